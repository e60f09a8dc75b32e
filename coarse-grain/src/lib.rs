//! Coarse-graining: fields of the continuum from particles and contacts.
//!
//! The way of a number: [`input`] makes [`State`](state::State)s from files (or a program hands over its own), an
//! [`Evaluator`](evaluate::Evaluator) spreads particles and contacts over points with a [`Kernel`](kernel::Kernel) into
//! [`Sums`](sums::Sums), sums are averaged over frames, and [`fields`] are computed from them.
//!
//! Definitions with units and signs: `docs/theory/coarse-graining.md`.

// An error ends the reading, so its size does not matter.
#![allow(clippy::result_large_err)]
#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod analysis;
pub mod coordinates;
mod error;
pub mod evaluate;
pub mod fields;
pub mod input;
pub mod kernel;
pub mod options;
pub mod output;
pub mod scan;
pub mod setup;
pub mod state;
pub mod sums;

pub use error::CgError;
