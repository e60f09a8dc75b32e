//! Progress of a run, and the work ahead of it.

use mercury_engine::state::{FIXED, PEBBLE};
use mercury_engine::step::Engine;

use crate::plan::{Ahead, Here, Workload};

/// Where a run is.
pub struct Progress<'a> {
    /// The engine, in the middle of a step's kicks.
    pub engine: &'a Engine,
    /// Particles times steps made so far.
    pub particle_steps: u64,
    /// Time of the steps, s: since the first one that was made here, without the insertion of a great many.
    pub seconds: f64,
    /// Expected time of the remaining steps, s.
    pub left: f64,
}

impl Progress<'_> {
    /// The share of the planned steps that is made.
    #[must_use]
    pub fn share(&self) -> f64 {
        let steps = self.engine.physics().steps.max(1);
        self.engine.steps() as f64 / steps as f64
    }

    /// Translational kinetic energy of the particles and bodies that are not fixed, J.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        let particles = &self.engine.particles;
        let is_counted = |&row: &usize| particles.records[row].flags & (FIXED | PEBBLE) == 0;
        let rows = (0..particles.len()).filter(is_counted);
        let of_particles: f64 = rows
            .map(|row| {
                0.5 * particles.masses[row] * particles.records[row].velocity.length_squared()
            })
            .sum();
        let bodies = particles.bodies().iter().filter(|body| !body.is_fixed());
        let of_bodies = bodies.map(|body| 0.5 * body.mass * body.velocity.length_squared());
        of_particles + of_bodies.sum::<f64>()
    }
}

/// Work that is ahead of a run.
pub(super) fn ahead_of(workload: &Workload, engine: &Engine) -> Ahead {
    let insertions = engine.boundaries().insertions();
    let brought: Vec<_> = insertions
        .map(|state| (state.inserted.number, state.is_finished()))
        .collect();
    workload.ahead(Here {
        step: engine.steps(),
        grains: engine.particles.grains() as f64,
        brought: &brought,
    })
}
