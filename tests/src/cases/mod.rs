//! The table of contact cases: numbers from theory or independent codes, and the same numbers from the solver.
//!
//! A row names its case (T1 to T24, by the physics it tests), what is measured, the expected value, how near the solver must
//! come and why that is fair (the tolerances are derived beside the rows). *law* in a name: one law was evaluated on its own;
//! *engine*: the whole engine ran the scene. Each row is a test of its own (`cargo test -p tests --test validation`); the validation page prints them.

mod bonds;
mod collision;
mod decay;
mod dry;
mod first_impacts;
mod friction;
mod golden;
mod hertz;
pub(crate) mod impact;
mod integrator;
mod membranes;
mod mesh;
mod mindlin_paths;
mod mixing;
mod normal;
pub(crate) mod oblique;
mod sheets_alone;
mod slope;
mod squeezed;
mod three_beads;
mod wear;
mod wet;
mod wet_pairs;

pub(crate) use collision::lag;

/// How near a measured value must come to the expected one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// |measured/expected − 1| at most this.
    Relative(f64),
    /// |measured − expected| at most this, in the unit of the value.
    Absolute(f64),
    /// The expected value is known to so many digits: one unit of the last one.
    Digit(f64),
}

impl Tolerance {
    /// The largest difference allowed from `expected`, in its unit.
    pub fn allowed(self, expected: f64) -> f64 {
        match self {
            Self::Relative(share) => share * expected.abs(),
            Self::Absolute(difference) | Self::Digit(difference) => difference,
        }
    }
}

/// One row of the table.
pub struct Case {
    /// Unique: the case, *law* or *engine*, and the quantity with its unit.
    pub name: String,
    /// Value of the theory or of another code, SI units.
    pub expected: f64,
    /// How near the solver must come.
    pub tolerance: Tolerance,
    /// Computes the value with the solver.
    pub measured: Box<dyn Fn() -> f64 + Send + Sync>,
    /// Where the expected value comes from.
    pub source: &'static str,
}

/// The outcome of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Its name.
    pub name: String,
    /// Expected value.
    pub expected: f64,
    /// Value of the solver.
    pub measured: f64,
    /// Largest difference allowed.
    pub allowed: f64,
    /// Where the expected value comes from.
    pub source: &'static str,
}

impl Outcome {
    /// Whether the difference is allowed; not-a-number never is.
    pub fn holds(&self) -> bool {
        (self.measured - self.expected).abs() <= self.allowed
    }

    /// The difference over the largest one allowed: at most 1 where it holds, infinite for not-a-number.
    pub fn share(&self) -> f64 {
        let difference = (self.measured - self.expected).abs();
        if difference == 0.0 {
            0.0
        } else if difference.is_nan() {
            f64::INFINITY
        } else {
            difference / self.allowed
        }
    }
}

impl Case {
    /// A row.
    pub fn new(
        name: impl Into<String>,
        expected: f64,
        tolerance: Tolerance,
        source: &'static str,
        measured: impl Fn() -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            expected,
            tolerance,
            measured: Box::new(measured),
            source,
        }
    }

    /// Computes the value with the solver and compares.
    pub fn run(&self) -> Outcome {
        Outcome {
            name: self.name.clone(),
            expected: self.expected,
            measured: (self.measured)(),
            allowed: self.tolerance.allowed(self.expected),
            source: self.source,
        }
    }
}

/// The whole table.
pub fn all() -> Vec<Case> {
    let mut cases = normal::cases();
    cases.extend(hertz::cases());
    cases.extend(integrator::cases());
    cases.extend(golden::cases());
    cases.extend(friction::cases());
    cases.extend(slope::cases());
    cases.extend(squeezed::cases());
    cases.extend(mindlin_paths::cases());
    cases.extend(mixing::cases());
    cases.extend(mesh::cases());
    cases.extend(oblique::cases());
    cases.extend(first_impacts::cases());
    cases.extend(decay::cases());
    cases.extend(three_beads::cases());
    cases.extend(wear::cases());
    cases.extend(sheets_alone::cases());
    cases.extend(membranes::cases());
    cases.extend(wet::cases());
    cases.extend(wet_pairs::cases());
    cases.extend(dry::cases());
    cases.extend(bonds::cases());
    cases
}
