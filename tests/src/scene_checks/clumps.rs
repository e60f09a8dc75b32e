//! The scenes of clumps below `scenes/clumps`.

use std::sync::OnceLock;

use glam::DVec3;
use mercury_engine::state::Body;
use mercury_engine::step::Engine;
use mercury_solver::plan::Draft;

use super::planned;
use crate::cases::Case;
use crate::cases::Tolerance::{Absolute, Relative};
use crate::scenes::{RECORDS, advance, start};

/// The checks of single bodies.
pub(super) fn quick() -> Vec<Case> {
    let mut cases = t_bar();
    cases.extend(wheels());
    cases.extend(egg());
    cases
}

/// The checks that need seconds.
pub(super) fn slow() -> Vec<Case> {
    let mut cases = gases();
    cases.extend(rattleback());
    cases.extend(dominoes());
    cases.extend(drum());
    cases
}

fn scene(name: &str) -> Draft {
    let plan = planned(&format!("clumps/{name}.toml"), &[]);
    plan.expect("the scenes of the project are right").draft()
}

fn body(engine: &Engine, index: usize) -> Body {
    engine.particles.bodies()[index]
}

/// The T-bar with another spin (rad/s) and step (s).
fn rotor(spin: DVec3, step: f64) -> Engine {
    let mut plan = scene("t-bar");
    plan.bodies[0].angular_velocity = spin;
    plan.time_step = step;
    start(plan)
}

/// Angular velocity in the body frame, rad/s.
fn in_body_frame(body: &Body) -> DVec3 {
    body.orientation.inverse() * body.angular_velocity
}

/// Mean time (s) between the instants, up to `end` (s), at which the spin about the second axis changes its sign.
fn time_between_flips(spin: DVec3, end: f64) -> f64 {
    let step = 1e-3;
    let mut engine = rotor(spin, step);
    let mut flips = Vec::new();
    let mut before = in_body_frame(&body(&engine, 0)).y;
    for k in 1..=(end / step).round() as u64 {
        advance(&mut engine, 1);
        let now = in_body_frame(&body(&engine, 0)).y;
        if before * now < 0.0 {
            flips.push((k as f64 - now / (now - before)) * step);
        }
        before = now;
    }
    (flips[flips.len() - 1] - flips[0]) / (flips.len() - 1) as f64
}

const FAST: DVec3 = DVec3::new(0.0, 20.0, 0.01);
const SLOW: DVec3 = DVec3::new(0.01, 2.0, 0.01);

/// Error of the angular velocity in the body frame after 1 s of the fast spin, rad/s.
fn rotor_error(step: f64) -> f64 {
    let mut engine = rotor(FAST, step);
    advance(&mut engine, (1.0 / step).round() as u64);
    let reference = DVec3::new(-0.603_232_76, -19.990_369_56, 0.422_231_60);
    (in_body_frame(&body(&engine, 0)) - reference).length()
}

fn t_bar() -> Vec<Case> {
    const PERIOD: &str = "2 K(k) sqrt(I1 I2 I3 / ((I3 - I2)(L^2 - 2 E I1))) of Euler's equations (Landau & Lifshitz, Mechanics, section 37)";
    const REFERENCE: &str = "Euler's equations by an integrator of eighth order at 1e-13";
    vec![
        Case::new(
            "scene clumps/t-bar: time between flips (s)",
            10.394_351_63,
            // Second order in the step; what the step is to the period of the spin, squared: (2e-3)^2 of the period.
            Relative(2e-5),
            PERIOD,
            || time_between_flips(SLOW, 32.0),
        ),
        Case::new(
            "scene clumps/t-bar: time between flips at 20 rad/s (s)",
            1.347_464_33,
            Relative(2e-4),
            PERIOD,
            || time_between_flips(FAST, 5.0),
        ),
        Case::new(
            "scene clumps/t-bar: angular velocity at 20 rad/s after 1 s, error (rad/s)",
            0.0,
            Absolute(2e-3),
            REFERENCE,
            || rotor_error(1e-4),
        ),
        Case::new(
            "scene clumps/t-bar: order of the error in the step",
            2.0,
            Absolute(0.05),
            REFERENCE,
            || (rotor_error(1e-3) / rotor_error(5e-4)).log2(),
        ),
        Case::new(
            "scene clumps/t-bar: change of the energy over 32 s, relative",
            0.0,
            // (w dt)^2/12 of the share of energy that the flips move to and fro.
            Absolute(1e-6),
            "no torque: the energy is constant",
            || {
                let mut engine = rotor(SLOW, 1e-3);
                let first = body(&engine, 0).rotational_energy();
                let mut worst = 0.0f64;
                for _ in 0..3200 {
                    advance(&mut engine, 10);
                    worst = worst.max((body(&engine, 0).rotational_energy() / first - 1.0).abs());
                }
                worst
            },
        ),
    ]
}

/// The results for a gas: rotational over translational energy averaged over the last two thirds of the run, the largest relative
/// change of the energy, and the change of the momentum over the root mean square momentum of a body.
fn gas(name: &str) -> [f64; 3] {
    let plan = scene(name);
    let steps = plan.steps;
    let mut engine = start(plan);
    let state = |engine: &Engine| {
        let bodies = engine.particles.bodies().iter();
        bodies.fold([0.0; 6], |sum, body| {
            let p = body.mass * body.velocity;
            let kinetic = 0.5 * p.length_squared() / body.mass;
            [
                sum[0] + kinetic,
                sum[1] + body.rotational_energy(),
                sum[2] + p.x,
                sum[3] + p.y,
                sum[4] + p.z,
                sum[5] + body.mass,
            ]
        })
    };
    let first = state(&engine);
    let (mut kinetic, mut rotational, mut worst) = (0.0, 0.0, 0.0f64);
    let looks = 200;
    let mut last = first;
    for look in 0..looks {
        engine
            .steps_at_once(steps / looks, RECORDS)
            .expect("the motion stays finite");
        engine.complete_step().expect("the motion stays finite");
        last = state(&engine);
        let energy = last[0] + last[1] + engine.observation().elastic_energy;
        worst = worst.max((energy / (first[0] + first[1]) - 1.0).abs());
        if 3 * look > looks {
            kinetic += last[0];
            rotational += last[1];
        }
    }
    let change = DVec3::new(last[2] - first[2], last[3] - first[3], last[4] - first[4]);
    let number = engine.particles.bodies().len() as f64;
    let typical = (2.0 * first[0] * first[5]).sqrt() / number;
    [rotational / kinetic, worst, change.length() / typical]
}

fn gases() -> Vec<Case> {
    static ROD: OnceLock<[f64; 3]> = OnceLock::new();
    static T_BAR: OnceLock<[f64; 3]> = OnceLock::new();
    const SHARE: &str = "equipartition: the same energy in every degree of freedom";
    let mut cases = Vec::new();
    for (name, reported, expected, spread) in [
        // Standard deviation of E_rot/E_tr at one instant: sqrt(2/(2 N) + 2/(3 N)) of N = 60 and (3 and 3 of N = 40) of some
        // ten independent ones: 5 and 6 %; three of them.
        ("rod", &ROD, 2.0 / 3.0, 0.15),
        ("t-bar", &T_BAR, 1.0, 0.18),
    ] {
        let of = move |k: usize| reported.get_or_init(|| gas(&format!("{name}-gas")))[k];
        cases.push(Case::new(
            format!("scene clumps/{name}-gas: rotational over translational energy"),
            expected,
            Relative(spread),
            SHARE,
            move || of(0),
        ));
        cases.push(Case::new(
            format!("scene clumps/{name}-gas: change of the energy, relative"),
            0.0,
            // Second order in the step, contacts of some 20 steps.
            Absolute(5e-3),
            "elastic contacts keep the energy",
            move || of(1),
        ));
        cases.push(Case::new(
            format!("scene clumps/{name}-gas: change of the momentum, over that of a body"),
            0.0,
            Absolute(1e-10),
            "the forces between bodies are equal and opposite",
            move || of(2),
        ));
    }
    cases
}

fn wheels() -> Vec<Case> {
    let rolling = |at: f64| {
        let plan = scene("wheels");
        let steps = (at / plan.time_step).round() as u64;
        let mut engine = start(plan);
        advance(&mut engine, steps);
        body(&engine, 0)
    };
    vec![
        Case::new(
            "scene clumps/wheels: acceleration (m/s^2)",
            1.923_841 / (1.0 + 2.0 / 3.0),
            // Settling into the overlap in the first hundredth of a second; contact radius smaller by the overlap of 1e-5 m.
            Relative(1e-3),
            "g sin(slope) / (1 + I/(M R^2)), I = 2/3 M R^2",
            move || (rolling(1.0).velocity.x - rolling(0.5).velocity.x) / 0.5,
        ),
        Case::new(
            "scene clumps/wheels: slip after 1 s, over the speed",
            0.0,
            Absolute(1e-3),
            "v = w R",
            move || {
                let wheels = rolling(1.0);
                1.0 - wheels.angular_velocity.y * 0.05 / wheels.velocity.x
            },
        ),
    ]
}

/// Spin about the vertical at the end over that at the start.
fn rattleback_spin(sign: f64) -> f64 {
    let mut plan = scene("rattleback");
    plan.bodies[0].angular_velocity.z *= sign;
    let (steps, spin) = (plan.steps, plan.bodies[0].angular_velocity.z);
    let mut engine = start(plan);
    advance(&mut engine, steps);
    body(&engine, 0).angular_velocity.z / spin
}

fn rattleback() -> Vec<Case> {
    const WALKER: &str =
        "a rattleback turns back in one direction of spin only (Walker 1896; Bondi 1986)";
    vec![
        Case::new(
            "scene clumps/rattleback: spin after 3 s over that at the start, against its sense",
            -0.8,
            Absolute(0.2),
            WALKER,
            || rattleback_spin(1.0),
        ),
        Case::new(
            "scene clumps/rattleback: the same, spun the other way",
            0.9,
            Absolute(0.1),
            WALKER,
            || rattleback_spin(-1.0),
        ),
    ]
}

/// Mean speeds (m/s) of the wave from domino 8 to 12 and from 12 to 16, and the largest deviation of the potential energy from a
/// straight line in between, over its fall; the first domino is pushed `push` times as hard as in the scene.
fn domino_wave(push: f64) -> [f64; 3] {
    let mut plan = scene("dominoes");
    plan.bodies[0].velocity *= push;
    plan.bodies[0].angular_velocity *= push;
    let gravity = plan.gravity;
    let mut engine = start(plan);
    let mut fallen = [f64::NAN; 20];
    let mut energies = Vec::new();
    let every = 20;
    while fallen[16].is_nan() && engine.time() < 2.0 {
        advance(&mut engine, every);
        let time = engine.time();
        let mut energy = 0.0;
        for (k, body) in engine.particles.bodies().iter().enumerate() {
            // The height of the domino leans by more than 0.3.
            let lean = (body.orientation * DVec3::X).z.acos();
            if fallen[k].is_nan() && lean > 0.3 {
                fallen[k] = time;
            }
            energy -= body.mass * gravity.dot(body.position);
        }
        if !fallen[8].is_nan() {
            energies.push((time, energy));
        }
    }
    let pitch = 0.02;
    let speed = |from: usize, to: usize| pitch * (to - from) as f64 / (fallen[to] - fallen[from]);
    let (first, last) = (energies[0], energies[energies.len() - 1]);
    let line = |time: f64| first.1 + (last.1 - first.1) * (time - first.0) / (last.0 - first.0);
    let off = energies.iter().map(|&(t, e)| (e - line(t)).abs());
    [
        speed(8, 12),
        speed(12, 16),
        off.fold(0.0, f64::max) / (first.1 - last.1),
    ]
}

fn dominoes() -> Vec<Case> {
    static GENTLE: OnceLock<[f64; 3]> = OnceLock::new();
    static HARD: OnceLock<[f64; 3]> = OnceLock::new();
    let gentle = |k: usize| GENTLE.get_or_init(|| domino_wave(1.0))[k];
    let hard = |k: usize| HARD.get_or_init(|| domino_wave(2.0))[k];
    const STEADY: &str = "the wave has a speed of its own (Stronge 1987, Proc. R. Soc. A 409, 199)";
    vec![
        Case::new(
            "scene clumps/dominoes: speed from 12 to 16 over that from 8 to 12",
            1.0,
            Absolute(0.05),
            STEADY,
            move || gentle(1) / gentle(0),
        ),
        Case::new(
            "scene clumps/dominoes: speed from 12 to 16 after a push twice as hard, over that of the scene",
            1.0,
            Absolute(0.03),
            STEADY,
            move || hard(1) / gentle(1),
        ),
        Case::new(
            "scene clumps/dominoes: potential energy, deviation from a straight line over its fall",
            0.0,
            // One domino of eight falls at a time, in a fall that is not itself straight.
            Absolute(0.05),
            "a steady wave lets the same energy go in every interval",
            move || gentle(2),
        ),
    ]
}

fn egg() -> Vec<Case> {
    static REST: OnceLock<Body> = OnceLock::new();
    let rest = || {
        *REST.get_or_init(|| {
            let plan = scene("egg");
            let steps = plan.steps;
            let mut engine = start(plan);
            advance(&mut engine, steps);
            body(&engine, 0)
        })
    };
    vec![
        Case::new(
            "scene clumps/egg: height of the centre of mass at the end (m)",
            // Radius of the blunt end less the depth of the centre of mass, less the overlap M g / k.
            0.02 - 0.006 - 0.05 * 9.81 / 2e4,
            Absolute(2e-5),
            "the only stable pose: upright on the blunt end",
            move || rest().position.z,
        ),
        Case::new(
            "scene clumps/egg: upward component of its axis at the end",
            1.0,
            // Rolling resistance 0.01 holds it at up to mu_r R / 6 mm of lean: 0.03; 1 - cos of it.
            Absolute(1e-3),
            "the only stable pose: upright on the blunt end",
            move || (rest().orientation * DVec3::X).z,
        ),
    ]
}

fn drum() -> Vec<Case> {
    // Torque of the drum on its content about the axis and moment of the content's weight, averaged over the last second.
    let balance = || {
        let plan = scene("drum");
        let gravity = plan.gravity;
        let settle = (1.5 / plan.time_step).round() as u64;
        let looks = ((plan.steps - settle) / 10) as usize;
        let mut engine = start(plan);
        engine
            .steps_at_once(settle, None)
            .expect("the motion stays finite");
        let (mut torque, mut weight) = (0.0, 0.0);
        for _ in 0..looks {
            engine
                .steps_at_once(10, RECORDS)
                .expect("the motion stays finite");
            torque -= engine.observation().walls[0].0.torque.y;
            let moments = engine.particles.bodies().iter();
            let moments = moments.map(|body| body.position.cross(body.mass * gravity).y);
            weight += moments.sum::<f64>();
        }
        -torque / weight
    };
    vec![Case::new(
        "scene clumps/drum: mean torque of the drum over the moment of the content's weight",
        1.0,
        // The angular momentum of the content may change by its own size, M R^2 w / 1 s, over a moment of M g R/4.
        Absolute(0.05),
        "balance of angular momentum about the axis in the steady state",
        balance,
    )]
}
