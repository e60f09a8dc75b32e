//! T28 and T29: dry cohesion.

use std::f64::consts::PI;

use mercury_engine::contact::adhesion::dry::{Branch, Dry, Jkr, Pull, VanDerWaals};
use mercury_engine::contact::{
    AdhesionLaw, AnyNormal, Held, Hertz, NoFriction, NoRolling, PairLaw,
};

use super::Case;
use super::Tolerance::{Absolute, Digit};
use crate::dry::{PLANE, STICKS, W_S, ball, gap, rebound, velocity};
use crate::scenes::{contact_at_rest, observed_step};

/// E* of E = 100 MPa, nu = 0.3, Pa.
const MODULUS: f64 = 1e8 / (2.0 * (1.0 - 0.3 * 0.3));
/// J/m^2
const WORK: f64 = 0.05;

const JKR: &str =
    "Johnson, Kendall & Roberts 1971, the larger root by bisection in 50 digits; as printed";
const REBOUND: &str = "sqrt(1 - (v_s/v)^2), v_s = sqrt(2 W_s/m)";

/// Rows of T28 and T29.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (radius, overlap, expected, digit) in [
        (5e-5, 0.0, -1.047197551e-5, 1e-14),
        (5e-5, 1e-7, 7.517437405e-6, 1e-15),
        (5e-5, -2.782800755e-8, -1.177828222e-5, 1e-14),
        (1e-4, 1e-7, 5.201488973e-6, 1e-15),
    ] {
        cases.push(Case::new(
            format!("T28 law: jkr, R* = {radius:e} m, overlap {overlap:e} m: force (N)"),
            expected,
            Digit(digit),
            JKR,
            move || jkr_force(overlap, radius),
        ));
    }
    for (radius, expected) in [(5e-5, 5.565601510e-8), (1e-4, 7.012218498e-8)] {
        cases.push(Case::new(
            format!("T28 law: jkr, R* = {radius:e} m: gap at the end of the neck (m)"),
            expected,
            Digit(1e-17),
            "3 a_f^2/R*, a_f^3 = pi W R*^2/(8 E*)",
            move || Jkr::new(WORK, MODULUS).end(radius),
        ));
    }
    for (part, what) in [(0.3, "0.3"), (0.98, "0.98")] {
        cases.push(Case::new(
            format!("T28 engine: jkr, ball on a wall at {what} v_s: speed away from it after 60 us (m/s)"),
            0.0,
            Absolute(0.0),
            "it sticks",
            move || rebound(&mut ball(part * STICKS, PLANE, &[])),
        ));
    }
    for times in [1.05f64, 1.3, 2.0] {
        cases.push(Case::new(
            format!("T28 engine: jkr, ball on a wall at {times} v_s: restitution"),
            (1.0 - 1.0 / (times * times)).sqrt(),
            // The touch is met within a step, v dt = 1.2e-11 m at 1.05 v_s, where 2.1e-5 N begin at once: 2.4e-16 J of 1.7e-12 J, of which 9 % are left.
            Absolute(1e-3),
            REBOUND,
            move || rebound(&mut ball(times * STICKS, PLANE, &[])) / (times * STICKS),
        ));
    }
    cases.push(Case::new(
        "T28 engine: jkr, ball on a wall at 2 v_s: dissipated by adhesion (J)",
        W_S,
        Absolute(2e-3 * W_S),
        "7.0922 (W^5 R*^4/E*^2)^(1/3), the integral of the force from the end to the touch",
        lost,
    ));
    let van_der_waals = Dry::VanDerWaals(VanDerWaals {
        hamaker: 6.5e-20,
        separation: 4e-10,
        range: 1e-8,
    });
    let dmt = Branch {
        force_per_radius: 2.0 * PI * WORK,
        ..Branch::NONE
    };
    let dmt = Dry::Pull(Pull::new("dmt", [dmt, Branch::NONE], true));
    for (name, law, gap, expected, digit) in [
        ("van-der-waals", van_der_waals, -1e-9, 5.070612981e-6, 1e-15),
        ("van-der-waals", van_der_waals, 2e-9, 1.335470086e-7, 1e-16),
        ("dmt", dmt, -1e-9, 2.356194490e-5, 1e-14),
    ] {
        cases.push(Case::new(
            format!("T29 law: {name}, R* = 75 um, gap {gap:e} m: pull (N)"),
            expected,
            Digit(digit),
            "the formula; as printed",
            move || {
                let contact = contact_at_rest(-gap, 7.5e-5, 1e-9);
                -law.force(&contact, 0.0, &mut Held(0.0)).normal.elastic
            },
        ));
    }
    cases
}

/// Whole force of the contact, N.
fn jkr_force(overlap: f64, radius: f64) -> f64 {
    let law = PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(MODULUS, 0.0)),
        tangential: NoFriction,
        rolling: NoRolling,
        adhesion: Dry::Jkr(Jkr::new(WORK, MODULUS)),
    };
    let contact = contact_at_rest(overlap, radius, 1e-9);
    let action = law.act(&contact, 0.0, &mut Default::default());
    action.force.dot(contact.normal)
}

/// What the budget counts of a touch and a parting, J.
fn lost() -> f64 {
    let mut engine = ball(2.0 * STICKS, PLANE, &[]);
    while engine.time() < 2e-5 && !(gap(&engine) > 2e-7 && velocity(&engine) > 0.0) {
        observed_step(&mut engine);
    }
    engine.audit().losses.of("adhesion")
}
