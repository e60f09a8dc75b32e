//! Insertions, deletions, planes and regions of a scene.

pub(crate) mod fluxes;
pub(crate) mod insertions;
pub(crate) mod regions;
