//! T16 and T17: the Mindlin law along prescribed paths of a sphere on a plane.

use glam::{DVec3, dvec3};
use mercury_engine::contact::tangential::StoredForce;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Contact, Hertz, Mindlin, MindlinRescaled,
    NormalLaw, PairLaw, TangentialLaw,
};
use mercury_engine::lanes::Vector;

use super::Case;
use super::Tolerance::{Absolute, Relative};
use crate::scenes::{advance, contact_at_rest, held, plan, plane, sphere, start};

const RADIUS: f64 = 0.25;
const MODULUS: f64 = 1e5;
const SHEAR_MODULUS: f64 = 65000.0;
const MU: f64 = 0.1;
const OVERLAP: f64 = 0.015;
/// μ N at the overlap above: 0.1 · (4/3) E* √R δ^(3/2).
const LIMIT: f64 = 12.247448714;
const AMPLITUDE: f64 = 0.0025;

/// Rows of T16 and T17.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = constant_overlap();
    cases.extend(changing_overlap());
    cases
}

fn law(factor: f64, friction: f64) -> Mindlin {
    Mindlin::new(SHEAR_MODULUS, factor, 0.0, friction, friction)
}

/// A contact that moves along x by `way` (m) in one second.
fn sheared(overlap: f64, way: f64) -> Contact {
    Contact {
        tangential_velocity: Vector::X * way,
        ..contact_at_rest(overlap, RADIUS, 1.0)
    }
}

/// Friction (N) along −x after ways (m) along x, one step each.
fn after(factor: f64, ways: &[f64]) -> f64 {
    let normal = Hertz::new(MODULUS, 0.0).elastic_force(RADIUS, OVERLAP);
    let mut history = Default::default();
    ways.iter()
        .map(|&way| {
            -law(factor, MU)
                .force(&sheared(OVERLAP, way), normal, 1.0, &mut history)
                .x
        })
        .last()
        .unwrap_or(f64::NAN)
}

/// Work (J) that friction takes in a steady cycle of the engine, by the trapezoidal rule over its steps.
fn cycle(factor: f64) -> f64 {
    let law = PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(MODULUS, 0.0)),
        tangential: AnyTangential::Mindlin(law(factor, MU)),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let steps = 20_000;
    let step = 2.0 * AMPLITUDE / steps as f64;
    let mut plan = plan(1.0, 1000.0, law);
    plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
    let ball = sphere(
        dvec3(0.0, 0.0, RADIUS - OVERLAP),
        RADIUS,
        step * DVec3::X,
        DVec3::ZERO,
    );
    let mut engine = start(plan.with_particles(vec![held(ball)]));
    advance(&mut engine, steps / 2);
    let mut work = 0.0;
    for direction in [-1.0, 1.0] {
        engine.particles.prescribed[0].velocity[0] = Some(direction * step);
        for _ in 0..steps {
            let before = engine.particles.loads[0].force.x;
            advance(&mut engine, 1);
            work += 0.5 * (before + engine.particles.loads[0].force.x) * direction * step;
        }
    }
    -work
}

fn constant_overlap() -> Vec<Case> {
    const SOURCE: &str = "Mindlin 1949, Coulomb's limit";
    let digits = Relative(1e-9);
    let mut cases = vec![
        Case::new(
            "T16 law: normal force (N)",
            122.4744871,
            digits,
            "Hertz 1882",
            || {
                let law = Hertz::new(MODULUS, 0.0);
                law.force(&contact_at_rest(OVERLAP, RADIUS, 1.0), &mut ())
                    .total()
            },
        ),
        Case::new(
            "T16 law: tangential stiffness (N/m)",
            31843.366656,
            digits,
            SOURCE,
            || law(1.0, MU).stiffness(&contact_at_rest(OVERLAP, RADIUS, 1.0)),
        ),
        Case::new(
            "T16 law: friction at 4 um, factor 2/3 (N)",
            0.0849156444,
            digits,
            SOURCE,
            || after(2.0 / 3.0, &[4e-6]),
        ),
    ];
    for (factor, name, slip) in [
        (2.0 / 3.0, "2/3", 5.769230769e-4),
        (1.0, "1", 3.846153846e-4),
    ] {
        cases.push(Case::new(
            format!("T16 law: friction just below the slip displacement, factor {name} (N)"),
            LIMIT * (1.0 - 1e-6),
            digits,
            SOURCE,
            move || after(factor, &[4e-6, slip * (1.0 - 1e-6) - 4e-6]),
        ));
        cases.push(Case::new(
            format!("T16 law: friction just above it, factor {name} (N)"),
            LIMIT,
            digits,
            SOURCE,
            move || after(factor, &[4e-6, slip * 1.0001 - 4e-6]),
        ));
        // The trapezoidal rule cuts off at most k_t dx²/8 at each of four corners, 2e-8 of the whole.
        let dissipated = 4.0 * LIMIT * (AMPLITUDE - slip);
        cases.push(Case::new(
            format!("T16 engine: loss in a steady cycle, factor {name} (J)"),
            dissipated,
            Relative(1e-7),
            SOURCE,
            move || cycle(factor),
        ));
    }
    cases
}

/// Shears at a small overlap, unshears at a large one, releases. Returns the work done by the spring (J), and the force along x
/// (N) before and after the release. `force` gives the force along x after a way at an overlap.
fn shear_press_unshear_release(mut force: impl FnMut(f64, f64) -> f64) -> (f64, f64, f64) {
    let (shallow, deep, shear) = (0.00375, 0.015, 1e-4);
    let loaded = force(shallow, shear);
    let pressed = force(deep, 0.0);
    let unsheared = force(deep, -shear);
    let released = force(shallow, 0.0);
    // forces are linear in the way, so the trapezoidal rule is exact
    let work = 0.5 * loaded * shear - 0.5 * (pressed + unsheared) * shear;
    (work, unsheared, released)
}

fn changing_overlap() -> Vec<Case> {
    const SOURCE: &str = "work along the path (Elata & Berryman 1996)";
    let load = |overlap| Hertz::new(MODULUS, 0.0).elastic_force(RADIUS, overlap);
    let secant = move || {
        let (law, mut history) = (law(2.0 / 3.0, 1e3), Default::default());
        shear_press_unshear_release(move |overlap, way| {
            law.force(&sheared(overlap, way), load(overlap), 1.0, &mut history)
                .x
        })
    };
    let rescaled = move || {
        let law = MindlinRescaled {
            plain: law(2.0 / 3.0, 1e3),
        };
        let mut history = StoredForce::default();
        shear_press_unshear_release(move |overlap, way| {
            law.force(&sheared(overlap, way), load(overlap), 1.0, &mut history)
                .x
        })
    };
    let stiffness = |overlap: f64| 2.0 / 3.0 * 8.0 * SHEAR_MODULUS * (RADIUS * overlap).sqrt();
    let (soft, stiff, shear) = (stiffness(0.00375), stiffness(0.015), 1e-4);
    vec![
        Case::new(
            "T17 law: energy that the secant law creates (J)",
            5.30722778e-5,
            Relative(1e-8),
            SOURCE,
            move || secant().0,
        ),
        Case::new(
            "T17 law: force left by the secant law (N)",
            0.0,
            Absolute(1e-12 * stiff * shear),
            SOURCE,
            move || secant().2,
        ),
        // −k₁ξ²/2 in; pressing keeps the force k₁ξ; unshearing against k₂ gives k₁ξ² − k₂ξ²/2: never more than was put in
        Case::new(
            "T17 law: work of the rescaled law (J)",
            0.5 * (soft - stiff) * shear * shear,
            Relative(1e-12),
            SOURCE,
            move || rescaled().0,
        ),
        Case::new(
            "T17 law: force of the rescaled law before the release (N)",
            (stiff - soft) * shear,
            Relative(1e-12),
            SOURCE,
            move || rescaled().1,
        ),
        // releasing to half the contact radius halves what is left
        Case::new(
            "T17 law: force of the rescaled law after the release (N)",
            0.5 * (stiff - soft) * shear,
            Relative(1e-12),
            SOURCE,
            move || rescaled().2,
        ),
    ]
}
