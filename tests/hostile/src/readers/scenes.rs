//! Scenes, up to the plan that `--check` prints, and the files that scenes name.

use std::path::Path;
use std::sync::Arc;

use mercury_common::machine::MachineMemory;
use mercury_common::scene::{Files, Scene, SceneErrors, parse_clump, read_clump, read_psd};
use mercury_engine::step::{Engine, StartOptions};
use mercury_solver::plan::{document, parse_scene, read_scene, refusal, report};
use mercury_solver::run::{check_fit, plan_within};

use super::runs::resealed;
use super::{MB, Reader};
use crate::checks::{said, say};
use crate::mutate::Make::{Binary, Text};
use crate::place::{Place, file, repository};

const WORDS: &[&str] = &[
    "true",
    "false",
    "\"\"",
    "\"auto\"",
    "\"free\"",
    "[]",
    "{}",
    "[0, 0, 0]",
    "\"x\"",
    "[[walls]]",
    "[[particles]]",
    "[domain]",
    "[materials.glass]",
    "[[contacts]]",
    "[output]",
    "\"hertz\"",
    "\"linear\"",
    "\"mindlin\"",
    "\"plastic\"",
    "\"box\"",
    "\"mesh\"",
    "\"glass\"",
    "radius",
    "stiffness",
    "restitution",
    "friction",
    "periodic",
    "min",
    "max",
    "step",
    "end",
    "interval",
    "a.b.c.d.e",
    "1979-05-27T07:32:00Z",
    "0x7fffffffffffffff",
    "1_000",
    "[[insertions]]",
    "psd",
    "lattice",
    "spacing",
    "motion",
    "seed",
    "0b1",
    "-nan",
];

const PLANNED: &str = "the tree of the text and TOML's own: some 300 bytes for a key of 4 (`a=1`), three times while tables \
grow; the particles of \
the scene, 3,000 of which fit into the machine of the tests, with their cells; words of at most a hundred mistakes";

pub(super) const READERS: &[Reader] = &[
    Reader::new("scene", Text(WORDS), scene_samples, scene).bound(8 * MB, 800, PLANNED),
    Reader::new("override", Text(WORDS), override_samples, overridden).bound(8 * MB, 800, PLANNED),
    Reader::new("clump-file", Text(&["name", "density", "mass", "pebbles", "[checks]", "[source]", "rotation", "surface"]), clump_samples, clump)
        .bound(MB, 800, "the tree of the text and TOML's own: some 300 bytes for a key of 4 (`a=1`), three times while tables grow"),
    Reader::new("size-law", Text(&["kind", "\"lognormal\"", "\"classes\"", "\"mixture\"", "parts", "median", "weighting"]), law_samples, law)
        .bound(8 * MB, 800, "the tree of the text and TOML's own; classes of the distribution, bounded by the numbers in the text"),
    Reader::new("size-law-of-files", Text(&["kind", "\"mixture\"", "of", "share", "file", "\"law.toml\"", "\"other.toml\"", "\"twice.toml\"", "\"sizes.csv\"", "weighting"]), files_samples, law)
        .bound(8 * MB, 1600, "as of a law, and the law of each file that one names, of which 1000 are read at most, one after the other"),
    Reader::new("scene-with-particles", Text(&["x", "radius", "material", "vx"]), |place| {
        place.scene();
        vec![file("tests/scenes/good/some.csv"), file("scenes/particles.csv")]
    }, |bytes, place| with(place, "some.csv", bytes))
        .bound(16 * MB, 900, "a particle of the start with its place in the file from 8 bytes (`0,0,0,1`): some 300 bytes, and its place in the cells \
            that look for overlaps, three times while lists grow; words of at most a hundred mistakes"),
    Reader::new("scene-with-mesh", Text(&["v", "f"]), |place| {
        place.scene();
        vec![file("tests/scenes/good/dish.obj"), file("tests/scenes/good/bin.obj")]
    }, |bytes, place| with(place, "dish.obj", bytes))
        .bound(16 * MB, 2000, "a triangle from 8 bytes (`f 1 2 3`): features, edges, planes, boxes of the tree: some 2 kB, three times while lists grow"),
    Reader::new("scene-with-stl", Binary, |place| {
        place.write("dish.obj", b"");
        let text = place.scene().replace("dish.obj", "dish.stl");
        place.write("dish.stl", &file("scenes/plate.stl"));
        place.write("scene.toml", text.as_bytes());
        vec![file("scenes/plate.stl")]
    }, |bytes, place| with(place, "dish.stl", bytes))
        .bound(16 * MB, 1000, "a triangle from 50 bytes: features, edges, planes, boxes of the tree: some 2 kB, three times while lists grow"),
    Reader::new("scene-with-motion", Text(&["t", "x", "angle_x", "angle_y", "angle_z"]), |place| {
        place.scene();
        vec![file("tests/scenes/good/lift.csv"), file("scenes/motion.csv")]
    }, |bytes, place| with(place, "lift.csv", bytes))
        .bound(8 * MB, 64, "a row of 56 bytes from 8, three times while the list grows, and a copy for the plan"),
    Reader::new("scene-with-rate", Text(&["t", "cumulative", "#"]), |place| {
        place.scene();
        vec![file("tests/scenes/good/rate.csv")]
    }, |bytes, place| with(place, "rate.csv", bytes))
        .bound(8 * MB, 64, "a row of 16 bytes from 4, three times while the list grows, and a copy for the plan"),
    Reader::new("scene-with-sizes", Text(&["sieve [mm]", "retained [g]", "diameter [mm]", "cumulative volume [%]", "pan", "in-class:"]), |place| {
        place.scene();
        vec![file("tests/scenes/good/sizes.csv"), file("scenes/grain.psd.csv")]
    }, |bytes, place| with(place, "sizes.csv", bytes))
        .bound(8 * MB, 300, "a row from 4 bytes: shares, edges, sums of powers, some 200 bytes, three times while lists grow"),
    Reader::new("scene-with-clump", Text(&["name", "density", "mass", "pebbles", "rotation"]), |place| {
        place.scene();
        clump_samples(place)
    }, |bytes, place| with(place, "rod.clump.toml", bytes))
        .bound(16 * MB, 2000, "the tree of the clump file, pebbles, and what looks for overlaps of them"),
    Reader::new("scene-from-run", Binary, from_run_samples, from_run)
        .bound(64 * MB, 400, "the file; its values; the particles of the start; the engine that starts with their contacts")
        .own(resealed),
];

fn files_in(folder: &str, is_wanted: impl Fn(&str) -> bool) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(repository().join(folder)).expect("the folder is there");
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| is_wanted(name))
        .collect();
    names.sort();
    names
        .iter()
        .map(|name| file(&format!("{folder}/{name}")))
        .collect()
}

fn is_scene(name: &str) -> bool {
    name.ends_with(".toml") && !name.ends_with(".clump.toml")
}

/// Every scene that is meant to be read, and the table of all keys.
fn scene_samples(_: &Place) -> Vec<Vec<u8>> {
    let mut samples = files_in("scenes", is_scene);
    samples.extend(files_in("tests/scenes/good", is_scene));
    samples.push(JSON.as_bytes().to_vec());
    samples
}

const JSON: &str = r#"{
  "title": "one \"ball\"", "seed": 7, "gravity": [0, 0, -9.81],
  "time": {"end": 0.004, "step": 1e-5},
  "domain": {"min": [0, 0, 0], "max": [0.1, 0.1, 0.1], "periodic": ["x"]},
  "materials": {"ball": {"density": 2500, "normal": {"law": "linear", "stiffness": 1e5, "restitution": 0.8}}},
  "walls": [{"name": "floor", "shape": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "material": "ball"}],
  "particles": [{"name": "first", "material": "ball", "radius": "1 cm", "position": [0.05, 0.05, 0.05]}],
  "output": {"interval": 0.001, "pictures": false, "track": ["first"]}
}
"#;

/// The machine of the tests: the cost of a scene is not bounded by its length, but by this. Beside the program's own 16 MB some
/// 3,000 spheres fit into it.
const MACHINE: MachineMemory = MachineMemory {
    total: 20e6,
    free: 20e6,
};

/// Plans as `mercury-solve --check` does.
fn checked(scene: Result<Scene, SceneErrors>) {
    let scene = match scene {
        Ok(scene) => scene,
        Err(errors) => return refused(&errors),
    };
    match plan_within(&scene, Some(MACHINE)) {
        Err(errors) => refused(&errors),
        Ok((plan, memory)) => {
            let _ = report(&plan, &memory, Some(MACHINE));
            let document = document(&plan, &memory).expect("a plan can be written");
            document.parse::<toml::Table>().expect("a plan is TOML");
            if let Err(error) = check_fit(&scene, &plan, &memory, MACHINE) {
                say(&error);
            }
        }
    }
}

fn refused(errors: &SceneErrors) {
    assert!(!errors.0.is_empty(), "refused without a word");
    say(&refusal(errors));
}

fn scene(bytes: &[u8], place: &Place) {
    // Beside the example scenes are the files that they name; bytes that are no text have to be in a file.
    match std::str::from_utf8(bytes) {
        Ok(text) => {
            let good = repository().join("tests/scenes/good/mutant.toml");
            let shown = repository().join("scenes/mutant.toml");
            let path = if text.contains("grain.psd.csv") || text.contains("plate.stl") {
                shown
            } else {
                good
            };
            checked(parse_scene(&path, text, &[], Files::MustExist));
        }
        Err(_) => {
            let path = place.write("mutant.toml", bytes);
            checked(read_scene(&path, &[]));
        }
    }
}

fn override_samples(place: &Place) -> Vec<Vec<u8>> {
    place.scene();
    [
        "time.end=0.1",
        "materials.glass.friction=0.3",
        "particles.1.radius=0.4",
        "walls.lid.motion=[]",
        "domain.periodic=[\"x\", \"y\"]",
        "walls.box.material=\"glass\"",
        "clumps.rod.file=\"no\"",
        "insertions.rain.rate={ number = 10 }",
        "a.\"b c\".d={e=1}",
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

fn overridden(bytes: &[u8], place: &Place) {
    let text = String::from_utf8_lossy(bytes).into_owned();
    checked(read_scene(&place.path("scene.toml"), &[text]));
}

fn clump_samples(_: &Place) -> Vec<Vec<u8>> {
    let mut samples = files_in("scenes/clumps", |name| name.ends_with(".clump.toml"));
    // Some have hundreds of pebbles.
    samples.retain(|sample| sample.len() < 20_000);
    samples.push(file("tests/scenes/good/rod.clump.toml"));
    samples
}

fn clump(bytes: &[u8], place: &Place) {
    let result = match std::str::from_utf8(bytes) {
        Ok(text) => parse_clump(Path::new("a.clump.toml"), text),
        Err(_) => read_clump(place.write("a.clump.toml", bytes)),
    };
    if let Err(errors) = result {
        refused(&errors);
    }
}

fn law_samples(_: &Place) -> Vec<Vec<u8>> {
    [
        "kind = \"monodisperse\"\ndiameter = 0.006\n",
        "kind = \"uniform\"\nmin_diameter = 3.8e-3\nmax_diameter = 4.2e-3\nweighting = \"number\"\n",
        "kind = \"lognormal\"\nmedian_diameter = 1e-3\nsigma = 0.3\nweighting = \"volume\"\n",
        "kind = \"rosin-rammler\"\ndiameter = 1e-3\nexponent = 3.0\nweighting = \"volume\"\n",
        "kind = \"classes\"\nedges = [1e-3, 2e-3, 3e-3]\nshares = [0.5, 0.5]\nweighting = \"number\"\n",
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

/// Laws that name files whose laws name files, among them the one that is read.
fn files_samples(place: &Place) -> Vec<Vec<u8>> {
    place.write("sizes.csv", &file("tests/scenes/good/sizes.csv"));
    let mixture = |files: &[&str]| {
        let parts = files
            .iter()
            .map(|name| format!("{{ share = 1, file = \"{name}\" }}"));
        let parts = parts.collect::<Vec<_>>().join(", ");
        format!("kind = \"mixture\"\nweighting = \"volume\"\nof = [{parts}]\n").into_bytes()
    };
    place.write("other.toml", &mixture(&["sizes.csv", "law.toml"]));
    place.write("twice.toml", &mixture(&["sizes.csv", "sizes.csv"]));
    place.write("law.toml", b"");
    vec![
        mixture(&["sizes.csv"]),
        mixture(&["law.toml"]),
        mixture(&["other.toml", "twice.toml"]),
        b"file = \"twice.toml\"\n".to_vec(),
    ]
}

fn law(bytes: &[u8], place: &Place) {
    let path = place.write("law.toml", bytes);
    match read_psd(&path) {
        Err(errors) => refused(&errors),
        Ok(law) => {
            if let Some(sizes) = said(mercury_common::sizes::SizeDistribution::from_scene(&law)) {
                for u in [0.0, 0.3, 0.999] {
                    let diameter = sizes.sample_diameter(u);
                    assert!(
                        diameter >= 0.0 && diameter.is_finite(),
                        "drew the diameter {diameter}"
                    );
                }
            }
        }
    }
}

/// The checkpoint of the samples' run, from which another scene starts.
fn from_run_samples(place: &Place) -> Vec<Vec<u8>> {
    let text = place.scene();
    let cut = |name: &str| text.find(name).expect("the scene has it");
    let (before, behind) = (&text[..cut("[[particles]]")], &text[cut("[[regions]]")..]);
    let text = format!("{before}[[particles]]\nrun = \"first\"\n\n{behind}");
    let text = text.replace("track = [\"first\"]\n", "");
    place.write("from-run.toml", text.as_bytes());
    let _ = std::fs::create_dir(place.path("first"));
    vec![place.of_run("scene.0.restart")]
}

/// Up to some steps: the contacts that go on are used in the first list.
fn from_run(bytes: &[u8], place: &Place) {
    place.write("first/scene.0.restart", bytes);
    let scene = match read_scene(&place.path("from-run.toml"), &[]) {
        Ok(scene) => scene,
        Err(errors) => return refused(&errors),
    };
    let plan = match plan_within(&scene, Some(MACHINE)) {
        Ok((plan, _)) => plan,
        Err(errors) => return refused(&errors),
    };
    let Some(mut engine) = said(Engine::start(Arc::new(plan), StartOptions::threads(1))) else {
        return;
    };
    for _ in 0..3 {
        if said(engine.step(None)).is_none() {
            return;
        }
    }
}

/// The scene of the samples, of whose files one is this.
fn with(place: &Place, name: &str, bytes: &[u8]) {
    place.write(name, bytes);
    checked(read_scene(&place.path("scene.toml"), &[]));
}
