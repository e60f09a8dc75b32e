//! Deletion regions, exits through faces, and what stays.

use glam::DVec3;
use mercury_common::random::Stream;

use super::super::{DeletionPlan, InsertionPlan, Quantity, Rate, Region, Total};
use super::{insertion, monodisperse, plan};
use crate::contact::{AnyTangential, CoulombLimits, LinearFriction, SpringRotation};
use crate::physics::Inputs;
use crate::state::Id;
use crate::state::MaterialIndex;
use crate::state::NewParticle;
use crate::step::Engine;

fn outlet(name: &str, region: Region) -> DeletionPlan {
    DeletionPlan {
        name: name.to_owned(),
        region,
    }
}

/// A gas of small spheres that hardly meet, in random motion.
fn gas(number: u64, plan: Inputs) -> Inputs {
    let mut stream = Stream::new(3, "gas", 0);
    let mut point = |low, high| {
        DVec3::new(
            stream.uniform_in(low, high),
            stream.uniform_in(low, high),
            stream.uniform_in(low, high),
        )
    };
    let particles = (0..number)
        .map(|_| NewParticle {
            velocity: point(-2.0, 2.0),
            ..NewParticle::at(point(0.01, 0.99), 0.004, MaterialIndex::new(0))
        })
        .collect();
    plan.with_particles(particles)
}

/// Runs and compares in every step with a test of all particles; returns the engine.
fn check_every_step(plan: Inputs, steps: u32) -> Engine {
    let plan = plan.setup().unwrap();
    let mut engine = Engine::new(plan.clone(), 1).unwrap();
    for step in 0..steps {
        engine.step(None).unwrap();
        let cell = *engine.cell();
        for record in &engine.particles.records {
            let position = record.position;
            let inside = cell.wrap(position);
            for deletion in &plan.physics.deletions {
                assert!(
                    !deletion.region.contains(inside),
                    "step {step}: {position} is in {}",
                    deletion.name
                );
            }
            for axis in (0..3).filter(|&axis| !plan.physics.cell.is_periodic(axis)) {
                assert!((0.0..=1.0).contains(&position[axis]), "step {step}");
            }
        }
        let (came, left) = (
            engine.boundaries().inserted().number,
            engine.boundaries().removed().number,
        );
        let start = plan.physics.particles.len() as u64;
        assert_eq!(engine.particles.len() as u64, start + came - left);
    }
    engine
}

#[test]
fn all_particles_leave_in_the_step_in_which_the_centre_does() {
    let ball = Region::Sphere {
        origin: DVec3::new(0.0, 0.5, 0.5),
        radius: 0.2,
    };
    let slab = Region::Box {
        min: DVec3::new(0.4, 0.4, -1.0),
        max: DVec3::new(0.5, 0.6, 2.0),
    };
    for periodic in [[false; 3], [true, false, true], [true; 3]] {
        let mut scene = plan();
        scene.cell = scene.cell.with_periodic(periodic);
        scene.deletions = vec![outlet("ball", ball.clone()), outlet("slab", slab.clone())];
        let engine = check_every_step(gas(1500, scene), 300);
        let boundaries = engine.boundaries();
        for tally in boundaries.deletions() {
            assert!(tally.number > 20, "{periodic:?}: {tally:?}");
        }
        for (face, tally) in boundaries.faces().iter().enumerate() {
            assert_eq!(tally.number > 0, !periodic[face / 2], "face {face}");
        }
    }
}

#[test]
fn exits_are_counted_by_face_with_what_left() {
    let mut scene = plan();
    scene.cell = scene.cell.with_periodic([false, true, false]);
    let radius = 0.01;
    let mass = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * f64::powi(radius, 3);
    // One to each face, the two along the periodic axis stay; one stands fixed outside.
    let mut particles: Vec<NewParticle> = [DVec3::X, DVec3::Y, DVec3::Z]
        .iter()
        .flat_map(|&axis| [-axis, axis])
        .enumerate()
        .map(|(face, direction)| NewParticle {
            velocity: direction * (1.0 + face as f64),
            angular_velocity: DVec3::Y * 3.0,
            ..NewParticle::at(
                DVec3::splat(0.5) + 0.1 * direction,
                radius,
                MaterialIndex::new(0),
            )
        })
        .collect();
    particles.push(NewParticle {
        fixed: true,
        ..NewParticle::at(DVec3::new(2.0, 0.5, 0.5), radius, MaterialIndex::new(0))
    });
    let engine = check_free(scene.with_particles(particles), 500);
    let faces = engine.boundaries().faces();
    for face in [0, 1, 4, 5] {
        let speed = 1.0 + f64::from(face);
        let tally = faces[face as usize];
        assert_eq!(tally.number, 1);
        assert!((tally.mass - mass).abs() < 1e-15);
        assert!((tally.kinetic - 0.5 * mass * speed * speed).abs() < 1e-12);
        assert!((tally.rotational - 0.2 * mass * radius * radius * 9.0).abs() < 1e-15);
        assert!((tally.momentum.length() - mass * speed).abs() < 1e-12);
        // The centre was beyond the face by less than a step's way.
        let place = (tally.mass_moment / tally.mass)[face as usize / 2];
        let beyond = if face % 2 == 0 { -place } else { place - 1.0 };
        assert!((0.0..=speed * 1e-3).contains(&beyond), "{beyond}");
    }
    assert_eq!((faces[2].number, faces[3].number), (0, 0));
    assert_eq!(engine.particles.len(), 3);
}

fn check_free(plan: Inputs, steps: u32) -> Engine {
    let mut engine = Engine::new(plan.setup().unwrap(), 1).unwrap();
    for _ in 0..steps {
        engine.step(None).unwrap();
    }
    engine
}

#[test]
fn fixed_particles_are_geometry() {
    let mut scene = plan();
    scene.deletions = vec![outlet("all", super::unit_box())];
    let fixed = NewParticle {
        fixed: true,
        ..NewParticle::at(DVec3::splat(0.5), 0.01, MaterialIndex::new(0))
    };
    let free = NewParticle::at(DVec3::splat(0.7), 0.01, MaterialIndex::new(0));
    let engine = check_free(scene.with_particles(vec![fixed, free]), 1);
    assert_eq!(engine.particles.ids, [Id::new(0)]);
    assert_eq!(engine.boundaries().deletions()[0].number, 1);
}

#[test]
fn ids_are_never_used_twice_while_particles_come_and_go() {
    let mut scene = plan();
    scene.gravity = DVec3::new(0.0, 0.0, -9.81);
    scene.insertions = vec![InsertionPlan {
        rate: Some(Rate::Steady {
            quantity: Quantity::Number,
            per_second: 500.0,
        }),
        total: None,
        ..insertion(
            Region::Box {
                min: DVec3::new(0.3, 0.3, 0.8),
                max: DVec3::new(0.7, 0.7, 1.0),
            },
            monodisperse(0.02),
            Total::Full,
        )
    }];
    scene.deletions = vec![outlet(
        "low",
        Region::HalfSpace {
            point: DVec3::Z * 0.3,
            normal: -DVec3::Z,
        },
    )];
    let engine = check_every_step(scene, 1000);
    let (came, left) = (
        engine.boundaries().inserted(),
        engine.boundaries().removed(),
    );
    assert_eq!(came.number, 500);
    assert!(left.number > 200);
    assert_eq!(u64::from(engine.particles.next_id), came.number);
    let mut ids = engine.particles.ids.clone();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len() as u64, came.number - left.number);
    // They left lower and faster than they came.
    let fallen = came.mass_moment.z / came.mass * left.mass - left.mass_moment.z;
    assert!(fallen > 0.0 && left.kinetic > 0.0);
}

#[test]
fn contacts_keep_their_history_when_others_go_and_come() {
    let run = |others: bool| {
        let mut scene = plan();
        scene.time_step = 1e-4;
        if let Some(law) = &mut scene.laws.laws[0] {
            law.tangential = AnyTangential::Linear(LinearFriction {
                stiffness: 300.0,
                dissipation: 0.0,
                friction: 0.8,
                static_friction: 0.8,
                rotation: SpringRotation::default(),
                limits: CoulombLimits::Bounded,
            });
        }
        // Two spheres pressed together that shear one another.
        let mut particles = vec![
            NewParticle {
                velocity: DVec3::new(0.2, 0.05, 0.0),
                ..NewParticle::at(DVec3::new(0.451, 0.5, 0.5), 0.05, MaterialIndex::new(0))
            },
            NewParticle {
                velocity: DVec3::new(-0.2, -0.05, 0.0),
                ..NewParticle::at(DVec3::new(0.549, 0.5, 0.5), 0.05, MaterialIndex::new(0))
            },
        ];
        if others {
            // Far apart from the pair, on both sides of it in the sorted order; they leave in different steps.
            for (k, x) in [0.1, 0.9, 0.15, 0.85].into_iter().enumerate() {
                particles.push(NewParticle {
                    velocity: DVec3::new(0.0, 0.0, -2.5 - k as f64),
                    ..NewParticle::at(DVec3::new(x, 0.1, 0.06), 0.05, MaterialIndex::new(0))
                });
            }
            particles.swap(0, 3);
            scene.insertions = vec![InsertionPlan {
                from: 0.012,
                ..insertion(
                    Region::Box {
                        min: DVec3::new(0.0, 0.8, 0.0),
                        max: DVec3::ONE,
                    },
                    monodisperse(0.1),
                    Total::Number(3),
                )
            }];
        }
        let engine = check_free(scene.with_particles(particles), 300);
        let pair: Vec<_> = engine
            .particles
            .records
            .iter()
            .filter(|record| (record.position.z - 0.5).abs() < 1e-12 && record.position.y < 0.7)
            .copied()
            .collect();
        (engine, pair)
    };
    let (_, alone) = run(false);
    let (engine, among_others) = run(true);
    assert_eq!(engine.boundaries().removed().number, 4);
    assert_eq!(engine.boundaries().inserted().number, 3);
    assert_eq!((alone.len(), among_others.len()), (2, 2));
    for one in &alone {
        let other = among_others
            .iter()
            .min_by(|a, b| {
                let distance = |p: DVec3| p.distance(one.position);
                distance(a.position).total_cmp(&distance(b.position))
            })
            .unwrap();
        // Only the order of summation differs; a lost spring would show in the eighth digit after one step.
        assert!((other.position - one.position).length() < 1e-14);
        assert!((other.angular_velocity - one.angular_velocity).length() < 1e-10);
        assert!(one.angular_velocity.length() > 0.1, "there was friction");
    }
}
