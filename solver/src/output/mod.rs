//! output.

pub mod pictures;
