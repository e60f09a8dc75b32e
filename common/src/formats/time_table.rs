//! Tables of numbers over time in comma-separated text: motions, loads, flows, droplets.

use std::io::{BufRead, BufReader};
use std::path::Path;

use super::delimited::Cells;
use super::lines::{LineReader, shorten};
use super::number::parse_number;
use crate::error::FormatError;

/// The columns of a table of numbers over time.
#[derive(Debug, Clone, Copy)]
pub struct TimeTable<'a, const N: usize> {
    /// Their names; the first is the time, s.
    pub names: [&'a str; N],
    /// How many of the names a table must have; the others may be missing together, and are then 0.
    pub required: usize,
    /// Whether rows may have equal times.
    pub equal_times: bool,
}

/// A row of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeRow<const N: usize> {
    /// Line of the file, counted from 1.
    pub line: usize,
    /// Finite numbers in the order of the names.
    pub values: [f64; N],
}

impl<'a, const N: usize> TimeTable<'a, N> {
    /// A table with all of these columns and increasing times.
    #[must_use]
    pub fn new(names: [&'a str; N]) -> Self {
        Self {
            names,
            required: N,
            equal_times: false,
        }
    }

    /// Reads a file: a header with the names in any order, then a row for each time. Blank lines and lines that begin with `#` are skipped.
    ///
    /// # Errors
    /// If the file cannot be read or is not text, a column is missing, unknown or doubled, a row has another number of cells than the header, a cell
    /// is not a finite number, times go back, or there is no row; with file, line and column.
    pub fn read(&self, path: &Path) -> Result<Vec<TimeRow<N>>, FormatError> {
        self.read_from(BufReader::new(super::open(path)?), path)
    }

    /// As [`read`](Self::read), from the content of a file; `path` is for the messages.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn parse(&self, path: &Path, text: &str) -> Result<Vec<TimeRow<N>>, FormatError> {
        self.read_from(text.as_bytes(), path)
    }

    fn read_from<R: BufRead>(&self, input: R, path: &Path) -> Result<Vec<TimeRow<N>>, FormatError> {
        let mut lines = LineReader::new(input, path);
        if !lines.advance_to_content()? {
            return Err(FormatError {
                expected: self.header_text(),
                ..FormatError::of_file(path, "no header")
            });
        }
        let columns = self.header(&lines)?;
        let mut rows: Vec<TimeRow<N>> = Vec::new();
        while lines.advance_to_content()? {
            let before = rows.last().map(|row| row.values[0]);
            rows.push(self.row(&lines, &columns, before)?);
        }
        if rows.is_empty() {
            return Err(FormatError {
                expected: "at least one row below the header".to_owned(),
                ..FormatError::of_file(path, "no rows")
            });
        }
        Ok(rows)
    }

    fn header_text(&self) -> String {
        let all = self.names.join(",");
        match self.required < N {
            true => format!(
                "the columns {} or {all}",
                self.names[..self.required].join(",")
            ),
            false => format!("the columns {all}"),
        }
    }

    /// For each cell of a row the place of its name.
    fn header<R: BufRead>(&self, lines: &LineReader<R>) -> Result<Vec<usize>, FormatError> {
        let expected = self.header_text();
        let mut columns = Vec::new();
        for cell in Cells::new(lines.text(), b',') {
            let wrong = |found: String| Err(lines.error_at(cell.start, found, expected.as_str()));
            let name = shorten(cell.text);
            let Some(column) = self.names.iter().position(|&known| known == cell.text) else {
                return wrong(format!("the column \"{name}\""));
            };
            if columns.contains(&column) {
                return wrong(format!("the column \"{name}\" a second time"));
            }
            columns.push(column);
        }
        let has_optional = columns.iter().any(|&column| column >= self.required);
        let needed = if has_optional { N } else { self.required };
        match (0..needed).find(|column| !columns.contains(column)) {
            None => Ok(columns),
            Some(missing) => {
                let found = format!("no column \"{}\"", self.names[missing]);
                let (path, line) = (lines.path(), lines.line_number());
                Err(FormatError::at(path, line, None, found, expected))
            }
        }
    }

    /// The row of the current line; `before` is the time of the row before it.
    fn row<R: BufRead>(
        &self,
        lines: &LineReader<R>,
        columns: &[usize],
        before: Option<f64>,
    ) -> Result<TimeRow<N>, FormatError> {
        let mut values = [0.0; N];
        let mut count = 0;
        for cell in Cells::new(lines.text(), b',') {
            let wrong =
                |found: String, expected: String| Err(lines.error_at(cell.start, found, expected));
            let text = shorten(cell.text);
            let Some(&column) = columns.get(count) else {
                let expected = format!("{} fields, as in the header", columns.len());
                return wrong(format!("one more field, \"{text}\""), expected);
            };
            let Some(value) = parse_number(cell.text).filter(|value| value.is_finite()) else {
                let found = format!("\"{text}\" in column {}", self.names[column]);
                return wrong(found, "a finite number".to_owned());
            };
            if let Some(before) = before.filter(|_| column == 0)
                && !(value > before || self.equal_times && value == before)
            {
                let order = if self.equal_times {
                    "not before"
                } else {
                    "after"
                };
                let expected = format!("a time {order} that of the row before, {before}");
                return wrong(format!("{} = {value}", self.names[0]), expected);
            }
            values[column] = value;
            count += 1;
        }
        let line = lines.line_number();
        if count < columns.len() {
            let found = format!("{count} fields");
            let expected = format!("{}, as in the header", columns.len());
            return Err(FormatError::at(lines.path(), line, None, found, expected));
        }
        Ok(TimeRow { line, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_with_their_lines_in_the_order_of_the_names() {
        let table = TimeTable::new(["t", "rate"]);
        let text = "\u{feff}# flow\nrate,t\n\n1e-6, 0\r\n2e-6,0.5\n";
        let rows = table.parse(Path::new("flow.csv"), text).unwrap();
        let rows: Vec<_> = rows.iter().map(|row| (row.line, row.values)).collect();
        assert_eq!(rows, [(4, [0.0, 1e-6]), (5, [0.5, 2e-6])]);
    }

    #[test]
    fn mistakes_have_their_places() {
        let strict = TimeTable::new(["t", "rate"]);
        let table = |equal_times| TimeTable {
            equal_times,
            ..strict
        };
        let wrong = |text: &str| {
            let found = table(false).parse(Path::new("a.csv"), text);
            found.unwrap_err().to_string()
        };
        assert_eq!(
            wrong("# only\n"),
            "a.csv: no header, expected the columns t,rate"
        );
        for (text, message) in [
            (
                "time,rate\n",
                "a.csv:1:1: the column \"time\", expected the columns t,rate",
            ),
            (
                "rate\n",
                "a.csv:1: no column \"t\", expected the columns t,rate",
            ),
            (
                "t,rate\n",
                "a.csv: no rows, expected at least one row below the header",
            ),
            (
                "t,rate\n0\n",
                "a.csv:2: 1 fields, expected 2, as in the header",
            ),
            (
                "t,rate\n0,0x1\n",
                "a.csv:2:3: \"0x1\" in column rate, expected a finite number",
            ),
            (
                "t,rate\n1,1\n\n1,1\n",
                "a.csv:4:1: t = 1, expected a time after that of the row before, 1",
            ),
        ] {
            assert_eq!(wrong(text), message);
        }
        let twice = "t,rate\n1,1\n1,2\n0,3\n";
        let error = table(true).parse(Path::new("a.csv"), twice).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a.csv:4:1: t = 0, expected a time not before that of the row before, 1"
        );
    }
}
