//! Is this sample one of that distribution?
//!
//! `goodness` holds the tests and what is seen beside them, `bands` the confidence of the curves, `verdict` what follows;
//! `two_samples` tests whether two samples are of one distribution, `many_samples` whether several are; `run` finds the sizes and
//! targets of a run.

mod bands;
mod goodness;
mod many_samples;
pub mod run;
mod two_samples;
mod verdict;

pub use bands::{Interval, VolumeBand, fewest, number_band, number_interval, volume_interval};
pub(crate) use goodness::anderson_darling;
pub use goodness::{Goodness, Outside, Statistic};
pub use many_samples::anderson_darling_samples;
pub use two_samples::TwoSamples;
pub(crate) use verdict::too_few;
pub use verdict::{Criterion, Finding, Verdict};
