#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| mercury_hostile::fuzz("export-bonds", bytes));
