//! One element by the numbers of the theory (T31).

use std::f64::consts::PI;

use glam::{DQuat, DVec3, dvec3};
use proptest::prelude::*;

use super::{LENGTH, RADIUS, YOUNG, element};
use crate::bonds::element::Modes;
use crate::bonds::evaluation::Motion;
use crate::bonds::{Action, Ends, LawOfBonds, Section};

/// Small rotations: what is of second order in them is below the tolerance.
const SMALL: f64 = 1e-7;

/// Ends of an element along x whose ends were shifted (m) and turned (rad) since the gluing, all of it turned by `turn`.
fn ends(shift: DVec3, turns: [DVec3; 2], turn: DQuat) -> Ends {
    Ends {
        branch: turn * (DVec3::X * LENGTH + shift),
        velocity: DVec3::ZERO,
        rotations: turns.map(|by| turn * DQuat::from_scaled_axis(by)),
        spins: [DVec3::ZERO; 2],
    }
}

#[test]
fn the_six_modes_have_the_stiffness_of_timoshenkos_beam() {
    // T31, printed to ten digits.
    let (tension, shear, turn, twist) = (
        157_079.632_7,
        37_699.111_84,
        37.699_111_84,
        0.031_415_926_54,
    );
    let bending = YOUNG * PI * RADIUS.powi(4) / 4.0 / LENGTH;
    let (phi, k) = (2.125, bending / 3.125);
    let element = element(0.0);
    let act = |shift: DVec3, a: DVec3, b: DVec3| element.act(&ends(shift, [a, b], DQuat::IDENTITY));
    let near = |found: DVec3, expected: DVec3, scale: f64| {
        assert!(
            found.abs_diff_eq(expected, 1e-6 * scale),
            "{found} instead of {expected}"
        );
    };
    let stretch = SMALL * LENGTH;
    // Tension pulls A along x.
    let pulled = act(DVec3::X * stretch, DVec3::ZERO, DVec3::ZERO);
    near(
        pulled.force,
        DVec3::X * (tension * stretch),
        tension * stretch,
    );
    // Shear: B shifted along y; A is pulled along, and both are turned against the line.
    for (across, sign, about) in [(DVec3::Y, 1.0, DVec3::Z), (DVec3::Z, -1.0, DVec3::Y)] {
        let sheared = act(across * stretch, DVec3::ZERO, DVec3::ZERO);
        near(sheared.force, across * (shear * stretch), shear * stretch);
        let couple = about * (sign * turn * stretch);
        near(sheared.couples[0], couple, turn * stretch);
        near(sheared.couples[1], couple, turn * stretch);
        // An end is turned.
        let bent = act(DVec3::ZERO, DVec3::ZERO, about * SMALL);
        near(
            bent.couples[1],
            about * (-(4.0 + phi) * k * SMALL),
            4.0 * k * SMALL,
        );
        near(
            bent.couples[0],
            about * (-(2.0 - phi) * k * SMALL),
            4.0 * k * SMALL,
        );
        near(bent.force, across * (-sign * turn * SMALL), turn * SMALL);
        let bent = act(DVec3::ZERO, about * SMALL, DVec3::ZERO);
        near(
            bent.couples[0],
            about * (-(4.0 + phi) * k * SMALL),
            4.0 * k * SMALL,
        );
        near(
            bent.couples[1],
            about * (-(2.0 - phi) * k * SMALL),
            4.0 * k * SMALL,
        );
    }
    let twisted = act(DVec3::ZERO, DVec3::ZERO, DVec3::X * SMALL);
    near(
        twisted.couples[0],
        DVec3::X * (twist * SMALL),
        twist * SMALL,
    );
    near(
        twisted.couples[1],
        DVec3::X * (-twist * SMALL),
        twist * SMALL,
    );
}

/// Springs over the section are the beam of Euler and Bernoulli where the shear stiffness is 12 E I/(A L^3).
#[test]
fn parallel_bonds_are_eulers_beam_at_one_shear_stiffness() {
    let section = Section { radius: RADIUS };
    let euler = LawOfBonds::Beam {
        youngs_modulus: YOUNG,
        poisson_ratio: None,
    };
    let parallel = LawOfBonds::Parallel {
        normal_stiffness: YOUNG / LENGTH,
        shear_stiffness: 12.0 * YOUNG * section.moment() / (section.area() * LENGTH.powi(3)),
    };
    let [a, b] = [euler, parallel].map(|law| law.stiffness(LENGTH, section));
    for (one, other) in [
        (a.normal, b.normal),
        (a.shear, b.shear),
        (a.bending, b.bending),
    ] {
        assert!((one / other - 1.0).abs() < 1e-14);
    }
    // k_s J.
    let twist = 12.0 * YOUNG * section.moment() / (section.area() * LENGTH.powi(3));
    assert!((b.twist / (twist * 2.0 * section.moment()) - 1.0).abs() < 1e-14);
}

/// Stresses are those of Potyondy & Cundall (2004): T/A + |M| r/I and |V|/A + |M_t| r/J.
#[test]
fn stresses_are_those_of_a_round_section() {
    let element = element(0.0);
    let (area, moment) = (PI * RADIUS * RADIUS, 0.25 * PI * RADIUS.powi(4));
    let stretch = SMALL * LENGTH;
    let act = |shift: DVec3, b: DVec3| {
        element
            .act(&ends(shift, [DVec3::ZERO, b], DQuat::IDENTITY))
            .stresses
    };
    let [tension, shear] = act(DVec3::X * stretch, DVec3::ZERO);
    assert!((tension / (YOUNG * SMALL) - 1.0).abs() < 1e-6 && shear == 0.0);
    let [tension, _] = act(DVec3::X * -stretch, DVec3::ZERO);
    assert!((tension / (YOUNG * SMALL) + 1.0).abs() < 1e-6);
    let [_, shear] = act(DVec3::ZERO, DVec3::X * SMALL);
    let twist = 0.031_415_926_54 * SMALL * RADIUS / (2.0 * moment);
    assert!((shear / twist - 1.0).abs() < 1e-6);
    let [tension, shear] = act(DVec3::Y * stretch, DVec3::ZERO);
    let bent = 37.699_111_84 * stretch * RADIUS / moment;
    assert!((tension / bent - 1.0).abs() < 1e-6);
    assert!((shear / (37_699.111_84 * stretch / area) - 1.0).abs() < 1e-6);
}

fn vector(size: f64) -> impl Strategy<Value = DVec3> {
    let one = -size..size;
    (one.clone(), one.clone(), one).prop_map(|(x, y, z)| dvec3(x, y, z))
}

proptest! {
    /// A rigid motion makes no force; forces, momentum and angular momentum turn with it.
    #[test]
    fn rigid_motions_change_nothing(
        turn in vector(3.0),
        shift in vector(1e-4),
        a in vector(0.2),
        b in vector(0.2),
    ) {
        let element = element(0.0);
        let turn = DQuat::from_scaled_axis(turn);
        let rest = element.act(&ends(DVec3::ZERO, [DVec3::ZERO; 2], turn));
        // Round-off of unit quaternions and of the length, some 1e-16 each.
        prop_assert!(rest.force.length() < 1e-12 * YOUNG * PI * RADIUS * RADIUS);
        prop_assert!(rest.couples.iter().all(|c| c.length() < 1e-12 * YOUNG * RADIUS.powi(3)));
        let still = element.act(&ends(shift, [a, b], DQuat::IDENTITY));
        let turned = element.act(&ends(shift, [a, b], turn));
        prop_assert!(turned.force.abs_diff_eq(turn * still.force, 1e-9));
        for (one, other) in turned.couples.iter().zip(still.couples) {
            prop_assert!(one.abs_diff_eq(turn * other, 1e-12));
        }
        // Angular momentum: about A the force on B has the lever of the whole branch.
        let branch = DVec3::X * LENGTH + shift;
        let sum = still.couples[0] + still.couples[1] + branch.cross(-still.force);
        prop_assert!(sum.length() < 1e-14, "{}", sum);
    }

    /// Forces are the gradient of the energy, to second order in the rotations.
    #[test]
    fn forces_follow_from_the_energy(shift in vector(2e-6), a in vector(1e-3), b in vector(1e-3)) {
        let element = element(0.0);
        let energy = |shift: DVec3, a: DVec3, b: DVec3| {
            element.act(&ends(shift, [a, b], DQuat::IDENTITY)).energy
        };
        let found = element.act(&ends(shift, [a, b], DQuat::IDENTITY));
        let (way, turn) = (1e-8, 1e-5);
        // Terms left out: of the order of the rotations, 1e-3, and a third of that for components.
        let most = 5e-3;
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let slope = |f: &dyn Fn(f64) -> f64, h: f64| (f(h) - f(-h)) / (2.0 * h);
            let on_b = -slope(&|h| energy(shift + axis * h, a, b), way);
            let scale = 157_080.0 * 2e-6;
            prop_assert!((on_b + found.force.dot(axis)).abs() < most * scale);
            let scale = 0.2 * 1e-3;
            let couple = -slope(&|h| energy(shift, a + axis * h, b), turn);
            prop_assert!((couple - found.couples[0].dot(axis)).abs() < most * scale);
            let couple = -slope(&|h| energy(shift, a, b + axis * h), turn);
            prop_assert!((couple - found.couples[1].dot(axis)).abs() < most * scale);
        }
    }

    /// Damping takes what its forces do on the ends.
    #[test]
    fn damping_takes_the_power_of_its_forces(
        velocity in vector(1.0),
        a in vector(100.0),
        b in vector(100.0),
    ) {
        let damped = element(0.3);
        let moving = Ends { velocity, spins: [a, b], ..ends(DVec3::ZERO, [DVec3::ZERO; 2], DQuat::IDENTITY) };
        let Action { force, couples, .. } = damped.act(&moving);
        let given = -force.dot(velocity) + couples[0].dot(a) + couples[1].dot(b);
        let motion = Motion {
            velocity: velocity.into(),
            spins: [a.into(), b.into()],
        };
        let taken = damped.damping_power(moving.branch.into(), &motion, &motion);
        prop_assert!(taken >= 0.0);
        prop_assert!((taken + given).abs() <= 1e-12 * taken);
    }
}

#[test]
fn modes_are_all_zero_without_damping() {
    assert_eq!(element(0.0).damping, Modes::default());
}
