//! Dry cohesion in the engine: touches and partings of `jkr`, energies, walls, new lists; T28 and T29.

use std::f64::consts::PI;
use std::path::Path;

use mercury_common::scene::{Files, parse_scene_with};
use mercury_engine::contact::law_keys;
use mercury_engine::forces::{Partner, SlotState};
use mercury_engine::step::Engine;
use mercury_solver::plan::plan;
use mercury_tests::dry::{MASS, PLANE, STICKS, W_S, ball, gap, rebound, velocity};
use mercury_tests::scenes::observed_step;
use mercury_tests::wet::start;

/// e = √(1 − (v_s/v)²) above v_s, and 0 below. The force jumps at the touch by 4/3 π W R* = 2.1e-5 N, so that the step of v dt makes an error of
/// at most 2.1e-5 N × 2.3e-2 m/s × 5e-10 s = 2.4e-16 J in the energy of 1.7e-12 J at 1.05 v_s, of which e² = 0.09 is left: 8e-4 of e.
#[test]
fn a_ball_sticks_to_a_wall_or_rebounds() {
    for part in [0.3, 0.98] {
        assert_eq!(rebound(&mut ball(part * STICKS, PLANE, &[])), 0.0, "{part}");
    }
    for times in [1.05, 1.3, 2.0] {
        let e = rebound(&mut ball(times * STICKS, PLANE, &[])) / (times * STICKS);
        let expected = (1.0 - 1.0 / (times * times)).sqrt();
        assert!((e - expected).abs() < 1e-3, "{times}: {e}, {expected}");
    }
}

/// The budget counts what a touch and a parting lose, 7.0922 (W⁵ R*⁴/E*²)^(1/3), and closes.
#[test]
fn the_loss_of_a_touch_is_counted() {
    for wall in [
        PLANE,
        "shape = \"sphere\"\norigin = [0, 0, -1.0]\nradius = 1.0\nside = \"outside\"",
    ] {
        let mut engine = ball(2.0 * STICKS, wall, &[]);
        let before = 0.5 * MASS * velocity(&engine).powi(2);
        let mut joined = 0;
        while engine.time() < 2e-5 && !(gap(&engine) > 2e-7 && velocity(&engine) > 0.0) {
            observed_step(&mut engine);
            let stored = engine.observation().elastic_energy;
            let now = 0.5 * MASS * velocity(&engine).powi(2);
            let losses = engine.audit().losses;
            assert_eq!(losses.of("adhesion"), losses.total());
            let error = now + stored + losses.total() - before;
            assert!(error.abs() < 1e-3 * W_S, "{error} at {}", gap(&engine));
            let touching = engine.snapshot().near_walls().expect("slots");
            let is_neck = |state| state == SlotState::Touching && gap(&engine) > 1e-8;
            joined += usize::from(touching.iter().any(|slot| is_neck(slot.state)));
        }
        let lost = engine.audit().losses.of("adhesion");
        assert!((lost / W_S - 1.0).abs() < 2e-3, "{lost}");
        assert!(joined > 10, "{joined} steps in the neck");
    }
}

/// In a scene where other pairs stick, a dry pair and a dry ball at a wall have a record in the steps in which they touch, and in no other.
#[test]
fn a_contact_without_adhesion_has_no_record_once_it_is_over() {
    let text = r#"
time = { end = 1.0, step = 5e-9 }
domain = { min = [0, 0, 0], max = [4e-3, 4e-3, 4e-3] }
output = { interval = 1.0 }
[materials.powder]
density = 1500.0
normal = { law = "hertz", youngs_modulus = 1e8, poisson_ratio = 0.3, restitution = 0.8 }
tangential = { law = "mindlin", friction = 0.5 }
adhesion = { law = "jkr", work_of_adhesion = 0.05 }
[materials.glass]
density = 1500.0
normal = { law = "hertz", youngs_modulus = 1e8, poisson_ratio = 0.3, restitution = 0.8 }
tangential = { law = "mindlin", friction = 0.5 }
[[walls]]
name = "floor"
shape = "plane"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
material = "glass"
[[particles]]
material = "powder"
radius = 1e-4
position = [1e-3, 1e-3, 3e-3]
[[particles]]
material = "powder"
radius = 1e-4
position = [1e-3, 2e-3, 3e-3]
[[particles]]
material = "glass"
radius = 1e-4
position = [1.99995e-3, 2e-3, 2e-3]
velocity = [0.1, 0.02, 0.0]
[[particles]]
material = "glass"
radius = 1e-4
position = [2.2e-3, 2e-3, 2e-3]
[[particles]]
material = "glass"
radius = 1e-4
position = [3e-3, 3e-3, 1.00005e-4]
velocity = [0.01, 0.0, -0.1]
"#;
    let mut engine = start(text, &[]);
    let (mut touches, mut partings) = ([0; 2], [0; 2]);
    for _ in 0..6000 {
        observed_step(&mut engine);
        let records = &engine.particles.records;
        let by_id = |id: u32| {
            let ids = &engine.particles.ids;
            let row = ids.iter().position(|other| other.number() == id);
            records[row.expect("all stay")].position
        };
        let overlaps = [2e-4 - by_id(2).distance(by_id(3)), 1e-4 - by_id(4).z];
        let listed = &engine.observation().records;
        let is_wall = |partner: &Partner| matches!(partner, Partner::Wall { .. });
        let at_wall = listed.iter().filter(|one| is_wall(&one.partner)).count();
        for (kind, found) in [listed.len() - at_wall, at_wall].into_iter().enumerate() {
            let touching = overlaps[kind] > 0.0;
            assert_eq!(found, usize::from(touching), "{kind}: {}", overlaps[kind]);
            touches[kind] += usize::from(touching);
            partings[kind] += usize::from(!touching && touches[kind] > 0);
        }
    }
    assert!(touches.iter().chain(&partings).all(|steps| *steps > 100));
}

/// Two spheres whose neck is stretched and swings back, at rest or in fast flight across many new lists (LAMMPS #4685 lost such contacts).
#[test]
fn a_neck_outlasts_new_lists() {
    let pair = |flight: f64| {
        let text = format!(
            r#"
time = {{ end = 1.0, step = 5e-9 }}
domain = {{ min = [0, -1e-3, -1e-3], max = [2e-3, 1e-3, 1e-3], periodic = ["x"] }}
output = {{ interval = 1.0 }}
[materials.powder]
density = 1500.0
normal = {{ law = "hertz", youngs_modulus = 1e8, poisson_ratio = 0.3, restitution = 1.0 }}
tangential = {{ law = "mindlin", friction = 0.5 }}
adhesion = {{ law = "jkr", work_of_adhesion = 0.05 }}
[[particles]]
material = "powder"
radius = 1e-4
position = [1e-3, 0.99999e-4, 0.0]
velocity = [{flight:?}, 0.008, 0.0]
[[particles]]
material = "powder"
radius = 1e-4
position = [1e-3, -0.99999e-4, 0.0]
velocity = [{flight:?}, -0.008, 0.0]
"#
        );
        start(&text, &[])
    };
    let apart = |engine: &Engine| {
        let [a, b] = [0, 1].map(|row| engine.particles.records[row].position.y);
        (a - b).abs() - 2e-4
    };
    let (mut rest, mut flies) = (pair(0.0), pair(50.0));
    let mut widest = 0.0f64;
    for _ in 0..400 {
        for engine in [&mut rest, &mut flies] {
            engine.steps_at_once(20, None).expect("numbers");
        }
        widest = widest.max(apart(&rest));
        // The positions are numbers of 1e-3 m, and the contact swings for some periods.
        assert!(
            (apart(&rest) - apart(&flies)).abs() < 1e-12,
            "{}",
            apart(&flies)
        );
        for engine in [&rest, &flies] {
            let slots = engine.snapshot();
            let touching = (slots.pairs().expect("slots").iter())
                .any(|slot| slot.state == SlotState::Touching);
            assert!(touching, "parted at {}", apart(engine));
        }
    }
    assert!(widest > 1e-8, "the neck was never stretched: {widest}");
    assert!(flies.lists().rebuilds > 5, "{}", flies.lists().rebuilds);
}

/// Pull-off at each kind of wall: a constant force above 3/2 π W R* draws the sphere off, and less than half of it never does.
#[test]
fn the_pull_off_is_that_of_the_law_at_every_kind_of_wall() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("square.stl");
    std::fs::write(
        &mesh,
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex -1e-3 -1e-3 0\nvertex 1e-3 -1e-3 0\nvertex 1e-3 1e-3 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex -1e-3 -1e-3 0\nvertex 1e-3 1e-3 0\nvertex -1e-3 1e-3 0\nendloop\nendfacet\nendsolid s\n",
    )
    .unwrap();
    let mesh = format!("shape = \"mesh\"\nfile = {:?}", mesh.display().to_string());
    for wall in [
        PLANE,
        "shape = \"disc\"\norigin = [0, 0, 0]\naxis = [0, 0, 1]\nradius = 1e-3",
        &mesh,
    ] {
        let pull_off = 1.5 * PI * 0.05 * 1e-4;
        let holds = |part: f64| {
            let force = part * pull_off / MASS;
            let acceleration = format!("gravity=[0.0, 0.0, {force:?}]");
            let set = [
                acceleration.as_str(),
                "materials.powder.normal.restitution=0.5",
                "particles.0.position=[0.0, 0.0, 0.99999e-4]",
                "time.step=1e-9",
            ];
            let mut engine = ball(0.0, wall, &set);
            engine.steps_at_once(100_000, None).expect("numbers");
            gap(&engine) < 1e-7
        };
        // The contact begins at the touch, away from where the forces balance, and overshoots: a constant force of half the pull-off acts
        // like one of twice as much at most.
        assert!(holds(0.45), "{wall}");
        assert!(!holds(1.01), "{wall}");
    }
}

/// The force of the law is the same in the engine: a touch at T29's places.
#[test]
fn laws_pull_as_their_formulas_say() {
    let scene = |adhesion: &str, gap: f64| {
        let place = 1e-4 * (1.0 + 3.0) + gap;
        format!(
            r#"
time = {{ end = 1.0, step = 1e-12 }}
domain = {{ min = [-1e-2, -1e-2, -1e-2], max = [1e-2, 1e-2, 1e-2] }}
output = {{ interval = 1.0 }}
[materials.fine]
density = 1500.0
normal = {{ law = "hertz", youngs_modulus = 1e8, poisson_ratio = 0.3, restitution = 0.8 }}
adhesion = {adhesion}
[[particles]]
material = "fine"
radius = 1e-4
position = [0.0, 0.0, 0.0]
[[particles]]
material = "fine"
radius = 3e-4
position = [{place:?}, 0.0, 0.0]
"#
        )
    };
    // R* = 7.5e-5 m. The gap of 2 nm is a difference of numbers of 4e-4 m, known to 5e-20 m.
    let van_der_waals =
        r#"{ law = "van-der-waals", hamaker = 6.5e-20, separation = 4e-10, range = 1e-8 }"#;
    let reversible = r#"{ law = "reversible", force = 1e-4, stiffness = 10.0 }"#;
    let irreversible = r#"{ law = "irreversible", force = 1e-4, stiffness = 10.0 }"#;
    for (law, gap, expected) in [
        (van_der_waals, 2e-9, 1.335470086e-7),
        (van_der_waals, 1.01e-8, 0.0),
        (reversible, 4e-6, 6e-5),
        (irreversible, 4e-6, 0.0),
    ] {
        let mut engine = start(&scene(law, gap), &[]);
        observed_step(&mut engine);
        let row = usize::from(engine.particles.records[0].radius > 2e-4);
        let force = engine.particles.loads[row].force.x;
        assert!(
            (force - expected).abs() < 1e-9 * 1e-4,
            "{law} at {gap}: {force}"
        );
    }
}

/// The critical step counts the slope of the force: A R*/(3 z0³) of van der Waals forces, k_a of a linear branch, and the larger radius of `jkr`.
#[test]
fn the_critical_step_counts_adhesion() {
    let text = |adhesion: &str, step: &str| {
        format!(
            r#"
time = {{ end = 1.0, step = {step} }}
domain = {{ min = [-1e-2, -1e-2, -1e-2], max = [1e-2, 1e-2, 1e-2] }}
output = {{ interval = 1.0 }}
[materials.fine]
density = 1500.0
normal = {{ law = "hertz", youngs_modulus = 1e8, poisson_ratio = 0.3, restitution = 1.0 }}
{adhesion}
[[particles]]
material = "fine"
radius = 1e-4
position = [0.0, 0.0, 0.0]
velocity = [0.01, 0.0, 0.0]
[[particles]]
material = "fine"
radius = 1e-4
position = [3e-4, 0.0, 0.0]
"#
        )
    };
    let planned = |adhesion: &str, step: &str| {
        let text = text(adhesion, step);
        let scene = parse_scene_with(
            &law_keys(),
            Path::new("t.toml"),
            &text,
            &[],
            Files::Unchecked,
        );
        plan(&scene.unwrap_or_else(|errors| panic!("{errors}")))
    };
    let critical = |adhesion: &str| {
        let plan = planned(adhesion, "\"auto\"").unwrap_or_else(|errors| panic!("{errors}"));
        let limit = plan.notes().step().critical.clone();
        limit.expect("the two can meet")
    };
    let (mass, radius) = (0.5 * MASS, 5e-5);
    let van_der_waals = r#"adhesion = { law = "van-der-waals", hamaker = 6.5e-20, separation = 4e-10, range = 1e-8 }"#;
    let linear = r#"adhesion = { law = "reversible", force = 1e-4, stiffness = 1e4 }"#;
    for (adhesion, stiffness) in [
        (van_der_waals, 6.5e-20 * radius / (3.0 * 4e-10f64.powi(3))),
        (linear, 1e4),
    ] {
        let limit = critical(adhesion);
        let expected = 2.0 * (mass / stiffness).sqrt();
        assert!(
            (limit.time / expected - 1.0).abs() < 1e-9,
            "{adhesion}: {limit:?}, {expected}"
        );
        assert_eq!(limit.part, "adhesion");
        // A step that is too long is refused, with a way out.
        let step = format!("{:e}", 2.0 * expected);
        let errors = planned(adhesion, &step).unwrap_err().to_string();
        assert!(errors.contains("soften the adhesion"), "{errors}");
    }
    let sticky = critical(r#"adhesion = { law = "jkr", work_of_adhesion = 0.05 }"#);
    let smooth = critical("");
    assert!(sticky.time < smooth.time, "{sticky:?}, {smooth:?}");
    assert_eq!(sticky.part, "normal");
}

/// Messages of what cannot be, all at once.
#[test]
fn mistakes_are_named() {
    let text = r#"
time = { end = 1.0, step = 1e-6 }
domain = { min = [0, 0, 0], max = [1, 1, 1] }
output = { interval = 0.1 }
[materials.sticky]
density = 1500.0
normal = { law = "linear", stiffness = 1e3, restitution = 0.8 }
adhesion = { law = "jkr", work_of_adhesion = 0.05 }
[materials.wet]
density = 1500.0
normal = { law = "hertz", youngs_modulus = 1e8, poisson_ratio = 0.3, restitution = 0.8 }
liquid = { law = "bagheri", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-11 }
adhesion = { law = "dmt", work_of_adhesion = 0.05 }
[materials.ion]
density = 1500.0
normal = { law = "linear", stiffness = 1e3, restitution = 0.8 }
adhesion = { law = "charged", charge = 0.5, force = 1e-4, stiffness = 10.0 }
[[contacts]]
between = ["sticky", "wet"]
normal = { law = "linear", stiffness = 1e3, restitution = 0.8 }
[[contacts]]
between = ["wet", "ion"]
normal = { law = "linear", stiffness = 1e3, restitution = 0.8 }
adhesion = { law = "dmt" }
[[contacts]]
between = ["sticky", "ion"]
adhesion = { law = "dmt", work_of_adhesion = 0.1 }
[[particles]]
material = "sticky"
radius = 1e-2
position = [0.1, 0.1, 0.1]
[[particles]]
material = "sticky"
radius = 1e-2
position = [0.2, 0.1, 0.1]
[[particles]]
material = "wet"
radius = 1e-2
position = [0.3, 0.1, 0.1]
[[particles]]
material = "wet"
radius = 1e-2
position = [0.4, 0.1, 0.1]
[[particles]]
material = "ion"
radius = 1e-2
position = [0.5, 0.1, 0.1]
[[particles]]
material = "ion"
radius = 1e-2
position = [0.6, 0.1, 0.1]
"#;
    let scene = parse_scene_with(
        &law_keys(),
        Path::new("t.toml"),
        text,
        &[],
        Files::Unchecked,
    );
    let errors = plan(&scene.unwrap_or_else(|errors| panic!("{errors}"))).unwrap_err();
    let errors = errors.to_string();
    for expected in [
        "t.toml:8:",
        "adhesion.law = \"jkr\" of the contacts of `sticky` and `sticky` needs the normal law \"hertz\"",
        "the contacts of `wet` and `wet` have both liquid and adhesion: a pair has one of the two",
        "have no adhesion law in common: `sticky` has jkr, `wet` has dmt",
        "adhesion.charge = 0.5 is none of -1, 0 and 1",
    ] {
        assert!(errors.contains(expected), "{expected}\n{errors}");
    }
    // A key that is wrong alone.
    for (keys, expected) in [
        (
            r#"{ law = "van-der-waals", hamaker = 1e-20, range = 1e-8 }"#,
            "separation",
        ),
        (
            r#"{ law = "dmt", work_of_adhesion = -0.05 }"#,
            "must be >= 0",
        ),
        (
            r#"{ law = "reversible", force = 1e-4, stiffness = -10.0 }"#,
            "must be > 0",
        ),
        (r#"{ law = "sjkr" }"#, "jkr, dmt, van-der-waals"),
    ] {
        let text = format!(
            "time = {{ end = 1.0, step = 1e-6 }}\ndomain = {{ min = [0, 0, 0], max = [1, 1, 1] }}\noutput = {{ interval = 0.1 }}\n[materials.m]\ndensity = 1.0\nnormal = {{ law = \"linear\", stiffness = 1.0, restitution = 0.5 }}\nadhesion = {keys}\n"
        );
        let scene = parse_scene_with(
            &law_keys(),
            Path::new("t.toml"),
            &text,
            &[],
            Files::Unchecked,
        );
        let errors = scene.expect_err(keys).to_string();
        assert!(
            errors.contains("t.toml:7:") && errors.contains(expected),
            "{errors}"
        );
    }
}
