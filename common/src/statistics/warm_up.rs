//! The start-up of a series that becomes steady.

use super::batches::variance_by_batch;
use super::{group_means, mean};

/// Statistic above which a series is not taken to be steady from its beginning: Cramér-von Mises, 25 % level.
const CRITICAL: f64 = 0.209;

/// Number of groups into which a record is divided; there are fewer than twice as many.
const GROUPS: usize = 128;

/// Largest correlation of neighbouring groups that is put right in the variance.
const MOST_CORRELATION: f64 = 0.9;

/// Fewest groups that are left in the search for the best truncation.
const FEWEST_LEFT: usize = 5;

/// The part of a series that belongs to its start-up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartUp {
    /// The statistic of Cramér and von Mises: large where the beginning lies on one side of the mean.
    pub statistic: f64,
    /// Number of bins at the beginning to leave out.
    pub cut: usize,
    /// False where more than half would have to be left out.
    pub is_steady: bool,
}

/// The start-up of a series of bins; `None` from fewer than 16.
///
/// Nothing is cut where the series passes the test of Heidelberger & Welch (*Oper. Res.* 31, 1983). Otherwise twice the truncation with the least standard
/// error of the mean of what is left (MSER: White, *Simulation* 69, 1997): the truncation itself leaves a third of the start-up's tail.
#[must_use]
pub fn start_up(bins: &[f64]) -> Option<StartUp> {
    if bins.len() < super::FEWEST_BATCHES {
        return None;
    }
    let size = (bins.len() / GROUPS).max(1);
    let statistic = cramer_von_mises(&group_means(bins, size));
    if statistic <= CRITICAL {
        return Some(StartUp {
            statistic,
            cut: 0,
            is_steady: true,
        });
    }
    let from_start: Vec<f64> = bins.chunks_exact(size).map(mean).collect();
    let cut = 2 * least_error(&from_start) * size;
    Some(StartUp {
        statistic,
        is_steady: 2 * cut <= bins.len(),
        cut: cut.min(bins.len()),
    })
}

/// Sum of squares of the partial sums of distances from the mean, in units that make it the same for all steady series. A series that
/// never changes has 0.
fn cramer_von_mises(groups: &[f64]) -> f64 {
    let count = groups.len() as f64;
    let variance = variance_by_batch(&groups[groups.len() / 2..], MOST_CORRELATION);
    let middle = mean(groups);
    let (mut partial, mut squares) = (0.0, 0.0);
    for group in groups {
        partial += group - middle;
        squares += partial * partial;
    }
    if squares == 0.0 {
        return 0.0;
    }
    squares / (variance * count * count)
}

/// Number of groups at the beginning without which the mean of the others has the least standard error; the earliest of equals.
fn least_error(groups: &[f64]) -> usize {
    let most = groups.len() - FEWEST_LEFT.max(groups.len() / 20);
    let mut best = (f64::INFINITY, 0);
    for cut in 0..=most {
        let left = &groups[cut..];
        let middle = mean(left);
        let spread: f64 = left.iter().map(|g| (g - middle) * (g - middle)).sum();
        let error = spread / (left.len() as f64 * left.len() as f64);
        if error < best.0 {
            best = (error, cut);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::super::batches::tests::series;
    use super::*;

    /// The check values of the specification, to their digits.
    #[test]
    fn start_up_is_found_in_known_series() {
        let steady = start_up(series(0.0).bins()).unwrap();
        assert!((steady.statistic - 0.088_141).abs() < 0.5e-6, "{steady:?}");
        assert_eq!((steady.cut, steady.is_steady), (0, true));
        let starting = start_up(series(20.0).bins()).unwrap();
        assert!((starting.statistic - 63.515).abs() < 0.5e-3, "{starting:?}");
        assert_eq!((starting.cut, starting.is_steady), (140, true));
    }

    #[test]
    fn drifts_are_not_steady_and_constants_are() {
        let drift: Vec<f64> = (0..600).map(f64::from).collect();
        assert!(!start_up(&drift).unwrap().is_steady);
        let step: Vec<f64> = (0..600).map(|k| f64::from(u8::from(k > 400))).collect();
        assert!(!start_up(&step).unwrap().is_steady);
        let constant = start_up(&[7.0; 600]).unwrap();
        assert_eq!((constant.cut, constant.is_steady), (0, true));
        assert_eq!(start_up(&[1.0; 15]), None);
    }
}
