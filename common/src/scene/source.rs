//! Where a value was written: the text it comes from, its span, its key.

use std::fmt;
use std::ops::{Deref, Range};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use super::cursor::Files;
use super::error::SceneError;
use super::tree::{Node, Value};
use crate::problem::Spot;
use crate::readable::{printable, shortened};

/// Characters of a line of the source that a message shows.
const WIDTH: usize = 400;

/// A text that values come from: a scene file, or one `--set KEY=VALUE` of the command line.
#[derive(Debug)]
pub struct Source {
    name: String,
    text: String,
    kind: SourceKind,
    /// Files that it may name.
    files: Files,
    /// The ends of its lines, computed on first use.
    ends: OnceLock<Vec<usize>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SourceKind {
    File,
    Argument,
}

impl Source {
    /// The text of a scene file, under the name that messages call it by, and which files it may name.
    pub(super) fn file(
        name: impl Into<String>,
        text: impl Into<String>,
        files: &Files,
    ) -> Arc<Self> {
        Arc::new(Self {
            name: name.into(),
            text: text.into(),
            kind: SourceKind::File,
            files: files.clone(),
            ends: OnceLock::new(),
        })
    }

    /// One `KEY=VALUE` of the command line.
    pub(super) fn argument(text: impl Into<String>, files: &Files) -> Arc<Self> {
        Arc::new(Self {
            name: "--set".to_owned(),
            text: text.into(),
            kind: SourceKind::Argument,
            files: files.clone(),
            ends: OnceLock::new(),
        })
    }

    /// Name of the source in messages.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The line that holds byte `at`, counted from 1.
    fn line_of(&self, at: usize) -> usize {
        let ends = self.ends.get_or_init(|| {
            let ends = self.text.match_indices('\n');
            ends.map(|(end, _)| end).collect()
        });
        1 + ends.partition_point(|&end| end < at)
    }

    /// The byte range of the line that holds byte `at`, without its line end.
    fn line_around(&self, at: usize) -> Range<usize> {
        let bytes = self.text.as_bytes();
        let at = at.min(bytes.len());
        let start = bytes[..at]
            .iter()
            .rposition(|&b| b == b'\n')
            .map_or(0, |i| i + 1);
        let end = bytes[at..]
            .iter()
            .position(|&b| b == b'\n')
            .map_or(bytes.len(), |i| at + i);
        let end = if end > start && bytes[end - 1] == b'\r' {
            end - 1
        } else {
            end
        };
        start..end
    }
}

/// The place of a value: the text, the span in it, and the key path (`materials.glass.density`).
///
/// Cheap to clone. It outlives reading, so that later checks report with the look of the reader:
/// see [`SourceSpan::error`].
#[derive(Debug, Clone)]
pub struct SourceSpan {
    source: Arc<Source>,
    start: usize,
    end: usize,
    key: Arc<str>,
}

impl SourceSpan {
    /// A span of a source, under a key. The span is clipped to the text and to whole characters.
    pub(super) fn new(source: &Arc<Source>, span: Range<usize>, key: impl Into<Arc<str>>) -> Self {
        let text = &source.text;
        let floor = |at: usize| {
            let mut at = at.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = floor(span.start);
        Self {
            source: Arc::clone(source),
            start,
            end: floor(span.end).max(start),
            key: key.into(),
        }
    }

    /// A value at this place.
    pub(super) fn node(&self, value: Value) -> Node {
        Node {
            value,
            source: Arc::clone(&self.source),
            span: self.start..self.end,
        }
    }

    /// This span under another key.
    pub(super) fn with_key(&self, key: impl Into<Arc<str>>) -> Self {
        Self {
            key: key.into(),
            ..self.clone()
        }
    }

    /// The path of the key, as `--set` takes it; empty for the whole file.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The file as the user named it, or `--set`.
    #[must_use]
    pub fn source_name(&self) -> &str {
        &self.source.name
    }

    /// Whether the value was given on the command line.
    #[must_use]
    pub fn is_argument(&self) -> bool {
        self.source.kind == SourceKind::Argument
    }

    /// Text of the span, as typed.
    #[must_use]
    pub fn text(&self) -> &str {
        self.source
            .text
            .get(self.start..self.end)
            .unwrap_or_default()
    }

    /// Line of the first character, counted from 1.
    #[must_use]
    pub fn line(&self) -> usize {
        self.source.line_of(self.start)
    }

    /// Column of the first character, counted in characters from 1.
    #[must_use]
    pub fn column(&self) -> usize {
        self.column_of(self.start)
    }

    fn column_of(&self, at: usize) -> usize {
        let line = self.source.line_around(at);
        let before = self.source.text.get(line.start..at);
        1 + before.map_or(0, |text| text.chars().count())
    }

    /// Where it begins, and where it ends, behind its last character; nothing for the whole file and for what is missing in it.
    #[must_use]
    pub fn spots(&self) -> Option<(Spot, Spot)> {
        let spot = |at: usize| Spot {
            line: self.source.line_of(at),
            column: self.column_of(at),
        };
        (self.end > 0).then(|| (spot(self.start), spot(self.end)))
    }

    /// The `KEY=VALUE` of the command line that it is in, if it is in one.
    #[must_use]
    pub fn argument(&self) -> Option<&str> {
        self.is_argument().then_some(self.source.text.as_str())
    }

    /// Files that may be named here.
    #[must_use]
    pub fn files(&self) -> &Files {
        &self.source.files
    }

    /// Whether a file that is named here, or by a file that is named here, may be read.
    ///
    /// # Errors
    /// The file lies outside of the folder to which the scene is confined; with the name as it is given, and no word on what is
    /// there.
    pub fn may_read(&self, name: &Path) -> Result<(), SceneError> {
        match &self.source.files {
            Files::Within(within) => within
                .check(name)
                .map_err(|outside| self.error(format!("{}: {outside}", name.display()))),
            Files::MustExist | Files::Unchecked => Ok(()),
        }
    }

    /// An error at this place.
    ///
    /// ```
    /// use std::path::Path;
    /// use mercury_common::scene::{Files, parse_scene};
    /// let text = "[time]\nend = 1.0\nstep = 0.1\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n";
    /// let scene = parse_scene(Path::new("box.toml"), text, &[], Files::Unchecked)?;
    /// let error = scene.time.end.place.error("the end comes too early").with_help("wait longer");
    /// assert_eq!(
    ///     error.to_string(),
    ///     "box.toml:2:7: time.end: the end comes too early\n    end = 1.0\n          ^^^\nhelp: wait longer"
    /// );
    /// # Ok::<(), mercury_common::scene::SceneErrors>(())
    /// ```
    #[must_use]
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        SceneError {
            place: self.clone(),
            message: message.into(),
            help: None,
        }
    }

    /// Sorts as a reader meets the places: file order, the command line last.
    pub(super) fn order(&self) -> (bool, usize) {
        (self.is_argument(), self.start)
    }

    /// `file:line:column`, `file` or `--set KEY=VALUE`.
    pub(super) fn write_head(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.source.kind {
            SourceKind::Argument => {
                let text = shortened(&self.source.text, WIDTH);
                write!(f, "--set {}", printable(&text))
            }
            // An error of the whole file has no line.
            SourceKind::File if self.end == 0 && self.key.is_empty() => {
                f.write_str(&printable(&self.source.name))
            }
            SourceKind::File => {
                let name = printable(&self.source.name);
                write!(f, "{name}:{}:{}", self.line(), self.column())
            }
        }
    }

    /// The source line with carets under the span; nothing for the command line, which the head
    /// shows already, for the whole file, and for an empty line.
    pub(super) fn write_excerpt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = self.source.line_around(self.start);
        let Some(text) = self.source.text.get(line.clone()) else {
            return Ok(());
        };
        let is_whole = self.end == 0 && self.key.is_empty();
        if self.is_argument() || is_whole || text.trim().is_empty() {
            return Ok(());
        }
        let before = self
            .source
            .text
            .get(line.start..self.start.min(line.end))
            .unwrap_or_default();
        let under = self
            .source
            .text
            .get(self.start..self.end.min(line.end))
            .unwrap_or_default()
            .trim_end();
        // Of a long line only what is around the place.
        let text = text.trim_end();
        let skipped = before.chars().count().saturating_sub(WIDTH / 2);
        let skipped = if text.chars().nth(WIDTH).is_some() {
            skipped
        } else {
            0
        };
        let indent: String = before
            .chars()
            .skip(skipped)
            .map(|c| if c == '\t' { '\t' } else { ' ' })
            .collect();
        let room = WIDTH.saturating_sub(indent.chars().count()).max(1);
        let carets = "^".repeat(under.chars().count().clamp(1, room));
        let shown: String = text.chars().skip(skipped).take(WIDTH).collect();
        write!(f, "\n    {}\n    {indent}{carets}", printable(&shown))
    }
}

impl PartialEq for SourceSpan {
    fn eq(&self, other: &Self) -> bool {
        (self.source_name(), self.start, self.end, &self.key)
            == (other.source_name(), other.start, other.end, &other.key)
    }
}

/// A value together with the place where it was typed (or, for a default, where it could be).
#[derive(Debug, Clone, PartialEq)]
pub struct Located<T> {
    /// The value.
    pub value: T,
    /// Where it was typed.
    pub place: SourceSpan,
}

impl<T> Located<T> {
    /// Applies a function to the value and keeps the place.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Located<U> {
        Located {
            value: change(self.value),
            place: self.place,
        }
    }

    /// An error at the value's place: see [`SourceSpan::error`].
    #[must_use]
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        self.place.error(message)
    }
}

impl<T> Deref for Located<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.value
    }
}
