//! Sizes of a run's files by the plan, against the files.

use std::fs;
use std::path::Path;
use std::process::Command;

/// 6 x 6 x 6 spheres that overlap a little with their neighbours.
const SCENE: &str = r#"
time = { end = 2e-3, step = 2e-5 }
domain = { min = [0, 0, 0], max = [0.1, 0.1, 0.1] }
materials.m = { density = 2500.0, normal = { law = "linear", stiffness = 1000, restitution = 0.8 }, tangential = { law = "linear", stiffness_ratio = 0.3, friction = 0.5 } }
output = { interval = 2e-4, fstat = true, vtk = true, pictures = false }
[[particles]]
name = "packing"
material = "m"
radius = 5.001e-3
lattice = { min = [0.01, 0.01, 0.01], max = [0.06, 0.06, 0.06], spacing = 0.01, jitter = 1e-6 }
"#;

fn solve(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder)
        .arg("a.toml")
        .args(arguments)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    String::from_utf8(output.stdout).unwrap()
}

fn size(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let sizes = entries.map(|entry| {
        let (path, name) = (entry.path(), entry.file_name());
        match name.to_string_lossy() {
            _ if path.is_dir() => size(&path),
            name if name.ends_with(".restart") => 0,
            _ => entry.metadata().unwrap().len(),
        }
    });
    sizes.sum()
}

/// The estimate is "about": numbers in text take 2 to 24 characters, so it is held to a factor of 1.5.
#[test]
fn the_plan_states_how_many_frames_come_and_what_they_take() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), SCENE).unwrap();
    let plan: serde_json::Value =
        serde_json::from_str(&solve(folder.path(), &["--check", "--json"])).unwrap();
    let disk = &plan["disk"];
    assert_eq!(disk["frames"], 11.0);
    assert_eq!(disk["contact_frames"], 11.0);
    assert_eq!(disk["vtk_frames"], 11.0);
    solve(folder.path(), &["--quiet"]);
    let found = size(&folder.path().join("a")) as f64;
    let reported = disk["bytes"].as_f64().unwrap();
    assert!(
        (found / 1.5..found * 1.5).contains(&reported),
        "{reported} announced, {found} found"
    );

    let text = solve(folder.path(), &["--check", "--output", "b"]);
    assert!(text.contains("11, every 0.0002 s"), "{text}");
    assert!(!text.contains("output: "), "{text}");
    // A hundred thousand frames are announced before they are written.
    let many = ["--check", "--set", "time.end=20"];
    let text = solve(folder.path(), &many);
    let warning = text
        .lines()
        .find(|line| line.contains("output: 100001 frames"));
    assert!(
        warning.is_some_and(|line| line.contains("GB on the disk")),
        "{text}"
    );
}
