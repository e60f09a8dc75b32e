//! Lists, threads and resumed runs with sheets.

use super::*;

/// One thread, two threads, and a run that is stopped and goes on, give the same bytes; so do steps that are looked at.
#[test]
fn threads_and_resumes_change_nothing() {
    let plan = || {
        let mut balls = thrown(1);
        // More rows than a block has.
        let mut random = Stream::new(8, "crowd", 0);
        let mut any = || DVec3::new(random.uniform(), random.uniform(), random.uniform());
        balls.extend((0..3000).map(|_| {
            let at = any() * dvec3(0.12, 0.12, 0.02) + dvec3(0.0, 0.0, 0.0015);
            ball(
                at,
                0.0008,
                dvec3(0.0, 0.0, -2.0) + any() * 0.3,
                any() * 20.0,
            )
        }));
        Setup::default().plan(
            balls,
            vec![square(6, 0.12, 0.1, 1), {
                let mut other = square(5, 0.1, 0.1, 2);
                other.vertices.iter_mut().for_each(|at| at.z -= 0.02);
                other
            }],
        )
    };
    let plan = plan();
    let mut one = Engine::new(Arc::clone(&plan), 1).unwrap();
    let mut two = Engine::new(Arc::clone(&plan), 2).unwrap();
    let mut resumed = Engine::new(Arc::clone(&plan), 1).unwrap();
    for round in 0..6 {
        for _ in 0..49 {
            one.step(None).unwrap();
        }
        one.step(Some(SEE)).unwrap();
        two.steps_at_once(50, Some(SEE)).unwrap();
        resumed.steps_at_once(50, None).unwrap();
        let bytes = resumed.snapshot().encode();
        let snapshot = Snapshot::decode(&bytes).unwrap();
        resumed = Engine::restore(Arc::clone(&plan), snapshot, 1 + round % 2).unwrap();
        let expected = one.snapshot().encode();
        assert!(expected == two.snapshot().encode(), "two threads, {round}");
        assert!(expected == resumed.snapshot().encode(), "resumed, {round}");
    }
    assert!(
        one.surfaces()
            .iter()
            .any(|s| s.loads.iter().any(|load| *load != DVec3::ZERO))
    );
}

/// Lists follow a sheet that moves faster than the particles: nothing is missed.
#[test]
fn fast_sheets_meet_resting_particles() {
    let mut random = Stream::new(8, "rest", 0);
    let mut any = || DVec3::new(random.uniform(), random.uniform(), random.uniform());
    let balls: Vec<NewParticle> = (0..200)
        .map(|_| {
            ball(
                any() * dvec3(0.1, 0.1, 0.05),
                0.001,
                DVec3::ZERO,
                DVec3::ZERO,
            )
        })
        .collect();
    let mut sheet = square(4, 0.12, 0.0, 1);
    for at in &mut sheet.vertices {
        *at += dvec3(-0.01, -0.01, -0.01);
    }
    let plan = Setup::default().plan_of(|draft| {
        draft.particles = balls;
        draft.plans.insert(carried(sheet, dvec3(0.0, 0.0, 10.0)));
    });
    let mut engine = Engine::new(plan, 1).unwrap();
    engine.steps_at_once(700, None).unwrap();
    let front = engine.surfaces()[0].positions[0].z;
    assert!(front > 0.05);
    for record in &engine.particles.records {
        assert!(record.position.z > front, "{record:?} at {front}");
    }
}

/// A sheet that moves far from all particles costs no lists: it uses up the gap between them first. Where it comes from afar it meets them as ever.
#[test]
fn a_sheet_far_away_wears_no_list_out() {
    let places = (0..216).map(|k| dvec3(f64::from(k % 6), f64::from(k / 6 % 6), f64::from(k / 36)));
    let balls: Vec<NewParticle> = places
        .map(|place| ball(0.015 * place, 0.001, DVec3::ZERO, DVec3::ZERO))
        .collect();
    let lists = |height: f64, periodic: &str| {
        let mut sheet = square(4, 0.12, 0.0, 1);
        for at in &mut sheet.vertices {
            *at += dvec3(-0.01, -0.01, height);
        }
        let setup = Setup {
            periodic,
            ..Setup::default()
        };
        let plan = setup.plan_of(|draft| {
            draft.particles = balls.clone();
            draft.plans.insert(carried(sheet, dvec3(0.0, 0.0, 10.0)));
        });
        let mut engine = Engine::new(plan, 1).unwrap();
        let start = engine.list_statistics().0;
        // It goes 0.1 m; the skin of balls at rest is a few hundredths of their millimetre.
        engine.steps_at_once(1000, None).unwrap();
        let front = engine.surfaces()[0].positions[0].z;
        let above = |z: f64| height > 0.1 || z > front || front < 0.0;
        assert!(
            engine
                .particles
                .records
                .iter()
                .all(|ball| above(ball.position.z))
        );
        engine.list_statistics().0 - start
    };
    assert_eq!(lists(-0.5, "[]"), 0);
    assert_eq!(lists(0.3, "[]"), 0);
    // Through the periodic face: it stands below all balls, and above their images by 1.6 m.
    assert_eq!(lists(-0.5, "[\"z\"]"), 0);
    // From 20 mm below them it comes to push them.
    assert!(lists(-0.02, "[]") > 5);
}

/// The vertices of a large sheet are shared among threads where they touch walls, and its triangles where its mesh follows, to the same bytes, also when
/// the run is stopped meanwhile.
#[test]
fn threads_share_large_sheets() {
    let mut sheet = square(50, 0.1, 0.1, 2);
    sheet.touches_walls = true;
    sheet.thickness = 2e-3;
    sheet.vertices.iter_mut().for_each(|at| at.z += 0.0015);
    assert!(sheet.vertices.len() > 2 * 1024 && sheet.triangles.len() > 4096);
    let above = |ball: &NewParticle| ball.position.z > 0.0;
    let mut balls: Vec<NewParticle> = thrown(1).into_iter().filter(above).collect();
    balls.iter_mut().for_each(|ball| ball.position.z -= 0.001);
    let setup = Setup {
        step: 1e-5,
        output: "interval = 0.1, energy_budget = true, walls = true",
        more: r#"
        [[walls]]
        name = "floor"
        material = "m"
        shape = "plane"
        point = [0.0, 0.0, 0.0]
        normal = [0.0, 0.0, 1.0]"#,
        ..Setup::default()
    };
    let plan = setup.plan(balls, vec![sheet]);
    let start = |threads| {
        let mut engine = Engine::new(Arc::clone(&plan), threads).unwrap();
        let velocities = &mut engine.domain.surfaces[0].velocities;
        velocities.fill(dvec3(0.3, 0.1, -1.0));
        engine
    };
    let [mut one, mut two, mut resumed] = [1, 2, 1].map(start);
    for round in 0..4 {
        one.steps_at_once(40, Some(SEE)).unwrap();
        two.steps_at_once(40, Some(SEE)).unwrap();
        resumed.steps_at_once(40, Some(SEE)).unwrap();
        let snapshot = Snapshot::decode(&resumed.snapshot().encode()).unwrap();
        resumed = Engine::restore(Arc::clone(&plan), snapshot, 2).unwrap();
        let expected = one.snapshot().encode();
        assert!(expected == two.snapshot().encode(), "two threads, {round}");
        assert!(expected == resumed.snapshot().encode(), "resumed, {round}");
        let load = |engine: &Engine| engine.observation().walls[0].0.force;
        assert_eq!(load(&one), load(&two), "{round}");
    }
    assert!((one.surfaces()[0].velocities.iter()).any(|v| v.z > 0.1));
    assert!(at_sheets(&one.observation()) > 0);
}
