//! Rigid bodies of several pebbles, with every law and in all surroundings.
//!
//! A body that is hit off its centre turns, and the next hit comes elsewhere: differences grow faster than between spheres, by some
//! ten to thirty at each meeting.

use glam::{DQuat, DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::random::Stream;
use mercury_engine::bodies::Clump;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_solver::plan::{Draft, NewBody, NewParticle};
use mercury_tests::reference::Simulation;
use mercury_tests::scenes::start;
use mercury_tests::twins::reference_of;

use super::laws::laws;
use super::surroundings::{Surroundings, surroundings};
use super::{DENSITY, SIZE, STEP, compare_paths, uniform};

const POSITIONS: f64 = 1e-8;

/// A snake of three and a knot of five overlapping pebbles. Masses and moments are those of bodies, though not of these.
fn clumps() -> Vec<Clump> {
    let pebble = |x: f64, y: f64, z: f64, radius: f64| Pebble {
        position: dvec3(x, y, z),
        radius,
    };
    let snake = vec![
        pebble(-0.025, 0.004, 0.0, 0.012),
        pebble(0.0, -0.003, 0.002, 0.016),
        pebble(0.022, 0.004, -0.002, 0.014),
    ];
    let knot = vec![
        pebble(0.01, 0.0, 0.0, 0.015),
        pebble(-0.01, 0.002, 0.0, 0.013),
        pebble(0.0, 0.012, 0.004, 0.012),
        pebble(0.002, -0.012, 0.0, 0.011),
        pebble(0.0, 0.0, 0.014, 0.01),
    ];
    let snake = Clump::new(
        "snake",
        MaterialIndex::new(0),
        snake,
        0.06,
        3e-5,
        dvec3(6e-6, 1.9e-5, 2.1e-5),
    );
    let knot = Clump::new(
        "knot",
        MaterialIndex::new(0),
        knot,
        0.05,
        2.5e-5,
        dvec3(7e-6, 8e-6, 1e-5),
    );
    vec![snake.unwrap(), knot.unwrap()]
}

/// A random scene: free bodies at different scales, one fixed, two held in part, and some spheres. The first two overlap.
fn scene(law: AnyPairLaw, around: &Surroundings, seed: u64) -> (Engine, Simulation) {
    let mut random = Stream::new(seed, "bodies against reference", 0);
    let far = |periodic: bool| if periodic { 0.0 } else { 1.0 };
    let margin = DVec3::from_array(around.periodic.map(far));
    let domain = (-margin, DVec3::splat(SIZE) + margin);
    let mut plan = Draft::new(STEP, domain, DENSITY, law);
    plan.laws = uniform(law);
    plan.cell = plan.cell.with_periodic(around.periodic);
    plan.gravity = around.gravity;
    plan.contact_point_mass = seed.is_multiple_of(2);
    let periodic_box = reference_of(&mut plan, &around.walls).periodic_box;
    let clumps = clumps();
    let (mut bodies, mut particles) = (Vec::<NewBody>::new(), Vec::<NewParticle>::new());
    let mut spheres: Vec<(DVec3, f64)> = Vec::new();
    let mut tries = 0;
    while bodies.len() < 9 && tries < 20_000 {
        tries += 1;
        let turn = random.unit_quaternion();
        let mut vector = |size: f64| {
            (dvec3(random.uniform(), random.uniform(), random.uniform()) * 2.0 - 1.0) * size
        };
        let count = bodies.len();
        let mut body = NewBody {
            scale: 0.8 + 0.4 * vector(1.0).x.abs(),
            orientation: turn,
            ..NewBody::at(
                DVec3::splat(0.5 * SIZE) + vector(0.4 * SIZE),
                count as u32 % 2,
            )
        };
        let clump = &clumps[body.clump as usize];
        let nearest = |body: &NewBody, spheres: &[(DVec3, f64)]| {
            let gap = |(centre, radius): (DVec3, f64)| {
                let gap = |&(other, size): &(DVec3, f64)| {
                    periodic_box.minimum_image(other - centre).length() / (radius + size)
                };
                spheres.iter().map(gap).fold(f64::INFINITY, f64::min)
            };
            body.spheres(clump).map(gap).fold(f64::INFINITY, f64::min)
        };
        if count == 1 {
            // Towards the first one until they overlap by 4 % of the pebbles.
            let first = bodies[0].position;
            let towards = vector(1.0).normalize();
            let mut bounds = (0.0, 0.12);
            for _ in 0..60 {
                let middle = 0.5 * (bounds.0 + bounds.1);
                body.position = first + towards * middle;
                if nearest(&body, &spheres) < 0.96 {
                    bounds.0 = middle;
                } else {
                    bounds.1 = middle;
                }
            }
        }
        let off_walls = body.spheres(clump).all(|(centre, radius)| {
            around.walls.iter().all(|wall| {
                let touched = wall.plain.contacts(centre, radius, 0.0);
                touched.iter().all(|touch| touch.distance > 0.98 * radius)
            })
        });
        if !off_walls || nearest(&body, &spheres) < 0.955 {
            continue;
        }
        body.velocity = (DVec3::splat(0.5 * SIZE) - body.position) * 6.0 + vector(0.6);
        body.angular_velocity = vector(20.0);
        match count {
            3 => {
                body.fixed = true;
                (body.velocity, body.angular_velocity) = (DVec3::ZERO, DVec3::ZERO);
            }
            4 => body.prescribed_velocity[0] = Some(body.velocity.x),
            5 => body.prescribed_angular_velocity[2] = Some(body.angular_velocity.z),
            _ => {}
        }
        spheres.extend(body.spheres(clump));
        bodies.push(body);
    }
    assert_eq!(bodies.len(), 9, "{}: no space", around.name);
    while particles.len() < 4 && tries < 40_000 {
        tries += 1;
        let mut vector = |size: f64| {
            (dvec3(random.uniform(), random.uniform(), random.uniform()) * 2.0 - 1.0) * size
        };
        let position = DVec3::splat(0.5 * SIZE) + vector(0.45 * SIZE);
        let radius = 0.012 + 0.004 * vector(1.0).x.abs();
        let clear = |&(other, size): &(DVec3, f64)| {
            periodic_box.minimum_image(other - position).length() > 0.98 * (radius + size)
        };
        let off_walls = around.walls.iter().all(|wall| {
            let touched = wall.plain.contacts(position, radius, 0.0);
            touched.iter().all(|touch| touch.distance > 0.98 * radius)
        });
        if off_walls && spheres.iter().all(clear) {
            spheres.push((position, radius));
            particles.push(NewParticle {
                velocity: vector(0.6),
                angular_velocity: vector(20.0),
                ..NewParticle::at(position, radius, MaterialIndex::new(0))
            });
        }
    }
    let mut plan = plan.with_particles(particles).with_bodies(clumps, bodies);
    let check = reference_of(&mut plan, &around.walls);
    (start(plan), check)
}

#[test]
fn bodies_of_every_law_somewhere() {
    let around: Vec<_> = surroundings()
        .into_iter()
        .filter(|around| around.dimensions == 3)
        .collect();
    let mut most = 0;
    for (k, law) in laws().into_iter().enumerate() {
        // Every law is met by its first forces, every third by a trajectory.
        let steps = if k % 3 == 0 { 400 } else { 1 };
        let around = &around[(k + k / around.len()) % around.len()];
        let (engine, reference) = scene(law, around, k as u64);
        let name = format!("bodies, {} under {law:?}", around.name);
        let contacts = compare_paths(&name, engine, reference, steps, POSITIONS);
        assert!(contacts > 0, "{name}: nothing touches");
        most = most.max(contacts);
    }
    assert!(most >= 4, "{most} contacts at most");
}

/// A body whose pebbles are all at its centre and whose moments are a sphere's is a sphere.
#[test]
fn a_body_of_one_pebble_is_a_sphere() {
    let law = laws().into_iter().last().unwrap();
    let radius = 0.02;
    let mass = DENSITY * 4.0 / 3.0 * std::f64::consts::PI * f64::powi(radius, 3);
    let pebble = Pebble {
        position: DVec3::ZERO,
        radius,
    };
    let moments = DVec3::splat(0.4 * mass * radius * radius);
    let volume = mass / DENSITY;
    let clump = Clump::new(
        "ball",
        MaterialIndex::new(0),
        vec![pebble],
        mass,
        volume,
        moments,
    )
    .unwrap();
    let plan = || Draft::new(STEP, (DVec3::splat(-1.0), DVec3::splat(1.0)), DENSITY, law);
    let (x, v, w) = (
        [dvec3(0.0, 0.0, 0.0), dvec3(0.037, 0.013, 0.002)],
        [dvec3(1.0, 0.2, 0.0), dvec3(-1.0, 0.0, 0.1)],
        [dvec3(5.0, 9.0, -30.0), dvec3(0.0, 20.0, 3.0)],
    );
    let spheres = [0, 1].map(|k| NewParticle {
        velocity: v[k],
        angular_velocity: w[k],
        ..NewParticle::at(x[k], radius, MaterialIndex::new(0))
    });
    let bodies = [0, 1].map(|k| NewBody {
        velocity: v[k],
        angular_velocity: w[k],
        orientation: DQuat::from_rotation_x(0.3),
        ..NewBody::at(x[k], 0)
    });
    let mut spheres = start(plan().with_particles(spheres.to_vec()));
    let mut bodies = start(plan().with_bodies(vec![clump], bodies.to_vec()));
    for engine in [&mut spheres, &mut bodies] {
        mercury_tests::scenes::advance(engine, 300);
    }
    for id in 0..2 {
        let sphere = mercury_tests::scenes::particle(&spheres, id);
        let body = bodies.particles.bodies()[id as usize];
        assert_ne!(sphere.angular_velocity, w[id as usize], "they have met");
        let apart = (sphere.position - body.position).length() / radius;
        let slower = (sphere.angular_velocity - body.angular_velocity).length();
        assert!(apart < 1e-12 && slower < 1e-9, "{apart:e} {slower:e}");
    }
}
