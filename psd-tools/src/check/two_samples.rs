//! Are two samples of one distribution? Two regions or two times of a run, or two runs.

use mercury_common::sizes::Weighting;

use super::bands::{Interval, fewest};
use super::goodness::Statistic;
use super::many_samples::anderson_darling_samples;
use super::verdict::Finding;
use crate::sample::Sample;
use crate::special::two_sample_kolmogorov_tail;

/// Two samples against each other.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoSamples {
    /// Particles of each.
    pub numbers: [usize; 2],
    /// Largest distance of the cumulative numbers.
    pub kolmogorov: Statistic,
    /// Anderson-Darling's A^2 of two samples, which weighs both ends; none for fewer than four particles.
    pub anderson_darling: Option<Statistic>,
    /// Mean distance of equal quantiles, m.
    pub wasserstein: f64,
    /// Largest distance of the cumulative volumes.
    pub volume_distance: f64,
    /// Second minus first of d10, d50 and d90 by number and by volume, relative to the first, with intervals.
    pub differences: Vec<(Weighting, &'static str, Interval)>,
    /// Whether sizes stand in both samples, so that the p-values are approximate.
    pub ties: bool,
}

impl TwoSamples {
    /// Compares two samples; `level` is that of the intervals.
    #[must_use]
    pub fn of(first: &Sample, second: &Sample, level: f64) -> Self {
        let (n, m) = (first.len(), second.len());
        let distance = kolmogorov(first.diameters(), second.diameters());
        let mut differences = Vec::new();
        for weighting in [Weighting::Number, Weighting::Volume] {
            for (name, u) in [("d10", 0.1), ("d50", 0.5), ("d90", 0.9)] {
                let [a, b] = [first, second].map(|s| match weighting {
                    Weighting::Volume => super::volume_interval(s, u, level),
                    _ => super::number_interval(s, u, level),
                });
                // Half widths add in squares, side by side.
                let value = (b.value - a.value) / a.value;
                let width = |one: Option<f64>, other: Option<f64>| {
                    let (one, other) = (one? - b.value, other? - a.value);
                    Some((one * one + other * other).sqrt() / a.value)
                };
                differences.push((
                    weighting,
                    name,
                    Interval {
                        value,
                        low: width(b.low, a.high).map(|width| value - width),
                        high: width(b.high, a.low).map(|width| value + width),
                    },
                ));
            }
        }
        Self {
            numbers: [n, m],
            kolmogorov: Statistic {
                value: distance,
                p: two_sample_kolmogorov_tail(distance, n, m),
            },
            anderson_darling: anderson_darling_samples(&[first.diameters(), second.diameters()]),
            wasserstein: wasserstein(first, second),
            volume_distance: volume_distance(first, second),
            differences,
            ties: have_ties(first, second),
        }
    }

    /// The tests that decide: name, letter, result.
    #[must_use]
    pub fn tests(&self) -> Vec<(&'static str, &'static str, Statistic)> {
        let mut tests = vec![("Kolmogorov-Smirnov", "D", self.kolmogorov)];
        tests.extend(
            self.anderson_darling
                .map(|test| ("Anderson-Darling", "A^2", test)),
        );
        tests
    }

    /// Whether the two are taken for samples of one distribution: no test rejects at `level` over the number of tests. Undetermined
    /// where that is so with fewer particles on either side than [`fewest`].
    #[must_use]
    pub fn finding(&self, level: f64) -> Finding {
        let tests = self.tests();
        let least = level / tests.len() as f64;
        if tests.iter().any(|(_, _, test)| test.p < least) {
            Finding::Failed
        } else if self.fewer() < fewest(level) {
            Finding::Undetermined
        } else {
            Finding::Passed
        }
    }

    /// Particles of the smaller sample.
    pub(crate) fn fewer(&self) -> usize {
        self.numbers[0].min(self.numbers[1])
    }
}

fn kolmogorov(a: &[f64], b: &[f64]) -> f64 {
    let (n, m) = (a.len() as f64, b.len() as f64);
    let (mut i, mut j, mut largest) = (0, 0, 0.0_f64);
    while i < a.len() && j < b.len() {
        let d = a[i].min(b[j]);
        while i < a.len() && a[i] <= d {
            i += 1;
        }
        while j < b.len() && b[j] <= d {
            j += 1;
        }
        largest = largest.max((i as f64 / n - j as f64 / m).abs());
    }
    largest
}

/// The sizes of both, ascending, m.
fn sorted(first: &Sample, second: &Sample) -> Vec<f64> {
    let mut all = [first.diameters(), second.diameters()].concat();
    all.sort_unstable_by(f64::total_cmp);
    all
}

fn have_ties(first: &Sample, second: &Sample) -> bool {
    sorted(first, second)
        .windows(2)
        .any(|pair| pair[0] == pair[1])
}

fn wasserstein(first: &Sample, second: &Sample) -> f64 {
    // The integral of |F - G| over the sizes of both.
    let (a, b) = (first.diameters(), second.diameters());
    let (n, m) = (a.len() as f64, b.len() as f64);
    let all = sorted(first, second);
    let (mut i, mut j, mut sum) = (0, 0, 0.0);
    for pair in all.windows(2) {
        while i < a.len() && a[i] <= pair[0] {
            i += 1;
        }
        while j < b.len() && b[j] <= pair[0] {
            j += 1;
        }
        sum += (i as f64 / n - j as f64 / m).abs() * (pair[1] - pair[0]);
    }
    sum
}

fn volume_distance(first: &Sample, second: &Sample) -> f64 {
    let sizes = first.diameters().iter().chain(second.diameters());
    let difference =
        |&d: &f64| (first.cdf(Weighting::Volume, d) - second.cdf(Weighting::Volume, d)).abs();
    sizes.map(difference).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
