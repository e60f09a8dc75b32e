//! Fixed particles beside sleepers.

use super::*;

/// A plate of fixed spheres beside one of loose spheres that are driven against it by `tilt` (m/s^2), in blocks of their own; a wall comes nearer from 0.15 s to 0.25 s.
/// `more`: tables behind it.
fn leaning_on_fixed_ones(sleeping: &str, tilt: f64, more: &str) -> Arc<Plan> {
    let text = format!(
        r#"
        {sleeping}
        gravity = [-{tilt}, 0, -9.81]
        time = {{ end = 1.0, step = 2e-5 }}
        domain = {{ min = [-0.2, -0.01, -0.01], max = [0.2, 0.04, 0.03] }}
        output = {{ interval = 0.05 }}
        [materials.m]
        density = 2000.0
        normal = {{ law = "linear", stiffness = 500.0, restitution = 0.3 }}
        tangential = {{ law = "linear", stiffness_ratio = 0.2857, friction = 0.5, dissipation = 0.002 }}
        rolling = {{ law = "luding", friction = 0.1, dissipation = 0.01 }}
        {FLOOR}
        [[walls]]
        shape = "plane"
        point = [0, 0.02602, 0]
        normal = [0, -1, 0]
        material = "m"
        motion = [{{ kind = "translation", velocity = [0, -1e-3, 0], from = 0.15, until = 0.25 }}]
        [[particles]]
        material = "m"
        radius = 1e-3
        fixed = true
        lattice = {{ min = [-0.12, 0, 1e-3], max = [-2e-3, 0.0181, 1e-3], spacing = 2e-3 }}
        [[particles]]
        material = "m"
        radius = 1e-3
        lattice = {{ min = [0, 0, 1e-3], max = [0.118, 0.0181, 1e-3], spacing = 2e-3 }}
        [[particles]]
        material = "m"
        radius = 1e-3
        fixed = true
        position = [-0.125, 0, 1e-3]
        {more}
    "#
    );
    let scene = parse_scene(Path::new("leaning.toml"), &text, &[], Files::Unchecked).unwrap();
    Arc::new(plan(&scene).unwrap())
}

/// Contacts of particles that touch fixed ones act on these and are seen there, whether the particle sleeps or not: also in
/// blocks without sleepers.
#[test]
fn fixed_ones_feel_sleepers() {
    let run = |sleeping| {
        let mut engine = Engine::new(leaning_on_fixed_ones(sleeping, 2.0, ""), 1).unwrap();
        advance(&mut engine, 0.14);
        engine.step(Some(WITNESS)).unwrap();
        let seen = engine.observation();
        let is_fixed = |row: u32| engine.particles.records[row as usize].flags & FIXED != 0;
        let reported = seen.records.iter().filter(|record| match record.partner {
            Partner::Particle { row, .. } => is_fixed(row) || is_fixed(record.row),
            Partner::Wall { .. } => false,
        });
        let reported: Vec<f64> = reported.map(|record| record.force.x.abs()).collect();
        let rows = (0..).zip(&engine.particles.loads);
        let felt = rows.filter(|&(row, _)| is_fixed(row));
        let felt: f64 = felt.map(|(_, load)| load.force.x.abs()).sum();
        assert_eq!(reported.len(), 10);
        assert!(
            (reported.iter().sum::<f64>() / felt - 1.0).abs() < 1e-12,
            "{reported:?}, {felt}"
        );
        let slept = engine.sleepers().map(|sleepers| sleepers.0);
        (slept, seen.particle_contacts, seen.elastic_energy)
    };
    let (with, without) = (run("sleeping = {}"), run(""));
    assert_eq!(with.0, Some(600));
    assert_eq!(with.1, without.1);
    // Of each contact with the floor the force is right to a twentieth, and its energy to a tenth; the others are far weaker.
    assert!(
        (with.2 / without.2 - 1.0).abs() < 0.1,
        "{with:?}, {without:?}"
    );
}

/// What fixed ones feel of sleepers outlasts an interruption, also when those are awake again.
#[test]
fn what_fixed_ones_feel_is_kept() {
    // Beside the fixed ones, in a block without other sleepers; the wall wakes it.
    let alone = "[[particles]]\nmaterial = \"m\"\nradius = 1e-3\nposition = [-0.06, 0.025, 1e-3]";
    let plan = leaning_on_fixed_ones("sleeping = {}", 0.5, alone);
    let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
    let mut interrupted = Engine::new(Arc::clone(&plan), 1).unwrap();
    advance(&mut engine, 0.1499);
    advance(&mut interrupted, 0.1499);
    let (mut slept, mut woke) = (asleep(&engine), false);
    for _ in 0..60 {
        engine.steps_at_once(20, None).unwrap();
        interrupted.steps_at_once(20, None).unwrap();
        let state = engine.snapshot().encode();
        assert!(
            interrupted.snapshot().encode() == state,
            "at {} s",
            engine.time()
        );
        let saved = Snapshot::decode(&state).unwrap();
        interrupted = Engine::restore(Arc::clone(&plan), saved, 2).unwrap();
        engine.step(Some(WITNESS)).unwrap();
        interrupted.step(Some(WITNESS)).unwrap();
        assert_eq!(
            engine.observation().elastic_energy,
            interrupted.observation().elastic_energy
        );
        assert_eq!(
            engine.observation().particle_contacts,
            interrupted.observation().particle_contacts
        );
        woke |= asleep(&engine) < slept;
        slept = asleep(&engine);
    }
    assert!(woke && slept < 601, "{slept}");
}
