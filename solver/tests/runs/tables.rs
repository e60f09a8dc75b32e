//! Small tables of a run: what stands in them is that of the scene. A test of another output goes here.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use mercury_common::formats::table_head;

/// A lid that comes down at 0.1 m/s from 0.02 m on, and a disc that turns at 2 rad/s about a point beside its middle and travels.
const SCENE: &str = r#"
time = { end = 0.1, step = 1e-4 }
domain = { min = [-1, -1, 0], max = [1, 1, 1] }
materials.m = { density = 2500.0, normal = { law = "linear", stiffness = 100, restitution = 0.5 } }
output = { interval = 0.05, pictures = false }
[[walls]]
name = "lid"
shape = "plane"
point = [0, 0, 0.5]
normal = [0, 0, -1]
material = "m"
motion = [{ kind = "translation", velocity = [0, 0, -0.1], from = 0.05 }]
[[walls]]
name = "disc"
shape = "disc"
origin = [0.3, 0, 0.2]
axis = [0, 0, 1]
radius = 0.1
material = "m"
motion = [
  { kind = "rotation", axis = [0, 0, 1], origin = [0.1, 0, 0.2], angular_velocity = 2 },
  { kind = "translation", velocity = [0, 0.5, 0] },
]
[[particles]]
name = "ball"
material = "m"
radius = 0.01
position = [0, 0, 0.1]
"#;

#[test]
fn place_and_motion_of_walls_are_those_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), SCENE).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder.path())
        .args(["a.toml", "--quiet"])
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = fs::read_to_string(folder.path().join("a/a.walls.csv")).unwrap();
    let head = text.lines().next().unwrap().split(',');
    let head: Vec<&str> = head.map(table_head::name).collect();
    let rows = text
        .lines()
        .skip(1)
        .map(|line| head.iter().copied().zip(line.split(',')));
    let rows: Vec<BTreeMap<&str, &str>> = rows.map(Iterator::collect).collect();
    assert_eq!(rows.len(), 6);
    let check = |row: &BTreeMap<&str, &str>, what: &[(&str, f64)]| {
        for (column, expected) in what {
            let found: f64 = row[column].parse().unwrap();
            // Sums and products of a few numbers of order 1.
            assert!(
                (found - expected).abs() < 1e-14,
                "{column}: {found} {expected}"
            );
        }
    };
    let (lid, disc) = (&rows[4], &rows[5]);
    assert_eq!((lid["name"], disc["name"]), ("lid", "disc"));
    let still = [
        ("qw", 1.0),
        ("qx", 0.0),
        ("qy", 0.0),
        ("qz", 0.0),
        ("wz", 0.0),
    ];
    check(lid, &still);
    check(
        lid,
        &[
            ("x", 0.0),
            ("z", 0.495),
            ("vz", -0.1),
            ("vx", 0.0),
            ("fz", 0.0),
        ],
    );
    check(&rows[2], &[("z", 0.5), ("vz", -0.1)]);
    // The point about which it turns travels with it; 0.1 s at 2 rad/s.
    let half = 0.1f64;
    check(
        disc,
        &[
            ("x", 0.1),
            ("y", 0.05),
            ("z", 0.2),
            ("vx", 0.0),
            ("vy", 0.5),
            ("wz", 2.0),
        ],
    );
    check(disc, &[("qw", half.cos()), ("qz", half.sin()), ("qx", 0.0)]);
}

/// The slider of `wear-plate.toml` after 0.1 s: the legend is that of the depth, and the worn triangles are drawn opaque under the slider.
#[test]
fn the_final_picture_of_a_scene_that_wears_shows_depth() {
    let folder = tempfile::tempdir().unwrap();
    let scene = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../scenes/wear/wear-plate.toml"
    );
    let output = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder.path())
        .args([scene, "--quiet", "--set", "time.end=0.1"])
        .args(["--set", "time.step=5e-5"])
        .output()
        .unwrap();
    assert!(output.status.success());
    let text = fs::read_to_string(folder.path().join("wear-plate/wear-plate.final.svg")).unwrap();
    assert!(text.contains(">depth (") && !text.contains(">speed ("));
}
