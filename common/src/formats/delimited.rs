//! Delimited text: lines cut into cells, and cells put into lines, with quotes as in RFC 4180.
//!
//! A cell in double quotes may hold the separator and ends of lines; a quote inside is doubled.

use std::borrow::Cow;

use super::table_head;

/// A cell of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell<'a> {
    /// Its text without blanks around it and without its quotes; quotes inside are still doubled, see [`value`](Self::value).
    pub text: &'a str,
    /// Byte offset of the text in the line (of the separator or end if the cell is empty).
    pub start: usize,
    /// Whether the cell has no quotes around it, or both.
    pub is_closed: bool,
    /// Whether it has both.
    pub is_quoted: bool,
}

impl<'a> Cell<'a> {
    /// The text; of a cell in quotes with single ones in place of doubled ones.
    #[must_use]
    pub fn value(self) -> Cow<'a, str> {
        match self.is_quoted && self.text.contains("\"\"") {
            true => self.text.replace("\"\"", "\"").into(),
            false => self.text.into(),
        }
    }
}

/// The separator of a header: the one among `,` `;` tab that occurs in it; `Err` lists several.
pub(super) fn detect_separator(header: &str) -> Result<Option<u8>, Vec<char>> {
    let present: Vec<char> = [',', ';', '\t']
        .into_iter()
        .filter(|&c| header.contains(c))
        .collect();
    match present[..] {
        [] => Ok(None),
        [one] => Ok(Some(one as u8)),
        _ => Err(present),
    }
}

/// The cells of a line.
#[derive(Debug, Clone)]
pub struct Cells<'a> {
    line: &'a str,
    separator: u8,
    /// Byte offset of the next cell; `None` after the last.
    next: Option<usize>,
}

impl<'a> Cells<'a> {
    /// Of a line without its end; `separator` is a character of ASCII.
    #[must_use]
    pub fn new(line: &'a str, separator: u8) -> Self {
        Self {
            line,
            separator,
            next: Some(0),
        }
    }
}

/// Byte offset of the quote that closes a cell, in the text behind the quote that opens it.
fn closing_quote(text: &str) -> Option<usize> {
    let mut from = 0;
    loop {
        let at = from + text[from..].find('"')?;
        if !text[at + 1..].starts_with('"') {
            return Some(at);
        }
        from = at + 2;
    }
}

impl<'a> Iterator for Cells<'a> {
    type Item = Cell<'a>;

    fn next(&mut self) -> Option<Cell<'a>> {
        let begin = self.next?;
        let rest = &self.line[begin..];
        let blanks = rest.len() - rest.trim_start_matches(' ').len();
        let quoted = rest[blanks..].strip_prefix('"');
        // The separator counts again behind the closing quote; without one the quote is a character.
        let closing = quoted.and_then(closing_quote);
        let search_from = closing.map_or(0, |length| blanks + length + 2);
        let end = rest.as_bytes()[search_from..]
            .iter()
            .position(|&byte| byte == self.separator)
            .map_or(rest.len(), |length| search_from + length);
        self.next = (end < rest.len()).then_some(begin + end + 1);

        let cell = &rest[..end];
        let text = cell.trim();
        let start = begin + cell.len() - cell.trim_start().len();
        let is_whole = closing.is_some() && rest[search_from..end].trim().is_empty();
        Some(match (closing, is_whole) {
            (Some(length), true) => Cell {
                text: &rest[blanks + 1..blanks + 1 + length],
                start: start + 1,
                is_closed: true,
                is_quoted: true,
            },
            _ => Cell {
                text,
                start,
                is_closed: quoted.is_none(),
                is_quoted: false,
            },
        })
    }
}

/// Appends a cell, in quotes if it holds a comma, a quote or an end of line, or begins or ends with a blank.
pub fn push_cell(out: &mut Vec<u8>, text: &str) {
    if text.contains([',', '"', '\n', '\r']) || text.trim() != text {
        out.push(b'"');
        out.extend_from_slice(text.replace('"', "\"\"").as_bytes());
        out.push(b'"');
    } else {
        out.extend_from_slice(text.as_bytes());
    }
}

/// Appends a line of cells with commas between them.
///
/// ```
/// use mercury_common::formats::delimited::push_line;
/// let mut out = Vec::new();
/// push_line(&mut out, ["1", "a,\"b\""]);
/// assert_eq!(out, b"1,\"a,\"\"b\"\"\"\n");
/// ```
pub fn push_line(out: &mut Vec<u8>, cells: impl IntoIterator<Item = impl AsRef<str>>) {
    for (place, cell) in cells.into_iter().enumerate() {
        if place > 0 {
            out.push(b',');
        }
        push_cell(out, cell.as_ref());
    }
    out.push(b'\n');
}

/// A table with a head, row by row: rows without an end or with another number of cells than the head, as a killed program leaves them, are
/// left out.
///
/// ```
/// use mercury_common::formats::delimited::Rows;
/// let mut rows = Rows::new("time [s],name\n0,\"a,\nb\"\n0.5,cu");
/// assert_eq!(rows.place("name"), Some(1));
/// assert_eq!(rows.next().unwrap(), ["0", "a,\nb"]);
/// assert_eq!(rows.next(), None);
/// ```
#[derive(Debug, Clone)]
pub struct Rows<'a> {
    /// Names of the columns, without their units.
    pub names: Vec<String>,
    rest: &'a str,
}

impl<'a> Rows<'a> {
    /// Of the text of a file with commas between its cells; no names where it has no head.
    #[must_use]
    pub fn new(text: &'a str) -> Self {
        let mut rows = Self {
            names: Vec::new(),
            rest: text,
        };
        let head = rows.next_line().into_iter();
        let cells = head.flat_map(|line| Cells::new(line, b','));
        rows.names = cells
            .map(|cell| table_head::name(&cell.value()).to_owned())
            .collect();
        rows
    }

    /// The place of a column.
    #[must_use]
    pub fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// The next line that has an end, up to an end of line outside of quotes.
    fn next_line(&mut self) -> Option<&'a str> {
        let mut in_quotes = false;
        let end = self.rest.bytes().position(|byte| {
            in_quotes ^= byte == b'"';
            byte == b'\n' && !in_quotes
        })?;
        let line = &self.rest[..end];
        self.rest = &self.rest[end + 1..];
        Some(line)
    }
}

impl<'a> Iterator for Rows<'a> {
    type Item = Vec<Cow<'a, str>>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let cells = Cells::new(self.next_line()?, b',').map(Cell::value);
            let row: Vec<Cow<'a, str>> = cells.collect();
            if row.len() == self.names.len() {
                return Some(row);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(line: &str, separator: u8) -> Vec<Cow<'_, str>> {
        Cells::new(line, separator).map(Cell::value).collect()
    }

    #[test]
    fn cuts_at_separators_outside_quotes() {
        assert_eq!(texts("a, b ,c", b','), ["a", "b", "c"]);
        assert_eq!(texts("a;;", b';'), ["a", "", ""]);
        assert_eq!(texts("", b','), [""]);
        assert_eq!(texts("1, \"wet, clay\" ,2", b','), ["1", "wet, clay", "2"]);
        assert_eq!(texts("\"open,2", b','), ["\"open", "2"]);
        assert_eq!(texts("\"\",x", b','), ["", "x"]);
        assert_eq!(texts("a;\"b;\"\"c\"\"\" ;d", b';'), ["a", "b;\"c\"", "d"]);
        assert_eq!(texts("\"\"\t5\" pipe", b'\t'), ["", "5\" pipe"]);
        // Quotes are doubled only where there are some around the cell.
        assert_eq!(texts("7\"\",\"7\"\"\"", b','), ["7\"\"", "7\""]);
    }

    #[test]
    fn quotes_that_are_not_closed_are_seen() {
        let closed = |line| Cells::new(line, b',').all(|cell| cell.is_closed);
        assert!(closed("a,\"b\",\"\"\"\" ,5\" pipe"));
        for line in ["\"a,b", "\"a\"b,c", "x, \"a\"\"", "\""] {
            assert!(!closed(line), "{line}");
        }
    }

    #[test]
    fn starts_are_places_in_the_line() {
        for line in ["a, b ,\"c\"", " \t1,\u{e4} , 2"] {
            for cell in Cells::new(line, b',') {
                assert!(line[cell.start..].starts_with(cell.text));
            }
        }
    }

    #[test]
    fn lines_are_read_as_they_are_written() {
        let mut text = Vec::new();
        push_line(&mut text, ["run", "title"]);
        push_line(&mut text, ["a", "one,\n\"two\""]);
        text.extend_from_slice(b"b,cut");
        let text = String::from_utf8(text).unwrap();
        let rows = Rows::new(&text);
        assert_eq!(rows.names, ["run", "title"]);
        assert_eq!(rows.collect::<Vec<_>>(), [["a", "one,\n\"two\""]]);
        assert_eq!(Rows::new("time,na").names, [""; 0]);
    }

    #[test]
    fn finds_the_separator() {
        assert_eq!(detect_separator("x,y"), Ok(Some(b',')));
        assert_eq!(detect_separator("x\ty"), Ok(Some(b'\t')));
        assert_eq!(detect_separator("x"), Ok(None));
        assert_eq!(detect_separator("x,y;z"), Err(vec![',', ';']));
    }
}
