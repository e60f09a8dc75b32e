//! What the sources promise: compiled laws, the folders of the crate.

mod compiled_laws;
mod rooms;
