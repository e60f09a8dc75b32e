//! Grains that leave or cross a plane, one by one: `.left.csv`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mercury_common::formats::table_head;

use crate::common::{code, command, errors, folder_with, results, solve};

/// Nothing touches: grains that fly straight cross planes and leave at the places and times of a line. Gravity is off.
const SCENE: &str = r#"
time = { end = 0.2, step = 1e-3 }
output = { interval = 0.05, left = true, pictures = false }
[domain]
min = [0.0, 0.0, 0.0]
max = [0.2, 0.2, 0.2]
periodic = ["y"]
[materials.coarse]
density = 2500.0
normal = { law = "linear", stiffness = 1.0, restitution = 0.8 }
[materials.fine]
density = 2000.0
normal = { law = "linear", stiffness = 1.0, restitution = 0.8 }
[clumps.rod]
file = "rod.clump.toml"
material = "coarse"
# Through the deck where it is, through the face below.
[[particles]]
material = "fine"
radius = 0.0025
position = [0.0501, 0.05, 0.1005]
velocity = [0.0, 0.0, -1.0]
# Beside the rectangle.
[[particles]]
material = "coarse"
radius = 0.004
position = [0.1001, 0.05, 0.1005]
velocity = [0.0, 0.0, -1.0]
# Up through it, where it holds in the next period.
[[particles]]
material = "coarse"
radius = 0.003
position = [0.0501, 0.1905, 0.0505]
velocity = [0.0, 0.5, 1.0]
# Into the chute.
[[particles]]
clump = "rod"
position = [0.1305, 0.1, 0.15]
velocity = [1.0, 0.0, 0.0]
[[deletions]]
name = "chute"
region = { shape = "half-space", point = [0.15, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }
[[fluxes]]
name = "deck"
plane = { point = [0.05, 0.05, 0.08], normal = [0.0, 0.0, -1.0], rectangle = { along = [0.06, 0.0, 0.0], across = [0.0, 0.1, 0.0] } }
"#;

const ROD: &str = include_str!("../../../tests/scenes/good/rod.clump.toml");

fn folder(scene: &str) -> tempfile::TempDir {
    let folder = folder_with("screen.toml", scene);
    fs::write(folder.path().join("rod.clump.toml"), ROD).unwrap();
    folder
}

fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = (lines.next().unwrap().split(','))
        .map(table_head::name)
        .collect();
    let row = |line: &str| {
        let cells = line.split(',').map(str::to_owned);
        (head.iter().map(|name| (*name).to_owned()))
            .zip(cells)
            .collect()
    };
    lines.map(row).collect()
}

#[test]
fn each_grain_that_leaves_or_crosses_a_plane_has_a_row() {
    let folder = folder(SCENE);
    let output = solve(folder.path(), &["screen.toml", "--quiet"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let rows = rows(&folder.path().join("screen/screen.left.csv"));
    let text = |k: usize, column: &str| rows[k][column].as_str();
    let found: Vec<[&str; 6]> = (0..rows.len())
        .map(|k| {
            ["at", "name", "direction", "id", "clump", "material"].map(|column| text(k, column))
        })
        .collect();
    let expected = [
        ["region", "chute", "1", "3", "rod", "coarse"],
        ["plane", "deck", "1", "0", "", "fine"],
        ["plane", "deck", "-1", "2", "", "coarse"],
        ["face", "-z", "1", "0", "", "fine"],
        ["face", "-z", "1", "1", "", "coarse"],
        ["face", "+z", "1", "2", "", "coarse"],
    ];
    assert_eq!(found, expected);
    // The end of the step in which each passes, and the place there: 1 m/s over distances of whole steps and a half.
    // Three spheres of 10 mm.
    let rod = 0.01 * 3f64.cbrt();
    let passes = [
        (0.020, rod, [0.1505, 0.1, 0.15], [1.0, 0.0, 0.0]),
        (0.021, 0.005, [0.0501, 0.05, 0.0795], [0.0, 0.0, -1.0]),
        (0.030, 0.006, [0.0501, 0.0055, 0.0805], [0.0, 0.5, 1.0]),
        (0.101, 0.005, [0.0501, 0.05, -0.0005], [0.0, 0.0, -1.0]),
        (0.101, 0.008, [0.1001, 0.05, -0.0005], [0.0, 0.0, -1.0]),
        (0.150, 0.006, [0.0501, 0.0655, 0.2005], [0.0, 0.5, 1.0]),
    ];
    for (row, (time, diameter, place, velocity)) in rows.iter().zip(passes) {
        let number = |column: &str| -> f64 { row[column].parse().unwrap() };
        let close = |column: &str, expected: f64| {
            // 200 steps, each rounded to half an ulp of 0.2, and pebbles of a rod placed about its centre.
            let off = (number(column) - expected).abs();
            assert!(off < 1e-14, "{column}: {} {expected}", number(column));
        };
        close("time", time);
        assert!((number("diameter") / diameter - 1.0).abs() < 1e-12);
        for (axis, column) in ["x", "y", "z"].into_iter().enumerate() {
            close(column, place[axis]);
            close(&format!("v{column}"), velocity[axis]);
        }
    }
}

#[test]
fn rows_are_the_same_bytes_when_a_run_is_interrupted_and_on_two_threads() {
    let folder = folder(SCENE);
    let place = folder.path();
    let run = |arguments: &[&str], expected: i32| {
        let output = command(place, arguments).output().unwrap();
        assert_eq!(code(&output), Some(expected), "{}", errors(&output));
    };
    run(&["screen.toml", "--output", "whole", "--threads", "2"], 0);
    // A checkpoint at 0.025 s, between two frames, with passages that no frame has taken yet.
    let short = ["--set", "time.end=0.025"];
    let parts = ["screen.toml", "--output", "parts", "--threads", "1"];
    run(&[&parts[..], &short].concat(), 0);
    run(&[&parts[..], &["--resume"]].concat(), 0);
    let [whole, parts] = ["whole", "parts"].map(|name| results(&place.join(name), "screen"));
    assert_eq!(whole["screen.left.csv"], parts["screen.left.csv"]);
}

#[test]
fn rectangles_of_planes_that_are_none_are_refused() {
    for (from, to, message) in [
        (
            "along = [0.06, 0.0, 0.0], across = [0.0, 0.1, 0.0]",
            "along = [0.06, 0.0, 0.0]",
            "rectangle.across: is missing",
        ),
        (
            "rectangle = {",
            "radius = 0.1, rectangle = {",
            "a plane has a disc or a rectangle, not both",
        ),
        (
            "along = [0.06, 0.0, 0.0]",
            "along = [0.06, 0.0, 0.01]",
            "must be at right angles to `normal`",
        ),
        (
            "along = [0.06, 0.0, 0.0]",
            "along = [0.06, 0.01, 0.0]",
            "must be at right angles to `along`",
        ),
        (
            "along = [0.06, 0.0, 0.0]",
            "along = [0.0, 0.0, 0.0]",
            "must not be of length 0",
        ),
        (
            "point = [0.05, 0.05, 0.08]",
            "point = [-0.05, 0.05, 0.08]",
            "does not pass through the domain",
        ),
    ] {
        assert!(SCENE.contains(from));
        let folder = folder(&SCENE.replace(from, to));
        let output = solve(folder.path(), &["screen.toml", "--check"]);
        assert_eq!(code(&output), Some(2), "{to}");
        assert!(
            errors(&output).contains(message),
            "{to}: {}",
            errors(&output)
        );
    }
}
