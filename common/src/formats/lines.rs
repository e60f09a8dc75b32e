//! Lines of a text file and the blank-separated tokens on them, with their places.

use std::borrow::Cow;
use std::io::{BufRead, Read as _};
use std::path::{Path, PathBuf};

use crate::error::FormatError;
use crate::formats::number::parse_number;
use crate::formats::other_kinds;
use crate::run_files::Packing;

/// The longest line, in bytes. No format of ours or of those we read has longer ones; a compressed file of a few kilobytes may.
pub const LONGEST_LINE: usize = 1 << 24;

/// Reads lines one by one and remembers where it is.
#[derive(Debug)]
pub struct LineReader<R> {
    input: R,
    path: PathBuf,
    line: String,
    line_number: usize,
    held: bool,
    takes_any_encoding: bool,
    has_begun: bool,
}

impl<R: BufRead> LineReader<R> {
    /// `path` is only used in messages.
    pub fn new(input: R, path: impl Into<PathBuf>) -> Self {
        Self {
            input,
            path: path.into(),
            line: String::new(),
            line_number: 0,
            held: false,
            takes_any_encoding: false,
            has_begun: false,
        }
    }

    /// Reads bytes that are not UTF-8 as U+FFFD: for files in which names alone may have letters beyond ASCII.
    #[must_use]
    pub fn with_any_encoding(mut self) -> Self {
        self.takes_any_encoding = true;
        self
    }

    /// Goes to the next line that is not blank; `false` at the end of the file.
    ///
    /// # Errors
    /// If the file cannot be read, is not text (UTF-8), has a line longer than [`LONGEST_LINE`], or begins like a file of another kind.
    pub fn advance(&mut self) -> Result<bool, FormatError> {
        if std::mem::take(&mut self.held) {
            return Ok(true);
        }
        loop {
            let mut bytes = std::mem::take(&mut self.line).into_bytes();
            bytes.clear();
            let mut line = (&mut self.input).take(LONGEST_LINE as u64 + 1);
            let length = line.read_until(b'\n', &mut bytes).map_err(|error| {
                let place = Some(self.line_number + 1);
                FormatError {
                    line: place,
                    ..FormatError::of_file(&self.path, format!("the file cannot be read: {error}"))
                }
            })?;
            if length == 0 {
                return Ok(false);
            }
            self.line_number += 1;
            if length > LONGEST_LINE {
                let found = format!("a line of more than {} MiB", LONGEST_LINE >> 20);
                let expected = "a text file, whose lines are shorter";
                let place = self.line_number;
                return Err(FormatError::at(&self.path, place, None, found, expected));
            }
            self.line = match String::from_utf8(bytes) {
                Ok(line) => line,
                Err(error) if self.takes_any_encoding => {
                    String::from_utf8_lossy(error.as_bytes()).into_owned()
                }
                Err(error) => {
                    return Err(not_text(&self.path, self.line_number, error.as_bytes()));
                }
            };
            if self.line_number == 1 && self.line.starts_with('\u{feff}') {
                self.line.remove(0);
            }
            if !self.line.bytes().all(|byte| byte.is_ascii_whitespace()) {
                if !std::mem::replace(&mut self.has_begun, true) {
                    other_kinds::refuse(&self.path, self.line.as_bytes())?;
                }
                return Ok(true);
            }
        }
    }

    /// Goes to the next line that is neither blank nor a comment; `false` at the end of the file.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    pub fn advance_to_content(&mut self) -> Result<bool, FormatError> {
        while self.advance()? {
            if !self.is_comment() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Makes the next [`advance`](Self::advance) stay on this line.
    pub fn hold(&mut self) {
        self.held = true;
    }

    /// The file, as named by the user.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The number of the current line, counted from 1; 0 before the first.
    pub fn line_number(&self) -> usize {
        self.line_number
    }

    /// The text of the current line with its line end.
    pub fn line(&self) -> &str {
        &self.line
    }

    /// The text of the current line without its line end.
    pub fn text(&self) -> &str {
        let text = self.line.strip_suffix('\n').unwrap_or(&self.line);
        text.strip_suffix('\r').unwrap_or(text)
    }

    /// A problem at a byte of the current line.
    pub fn error_at(
        &self,
        byte: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> FormatError {
        let column = self.line[..byte].chars().count() + 1;
        FormatError::at(&self.path, self.line_number, Some(column), found, expected)
    }

    /// True if the first token of the current line starts with `#`.
    pub fn is_comment(&self) -> bool {
        self.line.trim_ascii_start().starts_with('#')
    }

    /// The tokens of the current line.
    pub fn tokens(&self) -> Tokens<'_> {
        Tokens {
            path: &self.path,
            line_number: self.line_number,
            text: &self.line,
            position: 0,
        }
    }
}

/// The text with a line feed in place of each carriage return that has none: such are the line ends of old programs of the
/// Macintosh.
pub(crate) fn with_line_feeds(bytes: &[u8]) -> Cow<'_, [u8]> {
    let is_alone = |at: usize| bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n');
    if !(bytes.contains(&b'\r') && (0..bytes.len()).any(is_alone)) {
        return Cow::Borrowed(bytes);
    }
    let byte = |at: usize| if is_alone(at) { b'\n' } else { bytes[at] };
    (0..bytes.len()).map(byte).collect()
}

/// The message for bytes that are not UTF-8, with the usual reasons.
pub(crate) fn not_text(path: &Path, line_number: usize, line: &[u8]) -> FormatError {
    let valid = std::str::from_utf8(line).map_or_else(|error| error.valid_up_to(), |_| line.len());
    let column = String::from_utf8_lossy(&line[..valid]).chars().count() + 1;
    let error = FormatError::at(
        path,
        line_number,
        Some(column),
        "a byte that is not text",
        "a text file in UTF-8",
    );
    match Packing::of(line).filter(|_| line_number == 1) {
        Some(packing) => {
            let command = packing.command();
            error.with_help(format!(
                "the file is compressed: unpack it first ({command})"
            ))
        }
        None => error.with_help("save it as text with the encoding UTF-8"),
    }
}

/// A piece of a line without blanks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Token<'a> {
    /// The text itself, never empty.
    pub text: &'a str,
    /// Byte offset of its first character in the line.
    pub start: usize,
}

/// The tokens of one line, separated by blanks or tabs.
#[derive(Debug, Clone)]
pub struct Tokens<'a> {
    path: &'a Path,
    line_number: usize,
    text: &'a str,
    position: usize,
}

impl<'a> Iterator for Tokens<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        let bytes = self.text.as_bytes();
        let mut start = self.position;
        while bytes.get(start).is_some_and(u8::is_ascii_whitespace) {
            start += 1;
        }
        let mut end = start;
        while bytes
            .get(end)
            .is_some_and(|byte| !byte.is_ascii_whitespace())
        {
            end += 1;
        }
        self.position = end;
        // The borders are ASCII blanks, so they are character borders.
        (end > start).then(|| Token {
            text: &self.text[start..end],
            start,
        })
    }
}

impl<'a> Tokens<'a> {
    /// Tokens of a line that was read elsewhere.
    pub fn new(path: &'a Path, line_number: usize, text: &'a str) -> Self {
        Self {
            path,
            line_number,
            text,
            position: 0,
        }
    }

    /// The next token as a number; `name` is its noun in messages.
    ///
    /// # Errors
    /// If the line ends here, or the token is not a number.
    pub fn number(&mut self, name: &str) -> Result<f64, FormatError> {
        let token = self.expect(name, "a number")?;
        parse_number(token.text).ok_or_else(|| self.unexpected(token, name, "a number"))
    }

    /// The next token as a whole number.
    ///
    /// # Errors
    /// If the line ends here, or the token is not a whole number that fits.
    pub fn integer(&mut self, name: &str) -> Result<i64, FormatError> {
        let token = self.expect(name, "a whole number")?;
        token
            .text
            .parse()
            .map_err(|_| self.unexpected(token, name, "a whole number"))
    }

    /// Fills `values` from the next tokens, named by `names` (same length) in messages.
    ///
    /// # Errors
    /// If the line ends too early, or a token is not a number.
    pub fn numbers(&mut self, values: &mut [f64], names: &[&str]) -> Result<(), FormatError> {
        for (index, value) in values.iter_mut().enumerate() {
            *value = self.number(names.get(index).copied().unwrap_or("?"))?;
        }
        Ok(())
    }

    /// The next token, whatever it is.
    ///
    /// # Errors
    /// If the line ends here.
    pub fn expect(&mut self, name: &str, expected: &str) -> Result<Token<'a>, FormatError> {
        self.next().ok_or_else(|| {
            let column = self.text.trim_ascii_end().chars().count() + 1;
            FormatError::at(
                self.path,
                self.line_number,
                Some(column),
                format!("the end of the line in place of {name}"),
                expected,
            )
        })
    }

    /// A message about a token.
    #[must_use]
    pub fn unexpected(&self, token: Token<'_>, name: &str, expected: &str) -> FormatError {
        let column = self.text[..token.start].chars().count() + 1;
        FormatError::at(
            self.path,
            self.line_number,
            Some(column),
            format!("\"{}\" for {name}", shorten(token.text)),
            expected,
        )
    }
}

/// Keeps messages readable when a file holds a very long word.
pub(crate) fn shorten(text: &str) -> String {
    const LONGEST: usize = 40;
    if text.chars().count() <= LONGEST {
        text.to_owned()
    } else {
        format!("{}...", text.chars().take(LONGEST).collect::<String>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reader(text: &str) -> LineReader<&[u8]> {
        LineReader::new(text.as_bytes(), "a.data")
    }

    #[test]
    fn counts_lines_and_columns() {
        let mut lines = reader("\u{feff}1 2\r\n\r\n  \u{e4}\u{f6}  x7 3\n");
        assert!(lines.advance().unwrap());
        let mut tokens = lines.tokens();
        assert_eq!(tokens.number("a").unwrap(), 1.0);
        assert_eq!(tokens.integer("b").unwrap(), 2);
        let error = tokens.number("c").unwrap_err();
        assert_eq!((error.line, error.column), (Some(1), Some(4)));
        assert!(lines.advance().unwrap());
        let mut tokens = lines.tokens();
        assert_eq!(tokens.next().unwrap().text, "\u{e4}\u{f6}");
        let error = tokens.number("radius").unwrap_err();
        assert_eq!(
            error.to_string(),
            "a.data:3:7: \"x7\" for radius, expected a number"
        );
        assert!(!lines.advance().unwrap());
    }

    #[test]
    fn holds_a_line() {
        let mut lines = reader("a\nb\n");
        assert!(lines.advance().unwrap());
        lines.hold();
        assert!(lines.advance().unwrap());
        assert_eq!(lines.tokens().next().unwrap().text, "a");
        assert!(lines.advance().unwrap());
        assert_eq!(lines.tokens().next().unwrap().text, "b");
    }

    #[test]
    fn says_that_a_file_is_compressed() {
        let mut lines = LineReader::new(&[0x1f, 0x8b, 8, 0, b'\n'][..], "f.gz");
        let error = lines.advance().unwrap_err();
        assert_eq!((error.line, error.column), (Some(1), Some(2)));
        assert!(error.help.unwrap().contains("gunzip"));
    }

    #[test]
    fn files_of_another_kind_are_named() {
        for (text, found) in [
            (
                "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n",
                "f.data: a pointer of Git LFS in place of the file",
            ),
            (
                "\n <!DOCTYPE html>\n<html>\n",
                "f.data: a page of the web (HTML) in place of the file",
            ),
        ] {
            let mut lines = LineReader::new(text.as_bytes(), "f.data");
            let error = lines.advance().unwrap_err();
            assert!(error.to_string().starts_with(found), "{error}");
            assert!(error.help.is_some());
        }
    }

    #[test]
    fn lines_end_with_any_of_the_three_ends() {
        let text = |bytes: &[u8]| String::from_utf8(with_line_feeds(bytes).into_owned()).unwrap();
        assert_eq!(text(b"a\rb\r\rc\r"), "a\nb\n\nc\n");
        assert_eq!(text(b"a\r\nb\rc\n\r\n"), "a\r\nb\nc\n\r\n");
        assert!(matches!(with_line_feeds(b"a\r\nb\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn names_may_be_in_any_encoding() {
        let mut lines = LineReader::new(&b"solid Gr\xf6\xdfe 7\n"[..], "f.stl").with_any_encoding();
        assert!(lines.advance().unwrap());
        let mut tokens = lines.tokens().skip(2);
        assert_eq!(tokens.next().unwrap().text, "7");
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let endless = std::io::BufReader::new(std::io::repeat(b'0'));
        let mut lines = LineReader::new(endless, "bomb.data");
        let error = lines.advance().unwrap_err().to_string();
        assert!(
            error.starts_with("bomb.data:1: a line of more than 16 MiB"),
            "{error}"
        );
        // One of just that length is read.
        let mut text = vec![b'1'; LONGEST_LINE - 1];
        text.push(b'\n');
        let mut lines = LineReader::new(&text[..], "long.data");
        assert!(lines.advance().unwrap());
        assert_eq!(lines.line().len(), LONGEST_LINE);
    }

    #[test]
    fn a_whole_number_is_not_a_fraction() {
        let mut lines = reader("1.5\n");
        lines.advance().unwrap();
        assert!(lines.tokens().integer("i").is_err());
    }
}
