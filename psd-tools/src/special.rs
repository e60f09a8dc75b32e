//! Distributions of test statistics: Kolmogorov, Anderson-Darling.

mod kolmogorov;
mod quadratic;

pub use kolmogorov::{kolmogorov_tail, two_sample_kolmogorov_tail};
pub use quadratic::{
    ANDERSON_DARLING_VARIANCE, anderson_darling_samples_tail, anderson_darling_tail,
};
