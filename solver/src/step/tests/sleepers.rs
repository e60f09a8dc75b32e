//! Particles at rest fall asleep, no relevant result changes, and disturbed sleepers are woken.

mod fixed;

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use mercury_common::scene::Files;

use crate::forces::{Partner, Watch};
use crate::lanes::Width;
use crate::plan::{Plan, parse_scene, plan};
use crate::sleeping::hold_contacts;
use crate::state::{ASLEEP, FIXED, PEBBLE, Particles, WOKEN, WallIndex};
use crate::step::{Core, Engine, Snapshot, StartOptions};
use crate::walls::{Plane, Shape};

const G: f64 = 9.81;
/// Of all spheres here, m.
const RADIUS: f64 = 1e-3;
/// N/m
const STIFFNESS: f64 = 500.0;

fn mass() -> f64 {
    2000.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3)
}

const WITNESS: Watch = Watch {
    records: true,
    audit: None,
};

/// A scene of soft, sticky spheres of 1 mm radius over a floor at z = 0, which is there `until`; `more`: tables behind it.
fn scene(head: &str, floor: &str, more: &str) -> Arc<Plan> {
    let text = format!(
        r#"
        gravity = [0, 0, -9.81]
        {head}
        output = {{ interval = 0.05 }}
        [materials.m]
        density = 2000.0
        normal = {{ law = "linear", stiffness = 500.0, restitution = 0.3 }}
        tangential = {{ law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }}
        {FLOOR}
        {floor}
        {more}
    "#
    );
    let scene = parse_scene(Path::new("sleepers.toml"), &text, &[], Files::Unchecked).unwrap();
    Arc::new(plan(&scene).unwrap())
}

const FLOOR: &str = r#"
        [[walls]]
        name = "floor"
        shape = "plane"
        point = [0, 0, 0]
        normal = [0, 0, 1]
        material = "m""#;

const ROOM: &str = r"time = { end = 1.0, step = 2e-5 }
        domain = { min = [-0.02, -0.02, -0.1], max = [0.02, 0.02, 0.4] }";

/// `count` spheres, one on the other; the lowest is number 0.
fn column(count: u32, sleeping: &str, floor: &str, more: &str) -> Arc<Plan> {
    let top = (2 * count - 1) as f64 * RADIUS;
    let lattice = format!(
        "[[particles]]\nmaterial = \"m\"\nradius = 1e-3\nlattice = {{ min = [0, 0, {RADIUS}], max = [0, 0, {top}], spacing = 2e-3 }}\n{more}"
    );
    scene(&format!("{sleeping}\n{ROOM}"), floor, &lattice)
}

fn asleep(engine: &Engine) -> u64 {
    engine.sleepers().unwrap().0
}

fn advance(engine: &mut Engine, time: f64) {
    let steps = (time / engine.physics().time_step()).round() as u64;
    engine.steps_at_once(steps, None).unwrap();
}

/// Height of each sphere, by id, m.
fn heights(engine: &Engine) -> Vec<f64> {
    let rows = engine.particles.rows_by_id();
    let records = &engine.particles.records;
    (rows.iter())
        .map(|&row| records[row as usize].position.z)
        .collect()
}

/// A column carries in each contact what lies above it, whether it sleeps or not, and files show it.
#[test]
fn sleepers_carry_what_lies_above_them() {
    let count = 8;
    let mut engine = Engine::new(column(count, "sleeping = {}", "", ""), 1).unwrap();
    assert_eq!(asleep(&engine), 0);
    advance(&mut engine, 0.5);
    assert_eq!(asleep(&engine), u64::from(count), "all have come to rest");
    let (_, counts) = engine.sleepers().unwrap();
    assert_eq!(counts.fell_asleep, u64::from(count) + counts.woken);
    let before = engine.snapshot();
    engine.step(Some(WITNESS)).unwrap();
    let seen = engine.observation();
    assert_eq!((seen.particle_contacts, seen.wall_contacts), (7, 1));
    let weight = mass() * G;
    // Each is in balance to half of the tenth that wakes it, and so is the sum of those above a contact.
    for record in &seen.records {
        let id = |row: u32| engine.particles.ids[row as usize].number();
        let above = match record.partner {
            Partner::Particle { row, .. } => count - id(record.row).max(id(row)),
            Partner::Wall { .. } => count,
        };
        let expected = f64::from(above) * weight;
        let force = record.force.z.abs();
        assert!(
            (force - expected).abs() < 0.05 * expected,
            "{above}: {force} N"
        );
    }
    // Loads are those of all contacts, and nothing has changed but the clock and its counts.
    for load in &engine.particles.loads {
        assert!((load.force.z - weight).abs() < 0.05 * weight);
    }
    let after = engine.snapshot();
    assert_eq!(after.pairs(), before.pairs());
    assert_eq!(after.near_walls(), before.near_walls());
    assert_eq!(after.particles(), before.particles());
    engine.complete_step().unwrap();
    let at_rest = |record: &crate::state::Particle| record.velocity.length() == 0.0;
    assert!(engine.particles.records.iter().all(at_rest));
}

/// The heights of the column are those without sleepers: each contact is in balance to 0.05 weights of those above.
#[test]
fn a_column_settles_to_the_same_height() {
    let run = |sleeping| {
        let mut engine = Engine::new(column(8, sleeping, "", ""), 1).unwrap();
        advance(&mut engine, 0.5);
        heights(&engine)
    };
    let (with, without) = (run("sleeping = {}"), run(""));
    let (mut bound, compression) = (0.0, mass() * G / STIFFNESS);
    for (k, (with, without)) in with.iter().zip(&without).enumerate() {
        bound += 0.05 * compression * (8 - k) as f64;
        assert!((with - without).abs() < bound, "{k}: {with} m, {without} m");
    }
}

/// Without its floor the column falls as one that did not sleep. A sleeper holds back a tenth of its weight at most, until
/// the contact below it has opened by as much: k g t^2/2 = 0.1 m g.
#[test]
fn a_floor_that_goes_wakes_what_stood_on_it() {
    let count = 8;
    let run = |sleeping| {
        let mut engine = Engine::new(column(count, sleeping, "until = 0.5", ""), 1).unwrap();
        advance(&mut engine, 0.499);
        let slept = engine.sleepers().map(|(asleep, _)| asleep);
        advance(&mut engine, 0.051);
        engine.complete_step().unwrap();
        let records = engine.particles.records.iter();
        let momentum: f64 = records.map(|record| record.velocity.z).sum();
        (slept, engine.sleepers().map(|s| s.0), momentum)
    };
    let (slept, left, with) = run("sleeping = {}");
    assert_eq!((slept, left), (Some(8), Some(0)));
    let (_, _, without) = run("");
    // The floor goes at 0.5 s: 0.05 s of free fall.
    assert!((without + f64::from(count) * G * 0.05).abs() < 2e-4 * without.abs());
    let delay = (0.2 * mass() / STIFFNESS).sqrt();
    let bound = G * delay * f64::from(count * (count + 1) / 2);
    assert!((with - without).abs() < bound, "{with}, {without} m/s");
}

#[test]
fn a_floor_that_begins_to_move_takes_its_sleepers_along() {
    let motion =
        r#"motion = [{ kind = "translation", velocity = [0, 0, 0.02], from = 0.5, until = 0.6 }]"#;
    let mut engine = Engine::new(column(4, "sleeping = {}", motion, ""), 1).unwrap();
    advance(&mut engine, 0.5);
    assert_eq!(asleep(&engine), 4);
    let before = heights(&engine);
    advance(&mut engine, 0.01);
    assert_eq!(asleep(&engine), 0);
    advance(&mut engine, 0.4);
    assert_eq!(asleep(&engine), 4, "at rest again, 2 mm higher");
    for (before, after) in before.iter().zip(heights(&engine)) {
        assert!(
            (after - before - 0.002).abs() < 1e-6,
            "{before} m, {after} m"
        );
    }
}

/// Between two steps a floor goes down, and all fall: after n steps with (n - 1/2) g dt, as the first half kick knows the old floor. What a sleeper was out of
/// balance by acts in that one step at most, and the state between can be saved.
#[test]
fn a_floor_that_is_exchanged_wakes_its_sleepers() {
    let plan = column(4, "sleeping = {}", "", "");
    let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
    advance(&mut engine, 0.5);
    engine.complete_step().unwrap();
    assert_eq!(asleep(&engine), 4);
    let floor = Plane::new(-0.05 * DVec3::Z, DVec3::Z).unwrap();
    engine
        .exchange_wall(WallIndex::new(0), Shape::Plane(floor))
        .unwrap();
    assert_eq!(asleep(&engine), 4, "it acts in the next step");
    let saved = engine.snapshot();
    assert!(Snapshot::decode(&saved.encode()).is_ok_and(|read| read == saved));
    let is_woken = |record: &crate::state::Particle| record.flags & WOKEN != 0;
    assert!(!engine.particles.records.iter().any(is_woken));
    let dt = plan.physics().time_step();
    engine.steps_at_once(1, None).unwrap();
    assert_eq!(asleep(&engine), 0);
    engine.steps_at_once(99, None).unwrap();
    engine.complete_step().unwrap();
    for record in &engine.particles.records {
        // The springs of the column push its spheres apart: together they fall freely.
        assert!(record.velocity.z < 0.0);
    }
    let records = &engine.particles.records;
    let mean = records.iter().map(|r| r.velocity.z).sum::<f64>() / 4.0;
    assert!((mean + 99.5 * G * dt).abs() < 0.1 * G * dt, "{mean} m/s");
}

/// A sphere that is thrown up from a sleeping column and stands still at its highest point at every look is in no balance there.
#[test]
fn who_stands_still_in_the_air_does_not_fall_asleep() {
    // Up in 0.1 s and down in as long; a check each 1 ms, one of them at the top, and no particle is too fast.
    let ball = "[[particles]]\nmaterial = \"m\"\nradius = 1e-3\nposition = [0.005, 0, 1e-3]\nvelocity = [0, 0, 0.981]";
    let sleeping = "sleeping = { after = 1e-3, speed = 10.0 }";
    let mut engine = Engine::new(column(1, sleeping, "", ball), 1).unwrap();
    advance(&mut engine, 0.199);
    assert_eq!(asleep(&engine), 1, "the one on the floor");
    let row = engine.particles.rows_by_id()[1] as usize;
    assert_eq!(engine.particles.records[row].flags & ASLEEP, 0);
    assert!(engine.particles.records[row].position.z > RADIUS);
}

/// On a slope of half a degree a sphere rolls with 5/7 g sin(a) from rest, and never falls asleep, although nothing moves slower.
#[test]
fn a_sphere_that_begins_to_roll_goes_on() {
    let slope = 0.5f64.to_radians();
    let gravity = format!("gravity=[{}, 0, {}]", G * slope.sin(), -G * slope.cos());
    let run = |sleeping: &str| {
        let text = format!(
            r#"
            gravity = [0, 0, -9.81]
            {sleeping}
            time = {{ end = 1.0, step = 2e-5 }}
            domain = {{ min = [-0.02, -0.02, -0.1], max = [0.2, 0.02, 0.1] }}
            output = {{ interval = 0.05 }}
            [materials.m]
            density = 2000.0
            normal = {{ law = "linear", stiffness = 500.0, restitution = 0.3 }}
            tangential = {{ law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }}
            [[walls]]
            shape = "plane"
            point = [0, 0, 0]
            normal = [0, 0, 1]
            material = "m"
            [[particles]]
            material = "m"
            radius = 1e-3
            position = [0, 0, {}]
        "#,
            RADIUS - mass() * G / STIFFNESS
        );
        let overrides = [gravity.clone()];
        let scene =
            parse_scene(Path::new("slope.toml"), &text, &overrides, Files::Unchecked).unwrap();
        let mut engine = Engine::new(Arc::new(plan(&scene).unwrap()), 1).unwrap();
        advance(&mut engine, 0.5);
        (engine.particles.records[0].position.x, engine.sleepers())
    };
    let (with, sleepers) = run("sleeping = {}");
    assert_eq!(sleepers.unwrap().1.fell_asleep, 0);
    assert_eq!(with, run("").0, "no particle slept: the same bits");
    let expected = 0.5 * 5.0 / 7.0 * G * slope.sin() * 0.25;
    assert!((with - expected).abs() < 0.01 * expected, "{with} m");
}

/// A ball comes down on a column that sleeps: it comes back as fast as from one that does not sleep, and the floor feels the same blow. Each sleeper
/// keeps back a tenth of its weight at most, and nothing once it is woken.
#[test]
fn a_blow_goes_through_sleepers() {
    // Thrown up from above the column, so that that rests when it comes back after 0.47 s.
    let ball = "[[particles]]\nmaterial = \"m\"\nradius = 1e-3\nposition = [0, 0, 0.02]\nvelocity = [0, 0, 2.3]";
    let count = 6;
    let run = |sleeping: &str| {
        let mut engine = Engine::new(column(count, sleeping, "", ball), 1).unwrap();
        advance(&mut engine, 0.45);
        let slept = engine.sleepers().map(|sleepers| sleepers.0);
        let mut most = 0.0f64;
        for _ in 0..1500 {
            engine.step(Some(Watch::default())).unwrap();
            most = most.max(-engine.observation().walls[0].0.force.z);
        }
        engine.complete_step().unwrap();
        let row = engine.particles.rows_by_id()[count as usize] as usize;
        (slept, most, engine.particles.records[row].velocity.z)
    };
    let (slept, with, back) = run("sleeping = {}");
    let (_, without, expected) = run("");
    assert_eq!(slept, Some(u64::from(count)), "all but the ball");
    let weight = mass() * G;
    assert!(without > 100.0 * weight, "{without} N");
    let kept_back = 0.1 * weight * f64::from(count);
    assert!((with - without).abs() < kept_back, "{with}, {without} N");
    // For as long as the blow lasts, which is less than 5 ms.
    let bound = kept_back / mass() * 5e-3;
    assert!((back - expected).abs() < bound, "{back}, {expected} m/s");
}

/// A bed that is filled with spheres and, on request, rods; a plate shakes it and it loses grains, so that some fall asleep and
/// are woken all the time.
fn restless(with_rods: bool) -> Arc<Plan> {
    let rod = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/rod.clump.toml");
    let (rods, grains, total) = if with_rods {
        let rods = format!("[clumps.rod]\nfile = {rod:?}\nmaterial = \"m\"\n");
        let sphere =
            r#"{ material = "m", psd = { kind = "monodisperse", diameter = 2e-3 }, share = 0.5 }"#;
        // Three spheres of 1.8 mm in a row.
        let rod =
            r#"{ clump = "rod", psd = { kind = "monodisperse", diameter = 2.6e-3 }, share = 0.5 }"#;
        (rods, format!("mixture = [{sphere}, {rod}]"), 150)
    } else {
        let psd = r#"psd = { kind = "uniform", min_diameter = 1.6e-3, max_diameter = 2.4e-3, weighting = "number" }"#;
        (String::new(), format!("material = \"m\"\n{psd}"), 250)
    };
    let more = &format!(
        r#"
        {rods}
        [[walls]]
        name = "plate"
        shape = "disc"
        axis = [0, 0, 1]
        origin = [0.003, 0.003, 0.0015]
        radius = 0.003
        material = "m"
        motion = [{{ kind = "translation", velocity = [0, 0, 0.01], from = 0.16, until = 0.18 }}]
        [[walls]]
        name = "side"
        shape = "plane"
        point = [-0.008, 0, 0]
        normal = [1, 0, 0]
        material = "m"
        [[walls]]
        name = "other side"
        shape = "plane"
        point = [0.008, 0, 0]
        normal = [-1, 0, 0]
        material = "m"
        [[insertions]]
        name = "feed"
        region = {{ shape = "box", min = [-0.007, -0.008, 0.015], max = [0.007, 0.008, 0.03] }}
        {grains}
        total = {{ number = {total} }}
        rate = {{ number = 2500.0 }}
        velocity = {{ mean = [0, 0, -0.5], spread = [0.1, 0.1, 0.0] }}
        [[deletions]]
        name = "out"
        region = {{ shape = "box", min = [-0.008, -0.01, -0.1], max = [-0.006, 0.01, 0.0009] }}
    "#
    );
    let head = r#"sleeping = { after = 2e-3, speed = 1e-3 }
        time = { end = 1.0, step = 2e-5 }
        domain = { min = [-0.01, -0.008, -0.1], max = [0.01, 0.008, 0.1], periodic = ["y"] }"#;
    scene(head, "", more)
}

#[test]
fn sleepers_depend_on_neither_threads_nor_lanes_nor_looks_nor_interruptions() {
    stays_the_same(&restless(false));
}

#[test]
fn sleeping_rods_depend_on_neither_threads_nor_lanes_nor_looks_nor_interruptions() {
    stays_the_same(&restless(true));
}

fn stays_the_same(plan: &Arc<Plan>) {
    let start = |threads, width| {
        let options = StartOptions::threads(threads).width(Some(width));
        Engine::start(Arc::clone(plan), options).unwrap()
    };
    let mut first = start(1, Width::ONE);
    let mut others: Vec<Engine> = Width::all()
        .into_iter()
        .map(|width| start(1, width))
        .collect();
    others.push(start(2, Width::fastest()));
    let mut looked_at = start(1, Width::fastest());
    let mut interrupted = start(2, Width::fastest());
    let mut slept = Vec::new();
    for count in [1, 99, 2400, 2500, 1500, 1500, 1000, 500, 1500, 997, 3003] {
        first.steps_at_once(count, None).unwrap();
        slept.push(asleep(&first));
        let state = first.snapshot();
        for engine in &mut others {
            engine.steps_at_once(count, None).unwrap();
            assert_eq!(engine.snapshot(), state);
        }
        for k in 1..=count {
            let is_seen = k % 7 == 0 || k == count;
            looked_at.step(is_seen.then_some(WITNESS)).unwrap();
        }
        assert_eq!(looked_at.snapshot(), state);
        interrupted.steps_at_once(count, None).unwrap();
        let bytes = interrupted.snapshot().encode();
        assert_eq!(bytes, state.encode());
        let threads = 1 + slept.len() % 2;
        let saved = Snapshot::decode(&bytes).unwrap();
        interrupted = Engine::restore(Arc::clone(plan), saved, threads).unwrap();
    }
    // All of it happened.
    let (asleep, counts) = first.sleepers().unwrap();
    assert!(
        counts.fell_asleep > 300 && counts.woken > 100,
        "{counts:?} {slept:?}"
    );
    assert!(asleep > 60, "{slept:?}");
    let bodies = first.particles.bodies();
    if bodies.is_empty() {
        assert!(first.boundaries().removed().number > 3);
    } else {
        let rods = bodies.iter().filter(|body| body.flags & ASLEEP != 0);
        assert!(rods.count() > 10, "{slept:?}");
    }
}

/// What is held is the sum of what contacts among sleepers do, however it came about: as if it were summed up anew.
#[test]
fn what_is_held_does_not_drift() {
    let mut compared = 0;
    for with_rods in [false, true] {
        let mut engine = Engine::new(restless(with_rods), 1).unwrap();
        for _ in 0..300 {
            engine.steps_at_once(97, None).unwrap();
            let held = engine.contacts.held();
            hold_contacts(&mut engine, None);
            let anew = engine.contacts.held();
            let scale = mass() * G;
            for ((held, anew), record) in held.iter().zip(&anew).zip(&engine.particles.records) {
                let gap = (held.force - anew.force).length();
                assert!(gap < 1e-9 * scale, "{held:?} {anew:?} {record:?}");
                compared += u32::from(anew.force.length() > 0.0);
            }
            let Core {
                contacts,
                particles,
                ..
            } = &mut *engine;
            contacts.restore_held(particles, &held);
        }
    }
    assert!(compared > 2000);
}

/// A sphere without friction goes on turning while it rests, so it does not sleep; one that does not turn does.
#[test]
fn who_turns_does_not_sleep() {
    let text = format!(
        r#"
        sleeping = {{}}
        gravity = [0, 0, -9.81]
        time = {{ end = 1.0, step = 2e-5 }}
        domain = {{ min = [0, 0, -0.01], max = [0.1, 0.1, 0.1] }}
        output = {{ interval = 0.05 }}
        materials.m = {{ density = 2000.0, normal = {{ law = "linear", stiffness = 500.0, restitution = 0.3 }} }}
        {FLOOR}
        [[particles]]
        material = "m"
        radius = 1e-3
        position = [0.02, 0.05, 1e-3]
        [[particles]]
        material = "m"
        radius = 1e-3
        position = [0.08, 0.05, 1e-3]
        angular_velocity = [0, 0, 10.0]
    "#
    );
    let scene = parse_scene(Path::new("turning.toml"), &text, &[], Files::Unchecked).unwrap();
    let mut engine = Engine::new(Arc::new(plan(&scene).unwrap()), 1).unwrap();
    advance(&mut engine, 0.2);
    assert_eq!(asleep(&engine), 1);
    let spins = engine
        .particles
        .records
        .iter()
        .map(|record| record.angular_velocity.z);
    assert_eq!(spins.sum::<f64>(), 10.0);
}

/// A checkpoint with a sleeper that cannot sleep is refused: where the scene does not enable sleeping, a fixed particle, a
/// particle just woken, a pebble alone.
#[test]
fn nobody_sleeps_in_a_checkpoint_who_cannot() {
    let refused = |plan: Arc<Plan>, change: &dyn Fn(&mut Particles)| {
        let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
        advance(&mut engine, 0.02);
        let saved = engine.snapshot();
        assert!(Engine::restore(Arc::clone(&plan), saved.clone(), 1).is_ok());
        let changed = saved.edited("particles", change).unwrap();
        let error = Engine::restore(plan, changed, 1).err().unwrap();
        error.to_string()
    };
    let message = "a particle sleeps that cannot sleep";
    let first = |flags| move |particles: &mut Particles| particles.records[0].flags |= flags;
    assert!(refused(column(2, "", "", ""), &first(ASLEEP)).contains(message));
    let sleeping = || column(2, "sleeping = {}", "", "");
    assert!(refused(sleeping(), &first(ASLEEP | FIXED)).contains(message));
    assert!(refused(sleeping(), &first(ASLEEP | WOKEN)).contains(message));
    let pebble = |particles: &mut Particles| {
        let records = particles.records.iter_mut();
        let pebbles = records.filter(|record| record.flags & PEBBLE != 0);
        pebbles.take(1).for_each(|record| record.flags |= ASLEEP);
    };
    assert!(refused(restless(true), &pebble).contains(message));
}

/// The energy of particles that fall asleep is all that an audit does not find elsewhere: here they do so while they are fast,
/// and springs are stretched sideways.
#[test]
fn an_audit_closes_over_sleepers() {
    let ball = "[[particles]]\nmaterial = \"m\"\nradius = 1e-3\nposition = [-0.015, 0.01, 0.005]\nvelocity = [0.3, 0, 0]";
    let run = |sleeping: &str| {
        let mut draft = column(4, sleeping, "", ball).draft();
        draft.energy_budget = true;
        let mut engine = Engine::new(Arc::new(draft.plan().unwrap()), 1).unwrap();
        let energy = |engine: &Engine| {
            let of = |record: &crate::state::Particle| {
                let spin = 0.4 * RADIUS * RADIUS * record.angular_velocity.length_squared();
                let twice = record.velocity.length_squared() + spin;
                mass() * (0.5 * twice + G * record.position.z)
            };
            let records = engine.particles.records.iter();
            records.map(of).sum::<f64>() + engine.observation().elastic_energy
        };
        let before = energy(&engine);
        // Before an awake particle rolls out.
        engine.steps_at_once(4_999, None).unwrap();
        engine.step(Some(WITNESS)).unwrap();
        engine.complete_step().unwrap();
        let taken = engine.sleepers().map_or(0.0, |(_, counts)| counts.energy);
        let lost = engine.audit().dissipated();
        let gap = before - energy(&engine) - lost - taken;
        let slept = engine.sleepers().map(|sleepers| sleepers.0);
        (gap / lost, slept, taken / lost)
    };
    let (with, asleep, taken) = run("sleeping = { speed = 0.3, after = 2e-3, imbalance = 0.9 }");
    let (without, ..) = run("");
    assert_eq!(asleep, Some(5));
    assert!(taken > 0.2, "{taken}");
    // The trapezoidal rule: (w dt)^2/12 = 0.4 % for contacts of 14 steps, either way.
    assert!(
        without.abs() < 0.01 && with.abs() < 0.01,
        "{with}, {without}"
    );
}
