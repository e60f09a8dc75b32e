//! A loop compiled for its laws and the loop that chooses them at each contact give the same bytes, and so do loops that evaluate one
//! contact after the other or several side by side.

use std::path::Path;
use std::sync::Arc;

use mercury_common::scene::Files;
use mercury_engine::forces::{
    SavedSlot, SavedSlots, SlotState, Watch, contact_loop, dispatching_loop,
};
use mercury_engine::lanes::Width;
use mercury_engine::step::{Engine, Snapshot, StartOptions};
use mercury_solver::plan::{Plan, parse_scene, plan, read_scene};

const LINEAR: &str = r#"normal = { law = "linear", stiffness = 200.0, restitution = 0.7 }"#;
const HERTZ: &str =
    r#"normal = { law = "hertz", youngs_modulus = 1e6, poisson_ratio = 0.3, restitution = 0.7 }"#;
const LINEAR_FRICTION: &str =
    r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }"#;
const MINDLIN: &str = r#"tangential = { law = "mindlin", friction = 0.5 }"#;
const LUDING: &str = r#"rolling = { law = "luding", friction = 0.1, dissipation = 1e-4 }
    torsion = { law = "luding", friction = 0.1, dissipation = 1e-4 }"#;

const WET: &str = r#"liquid = { law = "bagheri", surface_tension = 0.05, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 4e-12 }"#;

const EXACT: &str = r#"liquid = { law = "young-laplace", surface_tension = 0.05, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 4e-12 }"#;

/// Spheres that fall on a floor that swings, and against each other, in two or three dimensions. `output`: its keys; `more`: tables
/// behind all others.
fn falling(laws: &[&str], dimensions: u32, output: &str, more: &str) -> Arc<Plan> {
    // In space, contacts reach through the periodic faces.
    let (periodic, sites) = match dimensions {
        2 => ("", "min = [0.0021, 0.0031, 0], max = [0.0281, 0.0171, 0]"),
        _ => (
            "\"z\"",
            "min = [0.0021, 0.0031, -0.019], max = [0.0081, 0.0091, 0.019]",
        ),
    };
    let film = if laws.contains(&WET) || laws.contains(&EXACT) {
        "film_volume = 2e-11"
    } else {
        ""
    };
    let text = format!(
        r#"
        gravity = [0, -9.81, 0]
        time = {{ end = 0.1, step = 1e-5 }}
        domain = {{ min = [0, 0, -0.02], max = [0.03, 0.03, 0.02], periodic = [{periodic}], dimensions = {dimensions} }}
        output = {{ {output} }}
        # Deep overlaps are wanted here: whatever the laws can meet.
        guard = {{ policy = "off" }}
        [materials.m]
        density = 2000.0
        {}
        [[walls]]
        name = "floor"
        shape = "plane"
        point = [0, 0.002, 0]
        normal = [0, 1, 0]
        material = "m"
        motion = [{{ kind = "oscillation", amplitude = [1e-3, 1e-4, 0], frequency = 50.0 }}]
        [[walls]]
        name = "plate"
        shape = "plane"
        point = [0.001, 0, 0]
        normal = [1, 0, 0]
        material = "m"
        [[particles]]
        material = "m"
        radius = 1.02e-3
        lattice = {{ {sites}, spacing = 0.002 }}
        velocity = [-0.5, -0.5, 0]
        angular_velocity = [0, 0, 40]
        {film}
        {more}
    "#,
        laws.join("\n")
    );
    let scene = parse_scene(Path::new("falling.toml"), &text, &[], Files::Unchecked).unwrap();
    Arc::new(plan(&scene).unwrap())
}

/// The state without the histories, which every loop saves in its own way.
fn plain(engine: &Engine) -> impl PartialEq + std::fmt::Debug {
    let snapshot = engine.snapshot();
    let heads = [snapshot.pairs(), snapshot.near_walls()].map(|slots| {
        let slots = slots.unwrap();
        let head = |s: SavedSlot<'_>| (s.row, s.partner, s.image, s.state, s.feature);
        slots.iter().map(head).collect::<Vec<_>>()
    });
    let without = |snapshot: Snapshot, section| {
        let edit = |slots: &mut SavedSlots| *slots = SavedSlots::new(Vec::new());
        snapshot.edited(section, edit).unwrap()
    };
    (heads, without(without(snapshot, "pairs"), "near walls"))
}

#[test]
fn the_dispatching_loop_gives_the_bytes_of_every_compiled_one() {
    let combinations: [&[&str]; 7] = [
        &[LINEAR],
        &[LINEAR, LINEAR_FRICTION],
        &[LINEAR, LINEAR_FRICTION, LUDING],
        &[HERTZ, MINDLIN],
        &[HERTZ, MINDLIN, LUDING],
        &[HERTZ, MINDLIN, WET],
        &[HERTZ, MINDLIN, EXACT],
    ];
    for (laws, dimensions) in combinations.iter().flat_map(|laws| [(laws, 3), (laws, 2)]) {
        // Discs have no surface that liquid could wet.
        if dimensions == 2 && (laws.contains(&WET) || laws.contains(&EXACT)) {
            continue;
        }
        let plan = falling(
            laws,
            dimensions,
            "interval = 0.01, energy_budget = true",
            "",
        );
        let (_, name) = contact_loop(&plan.physics().laws);
        assert!(name.ends_with("(compiled together)"), "{name}");
        let mut compiled = Engine::new(Arc::clone(&plan), 1).unwrap();
        let contacts = (dispatching_loop(&plan.physics().laws), String::new());
        let mut dispatching = Engine::start(
            Arc::clone(&plan),
            StartOptions::threads(2).contacts(contacts),
        )
        .unwrap();
        assert_eq!(compiled.history_columns(), dispatching.history_columns());
        let watch = Some(Watch {
            records: true,
            audit: None,
        });
        let mut contacts = 0;
        for _ in 0..12 {
            for engine in [&mut compiled, &mut dispatching] {
                engine.steps_at_once(150, watch).unwrap();
            }
            // Debug output distinguishes -0 from 0, which a record may print.
            let (one, other) = (compiled.observation(), dispatching.observation());
            assert_eq!(format!("{one:?}"), format!("{other:?}"), "{name}");
            contacts += one.particle_contacts.min(one.wall_contacts);
            assert_eq!(plain(&compiled), plain(&dispatching), "{name}");
        }
        assert!(contacts > 20, "{name}: {contacts} contacts");
        assert!(compiled.list_statistics().0 > 2, "lists were built anew");
    }
}

#[test]
fn other_combinations_are_chosen_at_each_contact() {
    let plan = falling(&[HERTZ], 3, "interval = 0.01", "");
    let (_, name) = contact_loop(&plan.physics().laws);
    assert_eq!(
        name,
        "hertz, frictionless, no rolling (chosen at each contact)"
    );
    // Its slots hold the history of every law, which a state keeps.
    let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
    engine.steps_at_once(2000, None).unwrap();
    let bytes = engine.snapshot().encode();
    let snapshot = Snapshot::decode(&bytes).unwrap();
    assert!(snapshot.pairs().unwrap().numbers() > 3);
    let restored = Engine::restore(plan, snapshot, 2).unwrap();
    assert_eq!(restored.snapshot().encode(), bytes);
}

/// Runs a plan in every width of this processor, on one thread and on two, and compares all that changes. Returns how many pairs
/// touched in the end.
fn same_in_every_width(name: &str, plan: &Arc<Plan>, steps: u64) -> usize {
    let widths = Width::all();
    let on_two_threads = (Width::fastest(), 2);
    let mut first: Option<Snapshot> = None;
    for (width, threads) in widths
        .iter()
        .map(|&width| (width, 1))
        .chain([on_two_threads])
    {
        let options = StartOptions::threads(threads).width(Some(width));
        let mut engine = Engine::start(Arc::clone(plan), options).unwrap();
        for _ in 0..4 {
            engine.steps_at_once(steps / 4, None).unwrap();
        }
        let last = engine.snapshot();
        match &first {
            // By bytes: where they are numbers, -0 is not 0.
            Some(first) => assert!(
                last.encode() == first.encode(),
                "{name}: {} lanes, {threads} threads",
                width.lanes()
            ),
            None => first = Some(last),
        }
    }
    let pairs = first.unwrap().pairs().unwrap();
    let touching = pairs
        .iter()
        .filter(|slot| slot.state == SlotState::Touching);
    touching.count()
}

/// A second kind of sphere among the first, of other laws.
const OTHERS: &str = r#"
    [materials.soft]
    density = 1500.0
    normal = { law = "plastic", loading_stiffness = 100.0, unloading_stiffness = 200.0, cohesion_stiffness = 20.0, penetration_depth = 0.05, dissipation = 1e-3 }
    tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.3 }
    [[contacts]]
    between = ["m", "soft"]
    normal = { law = "linear", stiffness = 150.0, restitution = 0.5 }
    tangential = { law = "linear", stiffness_ratio = 0.3, friction = 0.4 }
    [[particles]]
    material = "soft"
    radius = 0.9e-3
    lattice = { min = [0.0131, 0.0031, -0.019], max = [0.0191, 0.0091, 0.019], spacing = 0.002 }
    velocity = [-1.5, -0.4, 0]
    angular_velocity = [0, 10, 40]
"#;

#[test]
fn the_number_of_lanes_changes_no_byte_of_any_law() {
    assert!(
        Width::all().len() >= 2,
        "one lane and two can always be had"
    );
    const RESCALED: &str =
        r#"tangential = { law = "mindlin", friction = 0.5, load_history = "rescale" }"#;
    let combinations: [&[&str]; 7] = [
        &[LINEAR],
        &[LINEAR, LINEAR_FRICTION],
        &[LINEAR, LINEAR_FRICTION, LUDING],
        &[HERTZ, MINDLIN],
        &[HERTZ, MINDLIN, LUDING],
        &[HERTZ],
        &[HERTZ, RESCALED],
    ];
    for (laws, dimensions) in combinations.iter().flat_map(|laws| [(laws, 3), (laws, 2)]) {
        let plan = falling(laws, dimensions, "interval = 0.01", "");
        let touching = same_in_every_width(&format!("{laws:?} in {dimensions}D"), &plan, 1200);
        assert!(touching > 10, "{laws:?}: {touching} touch");
    }
    // Groups in which pairs of several laws lie side by side.
    let plan = falling(&[LINEAR, LINEAR_FRICTION], 3, "interval = 0.01", OTHERS);
    let touching = same_in_every_width("several laws", &plan, 1200);
    assert!(touching > 20, "{touching} touch");
}

/// Ten materials in one heap, so many that those of one law are not put side by side any more: nine more kinds of sphere, one
/// layer each, which all meet the first.
#[test]
fn the_number_of_lanes_changes_no_byte_of_ten_materials() {
    let mut more = String::new();
    for k in 0..9 {
        let (stiffness, friction) = (120.0 + 10.0 * f64::from(k), 0.1 * f64::from(k));
        let low = f64::from(k) * 0.0042 - 0.0185;
        let high = low + 0.0021;
        more.push_str(&format!(
            r#"
            [materials.m{k}]
            density = 1800.0
            normal = {{ law = "linear", stiffness = {stiffness}, restitution = 0.6 }}
            tangential = {{ law = "linear", stiffness_ratio = 0.2857, friction = {friction} }}
            [[particles]]
            material = "m{k}"
            radius = 1e-3
            lattice = {{ min = [0.0021, 0.0111, {low}], max = [0.0181, 0.0191, {high}], spacing = 0.00205 }}
            velocity = [0.3, -1.5, 0]
        "#
        ));
    }
    let plan = falling(&[LINEAR, LINEAR_FRICTION], 3, "interval = 0.01", &more);
    let touching = same_in_every_width("ten materials", &plan, 1600);
    assert!(touching > 10, "{touching} touch");
}

/// Pebbles of clumps, whose contacts may be damped by another mass, through periodic faces.
#[test]
fn the_number_of_lanes_changes_no_byte_of_clumps() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/clumps/drum.toml");
    let fall = "insertions.fill.velocity.mean=[0,0,-1]";
    for mass in ["body", "contact-point"] {
        let mass = format!("contact.clump_mass={mass:?}");
        let changes = [mass.clone(), fall.into()];
        let scene = read_scene(&file, &changes).unwrap();
        let plan = Arc::new(plan(&scene).unwrap());
        let touching = same_in_every_width(&mass, &plan, 1200);
        assert!(touching > 50, "{mass}: {touching} touch");
    }
}

#[test]
fn the_number_of_lanes_changes_no_byte_of_a_benchmark() {
    let bench = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/bench");
    for (name, steps) in [
        ("dense-2k", 400),
        ("dense-20k-frictionless", 40),
        ("poly-20k", 40),
        ("mesh-drum-6k", 80),
    ] {
        let scene = read_scene(&bench.join(format!("{name}.toml")), &[]).unwrap();
        let plan = Arc::new(plan(&scene).unwrap());
        let touching = same_in_every_width(name, &plan, steps);
        assert!(touching > 1000, "{name}: {touching} touch");
    }
}
