//! A named column and its values.

/// The type of a column's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Floating point, 64 bits.
    F64,
    /// Signed, 32 bits.
    I32,
    /// Signed, 64 bits.
    I64,
    /// Unsigned, 8 bits.
    U8,
    /// Unsigned, 32 bits.
    U32,
    /// Unsigned, 32 bits; values may be missing.
    OptionalU32,
    /// Unsigned, 64 bits.
    U64,
    /// True or false.
    Bool,
    /// Text.
    Text,
}

impl Kind {
    /// Noun for the values of a column of this type, for messages.
    #[must_use]
    pub fn plural(self) -> &'static str {
        match self {
            Self::F64 => "numbers",
            Self::I32 | Self::I64 | Self::U8 | Self::U32 | Self::OptionalU32 | Self::U64 => {
                "whole numbers"
            }
            Self::Bool => "truth values",
            Self::Text => "text",
        }
    }
}

/// Name, unit and type of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spec {
    /// Unique in its table.
    pub name: String,
    /// The unit, `1` for pure numbers; empty when nothing is known of it.
    pub unit: String,
    /// The type.
    pub kind: Kind,
}

impl Spec {
    /// A column of this name, unit (`1` for pure numbers) and type.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, kind: Kind) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            kind,
        }
    }
}

/// The values of a column, all of one type.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Floating point, 64 bits.
    F64(Vec<f64>),
    /// Signed, 32 bits.
    I32(Vec<i32>),
    /// Signed, 64 bits.
    I64(Vec<i64>),
    /// Unsigned, 8 bits.
    U8(Vec<u8>),
    /// Unsigned, 32 bits.
    U32(Vec<u32>),
    /// Unsigned, 32 bits; values may be missing.
    OptionalU32(Vec<Option<u32>>),
    /// Unsigned, 64 bits.
    U64(Vec<u64>),
    /// True or false.
    Bool(Vec<bool>),
    /// Text.
    Text(Vec<String>),
}

impl Values {
    /// The type.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::F64(_) => Kind::F64,
            Self::I32(_) => Kind::I32,
            Self::I64(_) => Kind::I64,
            Self::U8(_) => Kind::U8,
            Self::U32(_) => Kind::U32,
            Self::OptionalU32(_) => Kind::OptionalU32,
            Self::U64(_) => Kind::U64,
            Self::Bool(_) => Kind::Bool,
            Self::Text(_) => Kind::Text,
        }
    }

    /// Number of values, missing ones included.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::I32(v) => v.len(),
            Self::I64(v) => v.len(),
            Self::U8(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::OptionalU32(v) => v.len(),
            Self::U64(v) => v.len(),
            Self::Bool(v) => v.len(),
            Self::Text(v) => v.len(),
        }
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Unique in its table.
    pub name: String,
    /// The unit, `1` for pure numbers; empty when nothing is known of it.
    pub unit: String,
    /// Values of its rows.
    pub values: Values,
}

impl Column {
    /// A column of this name, unit (`1` for pure numbers) and these values.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, values: Values) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            values,
        }
    }

    /// Its name, unit and type.
    #[must_use]
    pub fn spec(&self) -> Spec {
        Spec::new(&self.name, &self.unit, self.values.kind())
    }
}
