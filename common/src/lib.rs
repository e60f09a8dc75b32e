//! Shared parts of all Mercury tools: file formats, the scene format, size distributions, random numbers, command lines.
//!
//! Nothing in here simulates anything. Errors are values, and nothing exits; only [`cli`] prints, for the programs.

#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

#[cfg(feature = "cli")]
pub mod cli;
pub mod curve;
pub mod error;
pub mod folder_owner;
pub mod formats;
pub mod frames;
pub mod machine;
pub mod normal;
pub mod paraview;
pub mod particle_properties;
pub mod plausible;
pub mod problem;
pub mod random;
pub mod readable;
#[doc(hidden)]
pub mod reference_data;
pub mod run_files;
pub mod run_tables;
pub mod scene;
pub mod sizes;
pub mod statistics;
pub mod surfaces;
pub mod turns;
pub mod units;
pub mod whole_file;
pub mod within;
