//! Two distributions or samples side by side, without any question of chance.

use mercury_common::sizes::{Weighted, Weighting};

use crate::input::Sizes;
use crate::sample::Sample;
use crate::statistics::Spectrum as _;

/// Points of the rule for the distances.
const POINTS: usize = 4096;

/// How the second differs from the first in one weighting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The weighting of the shares.
    pub weighting: Weighting,
    /// Relative change of d10, d50 and d90.
    pub deciles: [f64; 3],
    /// Largest distance of the cumulative shares.
    pub distance: f64,
    /// Mean distance of equal quantiles (Wasserstein), m.
    pub wasserstein: f64,
}

/// How the second differs from the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// In the four weightings.
    pub rows: [Row; 4],
}

/// A cumulative curve and its inverse.
enum View<'a> {
    Distribution(Weighted),
    Sample(&'a Sample, Weighting),
}

impl View<'_> {
    fn of(sizes: &Sizes, weighting: Weighting) -> View<'_> {
        match sizes {
            Sizes::Distribution(sizes, _) => View::Distribution(sizes.by(weighting)),
            Sizes::Sample(sample) => View::Sample(sample, weighting),
        }
    }

    fn cdf(&self, d: f64) -> f64 {
        match self {
            View::Distribution(view) => view.cdf(d),
            View::Sample(sample, weighting) => sample.cdf(*weighting, d),
        }
    }

    fn quantile(&self, u: f64) -> f64 {
        match self {
            View::Distribution(view) => view.quantile(u),
            View::Sample(sample, weighting) => sample.quantile(*weighting, u),
        }
    }
}

/// Compares two distributions or samples.
#[must_use]
pub fn compare(first: &Sizes, second: &Sizes) -> Comparison {
    let rows = Weighting::ALL.map(|weighting| {
        let (a, b) = (View::of(first, weighting), View::of(second, weighting));
        let deciles = [0.1, 0.5, 0.9]
            .map(|u| second.quantile(weighting, u) / first.quantile(weighting, u) - 1.0);
        let mut wasserstein = 0.0;
        let mut distance = 0.0_f64;
        for i in 0..POINTS {
            let u = (i as f64 + 0.5) / POINTS as f64;
            let (x, y) = (a.quantile(u), b.quantile(u));
            wasserstein += (x - y).abs();
            // At the quantiles of both, which include the steps of samples to 1/POINTS.
            for d in [x, y] {
                distance = distance.max((a.cdf(d) - b.cdf(d)).abs());
            }
        }
        Row {
            weighting,
            deciles,
            distance,
            wasserstein: wasserstein / POINTS as f64,
        }
    });
    Comparison { rows }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mercury_common::sizes::{ClassModel, Classes, SizeDistribution};

    fn uniform(low: f64, high: f64) -> Sizes {
        let by = Weighting::Number;
        let classes = Classes::new(&[low, high], &[1.0], by, ClassModel::default()).unwrap();
        Sizes::Distribution(SizeDistribution::from_classes(classes, by), None)
    }

    #[test]
    fn two_uniform_laws_have_closed_distances() {
        // [1, 2] against [1.5, 2.5]: every quantile 0.5 higher; cumulative shares 0.5 apart.
        let comparison = compare(&uniform(1.0, 2.0), &uniform(1.5, 2.5));
        let row = comparison.rows[0];
        assert!((row.wasserstein - 0.5).abs() < 1e-14);
        assert!((row.distance - 0.5).abs() < 1e-3);
        assert!((row.deciles[1] - (2.0 / 1.5 - 1.0)).abs() < 1e-14);
        let same = compare(&uniform(1.0, 2.0), &uniform(1.0, 2.0));
        assert!(
            same.rows
                .iter()
                .all(|row| row.distance == 0.0 && row.wasserstein == 0.0)
        );
    }
}
