//! Tracks: of single particles and clumps, of grains that insertions bring, at an interval of their own and through periodic faces.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::{code, command, errors, folder_with, results, solve};

const SCENE: &str = r#"
[time]
end = 0.5
step = 1e-4

[domain]
min = [0.0, 0.0, 0.0]
max = [0.1, 0.1, 0.1]
periodic = ["x", "y"]

[materials.ball]
density = 2500.0
normal = { law = "linear", stiffness = 1e3, restitution = 0.8 }

[clumps.rod]
file = "rod.clump.toml"
material = "ball"

[[particles]]
name = "first"
material = "ball"
radius = 0.002
position = [0.05, 0.01, 0.02]
velocity = [1.0, -0.5, 0.0]

[[particles]]
name = "rod"
clump = "rod"
position = [0.05, 0.05, 0.04]
velocity = [0.0, -0.4, 0.0]
angular_velocity = [0.0, 0.0, 20.0]

[[insertions]]
name = "rain"
region = { shape = "box", min = [0.02, 0.02, 0.06], max = [0.08, 0.08, 0.08] }
material = "ball"
psd = { kind = "monodisperse", diameter = 0.002 }
velocity = { mean = [0.0, 0.3, 0.0] }
rate = { number = 40.0 }
total = { number = 10 }

[output]
interval = 0.1
track = ["rain", "rod", "first"]
track_interval = "2 ms"
track_every = 3
pictures = false
"#;

const ROD: &str = include_str!("../../../tests/scenes/good/rod.clump.toml");

fn folder(scene: &str) -> tempfile::TempDir {
    let folder = folder_with("fly.toml", scene);
    fs::write(folder.path().join("rod.clump.toml"), ROD).unwrap();
    folder
}

/// Of each name and id: time and the other numbers of each row.
fn tracks(path: &Path) -> BTreeMap<(String, u32), Vec<Vec<f64>>> {
    let mut all: BTreeMap<(String, u32), Vec<Vec<f64>>> = BTreeMap::new();
    for line in fs::read_to_string(path).unwrap().lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers = [&cells[..1], &cells[3..]].concat();
        let numbers = numbers.iter().map(|cell| cell.parse().unwrap()).collect();
        let key = (cells[1].to_owned(), cells[2].parse().unwrap());
        all.entry(key).or_default().push(numbers);
    }
    all
}

/// Nothing touches, so that all fly straight: x = x0 + v (t - t0), through the faces, too.
#[test]
fn tracks_go_straight_through_periodic_faces() {
    let folder = folder(SCENE);
    let output = solve(folder.path(), &["fly.toml"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let all = tracks(&folder.path().join("fly/fly.track.csv"));
    let names: Vec<&str> = all.keys().map(|(name, _)| name.as_str()).collect();
    // Ten grains have come, of which numbers 0, 3, 6 and 9 are followed.
    assert_eq!(names, ["first", "rain", "rain", "rain", "rain", "rod"]);
    for ((name, id), rows) in &all {
        let velocity = match name.as_str() {
            "first" => [1.0, -0.5, 0.0],
            "rod" => [0.0, -0.4, 0.0],
            _ => [0.0, 0.3, 0.0],
        };
        if name != "rain" {
            // 0.5 s in pieces of 2 ms, and the start.
            assert_eq!(rows.len(), 251, "{name}");
        }
        let first = &rows[0];
        for (k, row) in rows.iter().enumerate() {
            let since = row[0] - first[0];
            assert!(
                (since - 2e-3 * k as f64).abs() < 1e-9,
                "{name} {id}: {row:?}"
            );
            for axis in 0..3 {
                let expected = first[1 + axis] + velocity[axis] * since;
                // Sums of 5000 steps, each rounded to half an ulp of 0.5.
                let off = (row[1 + axis] - expected).abs();
                assert!(off < 5000.0 * 1.2e-16, "{name} {id}: {row:?}, {expected}");
            }
        }
    }
    let start = [("first", 0.05), ("rod", 0.05)];
    for (name, x) in start {
        let rows = all.iter().find(|((known, _), _)| known == name).unwrap().1;
        assert_eq!(rows[0][1], x);
    }
    // Five periods on.
    let last = all.values().next().unwrap().last().unwrap();
    assert!((last[1] - 0.55).abs() < 1e-12, "{last:?}");
}

#[test]
fn tracks_are_the_same_bytes_when_a_run_is_interrupted_and_take_no_part_in_it() {
    let folder = folder(&SCENE.replace("end = 0.5", "end = 0.3"));
    let place = folder.path();
    let run = |arguments: &[&str]| {
        let output = command(place, arguments).output().unwrap();
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
    };
    run(&["fly.toml", "--output", "whole"]);
    run(&["fly.toml", "--output", "parts", "--set", "time.end=0.1"]);
    run(&["fly.toml", "--output", "parts", "--resume"]);
    let [mut whole, parts] = ["whole", "parts"].map(|name| results(&place.join(name), "fly"));
    assert!(whole["fly.track.csv"] == parts["fly.track.csv"]);
    // Without tracks all other files are the same.
    run(&[
        "fly.toml",
        "--output",
        "without",
        "--set",
        "output.track=[]",
    ]);
    let mut without = results(&place.join("without"), "fly");
    for all in [&mut whole, &mut without] {
        all.remove("fly.track.csv");
        all.remove("checkpoint");
        // It has sums of the state, where tracks have columns, and of all files.
        all.remove("fly.chain.jsonl");
    }
    assert!(whole == without);
}

#[test]
fn slips_are_named() {
    let folder = folder(SCENE);
    for (set, message) in [
        (
            "output.track=[\"rian\"]",
            "there is no particle or insertion named \"rian\"\nhelp: did you mean `rain`?",
        ),
        ("output.track_every=0", "output.track_every: must be >= 1"),
        (
            "output.track_interval=-1",
            "output.track_interval: must be > 0",
        ),
        (
            "insertions.rain.name=rod",
            "an entry of [[particles]] and one of [[insertions]] have this name",
        ),
    ] {
        let output = solve(folder.path(), &["fly.toml", "--check", "--set", set]);
        assert_eq!(code(&output), Some(2), "{set}");
        assert!(errors(&output).contains(message), "{}", errors(&output));
    }
}
