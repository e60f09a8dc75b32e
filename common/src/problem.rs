//! One thing that is wrong with an input, in parts: for programs that show it where it is, as editors do.
//!
//! Readers have errors of their own, which people read as text; each of these gives its parts to a [`Problem`].

use crate::error::FormatError;
use crate::scene::{SceneError, SceneErrors};

/// A place in a text: line and column, both counted from 1, the column in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Spot {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

/// A problem. A field that is not known is `None`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Problem {
    /// The file, as the user named it.
    pub file: Option<String>,
    /// Where it begins.
    pub start: Option<Spot>,
    /// Behind its last character.
    pub end: Option<Spot>,
    /// The key of the scene, as `--set` takes it.
    pub key: Option<String>,
    /// The `KEY=VALUE` of the command line that it is in.
    pub set: Option<String>,
    /// Description of the problem.
    pub message: String,
    /// Advice on how to solve it.
    pub help: Option<String>,
}

impl Problem {
    /// Problem in a message for people, whose advice stands in a line that begins with `help: `.
    #[must_use]
    pub fn of_text(text: &str) -> Self {
        let (message, help) = match text.split_once("\nhelp: ") {
            Some((message, help)) => (message, Some(help.trim_end().to_owned())),
            None => (text, None),
        };
        Self {
            message: message.trim_end().to_owned(),
            help,
            ..Self::default()
        }
    }

    /// All problems of a scene, in the order of the file.
    #[must_use]
    pub fn of_scene(errors: &SceneErrors) -> Vec<Self> {
        errors.0.iter().map(Self::from).collect()
    }
}

impl From<&SceneError> for Problem {
    fn from(error: &SceneError) -> Self {
        let place = &error.place;
        let key = (!place.key().is_empty()).then(|| place.key().to_owned());
        let text = Self {
            key,
            message: error.message.clone(),
            help: error.help.clone(),
            ..Self::default()
        };
        if let Some(argument) = place.argument() {
            return Self {
                set: Some(argument.to_owned()),
                ..text
            };
        }
        let spots = place.spots();
        Self {
            file: Some(place.source_name().to_owned()),
            start: spots.map(|(start, _)| start),
            end: spots.map(|(_, end)| end),
            ..text
        }
    }
}

impl From<&FormatError> for Problem {
    fn from(error: &FormatError) -> Self {
        let spot = error.line.map(|line| Spot {
            line,
            column: error.column.unwrap_or(1),
        });
        let message = match error.expected.as_str() {
            "" => error.found.clone(),
            expected => format!("{}, expected {expected}", error.found),
        };
        Self {
            file: Some(error.path.display().to_string()),
            start: spot,
            end: spot,
            message,
            help: error.help.as_deref().map(str::to_owned),
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::{Files, parse_scene};

    const SCENE: &str = "[time]\nend = 1\nstep = 1e-5\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n";

    fn problems(text: &str, overrides: &[&str]) -> Vec<Problem> {
        let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
        let read = parse_scene(Path::new("a.toml"), text, &overrides, Files::Unchecked);
        Problem::of_scene(&read.unwrap_err())
    }

    fn spot(line: usize, column: usize) -> Option<Spot> {
        Some(Spot { line, column })
    }

    #[test]
    fn the_place_of_a_value_is_that_of_its_characters() {
        // Characters count, not bytes: the comment in front of the value has two of two bytes.
        let text = SCENE.replace("min = [0, 0, 0]", "min = [ # äö\n 0, \"ä\", 0]");
        let found = problems(&text, &[]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].file.as_deref(), Some("a.toml"));
        assert_eq!(found[0].key.as_deref(), Some("domain.min[1]"));
        assert_eq!((found[0].start, found[0].end), (spot(6, 5), spot(6, 8)));
    }

    #[test]
    fn what_is_missing_has_a_key_and_no_place() {
        let found = problems(&SCENE.replace("[time]\nend = 1\nstep = 1e-5\n", ""), &[]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].key.as_deref(), Some("time"));
        assert_eq!((found[0].start, found[0].end), (None, None));
        assert!(found[0].help.is_some());
    }

    #[test]
    fn an_argument_is_no_place_in_the_file() {
        let found = problems(SCENE, &["time.end=-1"]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].file, None);
        assert_eq!(found[0].start, None);
        assert_eq!(found[0].key.as_deref(), Some("time.end"));
        assert_eq!(found[0].set.as_deref(), Some("time.end=-1"));
    }

    #[test]
    fn texts_for_people_are_taken_apart() {
        let problem = Problem::of_text("drum: there is a run\nhelp: --force replaces it\n");
        assert_eq!(problem.message, "drum: there is a run");
        assert_eq!(problem.help.as_deref(), Some("--force replaces it"));
        assert_eq!(Problem::of_text("x").help, None);
    }
}
