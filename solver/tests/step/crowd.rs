//! Bodies in contact: what is conserved, and what must not change the numbers.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::scene::Files;
use mercury_solver::plan::parse_scene;

use mercury_engine::bodies::Clump;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear};
use mercury_engine::forces::Watch;
use mercury_engine::state::{MaterialIndex, PEBBLE};
use mercury_engine::step::Engine;
use mercury_solver::plan::{Draft, NewBody, NewParticle, Plan, plan};

const WATCH: Option<Watch> = Some(Watch {
    records: true,
    audit: None,
});

/// Touching spheres of diameter 1 m and density 1 kg/m^3 at `centres` (m), principal moments given in units of pi/6 kg m^2.
fn touching(name: &str, centres: &[DVec3], moments: DVec3) -> Clump {
    let pebbles = centres.iter().map(|&position| Pebble {
        position,
        radius: 0.5,
    });
    let volume = PI / 6.0 * centres.len() as f64;
    let moments = moments * (PI / 6.0);
    Clump::new(
        name,
        MaterialIndex::new(0),
        pebbles.collect(),
        volume,
        volume,
        moments,
    )
    .unwrap()
}

/// Three spheres in a row: I = (pi/6) diag(0.3, 2.3, 2.3).
fn rod() -> Clump {
    let centres = [-1.0, 0.0, 1.0].map(|x| dvec3(x, 0.0, 0.0));
    touching("rod", &centres, dvec3(0.3, 2.3, 2.3))
}

/// Seven spheres along x, three more along y above the middle: I = (pi/6) diag(11.4, 29, 39.4).
fn t_bar() -> Clump {
    let bar = (-3..=3).map(|x| dvec3(f64::from(x), 0.0, 0.0));
    let stem = (1..=3).map(|y| dvec3(0.0, f64::from(y), 0.0));
    let centres: Vec<DVec3> = bar.chain(stem).map(|c| c - dvec3(0.0, 0.6, 0.0)).collect();
    touching("t-bar", &centres, dvec3(11.4, 29.0, 39.4))
}

/// Elastic T-bars, rods and a few spheres that fly into one another in a periodic box.
fn gas() -> Draft {
    let law = AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(1e4, 0.0)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let mut plan = Draft::new(5e-4, (DVec3::ZERO, DVec3::splat(16.0)), 1.0, law);
    plan.cell = plan.cell.with_periodic([true; 3]);
    let mut random = mercury_common::random::Stream::new(4, "gas", 0);
    let mut vector = |size: f64| {
        let mut one = || size * (2.0 * random.uniform() - 1.0);
        dvec3(one(), one(), one())
    };
    let (mut bodies, mut particles) = (Vec::new(), Vec::new());
    for k in 0..8u32 {
        let cell = dvec3(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
        let position = (cell + 0.5) * 8.0;
        bodies.push(NewBody {
            velocity: vector(20.0),
            angular_velocity: vector(10.0),
            ..NewBody::at(position, k % 2)
        });
        particles.push(NewParticle {
            velocity: vector(20.0),
            ..NewParticle::at(
                position + DVec3::splat(4.0) * dvec3(1.0, 0.0, 0.0),
                0.4,
                MaterialIndex::new(0),
            )
        });
    }
    plan.with_particles(particles)
        .with_bodies(vec![t_bar(), rod()], bodies)
}

/// Kinetic and rotational energy, J, and momentum, kg m/s.
fn energy_and_momentum(engine: &Engine) -> (f64, DVec3) {
    let particles = &engine.particles;
    let mut sum = (engine.observation().elastic_energy, DVec3::ZERO);
    for (row, record) in particles.records.iter().enumerate() {
        if record.flags & PEBBLE == 0 {
            let m = particles.masses[row];
            sum.0 += 0.5 * m * record.velocity.length_squared();
            sum.0 += 0.2 * m * (record.radius * record.angular_velocity).length_squared();
            sum.1 += m * record.velocity;
        }
    }
    for body in particles.bodies() {
        sum.0 += 0.5 * body.mass * body.velocity.length_squared() + body.rotational_energy();
        sum.1 += body.mass * body.velocity;
    }
    sum
}

#[test]
fn an_elastic_gas_keeps_energy_and_momentum() {
    let plan = Arc::new(gas().plan().unwrap());
    let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
    let (energy, momentum) = energy_and_momentum(&engine);
    let (mut contacts, mut worst) = (0, 0.0f64);
    for _ in 0..4000 {
        engine.step(WATCH).unwrap();
        engine.complete_step().unwrap();
        contacts += engine.observation().particle_contacts;
        let (now, p) = energy_and_momentum(&engine);
        worst = worst.max((now / energy - 1.0).abs());
        // Round-off of a few thousand kicks.
        assert!((p - momentum).length() < 1e-10 * energy.sqrt());
    }
    assert!(contacts > 1000, "{contacts}");
    // Second order in the step: contacts of pi sqrt(m/k) = 20 ms and more, 40 steps.
    assert!(worst < 2e-3, "{worst:e}");
}

/// Everything at once: clumps of two kinds that come, settle on a moving floor in a periodic box and leave, one of them
/// prescribed, one fixed, among spheres.
fn busy() -> Arc<Plan> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rod.clump.toml");
    let text = include_str!("../../../scenes/rod.clump.toml");
    std::fs::write(&file, text).unwrap();
    let text = r#"
        gravity = [0, 0, -9.81]
        time = { end = 0.1, step = 2e-5 }
        domain = { min = [0, 0, 0], max = [0.03, 0.03, 0.03], periodic = ["y"] }
        output = { interval = 0.01, data = true, energy_budget = true }
        contact = { clump_mass = "contact-point" }
        [materials.m]
        density = 2000.0
        normal = { law = "linear", stiffness = 200.0, restitution = 0.7 }
        tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
        [clumps.rod]
        file = "rod.clump.toml"
        material = "m"
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
        mixture = [
            { clump = "rod", psd = { kind = "uniform", min_diameter = 2e-3, max_diameter = 3e-3, weighting = "number" }, share = 0.8 },
            { material = "m", psd = { kind = "monodisperse", diameter = 2e-3 }, share = 0.2 },
        ]
        share_by = "number"
        total = { number = 60 }
        rate = { number = 3000.0 }
        velocity = { mean = [0, 0, -0.5], spread = [0.3, 0.3, 0.0] }
        [[deletions]]
        name = "out"
        region = { shape = "box", min = [0.022, 0, 0], max = [0.03, 0.03, 0.03] }
        [[particles]]
        clump = "rod"
        scale = 0.1
        position = [0.018, 0.015, 0.02]
        prescribed = { velocity = [0.3, "free", "free"], angular_velocity = ["free", "free", 100.0] }
        [[particles]]
        clump = "rod"
        scale = 0.2
        fixed = true
        orientation = [1.0, 0.5, 0.2, -0.4]
        position = [0.012, 0.001, 0.01]
    "#;
    let scene = parse_scene(
        &folder.path().join("busy.toml"),
        text,
        &[],
        Files::MustExist,
    )
    .unwrap();
    Arc::new(plan(&scene).unwrap())
}

#[test]
fn neither_looking_nor_threads_nor_a_restart_change_a_bit() {
    let plan = busy();
    let mut single = Engine::new(Arc::clone(&plan), 1).unwrap();
    let mut looked_at = Engine::new(Arc::clone(&plan), 1).unwrap();
    let mut at_once = Engine::new(Arc::clone(&plan), 2).unwrap();
    let mut restored = Engine::new(Arc::clone(&plan), 2).unwrap();
    for count in [1, 7, 92, 900, 1500] {
        for _ in 0..count {
            single.step(None).unwrap();
            looked_at.step(WATCH).unwrap();
            looked_at.complete_step().unwrap();
        }
        at_once.steps_at_once(count, None).unwrap();
        let snapshot = restored.snapshot();
        restored = Engine::restore(Arc::clone(&plan), snapshot, 1).unwrap();
        restored.steps_at_once(count, None).unwrap();
        single.complete_step().unwrap();
        at_once.complete_step().unwrap();
        restored.complete_step().unwrap();
        let expected = single.snapshot();
        assert!(looked_at.snapshot() == expected, "looking changes numbers");
        assert!(at_once.snapshot() == expected, "steps at once differ");
        assert!(restored.snapshot() == expected, "a restart differs");
    }
    let removed = single.boundaries().removed();
    let inserted = single.boundaries().inserted();
    assert!(removed.number > 5 && inserted.number == 60);
    assert_eq!(
        single.particles.grains() as u64,
        2 + inserted.number - removed.number
    );
    // Mass is neither lost nor counted twice: the prescribed rod is among the removed.
    let present: f64 = single.particles.masses.iter().sum();
    let start: f64 = plan
        .physics()
        .bodies
        .iter()
        .map(|body| body.mass(&plan.physics().clumps))
        .sum();
    let missing = start + inserted.mass - removed.mass - present;
    assert!(missing.abs() < 1e-12 * start, "{missing:e}");
}

#[test]
fn pebbles_of_one_body_never_touch() {
    // Pebbles that lie in one another, alone in the world.
    let mut clump = rod();
    for pebble in &mut clump.pebbles {
        pebble.position *= 0.3;
    }
    let plan = Draft::new(
        1e-3,
        (DVec3::splat(-9.0), DVec3::splat(9.0)),
        1.0,
        gas().laws.laws[0].unwrap(),
    );
    let plan = plan.with_bodies(vec![clump], vec![NewBody::at(DVec3::ZERO, 0)]);
    let mut engine = Engine::new(Arc::new(plan.plan().unwrap()), 1).unwrap();
    for _ in 0..10 {
        engine.step(WATCH).unwrap();
    }
    engine.complete_step().unwrap();
    assert_eq!(engine.observation().particle_contacts, 0);
    assert_eq!(engine.list_statistics().1, 0);
    assert_eq!(engine.particles.bodies()[0].velocity, DVec3::ZERO);
}
