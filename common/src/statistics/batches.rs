//! The error of the mean of a correlated series, by batch means.

use super::{Estimate, group_means, mean, student_t_975};

/// Fewest batches that give an error.
pub const FEWEST_BATCHES: usize = 16;

/// Number of batches that are aimed at; there are fewer than twice as many.
const BATCHES: usize = 64;

/// Bins that suffice for as many batches as more bins give: one or two of them make a batch.
pub const BATCH_BINS: usize = 2 * BATCHES;

/// Largest correlation of neighbouring batches that is put right.
const MOST_CORRELATION: f64 = 0.95;

/// Means of batches of a steady series, and the variance of its mean.
///
/// The correlation of neighbours is put right as that of an autoregressive process of first order, whose bias of about -1/k is taken off, as in
/// Skart (Tafazzoli & Wilson, *Oper. Res.* 59, 2011) and SBatch (Lada & Wilson, *INFORMS J. Comput.* 20, 2008). Student's t accounts for the fixed number of batches
/// (Glynn & Whitt, *Oper. Res. Lett.* 10, 1991).
#[derive(Debug, Clone, PartialEq)]
pub struct Batches {
    means: Vec<f64>,
    value: f64,
    /// Sum of squared distances of the batches from their mean.
    spread: f64,
    correlation: f64,
}

impl Batches {
    /// Batches of these bins; `None` from fewer than [`FEWEST_BATCHES`].
    #[must_use]
    pub fn of(bins: &[f64]) -> Option<Self> {
        let count = bins.len();
        if count < FEWEST_BATCHES {
            return None;
        }
        let means = group_means(bins, (count / BATCHES).max(1));
        let (spread, correlation) = spread_and_correlation(&means, MOST_CORRELATION);
        Some(Self {
            value: mean(bins),
            means,
            spread,
            correlation,
        })
    }

    /// Number of batches.
    #[must_use]
    pub fn count(&self) -> usize {
        self.means.len()
    }

    /// The error of the mean: one standard error. A series that never changes has error 0.
    #[must_use]
    pub fn error(&self) -> f64 {
        let count = self.means.len() as f64;
        (variance_of_a_batch(count, self.spread, self.correlation) / count).sqrt()
    }

    /// The mean of all bins, its error, its 95 % interval.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        let count = self.means.len() as f64;
        let phi = self.correlation;
        let independent = count * (1.0 - phi) / (1.0 + phi);
        let error = self.error();
        Estimate {
            value: self.value,
            error,
            half_width: student_t_975((independent - 1.0).max(2.0)) * error,
            independent,
        }
    }

    /// Difference of the means of the second and the first half of the batches.
    #[must_use]
    pub fn difference_of_halves(&self) -> f64 {
        let (first, second) = self.means.split_at(self.means.len() / 2);
        mean(second) - mean(first)
    }
}

/// Sum of squared distances from the mean, and the correlation of neighbours, from 0 to `most`. The same values: 0 and 0.
fn spread_and_correlation(values: &[f64], most: f64) -> (f64, f64) {
    let middle = mean(values);
    let distances: Vec<f64> = values.iter().map(|value| value - middle).collect();
    let spread: f64 = distances.iter().map(|d| d * d).sum();
    if spread == 0.0 {
        return (0.0, 0.0);
    }
    let neighbours: f64 = distances.windows(2).map(|pair| pair[1] * pair[0]).sum();
    let correlation = neighbours / spread + 1.0 / values.len() as f64;
    (spread, correlation.clamp(0.0, most))
}

/// Variance of the mean of a long series, times the number of its batches.
fn variance_of_a_batch(count: f64, spread: f64, correlation: f64) -> f64 {
    spread / (count - 1.0) * (1.0 + correlation) / (1.0 - correlation)
}

/// The variance by batch of a series of batches whose neighbours are correlated by `most` at most.
pub(super) fn variance_by_batch(means: &[f64], most: f64) -> f64 {
    let (spread, correlation) = spread_and_correlation(means, most);
    variance_of_a_batch(means.len() as f64, spread, correlation)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::statistics::{Record, start_up};

    /// 3,000 rows of an autoregressive process with a start-up of so much, in a record.
    pub(in crate::statistics) fn series(start: f64) -> Record {
        let (mut state, mut y, mut record) = (1u64, 0.0, Record::default());
        let mut left = start;
        for _ in 0..3000 {
            state = (1_103_515_245 * state + 12345) % (1 << 31);
            y = 0.9 * y + state as f64 / (1u64 << 31) as f64 - 0.5;
            left *= 0.99;
            record.add(y + left);
        }
        record
    }

    fn close(value: f64, expected: f64, digits: i32) {
        let half = 0.5 * 10f64.powi(-digits);
        assert!(
            (value - expected).abs() <= half * 1.001,
            "{value} {expected}"
        );
    }

    /// The check values of the specification, to their digits.
    #[test]
    fn a_known_series_has_its_known_error() {
        let record = series(0.0);
        assert_eq!((record.bins().len(), record.width()), (750, 4));
        let batches = Batches::of(record.bins()).unwrap();
        assert_eq!(batches.count(), 68);
        let estimate = batches.estimate();
        close(estimate.value, -0.004_440_912, 9);
        close(estimate.error, 0.056_678_163, 9);
        close(estimate.independent, 41.9007, 4);

        let record = series(20.0);
        let cut = start_up(record.bins()).unwrap().cut;
        let batches = Batches::of(&record.bins()[cut..]).unwrap();
        assert_eq!((cut, batches.count()), (140, 67));
        let estimate = batches.estimate();
        close(estimate.value, 0.013_687_026, 9);
        close(estimate.error, 0.054_232_967, 9);
        close(estimate.independent, 54.7496, 4);
    }

    #[test]
    fn a_constant_series_has_no_error() {
        let estimate = Batches::of(&[2.5; 700]).unwrap().estimate();
        assert_eq!((estimate.value, estimate.error), (2.5, 0.0));
        assert_eq!(estimate.half_width, 0.0);
        assert_eq!(Batches::of(&[1.0; FEWEST_BATCHES - 1]), None);
    }

    /// The error of a mean scales with its values; a shift leaves it.
    #[test]
    fn errors_scale_with_their_values() {
        let record = series(0.0);
        let changed: Vec<f64> = record.bins().iter().map(|bin| 4.0 * bin - 8.0).collect();
        let [one, other] =
            [record.bins(), &changed].map(|bins| Batches::of(bins).unwrap().estimate());
        // Round-off of 750 sums of numbers up to 20.
        let tolerance = 750.0 * 20.0 * f64::EPSILON;
        assert!((other.value - (4.0 * one.value - 8.0)).abs() < tolerance);
        assert!((other.error / (4.0 * one.error) - 1.0).abs() < 1e-9);
    }
}
