//! Pairs of particles with a sheet between them.

use super::*;

/// Two balls that press on a sheet from either side, by more than its thickness: each feels a plane at half the thickness, and nothing of the other one, in the
/// domain and across its faces. Beside the sheet they feel each other.
#[test]
fn a_sheet_separates_what_touches_it_from_either_side() {
    const HERTZ: &str =
        r#"{ law = "hertz", youngs_modulus = 1e6, poisson_ratio = 0.3, restitution = 1.0 }"#;
    let (radius, overlap) = (0.004, 2e-4);
    for (periodic, height) in [("[]", 0.0), (r#"["z"]"#, 1.0)] {
        let setup = Setup {
            laws: "",
            normal: HERTZ,
            periodic,
            ..Setup::default()
        };
        let mut sheet = square(7, 0.03, 0.0, 0);
        for at in &mut sheet.vertices {
            at.z += height;
        }
        sheet.masses.fill(f64::INFINITY);
        let away = dvec3(0.0, 0.0, radius + 0.5 * THICKNESS - overlap);
        // Half their distance is less than their radius.
        assert!(away.z < radius);
        // On a face, on an edge, on a corner, anywhere.
        let cell = 0.03 / 7.0;
        let places = [(3.6, 3.3), (3.5, 3.5), (3.0, 3.0), (4.1, 2.0)];
        for (x, y) in places {
            let at = dvec3(x * cell, y * cell, height);
            let mut balls =
                [at + away, at - away].map(|at| ball(at, radius, DVec3::ZERO, DVec3::ZERO));
            balls[1].position.z -= 2.0 * height;
            let plan = setup.plan(balls.to_vec(), vec![sheet.clone()]);
            let mut engine = Engine::new(plan, 1).unwrap();
            let seen = engine.take_observation();
            assert_eq!(seen.records.len(), 2, "{periodic}, {at}");
            // Hertz at a plane: 4/3 E* sqrt(R) delta^(3/2), E* = E/(2 (1 - nu^2)).
            let modulus = 1e6 / (2.0 * (1.0 - 0.09));
            let force = 4.0 / 3.0 * modulus * radius.sqrt() * overlap.powf(1.5);
            for (load, side) in engine.particles.loads.iter().zip([1.0, -1.0]) {
                let expected = dvec3(0.0, 0.0, side * force);
                // Places of 1 m are known to 2e-16 m, of an overlap of 2e-4 m.
                let error = load.force.distance(expected) / force;
                assert!(
                    error < 1e-11,
                    "{periodic}, {at}: {} for {force}",
                    load.force
                );
            }
        }
        // Beside it.
        let at = dvec3(-0.0045, 0.01, height);
        let mut balls = [at + away, at - away].map(|at| ball(at, radius, DVec3::ZERO, DVec3::ZERO));
        balls[1].position.z -= 2.0 * height;
        let plan = setup.plan(balls.to_vec(), vec![sheet]);
        let mut engine = Engine::new(plan, 1).unwrap();
        let seen = engine.take_observation();
        assert_eq!(seen.records.len(), 1, "{periodic}");
        assert!(matches!(seen.records[0].partner, Partner::Particle { .. }));
    }
}

/// A sheet that comes between two wet grains takes their bridge apart: all of its liquid goes back to their films.
#[test]
fn a_sheet_takes_a_bridge_apart() {
    const WILLETT: &str = r#"liquid = { law = "willett", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-12 }"#;
    let setup = Setup {
        laws: WILLETT,
        normal: LINEAR,
        ..Setup::default()
    };
    let (radius, film) = (1e-3, 1e-12);
    let mut sheet = square(4, 0.02, 0.0, 0);
    for at in &mut sheet.vertices {
        *at += dvec3(0.002, -0.01, 0.0);
    }
    let plan = setup.plan_of(|draft| {
        draft.particles = [1.0, -1.0]
            .map(|side| {
                let at = dvec3(0.0, 0.0, side * (radius - 1e-6));
                ball(at, radius, DVec3::ZERO, DVec3::ZERO)
            })
            .to_vec();
        draft.plans.insert(carried(sheet, dvec3(-2.0, 0.0, 0.0)));
        draft.start_values.push(StartValues {
            particles: vec![(0, film), (1, film)],
            ..StartValues::new(&FILM_VOLUME)
        });
    });
    let mut engine = Engine::new(plan, 1).unwrap();
    let films = |engine: &Engine| -> f64 {
        let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap();
        films.iter().sum()
    };
    let bridges = |engine: &Engine, of_pairs: bool| -> f64 {
        let is_pair = |partner: &Partner| matches!(partner, Partner::Particle { .. });
        let bridges = engine.bridges().into_iter();
        let own = bridges.filter(|bridge| is_pair(&bridge.partner) == of_pairs);
        own.map(|bridge| bridge.memory.volume).sum()
    };
    assert!(bridges(&engine, true) > 0.1 * film);
    for _ in 0..200 {
        engine.step(None).unwrap();
        let all = films(&engine) + bridges(&engine, true) + bridges(&engine, false);
        assert!((all - 2.0 * film).abs() < 1e-12 * film, "{all:e}");
    }
    assert_eq!(bridges(&engine, true), 0.0);
}
