//! The engine finds the contacts that brute force finds, in every step, while particles move and lists are rebuilt.

use std::collections::BTreeSet;

use glam::{DVec3, dvec3};
use mercury_common::random::Stream;
use mercury_solver::contact::{AnyNormal, Linear};
use mercury_solver::forces::Partner;
use mercury_solver::plan::{Draft, NewParticle};
use mercury_solver::state::{Id, MaterialIndex};
use mercury_solver::step::Engine;
use mercury_tests::scenes::{RECORDS, frictionless, start};
use proptest::prelude::*;

/// Ids of all pairs that the last step's records name; fails if one is named twice.
fn recorded(engine: &Engine) -> BTreeSet<(Id, Id)> {
    let ids = &engine.particles.ids;
    let mut pairs = BTreeSet::new();
    for record in engine.observation().records {
        if let Partner::Particle { row, .. } = record.partner {
            let (a, b) = (ids[record.row as usize], ids[row as usize]);
            assert!(
                pairs.insert((a.min(b), a.max(b))),
                "{a} and {b} touch twice"
            );
        }
    }
    pairs
}

/// Ids of all pairs that overlap, through the nearest image, at the positions of the last force evaluation.
fn overlapping(engine: &Engine, size: DVec3, periodic: [bool; 3]) -> BTreeSet<(Id, Id)> {
    let (records, ids) = (&engine.particles.records, &engine.particles.ids);
    let mut pairs = BTreeSet::new();
    for i in 0..records.len() {
        for j in i + 1..records.len() {
            let mut branch = records[i].position - records[j].position;
            for axis in 0..3 {
                if periodic[axis] {
                    branch[axis] -= size[axis] * (branch[axis] / size[axis]).round();
                }
            }
            let fixed = engine.particles.is_fixed(i) && engine.particles.is_fixed(j);
            if branch.length() < records[i].radius + records[j].radius && !fixed {
                pairs.insert((ids[i].min(ids[j]), ids[i].max(ids[j])));
            }
        }
    }
    pairs
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    /// Springs so soft that particles fly through each other: contacts open and close all the time.
    #[test]
    fn is_that_of_brute_force_while_everything_moves(
        seed in any::<u64>(),
        count in 2usize..140,
        ratio in prop_oneof![Just(1.0), 1.0..10.0f64],
        periodic in any::<[bool; 3]>(),
        speed in prop_oneof![Just(0.05), Just(2.0)],
        gravity in prop_oneof![Just(0.0), Just(-9.81)],
        fixed_every in 3usize..9,
    ) {
        let size = dvec3(0.5, 0.6, 0.7);
        let mut random = Stream::new(seed, "moving contact set", 0);
        let mut vector = || dvec3(random.uniform(), random.uniform(), random.uniform());
        let law = frictionless(AnyNormal::Linear(Linear::new(1.0, 0.0)));
        let mut plan = Draft::new(1e-3, (DVec3::ZERO, size), 1000.0, law);
        plan.periodic = periodic;
        plan.gravity = gravity * DVec3::Z;
        let particles = (0..count)
            .map(|k| NewParticle {
                velocity: (vector() * 2.0 - 1.0) * speed,
                fixed: k % fixed_every == 0,
                prescribed_velocity: [None, None, (k % 7 == 3).then_some(0.0098)],
                ..NewParticle::at(vector() * size, 0.011 * ratio.powf(vector().x), MaterialIndex::new(0))
            })
            .collect();
        let mut engine = start(plan.with_particles(particles));
        let mut seen = BTreeSet::new();
        for _ in 0..300 {
            engine.step(RECORDS).unwrap();
            let found = recorded(&engine);
            let expected = overlapping(&engine, size, periodic);
            prop_assert_eq!(&found, &expected, "in step {}", engine.steps());
            seen.extend(expected);
        }
        if count > 100 && speed > 1.0 && periodic == [true; 3] {
            prop_assert!(engine.list_statistics().0 > 3, "the list was never rebuilt");
            prop_assert!(seen.len() > 10);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn is_that_of_brute_force_while_few_are_fast(
        seed in any::<u64>(),
        count in 400usize..500,
        ratio in prop_oneof![Just(1.0), 1.0..4.0f64],
        periodic in any::<[bool; 3]>(),
        speed in 1.0..5.0f64,
    ) {
        few_are_fast(seed, count, ratio, periodic, speed)?;
    }
}

/// In a given scene, as how often extra skin acts depends on the scene: later the skin of so thin a gas is as thick as it may be,
/// and leaves no room for more.
#[test]
fn few_that_are_fast_have_extra_skin() {
    let steps = few_are_fast(1, 450, 1.0, [true; 3], 4.0).unwrap();
    assert!(steps > 2, "extra skin in {steps} steps only");
}

/// Two among hundreds shoot through the others, which hardly move: they get extra skin, and lists last longer. Through faces
/// and walls of spheres that are fixed too. Compares each step with brute force; returns the steps in which a particle had extra
/// skin.
fn few_are_fast(
    seed: u64,
    count: usize,
    ratio: f64,
    periodic: [bool; 3],
    speed: f64,
) -> Result<usize, TestCaseError> {
    let size = dvec3(0.5, 0.6, 0.7);
    let mut random = Stream::new(seed, "few are fast", 0);
    let mut vector = || dvec3(random.uniform(), random.uniform(), random.uniform());
    let law = frictionless(AnyNormal::Linear(Linear::new(0.1, 0.0)));
    let mut plan = Draft::new(1e-3, (DVec3::ZERO, size), 1000.0, law);
    plan.periodic = periodic;
    let particles = (0..count)
        .map(|k| {
            let speed = if k == 16 || k == 215 { speed } else { 0.02 };
            NewParticle {
                velocity: (vector() * 2.0 - 1.0).normalize() * speed,
                fixed: k % 7 == 0,
                ..NewParticle::at(
                    vector() * size,
                    0.011 * ratio.powf(vector().x),
                    MaterialIndex::new(0),
                )
            }
        })
        .collect();
    let mut engine = start(plan.with_particles(particles));
    let mut with_extra_skin = 0;
    for _ in 0..150 {
        engine.step(RECORDS).unwrap();
        let found = recorded(&engine);
        let expected = overlapping(&engine, size, periodic);
        prop_assert_eq!(&found, &expected, "in step {}", engine.steps());
        let extra_skin = engine.snapshot().lists.extra_skin;
        with_extra_skin += usize::from(extra_skin.iter().any(|&extra_skin| extra_skin > 0.0));
    }
    Ok(with_extra_skin)
}

/// The list must be rebuilt for a particle that moves only because its velocity is prescribed, even where a kick of gravity
/// happens to cancel that velocity before it is put back.
#[test]
fn sees_a_particle_whose_prescribed_velocity_gravity_would_cancel() {
    let (time_step, gravity) = (1e-3, 9.81);
    let law = frictionless(AnyNormal::Linear(Linear::new(1e3, 0.0)));
    let mut plan = Draft::new(time_step, (-DVec3::ONE, DVec3::ONE), 1000.0, law);
    plan.gravity = -gravity * DVec3::Z;
    let mut pusher = NewParticle::at(DVec3::ZERO, 0.01, MaterialIndex::new(0));
    let velocity = gravity * time_step;
    pusher.velocity.z = velocity;
    pusher.prescribed_velocity = [Some(0.0), Some(0.0), Some(velocity)];
    let mut target = NewParticle::at(dvec3(0.0, 0.0, 0.03), 0.01, MaterialIndex::new(0));
    target.fixed = true;
    let mut engine = start(plan.with_particles(vec![pusher, target]));
    let needed = (0.011 / (velocity * time_step)) as u64;
    for _ in 0..needed {
        engine.step(RECORDS).unwrap();
    }
    assert_eq!(
        recorded(&engine),
        BTreeSet::from([(Id::new(0), Id::new(1))])
    );
}
