//! Names of files that users give, and which files of a run only grow.

use crate::RunId;

/// The longest name of an input file, in bytes.
pub const LONGEST_NAME: usize = 100;

/// Reason for which a name is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadName {
    /// Empty, or longer than [`LONGEST_NAME`].
    #[error("a file name has 1 to {LONGEST_NAME} characters")]
    Length,
    /// A character beyond `A-Z a-z 0-9 . _ -`.
    #[error("a file name has letters, digits and . _ - only")]
    Character,
    /// Names that begin with a dot are hidden, or lead elsewhere.
    #[error("a file name does not begin with a dot or a dash")]
    Beginning,
}

/// The longest title, label and name of other things than files, in bytes.
pub const LONGEST_TEXT: usize = 200;

/// Reason for which a title, a label or a name is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadText {
    /// Longer than [`LONGEST_TEXT`].
    #[error("it has at most {LONGEST_TEXT} bytes")]
    Length,
    /// A line feed, an escape sequence of a terminal, and the like.
    #[error("it has no control characters")]
    Control,
}

/// Checks a title, a label or a name that is for people.
pub fn check_text(text: &str) -> Result<(), BadText> {
    if text.len() > LONGEST_TEXT {
        Err(BadText::Length)
    } else if text.chars().any(char::is_control) {
        Err(BadText::Control)
    } else {
        Ok(())
    }
}

/// Checks the name of an input file. All inputs of a run lie in one flat folder.
pub fn check_name(name: &str) -> Result<(), BadName> {
    if name.is_empty() || name.len() > LONGEST_NAME {
        return Err(BadName::Length);
    }
    if !name
        .bytes()
        .all(|b| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'_' | b'-'))
    {
        return Err(BadName::Character);
    }
    if name.starts_with(['.', '-']) {
        Err(BadName::Beginning)
    } else {
        Ok(())
    }
}

/// Checks the name of an input as workers lay it out: a flat name, or that of a checkpoint of another run, `ID/NAME`.
pub fn check_input(name: &str) -> Result<(), BadName> {
    match name.split_once('/') {
        Some((run, file)) if run.parse::<RunId>().is_ok() => check_name(file),
        _ => check_name(name),
    }
}

/// How the files of a run come to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// Frames are appended; the file ends in an eight-byte marker that moves (`docs/formats/frames.md`).
    Frames,
    /// Whole lines are appended.
    Lines,
    /// Written as a whole, and again when it changes.
    Whole,
    /// Belongs to the machine that computes, and is never kept: locks, requests, files under construction.
    Never,
    /// A checkpoint from which the run goes on. Kept checkpoints, which lie in a folder of their own, are written as a whole.
    Checkpoint,
}

/// How the file `name`, a path within the folder of a run, comes to be.
pub fn growth(name: &str) -> Growth {
    let last = name.rsplit('/').next().unwrap_or(name);
    let extension = last.rsplit_once('.').map_or("", |(_, extension)| extension);
    if last.starts_with('.') || last == "STOP" || matches!(extension, "new" | "tmp" | "part") {
        return Growth::Never;
    }
    match extension {
        "restart" if !name.contains('/') => Growth::Checkpoint,
        "arrow" if !last.ends_with(".surfaces.arrow") && !last.ends_with(".clumps.arrow") => {
            Growth::Frames
        }
        "ene" | "csv" | "data" | "fstat" | "stat" | "fields" | "jsonl" => Growth::Lines,
        _ => Growth::Whole,
    }
}

/// Whether two runs of one scene may differ in this file: it holds times of the clock, or how often the run was interrupted.
pub fn may_differ(name: &str) -> bool {
    let last = name.rsplit('/').next().unwrap_or(name);
    last == "run.log"
        || last == "summary.json"
        || last == "plan.toml"
        || growth(name) == Growth::Checkpoint
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkpoint_lies_in_a_folder_with_the_id_of_its_run() {
        let run = "0123456789abcdef0123456789abcdef";
        assert_eq!(check_input(&format!("{run}/drum.0.restart")), Ok(()));
        assert_eq!(check_input("drum.toml"), Ok(()));
        for name in [
            "/x",
            "a/b",
            &format!("{run}/../x"),
            &format!("{run}/a/b"),
            &format!("{run}/"),
            &format!("../{run}/x"),
        ] {
            assert!(check_input(name).is_err(), "{name}");
        }
    }

    #[test]
    fn texts_have_no_control_characters() {
        for text in ["", "Drum, 3 rad/s", "Trommel \u{fc}", &"x".repeat(200)] {
            assert_eq!(check_text(text), Ok(()), "{text}");
        }
        for text in ["a\nb", "\u{1b}[2J", "\0", "\u{85}", "\u{7f}"] {
            assert_eq!(check_text(text), Err(BadText::Control), "{text:?}");
        }
        assert_eq!(check_text(&"x".repeat(201)), Err(BadText::Length));
    }

    #[test]
    fn names_that_lead_elsewhere_are_refused() {
        for name in ["scene.toml", "a-b_c.stl", "0", &"x".repeat(100)] {
            assert_eq!(check_name(name), Ok(()), "{name}");
        }
        for name in [
            "",
            "..",
            ".lock",
            "a/b",
            "/etc/passwd",
            "a\\b",
            "a\0",
            "a b",
            "ü",
            "<img onerror=x>",
            "-rf",
        ] {
            assert!(check_name(name).is_err(), "{name}");
        }
        assert!(check_name(&"x".repeat(101)).is_err());
    }

    #[test]
    fn growth_follows_from_the_name() {
        assert_eq!(growth("drum.particles.arrow"), Growth::Frames);
        assert_eq!(growth("drum.surfaces.arrow"), Growth::Whole);
        assert_eq!(growth("drum.ene"), Growth::Lines);
        assert_eq!(growth("drum.chain.jsonl"), Growth::Lines);
        assert_eq!(growth("run.log"), Growth::Whole);
        assert_eq!(growth("png/drum.0001.png"), Growth::Whole);
        assert_eq!(growth("drum.0.restart"), Growth::Checkpoint);
        assert_eq!(growth("drum.checkpoints/480.restart"), Growth::Whole);
        assert_eq!(growth(".lock"), Growth::Never);
        assert_eq!(growth("drum.particles.arrow.new"), Growth::Never);
    }
}
