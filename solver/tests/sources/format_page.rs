//! The page of the scene format says what the program does: each of its keys runs, each key that runs is described; and each number with a
//! unit may be written with another one.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use mercury_common::scene::{Files, Scene, SceneErrors};
use mercury_solver::plan::{parse_scene, plan};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// `scenes/keys.toml`, which has every key once.
fn all_keys() -> String {
    fs::read_to_string(repository().join("scenes/keys.toml")).unwrap()
}

/// What excludes something of that scene, and is put into its place; a line for each key.
const ALTERNATIVES: &[&str] = &[
    "materials.a.normal={ law = \"hertz\", effective_modulus = 1e7, damping = 0.1 }\nmaterials.a.tangential={ law = \"mindlin\", friction = 0.5, effective_shear_modulus = 1e6 }",
    "materials.b.normal={ law = \"linear\", collision_time = 1e-3, mass = 1e-3, restitution = 0.5 }",
    "materials.b.tangential={ law = \"linear\", stiffness_ratio = 0.3, friction = 0.5 }",
    "contacts[0].rolling={ law = \"luding\", friction = 0.1, static_friction = 0.1, stiffness = 100.0, dissipation = 0.1 }",
    "contacts[0].torsion={ law = \"luding\", friction = 0.1, static_friction = 0.1, stiffness = 100.0 }",
    "walls.plate.motion=[{ kind = \"servo\", axis = [0, 0, 1], pressure = 10.0, area = 0.01, max_speed = 0.1, from = 0.0, until = 0.5 }]",
    "walls.plate.motion=[{ kind = \"servo\", axis = [0, 0, 1], pressure = [[0.0, 10.0], [1.0, 20.0]], max_speed = 0.1 }]",
    "walls.plate.motion=[{ kind = \"servo\", axis = [0, 0, 1], force = { table = \"load.csv\" }, max_speed = 0.1 }]",
    "walls.lid.from=0.1",
    "walls.lid.until=0.1",
    "guard={ policy = \"warn\", overlap = 0.5, way = 0.5 }",
    "contact.clamp_tension=true",
    "walls.mesh.wear={ law = \"finnie\", constant = 1e-12, acceleration = 1.0 }",
    "walls.mesh.wear={ law = \"oka\", hardness = 1.2e9, reference_erosion = 65.0, reference_speed = 104.0, reference_diameter = 326e-6, speed_exponent = 2.35, diameter_exponent = 0.19, n1 = 0.8, n2 = 1.3 }",
    "contacts[0].liquid={ law = \"willett\", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-11 }",
    "materials.a.liquid={ law = \"bagheri\", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-11, roughness = 1e-6 }",
    "particles[0].prescribed={ angular_velocity = [0.0, \"free\", \"free\"] }",
    "particles[3]={ file = \"still.csv\", material = \"a\", fixed = true }",
    "particles[4]={ clump = \"rod\", lattice = { min = [0.3, 0.3, 0.7], max = [0.5, 0.3, 0.7], spacing = 0.1, jitter = 0.001 }, orientation = \"random\" }",
    "insertions.feed={ region = { shape = \"sphere\", origin = [0.7, 0.7, 0.7], radius = 0.1 }, clump = \"rod\", total = { number = 3 } }",
    "insertions.feed={ region = { shape = \"cylinder\", axis = [0, 0, 1], origin = [0.7, 0.7, 0.6], radius = 0.1, along = [0.0, 0.2] }, material = \"a\", psd = { kind = \"monodisperse\", diameter = 0.01 }, total = { volume = 1e-5 }, rate = { number = 10.0 } }",
    "insertions.feed={ region = { shape = \"cone\", axis = [0, 0, 1], origin = [0.7, 0.7, 0.6], radii = [0.1, 0.1], along = [0.0, 0.2] }, material = \"a\", psd = { kind = \"monodisperse\", diameter = 0.01 }, total = { full = true }, rate = { volume = 1e-3 } }",
    "insertions.feed={ region = { shape = \"mesh\", file = \"box.obj\", scale = 1.0, offset = [0, 0, 0], rotate = { axis = [0, 0, 1], degrees = 90.0 } }, material = \"a\", psd = { kind = \"monodisperse\", diameter = 0.01 }, rate = { table = \"rate.csv\" } }",
    "insertions.feed.region={ shape = \"union\", of = [{ shape = \"box\", min = [0.6, 0.6, 0.6], max = [0.7, 0.8, 0.8] }, { shape = \"half-space\", point = [0, 0, 0.8], normal = [0, 0, 1] }] }",
    "insertions.feed.mixture[0].psd={ kind = \"normal\", mean_diameter = 0.01, standard_deviation = 0.001, weighting = \"volume\", cut = [0.01, 0.99] }",
    "insertions.feed.mixture[0].psd={ kind = \"lognormal\", median_diameter = 0.01, sigma = 0.1, weighting = \"volume\", cut = [0.01, 0.99] }",
    "insertions.feed.mixture[0].psd={ kind = \"rosin-rammler\", d63 = 0.01, exponent = 4.0, weighting = \"volume\", cut = [0.1, 0.99] }",
    "insertions.feed.mixture[0].psd={ kind = \"ggs\", max_diameter = 0.01, exponent = 4.0, weighting = \"volume\", cut = [0.1, 0.99] }",
    "insertions.feed.mixture[0].psd={ kind = \"phi-normal\", median_diameter = 0.01, sigma_phi = 0.1, weighting = \"volume\", cut = [0.01, 0.99] }",
    "insertions.feed.mixture[0].psd={ kind = \"classes\", diameters = [0.008, 0.01, 0.012], shares = [1, 2], model = \"number-uniform\", weighting = \"volume\" }",
    "insertions.feed.mixture[0].psd={ kind = \"mixture\", weighting = \"number\", of = [{ share = 1.0, kind = \"monodisperse\", diameter = 0.01 }] }",
    "insertions.feed.mixture[0].psd={ file = \"law.toml\" }",
    "fluxes.gate.plane.radius=0.1",
    "fields.profile={ name = \"profile\", points = \"points.txt\", coordinates = \"Z\", materials = [\"a\"], since = \"first\", width = \"1.5d\" }",
    "fields.profile={ name = \"profile\", spacing = [0.1], coordinates = \"Z\", smooth = [0.1, 0.05] }",
    "fields.tube.limits={ r = [0.0, 0.4] }",
    "fields.tube={ name = \"tube\", coordinates = \"Rphi\", spacing = [0.1, 0.1], limits = { phi = [0.0, 1.0] } }",
    "sprays.nozzle.pattern={ kind = \"full-cone\", half_angle_degrees = 20.0 }\nsprays.nozzle.at_walls=bounce\nsprays.nozzle.restitution=0.5",
    "materials.a.liquid={ law = \"young-laplace\", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-9, accuracy = 1e-3 }",
    "walls.plate.film={ thickness = 1e-6, keeps = 0.5 }\nsprays.nozzle.at_walls=film",
    "liquid.evaporation=1e-9",
    "sprays.nozzle.pattern={ kind = \"hollow-cone\", half_angles_degrees = [10.0, 20.0] }",
    "sprays.nozzle.flow_rate={ table = \"flow.csv\" }",
    "sprays.nozzle.speed=2.0",
    "sprays=[{ name = \"list\", pattern = { kind = \"points\", file = \"droplets.csv\" }, liquid_density = 1000.0 }]",
    "membranes=[{ name = \"ball\", shape = \"sphere\", origin = [0.5, 0.5, 0.5], radius = 0.1, edge = 0.05, material = \"b\", thickness = 1e-3, youngs_modulus = 1e6, pressure = { fluid = 1e4, bulk_modulus = 1e6, ambient = 0.0 } }]",
    "membranes.patch.pressure=[[0.0, 1.0], [1.0, 2.0]]",
    "membranes.patch.fixed=[\"rim\", { shape = \"half-space\", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }]",
    "output.fstat=true",
    "output.vtk_interval=0.1",
    "time.until_at_rest=true",
    "domain.dimensions=3",
    "contact.tangential_history=incremental",
    "contact.coulomb_limits=elastic",
    "contact.sliding_normal=step",
    "contact.wall_curvature=true",
    "contact.startup_increment=true",
    "contact.rolling_lever=2R*",
    "contact.overlap_error=0.6",
    "contact.overlap_warning=0.2",
    "contact.clump_mass=contact-point",
];

fn settings(lines: &str) -> Vec<String> {
    lines.lines().map(str::to_owned).collect()
}

/// The files of `scenes/` that the scene of all keys names, and those that the alternatives name.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["motion.csv", "particles.csv", "plate.stl", "rod.clump.toml"] {
        fs::copy(
            repository().join("scenes").join(name),
            folder.path().join(name),
        )
        .unwrap();
    }
    let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| 0.6 + 0.2 * bit as f64);
    let mut cube: String = (0..8)
        .map(|k| corner(k).map(|x| x.to_string()).join(" "))
        .map(|point| format!("v {point}\n"))
        .collect();
    for face in [
        "1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6",
    ] {
        cube += &format!("f {face}\n");
    }
    for (name, text) in [
        ("load.csv", "t,force\n0,1\n1,2\n"),
        ("still.csv", "x,y,z,radius\n0.5,0.1,0.5,0.01\n"),
        ("rate.csv", "t,cumulative\n0,0\n1,0.1\n"),
        ("points.txt", "0.1\n0.2\n"),
        ("flow.csv", "t,rate\n0,0\n1,1e-6\n"),
        (
            "droplets.csv",
            "t,x,y,z,vx,vy,vz,diameter\n0.1,0.5,0.5,0.9,0,0,-1,1e-4\n",
        ),
        ("law.toml", "kind = \"monodisperse\"\ndiameter = 0.01\n"),
        ("box.obj", cube.as_str()),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// The scene of all keys with these. Sprays and membranes exclude each other: the former are there where a key of theirs is given.
fn read(folder: &Path, text: &str, overrides: &[String]) -> Result<Scene, SceneErrors> {
    let has_sprays = overrides.iter().any(|key| key.starts_with("sprays"));
    let without = if has_sprays {
        "membranes=[]"
    } else {
        "sprays=[]"
    };
    let mut all = vec![without.to_owned()];
    all.extend_from_slice(overrides);
    parse_scene(&folder.join("keys.toml"), text, &all, Files::MustExist)
}

/// The part of the format (the first key) and the name of each key on a path, as `walls` with `motion` and `velocity`.
fn parts_of(path: &str) -> (String, Vec<String>) {
    let mut names = Vec::new();
    for step in path.split('.') {
        names.push(
            step.split('[')
                .next()
                .unwrap_or_default()
                .trim_matches('"')
                .to_owned(),
        );
    }
    let first = names.remove(0);
    // The names that the user chose.
    if matches!(first.as_str(), "materials" | "clumps") && !names.is_empty() {
        names.remove(0);
    }
    (first, names)
}

fn keys_of(scene: &Scene, keys: &mut BTreeSet<(String, String)>) {
    for path in scene.statement.entries().unwrap().keys() {
        if path.starts_with("content of file") {
            continue;
        }
        let (part, names) = parts_of(path);
        if names.is_empty() {
            keys.insert((String::new(), part));
        } else {
            keys.extend(names.into_iter().map(|name| (part.clone(), name)));
        }
    }
}

/// A line of the page.
struct Line {
    /// First keys of the parts of the format that its section is about; the empty one is the top level.
    parts: Vec<String>,
    /// Words between backticks that may be keys.
    words: Vec<String>,
    /// Of a table, those of the column of keys.
    keys: Vec<String>,
}

/// Words of a text between backticks that may be keys: without values in quotes and brackets.
fn words(cell: &str) -> Vec<String> {
    let mut found = Vec::new();
    for code in cell.split('`').skip(1).step_by(2) {
        let without = |text: &str, open: char, close: char| {
            let mut inside = false;
            let mut kept = String::new();
            for c in text.chars() {
                if !inside && c == open {
                    inside = true;
                } else if inside && c == close {
                    inside = false;
                } else if !inside {
                    kept.push(c);
                }
            }
            kept
        };
        let code = without(&without(&without(code, '"', '"'), '[', ']'), '(', ')');
        let is_part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        // Endings of files are no keys.
        let code = code.replace(".csv", "").replace(".toml", "");
        let all = code.split(|c| !is_part(c)).map(str::to_owned);
        found.extend(all.filter(|word| word.starts_with(|c: char| c.is_ascii_lowercase())));
    }
    found
}

fn page() -> Vec<Line> {
    let text = fs::read_to_string(repository().join("docs/formats/scene.md")).unwrap();
    let mut lines = Vec::new();
    let mut parts: Vec<String> = Vec::new();
    let mut column = None;
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            parts = match heading {
                "Top level" => vec![String::new()],
                _ => heading
                    .split('`')
                    .skip(1)
                    .step_by(2)
                    .map(|code| code.trim_matches(['[', ']']))
                    .map(|code| code.split('.').next().unwrap_or_default().to_owned())
                    .collect(),
            };
        }
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        if !line.starts_with('|') {
            column = None;
        } else if let Some(place) = cells.iter().position(|cell| *cell == "keys") {
            column = Some(place);
        } else if cells[0].starts_with("key") {
            column = Some(0);
        }
        let of_column = column.filter(|_| line.starts_with('|') && !cells[0].starts_with("**"));
        lines.push(Line {
            parts: parts.clone(),
            words: words(line),
            keys: of_column.map_or(Vec::new(), |place| words(cells.get(place).unwrap_or(&""))),
        });
    }
    lines
}

#[test]
fn each_key_of_the_page_runs_or_says_that_it_does_not() {
    let folder = folder();
    let base = all_keys();
    let mut run = BTreeSet::new();
    let mut wrong = Vec::new();
    for setting in std::iter::once("seed=1").chain(ALTERNATIVES.iter().copied()) {
        let scene = read(folder.path(), &base, &settings(setting));
        match scene.and_then(|scene| plan(&scene).map(|_| scene)) {
            Ok(scene) => keys_of(&scene, &mut run),
            Err(errors) => wrong.push(format!("{setting}\n{errors}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // The last state of another run: one that is there.
    run.insert(("particles".to_owned(), started_from_a_run(folder.path())));

    let page = page();
    let mut wrong = Vec::new();
    for line in &page {
        for key in &line.keys {
            let is_in = |part: &String| run.contains(&(part.clone(), key.clone()));
            if !line.parts.iter().any(is_in) {
                wrong.push(format!("{:?}: `{key}` of the page is not run", line.parts));
            }
        }
    }
    let is_described = |part: &String, key: &String| {
        // Regions have the keys of walls, whatever they are for; contacts those of materials.
        let also: &[&str] = match part.as_str() {
            "regions" | "deletions" | "fluxes" => &["insertions", "walls"],
            "insertions" => &["walls"],
            "membranes" => &["insertions", "walls"],
            "contacts" => &["materials"],
            _ => &[],
        };
        let of = |line: &&Line| {
            let is_part = |of: &String| of == part || also.contains(&of.as_str());
            line.parts.iter().any(is_part)
        };
        page.iter().filter(of).any(|line| line.words.contains(key))
    };
    for (part, key) in &run {
        // A section of its own says it.
        let is_section = part.is_empty() && page.iter().any(|line| line.parts.contains(key));
        if !is_section && !is_described(part, key) {
            wrong.push(format!(
                "`{part}`: the page does not know `{key}`, which runs"
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Makes a run, and starts from what it left; the name of the key by which that is done.
fn started_from_a_run(folder: &Path) -> String {
    let scene = "time = { end = 2e-5, step = 1e-5 }\ndomain = { min = [0, 0, 0], max = [1, 1, 1] }\n\
        output = { interval = 1e-5, pictures = false }\n[materials.m]\ndensity = 2500.0\n\
        normal = { law = \"linear\", stiffness = 1e3, restitution = 0.5 }\n";
    let first = format!(
        "{scene}[[particles]]\nmaterial = \"m\"\nradius = 0.1\nposition = [0.5, 0.5, 0.5]\n"
    );
    fs::write(folder.join("first.toml"), first).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_mercury-solve"));
    let output = command
        .current_dir(folder)
        .args(["first.toml", "--quiet"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let scene = read(
        folder,
        &format!("{scene}[[particles]]\nrun = \"first\"\n"),
        &[],
    )
    .unwrap();
    assert_eq!(plan(&scene).unwrap().physics().particles().len(), 1);
    "run".to_owned()
}

/// Keys whose numbers are counts, ratios or exponents. A new key that is none must take units.
const WITHOUT_UNIT: &[&str] = &[
    "seed",
    "axis",
    "normal",
    "dimensions",
    "overlap_error",
    "overlap_warning",
    "overlap",
    "way",
    "friction",
    "static_friction",
    "restitution",
    "keeps",
    "accuracy",
    "imbalance",
    "poisson_ratio",
    "damping",
    "stiffness_factor",
    "stiffness_ratio",
    "penetration_depth",
    "scale",
    "share",
    "shares",
    "number",
    "attempts",
    "cut",
    "sigma",
    "sigma_phi",
    "exponent",
    "grid",
    "cutoff",
    "tolerance",
    "digits",
    "track_every",
    "orientation",
    "sides",
    "periodic",
    "distribution",
    "coefficient",
    "acceleration",
    "step",
    "smoothing",
    "reference_erosion",
    "speed_exponent",
    "diameter_exponent",
    "n1",
    "n2",
    "prestrain",
    "damping_ratio",
    "wide_axis",
    "max_droplets",
    "mirror",
    "track",
    "fields",
    "materials",
    "between",
];

#[test]
fn each_number_with_a_unit_takes_one_in_a_text() {
    let folder = folder();
    let base = all_keys();
    let mut with_units = 0;
    for setting in std::iter::once("seed=1").chain(ALTERNATIVES.iter().copied()) {
        let overrides = settings(setting);
        let stated = |overrides: &[String]| {
            read(folder.path(), &base, overrides).map(|s| s.statement.entries().unwrap())
        };
        let plain = stated(&overrides).unwrap();
        // Only what the setting brings, of the scene itself all.
        let base_entries = if setting == "seed=1" {
            Default::default()
        } else {
            stated(&[]).unwrap()
        };
        let numbers: Vec<(&String, &String)> = plain
            .iter()
            .filter(|(path, value)| {
                value.parse::<f64>().is_ok() && base_entries.get(*path) != Some(value)
            })
            .filter(|(path, _)| !path.starts_with("content of file"))
            .collect();
        if numbers.is_empty() {
            continue;
        }
        // A unit that is none: the answer names units that are possible.
        let mut asked = overrides.clone();
        // Each with a number of its own, by which its answer is found.
        let unlikely = |index: usize| format!("{} parsec", 1000 + index);
        asked.extend(
            (numbers.iter().enumerate())
                .map(|(index, (path, _))| format!("{path}=\"{}\"", unlikely(index))),
        );
        let answer = stated(&asked).unwrap_err();
        let mut units = overrides.clone();
        let mut without = BTreeSet::new();
        for (index, (path, value)) in numbers.into_iter().enumerate() {
            let error =
                (answer.0.iter()).find(|error| error.place.text().contains(&unlikely(index)));
            let help = error
                .and_then(|error| error.help.clone())
                .unwrap_or_default();
            match help
                .split_once(" are ")
                .filter(|_| help.starts_with("units of "))
            {
                Some((_, list)) => {
                    with_units += 1;
                    let unit = list.split(',').next().unwrap();
                    units.push(format!("{path}=\"{value} {unit}\""));
                }
                None => {
                    let (part, names) = parts_of(path);
                    without.insert(names.last().cloned().unwrap_or(part));
                }
            }
        }
        let unknown: Vec<&String> = without
            .iter()
            .filter(|key| !WITHOUT_UNIT.contains(&key.as_str()))
            .collect();
        assert!(
            unknown.is_empty(),
            "{setting}: no unit may stand at {unknown:?}"
        );
        // In degrees a number stays what it is up to round-off; SI units cost nothing.
        assert_eq!(
            stated(&units).unwrap_or_else(|e| panic!("{e}")),
            plain,
            "{setting}"
        );
    }
    assert!(with_units > 200, "{with_units}");
}
