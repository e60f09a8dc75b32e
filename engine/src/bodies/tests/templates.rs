//! Conditions for a clump, and the effective mass of its contacts.

use glam::{DQuat, DVec3, dvec3};
use mercury_common::formats::clump::Pebble;

use super::{rod, t_bar};
use crate::bodies::{Clump, ClumpError};
use crate::state::MaterialIndex;

#[test]
fn sizes_of_known_clumps() {
    let rod = rod();
    assert_eq!(rod.radius, 1.5);
    // Three spheres of 1 m: the diameter of equal volume is the cube root of 3.
    assert!((rod.equal_volume_diameter() - 3f64.cbrt()).abs() < 1e-15);
    assert_eq!(rod.shares(), [1.0 / 3.0; 3]);
    assert!((t_bar().radius - (3.0f64.hypot(0.6) + 0.5)).abs() < 1e-15);
}

#[test]
fn a_lopsided_body_reaches_farther_on_one_side() {
    let pebble = |z, radius| Pebble {
        position: dvec3(0.0, 0.0, z),
        radius,
    };
    let pebbles = vec![pebble(0.5, 0.2), pebble(-1.0, 0.4)];
    let material = MaterialIndex::new(0);
    let clump = Clump::new("drop", material, pebbles, 1.0, 1.0, DVec3::ONE).unwrap();
    let is_near = |(below, above): (DVec3, DVec3), expected: [DVec3; 2]| {
        let off = (below - expected[0]).length() + (above - expected[1]).length();
        assert!(off < 1e-14, "{below} {above}");
    };
    let extent = clump.extent(1.0, DQuat::IDENTITY);
    is_near(extent, [dvec3(0.4, 0.4, 1.4), dvec3(0.4, 0.4, 0.7)]);
    // By a right angle about x, z goes to -y; twice as large.
    let turned = clump.extent(2.0, DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    is_near(turned, [dvec3(0.8, 1.4, 0.8), dvec3(0.8, 2.8, 0.8)]);
}

#[test]
fn the_contact_mass_is_that_of_the_stiffest_pose() {
    // A single sphere has its own mass as effective mass; its friction 2/7 of it, which is what the time step takes of any mass.
    let pebble = |position| Pebble {
        position,
        radius: 1.0,
    };
    let one = vec![pebble(DVec3::ZERO)];
    let sphere = Clump::new(
        "one",
        MaterialIndex::new(0),
        one,
        2.0,
        1.0,
        DVec3::splat(0.8),
    )
    .unwrap();
    assert!((sphere.contact_mass - 2.0).abs() < 1e-12);
    // A rod lies on three pebbles: 3/M + 2 l^2/I along the normal, more than at one end. With M = 3 u, I = 2.3 u: 1.87/u; the bound
    // for friction springs, sum of (1/M + |c|^2/I) with the slow axis I_1 = 0.3 u at r = 0.5 m, is 3 (1/3 + 0.25/0.3) / 3.5.
    let unit = std::f64::consts::PI / 6.0;
    let expected = unit / (1.0 + 2.0 / 2.3);
    let rod = rod();
    assert!(
        (rod.contact_mass / expected - 1.0).abs() < 1e-12,
        "{} {expected}",
        rod.contact_mass
    );
}

/// A ball whose mass sits near its middle turns easily: I = f m R^2, and a friction spring sees m/(1 + 1/f), less than the 2/7 m
/// of a sphere where f < 2/5. This smaller mass counts for the contact.
#[test]
fn the_contact_mass_knows_bodies_that_turn_easily() {
    let (radius, mass) = (0.3, 5.0);
    let pebble = Pebble {
        position: DVec3::ZERO,
        radius,
    };
    for factor in [0.6, 0.4, 0.1, 0.02] {
        let moments = DVec3::splat(factor * mass * radius * radius);
        let ball = Clump::new(
            "ball",
            MaterialIndex::new(0),
            vec![pebble],
            mass,
            0.1,
            moments,
        );
        let expected = mass * (3.5 / (1.0 + 1.0 / factor)).min(1.0);
        let found = ball.unwrap().contact_mass;
        assert!(
            (found / expected - 1.0).abs() < 1e-12,
            "{factor}: {found}, not {expected}"
        );
    }
}

#[test]
fn what_is_no_body_is_refused() {
    let pebble = Pebble {
        position: DVec3::ZERO,
        radius: 1.0,
    };
    let clump = |pebbles, mass, moments| {
        Clump::new("c", MaterialIndex::new(0), pebbles, mass, 1.0, moments)
    };
    let message = |clump: Result<Clump, ClumpError>| clump.unwrap_err().to_string();
    assert_eq!(
        message(clump(vec![], 1.0, DVec3::ONE)),
        "there are no pebbles"
    );
    assert_eq!(
        message(clump(vec![pebble], 0.0, DVec3::ONE)),
        "the mass must be a number above 0, got 0"
    );
    assert_eq!(
        message(clump(vec![pebble], 1.0, dvec3(1.0, 1.0, 2.1))),
        "the moments [1, 1, 2.1] kg m^2 fit no body: each must be at most the sum of the other two"
    );
    let hole = Pebble {
        radius: f64::NAN,
        ..pebble
    };
    assert_eq!(
        message(clump(vec![pebble, hole], 1.0, DVec3::ONE)),
        "a pebble's radius must be a number above 0, got NaN"
    );
}
