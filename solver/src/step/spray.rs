//! Droplets in a step.

use super::{Engine, RunError};
use crate::spray::{Sprays, Surroundings};
use crate::walls::WallFilms;

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
        let mut none = WallFilms::default();
        let wall_films = (self.liquid.as_mut()).map_or(&mut none, |liquid| &mut liquid.walls);
        let advanced = sprays.advance(plan, &mut self.particles, wall_films, &around);
        advanced.map_err(|error| RunError::Droplets { time, error })
    }

    /// What liquid brought to particles from outside since the start: mass (kg, where it has any) and energy (J), by the rules of migration
    /// and evaporation, and by droplets.
    #[must_use]
    pub fn liquid_brought(&self) -> [[f64; 2]; 2] {
        let liquid = self.liquid.as_ref().map_or([0.0; 2], |liquid| {
            [liquid.gained_mass(), liquid.balance.weighed.energy]
        });
        let sprays = self.sprays.as_ref().map_or([0.0; 2], |sprays| {
            let balance = &sprays.state.balance;
            [balance.mass.value(), balance.energy]
        });
        [liquid, sprays]
    }

    /// The droplets in flight and where their liquid went, in scenes with sprays.
    #[must_use]
    pub fn sprays(&self) -> Option<&Sprays> {
        self.sprays.as_ref()
    }
}
