//! One error type for every reader: which file, which line and column, what was found, what was expected.

use std::fmt;
use std::path::PathBuf;

use crate::readable::{printable, printable_lines, shortened};

/// Characters of each part of a message that are printed: they quote the file, which may hold anything.
const LONGEST: usize = 1000;

/// Characters of a path that are printed, as many as any system takes.
const LONGEST_PATH: usize = 4096;

/// Problem of an input file, in words that a user can act on.
///
/// Printed as `path:line:column: found ..., expected ...`, the form that editors make clickable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormatError {
    /// The file, as the user named it.
    pub path: PathBuf,
    /// Line, counted from 1, where the problem has one.
    pub line: Option<usize>,
    /// Column, counted in characters from 1, where the problem has one.
    pub column: Option<usize>,
    /// Text that was found (`"abc" in column radius`), or the failure (`the file cannot be opened: ...`).
    pub found: String,
    /// Text that was expected; empty when `found` is sufficient.
    pub expected: String,
    /// Advice, if there is more than "correct it".
    pub help: Option<Box<str>>,
}

impl FormatError {
    /// A problem of the whole file.
    pub fn of_file(path: impl Into<PathBuf>, found: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            line: None,
            column: None,
            found: found.into(),
            expected: String::new(),
            help: None,
        }
    }

    /// A problem at a line (and column) of the file, both counted from 1.
    pub fn at(
        path: impl Into<PathBuf>,
        line: usize,
        column: Option<usize>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            path: path.into(),
            line: Some(line),
            column,
            found: found.into(),
            expected: expected.into(),
            help: None,
        }
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into().into_boxed_str());
        self
    }

    /// Adds a further thing to do about it, behind the present advice.
    #[must_use]
    pub fn with_more_help(self, help: &str) -> Self {
        let help = match &self.help {
            Some(known) => format!("{known}; {help}"),
            None => help.to_owned(),
        };
        self.with_help(help)
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display().to_string();
        write!(f, "{}", printable(&shortened(&path, LONGEST_PATH)))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        write!(f, ": {}", printable_lines(&shortened(&self.found, LONGEST)))?;
        if !self.expected.is_empty() {
            let expected = shortened(&self.expected, LONGEST);
            write!(f, ", expected {}", printable_lines(&expected))?;
        }
        if let Some(help) = &self.help {
            write!(f, "\nhelp: {}", printable_lines(&shortened(help, LONGEST)))?;
        }
        Ok(())
    }
}

impl std::error::Error for FormatError {}
