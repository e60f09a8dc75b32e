//! A wall as wide as the period or wider is met with all its images: like copies of it in a domain without periods.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use mercury_engine::cell::Cell;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear, LinearFriction, PairLaw,
    SpringRotation,
};
use mercury_engine::state::{Particle, volume};
use mercury_engine::walls::{
    Component, Cone, Cylinder, Disc, Motion, Revolution, Shape, Side, SphereShell, Wall,
};
use mercury_solver::plan::{Draft, NewParticle};
use mercury_tests::scenes::{plan, plane, sphere, start, wall};

const PERIOD: f64 = 0.024;
const RADIUS: f64 = 0.003;
const DENSITY: f64 = 2000.0;
const STIFFNESS: f64 = 500.0;

fn law() -> AnyPairLaw {
    PairLaw {
        normal: AnyNormal::Linear(Linear::with_damping_ratio(STIFFNESS, 0.1)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 2.0 / 7.0 * STIFFNESS,
            dissipation: 0.0,
            friction: 0.6,
            static_friction: 0.6,
            rotation: SpringRotation::Project,
            limits: Default::default(),
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

fn contact_time() -> f64 {
    PI * (DENSITY * volume(RADIUS, 3) / STIFFNESS).sqrt()
}

fn scene(walls: Vec<Wall>, ball: NewParticle) -> Draft {
    let mut plan = plan(contact_time() / 30.0, DENSITY, law());
    plan.gravity = dvec3(0.0, 0.0, -9.81);
    plan.walls = walls;
    plan.with_particles(vec![ball])
}

/// Where the ball is every tenth step.
fn way(scene: Draft, steps: u64) -> Vec<Particle> {
    let mut engine = start(scene);
    let mut way = Vec::new();
    for step in 1..=steps {
        engine.step(None).unwrap();
        if step % 10 == 0 {
            assert_eq!(engine.particles.len(), 1, "it left the domain");
            way.push(engine.particles.records[0]);
        }
    }
    way
}

/// The ball among the images of the wall goes the same way as among copies of it, for `steps` steps; returns how many periods it went along x.
fn as_among_copies(
    name: &str,
    shape: impl Fn(f64) -> Shape,
    motion: Motion,
    ball: &NewParticle,
    steps: u64,
) -> f64 {
    let copies = (-6..=6).map(|k| wall(shape(f64::from(k) * PERIOD), motion.clone()));
    let copies = scene(copies.collect(), ball.clone());
    as_there(name, copies, wall(shape(0.0), motion), ball, steps)
}

/// Compares the way of a ball with that in any scene without periods.
fn as_there(name: &str, there: Draft, wall: Wall, ball: &NewParticle, steps: u64) -> f64 {
    let expected = way(there, steps);
    let mut periodic = scene(vec![wall], ball.clone());
    let (low, high) = periodic.cell.corners();
    periodic.cell = Cell::new(low.with_x(0.0), high.with_x(PERIOD), [true, false, false]);
    let mut gone = 0.0f64;
    for (k, (one, other)) in expected.iter().zip(way(periodic, steps)).enumerate() {
        let mut apart = one.position - other.position;
        let periods = (apart.x / PERIOD).round();
        apart.x -= periods * PERIOD;
        if periods.abs() > gone.abs() {
            gone = periods;
        }
        // Round-off, which the motion makes grow.
        let places = [one.position, other.position];
        assert!(
            apart.length() < 1e-9 * RADIUS,
            "{name}: {apart} m apart at {k}, {places:?}"
        );
        let spin = one.angular_velocity - other.angular_velocity;
        assert!(spin.length() < 1e-6, "{name}: spin {spin} at {k}");
    }
    gone
}

fn ball(x: f64, height: f64, velocity: DVec3) -> NewParticle {
    sphere(
        dvec3(x, 0.0, height),
        RADIUS,
        velocity,
        dvec3(0.0, 1.0, 0.0),
    )
}

fn translation(velocity: DVec3) -> Component {
    Component::Translation {
        velocity,
        from: 0.0,
        until: f64::INFINITY,
    }
}

fn rotation(axis: DVec3, origin: DVec3, angular_velocity: f64) -> Component {
    Component::Rotation {
        axis,
        origin,
        angular_velocity,
        from: 0.0,
        until: f64::INFINITY,
    }
}

/// Domes wider than the period cross; a ball falls into the crease between them, and is thrown across several.
#[test]
fn a_ball_stays_on_domes_that_cross() {
    let (radius, middle) = (0.013, 0.5 * PERIOD);
    let dome = |x: f64| {
        let centre = dvec3(middle + x, 0.0, 0.0);
        Shape::Sphere(SphereShell::new(centre, radius, Side::Outside).unwrap())
    };
    let height = radius + 1.5 * RADIUS;
    let falls = ball(0.1 * PERIOD, height, DVec3::ZERO);
    as_among_copies("falls", dome, Motion::default(), &falls, 3000);
    let thrown = ball(0.1 * PERIOD, height, dvec3(-0.4, 0.0, 0.0));
    let gone = as_among_copies("thrown", dome, Motion::default(), &thrown, 3000);
    assert!(gone <= -1.0, "{gone}");
}

/// Rods across the period, cones side by side, plates that lean: of all shapes, at rest, while they travel on and on, and while they turn.
#[test]
fn every_shape_is_met_with_its_images() {
    let middle = 0.5 * PERIOD;
    let across = 1.1 * middle;
    let axis = DVec3::Y;
    type At = Box<dyn Fn(f64) -> Shape>;
    let shapes: [(&str, At); 5] = [
        (
            "rod",
            Box::new(move |x| {
                let along = Some([-0.02, 0.02]);
                let origin = dvec3(middle + x, 0.0, 0.0);
                let rod = Cylinder::new(axis, origin, across, along, Side::Outside);
                Shape::Cylinder(rod.unwrap())
            }),
        ),
        (
            "endless rod",
            Box::new(move |x| {
                let origin = dvec3(middle + x, 0.0, 0.0);
                let rod = Cylinder::new(axis, origin, across, None, Side::Outside);
                Shape::Cylinder(rod.unwrap())
            }),
        ),
        (
            "cone",
            Box::new(move |x| {
                let origin = dvec3(middle + x, 0.0, 0.0);
                let (along, radii) = ([-0.01, across], [1.5 * across, 0.3 * across]);
                let cone = Cone::new(DVec3::Z, origin, along, radii, Side::Outside);
                Shape::Cone(cone.unwrap())
            }),
        ),
        (
            "plate",
            Box::new(move |x| {
                let normal = dvec3(-0.3, 0.0, 1.0);
                let origin = dvec3(middle + x, 0.0, 0.5 * across);
                Shape::Disc(Disc::new(normal, origin, across).unwrap())
            }),
        ),
        (
            "top",
            Box::new(move |x| {
                let origin = dvec3(middle + x, 0.0, 0.0);
                let profile = [[0.0, 1.0], [0.7, 0.8], [1.2, 0.0]]
                    .map(|point: [f64; 2]| point.map(|part| part * across));
                let top = Revolution::new(DVec3::Z, origin, &profile, Side::Outside);
                Shape::Revolution(top.unwrap())
            }),
        ),
    ];
    let rolls = ball(0.3 * PERIOD, across + 1.2 * RADIUS, dvec3(-0.35, 0.0, 0.0));
    for (name, shape) in &shapes {
        let follow = |how: &str, motion: Vec<Component>| {
            let motion = Motion::new(motion).unwrap();
            as_among_copies(&format!("{name} {how}"), shape, motion, &rolls, 2000)
        };
        follow("at rest", Vec::new());
        let gone = follow("travels", vec![translation(dvec3(-0.35, 0.0, 0.0))]);
        assert!(gone <= -1.0, "{name}: {gone}");
        follow(
            "shakes",
            vec![Component::Oscillation {
                amplitude: dvec3(0.3, 0.0, 0.1) * RADIUS,
                frequency: 30.0,
                phase: 0.0,
                from: 0.0,
                until: f64::INFINITY,
            }],
        );
    }
}

/// A ball that spins in the crease between two rods while both travel: its two contacts go on, each with its own spring, where the ball is put back
/// into the domain, and where the rods are.
#[test]
fn both_contacts_in_a_crease_go_on() {
    let (middle, radius) = (0.5 * PERIOD, 0.55 * PERIOD);
    let rod = |x: f64| {
        let origin = dvec3(middle + x, 0.0, 0.0);
        let rod = Cylinder::new(DVec3::Y, origin, radius, None, Side::Outside);
        Shape::Cylinder(rod.unwrap())
    };
    // It touches both.
    let height = ((radius + 0.99 * RADIUS).powi(2) - middle * middle).sqrt();
    for side in [-1.0, 1.0] {
        let velocity = dvec3(side * 0.35, 0.0, 0.0);
        let mut spins = ball(0.3 * RADIUS, height + 0.3 * RADIUS, velocity);
        spins.angular_velocity = dvec3(0.0, 20.0, 0.0);
        let motion = Motion::new(vec![translation(velocity)]).unwrap();
        let gone = as_among_copies("spins", rod, motion, &spins, 4000);
        assert!(gone * side >= 2.0, "{gone}");
    }
}

/// Images of a wall while each copy turns about an axis of its own.
#[test]
fn images_of_a_wall_that_turns() {
    let (middle, radius) = (0.5 * PERIOD, 0.55 * PERIOD);
    let copy = |x: f64| {
        let origin = dvec3(middle + x, 0.0, 0.0);
        let along = Some([-0.02, 0.02]);
        let rod = Cylinder::new(DVec3::Y, origin, radius, along, Side::Outside).unwrap();
        let turn = rotation(DVec3::Y, origin, 5.0);
        wall(Shape::Cylinder(rod), Motion::new(vec![turn]).unwrap())
    };
    let falls = ball(0.2 * PERIOD, radius + 1.1 * RADIUS, dvec3(-0.3, 0.0, 0.0));
    let copies = (-6..=6).map(|k| copy(f64::from(k) * PERIOD)).collect();
    let gone = as_there(
        "turns",
        scene(copies, falls.clone()),
        copy(0.0),
        &falls,
        2000,
    );
    assert!(gone <= -1.0, "{gone}");
}

/// Discs wider than the period lie one on the other: a ball that rolls over them feels a plane, spring and all.
#[test]
fn discs_that_overlap_are_one_plane() {
    let rolls = ball(0.3 * PERIOD, 0.98 * RADIUS, dvec3(-0.4, 0.0, 0.0));
    for part in [0.5000001, 0.7, 1.3, 2.2] {
        let disc = Disc::new(DVec3::Z, dvec3(0.5 * PERIOD, 0.0, 0.0), part * PERIOD);
        let disc = wall(Shape::Disc(disc.unwrap()), Motion::default());
        let expected = scene(vec![plane(DVec3::ZERO, DVec3::Z)], rolls.clone());
        let gone = as_there("disc", expected, disc, &rolls, 3000);
        assert!(gone <= -2.0, "{gone}");
    }
}

/// A pipe with a profile of one period goes on in its images: wherever the seam is, and where the profile is longer, it is like a pipe of many
/// periods.
#[test]
fn a_profile_of_a_period_goes_on() {
    let wave = |point: u32| match point % 4 {
        0 => 0.0095,
        2 => 0.0115,
        _ => 0.0105,
    };
    let pipe = |first: u32, last: u32, start: f64| {
        let profile: Vec<_> = (first..=last)
            .map(|k| [wave(k), f64::from(k - first) * 0.25 * PERIOD])
            .collect();
        let pipe = Revolution::new(DVec3::X, dvec3(start, 0.0, 0.0), &profile, Side::Inside);
        wall(Shape::Revolution(pipe.unwrap()), Motion::default())
    };
    let rolls = ball(0.3 * PERIOD, 0.98 * RADIUS - 0.0095, dvec3(-0.4, 0.0, 0.0));
    for first in 0..4 {
        for quarters in [4, 6, 9] {
            let start = f64::from(first) * 0.25 * PERIOD;
            let long = scene(vec![pipe(0, 52, -6.0 * PERIOD)], rolls.clone());
            let short = pipe(first, first + quarters, start);
            let name = format!("from {first}, {quarters} quarters");
            let gone = as_there(&name, long, short, &rolls, 3000);
            assert!(gone <= -2.0, "{name}: {gone}");
        }
    }
}

/// A pipe as long as the period, or longer, is endless.
#[test]
fn a_pipe_along_the_period_is_endless() {
    let pipe = |along: Option<[f64; 2]>| {
        let pipe = Cylinder::new(DVec3::X, DVec3::ZERO, 0.01, along, Side::Inside);
        wall(Shape::Cylinder(pipe.unwrap()), Motion::default())
    };
    let rolls = ball(0.3 * PERIOD, 0.98 * RADIUS - 0.01, dvec3(-0.4, 0.0, 0.0));
    for along in [
        [0.0, PERIOD],
        [0.4 * PERIOD, 1.4 * PERIOD],
        [-0.3 * PERIOD, 1.9 * PERIOD],
    ] {
        let expected = scene(vec![pipe(None)], rolls.clone());
        let gone = as_there("pipe", expected, pipe(Some(along)), &rolls, 3000);
        assert!(gone <= -2.0, "{gone}");
    }
}
