//! Clumps that sleep: each as a whole, and woken by what happens to any of its pebbles.

use mercury_engine::state::ASLEEP;
use mercury_engine::step::Engine;
use mercury_tests::sleeping_scenes::{
    D, G, IMBALANCE, Scene, TIME_STEP, advance_by, asleep, load_on_walls, weight,
};

/// Mean height of the centres of mass, m.
fn height(engine: &Engine) -> f64 {
    let bodies = engine.particles.bodies();
    bodies.iter().map(|body| body.position.z).sum::<f64>() / bodies.len() as f64
}

/// A heap of `count` rods in a periodic box; `floor`: keys of that.
fn rods(count: u32, floor: &str) -> Scene {
    Scene::periodic().clumps().floor(floor).and(&format!(
        r#"
        [[insertions]]
        name = "rods"
        region = {{ shape = "box", min = [0, 0, 0.0], max = [0.008, 0.008, 0.06] }}
        clump = "rod"
        psd = {{ kind = "monodisperse", diameter = 2.88e-3 }}
        total = {{ number = {count} }}
    "#
    ))
}

/// A heap of rods comes to rest and sleeps, and the floor carries it. Then the floor begins to vibrate: all wake, and jump as those that never slept.
#[test]
fn a_heap_of_rods_sleeps_and_wakes() {
    let from = 0.6;
    let scene = rods(
        30,
        &format!(
            r#"motion = [{{ kind = "oscillation", amplitude = [0, 0, 1e-4], frequency = 80, from = {from} }}]"#
        ),
    );
    let [with, without] = scene.both(|engine| {
        advance_by(engine, from - 10.0 * TIME_STEP);
        let slept = asleep(engine);
        engine.step(Some(Default::default())).unwrap();
        let off = load_on_walls(engine) / weight(engine) - 1.0;
        engine.complete_step().unwrap();
        let before = height(engine);
        advance_by(engine, 9.0 * TIME_STEP + 0.25 / 80.0);
        let risen = height(engine) - before;
        (slept, off, risen, asleep(engine))
    });
    assert!(with.0 > Some(26), "{with:?}");
    assert!(
        with.1.abs() < IMBALANCE && without.1.abs() < 0.01,
        "{with:?}, {without:?}"
    );
    assert_eq!(with.3, Some(0));
    assert!(
        (with.2 / without.2 - 1.0).abs() < 0.02,
        "{with:?}, {without:?}"
    );
}

/// No body sleeps on that was out of balance, and all pebbles of one sleep or none.
#[test]
fn no_body_sleeps_out_of_balance() {
    for sleeping in ["sleeping = {}", "sleeping = { speed = 5e-3, after = 1e-3 }"] {
        let mut engine = rods(20, "").start(sleeping);
        let (mut out, mut tested) = (Vec::new(), 0);
        for _ in 0..(0.6 / TIME_STEP) as u64 {
            engine.step(None).unwrap();
            let particles = &engine.particles;
            for (index, body) in particles.bodies().iter().enumerate() {
                let pebbles = &particles.bodies.as_ref().unwrap().pebbles[body.pebbles()];
                for pebble in pebbles {
                    let record = &particles.records[pebble.row.index()];
                    assert_eq!(record.flags & ASLEEP, body.flags & ASLEEP);
                }
                if body.flags & ASLEEP == 0 {
                    out.retain(|other| *other != index);
                    continue;
                }
                assert!(!out.contains(&index), "{index} at {} s", engine.time());
                tested += 1;
                let mut force = body.load.force / body.mass;
                force.z -= G;
                let torque = body.load.torque.length() / (body.mass * body.radius);
                if force.length().max(torque) > IMBALANCE * G {
                    out.push(index);
                }
            }
        }
        assert!(tested > 50_000, "{tested}");
    }
}

/// A block lies on a floor that is tilted bit by bit: it slides off where tan(slope) exceeds the coefficient of friction, asleep before or not.
#[test]
fn a_block_that_sleeps_slides_at_the_angle_of_friction() {
    let (friction, by): (f64, f64) = (0.5, 2.0);
    let first = friction.atan().to_degrees() / by;
    let turns: Vec<String> = (0..15)
        .map(|k| {
            let (from, speed) = (0.1 + 0.1 * k as f64, by.to_radians() / 0.05);
            format!(
                r#"{{ kind = "rotation", axis = [0, 1, 0], origin = [0, 0, 0], angular_velocity = {speed}, from = {from}, until = {} }}"#,
                from + 0.05
            )
        })
        .collect();
    // On its largest face.
    let block = r#"
        [[particles]]
        clump = "domino"
        scale = 0.2
        position = [0, 0, 0.0008]
    "#;
    let scene = Scene::empty()
        .clumps()
        .floor(&format!("motion = [{}]", turns.join(", ")))
        .and(block);
    scene.both(|engine| {
        advance_by(engine, 0.099);
        for k in 1..=15 {
            advance_by(engine, 0.1);
            let slope = f64::from(k) * by;
            let rests = f64::from(k) < first;
            let slope = slope.to_radians();
            let place = engine.particles.bodies()[0].position;
            let way = place.x * slope.cos() - place.z * slope.sin();
            assert_eq!(way.abs() < 1e-4, rests, "{slope}: {way} m");
            assert!(asleep(engine).is_none_or(|asleep| asleep == u64::from(rests)));
        }
    });
}

/// A standing block that sleeps is touched near its top by spheres that are driven: it topples as one that did not sleep, and so does the next one.
#[test]
fn blocks_that_sleep_topple_one_another() {
    let mut scene = Scene::empty().clumps();
    for k in 0..2 {
        scene = scene.and(&format!(
            "[[particles]]\nclump = \"domino\"\nscale = 0.2\norientation = [{h}, 0, -{h}, 0]\nposition = [{}, 0, 0.0048]\n",
            f64::from(k) * 0.005,
            h = 0.5f64.sqrt()
        ));
    }
    // The pebbles of a block stand at its edges.
    for y in [-0.0019, 0.0019] {
        let drive = "prescribed = { velocity = [0.05, 0, 0], angular_velocity = [0, 0, 0] }";
        scene = scene.sphere([-0.02, y, 0.008], drive);
    }
    let [with, without] = scene.both(|engine| {
        advance_by(engine, 0.25);
        let slept = asleep(engine);
        let places = [0.14, 0.03, 0.08].map(|more| {
            advance_by(engine, more);
            engine
                .particles
                .bodies()
                .iter()
                .map(|body| body.position)
                .collect::<Vec<_>>()
        });
        (slept, places)
    });
    assert_eq!(with.0, Some(2));
    for (with, without) in with.1.iter().flatten().zip(without.1.iter().flatten()) {
        assert!(with.distance(*without) < 0.02 * D, "{with} {without}");
    }
    // Both lie.
    assert!(with.1[2].iter().all(|place| place.z < 0.004), "{with:?}");
}
