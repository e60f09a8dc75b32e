//! Problems of a scene, each with its place.

use std::fmt;

use super::source::SourceSpan;
use crate::readable::{counted, printable, printable_lines, shortened};

/// Characters of a key, a message or a piece of advice that are printed: they quote the file, which may hold anything.
const LONGEST: usize = 600;

/// The largest number of problems that are printed one by one; of the others only the number is printed.
const MOST_PRINTED: usize = 50;

/// One problem of a scene.
///
/// Printed as `scene.toml:12:9: materials.glass.friction: must be >= 0, got -0.3`, then the source
/// line with carets under the value, then `help: ...` where there is advice.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneError {
    /// Place of the error, with its key.
    pub place: SourceSpan,
    /// Description of the problem.
    pub message: String,
    /// Advice on how to solve it.
    pub help: Option<String>,
}

impl SceneError {
    /// Adds what to do about it.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The key that the problem belongs to; empty for the whole file.
    #[must_use]
    pub fn path(&self) -> &str {
        self.place.key()
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.place.write_head(f)?;
        if !self.path().is_empty() {
            write!(f, ": {}", printable(&shortened(self.path(), LONGEST)))?;
        }
        write!(
            f,
            ": {}",
            printable_lines(&shortened(&self.message, LONGEST))
        )?;
        self.place.write_excerpt(f)?;
        if let Some(help) = &self.help {
            write!(f, "\nhelp: {}", printable_lines(&shortened(help, LONGEST)))?;
        }
        Ok(())
    }
}

impl std::error::Error for SceneError {}

/// All problems of a scene, in the order of the file. Printed one after the other, up to fifty.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneErrors(pub Vec<SceneError>);

impl SceneErrors {
    /// These and more, in the order of the file.
    #[must_use]
    pub fn and(mut self, more: Vec<SceneError>) -> Self {
        self.0.extend(more);
        self.0.sort_by_key(|error| error.place.order());
        self
    }
}

impl fmt::Display for SceneErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.0.iter().take(MOST_PRINTED).enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            error.fmt(f)?;
        }
        match self.0.len().saturating_sub(MOST_PRINTED) {
            0 => Ok(()),
            more => write!(f, "\nand {} more", counted(more, "problem")),
        }
    }
}

impl std::error::Error for SceneErrors {}

impl From<SceneError> for SceneErrors {
    fn from(error: SceneError) -> Self {
        Self(vec![error])
    }
}
