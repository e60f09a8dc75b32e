//! Observation changes no byte: lanes, threads and the steps with output leave the state as it is, for every law and every example scene, and the contacts
//! that are written belong to the positions beside them.

use std::path::Path;
use std::sync::Arc;

use mercury_common::random::Stream;
use mercury_common::scene::{Files, LawPart};
use mercury_engine::cell::Cell;
use mercury_engine::contact::adhesion::liquid::Fit;
use mercury_engine::contact::{AnyAdhesion, law_keys};
use mercury_engine::forces::{ContactRecord, Partner, Watch};
use mercury_engine::lanes::Width;
use mercury_engine::state::Particle;
use mercury_engine::step::{Engine, Snapshot, StartOptions};
use mercury_solver::plan::{Plan, parse_scene, plan};
use mercury_tests::scenes::assert_every_law;

use crate::state_bytes::{planned, scenes};

const WATCH: Watch = Watch {
    records: true,
    audit: None,
};

/// How a run is evaluated and seen.
#[derive(Debug, Clone, Copy)]
struct Way {
    width: Width,
    threads: usize,
    /// Every how many steps the contacts are observed; 0: in the last step only.
    interval: u64,
}

/// One lane, one thread, seen at the end; then every width on one thread and the fastest on two, observed in every step, in every seventh and never.
fn ways() -> Vec<Way> {
    let on_one = Width::all().into_iter().map(|width| (width, 1));
    let evaluations = on_one.chain([(Width::fastest(), 2)]);
    evaluations
        .flat_map(|(width, threads)| {
            [0, 1, 7].map(|interval| Way {
                width,
                threads,
                interval,
            })
        })
        .collect()
}

/// A state and what was seen of its contacts.
struct End {
    state: Vec<u8>,
    /// Debug output distinguishes -0 from 0, which a record may print.
    seen: String,
}

/// Goes on from `start` for `steps` steps, the last of which is observed.
fn end_of(plan: &Arc<Plan>, start: Option<&Snapshot>, way: Way, steps: u64) -> (End, Engine) {
    let options = StartOptions::threads(way.threads).width(Some(way.width));
    let mut engine = match start {
        Some(state) => Engine::resume(Arc::clone(plan), state.clone(), options),
        None => Engine::start(Arc::clone(plan), options),
    }
    .expect("the scene starts");
    let mut made = 0;
    while made < steps {
        let next = match way.interval {
            0 => steps,
            interval => steps.min(made + interval),
        };
        engine
            .steps_at_once(next - made, Some(WATCH))
            .expect("the scene goes on");
        made = next;
    }
    let end = End {
        state: engine.snapshot().encode(),
        seen: format!("{:?}", engine.observation()),
    };
    (end, engine)
}

/// Runs a scene in all ways, compares states and contacts, and compares the overlaps of the pairs with the positions. Returns how many pairs touch and how
/// many are bridged across a gap in the end.
fn same_in_all_ways(
    name: &str,
    plan: &Arc<Plan>,
    start: Option<&Snapshot>,
    steps: u64,
) -> [usize; 2] {
    let mut first: Option<End> = None;
    let mut pairs = [0; 2];
    for way in ways() {
        let (end, engine) = end_of(plan, start, way, steps);
        pairs = assert_overlaps(name, &engine);
        match &first {
            Some(first) => {
                assert!(first.state == end.state, "{name}: other states in {way:?}");
                assert!(first.seen == end.seen, "{name}: other contacts in {way:?}");
            }
            None => first = Some(end),
        }
    }
    pairs
}

/// The overlap of each pair is R_A + R_B - |x_A - x_B| at the image of B. Both have some rounding errors of a part in 2^53 of the numbers that they are
/// computed from: 1e-15 m where these are below a metre, and as much of them where they are larger.
fn assert_overlaps(name: &str, engine: &Engine) -> [usize; 2] {
    let (particles, cell) = (&engine.particles.records, engine.cell());
    let mut pairs = [0; 2];
    for record in engine.observation().records {
        let Some((expected, size)) = overlap(particles, cell, &record) else {
            continue;
        };
        let error = (record.overlap - expected).abs();
        assert!(
            error <= 1e-15 * size.max(1.0),
            "{name}: rows {} and {:?}: overlap {:e} m, from the positions {expected:e} m",
            record.row,
            record.partner,
            record.overlap
        );
        pairs[usize::from(record.overlap <= 0.0)] += 1;
    }
    pairs
}

/// The overlap from the positions, m, and the largest number that it comes from, m; `None` at walls.
fn overlap(particles: &[Particle], cell: &Cell, record: &ContactRecord) -> Option<(f64, f64)> {
    let Partner::Particle { row, image } = record.partner else {
        return None;
    };
    let (a, b) = (&particles[record.row as usize], &particles[row as usize]);
    let shift = cell.shift(image);
    let apart = (a.position - b.position - shift).length();
    let size = a
        .position
        .abs()
        .max_element()
        .max(b.position.abs().max_element());
    Some((a.radius + b.radius - apart, size))
}

/// Laws without liquid, each as the keys of a material and as those of a pair.
const DRY: [&str; 6] = [
    r#"normal = { law = "linear", stiffness = 200.0, restitution = 0.7 }"#,
    r#"normal = { law = "linear", stiffness = 200.0, restitution = 0.7 }
    tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
    rolling = { law = "luding", friction = 0.1, dissipation = 1e-4 }
    torsion = { law = "luding", friction = 0.1, dissipation = 1e-4 }"#,
    r#"normal = { law = "hertz", youngs_modulus = 1e6, poisson_ratio = 0.3, restitution = 0.7 }
    tangential = { law = "mindlin", friction = 0.5 }"#,
    r#"normal = { law = "hertz", youngs_modulus = 1e6, poisson_ratio = 0.3, restitution = 0.7 }
    tangential = { law = "mindlin", friction = 0.5, load_history = "rescale" }
    rolling = { law = "luding", friction = 0.1, dissipation = 1e-4 }"#,
    r#"normal = { law = "plastic", loading_stiffness = 100.0, unloading_stiffness = 200.0, cohesion_stiffness = 20.0, penetration_depth = 0.05, dissipation = 1e-3 }
    tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.3 }"#,
    r#"normal = { law = "plastic", loading_stiffness = 100.0, unloading_stiffness = 200.0, cohesion_stiffness = 20.0, penetration_depth = 0.05, dissipation = 1e-3 }"#,
];

const FITS: [Fit; 5] = [
    Fit::Bagheri,
    Fit::WillettClassical,
    Fit::LianSeville,
    Fit::Willett,
    Fit::YoungLaplace,
];

/// The keys of a liquid, with which a law's name stands.
fn liquid(fit: Fit) -> String {
    format!(
        r#"liquid = {{ law = "{}", surface_tension = 0.05, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 4e-12 }}"#,
        fit.name()
    )
}

/// Over a thousand grains, so that they are divided among threads, in a jittered grid whose neighbours touch or nearly touch, in random motion on a floor
/// and across periodic faces. `several`: of three materials, one of which is dry and of other laws.
fn jittered(laws: &str, several: bool) -> Arc<Plan> {
    planned_text(&jittered_text(laws, several))
}

fn planned_text(text: &str) -> Arc<Plan> {
    let scene = parse_scene(Path::new("jittered.toml"), text, &[], Files::Unchecked)
        .unwrap_or_else(|error| panic!("{error}"));
    Arc::new(plan(&scene).unwrap_or_else(|error| panic!("{error}")))
}

fn jittered_text(laws: &str, several: bool) -> String {
    const SIDE: u64 = 10;
    const LAYERS: u64 = 12;
    const SPACING: f64 = 2.0e-3;
    let width = SPACING * SIDE as f64;
    let is_wet = laws.contains("liquid");
    let other = r#"
        [materials.n]
        density = 1500.0
        normal = { law = "linear", stiffness = 300.0, restitution = 0.5 }
        tangential = { law = "linear", stiffness_ratio = 0.3, friction = 0.4 }
    "#;
    let mut text = format!(
        r#"
        gravity = [0, 0, -9.81]
        time = {{ end = 1.0, step = 1e-5 }}
        domain = {{ min = [0, 0, -0.01], max = [{width}, {width}, 0.05], periodic = ["x", "y"] }}
        output = {{ interval = 0.1 }}
        # Some pairs overlap deeply at the start.
        guard = {{ policy = "off" }}
        [materials.m]
        density = 2000.0
        {laws}
        [[walls]]
        name = "floor"
        shape = "plane"
        point = [0, 0, 0.0]
        normal = [0, 0, 1]
        material = "m"
    "#
    );
    if several {
        text.push_str(&format!(
            "[materials.second]\ndensity = 1700.0\n{laws}\n{other}"
        ));
        for one in ["m", "second"] {
            text.push_str(&format!(
                "[[contacts]]\nbetween = [\"{one}\", \"n\"]\nnormal = {{ law = \"linear\", stiffness = 150.0, restitution = 0.5 }}\ntangential = {{ law = \"linear\", stiffness_ratio = 0.3, friction = 0.4 }}\n"
            ));
        }
    }
    let mut random = Stream::new(11, "jittered", 0);
    for k in 0..SIDE * SIDE * LAYERS {
        let [i, j, layer] = [k % SIDE, k / SIDE % SIDE, k / (SIDE * SIDE)].map(|n| n as f64 + 0.5);
        let mut place = [i, j, layer].map(|n| SPACING * (n + random.uniform_in(-0.03, 0.03)));
        place[2] = place[2].max(0.97e-3);
        let velocity = [0; 3].map(|_| random.uniform_in(-0.8, 0.8));
        let radius = random.uniform_in(0.97e-3, 1.02e-3);
        let material = match random.uniform() {
            _ if !several => "m",
            choice if choice < 0.2 => "n",
            choice if choice < 0.5 => "second",
            _ => "m",
        };
        let film = if is_wet && material != "n" {
            "film_volume = 4e-12"
        } else {
            ""
        };
        text.push_str(&format!(
            "[[particles]]\nmaterial = \"{material}\"\nradius = {radius:?}\nposition = {place:?}\nvelocity = {velocity:?}\n{film}\n"
        ));
    }
    text
}

/// Time for grains to part by more than a bridge holds: some 1e-4 m.
const STEPS: u64 = 28;

#[test]
fn observation_changes_no_byte_of_any_law_without_liquid() {
    let mut laws = Vec::new();
    for dry in DRY {
        for several in [false, true] {
            let plan = jittered(dry, several);
            laws.extend(plan.physics().laws.laws.iter().flatten().copied());
            let name = format!("{dry}, several materials: {several}");
            let [touching, _] = same_in_all_ways(&name, &plan, None, STEPS);
            assert!(touching > 300, "{name}: {touching} touch");
        }
    }
    assert_every_law(laws.into_iter());
}

#[test]
fn observation_changes_no_byte_of_any_law_of_liquid() {
    for (k, fit) in FITS.into_iter().enumerate() {
        // Each with and without friction; the laws that are compiled together with liquid are among them.
        for dry in [DRY[2], DRY[k % DRY.len()]] {
            let laws = format!("{dry}\n{}", liquid(fit));
            for several in [false, true] {
                let plan = jittered(&laws, several);
                let law = plan.physics().laws.get(0, 0).expect("grains meet");
                assert!(matches!(law.adhesion, AnyAdhesion::Liquid(law) if law.fit == fit));
                let name = format!("{laws}, several materials: {several}");
                let [touching, apart] = same_in_all_ways(&name, &plan, None, STEPS);
                assert!(
                    touching > 300 && apart > 100,
                    "{name}: {touching} touch, {apart} are bridged"
                );
            }
        }
    }
    // A law that is added is added here, too.
    let is_here = |fit: Fit| match fit {
        Fit::Bagheri
        | Fit::WillettClassical
        | Fit::LianSeville
        | Fit::Willett
        | Fit::YoungLaplace => FITS.contains(&fit),
    };
    assert!(FITS.into_iter().all(is_here));
}

/// Laws of dry cohesion, as the keys of a material, and whether they act over a gap.
const COHESIONS: [(&str, bool); 6] = [
    (r#"{ law = "jkr", work_of_adhesion = 10.0 }"#, true),
    (r#"{ law = "dmt", work_of_adhesion = 1.0 }"#, false),
    (
        r#"{ law = "van-der-waals", hamaker = 1.2e-8, separation = 1e-5, range = 1e-4 }"#,
        true,
    ),
    (
        r#"{ law = "reversible", force = 5e-3, stiffness = 50.0 }"#,
        true,
    ),
    (
        r#"{ law = "irreversible", work_of_adhesion = 2.0, stiffness = 50.0 }"#,
        true,
    ),
    (
        r#"{ law = "charged", charge = 1, force = 1e-3, stiffness = 50.0, van_der_waals_force = 5e-3 }"#,
        true,
    ),
];

#[test]
fn observation_changes_no_byte_of_any_law_of_dry_cohesion() {
    for (k, (cohesion, reaches)) in COHESIONS.into_iter().enumerate() {
        let dry = if cohesion.contains("jkr") {
            [DRY[2], DRY[3]]
        } else {
            [DRY[2], DRY[k % DRY.len()]]
        };
        for (laws, several) in [(dry[0], false), (dry[1], true)] {
            let laws = format!("{laws}\nadhesion = {cohesion}");
            let plan = jittered(&laws, several);
            let law = plan.physics().laws.get(0, 0).expect("grains meet");
            assert!(law.adhesion.dry().is_some());
            let name = format!("{laws}, several materials: {several}");
            let [touching, apart] = same_in_all_ways(&name, &plan, None, STEPS);
            assert!(
                touching > 300 && (apart > 40) == reaches,
                "{name}: {touching} touch, {apart} are held across a gap"
            );
            // A run that stops between goes on to the same bytes.
            let way = ways()[0];
            let (_, half) = end_of(&plan, None, way, STEPS / 2);
            let (rest, _) = end_of(&plan, Some(&half.snapshot()), way, STEPS - STEPS / 2);
            let (whole, _) = end_of(&plan, None, way, STEPS);
            assert!(
                rest.state == whole.state,
                "{name}: another state after a stop"
            );
        }
    }
    // A law that is added is added here, too.
    let laws = law_keys().into_iter();
    let of_part = laws.filter(|law| law.parts.contains(&LawPart::Adhesion));
    assert!(
        of_part
            .map(|law| format!("\"{}\"", law.name))
            .all(|name| COHESIONS.iter().any(|(keys, _)| keys.contains(&name)))
    );
}

/// Wet grains and sticky ones in one scene, whose contacts with each other are dry.
#[test]
fn observation_changes_no_byte_where_liquid_and_dry_cohesion_meet() {
    let wet = format!("{}\n{}", DRY[2], liquid(Fit::Bagheri));
    let text = jittered_text(&wet, true);
    let sticky = text.replace(
        &format!("[materials.second]\ndensity = 1700.0\n{wet}"),
        &format!(
            "[materials.second]\ndensity = 1700.0\n{}\nadhesion = {}",
            DRY[2], COHESIONS[0].0
        ),
    );
    assert_ne!(text, sticky);
    let plan = planned_text(&sticky);
    let laws = &plan.physics().laws;
    assert!(laws.has_liquid() && laws.has_dry_cohesion());
    let [touching, apart] = same_in_all_ways("wet and sticky", &plan, None, STEPS);
    assert!(
        touching > 300 && apart > 100,
        "{touching} touch, {apart} are held across a gap"
    );
}

/// Every part of the step is in an example scene: sheets, sprays, wear, clumps, servos, the audit.
#[test]
fn observation_changes_no_byte_of_any_example_scene() {
    let mut with_contacts = 0;
    for path in scenes() {
        let name = path.display().to_string();
        let plan = planned(&path);
        let mut engine = Engine::new(Arc::clone(&plan), 1).expect("an example scene starts");
        let size = |engine: &Engine| engine.particles.len().max(20) as u64;
        // To where the first grains touch, or as far as a million particle-steps go.
        let mut made = 0;
        while made < 1_000_000 && engine.observation().particle_contacts < size(&engine) / 2 {
            let steps = (100_000 / size(&engine)).clamp(1, 4000);
            if engine.steps_at_once(steps, Some(WATCH)).is_err() {
                break;
            }
            made += steps * size(&engine);
        }
        let steps = (25_000 / size(&engine)).clamp(4, 200);
        let state = engine.snapshot();
        let [touching, apart] = same_in_all_ways(&name, &plan, Some(&state), steps);
        with_contacts += usize::from(touching + apart > 0);
    }
    assert!(
        with_contacts >= 15,
        "{with_contacts} scenes have contacts of grains"
    );
}
