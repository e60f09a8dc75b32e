//! The engine against the plain reference path, on random small scenes of every combination of laws, walls and periodic axes.
//!
//! Both evaluate the same formulas in another order. The largest overlap, of some 3 mm, sets the scale of the
//! forces; all overlaps are known to the round-off of positions up to 0.27 m, 1e-16 m: so forces agree to some 1e-14 of the largest. In 1,000 steps a sphere travels two radii and meets two or three
//! others; a collision turns a difference of the directions into one that is about 2 · path/radius, up to ten times, larger.
//! Hence 1e-15 radii grow to 1e-12 in the mean and, in the unluckiest of thousands of pairs, six meetings, to 1e-9.

use glam::{DVec3, dvec3};
use mercury_common::random::Stream;
use mercury_solver::contact::normal::hertz_damping;
use mercury_solver::contact::registry::{AnyPairLaw, LawTable};
use mercury_solver::contact::rolling::FrictionSpring;
use mercury_solver::contact::{
    AnyNormal, AnyRolling, AnyTangential, Hertz, Linear, LinearFriction, Luding, Mindlin,
    MindlinRescaled, PairLaw, Plastic, SpringRotation,
};
use mercury_solver::engine::Engine;
use mercury_solver::plan::{NewParticle, Plan};
use mercury_solver::walls as fast;
use mercury_tests::reference::Simulation;
use mercury_tests::reference::walls as plain;
use mercury_tests::scenes::{advance, start, wall};
use mercury_tests::twins::{TwinWall, force_difference, position_difference, reference_of};

const SIZE: f64 = 0.27;
const DENSITY: f64 = 2000.0;
const STEP: f64 = 5e-5;
const FORCES: f64 = 1e-13;
const POSITIONS: f64 = 1e-9;

fn normals() -> Vec<AnyNormal> {
    let ratio = Linear::with_damping_ratio(1e5, 0.1);
    let mut clamped_ratio = ratio;
    clamped_ratio.clamp_tension = true;
    let hertz = Hertz::new(2e6, hertz_damping(0.7));
    let mut clamped_hertz = hertz;
    clamped_hertz.clamp_tension = true;
    let plastic = Plastic {
        loading_stiffness: 5e4,
        unloading_stiffness: 1.5e5,
        cohesion_stiffness: 2e4,
        penetration_depth: 0.05,
        dissipation: 5.0,
        clamp_tension: false,
    };
    vec![
        AnyNormal::Linear(Linear::new(1e5, 20.0)),
        AnyNormal::Linear(ratio),
        AnyNormal::Linear(clamped_ratio),
        AnyNormal::Hertz(hertz),
        AnyNormal::Hertz(clamped_hertz),
        AnyNormal::Plastic(plastic),
        AnyNormal::Plastic(Plastic {
            clamp_tension: true,
            ..plastic
        }),
    ]
}

fn tangentials() -> Vec<AnyTangential> {
    let linear = LinearFriction {
        stiffness: 3e4,
        dissipation: 2.0,
        friction: 0.4,
        static_friction: 0.5,
        rotation: SpringRotation::Project,
    };
    let mindlin = Mindlin::new(6e5, 2.0 / 3.0, 0.1, 0.4, 0.4);
    let mut total = Mindlin::new(6e5, 1.0, 0.1, 0.3, 0.4);
    total.cap_total = true;
    vec![
        AnyTangential::None,
        AnyTangential::Linear(linear),
        AnyTangential::Linear(LinearFriction {
            rotation: SpringRotation::Incremental,
            ..linear
        }),
        AnyTangential::Linear(LinearFriction {
            stiffness: 0.0,
            dissipation: 20.0,
            ..linear
        }),
        AnyTangential::Mindlin(mindlin),
        AnyTangential::Mindlin(total),
        AnyTangential::MindlinRescaled(MindlinRescaled { plain: mindlin }),
        AnyTangential::MindlinRescaled(MindlinRescaled { plain: total }),
    ]
}

fn rollings(rotation: SpringRotation) -> Vec<AnyRolling> {
    let spring = |stiffness, friction| FrictionSpring {
        stiffness,
        dissipation: 0.5,
        friction,
        static_friction: 1.2 * friction,
    };
    let luding = |stiffness, lever| {
        AnyRolling::Luding(Luding {
            rolling: spring(stiffness, 0.1),
            torsion: spring(stiffness, 0.05),
            lever,
            rotation,
        })
    };
    vec![AnyRolling::None, luding(Some(2e4), 1.0), luding(None, 2.0)]
}

/// Every combination of the three parts.
fn laws() -> Vec<AnyPairLaw> {
    let mut laws = Vec::new();
    for normal in normals() {
        for tangential in tangentials() {
            // The rolling spring follows the contact as the sliding one does.
            let rotation = match tangential {
                AnyTangential::Linear(law) => law.rotation,
                _ => SpringRotation::Project,
            };
            for rolling in rollings(rotation) {
                laws.push(PairLaw {
                    normal,
                    tangential,
                    rolling,
                });
            }
        }
    }
    laws
}

/// Walls, periodic axes and the like.
struct Surroundings {
    name: &'static str,
    walls: Vec<TwinWall>,
    periodic: [bool; 3],
    gravity: DVec3,
    dimensions: u8,
}

fn open(name: &'static str) -> Surroundings {
    Surroundings {
        name,
        walls: Vec::new(),
        periodic: [false; 3],
        gravity: DVec3::ZERO,
        dimensions: 3,
    }
}

fn twin(shape: Result<fast::Shape, fast::WallError>, plain: plain::Shape) -> TwinWall {
    TwinWall {
        fast: wall(shape.unwrap(), fast::Motion::default()),
        plain: plain::Wall::at_rest(plain),
    }
}

fn plane(point: DVec3, normal: DVec3) -> TwinWall {
    let normal = normal.normalize();
    twin(
        fast::Plane::new(point, normal).map(fast::Shape::Plane),
        plain::Shape::Plane { point, normal },
    )
}

fn side(inside: bool) -> (fast::Side, plain::Side) {
    if inside {
        (fast::Side::Inside, plain::Side::Inside)
    } else {
        (fast::Side::Outside, plain::Side::Outside)
    }
}

fn cylinder(origin: DVec3, axis: DVec3, radius: f64, inside: bool) -> TwinWall {
    let (fast_side, side) = side(inside);
    twin(
        fast::Cylinder::new(axis, origin, radius, None, fast_side).map(fast::Shape::Cylinder),
        plain::Shape::Cylinder {
            origin,
            axis,
            radius,
            side,
        },
    )
}

fn ball(origin: DVec3, radius: f64, inside: bool) -> TwinWall {
    let (fast_side, side) = side(inside);
    twin(
        fast::SphereShell::new(origin, radius, fast_side).map(fast::Shape::Sphere),
        plain::Shape::Sphere {
            origin,
            radius,
            side,
        },
    )
}

fn disc(origin: DVec3, axis: DVec3, radius: f64) -> TwinWall {
    let axis = axis.normalize();
    twin(
        fast::Disc::new(axis, origin, radius).map(fast::Shape::Disc),
        plain::Shape::disc(origin, axis, radius),
    )
}

fn cone(origin: DVec3, axis: DVec3, along: [f64; 2], radii: [f64; 2]) -> TwinWall {
    let axis = axis.normalize();
    twin(
        fast::Cone::new(axis, origin, along, radii, fast::Side::Both).map(fast::Shape::Cone),
        plain::Shape::cone(origin, axis, along, radii),
    )
}

fn pipe(origin: DVec3, axis: DVec3, radius: f64, along: [f64; 2]) -> TwinWall {
    let axis = axis.normalize();
    twin(
        fast::Cylinder::new(axis, origin, radius, Some(along), fast::Side::Both)
            .map(fast::Shape::Cylinder),
        plain::Shape::pipe(origin, axis, radius, along),
    )
}

fn revolution(origin: DVec3, axis: DVec3, profile: &[[f64; 2]]) -> TwinWall {
    let axis = axis.normalize();
    twin(
        fast::Revolution::new(axis, origin, profile, fast::Side::Both).map(fast::Shape::Revolution),
        plain::Shape::Revolution {
            origin,
            axis,
            profile: profile.iter().map(|&[r, z]| (r, z)).collect(),
        },
    )
}

fn moving(mut wall: TwinWall, velocity: DVec3) -> TwinWall {
    wall.fast.motion = fast::Motion::new(vec![fast::Component::Translation {
        velocity,
        from: 0.0,
        until: f64::INFINITY,
    }])
    .unwrap();
    wall.plain.motion = plain::Motion::Translation(velocity);
    wall
}

fn turning(mut wall: TwinWall, origin: DVec3, angular_velocity: DVec3) -> TwinWall {
    wall.fast.motion = fast::Motion::new(vec![fast::Component::Rotation {
        axis: angular_velocity,
        origin,
        angular_velocity: angular_velocity.length(),
        from: 0.0,
        until: f64::INFINITY,
    }])
    .unwrap();
    wall.plain.motion = plain::Motion::Rotation {
        origin,
        angular_velocity,
    };
    wall
}

fn surroundings() -> Vec<Surroundings> {
    let middle = DVec3::splat(0.5 * SIZE);
    let weight = dvec3(1.0, 0.0, -9.81);
    let tilted = dvec3(0.3, 0.2, 1.0);
    vec![
        Surroundings {
            gravity: weight,
            ..open("open")
        },
        Surroundings {
            periodic: [true, false, false],
            ..open("periodic x")
        },
        Surroundings {
            periodic: [false, true, true],
            ..open("periodic yz")
        },
        Surroundings {
            periodic: [true; 3],
            ..open("periodic xyz")
        },
        Surroundings {
            walls: vec![
                plane(DVec3::ZERO, DVec3::Z),
                plane(dvec3(0.0, 0.0, SIZE), -DVec3::Z),
            ],
            periodic: [true, true, false],
            gravity: weight,
            ..open("periodic xy between plates")
        },
        Surroundings {
            walls: vec![
                plane(DVec3::ZERO, DVec3::X),
                plane(dvec3(SIZE, 0.0, 0.0), dvec3(-1.0, 0.0, 0.1)),
                moving(plane(DVec3::ZERO, DVec3::Y), dvec3(0.2, 0.3, 0.1)),
                plane(dvec3(0.0, SIZE, 0.0), -DVec3::Y),
                plane(DVec3::ZERO, dvec3(0.2, 0.1, 1.0)),
            ],
            gravity: weight,
            ..open("box with a moving side")
        },
        Surroundings {
            walls: vec![turning(
                cylinder(middle, DVec3::Y, 0.5 * SIZE, true),
                middle,
                6.0 * DVec3::Y,
            )],
            periodic: [false, true, false],
            gravity: weight,
            ..open("turning drum, periodic y")
        },
        Surroundings {
            walls: vec![ball(middle, 0.55 * SIZE, true)],
            ..open("in a sphere")
        },
        Surroundings {
            walls: vec![ball(middle, 0.2 * SIZE, false)],
            periodic: [true; 3],
            ..open("round a sphere, periodic xyz")
        },
        Surroundings {
            walls: vec![
                cylinder(middle, DVec3::Z, 0.2 * SIZE, false),
                plane(DVec3::ZERO, DVec3::Z),
            ],
            gravity: weight,
            ..open("round a column")
        },
        Surroundings {
            walls: vec![
                disc(middle, tilted, 0.3 * SIZE),
                plane(DVec3::ZERO, DVec3::Z),
            ],
            gravity: weight,
            ..open("on a plate")
        },
        Surroundings {
            walls: vec![turning(
                disc(middle, tilted, 0.35 * SIZE),
                middle,
                dvec3(2.0, -1.0, 4.0),
            )],
            ..open("round a tumbling plate")
        },
        Surroundings {
            walls: vec![
                cone(middle, tilted, [-0.1, 0.08], [0.03, 0.12]),
                pipe(middle, dvec3(0.0, 0.0, 1.0), 0.13, [-0.2, -0.11]),
            ],
            gravity: weight,
            ..open("funnel on a pipe")
        },
        Surroundings {
            walls: vec![moving(
                revolution(
                    middle,
                    DVec3::Y,
                    &[[0.0, -0.1], [0.1, -0.05], [0.12, 0.06], [0.09, 0.12]],
                ),
                dvec3(0.1, -0.4, 0.0),
            )],
            ..open("moving vase")
        },
        Surroundings {
            walls: vec![plane(DVec3::ZERO, DVec3::Y)],
            periodic: [true, false, false],
            gravity: dvec3(0.0, -9.81, 0.0),
            dimensions: 2,
            ..open("discs, periodic x")
        },
    ]
}

/// A random scene: free spheres of two sizes and more, one fixed, one held in part. The first pair of spheres overlaps, so that
/// the first step has a force to compare with.
fn scene(laws: LawTable, surroundings: &Surroundings, seed: u64) -> (Engine, Simulation) {
    let mut random = Stream::new(seed, "engine against reference", 0);
    let flat = surroundings.dimensions == 2;
    let mut plan = Plan::bare(
        STEP,
        (DVec3::ZERO, DVec3::splat(SIZE)),
        DENSITY,
        laws.laws[0].unwrap(),
    );
    while plan.materials.len() < laws.materials {
        let mut other = plan.materials[0].clone();
        other.density *= 1.5;
        plan.materials.push(other);
    }
    plan.laws = laws;
    plan.periodic = surroundings.periodic;
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
            material: (count % plan.materials.len()) as u32,
            ..NewParticle::at(position, radius, 0)
        });
    }
    assert_eq!(particles.len(), wanted, "{}: no room", surroundings.name);
    for (id, particle) in particles.iter_mut().enumerate() {
        if id == 5 {
            particle.fixed = true;
            particle.velocity = DVec3::ZERO;
            particle.angular_velocity = DVec3::ZERO;
        }
        if id == 6 {
            particle.prescribed_velocity[0] = Some(particle.velocity.x);
            particle.prescribed_angular_velocity[2] = Some(particle.angular_velocity.z);
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
    }
}

/// Runs both and compares; returns how many contacts were seen.
fn compare(laws: LawTable, surroundings: &Surroundings, seed: u64, steps: u64) -> usize {
    let name = format!("{} under {:?}", surroundings.name, laws.laws[0].unwrap());
    let (mut engine, mut reference) = scene(laws, surroundings, seed);
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
            apart <= POSITIONS,
            "{name}: positions differ by {apart:e} radii after {} steps",
            reference.step
        );
    }
    contacts
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
        .filter(|law| {
            let clamped = match law.normal {
                AnyNormal::Linear(law) => law.clamp_tension,
                AnyNormal::Hertz(law) => law.clamp_tension,
                AnyNormal::Plastic(law) => law.clamp_tension,
            };
            let total = match law.tangential {
                AnyTangential::Mindlin(law) => law.cap_total,
                AnyTangential::MindlinRescaled(law) => law.plain.cap_total,
                AnyTangential::Linear(law) => law.rotation == SpringRotation::Incremental,
                AnyTangential::None => false,
            };
            let lever = matches!(law.rolling, AnyRolling::Luding(luding) if luding.lever != 1.0);
            !(clamped || total || lever)
        })
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
        };
        compare(laws, around, k as u64, 1000);
    }
}
