//! Scenes of the project, read and run through the library, against theory.

mod clumps;

use std::path::Path;

use anyhow::{Result, anyhow};
use mercury_engine::step::Engine;
use mercury_solver::plan::read_scene;
use mercury_solver::plan::{Plan, plan};

use crate::cases::Case;
use crate::cases::Tolerance::{Absolute, Digit, Relative};
use crate::scenes::{RECORDS, advance, particle, start, start_planned};

/// The plan of a scene below `scenes/`, with `KEY=VALUE` put on top.
///
/// # Errors
/// If the scene is wrong.
pub fn planned(scene: &str, overrides: &[String]) -> Result<Plan> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenes")
        .join(scene);
    let scene = read_scene(&path, overrides).map_err(|errors| anyhow!("{errors}"))?;
    plan(&scene).map_err(|errors| anyhow!("{errors}"))
}

/// The plan of a scene with another time step (s).
fn with_step(scene: &str, step: f64) -> Plan {
    planned(scene, &[format!("time.step={step:e}")]).expect("the scenes of the project are right")
}

/// All checks.
#[must_use]
pub fn all() -> Vec<Case> {
    let mut cases = quick();
    cases.extend(clumps::slow());
    cases
}

/// The checks that need less than a second each.
#[must_use]
pub fn quick() -> Vec<Case> {
    let mut cases = two_spheres();
    cases.extend(hertz_wall());
    cases.extend(clumps::quick());
    cases.push(press());
    cases
}

/// Restitution and duration (s) of the collision of two-spheres.toml.
#[must_use]
pub fn two_spheres_collide(step: f64) -> (f64, f64) {
    let plan = with_step("two-spheres.toml", step);
    let steps = plan.physics().steps;
    let mut engine = start_planned(plan);
    let approach = relative_velocity(&engine);
    let mut touching = 0.0;
    for _ in 0..steps {
        engine.step(RECORDS).expect("the motion stays finite");
        touching += engine.observation().particle_contacts as f64;
    }
    engine.complete_step().expect("the motion stays finite");
    (-relative_velocity(&engine) / approach, touching * step)
}

/// v_1 - v_0 along x, m/s.
fn relative_velocity(engine: &Engine) -> f64 {
    particle(engine, 1).velocity.x - particle(engine, 0).velocity.x
}

fn two_spheres() -> Vec<Case> {
    const CLOSED: &str =
        "closed form of the linear law: e = exp(-gamma t_c / 2m*) (Cundall & Strack 1979)";
    // The instant of the last contact is known to a step, whose dashpot force changes e by up to 20/s dt.
    let error = |step: f64| 20.0 * step;
    let mut cases = vec![
        Case::new(
            "scene two-spheres: restitution at the given step",
            0.700_735_1,
            Digit(1e-7),
            "the value required of this scene at dt = 4e-5 s",
            || two_spheres_collide(4e-5).0,
        ),
        Case::new(
            "scene two-spheres: duration of the contact (s)",
            0.02,
            Absolute(2.0 * 4e-5),
            "t_c = pi / sqrt(k/m* - (gamma/2m*)^2), to two steps",
            || two_spheres_collide(4e-5).1,
        ),
    ];
    for step in [4e-5, 2e-5, 1e-5, 5e-6] {
        cases.push(Case::new(
            format!("scene two-spheres: restitution with steps of {step:e} s"),
            0.7,
            Absolute(error(step)),
            CLOSED,
            move || two_spheres_collide(step).0,
        ));
    }
    cases
}

/// Rebound velocity (m/s) of hertz-wall.toml; the first contact is `phase` steps later than in the scene.
#[must_use]
pub fn hertz_wall_rebound(step: f64, phase: f64) -> f64 {
    let mut draft = with_step("hertz-wall.toml", step).draft();
    let steps = draft.steps + 1;
    // The sphere falls at 1 m/s.
    draft.particles[0].position.z += phase * step;
    let mut engine = start(draft);
    advance(&mut engine, steps);
    particle(&engine, 0).velocity.z
}

fn hertz_wall() -> Vec<Case> {
    let mut cases = vec![Case::new(
        "scene hertz-wall: rebound velocity (m/s)",
        0.401_075,
        Absolute(5e-6),
        "MercuryDPM at dt = 5e-7 s (OSHertzSelfTest, the same impact), 6 digits",
        || hertz_wall_rebound(5e-7, 0.0),
    )];
    for step in [5e-7, 2.5e-7, 1.25e-7] {
        for eighth in 0..8 {
            let phase = f64::from(eighth) / 8.0;
            cases.push(Case::new(
                format!(
                    "scene hertz-wall: restitution, first touch at {phase} of a step of {step:e} s"
                ),
                0.4,
                // The dashpot acts from the first overlap on, which is up to a step late.
                Absolute(0.4 * 0.012 * step / 5e-7),
                "given restitution; first order in dt (Antypov & Elliott 2011)",
                move || hertz_wall_rebound(step, phase),
            ));
        }
    }
    cases
}

fn press() -> Case {
    Case::new(
        "scene press: force on the lid (N)",
        20.0,
        Relative(0.01),
        "the target of its servo: at rest nothing else moves the lid",
        || {
            let overrides = ["insertions.feed.total.number=40", "time.end=0.5"].map(str::to_owned);
            let plan = planned("press.toml", &overrides);
            let plan = plan.expect("the scenes of the project are right");
            let (steps, lid) = (plan.physics().steps, plan.physics().walls.len() - 1);
            let mut engine = start_planned(plan);
            advance(&mut engine, steps);
            engine.observation().walls[lid].0.force.z
        },
    )
}
