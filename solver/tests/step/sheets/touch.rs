//! Which contacts a particle has with a sheet, and how their forces join.

use super::*;

/// A ball of twenty edges rolls over a flat sheet that is held: it has one contact in every step, of an even force, and slides over edges as over faces.
#[test]
fn a_large_ball_on_a_flat_sheet_has_one_contact() {
    let mut sheet = square(40, 0.2, 0.0, 0);
    // In its plane the corners are anywhere.
    let mut random = Stream::new(5, "skew", 0);
    for at in &mut sheet.vertices {
        let way = DVec3::new(random.uniform() - 0.5, random.uniform() - 0.5, 0.0);
        *at += way * 0.2 * 0.005;
    }
    sheet.masses.fill(f64::INFINITY);
    let (radius, overlap) = (0.1, 1e-4);
    let height = radius + 0.5 * THICKNESS - overlap;
    let rolling = ball(
        dvec3(0.05, 0.06, height),
        radius,
        dvec3(0.5, 0.4, 0.0),
        dvec3(-0.4, 0.5, 0.0) / height,
    );
    // So heavy that the spring hardly moves it.
    let setup = Setup {
        laws: r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }"#,
        normal: r#"{ law = "linear", stiffness = 5.0, dissipation = 0.0 }"#,
        ..Setup::default()
    };
    let mut engine = Engine::new(setup.plan(vec![rolling], vec![sheet]), 1).unwrap();
    let mut features = std::collections::BTreeSet::new();
    let mut last = 5.0 * overlap;
    for step in 0..4_000 {
        engine.step(Some(SEE)).unwrap();
        let seen = engine.take_observation();
        assert_eq!(seen.records.len(), 1, "{step}");
        let record = &seen.records[0];
        features.insert(record.feature);
        let force = record.force.z;
        assert!(
            (force - last).abs() < 1e-3 * last,
            "{step}: {last} to {force}"
        );
        assert!(
            record.tangential.length() < 1e-3 * force,
            "{step}: {record:?}"
        );
        last = force;
    }
    assert!(features.len() > 8, "{}", features.len());
}

/// A ball of twenty edges flies into a free sheet, which bends around it: momenta, and without losses the energy.
#[test]
fn a_sheet_bends_around_a_large_ball() {
    for (laws, normal, bound) in [("", LINEAR, 2e-4), (FRICTION, HARD, f64::INFINITY)] {
        let mut sheet = square(12, 0.06, 0.1, 4);
        for at in &mut sheet.vertices {
            *at -= dvec3(0.03, 0.03, 0.0);
        }
        let radius = 0.1;
        let at = dvec3(0.001, 0.002, radius + 0.003);
        let thrown = ball(at, radius, dvec3(0.1, 0.0, -2.0), dvec3(3.0, 1.0, 0.0));
        let setup = Setup {
            step: 2e-6,
            laws,
            normal,
            ..Setup::default()
        };
        let mut engine = Engine::new(setup.plan(vec![thrown], vec![sheet]), 1).unwrap();
        let (first, start) = (momenta(&engine), energy(&engine, &Observation::empty(0)));
        let mut most_contacts = 0;
        for step in 0..3_000 {
            engine.step(Some(SEE)).unwrap();
            let seen = engine.take_observation();
            engine.complete_step().unwrap();
            most_contacts = most_contacts.max(at_sheets(&seen));
            for (now, first) in momenta(&engine).iter().zip(&first) {
                let size = first.1.max(now.1);
                assert!(now.0.distance(first.0) < 1e-11 * size, "{step}");
            }
            let off = (energy(&engine, &seen) - start) / start;
            assert!(off < bound.min(1e-3), "{step}: {off:e}");
            assert!(-off < bound, "{step}: {off:e}");
        }
        assert!(most_contacts > 3, "{most_contacts}");
    }
}

/// Laws whose contacts count by a part where they join: momenta of a ball in a sheet that bends around it are kept in every step, and the audit lacks
/// no more than by the theory page.
#[test]
fn plastic_and_wet_contacts_join() {
    const PLASTIC: &str = r#"{ law = "plastic", loading_stiffness = 200.0, unloading_stiffness = 800.0, cohesion_stiffness = 50.0, penetration_depth = 0.05, dissipation = 1e-3 }"#;
    const WILLETT: &str = r#"liquid = { law = "willett", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-10 }"#;
    const BAGHERI: &str = r#"liquid = { law = "bagheri", surface_tension = 0.07, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 1e-10 }"#;
    for (name, normal, laws, film, bound) in [
        ("plastic", PLASTIC, "", 0.0, 1e-6),
        ("plastic with friction", PLASTIC, FRICTION, 0.0, 1e-6),
        ("wet", LINEAR, WILLETT, 1e-8, 1e-2),
        ("wet and viscous", HARD, BAGHERI, 1e-8, 1e-2),
    ] {
        let mut sheet = square(12, 0.06, 0.1, 4);
        for at in &mut sheet.vertices {
            *at -= dvec3(0.03, 0.03, 0.0);
        }
        let (radius, at) = (0.1, dvec3(0.001, 0.002, 0.103));
        let thrown = ball(at, radius, dvec3(0.1, 0.0, -2.0), dvec3(3.0, 1.0, 0.0));
        let setup = Setup {
            step: 2e-6,
            laws,
            normal,
            output: "interval = 0.1, energy_budget = true",
            ..Setup::default()
        };
        let plan = setup.plan_of(|draft| {
            draft.particles = vec![thrown];
            draft.plans.insert(limp(sheet));
            if film > 0.0 {
                draft.start_values.push(StartValues {
                    particles: vec![(0, film)],
                    ..StartValues::new(&FILM_VOLUME)
                });
            }
        });
        let mut engine = Engine::new(plan, 1).unwrap();
        let seen = engine.take_observation();
        let (first, start) = (momenta(&engine), energy(&engine, &seen));
        let (mut most_contacts, mut most) = (0, 0.0f64);
        for step in 0..3_000 {
            engine.step(Some(SEE)).unwrap();
            let seen = engine.take_observation();
            engine.complete_step().unwrap();
            most_contacts = most_contacts.max(at_sheets(&seen));
            for (now, first) in momenta(&engine).iter().zip(&first) {
                let size = first.1.max(now.1);
                let off = now.0.distance(first.0);
                assert!(off < 1e-11 * size, "{name}, {step}: {off:e} of {size:e}");
            }
            let lacks = energy(&engine, &seen) + engine.audit().losses.total() - start;
            most = most.max((lacks / start).abs());
        }
        assert!(most_contacts > 3, "{name}: {most_contacts}");
        assert!(most < bound, "{name}: {most:e}");
    }
}

/// Both faces push a ball away, and a sheet with a front only that one; from behind a ball passes.
#[test]
fn faces_act_as_they_are_planned() {
    let passes = |faces: Faces, from: f64| {
        let mut sheet = square(4, 0.08, 0.1, 9);
        sheet.faces = faces;
        sheet.masses.fill(f64::INFINITY);
        let at = dvec3(0.041, 0.043, from * 0.02);
        let thrown = ball(at, 0.01, dvec3(0.0, 0.0, -from), DVec3::ZERO);
        let plan = Setup::default().plan(vec![thrown], vec![sheet]);
        let mut engine = Engine::new(plan, 1).unwrap();
        engine.steps_at_once(4000, None).unwrap();
        engine.complete_step().unwrap();
        let [record] = &engine.particles.records[..] else {
            panic!("one ball");
        };
        record.velocity.z * from < 0.0
    };
    assert!(!passes(Faces::Both, 1.0));
    assert!(!passes(Faces::Both, -1.0));
    assert!(!passes(Faces::Front, 1.0));
    assert!(
        !passes(Faces::Front, -1.0),
        "what begins behind is pushed back behind"
    );
}

/// Pebbles of a clump and a particle whose motion is prescribed push a sheet; momentum of clump and sheet is kept.
#[test]
fn clumps_and_prescribed_particles_push_sheets() {
    let material = MaterialIndex::new(0);
    let (radius, apart) = (0.004, 0.003);
    let pebbles = [-apart, apart].map(|x| Pebble {
        position: dvec3(x, 0.0, 0.0),
        radius,
    });
    // Mass and moments of about such a rod.
    let (mass, moments) = (4e-4, dvec3(2.6e-9, 6e-9, 6e-9));
    let rod = Clump::new("rod", material, pebbles.to_vec(), mass, 4e-7, moments);
    let body = NewBody {
        velocity: dvec3(0.3, 0.1, -1.5),
        angular_velocity: dvec3(10.0, 50.0, 3.0),
        ..NewBody::at(dvec3(0.05, 0.06, 0.006), 0)
    };
    let plan = Setup::default().plan_of(|draft| {
        draft.particles.clear();
        draft.clumps = vec![rod.unwrap()];
        draft.bodies = vec![body];
        draft.plans.insert(limp(square(6, 0.12, 0.1, 3)));
    });
    let mut engine = Engine::new(plan, 1).unwrap();
    let sums = |engine: &Engine| {
        let (mut linear, mut angular) = (Sum::default(), Sum::default());
        let bodies = engine.particles.bodies.as_ref().unwrap();
        for body in &bodies.all {
            linear.add(body.velocity * body.mass);
            angular.add(body.position.cross(body.velocity * body.mass));
            angular.add(body.angular_momentum);
        }
        let surface = &engine.surfaces()[0];
        for (k, at) in surface.positions.iter().enumerate() {
            let momentum = surface.velocities[k] / surface.inverse_masses[k];
            linear.add(momentum);
            angular.add(at.cross(momentum));
        }
        [linear, angular]
    };
    let (first, mut contacts) = (sums(&engine), 0);
    for step in 0..2000 {
        engine.step(Some(SEE)).unwrap();
        contacts += at_sheets(&engine.take_observation());
        for (now, first) in sums(&engine).iter().zip(&first) {
            assert!(
                now.0.distance(first.0) < 1e-11 * first.1.max(now.1),
                "{step}"
            );
        }
    }
    assert!(contacts > 100, "{contacts}");

    let setup = Setup {
        more: r#"
        [[particles]]
        material = "m"
        radius = 0.01
        position = [0.06, 0.06, 0.0105]
        prescribed = { velocity = [0.0, 0.0, -1.0] }"#,
        ..Setup::default()
    };
    let particles = setup.scene_particles();
    let plan = setup.plan(particles, vec![square(6, 0.12, 0.0, 3)]);
    let mut engine = Engine::new(plan, 1).unwrap();
    engine.steps_at_once(600, None).unwrap();
    let lowest = engine.surfaces()[0]
        .velocities
        .iter()
        .map(|v| v.z)
        .fold(0.0, f64::min);
    assert!(lowest < -0.9, "{lowest}");
}

/// A sheet of exactly one period: beside its seam, however near, a ball has one contact, with the force of a plane.
#[test]
fn a_ball_beside_a_seam_has_one_contact() {
    let setup = Setup {
        laws: "",
        normal: LINEAR,
        periodic: r#"["x", "y"]"#,
        ..Setup::default()
    };
    let mut sheet = square(8, 2.0, 0.0, 0);
    sheet
        .vertices
        .iter_mut()
        .for_each(|at| *at -= dvec3(1.0, 1.0, 0.0));
    sheet.masses.fill(f64::INFINITY);
    let (radius, overlap) = (0.004, 2e-4);
    let height = radius + 0.5 * THICKNESS - overlap;
    let mut random = Stream::new(3, "offsets", 0);
    let mut offsets = vec![0.0, 1e-9, -1e-9, 1e-7, -1e-7];
    offsets.extend((0..40).map(|k| {
        let size = 10f64.powf(random.uniform_in(-15.0, -3.0));
        if k % 2 == 0 { size } else { -size }
    }));
    for pair in offsets.windows(2) {
        for (x, y) in [(1.0 + pair[0], 0.3), (1.0 + pair[0], 1.0 + pair[1])] {
            let box_of_scene = Cell::new(-DVec3::ONE, DVec3::ONE, [true, true, false]);
            let at = box_of_scene.wrap(dvec3(x, y, height));
            let plan = setup.plan(
                vec![ball(at, radius, DVec3::ZERO, DVec3::ZERO)],
                vec![sheet.clone()],
            );
            let mut engine = Engine::new(plan, 1).unwrap();
            let seen = engine.take_observation();
            assert_eq!(seen.records.len(), 1, "{pair:?}");
            let force = engine.particles.loads[0].force;
            // Places within 1e-9 of the reach are one, so the normal may be tilted by as much.
            let expected = dvec3(0.0, 0.0, 500.0 * overlap);
            let error = force.distance(expected) / expected.z;
            assert!(error < 2e-9, "{pair:?}: {force}");
        }
    }
}
