//! T14 and T15: a sphere on a plane.

use glam::{DVec3, dvec3};
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    Luding, PairLaw, SpringRotation,
};
use mercury_engine::state::volume;
use mercury_engine::step::Engine;

use super::Case;
use super::Tolerance::{Absolute, Relative};
use crate::closed_forms::{
    acceleration_with_rolling_resistance, rolling_begins_after, slipping_angle,
};
use crate::scenes::{advance, particle, plan, plane, sphere, start};

const RADIUS: f64 = 0.005;
pub(super) const GRAVITY: f64 = 9.81;
const FRICTION: f64 = 0.3;
/// Stiff enough for δ/R = 2.6e-6, which is how far the lever R − δ/2 is off.
const STIFFNESS: f64 = 1e6;
pub(super) const NEAR: f64 = 1e-5;
const STEP: f64 = 1e-6;

/// Rows of T14 and T15.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = sliding_to_rolling();
    cases.extend(slopes());
    cases.extend(rolling_resistance());
    cases.extend(torsion());
    cases
}

/// The inputs of a sphere on a plane.
#[derive(Clone, Copy)]
pub(super) struct OnPlane {
    /// Coefficient of sliding friction.
    pub(super) friction: f64,
    /// Slope, degrees.
    pub(super) angle: f64,
    pub(super) rolling: f64,
    pub(super) torsion: f64,
    /// Lever of rolling and torsion, over R*.
    pub(super) lever: f64,
    /// Damping of the sliding and rolling springs, relative to critical damping. The more of it, the sooner they settle; the
    /// less, the more sharply sliding ends: a sliding spring begins to hold when k u < γ |du/dt|.
    pub(super) damping: f64,
    /// Velocity along the plane, m/s.
    pub(super) speed: f64,
    /// Spin about its normal, rad/s.
    pub(super) spin: f64,
}

pub(super) const LEVEL: OnPlane = OnPlane {
    friction: FRICTION,
    angle: 0.0,
    rolling: 0.0,
    torsion: 0.0,
    lever: 1.0,
    damping: 0.5,
    speed: 0.0,
    spin: 0.0,
};

impl OnPlane {
    /// Sunk in to its equilibrium, with springs still relaxed.
    fn start(self) -> Engine {
        self.start_with(self.spin * DVec3::Z)
    }

    /// Engine of the sphere on the plane, rolling from the start.
    pub(super) fn start_rolling(self) -> Engine {
        self.start_with(self.speed / RADIUS * DVec3::Y)
    }

    fn start_with(self, angular_velocity: DVec3) -> Engine {
        let mass = 2500.0 * volume(RADIUS, 3);
        let tangential = 2.0 / 7.0 * STIFFNESS;
        let spring = |friction| FrictionSpring {
            stiffness: Some(tangential),
            dissipation: 2.0 * self.damping * (1.4 * mass * tangential).sqrt(),
            friction,
            static_friction: friction,
        };
        let law = PairLaw {
            normal: AnyNormal::Linear(Linear::with_damping_ratio(STIFFNESS, 0.3)),
            tangential: AnyTangential::Linear(LinearFriction {
                stiffness: tangential,
                dissipation: 2.0 * self.damping * (2.0 / 7.0 * mass * tangential).sqrt(),
                friction: self.friction,
                static_friction: self.friction,
                rotation: SpringRotation::Project,
                limits: CoulombLimits::Bounded,
            }),
            rolling: AnyRolling::Luding(Luding {
                rolling: spring(self.rolling),
                torsion: spring(self.torsion),
                lever: self.lever,
                rotation: SpringRotation::Project,
            }),
            adhesion: AnyAdhesion::None,
        };
        let angle = self.angle.to_radians();
        let mut plan = plan(STEP, 2500.0, law);
        plan.gravity = GRAVITY * dvec3(angle.sin(), 0.0, -angle.cos());
        plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
        let overlap = mass * GRAVITY * angle.cos() / STIFFNESS;
        let position = dvec3(0.0, 0.0, RADIUS - overlap);
        start(plan.with_particles(vec![sphere(
            position,
            RADIUS,
            self.speed * DVec3::X,
            angular_velocity,
        )]))
    }

    /// Mean acceleration down the slope (m/s²), and angular acceleration (rad/s²), after the springs have settled. While they
    /// stretch the sphere gains about 3e-4 m/s, which friction needs 12 ms to take back when it exceeds what is needed by as
    /// little as it does 0.1 degrees below a threshold.
    fn accelerations(self) -> (f64, f64) {
        let mut engine = self.start();
        advance(&mut engine, 30_000);
        let early = particle(&engine, 0);
        advance(&mut engine, 10_000);
        let late = particle(&engine, 0);
        let time = 10_000.0 * STEP;
        (
            (late.velocity.x - early.velocity.x) / time,
            (late.angular_velocity.y - early.angular_velocity.y) / time,
        )
    }

    /// When (s) and where (m) sliding turns into rolling, and the speed (m/s) then.
    pub(super) fn rolling_begins(self) -> [f64; 3] {
        let mut engine = self.start();
        let slip = |engine: &Engine| {
            let ball = particle(engine, 0);
            ball.velocity.x - ball.angular_velocity.y * RADIUS
        };
        let soon = 0.9 * rolling_begins_after(self.speed, self.friction, GRAVITY);
        advance(&mut engine, (soon / STEP) as u64);
        let (mut before, mut position) = (slip(&engine), 0.0);
        while slip(&engine) > 0.0 && engine.time() < 2.0 * soon {
            (before, position) = (slip(&engine), particle(&engine, 0).position.x);
            advance(&mut engine, 1);
        }
        // The slip falls linearly; where it vanished lies within the last step.
        let share = before / (before - slip(&engine));
        let ball = particle(&engine, 0);
        [
            engine.time() - (1.0 - share) * STEP,
            position + share * (ball.position.x - position),
            ball.velocity.x,
        ]
    }
}

fn sliding_to_rolling() -> Vec<Case> {
    const SOURCE: &str = "rigid sphere with Coulomb friction (Coriolis 1835)";
    let row = |name: &str, expected, index: usize| {
        Case::new(
            format!("T14 engine: sliding at 1 m/s turns into rolling: {name}"),
            expected,
            Relative(NEAR),
            SOURCE,
            move || {
                let sliding = OnPlane {
                    damping: 0.002,
                    speed: 1.0,
                    ..LEVEL
                };
                sliding.rolling_begins()[index]
            },
        )
    };
    vec![
        row("time (s)", 0.0970826659, 0),
        row("distance (m)", 0.0832137136, 1),
        row("speed (m/s)", 5.0 / 7.0, 2),
    ]
}

fn slopes() -> Vec<Case> {
    const SOURCE: &str = "rigid sphere with Coulomb friction";
    let slope = |angle: f64| OnPlane { angle, ..LEVEL };
    let threshold = slipping_angle(FRICTION).to_degrees();
    let above = (threshold + 0.1).to_radians();
    // what the contact point gains when friction is at its limit
    let gain = GRAVITY * (above.sin() - 3.5 * FRICTION * above.cos());
    vec![
        Case::new(
            "T14 engine: rolling down 20 degrees, acceleration (m/s2)",
            2.396584004,
            Relative(NEAR),
            SOURCE,
            move || slope(20.0).accelerations().0,
        ),
        Case::new(
            "T14 engine: rolling down 20 degrees, R times angular acceleration (m/s2)",
            2.396584004,
            Relative(NEAR),
            SOURCE,
            move || slope(20.0).accelerations().1 * RADIUS,
        ),
        // the difference of two accelerations, one of them 2.5 times larger and known to 1e-5
        Case::new(
            "T14 engine: rolling down 20 degrees, friction per mass (m/s2)",
            0.958633602,
            Relative(3.0 * NEAR),
            SOURCE,
            move || GRAVITY * 20f64.to_radians().sin() - slope(20.0).accelerations().0,
        ),
        Case::new(
            "T14 engine: slipping down 50 degrees, acceleration (m/s2)",
            5.623172052,
            Relative(NEAR),
            SOURCE,
            move || slope(50.0).accelerations().0,
        ),
        Case::new(
            "T14 engine: slipping down 50 degrees, angular acceleration (rad/s2)",
            945.8619677,
            Relative(NEAR),
            SOURCE,
            move || slope(50.0).accelerations().1,
        ),
        Case::new(
            "T14 engine: 0.1 degrees below the slipping angle, gain of slip (m/s2)",
            0.0,
            Absolute(NEAR),
            SOURCE,
            move || {
                let (linear, angular) = slope(threshold - 0.1).accelerations();
                linear - angular * RADIUS
            },
        ),
        Case::new(
            "T14 engine: 0.1 degrees above the slipping angle, gain of slip (m/s2)",
            gain,
            Absolute(10.0 * NEAR),
            SOURCE,
            move || {
                let (linear, angular) = slope(threshold + 0.1).accelerations();
                linear - angular * RADIUS
            },
        ),
    ]
}

fn rolling_resistance() -> Vec<Case> {
    const SOURCE: &str = "rigid sphere with a limited rolling couple (Luding 2008)";
    let mut cases = Vec::new();
    for (lever, name, threshold, at_20_degrees) in [
        (2.0, "lever 2R*", 11.30993f64, 1.079671917),
        (1.0, "lever R*", 5.710593, 1.738127961),
    ] {
        let slope = move |angle: f64| OnPlane {
            angle,
            lever,
            rolling: 0.1,
            damping: 1.0,
            ..LEVEL
        };
        let mut row = |what: &str, angle: f64, expected: f64, tolerance| {
            cases.push(Case::new(
                format!("T15 engine: rolling resistance, {name}, {what}, acceleration (m/s2)"),
                expected,
                tolerance,
                SOURCE,
                move || slope(angle).accelerations().0,
            ));
        };
        let above = acceleration_with_rolling_resistance(
            (threshold + 0.1).to_radians(),
            0.1,
            lever,
            GRAVITY,
        );
        row("20 degrees", 20.0, at_20_degrees, Relative(NEAR));
        row(
            "0.1 degrees below its angle of rest",
            threshold - 0.1,
            0.0,
            Absolute(NEAR),
        );
        row(
            "0.1 degrees above its angle of rest",
            threshold + 0.1,
            above,
            Absolute(10.0 * NEAR),
        );
    }
    cases
}

fn torsion() -> Vec<Case> {
    const SOURCE: &str = "rigid sphere with a limited torsion couple (Luding 2008)";
    let spinning = OnPlane {
        torsion: 0.05,
        lever: 2.0,
        damping: 0.002,
        spin: 100.0,
        ..LEVEL
    };
    vec![
        Case::new(
            "T15 engine: torsion, spin decay (rad/s2)",
            490.5,
            Relative(NEAR),
            SOURCE,
            move || {
                let mut engine = spinning.start();
                advance(&mut engine, 100_000);
                (100.0 - particle(&engine, 0).angular_velocity.z) / engine.time()
            },
        ),
        Case::new(
            "T15 engine: torsion, time until 100 rad/s are stopped (s)",
            0.203873598,
            Relative(NEAR),
            SOURCE,
            move || {
                let mut engine = spinning.start();
                advance(&mut engine, 190_000);
                while particle(&engine, 0).angular_velocity.z > 0.0 && engine.time() < 0.21 {
                    advance(&mut engine, 1);
                }
                engine.time()
            },
        ),
    ]
}
