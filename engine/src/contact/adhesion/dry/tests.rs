//! Curves of the laws, against the theory and roots found in another way.

use std::f64::consts::PI;

use proptest::prelude::*;

use super::super::{AdhesionLaw, Contact};
use super::{Branch, Dry, Held, Jkr, Pull, VanDerWaals};
use crate::contact::{AnyNormal, AnyRolling, AnyTangential, Hertz, Histories, Mindlin, PairLaw};
use crate::lanes::Vector;

/// E* of T28, Pa.
const MODULUS: f64 = 1e8 / (2.0 * (1.0 - 0.3 * 0.3));
const WORK: f64 = 0.05;

type Law = PairLaw<AnyNormal, AnyTangential, AnyRolling, Dry>;

fn law(adhesion: Dry, beta: f64) -> Law {
    PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(MODULUS, beta)),
        tangential: AnyTangential::Mindlin(Mindlin::new(2e7, 1.0, 0.3, 0.5, 0.5)),
        rolling: AnyRolling::None,
        adhesion: adhesion.reaching(1e-3),
    }
}

fn contact(overlap: f64, effective_radius: f64) -> Contact {
    Contact {
        normal: Vector::X,
        distance: 4.0 * effective_radius - overlap,
        overlap,
        effective_radius,
        effective_mass: 1e-9,
        normal_velocity: 0.0,
        tangential_velocity: Vector::ZERO,
        sliding_normal: Vector::X,
        sliding_distance: 4.0 * effective_radius - overlap,
        centre_velocity: Vector::ZERO,
        spin: Vector::ZERO,
    }
}

/// The force on A along the normal of two that touch, and the history after it.
fn force(
    law: &Law,
    contact: &Contact,
) -> (f64, Histories<AnyNormal, AnyTangential, AnyRolling, Dry>) {
    let mut history = Default::default();
    let action = law.act(contact, 0.0, &mut history);
    (action.force.x, history)
}

/// F by bisection of δ(a), which grows beyond a_f.
fn by_bisection(overlap: f64, r: f64) -> f64 {
    let delta = |a: f64| a * a / r - (2.0 * PI * WORK * a / MODULUS).sqrt();
    let mut low = (PI * WORK * r * r / (8.0 * MODULUS)).cbrt();
    let mut high = 10.0 * (low + (r * overlap.abs()).sqrt());
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if delta(middle) < overlap {
            low = middle;
        } else {
            high = middle;
        }
    }
    let a = 0.5 * (low + high);
    4.0 * MODULUS * a.powi(3) / (3.0 * r) - (8.0 * PI * WORK * MODULUS * a.powi(3)).sqrt()
}

#[test]
fn jkr_has_the_numbers_of_t28() {
    let jkr = Jkr::new(WORK, MODULUS);
    let law = law(Dry::Jkr(jkr), 0.0);
    for (r, cases) in [
        (
            5e-5,
            &[
                (0.0, -1.047197551e-5),
                (1e-7, 7.517437405e-6),
                (-2.782800755e-8, -1.177828222e-5),
            ][..],
        ),
        (1e-4, &[(1e-7, 5.201488973e-6)][..]),
    ] {
        let pull_off = 1.5 * PI * WORK * r;
        for &(overlap, expected) in cases {
            let (force, _) = force(&law, &contact(overlap, r));
            // The numbers have ten digits.
            assert!(
                (force - expected).abs() < 1e-9 * pull_off,
                "{overlap}: {force}"
            );
        }
        // Largest pull, where t³ = 3/4: δ = −1/4 (3/4)^(1/3) a₀²/R*.
        let unit = (2.0 * PI * WORK * r * r / MODULUS).cbrt().powi(2) / r;
        let (most, _) = force(&law, &contact(-0.25 * 0.75f64.cbrt() * unit, r));
        assert!((most + pull_off).abs() < 1e-9 * pull_off, "{most}");
    }
    assert!((jkr.end(5e-5) - 5.565601510e-8).abs() < 1e-17);
    assert!((jkr.end(1e-4) - 7.012218498e-8).abs() < 1e-17);
}

proptest! {
    /// The whole curve to 1e-9 of the pull-off force. At the end the slope has no bound: δ is known to round-off, so that the force is to
    /// its root; so the curve is compared from 1e-6 of the end on.
    #[test]
    fn jkr_is_the_curve_of_another_root_finder(part in 0.0f64..1.0, log_radius in -6.0f64..-2.0) {
        let r = 10f64.powf(log_radius);
        let jkr = Jkr::new(WORK, MODULUS);
        let law = law(Dry::Jkr(jkr), 0.0);
        let end = jkr.end(r);
        // From the end of the neck to a hundred times as deep, more densely at the end.
        let overlap = end * (100.0 * part * part * part - 1.0 + 1e-6);
        let (force, _) = force(&law, &contact(overlap, r));
        let pull_off = 1.5 * PI * WORK * r;
        let scale = pull_off.max(force.abs());
        prop_assert!((force - by_bisection(overlap, r)).abs() < 1e-9 * scale, "{} at {} of {}", force, overlap, r);
    }

    /// F = -dU/d(gap), of normal law and adhesion together, and of each law alone.
    #[test]
    fn forces_are_gradients_of_energies(part in 0.01f64..1.0, log_radius in -5.0f64..-3.0) {
        let r = 10f64.powf(log_radius);
        let work = law(Dry::Jkr(Jkr::new(WORK, MODULUS)), 0.0);
        let end = Jkr::new(WORK, MODULUS).end(r);
        let linear = Branch { force: 1e-5, force_per_radius: 0.1, stiffness: 10.0, sign: 1.0 };
        let apart = Branch { force: 3e-6, force_per_radius: 0.0, stiffness: 40.0, sign: -1.0 };
        let dmt = Branch { force_per_radius: 0.3, ..Branch::NONE };
        let van_der_waals = VanDerWaals { hamaker: 6.5e-20, separation: 4e-10, range: 1e-8 };
        let linear_range = (1e-5 + 0.1 * r) / 10.0;
        for (law, from, until) in [
            (work, -end * (1.0 - 1e-3), 20.0 * end),
            (law(Dry::Pull(Pull::new("reversible", [linear, apart], false)), 0.0), -linear_range, linear_range),
            (law(Dry::Pull(Pull::new("dmt", [dmt, Branch::NONE], true)), 0.0), 1e-9, 1e-6),
            (law(Dry::VanDerWaals(van_der_waals), 0.0), -1e-8, 1e-8),
        ] {
            let overlap = from + part * (until - from);
            let h = 1e-4 * overlap.abs().min(end).min(1e-9);
            let energy = |overlap: f64| {
                let contact = contact(overlap, r);
                let mut history: Histories<AnyNormal, AnyTangential, AnyRolling, Dry> = Default::default();
                if overlap > 0.0 || law.adhesion.is_one_with_normal() {
                    law.act(&contact, 0.0, &mut history);
                    law.energy(&contact, &history)
                } else {
                    law.act_apart(&contact, 0.0, &mut history);
                    law.adhesion.energy(&contact, &history.3)
                }
            };
            let gradient = (energy(overlap + h) - energy(overlap - h)) / (2.0 * h);
            let contact = contact(overlap, r);
            let mut history = Default::default();
            let action = if overlap > 0.0 || law.adhesion.is_one_with_normal() {
                law.act(&contact, 0.0, &mut history)
            } else {
                law.act_apart(&contact, 0.0, &mut history)
            };
            // Round-off of the two energies over the distance, and the third derivative.
            let round_off = 1e-15 * energy(overlap).abs() / h;
            let scale = action.force.x.abs().max(1e-7);
            prop_assert!((action.force.x - gradient).abs() < 1e-4 * scale + 10.0 * round_off,
                "{}: {} and {} at {}", law.adhesion.name(), action.force.x, gradient, overlap);
        }
    }
}

/// The energies at the touch and at the end differ by W_s = 7.0922 (W⁵ R*⁴/E*²)^(1/3).
#[test]
fn a_touch_and_a_parting_lose_the_energy_of_the_neck() {
    for (r, expected) in [(5e-5, 6.133923178e-13), (1e-4, 1.545651786e-12)] {
        let jkr = Jkr::new(WORK, MODULUS);
        let law = law(Dry::Jkr(jkr), 0.0);
        let energy = |overlap: f64| {
            let contact = contact(overlap, r);
            let (_, history) = force(&law, &contact);
            law.energy(&contact, &history)
        };
        let lost = energy(-jkr.end(r)) - energy(0.0);
        assert!((lost / expected - 1.0).abs() < 1e-8, "{lost}");
        let scale = (WORK.powi(5) * r.powi(4) / MODULUS.powi(2)).cbrt();
        assert!((lost / scale - 7.0922).abs() < 1e-4, "{}", lost / scale);
    }
}

/// LAMMPS #4180: cohesion with a dashpot gave no number where the contact has negative overlap.
#[test]
fn friction_and_dashpot_go_on_in_the_neck() {
    let r = 5e-5;
    let jkr = Jkr::new(WORK, MODULUS);
    let beta = 0.4;
    let law = law(Dry::Jkr(jkr), beta);
    let overlap = -0.9 * jkr.end(r);
    let moving = Contact {
        normal_velocity: 1e-3,
        tangential_velocity: Vector::Y * 1e-3,
        ..contact(overlap, r)
    };
    let mut history: Histories<AnyNormal, AnyTangential, AnyRolling, Dry> = Default::default();
    let (dt, mut friction) = (1e-8, 0.0);
    for _ in 0..100 {
        let action = law.act(&moving, dt, &mut history);
        // The neck at this overlap, by Newton's method on δ(a).
        let a = {
            let mut a = (r * jkr.end(r)).sqrt() * 3.0;
            for _ in 0..100 {
                let root = (2.0 * PI * WORK * a / MODULUS).sqrt();
                a -= (a * a / r - root - overlap) / (2.0 * a / r - 0.5 * root / a);
            }
            a
        };
        let dashpot = beta * (1e-9 * 4.0 / 3.0 * MODULUS * a).sqrt() * 1e-3;
        assert!((action.normal.viscous + dashpot).abs() < 1e-9 * dashpot);
        let pull_off = 1.5 * PI * WORK * r;
        let load = action.normal.total() + action.adhesion.friction_load;
        let expected = jkr.force_at(overlap, r) - dashpot + 2.0 * pull_off;
        assert!(
            (load - expected).abs() < 1e-9 * pull_off,
            "{load}, {expected}"
        );
        friction = action.tangential.length();
        assert!(friction <= 0.5 * load * (1.0 + 1e-12), "{friction}, {load}");
    }
    // The spring holds: 8 G* a times the way, 1e-9 m; or the limit.
    assert!(friction > 0.0);
    assert!(law.touches(&moving, &history));
    // Beyond the end it is over, and all is forgotten.
    let gone = contact(-1.01 * jkr.end(r), r);
    assert!(!law.touches(&gone, &history));
    let action = law.act_apart(&gone, dt, &mut history);
    assert_eq!((action.force, history), (Vector::ZERO, Default::default()));
}

#[test]
fn the_stiffest_contact_bounds_every_slope_up_to_the_largest_pull() {
    let (r, mass) = (5e-5, 1e-9);
    let jkr = Jkr::new(WORK, MODULUS);
    let unit = (2.0 * PI * WORK * r * r / MODULUS).cbrt().powi(2) / r;
    for speed in [0.0, 1e-3, 0.1, 10.0] {
        let (spring, radius) = jkr.stiffest(0.0, mass, r, speed);
        // An impact with this energy goes as deep as that.
        let deepest = radius * radius / r - (2.0 * PI * WORK * radius / MODULUS).sqrt();
        let law = law(Dry::Jkr(jkr), 0.0);
        let contact = contact(deepest, r);
        let (_, history) = force(&law, &contact);
        let (stored, brought) = (law.energy(&contact, &history), 0.5 * mass * speed * speed);
        assert!(
            (stored - brought).abs() <= 1e-6 * brought + 1e-9 * WORK * r * r,
            "{stored}"
        );
        let start = -0.25 * 0.75f64.cbrt() * unit;
        for part in 0..1000 {
            let overlap = start + (deepest - start) * f64::from(part) / 1000.0;
            let h = 1e-5 * unit;
            let slope = (jkr.force_at(overlap + h, r) - jkr.force_at(overlap, r)) / h;
            assert!(
                slope <= spring.stiffness * (1.0 + 1e-4),
                "{slope} at {overlap}"
            );
        }
        // The chord from the largest pull to the end.
        let drop = jkr.force_at(-jkr.end(r), r) - jkr.force_at(start, r);
        let chord = drop / (start + jkr.end(r));
        assert!(chord <= spring.stiffness * (1.0 + 1e-9), "{chord}");
    }
}

#[test]
fn t29_and_the_branches_of_the_linear_laws() {
    let at = |law: Dry, overlap: f64, touched: bool| {
        let mut held = Held(f64::from(u8::from(touched)));
        let action = law.force(&contact(overlap, 7.5e-5), 0.0, &mut held);
        (action.normal.elastic, held.0)
    };
    let dmt = Branch {
        force_per_radius: 2.0 * PI * WORK,
        ..Branch::NONE
    };
    let dmt = Dry::Pull(Pull::new("dmt", [dmt, Branch::NONE], true));
    assert!((at(dmt, 1e-9, false).0 + 2.356194490e-5).abs() < 1e-14);
    assert_eq!(at(dmt, -1e-12, true), (0.0, 0.0));
    let linear = Branch {
        force: 1e-4,
        force_per_radius: 0.0,
        stiffness: 10.0,
        sign: 1.0,
    };
    let both = |name, forms| Dry::Pull(Pull::new(name, [linear, Branch::NONE], forms));
    let (reversible, irreversible) = (both("reversible", false), both("irreversible", true));
    // f − k_a s = 1e-4 − 10 × 4e-6 N
    assert!((at(reversible, -4e-6, false).0 + 6e-5).abs() < 1e-18);
    assert_eq!(at(irreversible, -4e-6, false), (0.0, 0.0));
    assert!((at(irreversible, -4e-6, true).0 + 6e-5).abs() < 1e-18);
    assert_eq!(at(irreversible, 1e-9, false), (-1e-4, 1.0));
    // 10 µm is the end, and the touch is forgotten there.
    assert_eq!(at(irreversible, -1.1e-5, true), (0.0, 0.0));
    // The longer branch of the two counts.
    let charge = Branch {
        sign: -1.0,
        ..linear
    };
    let far = Branch {
        force: 2e-4,
        force_per_radius: 0.0,
        stiffness: 5.0,
        sign: 1.0,
    };
    let charged = Dry::Pull(Pull::new("charged", [charge, far], false)).reaching(1e-3);
    assert_eq!(charged.range(), 4e-5);
    assert!((at(charged, 0.0, false).0 + 1e-4).abs() < 1e-18);
    assert!((at(charged, -2e-5, false).0 + 1e-4).abs() < 1e-18);
}
