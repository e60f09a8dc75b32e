//! Passed or not, and why.

use mercury_common::sizes::{SizeDistribution, Weighting};

use super::bands::fewest;
use super::goodness::Goodness;
use crate::sample::Sample;

/// Criterion of a verdict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Criterion {
    /// The tests, at this level: a good sample fails with at most this probability.
    Level(f64),
    /// d10, d50 and d90 by number and by volume may differ from the target by this share. For samples so large that any
    /// difference is significant.
    Tolerance(f64),
}

/// Passed, failed, or neither.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finding {
    /// Nothing speaks against the target, and a sample of that number could have.
    Passed,
    /// The sample is not one of the target.
    Failed,
    /// Nothing speaks against the target, as there are too few particles.
    Undetermined,
}

impl Finding {
    /// For reports.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "PASSED",
            Self::Failed => "FAILED",
            Self::Undetermined => "UNDETERMINED",
        }
    }
}

/// Result of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Finding of the check.
    pub finding: Finding,
    /// Why not, or by what.
    pub reasons: Vec<String>,
}

impl Verdict {
    /// Judges a sample against its target.
    ///
    /// Verdict by level: the smallest p of the tests is compared with the level over their number (Bonferroni), so that several
    /// tests do not fail more good samples. Where none rejects but there are [`fewest`] particles or less, they prove nothing;
    /// but for targets of one size, of which each particle is right or wrong.
    #[must_use]
    pub fn of(
        goodness: &Goodness,
        sample: &Sample,
        target: &SizeDistribution,
        criterion: Criterion,
    ) -> Self {
        let mut reasons = Vec::new();
        let outside = goodness.outside;
        for (count, what) in [
            (outside.below, "smaller than the smallest"),
            (outside.above, "larger than the largest"),
        ] {
            if count > 0 {
                let (particles, are) = if count == 1 {
                    ("particle", "is")
                } else {
                    ("particles", "are")
                };
                reasons.push(format!("{count} {particles} {are} {what} of the target"));
            }
        }
        match criterion {
            Criterion::Level(level) => reasons.extend(by_tests(goodness, level)),
            Criterion::Tolerance(tolerance) => {
                reasons.extend(by_deciles(sample, target, tolerance))
            }
        }
        if !reasons.is_empty() {
            let finding = Finding::Failed;
            return Self { finding, reasons };
        }
        let number = sample.len();
        let has_one_size = target.smallest() == target.largest();
        if let Criterion::Level(level) = criterion
            && number < fewest(level)
            && !has_one_size
        {
            return Self {
                finding: Finding::Undetermined,
                reasons: vec![too_few(&number.to_string(), level)],
            };
        }
        reasons.push(match criterion {
            Criterion::Level(_) if tests(goodness).next().is_none() => {
                "all sizes are those of the target".to_owned()
            }
            Criterion::Level(level) => format!("no test rejects at level {level}"),
            Criterion::Tolerance(tolerance) => {
                format!(
                    "d10, d50 and d90 are within {} % of the target",
                    percent(tolerance)
                )
            }
        });
        Self {
            finding: Finding::Passed,
            reasons,
        }
    }

    /// Whether the sample passed.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.finding == Finding::Passed
    }
}

/// Why so few particles (`counted`, in words) show nothing.
pub(crate) fn too_few(counted: &str, level: f64) -> String {
    format!(
        "too few particles ({counted}): with fewer than {} not even the median has an interval at level {level}",
        fewest(level)
    )
}

fn percent(share: f64) -> String {
    format!("{:.3}", 100.0 * share)
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}

fn tests(goodness: &Goodness) -> impl Iterator<Item = (&'static str, f64)> {
    [
        ("Kolmogorov-Smirnov", goodness.kolmogorov),
        ("Anderson-Darling", goodness.anderson_darling),
    ]
    .into_iter()
    .filter_map(|(name, statistic)| Some((name, statistic?.p)))
}

fn by_tests(goodness: &Goodness, level: f64) -> Vec<String> {
    let count = tests(goodness).count() as f64;
    tests(goodness)
        .filter(|(_, p)| *p < level / count)
        .map(|(name, p)| format!("{name} rejects: p = {p:.2e} is below {level} / {count} tests"))
        .collect()
}

fn by_deciles(sample: &Sample, target: &SizeDistribution, tolerance: f64) -> Vec<String> {
    let mut reasons = Vec::new();
    for weighting in [Weighting::Number, Weighting::Volume] {
        let view = target.by(weighting);
        for (name, u) in [("d10", 0.1), ("d50", 0.5), ("d90", 0.9)] {
            let (got, wanted) = (sample.quantile(weighting, u), view.quantile(u));
            let off = got / wanted - 1.0;
            if off.abs() > tolerance {
                reasons.push(format!(
                    "{name} by {} is off by {} %, more than {} %",
                    weighting.word(),
                    percent(off),
                    percent(tolerance)
                ));
            }
        }
    }
    reasons
}
