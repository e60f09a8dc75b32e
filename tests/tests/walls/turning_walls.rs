//! Walls that turn: what sticks to one stays where it is on it, and what they feel and give balances, through periodic faces too.

use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_engine::bodies::{Clump, NewBody};
use mercury_engine::cell::Cell;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    Luding, PairLaw, SpringRotation,
};
use mercury_engine::state::{MaterialIndex, volume};
use mercury_engine::step::Engine;
use mercury_engine::walls::{Component, Cylinder, Disc, Motion, Plane, Shape, Side};
use mercury_solver::plan::{Draft, PrescribedMotion};
use mercury_tests::scenes::{RECORDS, advance, particle, plan, sphere, start, wall};

const RADIUS: f64 = 0.05;
const DENSITY: f64 = 2500.0;
const STIFFNESS: f64 = 1e3;
const GRAVITY: f64 = 1.0;
/// Angular velocity of the table, rad/s.
const SPIN: f64 = 0.1;

/// Resistance to sliding, rolling and torsion, each with a coefficient of `friction`.
fn law(friction: f64) -> AnyPairLaw {
    let mass = DENSITY * volume(RADIUS, 3);
    let stiffness = 2.0 / 7.0 * STIFFNESS;
    let spring = FrictionSpring {
        stiffness: Some(stiffness),
        dissipation: (mass * stiffness).sqrt(),
        friction,
        static_friction: friction,
    };
    PairLaw {
        normal: AnyNormal::Linear(Linear::with_damping_ratio(STIFFNESS, 0.5)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness,
            dissipation: 0.5 * (mass * stiffness).sqrt(),
            friction,
            static_friction: friction,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::Luding(Luding {
            rolling: spring,
            torsion: spring,
            lever: 1.0,
            rotation: SpringRotation::Project,
        }),
        adhesion: AnyAdhesion::None,
    }
}

/// How far (m) a sphere that cannot slide or roll moves outwards in one turn of the table that it lies on, 1 m from the axis; steps of `dt`.
fn outwards_per_turn(dt: f64) -> f64 {
    let mass = DENSITY * volume(RADIUS, 3);
    let mut plan = plan(dt, DENSITY, law(1.0));
    plan.gravity = -GRAVITY * DVec3::Z;
    let turn = Component::Rotation {
        axis: DVec3::Z,
        origin: DVec3::ZERO,
        angular_velocity: SPIN,
        from: 0.0,
        until: f64::INFINITY,
    };
    let table = Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap());
    plan.walls
        .push(wall(table, Motion::new(vec![turn]).unwrap()));
    let height = RADIUS - mass * GRAVITY / STIFFNESS;
    let ball = sphere(
        dvec3(1.0, 0.0, height),
        RADIUS,
        SPIN * DVec3::Y,
        SPIN * DVec3::Z,
    );
    let mut engine = start(plan.with_particles(vec![ball]));
    let turn = (std::f64::consts::TAU / SPIN / dt).round() as u64;
    // A quarter of a turn for the springs to take up the load of the path's curvature.
    advance(&mut engine, turn / 4);
    let from_axis = |engine: &_| particle(engine, 0).position.truncate().length();
    let before = from_axis(&engine);
    advance(&mut engine, turn);
    from_axis(&engine) - before
}

/// With the wall's velocity of another time than the sphere's it creeps by w^2 r dt/2: 1.571 mm in a turn with steps of 5 ms. The
/// rest does not come from the step: the springs that hold the sphere on its circle, m w^2 r/k = 4.6e-5 m long, have to turn with
/// the table, and lag by w times gamma/k of both (0.034 and 0.068 s), which lets the sphere out by 2 pi w (0.034 s + 0.068 s)
/// 4.6e-5 m = 2.9e-6 m.
#[test]
fn a_sticking_sphere_does_not_creep() {
    let (way, coarse) = (outwards_per_turn(5e-3), outwards_per_turn(1e-2));
    assert!(way.abs() < 4e-6, "{way} m outwards in one turn");
    assert!((way - coarse).abs() < 5e-7, "{way} m, and {coarse} m");
}

/// A rod of two balls lies on the table, along its radius, and turns with it: nothing pulls one ball against the other. That takes the velocity of each
/// ball, and that of the wall below it, at the place where the ball was half a step ago. With the lever of the end of the step, the two would
/// be apart by w^2 l dt/2 each second, and after half a turn the springs, which do not turn with the table, by twice 2/w of that each: 0.03 N.
#[test]
fn a_rod_on_a_table_that_turns_is_not_strained() {
    let (dt, lever) = (5e-3, 0.1);
    let mass = DENSITY * volume(RADIUS, 3);
    let mut plan = plan(dt, DENSITY, law(1.0));
    plan.gravity = -GRAVITY * DVec3::Z;
    let turn = Component::Rotation {
        axis: DVec3::Z,
        origin: DVec3::ZERO,
        angular_velocity: SPIN,
        from: 0.0,
        until: f64::INFINITY,
    };
    let table = Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap());
    plan.walls
        .push(wall(table, Motion::new(vec![turn]).unwrap()));
    let pebbles = [-lever, lever].map(|x| Pebble {
        position: x * DVec3::X,
        radius: RADIUS,
    });
    let (own, apart) = (0.4 * RADIUS * RADIUS, lever * lever);
    let moments = 2.0 * mass * dvec3(own, own + apart, own + apart);
    let material = MaterialIndex::new(0);
    let volume = 2.0 * volume(RADIUS, 3);
    let rod = Clump::new(
        "rod",
        material,
        pebbles.to_vec(),
        2.0 * mass,
        volume,
        moments,
    );
    let place = dvec3(1.0, 0.0, RADIUS - mass * GRAVITY / STIFFNESS);
    let body = NewBody {
        velocity: SPIN * DVec3::Y,
        angular_velocity: SPIN * DVec3::Z,
        ..NewBody::at(place, 0)
    };
    let mut engine = start(plan.with_bodies(vec![rod.unwrap()], vec![body]));
    let half = std::f64::consts::PI / SPIN;
    advance(&mut engine, (half / dt).round() as u64);
    engine.step(RECORDS).unwrap();
    let records = engine.observation().records;
    assert_eq!(records.len(), 2);
    let strain = (records[0].tangential - records[1].tangential).length();
    assert!(strain < 1e-4, "{strain} N");
    // It sticks, and stays upon its circle by friction: M w^2 r, which changes its direction as slowly as the table turns.
    let held = (records[0].tangential + records[1].tangential).length();
    let expected = 2.0 * mass * SPIN * SPIN;
    assert!(
        (held / expected - 1.0).abs() < 0.05,
        "{held} N, {expected} N"
    );
}

/// A ball that stands in the middle of a table which turns fast is spun up by the couple of torsion at its limit, l mu N with l = R: by mu N R t/I,
/// as long as the table is faster; N as it is, held at its height.
#[test]
fn torsion_spins_up_a_ball_as_fast_as_its_limit_says() {
    let (mu, overlap, spin, dt) = (0.2, 1e-3, 300.0, 1e-4);
    let mut plan = plan(dt, DENSITY, law(mu));
    let turn = Component::Rotation {
        axis: DVec3::Z,
        origin: DVec3::ZERO,
        angular_velocity: spin,
        from: 0.0,
        until: f64::INFINITY,
    };
    let table = Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap());
    plan.walls
        .push(wall(table, Motion::new(vec![turn]).unwrap()));
    let mut ball = sphere(
        (RADIUS - overlap) * DVec3::Z,
        RADIUS,
        DVec3::ZERO,
        DVec3::ZERO,
    );
    ball.prescribed = PrescribedMotion::boxed([Some(0.0); 3], [None; 3]);
    let mut engine = start(plan.with_particles(vec![ball]));
    let inertia = 0.4 * DENSITY * volume(RADIUS, 3) * RADIUS * RADIUS;
    let rate = mu * STIFFNESS * overlap * RADIUS / inertia;
    for part in 1..5u32 {
        advance(&mut engine, 500);
        let time = 500.0 * f64::from(part) * dt;
        let found = particle(&engine, 0).angular_velocity;
        // The first evaluation, at the start, is of springs that are not stretched yet: half a step's kick, less what the dashpot gives.
        let expected = rate * time * DVec3::Z;
        assert!(
            (found - expected).length() <= 0.5 * rate * dt * 1.000_001,
            "{found}, {expected}"
        );
        assert!(found.z < 0.5 * spin);
    }
}

/// Angular velocity of the walls below, rad/s, about an axis through their reference point.
const TURN: DVec3 = dvec3(3.0, -2.0, 5.0);

/// Three balls, some spinning, that come to a wall which turns about `origin`.
fn balls_and_wall(shape: Shape, origin: DVec3, places: [DVec3; 3]) -> Draft {
    let turn = Component::Rotation {
        axis: TURN,
        origin,
        angular_velocity: TURN.length(),
        from: 0.0,
        until: f64::INFINITY,
    };
    let mut plan = plan(1e-4, DENSITY, law(0.4));
    let mut wall = wall(shape, Motion::new(vec![turn]).unwrap());
    wall.reference = origin;
    plan.walls.push(wall);
    let ball = |k: usize| {
        let inwards = (origin - places[k]).normalize();
        let spin = dvec3(20.0, -10.0, 5.0) * k as f64;
        sphere(places[k], RADIUS, inwards, spin)
    };
    plan.with_particles(vec![ball(0), ball(1), ball(2)])
}

/// A disc, and a drum, with balls that reach them at once or soon.
fn turning_walls(origin: DVec3) -> [Draft; 2] {
    let near = 0.98 * RADIUS;
    let disc = Disc::new(DVec3::Z, origin, 0.4).unwrap();
    let on_disc = [
        dvec3(0.2, 0.05, near),
        dvec3(-0.1, 0.2, -near),
        dvec3(-0.15, -0.2, near),
    ];
    let drum = Cylinder::new(DVec3::X, origin, 0.3, Some([-0.4, 0.4]), Side::Both).unwrap();
    let at_drum = [
        dvec3(0.1, 0.3 - near, 0.0),
        dvec3(-0.2, 0.0, 0.3 + near),
        dvec3(0.15, -0.3 + near, 0.0),
    ];
    [
        balls_and_wall(
            Shape::Disc(disc),
            origin,
            on_disc.map(|place| origin + place),
        ),
        balls_and_wall(
            Shape::Cylinder(drum),
            origin,
            at_drum.map(|place| origin + place),
        ),
    ]
}

/// Force and torque about the wall's origin of all particles on the wall by what they feel themselves: at rest with each other, the
/// wall has the opposite of the sum. `nearest`: the image of a place that is near the wall.
fn counter_load(engine: &Engine, origin: DVec3, nearest: impl Fn(DVec3) -> DVec3) -> [DVec3; 2] {
    let particles = &engine.particles;
    let rows = particles.records.iter().zip(&particles.loads);
    rows.fold([DVec3::ZERO; 2], |[force, torque], (record, load)| {
        let arm = nearest(record.position) - origin;
        [
            force - load.force,
            torque - load.torque - arm.cross(load.force),
        ]
    })
}

/// A wall's torque is the opposite of all that its particles feel, their rolling and torsion couples included, and its power is what that
/// torque takes at the speed of its turn.
#[test]
fn torque_and_power_balance_what_the_particles_feel() {
    let origin = dvec3(0.02, -0.01, 0.03);
    for draft in turning_walls(origin) {
        let mut engine = start(draft);
        let mut couples = 0.0f64;
        for _ in 0..300 {
            engine.step(RECORDS).unwrap();
            let seen = engine.observation();
            assert_eq!(seen.particle_contacts, 0);
            let (load, power) = seen.walls[0];
            let [force, torque] = counter_load(&engine, origin, |place| place);
            // Sums of a few numbers of this size.
            let size = seen.records.iter().map(|record| record.force.length());
            let size = size.sum::<f64>() + f64::MIN_POSITIVE;
            assert!((load.force - force).length() <= 1e-13 * size);
            assert!(
                (load.torque - torque).length() <= 1e-13 * size,
                "{load:?} {torque}"
            );
            let given = -load.torque.dot(TURN);
            assert!(
                (power - given).abs() <= 1e-12 * size,
                "{power} and {given} W"
            );
            couples += seen
                .records
                .iter()
                .map(|record| record.couple.length() / size)
                .sum::<f64>();
        }
        assert!(
            couples > 0.1 * RADIUS,
            "rolling and torsion had a part: {couples}"
        );
    }
}

/// Through a periodic face a turning wall does what it does inside the domain: the particles' forces and torques are the same, and so are the
/// wall's load about its origin and its power.
#[test]
fn a_turning_wall_is_the_same_through_a_periodic_face() {
    let origin = dvec3(0.1, 0.05, 0.02);
    let size = DVec3::splat(2.0);
    for (inside, mut across) in turning_walls(origin).into_iter().zip(turning_walls(origin)) {
        // The wall and its particles stand across faces, particles up to a period away from where they meet it.
        let low = DVec3::splat(0.05);
        across.cell = Cell::new(low, low + size, [true; 3]);
        let mut engines = [start(inside), start(across)];
        let mut wrapped = 0;
        for _ in 0..300 {
            for engine in &mut engines {
                engine.step(RECORDS).unwrap();
            }
            let [one, other] = &engines;
            let (a, b) = (one.observation().walls[0], other.observation().walls[0]);
            let loads = |engine: &Engine| {
                [0, 1, 2].map(|id| {
                    let row = mercury_tests::scenes::row(engine, id);
                    (
                        engine.particles.loads[row],
                        engine.particles.records[row].position,
                    )
                })
            };
            let size = loads(one)
                .iter()
                .map(|(load, _)| load.force.length())
                .sum::<f64>()
                + 1e-3;
            for ((here, place), (there, elsewhere)) in loads(one).into_iter().zip(loads(other)) {
                // Places of a metre are known to 1e-16 m, of which the springs make 1e-13 N, the dashpots of rolling no more.
                assert!(
                    (here.force - there.force).length() < 1e-10 * size,
                    "{here:?} {there:?}"
                );
                assert!((here.torque - there.torque).length() < 1e-10 * size);
                wrapped += usize::from(place.distance(elsewhere) > 1.0);
            }
            assert!((a.0.force - b.0.force).length() < 1e-10 * size);
            assert!(
                (a.0.torque - b.0.torque).length() < 1e-10 * size,
                "{a:?} {b:?}"
            );
            assert!((a.1 - b.1).abs() < 1e-9 * size, "{} and {} W", a.1, b.1);
        }
        assert!(
            wrapped > 100,
            "a particle meets an image in {wrapped} steps"
        );
    }
}
