//! Distributions of test statistics: chi-square, Kolmogorov, Anderson-Darling, Cramer-von Mises.

mod gamma;
mod kolmogorov;
mod quadratic;

pub use gamma::chi_square_tail;
pub use kolmogorov::{kolmogorov_tail, two_sample_kolmogorov_tail};
pub use quadratic::{
    ANDERSON_DARLING_VARIANCE, anderson_darling_samples_tail, anderson_darling_tail,
    cramer_von_mises_limit_tail, cramer_von_mises_tail,
};
