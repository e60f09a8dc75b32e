//! Scenes that run for minutes: what other programs say of them, and what our solver gives.
//!
//! They are the drum and the penetration of the open-source benchmark (Dosta et al. 2024, Comput. Phys. Commun. 296, 109066), whose
//! scenes and particles are not part of the project. The page is `docs/validation-long.md`; a check on the frozen list that
//! no longer runs is an error, as in [`crate::validation`].

mod drum;
mod page;
mod penetration;
mod runs;

use std::path::Path;

use anyhow::Result;

use crate::cases::Outcome;
use crate::validation::compare_names;

/// Names of all checks, one in each line.
const FROZEN: &str = include_str!("long/checks.txt");

/// What the long scenes gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    penetration: penetration::Found,
    drum: drum::Found,
}

/// Runs the scenes into folders below `runs`, or takes the finished runs that are there, and evaluates them.
///
/// # Errors
/// If a scene is missing or fails, its files cannot be read, or a check has vanished or is not on the frozen list.
pub fn run(runs: &Path) -> Result<Results> {
    // Later the intruder only flies.
    let end = [format!("time.end={}", penetration::END)];
    let results = Results {
        drum: drum::evaluate(&runs::finished("drum-soft", "drum-soft", &[], runs)?)?,
        penetration: penetration::evaluate(
            &runs::finished("penetration-25k", "penetration-25k", &end, runs)?,
            &penetration::SHIFTS
                .iter()
                .enumerate()
                .map(|(k, &shift)| {
                    let name = format!("penetration-shot-{k}");
                    runs::finished("penetration-25k", &name, &penetration::shot(shift), runs)
                })
                .collect::<Result<Vec<_>>>()?,
        )?,
    };
    let names: Vec<&str> = results.outcomes().map(|row| row.name.as_str()).collect();
    compare_names(&names, FROZEN)?;
    Ok(results)
}

impl Results {
    fn outcomes(&self) -> impl Iterator<Item = &Outcome> {
        self.penetration.checks.iter().chain(&self.drum.checks)
    }

    /// Names of the checks that fail.
    #[must_use]
    pub fn failed(&self) -> Vec<&str> {
        let rows = self.outcomes().filter(|row| !row.holds());
        rows.map(|row| row.name.as_str()).collect()
    }
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
