//! Bonds that break: when, with what energy, and what the contact does then.

use glam::{DVec3, dvec3};

use super::{
    CONTACT, LENGTH, RADIUS, YOUNG, bonds, chain, close_to, glue, inputs, kinetic, row, start,
};
use crate::bonds::{BondPlan, Bonds, BreakMode, LawOfBonds};
use crate::cell::Cell;
use crate::step::Engine;

/// Damping and breaks take the energy that is missing.
#[test]
fn the_budget_closes_with_damping_and_breaks() {
    let plan = BondPlan {
        damping: 0.05,
        strengths: [3e3, f64::INFINITY],
        ..glue()
    };
    let mut inputs = inputs(1e-7, &chain(3), plan);
    inputs.energy_budget = true;
    inputs.particles[0].velocity = dvec3(-0.02, 0.005, 0.0);
    let mut engine = start(inputs);
    let before = kinetic(&engine);
    engine.steps_at_once(2000, None).unwrap();
    engine.complete_step().unwrap();
    let counts = bonds(&engine).counts()[0];
    assert!(counts.broken > 0 && counts.made == 2);
    let taken = engine.audit().losses.of("bonds");
    assert!(taken > 0.05 * before);
    let left = kinetic(&engine) + engine.observation().elastic_energy;
    close_to(left + taken, before, 1e-3);
}

/// A bond breaks in the step in which the strength is passed: a pull at a steady speed, (L - L0) E/L0 = strength.
#[test]
fn a_bond_breaks_in_the_step_that_passes_its_strength() {
    let (dt, speed, strength) = (1e-6, 1e-2, 1e5);
    let plan = BondPlan {
        strengths: [strength, f64::INFINITY],
        ..glue()
    };
    let mut inputs = inputs(dt, &chain(2), plan);
    inputs.particles[0].fixed = true;
    inputs.particles[1].prescribed = Some(Box::new(crate::state::PrescribedMotion {
        velocity: [Some(speed), Some(0.0), Some(0.0)],
        angular_velocity: [Some(0.0); 3],
    }));
    inputs.particles[1].velocity = DVec3::X * speed;
    let mut engine = start(inputs);
    // Stretch over a step: 1e-8 m, 500 Pa.
    let steps = (strength / YOUNG * LENGTH / (speed * dt)).ceil() as u64;
    engine.steps_at_once(steps - 1, None).unwrap();
    assert_eq!(bonds(&engine).all().len(), 1);
    engine.steps_at_once(2, None).unwrap();
    assert_eq!(bonds(&engine).all().len(), 0);
    let (part, _) = engine.part_and_core::<Bonds>().unwrap();
    let broken = part.take_breaks().remove(0);
    assert_eq!((broken.ids, broken.mode), ([0, 1], BreakMode::Tension));
    assert!((broken.time / (steps as f64 * dt) - 1.0).abs() <= 1.01 / steps as f64);
    let stretch = strength / YOUNG * LENGTH;
    close_to(broken.energy, 0.5 * 157_079.632_7 * stretch * stretch, 0.02);
    close_to(broken.position.x, 0.5 * (LENGTH + stretch), 1e-4);
}

/// A lattice flies apart: all of its bonds break in one step, and the run goes on.
#[test]
fn thousands_break_in_one_step() {
    let n = 12;
    let places: Vec<DVec3> = (0..n * n * n)
        .map(|k| dvec3((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64) * LENGTH)
        .collect();
    for contact in [true, false] {
        let plan = BondPlan {
            strengths: [1e3, 1e3],
            contact,
            ..glue()
        };
        let mut inputs = inputs(1e-6, &places, plan);
        for (particle, place) in inputs.particles.iter_mut().zip(&places) {
            particle.velocity = *place * 100.0;
        }
        let mut engine = start(inputs);
        let made = 3 * (n * n * (n - 1)) as u64;
        assert_eq!(bonds(&engine).all().len() as u64, made);
        // 2e-7 m in a step: 1e4 Pa.
        engine.step(None).unwrap();
        let counts = bonds(&engine).counts()[0];
        assert_eq!((counts.made, counts.broken, counts.left()), (made, made, 0));
        engine.steps_at_once(10, None).unwrap();
        let fastest = engine.fastest();
        close_to(fastest, (places[n * n * n - 1] * 100.0).length(), 1e-9);
    }
}

/// After a break the contact goes on without a jump of force, until the two have parted; then the whole overlap counts.
#[test]
fn a_break_makes_no_jump_of_force() {
    let overlap = 0.02 * RADIUS;
    let plan = BondPlan {
        law: LawOfBonds::Parallel {
            normal_stiffness: 1.0,
            shear_stiffness: 1e9,
        },
        // Broken by twist.
        strengths: [f64::INFINITY, 1e-3],
        contact: true,
        ..glue()
    };
    let mut inputs = inputs(1e-9, &[DVec3::ZERO, DVec3::X * (LENGTH - overlap)], plan);
    inputs.particles[0].fixed = true;
    inputs.particles[1].angular_velocity = DVec3::X;
    let mut engine = start(inputs);
    engine.step(None).unwrap();
    assert_eq!(bonds(&engine).all().len(), 0);
    let force = |engine: &mut Engine, overlap: f64| {
        let far = row(engine, 1);
        engine.particles.records[far].position = DVec3::X * (LENGTH - overlap);
        engine.lists_are_stale();
        engine.step(None).unwrap();
        -engine.particles.loads[row(engine, 0)].force.x
    };
    assert_eq!(force(&mut engine, overlap), 0.0);
    close_to(
        force(&mut engine, 1.5 * overlap),
        0.5 * CONTACT * overlap,
        1e-3,
    );
    assert_eq!(force(&mut engine, 0.1 * overlap), 0.0);
    // They part, and meet again.
    assert_eq!(force(&mut engine, -0.1 * overlap), 0.0);
    close_to(
        force(&mut engine, 0.5 * overlap),
        0.5 * CONTACT * overlap,
        1e-3,
    );
}

/// Strengths spread by the seed and the pair, about their mean.
#[test]
fn strengths_spread_about_their_mean() {
    let plan = BondPlan {
        strengths: [1e5, 3e5],
        strength_spread: 0.25,
        ..glue()
    };
    let places: Vec<DVec3> = (0..4000)
        .map(|k| dvec3((k % 40) as f64, (k / 40) as f64, 0.0) * LENGTH - dvec3(0.04, 0.09, 0.0))
        .collect();
    let mut inputs = inputs(1e-6, &places, plan);
    inputs.cell = Cell::new(DVec3::splat(-0.2), DVec3::splat(0.2), [false; 3]);
    let engine = start(inputs);
    let all = bonds(&engine).all();
    let count = all.len() as f64;
    for (k, mean) in [(0, 1e5), (1, 3e5)] {
        let values = all.iter().map(|bond| bond.strengths[k]);
        let found = values.clone().sum::<f64>() / count;
        let variance = values.map(|value| (value - found).powi(2)).sum::<f64>() / count;
        // Four standard errors: of the mean 4 * 0.25/sqrt(7860), of the deviation some 4/sqrt(2 * 7860) and the tail.
        close_to(found, mean, 0.0115);
        close_to(variance.sqrt(), 0.25 * mean, 0.05);
    }
}
