//! Spheres and discs with the linear law, without friction: set-ups 1 to 4.

use anyhow::{Result, ensure};
use glam::DVec3;
use mercury_common::formats::ene::{EnergyReader, EnergyRow};
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::forces::Partner;
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_solver::plan::{Draft, NewParticle};

use super::Data;
use super::comparison::{Comparison, Tally, Tolerance};
use super::restart_file::{self, RestartState};
use super::run::{by_id, compare_energies, energies, frictionless, observe, plane, saved_steps};

/// The linear spring and dashpot.
fn linear(stiffness: f64, dissipation: f64) -> mercury_engine::contact::registry::AnyPairLaw {
    frictionless(AnyNormal::Linear(Linear::new(stiffness, dissipation)))
}

/// Runs a plan beside a file of energies and returns the final state.
fn beside_energies(
    plan: Draft,
    saved: &[u64],
    file: &[EnergyRow],
    tally: &mut Tally,
) -> Result<Engine> {
    ensure!(
        saved.len() == file.len(),
        "{} rows in the file, {} here",
        file.len(),
        saved.len()
    );
    let mut rows = file.iter();
    observe(plan, saved, |engine| {
        if let Some(expected) = rows.next() {
            compare_energies(tally, expected, &energies(engine));
        }
        Ok(())
    })
}

/// Compares positions, velocities and contacts with a restart file.
fn compare_state(tally: &mut Tally, expected: &RestartState, engine: &Engine) -> Result<()> {
    let particles = by_id(engine);
    ensure!(
        particles.len() == expected.particles.len(),
        "particle count"
    );
    for (expected, found) in expected.particles.iter().zip(&particles) {
        tally.vector("position", expected.position, found.position);
        tally.vector("velocity", expected.velocity, found.velocity);
    }
    let records = engine.observation().records;
    ensure!(records.len() == expected.contacts.len(), "contact count");
    for expected in &expected.contacts {
        let id = |row: u32| engine.particles.ids[row as usize].number();
        let found = records.iter().find_map(|record| match record.partner {
            Partner::Wall { wall, .. } => {
                let same = expected.with_wall
                    && expected.ids == (id(record.row), u32::from(wall.number()));
                same.then_some((record.overlap, record.force))
            }
            Partner::Particle { row, .. } if expected.with_wall || row == record.row => None,
            Partner::Particle { row, .. } => {
                let ids = (id(record.row), id(row));
                if expected.ids == ids {
                    Some((record.overlap, record.force))
                } else {
                    (expected.ids == (ids.1, ids.0)).then_some((record.overlap, -record.force))
                }
            }
        });
        let Some((overlap, force)) = found else {
            anyhow::bail!("the contact {:?} is missing", expected.ids)
        };
        tally.add("overlap", expected.overlap, overlap);
        tally.vector("contact force", expected.force, force);
    }
    Ok(())
}

/// 1: two elastic discs fall between four walls and collide again and again.
pub(super) fn two_particles(data: &Data) -> Result<Comparison> {
    let (dt, end) = (2e-5, 0.25);
    let domain = (DVec3::ZERO, DVec3::new(0.01, 0.01, 0.0));
    let mut plan = Draft::new(dt, domain, 2000.0, linear(1e4, 0.0));
    plan.dimensions = 2;
    plan.gravity = DVec3::new(0.0, -9.8, 0.0);
    for (outward, point) in [
        (DVec3::NEG_X, DVec3::ZERO),
        (DVec3::X, DVec3::new(0.01, 0.0, 0.0)),
        (DVec3::NEG_Y, DVec3::ZERO),
        (DVec3::Y, DVec3::new(0.0, 0.01, 0.0)),
    ] {
        plan.walls.push(plane(outward, point)?);
    }
    let disc = |x: f64, speed: f64| NewParticle {
        velocity: DVec3::new(speed, 0.0, 0.0),
        ..NewParticle::at(DVec3::new(x, 0.005, 0.0), 0.0005, MaterialIndex::new(0))
    };
    let plan = plan.with_particles(vec![disc(0.006, -0.1), disc(0.004, 0.1)]);
    let file = data.file("interactions/TwoParticleElasticCollisionSelfTest.ene");
    let rows = EnergyReader::open(file)?.collect::<Result<Vec<_>, _>>()?;
    let mut tally = Tally::default();
    let engine = beside_energies(plan, &saved_steps(dt, end, 10), &rows, &mut tally)?;
    let last = data.file("interactions/TwoParticleElasticCollisionSelfTest.restart");
    compare_state(&mut tally, &restart_file::read(&last)?, &engine)?;
    Ok(tally.finish(
        "two discs between elastic walls",
        "MercuryDPM TwoParticleElasticCollisionSelfTest (.ene, .restart)",
        Tolerance::TEN_DIGITS,
    ))
}

/// 2: a sphere bounces on an elastic floor for a million steps.
///
/// Every bounce lasts half a collision period, so that round-off in the instant of touching grows from bounce to bounce; an
/// independent solver deviates by 7e-7.
pub(super) fn free_fall(data: &Data) -> Result<Comparison> {
    let (dt, end) = (1e-6, 1.0);
    let domain = (DVec3::ZERO, DVec3::new(0.01, 0.1, 0.01));
    let mut plan = Draft::new(dt, domain, 2000.0, linear(8e6, 0.0));
    plan.gravity = DVec3::new(0.0, -9.8, 0.0);
    plan.walls.push(plane(DVec3::NEG_Y, DVec3::ZERO)?);
    let sphere = NewParticle::at(DVec3::new(0.005, 0.095, 0.0), 0.005, MaterialIndex::new(0));
    let plan = plan.with_particles(vec![sphere]);
    let file = data.file("interactions/FreeFallSelfTest.ene");
    let rows = EnergyReader::open(file)?.collect::<Result<Vec<_>, _>>()?;
    let mut tally = Tally::default();
    let engine = beside_energies(plan, &saved_steps(dt, end, 500), &rows, &mut tally)?;
    let last = data.file("interactions/FreeFallSelfTest.restart");
    compare_state(&mut tally, &restart_file::read(&last)?, &engine)?;
    Ok(tally.finish(
        "a sphere bounces for a million steps",
        "MercuryDPM FreeFallSelfTest (.ene, .restart)",
        Tolerance {
            relative: 1e-6,
            floor: 1e-6,
        },
    ))
}

/// Stiffness (N/m) and dissipation (kg/s) for 1 kg bodies that collide in 0.01 s with a restitution of 0.1.
const SLUGGISH: (f64, f64) = (75_857.512_557_838_6, 230.258_509_299_404);

/// 3: a column of five unequal spheres comes to rest on a floor.
pub(super) fn newtons_cradle(data: &Data) -> Result<Comparison> {
    let (dt, end) = (1e-4, 8.0);
    let domain = (DVec3::ZERO, DVec3::new(1.0, 1.0, 4.0));
    let density = 6.0 / std::f64::consts::PI;
    let mut plan = Draft::new(dt, domain, density, linear(SLUGGISH.0, SLUGGISH.1));
    plan.gravity = DVec3::NEG_Z;
    plan.walls.push(plane(DVec3::NEG_Z, DVec3::ZERO)?);
    let mut top = 0.0;
    let spheres = (0..5).map(|k| {
        let radius = 0.5 * (1.0 - 0.1 * f64::from(k));
        top += 2.0 * radius;
        NewParticle::at(
            DVec3::new(0.5, 0.5, top - radius),
            radius,
            MaterialIndex::new(0),
        )
    });
    let spheres = spheres.collect();
    let plan = plan.with_particles(spheres);
    let engine = observe(plan, &saved_steps(dt, end, 1000), |_| Ok(()))?;
    let mut tally = Tally::default();
    // At rest, velocities are round-off: sqrt(g d) = 1 m/s is the speed of the problem.
    tally.scale("velocity", 1.0);
    let last = data.file("cg/NewtonsCradleSelfTest.restart");
    compare_state(&mut tally, &restart_file::read(&last)?, &engine)?;
    Ok(tally.finish(
        "a column of five spheres comes to rest",
        "MercuryDPM NewtonsCradleSelfTest (.restart)",
        AT_REST,
    ))
}

/// Overlaps of 1e-5 m are differences of positions of 1 m printed to 15 digits, and kick and kick are added in another order:
/// round-off is 1e-15 m / 1e-5 m = 1e-10 of an overlap, and of a force.
const AT_REST: Tolerance = Tolerance {
    relative: 1e-9,
    floor: 1e-10,
};

/// 4: 25 discs settle in a square packing.
pub(super) fn square_packing(data: &Data) -> Result<Comparison> {
    let (dt, end) = (2e-4, 1.0);
    let domain = (DVec3::ZERO, DVec3::new(5.0, 5.0, 0.0));
    let density = 4.0 / std::f64::consts::PI;
    let mut plan = Draft::new(dt, domain, density, linear(SLUGGISH.0, SLUGGISH.1));
    plan.dimensions = 2;
    plan.gravity = DVec3::NEG_Y;
    for (outward, point) in [
        (DVec3::NEG_X, DVec3::ZERO),
        (DVec3::X, DVec3::new(5.0, 0.0, 0.0)),
        (DVec3::NEG_Y, DVec3::ZERO),
        (DVec3::Y, DVec3::new(0.0, 5.0, 0.0)),
    ] {
        plan.walls.push(plane(outward, point)?);
    }
    let discs = (0..25).map(|k| {
        let place = DVec3::new(0.5 + f64::from(k / 5), 0.5 + f64::from(k % 5), 0.0);
        NewParticle::at(place, 0.5, MaterialIndex::new(0))
    });
    let discs = discs.collect();
    let plan = plan.with_particles(discs);
    let engine = observe(plan, &saved_steps(dt, end, 1000), |_| Ok(()))?;
    let mut tally = Tally::default();
    tally.scale("velocity", 1.0);
    let last = data.file("cg/SquarePackingSelfTest.restart");
    compare_state(&mut tally, &restart_file::read(&last)?, &engine)?;
    Ok(tally.finish(
        "25 discs settle in a square packing",
        "MercuryDPM SquarePackingSelfTest (.restart)",
        AT_REST,
    ))
}
