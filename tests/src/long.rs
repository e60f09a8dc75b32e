//! Scenes that run for minutes: values of theory or other programs, and those of our solver.
//!
//! Each subject is run by itself. The page is `docs/validation-long.md` with a table of all checks beside it; the sections of subjects
//! that are not run stay as they are. A check on the frozen list that no longer runs is an error, as in [`crate::validation`].

mod chute;
mod drum;
mod fits;
mod haff;
mod hopper;
mod janssen;
mod page;
mod penetration;
mod repose;
mod runs;

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Result, anyhow, ensure};
use mercury_pictures::charts::ChartPage;
use mercury_solver::plan::{Plan, plan, read_scene};

use crate::cases::Outcome;
use crate::validation::compare_names;
pub use page::Page;

/// Names of all checks, one in each line; each begins with the key of its subject.
const FROZEN: &str = include_str!("long/checks.txt");

/// Results of a subject.
#[derive(Debug, Clone, PartialEq)]
pub struct Reported {
    checks: Vec<Outcome>,
    /// Below the table of its checks.
    text: String,
    /// Names of the files, and the pictures.
    pictures: Vec<(&'static str, ChartPage)>,
}

/// A subject of the page.
pub struct Subject {
    /// Key of the subject, with which the names of its checks begin.
    pub key: &'static str,
    /// Its heading.
    pub title: &'static str,
    tell: fn(&Path) -> Result<Reported>,
}

/// All subjects, in the order of the page.
pub const SUBJECTS: [Subject; 7] = [
    Subject {
        key: "haff",
        title: "Gases that cool",
        tell: haff::tell,
    },
    Subject {
        key: "janssen",
        title: "A silo with friction at its walls",
        tell: janssen::tell,
    },
    Subject {
        key: "repose",
        title: "Angle of repose",
        tell: repose::tell,
    },
    Subject {
        key: "hopper-psd",
        title: "A hopper discharges",
        tell: hopper::tell,
    },
    Subject {
        key: "chute",
        title: "Profiles of a chute",
        tell: chute::tell,
    },
    Subject {
        key: "penetration-25k",
        title: "A sphere is shot into a bed",
        tell: penetration::tell,
    },
    Subject {
        key: "drum-soft",
        title: "Two sizes in a drum",
        tell: drum::tell,
    },
];

/// The subjects with these keys; all if there are no keys, no subject for `none`: the page is then only written anew.
///
/// # Errors
/// If there is no such subject.
pub fn chosen(keys: &[String]) -> Result<Vec<&'static Subject>> {
    for key in keys {
        ensure!(
            key == "none" || SUBJECTS.iter().any(|subject| subject.key == key),
            "there is no subject {key}\nhelp: one of {}",
            SUBJECTS.map(|subject| subject.key).join(", ")
        );
    }
    let all = SUBJECTS.iter();
    Ok(all
        .filter(|subject| keys.is_empty() || keys.iter().any(|key| key == subject.key))
        .collect())
}

/// Runs a subject in folders below `runs`, or takes the finished runs that are there, and draws its pictures into `pictures`.
///
/// # Errors
/// If a scene is missing or fails, its files cannot be read, or a check has vanished or is not on the frozen list.
pub fn run(subject: &Subject, runs: &Path, pictures: &Path) -> Result<Reported> {
    let reported = (subject.tell)(runs)?;
    let names: Vec<&str> = reported
        .checks
        .iter()
        .map(|row| row.name.as_str())
        .collect();
    let prefix = format!("{}: ", subject.key);
    let frozen: BTreeSet<&str> = FROZEN.lines().filter(|n| n.starts_with(&prefix)).collect();
    let frozen: Vec<&str> = frozen.into_iter().collect();
    compare_names(&names, &frozen.join("\n"))?;
    std::fs::create_dir_all(pictures)?;
    for (name, picture) in &reported.pictures {
        picture.write_svg(&pictures.join(name))?;
    }
    Ok(reported)
}

/// The plan of a scene below `tests/scenes/long`, with `KEY=VALUE` put on top.
fn small_scene(name: &str, overrides: &[String]) -> Result<Plan> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes/long")
        .join(format!("{name}.toml"));
    let scene = read_scene(&path, overrides).map_err(|e| anyhow!("{e}"))?;
    plan(&scene).map_err(|e| anyhow!("{e}"))
}

/// A measured value beside the expected one.
fn outcome(
    name: &str,
    expected: f64,
    measured: f64,
    allowed: f64,
    source: &'static str,
) -> Outcome {
    Outcome {
        name: name.to_owned(),
        expected,
        measured,
        allowed,
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frozen_check_belongs_to_a_subject_and_every_small_scene_is_right() {
        for name in FROZEN.lines() {
            let belongs = |s: &Subject| name.starts_with(&format!("{}: ", s.key));
            assert!(SUBJECTS.iter().any(belongs), "{name}");
        }
        for name in ["haff", "janssen", "repose"] {
            small_scene(name, &[]).unwrap();
        }
        let message = |keys: &[&str]| {
            let keys: Vec<String> = keys.iter().map(|k| (*k).to_owned()).collect();
            chosen(&keys)
                .map(|found| found.len())
                .map_err(|e| e.to_string())
        };
        assert_eq!(message(&[]), Ok(SUBJECTS.len()));
        assert_eq!(message(&["haff"]), Ok(1));
        assert_eq!(message(&["none"]), Ok(0));
        assert!(message(&["half"]).unwrap_err().contains("haff, janssen"));
    }
}
