//! Tables of measured sizes: one grammar for the solver and the tools (`docs/formats/size-table.md`).
//!
//! The modules: `header` gives the meaning of the columns, `lines` cuts the text into rows of numbers, `rules` turns rows into
//! [`Classes`]. A reader of another kind of file (Parquet) hands its columns to [`from_rows`].

mod header;
mod lines;
mod rules;

use std::path::Path;

use super::Weighting;
use super::classes::{ClassModel, Classes};
use crate::error::FormatError;
use crate::formats;

pub use header::{Columns, SizeKind, ValueKind, ValueUnit, parse_size_unit, parse_type};
pub use lines::{BY_QUOTA, Row};

/// Facts about a table that its header may leave out: options of a command line. They win over the header.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Meaning of the sizes.
    pub size: Option<SizeKind>,
    /// Number of its units in a metre.
    pub per_metre: Option<f64>,
    /// Meaning of the values.
    pub values: Option<(ValueKind, Weighting)>,
    /// Distribution inside a class; that of the file where this is left out.
    pub model: Option<Model>,
    /// Repair like MercuryDPM: negative values count as 0, values are divided by their last (or sum), a class is put in
    /// front of a table that does not begin with 0.
    pub mercury: bool,
}

/// A [`ClassModel`] that may refer to what the table measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// This one.
    Of(ClassModel),
    /// Constant density of the measured quantity.
    UniformInMeasured,
    /// Constant density of the measured quantity per ln d.
    LogUniformInMeasured,
}

impl Model {
    fn resolve(self, measured: Weighting) -> ClassModel {
        match self {
            Self::Of(model) => model,
            Self::UniformInMeasured => ClassModel::Uniform(measured),
            Self::LogUniformInMeasured => ClassModel::LogUniform(measured),
        }
    }
}

/// A measured distribution as a file holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct SizeTable {
    /// The distribution.
    pub classes: Classes,
    /// Quantity that was measured.
    pub weighting: Weighting,
    /// Diameters between the measured classes, m, with the empty ones at the ends.
    pub edges: Vec<f64>,
    /// Measured share of each class, scaled to the sum 1.
    pub shares: Vec<f64>,
    /// Number of counted particles, where the table counts particles.
    pub counted: Option<f64>,
    /// Notes of what was repaired or left out while reading.
    pub notes: Vec<String>,
}

/// Content of a file of sizes.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Shares of classes.
    Table(SizeTable),
    /// One size per line.
    Sizes(SizeList),
}

/// Particles one by one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SizeList {
    /// Diameters, m, in the order of the file.
    pub diameters: Vec<f64>,
    /// Whether they are marked as drawn by quota, which fits better than chance.
    pub by_quota: bool,
}

/// Reads a table of shares, as a scene names it.
///
/// # Errors
/// If the file cannot be read or is no table of shares: what, where and what to do.
pub fn read(path: &Path) -> Result<SizeTable, FormatError> {
    match read_content(path, &Options::default())? {
        Content::Table(table) => Ok(table),
        Content::Sizes(_) => Err(FormatError {
            expected: "a second column with shares".to_owned(),
            ..FormatError::of_file(path, "a list of sizes").with_help(
                "make a table of it: mercury-psd convert FILE --type cumulative-number -o TABLE.csv",
            )
        }),
    }
}

/// Reads a file of sizes, with the options of the command line.
///
/// # Errors
/// As [`read`].
pub fn read_content(path: &Path, options: &Options) -> Result<Content, FormatError> {
    let bytes = formats::read_bytes(path)?;
    let bytes = formats::lines::with_line_feeds(&bytes);
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()]
            .iter()
            .filter(|&&b| b == b'\n')
            .count();
        FormatError::at(
            path,
            line,
            None,
            "bytes that are not text",
            "a table of sizes",
        )
        .with_help("save the table as CSV in UTF-8")
    })?;
    parse(path, text, options)
}

/// Reads a file of sizes from memory; `path` is used in messages only.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, text: &str, options: &Options) -> Result<Content, FormatError> {
    let lines::Read {
        columns,
        rows,
        mut notes,
        by_quota,
    } = lines::read(path, text, options)?;
    let content = from_rows(path, &columns, &rows)?;
    Ok(match content {
        Content::Table(mut table) => {
            notes.append(&mut table.notes);
            Content::Table(SizeTable { notes, ..table })
        }
        Content::Sizes(list) => Content::Sizes(SizeList { by_quota, ..list }),
    })
}

/// Makes a distribution, or a list of diameters, of rows of numbers.
///
/// # Errors
/// If a row is wrong: which, and why.
pub fn from_rows(path: &Path, columns: &Columns, rows: &[Row]) -> Result<Content, FormatError> {
    match columns.values {
        Some((kind, weighting)) => {
            rules::table(path, columns, kind, weighting, rows).map(Content::Table)
        }
        None => rules::sizes(path, columns, rows).map(|diameters| {
            Content::Sizes(SizeList {
                diameters,
                by_quota: false,
            })
        }),
    }
}

#[cfg(test)]
mod tests;
