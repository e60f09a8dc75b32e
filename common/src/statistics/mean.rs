//! The mean of independent values.

use super::{mean, student_t_975};

/// The error of the normal law's 95 % interval, in standard errors.
const NORMAL: f64 = 1.96;

/// The mean of independent values, such as the outcomes of several seeds, with the interval of Student's distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The mean, in the unit of the values.
    pub value: f64,
    /// Standard deviation of one value.
    pub spread: f64,
    /// Half the width of the 95 % interval.
    pub half: f64,
    /// That in units of a standard error of the normal law, which a few values widen.
    pub error: f64,
}

impl Mean {
    /// Of one value or more; a single value has no error, which is not a number then.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let value = mean(values);
        let squares: f64 = values.iter().map(|v| (v - value) * (v - value)).sum();
        let (mut spread, mut half) = (f64::NAN, f64::NAN);
        if values.len() > 1 {
            spread = (squares / (count - 1.0)).sqrt();
            half = student_t_975(count - 1.0) * spread / count.sqrt();
        }
        Self {
            value,
            spread,
            half,
            error: half / NORMAL,
        }
    }

    /// The mean difference of pairs, and the correlation of the two; not a number for fewer than two pairs.
    #[must_use]
    pub fn of_differences(ours: &[f64], theirs: &[f64]) -> (Self, f64) {
        let pairs = || ours.iter().zip(theirs);
        let difference: Vec<f64> = pairs().map(|(a, b)| a - b).collect();
        let (a, b) = (Self::of(ours), Self::of(theirs));
        let product: f64 = pairs().map(|(x, y)| (x - a.value) * (y - b.value)).sum();
        let correlation = product / ((ours.len() as f64 - 1.0) * a.spread * b.spread);
        (Self::of(&difference), correlation)
    }
}

/// The root mean square of errors; not a number where there are none.
#[must_use]
pub fn root_mean_square(errors: &[f64]) -> f64 {
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    (squares / errors.len() as f64).sqrt()
}
