//! Types in which a column can be read.

use mercury_common::formats::number::parse_number;

use crate::column::{Kind, Values};

/// A value of a column, or what a text file has in its place.
#[derive(Debug, Clone, Copy)]
pub enum Cell<'a> {
    /// A floating-point number.
    Number(f64),
    /// A whole number.
    Whole(i128),
    /// True or false.
    Truth(bool),
    /// Text that is meant as text.
    Text(&'a str),
    /// The cells of a text file, to be converted to the requested type.
    Written(&'a str),
    /// Nothing.
    Missing,
}

impl Values {
    /// The value of a row, which must exist.
    pub(crate) fn cell(&self, row: usize) -> Cell<'_> {
        match self {
            Self::F64(v) => Cell::Number(v[row]),
            Self::I32(v) => Cell::Whole(v[row].into()),
            Self::I64(v) => Cell::Whole(v[row].into()),
            Self::U8(v) => Cell::Whole(v[row].into()),
            Self::U32(v) => Cell::Whole(v[row].into()),
            Self::OptionalU32(v) => v[row].map_or(Cell::Missing, |value| Cell::Whole(value.into())),
            Self::U64(v) => Cell::Whole(v[row].into()),
            Self::Bool(v) => Cell::Truth(v[row]),
            Self::Text(v) => Cell::Text(&v[row]),
        }
    }
}

/// Type of the values that [`Table::values`](crate::Table::values) gives: `f64`, `i32`, `i64`, `u8`, `u32`, `u64`, `Option<u32>`,
/// `bool`, `String`. Nothing is rounded or cut: a whole number becomes an `f64` only if it is exactly that, and fits into the
/// type or is refused.
pub trait Element: Sized + sealed::Sealed {
    /// Expected value, for messages: `a number`.
    const EXPECTED: &'static str;
    /// Columns of which types may hold it.
    const KINDS: &'static [Kind];
    /// The value, if it is one.
    fn of(cell: Cell<'_>) -> Option<Self>;
}

mod sealed {
    pub trait Sealed {}
}

const WHOLE: &[Kind] = &[
    Kind::I32,
    Kind::I64,
    Kind::U8,
    Kind::U32,
    Kind::OptionalU32,
    Kind::U64,
];

impl sealed::Sealed for f64 {}

impl Element for f64 {
    const EXPECTED: &'static str = "a number";
    const KINDS: &'static [Kind] = &[
        Kind::F64,
        Kind::I32,
        Kind::I64,
        Kind::U8,
        Kind::U32,
        Kind::OptionalU32,
        Kind::U64,
    ];

    fn of(cell: Cell<'_>) -> Option<Self> {
        match cell {
            Cell::Number(value) => Some(value),
            Cell::Whole(value) => Some(value as Self).filter(|number| *number as i128 == value),
            Cell::Written(text) => parse_number(text),
            _ => None,
        }
    }
}

macro_rules! whole {
    ($($type:ty: $expected:expr),*) => {$(
        impl sealed::Sealed for $type {}

        impl Element for $type {
            const EXPECTED: &'static str = $expected;
            const KINDS: &'static [Kind] = WHOLE;

            fn of(cell: Cell<'_>) -> Option<Self> {
                match cell {
                    Cell::Whole(value) => value.try_into().ok(),
                    Cell::Written(text) => text.parse().ok(),
                    _ => None,
                }
            }
        }
    )*};
}

whole!(
    i32: "a whole number of 32 bits",
    i64: "a whole number of 64 bits",
    u8: "a whole number from 0 to 255",
    u32: "a whole number from 0 to 4294967295",
    u64: "a whole number from 0 to 18446744073709551615"
);

impl sealed::Sealed for Option<u32> {}

impl Element for Option<u32> {
    const EXPECTED: &'static str = "a whole number from 0 to 4294967295, or nothing";
    const KINDS: &'static [Kind] = WHOLE;

    fn of(cell: Cell<'_>) -> Option<Self> {
        match cell {
            Cell::Missing | Cell::Written("") => Some(None),
            other => u32::of(other).map(Some),
        }
    }
}

impl sealed::Sealed for bool {}

impl Element for bool {
    const EXPECTED: &'static str = "true or false";
    const KINDS: &'static [Kind] = &[Kind::Bool];

    fn of(cell: Cell<'_>) -> Option<Self> {
        match cell {
            Cell::Truth(value) => Some(value),
            Cell::Written(text) => text.parse().ok(),
            _ => None,
        }
    }
}

impl sealed::Sealed for String {}

impl Element for String {
    const EXPECTED: &'static str = "text";
    const KINDS: &'static [Kind] = &[Kind::Text];

    fn of(cell: Cell<'_>) -> Option<Self> {
        match cell {
            Cell::Text(text) | Cell::Written(text) => Some(text.to_owned()),
            _ => None,
        }
    }
}
