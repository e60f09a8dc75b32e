//! Arrays of every type that a `.vtu` file can hold, as bytes on demand.

use std::borrow::Cow;
use std::ops::Range;

use glam::{DQuat, DVec3};

use super::VtuPrecision;

/// The values of an array, borrowed or owned.
#[derive(Debug, Clone)]
pub enum VtuValues<'a> {
    /// Numbers.
    F64(Cow<'a, [f64]>),
    /// Vectors.
    Vectors(Cow<'a, [DVec3]>),
    /// Unit quaternions, stored as w, x, y, z.
    Quaternions(Cow<'a, [DQuat]>),
    /// Flags and small codes.
    U8(Cow<'a, [u8]>),
    /// Signed integers.
    I32(Cow<'a, [i32]>),
    /// Indices.
    U32(Cow<'a, [u32]>),
    /// Ids, with -1 for none.
    I64(Cow<'a, [i64]>),
    /// Counts.
    U64(Cow<'a, [u64]>),
    /// `start + k step`, made while writing.
    Sequence {
        /// The first value.
        start: i32,
        /// From one value to the next.
        step: i32,
        /// Number of values.
        length: usize,
    },
    /// A small number that is equal everywhere, made while writing.
    Constant {
        /// The number.
        value: u8,
        /// Number of values.
        length: usize,
    },
}

macro_rules! from_lists {
    ($($variant:ident: $type:ty),*) => {$(
        impl<'a> From<&'a [$type]> for VtuValues<'a> {
            fn from(values: &'a [$type]) -> Self {
                Self::$variant(Cow::Borrowed(values))
            }
        }
        impl<'a> From<&'a Vec<$type>> for VtuValues<'a> {
            fn from(values: &'a Vec<$type>) -> Self {
                Self::$variant(Cow::Borrowed(values))
            }
        }
        impl From<Vec<$type>> for VtuValues<'_> {
            fn from(values: Vec<$type>) -> Self {
                Self::$variant(Cow::Owned(values))
            }
        }
    )*};
}
from_lists!(F64: f64, Vectors: DVec3, Quaternions: DQuat, U8: u8, I32: i32, U32: u32, I64: i64, U64: u64);

impl VtuValues<'_> {
    /// The number of entries (a vector is one).
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::Vectors(v) => v.len(),
            Self::Quaternions(v) => v.len(),
            Self::U8(v) => v.len(),
            Self::I32(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::I64(v) => v.len(),
            Self::U64(v) => v.len(),
            Self::Sequence { length, .. } | Self::Constant { length, .. } => *length,
        }
    }

    /// Whether there are no entries.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Numbers per entry.
    #[must_use]
    pub fn components(&self) -> usize {
        match self {
            Self::Vectors(_) => 3,
            Self::Quaternions(_) => 4,
            _ => 1,
        }
    }

    /// VTK's name of the type of the numbers.
    pub(super) fn type_name(&self, precision: VtuPrecision) -> &'static str {
        match self {
            Self::F64(_) | Self::Vectors(_) | Self::Quaternions(_) => match precision {
                VtuPrecision::Double => "Float64",
                VtuPrecision::Single => "Float32",
            },
            Self::U8(_) | Self::Constant { .. } => "UInt8",
            Self::I32(_) | Self::Sequence { .. } => "Int32",
            Self::U32(_) => "UInt32",
            Self::I64(_) => "Int64",
            Self::U64(_) => "UInt64",
        }
    }

    /// Bytes of one entry.
    pub(super) fn entry_bytes(&self, precision: VtuPrecision) -> usize {
        let number = match self.type_name(precision) {
            "UInt8" => 1,
            "Float64" | "Int64" | "UInt64" => 8,
            _ => 4,
        };
        number * self.components()
    }

    /// Replaces `out` by the little-endian bytes of some entries.
    pub(super) fn bytes(&self, precision: VtuPrecision, entries: Range<usize>, out: &mut Vec<u8>) {
        let double = precision == VtuPrecision::Double;
        match self {
            Self::F64(v) if double => put(&v[entries], out, |x| x.to_le_bytes()),
            Self::F64(v) => put(&v[entries], out, |x| (x as f32).to_le_bytes()),
            Self::Vectors(v) if double => put(&v[entries], out, |x| {
                join::<3, 8, 24>(x.to_array().map(f64::to_le_bytes))
            }),
            Self::Vectors(v) => put(&v[entries], out, |x| {
                join::<3, 4, 12>(x.to_array().map(|x| (x as f32).to_le_bytes()))
            }),
            Self::Quaternions(v) if double => put(&v[entries], out, |q| {
                join::<4, 8, 32>([q.w, q.x, q.y, q.z].map(f64::to_le_bytes))
            }),
            Self::Quaternions(v) => put(&v[entries], out, |q| {
                join::<4, 4, 16>([q.w, q.x, q.y, q.z].map(|x| (x as f32).to_le_bytes()))
            }),
            Self::U8(v) => put(&v[entries], out, |x| [x]),
            Self::I32(v) => put(&v[entries], out, i32::to_le_bytes),
            Self::U32(v) => put(&v[entries], out, u32::to_le_bytes),
            Self::I64(v) => put(&v[entries], out, i64::to_le_bytes),
            Self::U64(v) => put(&v[entries], out, u64::to_le_bytes),
            Self::Sequence { start, step, .. } => {
                out.clear();
                for k in entries {
                    let value = start.wrapping_add(step.wrapping_mul(k as i32));
                    out.extend_from_slice(&value.to_le_bytes());
                }
            }
            Self::Constant { value, .. } => {
                out.clear();
                out.resize(entries.len(), *value);
            }
        }
    }
}

/// Fixed strides, so that the loop becomes a copy.
fn put<T: Copy, const BYTES: usize>(
    values: &[T],
    out: &mut Vec<u8>,
    bytes: impl Fn(T) -> [u8; BYTES],
) {
    out.resize(values.len() * BYTES, 0);
    let (places, _) = out.as_chunks_mut::<BYTES>();
    for (place, &value) in places.iter_mut().zip(values) {
        *place = bytes(value);
    }
}

/// The bytes of the numbers of an entry in a row.
fn join<const N: usize, const B: usize, const ALL: usize>(parts: [[u8; B]; N]) -> [u8; ALL] {
    let mut all = [0; ALL];
    for (place, part) in all.as_chunks_mut::<B>().0.iter_mut().zip(parts) {
        *place = part;
    }
    all
}
