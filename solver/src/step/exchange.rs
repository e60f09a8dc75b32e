//! What comes, what goes and what passes.

use super::Engine;
use crate::boundaries::Crossed;

impl Engine {
    /// Counts, removes and inserts particles.
    pub(super) fn exchange_particles(&mut self) {
        let time = self.time();
        let changed = self.boundaries.exchange(
            &mut self.particles,
            self.plan.physics().insertions(),
            &self.plan.physics().setting(),
            &self.images,
            &self.walls,
            time,
        );
        self.lists.rows_changed |= changed;
    }

    /// What crossed the flux planes since this was last asked for: plane by plane, in the order of the plan, each material by material.
    pub fn take_crossed(&mut self) -> Vec<Crossed> {
        self.boundaries.take_crossed()
    }
}
