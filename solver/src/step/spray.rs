//! Droplets in a step.

use super::{Engine, RunError};
use crate::spray::{Sprays, Surroundings};

impl Engine {
    /// Releases droplets and moves them to the end of the step, in which no particle was faster than `fastest` (m/s).
    ///
    /// # Errors
    /// If more droplets are in flight than a spray allows.
    pub(super) fn spray(&mut self, fastest: f64) -> Result<(), RunError> {
        let time = self.time();
        let Some(sprays) = &mut self.sprays else {
            return Ok(());
        };
        let physics = self.plan.physics();
        let Some(plan) = physics.sprays() else {
            return Ok(());
        };
        let around = Surroundings {
            time,
            dt: physics.time_step(),
            gravity: physics.gravity(),
            walls: &self.walls,
            images: &self.images,
            fastest,
            rebuilds: self.lists.rebuilds,
        };
        let advanced = sprays.advance(plan, &mut self.particles, &around);
        advanced.map_err(|error| RunError::Droplets { time, error })
    }

    /// The droplets in flight and where their liquid went, in scenes with sprays.
    #[must_use]
    pub fn sprays(&self) -> Option<&Sprays> {
        self.sprays.as_ref()
    }
}
