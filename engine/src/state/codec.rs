//! Values as bytes and back: the format of a run's state.
//!
//! Numbers are little-endian, floating-point numbers bit by bit, so that a run goes on from them with the same bytes. Values are
//! collected in sections, each with a name, its length and a checksum, behind a head with a version.

use std::borrow::Cow;
use std::collections::{BTreeMap, VecDeque};

use glam::{DQuat, DVec3};

use super::sections::Sections;
use crate::parallel::each_part_by;

/// The first bytes.
const MAGIC: &[u8; 8] = b"MERCSTAT";
/// Version of the layout of the head and the sections, and of their content. Any other version is refused.
pub const VERSION: u32 = 21;

/// Why bytes are not a valid state.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// The bytes do not begin like a state.
    #[error("this is not the state of a run: it begins with other bytes")]
    Foreign,
    /// There are no bytes.
    #[error("the file is empty: there is no state of a run in it")]
    Empty,
    /// The bytes are of another version of this program.
    #[error(
        "the state has the layout of version {found}, this program reads version {VERSION}\n\
         help: go on with the version of the program that wrote it"
    )]
    Version {
        /// The version in the head.
        found: u32,
    },
    /// The bytes end too early.
    #[error("the state is cut off in section `{section}`")]
    Cut {
        /// Where.
        section: String,
    },
    /// Bytes have changed since they were written.
    #[error(
        "section `{section}` is damaged: its checksum is {found:08x}, it should be {expected:08x}"
    )]
    Damaged {
        /// Where.
        section: String,
        /// Checksum of the bytes.
        found: u32,
        /// Checksum as written.
        expected: u32,
    },
    /// An impossible value, or sections in another order.
    #[error("section `{section}`: {reason}")]
    Wrong {
        /// Where.
        section: String,
        /// Description of the problem.
        reason: String,
    },
}

/// A value that can be written as bytes and read back, the same to the bit.
pub trait Plain: Sized + Sync {
    /// Appends the value.
    fn put(&self, bytes: &mut Vec<u8>);
    /// Appends the same bytes; what holds long columns does it with the threads of a pool.
    fn put_pieces(&self, pieces: &mut Pieces, _pool: Option<&rayon::ThreadPool>) {
        self.put(pieces.end());
    }
    /// Takes a value from the front.
    ///
    /// # Errors
    /// The bytes are too few, or are no value of this type.
    fn take(bytes: &mut &[u8]) -> Result<Self, String>;
    /// Takes this many values from the front.
    ///
    /// # Errors
    /// Errors of [`Plain::take`].
    fn take_many(count: usize, bytes: &mut &[u8]) -> Result<Vec<Self>, String> {
        // A damaged number reserves no more than the bytes that are there.
        let mut values = Vec::with_capacity(count.min(bytes.len() / size_of::<Self>().max(1)));
        for _ in 0..count {
            values.push(Self::take(bytes)?);
        }
        Ok(values)
    }
}

/// Takes the first `count` bytes off.
fn front<'a>(bytes: &mut &'a [u8], count: usize) -> Result<&'a [u8], String> {
    let (front, rest) = bytes
        .split_at_checked(count)
        .ok_or_else(|| format!("{count} bytes expected, {} left", bytes.len()))?;
    *bytes = rest;
    Ok(front)
}

/// Value that `take` makes of all of the bytes.
///
/// # Errors
/// Errors of `take`, and bytes that it leaves.
pub fn whole<T>(
    mut bytes: &[u8],
    take: impl FnOnce(&mut &[u8]) -> Result<T, String>,
) -> Result<T, String> {
    let value = take(&mut bytes)?;
    match bytes.len() {
        0 => Ok(value),
        left => Err(format!("{left} bytes too many")),
    }
}

/// Takes a number of entries that follow. No entry takes less than a byte: a damaged number allocates no memory.
///
/// # Errors
/// If there are not as many bytes.
pub fn announced(bytes: &mut &[u8]) -> Result<usize, String> {
    let (count, most) = (usize::take(bytes)?, bytes.len());
    if count > most {
        return Err(format!(
            "{count} entries announced, space for {most} at most"
        ));
    }
    Ok(count)
}

macro_rules! plain_number {
    ($($number:ty),*) => {$(
        impl Plain for $number {
            fn put(&self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }

            fn take(bytes: &mut &[u8]) -> Result<Self, String> {
                let mut raw = [0; size_of::<$number>()];
                raw.copy_from_slice(front(bytes, size_of::<$number>())?);
                Ok(<$number>::from_le_bytes(raw))
            }

            fn take_many(count: usize, bytes: &mut &[u8]) -> Result<Vec<Self>, String> {
                let raw = front(bytes, count.saturating_mul(size_of::<$number>()))?;
                let numbers = raw.as_chunks().0.iter();
                Ok(numbers.map(|raw| <$number>::from_le_bytes(*raw)).collect())
            }
        }
    )*};
}

plain_number!(u8, u16, u32, u64, f64);

impl Plain for usize {
    fn put(&self, bytes: &mut Vec<u8>) {
        (*self as u64).put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let number = u64::take(bytes)?;
        Self::try_from(number).map_err(|_| format!("{number} is too large for this machine"))
    }
}

impl Plain for bool {
    fn put(&self, bytes: &mut Vec<u8>) {
        bytes.push(u8::from(*self));
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        match u8::take(bytes)? {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(format!("{other} is not a truth value")),
        }
    }
}

impl<T: Plain> Plain for Option<T> {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.is_some().put(bytes);
        if let Some(value) = self {
            value.put(bytes);
        }
    }

    fn put_pieces(&self, pieces: &mut Pieces, pool: Option<&rayon::ThreadPool>) {
        self.is_some().put(pieces.end());
        if let Some(value) = self {
            value.put_pieces(pieces, pool);
        }
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        bool::take(bytes)?.then(|| T::take(bytes)).transpose()
    }
}

impl<T: Plain> Plain for Vec<T> {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.len().put(bytes);
        for value in self {
            value.put(bytes);
        }
    }

    fn put_pieces(&self, pieces: &mut Pieces, pool: Option<&rayon::ThreadPool>) {
        pieces.column(self, pool);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        T::take_many(announced(bytes)?, bytes)
    }
}

impl Plain for String {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.len().put(bytes);
        bytes.extend_from_slice(self.as_bytes());
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let count = usize::take(bytes)?;
        let text = front(bytes, count)?.to_vec();
        Self::from_utf8(text).map_err(|error| error.to_string())
    }
}

impl Plain for Cow<'static, str> {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.len().put(bytes);
        bytes.extend_from_slice(self.as_bytes());
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        String::take(bytes).map(Self::from)
    }
}

impl<T: Plain, const N: usize> Plain for [T; N] {
    fn put(&self, bytes: &mut Vec<u8>) {
        for value in self {
            value.put(bytes);
        }
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let values: Vec<T> = (0..N).map(|_| T::take(bytes)).collect::<Result<_, _>>()?;
        values
            .try_into()
            .map_err(|_| format!("{N} values expected"))
    }
}

impl<K: Plain + Ord, V: Plain> Plain for BTreeMap<K, V> {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.len().put(bytes);
        for (key, value) in self {
            key.put(bytes);
            value.put(bytes);
        }
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        Vec::<(K, V)>::take(bytes).map(Self::from_iter)
    }
}

impl<A: Plain, B: Plain> Plain for (A, B) {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.0.put(bytes);
        self.1.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        Ok((A::take(bytes)?, B::take(bytes)?))
    }
}

impl Plain for DVec3 {
    fn put(&self, bytes: &mut Vec<u8>) {
        // All at once: most of a state is vectors.
        let mut raw = [0; 3 * size_of::<f64>()];
        for (raw, number) in raw.chunks_exact_mut(8).zip(self.to_array()) {
            raw.copy_from_slice(&number.to_le_bytes());
        }
        bytes.extend_from_slice(&raw);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        // Likewise, without memory of the system for each vector.
        let mut raw = front(bytes, 3 * size_of::<f64>())?;
        let mut number = || f64::take(&mut raw);
        Ok(Self::new(number()?, number()?, number()?))
    }
}

impl Plain for DQuat {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.to_array().put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let mut raw = front(bytes, 4 * size_of::<f64>())?;
        let mut number = || f64::take(&mut raw);
        Ok(Self::from_xyzw(number()?, number()?, number()?, number()?))
    }
}

/// Makes a struct [`Plain`](crate::state::Plain): its fields in this order. All of them must be named, so none can be forgotten; those behind a
/// semicolon are not written and start at their defaults.
#[macro_export]
macro_rules! plain {
    ($name:ty { $($field:ident),* $(,)? $(; $($derived:ident),*)? }) => {
        impl $crate::state::Plain for $name {
            fn put(&self, bytes: &mut Vec<u8>) {
                $($crate::state::Plain::put(&self.$field, bytes);)*
            }

            fn put_pieces(
                &self,
                pieces: &mut $crate::state::Pieces,
                pool: Option<&$crate::state::ThreadPool>,
            ) {
                $($crate::state::Plain::put_pieces(&self.$field, pieces, pool);)*
            }

            fn take(bytes: &mut &[u8]) -> Result<Self, String> {
                Ok(Self {
                    $($field: $crate::state::Plain::take(bytes)?,)*
                    $($($derived: Default::default(),)*)?
                })
            }
        }
    };
}
/// A piece of the bytes of a state.
#[derive(Debug, Default)]
pub struct Piece {
    /// Bytes of the piece.
    pub bytes: Vec<u8>,
    /// Whether the piece is large, and its memory is worth keeping.
    is_large: bool,
}

/// Bytes in pieces, one after the other. Several threads fill pieces of their own, and nothing is copied to join them.
#[derive(Debug, Default)]
pub struct Pieces {
    filled: Vec<Piece>,
    /// Memory of pieces that were written, in their order.
    spare: VecDeque<Vec<u8>>,
}

/// Shorter columns are not worth a piece, bytes.
const PIECE: usize = 1 << 16;

impl Pieces {
    /// Memory for a piece: that of the piece at the same place of an earlier checkpoint, if there was one.
    #[must_use]
    pub fn memory(&mut self) -> Vec<u8> {
        self.spare.pop_front().unwrap_or_default()
    }

    /// All of them, one after the other.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        let pieces = self.filled.iter().map(|piece| &piece.bytes[..]);
        pieces.collect::<Vec<_>>().concat()
    }

    /// Appends a piece.
    pub fn push(&mut self, bytes: Vec<u8>) {
        let is_large = true;
        self.filled.push(Piece { bytes, is_large });
        // Later bytes must not make it grow.
        self.begin();
    }

    /// Begins a piece for small things.
    fn begin(&mut self) {
        self.filled.push(Piece::default());
    }

    /// Where small things are appended.
    pub fn end(&mut self) -> &mut Vec<u8> {
        if self.filled.is_empty() {
            self.begin();
        }
        let last = self.filled.len() - 1;
        &mut self.filled[last].bytes
    }

    /// Appends what [`Plain::put`] of a vector of these values would, with the threads of a pool.
    fn column<T: Plain>(&mut self, values: &[T], pool: Option<&rayon::ThreadPool>) {
        values.len().put(self.end());
        if size_of_val(values) < PIECE {
            values.iter().for_each(|value| value.put(self.end()));
            return;
        }
        let fill = |(piece, values): (&mut Vec<u8>, &[T])| {
            piece.clear();
            piece.reserve(size_of_val(values));
            values.iter().for_each(|value| value.put(piece));
        };
        let threads = pool.map_or(1, rayon::ThreadPool::current_num_threads);
        let share = values.len().div_ceil(threads);
        let mut pieces: Vec<_> = values.chunks(share).map(|_| self.memory()).collect();
        each_part_by(pool, pieces.iter_mut().zip(values.chunks(share)), fill);
        pieces.into_iter().for_each(|piece| self.push(piece));
    }
}

/// Collects sections.
#[derive(Debug)]
pub struct Encoder {
    pieces: Pieces,
    /// Where the length of each section goes: in which piece, and behind how many bytes. Lengths and checksums are added last,
    /// when no other work waits for them.
    sections: Vec<(usize, usize)>,
    /// Their names.
    names: Vec<String>,
}

/// Bytes of the length and the checksum of a section.
const LENGTH_AND_CHECKSUM: usize = 12;

impl Default for Encoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Encoder {
    /// A head and no section yet.
    #[must_use]
    pub fn new() -> Self {
        Self::reusing(Vec::new())
    }

    /// Encoder in the memory of an earlier state: the system takes longer to provide new memory for a million particles than it
    /// takes to fill it.
    #[must_use]
    pub fn reusing(spent: Vec<Piece>) -> Self {
        let spare = spent.into_iter().filter(|piece| piece.is_large);
        let mut pieces = Pieces {
            filled: Vec::new(),
            spare: spare.map(|piece| piece.bytes).collect(),
        };
        pieces.end().extend_from_slice(MAGIC);
        VERSION.put(pieces.end());
        Self {
            pieces,
            sections: Vec::new(),
            names: Vec::new(),
        }
    }

    /// Appends a section.
    pub fn section(&mut self, name: &str, value: &impl Plain) {
        self.section_by(name, |pieces| value.put(pieces.end()));
    }

    /// Appends a section whose content `put` appends.
    pub fn section_by(&mut self, name: &str, put: impl FnOnce(&mut Pieces)) {
        let end = self.pieces.end();
        name.to_owned().put(end);
        let at = end.len();
        end.extend_from_slice(&[0; LENGTH_AND_CHECKSUM]);
        self.sections.push((self.pieces.filled.len() - 1, at));
        self.names.push(name.to_owned());
        put(&mut self.pieces);
        // The next section begins in a piece of its own, so that this one ends with a piece.
        self.pieces.begin();
    }

    /// Its memory, for [`Encoder::reusing`]; its content is lost.
    #[must_use]
    pub fn into_memory(self) -> Vec<Piece> {
        self.pieces.filled
    }

    /// The first piece of each section but the first, and the end of all.
    fn ends(&self) -> Vec<usize> {
        let ends = self.sections.iter().skip(1).map(|(piece, _)| *piece);
        ends.chain([self.pieces.filled.len()]).collect()
    }

    /// Names of the sections, and their contents in pieces.
    pub fn contents(&self) -> impl Iterator<Item = (&str, Vec<&[u8]>)> {
        let pieces = &self.pieces.filled;
        let places = self.sections.iter().zip(self.ends());
        let names = self.names.iter();
        names.zip(places).map(|(name, (&(first, at), end))| {
            let begin = &pieces[first].bytes[at + LENGTH_AND_CHECKSUM..];
            let others = pieces[first + 1..end].iter().map(|piece| &piece.bytes[..]);
            (
                name.as_str(),
                std::iter::once(begin).chain(others).collect(),
            )
        })
    }

    /// The sections, as a decoder would find them.
    #[must_use]
    pub fn into_sections(self) -> Sections {
        let mut sections = Sections::default();
        for (name, content) in self.contents() {
            sections.push(name.to_owned(), content.into_iter());
        }
        sections
    }

    /// All of it, piece by piece.
    #[must_use]
    pub fn finish_in_pieces(mut self) -> Vec<Piece> {
        let ends = self.ends();
        let pieces = &mut self.pieces.filled;
        for ((first, at), end) in self.sections.into_iter().zip(ends) {
            let begin = at + LENGTH_AND_CHECKSUM;
            let mut checksum = crc32fast::Hasher::new();
            let mut length = 0;
            let others = pieces[first + 1..end].iter().map(|piece| &piece.bytes[..]);
            for bytes in std::iter::once(&pieces[first].bytes[begin..]).chain(others) {
                checksum.update(bytes);
                length += bytes.len();
            }
            let checksum = checksum.finalize().to_le_bytes();
            let head = &mut pieces[first].bytes[at..begin];
            head[..8].copy_from_slice(&(length as u64).to_le_bytes());
            head[8..].copy_from_slice(&checksum);
        }
        self.pieces.filled
    }

    /// All of it.
    #[must_use]
    pub fn finish(self) -> Vec<u8> {
        let pieces = self.finish_in_pieces();
        let bytes: Vec<&[u8]> = pieces.iter().map(|piece| &piece.bytes[..]).collect();
        bytes.concat()
    }
}

/// Reads sections in the order in which they were written.
#[derive(Debug)]
pub struct Decoder<'a> {
    rest: &'a [u8],
}

impl<'a> Decoder<'a> {
    /// Behind the head of these bytes.
    ///
    /// # Errors
    /// If they are no state, or one of another version.
    pub fn new(bytes: &'a [u8]) -> Result<Self, DecodeError> {
        let cut = || DecodeError::Cut {
            section: "head".to_owned(),
        };
        let mut rest = bytes.strip_prefix(MAGIC).ok_or_else(|| match bytes {
            [] => DecodeError::Empty,
            part if MAGIC.starts_with(part) => cut(),
            _ => DecodeError::Foreign,
        })?;
        let found = u32::take(&mut rest).map_err(|_| cut())?;
        if found != VERSION {
            return Err(DecodeError::Version { found });
        }
        Ok(Self { rest })
    }

    /// The value in the next section, which must have this name.
    ///
    /// # Errors
    /// If it is another one, cut, damaged, or holds no such value.
    pub fn section<T: Plain>(&mut self, name: &str) -> Result<T, DecodeError> {
        let wrong = |reason| DecodeError::Wrong {
            section: name.to_owned(),
            reason,
        };
        whole(self.content(name)?, T::take).map_err(wrong)
    }

    /// The name of the next section; `None` at the end.
    pub(super) fn next_name(&self) -> Option<String> {
        let mut ahead = self.rest;
        (!ahead.is_empty()).then(|| String::take(&mut ahead).unwrap_or_default())
    }

    /// The bytes of the next section, which must have this name and its checksum.
    pub(super) fn content(&mut self, name: &str) -> Result<&'a [u8], DecodeError> {
        let section = || name.to_owned();
        let cut = |_| DecodeError::Cut { section: section() };
        let found = String::take(&mut self.rest).map_err(cut)?;
        if found != name {
            return Err(DecodeError::Wrong {
                section: section(),
                reason: format!("expected `{name}`, found `{found}`"),
            });
        }
        let length = usize::take(&mut self.rest).map_err(cut)?;
        let expected = u32::take(&mut self.rest).map_err(cut)?;
        let bytes = front(&mut self.rest, length).map_err(cut)?;
        let found = crc32fast::hash(bytes);
        if found != expected {
            return Err(DecodeError::Damaged {
                section: section(),
                found,
                expected,
            });
        }
        Ok(bytes)
    }

    /// Nothing may follow.
    ///
    /// # Errors
    /// If something does.
    pub fn finish(self) -> Result<(), DecodeError> {
        if self.rest.is_empty() {
            return Ok(());
        }
        Err(DecodeError::Wrong {
            section: "end".to_owned(),
            reason: format!("{} bytes follow the last section", self.rest.len()),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    type Value = (Vec<(u32, Option<f64>)>, (String, [bool; 3]));

    fn encoded(value: &Value) -> Vec<u8> {
        let mut encoder = Encoder::new();
        encoder.section("first", value);
        encoder.section("second", &value.0);
        encoder.finish()
    }

    fn decoded(bytes: &[u8]) -> Result<Value, DecodeError> {
        let mut decoder = Decoder::new(bytes)?;
        let value = decoder.section("first")?;
        let _: Vec<(u32, Option<f64>)> = decoder.section("second")?;
        decoder.finish()?;
        Ok(value)
    }

    fn value() -> impl Strategy<Value = Value> {
        let entries =
            proptest::collection::vec((any::<u32>(), proptest::option::of(any::<u64>())), 0..20);
        (entries, (".*", any::<[bool; 3]>())).prop_map(|(entries, rest)| {
            // Any bits, numbers or not.
            let entries = entries
                .into_iter()
                .map(|(n, bits)| (n, bits.map(f64::from_bits)));
            (entries.collect(), rest)
        })
    }

    fn bits(value: &Value) -> Vec<Option<u64>> {
        let bits = |entry: &(u32, Option<f64>)| entry.1.map(f64::to_bits);
        value.0.iter().map(bits).collect()
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(value in value()) {
            let back = decoded(&encoded(&value)).unwrap();
            prop_assert_eq!(bits(&back), bits(&value));
            prop_assert_eq!(back.1, value.1);
        }

        #[test]
        fn columns_in_pieces_are_the_same_bytes(
            values in proptest::collection::vec(any::<u64>(), 0..3 * PIECE / 8),
            threads in 1usize..4,
        ) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let pool = (threads > 1).then_some(&pool);
            let mut expected = Encoder::new();
            expected.section("column", &(values.clone(), 7u8));
            expected.section("last", &8u8);
            let expected = expected.finish();
            let mut spent = Vec::new();
            // Anew, and in memory that holds other bytes.
            for _ in 0..2 {
                let mut encoder = Encoder::reusing(spent);
                encoder.section_by("column", |pieces| {
                    pieces.column(&values, pool);
                    7u8.put(pieces.end());
                });
                encoder.section("last", &8u8);
                spent = encoder.finish_in_pieces();
                let found: Vec<u8> = spent.iter().flat_map(|piece| piece.bytes.clone()).collect();
                prop_assert!(found == expected);
            }
        }

        #[test]
        fn any_change_of_a_bit_and_any_cut_is_an_error(value in value(), place: proptest::sample::Index, bit in 0u8..8) {
            let mut bytes = encoded(&value);
            let place = place.index(bytes.len());
            prop_assert!(decoded(&bytes[..place]).is_err());
            bytes[place] ^= 1 << bit;
            prop_assert!(decoded(&bytes).is_err());
        }

        #[test]
        fn bytes_that_no_encoder_wrote_are_an_error(noise in proptest::collection::vec(any::<u8>(), 0..200)) {
            prop_assert!(decoded(&noise).is_err());
            let mut behind_head = Encoder::new().finish();
            behind_head.extend(noise);
            prop_assert!(decoded(&behind_head).is_err());
        }
    }

    #[test]
    fn the_page_about_checkpoints_has_this_version() {
        let page = include_str!("../../../docs/formats/checkpoint.md");
        assert!(page.contains(&format!("| version of the layout | {VERSION} |")));
    }

    #[test]
    fn other_versions_and_other_files_are_named() {
        assert_eq!(decoded(b"PNG").unwrap_err(), DecodeError::Foreign);
        assert_eq!(decoded(b"").unwrap_err(), DecodeError::Empty);
        let cut = decoded(b"MERCS").unwrap_err();
        assert!(matches!(cut, DecodeError::Cut { .. }), "{cut}");
        let mut bytes = encoded(&(Vec::new(), (String::new(), [false; 3])));
        let found = VERSION + 1;
        bytes[8..12].copy_from_slice(&found.to_le_bytes());
        assert_eq!(decoded(&bytes).unwrap_err(), DecodeError::Version { found });
    }

    #[test]
    fn a_length_beyond_the_bytes_requests_no_memory() {
        let mut bytes: &[u8] = &u64::MAX.to_le_bytes();
        assert!(
            Vec::<f64>::take(&mut bytes)
                .unwrap_err()
                .contains("space for 0")
        );
    }
}
