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
use mercury_common::formats::lines::LineReader;

use crate::column::{Column, Values};
use crate::table::{Origin, Table, unreadable};

/// See [`Table::read_text`].
pub(crate) fn read(path: &Path) -> Result<Table, FormatError> {
    let file = File::open(path).map_err(|error| unreadable(path, &error))?;
    let mut lines = LineReader::new(BufReader::new(file), path);
    if !advance(&mut lines)? {
        let mut error = FormatError::of_file(path, "the file is empty");
        error.expected = "a line with the names of the columns".to_owned();
        return Err(error);
    }
    let header = lines.line();
    let found = |separator: &u8| header.as_bytes().contains(separator);
    let separator = *(b"\t;".iter().find(|s| found(s))).unwrap_or(&b',');
    let (mut names, mut numbers) = (Vec::<(String, String)>::new(), Vec::new());
    let mut known = HashSet::new();
    for field in fields(header, separator) {
        let name = field.ok_or_else(|| open_quote(&lines))?;
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
    while advance(&mut lines)? {
        let mut count = 0;
        for field in fields(lines.line(), separator) {
            let field = field.ok_or_else(|| open_quote(&lines))?;
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

/// The next line that is neither blank nor a comment.
fn advance(lines: &mut LineReader<BufReader<File>>) -> Result<bool, FormatError> {
    while lines.advance()? {
        if !lines.is_comment() {
            return Ok(true);
        }
    }
    Ok(false)
}

fn at<R: std::io::BufRead>(
    lines: &LineReader<R>,
    found: impl Into<String>,
    expected: impl Into<String>,
) -> FormatError {
    FormatError::at(lines.path(), lines.line_number(), None, found, expected)
}

fn open_quote<R: std::io::BufRead>(lines: &LineReader<R>) -> FormatError {
    let expected = "a second one at the end of the field, or none";
    at(lines, "a quote that is not closed", expected)
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

/// The fields of a line; none for one whose quote is not closed on it.
fn fields(line: &str, separator: u8) -> impl Iterator<Item = Option<Cow<'_, str>>> {
    let mut rest = Some(line.trim_end_matches(['\n', '\r']));
    std::iter::from_fn(move || {
        let text = rest.take()?;
        let start = text.trim_start_matches([' ']);
        let Some(quoted) = start.strip_prefix('"') else {
            let field = match text.bytes().position(|byte| byte == separator) {
                Some(end) => {
                    rest = Some(&text[end + 1..]);
                    &text[..end]
                }
                None => text,
            };
            return Some(Some(field.trim_ascii().into()));
        };
        let mut end = 0;
        loop {
            let Some(length) = quoted[end..].find('"') else {
                return Some(None);
            };
            end += length;
            if !quoted[end + 1..].starts_with('"') {
                break;
            }
            end += 2;
        }
        let field = quoted[..end].replace("\"\"", "\"");
        let behind = quoted[end + 1..].trim_start_matches([' ']);
        if let Some(next) = behind.strip_prefix(separator as char) {
            rest = Some(next);
        } else if !behind.is_empty() {
            return Some(None);
        }
        Some(Some(field.into()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(line: &str, separator: u8) -> Option<Vec<String>> {
        let field = |field: Option<Cow<'_, str>>| field.map(Cow::into_owned);
        fields(line, separator).map(field).collect()
    }

    #[test]
    fn lines_are_cut_into_fields() {
        let of = |fields: &[&str]| Some(fields.iter().map(|f| (*f).to_owned()).collect());
        assert_eq!(split("a,b\r\n", b','), of(&["a", "b"]));
        assert_eq!(split(" a , b ,", b','), of(&["a", "b", ""]));
        assert_eq!(
            split("a;\"b;\"\"c\"\"\" ;d", b';'),
            of(&["a", "b;\"c\"", "d"])
        );
        assert_eq!(split("\"\"\t5\" pipe", b'\t'), of(&["", "5\" pipe"]));
        assert_eq!(split("\"a,b", b','), None);
        assert_eq!(split("\"a\"b,c", b','), None);
    }

    #[test]
    fn units_stand_in_brackets() {
        assert_eq!(with_unit("radius [mm]"), ("radius", "mm"));
        assert_eq!(with_unit("x[m/s]"), ("x", "m/s"));
        assert_eq!(with_unit("f[0] [N]"), ("f[0]", "N"));
        assert_eq!(with_unit("plain"), ("plain", ""));
    }
}
