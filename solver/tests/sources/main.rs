//! Rules for the sources: compiled laws, the folders of the crates.

mod compiled_laws;
mod modules;
