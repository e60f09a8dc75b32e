//! A table in memory.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use mercury_common::error::FormatError;

use crate::column::{Column, Spec, Values};
use crate::element::{Cell, Element};
use crate::parquet::{self, ParquetWriter, WriteError};
use crate::text;

/// Named columns of equal length, and words about the whole.
#[derive(Debug, Clone, Default)]
pub struct Table {
    pub(crate) columns: Vec<Column>,
    /// Further entries of the file's metadata: key and value. Units are not among them.
    pub metadata: Vec<(String, String)>,
    pub(crate) origin: Origin,
}

/// Where a table was read, for messages.
#[derive(Debug, Clone, Default)]
pub(crate) struct Origin {
    pub(crate) path: PathBuf,
    /// The line of each row, where the file is text.
    pub(crate) lines: Option<Vec<usize>>,
    /// Columns that this crate has no type for, and what they are.
    pub(crate) left_out: Vec<(String, String)>,
}

impl Table {
    /// The table with one more column.
    #[must_use]
    pub fn with(mut self, column: Column) -> Self {
        self.columns.push(column);
        self
    }

    /// Reads a file of either format: Parquet if it begins like one, else [delimited text](Self::read_text).
    ///
    /// # Errors
    /// As [`read_parquet`](Self::read_parquet) and [`read_text`](Self::read_text).
    pub fn read(path: &Path) -> Result<Self, FormatError> {
        let mut magic = Vec::new();
        let opened = File::open(path).and_then(|file| file.take(4).read_to_end(&mut magic));
        opened.map_err(|error| unreadable(path, &error))?;
        if magic == parquet::MAGIC {
            Self::read_parquet(path)
        } else {
            Self::read_text(path)
        }
    }

    /// Reads a Parquet file. A number that is missing is NaN, as other programs write NaN as missing. Columns of types that are
    /// neither numbers nor truth values nor text are left out; reading such a column gives an error with the reason.
    ///
    /// # Errors
    /// When it cannot be opened, is no Parquet file, is cut or damaged.
    pub fn read_parquet(path: &Path) -> Result<Self, FormatError> {
        parquet::read(path)
    }

    /// Reads delimited text. The first line that is neither blank nor begins with `#` names the columns, which commas, semicolons
    /// or tabs separate (tabs if the line has one, else semicolons if it has one); `radius [m]` names a unit, too. Every further
    /// line is a row. A field may stand in quotes, a quote inside doubled; blanks around a field do not count. Which type a
    /// column has is settled when it is [read](Self::values).
    ///
    /// # Errors
    /// When it cannot be opened, is not text, has no header, two columns of the same name, or a row with more or fewer fields.
    pub fn read_text(path: &Path) -> Result<Self, FormatError> {
        text::read(path)
    }

    /// The columns, in their order. Those of a text file are text.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The column with this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The values of a column as a type: `f64` takes every number, whole or not, whole types what fits, `Option<u32>` has
    /// missing values. A column of a text file is converted to the requested type.
    ///
    /// # Errors
    /// When there is no such column, or a value is not of that type; the message names file, column and row (or line).
    pub fn values<T: Element>(&self, name: &str) -> Result<Vec<T>, FormatError> {
        let path = &self.origin.path;
        let Some(column) = self.column(name) else {
            return Err(self.missing(name));
        };
        let kind = column.values.kind();
        let written = self.origin.lines.as_ref();
        if written.is_none() && !T::KINDS.contains(&kind) {
            let found = format!("column `{name}` holds {}", kind.plural());
            let mut error = FormatError::of_file(path, found);
            T::EXPECTED.clone_into(&mut error.expected);
            return Err(error);
        }
        let value = |row: usize| {
            let cell = match (column.values.cell(row), written) {
                (Cell::Text(text), Some(_)) => Cell::Written(text),
                (cell, _) => cell,
            };
            T::of(cell).ok_or_else(|| self.unlike::<T>(name, row, cell))
        };
        (0..column.values.len()).map(value).collect()
    }

    fn missing(&self, name: &str) -> FormatError {
        let path = &self.origin.path;
        let left_out = self.origin.left_out.iter().find(|(left, _)| left == name);
        if let Some((_, what)) = left_out {
            return FormatError::of_file(path, format!("column `{name}` holds {what}"))
                .with_help("columns of numbers, truth values and text can be read");
        }
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        let help = if names.is_empty() {
            "it has no columns".to_owned()
        } else {
            format!("its columns are {}", names.join(", "))
        };
        FormatError::of_file(path, format!("no column `{name}`")).with_help(help)
    }

    fn unlike<T: Element>(&self, name: &str, row: usize, cell: Cell<'_>) -> FormatError {
        let what = match cell {
            Cell::Number(value) => value.to_string(),
            Cell::Whole(value) => value.to_string(),
            Cell::Truth(value) => value.to_string(),
            Cell::Text("") | Cell::Written("") | Cell::Missing => "nothing".to_owned(),
            Cell::Text(text) | Cell::Written(text) => format!("{text:?}"),
        };
        let path = &self.origin.path;
        match &self.origin.lines {
            Some(lines) => {
                let found = format!("{what} in column `{name}`");
                FormatError::at(path, lines[row], None, found, T::EXPECTED)
            }
            None => {
                let found = format!("{what} in row {} of column `{name}`", row + 1);
                let mut error = FormatError::of_file(path, found);
                T::EXPECTED.clone_into(&mut error.expected);
                error
            }
        }
    }

    /// Writes a Parquet file: whole or not at all, and a file that was there before stays until this one is whole.
    ///
    /// # Errors
    /// When columns have the same name or unequal lengths, or the file cannot be written.
    pub fn write_parquet(self, path: &Path) -> Result<(), WriteError> {
        let specs = self.columns.iter().map(Column::spec).collect();
        let mut writer = ParquetWriter::create(path, specs, &self.metadata)?;
        let columns = self.columns.into_iter();
        writer.write(columns.map(|column| column.values).collect())?;
        writer.finish()
    }

    /// The names, units and types of its columns.
    #[must_use]
    pub fn specs(&self) -> Vec<Spec> {
        self.columns.iter().map(Column::spec).collect()
    }

    /// The table with numbers in the columns of text whose cells are all numbers (empty cells as missing ones), and text in the
    /// others.
    #[must_use]
    pub fn typed(self) -> Self {
        let columns = self.columns.into_iter().map(|column| match column.values {
            Values::Text(cells) => {
                let values = numbers(&cells).unwrap_or(Values::Text(cells));
                Column::new(column.name, column.unit, values)
            }
            values => Column { values, ..column },
        });
        columns.fold(Self::default(), Self::with)
    }

    pub(crate) fn read_from(origin: Origin) -> Self {
        Self {
            origin,
            ..Self::default()
        }
    }
}

/// The cells as numbers, if all that are not empty are, and one is not empty.
fn numbers(cells: &[String]) -> Option<Values> {
    if cells.iter().all(String::is_empty) {
        return None;
    }
    let number = |cell: &String| match cell.as_str() {
        "" => Some(f64::NAN),
        text => text.parse().ok(),
    };
    let numbers: Option<_> = cells.iter().map(number).collect();
    numbers.map(Values::F64)
}

/// Error of a file that the system refuses.
pub(crate) fn unreadable(path: &Path, error: &std::io::Error) -> FormatError {
    FormatError::of_file(path, format!("the file cannot be read: {error}"))
}
