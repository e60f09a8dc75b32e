//! Tests DEM01 to DEM05 of MFiX 21.3.2. DEM06, a sphere in a gas that flows upwards, needs a drag law and is not run.

use std::sync::{Arc, OnceLock};

use anyhow::{Context, Result};
use glam::{DVec3, dvec3};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    PairLaw, SpringRotation,
};
use mercury_engine::state::{MaterialIndex, volume};
use mercury_engine::step::Engine;
use mercury_solver::plan::Draft;

use super::Published;
use super::mfix_table::{Table, read};
use crate::cases::Case;
use crate::cases::Tolerance::{Absolute, Relative};
use crate::cases::impact::Impact;
use crate::cases::oblique;
use crate::closed_forms::{Bouncing, damping_ratio};
use crate::scenes::{add_material, advance, frictionless, particle, plan, plane, sphere, start};

/// m/s², as in the files.
const GRAVITY: f64 = 9.80665;
/// DEM01 and DEM02: radius (m), density (kg/m³), height of the centre at the start (m).
const RADIUS: f64 = 0.1;
const DENSITY: f64 = 2600.0;
const START: f64 = 0.5;

/// The checks of a second.
pub(super) fn quick(published: &Published) -> Result<Vec<Case>> {
    let mut cases = slip_to_roll();
    cases.extend(oblique_impacts(published)?);
    Ok(cases)
}

/// The others.
pub(super) fn slow(published: &Published) -> Result<Vec<Case>> {
    let mut cases = falls(published)?;
    cases.extend(bounces());
    cases.extend(stacked(published)?);
    Ok(cases)
}

/// A linear law with the damping of a restitution, at every effective mass.
fn linear(stiffness: f64, restitution: f64) -> AnyPairLaw {
    let zeta = damping_ratio(restitution);
    frictionless(AnyNormal::Linear(Linear::with_damping_ratio(
        stiffness, zeta,
    )))
}

/// A sphere that falls on a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fall {
    pub(super) stiffness: f64,
    pub(super) restitution: f64,
}

impl Fall {
    fn ball(&self) -> Bouncing {
        Bouncing {
            frequency: (self.stiffness / (DENSITY * volume(RADIUS, 3))).sqrt(),
            damping_ratio: damping_ratio(self.restitution),
            gravity: GRAVITY,
        }
    }

    fn step(&self, per_contact: f64) -> f64 {
        std::f64::consts::PI / self.ball().frequency / per_contact
    }

    fn start(&self, step: f64) -> Engine {
        let mut plan = plan(step, DENSITY, linear(self.stiffness, self.restitution));
        plan.gravity = -GRAVITY * DVec3::Y;
        plan.walls.push(plane(DVec3::ZERO, DVec3::Y));
        let ball = sphere(START * DVec3::Y, RADIUS, DVec3::ZERO, DVec3::ZERO);
        start(plan.with_particles(vec![ball]))
    }

    /// Height (m) and velocity (m/s) at the times given (s), in order, between the steps by the cubic that has both at their ends.
    pub(super) fn heights(&self, times: &[f64]) -> Vec<[f64; 2]> {
        let step = self.step(1000.0);
        course(self.start(step), step, times, |engine| {
            let ball = particle(engine, 0);
            [ball.position.y, ball.velocity.y]
        })
    }

    /// Heights of the first bounces, m: each where the velocity turns.
    pub(super) fn bounces(&self, number: usize) -> Vec<f64> {
        let mut engine = self.start(self.step(500.0));
        let mut found = Vec::new();
        let mut before = 0.0;
        while found.len() < number && engine.time() < 10.0 {
            advance(&mut engine, 1);
            let ball = particle(&engine, 0);
            let speed = ball.velocity.y;
            if before > 0.0 && speed <= 0.0 {
                found.push(ball.position.y + 0.5 * speed * speed / GRAVITY);
            }
            before = speed;
        }
        found
    }

    /// Heights of the rebounds in closed form, while gravity is a small part of the force in a contact: g/(omega v) below 0.2.
    pub(super) fn theory(&self, most: usize) -> Vec<f64> {
        let ball = self.ball();
        let mut speed = (2.0 * GRAVITY * (START - RADIUS)).sqrt();
        let mut found = Vec::new();
        while found.len() < most && GRAVITY / (ball.frequency * speed) < 0.2 {
            let Some((_, leaves)) = ball.leaves(speed) else {
                break;
            };
            speed = leaves;
            found.push(RADIUS + 0.5 * speed * speed / GRAVITY);
        }
        found
    }

    /// How far off the speed after a contact may be, over itself: the dashpot of a linear contact in so many steps.
    fn lag(&self, steps: f64) -> f64 {
        crate::cases::lag(self.ball().damping_ratio, steps)
    }
}

/// Values of `see` (a place, m, and its rate) at times (s) in order, between the steps by the cubic that has both at their ends.
fn course(
    mut engine: Engine,
    step: f64,
    times: &[f64],
    see: impl Fn(&Engine) -> [f64; 2],
) -> Vec<[f64; 2]> {
    let mut before = see(&engine);
    let mut now = before;
    let at = |engine: &Engine| engine.steps() as f64 * step;
    times
        .iter()
        .map(|&time| {
            while at(&engine) < time {
                before = now;
                advance(&mut engine, 1);
                now = see(&engine);
            }
            if engine.steps() == 0 {
                return now;
            }
            let s = 1.0 - (at(&engine) - time) / step;
            let ([y0, v0], [y1, v1]) = (before, now);
            let (a, b) = (y1 - y0 - v0 * step, (v1 - v0) * step);
            // y0 + v0 t + (3 a - b) s^2 + (b - 2 a) s^3
            [
                y0 + v0 * step * s + (3.0 * a - b) * s * s + (b - 2.0 * a) * s * s * s,
                v0 + (2.0 * (3.0 * a - b) * s + 3.0 * (b - 2.0 * a) * s * s) / step,
            ]
        })
        .collect()
}

/// The tables of DEM01 by Euler's scheme: of heights (k = 0) or velocities.
pub(super) fn fall_tables(published: &Published, k: usize) -> Result<Vec<Table>> {
    let file = ["mfix/DEM01_POST_POS.dat", "mfix/DEM01_POST_VEL.dat"][k];
    let mut tables = read(&published.text(file)?)?;
    tables.retain(|table| table.scheme == "EULER");
    Ok(tables)
}

fn falls(published: &Published) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (k, what) in ["height (m)", "velocity (m/s)"].into_iter().enumerate() {
        for table in fall_tables(published, k)? {
            let fall = Fall {
                stiffness: table.stiffness,
                restitution: table.restitution,
            };
            let times: Vec<f64> = table.rows.iter().map(|row| row[0]).collect();
            let speed = (2.0 * GRAVITY * (START - RADIUS)).sqrt();
            // The speed after the contact is off by the lag; at the ends of the contact the dashpot sets in within a step.
            let within =
                4.0 * fall.ball().damping_ratio * fall.ball().frequency * fall.step(1000.0);
            let off = speed * fall.lag(1000.0);
            // Times and numbers are printed with 8 decimals.
            let allowed = if k == 0 {
                off * 0.22 + 0.5e-8 * (1.0 + speed)
            } else {
                off + speed * within + 0.5e-8
            };
            // Gravity alone, or the spring: what the rounding of the time can do to a velocity.
            let rounding = if k == 0 {
                0.0
            } else {
                0.5e-8 * speed * fall.ball().frequency
            };
            cases.push(Case::new(
                format!(
                    "MFiX DEM01, k = {} N/m, e = {}: {what}, largest difference from the closed form",
                    table.stiffness, table.restitution
                ),
                0.0,
                Absolute(allowed + rounding),
                "three stages in closed form, as printed in MFiX's DEM01",
                move || {
                    let ours = fall.heights(&times);
                    let pairs = ours.iter().zip(&table.rows);
                    pairs.map(|(seen, row)| (seen[k] - row[2]).abs()).fold(0.0, f64::max)
                },
            ));
        }
    }
    Ok(cases)
}

/// The sweep of DEM02.
pub(super) const SWEEP: [f64; 3] = [5e4, 5e5, 5e6];

fn bounces() -> Vec<Case> {
    let mut cases = Vec::new();
    for stiffness in SWEEP {
        for restitution in [1.0, 0.9, 0.8, 0.7, 0.6, 0.5] {
            let fall = Fall {
                stiffness,
                restitution,
            };
            let theory = fall.theory(15);
            let (number, last) = (theory.len(), theory[theory.len() - 1] - RADIUS);
            cases.push(Case::new(
                format!("MFiX DEM02, k = {stiffness} N/m, e = {restitution}: height of bounce {number}, over the plane (m)"),
                last,
                // Each contact adds its lag to the speed; the height has its square.
                Relative(2.0 * number as f64 * fall.lag(500.0)),
                "damped oscillator under gravity, contact after contact",
                move || fall.bounces(number).last().map_or(f64::NAN, |h| h - RADIUS),
            ));
            // By perturbation: the weight deepens the contact by g/w^2, so that it ends later by (1 + e) g/(w^2 v e) and the speed
            // after it, v e, is less by the share 2 zeta (1 + e)/e g/(w v). The next terms are smaller by the phase that it ends
            // later.
            let speed = (2.0 * GRAVITY * (START - RADIUS)).sqrt();
            let later =
                (1.0 + restitution) / restitution * GRAVITY / (fall.ball().frequency * speed);
            let less = 4.0 * fall.ball().damping_ratio * later;
            cases.push(Case::new(
                format!("MFiX DEM02, k = {stiffness} N/m, e = {restitution}: height of the first bounce, over the plane, gravity in the contact to first order (m)"),
                (START - RADIUS) * restitution * restitution * (1.0 - less),
                Relative(less * later + 2.0 * fall.lag(500.0)),
                "MFiX's (h0 - r) e^2, which is for a stiff spring, less 4 zeta (1 + e)/e g/(omega v) of it",
                move || fall.bounces(1).last().map_or(f64::NAN, |h| h - RADIUS),
            ));
        }
    }
    cases
}

/// DEM03: two spheres of 1 mm, the lower one twice as dense, squeezed between planes 1.8 mm apart.
fn stacked_engine(stiffness: f64, restitution: f64, step: f64) -> Engine {
    let radius = 0.0005;
    let mut plan: Draft = plan(step, 20_000.0, linear(stiffness, restitution));
    plan.gravity = -GRAVITY * DVec3::Y;
    plan.walls.push(plane(DVec3::ZERO, DVec3::Y));
    plan.walls
        .push(plane(3.6 * radius * DVec3::Y, DVec3::NEG_Y));
    let light = add_material(&mut plan, 10_000.0);
    let at = |height: f64| sphere(height * DVec3::Y, radius, DVec3::ZERO, DVec3::ZERO);
    let mut upper = at(0.00135);
    upper.material = MaterialIndex::new(light);
    start(plan.with_particles(vec![at(0.00045), upper]))
}

/// The largest change of the second column over that of the first, from row to row.
fn largest_slope(table: &Table) -> f64 {
    let slope = |pair: &[Vec<f64>]| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
    let slopes = table.rows.windows(2).map(slope);
    slopes.fold(0.0, |most: f64, slope| most.max(slope.abs()))
}

fn stacked(published: &Published) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (which, file) in ["mfix/DEM03_POST_POS1.dat", "mfix/DEM03_POST_POS2.dat"]
        .into_iter()
        .enumerate()
    {
        for table in read(&published.text(file)?)? {
            let name = ["lower", "upper"][which];
            cases.push(Case::new(
                format!(
                    "MFiX DEM03, e = {}: place of the {name} sphere (m), largest difference in 1 ms",
                    table.restitution
                ),
                0.0,
                // Half a unit of the last digit of the place, and of the time at the largest speed in the table; and the dashpots'
                // lag: zeta omega dt of 0.1 mm, with omega = 2e4 rad/s.
                Absolute(
                    0.5e-8 * (1.0 + largest_slope(&table))
                        + 2e4 * damping_ratio(table.restitution) * 5e-9 * 1e-4,
                ),
                "two coupled linear equations, as printed in MFiX's DEM03",
                move || {
                    let step = 5e-9;
                    let times: Vec<f64> = table.rows.iter().map(|row| row[0]).collect();
                    let engine = stacked_engine(table.stiffness, table.restitution, step);
                    let ours = course(engine, step, &times, |engine| {
                        let ball = particle(engine, which as u32);
                        [ball.position.y, ball.velocity.y]
                    });
                    let pairs = ours.iter().zip(&table.rows);
                    pairs.map(|(seen, row)| (seen[0] - row[1]).abs()).fold(0.0, f64::max)
                },
            ));
        }
    }
    Ok(cases)
}

/// DEM04: radius (m), density (kg/m³), speed (m/s).
const SLIDER: [f64; 3] = [0.0005, 1e4, 0.1];
/// Stiffness of the contact with the floor, N/m; not stated. Stiff: the overlap at rest is 1e-5 radii.
const FLOOR: f64 = 1e4;

/// 1/200 of a contact, s.
fn slider_step() -> f64 {
    let mass = SLIDER[1] * volume(SLIDER[0], 3);
    std::f64::consts::PI * (mass / FLOOR).sqrt() / 200.0
}

/// DEM04: time of the end of sliding over u0/(mu g), and speed and R spin over u0 then.
fn rolling_begins(friction: f64) -> [f64; 3] {
    let [radius, density, speed] = SLIDER;
    let (stiffness, step) = (FLOOR, slider_step());
    let mass = density * volume(radius, 3);
    let tangential = 2.0 / 7.0 * stiffness;
    let law = PairLaw {
        normal: AnyNormal::Linear(Linear::with_damping_ratio(stiffness, 0.3)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: tangential,
            dissipation: 0.004 * (2.0 / 7.0 * mass * tangential).sqrt(),
            friction,
            static_friction: friction,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let mut plan = plan(step, density, law);
    plan.gravity = -GRAVITY * DVec3::Y;
    plan.walls.push(plane(DVec3::ZERO, DVec3::Y));
    let position = dvec3(0.0, radius - mass * GRAVITY / stiffness, 0.0);
    let ball = sphere(position, radius, speed * DVec3::X, DVec3::ZERO);
    let mut engine = start(plan.with_particles(vec![ball]));
    // Speed and R spin along the plane.
    let see = |engine: &Engine| {
        let ball = particle(engine, 0);
        [ball.velocity.x, -ball.angular_velocity.z * radius]
    };
    let (mut before, mut now) = ([speed, 0.0], [speed, 0.0]);
    while now[0] > now[1] && engine.time() < 0.1 {
        before = now;
        advance(&mut engine, 1);
        now = see(&engine);
    }
    // All three are straight within the last step.
    let (slip, over) = (before[0] - before[1], now[1] - now[0]);
    let share = slip / (slip + over);
    let between = |k: usize| before[k] + share * (now[k] - before[k]);
    [
        (engine.time() - (1.0 - share) * step) * friction * GRAVITY / speed,
        between(0) / speed,
        between(1) / speed,
    ]
}

fn slip_to_roll() -> Vec<Case> {
    let mut cases = Vec::new();
    for tenth in 2..=10 {
        let friction = f64::from(tenth) / 10.0;
        let measured = Arc::new(OnceLock::new());
        // The lever is short by half the overlap (5e-6), and the spring needs a way of mu m g/k_t to load (2e-6 of that of the
        // sliding at mu = 1); it holds when k u < gamma du/dt, 1e-7 s early; twice the sum. Friction begins within a step.
        let near = 2e-5;
        let begins = 3.5 * friction * GRAVITY / SLIDER[2] * slider_step();
        for (k, (what, expected)) in [
            ("time of the end of sliding over u0/(mu g)", 2.0 / 7.0),
            ("speed then over u0", 5.0 / 7.0),
            ("R spin then over u0", 5.0 / 7.0),
        ]
        .into_iter()
        .enumerate()
        {
            cases.push(Case::new(
                format!("MFiX DEM04, mu = {friction}: {what}"),
                expected,
                Relative(if k == 0 { near + begins } else { near }),
                "rigid sphere with Coulomb friction, as in MFiX's DEM04 (2/7 and 5/7)",
                {
                    let measured = Arc::clone(&measured);
                    move || measured.get_or_init(|| rolling_begins(friction))[k]
                },
            ));
        }
    }
    cases
}

/// DEM05 by the angle from the normal (degrees): the file's impacts that slide fit e = 1.
fn oblique_impact(degrees: f64, factor: f64) -> Impact {
    Impact {
        restitution: 1.0,
        ..oblique::test_4(degrees, factor)
    }
}

/// v_t after over before, spin (rad/s), angle of the centre's way after (degrees): on a wall, or of two equal spheres.
pub(super) fn seen_in_impact(degrees: f64, factor: f64, pair: bool) -> [f64; 3] {
    let impact = oblique_impact(degrees, factor);
    let after = if pair {
        impact.on_opposite()
    } else {
        impact.on_wall()
    };
    [
        after.velocity.x / impact.along,
        after.angular_velocity.z.abs(),
        after.velocity.x.atan2(after.velocity.y).to_degrees(),
    ]
}

pub(super) const NAMES: [&str; 3] = ["coeff", "omega", "alpha"];

fn oblique_impacts(published: &Published) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    let what = [
        "v_t after over before",
        "spin after (rad/s)",
        "angle after (degrees)",
    ];
    for (k, name) in NAMES.into_iter().enumerate() {
        let rows = published.points("mfix/DEM05.json", &["hertz", name])?;
        for row in rows {
            let [degrees, pair, wall] = row[..]
                .try_into()
                .ok()
                .context("DEM05: rows have an angle and two numbers")?;
            // The motion of a sphere that sticks depends on the tangential stiffness, which the file does not state.
            if f64::tan(f64::to_radians(degrees)) < 3.5 * 0.092 * 2.0 {
                continue;
            }
            for (of, expected) in [("two spheres", pair), ("a sphere on a wall", wall)] {
                cases.push(Case::new(
                    format!("MFiX DEM05, {of}, {degrees} degrees: {}", what[k]),
                    expected,
                    Relative(0.05),
                    "MFiX's DEM05, Hertz model; its limit of 5 %",
                    move || seen_in_impact(degrees, 2.0 / 3.0, of == "two spheres")[k],
                ));
            }
        }
    }
    Ok(cases)
}
