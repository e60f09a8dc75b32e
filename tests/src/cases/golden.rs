//! T8 to T10: trajectories that independent codes have printed to all digits, with Coulomb's limits as those codes have them.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use mercury_engine::contact::normal::hertz_damping;
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Hertz, Linear,
    LinearFriction, Luding, Mindlin, PairLaw, SlidingNormal, SpringRotation,
};
use mercury_engine::step::Engine;

use super::Case;
use super::Tolerance::{Absolute, Digit, Relative};
use crate::closed_forms::linear_from_contact_time;
use crate::scenes::{advance, particle, plan, plane, sphere, start};

const SOURCE: &str = "two independent codes";
const MERCURYDPM: &str = "MercuryDPM's algorithm, two independent codes";
/// Independent codes differ in the order of their sums, and a collision amplifies that round-off.
const GOLDEN: f64 = 1e-9;

/// Rows of T8 to T10.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = linear_and_sliding();
    cases.extend(mindlin_on_wall());
    cases.extend(all_kinds_of_friction());
    cases
}

/// One row for each component that is not zero, and one for each that is.
fn vector(
    cases: &mut Vec<Case>,
    name: &str,
    source: &'static str,
    expected: DVec3,
    measured: impl Fn() -> DVec3 + Copy + Send + Sync + 'static,
) {
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        let tolerance = if expected[axis] == 0.0 {
            Absolute(GOLDEN * expected.length())
        } else {
            Relative(GOLDEN)
        };
        cases.push(Case::new(
            format!("{name}, {letter}"),
            expected[axis],
            tolerance,
            source,
            move || measured()[axis],
        ));
    }
}

fn linear_and_sliding() -> Vec<Case> {
    let run = |rotation: SpringRotation, time_step: f64| {
        let (stiffness, dissipation) = linear_from_contact_time(0.02, 0.7, 0.5);
        let law = PairLaw {
            normal: AnyNormal::Linear(Linear::new(stiffness, dissipation)),
            tangential: AnyTangential::Linear(LinearFriction {
                stiffness: 2.0 / 7.0 * stiffness,
                dissipation: 0.0,
                friction: 0.5,
                static_friction: 0.5,
                rotation,
                limits: CoulombLimits::Total,
            }),
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        };
        let spheres = [(-1.0, 5.0), (1.0, -2.0)].map(|(side, spin)| {
            let velocity = dvec3(-side * 0.5, side * 0.3, 0.0);
            sphere(
                dvec3(side * 0.5005, 0.0, 0.0),
                0.5,
                velocity,
                spin * DVec3::Z,
            )
        });
        let mut plan = plan(time_step, 6.0 / PI, law);
        plan.sliding_normal = SlidingNormal::Step;
        let mut engine = start(plan.with_particles(spheres.into()));
        advance(&mut engine, (0.04 / time_step).round() as u64);
        engine
    };
    let variants = [
        (
            "incremental history",
            SpringRotation::Incremental,
            MERCURYDPM,
            dvec3(-0.34048476711170006, -0.5503058305389921, 0.0),
            (3.78062819732016, -3.2193718026798326),
            dvec3(-0.5064416194492787, -0.01941524667502733, 0.0),
        ),
        (
            "default history",
            SpringRotation::Project,
            SOURCE,
            dvec3(-0.34048476482689227, -0.5503059654750336, 0.0),
            (3.780627526570739, -3.2193724734292655),
            dvec3(-0.5064416193924911, -0.01941525042084568, 0.0),
        ),
    ];
    let mut cases = Vec::new();
    for (name, rotation, source, velocity, spins, position) in variants {
        let mut row = |what: &str, expected, pick: fn(&Engine) -> DVec3| {
            let name = format!("T8 engine: linear with sliding, {name}: {what}");
            vector(&mut cases, &name, source, expected, move || {
                pick(&run(rotation, 4e-4))
            });
        };
        row("v of 1 (m/s)", velocity, |e| particle(e, 0).velocity);
        row("v of 2 (m/s)", -velocity, |e| particle(e, 1).velocity);
        row("spin of 1 (rad/s)", spins.0 * DVec3::Z, |e| {
            particle(e, 0).angular_velocity
        });
        row("spin of 2 (rad/s)", spins.1 * DVec3::Z, |e| {
            particle(e, 1).angular_velocity
        });
        row("position of 1 (m)", position, |e| particle(e, 0).position);
    }
    let fine = move || particle(&run(SpringRotation::Incremental, 6.25e-6), 0);
    cases.push(Case::new(
        "T8 engine: linear with sliding, dt 6.25e-6 s: v of 1 (m/s), x",
        -0.342992,
        Digit(1e-6),
        MERCURYDPM,
        move || fine().velocity.x,
    ));
    cases.push(Case::new(
        "T8 engine: linear with sliding, dt 6.25e-6 s: v of 1 (m/s), y",
        -0.548893,
        Digit(1e-6),
        MERCURYDPM,
        move || fine().velocity.y,
    ));
    cases.push(Case::new(
        "T8 engine: linear with sliding, dt 6.25e-6 s: spin of 1 (rad/s)",
        3.787866,
        Digit(1e-6),
        MERCURYDPM,
        move || fine().angular_velocity.z,
    ));
    cases
}

fn mindlin_on_wall() -> Vec<Case> {
    let run = |time_step: f64| {
        let damping = hertz_damping(0.8);
        let law = PairLaw {
            normal: AnyNormal::Hertz(Hertz::new(5494505.494505494, damping)),
            tangential: AnyTangential::Mindlin(
                Mindlin::new(
                    1131221.719457014,
                    2.0 / 3.0,
                    (2.0f64 / 3.0).sqrt() * damping,
                    0.3,
                    0.3,
                )
                .with_limits(CoulombLimits::Elastic),
            ),
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        };
        let mut plan = plan(time_step, 2500.0, law);
        plan.sliding_normal = SlidingNormal::Step;
        plan.gravity = dvec3(0.0, 0.0, -9.81);
        plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
        let ball = sphere(
            dvec3(0.0, 0.0, 0.0051),
            0.005,
            dvec3(0.1, 0.05, -0.2),
            dvec3(3.0, -4.0, 10.0),
        );
        let mut engine = start(plan.with_particles(vec![ball]));
        advance(&mut engine, (4e-3 / time_step).round() as u64);
        particle(&engine, 0)
    };
    let mut cases = Vec::new();
    let name = "T9 engine: Hertz-Mindlin on a wall:";
    let position = dvec3(
        2.5276075022564467e-4,
        1.2029325705069046e-4,
        5.281911862806079e-3,
    );
    vector(
        &mut cases,
        &format!("{name} position (m)"),
        SOURCE,
        position,
        move || run(1e-5).position,
    );
    let velocity = dvec3(0.05441137276294136, 0.02532198352330283, 0.1442643911682604);
    vector(
        &mut cases,
        &format!("{name} v (m/s)"),
        SOURCE,
        velocity,
        move || run(1e-5).velocity,
    );
    let spin = dvec3(-9.231377050985667, 18.595450794307528, 10.0);
    vector(
        &mut cases,
        &format!("{name} spin (rad/s)"),
        SOURCE,
        spin,
        move || run(1e-5).angular_velocity,
    );
    cases.push(Case::new(
        format!("{name} v_z with dt = 1e-6 s (m/s)"),
        0.1443237546,
        Digit(1e-10),
        SOURCE,
        move || run(1e-6).velocity.z,
    ));
    cases.push(Case::new(
        format!("{name} v_x with dt = 1e-6 s (m/s)"),
        0.0544403952,
        Digit(1e-10),
        SOURCE,
        move || run(1e-6).velocity.x,
    ));
    cases
}

/// A quantity by its name, and the way to it.
type Pick = (&'static str, fn(&Engine) -> DVec3);

fn all_kinds_of_friction() -> Vec<Case> {
    let begin = |rotation: SpringRotation, lever: f64| {
        let spring = |stiffness, dissipation, friction| FrictionSpring {
            stiffness: Some(stiffness),
            dissipation,
            friction,
            static_friction: friction,
        };
        let law = PairLaw {
            normal: AnyNormal::Linear(Linear::new(1e4, 2.0)),
            tangential: AnyTangential::Linear(LinearFriction {
                stiffness: 4e3,
                dissipation: 0.5,
                friction: 0.5,
                static_friction: 0.5,
                rotation,
                limits: CoulombLimits::Total,
            }),
            rolling: AnyRolling::Luding(Luding {
                rolling: spring(3e3, 0.2, 0.1),
                torsion: spring(2e3, 0.1, 0.05),
                lever,
                rotation,
            }),
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
        let mut plan = plan(1e-4, 2000.0, law);
        plan.sliding_normal = SlidingNormal::Step;
        start(plan.with_particles(vec![one, two]))
    };
    let run = move |rotation, lever| {
        let mut engine = begin(rotation, lever);
        advance(&mut engine, 600);
        engine
    };
    let variants = [
        (
            "lever 2R*, incremental history",
            SpringRotation::Incremental,
            2.0,
            MERCURYDPM,
            [
                dvec3(
                    0.05914679591217452,
                    0.07835207145544351,
                    0.11491741886880334,
                ),
                dvec3(0.9381355912559206, 13.313545500612783, -3.138996782054753),
                dvec3(0.7150611300362292, 0.10022189140998389, -0.4820250873555715),
                dvec3(-2.17164098634071, -30.78746643452741, 1.9820969652962113),
            ],
        ),
        (
            "default",
            SpringRotation::Project,
            1.0,
            SOURCE,
            [
                dvec3(0.05927830312513551, 0.07536194469878962, 0.1112192355360957),
                dvec3(1.1321822293244268, 13.939580268429081, -3.391408439104942),
                dvec3(
                    0.7144523003465953,
                    0.11406507083893744,
                    -0.46490386822266516,
                ),
                dvec3(-4.838759568835323, -35.106873388842565, 2.2668754786808805),
            ],
        ),
    ];
    let mut cases = Vec::new();
    for (name, rotation, lever, source, expected) in variants {
        let picks: [Pick; 4] = [
            ("v of 1 (m/s)", |e| particle(e, 0).velocity),
            ("spin of 1 (rad/s)", |e| particle(e, 0).angular_velocity),
            ("v of 2 (m/s)", |e| particle(e, 1).velocity),
            ("spin of 2 (rad/s)", |e| particle(e, 1).angular_velocity),
        ];
        for ((what, pick), expected) in picks.into_iter().zip(expected) {
            let name = format!("T10 engine: sliding, rolling, torsion, {name}: {what}");
            vector(&mut cases, &name, source, expected, move || {
                pick(&run(rotation, lever))
            });
        }
        cases.push(Case::new(
            format!(
                "T10 engine: sliding, rolling, torsion, {name}: largest change of momentum (kg m/s)"
            ),
            0.0,
            Absolute(1e-13 * 0.25),
            "action and reaction",
            move || {
                let momentum = dvec3(0.22368139693559, 0.10471975511966, 0.01130973355292);
                let mut engine = begin(rotation, lever);
                let mut largest: f64 = 0.0;
                for _ in 0..600 {
                    advance(&mut engine, 1);
                    let rows = engine
                        .particles
                        .records
                        .iter()
                        .zip(&engine.particles.masses);
                    let sum: DVec3 = rows.map(|(record, &mass)| record.velocity * mass).sum();
                    largest = largest.max((sum - momentum).length());
                }
                largest
            },
        ));
    }
    cases
}
