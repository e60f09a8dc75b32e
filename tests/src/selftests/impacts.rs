//! Two short impacts: elasto-plastic spheres and Hertz' law with damping (set-ups 6 and 7).

use std::f64::consts::PI;

use anyhow::{Context, Result};
use glam::DVec3;
use mercury_engine::contact::normal::{effective_modulus, hertz_damping};
use mercury_engine::contact::{AnyNormal, Hertz, Plastic};
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_solver::plan::{Draft, NewParticle};

use super::Data;
use super::comparison::{Comparison, Tally, Tolerance};
use super::restart_file;
use super::run::{by_id, frictionless, observe, plane, saved_steps};

/// Two elasto-plastic spheres driven together so that the overlap would reach chi delta_m; 100 steps.
fn plastic_pair(chi: f64) -> Result<Engine> {
    let law = Plastic {
        loading_stiffness: 100.0,
        unloading_stiffness: 500.0,
        cohesion_stiffness: 100.0,
        penetration_depth: 0.05,
        dissipation: 0.0,
        clamp_tension: false,
    };
    let deepest = 500.0 / (500.0 - 100.0) * 0.05 * 0.5;
    let speed = (2.0 * 100.0 * (chi * deepest) * (chi * deepest)).sqrt();
    let dt = 0.04 * PI / (2.0f64 * 500.0).sqrt();
    let domain = (DVec3::ZERO, DVec3::new(3.0, 2.0, 2.0));
    let plan = Draft::new(dt, domain, 6.0 / PI, frictionless(AnyNormal::Plastic(law)));
    let sphere = |x: f64, speed: f64| NewParticle {
        velocity: DVec3::new(speed, 0.0, 0.0),
        ..NewParticle::at(DVec3::new(x, 1.0, 1.0), 0.5, MaterialIndex::new(0))
    };
    let spheres = vec![sphere(1.0, 0.5 * speed), sphere(2.0, -0.5 * speed)];
    observe(plan.with_particles(spheres), &[0, 100], |_| Ok(()))
}

/// 6: all branches of the elasto-plastic law.
pub(super) fn plastic(data: &Data) -> Result<Comparison> {
    let mut tally = Tally::default();
    // Final place and velocity of the left sphere for four depths, as the unit test states them.
    for (chi, place, velocity) in [
        (0.34, 0.995_546_292_935_715, -0.032_721_738_352_012),
        (0.69, 1.006_951_932_699_55, -0.013_868_323_195_315_4),
        (1.1, 1.008_404_671_235_01, -0.020_465_535_855_540_5),
        (1.37, 0.969_386_085_767_181, -0.163_049_415_300_304),
    ] {
        let engine = plastic_pair(chi)?;
        let left = by_id(&engine)[0];
        tally.add("position", place, left.position.x);
        tally.add("velocity", velocity, left.velocity.x);
    }
    let expected = restart_file::read(&data.file("unittests/PlasticForceUnitTest1.1.restart"))?;
    let engine = plastic_pair(1.1)?;
    for (expected, found) in expected.particles.iter().zip(by_id(&engine)) {
        tally.vector("position", expected.position, found.position);
        tally.vector("velocity", expected.velocity, found.velocity);
    }
    let records = engine.observation().records;
    let (contact, record) = (
        expected
            .contacts
            .first()
            .context("no contact in the file")?,
        records.first().context("no contact here")?,
    );
    tally.add("overlap", contact.overlap, record.overlap);
    tally.add("force", contact.force.x.abs(), record.force.x.abs());
    let deepest = contact.max_overlap.context("no largest overlap")?;
    tally.add("largest overlap", deepest, record.history[0]);
    Ok(tally.finish(
        "elasto-plastic pair, four depths",
        "MercuryDPM PlasticForceUnitTest (end states of the unit test, .restart)",
        Tolerance {
            relative: 1e-12,
            floor: 1e-13,
        },
    ))
}

/// 7: a 1 mm sphere hits a steel wall at 1 m/s with a restitution of 0.4.
///
/// The gap is 20 steps long: whether step 20 already touches is a matter of the last bit, and with a dashpot that grows with
/// overlap^(1/4) that bit shows in the seventh digit.
pub(super) fn hertz_wall(data: &Data) -> Result<Comparison> {
    let (dt, end) = (5e-7, 6e-5);
    let modulus = effective_modulus((1e9, 0.2), (210e9, 0.2));
    let law = Hertz::new(modulus, hertz_damping(0.4));
    let domain = (
        DVec3::new(-1e-3, -1e-3, 0.0),
        DVec3::new(1e-3, 1e-3, 2.2e-3),
    );
    let mut plan = Draft::new(dt, domain, 2500.0, frictionless(AnyNormal::Hertz(law)));
    plan.walls.push(plane(DVec3::NEG_Z, DVec3::ZERO)?);
    let sphere = NewParticle {
        velocity: DVec3::NEG_Z,
        ..NewParticle::at(DVec3::new(0.0, 0.0, 0.00101), 0.001, MaterialIndex::new(0))
    };
    let plan = plan.with_particles(vec![sphere]);
    let engine = observe(plan, &saved_steps(dt, end, 1), |_| Ok(()))?;
    let expected = restart_file::read(&data.file("osbenchmark/OSHertzSelfTest.restart"))?;
    let mut tally = Tally::default();
    for (expected, found) in expected.particles.iter().zip(by_id(&engine)) {
        tally.vector("position", expected.position, found.position);
        tally.vector("velocity", expected.velocity, found.velocity);
    }
    Ok(tally.finish(
        "Hertz sphere on a steel wall",
        "MercuryDPM OSHertzSelfTest (.restart)",
        Tolerance {
            relative: 2e-6,
            floor: 1e-12,
        },
    ))
}
