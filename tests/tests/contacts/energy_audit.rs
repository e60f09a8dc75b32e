//! The energy audit closes to second order in the time step, whatever the law.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::table_head;
use mercury_common::random::Stream;
use mercury_common::scene::{Files, parse_scene};
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::{DeletionPlan, Region};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Hertz, Linear, LinearFriction, Luding,
    Mindlin, MindlinRescaled, NormalLaw as _, PairLaw, PlannedNormal as _, Plastic, Scale,
    SpringRotation,
};
use mercury_engine::state::{MaterialIndex, volume};
use mercury_engine::step::{Engine, Snapshot};
use mercury_engine::walls::{Component, Motion, Plane, Shape, Wall};
use mercury_solver::output::summary::EnergySummary;
use mercury_solver::plan::{Draft, NewBody, PrescribedMotion, plan as planned};
use mercury_solver::run::{RunOptions, run};
use mercury_tests::scenes::{advance, assert_every_law, held, plan, plane, sphere, start, wall};

const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2000.0;
const STIFFNESS: f64 = 1000.0;
/// Onto a wall, or of one sphere onto another, m/s.
const SPEED: f64 = 0.2;

fn mass() -> f64 {
    DENSITY * volume(RADIUS, 3)
}

/// Half a period of the linear spring, by which all laws here are of the same stiffness, s.
fn contact_time() -> f64 {
    std::f64::consts::PI * (mass() / STIFFNESS).sqrt()
}

fn laws() -> Vec<(&'static str, AnyPairLaw)> {
    let law = |normal, tangential, rolling| PairLaw {
        normal,
        tangential,
        rolling,
        adhesion: AnyAdhesion::None,
    };
    let linear = AnyNormal::Linear(Linear::with_damping_ratio(STIFFNESS, 0.2));
    let plastic = AnyNormal::Plastic(Plastic {
        loading_stiffness: 0.5 * STIFFNESS,
        unloading_stiffness: STIFFNESS,
        cohesion_stiffness: 0.1 * STIFFNESS,
        penetration_depth: 0.2,
        dissipation: 0.3,
        clamp_tension: false,
    });
    // Hertz' tangent stiffness 2 E* sqrt(R* overlap) is that of the spring at an overlap of a tenth of the radius.
    let modulus = 0.5 * STIFFNESS / (RADIUS * 0.1f64.sqrt());
    let hertz = AnyNormal::Hertz(Hertz::new(modulus, 0.5));
    let friction = |mu: f64| {
        AnyTangential::Linear(LinearFriction {
            stiffness: 2.0 / 7.0 * STIFFNESS,
            dissipation: 0.3,
            friction: mu,
            static_friction: mu,
            rotation: SpringRotation::Project,
            limits: Default::default(),
        })
    };
    let mindlin = |mu: f64| Mindlin::new(0.2 * modulus, 2.0 / 3.0, 0.4, mu, mu);
    let spring = FrictionSpring {
        stiffness: None,
        dissipation: 0.1,
        friction: 0.2,
        static_friction: 0.2,
    };
    let luding = AnyRolling::Luding(Luding {
        rolling: spring,
        torsion: spring,
        lever: 1.0,
        rotation: SpringRotation::Project,
    });
    let none = AnyRolling::None;
    let normal_laws = AnyNormal::examples(&Scale {
        stiffness: STIFFNESS,
        radius: RADIUS,
        mass: mass(),
    });
    let alone = normal_laws.into_iter();
    let mut laws: Vec<_> = alone
        .map(|normal| (normal.name(), law(normal, AnyTangential::None, none)))
        .collect();
    laws.extend([
        ("linear, slides", law(linear, friction(0.2), none)),
        ("linear, sticks", law(linear, friction(10.0), none)),
        ("plastic, slides", law(plastic, friction(0.2), none)),
        (
            "mindlin slides",
            law(hertz, AnyTangential::Mindlin(mindlin(0.2)), none),
        ),
        (
            "mindlin sticks",
            law(hertz, AnyTangential::Mindlin(mindlin(10.0)), none),
        ),
        (
            "mindlin rescaled",
            law(
                hertz,
                AnyTangential::MindlinRescaled(MindlinRescaled {
                    plain: mindlin(10.0),
                }),
                none,
            ),
        ),
        ("rolling", law(linear, friction(0.5), luding)),
        (
            "mindlin, rolling",
            law(hertz, AnyTangential::Mindlin(mindlin(0.5)), luding),
        ),
    ]);
    laws
}

/// The budget of six contact times in steps of 1/`steps` of one.
fn budget(mut plan: Draft, steps: u64) -> EnergySummary {
    let dt = contact_time() / steps as f64;
    plan.time_step = dt;
    plan.steps = 6 * steps;
    plan.prefix = "run".to_owned();
    plan.energy_budget = true;
    plan.output.interval = 6.0 * contact_time();
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions {
        folder: folder.path().to_owned(),
        ..RunOptions::default()
    };
    run(plan.plan().unwrap(), &options, &mut |_| ())
        .unwrap()
        .summary
        .energy
}

/// A sphere that falls askew and spinning onto a wall.
fn onto(law: AnyPairLaw, wall: Wall) -> Draft {
    let mut plan = plan(1.0, DENSITY, law);
    plan.gravity = dvec3(0.0, 0.0, -9.81);
    plan.walls.push(wall);
    plan.with_particles(vec![sphere(
        dvec3(0.02, 0.01, RADIUS * 1.0123),
        RADIUS,
        dvec3(0.15, 0.05, -SPEED),
        dvec3(5.0, -7.0, 9.0),
    )])
}

/// Two spheres that meet askew, so that the contact turns.
fn askew(law: AnyPairLaw) -> Draft {
    let ball = |side: f64| {
        sphere(
            dvec3(side * 1.01, side * 0.4, 0.1 * side) * RADIUS,
            RADIUS,
            side * dvec3(-0.5 * SPEED, 0.3 * SPEED, 0.0),
            dvec3(side * 5.0, 4.0, 20.0),
        )
    };
    plan(1.0, DENSITY, law).with_particles(vec![ball(-1.0), ball(1.0)])
}

fn moving(component: Component) -> Wall {
    let floor = Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap());
    wall(floor, Motion::new(vec![component]).unwrap())
}

fn shaking() -> Wall {
    moving(Component::Oscillation {
        amplitude: dvec3(0.1, 0.05, 0.2) * RADIUS,
        frequency: 0.2 / contact_time(),
        phase: 0.3,
        from: 0.0,
        until: f64::INFINITY,
    })
}

fn turning() -> Wall {
    moving(Component::Rotation {
        axis: DVec3::Z,
        origin: DVec3::ZERO,
        angular_velocity: 10.0,
        from: 0.0,
        until: f64::INFINITY,
    })
}

/// Contacts begin and end within a step, where the integrator misses up to k (v dt)^2/8 of the energy m v^2/2, (pi dt/t_c)^2/4 of it; the
/// trapezoidal rules miss as much along the way. Of first order is what a dashpot takes if its work is formed with velocities that are
/// not those of its force: with the damping here, 2 zeta pi dt/t_c of what it takes, forty times more at 200 steps.
fn closes(name: &str, scene: impl Fn() -> Draft) {
    for steps in [50, 100, 200, 400] {
        let energy = budget(scene(), steps);
        let error = energy.closure_error.unwrap();
        let allowed = 10.0 * (steps as f64).powi(-2);
        println!("{name}, {steps}: {error:.2e} of {allowed:.2e}");
        assert!(
            error.abs() < allowed,
            "{name}: {error:e} with {steps} steps"
        );
    }
    let energy = budget(scene(), 400);
    let lost = energy.dissipated.unwrap();
    assert!(lost.of("normal") > 0.0, "{name}: {lost:?}");
}

#[test]
fn every_law_is_audited() {
    assert_every_law(laws().into_iter().map(|(_, law)| law));
}

#[test]
fn on_a_wall() {
    for (name, law) in laws() {
        closes(name, || onto(law, plane(DVec3::ZERO, DVec3::Z)));
    }
}

#[test]
fn between_spheres() {
    for (name, law) in laws() {
        closes(name, || askew(law));
    }
}

/// The point of contact is farther from the centre of the larger one.
#[test]
fn between_unequal_spheres() {
    for (name, law) in laws() {
        closes(name, || {
            let mut plan = askew(law);
            let large = &mut plan.particles[1];
            large.radius *= 1.5;
            // As far apart as equal ones are.
            large.position *= 1.0 + 0.5 * RADIUS / large.position.length();
            plan
        });
    }
}

#[test]
fn on_walls_that_move() {
    for (name, law) in laws() {
        closes(name, || onto(law, shaking()));
        closes(name, || onto(law, turning()));
    }
}

/// A body of two pebbles, which falls askew onto a floor and turns between and in its contacts.
fn twin(law: AnyPairLaw) -> Draft {
    let pebbles = [-1.0, 1.0].map(|side| Pebble {
        position: DVec3::X * (side * RADIUS),
        radius: RADIUS,
    });
    let moments = dvec3(0.8, 2.8, 2.8) * (mass() * RADIUS * RADIUS);
    let material = MaterialIndex::new(0);
    let volume = 2.0 * volume(RADIUS, 3);
    let twin = Clump::new(
        "twin",
        material,
        pebbles.to_vec(),
        2.0 * mass(),
        volume,
        moments,
    )
    .unwrap();
    let mut body = NewBody::at(dvec3(0.02, 0.01, 1.6 * RADIUS), 0);
    body.orientation = glam::DQuat::from_rotation_y(0.6);
    body.velocity = dvec3(0.15, 0.05, -SPEED);
    body.angular_velocity = dvec3(3.0, 2.0, 8.0);
    let mut plan = plan(1.0, DENSITY, law);
    plan.gravity = dvec3(0.0, 0.0, -9.81);
    plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
    plan.with_bodies(vec![twin], vec![body])
}

#[test]
fn of_a_body() {
    for (name, law) in laws() {
        closes(name, || twin(law));
    }
}

/// Takes out what is in a region.
fn with_outlet(mut plan: Draft, region: Region) -> Draft {
    plan.deletions.push(DeletionPlan {
        name: "outlet".to_owned(),
        region,
    });
    plan
}

/// One of two spheres, a sphere on a wall and a body leave in the middle of a contact: what the contact stores then leaves with them.
#[test]
fn of_what_leaves_in_a_contact() {
    // Where the centre comes by in about the middle of the contact.
    let between = Region::Box {
        min: dvec3(-0.845, -1.0, -1.0) * RADIUS,
        max: RADIUS * dvec3(0.0, 1.0, 1.0),
    };
    let below = |height: f64| Region::HalfSpace {
        point: height * DVec3::Z,
        normal: -DVec3::Z,
    };
    let deep = RADIUS - 0.12 * SPEED * contact_time();
    for (name, law) in laws() {
        let scenes = [
            ("of two", with_outlet(askew(law), between.clone())),
            ("at a wall", with_outlet(onto(law, turning()), below(deep))),
            ("a body", with_outlet(twin(law), below(1.5 * RADIUS))),
        ];
        for (case, scene) in scenes {
            let name = format!("{name}, {case}");
            closes(&name, || scene.clone());
            let stored = budget(scene, 200).deleted_elastic.unwrap();
            let largest = 0.5 * mass() * SPEED * SPEED;
            println!("{name}: {stored:?} of {largest:.2e} J");
            assert!(stored.normal > 0.02 * largest, "{name}: {stored:?}");
        }
    }
}

/// A bed that falls between four walls onto a floor with a hole, into which some of it is pressed: a lattice of 75 with places shaken by 2 % of
/// the radius, two layers with a hundredth of the radius of overlap.
fn bed_with_a_hole(law: AnyPairLaw) -> Draft {
    let mut stream = Stream::new(1, "bed", 0);
    let mut balls = Vec::new();
    for layer in 0..3 {
        for place in 0..25 {
            let at = dvec3(
                f64::from(place % 5) - 2.0,
                f64::from(place / 5) - 2.0,
                f64::from(layer),
            );
            let mut jitter = || 0.02 * stream.uniform_in(-1.0, 1.0);
            let jitter = dvec3(jitter(), jitter(), jitter());
            balls.push(sphere(
                (1.98 * at + jitter + 1.05 * DVec3::Z) * RADIUS,
                RADIUS,
                -SPEED * DVec3::Z,
                DVec3::ZERO,
            ));
        }
    }
    let mut plan = plan(1.0, DENSITY, law);
    plan.gravity = dvec3(0.0, 0.0, -9.81);
    plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
    for side in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y] {
        plan.walls.push(plane(-4.96 * RADIUS * side, side));
    }
    let hole = Region::Box {
        min: dvec3(-1.5, -1.5, 0.0) * RADIUS,
        max: dvec3(5.0, 1.5, 0.97) * RADIUS,
    };
    with_outlet(plan.with_particles(balls), hole)
}

/// The closure falls by about four with half the step, as it does without a hole.
#[test]
fn of_a_bed_with_a_hole() {
    for (name, law) in laws() {
        let errors = [50, 100, 200, 400].map(|steps| {
            let energy = budget(bed_with_a_hole(law), steps);
            let left = energy.deleted_elastic.unwrap();
            // It would show in the closure.
            let others = [energy.kinetic, energy.elastic, energy.deleted.unwrap()];
            assert!(
                left.normal > 5e-3 * others.iter().sum::<f64>(),
                "{name}: {left:?}"
            );
            energy.closure_error.unwrap().abs()
        });
        println!("{name}: {errors:?}");
        assert!(errors[3] < 10.0 / (400.0 * 400.0), "{name}: {errors:?}");
        for pair in errors.windows(2) {
            // A fourth, but for the steps in which single contacts begin and end.
            assert!(pair[1] < 0.35 * pair[0], "{name}: {errors:?}");
        }
    }
}

/// A floor that vanishes under what rests on it takes along what their contact stored.
#[test]
fn of_a_wall_that_vanishes() {
    for (name, law) in laws() {
        let scene = || {
            let mut plan = onto(law, plane(DVec3::ZERO, DVec3::Z));
            plan.walls[0].until = 0.35 * contact_time();
            plan
        };
        closes(name, scene);
        let vanished = budget(scene(), 200).vanished_walls.unwrap();
        let largest = 0.5 * mass() * SPEED * SPEED;
        assert!(vanished > 0.02 * largest, "{name}: {vanished} J");
    }
}

/// Grains that come with a velocity and leave below, without meeting anything: in free fall nothing is lost, and what they bring and take is
/// right to (g dt/v)^2. With velocities half a step older than the places it would be g dt/v.
#[test]
fn of_grains_that_come_and_go() {
    let closure = |step: f64| {
        let text = format!(
            r#"
            gravity = [0, 0, -10]
            time = {{ end = 0.4, step = {step:e} }}
            domain = {{ min = [0, 0, 0], max = [1, 1, 1] }}
            output = {{ interval = 0.1, energy_budget = true }}
            [materials.m]
            density = 2000.0
            normal = {{ law = "linear", stiffness = 1000.0, restitution = 0.7 }}
            [[insertions]]
            region = {{ shape = "box", min = [0, 0, 0.8], max = [1, 1, 1] }}
            material = "m"
            psd = {{ kind = "monodisperse", diameter = 0.02 }}
            total = {{ number = 20 }}
            rate = {{ number = 100.0 }}
            velocity = {{ mean = [0, 0, -2] }}
            "#
        );
        let path = Path::new("scene.toml");
        let scene = parse_scene(path, &text, &[], Files::Unchecked).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let options = RunOptions {
            folder: folder.path().to_owned(),
            ..RunOptions::default()
        };
        let report = run(planned(&scene).unwrap(), &options, &mut |_| ()).unwrap();
        let summary = report.summary;
        assert_eq!(summary.inserted, 20);
        assert!((1..20).contains(&summary.deleted), "{}", summary.deleted);
        summary.energy.closure_error.unwrap().abs()
    };
    let [one, half] = [1e-3, 5e-4].map(closure);
    println!("{one:e}, {half:e}");
    assert!(one < 1e-4 / 4.0 && half < 0.3 * one, "{one:e}, {half:e}");
}

/// Runs a scene, and gives the columns of `.budget.csv` beside the summary.
fn budget_file(text: &str) -> (BTreeMap<String, Vec<Option<f64>>>, EnergySummary) {
    let scene = parse_scene(Path::new("scene.toml"), text, &[], Files::Unchecked).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions {
        folder: folder.path().to_owned(),
        ..RunOptions::default()
    };
    let report = run(planned(&scene).unwrap(), &options, &mut |_| ()).unwrap();
    assert!(report.files.contains(&"scene.budget.csv".to_owned()));
    let table = std::fs::read_to_string(folder.path().join("scene.budget.csv")).unwrap();
    let mut lines = table.lines();
    let head = lines.next().unwrap().split(',');
    let names: Vec<&str> = head.map(table_head::name).collect();
    let mut columns: BTreeMap<String, Vec<Option<f64>>> = BTreeMap::new();
    for line in lines {
        let words: Vec<&str> = line.split(',').collect();
        assert_eq!(words.len(), names.len(), "{line}");
        for (name, word) in names.iter().zip(words) {
            let number = (!word.is_empty()).then(|| word.parse().unwrap());
            columns.entry((*name).to_owned()).or_default().push(number);
        }
    }
    (columns, report.summary.energy)
}

/// Grains fall onto a floor that vibrates, roll and leave through a hole in it, while a lid is pressed down: at every output time the row has all terms,
/// and they close. The last row is that of the summary.
#[test]
fn every_row_of_the_file_closes() {
    let text = r#"
        gravity = [0, 0, -10]
        seed = 3
        time = { end = 0.3, step = 1e-5 }
        domain = { min = [0, 0, 0], max = [0.1, 0.1, 0.15] }
        output = { interval = 0.01, energy_budget = true, pictures = false }
        [materials.m]
        density = 2000.0
        normal = { law = "linear", stiffness = 2000.0, restitution = 0.6 }
        tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.4 }
        rolling = { law = "luding", friction = 0.1, dissipation = 0.01 }
        [[walls]]
        name = "sides"
        shape = "box"
        sides = ["-x", "+x", "-y", "+y"]
        material = "m"
        [[walls]]
        name = "floor"
        shape = "plane"
        point = [0, 0, 0.03]
        normal = [0, 0, 1]
        material = "m"
        until = 0.25
        motion = [{ kind = "oscillation", amplitude = [0, 0, 0.0005], frequency = 60.0 }]
        [[walls]]
        name = "lid"
        shape = "plane"
        point = [0, 0, 0.14]
        normal = [0, 0, -1]
        material = "m"
        motion = [{ kind = "servo", axis = [0, 0, 1], force = -1.0, max_speed = 0.5, from = 0.1 }]
        [[insertions]]
        region = { shape = "box", min = [0, 0, 0.06], max = [0.1, 0.1, 0.13] }
        material = "m"
        psd = { kind = "monodisperse", diameter = 0.012 }
        total = { number = 120 }
        rate = { number = 2000.0 }
        [[deletions]]
        name = "outlet"
        region = { shape = "half-space", point = [0, 0, 0.02], normal = [0, 0, -1] }
    "#;
    let (columns, summary) = budget_file(text);
    let column = |name: &str| -> Vec<f64> {
        let values = columns[name].iter();
        values.map(|value| value.unwrap()).collect()
    };
    let times = column("time");
    assert_eq!(times.len(), 31);
    let mechanisms = ["normal", "tangential", "rolling", "liquid"];
    let given = [("wall_work", 1.0), ("inserted", 1.0)];
    let taken = ["deleted", "vanished_walls"];
    let stored = ["kinetic", "rotational", "gravitational", "elastic"];
    let mut left = vec![0.0; times.len()];
    let terms = (given
        .into_iter()
        .map(|(name, sign)| (name.to_owned(), sign)))
    .chain(taken.map(|name| (name.to_owned(), -1.0)))
    .chain(mechanisms.map(|name| (format!("dissipated_{name}"), -1.0)))
    .chain(stored.map(|name| (name.to_owned(), -1.0)));
    for (name, sign) in terms {
        for (sum, value) in left.iter_mut().zip(column(&name)) {
            *sum += sign * value;
        }
    }
    let first = -left[0];
    let closure = column("closure");
    for (row, error) in column("error").iter().enumerate() {
        // Round-off of a dozen sums of energies of some mJ.
        assert!((left[row] + first - error).abs() < 1e-15, "row {row}");
        // Of second order: a few (dt/t_c)^2 with contacts of 1.7 ms, for each of a dozen impacts one behind the other.
        assert!(closure[row].abs() < 5e-4, "row {row}: {}", closure[row]);
    }
    for name in ["normal", "tangential", "rolling"] {
        let lost = column(&format!("dissipated_{name}"));
        assert!(lost[30] > 0.0, "{name}");
    }
    // Dissipated energy never returns.
    let normal = column("dissipated_normal");
    assert!(normal.windows(2).all(|pair| pair[1] >= pair[0]));
    let last = |name: &str| column(name)[30];
    let lost = summary.dissipated.unwrap();
    for (found, expected) in [
        ("kinetic", summary.kinetic),
        ("rotational", summary.rotational),
        ("gravitational", summary.gravitational),
        ("elastic", summary.elastic),
        ("dissipated_normal", lost.of("normal")),
        ("dissipated_tangential", lost.of("tangential")),
        ("dissipated_rolling", lost.of("rolling")),
        ("dissipated_liquid", lost.of("liquid")),
        ("wall_work", summary.wall_work.unwrap()),
        ("servo_work", summary.servo_work.unwrap()),
        ("inserted", summary.inserted.unwrap()),
        ("deleted", summary.deleted.unwrap()),
        ("deleted_elastic", summary.deleted_elastic.unwrap().total()),
        ("vanished_walls", summary.vanished_walls.unwrap()),
        ("closure", summary.closure_error.unwrap()),
    ] {
        assert_eq!(last(found), expected, "{found}");
    }
    for name in ["servo_work", "deleted", "vanished_walls"] {
        assert!(last(name) != 0.0, "{name}");
    }
}

/// One ball is hit by a plate of given speed V, another one is pushed by a servo, without gravity and loss. The first is then 2 V fast, so that the plate
/// did the work m (2 V)^2 / 2; the rest is that of the servo, which is what the second ball has.
#[test]
fn the_work_of_servos_is_told_apart() {
    let text = r#"
        time = { end = 0.05, step = 1e-5 }
        domain = { min = [0, 0, 0], max = [0.1, 0.1, 0.3] }
        output = { interval = 0.01, energy_budget = true, pictures = false }
        [materials.m]
        density = 2000.0
        normal = { law = "linear", stiffness = 1000.0, restitution = 1.0 }
        [[walls]]
        name = "plate"
        shape = "disc"
        origin = [0.02, 0.05, 0.009]
        axis = [0, 0, 1]
        radius = 0.015
        material = "m"
        motion = [{ kind = "translation", velocity = [0, 0, 0.2] }]
        [[walls]]
        name = "ram"
        shape = "disc"
        origin = [0.07, 0.05, 0.009]
        axis = [0, 0, 1]
        radius = 0.015
        material = "m"
        motion = [{ kind = "servo", axis = [0, 0, 1], force = 0.2, max_speed = 0.3 }]
        [[particles]]
        material = "m"
        radius = 0.01
        position = [0.02, 0.05, 0.02]
        [[particles]]
        material = "m"
        radius = 0.01
        position = [0.07, 0.05, 0.02]
    "#;
    let (columns, summary) = budget_file(text);
    let (work, servos) = (summary.wall_work.unwrap(), summary.servo_work.unwrap());
    let expected = 0.5 * mass() * 0.4 * 0.4;
    // (dt/t_c)^2 = 4e-7 with contacts of 9 ms, some times over.
    assert!(
        (work - servos - expected).abs() < 1e-5 * expected,
        "{work} - {servos} J, expected {expected} J"
    );
    assert!(servos > 1e-3 * expected, "{servos}");
    let total = summary.kinetic + summary.elastic;
    assert!((total - work).abs() < 1e-4 * total, "{total} {work}");
    assert!(columns["closure"].iter().all(Option::is_some));
}

/// Work on what is prescribed is not measured: the terms are there, the closure is left empty.
#[test]
fn where_work_is_not_measured_the_closure_is_empty() {
    let text = r#"
        time = { end = 0.02, step = 1e-5 }
        domain = { min = [0, 0, 0], max = [0.1, 0.1, 0.1] }
        output = { interval = 0.01, energy_budget = true, pictures = false }
        [materials.m]
        density = 2000.0
        normal = { law = "linear", stiffness = 1000.0, restitution = 0.5 }
        [[particles]]
        material = "m"
        radius = 0.01
        position = [0.05, 0.05, 0.03]
        prescribed = { velocity = [0, 0, 0.5] }
        [[particles]]
        material = "m"
        radius = 0.01
        position = [0.05, 0.05, 0.0501]
    "#;
    let (columns, summary) = budget_file(text);
    assert_eq!(summary.closure_error, None);
    for name in ["error", "closure"] {
        assert!(columns[name].iter().all(Option::is_none), "{name}");
    }
    assert!(columns["dissipated_normal"][2].unwrap() > 0.0);
}

/// An audit that is interrupted after every step goes on to the same bits.
#[test]
fn goes_on_from_a_snapshot() {
    for (name, law) in laws() {
        let begun = || {
            let mut plan = bed_with_a_hole(law);
            plan.time_step = contact_time() / 25.0;
            plan.energy_budget = true;
            start(plan)
        };
        let (mut whole, mut pieces) = (begun(), begun());
        for _ in 0..100 {
            whole.step(None).unwrap();
            pieces.step(None).unwrap();
            let state = Snapshot::decode(&pieces.snapshot().encode()).unwrap();
            pieces = Engine::restore(pieces.setup(), state, 1).unwrap();
        }
        assert!(whole.audit().left.total() > 0.0, "{name}");
        assert_eq!(whole.audit(), pieces.audit(), "{name}");
    }
}

/// A ball that grazes another which is moved and turned in a given way: what is lost between them is the same where the other one is a body of one pebble,
/// which has the same mass, moments and motion.
#[test]
fn at_a_body_that_moves_as_prescribed() {
    let (own, radius) = (mass(), RADIUS);
    let (velocity, spin) = (dvec3(0.05, 0.02, 0.0), dvec3(1.0, 0.0, 6.0));
    for (name, law) in laws() {
        let audit = |is_body: bool| {
            let place = dvec3(0.8 * radius, 0.1 * radius, 1.9 * radius);
            let falls = sphere(place, radius, -SPEED * DVec3::Z, dvec3(0.0, 4.0, 0.0));
            let other = sphere(DVec3::ZERO, radius, velocity, spin);
            let mut plan = plan(contact_time() / 200.0, DENSITY, law);
            plan.gravity = dvec3(0.0, 0.0, -9.81);
            plan.energy_budget = true;
            let plan = if is_body {
                let pebble = Pebble {
                    position: DVec3::ZERO,
                    radius,
                };
                let moments = DVec3::splat(0.4 * own * radius * radius);
                let material = MaterialIndex::new(0);
                let volume = volume(radius, 3);
                let ball = Clump::new("ball", material, vec![pebble], own, volume, moments);
                let body = NewBody {
                    velocity,
                    angular_velocity: spin,
                    prescribed_velocity: velocity.to_array().map(Some),
                    prescribed_angular_velocity: spin.to_array().map(Some),
                    ..NewBody::at(DVec3::ZERO, 0)
                };
                plan.with_particles(vec![falls])
                    .with_bodies(vec![ball.unwrap()], vec![body])
            } else {
                plan.with_particles(vec![falls, held(other)])
            };
            let mut engine = start(plan);
            advance(&mut engine, 600);
            let losses = engine.audit().losses;
            ["normal", "tangential", "rolling"].map(|name| losses.of(name))
        };
        let (of_ball, of_body) = (audit(false), audit(true));
        let all: f64 = of_ball.iter().map(|part| part.abs()).sum();
        for (one, other) in of_ball.iter().zip(of_body) {
            assert!(
                (one - other).abs() < 1e-9 * (all + own * SPEED * SPEED),
                "{name}: {of_ball:?} J, of a body {of_body:?} J"
            );
        }
    }
}

/// A ball that is held in the middle of a floor's dent, so that its load stays as it is, and swings about its own axis on the damped spring of
/// rolling, or of torsion: I w' = -l^2 (k a + gamma w), a the angle. The loss in the audit is that of the closed form.
#[test]
fn of_a_damped_rolling_spring_in_closed_form() {
    let (stiffness, zeta, spin) = (400.0, 0.1, 3.0);
    let inertia = 0.4 * mass() * RADIUS * RADIUS;
    let frequency = (stiffness * RADIUS * RADIUS / inertia).sqrt();
    let dissipation = 2.0 * zeta * (stiffness * inertia).sqrt() / RADIUS;
    let overlap = 0.02 * RADIUS;
    // The springs' own stiffness, and that of a contact which does not slide: 8 G* sqrt(R overlap).
    let modulus = stiffness / (8.0 * (RADIUS * overlap).sqrt());
    for own in [Some(stiffness), None] {
        for axis in [DVec3::X, DVec3::Z] {
            let spring = FrictionSpring {
                stiffness: own,
                dissipation,
                friction: 1e6,
                static_friction: 1e6,
            };
            let tangential = match own {
                Some(_) => AnyTangential::None,
                // Without friction: it lends its stiffness.
                None => AnyTangential::Mindlin(Mindlin::new(modulus, 1.0, 0.0, 0.0, 0.0)),
            };
            let law = PairLaw {
                normal: AnyNormal::Linear(Linear::new(STIFFNESS, 0.0)),
                tangential,
                rolling: AnyRolling::Luding(Luding {
                    rolling: spring,
                    torsion: spring,
                    lever: 1.0,
                    rotation: SpringRotation::Project,
                }),
                adhesion: AnyAdhesion::None,
            };
            let mut plan = plan(1e-4 / frequency, DENSITY, law);
            plan.energy_budget = true;
            plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
            let mut ball = sphere(
                (RADIUS - overlap) * DVec3::Z,
                RADIUS,
                DVec3::ZERO,
                spin * axis,
            );
            ball.prescribed = PrescribedMotion::boxed([Some(0.0); 3], [None; 3]);
            let mut engine = start(plan.with_particles(vec![ball]));
            let start = 0.5 * inertia * spin * spin;
            for part in [0.3, 1.0, 3.0] {
                let time = part * std::f64::consts::TAU / frequency;
                let steps = (time / engine.physics().time_step).round() as u64;
                let made = engine.steps();
                advance(&mut engine, steps - made);
                // a = (w0/w_d) exp(-zeta w t) sin(w_d t).
                let (decay, damped) = (zeta * frequency, frequency * (1.0 - zeta * zeta).sqrt());
                let (sine, cosine) = (damped * time).sin_cos();
                let swing = spin * (-decay * time).exp();
                let angle = swing / damped * sine;
                let speed = swing * (cosine - decay / damped * sine);
                let left =
                    0.5 * inertia * speed * speed + 0.5 * stiffness * (RADIUS * angle).powi(2);
                let (lost, expected) = (engine.audit().losses.of("rolling"), start - left);
                // The dashpot sees the speed of half a step before, which changes frequency and damping by zeta w dt each: within 1e-4 of
                // the energy for each radian.
                let allowed = 1e-5 * (1.0 + frequency * time);
                assert!(
                    (lost - expected).abs() < allowed * start,
                    "{own:?}, {axis}: {lost} and {expected} of {start} J at {part}"
                );
            }
        }
    }
}
