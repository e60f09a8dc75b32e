//! From a surface and pebbles to a rigid clump that a solver can trust.

pub mod alignment;
pub mod descriptors;
pub mod fidelity;
pub mod generate;
pub mod inertia;
pub mod surface;
