//! `--set KEY=VALUE`.

use std::path::Path;

use super::bad::completed;
use crate::scene::*;

const SCENE: &str = r#"
[materials.sand]
density = 2600.0
normal = { law = "hertz", youngs_modulus = 1e7, poisson_ratio = 0.2, restitution = 0.5 }
tangential = { law = "mindlin", friction = 0.5 }

[[insertions]]
name = "rain"
region = { shape = "sphere", origin = [0, 0, 0], radius = 1 }
material = "sand"
psd = { kind = "monodisperse", diameter = 1e-3 }
total = { number = 2000 }

[[regions]]
name = "upper half"
region = { shape = "sphere", origin = [0, 0, 0], radius = 1 }
"#;

fn with(overrides: &[&str]) -> Result<Scene, SceneErrors> {
    let overrides: Vec<String> = overrides.iter().map(|&s| s.to_owned()).collect();
    parse_scene(
        Path::new("set.toml"),
        &completed(SCENE),
        &overrides,
        Files::Unchecked,
    )
}

fn good(overrides: &[&str]) -> Scene {
    with(overrides).unwrap_or_else(|errors| panic!("{errors}"))
}

fn total(scene: &Scene) -> Target {
    scene.insertions[0]
        .total
        .as_ref()
        .expect("a total")
        .value
        .clone()
}

#[test]
fn keys_are_replaced_and_added() {
    assert_eq!(*good(&["time.end=0.25"]).time.end, 0.25);
    assert_eq!(*good(&[" time . end = 0.25 "]).time.end, 0.25);
    assert_eq!(*good(&["time.end=0.25", "time.end=0.5"]).time.end, 0.5);
    assert_eq!(good(&["seed=7"]).seed, 7);
    assert_eq!(good(&["title=hello world"]).title, "hello world");
    assert_eq!(good(&["title=\"a = b\""]).title, "a = b");
    let scene = good(&["materials.sand.tangential.friction=0.3"]);
    let laws = scene.materials.iter().filter_map(|m| m.tangential.as_ref());
    let friction = laws.filter_map(|law| law.values.get("friction")).next();
    let friction = friction.expect("mindlin");
    assert_eq!(friction.value, Given::Number(0.3));
    assert_eq!(friction.place.source_name(), "--set");
    assert_eq!(friction.place.text(), "0.3");
    assert_eq!(
        good(&["contact.tangential_history=incremental"])
            .contact
            .tangential_history,
        TangentialHistory::Incremental
    );
    assert_eq!(*good(&["materials.steel={density=7800.0, normal={law=\"linear\", stiffness=1.0, restitution=0.5}}"])
        .materials[2].density, 7800.0);
    assert!(good(&["insertions=[]"]).insertions.is_empty());
}

#[test]
fn entries_of_lists_go_by_index_and_by_name() {
    assert_eq!(
        total(&good(&["insertions[0].total.number=10"])),
        Target::Of(Total::Number(10))
    );
    assert_eq!(
        total(&good(&["insertions.rain.total.number=10"])),
        Target::Of(Total::Number(10))
    );
    assert_eq!(
        total(&good(&["insertions.rain.total={ mass = 0.5 }"])),
        Target::Of(Total::Mass(0.5))
    );
    assert_eq!(
        *good(&["domain.max[2]=2.5"]).domain.max,
        glam::DVec3::new(1.0, 1.0, 2.5)
    );
    let scene = good(&["regions.\"upper half\".region.radius=3"]);
    let Region::Sphere { radius, .. } = &scene.regions[0].region.value else {
        panic!("sphere")
    };
    assert_eq!(**radius, 3.0);
}

#[test]
fn wrong_overrides_are_named() {
    let cases = [
        (
            "time.end",
            "--set time.end: there is no `=` in it\nhelp: write it as KEY=VALUE, for example time.end=0.1",
        ),
        (
            "=1",
            "--set =1: a key is missing before the `=`\nhelp: write it as KEY=VALUE, for example time.end=0.1",
        ),
        ("time.end=", "--set time.end=: a value is missing here"),
        (
            "time.end=-1",
            "--set time.end=-1: time.end: must be > 0, got -1",
        ),
        (
            "time.end=soon",
            "--set time.end=soon: time.end: expected a number, got a string",
        ),
        (
            "time.ende=1",
            "--set time.ende=1: time.ende: is not a known key\nhelp: did you mean `end`?",
        ),
        (
            "tme.end=1",
            "--set tme.end=1: tme: is not a known key\nhelp: did you mean `time`?",
        ),
        (
            "time.end.x=1",
            "--set time.end.x=1: time.end: is a number, there are no keys below it",
        ),
        (
            "time[0]=1",
            "--set time[0]=1: time: is a table, it has no item [0]",
        ),
        (
            "insertions[1].attempts=2",
            "--set insertions[1].attempts=2: insertions: there is no item [1]: the list has 1, counted from 0",
        ),
        (
            "insertions.rian.attempts=2",
            "--set insertions.rian.attempts=2: insertions.rian: there is nothing named `rian`\nhelp: did you mean `rain`?",
        ),
        (
            "insertions.feed.attempts=2",
            "--set insertions.feed.attempts=2: insertions.feed: there is nothing named `feed`\nhelp: there are: rain",
        ),
        (
            "materials.snad.density=1",
            "--set materials.snad.density=1: materials.snad: there is nothing named `snad`\nhelp: did you mean `sand`?",
        ),
        (
            "gravity=[0, 0",
            "--set gravity=[0, 0: not valid TOML: unclosed array, expected `]`",
        ),
        (
            "insertions.rain.total.mass=1",
            "--set insertions.rain.total.mass=1: insertions.rain.total.mass: cannot be given together with `number`: choose one",
        ),
    ];
    for (argument, expected) in cases {
        let errors = with(&[argument]).expect_err(argument);
        assert_eq!(errors.to_string(), expected, "{argument}");
    }
}

#[test]
fn all_wrong_overrides_are_reported() {
    let errors = with(&["time.end=-1", "time.step=-1", "nothing"]).expect_err("three mistakes");
    assert_eq!(errors.0.len(), 3, "{errors}");
}

#[test]
fn entries_without_a_name_go_by_their_number() {
    let list = "[[particles]]\nmaterial = \"glass\"\nradius = 0.1\nposition = [0.2, 0.5, 0.5]\n\
        [[particles]]\nmaterial = \"glass\"\nradius = 0.1\nposition = [0.7, 0.5, 0.5]\n";
    let with = |argument: &str, text: &str| {
        let overrides = [argument.to_owned()];
        parse_scene(
            Path::new("set.toml"),
            &completed(text),
            &overrides,
            Files::Unchecked,
        )
    };
    let radii = |argument: &str, text: &str| -> Vec<f64> {
        let scene = with(argument, text).unwrap_or_else(|errors| panic!("{errors}"));
        let radius = |particles: &Particles| match &particles.source {
            ParticleSource::One { particle, .. } => *particle.radius,
            other => panic!("{other:?}"),
        };
        scene.particles.iter().map(radius).collect()
    };
    assert_eq!(radii("particles.1.radius=0.4", list), [0.1, 0.4]);
    assert_eq!(radii("particles[1].radius=0.4", list), [0.1, 0.4]);
    // A name wins over a number.
    let named = list.replacen("[[particles]]\n", "[[particles]]\nname = \"1\"\n", 1);
    assert_eq!(radii("particles.1.radius=0.4", &named), [0.4, 0.1]);
    for (argument, expected) in [
        (
            "particles.2.radius=0.4",
            "--set particles.2.radius=0.4: particles: there is no item [2]: the list has 2, counted from 0",
        ),
        (
            "particles.left.radius=0.4",
            "--set particles.left.radius=0.4: particles.left: there is nothing named `left`\n\
             help: its entries have no names: write particles[0] (or particles.0) for the first of 2",
        ),
    ] {
        assert_eq!(with(argument, list).unwrap_err().to_string(), expected);
    }
}

#[test]
fn materials_go_by_their_number_too() {
    let scene = with(&["materials.0.density=1234.0"]).expect("the first material");
    assert_eq!(*scene.materials[0].density, 1234.0);
    let scene = with(&["materials[0].density=1234.0"]).expect("the first material");
    assert_eq!(*scene.materials[0].density, 1234.0);
    let errors = with(&["materials.7.density=1"]).expect_err("there is no eighth");
    assert!(
        errors.to_string().contains("there is nothing named `7`"),
        "{errors}"
    );
}

/// `1e9` is a float in TOML, and a whole number to most users.
#[test]
fn whole_numbers_may_be_written_as_floats() {
    assert_eq!(good(&["seed=1e9"]).seed, 1_000_000_000);
    assert_eq!(good(&["seed=20.0"]).seed, 20);
    for slip in [
        "seed=1.5",
        "seed=1e-3",
        "seed=1e300",
        "seed=-1e3",
        "seed=inf",
        "seed=nan",
    ] {
        assert!(with(&[slip]).is_err(), "{slip}");
    }
}

#[test]
fn a_clump_file_is_no_scene() {
    let text = "name = \"ball\"\ndensity = 1000\nmass = 1\nvolume = 1e-3\n\
        principal_moments = [1, 1, 1]\npebbles = [{ position = [0, 0, 0], radius = 1 }]\n";
    let errors = parse_scene(Path::new("celt.clump.toml"), text, &[], Files::Unchecked);
    assert_eq!(
        errors.unwrap_err().to_string(),
        "celt.clump.toml: this is a clump file, not a scene\n\
         help: a scene names it in [clumps.NAME] with file and material, and puts bodies of it with [[particles]] clump = \"NAME\""
    );
}

#[test]
fn what_nine_of_ten_want_may_be_left_out() {
    let text = r#"
time = { end = 1.0 }
domain = { min = [0, 0, 0], max = [1, 1, 1] }
output = { interval = 0.1 }
materials.sand = { density = 2600.0, normal = { law = "linear", stiffness = 100, restitution = 0.5 } }
[[walls]]
shape = "box"
material = "sand"
[[walls]]
name = "lid"
shape = "plane"
point = [0, 0, 1]
normal = [0, 0, -1]
material = "sand"
[[insertions]]
region = { shape = "sphere", origin = [0, 0, 0], radius = 1 }
material = "sand"
psd = { kind = "monodisperse", diameter = 1e-3 }
total = { number = 2000 }
[[deletions]]
region = { shape = "sphere", origin = [0, 0, 0], radius = 1 }
[[fluxes]]
plane = { point = [0, 0, 0], normal = [0, 0, 1] }
[[bonds]]
law = "beam"
youngs_modulus = 1e6
"#;
    let parse =
        |overrides: &[String]| parse_scene(Path::new("a.toml"), text, overrides, Files::Unchecked);
    let scene = parse(&[]).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(*scene.time.step, TimeStep::Auto);
    let names: Vec<&str> = scene
        .walls
        .iter()
        .map(|wall| wall.name.value.as_str())
        .collect();
    assert_eq!(names, ["wall-1", "lid"]);
    assert_eq!(*scene.insertions[0].name, "insertion-1");
    assert_eq!(*scene.deletions[0].name, "deletion-1");
    assert_eq!(*scene.fluxes[0].name, "flux-1");
    assert_eq!(*scene.bonds[0].name, "bond-1");
    // By its number it can be set.
    let scene = parse(&["insertions.0.total.number=7".to_owned()])
        .unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(total(&scene), Target::Of(Total::Number(7)));
}

#[test]
fn a_strict_start_leaves_the_guard_its_room() {
    // docs/formats/scene.md: 0.5, or `contact.overlap_error` if that is more; a given value counts as it is.
    let overlap = |overrides: &[&str]| *good(overrides).guard.overlap;
    for (said, limit) in [(0.02, 0.5), (0.5, 0.5), (0.8, 0.8)] {
        let start = format!("contact.overlap_error={said}");
        assert_eq!(overlap(&[&start]), limit, "{start}");
        assert_eq!(overlap(&[&start, "guard.policy=warn"]), limit, "{start}");
        assert_eq!(overlap(&[&start, "guard.overlap=0.3"]), 0.3, "{start}");
    }
    assert_eq!(overlap(&[]), 0.5);
}
