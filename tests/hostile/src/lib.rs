//! Hostile input: every reader of Mercury gets malformed and adversarial files.
//!
//! [`readers::all`] lists the readers, each with valid samples, the bound on what it may allocate, and one function that reads bytes.
//! The tests of this crate and the targets of cargo-fuzz (`fuzz/`) call the same functions. How to use it: `docs/how-to/fuzz.md`.

pub mod checks;
pub mod mutate;
pub mod place;
pub mod readers;

use mutate::Random;
use place::Place;
use readers::Reader;

/// Cases of some hundred kilobytes come once in so many.
const GROWN: usize = 50;

/// The file of a case: the same for the same reader, seed and number, on every machine. The first are the samples as they are.
#[must_use]
pub fn case(reader: &Reader, samples: &[Vec<u8>], seed: u64, number: u64, grown: usize) -> Vec<u8> {
    if let Some(sample) = samples.get(number as usize) {
        return sample.clone();
    }
    let name = reader.name.bytes();
    let name = name.fold(seed, |sum, byte| {
        sum.wrapping_mul(31).wrapping_add(byte.into())
    });
    let mut random = Random::new(name ^ number.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let random = &mut random;
    let kind = random.below(GROWN * 2);
    let plain = match kind {
        0 | 1 => mutate::grown(random, samples, reader.make, grown),
        2..=5 => mutate::arbitrary(random),
        _ => match reader.own {
            Some(own) if !random.one_in(4) => return own(random, samples),
            _ => mutate::mutated(random, samples, reader.make),
        },
    };
    match reader.wrap {
        Some(wrap) => wrap(random, plain),
        None => plain,
    }
}

/// Reads bytes as a reader does, for targets of cargo-fuzz: panics on whatever [`checks`] find.
///
/// # Panics
/// If there is no reader of that name, or a fault was found.
pub fn fuzz(name: &str, bytes: &[u8]) {
    use std::cell::RefCell;
    thread_local! {
        static PLACE: RefCell<Option<(&'static Reader, Place)>> = const { RefCell::new(None) };
    }
    PLACE.with_borrow_mut(|known| {
        let (reader, place) = known.get_or_insert_with(|| {
            let reader = readers::all().iter().find(|reader| reader.name == name);
            let place = Place::new().expect("a temporary folder");
            let reader = reader.unwrap_or_else(|| panic!("no reader {name}"));
            // They prepare what lies beside the file.
            (reader.samples)(&place);
            (reader, place)
        });
        (reader.read)(bytes, place);
    });
}
