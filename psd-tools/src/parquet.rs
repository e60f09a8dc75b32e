//! Tables and lists of sizes in Parquet files.
//!
//! A Parquet file holds what a text file would: columns of the same names, units in their metadata, what is assumed inside a class as
//! the file's entry `in-class`, `sampling` likewise. It is turned into that text and read by the one grammar of tables, with the same rules and messages; lines
//! in messages are those of that text.

use std::path::Path;

use mercury_common::error::FormatError;
use mercury_common::formats::number::{NumberStyle, parse_number, push_number};
use mercury_common::sizes::table::BY_QUOTA;
use mercury_tables::{Column, Kind, Table, Values, WriteError};

/// The entries of the metadata in place of the comments of a text file: the distribution inside a class, how sizes were drawn.
const ENTRIES: [&str; 2] = ["in-class", BY_QUOTA[0]];
/// The ending that selects Parquet.
const ENDING: &str = "parquet";

/// Why no Parquet file was written.
#[derive(Debug, thiserror::Error)]
pub enum ParquetError {
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The text is no table of numbers.
    #[error("line {0}: no row of as many numbers as the header has columns")]
    Row(usize),
}

/// Whether a file is to be Parquet, by its name.
#[must_use]
pub fn is_named(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == ENDING)
}

/// Whether a file begins like Parquet.
#[must_use]
pub fn is_one(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PAR1")
}

/// A Parquet file as the text of a table: header, then rows, cut by tabs. Columns that hold no numbers are left out.
///
/// # Errors
/// If it cannot be read, or has no column of numbers.
pub fn as_text(path: &Path) -> Result<String, FormatError> {
    let table = Table::read_parquet(path)?;
    let has_numbers = |column: &&Column| !matches!(column.values.kind(), Kind::Bool | Kind::Text);
    let columns: Vec<&Column> = table.columns().iter().filter(has_numbers).collect();
    if columns.is_empty() {
        return Err(FormatError {
            expected: "a column of sizes, such as diameter [mm]".to_owned(),
            ..FormatError::of_file(path, "no column of numbers")
        });
    }
    let mut out = Vec::new();
    for (key, word) in &table.metadata {
        if ENTRIES.contains(&key.as_str()) {
            out.extend_from_slice(format!("# {key}: {word}\n").as_bytes());
        }
    }
    let names: Vec<String> = (columns.iter())
        .map(|column| match &column.unit[..] {
            "" => column.name.clone(),
            unit => format!("{} [{unit}]", column.name),
        })
        .collect();
    out.extend_from_slice(names.join("\t").as_bytes());
    out.push(b'\n');
    let values = columns
        .iter()
        .map(|column| table.values::<f64>(&column.name));
    let values: Vec<Vec<f64>> = values.collect::<Result<_, _>>()?;
    for row in 0..table.rows() {
        for (k, column) in values.iter().enumerate() {
            if k > 0 {
                out.push(b'\t');
            }
            push_number(&mut out, column[row], NumberStyle::Shortest);
        }
        out.push(b'\n');
    }
    Ok(String::from_utf8_lossy(&out).into_owned())
}

/// Writes the text of a table or list, as this crate makes it, as a Parquet file.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, text: &str) -> Result<(), ParquetError> {
    let mut table = Table::default();
    let mut columns: Vec<(String, String, Vec<f64>)> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if let Some(comment) = line.strip_prefix('#') {
            if let Some((key, word)) = comment
                .split_once(':')
                .filter(|(key, _)| ENTRIES.contains(&key.trim()))
            {
                let entry = (key.trim().to_owned(), word.trim().to_owned());
                table.metadata.push(entry);
            }
            continue;
        }
        if columns.is_empty() {
            columns = line.split(',').map(named).collect();
            continue;
        }
        let mut cells = line.split(',');
        for (_, _, values) in &mut columns {
            let number = cells.next().and_then(parse_number);
            values.push(number.ok_or(ParquetError::Row(index + 1))?);
        }
    }
    for (name, unit, values) in columns {
        table = table.with(Column::new(name, unit, Values::F64(values)));
    }
    Ok(table.write_parquet(path)?)
}

/// Name and unit of a cell of the header.
fn named(cell: &str) -> (String, String, Vec<f64>) {
    let (name, unit) = cell.split_once('[').unwrap_or((cell, ""));
    let unit = match unit.trim_end().trim_end_matches(']') {
        // As Parquet files call what has no unit.
        "-" => "1",
        unit => unit,
    };
    (name.trim().to_owned(), unit.to_owned(), Vec::new())
}

#[cfg(test)]
mod tests {
    use mercury_common::sizes::table::{self, Content, Options};
    use mercury_common::sizes::{ClassModel, Weighting};

    use super::*;

    fn parsed(text: &str) -> Content {
        table::parse(Path::new("t.csv"), text, &Options::default()).expect("a table")
    }

    #[test]
    fn a_table_and_a_list_come_back() {
        let folder = tempfile::tempdir().expect("a folder");
        for text in [
            "# in-class: volume-log-uniform\ndiameter [mm],cumulative volume [-]\n1,0\n2.5,0.25\n4,1\n",
            "sieve [um],retained volume [%]\n63,12.5\n125,87.5\n250,0\n",
            "radius [um]\n63.5\n125\n",
            "# sampling: quota\nradius [um]\n63.5\n125\n",
        ] {
            let path = folder.path().join("t.parquet");
            write(&path, text).expect("written");
            assert!(is_one(&std::fs::read(&path).expect("bytes")) && is_named(&path));
            assert_eq!(
                parsed(&as_text(&path).expect("text")),
                parsed(text),
                "{text}"
            );
        }
        let Content::Table(table) = parsed(&as_text_of(&folder, "# in-class: volume-uniform\n"))
        else {
            panic!("a table");
        };
        assert_eq!(table.weighting, Weighting::Volume);
        assert_ne!(table.classes.model(), ClassModel::default());
    }

    fn as_text_of(folder: &tempfile::TempDir, comment: &str) -> String {
        let path = folder.path().join("u.parquet");
        write(
            &path,
            &format!("{comment}diameter [mm],fraction volume [-]\n1,0\n2,1\n"),
        )
        .expect("written");
        as_text(&path).expect("text")
    }

    #[test]
    fn what_is_no_table_is_reported() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.parquet");
        std::fs::write(&path, "PAR1 and no more").expect("written");
        assert!(as_text(&path).is_err());
        assert!(matches!(
            write(&path, "diameter [mm]\n1\nx\n"),
            Err(ParquetError::Row(3))
        ));
        let words =
            Table::default().with(Column::new("name", "", Values::Text(vec!["a".to_owned()])));
        words.write_parquet(&path).expect("written");
        let error = as_text(&path).expect_err("no numbers");
        assert!(
            error.to_string().contains("no column of numbers"),
            "{error}"
        );
    }
}
