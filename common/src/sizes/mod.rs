//! Particle size distributions: laws and measurements of the diameter, drawn by number whatever they were stated in.
//!
//! A distribution is stated by its density q_k in one weighting: number (k = 0), length (1), area (2) or volume
//! (3). Particles are drawn one by one, so draws follow the number density q_0(d) proportional to
//! q_k(d) / d^k. [`SizeDistribution`] holds all views: [`SizeDistribution::by`] gives each.
//!
//! [`Classes`] are a measured distribution, [`table`] reads them, [`changes`] cut, squeeze and scale them.

pub mod changes;
mod classes;
mod distribution;
mod error;
mod fines;
#[cfg(test)]
mod frozen;
mod laws;
mod open_files;
mod powers;
mod shares;
mod statement;
pub mod table;
mod tabulated;
mod weighted;

pub use classes::{ClassModel, ClassProblem, Classes};
pub use distribution::SizeDistribution;
pub use error::SizeError;
pub use shares::warning_of_shares;
pub use weighted::Weighted;

pub use crate::scene::Weighting;
