//! Discs: frames of plane problems, and the disc that starts inside another (set-up 19).

use anyhow::{Context, Result, ensure};
use glam::DVec3;
use mercury_common::formats::data::{DataFrame, DataReader};
use mercury_common::formats::orientation::euler_from_quaternion;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    PairLaw, SpringRotation,
};
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_solver::plan::{Draft, NewParticle};

use super::Data;
use super::comparison::{Comparison, Tally, Tolerance};
use super::run::{observe, saved_steps};

/// Adds every number of a frame of a plane problem.
pub(super) fn compare_frame(tally: &mut Tally, frame: &DataFrame, engine: &Engine) -> Result<()> {
    ensure!(
        frame.particles.len() == engine.particles.len(),
        "particle count"
    );
    tally.add("time", frame.time, engine.time());
    for (expected, row) in frame.particles.iter().zip(engine.particles.rows_by_id()) {
        let found = &engine.particles.records[row as usize];
        tally.add("x", expected.position.x, found.position.x);
        tally.add("y", expected.position.y, found.position.y);
        tally.add("x velocity", expected.velocity.x, found.velocity.x);
        tally.add("y velocity", expected.velocity.y, found.velocity.y);
        tally.add("radius", expected.radius, found.radius);
        tally.add(
            "angular velocity",
            expected.angular_velocity.z,
            found.angular_velocity.z,
        );
        if let Some(orientations) = &engine.particles.orientations {
            let angles = euler_from_quaternion(orientations[row as usize]);
            tally.add("angle", expected.angles.z, angles.z);
        }
    }
    Ok(())
}

/// 19: a small disc starts inside a large one, with friction.
pub(super) fn extreme_overlap(data: &Data) -> Result<Comparison> {
    let (dt, end) = (1e-7, 0.01);
    let law = PairLaw {
        normal: AnyNormal::Linear(Linear::new(10.0, 0.0)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 20.0 / 7.0,
            dissipation: 0.0,
            friction: 1.0,
            static_friction: 1.0,
            rotation: SpringRotation::Incremental,
            limits: CoulombLimits::Total,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    // Wider than the source's, whose particles may leave it.
    let domain = (DVec3::splat(-0.05), DVec3::splat(0.05));
    let mut plan = Draft::new(dt, domain, 2000.0, law);
    plan.dimensions = 2;
    plan.gravity = DVec3::new(0.0, -9.8, 0.0);
    plan.orientations = true;
    plan.startup_increment = true;
    let small = NewParticle {
        velocity: DVec3::X,
        ..NewParticle::at(DVec3::new(0.0, 0.015, 0.0), 0.001, MaterialIndex::new(0))
    };
    let large = NewParticle::at(DVec3::new(0.0, 0.01, 0.0), 0.01, MaterialIndex::new(0));
    let plan = plan.with_particles(vec![large, small]);
    let frames = DataReader::open(data.file("unittests/ExtremeOverlapUnitTest.data"))?;
    let frames = frames.collect::<Result<Vec<_>, _>>()?;
    let saved = saved_steps(dt, end, 1000);
    ensure!(saved.len() == frames.len(), "frame count");
    let mut tally = Tally::default();
    let mut frames = frames.iter();
    observe(plan, &saved, |engine| {
        let frame = frames.next().context("more states than frames")?;
        compare_frame(&mut tally, frame, engine)
    })?;
    Ok(tally.finish(
        "a disc inside another one",
        "MercuryDPM ExtremeOverlapUnitTest (.data)",
        Tolerance::TEN_DIGITS,
    ))
}
