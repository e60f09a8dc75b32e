//! Rigid clumps: pebbles, and the clump file.

use glam::DVec3;

/// A sphere that stands for a part of a rigid body. Pebbles of one body may overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pebble {
    /// Centre in m.
    pub position: DVec3,
    /// Radius in m, above 0.
    pub radius: f64,
}
