//! The engine finds the contacts that brute force finds, in every step, while particles, bodies and walls move and lists are rebuilt.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::random::Stream;
use mercury_engine::bodies::Clump;
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::forces::Partner;
use mercury_engine::state::{Id, MaterialIndex, WallIndex};
use mercury_engine::step::Engine;
use mercury_engine::walls::{
    Component, Cylinder, Disc, Motion, Plane, Shape, Side, SphereShell, Touches,
};
use mercury_solver::plan::{Draft, NewBody, NewParticle, PrescribedMotion};
use mercury_tests::scenes::{RECORDS, frictionless, row, start, wall};
use proptest::prelude::*;

/// Ids of all pairs that the last step's records name; fails if one is named twice.
fn recorded(engine: &Engine) -> BTreeSet<(Id, Id)> {
    let ids = &engine.particles.ids;
    let mut pairs = BTreeSet::new();
    for record in engine.observation().records {
        if let Partner::Particle { row, image } = record.partner {
            let (a, b) = (ids[record.row as usize], ids[row as usize]);
            assert!(
                pairs.insert((a.min(b), a.max(b))),
                "{a} and {b} touch twice"
            );
            // The partner is where its image stands.
            let [one, other] = [record.row, row].map(|row| engine.particles.records[row as usize]);
            let branch = one.position - other.position - engine.cell().shift(image);
            let length = one.radius + other.radius - record.overlap;
            let apart = (branch - length * record.normal).length();
            assert!(apart < 1e-12, "{a} and {b}: {branch} by image {image}");
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
            let bodies = engine.particles.bodies.as_ref();
            let body = |row: usize| bodies.and_then(|bodies| bodies.body_of_row(row));
            let apart = body(i).is_none() || body(i) != body(j);
            if branch.length() < records[i].radius + records[j].radius && !fixed && apart {
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
        plan.cell = plan.cell.with_periodic(periodic);
        plan.gravity = gravity * DVec3::Z;
        let particles = (0..count)
            .map(|k| NewParticle {
                velocity: (vector() * 2.0 - 1.0) * speed,
                fixed: k % fixed_every == 0,
                prescribed: PrescribedMotion::boxed([None, None, (k % 7 == 3).then_some(0.0098)], [None; 3]),
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
        few_are_fast(seed, count, [0.011, ratio], periodic, speed)?;
    }

    /// Sizes evenly over up to three decades, the largest as large as the domain allows: levels of sizes, fixed particles, extra skin and images together.
    #[test]
    fn is_that_of_brute_force_to_a_size_ratio_of_1000(
        seed in any::<u64>(),
        count in 400usize..500,
        decades in 1.0..3.0f64,
        periodic in any::<[bool; 3]>(),
        speed in 0.2..5.0f64,
    ) {
        let ratio = 10f64.powf(decades);
        few_are_fast(seed, count, [0.11 / ratio, ratio], periodic, speed)?;
    }
}

/// In a given scene, as how often extra skin acts depends on the scene: later the skin of so thin a gas is at its maximum, and
/// leaves no space for more.
#[test]
fn few_that_are_fast_have_extra_skin() {
    let steps = few_are_fast(1, 450, [0.011, 1.0], [true; 3], 4.0).unwrap();
    assert!(steps > 2, "extra skin in {steps} steps only");
    let steps = few_are_fast(1, 450, [1.1e-4, 1000.0], [true; 3], 0.5).unwrap();
    assert!(
        steps > 2,
        "extra skin in {steps} steps only at a size ratio of 1000"
    );
}

/// One of a level that has little skin, as its particles hardly moved, sets out fast: in this scene it met one that no list held
/// while such a particle counted as one that may go half the skin.
#[test]
fn particles_with_little_skin_are_listed_anew_in_time() {
    let ratio = 52.254;
    let sizes = [0.11 / ratio, ratio];
    few_are_fast(
        1343646275268759964,
        406,
        sizes,
        [false, true, false],
        1.324577972366924,
    )
    .unwrap();
}

/// Two among hundreds shoot through the others, which hardly move: they get extra skin, and lists last longer. Through faces
/// and walls of spheres that are fixed too. Radii are `smallest` (m) to `ratio` times that, evenly by their logarithm. Compares each step with brute force; returns the steps in which a particle had extra
/// skin.
fn few_are_fast(
    seed: u64,
    count: usize,
    [smallest, ratio]: [f64; 2],
    periodic: [bool; 3],
    speed: f64,
) -> Result<usize, TestCaseError> {
    let size = dvec3(0.5, 0.6, 0.7);
    // As slow for the smallest, whatever its mass.
    let stiffness = 0.1 * (smallest / 0.011f64).powi(3);
    let mut random = Stream::new(seed, "few are fast", 0);
    let mut vector = || dvec3(random.uniform(), random.uniform(), random.uniform());
    let law = frictionless(AnyNormal::Linear(Linear::new(stiffness, 0.0)));
    let mut plan = Draft::new(1e-3, (DVec3::ZERO, size), 1000.0, law);
    plan.cell = plan.cell.with_periodic(periodic);
    // A plate that swings, so far inside that no image of a particle meets it.
    let plate = Disc::new(dvec3(0.3, 0.2, 1.0), 0.5 * size, 0.08).unwrap();
    let swing = Component::Oscillation {
        amplitude: dvec3(0.02, -0.01, 0.03),
        frequency: 3.0,
        phase: 0.4,
        from: 0.0,
        until: f64::INFINITY,
    };
    plan.walls
        .push(wall(Shape::Disc(plate), Motion::new(vec![swing]).unwrap()));
    let particles = (0..count)
        .map(|k| {
            let speed = if k == 16 || k == 215 { speed } else { 0.02 };
            NewParticle {
                velocity: (vector() * 2.0 - 1.0).normalize() * speed,
                fixed: k % 7 == 0,
                ..NewParticle::at(
                    vector() * size,
                    smallest * ratio.powf(vector().x),
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
        let mut at_plate = touching_walls(&engine);
        at_plate.retain(|(id, ..)| !engine.particles.is_fixed(row(&engine, id.number())));
        let found = recorded_at_walls(&engine);
        prop_assert_eq!(found, at_plate, "in step {}", engine.steps());
        let extra_skin = engine.lists().extra_skin.clone();
        with_extra_skin += usize::from(extra_skin.iter().any(|&extra_skin| extra_skin > 0.0));
    }
    Ok(with_extra_skin)
}

/// Two shoot through a lattice of hundreds that nearly touch each other and hardly move, and through plates in it. They are so much faster that only the largest skin bounds
/// their extra skin, and they use up all of it while they meet one after the other.
#[test]
fn few_that_shoot_through_a_lattice_meet_all_on_their_way() {
    let radius = 0.01;
    let spacing = 2.05 * radius;
    let size = DVec3::splat(8.0 * spacing);
    let law = frictionless(AnyNormal::Linear(Linear::new(1e-3, 0.0)));
    let mut plan = Draft::new(1e-4, (DVec3::ZERO, size), 1000.0, law);
    plan.cell = plan.cell.with_periodic([true; 3]);
    // Plates well inside, so that no image of a particle meets one.
    for k in -3..=3 {
        let (axis, place) = (dvec3(0.3, 0.2, 1.0), 0.1 * f64::from(k) * size.x);
        let disc = Disc::new(axis, 0.5 * size + place * axis.normalize(), 0.25 * size.x).unwrap();
        plan.walls.push(wall(Shape::Disc(disc), Motion::default()));
    }
    let mut random = Stream::new(9, "lattice", 0);
    let mut vector = || dvec3(random.uniform(), random.uniform(), random.uniform()) * 2.0 - 1.0;
    let lattice = (0..512u32).map(|k| {
        let site = dvec3(f64::from(k % 8), f64::from(k / 8 % 8), f64::from(k / 64)) + 0.5;
        NewParticle {
            velocity: 1e-3 * vector(),
            ..NewParticle::at(site * spacing, radius, MaterialIndex::new(0))
        }
    });
    let mut particles: Vec<NewParticle> = lattice.collect();
    for (k, direction) in [dvec3(1.0, 0.3, 0.2), dvec3(-0.1, 0.4, -1.0)]
        .into_iter()
        .enumerate()
    {
        let place = (0.3 + 0.4 * k as f64) * size;
        let mut fast = NewParticle::at(place, radius, MaterialIndex::new(0));
        fast.velocity = 4.0 * direction;
        particles.push(fast);
    }
    let mut engine = start(plan.with_particles(particles));
    let (mut seen, mut begun, mut bounded) = (BTreeSet::new(), 0, 0);
    for _ in 0..1200 {
        engine.step(RECORDS).unwrap();
        let expected = overlapping(&engine, size, [true; 3]);
        assert_eq!(recorded(&engine), expected, "in step {}", engine.steps());
        let at_plates = touching_walls(&engine);
        assert_eq!(
            recorded_at_walls(&engine),
            at_plates,
            "in step {}",
            engine.steps()
        );
        begun += expected.difference(&seen).count();
        seen.extend(expected);
        let lists = engine.lists();
        let most = 0.5 * lists.skin.largest - 0.5 * lists.skin.thickness;
        // The largest skin is the mean radius but for round-off.
        let is_most = |extra: &f64| (extra - most).abs() < 1e-12 * radius;
        bounded += usize::from(lists.extra_skin.iter().any(is_most));
    }
    assert!(
        begun > 50 && bounded > 100,
        "{begun} contacts, bounded in {bounded} steps"
    );
}

/// Pairs that approach each other head-on, each with another gap: both of a pair use up all of their half of the skin, and the pair
/// that had just no place in a list must be in the next one in time.
#[test]
fn a_list_lasts_no_longer_than_its_skin() {
    let (radius, speed, time_step) = (0.01, 0.5, 1e-5);
    let law = frictionless(AnyNormal::Linear(Linear::new(1e-3, 0.0)));
    let mut plan = Draft::new(time_step, (DVec3::ZERO, DVec3::ONE), 1000.0, law);
    plan.cell = plan.cell.with_periodic([true; 3]);
    // Gaps up to four of the first skins of a tenth of a radius, each a hundredth of it larger than the last.
    let particles = (0..400u32).flat_map(|k| {
        let middle = dvec3(0.5, f64::from(k % 20), f64::from(k / 20)) * dvec3(1.0, 0.05, 0.05);
        let gap = 1e-3 * radius * f64::from(k);
        [-1.0, 1.0].map(|side| NewParticle {
            velocity: -side * speed * DVec3::X,
            ..NewParticle::at(
                middle + side * (radius + 0.5 * gap) * DVec3::X,
                radius,
                MaterialIndex::new(0),
            )
        })
    });
    let mut engine = start(plan.with_particles(particles.collect()));
    for _ in 0..400 {
        engine.step(RECORDS).unwrap();
        let found: BTreeSet<u32> = recorded(&engine)
            .iter()
            .map(|(a, _)| a.number() / 2)
            .collect();
        let records = &engine.particles.records;
        let touching = (0..400).filter(|k| {
            let [a, b] = [2 * k, 2 * k + 1].map(|id| records[row(&engine, id)].position);
            a.distance(b) < 2.0 * radius
        });
        assert_eq!(found, touching.collect(), "in step {}", engine.steps());
    }
    assert!(
        engine.list_statistics().0 >= 3,
        "{:?}",
        engine.list_statistics()
    );
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
    pusher.prescribed = PrescribedMotion::boxed([Some(0.0), Some(0.0), Some(velocity)], [None; 3]);
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

/// A rod of seven pebbles, six radii long to either side.
fn rod(radius: f64) -> Clump {
    let pebbles = (-3..=3).map(|k| Pebble {
        position: DVec3::X * (2.0 * radius * f64::from(k)),
        radius,
    });
    // Seven balls of mass m: I = m R^2 (2.8, 2.8 + 112, 2.8 + 112), as the sum of k^2 is 28.
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let mass = 1000.0 * volume;
    let moments = dvec3(2.8, 114.8, 114.8) * (mass * radius * radius);
    let material = MaterialIndex::new(0);
    Clump::new(
        "rod",
        material,
        pebbles.collect(),
        7.0 * mass,
        7.0 * volume,
        moments,
    )
    .unwrap()
}

/// Rods that spin beside each other: their ends are many times as fast as their centres, which hardly move.
#[test]
fn bodies_that_spin_meet_what_they_overlap() {
    for periodic in [[false; 3], [true; 3]] {
        let size = DVec3::splat(0.4);
        let mut random = Stream::new(3, "spinning rods", 0);
        let law = frictionless(AnyNormal::Linear(Linear::new(0.1, 0.0)));
        let mut plan = Draft::new(2e-4, (DVec3::ZERO, size), 1000.0, law);
        plan.cell = plan.cell.with_periodic(periodic);
        let bodies = (0..60).map(|_| {
            let mut vector = || dvec3(random.uniform(), random.uniform(), random.uniform());
            let (place, velocity, spin) = (vector(), vector() * 2.0 - 1.0, vector() * 2.0 - 1.0);
            NewBody {
                orientation: random.unit_quaternion(),
                velocity: 0.02 * velocity,
                angular_velocity: 100.0 * spin,
                ..NewBody::at(place * size, 0)
            }
        });
        let mut engine = start(plan.with_bodies(vec![rod(0.008)], bodies.collect()));
        let (mut seen, mut begun) = (BTreeSet::new(), 0);
        for _ in 0..600 {
            engine.step(RECORDS).unwrap();
            let found = recorded(&engine);
            let expected = overlapping(&engine, size, periodic);
            assert_eq!(found, expected, "in step {}", engine.steps());
            begun += expected.difference(&seen).count();
            seen.extend(expected);
        }
        // Contacts begin all the time: the tips pass the reach of a list in some steps.
        assert!(begun > 100, "{begun} contacts");
        assert!(
            engine.list_statistics().0 > 10,
            "{:?}",
            engine.list_statistics()
        );
    }
}

/// Particles and the features of walls that they touch, by the records of the last step.
fn recorded_at_walls(engine: &Engine) -> BTreeSet<(Id, WallIndex, u32)> {
    let records = engine.observation().records;
    let of_wall = records.iter().filter_map(|record| match record.partner {
        Partner::Wall { wall, .. } => Some((
            engine.particles.ids[record.row as usize],
            wall,
            record.feature,
        )),
        Partner::Particle { .. } => None,
    });
    of_wall.collect()
}

/// Touched walls by a query of every wall, at its place, for every particle.
fn touching_walls(engine: &Engine) -> BTreeSet<(Id, WallIndex, u32)> {
    let mut touching = BTreeSet::new();
    let mut touches = Touches::new();
    for (number, wall) in (0u16..).zip(engine.walls()) {
        for (record, &id) in engine.particles.records.iter().zip(&engine.particles.ids) {
            let place = wall.state.into_wall(record.position);
            wall.shape().touches(place, record.radius, &mut touches);
            let features = touches.iter().map(|touch| touch.feature);
            touching.extend(features.map(|feature| (id, WallIndex::new(number), feature)));
        }
    }
    touching
}

/// Walls that are as fast as the particles that come towards them, so that both use up the margin of the list: the contacts are
/// those of a check of every particle in every step.
#[test]
fn walls_that_are_fast_meet_what_they_touch() {
    let size = DVec3::ONE;
    let middle = 0.5 * size;
    let swing = |amplitude: DVec3, phase: f64| Component::Oscillation {
        amplitude,
        frequency: 2.0,
        phase,
        from: 0.0,
        until: f64::INFINITY,
    };
    let turn = |axis: DVec3, angular_velocity: f64| Component::Rotation {
        axis,
        origin: middle,
        angular_velocity,
        from: 0.0,
        until: f64::INFINITY,
    };
    let shapes = [
        Shape::Plane(Plane::new(dvec3(0.0, 0.0, 0.2), DVec3::Z).unwrap()),
        Shape::Disc(Disc::new(dvec3(0.2, 0.1, 1.0), middle, 0.4).unwrap()),
        Shape::Cylinder(
            Cylinder::new(DVec3::X, middle, 0.3, Some([-0.3, 0.3]), Side::Both).unwrap(),
        ),
        Shape::Sphere(SphereShell::new(middle, 0.3, Side::Both).unwrap()),
    ];
    for (k, shape) in shapes.into_iter().enumerate() {
        for components in [
            vec![swing(dvec3(0.1, 0.05, 0.15), 0.3 * k as f64)],
            vec![turn(dvec3(1.0, 0.3, -0.2), 0.5 * TAU)],
            vec![turn(DVec3::Y, TAU), swing(DVec3::Z * 0.1, 1.0)],
        ] {
            let mut random = Stream::new(5, "fast walls", k as u64);
            let law = frictionless(AnyNormal::Linear(Linear::new(0.1, 0.0)));
            let mut plan = Draft::new(1e-3, (-size, 2.0 * size), 1000.0, law);
            plan.walls
                .push(wall(shape.clone(), Motion::new(components).unwrap()));
            let particles = (0..150).map(|_| {
                let mut vector = || dvec3(random.uniform(), random.uniform(), random.uniform());
                let (place, velocity) = (vector(), vector() * 2.0 - 1.0);
                NewParticle {
                    velocity: 2.0 * velocity,
                    ..NewParticle::at(place * size, 0.02, MaterialIndex::new(0))
                }
            });
            let mut engine = start(plan.with_particles(particles.collect()));
            let (mut seen, mut begun) = (BTreeSet::new(), 0);
            for _ in 0..200 {
                engine.step(RECORDS).unwrap();
                let found = recorded_at_walls(&engine);
                let expected = touching_walls(&engine);
                assert_eq!(found, expected, "{shape:?} in step {}", engine.steps());
                begun += expected.difference(&seen).count();
                seen.extend(expected);
            }
            assert!(begun > 20, "{shape:?}: {begun} contacts");
            assert!(
                engine.list_statistics().0 > 5,
                "the list was hardly ever rebuilt"
            );
        }
    }
}

/// A plate that rises twice as fast as a layer of particles sinks towards it, each with another gap. When it has gone its half of the skin,
/// the list is built anew, although the particles have gone a fourth of it only.
#[test]
fn a_list_lasts_no_longer_than_the_walls_half_of_its_skin() {
    let (radius, speed) = (0.01, 0.2);
    let up = |velocity: DVec3| Component::Translation {
        velocity,
        from: 0.0,
        until: f64::INFINITY,
    };
    let tilt = Component::Rotation {
        axis: DVec3::Y,
        origin: DVec3::ZERO,
        angular_velocity: -2.0 * speed,
        from: 0.0,
        until: f64::INFINITY,
    };
    let plane = || Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap());
    let disc = Shape::Disc(Disc::new(DVec3::Z, DVec3::ZERO, 2.0).unwrap());
    for (shape, motion) in [
        (plane(), up(2.0 * speed * DVec3::Z)),
        (disc, up(2.0 * speed * DVec3::Z)),
        // About one metre from the axis, where the particles are.
        (plane(), tilt),
    ] {
        let law = frictionless(AnyNormal::Linear(Linear::new(1e-3, 0.0)));
        let domain = (-2.0 * DVec3::ONE, 2.0 * DVec3::ONE);
        let mut plan = Draft::new(1e-5, domain, 1000.0, law);
        plan.walls
            .push(wall(shape.clone(), Motion::new(vec![motion]).unwrap()));
        let particles = (0..300u32).map(|k| {
            let place = dvec3(1.0, 0.021 * (f64::from(k % 20) - 10.0), 0.0)
                + DVec3::X * (0.021 * f64::from(k / 20));
            let gap = 1e-3 * radius * f64::from(k);
            NewParticle {
                velocity: -speed * DVec3::Z,
                ..NewParticle::at(
                    place + (radius + gap) * DVec3::Z,
                    radius,
                    MaterialIndex::new(0),
                )
            }
        });
        let mut engine = start(plan.with_particles(particles.collect()));
        let mut most = 0;
        for _ in 0..400 {
            engine.step(RECORDS).unwrap();
            let expected = touching_walls(&engine);
            assert_eq!(
                recorded_at_walls(&engine),
                expected,
                "{shape:?} in step {}",
                engine.steps()
            );
            most = most.max(expected.len());
        }
        assert!(most > 200, "{most}");
        assert!(
            engine.list_statistics().0 >= 3,
            "{:?}",
            engine.list_statistics()
        );
    }
}

/// How deep the deepest contact is counts by its smaller sphere, in either order of rows and ids.
#[test]
fn the_largest_overlap_is_a_part_of_the_smaller_radius() {
    let overlap = 1e-3;
    for [one, other] in [[0.05, 0.01], [0.01, 0.05]] {
        let law = frictionless(AnyNormal::Linear(Linear::new(1e-6, 0.0)));
        let mut plan = Draft::new(1e-6, (-DVec3::ONE, DVec3::ONE), 1000.0, law);
        plan.particles = [(0.0, one), (one + other - overlap, other)]
            .map(|(x, radius)| NewParticle::at(x * DVec3::X, radius, MaterialIndex::new(0)))
            .to_vec();
        let mut engine = start(plan);
        engine.step(RECORDS).unwrap();
        let found = engine.observation().largest_overlap;
        assert!((found - overlap / 0.01).abs() < 1e-12, "{found}");
    }
}
