//! Particle size distributions: laws of the diameter, drawn by number whatever they were stated in.
//!
//! A law is stated by its density q_k in one weighting: number (k = 0), length (1), area (2) or volume
//! (3). Particles are drawn one by one, so draws follow the number density q_0(d) proportional to
//! q_k(d) / d^k. [`SizeDistribution`] holds both views.

mod distribution;
mod error;
mod normal;
mod tabulated;

pub use distribution::SizeDistribution;
pub use error::SizeError;
pub use normal::{normal_cdf, normal_quantile};

pub use crate::scene::Weighting;
