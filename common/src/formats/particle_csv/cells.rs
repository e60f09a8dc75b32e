//! Cutting a line of a table into cells.

/// One cell: what stands in it and where it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cell<'a> {
    /// Without blanks around it, and without quotes.
    pub(super) text: &'a str,
    /// Byte offset of the text in the line (of the separator or end if the cell is empty).
    pub(super) start: usize,
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

/// The cells of a line. A cell in double quotes may hold the separator.
#[derive(Debug, Clone)]
pub(super) struct Cells<'a> {
    line: &'a str,
    separator: u8,
    /// Byte offset of the next cell; `None` after the last.
    next: Option<usize>,
}

impl<'a> Cells<'a> {
    pub(super) fn new(line: &'a str, separator: u8) -> Self {
        Self {
            line,
            separator,
            next: Some(0),
        }
    }
}

impl<'a> Iterator for Cells<'a> {
    type Item = Cell<'a>;

    fn next(&mut self) -> Option<Cell<'a>> {
        let begin = self.next?;
        let rest = &self.line[begin..];
        let blanks = rest.len() - rest.trim_start_matches(' ').len();
        let search_from = match rest[blanks..].strip_prefix('"') {
            // The separator counts again behind the closing quote; without one the quote is a character.
            Some(quoted) => quoted.find('"').map_or(0, |length| blanks + length + 2),
            None => 0,
        };
        let end = rest.as_bytes()[search_from..]
            .iter()
            .position(|&byte| byte == self.separator)
            .map_or(rest.len(), |length| search_from + length);
        self.next = (end < rest.len()).then_some(begin + end + 1);

        let cell = &rest[..end];
        let text = cell.trim();
        let start = begin + cell.len() - cell.trim_start().len();
        match text
            .strip_prefix('"')
            .and_then(|text| text.strip_suffix('"'))
        {
            Some(inner) => Some(Cell {
                text: inner,
                start: start + 1,
            }),
            None => Some(Cell { text, start }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(line: &str, separator: u8) -> Vec<&str> {
        Cells::new(line, separator).map(|cell| cell.text).collect()
    }

    #[test]
    fn cuts_at_separators_outside_quotes() {
        assert_eq!(texts("a, b ,c", b','), ["a", "b", "c"]);
        assert_eq!(texts("a;;", b';'), ["a", "", ""]);
        assert_eq!(texts("", b','), [""]);
        assert_eq!(texts("1, \"wet, clay\" ,2", b','), ["1", "wet, clay", "2"]);
        assert_eq!(texts("\"open,2", b','), ["\"open", "2"]);
        assert_eq!(texts("\"\",x", b','), ["", "x"]);
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
    fn finds_the_separator() {
        assert_eq!(detect_separator("x,y"), Ok(Some(b',')));
        assert_eq!(detect_separator("x\ty"), Ok(Some(b'\t')));
        assert_eq!(detect_separator("x"), Ok(None));
        assert_eq!(detect_separator("x,y;z"), Err(vec![',', ';']));
    }
}
