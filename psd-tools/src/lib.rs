//! Particle size distributions as tables, laws and samples: statistics, conversion, fits, and the proof that a sample is of a
//! distribution.
//!
//! The distributions themselves, their file formats and their exact conversions are in [`mercury_common::sizes`], which the
//! solver draws from too. The modules here: [`input`] finds out what a file is, [`parquet`] reads and writes those of columns;
//! [`statistics`], [`compare`] and [`convert`] report and write its content; [`sample`] holds particles counted one by one;
//! [`fit`] fits laws; [`check`] tests samples, with the distributions of [`special`]; [`draw`] makes samples; [`charts`] shows
//! all of it.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the work, so its size does not matter"
)]

pub mod charts;
pub mod check;
pub mod compare;
pub mod convert;
pub mod draw;
pub mod fit;
pub mod input;
pub mod parquet;
pub mod report;
pub mod sample;
pub mod special;
pub mod statistics;

#[cfg(test)]
mod test_support;
