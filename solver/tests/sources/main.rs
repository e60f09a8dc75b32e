//! What the sources promise: compiled laws, the page of the scene format, the folders of the crate.

mod compiled_laws;
mod format_page;
mod modules;
