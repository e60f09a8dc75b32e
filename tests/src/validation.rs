//! The validation page: values of theory and of other programs, and those of our solver.
//!
//! [`run`] computes the results with the solver, [`page`] writes them down, [`charts`] draws some of them. A check whose name is
//! on the frozen list but that no longer runs is an error.

pub mod charts;
pub mod page;
mod subjects;

use std::collections::BTreeSet;

use anyhow::{Context, Result, ensure};

use crate::cases::{self, Outcome};
use crate::published::Published;
use crate::scene_checks;
use crate::selftests::{self, Comparison, Data};
use crate::shapes::{self, Shapes};

/// Names of all checks but the contact cases, one in each line.
const FROZEN: &str = include_str!("validation/checks.txt");
/// Names of all contact cases.
const FROZEN_CASES: &str = include_str!("../tests/validation/contact_cases.txt");

/// All results.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// Contact cases.
    pub cases: Vec<Outcome>,
    /// Scenes of the project.
    pub scenes: Vec<Outcome>,
    /// Bodies from reference shapes.
    pub shapes: Vec<Outcome>,
    /// Published cases of the field.
    pub published: Vec<Outcome>,
    /// Self tests of MercuryDPM and the packing that other programs run too.
    pub comparisons: Vec<Comparison>,
}

impl Results {
    /// Number of checks, and of those that fail.
    #[must_use]
    pub fn count(&self) -> (usize, usize) {
        let failed = self.outcomes().filter(|outcome| !outcome.holds()).count()
            + self.comparisons.iter().filter(|c| !c.holds()).count();
        (self.outcomes().count() + self.comparisons.len(), failed)
    }

    /// All checks of one number.
    pub(crate) fn outcomes(&self) -> impl Iterator<Item = &Outcome> {
        let outcomes = self.cases.iter().chain(&self.scenes);
        outcomes.chain(&self.shapes).chain(&self.published)
    }
}

/// Runs every check.
///
/// # Errors
/// If the reference data are missing, a comparison cannot be made, or a check has vanished or is new and not on the frozen list.
pub fn run() -> Result<Results> {
    let data = Data::find().context("the reference data of the self tests are not installed")?;
    let shapes = Shapes::find().context("the reference shapes are not installed")?;
    let published = Published::find().context("the published curves are not installed")?;
    let outcomes = |cases: Vec<cases::Case>| cases.iter().map(cases::Case::run).collect();
    let mut comparisons = vec![selftests::energy_of_a_packing()?];
    for set_up in selftests::ALL {
        comparisons.push((set_up.run)(&data).with_context(|| format!("set-up {}", set_up.number))?);
    }
    let results = Results {
        cases: outcomes(cases::all()),
        scenes: outcomes(scene_checks::all()),
        shapes: outcomes(shapes::all(&shapes)),
        published: outcomes(published.all()?),
        comparisons,
    };
    let outcomes = results.scenes.iter().chain(&results.shapes);
    let outcomes = outcomes.chain(&results.published);
    let mut names: Vec<&str> = outcomes.map(|row| row.name.as_str()).collect();
    names.extend(results.comparisons.iter().map(|comparison| comparison.name));
    compare_names(&names, FROZEN)?;
    let names: Vec<&str> = results
        .cases
        .iter()
        .map(|case| case.name.as_str())
        .collect();
    compare_names(&names, FROZEN_CASES)?;
    Ok(results)
}

/// Whether the checks are those of a frozen list.
pub(crate) fn compare_names(names: &[&str], frozen: &str) -> Result<()> {
    let present: BTreeSet<&str> = names.iter().copied().collect();
    ensure!(present.len() == names.len(), "a name stands for two checks");
    let frozen: BTreeSet<&str> = frozen.lines().collect();
    let vanished: Vec<_> = frozen.difference(&present).collect();
    ensure!(vanished.is_empty(), "checks have vanished: {vanished:#?}");
    let unlisted: Vec<_> = present.difference(&frozen).collect();
    ensure!(
        unlisted.is_empty(),
        "checks that are not on the frozen list: {unlisted:#?}"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::compare_names;

    #[test]
    fn vanished_new_and_doubled_checks_are_errors() {
        assert!(compare_names(&["a", "b"], "a\nb\n").is_ok());
        let message = |names: &[&str]| compare_names(names, "a\nb").unwrap_err().to_string();
        assert!(message(&["a"]).contains("vanished"));
        assert!(message(&["a", "b", "c"]).contains("not on the frozen list"));
        assert!(message(&["a", "a"]).contains("two"));
    }
}
