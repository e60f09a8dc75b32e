//! The mean of a correlated series and its error, as pure functions of its rows.
//!
//! An *error* is one standard error. A [`Record`] averages rows into at most 1,024 bins as they come; [`start_up`] finds how much of its
//! beginning belongs to the start-up of a run; [`Batches`] give the error of the mean of the rest. Elementary functions are those of `libm` and sums
//! have one order, so that the results have the same bits on every machine.

mod batches;
mod enough;
mod mean;
mod record;
mod student;
mod warm_up;

pub use batches::{BATCH_BINS, Batches, FEWEST_BATCHES};
pub use enough::{FIRST_LOOK, Look, Looks};
pub use mean::{Mean, root_mean_square};
pub use record::{MOST_BINS, Record};
pub use student::student_t_975;
pub use warm_up::{StartUp, start_up};

/// The mean of some numbers, summed in their order. Not a number where there are none.
fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Means of groups of so many neighbours, the last group ending with the last value; values at the beginning that fill no group are left out.
fn group_means(values: &[f64], size: usize) -> Vec<f64> {
    let rest = values.len() % size;
    values[rest..].chunks_exact(size).map(mean).collect()
}

/// A standard error, its interval and what else is known of a mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The mean, in the unit of the rows.
    pub value: f64,
    /// One standard error.
    pub error: f64,
    /// Half the width of the 95 % interval.
    pub half_width: f64,
    /// Number of independent batches.
    pub independent: f64,
}
