//! End-to-end tests, validation cases and the plain reference path.

pub mod closed_forms;
pub mod reference;
#[cfg(doctest)]
mod how_to;
