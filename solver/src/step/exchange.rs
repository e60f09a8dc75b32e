//! What comes, what goes and what passes.

use super::{Engine, RunError};
use crate::boundaries::Crossed;

impl Engine {
    /// Counts, removes and inserts particles.
    ///
    /// # Errors
    /// If that was given up; the state is none then.
    pub(super) fn exchange_particles(&mut self) -> Result<(), RunError> {
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
        if changed && self.plan.physics().energy_budget() {
            self.note_leavers();
        }
        if self.stage.is_given_up() {
            return Err(RunError::GivenUp);
        }
        Ok(())
    }

    /// What crossed the flux planes since this was last asked for: plane by plane, in the order of the plan, each material by material.
    pub fn take_crossed(&mut self) -> Vec<Crossed> {
        self.boundaries.take_crossed()
    }
}
