//! `mercury-solve new`: a scene to start from.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::starters::{STARTERS, StarterError};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use mercury_common::cli::{Failure, Outcome, say};

/// Arguments of `new`: the file to write, and its place.
#[derive(Debug, Args)]
pub(crate) struct New {
    /// Which
    #[arg(value_name = "WHICH", value_parser = PossibleValuesParser::new(
        STARTERS.map(|starter| PossibleValue::new(starter.name).help(starter.about))
    ))]
    which: String,

    /// Where to; it is made if it is not there
    #[arg(value_name = "FOLDER", default_value = ".")]
    folder: PathBuf,
}

/// Writes the scene, and prints the next command.
pub(crate) fn execute(new: &New) -> Outcome {
    let starter = (STARTERS.iter().find(|starter| starter.name == new.which))
        .ok_or_else(|| Failure::input(format!("there is no scene `{}`", new.which)))?;
    let paths = starter.write(&new.folder).map_err(|error| match error {
        StarterError::Exists { .. } => Failure::input(error),
        StarterError::System { .. } => Failure::run(error),
    })?;
    let names: Vec<String> = paths
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let mut text = format!("{}: {}\nnext:\n", names.join(", "), starter.about);
    if new.folder != Path::new(".") {
        let _ = writeln!(text, "  cd {}", quoted(&new.folder));
    }
    let next = starter.next();
    let width = next.iter().map(|(command, _)| command.len()).max();
    for (command, gives) in next {
        let _ = writeln!(text, "  {command:0$}  # {gives}", width.unwrap_or(0));
    }
    say(&text)
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "-_./".contains(c);
    if text.chars().all(plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}
