//! Gains, losses and present amounts: the budgets of a run.

use glam::DVec3;
use mercury_pictures::{EnergyFlows, EnergyRow};

use crate::output::summary::{EnergySummary, Springs};
use crate::output::{Exchanged, Written};
use mercury_engine::step::Engine;

/// Budgets of mass and momentum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Mass of the scene's own particles that are not fixed, kg.
    pub initial_mass: f64,
    /// Inserted, kg.
    pub inserted_mass: f64,
    /// Taken out, kg.
    pub deleted_mass: f64,
    /// There at the end, kg.
    pub final_mass: f64,
    /// Momentum in the first frame, kg m/s.
    pub initial_momentum: DVec3,
    /// Momentum at the end, kg m/s.
    pub final_momentum: DVec3,
}

impl Budget {
    /// Budget of a run.
    pub(super) fn new(engine: &Engine, written: &Written) -> Self {
        let physics = engine.physics();
        let (final_mass, final_momentum) = match &written.last {
            Some(last) => last.mass_and_momentum(),
            None => (0.0, DVec3::ZERO),
        };
        let exchanged = Exchanged::by_now(engine);
        let Exchanged {
            inserted, removed, ..
        } = exchanged;
        let particles = physics.particles.iter().filter(|particle| !particle.fixed);
        let bodies = physics.bodies.iter().filter(|body| !body.fixed);
        Self {
            // An empty sum of floats is -0.
            initial_mass: 0.0
                + particles
                    .map(|particle| particle.build(&physics.materials, physics.dimensions).1)
                    .sum::<f64>()
                + bodies.map(|body| body.mass(&physics.clumps)).sum::<f64>(),
            inserted_mass: inserted.mass + exchanged.liquid_mass,
            deleted_mass: removed.mass,
            final_mass,
            initial_momentum: written.initial,
            final_momentum,
        }
    }

    /// Mass that is missing (positive) or too much, kg.
    #[must_use]
    pub fn mass_error(&self) -> f64 {
        self.initial_mass + self.inserted_mass - self.deleted_mass - self.final_mass
    }
}

/// The energies at the end, and their budget where the plan includes it.
pub(super) fn energy_summary(engine: &Engine, written: &Written) -> EnergySummary {
    let at_end = written.at_end.as_ref();
    let energy = |pick: fn(&EnergyRow) -> f64| at_end.map_or(0.0, |budget| pick(&budget.energies));
    let flows = at_end.and_then(|budget| budget.energies.flows.as_ref());
    let flow = |pick: fn(&EnergyFlows) -> f64| flows.map(pick);
    let audit = engine.audit();
    let left = audit.left;
    EnergySummary {
        kinetic: energy(|row| row.kinetic),
        rotational: energy(|row| row.rotational),
        gravitational: energy(|row| row.gravitational),
        elastic: energy(|row| row.elastic),
        dissipated: flows.map(|_| audit.losses),
        wall_work: flow(|flows| flows.wall_work),
        servo_work: flow(|flows| flows.servo_work),
        inserted: flow(|flows| flows.inserted),
        deleted: flow(|flows| flows.deleted),
        deleted_elastic: flows.map(|_| Springs {
            normal: left.normal + left.plastic,
            tangential: left.tangential,
            rolling: left.rolling,
        }),
        vanished_walls: flow(|flows| flows.vanished_walls),
        closure_error: at_end.and_then(|budget| Some(budget.gap?.relative)),
    }
}
