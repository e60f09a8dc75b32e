//! The engine against the plain reference path, on random small scenes of every combination of laws, walls and periodic axes.
//!
//! Both evaluate the same formulas in another order. The largest overlap, of some 3 mm, sets the scale of the
//! forces; all overlaps are known to the round-off of positions up to 0.27 m, 1e-16 m: so forces agree to some 1e-14 of the largest. In 1,000 steps a sphere travels two radii and meets two or three
//! others; a collision turns a difference of the directions into one that is about 2 · path/radius, up to ten times, larger.
//! Hence 1e-15 radii grow to 1e-12 in the mean and, in the unluckiest of thousands of pairs, six meetings, to 1e-9.

mod bonds;
mod clumps;
mod dry_cohesion;
mod laws;
mod surroundings;

use glam::{DVec3, dvec3};
use mercury_common::random::Stream;
use mercury_engine::contact::adhesion::liquid::Tables;
use mercury_engine::contact::registry::{AnyPairLaw, LawTable};
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_engine::walls::{Touch, Touches};
use mercury_solver::plan::{Draft, NewParticle, PrescribedMotion};
use mercury_tests::reference::Simulation;
use mercury_tests::reference::laws::Conventions;
use mercury_tests::scenes::{advance, assert_every_law, start};
use mercury_tests::twins::{force_difference, position_difference, reference_law, reference_of};

use laws::laws;
use surroundings::{Surroundings, surroundings};

/// Edge of the cube in which particles start: the domain along periodic axes, m.
const SIZE: f64 = 0.27;
const DENSITY: f64 = 2000.0;
const STEP: f64 = 5e-5;
const FORCES: f64 = 1e-13;
const POSITIONS: f64 = 1e-9;

/// A random scene: free spheres of two sizes and more, one fixed, one held in part. The first pair of spheres overlaps, so that
/// the first step has a force to compare with.
fn scene(laws: LawTable, surroundings: &Surroundings, seed: u64) -> (Engine, Simulation) {
    let mut random = Stream::new(seed, "engine against reference", 0);
    let flat = surroundings.dimensions == 2;
    // Nothing leaves through the faces that are not periodic.
    let far = |periodic: bool| if periodic { 0.0 } else { 1.0 };
    let margin = DVec3::from_array(surroundings.periodic.map(far));
    let domain = (-margin, DVec3::splat(SIZE) + margin);
    let mut plan = Draft::new(STEP, domain, DENSITY, laws.laws[0].unwrap());
    while plan.materials.len() < laws.materials {
        let mut other = plan.materials[0].clone();
        other.density *= 1.5;
        plan.materials.push(other);
    }
    plan.laws = laws;
    plan.cell = plan.cell.with_periodic(surroundings.periodic);
    plan.gravity = surroundings.gravity;
    plan.dimensions = surroundings.dimensions;
    let mut check = reference_of(&mut plan, &surroundings.walls);
    let mut vector = |size: f64| {
        let vector = dvec3(random.uniform(), random.uniform(), random.uniform()) * 2.0 - 1.0;
        if flat {
            dvec3(vector.x, vector.y, 0.0) * size
        } else {
            vector * size
        }
    };
    let wanted = if flat { 12 } else { 28 };
    let mut particles: Vec<NewParticle> = Vec::new();
    let mut tries = 0;
    while particles.len() < wanted && tries < 20_000 {
        tries += 1;
        let count = particles.len();
        let mut position = DVec3::splat(0.5 * SIZE) + vector(0.5 * SIZE);
        let radius = 0.02 + 0.015 * vector(1.0).x.abs();
        if flat {
            position.z = 0.0;
        }
        if count == 1 {
            let towards = vector(1.0).normalize();
            position = particles[0].position + towards * 0.94 * (particles[0].radius + radius);
        }
        let gap = |other: &NewParticle| {
            let branch = check.periodic_box.minimum_image(other.position - position);
            branch.length() / (other.radius + radius)
        };
        let clear = particles
            .iter()
            .all(|other| gap(other) > if count == 1 { 0.93 } else { 0.975 })
            && surroundings.walls.iter().all(|wall| {
                let touched = wall.plain.contacts(position, radius, 0.0);
                touched.iter().all(|touch| touch.distance > 0.98 * radius)
            });
        if !clear {
            continue;
        }
        // Towards the middle, so that they meet.
        let inward = (DVec3::splat(0.5 * SIZE) - position) * 6.0;
        let inward = if flat {
            dvec3(inward.x, inward.y, 0.0)
        } else {
            inward
        };
        let spin = vector(20.0);
        particles.push(NewParticle {
            velocity: inward + vector(0.6),
            angular_velocity: if flat { spin.x * DVec3::Z } else { spin },
            material: MaterialIndex::new((count % plan.materials.len()) as u32),
            ..NewParticle::at(position, radius, MaterialIndex::new(0))
        });
    }
    assert_eq!(particles.len(), wanted, "{}: no space", surroundings.name);
    for (id, particle) in particles.iter_mut().enumerate() {
        if id == 5 {
            particle.fixed = true;
            particle.velocity = DVec3::ZERO;
            particle.angular_velocity = DVec3::ZERO;
        }
        if id == 6 {
            particle.prescribed = PrescribedMotion::boxed(
                [Some(particle.velocity.x), None, None],
                [None, None, Some(particle.angular_velocity.z)],
            );
        }
    }
    let mut plan = plan.with_particles(particles);
    check = reference_of(&mut plan, &surroundings.walls);
    (start(plan), check)
}

fn uniform(law: AnyPairLaw) -> LawTable {
    LawTable {
        materials: 1,
        laws: vec![Some(law)],
        tables: Tables::default(),
    }
}

/// Runs both and compares; returns how many contacts were seen.
fn compare(laws: LawTable, surroundings: &Surroundings, seed: u64, steps: u64) -> usize {
    let name = format!("{} under {:?}", surroundings.name, laws.laws[0].unwrap());
    let (engine, reference) = scene(laws, surroundings, seed);
    compare_paths(&name, engine, reference, steps, POSITIONS)
}

/// Runs both paths and compares; returns how many contacts were seen.
fn compare_paths(
    name: &str,
    mut engine: Engine,
    mut reference: Simulation,
    steps: u64,
    positions: f64,
) -> usize {
    reference.start();
    let start = force_difference(&engine, &reference);
    advance(&mut engine, 1);
    reference.advance();
    let first = force_difference(&engine, &reference);
    assert!(
        start <= FORCES && first <= FORCES,
        "{name}: forces differ by {start:e}, {first:e}"
    );
    let mut contacts = reference.contacts.len();
    for _ in 0..(steps - 1) / 37 {
        advance(&mut engine, 37);
        reference.advance_by(37);
        contacts = contacts.max(reference.contacts.len());
        let apart = position_difference(&engine, &reference);
        assert!(
            apart <= positions,
            "{name}: positions differ by {apart:e} radii after {} steps",
            reference.step
        );
    }
    contacts
}

#[test]
fn every_law_is_compared() {
    assert_every_law(laws().into_iter());
}

#[test]
fn first_forces_of_every_combination() {
    for (k, law) in laws().into_iter().enumerate() {
        for (seed, surroundings) in surroundings().iter().enumerate() {
            let contacts = compare(uniform(law), surroundings, (100 * k + seed) as u64, 1);
            assert!(contacts > 0, "{}: nothing touches", surroundings.name);
        }
    }
}

/// Every law in two surroundings, every surroundings with a quarter of the laws.
fn trajectories(part: usize, parts: usize) {
    let surroundings = surroundings();
    let mut most = 0;
    for (k, law) in laws().into_iter().enumerate() {
        if k % parts != part {
            continue;
        }
        for turn in 0..2 {
            let around =
                &surroundings[(k + 7 * turn + k / surroundings.len()) % surroundings.len()];
            most = most.max(compare(
                uniform(law),
                around,
                (k + 1000 * turn) as u64,
                1000,
            ));
        }
    }
    assert!(most > 10, "{most} contacts at most");
}

#[test]
fn trajectories_of_even_laws() {
    trajectories(0, 2);
}

#[test]
fn trajectories_of_odd_laws() {
    trajectories(1, 2);
}

/// Pairs of materials that differ in law use the dispatching contact loop.
#[test]
fn trajectories_of_mixed_laws() {
    let choices: Vec<AnyPairLaw> = laws()
        .into_iter()
        // The conventions of the reference path hold for all its contacts.
        .filter(|law| reference_law(law).1 == Conventions::default())
        .collect();
    for (k, around) in surroundings().iter().enumerate() {
        let pick = |offset: usize| Some(choices[(7 * k + 11 * offset) % choices.len()]);
        let mut table = vec![None; 9];
        for a in 0..3 {
            for b in a..3 {
                table[3 * a + b] = pick(3 * a + b);
                table[3 * b + a] = table[3 * a + b];
            }
        }
        let laws = LawTable {
            materials: 3,
            laws: table,
            tables: Tables::default(),
        };
        compare(laws, around, k as u64, 1000);
    }
}

/// How the normals of all walls turn when a centre moves: the derivatives of both, which the half step needs.
#[test]
fn normals_turn_alike() {
    let mut random = Stream::new(11, "turning normals", 0);
    let mut seen = 0;
    for surroundings in surroundings() {
        for wall in &surroundings.walls {
            for _ in 0..2000 {
                let mut vector =
                    |size: f64| size * dvec3(random.uniform(), random.uniform(), random.uniform());
                let (centre, way) = (vector(SIZE), vector(1.0));
                let radius = 0.03;
                let mut touches = Touches::new();
                wall.fast.shape.touches(centre, radius, &mut touches);
                for plain in wall.plain.shape.contacts(centre, radius) {
                    let same = |touch: &&Touch| (touch.normal - plain.normal).length() < 1e-12;
                    let Some(touch) = touches.iter().find(same) else {
                        continue;
                    };
                    let [one, other] = [touch.turning.of(touch.normal, way), plain.turning * way];
                    // Derivatives are 1/s beside an edge at distance s: 1e-12 of them for the round-off of places.
                    let scale = 1.0 / plain.distance.abs().min(centre.length());
                    assert!(
                        (one - other).length() < 1e-10 * scale,
                        "{}: {touch:?}, {plain:?}: {one} and {other}",
                        surroundings.name
                    );
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}
