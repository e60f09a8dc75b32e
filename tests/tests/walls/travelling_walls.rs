//! Bounded walls that travel along a periodic axis: a ball feels in a domain of one period what it feels in one that the wall never leaves.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::curve::Curve;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Hertz, Linear,
    LinearFriction, Mindlin, PairLaw, SpringRotation,
};
use mercury_engine::state::volume;
use mercury_engine::step::Engine;
use mercury_engine::walls::{
    Component, Cone, Cylinder, Disc, Mesh, Motion, MotionTable, Revolution, Servo, Shape, Side,
    SphereShell, Target,
};
use mercury_solver::plan::{Draft, NewParticle, PrescribedMotion};
use mercury_tests::scenes::{
    RECORDS, advance, held, observed_step, particle, plane, sphere, start, wall,
};

const RADIUS: f64 = 0.005;
const PERIOD: f64 = 0.04;
const TIME_STEP: f64 = 2e-5;
const G: f64 = 9.81;
const ALWAYS: (f64, f64) = (0.0, f64::INFINITY);

fn mindlin() -> AnyPairLaw {
    let modulus = 1e5;
    PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(modulus, 0.3)),
        tangential: AnyTangential::Mindlin(Mindlin::new(0.3 * modulus, 1.0, 0.3, 0.3, 0.35)),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

fn slide(velocity: DVec3) -> Component {
    let (from, until) = ALWAYS;
    Component::Translation {
        velocity,
        from,
        until,
    }
}

fn motion(components: Vec<Component>) -> Motion {
    Motion::new(components).unwrap()
}

/// The middle of the domain along x, m.
const MIDDLE: DVec3 = DVec3::new(0.5 * PERIOD, 0.0, 0.0);

/// An open box of triangles about the middle, `half` (m) wide to each side along x.
fn box_of_triangles(half: f64) -> Mesh {
    let mut mesh = TriangleMesh::default();
    for z in [-0.012, 0.012] {
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let corner = dvec3(x * half, y * 0.012, z);
            mesh.vertices.push(MIDDLE + corner);
        }
    }
    for [a, b, c, d] in [
        [0, 1, 2, 3],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ] {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    Mesh::new(&mesh, |x| x, false).unwrap()
}

/// Shapes that hold a ball near the middle, each with the height of its floor below the middle (m).
fn vessels() -> Vec<(&'static str, Shape, f64)> {
    let inside = Side::Inside;
    let below = |z: f64| MIDDLE - z * DVec3::Z;
    let cup = [[0.0, 0.0], [0.012, 0.0], [0.012, 0.024]];
    let lying = Cylinder::new(DVec3::Y, MIDDLE, 0.012, Some([-0.015, 0.015]), inside);
    let along = Cylinder::new(DVec3::X, MIDDLE, 0.012, Some([-0.015, 0.015]), inside);
    let endless = Cylinder::new(DVec3::Y, MIDDLE, 0.012, None, inside);
    let long = Cylinder::new(DVec3::X, MIDDLE, 0.012, Some([-0.027, 0.023]), inside);
    let funnel = Cone::new(
        DVec3::Z,
        below(0.012),
        [0.0, 0.018],
        [0.001, 0.019],
        Side::Both,
    );
    let shell = SphereShell::new(MIDDLE, 0.012, inside).unwrap();
    let cup = Revolution::new(DVec3::Z, below(0.012), &cup, Side::Both).unwrap();
    // A ball in a funnel of 45 degrees lies 1.41 radii above the tip, which is 1 mm below the rim.
    let in_funnel = 0.012 + 0.001 + (1.0 - 2f64.sqrt()) * RADIUS;
    vec![
        ("sphere", Shape::Sphere(shell), 0.012),
        ("lying cylinder", Shape::Cylinder(lying.unwrap()), 0.012),
        ("cylinder along", Shape::Cylinder(along.unwrap()), 0.012),
        ("endless cylinder", Shape::Cylinder(endless.unwrap()), 0.012),
        ("long cylinder", Shape::Cylinder(long.unwrap()), 0.012),
        ("funnel", Shape::Cone(funnel.unwrap()), in_funnel),
        ("cup", Shape::Revolution(cup), 0.012),
        (
            "mesh",
            Shape::Mesh(Arc::new(box_of_triangles(0.012))),
            0.012,
        ),
    ]
}

/// Motions that carry a vessel along x, with the velocity at the start (m/s).
fn motions() -> Vec<(&'static str, Motion, DVec3)> {
    let fast = 1.3 * DVec3::X;
    let (from, until) = ALWAYS;
    let turn = |axis: DVec3| Component::Rotation {
        axis,
        origin: MIDDLE,
        angular_velocity: 8.0,
        from,
        until,
    };
    // 5 m/s^2 at most: less than what throws a ball out of a funnel of 45 degrees.
    let (amplitude, frequency) = (0.07, 1.3);
    let shake = Component::Oscillation {
        amplitude: amplitude * DVec3::X,
        frequency,
        phase: 0.0,
        from,
        until,
    };
    let rows = "t,x,y,z,angle_x,angle_y,angle_z\n0, 0, 0, 0, 0, 0, 0\n0.3, 0.2, 0, 0, 0, 0, 0\n0.8, 0.45, 0, 0, 0, 0, 0.4\n";
    let table = Component::Table {
        table: MotionTable::parse(Path::new("table.csv"), rows).unwrap(),
        origin: MIDDLE,
    };
    vec![
        ("along", motion(vec![slide(fast)]), fast),
        (
            "against and across",
            motion(vec![slide(-0.9 * fast + 0.01 * DVec3::Y)]),
            -0.9 * fast,
        ),
        (
            "turning about z",
            motion(vec![turn(DVec3::Z), slide(fast)]),
            fast,
        ),
        (
            "shaken",
            motion(vec![shake]),
            TAU * frequency * amplitude * DVec3::X,
        ),
        (
            "by a table",
            motion(vec![table]),
            dvec3(0.2 / 0.3, 0.0, 0.0),
        ),
    ]
}

/// A domain of one period along x, or one of 8 m.
fn domain(periodic: bool) -> Draft {
    let half = if periodic { 0.0 } else { 4.0 };
    let low = dvec3(-half, -2.0 * PERIOD, -2.0 * PERIOD);
    let high = dvec3(PERIOD + half, 2.0 * PERIOD, 2.0 * PERIOD);
    let mut draft = Draft::new(TIME_STEP, (low, high), 2500.0, mindlin());
    draft.cell = draft.cell.with_periodic([periodic, false, false]);
    draft.gravity = -G * DVec3::Z;
    draft
}

/// The largest difference of the ball's velocity in the two runs, m/s, and the way that it has gone along x in the open domain, m.
fn difference(begin: impl Fn(bool) -> Engine, steps: u64) -> (f64, f64) {
    let [mut one, mut other] = [true, false].map(begin);
    let start = particle(&other, 0).position.x;
    let mut worst = 0.0f64;
    for _ in 0..steps / 50 {
        advance(&mut one, 50);
        advance(&mut other, 50);
        let [a, b] = [&one, &other].map(|engine| particle(engine, 0));
        worst = worst.max(a.velocity.distance(b.velocity));
        worst = worst.max(a.angular_velocity.distance(b.angular_velocity) * RADIUS);
    }
    (worst, particle(&other, 0).position.x - start)
}

/// A place in the open domain is known to 4e-17 m where it is known to 3e-18 m in the closed one: of an overlap of a micrometre
/// some 1e-10. A contact that rolls and slides damps what this does to velocities of a metre per second.
const ROUND_OFF: f64 = 1e-7;

#[test]
fn vessels_of_every_shape_hold_their_ball_through_many_periods() {
    for (shape_name, shape, floor) in vessels() {
        for (name, motion, velocity) in motions() {
            // Where the ends are open, only friction carries the ball along; a wall without an end crosses its images when it turns.
            if matches!(
                (shape_name, name),
                ("cylinder along" | "long cylinder", "shaken")
                    | ("endless cylinder", "turning about z" | "by a table")
            ) {
                continue;
            }
            let begin = |periodic: bool| {
                let mut draft = domain(periodic);
                draft.walls.push(wall(shape.clone(), motion.clone()));
                let place = MIDDLE - (floor - RADIUS + 1e-6) * DVec3::Z;
                let ball = sphere(place, RADIUS, velocity, DVec3::ZERO);
                start(draft.with_particles(vec![ball]))
            };
            // 0.3 s: 10 periods at 1.3 m/s; the shaken ones come back meanwhile.
            let (worst, _) = difference(begin, 15_000);
            assert!(worst < ROUND_OFF, "{shape_name}, {name}: {worst}");
        }
    }
}

/// Plates push a ball, by a given motion or with the force of a servo.
#[test]
fn plates_push_a_ball_through_many_periods() {
    let plate = |x: f64| Shape::Disc(Disc::new(DVec3::X, x * DVec3::X, 0.015).unwrap());
    let servo = Component::Servo(Servo {
        axis: DVec3::X,
        // Far more than the ball can bear: it goes at its full speed.
        target: Target::Force(Curve::constant(2.0).unwrap()),
        max_speed: 0.8,
        from: 0.0,
        until: f64::INFINITY,
    });
    for (name, component) in [("given", slide(0.8 * DVec3::X)), ("servo", servo)] {
        let begin = |periodic: bool| {
            let mut draft = domain(periodic);
            // It stays on the plate.
            draft.gravity = -3.0 * DVec3::X;
            draft
                .walls
                .push(wall(plate(0.011), motion(vec![component.clone()])));
            let place = dvec3(0.011 + RADIUS, 0.0, 0.0);
            let ball = sphere(place, RADIUS, 0.8 * DVec3::X, DVec3::ZERO);
            start(draft.with_particles(vec![ball]))
        };
        let (worst, way) = difference(begin, 15_000);
        assert!(worst < ROUND_OFF, "{name}: {worst}");
        assert!(way > 4.0 * PERIOD, "{name}: {way}");
    }
}

/// A blade through a layer of balls feels them as long as it goes.
#[test]
fn a_blade_through_a_bed_is_never_without_load() {
    let mut draft = domain(true);
    draft.cell = draft.cell.with_periodic([true, true, false]);
    draft.walls.push(plane(-RADIUS * DVec3::Z, DVec3::Z));
    let blade = Disc::new(DVec3::X, 0.001 * DVec3::X, 0.03).unwrap();
    let sweep = motion(vec![slide(0.2 * DVec3::X)]);
    draft.walls.push(wall(Shape::Disc(blade), sweep));
    let balls = (0..3).flat_map(|i| (0..12).map(move |j| (i, j)));
    let balls = balls.map(|(i, j)| {
        let [x, y] = [f64::from(i), f64::from(j)].map(|k| (k + 0.7) * 2.2 * RADIUS);
        let place = dvec3(x, y - 2.0 * PERIOD, 0.0);
        NewParticle {
            prescribed: PrescribedMotion::boxed([None; 3], [Some(0.0); 3]),
            ..sphere(place, RADIUS, DVec3::ZERO, DVec3::ZERO)
        }
    });
    let balls: Vec<NewParticle> = balls.collect();
    // They cannot roll.
    let friction = 0.35 * G * 2500.0 * volume(RADIUS, 3) * balls.len() as f64;
    let mut engine = start(draft.with_particles(balls));
    for period in 0..5 {
        let mut impulse = 0.0;
        for _ in 0..10_000 {
            observed_step(&mut engine);
            impulse -= engine.observation().walls[1].0.force.x * TIME_STEP;
        }
        // One period of the domain. Balls beside the blade lie still, and some before it have been thrown ahead.
        let expected = friction * 10_000.0 * TIME_STEP;
        assert!(
            impulse > 0.1 * expected,
            "period {period}: {impulse} N s, not {expected}"
        );
    }
    let pose = engine.walls()[1].state.pose.translation.x;
    assert!(pose.abs() <= 0.5 * PERIOD * (1.0 + 1e-6), "{pose}");
}

/// A ball that is held sticks to a floor which slides away under it: its spring is stretched by the floor's whole way, over every seam from one
/// feature of the floor to the next. On triangles of many sizes, and on the rings of a plate.
#[test]
fn springs_go_on_from_feature_to_feature() {
    let (stiffness, speed, overlap) = (1e3, 0.5, 1e-4);
    let law = PairLaw {
        normal: AnyNormal::Linear(Linear::new(1e3, 0.0)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness,
            dissipation: 0.0,
            friction: 1e6,
            static_friction: 1e6,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    // Strips across the way, each cut along a diagonal, narrower and narrower.
    let mut strips = TriangleMesh::default();
    let mut x = -0.02;
    for k in 0..12u32 {
        for y in [-0.03, 0.03] {
            strips.vertices.push(dvec3(x, y, 0.0));
        }
        x += 0.02 / f64::from(k + 1);
        if k > 0 {
            let [a, b, c, d] = [2 * k - 2, 2 * k - 1, 2 * k, 2 * k + 1];
            strips.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    let strips = Shape::Mesh(Arc::new(Mesh::new(&strips, |x| x, false).unwrap()));
    let rings: Vec<[f64; 2]> = (0..12).map(|k| [0.004 * f64::from(k), 0.0]).collect();
    let rings = Revolution::new(DVec3::Z, -0.002 * DVec3::X, &rings, Side::Both).unwrap();
    for (name, shape) in [("strips", strips), ("rings", Shape::Revolution(rings))] {
        let mut plan = Draft::new(TIME_STEP, (-DVec3::ONE, DVec3::ONE), 2500.0, law);
        let away = motion(vec![slide(-speed * DVec3::X)]);
        plan.walls.push(wall(shape, away));
        let place = dvec3(0.001, 0.003, RADIUS - overlap);
        let ball = held(sphere(place, RADIUS, DVec3::ZERO, DVec3::ZERO));
        let mut engine = start(plan.with_particles(vec![ball]));
        let mut features = Vec::new();
        for step in 1..=2000u32 {
            engine.step(RECORDS).unwrap();
            let records = engine.observation().records;
            assert_eq!(records.len(), 1, "{name}, step {step}");
            features.push(records[0].feature);
            // A sum of so many ways of a step.
            let expected = -stiffness * speed * TIME_STEP * f64::from(step);
            let force = records[0].tangential;
            assert!(
                (force - expected * DVec3::X).length() < 1e-10 * expected.abs(),
                "{name}, step {step}: {force} and {expected} N"
            );
        }
        features.dedup();
        assert!(features.len() > 4, "{name}: {features:?}");
    }
}

/// A ball that is held in a groove of one mesh sticks to both of its sides, which slide away along the groove: each of the two springs is stretched by
/// the whole way, over every renewal of the lists, for which a mesh is one thing that is near.
#[test]
fn a_ball_in_a_groove_of_one_mesh_keeps_both_springs() {
    let (stiffness, speed, overlap) = (1e3, 0.5, 1e-4);
    let law = PairLaw {
        normal: AnyNormal::Linear(Linear::new(1e3, 0.0)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness,
            dissipation: 0.0,
            friction: 1e6,
            static_friction: 1e6,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let mut groove = TriangleMesh::default();
    for (x, z) in [(-0.05, 0.05), (0.0, 0.0), (0.05, 0.05)] {
        for y in [-0.1, 0.1] {
            groove.vertices.push(dvec3(x, y, z));
        }
    }
    for [a, b, c, d] in [[0, 1, 3, 2], [2, 3, 5, 4]] {
        groove.triangles.extend([[a, b, c], [a, c, d]]);
    }
    let groove = Shape::Mesh(Arc::new(Mesh::new(&groove, |x| x, false).unwrap()));
    let mut plan = Draft::new(TIME_STEP, (-DVec3::ONE, DVec3::ONE), 2500.0, law);
    let away = motion(vec![slide(-speed * DVec3::Y)]);
    plan.walls.push(wall(groove, away));
    // The sides stand at 45 degrees.
    let place = DVec3::Z * (2f64.sqrt() * (RADIUS - overlap));
    let ball = held(sphere(place, RADIUS, DVec3::ZERO, DVec3::ZERO));
    let mut engine = start(plan.with_particles(vec![ball]));
    let before = engine.list_statistics().0;
    for step in 1..=2000u32 {
        engine.step(RECORDS).unwrap();
        let expected = -stiffness * speed * TIME_STEP * f64::from(step);
        let records = engine.observation().records;
        assert_eq!(records.len(), 2, "step {step}");
        for record in records {
            let force = record.tangential;
            assert!(
                (force - expected * DVec3::Y).length() < 1e-10 * expected.abs(),
                "step {step}: {force} and {expected} N"
            );
        }
    }
    let renewals = engine.list_statistics().0 - before;
    assert!(renewals > 3, "{renewals} renewals");
}

/// A plate turns about an axis that travels along a periodic axis with it: that axis moves at the velocity of the journey in every period, also after the
/// plate was set back by whole periods; and so do, turning about it, all other points.
#[test]
fn velocities_that_are_reported_go_back_by_periods_with_the_wall() {
    let (speed, spin) = (0.5, 3.0);
    let turn = Component::Rotation {
        axis: DVec3::Y,
        origin: MIDDLE,
        angular_velocity: spin,
        from: 0.0,
        until: f64::INFINITY,
    };
    let mut scene = domain(true);
    let plate = Disc::new(DVec3::Z, MIDDLE, 0.005).unwrap();
    let mut plate = wall(
        Shape::Disc(plate),
        motion(vec![turn, slide(speed * DVec3::X)]),
    );
    plate.reference = MIDDLE;
    scene.walls = vec![plate];
    let mut engine = start(scene);
    let mut set_back = 0;
    for _ in 0..30 {
        advance(&mut engine, 200);
        let time = engine.time();
        let planned = &engine.physics().walls[0];
        let state = engine.walls()[0].state_at(planned, time);
        let periods = (MIDDLE.x + speed * time - state.reference.x) / PERIOD;
        assert!((periods - periods.round()).abs() < 1e-9, "{periods}");
        set_back += i32::from(periods.round() != 0.0);
        let found = state.velocity.at(state.reference);
        assert!(
            (found - speed * DVec3::X).length() < 1e-9,
            "{time} s: {found}"
        );
        // A hand's breadth above the axis: faster by w h.
        let above = state.velocity.at(state.reference + 0.1 * DVec3::Z);
        let expected = (speed + spin * 0.1) * DVec3::X;
        assert!((above - expected).length() < 1e-9, "{time} s: {above}");
    }
    assert!(set_back > 10, "set back in {set_back} of 30 looks");
}
