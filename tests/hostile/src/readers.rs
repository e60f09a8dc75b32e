//! The readers: what is read, from which samples, in which bounds.

mod export;
mod fields;
mod formats;
mod frames;
mod runs;
mod scenes;
mod sizes;
mod tables;

use std::sync::OnceLock;

use crate::checks::Bound;
use crate::mutate::{Make, Random};
use crate::place::Place;

/// Makes the file of a case from the samples in a way of its own: for formats that mutations of bytes hardly get into.
pub type Own = fn(&mut Random, &[Vec<u8>]) -> Vec<u8>;

/// Last change of a mutated file.
pub type Wrap = fn(&mut Random, Vec<u8>) -> Vec<u8>;

/// A reader.
#[derive(Debug, Clone, Copy)]
pub struct Reader {
    /// Name in `tests/corpus/NAME` and in the targets of cargo-fuzz.
    pub name: &'static str,
    /// Make of its files.
    pub make: Make,
    /// Valid files. It also writes into the folder what lies beside them.
    pub samples: fn(&Place) -> Vec<Vec<u8>>,
    /// Reads a file in all the ways that programs do, and drops what it read. It panics where something is wrong.
    pub read: fn(&[u8], &Place),
    /// Memory that it may allocate for a file of that [`size`](Self::size).
    pub bound: Bound,
    /// Why so much.
    pub because: &'static str,
    /// Size of a file in bytes: its own, unless it is compressed.
    pub size: fn(&[u8]) -> u64,
    /// Last change of a mutated file: compression, for example.
    pub wrap: Option<Wrap>,
    /// Mutations by the format.
    pub own: Option<Own>,
}

const fn length(bytes: &[u8]) -> u64 {
    bytes.len() as u64
}

impl Reader {
    const fn new(
        name: &'static str,
        make: Make,
        samples: fn(&Place) -> Vec<Vec<u8>>,
        read: fn(&[u8], &Place),
    ) -> Self {
        Self {
            name,
            make,
            samples,
            read,
            bound: Bound {
                base: 0,
                per_byte: 0,
            },
            because: "",
            size: length,
            wrap: None,
            own: None,
        }
    }

    const fn bound(mut self, base: u64, per_byte: u64, because: &'static str) -> Self {
        self.bound = Bound { base, per_byte };
        self.because = because;
        self
    }

    const fn sized(mut self, size: fn(&[u8]) -> u64) -> Self {
        self.size = size;
        self
    }

    const fn wrapped(mut self, wrap: Wrap) -> Self {
        self.wrap = Some(wrap);
        self
    }

    const fn own(mut self, own: Own) -> Self {
        self.own = Some(own);
        self
    }
}

/// All readers.
pub fn all() -> &'static [Reader] {
    static ALL: OnceLock<Vec<Reader>> = OnceLock::new();
    ALL.get_or_init(|| {
        [
            scenes::READERS,
            formats::READERS,
            frames::READERS,
            runs::READERS,
            sizes::READERS,
            tables::READERS,
            fields::READERS,
            export::READERS,
        ]
        .concat()
    })
}

const KB: u64 = 1 << 10;
const MB: u64 = 1 << 20;
