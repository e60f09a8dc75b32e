//! Delimited text with a header.
//!
//! Read by ourselves rather than by the crate `csv`, whose records have the wrong line behind comments, blank lines and Windows line
//! ends, and which takes a quote that is not closed for one that ends with the file (`docs/decisions/0029-libraries.md`).

use std::borrow::Cow;
use std::collections::HashSet;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use mercury_common::error::FormatError;
use mercury_common::formats::delimited::{Cell, Cells};
use mercury_common::formats::lines::LineReader;

use crate::column::{Column, Values};
use crate::table::{Origin, Table, unreadable};

/// See [`Table::read_text`].
pub(crate) fn read(path: &Path) -> Result<Table, FormatError> {
    let file = File::open(path).map_err(|error| unreadable(path, &error))?;
    let mut lines = LineReader::new(BufReader::new(file), path);
    if !lines.advance_to_content()? {
        let mut error = FormatError::of_file(path, "the file is empty");
        error.expected = "a line with the names of the columns".to_owned();
        return Err(error);
    }
    let header = lines.text();
    let found = |separator: &u8| header.as_bytes().contains(separator);
    let separator = *(b"\t;".iter().find(|s| found(s))).unwrap_or(&b',');
    let (mut names, mut numbers) = (Vec::<(String, String)>::new(), Vec::new());
    let mut known = HashSet::new();
    for cell in Cells::new(header, separator) {
        let name = closed(&lines, cell)?;
        let (name, unit) = with_unit(&name);
        if name.is_empty() {
            let found = format!("no name of column {}", names.len() + 1);
            return Err(at(&lines, found, "a name in every column of the header"));
        }
        if !known.insert(name.to_owned()) {
            let found = format!("the name `{name}` twice");
            return Err(at(&lines, found, "columns with different names"));
        }
        names.push((name.to_owned(), unit.to_owned()));
    }
    let mut columns = vec![Vec::new(); names.len()];
    while lines.advance_to_content()? {
        let mut count = 0;
        for cell in Cells::new(lines.text(), separator) {
            let field = closed(&lines, cell)?;
            if let Some(column) = columns.get_mut(count) {
                column.push(field.into_owned());
            }
            count += 1;
        }
        if count != names.len() {
            let found = format!("{count} fields");
            return Err(at(
                &lines,
                found,
                format!("{}, as in the header", names.len()),
            ));
        }
        numbers.push(lines.line_number());
    }
    let columns = names.into_iter().zip(columns);
    let columns = columns.map(|((name, unit), text)| Column::new(name, unit, Values::Text(text)));
    Ok(columns.fold(
        Table::read_from(Origin {
            path: path.to_owned(),
            lines: Some(numbers),
            left_out: Vec::new(),
        }),
        Table::with,
    ))
}

fn at<R: std::io::BufRead>(
    lines: &LineReader<R>,
    found: impl Into<String>,
    expected: impl Into<String>,
) -> FormatError {
    FormatError::at(lines.path(), lines.line_number(), None, found, expected)
}

/// The value of a cell.
fn closed<'a, R: std::io::BufRead>(
    lines: &LineReader<R>,
    cell: Cell<'a>,
) -> Result<Cow<'a, str>, FormatError> {
    match cell.is_closed {
        true => Ok(cell.value()),
        false => {
            let expected = "a second one at the end of the field, or none";
            Err(lines.error_at(cell.start, "a quote that is not closed", expected))
        }
    }
}

/// `radius [m]` as `radius` and `m`.
fn with_unit(text: &str) -> (&str, &str) {
    let unit = text
        .strip_suffix(']')
        .and_then(|text| text.rsplit_once('['));
    unit.map_or((text, ""), |(name, unit)| {
        (name.trim_ascii(), unit.trim_ascii())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_stand_in_brackets() {
        assert_eq!(with_unit("radius [mm]"), ("radius", "mm"));
        assert_eq!(with_unit("x[m/s]"), ("x", "m/s"));
        assert_eq!(with_unit("f[0] [N]"), ("f[0]", "N"));
        assert_eq!(with_unit("plain"), ("plain", ""));
    }
}
