//! The expected memory of a run.

use super::expected::{AtStart, at_start};
use super::particles::{StartingSphere, Typed};
use super::{NewBody, NewParticle, Plan};
use mercury_engine::walls::Shape;

/// Expected memory of a run, bytes. The parts are counted where a run is made (`run::memory`), as they depend on all modules.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Memory {
    /// Spheres that are expected.
    pub spheres: f64,
    /// While the scene is read and looked over, its tables among it; given back before the time loop.
    pub start: f64,
    /// In the time loop, between two candidate lists of which one was built before.
    pub steps: f64,
    /// Part of that which is free, and which the allocator keeps for the next list.
    pub kept_free: f64,
    /// The maximum: while a candidate list is built, or a frame is written.
    pub most: f64,
    /// In addition, from the first checkpoint on: its bytes, whose memory is kept for the next one.
    pub checkpoint: f64,
}

impl Memory {
    /// The most memory needed at any time, bytes.
    #[must_use]
    pub fn peak(&self) -> f64 {
        (self.most + self.checkpoint).max(self.start)
    }
}

/// Bytes that a plan takes, and its making.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartBytes {
    /// The particles of the start in the plan.
    pub grains: f64,
    /// Meshes in the plan.
    pub meshes: f64,
    /// While tables are read, beside the plan.
    pub reading: f64,
    /// While overlaps are looked for, beside the plan and the list that is built for it.
    pub looking_over: f64,
    /// The spheres of that list.
    pub spheres: f64,
}

impl StartBytes {
    /// Bytes of a plan.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        let AtStart {
            particles,
            bodies,
            pebbles,
        } = at_start(plan);
        let spheres = particles + pebbles;
        let meshes = plan.physics().walls.iter().map(|wall| match &wall.shape {
            Shape::Mesh(mesh) => mesh.bytes() as f64,
            _ => 0.0,
        });
        let typed = (particles + bodies) * size_of::<Typed>() as f64;
        Self {
            grains: particles * size_of::<NewParticle>() as f64
                + bodies * size_of::<NewBody>() as f64,
            meshes: meshes.sum(),
            // A table is read line by line.
            reading: typed,
            looking_over: spheres * size_of::<StartingSphere>() as f64 + typed,
            spheres,
        }
    }
}
