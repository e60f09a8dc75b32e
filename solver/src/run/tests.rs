//! Whole runs of small scenes: what they write, and when.

mod bodies;
mod losses;
mod memory;
mod mercury_files;
mod rest;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use glam::{DQuat, DVec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::data::DataReader;
use mercury_common::formats::ene::EnergyReader;
use mercury_common::formats::table_head;
use mercury_common::frames::{ContactReader, ParticleReader, WallReader};
use mercury_common::scene::Switches;
use mercury_common::surfaces::{Placement, Surface};
use mercury_engine::cell::Cell;

use super::*;
use crate::output::summary::Status;
use crate::plan::{Draft, NewBody, NewParticle, OutputPlan};
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::{CountedRegion, FluxPart, FluxPlan, Region};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    SpringRotation,
};
use mercury_engine::state::MaterialIndex;
use mercury_engine::walls::{Motion, Plane, Shape, Wall};

const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2000.0;
const STIFFNESS: f64 = 1000.0;

fn law(friction: f64) -> AnyPairLaw {
    AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(STIFFNESS, 2.0)),
        tangential: if friction > 0.0 {
            AnyTangential::Linear(LinearFriction {
                stiffness: 2.0 / 7.0 * STIFFNESS,
                dissipation: 0.5,
                friction,
                static_friction: friction,
                rotation: SpringRotation::default(),
                limits: CoulombLimits::Bounded,
            })
        } else {
            AnyTangential::None
        },
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// An empty scene that writes everything every `interval`.
fn plan(steps: u64, interval: f64, friction: f64) -> Draft {
    let domain = (DVec3::ZERO, DVec3::splat(0.4));
    let mut plan = Draft::new(1e-4, domain, DENSITY, law(friction));
    plan.title = "test".to_owned();
    plan.prefix = "test".to_owned();
    plan.steps = steps;
    plan.gravity = DVec3::new(0.0, 0.0, -10.0);
    plan.orientations = friction > 0.0;
    plan.output = OutputPlan {
        interval,
        rows_interval: interval,
        fstat_interval: interval,
        switches: Switches {
            data: true,
            ene: true,
            fstat: true,
            frames: true,
            walls: true,
            ..Switches::default()
        },
        track: vec![("first, of all".to_owned(), 0)],
        track_interval: interval,
        ..OutputPlan::default()
    };
    plan
}

/// A sheet of ten thousand vertices has work for two threads, one particle has not.
#[test]
fn vertices_of_sheets_keep_threads_busy() {
    let scene = |edge: f64| {
        format!(
            r#"
            time = {{ end = 1e-6, step = 1e-7 }}
            domain = {{ min = [0, 0, 0], max = [1, 1, 1] }}
            output = {{ interval = 1.0 }}
            [materials.m]
            density = 1000.0
            normal = {{ law = "linear", stiffness = 1000.0, restitution = 0.5 }}
            [[membranes]]
            name = "sheet"
            shape = "rectangle"
            corner = [0.1, 0.1, 0.5]
            along = [0.8, 0.0, 0.0]
            across = [0.0, 0.8, 0.0]
            edge = {edge}
            material = "m"
            thickness = 1e-3
            youngs_modulus = 1e5
            "#
        )
    };
    let threads = |edge| {
        let scene = crate::plan::parse_scene(
            std::path::Path::new("sheet.toml"),
            &scene(edge),
            &[],
            mercury_common::scene::Files::Unchecked,
        );
        useful_threads(&crate::plan::plan(&scene.unwrap()).unwrap(), 2)
    };
    assert_eq!([threads(8e-3), threads(0.2)], [2, 1]);
}

fn floor() -> Wall {
    Wall {
        name: "floor".to_owned(),
        material: MaterialIndex::new(0),
        shape: Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap()),
        motion: Motion::new(Vec::new()).unwrap(),
        from: 0.0,
        until: f64::INFINITY,
        reference: DVec3::ZERO,
    }
}

fn options(folder: &Path, threads: usize) -> RunOptions {
    RunOptions {
        folder: folder.to_owned(),
        threads,
        plan_document: Some("planned = true\n".to_owned()),
        ..RunOptions::default()
    }
}

fn go(plan: Draft, folder: &Path) -> Report {
    let plan = plan.plan().unwrap();
    run(plan, &options(folder, 1), &mut |_| ()).unwrap()
}

/// Two spheres that collide along x in the middle of the domain.
fn collision(steps: u64, interval: f64) -> Draft {
    let mut plan = plan(steps, interval, 0.0);
    plan.gravity = DVec3::ZERO;
    let mut a = NewParticle::at(
        DVec3::new(0.2 - 1.01 * RADIUS, 0.2, 0.2),
        RADIUS,
        MaterialIndex::new(0),
    );
    let mut b = NewParticle::at(
        DVec3::new(0.2 + 1.01 * RADIUS, 0.2, 0.2),
        RADIUS,
        MaterialIndex::new(0),
    );
    (a.velocity.x, b.velocity.x) = (0.1, -0.1);
    plan.with_particles(vec![a, b])
}

fn times(folder: &Path) -> Vec<f64> {
    let rows = EnergyReader::open(folder.join("test.ene")).unwrap();
    rows.map(|row| row.unwrap().time).collect()
}

fn step_times(steps: &[u64]) -> Vec<f64> {
    steps.iter().map(|&step| step as f64 * 1e-4).collect()
}

#[test]
fn a_run_leaves_exactly_its_files() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = collision(30, 1e-3);
    plan.output.pictures = true;
    let report = go(plan, place.path());
    let mut found: Vec<_> = fs::read_dir(place.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    found.sort();
    let expected = [
        "plan.toml",
        "run.log",
        "summary.json",
        "test.contacts.arrow",
        "test.data",
        "test.ene",
        "test.energy.png",
        "test.energy.svg",
        "test.final.png",
        "test.final.svg",
        "test.fstat",
        "test.particles.arrow",
        "test.track.csv",
    ];
    assert_eq!(found, expected);
    let mut reported = report.files.clone();
    reported.sort();
    assert_eq!(reported, expected);
    let picture = fs::read_to_string(place.path().join("test.final.svg")).unwrap();
    assert!(picture.contains("2 spheres"), "both spheres");
    assert!(picture.contains("speed"), "they move");
    assert_eq!(times(place.path()), step_times(&[0, 10, 20, 30]));
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(place.path().join("summary.json")).unwrap()).unwrap();
    assert_eq!(json["status"], "finished");
    assert_eq!(json["steps"], 30);
    assert_eq!(json["inserted"], 0);
    assert!(json["energy"]["dissipated"].is_null());
}

#[test]
fn the_end_is_written_once_also_between_two_frames() {
    let place = tempfile::tempdir().unwrap();
    go(collision(25, 1e-3), place.path());
    assert_eq!(times(place.path()), step_times(&[0, 10, 20, 25]));
    go(collision(0, 1e-3), place.path());
    assert_eq!(
        times(place.path()),
        [0.0],
        "a run of no steps has its start"
    );
}

#[test]
fn contacts_have_their_own_interval() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = collision(30, 1e-3);
    plan.output.fstat_interval = 1.5e-3;
    go(plan, place.path());
    assert_eq!(times(place.path()), step_times(&[0, 10, 20, 30]));
    let frames = ContactReader::open(place.path().join("test.contacts.arrow")).unwrap();
    let found: Vec<f64> = frames.iter().map(|frame| frame.unwrap().time).collect();
    assert_eq!(found, step_times(&[0, 15, 30]));
}

/// Rows at half the interval of frames: every other row is that of a run whose rows come with frames, amounts add up, and no other file changes.
#[test]
fn rows_have_their_own_interval() {
    let draft = || {
        let mut draft = collision(30, 1e-3);
        draft.walls = vec![floor()];
        draft.fluxes = vec![FluxPlan {
            name: "gate".to_owned(),
            point: DVec3::splat(0.2) - 1.0095 * RADIUS * DVec3::X,
            normal: DVec3::X,
            part: FluxPart::Disc(RADIUS),
        }];
        draft.regions = vec![CountedRegion {
            name: "half".to_owned(),
            region: Region::HalfSpace {
                point: DVec3::splat(0.2),
                normal: DVec3::X,
            },
            volume: 0.5,
        }];
        draft
    };
    let (with_frames, often) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    go(draft(), with_frames.path());
    let mut plan = draft();
    plan.output.rows_interval = 5e-4;
    go(plan, often.path());
    let read = |folder: &Path, ending: &str| {
        let text = fs::read_to_string(folder.join(format!("test.{ending}"))).unwrap();
        text.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    for ending in ["ene", "walls.csv", "regions.csv"] {
        let (few, many) = (read(with_frames.path(), ending), read(often.path(), ending));
        assert_eq!((few.len(), many.len()), (1 + 4, 1 + 7), "{ending}");
        assert_eq!(few[0], many[0]);
        let every_other: Vec<&String> = many[1..].iter().step_by(2).collect();
        assert_eq!(every_other, few[1..].iter().collect::<Vec<_>>(), "{ending}");
    }
    let crossed = |folder: &Path| -> Vec<u32> {
        let rows = read(folder, "flux.csv");
        let forward = |row: &String| row.split(',').nth(3).unwrap().parse().unwrap();
        rows[1..].iter().map(forward).collect()
    };
    let (few, many) = (crossed(with_frames.path()), crossed(often.path()));
    assert_eq!((few.len(), many.len()), (4, 7));
    assert_eq!(few.iter().sum::<u32>(), 1);
    let pairs: Vec<u32> = many[1..].chunks(2).map(|two| two.iter().sum()).collect();
    assert_eq!(pairs, few[1..]);
    for file in [
        "data",
        "fstat",
        "particles.arrow",
        "walls.arrow",
        "track.csv",
    ] {
        let [one, other] = [&with_frames, &often]
            .map(|folder| fs::read(folder.path().join(format!("test.{file}"))).unwrap());
        assert!(one == other, "{file}");
    }
}

#[test]
fn data_and_frames_hold_the_state() {
    let place = tempfile::tempdir().unwrap();
    let plan = collision(20, 1e-3);
    go(plan.clone(), place.path());
    let mut engine = Engine::new(Arc::new(plan.plan().unwrap()), 1).unwrap();
    for _ in 0..20 {
        engine.step(None).unwrap();
    }
    engine.complete_step().unwrap();
    let rows = engine.particles.rows_by_id();
    let data = DataReader::open(place.path().join("test.data")).unwrap();
    let last = data.last().unwrap().unwrap();
    let native = ParticleReader::open(place.path().join("test.particles.arrow")).unwrap();
    let frame = native.frame(native.frames().len() - 1).unwrap();
    assert_eq!(frame.step, 20);
    for (k, &row) in rows.iter().enumerate() {
        let record = &engine.particles.records[row as usize];
        assert_eq!(last.particles[k].position, record.position);
        assert_eq!(last.particles[k].velocity, record.velocity);
        assert_eq!(frame.position[k], record.position);
        assert_eq!(frame.velocity[k], record.velocity);
        assert_eq!(frame.mass[k], engine.particles.masses[row as usize]);
        assert_eq!(
            frame.force.as_ref().unwrap()[k],
            engine.particles.loads[row as usize].force
        );
    }
    let track = fs::read_to_string(place.path().join("test.track.csv")).unwrap();
    assert_eq!(track.lines().count(), 1 + 3);
    let numbers = track.lines().last().unwrap().rsplit(',').take(6);
    let numbers: Vec<f64> = numbers.map(|cell| cell.parse().unwrap()).collect();
    let load = &engine.particles.loads[rows[0] as usize];
    let ([fx, fy, fz], [tx, ty, tz]) = (load.force.to_array(), load.torque.to_array());
    assert_eq!(numbers, [tz, ty, tx, fz, fy, fx]);
    assert!(
        track
            .lines()
            .nth(1)
            .unwrap()
            .starts_with("0,\"first, of all\",0,"),
        "{track}"
    );
}

#[test]
fn a_wall_carries_the_weight_of_what_rests_on_it() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = plan(40_000, 1.0, 0.0);
    plan.until_at_rest = true;
    plan.walls = vec![floor()];
    plan.wall_curvature = false;
    let (x, y) = (0.3, 0.1);
    let plan = plan.with_particles(vec![NewParticle::at(
        DVec3::new(x, y, 1.01 * RADIUS),
        RADIUS,
        MaterialIndex::new(0),
    )]);
    let report = go(plan, place.path());
    assert!(report.summary.steps < 40_000, "the run ends at rest");
    assert_eq!(report.summary.status, Status::Finished);
    let mass = DENSITY * mercury_engine::state::volume(RADIUS, 3);
    let weight = mass * 10.0;
    // At rest the kinetic energy is below 1e-6 m g d for a thousand steps, many periods of the contact (2 pi sqrt(m/k) =
    // 18 ms, 180 steps): amplitude A with k A^2 / 2 < 1e-6 m g d, so the force is off by less than k A; the
    // dashpot adds gamma v with m v^2 / 2 below the same energy.
    let energy = 1e-6 * weight * 2.0 * RADIUS;
    let tolerance = (2.0 * STIFFNESS * energy).sqrt() + 2.0 * (2.0 * energy / mass).sqrt();
    assert!(
        tolerance < 0.05 * weight,
        "the test is meaningful: {tolerance} of {weight}"
    );
    let walls = fs::read_to_string(place.path().join("test.walls.csv")).unwrap();
    let mut lines = walls.lines();
    let head = "time [s],name,fx [N],fy [N],fz [N],tx [N m],ty [N m],tz [N m],power [W],x [m],y [m],z [m],\
qw,qx,qy,qz,vx [m/s],vy [m/s],vz [m/s],wx [rad/s],wy [rad/s],wz [rad/s]";
    assert_eq!(lines.next().unwrap(), head);
    let last: Vec<&str> = lines.last().unwrap().split(',').collect();
    assert_eq!(last[1], "floor");
    let number = |k: usize| last[k].parse::<f64>().unwrap();
    assert_eq!((number(2), number(3)), (0.0, 0.0));
    assert!((number(4) + weight).abs() < tolerance, "{walls}");
    // (x, y, 0) x (0, 0, -W) = (-y W, x W, 0)
    assert!((number(5) + y * weight).abs() < y * tolerance);
    assert!((number(6) - x * weight).abs() < x * tolerance);
    assert_eq!((number(7), number(8)), (0.0, 0.0));
    let at_rest = [
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ];
    assert_eq!(
        [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12].map(|k| number(9 + k)),
        at_rest
    );
}

#[test]
fn energy_budget_closes() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = plan(2000, 0.01, 0.5);
    plan.energy_budget = true;
    plan.walls = vec![floor()];
    let mut ball = NewParticle::at(
        DVec3::new(0.2, 0.2, 2.0 * RADIUS),
        RADIUS,
        MaterialIndex::new(0),
    );
    ball.velocity.x = 0.3;
    let report = go(plan.with_particles(vec![ball]), place.path());
    let energy = report.summary.energy;
    let dissipated = energy.dissipated.clone().unwrap();
    assert!(dissipated.of("normal") > 0.0 && dissipated.of("tangential") > 0.0);
    assert_eq!(dissipated.of("rolling"), 0.0);
    // Of second order: 10 (dt/t_c)^2 with contacts of 9 ms, for each of a few bounces.
    let error = energy.closure_error.unwrap();
    assert!(error.abs() < 5e-3, "{error}");
    assert!(energy.rotational > 0.0);
}

/// A rod that bounces and slides on a floor: what its pebbles lose, the body has lost.
#[test]
fn energy_budget_of_a_clump_closes() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = plan(3000, 0.01, 0.5);
    plan.energy_budget = true;
    plan.walls = vec![floor()];
    let pebbles = [-1.0, 0.0, 1.0].map(|x| Pebble {
        position: DVec3::X * (2.0 * RADIUS * x),
        radius: RADIUS,
    });
    // Three touching spheres: I = m R^2 (1.2, 9.2, 9.2) with m the mass of one.
    let volume = 3.0 * mercury_engine::state::volume(RADIUS, 3);
    let mass = DENSITY * volume;
    let moments = DVec3::new(1.2, 9.2, 9.2) * (mass / 3.0 * RADIUS * RADIUS);
    let rod = Clump::new(
        "rod",
        MaterialIndex::new(0),
        pebbles.to_vec(),
        mass,
        volume,
        moments,
    )
    .unwrap();
    let mut body = NewBody::at(DVec3::new(0.2, 0.2, 3.0 * RADIUS), 0);
    body.orientation = DQuat::from_rotation_y(0.4);
    body.velocity = DVec3::new(0.3, 0.1, 0.0);
    body.angular_velocity = DVec3::new(3.0, 0.0, 8.0);
    let report = go(plan.with_bodies(vec![rod], vec![body]), place.path());
    let energy = report.summary.energy;
    let dissipated = energy.dissipated.clone().unwrap();
    assert!(dissipated.of("normal") > 0.0 && dissipated.of("tangential") > 0.0);
    // As for the sphere above.
    let error = energy.closure_error.unwrap();
    assert!(error.abs() < 5e-3, "{error}");
    assert!(energy.rotational > 0.0);
    assert_eq!(report.summary.particles, 1, "one grain of three pebbles");
    assert!((report.budget.initial_mass / mass - 1.0).abs() < 1e-15);
    assert!(report.budget.mass_error().abs() < 1e-15 * mass);
    // The row of .data is the body's, with its circumscribed radius; the frames hold its pebbles.
    let data = DataReader::open(place.path().join("test.data")).unwrap();
    let last = data.last().unwrap().unwrap();
    assert_eq!(last.particles.len(), 1);
    assert_eq!(last.particles[0].radius, 3.0 * RADIUS);
    let frames = ParticleReader::open(place.path().join("test.particles.arrow")).unwrap();
    let frame = frames.frame(frames.frames().len() - 1).unwrap();
    assert_eq!(frame.id, [0, 1, 2]);
    assert_eq!(frame.body, Some(vec![Some(0); 3]));
    assert!((frame.mass.iter().sum::<f64>() / mass - 1.0).abs() < 1e-15);
    assert!((frame.volume.iter().sum::<f64>() / volume - 1.0).abs() < 1e-15);
    let middle = frame.position[1] - last.particles[0].position;
    assert!(middle.length() < 1e-15, "{middle}");
    let turned = frame.orientation.unwrap();
    let end = frame.position[2] - frame.position[1] - turned[2] * (2.0 * RADIUS * DVec3::X);
    assert!(end.length() < 1e-15, "{end}");
    // The contacts of .fstat are those of row 0 of .data.
    let fstat = fs::read_to_string(place.path().join("test.fstat")).unwrap();
    let rows = fstat.lines().filter(|line| !line.starts_with('#'));
    let mut count = 0;
    for row in rows {
        assert_eq!(row.split_whitespace().nth(1), Some("0"), "{row}");
        count += 1;
    }
    assert!(count > 10, "{count}");
    let track = fs::read_to_string(place.path().join("test.track.csv")).unwrap();
    let line: Vec<&str> = track.lines().last().unwrap().split(',').collect();
    let head: Vec<&str> = track.lines().next().unwrap().split(',').collect();
    let number = |name: &str| -> f64 {
        let at = head
            .iter()
            .position(|column| table_head::name(column) == name)
            .unwrap();
        // From the end, as the name in quotes has a comma.
        line[line.len() + at - head.len()].parse().unwrap()
    };
    assert_eq!(number("wx"), last.particles[0].angular_velocity.x);
}

#[test]
fn a_request_stops_the_run_without_a_frame_of_its_own() {
    let place = tempfile::tempdir().unwrap();
    let mut options = options(place.path(), 1);
    options.stop = Arc::new(AtomicBool::new(true));
    let report = run(collision(1000, 0.01).plan().unwrap(), &options, &mut |_| ()).unwrap();
    assert_eq!(
        (report.summary.status, report.summary.steps),
        (Status::Stopped, 1)
    );
    assert_eq!(times(place.path()), step_times(&[0]));
    // The report is of the state in which it stopped nevertheless.
    assert!(report.summary.energy.kinetic > 0.0);
}

/// 3,375 particles in a box that is periodic along x, thrown about, with friction.
fn crowd() -> Draft {
    let mut plan = plan(40, 2e-3, 0.5);
    let high = DVec3::splat(15.0 * 2.0 * RADIUS);
    plan.cell = Cell::new(plan.cell.low(), high, [true, false, false]);
    plan.walls = vec![floor()];
    let mut particles = Vec::new();
    for k in 0..3375u32 {
        let cell = DVec3::new(
            f64::from(k % 15),
            f64::from(k / 15 % 15),
            f64::from(k / 225),
        );
        // Pseudo-random speeds without a generator: the fractional parts of multiples of irrational numbers.
        let wobble = |n: f64| (f64::from(k) * n).fract() - 0.5;
        let position = (cell + 0.5) * (1.99 * RADIUS);
        let mut particle = NewParticle::at(
            position,
            RADIUS * (1.0 + 0.01 * wobble(0.917)),
            MaterialIndex::new(0),
        );
        particle.velocity = DVec3::new(wobble(0.618), wobble(0.414), wobble(0.732));
        particle.angular_velocity = particle.velocity * 50.0;
        particle.fixed = k % 97 == 0;
        particles.push(particle);
    }
    plan.with_particles(particles)
}

#[test]
fn threads_do_not_change_a_byte() {
    let mut all = Vec::new();
    for threads in [1, 2, 4] {
        let place = tempfile::tempdir().unwrap();
        let report = run(
            crowd().plan().unwrap(),
            &options(place.path(), threads),
            &mut |_| (),
        )
        .unwrap();
        assert!(report.summary.contacts > 1000 && report.summary.wall_contacts > 100);
        let files: BTreeMap<String, Vec<u8>> = fs::read_dir(place.path())
            .unwrap()
            .map(|entry| entry.unwrap())
            .map(|entry| {
                (
                    entry.file_name().into_string().unwrap(),
                    fs::read(entry.path()).unwrap(),
                )
            })
            .filter(|(name, _)| name != "summary.json" && name != "run.log")
            .collect();
        assert!(files.len() >= 8);
        all.push(files);
    }
    for (name, bytes) in &all[0] {
        assert!(!bytes.is_empty());
        for other in &all[1..] {
            assert!(bytes == &other[name], "{name} depends on the threads");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_run_and_names_the_file() {
    let place = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/full", place.path().join("test.data")).unwrap();
    let failure = run(
        collision(1000, 1e-3).plan().unwrap(),
        &options(place.path(), 1),
        &mut |_| (),
    )
    .unwrap_err();
    let message = failure.to_string();
    assert!(
        message.contains("test.data: the file cannot be written"),
        "{message}"
    );
    assert!(!place.path().join("summary.json").exists());
    let log = fs::read_to_string(place.path().join("run.log")).unwrap();
    assert!(log.contains("failed"), "{log}");
}

#[test]
fn a_missing_folder_ends_the_run_before_it_steps() {
    let place = tempfile::tempdir().unwrap();
    let missing = place.path().join("missing");
    let message = run(
        collision(10, 1e-3).plan().unwrap(),
        &options(&missing, 1),
        &mut |_| panic!("no step is made"),
    )
    .unwrap_err()
    .to_string();
    assert!(message.contains("plan.toml"), "{message}");
}

#[test]
fn numbers_that_explode_end_the_run_with_what_was_written() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = collision(200_000, 1e-3);
    plan.time_step = 0.5;
    plan.output.interval = 0.5;
    plan.walls = vec![floor(), floor()];
    plan.gravity = DVec3::new(0.0, 0.0, f64::MAX);
    let failure = run(plan.plan().unwrap(), &options(place.path(), 1), &mut |_| ()).unwrap_err();
    assert!(
        matches!(failure, RunFailure::Engine(RunError::NotFinite { .. })),
        "{failure}"
    );
    assert!(!times(place.path()).is_empty());
}

#[test]
fn walls_leave_their_surfaces_and_where_they_stood() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = collision(20, 1e-3);
    plan.walls = vec![floor()];
    go(plan, place.path());
    let walls = WallReader::open(place.path().join("test.walls.arrow")).unwrap();
    assert_eq!(walls.header().walls, ["floor"]);
    assert!(matches!(walls.surfaces(), [Surface::Plane { normal, .. }] if *normal == DVec3::Z));
    assert_eq!(walls.frames().len(), 3);
    let last = walls.frame(2).unwrap();
    assert_eq!((last.step, last.present), (20, vec![true]));
    assert_eq!(last.placement, [Placement::default()]);
}

#[test]
fn files_for_paraview_have_their_own_interval_and_lists_with_times() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = collision(30, 1e-3);
    plan.walls = vec![floor()];
    plan.output.vtk = true;
    plan.output.vtk_interval = 2e-3;
    // Files of an earlier, longer run are not taken for a part of this one.
    let folder = place.path().join("vtk");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("test.particles.0007.vtu"), "old").unwrap();
    fs::write(folder.join("mine.vtu"), "kept").unwrap();
    go(plan, place.path());
    for kind in ["particles", "contacts", "walls"] {
        let list = fs::read_to_string(folder.join(format!("test.{kind}.pvd"))).unwrap();
        let tree = roxmltree::Document::parse(&list).unwrap();
        let sets = tree.descendants().filter(|n| n.has_tag_name("DataSet"));
        let found: Vec<(f64, String)> = sets
            .map(|n| {
                let time = n.attribute("timestep").unwrap().parse().unwrap();
                (time, n.attribute("file").unwrap().to_owned())
            })
            .collect();
        let times: Vec<f64> = found.iter().map(|(time, _)| *time).collect();
        assert_eq!(times, step_times(&[0, 20, 30]), "{kind}");
        for (k, (_, file)) in found.iter().enumerate() {
            assert_eq!(*file, format!("test.{kind}.{k:04}.vtu"));
            assert!(folder.join(file).exists());
        }
    }
    // 3 kinds of 3 frames and a list each, the script, and the stranger.
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 3 * 4 + 2);
}

#[test]
fn fluxes_are_written_at_every_output_time() {
    let place = tempfile::tempdir().unwrap();
    // One of the two that come together, seen before they meet.
    let mut plan = collision(30, 1e-3);
    let (from, velocity) = (plan.particles[0].position, plan.particles[0].velocity);
    plan.fluxes = vec![FluxPlan {
        name: "gate".to_owned(),
        point: from + 1.5e-4 * velocity,
        normal: velocity.normalize(),
        part: FluxPart::Disc(RADIUS),
    }];
    let mass = DENSITY * mercury_engine::state::volume(RADIUS, 3);
    let report = go(plan, place.path());
    assert!(report.files.contains(&"test.flux.csv".to_owned()));
    let text = fs::read_to_string(place.path().join("test.flux.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "time [s],name,material,forward,backward,mass [kg],volume [m3],px [kg m/s],py [kg m/s],pz [kg m/s],d10 [m],d32 [m],d43 [m]"
    );
    assert_eq!(lines.len(), 1 + 4);
    assert_eq!(lines[1], "0,gate,material,0,0,0,0,0,0,0,0,0,0");
    let cells: Vec<&str> = lines[2].split(',').collect();
    assert_eq!(cells[1..5], ["gate", "material", "1", "0"]);
    let number = |k: usize| cells[k].parse::<f64>().unwrap();
    // No force acts before they meet.
    let momentum = DVec3::new(number(7), number(8), number(9)) - mass * velocity;
    assert!((number(5) - mass).abs() < 1e-15 * mass);
    assert!(momentum.length() < 1e-12 * mass);
    assert!((10..13).all(|k| (number(k) - 2.0 * RADIUS).abs() < 1e-15));
    assert_eq!(lines[3].split(',').nth(3), Some("0"));
}

#[test]
fn regions_are_counted_at_every_output_time() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = collision(30, 1e-3);
    plan.regions = vec![CountedRegion {
        name: "right, half".to_owned(),
        region: Region::HalfSpace {
            point: DVec3::splat(0.2),
            normal: DVec3::X,
        },
        volume: 0.5,
    }];
    let mass = DENSITY * mercury_engine::state::volume(RADIUS, 3);
    let report = go(plan, place.path());
    assert!(report.files.contains(&"test.regions.csv".to_owned()));
    let text = fs::read_to_string(place.path().join("test.regions.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "time [s],name,material,number,mass [kg],vx [m/s],vy [m/s],vz [m/s],kinetic [J],solid_fraction"
    );
    // Also the first time and the last.
    assert_eq!(text.lines().count(), 1 + 4);
    let first = lines.next().unwrap();
    let rest = first.strip_prefix("0,\"right, half\",material,1,").unwrap();
    let found: Vec<f64> = rest.split(',').map(|cell| cell.parse().unwrap()).collect();
    let kinetic = 0.5 * mass * 0.1 * 0.1;
    let expected = [mass, -0.1, 0.0, 0.0, kinetic, mass / DENSITY / 0.5];
    for (found, expected) in found.iter().zip(expected) {
        // Products of at most four roundings.
        assert!(
            (found - expected).abs() <= 1e-15 * expected.abs(),
            "{first}"
        );
    }
}
