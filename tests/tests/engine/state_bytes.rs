//! The state of every example scene, written as bytes and read back, goes on to the same bytes.
//!
//! Every scene under `scenes/` takes part by itself, so that a new feature with an example cannot be forgotten.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::forces::{Needs, Watch, contact_loop};
use mercury_engine::state::{Pieces, Plain, WallIndex};
use mercury_engine::step::{Core, Engine, NewShape, Part, RunError, Snapshot, StartOptions};
use mercury_engine::walls::Shape;
use mercury_solver::plan::{Guard, GuardPolicy, Plan, plan, read_scene};
use mercury_tests::scenes::{advance, frictionless, sphere, start};
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use proptest::test_runner::{Config, TestRunner};

/// The scenes that run as they stand.
pub(super) fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut files = Vec::new();
    for folder in ["", "clumps", "bench"] {
        let entries = std::fs::read_dir(root.join(folder)).expect("the folder can be listed");
        files.extend(entries.map(|entry| entry.expect("the folder can be listed").path()));
    }
    let is_scene = |path: &PathBuf| {
        let name = path.to_string_lossy();
        name.ends_with(".toml") && !name.ends_with(".clump.toml") && !name.ends_with("keys.toml")
    };
    files.retain(is_scene);
    files.sort();
    files
}

pub(super) fn planned(path: &Path) -> Arc<Plan> {
    let scene = read_scene(path, &[]).expect("an example scene is whole");
    Arc::new(plan(&scene).expect("an example scene can be planned"))
}

/// Goes on from `engine` and from its decoded state for `steps` steps; they must stay equal to the byte.
fn goes_on(engine: &mut Engine, threads: usize, steps: u64) -> Result<(), TestCaseError> {
    let bytes = engine.snapshot().encode();
    let decoded =
        Snapshot::decode(&bytes).map_err(|error| TestCaseError::fail(error.to_string()))?;
    prop_assert!(
        decoded.encode() == bytes,
        "decoded and encoded again: other bytes"
    );
    let before = decoded.clone();
    // With the laws of the plan handed in as laws from outside are: these stay when a state is restored in place.
    let laws = contact_loop(&engine.physics().laws);
    let options = StartOptions::threads(threads).contacts(laws);
    let mut other =
        Engine::resume(engine.setup(), decoded, options).expect("the state fits its plan");
    prop_assert!(
        other.snapshot().encode() == bytes,
        "restored and encoded: other bytes"
    );
    for engine in [&mut *engine, &mut other] {
        engine
            .steps_at_once(steps, Some(Watch::default()))
            .expect("the scene goes on");
    }
    let after = engine.snapshot();
    prop_assert!(
        other.snapshot().encode() == after.encode(),
        "other bytes after {steps} steps"
    );
    // Back, and on again, in place.
    other.restore_in_place(&before).expect("it is of this plan");
    prop_assert!(
        other.snapshot() == before,
        "restored in place and encoded: other bytes"
    );
    other
        .steps_at_once(steps, Some(Watch::default()))
        .expect("the scene goes on");
    prop_assert!(
        other.snapshot() == after,
        "other bytes after {steps} steps from a state restored in place"
    );
    Ok(())
}

#[test]
fn every_example_scene_goes_on_from_its_bytes() {
    let scenes = scenes();
    assert!(scenes.len() > 15, "the example scenes are found");
    for path in scenes {
        let mut engine = Engine::new(planned(&path), 1).expect("an example scene starts");
        // Some hundred thousand particle-steps each.
        let most = (200_000 / engine.particles.len().max(1) as u64).clamp(4, 2000);
        let case = (0..=most, 1usize..=3, 1..=most / 2);
        // One engine goes through all the cases, so that later ones begin amid the run.
        let mut runner = TestRunner::deterministic();
        for _ in 0..3 {
            let (before, threads, after) = case.new_tree(&mut runner).expect("drawn").current();
            engine
                .steps_at_once(before.max(1), None)
                .expect("the scene goes on");
            if let Err(error) = goes_on(&mut engine, threads, after) {
                panic!(
                    "{}: after {before} steps, {threads} threads: {error}",
                    path.display()
                );
            }
        }
    }
}

/// Counts of the guard are part of the state: the final report of a resumed run includes all of them.
#[test]
fn counts_of_the_guard_go_on() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/two-spheres.toml");
    let mut draft = planned(&path).draft();
    // Limits far below what the collision of the scene comes to.
    draft.guard = Guard {
        policy: GuardPolicy::Warn,
        overlap: 1e-6,
        way: 1e-6,
    };
    let mut engine = Engine::new(Arc::new(draft.plan().unwrap()), 1).unwrap();
    while engine.guard_warnings().len() < 2 {
        engine.step(None).expect("the scene goes on");
    }
    let (reported, steps) = (engine.guard_warnings(), engine.steps());
    let state = engine.snapshot();
    let mut other = Engine::restore(engine.setup(), state, 1).unwrap();
    assert_eq!(other.guard_warnings(), reported);
    engine.steps_at_once(10, None).unwrap();
    other.steps_at_once(10, None).unwrap();
    assert_eq!(other.guard_warnings(), engine.guard_warnings());
    assert_ne!(
        reported,
        engine.guard_warnings(),
        "nothing to count after step {steps}"
    );
}

/// Losses so far are part of the state, and so are the values that the audit needs for the mean of two steps.
#[test]
fn the_energy_budget_goes_on() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/two-spheres.toml");
    let mut draft = planned(&path).draft();
    draft.energy_budget = true;
    let mut engine = Engine::new(Arc::new(draft.plan().unwrap()), 1).unwrap();
    // Amid the collision, which takes 0.02 s.
    engine.steps_at_once(200, None).expect("the scene goes on");
    assert!(engine.audit().losses.total() > 0.0);
    if let Err(error) = goes_on(&mut engine, 2, 150) {
        panic!("{error}");
    }
}

#[test]
fn damaged_states_are_named_and_never_taken() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/clumps/t-bar.toml");
    let mut engine = Engine::new(planned(&path), 1).expect("an example scene starts");
    engine.steps_at_once(50, None).expect("the scene goes on");
    let bytes = engine.snapshot().encode();
    let setup = engine.setup();
    // A cut between two sections, or another name of one, is found when the engine looks for the section.
    let is_refused = |bytes: &[u8]| match Snapshot::decode(bytes) {
        Ok(state) => Engine::restore(setup.clone(), state, 1).is_err(),
        Err(_) => true,
    };
    let config = Config::with_cases(300);
    TestRunner::new(config)
        .run(&(0..bytes.len(), 1u8..=255), |(place, change)| {
            prop_assert!(is_refused(&bytes[..place]), "cut at {place}");
            let mut damaged = bytes.clone();
            damaged[place] ^= change;
            prop_assert!(is_refused(&damaged), "changed at {place}");
            Ok(())
        })
        .expect("no damage passes");
}

#[test]
fn a_state_of_another_plan_is_refused_in_words() {
    let scene = |name: &str| {
        planned(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}.toml")))
    };
    let refused = |state: &Snapshot, plan: Arc<Plan>| match Engine::restore(plan, state.clone(), 1)
    {
        Err(RunError::OtherState { reason, .. }) => reason,
        _ => panic!("a state of another plan is taken"),
    };
    let engine = Engine::new(scene("bench/dense-2k"), 1).expect("an example scene starts");
    let state = engine.snapshot();
    assert!(Engine::restore(scene("bench/dense-2k"), state.clone(), 1).is_ok());
    let reason = refused(&state, scene("two-spheres"));
    assert!(reason.contains("that of the plan [-2, -2, -2]"), "{reason}");
    let mut draft = scene("bench/dense-2k").draft();
    draft.walls.truncate(2);
    let reason = refused(&state, Arc::new(draft.plan().unwrap()));
    assert!(reason.contains("walls, the plan"), "{reason}");
    // A scene with these walls, and laws that remember nothing.
    let mut draft = scene("bench/dense-2k").draft();
    draft.laws = scene("bench/dense-20k-frictionless").physics().laws.clone();
    let reason = refused(&state, Arc::new(draft.plan().unwrap()));
    assert!(reason.contains("remember"), "{reason}");
}

/// Gravity between all pairs, F = k m m / d^2, counted: a force across any gap that comes after the contacts.
struct Attraction {
    strength: f64,
    evaluations: u64,
}

impl Part for Attraction {
    fn name(&self) -> &str {
        "attraction"
    }

    fn needs(&self) -> Needs {
        Needs {
            after_contacts: true,
            ..Needs::default()
        }
    }

    fn add_loads(&mut self, core: &mut Core) {
        self.evaluations += 1;
        let particles = &mut core.particles;
        // By ids: the sums must not depend on the order of the rows.
        let rows = particles.rows_by_id();
        for (k, &a) in rows.iter().enumerate() {
            for &b in &rows[k + 1..] {
                let (a, b) = (a as usize, b as usize);
                let branch = particles.records[b].position - particles.records[a].position;
                let masses = particles.masses[a] * particles.masses[b];
                let force = branch * (self.strength * masses / branch.length().powi(3));
                particles.loads[a].force += force;
                particles.loads[b].force -= force;
            }
        }
    }

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        self.evaluations.put(pieces.end());
    }

    fn take(&mut self, _: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        self.evaluations = u64::take(bytes)?;
        Ok(())
    }
}

fn attraction() -> Vec<Box<dyn Part>> {
    vec![Box::new(Attraction {
        strength: 1e-2,
        evaluations: 0,
    })]
}

/// Moves a mesh by its corners at a steady velocity, m/s: a wall that changes its shape, not its place.
struct Lift {
    velocity: DVec3,
    corners: Vec<DVec3>,
    /// Whether contacts see that velocity.
    is_seen: bool,
}

impl Part for Lift {
    fn name(&self) -> &str {
        "lift"
    }

    fn needs(&self) -> Needs {
        Needs {
            reshapes_walls: true,
            ..Needs::default()
        }
    }

    fn reshape_walls(&mut self, core: &Core) -> Vec<NewShape> {
        let lifted = |corner: &DVec3| *corner + self.velocity * core.time();
        let seen = if self.is_seen { self.corners.len() } else { 0 };
        vec![NewShape {
            wall: WallIndex::new(0),
            corners: self.corners.iter().map(lifted).collect(),
            velocities: vec![self.velocity; seen],
        }]
    }
}

/// A plate below a ball, with `laws` of their contact and further `keys` of the plate, and the corners of the plate.
fn plate_and_ball(laws: &str, keys: &str) -> (Arc<Plan>, Vec<DVec3>) {
    let text = format!(
        r#"
        time = {{ end = 1.0, step = 1e-4 }}
        domain = {{ min = [-1, -1, -1], max = [1, 1, 1] }}
        output = {{ interval = 1.0 }}
        [materials.m]
        density = 1000.0
        {laws}
        [[walls]]
        name = "plate"
        shape = "mesh"
        file = "plate.stl"
        material = "m"
        {keys}
        [[particles]]
        material = "m"
        radius = 0.01
        position = [0.51, 0.48, 0.0]
        "#,
    );
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let files = mercury_common::scene::Files::MustExist;
    let scene = mercury_common::scene::parse_scene(&scenes.join("lift.toml"), &text, &[], files)
        .expect("the scene is whole");
    let plan = plan(&scene).expect("the scene can be planned");
    let corners = match &plan.physics().walls[0].shape {
        Shape::Mesh(mesh) => mesh.corners().to_vec(),
        _ => panic!("the plate is a mesh"),
    };
    // The ball lies just above the plate.
    let tops = corners.iter().map(|corner| corner.z);
    let mut draft = plan.draft();
    draft.particles[0].position.z = tops.fold(f64::NEG_INFINITY, f64::max) + 0.0101;
    (Arc::new(draft.plan().unwrap()), corners)
}

/// Stiffness in N/m by which the ball of [`plate_and_ball`] oscillates with 200 steps a period.
fn soft() -> f64 {
    let omega = 2.0 * std::f64::consts::PI / (200.0 * 1e-4);
    omega * omega * 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6
}

/// A plate that rises at v by its corners meets a ball at rest: in the plate's frame the ball comes at v, and an elastic spring
/// sends it away at v, so it ends at 2 v. Verlet with 2 pi/(w dt) = 200 steps a period keeps the energy of a spring to (w dt)^2/8
/// = 1.2e-4 of it, of which the speed has half; the end of the contact, found to a step, adds up to (w dt)^2/2 = 5e-4.
#[test]
fn a_wall_that_changes_its_shape_is_felt_and_is_part_of_the_state() {
    let laws = format!(
        "normal = {{ law = \"linear\", stiffness = {}, restitution = 1.0 }}",
        soft()
    );
    let (plan, corners) = plate_and_ball(&laws, "");
    let speed = 0.05;
    let lift = || -> Vec<Box<dyn Part>> {
        vec![Box::new(Lift {
            velocity: DVec3::Z * speed,
            corners: corners.clone(),
            is_seen: false,
        })]
    };
    let mut engine = Engine::start(Arc::clone(&plan), StartOptions::threads(1).parts(lift()))
        .expect("it starts");
    // 2 ms to meet, half a period of 20 ms in touch; this is in the midst of it.
    engine.steps_at_once(70, None).expect("it goes on");
    let state = Snapshot::decode(&engine.snapshot().encode()).expect("a whole state");
    let mut other = Engine::resume(
        Arc::clone(&plan),
        state,
        StartOptions::threads(2).parts(lift()),
    )
    .expect("it goes on");
    for engine in [&mut engine, &mut other] {
        engine.steps_at_once(200, None).expect("it goes on");
        let velocity = engine.particles.records[0].velocity;
        assert!(
            (velocity.z / (2.0 * speed) - 1.0).abs() < 6e-4,
            "{velocity}"
        );
    }
    assert!(engine.snapshot().encode() == other.snapshot().encode());
}

/// A plate whose corners move acts on a ball as one that moves as a whole with their velocity, damping, friction and rolling of the ball with
/// it, and the wall does the same work: to round-off, 300 steps long. Without their velocities it does not.
#[test]
fn contacts_see_the_velocity_of_a_wall_that_changes_its_shape() {
    let laws = format!(
        "normal = {{ law = \"linear\", stiffness = {}, restitution = 0.5 }}\n\
         tangential = {{ law = \"linear\", stiffness_ratio = 0.3, friction = 0.4 }}",
        soft()
    );
    let velocity = DVec3::new(0.03, -0.01, 0.05);
    let motion = "motion = [{ kind = \"translation\", velocity = [0.03, -0.01, 0.05] }]";
    let (moved, corners) = plate_and_ball(&laws, motion);
    let (still, _) = plate_and_ball(&laws, "");
    let bounce = |plan: &Arc<Plan>, parts: Vec<Box<dyn Part>>| {
        let options = StartOptions::threads(1).parts(parts);
        let mut engine = Engine::start(Arc::clone(plan), options).expect("it starts");
        let mut work = 0.0;
        for _ in 0..300 {
            engine.step(Some(Watch::default())).expect("it goes on");
            work += engine.observation().walls[0].1 * 1e-4;
        }
        let ball = engine.particles.records[0];
        (ball.velocity, ball.angular_velocity, work)
    };
    let lift = |is_seen: bool| -> Vec<Box<dyn Part>> {
        let corners = corners.clone();
        vec![Box::new(Lift {
            velocity,
            corners,
            is_seen,
        })]
    };
    let (linear, angular, work) = bounce(&moved, Vec::new());
    let (by_corners, turning, same) = bounce(&still, lift(true));
    assert!(
        linear.z > 0.06 && angular.y.abs() > 0.1 && work > 1e-6,
        "{linear} {angular} {work}"
    );
    assert!(linear.distance(by_corners) < 1e-10, "{linear} {by_corners}");
    assert!(angular.distance(turning) < 1e-8, "{angular} {turning}");
    assert!((work / same - 1.0).abs() < 1e-8, "{work} {same}");
    let (blind, ..) = bounce(&still, lift(false));
    assert!(linear.distance(blind) > 1e-3, "{blind}");
}

/// Two spheres of 1 kg, 2 m apart, that fall around each other on a circle: w^2 = k M / d^3 for the sum M of the masses.
fn pair() -> Arc<Plan> {
    let text = r#"
        time = { end = 1.0, step = 0.01 }
        domain = { min = [-3, -3, -3], max = [3, 3, 3] }
        output = { interval = 1.0 }
        [materials.m]
        density = 1.909859317102744
        normal = { law = "linear", stiffness = 1000.0, restitution = 0.7 }
        [[particles]]
        material = "m"
        radius = 0.5
        position = [-1, 0, 0]
        velocity = [0, -0.05, 0]
        [[particles]]
        material = "m"
        radius = 0.5
        position = [1, 0, 0]
        velocity = [0, 0.05, 0]
    "#;
    let files = mercury_common::scene::Files::Unchecked;
    let scene = mercury_common::scene::parse_scene(Path::new("pair.toml"), text, &[], files)
        .expect("the scene is whole");
    Arc::new(plan(&scene).expect("the scene can be planned"))
}

#[test]
fn a_force_beside_the_contacts_acts_in_every_step_and_is_part_of_the_state() {
    // v^2/r = k m/d^2 with r = 1, d = 2, v = 0.05: k = 0.01.
    let plan = pair();
    let mut engine = Engine::start(
        Arc::clone(&plan),
        StartOptions::threads(1).parts(attraction()),
    )
    .unwrap();
    // A quarter of a turn: T/4 = pi r/(2 v) = 31.4 s. Verlet on a circle is off by (w dt)^2/24 per radian turned: 1e-8.
    let steps = (0.5 * std::f64::consts::PI / 0.05 / 0.01).round() as u64;
    engine.steps_at_once(steps / 2, None).unwrap();
    let bytes = engine.snapshot().encode();
    let state = Snapshot::decode(&bytes).unwrap();
    let mut other = Engine::resume(
        Arc::clone(&plan),
        state.clone(),
        StartOptions::threads(2).parts(attraction()),
    )
    .unwrap();
    for engine in [&mut engine, &mut other] {
        engine.steps_at_once(steps - steps / 2, None).unwrap();
        let row = engine.particles.rows_by_id()[1] as usize;
        let place = engine.particles.records[row].position;
        // The whole number of steps misses the quarter by half a step at most: 0.05 m/s for 0.005 s.
        assert!(
            (place - glam::DVec3::Y).length() < 0.05 * 0.005 + 1e-6,
            "{place}"
        );
    }
    assert_eq!(engine.snapshot().encode(), other.snapshot().encode());
    // Without the force, or under another name, the state is refused.
    let Err(RunError::OtherState { reason, .. }) = Engine::restore(plan, state, 1) else {
        panic!("a state with another force is taken");
    };
    assert!(reason.contains("attraction"), "{reason}");
}

/// The counts of the guard are the same after a restart as without one: how often, and the worst of it with its step, place and
/// partner.
#[test]
fn what_the_guard_has_counted_is_reported_after_a_restart() {
    let law = frictionless(AnyNormal::Linear(Linear::new(1e3, 0.0)));
    let mut draft = mercury_tests::scenes::plan(1e-4, 1000.0, law);
    draft.guard = Guard {
        policy: GuardPolicy::Warn,
        overlap: 0.1,
        way: 0.2,
    };
    // A third of a radius in a step, and, far from it, two that lie in each other by 0.3 radii.
    let balls = [(0.0, 33.0), (1.0, 0.0), (1.017, 0.0)];
    let balls = balls.map(|(x, speed)| sphere(x * DVec3::X, 0.01, speed * DVec3::Y, DVec3::ZERO));
    let mut engine = start(draft.with_particles(balls.to_vec()));
    advance(&mut engine, 5);
    let warnings = engine.guard_warnings();
    assert_eq!(warnings.len(), 2, "{warnings:#?}");
    let decoded = Snapshot::decode(&engine.snapshot().encode()).unwrap();
    let restored = Engine::restore(engine.setup(), decoded, 1).unwrap();
    assert_eq!(restored.guard_warnings(), warnings);
}
