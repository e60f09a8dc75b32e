//! Bonds to walls and between clumps.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use mercury_common::curve::Curve;

use super::{
    LENGTH, RADIUS, YOUNG, bonds, close_to, dumbbell, elastic, floor, glue, inputs, kinetic, mass,
    start,
};
use crate::bodies::NewBody;
use crate::bonds::BondPlan;
use crate::forces::Watch;
use crate::step::Engine;
use crate::walls::{Component, Servo, Target};

/// A wall carries what is glued to it, and gets the opposite load.
#[test]
fn walls_hold_what_is_glued_to_them() {
    let plan = BondPlan {
        walls: vec![0],
        contact: false,
        ..glue()
    };
    let speed = dvec3(0.01, 0.0, 0.02);
    let mut carried = inputs(1e-6, &[DVec3::Z * RADIUS], plan.clone());
    let motion = Component::Translation {
        velocity: speed,
        from: 0.0,
        until: f64::INFINITY,
    };
    carried.walls = vec![floor(DVec3::ZERO, DVec3::Z, vec![motion])];
    carried.particles[0].velocity = speed;
    let mut engine = start(carried);
    assert_eq!(
        (bonds(&engine).all().len(), engine.list_statistics().1),
        (1, 0)
    );
    engine.steps_at_once(1000, None).unwrap();
    assert!(bonds(&engine).all()[0].now.force.length() < 1e-9 * 314.0);
    // A ball on a beam of length R from a wall that turns about x with it: it goes round, pulled by m w^2 r.
    let mut held = inputs(1e-7, &[DVec3::Z * RADIUS], plan);
    held.walls = vec![floor(DVec3::ZERO, DVec3::Z, Vec::new())];
    held.gravity = dvec3(3.0, 0.0, 10.0);
    held.plans.all_mut::<BondPlan>()[0].damping = 0.3;
    let mut engine = start(held);
    engine.steps_at_once(20_000, None).unwrap();
    engine.step(Some(Watch::default())).unwrap();
    let observation = engine.observation();
    let (load, _) = observation.walls[0];
    let weight = dvec3(3.0, 0.0, 10.0) * mass();
    assert!(
        load.force.abs_diff_eq(weight, 1e-6 * weight.length()),
        "{}",
        load.force
    );
    let torque = (DVec3::Z * RADIUS).cross(weight);
    assert!(
        load.torque.abs_diff_eq(torque, 1e-3 * torque.length()),
        "{}",
        load.torque
    );
}

/// A moving wall works on what it is glued to.
#[test]
fn the_work_of_walls_closes_the_budget() {
    let plan = BondPlan {
        walls: vec![0],
        damping: 0.1,
        ..glue()
    };
    let mut inputs = inputs(2e-7, &[DVec3::Z * RADIUS], plan);
    let motion = Component::Translation {
        velocity: dvec3(0.01, 0.0, 0.02),
        from: 0.0,
        until: f64::INFINITY,
    };
    inputs.walls = vec![floor(DVec3::ZERO, DVec3::Z, vec![motion])];
    inputs.energy_budget = true;
    let mut engine = start(inputs);
    engine.steps_at_once(300, None).unwrap();
    engine.complete_step().unwrap();
    let audit = engine.audit();
    let taken = audit.losses.of("bonds");
    assert!(taken > 0.0 && audit.wall_work > 0.0);
    let has = kinetic(&engine) + engine.observation().elastic_energy;
    close_to(has + taken, audit.wall_work, 2e-3);
}

/// A servo pulls two glued balls, the farther of which is held, until its force is reached; all work of the wall is its work.
#[test]
fn servos_use_the_stiffness_of_bonds() {
    let plan = BondPlan {
        walls: vec![0],
        damping: 0.3,
        ..glue()
    };
    let places = [DVec3::Z * RADIUS, DVec3::Z * (3.0 * RADIUS)];
    let mut inputs = inputs(2e-7, &places, plan);
    inputs.particles[1].fixed = true;
    // A strain of 1 % in both.
    let pull = 0.01 * YOUNG * PI * RADIUS * RADIUS;
    let servo = Servo {
        axis: DVec3::Z,
        target: Target::Force(Curve::constant(-pull).unwrap()),
        max_speed: 1.0,
        from: 0.0,
        until: f64::INFINITY,
    };
    inputs.walls = vec![floor(DVec3::ZERO, DVec3::Z, vec![Component::Servo(servo)])];
    inputs.energy_budget = true;
    let mut engine = start(inputs);
    // The error falls at the rate of the stiffness E A/(3 R) over 4 sqrt(m k) + 2 gamma of the bond to the wall, k = E A/R, gamma = 0.6 sqrt(m k): in
    // 460 steps to the e-th part.
    engine.steps_at_once(5000, None).unwrap();
    engine.step(Some(Watch::default())).unwrap();
    let force = engine.observation().walls[0].0.force;
    close_to(force.z, pull, 1e-4);
    engine.complete_step().unwrap();
    let audit = engine.audit();
    assert_eq!(audit.servo_work, audit.wall_work);
    let has = kinetic(&engine) + engine.observation().elastic_energy;
    close_to(has + audit.losses.of("bonds"), audit.wall_work, 2e-3);
    // Springs in series.
    close_to(has, 0.5 * pull * 0.01 * 3.0 * RADIUS, 1e-3);
}

/// Clumps on both ends: free flight with vibration keeps momentum and energy, and pebbles of one body are not glued to each other.
#[test]
fn clumps_are_glued_by_their_pebbles() {
    let mut inputs = inputs(1e-7, &[], glue());
    inputs.clumps = vec![dumbbell()];
    let left = NewBody::at(DVec3::ZERO, 0);
    let right = NewBody {
        velocity: dvec3(0.0, 0.01, 0.0),
        angular_velocity: dvec3(3.0, 5.0, 0.0),
        ..NewBody::at(DVec3::X * (2.0 * LENGTH), 0)
    };
    inputs.bodies = vec![left, right];
    let mut engine = start(inputs);
    assert_eq!(bonds(&engine).all().len(), 1);
    let energy = |engine: &Engine| {
        let bodies = engine.particles.bodies();
        let moving = bodies.iter().map(|body| {
            0.5 * body.mass * body.velocity.length_squared() + body.rotational_energy()
        });
        moving.sum::<f64>() + elastic(engine)
    };
    let sums = |engine: &Engine| {
        let bodies = engine.particles.bodies().iter();
        let momentum: DVec3 = bodies.clone().map(|b| b.velocity * b.mass).sum();
        let angular: DVec3 = bodies
            .map(|b| b.position.cross(b.velocity) * b.mass + b.angular_momentum)
            .sum();
        (momentum, angular)
    };
    let (first, before) = (energy(&engine), sums(&engine));
    engine.steps_at_once(20_000, None).unwrap();
    engine.complete_step().unwrap();
    close_to(energy(&engine), first, 1e-3);
    let after = sums(&engine);
    assert!(after.0.abs_diff_eq(before.0, 1e-12 * before.0.length()));
    assert!(
        after.1.abs_diff_eq(before.1, 1e-7 * before.1.length()),
        "{after:?} {before:?}"
    );
}
