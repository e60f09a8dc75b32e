//! What every Mercury tool shares: file formats, the scene format, size distributions, random numbers.
//!
//! Nothing in here simulates anything, and nothing in here prints or exits: errors are values.

pub mod error;
pub mod formats;
pub mod frames;
pub mod paraview;
pub mod random;
pub mod scene;
pub mod sizes;
pub mod surfaces;
