//! Runs of our engine that write where the source writes.

use std::sync::Arc;

use anyhow::Result;
use glam::DVec3;
use mercury_common::formats::ene::EnergyRow;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, PairLaw, SlidingNormal,
};
use mercury_engine::forces::Watch;
use mercury_engine::state::{FIXED, MaterialIndex, Particle, inverse_inertia_factor};
use mercury_engine::step::Engine;
use mercury_engine::walls::{Motion, Plane, Shape, Wall};
use mercury_solver::plan::Draft;

use super::comparison::Tally;

/// The steps after which the source writes.
///
/// It adds up its time (`t += dt`) and makes steps while t < end, so that round-off may add one; it writes before every
/// `every`-th step and once more after the last.
pub(super) fn saved_steps(dt: f64, end: f64, every: u64) -> Vec<u64> {
    let (mut time, mut step) = (0.0, 0);
    let mut saved = Vec::new();
    while time < end {
        if step % every == 0 {
            saved.push(step);
        }
        time += dt;
        step += 1;
    }
    saved.push(step);
    saved
}

/// Runs a plan and shows each state that the source would have written, with its contacts. Returns the last state.
pub(super) fn observe(
    plan: Draft,
    saved: &[u64],
    mut visit: impl FnMut(&Engine) -> Result<()>,
) -> Result<Engine> {
    drive(plan, saved, |_| (), &mut visit)
}

/// As [`observe`], for particles moved from outside: `prepare` is called before every step.
pub(super) fn drive(
    mut plan: Draft,
    saved: &[u64],
    mut prepare: impl FnMut(&mut Engine),
    mut visit: impl FnMut(&Engine) -> Result<()>,
) -> Result<Engine> {
    // The rule of the source.
    plan.sliding_normal = SlidingNormal::Step;
    let mut engine = Engine::new(Arc::new(plan.plan()?), 1)?;
    let watch = Watch {
        records: true,
        audit: None,
    };
    for &step in saved {
        while engine.steps() < step {
            prepare(&mut engine);
            let seen = engine.steps() + 1 == step;
            engine.step(seen.then_some(watch))?;
        }
        engine.complete_step()?;
        visit(&engine)?;
    }
    Ok(engine)
}

/// A normal law alone.
pub(super) fn frictionless(normal: AnyNormal) -> AnyPairLaw {
    PairLaw {
        normal,
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// A plane wall whose normal points away from the particles, as the source defines it.
pub(super) fn plane(outward: DVec3, point: DVec3) -> Result<Wall> {
    Ok(Wall {
        name: "wall".to_owned(),
        material: MaterialIndex::new(0),
        shape: Shape::Plane(Plane::new(point, -outward)?),
        motion: Motion::default(),
        from: 0.0,
        until: f64::INFINITY,
        reference: point,
    })
}

/// The particles in order of their ids.
pub(super) fn by_id(engine: &Engine) -> Vec<Particle> {
    let rows = engine.particles.rows_by_id().into_iter();
    rows.map(|row| engine.particles.records[row as usize])
        .collect()
}

/// The energies of the present state; its contacts must have been watched.
pub(super) fn energies(engine: &Engine) -> EnergyRow {
    let physics = engine.physics();
    let mut row = EnergyRow {
        time: engine.time(),
        elastic: engine.observation().elastic_energy,
        ..EnergyRow::default()
    };
    let (mut mass_sum, mut moment) = (0.0, DVec3::ZERO);
    for (record, &mass) in engine
        .particles
        .records
        .iter()
        .zip(&engine.particles.masses)
    {
        if record.flags & FIXED != 0 {
            continue;
        }
        let inertia =
            mass * record.radius * record.radius / inverse_inertia_factor(physics.dimensions);
        row.gravitational -= mass * physics.gravity.dot(record.position);
        row.translational_kinetic += 0.5 * mass * record.velocity.length_squared();
        row.rotational_kinetic += 0.5 * inertia * record.angular_velocity.length_squared();
        mass_sum += mass;
        moment += mass * record.position;
    }
    row.center_of_mass = moment / mass_sum;
    row
}

/// Adds every number of a row of energies.
pub(super) fn compare_energies(tally: &mut Tally, expected: &EnergyRow, measured: &EnergyRow) {
    tally.add("time", expected.time, measured.time);
    tally.add(
        "gravitational energy",
        expected.gravitational,
        measured.gravitational,
    );
    tally.add(
        "kinetic energy",
        expected.translational_kinetic,
        measured.translational_kinetic,
    );
    tally.add(
        "rotational energy",
        expected.rotational_kinetic,
        measured.rotational_kinetic,
    );
    tally.add("elastic energy", expected.elastic, measured.elastic);
    tally.vector(
        "centre of mass",
        expected.center_of_mass,
        measured.center_of_mass,
    );
}

#[cfg(test)]
mod tests {
    use super::saved_steps;

    #[test]
    fn round_off_of_the_summed_time_adds_the_steps_that_the_files_show() {
        // last saved steps in the shipped restart files
        assert_eq!(saved_steps(2e-5, 0.25, 10).last(), Some(&12501));
        assert_eq!(saved_steps(5e-7, 6e-5, 1).last(), Some(&121));
        assert_eq!(saved_steps(1e-4, 8.0, 1000).last(), Some(&80001));
        assert_eq!(
            saved_steps(2e-4, 1.0, 1000),
            [0, 1000, 2000, 3000, 4000, 5000, 5001]
        );
    }
}
