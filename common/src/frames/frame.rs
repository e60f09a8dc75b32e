//! One frame in memory: a time, a step, and typed columns of equal length.

use super::schema::ColumnKind;

/// The values of one column.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Quantities, in the unit that the schema names.
    F64(Vec<f64>),
    /// Signed integers.
    I32(Vec<i32>),
    /// Small numbers and bit flags.
    U8(Vec<u8>),
    /// Ids and indices.
    U32(Vec<u32>),
    /// Ids and indices that some rows do not have.
    OptionalU32(Vec<Option<u32>>),
    /// Counts.
    U64(Vec<u64>),
    /// Words.
    Text(Vec<String>),
}

impl Column {
    /// The number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::I32(v) => v.len(),
            Self::U8(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::OptionalU32(v) => v.len(),
            Self::U64(v) => v.len(),
            Self::Text(v) => v.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The kind that a [`ColumnSpec`](super::ColumnSpec) of this column has.
    pub fn kind(&self) -> ColumnKind {
        match self {
            Self::F64(_) => ColumnKind::F64,
            Self::I32(_) => ColumnKind::I32,
            Self::U8(_) => ColumnKind::U8,
            Self::U32(_) => ColumnKind::U32,
            Self::OptionalU32(_) => ColumnKind::OptionalU32,
            Self::U64(_) => ColumnKind::U64,
            Self::Text(_) => ColumnKind::Text,
        }
    }

    /// The values of an [`F64`](Self::F64) column.
    pub fn as_f64(&self) -> Option<&[f64]> {
        match self {
            Self::F64(v) => Some(v),
            _ => None,
        }
    }

    /// The values of a [`U32`](Self::U32) column.
    pub fn as_u32(&self) -> Option<&[u32]> {
        match self {
            Self::U32(v) => Some(v),
            _ => None,
        }
    }
}

/// The state at one instant, columns in the order of the schema.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Time, in s. Kept even when the frame has no rows.
    pub time: f64,
    /// Number of time steps made; in a file without it, the number of the frame.
    pub step: u64,
    /// One column per entry of [`FrameSchema::columns`](super::FrameSchema::columns).
    pub columns: Vec<Column>,
}

impl Frame {
    /// The number of rows (particles, contacts); 0 for a frame without columns.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Column::len)
    }
}
