//! Liquid in frames: films, bridges and the liquid that each particle holds are of one moment, that of `.liquid.csv`.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::Path;

use mercury_common::formats::table_head;
use mercury_common::frames::{ContactReader, ParticleReader};

use crate::common::{code, errors, folder_with, said, solve};

/// A grain is drawn away from another one of the same liquid: the bridge forms in the first forces, and breaks 0.017 s later. 4e-12 m^3 in all.
const PAIR: &str = r#"
time = { end = 0.018, step = 2e-5 }
domain = { min = [-0.02, -0.02, -0.02], max = [0.02, 0.02, 0.02] }
output = { interval = 2e-5, fstat = true, pictures = false, data = false, ene = false }
[materials.a]
density = 1e21
normal = { law = "linear", stiffness = 1.0, dissipation = 0.0 }
liquid = { law = "willett", surface_tension = 0.07, contact_angle_degrees = 30.0, max_bridge_volume = 2.5e-12, min_bridge_volume = 0.0, distribution = 0.8 }
[[particles]]
material = "a"
radius = 0.001
position = [-0.00199999, 0.0, 0.0]
velocity = [-0.01, 0.0, 0.0]
film_volume = 3e-12
[[particles]]
material = "a"
radius = 0.001
position = [0.0, 0.0, 0.0]
film_volume = 1e-12
"#;

/// Wet spheres and rods that fall on a floor which keeps a film, and dry as they go; some leave through the open sides.
const FEED: &str = r#"
gravity = [0.0, 0.0, -9.81]
time = { end = 0.04, step = 2e-5 }
liquid = { evaporation = 1e-9 }
output = { interval = 4e-5, fstat = true, pictures = false, data = false, ene = false, walls = false }
[domain]
min = [0.0, 0.0, -0.001]
max = [0.008, 0.008, 0.012]
periodic = ["y"]
[clumps.rod]
file = "rod.clump.toml"
material = "wet"
[materials.wet]
density = 2500.0
normal = { law = "linear", stiffness = 200.0, restitution = 0.5 }
liquid = { law = "bagheri", surface_tension = 0.02, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 2e-12, distribution = 0.7 }
[materials.floor]
density = 2500.0
normal = { law = "linear", stiffness = 300.0, restitution = 0.5 }
liquid = { law = "bagheri", surface_tension = 0.02, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 2e-12, distribution = 0.7 }
[[walls]]
name = "floor"
shape = "plane"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
material = "floor"
film = { thickness = 0.0, keeps = 0.4 }
[[insertions]]
name = "feed"
region = { shape = "box", min = [0.0, 0.0, 0.004], max = [0.008, 0.008, 0.010] }
mixture = [{ material = "wet", psd = { kind = "uniform", min_diameter = 0.8e-3, max_diameter = 1.2e-3, weighting = "number" }, share = 0.7 },
           { clump = "rod", psd = { kind = "monodisperse", diameter = 1.3e-3 }, share = 0.3, film_volume = 4.1e-12 }]
film_volume = 1.7e-12
share_by = "number"
rate = { number = 6000.0 }
velocity = { mean = [0.0, 0.0, -0.4], spread = [0.3, 0.3, 0.2] }
"#;

const ROD: &str = include_str!("../../../tests/scenes/good/rod.clump.toml");

/// The rows of a table, by the names of its head without their units.
fn table(path: &Path) -> Vec<HashMap<String, f64>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = (lines.next().unwrap().split(','))
        .map(table_head::name)
        .collect();
    let row = |line: &str| {
        let cells = line.split(',').map(|cell| cell.parse().unwrap());
        (names.iter().map(|name| (*name).to_owned()))
            .zip(cells)
            .collect()
    };
    lines.map(row).collect()
}

/// Runs a scene and compares each of its frames with its row of `.liquid.csv`. Returns how many bridges formed and broke.
fn frames_are_of_one_moment(scene: &str, set: &[&str]) -> [f64; 2] {
    let folder = folder_with("wet.toml", scene);
    fs::write(folder.path().join("rod.clump.toml"), ROD).unwrap();
    let mut arguments = vec!["wet.toml", "--quiet"];
    arguments.extend(set.iter().flat_map(|set| ["--set", set]));
    let output = solve(folder.path(), &arguments);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let path = |name: &str| folder.path().join("wet").join(name);
    let particles = ParticleReader::open(path("wet.particles.arrow")).unwrap();
    let contacts = ContactReader::open(path("wet.contacts.arrow")).unwrap();
    let rows = table(&path("wet.liquid.csv"));
    let frames = particles.frames().len();
    assert_eq!((rows.len(), contacts.frames().len()), (frames, frames));
    for (k, row) in rows.iter().enumerate() {
        let grains = particles.frame(k).unwrap();
        let frame = contacts.frame(k).unwrap();
        let column = |name: &str| particles.layout().number(&grains, name).unwrap();
        let (films, held) = (column("film_volume"), column("liquid_volume"));
        let bridges = frame.bridge_volume.as_ref().unwrap();
        // Sums of so many volumes in another order.
        let total = row["films"] + row["bridges"];
        let count = (grains.len() + bridges.len()) as f64;
        let close = |found: f64, expected: f64, what: &str| {
            let off = (found - expected).abs();
            assert!(
                off <= 2.0 * count * f64::EPSILON * total,
                "{what} at t = {}: {found} {expected}",
                row["time"]
            );
        };
        close(films.iter().sum(), row["films"], "films");
        close(bridges.iter().sum(), row["bridges"], "bridges");
        close(held.iter().sum(), total, "liquid of the particles");
        let there = bridges.iter().filter(|volume| **volume > 0.0).count();
        assert_eq!(there as f64, row["bridge_count"]);
        // Liquid of each particle, from the two tables.
        let mut expected: BTreeMap<u32, f64> = grains
            .id
            .iter()
            .copied()
            .zip(films.iter().copied())
            .collect();
        for (contact, volume) in bridges.iter().enumerate() {
            let share = if frame.j[contact].is_some() { 0.5 } else { 1.0 };
            for id in [Some(frame.i[contact]), frame.j[contact]]
                .into_iter()
                .flatten()
            {
                *expected.get_mut(&id).unwrap() += share * volume;
            }
        }
        for (id, held) in grains.id.iter().zip(held) {
            close(*held, expected[id], "liquid of a particle");
        }
    }
    let last = rows.last().unwrap();
    [last["formed"], last["ruptured"]]
}

#[test]
fn films_and_bridges_of_a_frame_are_those_of_its_row_of_the_balance() {
    let both = frames_are_of_one_moment(PAIR, &[]);
    assert_eq!(both, [1.0, 1.0]);
    for form in ["contact", "films"] {
        let form = format!("liquid.bridges_form={form:?}");
        let [formed, ruptured] = frames_are_of_one_moment(FEED, &[&form]);
        assert!(formed > 100.0 && ruptured > 50.0, "{formed} {ruptured}");
    }
}

#[test]
fn liquid_of_particles_needs_no_contacts_and_is_a_result() {
    let fields =
        "[[fields]]\nname = \"all\"\nfields = [\"liquid_fraction\"]\ncoordinates = \"O\"\n";
    let folder = folder_with("wet.toml", &format!("{PAIR}{fields}"));
    let set = ["--set", "output.fstat=false"];
    let result = ["--result", "held=sum(particles.liquid_volume)"];
    let output = solve(
        folder.path(),
        &[&["wet.toml", "--quiet"][..], &set, &result].concat(),
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let path = folder.path().join("wet/wet.particles.arrow");
    let reader = ParticleReader::open(path).unwrap();
    let held = |k: usize| {
        let frame = reader.frame(k).unwrap();
        reader
            .layout()
            .number(&frame, "liquid_volume")
            .unwrap()
            .to_vec()
    };
    // A bridge of 2.5e-12 m^3 takes 3/4 and 1/4 of it from films of 3e-12 and 1e-12 m^3, and each end holds half of it.
    let expected = [3e-12 - 1.875e-12 + 1.25e-12, 1e-12 - 0.625e-12 + 1.25e-12];
    for (held, expected) in held(0).iter().zip(expected) {
        assert!(
            (held / expected - 1.0).abs() < 4.0 * f64::EPSILON,
            "{held} {expected}"
        );
    }
    // The mean over the domain, a cube of 0.04 m, in every frame.
    let text = fs::read_to_string(folder.path().join("wet/wet.fields.all.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(lines.next(), Some("time [s],liquid_fraction"));
    let cells = lines.map(|line| line.rsplit(',').next().unwrap());
    let fractions: Vec<f64> = cells.map(|cell| cell.parse().unwrap()).collect();
    assert!(fractions.len() > 900, "{}", fractions.len());
    for fraction in fractions {
        assert!(
            (fraction * 6.4e-5 / 4e-12 - 1.0).abs() < 1e-14,
            "{fraction}"
        );
    }
    let summary = fs::read_to_string(folder.path().join("wet/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let result = &summary["results"]["held"];
    assert_eq!(result["unit"], "m3");
    let value = result["value"].as_f64().unwrap();
    assert!((value / 4e-12 - 1.0).abs() < 4.0 * f64::EPSILON, "{value}");
}

#[test]
fn a_field_of_liquid_in_a_dry_scene_is_warned_about() {
    let is_dry = |line: &&str| !line.starts_with("liquid =") && !line.starts_with("film_volume");
    let dry: Vec<&str> = PAIR.lines().filter(is_dry).collect();
    let fields =
        "[[fields]]\nname = \"all\"\nfields = [\"liquid_fraction\"]\ncoordinates = \"O\"\n";
    let folder = folder_with("dry.toml", &format!("{}\n{fields}", dry.join("\n")));
    let output = solve(folder.path(), &["dry.toml", "--check"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let all = errors(&output) + &said(&output);
    let expected = "fields.all: liquid_fraction is 0 everywhere, as the scene has no liquid";
    assert!(all.contains(expected), "{all}");
}
