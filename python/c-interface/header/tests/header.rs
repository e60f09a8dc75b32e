//! The header is that of the sources.

use std::path::Path;

/// `MERCURY_BLESS=1` writes it anew.
#[test]
fn the_header_is_current() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let bindings = cbindgen::Builder::new()
        .with_config(config)
        .with_src(folder.join("src/lib.rs"))
        .generate()
        .unwrap();
    let mut made = Vec::new();
    bindings.write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = folder.join("mercury.h");
    if std::env::var_os("MERCURY_BLESS").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(
        kept, made,
        "MERCURY_BLESS=1 cargo test -p c-header in python/ writes it anew"
    );
    // Sections on safety are for Rust.
    assert!(made.contains("mercury_t *mercury_open("));
}
