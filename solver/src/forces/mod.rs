//! forces.
