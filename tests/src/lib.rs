//! End-to-end tests, validation cases and the plain reference path.

pub mod closed_forms;
#[cfg(doctest)]
mod how_to;
pub mod reference;
