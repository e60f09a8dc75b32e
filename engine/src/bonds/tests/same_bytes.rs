//! Bytes of bonds with other threads and lanes, and after a stop.

use glam::{DVec3, dvec3};

use super::{LENGTH, RADIUS, bonds, chain, dumbbell, floor, glue, inputs};
use crate::bodies::NewBody;
use crate::bonds::{BondPlan, Gluing};
use crate::cell::Cell;
use crate::lanes::{MOST_LANES, Width};
use crate::step::{Engine, StartOptions};

/// The state goes on to the same bytes, with other threads and lanes.
#[test]
fn a_state_with_bonds_goes_on_to_the_same_bytes() {
    let n = 9;
    let places: Vec<DVec3> = (0..n * n * n)
        .map(|k| dvec3((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64) * (0.999 * LENGTH))
        .collect();
    let all = |contact: bool| {
        let breaking = BondPlan {
            strengths: [3e4, 3e4],
            strength_spread: 0.3,
            damping: 0.1,
            contact,
            ..glue()
        };
        let mut inputs = inputs(1e-6, &places, breaking);
        let later = BondPlan {
            name: "later".to_owned(),
            when: Gluing::Contact {
                from: 0.0,
                until: 1.0,
            },
            walls: vec![0],
            ..glue()
        };
        inputs.plans.insert(later);
        inputs.walls = vec![floor(DVec3::Z * (-1.2 * RADIUS), DVec3::Z, Vec::new())];
        inputs.gravity = DVec3::Z * -9.81;
        inputs.energy_budget = true;
        let half = inputs.particles.len() / 2;
        for (k, particle) in inputs.particles.iter_mut().enumerate() {
            // It is torn apart in the middle before it falls on the floor.
            let sideways = if k < half { 0.0 } else { 2.0 };
            particle.velocity = dvec3(sideways, 0.0, -1.0);
        }
        inputs.setup().unwrap()
    };
    for contact in [true, false] {
        let setup = all(contact);
        let run = |threads: usize, lanes: usize| {
            let options = StartOptions::threads(threads).width(Width::of(lanes));
            Engine::start(setup.clone(), options).unwrap()
        };
        let mut engine = run(1, 1);
        engine.steps_at_once(250, None).unwrap();
        let amid = engine.snapshot();
        let counts = bonds(&engine).counts();
        assert!(
            counts[0].broken > 10 && counts[0].left() > 10 && counts[1].made > 10,
            "{counts:?}"
        );
        engine.steps_at_once(150, None).unwrap();
        let end = engine.snapshot();
        let mut other = run(2, 4);
        other.steps_at_once(400, None).unwrap();
        assert!(other.snapshot() == end);
        let options = StartOptions::threads(2);
        let mut resumed = Engine::resume(setup.clone(), amid.clone(), options).unwrap();
        resumed.steps_at_once(150, None).unwrap();
        assert!(resumed.snapshot() == end);
        engine.restore_in_place(&amid).unwrap();
        engine.steps_at_once(150, None).unwrap();
        assert!(engine.snapshot() == end);
    }
}

/// Clumps and periodic faces, for a number of bonds that no number of lanes divides.
#[test]
fn lanes_change_nothing_for_clumps_and_periods() {
    let plan = BondPlan {
        damping: 0.1,
        ..glue()
    };
    let mut inputs = inputs(1e-6, &chain(6), plan);
    let period = 6.0 * LENGTH;
    inputs.cell = Cell::new(DVec3::ZERO, dvec3(period, 0.1, 0.1), [true, false, false]);
    for (k, particle) in inputs.particles.iter_mut().enumerate() {
        particle.position += dvec3(0.5 * RADIUS, 0.05, 0.05);
        particle.velocity = dvec3(1.0, 1e-3 * k as f64, 0.0);
    }
    inputs.clumps = vec![dumbbell()];
    let at = |x: f64| NewBody {
        velocity: DVec3::X,
        angular_velocity: DVec3::Z * (500.0 * x),
        ..NewBody::at(dvec3(x + RADIUS, 0.02, 0.02), 0)
    };
    inputs.bodies = vec![at(0.0), at(2.0 * LENGTH)];
    let setup = inputs.setup().unwrap();
    let mut first = None;
    for width in Width::all() {
        let options = StartOptions::threads(1).width(Some(width));
        let mut engine = Engine::start(setup.clone(), options).unwrap();
        assert_ne!(bonds(&engine).all().len() % MOST_LANES, 0);
        // More than a period.
        engine.steps_at_once(16_000, None).unwrap();
        let end = engine.snapshot();
        let force = bonds(&engine).all()[0].now.force.length();
        assert!(force > 0.0, "the chain is at rest");
        match &first {
            None => first = Some(end),
            Some(first) => assert!(&end == first, "{} lanes", width.lanes()),
        }
    }
}
