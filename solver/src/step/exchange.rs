//! What comes and what goes.

use super::Engine;

impl Engine {
    /// Removes and inserts particles.
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
}
