//! End-to-end tests, validation cases and the plain reference path.

pub mod cases;
pub mod closed_forms;
pub mod dry;
#[cfg(doctest)]
mod how_to;
pub mod long;
pub mod meridian;
pub mod published;
pub mod reference;
pub mod scene_checks;
pub mod scenes;
pub mod selftests;
pub mod shapes;
pub mod sheet_at_rest;
pub mod stress;
pub mod three_beads;
pub mod twins;
pub mod validation;
pub mod wet;
