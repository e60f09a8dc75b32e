//! End-to-end tests, validation cases and the plain reference path.

pub mod cases;
pub mod closed_forms;
pub mod reference;
pub mod scenes;
pub mod twins;
