//! T4 to T6: Hertz' law without damping, with damping, and clamped.

use mercury_engine::contact::normal::{
    damping_ratio, damping_ratio_clamped, effective_modulus, effective_shear_modulus,
    hertz_damping, rayleigh_time,
};
use mercury_engine::contact::{AnyNormal, Hertz, NormalLaw};

use glam::{DVec3, dvec3};

use super::Case;
use super::Tolerance::{Absolute, Digit, Relative};
use super::collision::{Collision, HeadOn, lag};
use crate::closed_forms::{HERTZ_DURATION, hertz_contact_time, hertz_largest_overlap};
use crate::scenes::{contact_at_rest, frictionless, plan, plane, sphere, start};

/// E (Pa) and nu.
const SOFT: (f64, f64) = (1e7, 0.3);
const MODULUS: f64 = 5494505.494505494;
/// kg, of a sphere of 5 mm and 2500 kg/m³.
const MASS: f64 = 0.001308996938995747;
const RADIUS: f64 = 0.005;
const SPEED: f64 = 0.2;

/// Rows of T4 to T6.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = elastic_law();
    cases.extend(elastic_engine());
    cases.extend(damped());
    cases.extend(clamped());
    cases
}

fn elastic_law() -> Vec<Case> {
    const SOURCE: &str = "Hertz 1882";
    let law = Hertz::new(MODULUS, 0.0);
    let near = Relative(1e-12);
    let force = move |effective_radius: f64| {
        move || {
            law.force(
                &contact_at_rest(1e-5, effective_radius, 0.5 * MASS),
                &mut (),
            )
            .total()
        }
    };
    vec![
        Case::new(
            "T4 law: E* of equal materials (Pa)",
            MODULUS,
            near,
            SOURCE,
            || effective_modulus(SOFT, SOFT),
        ),
        Case::new(
            "T4 law: G* of equal materials (Pa)",
            1131221.719457014,
            near,
            "Mindlin 1949",
            || effective_shear_modulus(SOFT, SOFT),
        ),
        Case::new(
            "T4 law: force at 10 um, pair (N)",
            0.01158343465263,
            near,
            SOURCE,
            force(0.5 * RADIUS),
        ),
        Case::new(
            "T4 law: force at 10 um, wall (N)",
            0.01638145038461,
            near,
            SOURCE,
            force(RADIUS),
        ),
        Case::new(
            "T4 law: energy at 10 um, pair (J)",
            4.633373861053e-8,
            near,
            SOURCE,
            move || law.energy(&contact_at_rest(1e-5, 0.5 * RADIUS, 0.5 * MASS), &()),
        ),
        Case::new(
            "T4 law: largest overlap, pair (m)",
            9.559089210180e-5,
            near,
            SOURCE,
            move || law.largest_overlap(0.5 * MASS, 0.5 * RADIUS, SPEED),
        ),
        Case::new(
            "T4 law: largest overlap, wall (m)",
            1.098051005100e-4,
            near,
            SOURCE,
            move || law.largest_overlap(MASS, RADIUS, SPEED),
        ),
        Case::new(
            "T4 law: collision time, pair (s)",
            1.406751502853e-3,
            near,
            SOURCE,
            move || law.collision_time(0.5 * MASS, 0.5 * RADIUS, SPEED),
        ),
        Case::new(
            "T4 law: collision time, wall (s)",
            1.615933137217e-3,
            near,
            SOURCE,
            move || law.collision_time(MASS, RADIUS, SPEED),
        ),
        Case::new(
            "T4 law: Rayleigh time (s)",
            4.326991627612e-4,
            near,
            "Thornton 2015",
            || rayleigh_time(RADIUS, 2500.0, SOFT.0, SOFT.1),
        ),
    ]
}

fn elastic_engine() -> Vec<Case> {
    const SOURCE: &str = "Hertz 1882";
    let law = AnyNormal::Hertz(Hertz::new(MODULUS, 0.0));
    // Two spheres, or a sphere and a wall, 10 um deep, at rest.
    let pressed = move |on_wall: bool| {
        let mut plan = plan(1e-6, 2500.0, frictionless(law));
        let at = |x: f64| sphere(dvec3(x, 0.0, 0.0), RADIUS, DVec3::ZERO, DVec3::ZERO);
        if on_wall {
            plan.walls
                .push(plane(dvec3(1e-5 - RADIUS, 0.0, 0.0), DVec3::X));
            start(plan.with_particles(vec![at(0.0)])).observation()
        } else {
            start(plan.with_particles(vec![at(0.0), at(2.0 * RADIUS - 1e-5)])).observation()
        }
    };
    let force = move |on_wall| {
        move || {
            pressed(on_wall)
                .records
                .first()
                .map_or(f64::NAN, |record| record.force.length())
        }
    };
    // The overlap of 1e-5 m is the difference of lengths known to 1e-18 m.
    let near = Relative(1e-12);
    let mut cases = vec![
        Case::new(
            "T4 engine: force at 10 um, pair (N)",
            0.01158343465263,
            near,
            SOURCE,
            force(false),
        ),
        Case::new(
            "T4 engine: force at 10 um, wall (N)",
            0.01638145038461,
            near,
            SOURCE,
            force(true),
        ),
        Case::new(
            "T4 engine: energy at 10 um, pair (J)",
            4.633373861053e-8,
            near,
            SOURCE,
            move || pressed(false).elastic_energy,
        ),
    ];
    let head_on = HeadOn::equal(law, RADIUS, MASS, SPEED, 1.4e-3 / 10_000.0);
    let mut row = |name: &str, head_on: HeadOn, expected, pick: fn(Collision) -> f64| {
        // second order: (π/10⁴)² = 1e-7
        cases.push(Case::new(
            format!("T4 engine: {name}"),
            expected,
            Relative(1e-7),
            SOURCE,
            move || pick(head_on.run()),
        ));
    };
    row("restitution, pair", head_on, 1.0, |c| c.restitution);
    row("duration, pair (s)", head_on, 1.406751502853e-3, |c| {
        c.duration
    });
    row(
        "largest overlap, pair (m)",
        head_on,
        9.559089210180e-5,
        |c| c.largest_overlap,
    );
    row("largest force, pair (N)", head_on, 0.3423435303862, |c| {
        c.largest_force
    });
    let head_on = head_on.on_wall();
    row("restitution, wall", head_on, 1.0, |c| c.restitution);
    row("duration, wall (s)", head_on, 1.615933137217e-3, |c| {
        c.duration
    });
    row(
        "largest overlap, wall (m)",
        head_on,
        1.098051005100e-4,
        |c| c.largest_overlap,
    );
    row("largest force, wall (N)", head_on, 0.5960547064370, |c| {
        c.largest_force
    });
    cases
}

fn damped() -> Vec<Case> {
    const SOURCE: &str = "Tsuji, Tanaka & Ishida 1992; Antypov & Elliott 2011, eq. 17";
    const STEPS: f64 = 20_000.0;
    let table = [
        (0.95, 0.03650378, 1.005255, 0.9799007),
        (0.9, 0.07494953, 1.011068, 0.9595942),
        (0.8, 0.15842609, 1.024725, 0.9183028),
        (0.7, 0.25224736, 1.041892, 0.8759887),
        (0.5, 0.48176926, 1.093369, 0.7874709),
        (0.3, 0.80019287, 1.194866, 0.6911585),
        (0.1, 1.32186284, 1.510660, 0.5768492),
    ];
    let duration = hertz_contact_time(MODULUS, 0.5 * MASS, 0.5 * RADIUS, SPEED);
    let deepest = hertz_largest_overlap(MODULUS, 0.5 * MASS, 0.5 * RADIUS, SPEED);
    let mut cases = Vec::new();
    for (restitution, beta, time_ratio, overlap_ratio) in table {
        cases.push(Case::new(
            format!("T5 law: damping of e = {restitution}"),
            beta,
            Digit(1e-8),
            SOURCE,
            move || hertz_damping(restitution),
        ));
        let law = AnyNormal::Hertz(Hertz::new(MODULUS, hertz_damping(restitution)));
        let head_on = HeadOn::equal(law, RADIUS, MASS, SPEED, duration / STEPS);
        let error = lag(damping_ratio(restitution), STEPS);
        let mut row = |name: &str,
                       expected: f64,
                       digit: f64,
                       pick: Box<dyn Fn(Collision) -> f64 + Send + Sync>| {
            let tolerance = Absolute(error * expected + digit);
            cases.push(Case::new(
                format!("T5 engine: e = {restitution}, {name}"),
                expected,
                tolerance,
                SOURCE,
                move || pick(head_on.run()),
            ));
        };
        row("restitution", restitution, 0.0, Box::new(|c| c.restitution));
        row(
            "duration over elastic",
            time_ratio,
            1e-6,
            Box::new(move |c| c.duration / duration),
        );
        row(
            "largest overlap over elastic",
            overlap_ratio,
            1e-7,
            Box::new(move |c| c.largest_overlap / deepest),
        );
    }
    for speed in [0.02, 0.2, 2.0] {
        let duration = 1.093369
            * HERTZ_DURATION
            * hertz_largest_overlap(MODULUS, 0.5 * MASS, 0.5 * RADIUS, speed)
            / speed;
        let law = AnyNormal::Hertz(Hertz::new(MODULUS, hertz_damping(0.5)));
        let head_on = HeadOn::equal(law, RADIUS, MASS, speed, duration / 100.0);
        cases.push(Case::new(
            format!("T5 engine: e = 0.5 at {speed} m/s and t_c/100"),
            0.5,
            Absolute(1e-3),
            SOURCE,
            move || head_on.run().restitution,
        ));
    }
    cases
}

fn clamped() -> Vec<Case> {
    const SOURCE: &str = "force, not overlap, returns to zero (Schwager & Poeschel 2007); same ratio as the linear law";
    const STEPS: f64 = 20_000.0;
    let duration = hertz_contact_time(MODULUS, 0.5 * MASS, 0.5 * RADIUS, SPEED);
    [0.9, 0.7, 0.5, 0.3]
        .map(|wanted| {
            let zeta = damping_ratio_clamped(wanted);
            let mut law = Hertz::new(MODULUS, 5.0f64.sqrt() * zeta);
            law.clamp_tension = true;
            let head_on =
                HeadOn::equal(AnyNormal::Hertz(law), RADIUS, MASS, SPEED, duration / STEPS);
            Case::new(
                format!("T6 engine: Hertz restitution {wanted} with clamping"),
                wanted,
                Relative(lag(zeta, STEPS)),
                SOURCE,
                move || head_on.run().restitution,
            )
        })
        .into()
}
