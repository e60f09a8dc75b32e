//! Loads on the triangles of mesh walls: they add up to the load of the wall, and sliding dissipates by Coulomb's law.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::frames::{TriangleLoadFrame, TriangleLoadReader, WallReader};
use mercury_common::random::Stream;
use mercury_common::surfaces::Surface;
use mercury_engine::bodies::Clump;
use mercury_engine::contact::normal::hertz_damping;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Hertz, Linear,
    LinearFriction, Mindlin, PairLaw, SpringRotation,
};
use mercury_engine::forces::{LoadSums, Watch, block_size, contact_loop};
use mercury_engine::state::{Decoder, Encoder, MaterialIndex, volume};
use mercury_engine::step::{Engine, Snapshot, StartOptions};
use mercury_engine::walls::{Component, Mesh, Motion, Shape, Wall};
use mercury_solver::plan::{Draft, NewBody, NewParticle, PrescribedMotion};
use mercury_solver::run::{RunOptions, run};
use mercury_tests::scenes::{add_material, plan, wall};

const RADIUS: f64 = 0.005;
const DENSITY: f64 = 2500.0;
const GRAVITY: f64 = 9.81;
const FRICTION: f64 = 0.4;

fn weight() -> f64 {
    DENSITY * volume(RADIUS, 3) * GRAVITY
}

/// A square of side `edge` (m) about the origin at z = 0, cut into `2 cells^2` triangles that are no two alike.
fn floor(edge: f64, cells: u32) -> TriangleMesh {
    let mut random = Stream::new(11, "floor", 0);
    let mut mesh = TriangleMesh::default();
    for j in 0..=cells {
        for i in 0..=cells {
            let mut along = |k: u32| {
                let inside = k > 0 && k < cells;
                let shift = if inside {
                    0.6 * (random.uniform() - 0.5)
                } else {
                    0.0
                };
                ((f64::from(k) + shift) / f64::from(cells) - 0.5) * edge
            };
            mesh.vertices.push(dvec3(along(i), along(j), 0.0));
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = j * (cells + 1) + i;
            let (b, c, d) = (a + 1, a + cells + 2, a + cells + 1);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn mesh_wall(triangles: &TriangleMesh, motion: Motion) -> Wall {
    let mesh = Mesh::new(triangles, |x| x, false).unwrap();
    wall(Shape::Mesh(Arc::new(mesh)), motion)
}

/// A spring of 1000 N/m, and one of 2/7 of that with friction.
fn linear(dissipation: f64) -> AnyPairLaw {
    PairLaw {
        normal: AnyNormal::Linear(Linear::new(1000.0, dissipation)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 2.0 / 7.0 * 1000.0,
            dissipation: 0.0,
            friction: FRICTION,
            static_friction: FRICTION,
            rotation: SpringRotation::default(),
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// A plan whose loads on triangles are summed up.
fn loaded(mut plan: Draft) -> Draft {
    plan.gravity = -GRAVITY * DVec3::Z;
    plan.output.frames = true;
    plan.output.triangle_loads = true;
    plan
}

fn engine(plan: Draft) -> Engine {
    Engine::new(Arc::new(plan.plan().unwrap()), 1).unwrap()
}

fn advance(engine: &mut Engine, steps: u64) {
    engine.steps_at_once(steps, None).unwrap();
}

fn take(engine: &mut Engine) -> LoadSums {
    let [frame, vtk] = engine.take_load_sums(true, true);
    assert_eq!(vtk, None, "no files for ParaView are planned");
    frame.unwrap()
}

/// Mean normal force (N), mean force (N) and mean power of sliding (W) on the whole wall.
fn totals(sums: &LoadSums, time_step: f64) -> (f64, DVec3, f64) {
    let each = 1.0 / sums.evaluations as f64;
    let normal: f64 = sums.loads.values().map(|load| load.normal).sum();
    let force: DVec3 = sums.loads.values().map(|load| load.force).sum();
    let slip: f64 = sums.loads.values().map(|load| load.slip).sum();
    (normal * each, force * each, slip * each / time_step)
}

/// Three balls side by side that are one body.
fn tripod() -> Clump {
    let pebble = |x: f64, y: f64| Pebble {
        position: dvec3(x, y, 0.0) * RADIUS,
        radius: RADIUS,
    };
    let pebbles = vec![pebble(-1.5, -1.0), pebble(1.7, -0.8), pebble(-0.2, 1.8)];
    let volume = 3.0 * volume(RADIUS, 3);
    let moments = DVec3::splat(DENSITY * volume * RADIUS * RADIUS);
    Clump::new(
        "tripod",
        MaterialIndex::new(0),
        pebbles,
        DENSITY * volume,
        volume,
        moments,
    )
    .unwrap()
}

#[test]
fn a_ball_at_rest_lays_its_weight_on_the_triangles() {
    let overlap = weight() / 1000.0;
    for place in [dvec3(0.0, 0.0, 0.0), dvec3(0.0031, -0.0017, 0.0)] {
        let mut plan = loaded(plan(1e-4, DENSITY, linear(0.0)));
        plan.walls
            .push(mesh_wall(&floor(0.04, 6), Motion::default()));
        let ball = NewParticle::at(
            place + (RADIUS - overlap) * DVec3::Z,
            RADIUS,
            MaterialIndex::new(0),
        );
        let mut engine = engine(plan.with_particles(vec![ball]));
        let start = take(&mut engine);
        assert_eq!(start.evaluations, 1, "the start is one evaluation");
        advance(&mut engine, 100);
        let sums = take(&mut engine);
        assert_eq!(sums.evaluations, 100);
        for sums in [start, sums] {
            let (normal, force, slip) = totals(&sums, 1e-4);
            // Round-off of a centre at 5 mm beside an overlap of 13 micrometres.
            assert!((normal / weight() - 1.0).abs() < 1e-11, "{normal}");
            assert!((force + weight() * DVec3::Z).length() < 1e-11 * weight());
            assert_eq!(slip, 0.0);
        }
        // No load is left to be counted twice.
        advance(&mut engine, 1);
        assert_eq!(take(&mut engine).evaluations, 1);
    }
}

/// mu N v on what slides steadily, whatever triangles it passes.
#[test]
fn a_sliding_ball_and_a_sliding_body_dissipate_what_coulomb_says() {
    let (speed, dt) = (0.2, 1e-4);
    let overlap = weight() / 1000.0;
    let height = (RADIUS - overlap) * DVec3::Z;
    let motion = |velocity: DVec3| {
        let slide = Component::Translation {
            velocity,
            from: 0.0,
            until: f64::INFINITY,
        };
        Motion::new(vec![slide]).unwrap()
    };
    // A ball that may only move up and down, on a floor at rest or on one that slides away under it.
    for (of_ball, of_floor) in [(speed, 0.0), (0.5 * speed, -0.5 * speed)] {
        let mut plan = loaded(plan(dt, DENSITY, linear(0.0)));
        plan.walls
            .push(mesh_wall(&floor(0.1, 30), motion(of_floor * DVec3::X)));
        let ball = NewParticle {
            velocity: of_ball * DVec3::X,
            prescribed: PrescribedMotion::boxed([Some(of_ball), Some(0.0), None], [Some(0.0); 3]),
            ..NewParticle::at(height - 0.02 * DVec3::X, RADIUS, MaterialIndex::new(0))
        };
        let mut engine = engine(plan.with_particles(vec![ball]));
        // The spring is stretched to mu N = 2/7 k x within mu overlap 7/2 = 18 micrometres: one step.
        advance(&mut engine, 10);
        take(&mut engine);
        advance(&mut engine, 1500);
        let sums = take(&mut engine);
        let (normal, force, slip) = totals(&sums, dt);
        assert!((normal / weight() - 1.0).abs() < 1e-9, "{normal}");
        let expected = FRICTION * weight() * speed;
        assert!((slip / expected - 1.0).abs() < 1e-9, "{slip} {expected}");
        let pushed = force - weight() * dvec3(FRICTION, 0.0, -1.0);
        assert!(pushed.length() < 1e-9 * weight(), "{force}");
        // It has passed 30 mm of cells of 3.3 mm: at least nine of them.
        assert!(sums.loads.len() > 9);
    }
    // A body of three balls that slows down by mu g: the mean power is mu N times the mean speed.
    let mut plan = loaded(plan(dt, DENSITY, linear(0.0)));
    plan.walls
        .push(mesh_wall(&floor(0.1, 30), Motion::default()));
    let body = NewBody {
        velocity: 0.4 * DVec3::X,
        prescribed_angular_velocity: [Some(0.0); 3],
        ..NewBody::at(height - 0.02 * DVec3::X, 0)
    };
    let mut engine = engine(plan.with_bodies(vec![tripod()], vec![body]));
    advance(&mut engine, 10);
    take(&mut engine);
    let speed = |engine: &Engine| engine.particles.bodies()[0].velocity.x;
    engine.complete_step().unwrap();
    let before = speed(&engine);
    advance(&mut engine, 600);
    engine.complete_step().unwrap();
    let after = speed(&engine);
    let (normal, _, slip) = totals(&take(&mut engine), dt);
    let expected = FRICTION * 3.0 * weight() * 0.5 * (before + after);
    assert!((before - after - FRICTION * GRAVITY * 0.06).abs() < 1e-9);
    assert!((normal / (3.0 * weight()) - 1.0).abs() < 1e-9, "{normal}");
    // The mean over steps is that over time to half a step of slowing down.
    let limit = 0.5 * FRICTION * GRAVITY * dt / after;
    assert!((slip / expected - 1.0).abs() < limit, "{slip} {expected}");
}

/// Balls of two materials thrown onto a floor that turns and shakes, far from each other or not.
fn thrown(apart: bool, moves: Vec<Component>) -> Draft {
    let law = PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(2e6, hertz_damping(0.6))),
        tangential: AnyTangential::Mindlin(Mindlin::new(6e5, 2.0 / 3.0, 0.1, 0.4, 0.4)),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let mut plan = loaded(plan(2e-5, DENSITY, law));
    let other = add_material(&mut plan, 2.0 * DENSITY);
    plan.walls
        .push(mesh_wall(&floor(0.2, 20), Motion::new(moves).unwrap()));
    let mut random = Stream::new(5, "thrown", 0);
    let spacing = if apart { 4.0 } else { 2.02 };
    let balls = (0..64u32).map(|k| {
        let mut draw = || random.uniform() - 0.5;
        let place = dvec3(f64::from(k % 8) - 3.5, f64::from(k / 8) - 3.5, 0.0) * spacing;
        NewParticle {
            velocity: dvec3(draw(), draw(), draw() - 0.6),
            angular_velocity: dvec3(draw(), draw(), draw()) * 100.0,
            ..NewParticle::at(
                (place + 1.01 * DVec3::Z) * RADIUS,
                RADIUS,
                MaterialIndex::new(k % 2 * other),
            )
        }
    });
    plan.with_particles(balls.collect())
}

fn shaking() -> Component {
    Component::Oscillation {
        amplitude: dvec3(0.001, 0.0, 0.001),
        frequency: 40.0,
        phase: 0.0,
        from: 0.0,
        until: f64::INFINITY,
    }
}

fn turning() -> Component {
    Component::Rotation {
        axis: DVec3::Z,
        origin: DVec3::ZERO,
        angular_velocity: 8.0,
        from: 0.0,
        until: f64::INFINITY,
    }
}

/// The mean over any number of steps is the mean of what the wall feels, and sliding is what the audit of the energy counts, to the order of the step.
#[test]
fn means_are_those_of_the_whole_wall() {
    let mut plan = thrown(true, vec![shaking()]);
    plan.energy_budget = true;
    let dt = plan.time_step;
    let mut engine = engine(plan);
    take(&mut engine);
    let audited = engine.audit().losses.of("tangential");
    let (mut force, mut slip, mut slip_of_parts) = (DVec3::ZERO, 0.0, 0.0);
    for steps in [1u64, 7, 300] {
        let mut felt = DVec3::ZERO;
        for _ in 0..steps {
            engine.step(Some(Watch::default())).unwrap();
            felt += engine.observation().walls[0].0.force;
        }
        let sums = take(&mut engine);
        assert_eq!(sums.evaluations, steps);
        let totals = totals(&sums, dt);
        let mean = felt / steps as f64;
        assert!(
            (totals.1 - mean).length() <= 1e-13 * mean.length(),
            "{totals:?}"
        );
        force += mean.abs();
        slip_of_parts += totals.2 * dt * steps as f64;
        slip = engine.audit().losses.of("tangential") - audited;
    }
    // Balls far apart touch the floor only.
    assert_eq!(engine.observation().particle_contacts, 0);
    assert!(force.cmpgt(DVec3::ZERO).all() && slip > 0.0);
    // The audit counts velocities, and what springs store, at the time of the forces, triangles half a step before: friction stops the slip here
    // within a tenth of the contact, ten steps.
    let apart = slip_of_parts / slip - 1.0;
    assert!(apart.abs() < 0.1, "{apart}");
}

fn run_in(folder: &Path, mut plan: Draft, steps: u64, interval: f64, threads: usize) {
    plan.prefix = "run".to_owned();
    plan.steps = steps;
    plan.output.walls = true;
    plan.output.interval = interval;
    (plan.output.rows_interval, plan.output.vtk_interval) = (interval, interval);
    let options = RunOptions {
        folder: folder.to_owned(),
        threads,
        ..RunOptions::default()
    };
    run(plan.plan().unwrap(), &options, &mut |_| ()).unwrap();
}

fn frames(folder: &Path) -> Vec<TriangleLoadFrame> {
    let reader = TriangleLoadReader::open(folder.join("run.triangle_loads.arrow")).unwrap();
    (0..reader.frames().len())
        .map(|k| reader.frame(k).unwrap())
        .collect()
}

/// Written in every step: the forces on the triangles of a wall that moves and turns add up to its row of `.walls.csv`, and
/// pressure and shear times the area are those forces.
#[test]
fn triangles_add_up_to_the_rows_of_walls_csv() {
    let folder = tempfile::tempdir().unwrap();
    let plan = thrown(false, vec![turning(), shaking()]);
    let dt = plan.time_step;
    run_in(folder.path(), plan, 200, dt, 2);
    let text = std::fs::read_to_string(folder.path().join("run.walls.csv")).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|field| field.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    let frames = frames(folder.path());
    assert_eq!((frames.len(), rows.len()), (201, 201));
    let walls = WallReader::open(folder.path().join("run.walls.arrow")).unwrap();
    let Surface::Mesh(mesh) = &walls.surfaces()[0] else {
        panic!("a mesh")
    };
    let mut touched = 0;
    for (k, (frame, row)) in frames.iter().zip(&rows).enumerate() {
        assert_eq!(frame.time, row[0]);
        let felt = dvec3(row[2], row[3], row[4]);
        let sum: DVec3 = frame.force.iter().sum();
        let size: f64 = frame.force.iter().map(|force| force.length()).sum();
        assert!((sum - felt).length() <= 1e-13 * size, "{sum} {felt}");
        let pose = walls.frame(k).unwrap().placement[0];
        for (at, &triangle) in frame.triangle.iter().enumerate() {
            let [a, b, c] = mesh.corners(triangle as usize);
            let area = 0.5 * (b - a).cross(c - a).length();
            // The floor is flat, so normal forces are along its normal, and forces are those of triangles under a ball.
            let normal = pose.rotation * DVec3::Z;
            // Where a contact has just ended there is no force any more, and what it dissipated last.
            let whole = (frame.shear[at] - normal * frame.pressure[at]) * area;
            assert!((whole - frame.force[at]).length() <= 1e-12 * size);
            touched += 1;
        }
        assert!(frame.triangle.is_sorted());
    }
    assert!(touched > 1000, "{touched}");
}

/// More particles than one block holds, on a floor: the same bytes for any number of threads.
#[test]
fn threads_change_no_byte() {
    let many = || {
        let mut plan = thrown(false, vec![shaking()]);
        plan.walls.clear();
        plan.walls.push(mesh_wall(
            &floor(1.2, 30),
            Motion::new(vec![shaking()]).unwrap(),
        ));
        let balls: Vec<NewParticle> = (0..3000u32)
            .map(|k| {
                let place = dvec3(f64::from(k % 50) - 24.5, f64::from(k / 50) - 29.5, 0.5) * 2.01;
                NewParticle {
                    velocity: dvec3(0.3, 0.1 * f64::from(k % 7), -0.5),
                    ..NewParticle::at(place * RADIUS, RADIUS, MaterialIndex::new(0))
                }
            })
            .collect();
        assert!(balls.len() > 2 * block_size(balls.len()));
        plan.output.vtk = true;
        plan.with_particles(balls)
    };
    let runs = [1, 2, 4].map(|threads| {
        let folder = tempfile::tempdir().unwrap();
        run_in(folder.path(), many(), 120, 1e-3, threads);
        folder
    });
    let bytes =
        |folder: &tempfile::TempDir, file: &str| std::fs::read(folder.path().join(file)).unwrap();
    for file in ["run.triangle_loads.arrow", "vtk/run.walls.0002.vtu"] {
        let first = bytes(&runs[0], file);
        assert!(runs.iter().all(|run| bytes(run, file) == first), "{file}");
    }
    // While they press: in the end dashpots pull, which makes no friction.
    let rubs = |frame: &TriangleLoadFrame| {
        frame.triangle.len() > 100 && frame.slip_power.iter().sum::<f64>() > 0.0
    };
    assert!(frames(runs[0].path()).iter().any(rubs));
}

/// A ball that is held on the ridge of a roof presses on an edge: each of the two triangles there reports half of it, a corner's
/// share goes to all that meet in it.
#[test]
fn what_comes_through_an_edge_or_corner_is_shared_out_evenly() {
    let overlap = 1e-5;
    // A roof of two triangles under a ridge along y, and a pyramid of four.
    let corners = |points: &[[f64; 3]]| points.iter().map(|&x| DVec3::from(x) * 0.02).collect();
    let roof = TriangleMesh {
        vertices: corners(&[
            [0.0, -1.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, -1.0],
            [1.0, 0.0, -1.0],
        ]),
        triangles: vec![[0, 1, 2], [0, 3, 1]],
        ..TriangleMesh::default()
    };
    let pyramid = TriangleMesh {
        vertices: corners(&[
            [0.0, 0.0, 0.0],
            [1.0, 1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, -1.0],
            [1.0, -1.0, -1.0],
        ]),
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
        ..TriangleMesh::default()
    };
    for (mesh, shares) in [(roof, 2), (pyramid, 4)] {
        let mut plan = loaded(plan(1e-5, DENSITY, linear(0.0)));
        plan.walls.push(mesh_wall(&mesh, Motion::default()));
        let ball = NewParticle {
            prescribed: PrescribedMotion::boxed([Some(0.0); 3], [Some(0.0); 3]),
            ..NewParticle::at((RADIUS - overlap) * DVec3::Z, RADIUS, MaterialIndex::new(0))
        };
        let folder = tempfile::tempdir().unwrap();
        run_in(folder.path(), plan.with_particles(vec![ball]), 20, 1e-4, 1);
        let frames = frames(folder.path());
        let frame = frames.last().unwrap();
        assert_eq!(frame.triangle.len(), shares);
        for k in 0..shares {
            let [a, b, c] = mesh.corners(frame.triangle[k] as usize);
            let area = 0.5 * (b - a).cross(c - a).length();
            let each = 1000.0 * overlap / shares as f64;
            // The overlap is what 5 mm leave of 4.99: to 1e-18 m.
            assert!(
                (frame.force[k] + each * DVec3::Z).length() < 1e-11 * each,
                "{frame:?}"
            );
            assert!(
                (frame.pressure[k] * area / each - 1.0).abs() < 1e-11,
                "{frame:?}"
            );
        }
    }
}

/// Frames and files for ParaView that fall due together, and apart: each series sums up all since its own last one.
#[test]
fn each_series_has_its_own_sums_when_both_are_due() {
    // The sums of frames every `frames` steps and of files every `vtk` steps.
    let sums = |frames: u64, vtk: u64| {
        let mut plan = thrown(false, vec![turning(), shaking()]);
        plan.output.vtk = true;
        let mut engine = engine(plan);
        let (mut of_frames, mut of_files) = (Vec::new(), Vec::new());
        for step in 1..=240 {
            engine.step(None).unwrap();
            let due = (step % frames == 0, step % vtk == 0);
            let [frame, file] = engine.take_load_sums(due.0, due.1);
            assert_eq!((frame.is_some(), file.is_some()), due);
            of_frames.extend(frame);
            of_files.extend(file);
        }
        (of_frames, of_files)
    };
    let (together, frames_between, files_between) = (sums(40, 40), sums(20, 40), sums(40, 20));
    for (one, other) in [
        (&together.0, &together.1),
        (&together.0, &files_between.0),
        (&together.1, &frames_between.1),
    ] {
        let mut pressed = 0.0;
        assert_eq!(one.len(), other.len());
        for (one, other) in one.iter().zip(other) {
            assert_eq!(one.evaluations, other.evaluations);
            assert!(one.loads.keys().eq(other.loads.keys()));
            for (one, other) in one.loads.values().zip(other.loads.values()) {
                // Summed in other parts: some hundred numbers.
                assert!((one.normal - other.normal).abs() <= 1e-13 * one.normal.abs());
                pressed += one.normal;
            }
        }
        assert!(pressed > 0.0);
    }
}

/// A run that goes on from a snapshot between two frames gives the same means.
#[test]
fn sums_survive_a_snapshot() {
    let plan = Arc::new(thrown(false, vec![turning()]).plan().unwrap());
    let mut whole = Engine::new(Arc::clone(&plan), 1).unwrap();
    advance(&mut whole, 150);
    let snapshot = whole.snapshot();
    let mut again = Engine::restore(plan, snapshot.clone(), 2).unwrap();
    assert_eq!(again.snapshot(), snapshot);
    for engine in [&mut whole, &mut again] {
        advance(engine, 100);
    }
    let sums = take(&mut whole);
    assert_eq!(sums.evaluations, 251);
    assert_eq!(sums, take(&mut again));
}

/// Loads that wait in the contacts belong to their state: a loop that stays, as one from outside does, forgets them when another state is
/// restored, and has them again when that one is refused.
#[test]
fn sums_survive_a_state_restored_in_place() {
    let plan = Arc::new(thrown(false, vec![turning()]).plan().unwrap());
    for outside in [false, true] {
        let mut options = StartOptions::threads(1);
        if outside {
            options = options.contacts(contact_loop(&plan.physics().laws));
        }
        let mut engine = Engine::start(Arc::clone(&plan), options).unwrap();
        advance(&mut engine, 150);
        let snapshot = engine.snapshot();
        advance(&mut engine, 50);
        let later = engine.snapshot();
        // All is there and right up to the loads, which come behind the contacts.
        let sections = snapshot.sections().iter();
        let cut = sections.filter(|(name, _)| *name != "feature loads");
        let mut encoder = Encoder::new();
        for (name, bytes) in cut {
            encoder.section_by(name, |pieces| pieces.end().extend_from_slice(bytes));
        }
        encoder.section("stop", &0u32);
        let bytes = encoder.finish();
        let mut decoder = Decoder::new(&bytes).unwrap();
        let without = Snapshot::take_from(&mut decoder, "stop").unwrap();
        assert!(engine.restore_in_place(&without).is_err());
        assert!(engine.snapshot() == later, "outside: {outside}");
        engine.restore_in_place(&snapshot).unwrap();
        assert!(engine.snapshot() == snapshot, "outside: {outside}");
        advance(&mut engine, 50);
        assert!(engine.snapshot() == later, "outside: {outside}");
    }
}

/// Off is off: nothing is summed up, nothing is written.
#[test]
fn what_is_not_requested_costs_nothing() {
    let mut plan = thrown(false, vec![turning()]);
    plan.output.triangle_loads = false;
    let mut engine = engine(plan.clone());
    advance(&mut engine, 50);
    assert_eq!(engine.take_load_sums(true, true), [None, None]);
    let snapshot = engine.snapshot();
    let names: Vec<&str> = snapshot.sections().iter().map(|(name, _)| name).collect();
    assert!(!names.contains(&"feature loads"), "{names:?}");
    let folder = tempfile::tempdir().unwrap();
    run_in(folder.path(), plan, 10, 1e-4, 1);
    assert!(!folder.path().join("run.triangle_loads.arrow").exists());
}
