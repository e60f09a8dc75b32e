//! Hertz-Mindlin contacts with a wall, contact by contact: set-ups 22 to 24.

use anyhow::{Context, Result, ensure};
use glam::DVec3;
use mercury_common::formats::fstat::{FstatFrame, FstatReader};
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Hertz, Mindlin, PairLaw,
};
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_solver::plan::{Draft, NewParticle, PrescribedMotion};

use super::Data;
use super::comparison::{Comparison, Tally, Tolerance};
use super::run::{drive, observe, plane, saved_steps};

/// E* and G* of all three, Pa. The source's setter gives this G* for nu = 0.3.
const MODULI: (f64, f64) = (1e5, 65_000.0);

/// Hertz-Mindlin with mu = 0.1 and the factor 2/3 of the source.
fn law(normal_damping: f64) -> mercury_engine::contact::registry::AnyPairLaw {
    PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(MODULI.0, normal_damping)),
        tangential: AnyTangential::Mindlin(
            Mindlin::new(MODULI.1, 2.0 / 3.0, 0.0, 0.1, 0.1).with_limits(CoulombLimits::Elastic),
        ),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

fn frames(data: &Data, file: &str) -> Result<Vec<FstatFrame>> {
    let frames = FstatReader::open(data.file(file))?;
    Ok(frames.collect::<Result<Vec<_>, _>>()?)
}

/// Adds the numbers of the one contact that a frame may hold. A contact that one side sees with an overlap below `grazing` (m)
/// may be absent on the other.
fn compare_contact(
    tally: &mut Tally,
    frame: &FstatFrame,
    engine: &Engine,
    grazing: f64,
) -> Result<()> {
    let records = engine.observation().records;
    ensure!(
        frame.contacts.len() <= 1 && records.len() <= 1,
        "one contact at most"
    );
    tally.add("time", frame.time, engine.time());
    match (frame.contacts.first(), records.first()) {
        (Some(expected), Some(found)) => {
            tally.vector("contact point", expected.contact_point, found.point);
            tally.add("overlap", expected.overlap, found.overlap);
            tally.add(
                "tangential overlap",
                expected.tangential_overlap,
                found.tangential_overlap,
            );
            let normal = found.force.dot(found.normal);
            tally.add("normal force", expected.normal_force, normal);
            let tangential = found.tangential.length();
            tally.add("tangential force", expected.tangential_force, tangential);
            // Without shear the tangential numbers are round-off of the normal ones.
            tally.scale("tangential force", expected.normal_force.abs());
            tally.scale("tangential overlap", expected.overlap.abs());
            tally.vector("force", expected.force(), found.force);
            // The file's normal points into the wall.
            tally.vector("normal", -expected.normal, found.normal);
        }
        (None, None) => tally.add("contacts", 0.0, 0.0),
        (Some(contact), None) => ensure!(contact.overlap.abs() < grazing, "a contact is missing"),
        (None, Some(contact)) => ensure!(contact.overlap < grazing, "a contact too many"),
    }
    Ok(())
}

/// 22: a grazing elastic impact on a wall.
pub(super) fn oblique_impact(data: &Data) -> Result<Comparison> {
    let (dt, end) = (2.5e-9, 5e-4);
    let domain = (DVec3::ZERO, DVec3::new(0.01, 0.01, 0.0));
    let mut plan = Draft::new(dt, domain, 6.0 / std::f64::consts::PI, law(0.0));
    plan.walls.push(plane(DVec3::NEG_Y, DVec3::ZERO)?);
    let plan = plan.with_particles(vec![NewParticle {
        velocity: DVec3::new(10.0, -1.0, 0.0),
        ..NewParticle::at(
            DVec3::new(0.005, 0.005_005, 0.0),
            0.005,
            MaterialIndex::new(0),
        )
    }]);
    let frames = frames(data, "interactions/ObliqueImpactSelfTest.fstat")?;
    let saved = saved_steps(dt, end, 500);
    ensure!(saved.len() == frames.len(), "frame count");
    let mut tally = Tally::default();
    let mut frames = frames.iter();
    observe(plan, &saved, |engine| {
        let frame = frames.next().context("more states than frames")?;
        // The gap is 4 frames long to the last bit: sums of 2000 steps are uncertain by 2000 eps 0.005 m.
        compare_contact(&mut tally, frame, engine, 1e-14)
    })?;
    Ok(tally.finish(
        "grazing Hertz-Mindlin impact on a wall",
        "MercuryDPM ObliqueImpactSelfTest (.fstat)",
        Tolerance::TEN_DIGITS,
    ))
}

/// Puts the only particle where it will be at `place` (m), with `velocity` (m/s), after the drift of the next step.
fn lead(engine: &mut Engine, place: DVec3, velocity: DVec3) {
    let dt = engine.physics().time_step;
    engine.particles.records[0].position = place - velocity * dt;
    engine.particles.prescribed[0].velocity = velocity.to_array().map(Some);
}

/// A sphere of 0.25 m whose motion is prescribed, on a floor.
fn led_sphere(dt: f64, height: f64) -> Result<Draft> {
    let domain = (DVec3::new(-0.25, -0.25, 0.0), DVec3::new(0.25, 0.25, 0.5));
    let mut plan = Draft::new(dt, domain, 6.0 / std::f64::consts::PI, law(2.0));
    plan.walls.push(plane(DVec3::NEG_Z, DVec3::ZERO)?);
    Ok(plan.with_particles(vec![NewParticle {
        prescribed: PrescribedMotion::boxed([Some(0.0); 3], [Some(0.0); 3]),
        ..NewParticle::at(DVec3::new(0.0, 0.0, height), 0.25, MaterialIndex::new(0))
    }]))
}

/// 23: pressed into the wall and pulled back, damped. The test prescribes velocities of the wrong sign; so do we.
///
/// The wall of the source is displaced by the last bit of a quaternion, 5e-17 m: with an overlap of 1e-16 m at first touch the
/// dashpot, which grows with overlap^(1/4), shows it in a force of 2e-4 N of 122 N. Hence the floor: 1e-9 m, 7e-6 N.
pub(super) fn loading(data: &Data) -> Result<Comparison> {
    let end = 2.0 * 0.015 / 0.01;
    let dt = 2e-3 * end;
    let frames = frames(data, "unittests/MindlinSelfTestLoading.fstat")?;
    let saved = saved_steps(dt, end, 1);
    ensure!(saved.len() == frames.len(), "frame count");
    let mut tally = Tally::default();
    let mut rows = frames.iter();
    // Added up as in the source: round-off decides in which step the motion turns.
    let mut time: f64 = 0.0;
    drive(
        led_sphere(dt, 0.25)?,
        &saved,
        |engine| {
            let (sink, speed) = if time <= 1.5 {
                (0.01 * time, 0.01)
            } else {
                (0.03 - 0.01 * time, -0.01)
            };
            let place = DVec3::new(0.0, 0.0, 0.25 - sink);
            lead(engine, place, DVec3::new(0.0, 0.0, speed));
            time += dt;
        },
        |engine| {
            let frame = rows.next().context("more states than frames")?;
            compare_contact(&mut tally, frame, engine, 1e-12)
        },
    )?;
    Ok(tally.finish(
        "Hertz contact loaded and unloaded",
        "MercuryDPM MindlinSelfTestLoading (.fstat, every step)",
        Tolerance {
            relative: 1e-9,
            floor: 6e-8,
        },
    ))
}

/// 24: sheared to and fro at constant overlap, through sticking and sliding.
pub(super) fn shearing(data: &Data) -> Result<Comparison> {
    // One cycle: four strokes of 0.0025 m at 0.01 m/s.
    let (stroke, speed) = (0.0025, 0.01);
    let (dt, end) = (4e-4, 4.0 * stroke / speed);
    let frames = frames(
        data,
        "unittests/MindlinSelfTestNormalAndTangentialLoading.fstat",
    )?;
    let saved = saved_steps(dt, end, 1);
    ensure!(saved.len() == frames.len(), "frame count");
    let mut tally = Tally::default();
    let mut rows = frames.iter();
    // Added up as in the source: round-off decides in which step the motion turns.
    let mut time: f64 = 0.0;
    let height = 0.25 - 0.015;
    drive(
        led_sphere(dt, height)?,
        &saved,
        |engine| {
            let turns = (time / 0.5 + 0.5).floor();
            let (x, speed) = if turns % 2.0 == 0.0 {
                (0.0025 - 0.01 * time, -0.01)
            } else {
                (-0.005 + 0.01 * time, 0.01)
            };
            let velocity = DVec3::new(speed, 0.0, 0.0);
            lead(engine, DVec3::new(x, 0.0, height), velocity);
            time += dt;
        },
        |engine| {
            let frame = rows.next().context("more states than frames")?;
            compare_contact(&mut tally, frame, engine, 0.0)
        },
    )?;
    Ok(tally.finish(
        "Mindlin contact sheared to and fro",
        "MercuryDPM MindlinSelfTestNormalAndTangentialLoading (.fstat, every step)",
        Tolerance::TEN_DIGITS,
    ))
}
