//! Vertices of sheets at walls.

use super::*;

/// Vertices bounce on a floor as spheres of half the thickness: they stay above it, the wall feels what they get, and energy is kept.
#[test]
fn vertices_touch_walls() {
    let mut sheet = square(4, 0.04, 0.1, 2);
    sheet.touches_walls = true;
    sheet.thickness = 2e-3;
    sheet.vertices.iter_mut().for_each(|at| at.z += 0.003);
    let count = sheet.vertices.len();
    let setup = Setup {
        step: 1e-6,
        normal: r#"{ law = "linear", stiffness = 500.0, dissipation = 0.0 }"#,
        laws: "",
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
    let plan = setup.plan(Vec::new(), vec![sheet]);
    let start = |threads| {
        let mut engine = Engine::new(Arc::clone(&plan), threads).unwrap();
        engine.domain.surfaces[0]
            .velocities
            .fill(dvec3(0.0, 0.0, -1.0));
        engine
    };
    let (mut engine, mut resumed) = (start(1), start(1));
    let first = energy(&engine, &Observation::empty(0));
    let (mut pushed, mut lowest, mut most) = (DVec3::ZERO, 1.0f64, 0.0f64);
    for step in 0..6000u32 {
        engine.step(Some(SEE)).unwrap();
        let seen = engine.take_observation();
        let loads: DVec3 = engine.surfaces()[0].loads.iter().sum();
        let felt = seen.walls[0].0.force;
        assert!(
            (felt + loads).length() <= 1e-12 * loads.length(),
            "{felt}, {loads}"
        );
        pushed += loads * 1e-6;
        resumed.step(None).unwrap();
        if step % 1500 == 700 {
            let snapshot = Snapshot::decode(&resumed.snapshot().encode()).unwrap();
            assert!(snapshot == engine.snapshot());
            resumed = Engine::restore(Arc::clone(&plan), snapshot, 2).unwrap();
        }
        let heights = engine.surfaces()[0].positions.iter().map(|at| at.z);
        lowest = heights.fold(lowest, f64::min);
        let seen_energy = seen.elastic_energy;
        // Kinetic energy of the time of the positions, without touching the run.
        if seen_energy == 0.0 {
            most = most.max((energy(&engine, &seen) - first).abs());
        }
    }
    assert!(0.0 < lowest && lowest < 0.001, "{lowest}");
    let upwards = engine.surfaces()[0]
        .velocities
        .iter()
        .filter(|v| v.z > 0.99);
    assert_eq!(upwards.count(), count);
    assert!(most < 1e-4 * first, "{most:e} of {first:e}");
    let momentum: f64 = engine.surfaces()[0]
        .inverse_masses
        .iter()
        .map(|w| 2.0 / w)
        .sum();
    assert!(
        (pushed.z - momentum).abs() < 1e-3 * momentum,
        "{pushed}, {momentum}"
    );
    assert!(engine.snapshot() == resumed.snapshot());
}

/// Walls that act on both sides push vertices back to where they came from, also if their contacts are so soft that they go through: by twice as far as
/// their radius here.
#[test]
fn walls_with_two_sides_hold_vertices() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("floor.obj");
    let corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    std::fs::write(&file, format!("{corners}f 1 2 3 4\n")).unwrap();
    let mesh = format!("shape = \"mesh\"\nfile = {file:?}");
    let disc = "shape = \"disc\"\naxis = [0.0, 0.0, 1.0]\norigin = [0.0, 0.0, 0.0]\nradius = 1.0";
    for shape in [&mesh, disc] {
        let mut sheet = square(4, 0.04, 0.1, 2);
        sheet.touches_walls = true;
        sheet.thickness = 2e-3;
        sheet.vertices.iter_mut().for_each(|at| at.z += 0.003);
        let more = format!("[[walls]]\nname = \"floor\"\nmaterial = \"m\"\n{shape}");
        let setup = Setup {
            step: 1e-6,
            normal: r#"{ law = "linear", stiffness = 7.0, dissipation = 0.0 }"#,
            laws: "",
            output: "interval = 0.1, walls = true",
            more: &more,
            ..Setup::default()
        };
        let plan = setup.plan(Vec::new(), vec![sheet]);
        let start = || {
            let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
            engine.domain.surfaces[0]
                .velocities
                .fill(dvec3(0.0, 0.0, -1.0));
            engine
        };
        let (mut engine, mut resumed) = (start(), start());
        let lightest = (engine.surfaces()[0].inverse_masses.iter()).fold(0.0f64, |a, b| a.max(*b));
        let mut lowest = 1.0f64;
        for step in 0..20_000u32 {
            engine.step(None).unwrap();
            resumed.step(None).unwrap();
            if step % 2000 == 1000 {
                let snapshot = Snapshot::decode(&resumed.snapshot().encode()).unwrap();
                resumed = Engine::restore(Arc::clone(&plan), snapshot, 2).unwrap();
            }
            let heights = engine.surfaces()[0].positions.iter().map(|at| at.z);
            lowest = heights.fold(lowest, f64::min);
        }
        // The heaviest goes deepest: v sqrt(m/k) below where it begins to touch, and six triangles have six times the mass of one.
        let deepest = 1e-3 - (6.0 / (7.0 * lightest)).sqrt();
        assert!(
            (2.0 * deepest..-1e-3).contains(&lowest),
            "{lowest}, {deepest}"
        );
        for velocity in &engine.surfaces()[0].velocities {
            // Step and period give an error of (omega dt)^2/24, of less than 1e-5.
            assert!((velocity.z - 1.0).abs() < 1e-3, "{velocity}");
        }
        assert!(engine.snapshot() == resumed.snapshot());
    }
}
