//! Chains as beams: cantilever, frequency, flight, energy and momenta, periodic faces.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};

use super::{
    LENGTH, RADIUS, YOUNG, bonds, chain, close_to, elastic, glue, inputs, kinetic, mass, row, start,
};
use crate::bonds::{Action, BondPlan, LawOfBonds};
use crate::cell::Cell;
use crate::step::Engine;

/// Deflection of the tip under loads P at the distances a from the fixed end, by superposition: P a^2 (3 L - a)/(6 E I) + P a/(kappa G A).
fn tip(loads: &[(f64, f64)]) -> f64 {
    let length = loads.iter().map(|load| load.1).fold(0.0, f64::max);
    let (area, moment) = (PI * RADIUS * RADIUS, 0.25 * PI * RADIUS.powi(4));
    let shear = 0.882_352_941_2 * YOUNG / 2.5 * area;
    let of = |&(p, a): &(f64, f64)| {
        p * a * a * (3.0 * length - a) / (6.0 * YOUNG * moment) + p * a / shear
    };
    loads.iter().map(of).sum()
}

/// T31: nodes of a straight chain lie on the exact line of Timoshenko's beam, however many they are.
#[test]
fn a_cantilever_bends_like_timoshenkos_beam() {
    // The printed number, of a load at the tip alone.
    assert!((tip(&[(1e-6, 5.0 * LENGTH)]) / 4.334_319_62e-9 - 1.0).abs() < 1e-8);
    for count in [2, 3, 6] {
        let gravity = 1e-3;
        let mut inputs = inputs(1e-6, &chain(count), glue());
        inputs.gravity = DVec3::Z * -gravity;
        inputs.particles[0].fixed = true;
        let mut engine = start(inputs);
        // Kinetic damping: all stop where the kinetic energy begins to fall.
        let (mut last, mut stops) = (0.0, 0);
        while stops < 60 {
            engine.step(None).unwrap();
            engine.complete_step().unwrap();
            let now = kinetic(&engine);
            if now < last {
                for record in &mut engine.particles.records {
                    record.velocity = DVec3::ZERO;
                    record.angular_velocity = DVec3::ZERO;
                }
                stops += 1;
            }
            last = if now < last { 0.0 } else { now };
        }
        let weight = mass() * gravity;
        let loads: Vec<_> = (1..count).map(|k| (weight, LENGTH * k as f64)).collect();
        let found = -engine.particles.records[row(&engine, count - 1)].position.z;
        let expected = tip(&loads);
        assert!(
            (found / expected - 1.0).abs() < 1e-6,
            "{count}: {found} {expected}"
        );
    }
}

/// A sphere on one bond swings with the frequency of its 2 x 2 matrices.
#[test]
fn the_first_frequency_is_that_of_the_matrices() {
    let k = YOUNG * PI * RADIUS.powi(4) / 4.0 / LENGTH / 3.125;
    let (m, i) = (mass(), 0.4 * mass() * RADIUS * RADIUS);
    // det(K - w^2 M) = 0 of K = [[12 k/L^2, -6 k/L], [-6 k/L, (4 + Phi) k]].
    let (a, b, c) = (
        12.0 * k / (LENGTH * LENGTH) / m,
        6.125 * k / i,
        6.0 * k / LENGTH,
    );
    let squared = 0.5 * (a + b) - (0.25 * (a - b) * (a - b) + c * c / (m * i)).sqrt();
    let omega = squared.sqrt();
    // Of the mode: theta = (a - w^2) m/c u.
    let theta = (a - squared) * m / c;
    let steps_per_period = 400.0;
    let dt = 2.0 * PI / omega / steps_per_period;
    let mut inputs = inputs(dt, &chain(2), glue());
    inputs.particles[0].fixed = true;
    let speed = 1e-6 * LENGTH * omega;
    inputs.particles[1].velocity = DVec3::Y * speed;
    inputs.particles[1].angular_velocity = DVec3::Z * (speed * theta);
    let mut engine = start(inputs);
    let mut crossings = Vec::new();
    let mut last = 0.0;
    for step in 1..=(5.2 * steps_per_period) as u32 {
        engine.step(None).unwrap();
        let y = engine.particles.records[row(&engine, 1)].position.y;
        if last < 0.0 && y >= 0.0 {
            crossings.push(f64::from(step - 1) + last / (last - y));
        }
        last = y;
    }
    let period = (crossings[4] - crossings[0]) / 4.0;
    // Velocity Verlet: (w dt)^2/24 too fast, 1e-5 here; the second mode, three times as fast, is not excited.
    assert!((period / steps_per_period - 1.0).abs() < 1e-3, "{period}");
}

/// Flight with spin about the line of centres: nothing acts, for 100,000 steps.
#[test]
fn rigid_flight_makes_no_force() {
    let mut inputs = inputs(1e-6, &chain(3), glue());
    for particle in &mut inputs.particles {
        particle.velocity = dvec3(0.1, -0.2, 0.3);
        particle.angular_velocity = DVec3::X * 300.0;
    }
    let mut engine = start(inputs);
    let before = kinetic(&engine);
    let most = |of: &dyn Fn(&Action) -> f64, engine: &Engine| {
        bonds(engine)
            .all()
            .iter()
            .map(|bond| of(&bond.now))
            .fold(0.0, f64::max)
    };
    let area = PI * RADIUS * RADIUS;
    for _ in 0..100 {
        engine.steps_at_once(1000, None).unwrap();
        assert!(most(&|now| now.force.length(), &engine) < 1e-12 * YOUNG * area);
        assert!(most(&|now| now.couples[0].length(), &engine) < 1e-12 * YOUNG * area * RADIUS);
    }
    engine.complete_step().unwrap();
    assert!((kinetic(&engine) / before - 1.0).abs() < 1e-10);
}

/// A chain that is thrown about and spun keeps its energy, momentum and angular momentum.
#[test]
fn energy_and_momenta_are_kept() {
    let mut inputs = inputs(2e-7, &chain(4), glue());
    inputs.particles[1].velocity = dvec3(0.01, 0.02, -0.03);
    inputs.particles[3].angular_velocity = dvec3(40.0, 30.0, -20.0);
    let mut engine = start(inputs);
    let sums = |engine: &Engine| {
        let rows = engine.particles.records.iter();
        let m = mass();
        let momentum: DVec3 = rows.clone().map(|r| r.velocity * m).sum();
        let angular: DVec3 = rows
            .map(|r| {
                r.position.cross(r.velocity) * m + r.angular_velocity * (0.4 * m * RADIUS * RADIUS)
            })
            .sum();
        (momentum, angular)
    };
    let before = (kinetic(&engine), sums(&engine));
    engine.steps_at_once(50_000, None).unwrap();
    engine.complete_step().unwrap();
    let energy = kinetic(&engine) + elastic(&engine);
    // (w dt)^2/8 of the fastest mode: some 1e-4; and rotations of some 1e-2 squared.
    assert!(
        (energy / before.0 - 1.0).abs() < 1e-3,
        "{energy} {}",
        before.0
    );
    let (momentum, angular) = sums(&engine);
    let (was, turned) = before.1;
    assert!(momentum.abs_diff_eq(was, 1e-12 * was.length()));
    assert!(
        angular.abs_diff_eq(turned, 1e-9 * turned.length()),
        "{angular} {turned}"
    );
}

/// A chain across the period is a chain, and a bond that is stretched beyond half a period is still that of its own image.
#[test]
fn bonds_lead_through_periodic_faces() {
    let mut ring = inputs(1e-6, &chain(4), glue());
    ring.cell = Cell::new(
        DVec3::ZERO,
        dvec3(4.0 * LENGTH, 0.1, 0.1),
        [true, false, false],
    );
    for particle in &mut ring.particles {
        particle.position += dvec3(0.5 * RADIUS, 0.05, 0.05);
        particle.velocity = DVec3::X;
    }
    let mut engine = start(ring);
    assert_eq!(bonds(&engine).all().len(), 4);
    // Ten periods.
    engine.steps_at_once(80_000, None).unwrap();
    let area = PI * RADIUS * RADIUS;
    for bond in bonds(&engine).all() {
        // Places of 1e-2 m, rounded to 2e-18 m many times over.
        assert!(bond.now.force.length() < 1e-9 * YOUNG * area);
    }
    let weak = BondPlan {
        law: LawOfBonds::Parallel {
            normal_stiffness: 1.0,
            shear_stiffness: 1.0,
        },
        ..glue()
    };
    let mut apart = inputs(1e-6, &chain(2), weak);
    let period = 3.0 * LENGTH;
    apart.cell = Cell::new(DVec3::ZERO, dvec3(period, 0.1, 0.1), [true, false, false]);
    apart.particles[1].velocity = DVec3::X;
    for particle in &mut apart.particles {
        particle.position += dvec3(0.5 * RADIUS, 0.05, 0.05);
    }
    let mut engine = start(apart);
    // 1.5 mm: 3.5 mm is more than half of the period of 6 mm, and the image on the other side is nearer.
    engine.steps_at_once(1500, None).unwrap();
    close_to(bonds(&engine).all()[0].branch.x, LENGTH + 1.5e-3, 1e-6);
}
