//! A sample against a distribution that is fully known.

use mercury_common::sizes::{SizeDistribution, Weighted, Weighting};

use super::bands::VolumeBand;
use crate::sample::Sample;
use crate::special::{anderson_darling_tail, kolmogorov_tail};

/// Sizes may lie outside the target by this share of the size: what writing a file and the volume of clumps rounds.
const ROUND_OFF: f64 = 1e-9;
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
    /// Largest distance of the cumulative numbers; none where the target has one size only. Where it has several single sizes, p is an
    /// upper bound (Noether 1963, Statistica Neerlandica 17, 41).
    pub kolmogorov: Option<Statistic>,
    /// A^2: the squared distance, weighted so that both ends count; none where the target has single sizes.
    pub anderson_darling: Option<Statistic>,
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
        let n = sample.len();
        let (kolmogorov, anderson_darling) = if target.has_single_sizes() {
            let distance = distance_with_steps(sample, &by_number);
            let has_several = target.smallest() < target.largest();
            (has_several.then_some(distance), None)
        } else {
            let shares = shares(sample, &by_number);
            let value = anderson_darling(&shares);
            let p = anderson_darling_tail(value, n);
            (Some(kolmogorov(&shares)), Some(Statistic { value, p }))
        };
        let volume_distance = volume_distance(sample, &target.by(Weighting::Volume));
        Self {
            number: n,
            outside,
            kolmogorov: kolmogorov.map(|value| Statistic {
                value,
                p: kolmogorov_tail(value, n),
            }),
            anderson_darling,
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

/// Kolmogorov's distance from a target whose cumulative shares have steps: on both sides of each size, with room for round-off.
fn distance_with_steps(sample: &Sample, target: &Weighted) -> f64 {
    let n = sample.len() as f64;
    let at = |d: f64| {
        let smaller = sample.diameters().partition_point(|&size| size <= d);
        (smaller as f64 / n - target.cdf(d)).abs()
    };
    let sides = [1.0 - 2.0 * ROUND_OFF, 1.0 + 2.0 * ROUND_OFF];
    let sizes = sample.diameters().iter();
    sizes
        .flat_map(|d| sides.map(|side| at(d * side)))
        .fold(0.0, f64::max)
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
