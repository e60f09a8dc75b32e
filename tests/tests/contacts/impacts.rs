//! Head-on impacts of two spheres: what is left of their speed. The case of another normal law, against its closed form, goes here.

use glam::{DVec3, dvec3};
use mercury_engine::contact::normal::{damping_ratio, restitution_clamped};
use mercury_engine::contact::{AnyNormal, NormalLaw as _, PlannedNormal as _, Scale};
use mercury_engine::state::volume;
use mercury_tests::scenes::{advance, frictionless, particle, plan, sphere, start};

const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2000.0;
/// Speed of one towards the other, m/s.
const SPEED: f64 = 0.2;
/// Steps of an elastic impact.
const STEPS: f64 = 1000.0;

fn scale() -> Scale {
    Scale {
        stiffness: 1000.0,
        radius: 0.5 * RADIUS,
        mass: 0.5 * DENSITY * volume(RADIUS, 3),
    }
}

/// The relative speed afterwards over that before.
fn restitution(law: AnyNormal, speed: f64) -> f64 {
    let Scale { radius, mass, .. } = scale();
    let time_step = law.duration(mass, radius, speed) / STEPS;
    let ball = |side: f64| {
        let (position, velocity) = (side * 1.001 * RADIUS, -0.5 * side * speed);
        sphere(
            position * DVec3::X,
            RADIUS,
            velocity * DVec3::X,
            DVec3::ZERO,
        )
    };
    let plan = plan(time_step, DENSITY, frictionless(law));
    let mut engine = start(plan.with_particles(vec![ball(-1.0), ball(1.0)]));
    // The gap first; then an impact, which a dashpot makes longer.
    let gap = 0.002 * RADIUS / speed / time_step;
    advance(&mut engine, (gap + 5.0 * STEPS) as u64);
    let [left, right] = [0, 1].map(|id| particle(&engine, id).velocity);
    assert!(left.reject_from(dvec3(1.0, 0.0, 0.0)).length() < 1e-15);
    (right.x - left.x) / speed
}

/// A part of a step is missed where a contact begins and ends, (pi/n)^2/4 of the energy each.
const MISSED: f64 = 5.0 / (STEPS * STEPS);

/// Every law takes energy, as its examples are damped, and creates none.
#[test]
fn no_law_creates_energy() {
    for law in AnyNormal::examples(&scale()) {
        for speed in [0.1 * SPEED, SPEED, 2.0 * SPEED] {
            let left = restitution(law, speed);
            assert!(
                (-MISSED..1.0).contains(&left),
                "{law:?}: {left} of {speed} m/s"
            );
        }
    }
}

/// e = exp(-pi zeta/sqrt(1 - zeta^2)) for a spring (Schwager & Poeschel 2007) and, with zeta = beta/sqrt(5), for Hertz' law (Antypov & Elliott
/// 2011) at every speed. The dashpot of a spring pushes at once: of that up to half a step is missed or made twice where a contact begins and where it
/// ends, zeta pi/n of the speed each. It acts on velocities of half a step before, which changes ln e by another zeta pi/(2 n).
#[test]
fn restitutions_are_those_of_theory() {
    let mut seen = 0;
    for law in AnyNormal::examples(&scale()) {
        let zeta = match law {
            AnyNormal::Linear(law) if law.damping_ratio > 0.0 => law.damping_ratio,
            AnyNormal::Linear(law) => law.dissipation / scale().critical_dissipation(),
            AnyNormal::Hertz(law) => law.damping / 5.0f64.sqrt(),
            _ => continue,
        };
        let expected = match law.clamps_tension() {
            true => restitution_clamped(zeta),
            false => (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp(),
        };
        if !law.clamps_tension() {
            assert!((damping_ratio(expected) - zeta).abs() < 1e-14);
        }
        for speed in [SPEED, 3.0 * SPEED] {
            let found = restitution(law, speed);
            let allowed = 2.5 * zeta * std::f64::consts::PI / STEPS;
            let error = (found / expected).ln().abs();
            assert!(
                error < allowed + MISSED,
                "{law:?}: {found}, not {expected}, at {speed} m/s"
            );
        }
        seen += 1;
    }
    assert!(seen >= 6, "{seen} laws");
}
