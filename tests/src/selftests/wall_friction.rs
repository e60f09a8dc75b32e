//! An oblique impact on a wall with five sets of friction parameters: set-ups 8 to 12 (ForceSelfTest0 to 4), every step.

use anyhow::{Context, Result, ensure};
use glam::DVec3;
use mercury_common::formats::data::DataReader;
use mercury_common::formats::ene::EnergyReader;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    PairLaw, SpringRotation,
};
use mercury_engine::state::MaterialIndex;
use mercury_solver::plan::{Draft, NewParticle};

use super::Data;
use super::comparison::{Comparison, Tally, Tolerance};
use super::discs::compare_frame;
use super::run::{compare_energies, energies, observe, plane};

/// Collision time of two of the particles, s.
const COLLISION_TIME: f64 = 8.476_212_258_938_5e-6;
/// Sliding friction where it is finite.
const FRICTION: f64 = 0.215_915_834_330_101;

/// Friction, k_t and gamma_t of the five runs, and their files and names.
const RUNS: [(&str, &str, f64, f64, f64); 5] = [
    (
        "oblique impact on a wall, no friction",
        "interactions/ForceSelfTest0",
        0.0,
        0.0,
        0.0,
    ),
    (
        "oblique impact on a wall, sliding",
        "interactions/ForceSelfTest1",
        FRICTION,
        0.0,
        1e20,
    ),
    (
        "oblique impact on a wall, sliding with a spring",
        "interactions/ForceSelfTest2",
        FRICTION,
        1.0,
        1e20,
    ),
    (
        "oblique impact on a wall, tangential dashpot",
        "interactions/ForceSelfTest3",
        1e20,
        0.0,
        0.004_434_839_899_723_96,
    ),
    (
        "oblique impact on a wall, tangential spring",
        "interactions/ForceSelfTest4",
        1e20,
        86_495.487_159_152_2,
        0.0,
    ),
];

/// One of the five runs.
pub(super) fn run(data: &Data, index: usize) -> Result<Comparison> {
    let (name, file, friction, stiffness, dissipation) = RUNS[index];
    let radius = 0.000_714_816_739_582_627;
    let dt = COLLISION_TIME / 200.0;
    let law = PairLaw {
        normal: AnyNormal::Linear(Linear::new(422_114.037_641_424, 0.147_429_601_196_307)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness,
            dissipation,
            friction,
            static_friction: friction,
            rotation: SpringRotation::Incremental,
            limits: CoulombLimits::Total,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let domain = (DVec3::ZERO, DVec3::new(0.005, 0.005, 0.005));
    let mut plan = Draft::new(dt, domain, 2000.0, law);
    plan.gravity = DVec3::new(0.0, -9.8, 0.0);
    plan.orientations = true;
    plan.walls
        .push(plane(DVec3::X, DVec3::new(0.0025, 0.0, 0.0))?);
    let plan = plan.with_particles(vec![NewParticle {
        velocity: DVec3::new(0.076_859_099_532_608_8, 0.072_577_551_312_206_7, 0.0),
        ..NewParticle::at(
            DVec3::new(0.0025 - radius, 0.0025, 0.0025),
            radius,
            MaterialIndex::new(0),
        )
    }]);
    let frames = DataReader::open(data.file(&format!("{file}.data")))?;
    let frames = frames.collect::<Result<Vec<_>, _>>()?;
    let rows = EnergyReader::open(data.file(&format!("{file}.ene")))?;
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    ensure!(
        frames.len() == rows.len(),
        "the files have different lengths"
    );
    let saved: Vec<u64> = (0..frames.len() as u64).collect();
    let mut tally = Tally::default();
    let mut files = frames.iter().zip(&rows);
    observe(plan, &saved, |engine| {
        let (frame, row) = files.next().context("more states than frames")?;
        compare_frame(&mut tally, frame, engine)?;
        compare_energies(&mut tally, row, &energies(engine));
        Ok(())
    })?;
    Ok(tally.finish(
        name,
        "MercuryDPM ForceSelfTest (.data, .ene, every step)",
        Tolerance::TEN_DIGITS,
    ))
}
