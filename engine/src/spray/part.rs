//! Droplets in a step.

use std::sync::Arc;

use mercury_common::particle_properties::{FILM_VOLUME, ParticleProperty};

use super::{Among, SprayContext, SprayPlan, Sprays};
use crate::forces::Needs;
use crate::membrane::MembranePlan;
use crate::physics::{FeaturePlan, InputError, Inputs, Setup, number};
use crate::state::{Pieces, Plain};
use crate::step::{Core, Engine, Part, RunError, SizeEstimate};

impl FeaturePlan for SprayPlan {
    fn check(_: &[Self], inputs: &Inputs) -> Result<(), InputError> {
        if inputs.plans.get::<MembranePlan>().is_some() {
            return Err(number("sprays", "none in scenes with surfaces", "some"));
        }
        Ok(())
    }

    /// Droplets end in films.
    fn properties(&self) -> Vec<&'static ParticleProperty> {
        vec![&FILM_VOLUME]
    }
}

impl Part for Sprays {
    fn name(&self) -> &str {
        "sprays"
    }

    fn of(core: &mut Core) -> Option<Self> {
        core.physics().plans.get().map(Self::new)
    }

    fn bytes(setup: &Setup, crowd: &SizeEstimate) -> f64 {
        let Some(plan) = setup.physics.plans.get::<SprayPlan>() else {
            return 0.0;
        };
        let physics = &setup.physics;
        let across = physics.cell.diagonal();
        let droplets = plan.nozzles.iter().map(|nozzle| nozzle.in_flight(across));
        Self::bytes_of(droplets.sum(), crowd.rows)
    }

    fn needs(&self) -> Needs {
        Needs {
            all_walls: true,
            ..Needs::default()
        }
    }

    /// Releases droplets and moves them to the end of the step.
    fn before_forces(&mut self, core: &mut Core) -> Result<(), RunError> {
        // The forces before the first step are those of its beginning.
        if core.steps() == 0 {
            return Ok(());
        }
        let time = core.time();
        let (physics, cell) = (Arc::clone(core.physics()), *core.cell());
        let Some(plan) = physics.plans.get::<SprayPlan>() else {
            return Ok(());
        };
        let (fastest, rebuilds) = (core.fastest(), core.lists().rebuilds);
        let (particles, domain, ranks) = core.lend_rows();
        let around = SprayContext {
            time,
            dt: physics.time_step,
            gravity: physics.gravity,
            walls: &domain.walls,
            planned_walls: &physics.walls,
            cell: &cell,
            fastest,
            rebuilds,
        };
        let among = Among::new(particles, ranks);
        let advanced = self.advance(plan, among, &mut domain.wall_films, &around);
        self.too_many = advanced.err();
        Ok(())
    }

    /// Too many droplets end the run once the step is whole, so that its state can be written.
    fn end_step(&mut self, core: &mut Core) -> Result<(), RunError> {
        match self.too_many.take().filter(|_| !self.unlimited) {
            Some(error) => Err(RunError::Droplets {
                time: core.time(),
                error,
            }),
            None => Ok(()),
        }
    }

    /// Every rank has all droplets and moves them all, and gets the grains near them from the ranks of these.
    fn works_on_ranks(&self) -> bool {
        true
    }

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        self.state.put(pieces.end());
    }

    fn take(&mut self, _: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        self.restore(Plain::take(bytes)?)
    }
}

impl Engine {
    /// The droplets in flight and where their liquid went, in scenes with sprays.
    #[must_use]
    pub fn sprays(&self) -> Option<&Sprays> {
        self.part()
    }
}
