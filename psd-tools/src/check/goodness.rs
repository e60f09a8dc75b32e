//! A sample against a distribution that is fully known.

use mercury_common::sizes::{SizeDistribution, Weighted, Weighting};

use super::bands::VolumeBand;
use crate::sample::Sample;
use crate::special::{
    anderson_darling_tail, chi_square_tail, cramer_von_mises_tail, kolmogorov_tail,
};

/// Sizes may lie outside the target by this share of the size: what writing a file and the volume of clumps rounds.
const ROUND_OFF: f64 = 1e-9;
/// Classes are merged until this many particles are expected in each.
const LEAST_EXPECTED: f64 = 5.0;
/// Points of the rule for the Wasserstein distance, where the sample has fewer or more particles.
const QUANTILE_POINTS: [usize; 2] = [4096, 200_000];

/// A statistic and the probability of one at least as large if the sample is of the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistic {
    /// Its value.
    pub value: f64,
    /// The p-value.
    pub p: f64,
}

/// Counts in one class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClassCount {
    /// Bounds, m.
    pub low: f64,
    /// Bounds, m.
    pub high: f64,
    /// Particles there.
    pub observed: usize,
    /// Particles expected.
    pub expected: f64,
}

impl ClassCount {
    /// (observed - expected) over the binomial standard deviation: within +-2 in 95 % of classes.
    #[must_use]
    pub fn residual(&self, total: usize) -> f64 {
        let p = self.expected / total as f64;
        (self.observed as f64 - self.expected) / (self.expected * (1.0 - p)).sqrt()
    }
}

/// Pearson's test on classes.
#[derive(Debug, Clone, PartialEq)]
pub struct ChiSquare {
    /// Sum of (observed - expected)^2 / expected, and its p.
    pub statistic: Statistic,
    /// Classes - 1.
    pub degrees: usize,
    /// The classes, merged until each is expected to hold five particles.
    pub classes: Vec<ClassCount>,
    /// The same sum over the classes as they were.
    pub unmerged: Unmerged,
}

/// Pearson's sum over all classes, also those in which hardly a particle is expected. As others print it; its law is not that of
/// chi-square, so that nothing follows from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unmerged {
    /// Sum of (observed - expected)^2 / expected.
    pub value: f64,
    /// Classes - 1.
    pub degrees: usize,
}

/// Particles of sizes that the target does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outside {
    /// Smaller than its smallest.
    pub below: usize,
    /// Larger than its largest.
    pub above: usize,
}

/// A sample against its target.
#[derive(Debug, Clone, PartialEq)]
pub struct Goodness {
    /// Particles.
    pub number: usize,
    /// Sizes that the target does not have.
    pub outside: Outside,
    /// Largest distance of the cumulative numbers; none where the target has single sizes, as for the next two.
    pub kolmogorov: Option<Statistic>,
    /// A^2: the squared distance, weighted so that both ends count.
    pub anderson_darling: Option<Statistic>,
    /// W^2: the squared distance.
    pub cramer_von_mises: Option<Statistic>,
    /// Counts in classes; none for so few particles that there is but one class.
    pub chi_square: Option<ChiSquare>,
    /// Mean distance of equal quantiles, m: how far a particle is from its place.
    pub wasserstein: f64,
    /// Largest distance of the cumulative volumes.
    pub volume_distance: f64,
    /// The volume's band and how often random samples deviate as much.
    pub volume_band: VolumeBand,
}

impl Goodness {
    /// Tests a sample. `level` is that of the bands.
    #[must_use]
    pub fn of(sample: &Sample, target: &SizeDistribution, level: f64, seed: u64) -> Self {
        let by_number = target.by(Weighting::Number);
        let outside = outside(sample, target);
        let continuous = !target.has_single_sizes();
        let shares = shares(sample, &by_number);
        let n = sample.len();
        let statistic = |value: f64, p: f64| continuous.then_some(Statistic { value, p });
        let distance = kolmogorov(&shares);
        let anderson = anderson_darling(&shares);
        let cramer = cramer_von_mises(&shares);
        let chi_square = if continuous {
            chi_square(sample, target, &by_number)
        } else {
            single_sizes(sample, &by_number)
        };
        let volume_distance = volume_distance(sample, &target.by(Weighting::Volume));
        Self {
            number: n,
            outside,
            kolmogorov: statistic(distance, kolmogorov_tail(distance, n)),
            anderson_darling: statistic(anderson, anderson_darling_tail(anderson, n)),
            cramer_von_mises: statistic(cramer, cramer_von_mises_tail(cramer, n)),
            chi_square,
            wasserstein: wasserstein(sample, &by_number),
            volume_distance,
            volume_band: VolumeBand::of(sample, volume_distance, level, seed),
        }
    }
}

fn outside(sample: &Sample, target: &SizeDistribution) -> Outside {
    let (low, high) = (
        target.smallest() * (1.0 - ROUND_OFF),
        target.largest() * (1.0 + ROUND_OFF),
    );
    let sizes = sample.diameters();
    Outside {
        below: sizes.partition_point(|&d| d < low),
        above: sizes.len() - sizes.partition_point(|&d| d <= high),
    }
}

/// The target's cumulative share at each size of the sample; never 0 or 1, where one size within round-off of an end would make
/// A^2 infinite.
fn shares(sample: &Sample, target: &Weighted) -> Vec<f64> {
    let edge = 0.5_f64.powi(53);
    let share = |&d: &f64| target.cdf(d).clamp(edge, 1.0 - edge);
    sample.diameters().iter().map(share).collect()
}

pub(crate) fn kolmogorov(shares: &[f64]) -> f64 {
    let n = shares.len() as f64;
    let distance = |(i, &u): (usize, &f64)| ((i + 1) as f64 / n - u).max(u - i as f64 / n);
    shares.iter().enumerate().map(distance).fold(0.0, f64::max)
}

pub(crate) fn anderson_darling(shares: &[f64]) -> f64 {
    let n = shares.len() as f64;
    let sum: f64 = shares
        .iter()
        .zip(shares.iter().rev())
        .enumerate()
        .map(|(i, (low, high))| (2 * i + 1) as f64 * (libm::log(*low) + libm::log1p(-high)))
        .sum();
    -n - sum / n
}

pub(crate) fn cramer_von_mises(shares: &[f64]) -> f64 {
    let n = shares.len() as f64;
    let sum: f64 = shares
        .iter()
        .enumerate()
        .map(|(i, u)| {
            let distance = u - (i as f64 + 0.5) / n;
            distance * distance
        })
        .sum();
    1.0 / (12.0 * n) + sum
}

/// The bounds of the classes in which particles are counted: those of a measured target, else classes in which equal numbers are
/// expected (as many as Mann and Wald would take for a test at 5 %: 2 n^(2/5)).
fn class_bounds(sample: &Sample, target: &SizeDistribution, by_number: &Weighted) -> Vec<f64> {
    if let Some(classes) = target.classes() {
        return classes.edges().to_vec();
    }
    let count = (2.0 * (sample.len() as f64).powf(0.4))
        .round()
        .clamp(2.0, 200.0);
    let mut bounds: Vec<f64> = (0..=count as usize)
        .map(|i| by_number.quantile(i as f64 / count))
        .collect();
    bounds.dedup();
    bounds
}

fn chi_square(
    sample: &Sample,
    target: &SizeDistribution,
    by_number: &Weighted,
) -> Option<ChiSquare> {
    pearson(counts(sample, target, by_number), sample.len())
}

fn counts(sample: &Sample, target: &SizeDistribution, by_number: &Weighted) -> Vec<ClassCount> {
    let bounds = class_bounds(sample, target, by_number);
    let sizes = sample.diameters();
    let n = sizes.len() as f64;
    let last = bounds.len() - 2;
    let counts = bounds.windows(2).enumerate().map(|(i, class)| {
        // Sizes beyond the ends by round-off belong to the classes at the ends.
        let from = if i == 0 {
            0
        } else {
            sizes.partition_point(|&d| d <= class[0])
        };
        let to = if i == last {
            sizes.len()
        } else {
            sizes.partition_point(|&d| d <= class[1])
        };
        ClassCount {
            low: class[0],
            high: class[1],
            observed: to - from,
            expected: n * (by_number.cdf(class[1]) - by_number.cdf(class[0])),
        }
    });
    counts.collect()
}

/// The classes of a target with single sizes: those of its sizes that the sample has, and between them.
fn single_sizes(sample: &Sample, by_number: &Weighted) -> Option<ChiSquare> {
    let n = sample.len() as f64;
    let mut counts: Vec<ClassCount> = Vec::new();
    let mut from = 0;
    let sizes = sample.diameters();
    let mut below = 0.0;
    while from < sizes.len() {
        let low = sizes[from];
        let high = low * (1.0 + 2.0 * ROUND_OFF);
        let to = sizes.partition_point(|&d| d <= high);
        let share = by_number.cdf(high);
        counts.push(ClassCount {
            low,
            high,
            observed: to - from,
            expected: n * (share - below),
        });
        below = share;
        from = to;
        if counts.len() > 1000 {
            return None;
        }
    }
    pearson(counts, sizes.len())
}

/// Neighbours together until each class is expected to hold enough.
fn merged(counts: Vec<ClassCount>) -> Vec<ClassCount> {
    let mut merged: Vec<ClassCount> = Vec::new();
    let mut is_open = false;
    for count in counts {
        match merged.last_mut() {
            Some(last) if is_open => {
                last.high = count.high;
                last.observed += count.observed;
                last.expected += count.expected;
            }
            _ => merged.push(count),
        }
        is_open = merged
            .last()
            .is_some_and(|last| last.expected < LEAST_EXPECTED);
    }
    if is_open
        && merged.len() > 1
        && let Some(rest) = merged.pop()
        && let Some(last) = merged.last_mut()
    {
        last.high = rest.high;
        last.observed += rest.observed;
        last.expected += rest.expected;
    }
    merged
}

/// Pearson's sum. Classes in which nothing is expected and nothing is are no classes.
fn sum_of_squares(classes: &[ClassCount]) -> Unmerged {
    let terms = classes
        .iter()
        .filter(|class| class.expected > 0.0 || class.observed > 0)
        .map(|class| {
            let difference = class.observed as f64 - class.expected;
            difference * difference / class.expected
        });
    Unmerged {
        value: terms.clone().sum(),
        degrees: terms.count().saturating_sub(1),
    }
}

fn pearson(counts: Vec<ClassCount>, total: usize) -> Option<ChiSquare> {
    let unmerged = sum_of_squares(&counts);
    let classes = merged(counts);
    debug_assert_eq!(classes.iter().map(|c| c.observed).sum::<usize>(), total);
    let Unmerged { value, degrees } = sum_of_squares(&classes);
    (degrees > 0).then(|| ChiSquare {
        statistic: Statistic {
            value,
            p: chi_square_tail(value, degrees as f64),
        },
        degrees,
        classes,
        unmerged,
    })
}

/// The integral of the distance of the quantiles, by the midpoint rule inside the steps of the sample.
fn wasserstein(sample: &Sample, target: &Weighted) -> f64 {
    let n = sample.len();
    let [least, most] = QUANTILE_POINTS;
    let points = if n >= most {
        most
    } else {
        n * least.div_ceil(n)
    };
    let sum: f64 = (0..points)
        .map(|i| {
            let u = (i as f64 + 0.5) / points as f64;
            let at = (u * n as f64) as usize;
            (sample.diameters()[at.min(n - 1)] - target.quantile(u)).abs()
        })
        .sum();
    sum / points as f64
}

fn volume_distance(sample: &Sample, target: &Weighted) -> f64 {
    let distance = |(i, &d): (usize, &f64)| {
        let expected = target.cdf(d);
        let (before, after) = (sample.volume_share(i), sample.volume_share(i + 1));
        (expected - before).abs().max((after - expected).abs())
    };
    let sizes = sample.diameters().iter().enumerate();
    sizes.map(distance).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
