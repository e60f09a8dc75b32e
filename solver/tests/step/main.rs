//! The engine as a whole: what it must not miss, and what must not change its numbers.

mod absent;
mod crowd;
mod funnels;
mod sheets;
mod sides;
mod spray;

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::scene::Files;
use mercury_engine::state::WallIndex;
use mercury_engine::state::{Id, MaterialIndex};
use mercury_solver::plan::parse_scene;

use mercury_engine::cell::Cell;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear};
use mercury_engine::forces::Watch;
use mercury_engine::step::{Engine, Snapshot};
use mercury_engine::walls::{
    Component, Mesh, Motion, Plane, Revolution, SavedWall, Shape, Side, SphereShell, Wall,
};
use mercury_solver::plan::{Draft, NewParticle, Plan, plan};

fn frictionless() -> AnyPairLaw {
    AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(1000.0, 0.0)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// Materials that never meet anything have no laws in the loop.
#[test]
fn a_sphere_alone_flies_on() {
    let text = r#"
        time = { end = 0.1, step = 1e-3 }
        domain = { min = [0, 0, 0], max = [1, 1, 1] }
        output = { interval = 0.1 }
        [materials.m]
        density = 2000.0
        normal = { law = "linear", stiffness = 200.0, restitution = 0.7 }
        [[particles]]
        material = "m"
        radius = 1e-2
        position = [0.1, 0.5, 0.5]
        velocity = [1.0, 0.0, 0.0]
    "#;
    let scene = parse_scene(Path::new("alone.toml"), text, &[], Files::Unchecked).unwrap();
    let mut engine = Engine::new(Arc::new(plan(&scene).unwrap()), 1).unwrap();
    engine.steps_at_once(100, None).unwrap();
    // Sums of a hundred steps.
    assert!((engine.particles.records[0].position.x - 0.2).abs() < 1e-14);
}

/// The named particle is no longer finite, and in a few digits: its speed is finite, but not the square of it.
#[test]
fn what_cannot_be_squared_is_named() {
    let mut plan = Draft::new(
        1e-6,
        (DVec3::splat(-1.0), DVec3::splat(1.0)),
        2000.0,
        frictionless(),
    );
    plan.particles = vec![
        NewParticle::at(DVec3::ZERO, 0.01, MaterialIndex::new(0)),
        NewParticle {
            velocity: dvec3(0.0, 1e200, 0.0),
            ..NewParticle::at(dvec3(0.5, 0.0, 0.0), 0.01, MaterialIndex::new(0))
        },
    ];
    let mut engine = Engine::new(Arc::new(plan.plan().unwrap()), 1).unwrap();
    let error = engine.step(None).unwrap_err().to_string();
    for part in ["particle 1 ", "velocity [0, 1e200, 0]", "help: "] {
        assert!(error.contains(part), "{part}: {error}");
    }
}

/// A moving wall, insertion, deletion, a prescribed particle that is deleted in the end, orientations, the energy budget.
fn busy() -> Arc<Plan> {
    let text = r#"
        gravity = [0, 0, -9.81]
        time = { end = 0.1, step = 2e-5 }
        domain = { min = [0, 0, 0], max = [0.03, 0.03, 0.03], periodic = ["y"] }
        output = { interval = 0.01, data = true, energy_budget = true }
        [materials.m]
        density = 2000.0
        normal = { law = "linear", stiffness = 200.0, restitution = 0.7 }
        tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
        [[walls]]
        name = "floor"
        shape = "plane"
        point = [0, 0, 0.005]
        normal = [0, 0, 1]
        material = "m"
        motion = [{ kind = "oscillation", amplitude = [0, 0, 1e-3], frequency = 50.0, phase_degrees = 0.0 }]
        [[insertions]]
        name = "feed"
        region = { shape = "box", min = [0.002, 0, 0.015], max = [0.028, 0.03, 0.028] }
        material = "m"
        psd = { kind = "uniform", min_diameter = 2e-3, max_diameter = 3e-3, weighting = "number" }
        total = { number = 150 }
        rate = { number = 5000.0 }
        velocity = { mean = [0, 0, -0.5], spread = [0.3, 0.3, 0.0] }
        [[deletions]]
        name = "out"
        region = { shape = "box", min = [0.022, 0, 0], max = [0.03, 0.03, 0.03] }
        [[particles]]
        material = "m"
        radius = 1e-3
        position = [0.018, 0.015, 0.02]
        prescribed = { velocity = [0.3, "free", "free"] }
    "#;
    let scene = parse_scene(Path::new("busy.toml"), text, &[], Files::Unchecked).unwrap();
    Arc::new(plan(&scene).unwrap())
}

#[test]
fn steps_at_once_are_the_steps_one_by_one() {
    let plan = busy();
    let mut single = Engine::new(Arc::clone(&plan), 1).unwrap();
    let mut looked_at = Engine::new(Arc::clone(&plan), 1).unwrap();
    let mut at_once = Engine::new(Arc::clone(&plan), 2).unwrap();
    for count in [1, 2, 7, 50, 400, 640, 900] {
        for _ in 0..count {
            single.step(None).unwrap();
            // Looking at every step makes its last half kick early, and must not change it.
            let watch = Watch {
                records: true,
                audit: None,
            };
            looked_at.step(Some(watch)).unwrap();
            looked_at.complete_step().unwrap();
        }
        at_once.steps_at_once(count, None).unwrap();
        assert_eq!(single.snapshot(), at_once.snapshot());
    }
    single.complete_step().unwrap();
    assert_eq!(single.snapshot(), looked_at.snapshot());
    // All of it happened.
    let boundaries = single.boundaries();
    assert!(boundaries.inserted().number > 50 && boundaries.removed().number > 1);
    assert!(single.particles.prescribed.is_empty());
    assert!(single.audit().losses.total() > 0.0);
}

#[test]
fn a_face_that_comes_into_reach_after_the_list_was_built_is_felt() {
    let angle = 5f64.to_radians();
    let (radius, height) = (0.05, 0.0495);
    let profile = [[0.0, 0.0], [1.0, 0.0], [2.0, angle.tan()], [2.0, 1.0]];
    let vessel = Revolution::new(DVec3::Z, DVec3::ZERO, &profile, Side::Inside).unwrap();
    let domain = (dvec3(-3.0, -3.0, -1.0), dvec3(3.0, 3.0, 2.0));
    let mut plan = Draft::new(1e-4, domain, 1000.0, frictionless());
    plan.walls.push(Wall {
        name: "vessel".to_owned(),
        material: MaterialIndex::new(0),
        shape: Shape::Revolution(vessel),
        motion: Motion::new(Vec::new()).unwrap(),
        from: 0.0,
        until: f64::INFINITY,
        reference: DVec3::ZERO,
    });
    // From where the centre begins to project onto the cone it touches both faces of the corner.
    let both = 1.0 - height * angle.tan();
    plan.particles.push(NewParticle {
        velocity: DVec3::X,
        ..NewParticle::at(
            dvec3(both - 1.5e-4, 0.0, height),
            radius,
            MaterialIndex::new(0),
        )
    });
    let mut engine = Engine::new(Arc::new(plan.plan().unwrap()), 1).unwrap();
    assert_eq!(engine.observation().wall_contacts, 1);
    let watch = Watch::default();
    engine.steps_at_once(2, Some(watch)).unwrap();
    assert_eq!(engine.list_statistics().0, 1, "the list is the first one");
    assert_eq!(engine.observation().wall_contacts, 2);
}

#[test]
fn a_periodic_domain_may_be_empty() {
    let domain = (DVec3::ZERO, DVec3::ONE);
    let mut plan = Draft::new(1e-3, domain, 1000.0, frictionless());
    plan.cell = plan.cell.with_periodic([true; 3]);
    let mut engine = Engine::new(Arc::new(plan.plan().unwrap()), 1).unwrap();
    engine.steps_at_once(3, None).unwrap();
    assert_eq!(engine.steps(), 3);
}

/// A plate on springs: five spheres on a floor of lattice sites, pressed by a servo that also swings sideways.
fn pressed(motion: &str) -> Arc<Plan> {
    let text = format!(
        r#"
        time = {{ end = 0.4, step = 2e-5 }}
        domain = {{ min = [0, 0, 0], max = [0.1, 0.1, 0.1] }}
        output = {{ interval = 0.01 }}
        [materials.m]
        density = 2000.0
        normal = {{ law = "linear", stiffness = 1000.0, restitution = 0.5 }}
        [[walls]]
        name = "floor"
        shape = "plane"
        point = [0, 0, 0]
        normal = [0, 0, 1]
        material = "m"
        [[walls]]
        name = "lid"
        shape = "plane"
        point = [0, 0, 0.0105]
        normal = [0, 0, -1]
        material = "m"
        motion = [{motion}]
        [[particles]]
        material = "m"
        radius = 5e-3
        lattice = {{ min = [0.02, 0.02, 0.005], max = [0.06, 0.06, 0.005], spacing = 0.02 }}
    "#
    );
    let scene = parse_scene(Path::new("press.toml"), &text, &[], Files::Unchecked).unwrap();
    Arc::new(plan(&scene).unwrap())
}

const PRESS: &str = r#"{ kind = "servo", axis = [0, 0, 2], force = -0.9, max_speed = 0.05 }"#;

#[test]
fn a_servo_reaches_its_force_at_the_overlap_of_the_springs_and_stays() {
    let mut engine = Engine::new(pressed(PRESS), 1).unwrap();
    let force = |engine: &Engine| engine.observation().walls[1].0.force.z;
    let mut largest = 0.0f64;
    for step in 0..20_000 {
        let before = engine.walls()[1].state.pose.translation.z;
        engine.step(Some(Watch::default())).unwrap();
        let state = &engine.walls()[1].state;
        let moved = state.pose.translation.z - before;
        // Never faster than it may, and the pose follows the velocity that contacts see.
        assert!(state.velocity.velocity.z.abs() <= 0.05);
        assert!((moved - state.velocity.velocity.z * 2e-5).abs() < 1e-16);
        if step == 100 {
            assert_eq!(state.velocity.velocity, dvec3(0.0, 0.0, -0.05));
        }
        largest = largest.max(force(&engine));
        if step >= 10_000 {
            assert!((force(&engine) - 0.9).abs() < 0.009, "{}", force(&engine));
        }
    }
    // The spheres are free: on its arrival the plate sets them in motion, yet it swings over by less than a tenth.
    assert!(largest < 0.99, "{largest}");
    // Nine spheres, each between two springs of 1000 N/m: F/9 = k d at either end.
    let overlap = 0.9 / 9.0 / 1000.0;
    let depth = -engine.walls()[1].state.pose.translation.z - 0.0005;
    assert!((depth - 2.0 * overlap).abs() < 1e-2 * overlap, "{depth}");
}

/// A lid that is turned by half a radian before its servo begins: it holds its force along the axis that was turned with it, not along the one
/// that the scene names, of which the force of a slanting plate has cos 0.5 only.
#[test]
fn a_servo_that_was_turned_holds_its_force_along_its_own_axis() {
    let normal = dvec3(libm::sin(0.5), 0.0, libm::cos(0.5));
    let (x, z) = (normal.x, normal.z);
    let ball = 5e-3 * normal;
    let text = format!(
        r#"
        time = {{ end = 0.4, step = 2e-5 }}
        domain = {{ min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }}
        output = {{ interval = 0.01 }}
        [materials.m]
        density = 2000.0
        normal = {{ law = "linear", stiffness = 1000.0, restitution = 0.5 }}
        [[walls]]
        name = "floor"
        shape = "plane"
        point = [0, 0, 0]
        normal = [{x}, 0, {z}]
        material = "m"
        [[walls]]
        name = "lid"
        shape = "plane"
        point = [0, 0, 0.0105]
        normal = [0, 0, -1]
        material = "m"
        motion = [
            {{ kind = "servo", axis = [0, 0, 1], force = -0.1, max_speed = 0.05, from = 0.02 }},
            {{ kind = "rotation", axis = [0, 1, 0], origin = [0, 0, 0], angular_velocity = 50.0, until = 0.01 }},
        ]
        [[particles]]
        material = "m"
        radius = 5e-3
        position = [{}, {}, {}]
    "#,
        ball.x, ball.y, ball.z
    );
    let scene = parse_scene(Path::new("turned.toml"), &text, &[], Files::Unchecked).unwrap();
    let mut engine = Engine::new(Arc::new(plan(&scene).unwrap()), 1).unwrap();
    engine
        .steps_at_once(20_000, Some(Watch::default()))
        .unwrap();
    let force = engine.observation().walls[1].0.force;
    // As above: within 1 % after many periods of the springs.
    assert!((force - 0.1 * normal).length() < 1e-3, "{force}");
    // And it went along that axis, to where the springs on both sides of the ball are pressed by F/k.
    let way = engine.walls()[1].state.pose.translation;
    let expected = -(5e-4 + 2.0 * 0.1 / 1000.0) * normal;
    assert!((way - expected).length() < 2e-6, "{way} and {expected}");
}

/// Two servos of one wall, one after the other, the second by a table: load, hold, unload. The springs give the way of the lid.
#[test]
fn stages_load_and_unload() {
    let stages = r#"{ kind = "servo", axis = [0, 0, 1], force = -0.9, max_speed = 0.05, until = 0.2 },
        { kind = "servo", axis = [0, 0, 2], force = [[0.2, -0.9], [0.3, -0.3]], max_speed = 0.05, from = 0.2 }"#;
    let plan = pressed(stages);
    let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
    let depth = |engine: &Engine| -engine.walls()[1].state.pose.translation.z - 5e-4;
    // As above: nine spheres, each between two springs.
    let expected = |force: f64| 2.0 * force / 9.0 / 1000.0;
    engine.steps_at_once(10_000, None).unwrap();
    assert!((depth(&engine) / expected(0.9) - 1.0).abs() < 1e-2);
    let saved = engine.snapshot();
    engine
        .steps_at_once(10_000, Some(Watch::default()))
        .unwrap();
    assert!((depth(&engine) / expected(0.3) - 1.0).abs() < 1e-2);
    let servos = &engine.walls()[1].servos;
    for (servo, force) in servos.iter().zip([-0.9, -0.3]) {
        assert!(servo.followed.is_near());
        let [actual, asked] = servo.followed.means().unwrap();
        assert!((actual - force).abs() < 0.01 * 0.9, "{actual}");
        // Of the ramp, which ended 5000 steps ago, exp(-5) of 0.6 N at most is left.
        assert!((asked - force).abs() < 0.6 * libm::exp(-5.0), "{asked}");
    }
    // To the same bits from between the stages.
    let mut back = Engine::restore(plan, saved, 2).unwrap();
    back.steps_at_once(10_000, Some(Watch::default())).unwrap();
    assert_eq!(back.snapshot(), engine.snapshot());
}

/// A pressure on the wall's own area is the force on it: the lid is a plane over a domain of 0.1 m x 0.1 m.
#[test]
fn a_pressure_acts_on_the_area() {
    let depth = |target: &str| {
        let motion =
            format!("{{ kind = \"servo\", axis = [0, 0, -1], {target}, max_speed = 0.05 }}");
        let mut engine = Engine::new(pressed(&motion), 1).unwrap();
        engine.steps_at_once(3_000, None).unwrap();
        engine.walls()[1].state.pose.translation.z
    };
    let by_force = depth("force = 0.9");
    assert!(by_force < -5e-4);
    for target in ["pressure = 90.0, area = 0.01", "pressure = \"90 Pa\""] {
        // Both agree up to the round-off of the area.
        assert!((depth(target) - by_force).abs() < 1e-12, "{target}");
    }
}

#[test]
fn a_servo_is_part_of_the_state() {
    let swing = r#", { kind = "oscillation", amplitude = [1e-3, 0, 1e-4], frequency = 30.0 }, { kind = "rotation", axis = [0, 0, 1], origin = [0.04, 0.04, 0], angular_velocity = 3.0 }"#;
    let plan = pressed(&format!("{PRESS}{swing}"));
    let mut one = Engine::new(Arc::clone(&plan), 1).unwrap();
    one.steps_at_once(900, None).unwrap();
    let mut back = Engine::restore(Arc::clone(&plan), one.snapshot(), 4).unwrap();
    let poses = |engine: &Engine| {
        let state = &engine.walls()[1].state;
        (state.pose, state.velocity)
    };
    assert_eq!(poses(&one), poses(&back));
    let mut others = [2, 4].map(|threads| Engine::new(Arc::clone(&plan), threads).unwrap());
    for other in &mut others {
        for _ in 0..9 {
            other.steps_at_once(100, Some(Watch::default())).unwrap();
        }
    }
    one.steps_at_once(1500, None).unwrap();
    back.steps_at_once(1500, None).unwrap();
    assert_eq!(one.snapshot(), back.snapshot());
    for mut other in others {
        other.steps_at_once(1500, None).unwrap();
        assert_eq!(one.snapshot(), other.snapshot());
    }
    assert!(one.walls()[1].servos[0].displacement < -4e-4);
}

/// A sheet of triangles under five spheres that bounce without loss, and the numbers of its corners' places.
fn trampoline(motion: Motion) -> Draft {
    let mut sheet = TriangleMesh::default();
    for j in 0..=4u32 {
        for i in 0..=4u32 {
            let [x, y] = [i, j].map(|k| 0.05 * f64::from(k) - 0.1);
            sheet.vertices.push(dvec3(x, y, 0.0));
            if i < 4 && j < 4 {
                let a = 5 * j + i;
                sheet
                    .triangles
                    .extend([[a, a + 1, a + 6], [a, a + 6, a + 5]]);
            }
        }
    }
    let mesh = Mesh::new(&sheet, |x| x, false).unwrap();
    let domain = (dvec3(-0.3, -0.3, -1.0), dvec3(0.3, 0.3, 1.0));
    let mut plan = Draft::new(2e-5, domain, 1000.0, frictionless());
    plan.walls.push(Wall {
        name: "sheet".to_owned(),
        material: MaterialIndex::new(0),
        shape: Shape::Mesh(Arc::new(mesh)),
        motion,
        from: 0.0,
        until: f64::INFINITY,
        reference: DVec3::ZERO,
    });
    for k in 0..5 {
        let place = dvec3(
            0.03 * f64::from(k) - 0.06,
            0.013 * f64::from(k) - 0.03,
            0.0102,
        );
        plan.particles
            .push(NewParticle::at(place, 0.01, MaterialIndex::new(0)));
    }
    plan.gravity = -9.81 * DVec3::Z;
    plan
}

/// Where the sheet is at a step, m.
fn lift(step: u64) -> f64 {
    0.02 * (1e-3 * step as f64).sin()
}

fn reshape_to(engine: &mut Engine, lift: f64) {
    let Shape::Mesh(mesh) = &engine.physics().walls[0].shape else {
        panic!("it is a mesh");
    };
    let places: Vec<DVec3> = mesh
        .corners()
        .iter()
        .map(|x| *x + lift * DVec3::Z)
        .collect();
    engine.reshape_wall(WallIndex::new(0), &places).unwrap();
}

/// A sheet whose corners are lifted pushes spheres as one that moves: by the same overlaps, found in time whatever list there is.
#[test]
fn a_mesh_that_is_reshaped_acts_like_one_that_moves() {
    let moved = Motion::new(vec![Component::Oscillation {
        amplitude: 0.02 * DVec3::Z,
        frequency: 1e-3 / 2e-5 / std::f64::consts::TAU,
        phase: 0.0,
        from: 0.0,
        until: f64::INFINITY,
    }]);
    let still = Motion::new(Vec::new()).unwrap();
    let mut reference =
        Engine::new(Arc::new(trampoline(moved.unwrap()).plan().unwrap()), 1).unwrap();
    let mut reshaped = Engine::new(Arc::new(trampoline(still).plan().unwrap()), 1).unwrap();
    let mut touched = 0;
    for step in 1..=4000 {
        reference.step(Some(Watch::default())).unwrap();
        reshape_to(&mut reshaped, lift(step));
        reshaped.step(Some(Watch::default())).unwrap();
        let [one, other] = [&reference, &reshaped].map(|engine| engine.observation().wall_contacts);
        assert_eq!(one, other, "step {step}");
        touched += one;
    }
    assert!(touched > 500, "{touched}");
    let places = |engine: &Engine| {
        let mut places: Vec<(Id, DVec3)> = (engine.particles.ids.iter().copied())
            .zip(
                engine
                    .particles
                    .records
                    .iter()
                    .map(|record| record.position),
            )
            .collect();
        places.sort_by_key(|place| place.0);
        places
    };
    for ((id, one), (_, other)) in places(&reference).into_iter().zip(places(&reshaped)) {
        assert!(one.distance(other) < 1e-10, "{id}: {one} {other}");
    }
    // The plan keeps its own sheet.
    let Shape::Mesh(mesh) = &reshaped.physics().walls[0].shape else {
        panic!("it is a mesh");
    };
    assert!(mesh.corners().iter().all(|x| x.z == 0.0));
}

#[test]
fn a_reshaped_mesh_is_part_of_the_state() {
    let plan = Arc::new(trampoline(Motion::new(Vec::new()).unwrap()).plan().unwrap());
    let mut one = Engine::new(Arc::clone(&plan), 1).unwrap();
    let shape = |of: &Snapshot| -> Vec<f64> {
        let walls: Vec<SavedWall> = of.sections().get("walls").unwrap();
        walls[0].shape.clone()
    };
    assert!(shape(&one.snapshot()).is_empty(), "it is the plan's");
    let advance_to = |engine: &mut Engine, until: u64| {
        while engine.steps() < until {
            let next = lift(engine.steps() + 1);
            reshape_to(engine, next);
            engine.step(None).unwrap();
        }
    };
    advance_to(&mut one, 700);
    let saved = one.snapshot();
    assert_eq!(shape(&saved).len(), 75);
    let saved = Snapshot::decode(&saved.encode()).unwrap();
    let mut back = Engine::restore(Arc::clone(&plan), saved.clone(), 2).unwrap();
    advance_to(&mut one, 1500);
    advance_to(&mut back, 1500);
    assert_eq!(one.snapshot(), back.snapshot());
    let cut = saved.edited("walls", |walls: &mut Vec<SavedWall>| {
        walls[0].shape.pop();
    });
    let error = Engine::restore(plan, cut.unwrap(), 1).err().unwrap();
    assert!(error.to_string().contains("walls.sheet: "), "{error}");
}

#[test]
fn a_state_in_another_cell_is_refused() {
    let plan = Arc::new(trampoline(Motion::new(Vec::new()).unwrap()).plan().unwrap());
    let saved = Engine::new(Arc::clone(&plan), 1).unwrap().snapshot();
    assert_eq!(saved.sections().get("cell"), Ok(plan.physics().cell));
    let other = saved.edited("cell", |cell: &mut Cell| {
        *cell = cell.with_periodic([true; 3])
    });
    let error = Engine::restore(plan, other.unwrap(), 1).err().unwrap();
    let text = error.to_string();
    assert!(
        text.contains("cell") && text.contains("[true, true, true]"),
        "{text}"
    );
}

#[test]
fn a_plane_that_is_exchanged_is_felt_at_once() {
    let mut plan = trampoline(Motion::new(Vec::new()).unwrap());
    let floor = |z: f64| Shape::Plane(Plane::new(z * DVec3::Z, DVec3::Z).unwrap());
    plan.walls[0].shape = floor(-0.5);
    let mut engine = Engine::new(Arc::new(plan.plan().unwrap()), 1).unwrap();
    engine.step(Some(Watch::default())).unwrap();
    assert_eq!(engine.observation().wall_contacts, 0);
    engine
        .exchange_wall(WallIndex::new(0), floor(0.0003))
        .unwrap();
    engine.step(Some(Watch::default())).unwrap();
    assert_eq!(engine.observation().wall_contacts, 5);
    let ball = Shape::Sphere(SphereShell::new(DVec3::ZERO, 1.0, Side::Inside).unwrap());
    let error = engine.exchange_wall(WallIndex::new(0), ball).unwrap_err();
    assert!(
        error.to_string().starts_with("walls.sheet: shape: "),
        "{error}"
    );
    assert!(engine.exchange_wall(WallIndex::new(7), floor(0.0)).is_err());
}
