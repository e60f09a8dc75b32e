//! Schema of a file of frames: named, typed columns with units, and facts about the run.

use std::collections::{BTreeMap, HashSet};

use arrow_schema::{DataType, Field, Schema};

use super::FRAMES_VERSION;

/// The column that the writer adds in front of all others: the time of the frame, in s, in every row.
pub(super) const TIME: &str = "time";
const UNIT: &str = "unit";
const DESCRIPTION: &str = "description";
pub(super) const VERSION_KEY: &str = "mercury_frames";
pub(super) const TITLE_KEY: &str = "title";
pub(super) const GRAVITY_KEY: &str = "gravity";
pub(super) const KIND_KEY: &str = "kind";

/// The type of the values of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// 64-bit float.
    F64,
    /// 32-bit signed integer.
    I32,
    /// 8-bit unsigned integer.
    U8,
    /// 32-bit unsigned integer.
    U32,
    /// 32-bit unsigned integer, may be missing (Arrow null).
    OptionalU32,
    /// 64-bit unsigned integer.
    U64,
    /// UTF-8 string.
    Text,
}

impl ColumnKind {
    fn data_type(self) -> DataType {
        match self {
            Self::F64 => DataType::Float64,
            Self::I32 => DataType::Int32,
            Self::U8 => DataType::UInt8,
            Self::U32 | Self::OptionalU32 => DataType::UInt32,
            Self::U64 => DataType::UInt64,
            Self::Text => DataType::Utf8,
        }
    }

    /// Other writers (pandas, polars) mark every column as nullable; only for `u32` does Mercury use that. `None`: frames do not have
    /// this type.
    fn of_field(field: &Field) -> Option<Self> {
        match field.data_type() {
            DataType::Float64 => Some(Self::F64),
            DataType::Int32 => Some(Self::I32),
            DataType::UInt8 => Some(Self::U8),
            DataType::UInt32 if field.is_nullable() => Some(Self::OptionalU32),
            DataType::UInt32 => Some(Self::U32),
            DataType::UInt64 => Some(Self::U64),
            DataType::Utf8 => Some(Self::Text),
            _ => None,
        }
    }

    /// Arrow buffers per column of this kind: validity and values, for text validity, offsets and bytes.
    pub(super) fn buffers(self) -> usize {
        if self == Self::Text { 3 } else { 2 }
    }
}

/// Name, type, unit and meaning of one column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnSpec {
    /// The name, unique in the file; `time` is taken.
    pub name: String,
    /// The type of the values.
    pub kind: ColumnKind,
    /// The SI unit (`m/s`, `N m`), `1` for numbers without one.
    pub unit: String,
    /// Meaning of the column, for readers of the file.
    pub description: Option<String>,
}

impl ColumnSpec {
    /// A column without a description.
    pub fn new(name: impl Into<String>, kind: ColumnKind, unit: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            kind,
            unit: unit.into(),
            description: None,
        }
    }

    /// Adds what the column is, for people.
    #[must_use]
    pub fn described(mut self, description: impl Into<String>) -> Self {
        self.description = Some(description.into());
        self
    }
}

/// Why columns cannot be a schema.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SchemaError {
    /// Two columns share a name.
    #[error("two columns are named `{0}`")]
    Duplicate(String),
    /// The name of the column that every file has anyway.
    #[error("a column may not be named `time`: every frame carries its time already")]
    Reserved,
    /// A column without a name.
    #[error("a column has no name")]
    Unnamed,
}

/// The columns of a file and its metadata. Fixed for the whole file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameSchema {
    columns: Vec<ColumnSpec>,
    metadata: BTreeMap<String, String>,
}

/// Columns of earlier versions, and what they are called now. In pandas a table has `flags` of its own.
const RENAMED: [(&str, &str); 1] = [("flags", "state")];

impl FrameSchema {
    /// A schema for frames of this kind (`particles`, `contacts`), without the column `time`, which the writer adds.
    ///
    /// # Errors
    /// [`SchemaError`] when a name is empty, occurs twice, or is `time`.
    pub fn new(kind: &str, columns: Vec<ColumnSpec>) -> Result<Self, SchemaError> {
        for (k, column) in columns.iter().enumerate() {
            if column.name.is_empty() {
                return Err(SchemaError::Unnamed);
            }
            if column.name == TIME {
                return Err(SchemaError::Reserved);
            }
            if columns[..k].iter().any(|c| c.name == column.name) {
                return Err(SchemaError::Duplicate(column.name.clone()));
            }
        }
        let metadata = BTreeMap::from([
            (VERSION_KEY.to_owned(), FRAMES_VERSION.to_owned()),
            (KIND_KEY.to_owned(), kind.to_owned()),
        ]);
        Ok(Self { columns, metadata })
    }

    /// Adds facts about the run (title, material names, ...); a key that is there already is replaced.
    #[must_use]
    pub fn with_metadata(mut self, entries: impl IntoIterator<Item = (String, String)>) -> Self {
        self.metadata.extend(entries);
        self
    }

    /// Whether columns and metadata are the same, but for the title of the run and gravity, which a branch of a run may change.
    pub(super) fn is_alike(&self, other: &Self) -> bool {
        let facts = |schema: &Self| {
            let mut facts = schema.metadata.clone();
            facts.remove(TITLE_KEY);
            facts.remove(GRAVITY_KEY);
            facts
        };
        self.columns == other.columns && facts(self) == facts(other)
    }

    /// The columns in their order, without `time`.
    pub fn columns(&self) -> &[ColumnSpec] {
        &self.columns
    }

    /// All metadata of the schema, sorted by key.
    pub fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    /// Content of the frames (`particles`, `contacts`); empty for files of other programs.
    pub fn kind(&self) -> &str {
        self.metadata.get(KIND_KEY).map_or("", String::as_str)
    }

    /// The place of a column in [`columns`](Self::columns) and in [`Frame::columns`](super::Frame::columns).
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.name == name)
    }

    /// The Arrow schema of the file: `time` first.
    pub(super) fn to_arrow(&self) -> Schema {
        let time = ColumnSpec::new(TIME, ColumnKind::F64, "s").described("time of the frame");
        let fields = std::iter::once(&time).chain(&self.columns).map(|column| {
            let mut facts = BTreeMap::from([(UNIT.to_owned(), column.unit.clone())]);
            let described = column.description.iter();
            facts.extend(described.map(|text| (DESCRIPTION.to_owned(), text.clone())));
            let nullable = column.kind == ColumnKind::OptionalU32;
            Field::new(&column.name, column.kind.data_type(), nullable).with_metadata(facts)
        });
        Schema::new_with_metadata(fields.collect::<Vec<_>>(), self.metadata.clone())
    }

    /// Reads an Arrow schema back: the schema, the kinds of all fields in file order, and which of them is `time`.
    /// The error is what was found and what was expected.
    pub(super) fn of_arrow(schema: &Schema) -> Result<(Self, Vec<ColumnKind>, usize), [String; 2]> {
        let mut columns = Vec::new();
        let mut kinds = Vec::new();
        let mut time = None;
        let mut names = HashSet::new();
        for (k, field) in schema.fields().iter().enumerate() {
            let renamed = RENAMED.iter().find(|(before, _)| before == field.name());
            let name = renamed.map_or(field.name().as_str(), |(_, now)| now);
            let kind = ColumnKind::of_field(field).ok_or_else(|| {
                [
                    format!(
                        "column `{name}` of type {}",
                        field.data_type().to_string().to_lowercase()
                    ),
                    "float64, int32, uint8, uint32, uint64 or utf8".to_owned(),
                ]
            })?;
            kinds.push(kind);
            if name == TIME {
                if time.is_some() {
                    return Err(["two columns `time`".to_owned(), "one".to_owned()]);
                }
                if kind != ColumnKind::F64 {
                    let found = "column `time` of another type than float64".to_owned();
                    return Err([found, "float64, in s".to_owned()]);
                }
                time = Some(k);
                continue;
            }
            // Before anything is made of the field: offsets may lead to the same one over and over.
            if !names.insert(name) {
                let found = format!("two columns `{name}`");
                return Err([found, "different names".to_owned()]);
            }
            let fact = |key| field.metadata().get(key).cloned();
            columns.push(ColumnSpec {
                name: name.to_owned(),
                kind,
                unit: fact(UNIT).unwrap_or_default(),
                description: fact(DESCRIPTION),
            });
        }
        let time = time.ok_or_else(|| {
            let found = "no column `time`".to_owned();
            [found, "the time of the frame, float64, in s".to_owned()]
        })?;
        let metadata = schema.metadata().clone().into();
        Ok((Self { columns, metadata }, kinds, time))
    }
}
