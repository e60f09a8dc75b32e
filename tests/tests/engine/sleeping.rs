//! Particles that sleep: they behave as particles that never sleep, and disturbed ones wake.
//!
//! Where a closed form is known both must meet it. Else the same scene is run with and without `[sleeping]`; the bounds are those of
//! `docs/theory/sleeping.md`: each load is wrong by at most a part [`IMBALANCE`] of the weight above it.

use glam::DVec3;
use mercury_engine::forces::Watch;
use mercury_engine::state::{ASLEEP, Particle};
use mercury_engine::step::Engine;
use mercury_tests::sleeping_scenes::{
    D, G, IMBALANCE, R, STIFFNESS, Scene, TIME_STEP, advance_by, asleep, load_on_walls, mass,
    weight,
};

/// Seconds in which a sound goes through a bed of this depth (m), about: d sqrt(m/k) for a layer.
fn crossing(depth: f64) -> f64 {
    depth / D * (mass() / STIFFNESS).sqrt()
}

fn mean(engine: &Engine, of: impl Fn(&Particle) -> f64) -> f64 {
    let records = &engine.particles.records;
    records.iter().map(of).sum::<f64>() / records.len() as f64
}

/// Of translation, J.
fn kinetic_energy(engine: &Engine) -> f64 {
    let of = |record: &Particle| 0.5 / record.inverse_mass * record.velocity.length_squared();
    engine.particles.records.iter().map(of).sum()
}

/// A bed on a floor that begins to vibrate with half the acceleration of gravity: it goes along as one, with the kinetic energy M (A w)^2/4 on average
/// but for what its own sound adds, 1/cos(w H/c)^2 at its top.
#[test]
fn a_floor_that_begins_to_vibrate_wakes_the_whole_bed() {
    let (amplitude, frequency, from) = (5e-5, 50.0, 0.4);
    let omega = std::f64::consts::TAU * frequency;
    let scene = Scene::bed(110).floor(&format!(
        r#"motion = [{{ kind = "oscillation", amplitude = [0, 0, {amplitude}], frequency = {frequency}, from = {from} }}]"#
    ));
    let [with, without] = scene.both(|engine| {
        advance_by(engine, from);
        let (before, slept) = (mean(engine, |p| p.position.z), asleep(engine));
        let depth = 2.0 * before;
        advance_by(engine, 10.0 * crossing(depth));
        let left = asleep(engine);
        // Four periods from the second on, seen fifty times each.
        advance_by(engine, 1.0 / frequency - 10.0 * crossing(depth));
        let (mut energy, mut height) = (0.0, 0.0);
        for _ in 0..200 {
            advance_by(engine, 0.02 / frequency);
            energy += kinetic_energy(engine) / 200.0;
            height += mean(engine, |p| p.position.z) / 200.0;
        }
        assert!(slept.is_none_or(|slept| slept > 90), "{slept:?}");
        assert!(left.is_none_or(|left| left == 0), "{left:?} sleep on");
        let expected = 0.25 * weight(engine) / G * (amplitude * omega).powi(2);
        let sound = (omega * crossing(depth)).cos().powi(-2);
        assert!(
            energy > 0.98 * expected && energy < 1.25 * sound * expected,
            "{energy} J, {expected} J"
        );
        (energy, height)
    });
    assert!(
        (with.0 / without.0 - 1.0).abs() < 0.01,
        "{with:?}, {without:?}"
    );
    assert!(
        (with.1 - without.1).abs() < 1e-3 * D,
        "{with:?}, {without:?}"
    );
}

/// A sphere with rolling friction on a floor that is tilted bit by bit rolls off where tan(slope) exceeds the coefficient, whether it
/// slept between two turns of the floor or not.
#[test]
fn a_floor_that_tilts_lets_sleepers_roll_off_at_the_same_slope() {
    let (friction, by): (f64, f64) = (0.1, 0.5);
    let first = friction.atan().to_degrees() / by;
    let turns: Vec<String> = (0..14)
        .map(|k| {
            let (from, speed) = (0.1 + 0.08 * k as f64, by.to_radians() / 0.03);
            format!(
                r#"{{ kind = "rotation", axis = [0, 1, 0], origin = [0, 0, 0], angular_velocity = {speed}, from = {from}, until = {} }}"#,
                from + 0.03
            )
        })
        .collect();
    let scene = Scene::empty()
        .floor(&format!("motion = [{}]", turns.join(", ")))
        .sphere([0.0, -0.006, R], "")
        .sphere([0.0, 0.0, R], "")
        .sphere([0.0, 0.006, R], "");
    scene.both(|engine| {
        // Each time to shortly before the next turn begins.
        advance_by(engine, 0.099);
        for k in 1..=14 {
            advance_by(engine, 0.08);
            let slope = f64::from(k) * by;
            let rests = f64::from(k) < first;
            for record in &engine.particles.records {
                let way = record.position.x - R * slope.to_radians().sin();
                assert_eq!(way.abs() < 0.02 * R, rests, "{slope} degrees: {way} m");
            }
            assert!(asleep(engine).is_none_or(|asleep| asleep == if rests { 3 } else { 0 }));
        }
    });
}

/// A heavy ball hits a bed that sleeps. It goes as deep as into one that does not, and the walls take its momentum but for what sleepers
/// keep back: [`IMBALANCE`] of the weight of each as long as it sleeps.
#[test]
fn a_blow_goes_as_deep_into_sleepers() {
    let (from, speed, diameter) = (0.45, 1.5, 3.6e-3);
    let scene = Scene::trough(0.04, 300, "").steel().and(&format!(
        r#"
        [[insertions]]
        name = "ball"
        region = {{ shape = "box", min = [0.004, 0.002, 0.02], max = [0.0078, 0.0058, 0.0238] }}
        material = "steel"
        psd = {{ kind = "monodisperse", diameter = {diameter} }}
        total = {{ number = 1 }}
        from = {from}
        velocity = {{ mean = [0, 0, {}] }}
    "#,
        -speed
    ));
    let time = 0.12;
    let [with, without] = scene.both(|engine| {
        advance_by(engine, from);
        let slept = asleep(engine);
        let (mut impulse, mut kept_back) = (0.0, 0.0);
        for _ in 0..(time / TIME_STEP) as u64 {
            engine.step(Some(Watch::default())).unwrap();
            impulse += load_on_walls(engine) * TIME_STEP;
            let sleepers = engine.particles.records.iter();
            let sleepers = sleepers.filter(|p| p.flags & ASLEEP != 0);
            let weights: f64 = sleepers.map(|p| G / p.inverse_mass).sum();
            kept_back += IMBALANCE * weights * TIME_STEP;
        }
        engine.complete_step().unwrap();
        let mut records = engine.particles.records.iter();
        let momentum = |p: &Particle| p.velocity.z / p.inverse_mass;
        let left: f64 = records.clone().map(momentum).sum();
        let ball = records.find(|p| p.radius > 0.4 * diameter).unwrap();
        let brought = speed / ball.inverse_mass;
        let off = impulse - weight(engine) * time - brought - left;
        (ball.position.z, off, brought, kept_back, slept)
    });
    assert!(with.4 > Some(250), "{with:?}");
    // It has gone in by more than its radius. Where exactly it stops depends on how single grains give way, which differs from the first
    // round-off on: by less than one of them.
    for depth in [with.0, without.0] {
        assert!(depth < 0.0065, "{with:?}, {without:?}");
    }
    assert!((with.0 - without.0).abs() < D, "{with:?}, {without:?}");
    assert!(without.1.abs() < 0.01 * without.2, "{without:?}");
    assert!((with.1 - without.1).abs() < with.3, "{with:?}, {without:?}");
    // They woke, so that is little.
    assert!(with.3 < 0.05 * with.2, "{with:?}");
}

/// A grain lands on one end of a long bed that sleeps: those at the other end sleep on.
#[test]
fn a_grain_that_lands_wakes_its_neighbourhood_only() {
    let scene = Scene::trough(0.04, 120, "").and(
        r#"
        [[insertions]]
        name = "grain"
        region = { shape = "box", min = [0.004, 0.002, 0.01], max = [0.007, 0.005, 0.013] }
        material = "m"
        psd = { kind = "monodisperse", diameter = 2e-3 }
        total = { number = 1 }
        from = 0.6
    "#,
    );
    let mut engine = scene.start("sleeping = {}");
    let sleepers = |engine: &Engine, is_near: bool| {
        let records = engine.particles.records.iter();
        let meant = records.filter(|p| (p.position.x < 0.02) == is_near);
        meant.filter(|p| p.flags & ASLEEP != 0).count()
    };
    advance_by(&mut engine, 0.6);
    let before = [true, false].map(|is_near| sleepers(&engine, is_near));
    let mut least = before;
    for _ in 0..1000 {
        advance_by(&mut engine, 1e-4);
        for (least, is_near) in least.iter_mut().zip([true, false]) {
            *least = sleepers(&engine, is_near).min(*least);
        }
    }
    assert!(before[0] > 50 && before[1] > 50, "{before:?}");
    assert!(least[0] < before[0], "{before:?}, {least:?}");
    assert!(4 * least[1] > 3 * before[1], "{before:?}, {least:?}");
}

/// A frictionless bed sleeps behind a wall, which goes: it flows.
#[test]
fn a_side_wall_that_goes_lets_the_bed_flow() {
    let gone = 0.5;
    let scene = Scene::trough(0.02, 160, &format!("until = {gone}")).frictionless();
    let [with, without] = scene.both(|engine| {
        advance_by(engine, gone);
        let slept = asleep(engine);
        let before = mean(engine, |p| p.position.x);
        let ways = [0.01, 0.02, 0.04, 0.08].map(|until| {
            let left = gone + until - engine.time();
            advance_by(engine, left);
            mean(engine, |p| p.position.x) - before
        });
        (slept, ways, asleep(engine))
    });
    assert!(with.0 > Some(140) && with.2 == Some(0), "{with:?}");
    for (with, without) in with.1.into_iter().zip(without.1) {
        assert!((with / without - 1.0).abs() < 0.01, "{with} m, {without} m");
    }
}

/// Rain on a bed that sleeps: in the end all sleep, and the floor carries all of it.
#[test]
fn rain_on_a_sleeping_bed_ends_up_on_the_floor() {
    let scene = Scene::bed(60).rain(60, 120, 0.2);
    let [with, without] = scene.both(|engine| {
        advance_by(engine, 1.2);
        engine.step(Some(Watch::default())).unwrap();
        let off = load_on_walls(engine) / weight(engine) - 1.0;
        engine.complete_step().unwrap();
        (asleep(engine), off, mean(engine, |p| p.position.z))
    });
    assert!(with.0 > Some(110), "{with:?}");
    assert!(with.1.abs() < IMBALANCE, "{with:?}");
    assert!(without.1.abs() < 0.01, "{without:?}");
    assert!(
        (with.2 - without.2).abs() < 0.05 * D,
        "{with:?}, {without:?}"
    );
}

/// A particle that stays asleep was in balance: in each step of a restless scene, no sleeper that was out of balance after one
/// step sleeps after the next.
#[test]
fn nobody_sleeps_out_of_balance() {
    let scene = Scene::bed(60).rain(5, 20, 0.3);
    // With the default, and so fast that dashpots matter; their forces are gone when a moving particle is put to rest.
    for sleeping in ["sleeping = {}", "sleeping = { speed = 5e-3, after = 1e-3 }"] {
        let mut engine = scene.start(sleeping);
        let (mut out, mut tested) = (Vec::new(), 0);
        for _ in 0..(0.7 / TIME_STEP) as u64 {
            engine.step(None).unwrap();
            for id in &out {
                let row = engine.particles.ids.iter().position(|other| other == id);
                let record = &engine.particles.records[row.unwrap()];
                assert_eq!(record.flags & ASLEEP, 0, "{id:?} at {} s", engine.time());
            }
            out.clear();
            let particles = &engine.particles;
            for (row, record) in particles.records.iter().enumerate() {
                if record.flags & ASLEEP == 0 {
                    continue;
                }
                tested += 1;
                assert_eq!(record.velocity, DVec3::ZERO);
                let load = &particles.loads[row];
                let force = load.force * record.inverse_mass - G * DVec3::Z;
                let torque = load.torque.length() * record.inverse_mass / record.radius;
                if force.length().max(torque) > IMBALANCE * G {
                    out.push(particles.ids[row]);
                }
            }
        }
        assert!(tested > 100_000, "{tested}");
    }
}

/// A pusher that comes from far away takes a sleeper along: a wall, or a particle that is driven, also through a periodic face.
#[test]
fn a_pusher_from_outside_wakes_whom_it_touches() {
    let wall = r#"
        [[walls]]
        name = "pusher"
        shape = "plane"
        point = [-0.02, 0, 0]
        normal = [1, 0, 0]
        material = "m"
        motion = [{ kind = "translation", velocity = [0.05, 0, 0] }]
    "#;
    let drive = "prescribed = { velocity = [0.05, 0, 0], angular_velocity = [0, 0, 0] }";
    let lone = Scene::empty().sphere([0.0, 0.0, R], "");
    // Surfaces are apart by 0.019 m, 0.018 m, and again 0.018 m through the face at 0.02 m.
    let pushers = [
        (lone.clone().and(wall), 0.019),
        (lone.clone().sphere([-0.02, 0.0, R], drive), 0.018),
        (
            lone.periodic_x(0.02).sphere([0.0199, 0.0, R], drive),
            0.0181,
        ),
    ];
    for (scene, gap) in pushers {
        let [with, without] = scene.both(|engine| {
            advance_by(engine, 0.2);
            let slept = asleep(engine);
            advance_by(engine, gap / 0.05 + 0.1 - 0.2);
            let row = engine.particles.rows_by_id()[0] as usize;
            (slept, engine.particles.records[row].position.x)
        });
        assert_eq!(with.0, Some(1));
        assert!(without.1 > 0.0045, "{} m", without.1);
        assert!(
            (with.1 - without.1).abs() < 1e-6,
            "{}, {} m",
            with.1,
            without.1
        );
    }
}

/// A lid with a servo comes down on a bed that sleeps: in the end the floor carries both.
#[test]
fn a_servo_presses_through_sleepers() {
    let force = 20.0 * mass() * G;
    let scene = Scene::bed(60).and(&format!(
        r#"
        [[walls]]
        name = "lid"
        shape = "plane"
        point = [0, 0, 0.02]
        normal = [0, 0, -1]
        material = "m"
        motion = [{{ kind = "servo", axis = [0, 0, -1], force = {force}, max_speed = 0.03, from = 0.35 }}]
    "#
    ));
    let [with, without] = scene.both(|engine| {
        advance_by(engine, 0.35);
        let slept = asleep(engine);
        advance_by(engine, 0.6);
        let mut load = 0.0;
        for _ in 0..500 {
            engine.step(Some(Watch::default())).unwrap();
            load -= engine.observation().walls[0].0.force.z / 500.0;
        }
        engine.complete_step().unwrap();
        let expected = weight(engine) + force;
        let off = (load - expected) / weight(engine);
        (slept, off, mean(engine, |p| p.position.z))
    });
    assert!(with.0 > Some(50), "{with:?}");
    assert!(
        with.1.abs() < IMBALANCE && without.1.abs() < 0.01,
        "{with:?}, {without:?}"
    );
    assert!(
        (with.2 - without.2).abs() < 0.01 * D,
        "{with:?}, {without:?}"
    );
}

/// A sphere of a sleeping column is gone, as if it had left through a face of the domain: those above fall freely, those below are relieved of them.
#[test]
fn who_loses_a_supporter_falls() {
    // All stand at the edge of a region that removes particles.
    let mut scene = Scene::empty().and(
        "[[deletions]]\nname = \"out\"\nregion = { shape = \"half-space\", point = [1e-5, 0, 0], normal = [1, 0, 0] }\n",
    );
    for k in 0..6 {
        scene = scene.sphere([0.0, 0.0, (2 * k + 1) as f64 * R], "");
    }
    let mut engine = scene.start("sleeping = {}");
    advance_by(&mut engine, 0.4);
    assert_eq!(asleep(&engine), Some(6));
    let heights = |engine: &Engine| -> Vec<f64> {
        let rows = engine.particles.rows_by_id();
        let height = |&row: &u32| engine.particles.records[row as usize].position.z;
        rows.iter().map(height).collect()
    };
    let before = heights(&engine);
    let row = engine.particles.rows_by_id()[3] as usize;
    engine.particles.records[row].position.x = 0.01;
    let time = 0.012;
    advance_by(&mut engine, time);
    assert_eq!(engine.particles.len(), 5);
    // Two steps pass before the loss is felt.
    let fallen = 0.5 * G * time * time;
    let late = 3.0 * G * time * TIME_STEP;
    let after = heights(&engine);
    // Three weights less on each contact below; each was and is in balance to a twentieth of the weights above it.
    let compression = mass() * G / STIFFNESS;
    for rank in 0..3 {
        let contacts = (rank + 1) as f64;
        let rise = after[rank] - before[rank] - 3.0 * contacts * compression;
        assert!(
            rise.abs() < 0.05 * (6.0 + 3.0) * contacts * compression,
            "{rank}: {rise} m"
        );
    }
    for (rank, height) in after.into_iter().enumerate().skip(3) {
        let was = (2 * rank + 3) as f64 * R;
        let compressed = 25.0 * mass() * G / STIFFNESS;
        assert!(
            (was - height - fallen).abs() < late + compressed,
            "{height} m"
        );
    }
}
