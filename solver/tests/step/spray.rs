//! Droplets: when they leave, how they fly, what catches them, and where their liquid is.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::scene::Files;
use proptest::prelude::*;

use mercury_common::particle_properties::FILM_VOLUME;
use mercury_engine::spray::volume_of;
use mercury_engine::step::{Engine, Snapshot, StartOptions};
use mercury_solver::plan::{Plan, parse_scene, plan};

fn planned(text: &str) -> Arc<Plan> {
    let scene = parse_scene(Path::new("spray.toml"), text, &[], Files::MustExist);
    let plan = scene.and_then(|scene| plan(&scene));
    Arc::new(plan.unwrap_or_else(|errors| panic!("{errors}")))
}

fn start(plan: &Arc<Plan>, threads: usize) -> Engine {
    Engine::start(Arc::clone(plan), StartOptions::threads(threads)).unwrap()
}

/// A box of 0.1 m with steps of `step` (s), and more.
fn scene(step: f64, more: &str) -> String {
    format!(
        r#"seed = 3
        time = {{ end = 1.0, step = {step:e} }}
        domain = {{ min = [0, 0, 0], max = [0.1, 0.1, 0.1] }}
        output = {{ interval = 0.1 }}
        [materials.grain]
        density = 2500.0
        normal = {{ law = "linear", stiffness = 1000.0, dissipation = 0.0 }}
        {more}"#
    )
}

/// A nozzle in the middle of the top that sprays down, and more keys.
fn nozzle(pattern: &str, speed: &str, more: &str) -> String {
    format!(
        r#"[[sprays]]
        name = "nozzle"
        position = [0.05, 0.05, 0.09]
        axis = [0, 0, -1]
        pattern = {pattern}
        flow_rate = 1e-6
        speed = {speed}
        droplets = {{ kind = "monodisperse", diameter = 2e-4 }}
        liquid_density = 1000.0
        {more}
        "#
    )
}

const CONE: &str = r#"{ kind = "full-cone", half_angle_degrees = 20.0 }"#;

fn films(engine: &Engine) -> Vec<f64> {
    let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap();
    let rows = engine.particles.rows_by_id();
    rows.iter().map(|&row| films[row as usize]).collect()
}

/// Emitted volume is what the flow brought, less a droplet at most, in every step; droplets leave at their own instant.
#[test]
fn droplets_leave_when_the_flow_has_brought_them() {
    // A droplet of 4.19e-12 m^3 each 4.19e-6 s: two or three in a step.
    let step = 1e-5;
    let plan = planned(&scene(step, &nozzle(CONE, "1.0", "gravity = false")));
    let mut engine = start(&plan, 1);
    let one = volume_of(1e-4);
    let mut ages = Vec::new();
    for k in 1..=1000u32 {
        let known = engine.sprays().unwrap().state.next_id;
        engine.step(None).unwrap();
        let state = &engine.sprays().unwrap().state;
        let brought = 1e-6 * step * f64::from(k);
        let emitted = state.balance.emitted.value();
        let slack = 1e-12 * brought;
        assert!(emitted <= brought + slack && brought < emitted + one + slack);
        let new = state.droplets.iter().filter(|droplet| droplet.id >= known);
        // Its age follows from how far it went.
        let place = dvec3(0.05, 0.05, 0.09);
        ages.extend(new.map(|droplet| droplet.position.distance(place) / (1.0 * step)));
    }
    // Even over the step: mean 1/2, variance 1/12, each within five standard errors of as many even numbers.
    let n = ages.len() as f64;
    assert!(n > 2000.0 && ages.iter().all(|age| (0.0..1.0 + 1e-9).contains(age)));
    let mean = ages.iter().sum::<f64>() / n;
    let square = ages.iter().map(|age| age * age).sum::<f64>() / n;
    assert!((mean - 0.5).abs() < 5.0 * (1.0 / 12.0 / n).sqrt(), "{mean}");
    assert!(
        (square - 1.0 / 3.0).abs() < 5.0 * (4.0 / 45.0 / n).sqrt(),
        "{square}"
    );
}

/// T33: along (1, 2, -2)/3 with 2 m/s, the cosine of the angle is even in [cos 20, 1], and the speed is 2 m/s to round-off.
#[test]
fn a_full_cone_is_even_in_the_solid_angle() {
    let text = nozzle(CONE, "2.0", "gravity = false").replace("[0, 0, -1]", "[1, 2, -2]");
    let text = text.replace("[0.05, 0.05, 0.09]", "[0.03, 0.02, 0.09]");
    let plan = planned(&scene(1e-5, &text));
    let mut engine = start(&plan, 1);
    for _ in 0..2000 {
        engine.step(None).unwrap();
    }
    let axis = dvec3(1.0, 2.0, -2.0) / 3.0;
    let droplets = &engine.sprays().unwrap().state.droplets;
    let mut shares: Vec<f64> = Vec::new();
    for droplet in droplets {
        assert!((droplet.velocity.length() - 2.0).abs() < 2e-12);
        let cosine = droplet.velocity.dot(axis) / 2.0;
        let least = 20f64.to_radians().cos();
        shares.push((cosine - least) / (1.0 - least));
    }
    shares.sort_by(f64::total_cmp);
    // Kolmogorov and Smirnov: above 2/sqrt(n) once in 1,500 samples.
    let n = shares.len() as f64;
    assert!(n > 4000.0);
    let distance = (shares.iter().enumerate())
        .map(|(k, share)| ((k as f64 + 0.5) / n - share).abs())
        .fold(0.0, f64::max);
    assert!(distance < 2.0 / n.sqrt(), "{distance}");
}

/// Without drag the path is the parabola at any step, from the instant at which a droplet leaves.
#[test]
fn a_droplet_flies_along_the_parabola() {
    for step in [1e-3, 3e-4] {
        let file = tempfile::NamedTempFile::new().unwrap();
        let row = "t,x,y,z,vx,vy,vz,diameter\n0.00042,0.02,0.05,0.02,0.5,0.1,0.9,2e-4\n";
        std::fs::write(file.path(), row).unwrap();
        let text = format!(
            "gravity = [0, 0, -9.81]\n{}",
            scene(
                step,
                &format!(
                    r#"[[sprays]]
                    name = "one"
                    pattern = {{ kind = "points", file = '{}' }}
                    liquid_density = 1000.0"#,
                    file.path().display()
                )
            )
        );
        let plan = planned(&text);
        let mut engine = start(&plan, 1);
        while engine.time() < 0.05 {
            engine.step(None).unwrap();
        }
        let t = engine.time() - 0.00042;
        let state = &engine.sprays().unwrap().state;
        let [droplet] = state.droplets[..] else {
            panic!("{:?}", state.droplets);
        };
        let start = dvec3(0.02, 0.05, 0.02);
        let velocity = dvec3(0.5, 0.1, 0.9);
        let gravity = dvec3(0.0, 0.0, -9.81);
        let expected = start + t * velocity + 0.5 * t * t * gravity;
        assert!(droplet.position.distance(expected) < 1e-15 * 200.0);
        assert!(droplet.velocity.distance(velocity + t * gravity) < 1e-13);
    }
}

/// With drag the error falls with the square of the step.
#[test]
fn drag_is_of_second_order() {
    let drag = r#"drag = { law = "schiller-naumann", gas_density = 1.2, gas_viscosity = 1.8e-5, gas_velocity = [0.5, 0.0, 0.0] }"#;
    let end_of = |steps: u32| {
        let file = tempfile::NamedTempFile::new().unwrap();
        let row = "t,x,y,z,vx,vy,vz,diameter\n0,0.01,0.05,0.09,3.0,0,-1.0,1e-4\n";
        std::fs::write(file.path(), row).unwrap();
        let more = format!(
            r#"[[sprays]]
            name = "one"
            pattern = {{ kind = "points", file = '{}' }}
            liquid_density = 1000.0
            {drag}"#,
            file.path().display()
        );
        let step = 0.02 / f64::from(steps);
        let text = format!("gravity = [0, 0, -9.81]\n{}", scene(step, &more));
        let plan = planned(&text);
        let mut engine = start(&plan, 1);
        // The row of t = 0 leaves in the first step and flies all of it.
        for _ in 0..steps {
            engine.step(None).unwrap();
        }
        let droplet = engine.sprays().unwrap().state.droplets[0];
        (droplet.position, droplet.velocity)
    };
    let exact = end_of(6400);
    let error = |steps: u32| {
        let found = end_of(steps);
        (found.0.distance(exact.0), found.1.distance(exact.1))
    };
    let (coarse, fine) = (error(25), error(100));
    // 16 for the second order; what lies beyond it is of the third.
    for ratio in [coarse.0 / fine.0, coarse.1 / fine.1] {
        assert!((12.0..20.0).contains(&ratio), "{coarse:?} {fine:?}");
    }
}

/// At 400 m/s a droplet goes 4 mm in a step, past grains of 1 mm: the first on the path catches it, and none behind.
#[test]
fn the_first_on_the_path_catches_at_any_speed() {
    let grains: String = [0.06, 0.05, 0.04]
        .iter()
        .map(|z| {
            format!(
                "[[particles]]\nmaterial = \"grain\"\nradius = 5e-4\nposition = [0.05, 0.05, {z}]\n"
            )
        })
        .collect();
    let wall = "[[walls]]\nname = \"shelf\"\nshape = \"plane\"\npoint = [0, 0, 0.011]\nnormal = [0, 0, 1]\nmaterial = \"grain\"\n";
    let fan = r#"{ kind = "flat-fan", wide_axis = [1, 0, 0], half_angles_degrees = [0, 0] }"#;
    for (step, speed) in [(1e-5, 400.0), (1e-5, 3.0)] {
        let spray = nozzle(fan, &format!("{speed:?}"), "gravity = false");
        let plan = planned(&scene(step, &format!("{grains}{wall}{spray}")));
        let mut engine = start(&plan, 1);
        for _ in 0..2000 {
            engine.step(None).unwrap();
        }
        let films = films(&engine);
        assert!(films[0] > 0.0 && films[1..] == [0.0; 2], "{films:?}");
        let row = engine.liquid().unwrap();
        assert!((row.sprayed[2] - films[0]).abs() < 1e-12 * films[0]);
        assert_eq!(row.sprayed[3..], [0.0, 0.0]);
        assert!(row.error.abs() < 1e-13 * row.sprayed[1]);
    }
    // Without grains the shelf takes all.
    let spray = nozzle(fan, "400.0", "gravity = false");
    let plan = planned(&scene(1e-5, &format!("{wall}{spray}")));
    let mut engine = start(&plan, 1);
    for _ in 0..500 {
        engine.step(None).unwrap();
    }
    let [in_flight, emitted, absorbed, lost, left] = engine.liquid().unwrap().sprayed;
    assert!(lost > 0.9 * emitted && absorbed == 0.0 && left == 0.0);
    assert!((in_flight + lost - emitted).abs() < 1e-13 * emitted);
}

/// A grain that catches droplets gets their momentum.
#[test]
fn momentum_goes_over() {
    let fan = r#"{ kind = "flat-fan", wide_axis = [1, 0, 0], half_angles_degrees = [0, 0] }"#;
    let grain =
        "[[particles]]\nmaterial = \"grain\"\nradius = 2e-3\nposition = [0.05, 0.05, 0.05]\n";
    let spray = nozzle(fan, "1.0", "gravity = false\nmomentum = true\nuntil = 1e-3");
    let plan = planned(&scene(1e-5, &format!("{grain}{spray}")));
    let mut engine = start(&plan, 1);
    for _ in 0..8000 {
        engine.step(None).unwrap();
    }
    let [in_flight, _, absorbed, _, _] = engine.liquid().unwrap().sprayed;
    assert!(in_flight == 0.0 && absorbed > 0.0);
    let momentum = engine.particles.masses[0] * engine.particles.records[0].velocity;
    let expected = dvec3(0.0, 0.0, -1000.0 * absorbed * 1.0);
    assert!(momentum.distance(expected) < 1e-12 * expected.length());
}

/// Wet grains that collide in a periodic box under a spray of liquid with mass: momentum is kept by droplets, bridges that form, break and hand
/// on; each grain weighs what it holds; and the energy budget closes.
#[test]
fn liquid_with_mass_keeps_momentum_mass_and_energy() {
    let spray = nozzle(
        CONE,
        "1.0",
        "gravity = false\nmass = true\nuntil = 4e-3\nflow_rate = 1e-5",
    );
    let spray = spray.replace("flow_rate = 1e-6\n", "");
    let text = scene(1e-5, &spray).replace(
        "domain = { min = [0, 0, 0], max = [0.1, 0.1, 0.1] }",
        "domain = { min = [0, 0, 0], max = [0.1, 0.1, 0.1], periodic = [\"x\", \"y\", \"z\"] }",
    );
    let text = text.replace("interval = 0.1 }", "interval = 0.1, energy_budget = true }");
    let mut grains = String::new();
    let mut stream = mercury_common::random::Stream::new(5, "grains", 0);
    for k in 0..5 {
        for j in 0..5 {
            for i in 0..3 {
                let mut speed = || 0.4 * (stream.uniform() - 0.5);
                grains += &format!(
                    "[[particles]]\nmaterial = \"grain\"\nradius = 2e-3\nposition = [{}, {}, {}]\nvelocity = [{}, {}, {}]\nfilm_volume = 2e-11\n",
                    0.042 + 4.2e-3 * f64::from(k),
                    0.042 + 4.2e-3 * f64::from(j),
                    0.05 + 4.2e-3 * f64::from(i),
                    speed(),
                    speed(),
                    speed()
                );
            }
        }
    }
    let law = "liquid = { law = \"bagheri\", surface_tension = 0.07, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 3e-11 }\n[[sprays]]";
    let text = text.replacen("[[sprays]]", law, 1) + &grains;
    let plan = planned(&text);
    let mut engine = start(&plan, 1);
    let momentum = |engine: &Engine| {
        let particles = &engine.particles;
        let (mut sum, mut size) = (DVec3::ZERO, 0.0);
        for (record, mass) in particles.records.iter().zip(&particles.masses) {
            sum += mass * record.velocity;
            size += mass * record.velocity.length();
        }
        for droplet in &engine.sprays().unwrap().state.droplets {
            sum += 1000.0 * droplet.volume * droplet.velocity;
        }
        (sum, size)
    };
    let energy = |engine: &Engine| {
        let particles = &engine.particles;
        let kinetic: f64 = (particles.records.iter().zip(&particles.masses))
            .map(|(record, mass)| 0.5 * mass * record.velocity.length_squared())
            .sum();
        kinetic + engine.observation().elastic_energy + engine.audit().losses.total()
            - engine.liquid_brought().iter().map(|it| it[1]).sum::<f64>()
    };
    let watched = |engine: &mut Engine| {
        engine
            .step(Some(mercury_engine::forces::Watch::default()))
            .unwrap();
        engine.complete_step().unwrap();
    };
    watched(&mut engine);
    let (first, mut worst) = (energy(&engine), 0.0f64);
    while engine.time() < 4.5e-3 {
        watched(&mut engine);
        worst = worst.max((energy(&engine) / first - 1.0).abs());
    }
    let (before, _) = momentum(&engine);
    let caught = engine.liquid().unwrap().sprayed[2];
    while engine.time() < 0.05 {
        watched(&mut engine);
        worst = worst.max((energy(&engine) / first - 1.0).abs());
    }
    let row = engine.liquid().unwrap();
    assert!(row.sprayed[2] > caught && row.balance.formed > 20 && row.balance.ruptured > 5);
    let (after, size) = momentum(&engine);
    assert!(after.distance(before) < 1e-12 * size, "{after} {before}");
    // Liquid of each grain.
    let mut held = engine
        .particles
        .columns
        .get(FILM_VOLUME.name)
        .unwrap()
        .to_vec();
    for bridge in engine.bridges() {
        let mercury_engine::forces::Partner::Particle { row, .. } = bridge.partner else {
            panic!("there are no walls");
        };
        held[bridge.row as usize] += 0.5 * bridge.memory.volume;
        held[row as usize] += 0.5 * bridge.memory.volume;
    }
    let solid = 2500.0 * volume_of(2e-3);
    for (mass, held) in engine.particles.masses.iter().zip(&held) {
        assert!((mass / (solid + 1000.0 * held) - 1.0).abs() < 1e-12);
    }
    // Of second order in the step but for the instants of capture.
    assert!(worst < 2e-3, "{worst}");
}

/// Droplets of a list.
fn points(file: &tempfile::NamedTempFile, rows: &str, more: &str) -> String {
    let text = format!("t,x,y,z,vx,vy,vz,diameter\n{rows}");
    std::fs::write(file.path(), text).unwrap();
    format!(
        r#"[[sprays]]
        name = "list"
        pattern = {{ kind = "points", file = '{}' }}
        liquid_density = 1000.0
        gravity = false
        {more}
        "#,
        file.path().display()
    )
}

/// Droplets that hit a rod beside its centre turn it: it gets m r x v of the first, and the sum of the angular momenta of rod and droplets
/// about the origin is kept, whether liquid has mass or not.
#[test]
fn droplets_beside_the_centre_turn_a_clump() {
    let rod = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/clumps/rod.clump.toml");
    let rows = "1e-4,0.0585,0.0512,0.06,0.3,0,-2,2e-3\n2e-3,0.0412,0.04,0.0513,0,3,0.2,1e-3\n3e-3,0.05,0.0488,0.0588,0,0.1,-2,2e-3\n";
    for key in ["momentum", "mass"] {
        let file = tempfile::NamedTempFile::new().unwrap();
        let list = points(&file, rows, &format!("{key} = true"));
        let more = format!(
            "[clumps.rod]\nfile = '{}'\nmaterial = \"grain\"\n[[particles]]\nclump = \"rod\"\nposition = [0.05, 0.05, 0.05]\nscale = 0.01\n{list}",
            rod.display()
        );
        let mut engine = start(&planned(&scene(1e-5, &more)), 1);
        let turning = |engine: &Engine| {
            let body = &engine.particles.bodies()[0];
            let mut sum = body.angular_momentum + body.mass * body.position.cross(body.velocity);
            let mut size = sum.length();
            for droplet in &engine.sprays().unwrap().state.droplets {
                let own = 1000.0 * droplet.volume * droplet.position.cross(droplet.velocity);
                sum += own;
                size += own.length();
            }
            (sum, size)
        };
        let steps = |engine: &mut Engine, until: f64| {
            while engine.time() < until - 1e-9 {
                engine.step(None).unwrap();
            }
        };
        steps(&mut engine, 2e-4);
        let (first, size) = turning(&engine);
        assert!(engine.particles.bodies()[0].angular_momentum == DVec3::ZERO);
        // It flies 4.2e-3 m with 2 m/s.
        steps(&mut engine, 2.6e-3);
        let mass = 1000.0 * volume_of(1e-3);
        let expected = mass * dvec3(0.0085, 0.0012, 0.01).cross(dvec3(0.3, 0.0, -2.0));
        let found = engine.particles.bodies()[0].angular_momentum;
        // Places of 0.05 m, less than 200 steps of which round off each.
        let tolerance = 1e-16 * 200.0 * size;
        assert!(
            found.distance(expected) < tolerance,
            "{key}: {found}, not {expected}"
        );
        // All three: what the others bring with them comes at their instants, from the places and with the velocities of the list.
        let [second, third] = [
            1000.0 * volume_of(5e-4) * dvec3(0.0412, 0.04, 0.0513).cross(dvec3(0.0, 3.0, 0.2)),
            mass * dvec3(0.05, 0.0488, 0.0588).cross(dvec3(0.0, 0.1, -2.0)),
        ];
        steps(&mut engine, 0.01);
        let state = &engine.sprays().unwrap().state;
        assert!(
            state.droplets.is_empty() && state.balance.left.value() == 0.0,
            "{state:?}"
        );
        let (all, _) = turning(&engine);
        let whole = first + second + third;
        let size = size + second.length() + third.length();
        assert!(
            all.distance(whole) < 1e-16 * 1000.0 * size,
            "{key}: {all}, not {whole}"
        );
    }
}

/// A droplet that crosses a face of the domain before it would meet an endless wall behind it has left; one that meets it before is lost.
#[test]
fn a_droplet_that_leaves_first_is_not_lost_at_a_wall() {
    let wall = "[[walls]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0.01]\nnormal = [0, 0, 1]\nmaterial = \"grain\"\n";
    // At the face after 1e-3/30 = 33 us; at the floor after 87 us of a step of 100 us, or after 10 us.
    let file = tempfile::NamedTempFile::new().unwrap();
    let rows = "0,0.099,0.05,0.0136,30,0,-40,2e-4\n0,0.099,0.05,0.0105,30,0,-40,4e-4\n";
    let text = format!("{wall}{}", points(&file, rows, ""));
    let mut engine = start(&planned(&scene(1e-4, &text)), 1);
    engine.step(None).unwrap();
    let [in_flight, _, _, lost, left] = engine.liquid().unwrap().sprayed;
    assert_eq!(
        [in_flight, left, lost],
        [0.0, volume_of(1e-4), volume_of(2e-4)]
    );
}

/// A nozzle on an arm that turns and swings gives each droplet its place, its axis and its velocity of the instant at which it leaves.
#[test]
fn droplets_of_a_carried_nozzle_leave_as_it_stands_at_their_instant() {
    let (omega, amplitude, frequency, step) = (40.0, 2e-3, 100.0, 1e-4);
    let arm = format!(
        r#"[[walls]]
        name = "arm"
        shape = "disc"
        origin = [0.05, 0.05, 0.01]
        axis = [0, 0, 1]
        radius = 1e-3
        material = "grain"
        motion = [
            {{ kind = "rotation", axis = [0, 0, 1], origin = [0.05, 0.05, 0], angular_velocity = {omega:?} }},
            {{ kind = "oscillation", amplitude = [0, 0, {amplitude:?}], frequency = {frequency:?} }},
        ]
        "#
    );
    let fan = r#"{ kind = "flat-fan", wide_axis = [0, 0, 1], half_angles_degrees = [0, 0] }"#;
    let spray = nozzle(fan, "2.0", "gravity = false\ncarrier = \"arm\"");
    let spray = spray
        .replace("[0, 0, -1]", "[1, 0, 0]")
        .replace("[0.05, 0.05, 0.09]", "[0.06, 0.05, 0.05]");
    let mut engine = start(&planned(&scene(step, &format!("{arm}{spray}"))), 1);
    for _ in 0..80 {
        engine.step(None).unwrap();
    }
    let (now, one) = (engine.time(), volume_of(1e-4));
    let droplets = &engine.sprays().unwrap().state.droplets;
    assert!(droplets.len() > 1000);
    for droplet in droplets {
        let at = (droplet.id + 1) as f64 * one / 1e-6;
        let (turn, swing) = (omega * at, std::f64::consts::TAU * frequency);
        let along = dvec3(turn.cos(), turn.sin(), 0.0);
        let across = dvec3(-turn.sin(), turn.cos(), 0.0);
        let place = dvec3(0.05, 0.05, 0.05 + amplitude * (swing * at).sin()) + 0.01 * along;
        let velocity =
            2.0 * along + 0.01 * omega * across + DVec3::Z * amplitude * swing * (swing * at).cos();
        // Instants are sums of a thousand volumes: 1e-13 of 0.01 s, with rates of 600 per second.
        assert!(
            droplet.velocity.distance(velocity) < 1e-11,
            "{droplet:?}, not {velocity}"
        );
        let expected = place + (now - at) * velocity;
        assert!(
            droplet.position.distance(expected) < 1e-12,
            "{droplet:?}, not {expected}"
        );
    }
}

/// A droplet that bounces keeps the restitution of its normal speed, and all of its tangential one.
#[test]
fn droplets_bounce() {
    let wall = "[[walls]]\nname = \"shelf\"\nshape = \"plane\"\npoint = [0, 0, 0.01]\nnormal = [0, 0, 1]\nmaterial = \"grain\"\n";
    let fan = r#"{ kind = "flat-fan", wide_axis = [1, 0, 0], half_angles_degrees = [0, 0] }"#;
    let bounce = "gravity = false\nat_walls = \"bounce\"\nrestitution = 0.5\nuntil = 1e-4";
    let spray = nozzle(fan, "10.0", bounce).replace("[0, 0, -1]", "[0.6, 0, -0.8]");
    let spray = spray.replace("[0.05, 0.05, 0.09]", "[0.02, 0.05, 0.03]");
    let plan = planned(&scene(1e-5, &format!("{wall}{spray}")));
    let mut engine = start(&plan, 1);
    for _ in 0..400 {
        engine.step(None).unwrap();
    }
    let droplets = &engine.sprays().unwrap().state.droplets;
    assert!(!droplets.is_empty());
    for droplet in droplets {
        let expected = dvec3(6.0, 0.0, 4.0);
        assert!(droplet.velocity.distance(expected) < 1e-12, "{droplet:?}");
        assert!(droplet.position.z > 0.01 + 1e-4 * (1.0 - 2e-6));
    }
}

/// A wet, moving cloud of spheres and a clump of two in a box that is periodic along x, with a turning mesh, under two nozzles.
fn cloud(seed: u64, speed: f64) -> String {
    let mut grains = String::new();
    for k in 0..60u64 {
        let at = |n: u64| 0.005 + 0.09 * ((k * n + seed) % 61) as f64 / 61.0;
        let [x, y, z] = [at(17), at(23), at(41)];
        // Clear of the paddle.
        if (y - 0.05).abs() < 5e-3 {
            continue;
        }
        let v = |n: u64| 0.8 * (((k * n + seed) % 29) as f64 / 14.0 - 1.0);
        let radius = 1e-3 * (1.0 + (k % 7) as f64 * 0.5);
        grains += &format!(
            "[[particles]]\nmaterial = \"grain\"\nradius = {radius}\nposition = [{x}, {y}, {z}]\nvelocity = [{}, {}, {}]\n",
            v(5),
            v(11),
            v(3)
        );
    }
    let more = format!(
        r#"{grains}
        [[walls]]
        name = "paddle"
        shape = "disc"
        origin = [0.05, 0.05, 0.05]
        axis = [0, 1, 0]
        radius = 0.02
        material = "grain"
        motion = [{{ kind = "rotation", axis = [1, 0, 0], origin = [0.05, 0.05, 0.05], angular_velocity = 60.0 }}]
        {}
        {}"#,
        nozzle(
            CONE,
            "{ mean = 3.0, spread = 1.0 }",
            "orifice = 2e-3\nmomentum = true"
        ),
        nozzle(
            r#"{ kind = "hollow-cone", half_angles_degrees = [20, 40] }"#,
            &format!("{speed}"),
            "carrier = \"paddle\"",
        )
        .replace("\"nozzle\"", "\"other\"")
        .replace("[0.05, 0.05, 0.09]", "[0.05, 0.052, 0.05]")
        .replace("[0, 0, -1]", "[0, 1, 0]"),
    );
    let text = scene(5e-5, &more);
    let text = text.replace(
        "max = [0.1, 0.1, 0.1]",
        "max = [0.1, 0.1, 0.1], periodic = [\"x\"]",
    );
    format!("gravity = [0, 0, -9.81]\n{text}")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// Droplets that are looked at in every step, as after each resume, meet the same things in the same steps as those that are looked at
    /// only when something may be near; threads change nothing; and no volume is lost.
    #[test]
    fn nothing_is_missed_and_nothing_is_lost(seed in 0u64..1000, speed in 0.5f64..60.0) {
        let plan = planned(&cloud(seed, speed));
        let (mut rare, mut two, mut often) = (start(&plan, 1), start(&plan, 2), start(&plan, 1));
        for _ in 0..300 {
            rare.step(None).unwrap();
            two.step(None).unwrap();
            often.step(None).unwrap();
            let bytes = often.snapshot().encode();
            often = Engine::restore(Arc::clone(&plan), Snapshot::decode(&bytes).unwrap(), 1).unwrap();
            let row = rare.liquid().unwrap();
            let [in_flight, emitted, absorbed, lost, left] = row.sprayed;
            let gap = emitted - in_flight - absorbed - lost - left;
            prop_assert!(gap.abs() <= 1e-13 * emitted, "{gap}");
            prop_assert!(row.error.abs() <= 2e-14 * (emitted + row.films));
        }
        prop_assert!(rare.snapshot() == often.snapshot());
        prop_assert!(rare.snapshot() == two.snapshot());
        let [_, emitted, absorbed, lost, _] = rare.liquid().unwrap().sprayed;
        prop_assert!(absorbed + lost > 0.01 * emitted);
    }
}

/// A cube of 0.02 m about the middle of the box whose triangles face outwards.
const CUBE: &str = "v 0.04 0.04 0.04\nv 0.06 0.04 0.04\nv 0.04 0.06 0.04\nv 0.06 0.06 0.04\n\
    v 0.04 0.04 0.06\nv 0.06 0.04 0.06\nv 0.04 0.06 0.06\nv 0.06 0.06 0.06\n\
    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

/// A nozzle, or a droplet of a list, in a solid or behind a wall is refused by the wall's name, whatever the shape; before it, it is not.
#[test]
fn nozzles_in_walls_of_every_shape_are_refused() {
    let cube = tempfile::Builder::new().suffix(".obj").tempfile().unwrap();
    std::fs::write(cube.path(), CUBE).unwrap();
    let mesh = format!(
        "shape = \"mesh\"\nfile = '{}'\nside = \"front\"",
        cube.path().display()
    );
    let about = "origin = [0.05, 0.05, 0.05]";
    let (middle, corner) = ([0.05, 0.05, 0.05], [0.09, 0.09, 0.09]);
    let shapes = [
        (
            "shape = \"plane\"\npoint = [0, 0, 0.07]\nnormal = [0, 0, 1]".to_owned(),
            middle,
            corner,
        ),
        (
            format!("shape = \"sphere\"\nradius = 0.02\nside = \"outside\"\n{about}"),
            middle,
            corner,
        ),
        (
            format!("shape = \"sphere\"\nradius = 0.02\nside = \"inside\"\n{about}"),
            corner,
            middle,
        ),
        (
            format!(
                "shape = \"cylinder\"\nradius = 0.02\naxis = [0, 0, 1]\nside = \"outside\"\n{about}"
            ),
            middle,
            corner,
        ),
        (
            format!("shape = \"cylinder\"\nradius = 0.02\naxis = [0, 0, 1]\n{about}"),
            corner,
            middle,
        ),
        (
            format!(
                "shape = \"cone\"\nradii = [0.03, 0.01]\nalong = [-0.02, 0.02]\naxis = [0, 0, 1]\nside = \"outside\"\n{about}"
            ),
            middle,
            corner,
        ),
        (
            format!(
                "shape = \"revolution\"\nprofile = [[0.0, -0.02], [0.02, 0.0], [0.0, 0.02]]\naxis = [0, 0, 1]\nside = \"outside\"\n{about}"
            ),
            middle,
            corner,
        ),
        (mesh, middle, corner),
    ];
    let refusal = |text: &str| {
        let scene = parse_scene(Path::new("spray.toml"), text, &[], Files::MustExist).unwrap();
        plan(&scene).err().map(|errors| errors.to_string())
    };
    for (shape, behind, before) in shapes {
        let wall = format!("[[walls]]\nname = \"solid\"\nmaterial = \"grain\"\n{shape}\n");
        for (place, is_refused) in [(behind, true), (before, false)] {
            let spray =
                nozzle(CONE, "1.0", "").replace("[0.05, 0.05, 0.09]", &format!("{place:?}"));
            let file = tempfile::NamedTempFile::new().unwrap();
            let [x, y, z] = place;
            let list = points(&file, &format!("0,{x},{y},{z},0,0,1,1e-4\n"), "");
            for (spray, what) in [(spray, "the nozzle is"), (list, ":2: the droplet starts")] {
                let said = refusal(&scene(1e-5, &format!("{wall}{spray}")));
                let text = said.clone().unwrap_or_default();
                assert_eq!(said.is_some(), is_refused, "{shape} {place:?}: {text}");
                let names = format!("{what} in or behind the wall `solid`");
                assert!(!is_refused || text.contains(&names), "{shape}: {text}");
            }
        }
    }
}

/// A grain among twelve wet neighbours at rest, as close as equal spheres can be, stops at steps below the critical one, which counts
/// all their films: and not above. That of a pair alone is four times as long beside fixed grains.
#[test]
fn films_of_twelve_neighbours_bound_the_step() {
    let (radius, gap) = (1e-3, 1e-7);
    let half = (2.0 * radius + gap) * std::f64::consts::FRAC_1_SQRT_2;
    let mut grains = format!(
        "[[particles]]\nmaterial = \"grain\"\nradius = {radius:?}\nposition = [0.05, 0.05, 0.05]\nvelocity = [1e-6, 0, 0]\nfilm_volume = 1e-12\n"
    );
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        for (one, other) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let mut place = [0.05; 3];
            place[a] += one * half;
            place[b] += other * half;
            grains += &format!(
                "[[particles]]\nmaterial = \"grain\"\nradius = {radius:?}\nposition = {place:?}\nfixed = true\nfilm_volume = 1e-12\n"
            );
        }
    }
    // Without surface tension the films resist motion alone; the roughness is above the gap, so that the dashpots stay the same.
    let law = "liquid = { law = \"bagheri\", surface_tension = 0.0, contact_angle_degrees = 20.0, viscosity = 10.0, max_bridge_volume = 1e-11, roughness = 1e-5 }\n[liquid]\nbridges_form = \"films\"\n";
    let with = |step: f64| {
        let text = scene(step, &format!("{law}{grains}"));
        text.replace("end = 1.0", &format!("end = {:e}", 400.0 * step))
    };
    // 6 pi eta R*^2/h, and 6 pi eta R* (8/15 ln(R*/h) + 0.9588), R* = 0.5 mm.
    let scale = 6.0 * std::f64::consts::PI * 10.0 * 0.5e-3;
    let (normal, tangential) = (scale * 50.0, scale * (8.0 / 15.0 * 50f64.ln() + 0.9588));
    let mass = 2500.0 * volume_of(radius);
    let critical = 2.0 / (4.0 * (normal + 2.0 * tangential) / mass);
    let known = planned(&with(0.5 * critical));
    let limit = known.notes().step().critical.clone().unwrap();
    assert!(
        (limit.time / critical - 1.0).abs() < 1e-12,
        "{limit:?}, not {critical}"
    );
    // A step that a single pair bears was accepted.
    let text = with(0.85 * 2.0 * mass / normal);
    let refused = parse_scene(Path::new("spray.toml"), &text, &[], Files::MustExist).unwrap();
    let said = plan(&refused).unwrap_err().to_string();
    assert!(
        said.contains("raise `roughness`") && said.contains("a softer contact does not help"),
        "{said}"
    );
    for (part, grows) in [(0.85, false), (1.05, true)] {
        let mut inputs = known.physics().inputs().clone();
        inputs.time_step = part * critical;
        let mut engine = Engine::new(inputs.setup().unwrap(), 1).unwrap();
        assert_eq!(engine.liquid().unwrap().bridge_count, 12);
        let speed = |engine: &Engine| {
            engine.particles.records[engine.particles.rows_by_id()[0] as usize]
                .velocity
                .length()
        };
        let first = speed(&engine);
        for _ in 0..100 {
            engine.step(None).unwrap();
        }
        // |1 - 2 part| to the power 100: 3e-16 and 1.4e4.
        let grown = speed(&engine) / first;
        assert!(
            if grows { grown > 1e3 } else { grown < 1e-12 },
            "{part}: {grown:e}"
        );
    }
}

/// One droplet too many in flight ends the run by the name of its spray.
#[test]
fn too_many_droplets_are_named() {
    let plan = planned(&scene(1e-5, &nozzle(CONE, "1.0", "max_droplets = 20")));
    let mut engine = start(&plan, 1);
    let error = (0..100).find_map(|_| engine.step(None).err()).unwrap();
    let text = error.to_string();
    assert!(
        text.contains("spray \"nozzle\": more than 20 droplets are in flight"),
        "{text}"
    );
    assert!(
        engine.sprays().unwrap().state.droplets.len() == 21,
        "{text}"
    );
}

/// Flow by a table: linear between its rows, none before the first and behind the last.
#[test]
fn flow_follows_its_table() {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), "t,rate\n0.001,0\n0.003,2e-6\n0.004,0\n").unwrap();
    let table = format!("flow_rate = {{ table = '{}' }}", file.path().display());
    let spray = nozzle(CONE, "1.0", "gravity = false").replace("flow_rate = 1e-6", &table);
    let plan = planned(&scene(1e-5, &spray));
    let mut engine = start(&plan, 1);
    let one = volume_of(1e-4);
    while engine.time() < 0.006 {
        engine.step(None).unwrap();
        let t = engine.time() - 1e-3;
        let brought = if t <= 0.0 {
            0.0
        } else if t <= 2e-3 {
            0.5e-3 * t * t
        } else if t <= 3e-3 {
            let left = 3e-3 - t;
            3e-9 - 1e-3 * left * left
        } else {
            3e-9
        };
        let emitted = engine.sprays().unwrap().state.balance.emitted.value();
        assert!(
            emitted <= brought + 1e-21 && brought < emitted + one + 1e-21,
            "{t}"
        );
    }
    assert_eq!(DVec3::ZERO, engine.physics().gravity);
}
