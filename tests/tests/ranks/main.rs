//! One scene on several ranks: the same bytes as in one process.
//!
//! Ranks are threads here, with blocks of 64 rows, so that small scenes have many. State and observations of the first rank are compared with those
//! of an engine without others: in the middle, at looks, after a checkpoint on other ranks.

mod compare;
mod mistakes;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::thread;

use mercury_engine::forces::{LoadSums, SlotState};
use mercury_engine::liquid::LiquidRow;
use mercury_engine::ranks::{Ranks, Share, Threads};
use mercury_engine::step::{Engine, Part, RunError, Snapshot};
use mercury_solver::plan::Plan;

use compare::{Look, PIECES, ROWS, Seen, compared, on_ranks, options, same_on_any_ranks, scene};

/// Bridges that were there before some looks or after them, but not both, at grains of the first half of the rows and of the second one.
fn changed_bridges(looks: &[Look]) -> [usize; 2] {
    let bridges = |look: &Look| look.bridges.iter().copied().collect::<BTreeSet<_>>();
    let (before, after) = (bridges(&looks[0]), bridges(looks.last().unwrap()));
    let ends = |of: &BTreeSet<_>| of.iter().map(|(ends, _)| *ends).collect::<BTreeSet<_>>();
    let (ends_before, ends_after) = (ends(&before), ends(&after));
    let broken = before.iter().filter(|(ends, _)| !ends_after.contains(ends));
    let formed = after.iter().filter(|(ends, _)| !ends_before.contains(ends));
    let changed: Vec<bool> = broken.chain(formed).map(|(_, is_late)| *is_late).collect();
    [false, true].map(|half| changed.iter().filter(|is_late| **is_late == half).count())
}

#[test]
fn a_dense_bed() {
    same_on_any_ranks(&scene("bench/dense-2k.toml", &[]), 100);
}

/// Grains of several sizes come and leave, cross planes and a periodic face, are followed, and fall on a plate that moves.
fn busy(periodic: bool, set: &[&str]) -> Arc<Plan> {
    let periodic = if periodic { "[\"x\", \"y\"]" } else { "[]" };
    let periodic = format!("domain.periodic={periodic}");
    let mut all = vec![
        periodic.as_str(),
        "title=\"busy\"",
        "deletions=[{ name = \"out\", region = { shape = \"half-space\", point = [0.0, 0.0, 0.003], normal = [0.1, 0.0, -1.0] } }]",
        "fluxes=[{ name = \"low\", plane = { point = [0.0, 0.0, 0.006], normal = [0.0, 0.0, -1.0] } }, { name = \"mid\", plane = { point = [0.024, 0.0, 0.0], normal = [1.0, 0.0, 0.0] } }]",
        "insertions=[{ name = \"feed\", region = { shape = \"box\", min = [0.004, 0.004, 0.07], max = [0.044, 0.044, 0.077] }, material = \"bead\", psd = { kind = \"uniform\", min_diameter = 0.001, max_diameter = 0.004, weighting = \"number\" }, rate = { number = 20000.0 }, total = { number = 5000 }, velocity = { mean = [0.3, 0.1, -1.5], spread = [0.2, 0.2, 0.2] } }]",
        "walls=[{ name = \"plate\", shape = \"disc\", origin = [0.024, 0.024, 0.068], axis = [0.0, 0.02, 1.0], radius = 0.01, material = \"bead\", motion = [{ kind = \"translation\", velocity = [0.1, 0.0, -0.2] }] }]",
        "output.track=[\"feed\"]",
        "output.left=true",
    ];
    all.extend_from_slice(set);
    scene("bench/dense-2k.toml", &all)
}

#[test]
fn grains_that_come_and_leave() {
    for periodic in [false, true] {
        let counts = same_on_any_ranks(&busy(periodic, &[]), 60);
        assert!(
            counts.lists > 10 && counts.inserted > 40 && counts.removed > 5,
            "{counts:?}"
        );
    }
}

#[test]
fn sizes_apart() {
    same_on_any_ranks(&scene("bench/poly-20k.toml", &[]), 1);
}

/// Grains of a millimetre fall on a sphere of a metre, which has contacts with rows of all ranks.
#[test]
fn a_sphere_a_thousand_times_its_neighbours() {
    let plan = scene(
        "bench/dense-2k.toml",
        &[
            "time.step=2e-6",
            "domain={ min = [-0.6, -0.6, -0.6], max = [0.6, 0.6, 0.6] }",
            "walls=[]",
            "particles=[{ name = \"giant\", position = [0.0, 0.0, 0.0], radius = 0.5, material = \"bead\" }]",
            "insertions=[{ name = \"rain\", region = { shape = \"box\", min = [-0.02, -0.02, 0.5], max = [0.02, 0.02, 0.5035] }, material = \"bead\", psd = { kind = \"uniform\", min_diameter = 0.0009, max_diameter = 0.0011, weighting = \"number\" }, total = { number = 1500 }, velocity = { mean = [0.2, 0.1, -1.5], spread = [0.1, 0.1, 0.1] } }]",
        ],
    );
    let seen = on_ranks(&plan, 1, 1, None, &[1000]);
    let state = Snapshot::decode(seen.states.last().unwrap()).unwrap();
    let ids = state.particles().unwrap().ids;
    let giant = ids.iter().position(|id| id.number() == 0).unwrap() as u32;
    let mut blocks = BTreeSet::new();
    for pair in state.pairs().unwrap().iter() {
        let ends = [pair.row, pair.partner];
        if pair.state == SlotState::Touching && ends.contains(&giant) {
            blocks.extend(ends.map(|row| row as usize / ROWS));
        }
    }
    assert!(blocks.len() > 14, "the giant touches rows of {blocks:?}");
    same_on_any_ranks(&plan, 1000);
}

#[test]
fn a_drum_of_a_mesh() {
    let counts = same_on_any_ranks(&scene("bench/mesh-drum-6k.toml", &[]), 300);
    assert!(counts.lists > 1, "{counts:?}");
}

/// Walls that wear do it on each rank, by the contacts of all.
#[test]
fn a_screen_that_wears() {
    // Many small grains, so that those on the bars are of several ranks.
    let plan = scene(
        "wear/screen.toml",
        &[
            "insertions.0.rate={number=20000}",
            "insertions.0.mixture=[{ material = \"small\", psd = { kind = \"uniform\", min_diameter = 0.0015, max_diameter = 0.002, weighting = \"number\" }, share = 1.0 }]",
        ],
    );
    let start = on_ranks(&plan, 1, 1, None, &[12_000]);
    let after = on_ranks(&plan, 1, 1, start.states.last().map(Vec::as_slice), &PIECES);
    let wear = |seen: &Seen| {
        let state = Snapshot::decode(seen.states.last().unwrap()).unwrap();
        let mut sections = state.sections().iter();
        let (_, content) = sections.find(|(name, _)| *name == "wear").unwrap();
        content.to_vec()
    };
    assert!(wear(&start) != wear(&after), "nothing wears in these steps");
    same_on_any_ranks(&plan, 12_000);
}

#[test]
fn a_press_with_a_servo() {
    same_on_any_ranks(&scene("press.toml", &[]), 20_000);
}

#[test]
fn a_triaxial_cell() {
    same_on_any_ranks(&scene("triaxial.toml", &[]), 20_000);
}

#[test]
fn discs() {
    same_on_any_ranks(&scene("discs-2d.toml", &[]), 30_000);
}

#[test]
fn a_drum_of_clumps() {
    let counts = same_on_any_ranks(&scene("clumps/drum.toml", &[]), 6_000);
    assert!(counts.lists > 0, "{counts:?}");
}

#[test]
fn a_gas_of_rods() {
    same_on_any_ranks(&scene("clumps/rod-gas.toml", &[]), 3_000);
}

/// A wet bed that is thrown against a side: bridges form at touches, and break.
fn wet_bed(set: &[&str]) -> Arc<Plan> {
    let dry = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/bench/dense-2k.csv");
    let dry = std::fs::read_to_string(dry).unwrap();
    let mut rows = dry.lines();
    let head = format!("{},film_volume", rows.next().unwrap());
    let rows = rows.map(|row| format!("{row},1e-12"));
    let wet: Vec<String> = std::iter::once(head).chain(rows).collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wet.csv");
    std::fs::write(&file, wet.join("\n")).unwrap();
    let file = format!("particles.0.file=\"{}\"", file.display());
    let shared = [
        &file,
        "materials.bead.liquid={ law = \"willett\", surface_tension = 0.07, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 2e-13, distribution = 0.7 }",
        "gravity=[60.0, 20.0, -9.81]",
    ];
    scene("bench/dense-2k.toml", &[&shared, set].concat())
}

/// What liquid did between the first look and the last one.
fn liquid_of(looks: &[Look]) -> [LiquidRow; 2] {
    let of = |look: &Look| look.liquid.unwrap();
    let rows = [of(&looks[0]), of(looks.last().unwrap())];
    let [before, after] = rows.map(|row| row.balance);
    let events = [
        after.formed - before.formed,
        after.ruptured - before.ruptured,
    ];
    let halves = changed_bridges(looks);
    assert!(events.iter().all(|count| *count > 20), "{events:?}");
    assert!(halves.iter().all(|count| *count > 10), "{halves:?}");
    rows
}

#[test]
fn a_wet_bed() {
    let (_, looks) = compared(&wet_bed(&[]), 200);
    liquid_of(&looks);
}

/// Bridges that form as films meet, at walls with films, too; all of it evaporates.
#[test]
fn films_that_meet_and_dry() {
    let plan = wet_bed(&[
        "liquid.bridges_form=\"films\"",
        "liquid.neighbours=\"same-kind\"",
        "liquid.evaporation=1e-4",
        "walls.0.film={ thickness = 1e-6, keeps = 0.3 }",
        "output.energy_budget=true",
    ]);
    let (_, looks) = compared(&plan, 200);
    let [before, after] = liquid_of(&looks);
    assert!(after.balance.evaporated.value() > before.balance.evaporated.value());
    assert!(after.wall_films != before.wall_films);
    let liquid = |look: &Look| look.audit.losses.of("liquid");
    assert!(liquid(&looks[0]) != liquid(looks.last().unwrap()));
}

/// Droplets with mass that hit grains of all ranks, bounce off a wall that moves and fly through a periodic face; grains leave with their bridges,
/// and others come.
#[test]
fn sprays_and_liquid_with_mass() {
    let spray = "sprays=[{ name = \"fan\", position = [0.024, 0.024, 0.074], axis = [0.0, 0.0, -1.0], pattern = { kind = \"full-cone\", half_angle_degrees = 50.0 }, flow_rate = 2e-5, speed = { mean = 20.0, spread = 5.0 }, droplets = { kind = \"monodisperse\", diameter = 4e-4 }, liquid_density = 1000.0, at_walls = \"bounce\", restitution = 0.5, momentum = true, mass = true, drag = { law = \"schiller-naumann\", gas_density = 1.2, gas_viscosity = 1.8e-5, gas_velocity = [5.0, 0.0, 0.0] } }]";
    let plan = wet_bed(&[
        spray,
        "domain.periodic=[\"x\"]",
        "liquid.evaporation=1e-4",
        "walls=[{ name = \"box\", shape = \"box\", sides = [\"-y\", \"+y\", \"-z\"], material = \"bead\" }, { name = \"plate\", shape = \"disc\", origin = [0.024, 0.024, 0.07], axis = [0.0, 0.02, 1.0], radius = 0.003, material = \"bead\", motion = [{ kind = \"translation\", velocity = [0.1, 0.0, -0.2] }] }]",
        "deletions=[{ name = \"out\", region = { shape = \"half-space\", point = [0.0, 0.04, 0.0], normal = [0.0, 1.0, 0.0] } }]",
        "insertions=[{ name = \"feed\", region = { shape = \"box\", min = [0.004, 0.004, 0.06], max = [0.044, 0.03, 0.069] }, material = \"bead\", psd = { kind = \"uniform\", min_diameter = 0.001, max_diameter = 0.002, weighting = \"number\" }, rate = { number = 20000.0 }, total = { number = 5000 }, film_volume = 1e-12, velocity = { mean = [0.3, 0.1, -1.5], spread = [0.2, 0.2, 0.2] } }]",
    ]);
    let (counts, looks) = compared(&plan, 200);
    assert!(counts.removed > 5 && counts.inserted > 40, "{counts:?}");
    let [before, after] = liquid_of(&looks);
    assert!(after.balance.deleted.value() > before.balance.deleted.value());
    let [in_flight, emitted, caught, lost, left] =
        std::array::from_fn(|k| after.sprayed[k] - before.sprayed[k]);
    assert!(
        emitted > 0.0 && caught > 0.0 && after.sprayed[0] > 0.0,
        "{in_flight} {emitted} {caught} {lost} {left}"
    );
}

#[test]
fn wet_clumps() {
    let plan = scene(
        "clumps/drum.toml",
        &[
            "materials.plastic.liquid={ law = \"willett\", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-11, distribution = 0.7 }",
            "insertions.0.mixture=[{ clump = \"rod\", psd = { kind = \"uniform\", min_diameter = 4.5e-3, max_diameter = 6e-3, weighting = \"number\" }, share = 1.0, film_volume = 1e-9 }]",
            "gravity=[40.0, 0.0, -9.81]",
        ],
    );
    let (_, looks) = compared(&plan, 2_000);
    let [before, after] = [0, looks.len() - 1].map(|k| looks[k].liquid.unwrap().balance);
    assert!(after.formed > before.formed, "{after:?}");
    assert!(after.ruptured > before.ruptured, "{after:?}");
    let halves = changed_bridges(&looks);
    assert!(halves.iter().all(|count| *count > 0), "{halves:?}");
}

/// The audit of a bed with a servo, a plate that vanishes, and grains that come and leave.
#[test]
fn an_audit_of_energies() {
    let plan = scene(
        "bench/dense-2k.toml",
        &[
            "output.energy_budget=true",
            "gravity=[200.0, 0.0, -9.81]",
            "materials.bead.rolling={ law = \"luding\", friction = 0.05 }",
            // Gone in the middle of the steps compared: 70 of 148 behind 60.
            "walls=[{ name = \"box\", shape = \"box\", sides = [\"-x\", \"-y\", \"+y\", \"-z\"], material = \"bead\" }, { name = \"gate\", shape = \"plane\", point = [0.048, 0.0, 0.0], normal = [-1.0, 0.0, 0.0], material = \"bead\", until = 0.0039 }, { name = \"lid\", shape = \"plane\", point = [0.0, 0.0, 0.06], normal = [0.0, 0.0, -1.0], material = \"bead\", motion = [{ kind = \"servo\", axis = [0.0, 0.0, 1.0], force = -20.0, max_speed = 2.0 }] }]",
            "guard.policy=\"warn\"",
            "deletions=[{ name = \"out\", region = { shape = \"half-space\", point = [0.0463, 0.0, 0.0], normal = [1.0, 0.0, 0.0] } }]",
        ],
    );
    let (counts, looks) = compared(&plan, 60);
    assert!(counts.removed > 5, "{counts:?}");
    let [before, after] = [&looks[0].audit, &looks.last().unwrap().audit];
    let changes = [
        after.losses.of("normal") - before.losses.of("normal"),
        after.losses.of("tangential") - before.losses.of("tangential"),
        after.losses.of("rolling") - before.losses.of("rolling"),
        after.servo_work - before.servo_work,
        after.left.total() - before.left.total(),
        after.vanished.total() - before.vanished.total(),
    ];
    assert!(changes.iter().all(|change| *change != 0.0), "{changes:?}");
}

#[test]
fn an_audit_of_sticky_powder() {
    let (_, looks) = compared(
        &scene(
            "jkr-powder.toml",
            &["insertions.0.rate={ number = 400000.0 }"],
        ),
        4_000,
    );
    let adhesion = |look: &Look| look.audit.losses.of("adhesion");
    assert!(adhesion(&looks[0]) != adhesion(looks.last().unwrap()));
}

#[test]
fn loads_on_the_triangles_of_a_drum() {
    let plan = scene(
        "bench/mesh-drum-6k.toml",
        &["output.triangle_loads=true", "output.data=true"],
    );
    let (counts, looks) = compared(&plan, 300);
    assert!(counts.lists > 1, "{counts:?}");
    let loads: Vec<&LoadSums> = looks
        .iter()
        .filter_map(|look| look.loads.as_ref())
        .collect();
    let evaluations: Vec<u64> = loads.iter().map(|sums| sums.evaluations).collect();
    // Since the start, and behind each second piece.
    assert_eq!(
        evaluations[evaluations.len() - 2..],
        [300 + 1 + 1 + 40, 7 + 100]
    );
    assert!(loads.iter().all(|sums| sums.loads.len() > 20));
}

#[test]
fn two_spheres_are_fewer_than_the_ranks() {
    same_on_any_ranks(&scene("two-spheres.toml", &[]), 1);
}

/// Two agglomerates, one of which shatters on a plate, with the contacts of glued pairs.
fn agglomerates() -> Arc<Plan> {
    scene("agglomerate.toml", &[])
}

#[test]
fn agglomerates_that_shatter() {
    let counts = same_on_any_ranks(&agglomerates(), 30);
    assert!(counts.broken.are_spread(), "{counts:?}");
}

/// A block that is glued to floor and lid, and across a periodic face, has no contacts inside, and is torn apart by a servo.
#[test]
fn a_block_that_is_torn_apart() {
    let plan = scene(
        "agglomerate.toml",
        &[
            "domain={ min = [0.0, -0.02, -0.001], max = [0.016, 0.04, 0.05], periodic = [\"x\"] }",
            "particles=[{ material = \"grain\", radius = 1e-3, lattice = { min = [0.001, 0.0, 0.001], max = [0.0155, 0.0145, 0.0155], spacing = 0.002 } }]",
            "walls=[{ name = \"floor\", shape = \"plane\", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0], material = \"grain\" }, { name = \"lid\", shape = \"plane\", point = [0.0, 0.0, 0.016], normal = [0.0, 0.0, -1.0], material = \"grain\", motion = [{ kind = \"servo\", axis = [0.0, 0.0, 1.0], force = 60.0, max_speed = 2.0 }] }]",
            "bonds=[{ name = \"glue\", law = \"beam\", walls = [\"floor\", \"lid\"], youngs_modulus = 1e7, damping = 0.05, tensile_strength = 3e4, shear_strength = 3e4, strength_spread = 0.3, contact = false }]",
        ],
    );
    let counts = same_on_any_ranks(&plan, 1);
    assert!(counts.broken.are_spread(), "{counts:?}");
}

/// Grains that come and leave are glued where they touch, from a time on at which many do, and break.
#[test]
fn grains_that_are_glued_as_they_touch() {
    for (periodic, contact) in [(false, true), (true, false)] {
        let bonds = format!(
            "bonds=[{{ name = \"first\", between = [\"bead\", \"bead\"], when = \"contact\", from = 2.6e-3, until = 4e-3, law = \"beam\", walls = [\"plate\"], youngs_modulus = 1e5, damping = 0.1, tensile_strength = 300.0, strength_spread = 1.0, contact = {contact} }}, {{ name = \"then\", when = \"contact\", from = 3.5e-3, law = \"parallel\", normal_stiffness = 1e8, shear_stiffness = 5e7, contact = true }}]"
        );
        let counts = same_on_any_ranks(&busy(periodic, &[&bonds]), 60);
        let happened = counts.broken.are_spread();
        assert!(
            happened && counts.glued > 100 && counts.removed > 5,
            "{counts:?}"
        );
    }
}

/// Rods that stick where they touch.
#[test]
fn a_gas_of_rods_that_stick() {
    let plan = scene(
        "clumps/rod-gas.toml",
        &[
            "bonds=[{ name = \"glue\", when = \"contact\", law = \"beam\", youngs_modulus = 3e3, tensile_strength = 50.0 }]",
        ],
    );
    let counts = same_on_any_ranks(&plan, 3_000);
    assert!(counts.glued > 0, "{counts:?}");
}

/// Balls lie on a sheet that a plate with a servo presses from below.
fn balls_on_sheet() -> Arc<Plan> {
    scene(
        "membrane.toml",
        &[
            "particles=[{ material = \"ball\", radius = 1e-3, lattice = { min = [-0.02, -0.02, 0.0012], max = [0.02, 0.02, 0.0036], spacing = 0.0022 }, velocity = [0.05, 0.0, -0.2] }]",
            "walls=[{ name = \"plate\", shape = \"disc\", origin = [0.0, 0.0, -0.0002], axis = [0.0, 0.0, 1.0], radius = 0.025, material = \"ball\", motion = [{ kind = \"servo\", axis = [0.0, 0.0, 1.0], force = 0.2, max_speed = 0.1 }] }]",
            "membranes.0.walls=true",
            "guard={ policy = \"warn\" }",
        ],
    )
}

#[test]
fn balls_on_a_sheet_on_a_plate() {
    let counts = same_on_any_ranks(&balls_on_sheet(), 500);
    let happened = counts.at_sheets.are_spread();
    assert!(happened && counts.of_vertices > 3, "{counts:?}");
}

/// A sleeve under pressure, held by a wall with a servo.
#[test]
fn a_sample_in_a_sleeve() {
    let counts = same_on_any_ranks(&scene("sleeve.toml", &[]), 20_500);
    let happened = counts.at_sheets.are_spread();
    assert!(happened, "{counts:?}");
}

/// A part that does not say that it works on several ranks.
struct Foreign;

impl Part for Foreign {
    fn name(&self) -> &str {
        "foreign"
    }
}

/// Parts that do not work on several ranks are refused by name, and nothing hangs.
#[test]
fn other_parts_are_refused() {
    let plan = scene("two-spheres.toml", &[]);
    let mut team = Threads::team(2).into_iter();
    let mut options = || {
        let share = Share::new(Box::new(team.next().unwrap()));
        options(1, Some(share)).parts(vec![Box::new(Foreign)])
    };
    let (first, second) = (options(), options());
    let of_second = Arc::clone(&plan);
    let second = thread::spawn(move || Engine::follow(of_second, second).unwrap_err());
    let error = Engine::start(plan, first).err().unwrap();
    assert_eq!(error, second.join().unwrap());
    let what = "foreign".to_owned();
    assert_eq!(error, RunError::OnRanks { what });
}

/// Messages go where they are meant to.
#[test]
fn threads_exchange_bytes() {
    let team = Threads::team(3);
    let work = |mut rank: Threads| {
        let (own, count) = rank.place();
        let to = (0..count).filter(|&to| to != own);
        let to = to.map(|to| (to, vec![own as u8, to as u8])).collect();
        let others: Vec<usize> = (0..count).filter(|&from| from != own).collect();
        let came = rank.exchange(to, &others);
        let expected: Vec<Vec<u8>> = others
            .iter()
            .map(|&from| vec![from as u8, own as u8])
            .collect();
        assert_eq!(came, expected);
        assert_eq!(rank.all(vec![own as u8]), [[0], [1], [2]]);
        let first = rank.gather(vec![own as u8]);
        assert_eq!(first.len(), if own == 0 { 3 } else { 0 });
        assert_eq!(rank.broadcast(vec![own as u8]), [0]);
        let mut numbers = [own as f64, -(own as f64)];
        rank.largest(&mut numbers);
        assert_eq!(numbers, [2.0, 0.0]);
        let mut sums = [own as i64, 1];
        rank.add(&mut sums);
        assert_eq!(sums, [3, 3]);
    };
    let threads: Vec<_> = team
        .into_iter()
        .map(|rank| thread::spawn(move || work(rank)))
        .collect();
    threads
        .into_iter()
        .for_each(|thread| thread.join().unwrap());
}
