//! Particles that leave the domain, and particles that pass a flux plane: in the step and at the place of their own way.

use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::table_head;
use mercury_common::random::Stream;
use mercury_engine::bodies::{Clump, NewBody};
use mercury_engine::boundaries::{FluxPart, FluxPlan};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::state::MaterialIndex;
use mercury_solver::plan::{Draft, NewParticle};
use mercury_solver::run::{RunOptions, run};
use mercury_tests::scenes::{advance, frictionless, sphere, start};

fn law() -> AnyPairLaw {
    frictionless(AnyNormal::Linear(Linear::new(1000.0, 0.0)))
}

/// A few shoot away from a lattice of hundreds that nearly touch each other and hardly move: they get extra skin, with which a list lasts
/// while they go several skins. They leave in the step in which they pass the face all the same.
#[test]
fn few_that_are_fast_leave_in_the_step_in_which_they_pass_the_face() {
    let radius = 0.01;
    let spacing = 2.05 * radius;
    let top = 24.0 * spacing;
    let size = dvec3(8.0 * spacing, 8.0 * spacing, top);
    let mut scene = Draft::new(1e-4, (DVec3::ZERO, size), 1000.0, law());
    scene.cell = scene.cell.with_periodic([true, true, false]);
    let mut stream = Stream::new(9, "lattice", 0);
    let mut slow = || stream.uniform_in(-1e-3, 1e-3);
    let mut particles: Vec<NewParticle> = (0..1024u32)
        .map(|k| {
            let site = dvec3(f64::from(k % 8), f64::from(k / 8 % 8), f64::from(k / 64)) + 0.5;
            NewParticle {
                velocity: dvec3(slow(), slow(), slow()),
                ..NewParticle::at(site * spacing, radius, MaterialIndex::new(0))
            }
        })
        .collect();
    // At most one in 200 gets extra skin. Each leaves when the list that was built as the one before it had left is still valid: with its extra skin a
    // particle may go half of the largest skin, 5 mm.
    for k in 0..5 {
        let (x, height) = (
            (1.5 * f64::from(k) + 0.5) * spacing,
            0.0101 + 0.0045 * f64::from(k),
        );
        let place = dvec3(x, 4.0 * spacing, top - height);
        particles.push(NewParticle {
            velocity: 4.0 * DVec3::Z,
            ..NewParticle::at(place, radius, MaterialIndex::new(0))
        });
    }
    let mut engine = start(scene.with_particles(particles));
    let mut with_extra_skin = 0;
    while engine.boundaries().removed().number < 5 {
        let extra_skin = engine.lists().extra_skin.clone();
        let before = engine.boundaries().removed().number;
        engine.step(None).unwrap();
        let records = &engine.particles.records;
        let outside = records.iter().find(|record| record.position.z > top);
        assert!(outside.is_none(), "step {}: {outside:?}", engine.steps());
        if extra_skin.iter().any(|&extra_skin| extra_skin > 0.0) {
            with_extra_skin += engine.boundaries().removed().number - before;
        }
    }
    assert!(
        with_extra_skin >= 3,
        "{with_extra_skin} left in steps with extra skin"
    );
}

/// Prescribed motion stays with its body when the row of bodies closes up behind one that has left: the second goes on at its
/// velocity and spin, the third goes on falling, g t²/2 (exactly, as velocity Verlet is exact for a constant force).
#[test]
fn prescribed_motion_stays_with_its_body_when_another_leaves() {
    let radius = 0.01;
    let pebble = |x: f64| Pebble {
        position: x * DVec3::X,
        radius,
    };
    let moments = dvec3(1e-6, 2e-6, 2e-6);
    let material = MaterialIndex::new(0);
    let rod = Clump::new(
        "rod",
        material,
        vec![pebble(-radius), pebble(radius)],
        0.01,
        1e-5,
        moments,
    );
    let body = |x: f64| NewBody::at(dvec3(x, 0.0, 0.0), 0);
    let leaves = NewBody {
        velocity: 2.0 * DVec3::Y,
        ..body(-0.3)
    };
    let held = NewBody {
        prescribed_velocity: [Some(0.1), Some(0.0), Some(0.0)],
        prescribed_angular_velocity: [Some(0.0), Some(0.0), Some(5.0)],
        velocity: 0.1 * DVec3::X,
        angular_velocity: 5.0 * DVec3::Z,
        ..body(0.0)
    };
    let mut scene = Draft::new(1e-3, (DVec3::splat(-1.0), DVec3::splat(1.0)), 1000.0, law());
    scene.gravity = -0.5 * DVec3::Z;
    let mut engine = start(scene.with_bodies(vec![rod.unwrap()], vec![leaves, held, body(0.3)]));
    advance(&mut engine, 1000);
    let [held, falls] = engine.particles.bodies() else {
        panic!("{} bodies", engine.particles.bodies().len());
    };
    assert!(
        (held.position - dvec3(0.1, 0.0, 0.0)).length() < 1e-12,
        "{}",
        held.position
    );
    assert!(
        (held.angular_velocity - 5.0 * DVec3::Z).length() < 1e-12,
        "{}",
        held.angular_velocity
    );
    assert!(
        (falls.position - dvec3(0.3, 0.0, -0.25)).length() < 1e-12,
        "{}",
        falls.position
    );
    assert!(
        (falls.velocity - dvec3(0.0, 0.0, -0.5)).length() < 1e-12,
        "{}",
        falls.velocity
    );
}

/// The point where a way crosses the plane decides whether it goes through the disc, not where the particle is at the end of the
/// step.
#[test]
fn a_disc_is_passed_where_the_way_crosses_its_plane() {
    // In the plane after 3 1/3 steps of 1 ms, and 0.02 m behind it, and to the side, after the fourth.
    let through = |x: f64, speed: f64| {
        let velocity = dvec3(speed, 0.0, -30.0);
        let start = dvec3(x, 0.5, 0.5) - velocity * (10.0 / 3.0 * 1e-3);
        sphere(start, 0.01, velocity, DVec3::ZERO)
    };
    // Through it near the rim and outwards; beside it and inwards.
    for (particles, passed) in [
        ([through(0.69, 30.0), through(0.31, -30.0)], 2),
        ([through(0.71, -30.0), through(0.29, 30.0)], 0),
    ] {
        let mut draft = Draft::new(1e-3, (DVec3::ZERO, DVec3::ONE), 1000.0, law());
        draft.fluxes = vec![FluxPlan {
            name: "disc".to_owned(),
            point: DVec3::splat(0.5),
            normal: DVec3::NEG_Z,
            part: FluxPart::Disc(0.2),
        }];
        let mut engine = start(draft.with_particles(particles.to_vec()));
        advance(&mut engine, 6);
        let crossed = engine.take_crossed();
        assert_eq!((crossed[0].forward, crossed[0].backward), (passed, 0));
    }
}

/// Mean diameters of the grains that pass, by the powers in their names: d32 is the sum of d^3 over that of d^2.
#[test]
fn the_means_of_what_passes_are_written_in_their_columns() {
    let diameters = [0.02, 0.03, 0.05];
    let falling = |k: usize| {
        let place = dvec3(0.2 + 0.3 * k as f64, 0.5, 0.6);
        sphere(place, 0.5 * diameters[k], DVec3::NEG_Z, DVec3::ZERO)
    };
    let mut draft = Draft::new(1e-3, (DVec3::ZERO, DVec3::ONE), 1000.0, law());
    draft.prefix = "run".to_owned();
    draft.steps = 200;
    draft.output.interval = 0.2;
    draft.fluxes = vec![FluxPlan {
        name: "plane".to_owned(),
        point: DVec3::splat(0.5),
        normal: DVec3::NEG_Z,
        part: FluxPart::All,
    }];
    let plan = draft
        .with_particles((0..3).map(falling).collect())
        .plan()
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions {
        folder: folder.path().to_owned(),
        ..RunOptions::default()
    };
    run(plan, &options, &mut |_| ()).unwrap();
    let text = std::fs::read_to_string(folder.path().join("run.flux.csv")).unwrap();
    let head = text.lines().next().unwrap().split(',');
    let names: Vec<&str> = head.map(table_head::name).collect();
    let last: Vec<&str> = text.lines().last().unwrap().split(',').collect();
    let sum = |power: i32| diameters.iter().map(|d: &f64| d.powi(power)).sum::<f64>();
    for (name, expected) in [
        ("forward", sum(0)),
        ("d10", sum(1) / sum(0)),
        ("d32", sum(3) / sum(2)),
        ("d43", sum(4) / sum(3)),
    ] {
        let column = names.iter().position(|known| *known == name).unwrap();
        let found: f64 = last[column].parse().unwrap();
        assert!(
            (found / expected - 1.0).abs() < 1e-14,
            "{name}: {found}, not {expected}"
        );
    }
}
