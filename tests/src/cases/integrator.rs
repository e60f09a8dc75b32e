//! T7: the time step.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    PairLaw, SpringRotation,
};
use mercury_engine::step::Engine;

use super::Case;
use super::Tolerance::{Absolute, Relative};
use crate::scenes::{advance, frictionless, particle, plan, plane, sphere, start};

/// Rows of T7.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = free_flight();
    cases.push(spring());
    cases.extend(momentum());
    cases
}

fn law() -> AnyPairLaw {
    frictionless(AnyNormal::Linear(Linear::new(1e4, 0.0)))
}

const START: DVec3 = dvec3(0.1, 0.2, 0.3);
const SPEED: DVec3 = dvec3(4.0, -5.0, 6.0);
const GRAVITY: DVec3 = dvec3(0.3, 0.0, -9.81);

/// 100 steps of free flight with a spin of 10 rad/s about z.
fn flight(time_step: f64) -> Engine {
    let mut plan = plan(time_step, 1000.0, law());
    plan.gravity = GRAVITY;
    plan.orientations = true;
    let mut engine = start(plan.with_particles(vec![sphere(START, 0.1, SPEED, 10.0 * DVec3::Z)]));
    advance(&mut engine, 100);
    engine
}

fn free_flight() -> Vec<Case> {
    const SOURCE: &str = "velocity Verlet is exact under constant acceleration (Swope et al. 1982)";
    let mut cases = Vec::new();
    for time_step in [0.1, 0.003] {
        let time = 100.0 * time_step;
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let position = (START + SPEED * time + 0.5 * GRAVITY * time * time)[axis];
            let velocity = (SPEED + GRAVITY * time)[axis];
            // 100 sums of round-off 1e-16 each, of values up to 500 m
            cases.push(Case::new(
                format!("T7 engine: free flight, {name} after 100 steps of {time_step} s (m)"),
                position,
                Relative(1e-13),
                SOURCE,
                move || particle(&flight(time_step), 0).position[axis],
            ));
            cases.push(Case::new(
                format!("T7 engine: free flight, v_{name} after 100 steps of {time_step} s (m/s)"),
                velocity,
                Relative(1e-13),
                SOURCE,
                move || particle(&flight(time_step), 0).velocity[axis],
            ));
        }
    }
    cases.push(Case::new(
        "T7 engine: angle after 1 s at 10 rad/s in 100 steps (rad)",
        10.0,
        Relative(1e-12),
        "each step turns by exactly |ω| dt",
        || {
            let engine = flight(0.01);
            let Some(orientations) = &engine.particles.orientations else {
                return f64::NAN;
            };
            let turned = orientations[0] * DVec3::X;
            // one whole turn and some more
            TAU + turned.y.atan2(turned.x).rem_euclid(TAU)
        },
    ));
    cases
}

/// cos(W dt) = 1 − (ω dt)²/2 of an oscillator, from three successive positions about the rest position.
fn spring() -> Case {
    let (time_step, stiffness, mass) = (4e-4, 1e4, 1.0);
    let squared = stiffness / mass * time_step * time_step;
    Case::new(
        "T7 engine: cosine of the phase of a spring in a step",
        1.0 - 0.5 * squared,
        // displacements of 4 mm out of positions of 0.5 m: 1e-16 0.5/0.004
        Relative(1e-13),
        "dispersion of the leapfrog (Hairer, Lubich & Wanner 2003)",
        move || {
            let mut plan = plan(time_step, 6.0 / PI, law());
            plan.gravity = dvec3(0.0, 0.0, -100.0);
            plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
            let rest = 0.5 - 100.0 * mass / stiffness;
            let ball = sphere(dvec3(0.0, 0.0, rest + 0.005), 0.5, DVec3::ZERO, DVec3::ZERO);
            let mut engine = start(plan.with_particles(vec![ball]));
            let mut at = [0.0; 3];
            advance(&mut engine, 10);
            for height in &mut at {
                *height = particle(&engine, 0).position.z - rest;
                advance(&mut engine, 1);
            }
            0.5 * (at[0] + at[2]) / at[1]
        },
    )
}

/// Change of linear and angular momentum about the origin in an oblique collision with friction, over Σ m|v|.
fn momentum() -> Vec<Case> {
    const SOURCE: &str = "equal and opposite forces through one point";
    let collide = || {
        let law = PairLaw {
            normal: AnyNormal::Linear(Linear::new(1e4, 2.0)),
            tangential: AnyTangential::Linear(LinearFriction {
                stiffness: 4e3,
                dissipation: 0.5,
                friction: 0.5,
                static_friction: 0.5,
                rotation: SpringRotation::Project,
                limits: CoulombLimits::Bounded,
            }),
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        };
        let one = sphere(
            DVec3::ZERO,
            0.05,
            dvec3(0.3, 0.1, 0.0),
            dvec3(1.0, 20.0, -3.0),
        );
        let two = sphere(
            dvec3(0.081, 0.005, 0.002),
            0.03,
            dvec3(-0.4, 0.0, 0.05),
            dvec3(-10.0, 2.0, 8.0),
        );
        let mut engine = start(plan(1e-4, 2000.0, law).with_particles(vec![one, two]));
        let before = momenta(&engine);
        advance(&mut engine, 600);
        let after = momenta(&engine);
        let scale = before.2;
        (
            (after.0 - before.0).length() / scale,
            (after.1 - before.1).length() / (scale * 0.1),
        )
    };
    vec![
        Case::new(
            "T7 engine: linear momentum lost in a collision",
            0.0,
            Absolute(1e-13),
            SOURCE,
            move || collide().0,
        ),
        Case::new(
            "T7 engine: angular momentum lost in a collision",
            0.0,
            Absolute(1e-13),
            SOURCE,
            move || collide().1,
        ),
    ]
}

/// Linear momentum (kg m/s), angular momentum about the origin (kg m²/s) and Σ m|v| of solid spheres.
fn momenta(engine: &Engine) -> (DVec3, DVec3, f64) {
    let particles = &engine.particles;
    let mut sums = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for (record, &mass) in particles.records.iter().zip(&particles.masses) {
        let momentum = record.velocity * mass;
        let spin = record.angular_velocity * (0.4 * mass * record.radius * record.radius);
        sums.0 += momentum;
        sums.1 += record.position.cross(momentum) + spin;
        sums.2 += momentum.length();
    }
    sums
}
