//! Readers and writers of `.data`, `.fstat`, `.ene`, particle tables and surface meshes.
//!
//! Every reader reports a problem as a [`FormatError`] with path, line and
//! column. Every writer appends to a `Vec<u8>`, so that the caller can hand a whole frame to the
//! operating system in one call, and takes a [`NumberStyle`](number::NumberStyle): the shortest text
//! that reads back exactly, or a fixed number of significant digits like MercuryDPM.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the reading, so its size (128 bytes) does not matter"
)]

pub mod clump;
pub mod data;
pub mod delimited;
pub mod ene;
pub mod fstat;
pub mod lines;
pub mod mesh;
pub mod number;
pub mod orientation;
pub(crate) mod other_kinds;
pub mod particle_csv;
pub mod pebble_list;
pub mod table_head;
pub mod time_table;
pub mod vtu;

use std::fs::File;
use std::path::Path;

use crate::error::FormatError;

/// Opens a file for reading, with a message a user can act on.
pub(crate) fn open(path: &Path) -> Result<File, FormatError> {
    File::open(path)
        .map_err(|error| FormatError::of_file(path, format!("the file cannot be opened: {error}")))
}

/// Reads a whole file, which is not one of [another kind](other_kinds).
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, FormatError> {
    let failed = |error| FormatError::of_file(path, format!("the file cannot be read: {error}"));
    let bytes = std::fs::read(path).map_err(failed)?;
    other_kinds::refuse(path, &bytes)?;
    Ok(bytes)
}

/// Writes a whole file.
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), FormatError> {
    std::fs::write(path, bytes)
        .map_err(|error| FormatError::of_file(path, format!("the file cannot be written: {error}")))
}

/// Helpers that several tests use.
#[cfg(test)]
pub(crate) mod test_support {
    use glam::DVec3;
    use proptest::prelude::*;

    /// Compares two texts token by token as numbers; returns how many tokens differ as text.
    pub(crate) fn assert_same_numbers(found: &str, expected: &str, what: &str) -> usize {
        let found: Vec<_> = found.split_ascii_whitespace().collect();
        let expected: Vec<_> = expected.split_ascii_whitespace().collect();
        assert_eq!(found.len(), expected.len(), "{what}: number of tokens");
        let mut different = 0;
        for (index, (a, b)) in found.iter().zip(&expected).enumerate() {
            if a != b {
                different += 1;
                assert_eq!(
                    a.parse::<f64>().ok(),
                    b.parse::<f64>().ok(),
                    "{what}: token {index}"
                );
            }
        }
        different
    }

    /// Any number but NaN, often an awkward one.
    pub(crate) fn any_number() -> impl Strategy<Value = f64> {
        prop_oneof![
            any::<u64>()
                .prop_map(f64::from_bits)
                .prop_filter("not nan", |value| !value.is_nan()),
            Just(-0.0),
            Just(0.0),
            Just(5e-324),
            Just(f64::MAX),
            -10.0..10.0,
        ]
    }

    pub(crate) fn any_vector() -> impl Strategy<Value = DVec3> {
        [any_number(), any_number(), any_number()].prop_map(DVec3::from_array)
    }
}
