//! What came in, what went out, what is there: the budgets of a run.

use glam::DVec3;
use mercury_pictures::EnergyRow;

use crate::boundaries::Tally;
use crate::output::Written;
use crate::output::summary::{Dissipated, EnergySummary, Springs};
use crate::plan::{NewBody, NewParticle, Plan};
use crate::step::Engine;

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
    /// Of a run.
    pub(super) fn new(engine: &Engine, written: &Written) -> Self {
        let plan = engine.plan();
        let (final_mass, final_momentum) = match &written.last {
            Some(last) => last.mass_and_momentum(),
            None => (0.0, DVec3::ZERO),
        };
        let (inserted, deleted) = exchanged(engine);
        let particles = plan
            .physics()
            .particles()
            .iter()
            .filter(|particle| !particle.fixed);
        let bodies = plan.physics().bodies().iter().filter(|body| !body.fixed);
        Self {
            // An empty sum of floats is -0.
            initial_mass: 0.0
                + particles
                    .map(|particle| {
                        particle
                            .build(plan.physics().materials(), plan.physics().dimensions())
                            .1
                    })
                    .sum::<f64>()
                + bodies
                    .map(|body| body.mass(plan.physics().clumps()))
                    .sum::<f64>(),
            inserted_mass: inserted.mass,
            deleted_mass: deleted.mass,
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

/// What came in and what went out so far.
pub(super) fn exchanged(engine: &Engine) -> (Tally, Tally) {
    (
        engine.boundaries().inserted(),
        engine.boundaries().removed(),
    )
}

/// The energies at the end, and their budget where the plan asks for it.
pub(super) fn energy_summary(
    engine: &Engine,
    at_start: &(Tally, Tally),
    written: &Written,
) -> EnergySummary {
    let plan = engine.plan();
    let rows = &written.energies;
    let last = written.at_end.unwrap_or(EnergyRow {
        time: 0.0,
        kinetic: 0.0,
        rotational: 0.0,
        gravitational: 0.0,
        elastic: 0.0,
        dissipated: None,
    });
    let mut summary = EnergySummary {
        kinetic: last.kinetic,
        rotational: last.rotational,
        gravitational: last.gravitational,
        elastic: last.elastic,
        dissipated: None,
        wall_work: None,
        inserted: None,
        deleted: None,
        deleted_elastic: None,
        vanished_walls: None,
        closure_error: None,
    };
    if !plan.physics().energy_budget() {
        return summary;
    }
    let audit = engine.audit();
    let dissipated = Dissipated {
        normal: audit.dissipated_normal,
        tangential: audit.dissipated_tangential,
        rolling: audit.dissipated_rolling,
        liquid: audit.dissipated_adhesion,
    };
    // Velocities of those that come and go are half a step older than their places. What they carry is that of the velocities' time.
    let half = 0.5 * plan.physics().time_step();
    let carried = |tally: &Tally| {
        let moment = tally.mass_moment - tally.momentum * half;
        tally.kinetic + tally.rotational - plan.physics().gravity().dot(moment)
    };
    let (inserted, deleted) = exchanged(engine);
    let inserted = carried(&inserted) - carried(&at_start.0);
    let deleted = carried(&deleted) - carried(&at_start.1) + audit.left.total();
    let vanished = audit.vanished.total();
    summary.dissipated = Some(dissipated);
    summary.wall_work = Some(audit.wall_work);
    summary.inserted = Some(inserted);
    summary.deleted = Some(deleted);
    summary.deleted_elastic = Some(Springs {
        normal: audit.left.normal + audit.left.plastic,
        tangential: audit.left.tangential,
        rolling: audit.left.rolling,
    });
    summary.vanished_walls = Some(vanished);
    if let (Some(first), true) = (rows.first(), is_closed(plan)) {
        let total =
            |row: &EnergyRow| row.kinetic + row.rotational + row.gravitational + row.elastic;
        let put_to_rest = engine.sleepers().map_or(0.0, |(_, counts)| counts.energy);
        let given = total(first) + audit.wall_work + inserted;
        let gone = deleted + vanished;
        let gap = given - gone - total(&last) - dissipated.total() - put_to_rest;
        // Gravitational energy has no zero of its own: its change counts.
        let largest = rows
            .iter()
            .flat_map(|row| {
                let fall = row.gravitational - first.gravitational;
                [row.kinetic, row.rotational, row.elastic, fall]
            })
            .chain([
                audit.wall_work,
                inserted,
                deleted,
                vanished,
                dissipated.total(),
            ])
            .fold(0.0, |largest: f64, energy| largest.max(energy.abs()));
        summary.closure_error = Some(if largest > 0.0 { gap / largest } else { 0.0 });
    }
    summary
}

/// Whether all work done on the particles is measured.
fn is_closed(plan: &Plan) -> bool {
    let mut particles = plan.physics().particles().iter();
    let driven = particles.any(NewParticle::is_prescribed);
    let driven = driven || plan.physics().bodies().iter().any(NewBody::is_prescribed);
    let falls_for_ever =
        (0..3).any(|axis| plan.physics().periodic()[axis] && plan.physics().gravity()[axis] != 0.0);
    !driven && !falls_for_ever
}
