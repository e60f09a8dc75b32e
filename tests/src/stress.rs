//! Numerical stability under stress: scenes of `scenes/stress/` with what theory expects of them.
//!
//! Each case runs at two lengths: the long one, of minutes, writes `docs/stability.md` (`src/bin/stress.rs`), the short one, of a tenth of a second or so, runs
//! with the tests. A check on the frozen list that no longer runs is an error.

mod collisions;
mod energy_walk;
mod gases;
mod order;
pub mod page;
mod piles;
mod refusals;
mod shear;
mod spin;
mod stage;
mod steps;
mod three_beads;

use std::time::Instant;

use anyhow::{Context, Result};

use crate::validation::compare_names;

/// Names of all checks, one in each line.
const FROZEN: &str = include_str!("stress/checks.txt");

/// Length of the cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Length {
    /// For tests.
    Short,
    /// As in the scenes.
    Long,
}

impl Length {
    /// One of two numbers.
    fn pick<T>(self, short: T, long: T) -> T {
        match self {
            Self::Short => short,
            Self::Long => long,
        }
    }
}

/// Measured value beside that of the theory.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Name of the value.
    pub name: String,
    /// Expected value.
    pub expected: String,
    /// Measured value.
    pub measured: String,
    /// Where the expectation comes from.
    pub source: &'static str,
    /// Whether it is met.
    pub holds: bool,
}

impl Check {
    /// A number that lies between two others.
    fn within(
        name: impl Into<String>,
        [low, high]: [f64; 2],
        measured: f64,
        source: &'static str,
    ) -> Self {
        Self {
            name: name.into(),
            expected: format!("{} to {}", shown(low), shown(high)),
            measured: shown(measured),
            source,
            holds: (low..=high).contains(&measured),
        }
    }

    /// A size that is at most so much.
    fn at_most(name: impl Into<String>, bound: f64, measured: f64, source: &'static str) -> Self {
        Self {
            name: name.into(),
            expected: format!("at most {}", shown(bound)),
            measured: shown(measured),
            source,
            holds: measured.abs() <= bound,
        }
    }

    /// A whole number.
    fn exactly(
        name: impl Into<String>,
        expected: u64,
        measured: u64,
        source: &'static str,
    ) -> Self {
        Self {
            name: name.into(),
            expected: expected.to_string(),
            measured: measured.to_string(),
            source,
            holds: measured == expected,
        }
    }

    /// A message in which all these words occur.
    fn says(name: impl Into<String>, words: &[&str], message: &str, source: &'static str) -> Self {
        Self {
            name: name.into(),
            expected: format!("\"{}\"", words.join("\", \"")),
            measured: message.trim().replace('\n', "; "),
            source,
            holds: words.iter().all(|word| message.contains(word)),
        }
    }
}

/// A number in four digits.
fn shown(number: f64) -> String {
    match number.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e5).contains(&size) => {
            let text = format!("{number:.4}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        _ => format!("{number:.3e}"),
    }
}

/// Results of a case.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    /// Its checks.
    pub checks: Vec<Check>,
    /// Particles of its largest run.
    pub particles: usize,
    /// Steps of all its runs.
    pub steps: u64,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

/// A scene under stress.
pub struct Case {
    /// Name of the scene's file.
    pub scene: &'static str,
    /// Part of the solver that is stressed.
    pub what: &'static str,
    run: fn(Length) -> Result<Found>,
}

/// A case that ran.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Name of the scene's file.
    pub scene: &'static str,
    /// Part of the solver that is stressed.
    pub what: &'static str,
    /// Results of the case.
    pub found: Found,
    /// Time by the clock, s.
    pub seconds: f64,
}

/// All cases, in the order of the page.
pub const CASES: &[Case] = &[
    Case {
        scene: "elastic-gas",
        what: "1e7 steps of an elastic gas, linear springs: does the energy drift?",
        run: gases::linear,
    },
    Case {
        scene: "elastic-gas-hertz",
        what: "the same with Hertz contacts",
        run: gases::hertz,
    },
    Case {
        scene: "resting-pile",
        what: "1e6 steps of a pile at rest: does it creep or heat up, where does its kinetic energy end?",
        run: piles::at_the_origin,
    },
    Case {
        scene: "far-box",
        what: "the pile a million diameters from the origin, and the gas; farther away",
        run: piles::far_away,
    },
    Case {
        scene: "size-ratio",
        what: "size ratio 1000: one among 200",
        run: collisions::size_ratio,
    },
    Case {
        scene: "mass-ratio",
        what: "mass ratio 1e6: the heavy one stands on the light one, undamped, for 1e6 steps",
        run: piles::mass_ratio,
    },
    Case {
        scene: "mass-ratio-impact",
        what: "mass ratio 1e6: impact",
        run: collisions::mass_ratio,
    },
    Case {
        scene: "stiffness-ratio",
        what: "stiffness ratio 1e6 in one elastic gas",
        run: gases::stiffness_ratio,
    },
    Case {
        scene: "time-steps",
        what: "steps from 0.001 to 0.9 of the critical one, in a crystal: what fails, and is it caught?",
        run: steps::crystal,
    },
    Case {
        scene: "overlaps",
        what: "overlaps of 30 % at the start",
        run: collisions::overlaps,
    },
    Case {
        scene: "one-point",
        what: "4,000 spheres in one point",
        run: refusals::one_point,
    },
    Case {
        scene: "lattice",
        what: "aligned lattice: ties in cells, contacts and walls",
        run: order::lattice,
    },
    Case {
        scene: "grazing",
        what: "contacts that graze, down to an overlap of nothing",
        run: collisions::grazing,
    },
    Case {
        scene: "spin",
        what: "a million radians a second: sliding, and one radian in each step",
        run: spin::spheres,
    },
    Case {
        scene: "spin-clump",
        what: "a clump that tumbles with a million radians a second",
        run: spin::clump,
    },
    Case {
        scene: "dense-shear",
        what: "1e6 steps of dense shear with friction",
        run: shear::dense,
    },
    Case {
        scene: "denormals",
        what: "denormal numbers, and numbers beyond the range",
        run: refusals::denormals,
    },
    Case {
        scene: "three-beads",
        what: "a grain on two beads 20 times its size: does friction glue it into their groove?",
        run: three_beads::groove,
    },
];

impl Case {
    /// Runs it.
    ///
    /// # Errors
    /// If the scene is missing, or cannot be run where it should.
    pub fn run(&self, length: Length) -> Result<Outcome> {
        let begun = Instant::now();
        let found = (self.run)(length).with_context(|| self.scene.to_owned())?;
        Ok(Outcome {
            scene: self.scene,
            what: self.what,
            found,
            seconds: begun.elapsed().as_secs_f64(),
        })
    }
}

impl Outcome {
    /// Its checks that are not met, with their names as the frozen list has them.
    pub fn failed(&self) -> impl Iterator<Item = (String, &Check)> {
        let checks = self.found.checks.iter().filter(|check| !check.holds);
        checks.map(|check| (format!("{}: {}", self.scene, check.name), check))
    }
}

/// Names of all checks, as the frozen list has them.
#[must_use]
pub fn names(outcomes: &[Outcome]) -> Vec<String> {
    let of_case = |case: &Outcome| {
        let checks = case.found.checks.iter();
        let names = checks.map(|check| format!("{}: {}", case.scene, check.name));
        names.collect::<Vec<_>>()
    };
    outcomes.iter().flat_map(of_case).collect()
}

/// Whether the checks are those of the frozen list.
///
/// # Errors
/// Names those that have vanished or are not on the list.
pub fn compare_with_list(outcomes: &[Outcome]) -> Result<()> {
    let names = names(outcomes);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    compare_names(&names, FROZEN)
}
