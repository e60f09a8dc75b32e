//! A program in C that is compiled against the header and the library.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A lid above a box with grains.
pub const SCENE: &str = r#"
gravity = [0, 0, -9.81]
[time]
end = 1.0
[domain]
min = [0, 0, 0]
max = [0.02, 0.02, 0.03]
[materials.glass]
density = 2500.0
normal = { law = "linear", stiffness = 200.0, restitution = 0.6 }
tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.3 }
[[walls]]
name = "floor"
shape = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
material = "glass"
[[walls]]
name = "sides"
shape = "box"
sides = ["-x", "+x", "-y", "+y"]
material = "glass"
[[walls]]
name = "lid"
shape = "disc"
origin = [0.01, 0.01, 0.0095]
axis = [0, 0, -1]
radius = 0.02
material = "glass"
motion = "external"
[[insertions]]
name = "fill"
region = { shape = "box", min = [0.001, 0.001, 0.001], max = [0.019, 0.019, 0.009] }
material = "glass"
psd = { kind = "uniform", min_diameter = 1.8e-3, max_diameter = 2.2e-3, weighting = "number" }
total = { number = 250 }
[output]
interval = 0.004
fstat = true
"#;

/// The folder with the library that this test was built with.
fn library() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let deps = test.parent().unwrap();
    let folders = [deps, deps.parent().unwrap()];
    let holds = |folder: &&&Path| folder.join("libmercury.so").exists();
    folders
        .iter()
        .find(holds)
        .expect("libmercury.so")
        .to_path_buf()
}

fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let left_out = [
        "run.log",
        "summary.json",
        ".png",
        ".svg",
        ".lock",
        "plan.toml",
    ];
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap());
    let names = entries.map(|entry| entry.file_name().into_string().unwrap());
    let names = names.filter(|name| !left_out.iter().any(|end| name.ends_with(end)));
    names
        .map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap()))
        .collect()
}

#[test]
fn a_program_in_c_drives_a_lid_and_goes_back() {
    if Command::new("cc").arg("--version").output().is_err() {
        println!("not tested: there is no C compiler");
        return;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = folder.join("press.toml");
    std::fs::write(&scene, SCENE).unwrap();
    let (program, library) = (folder.join("lid"), library());
    let compiled = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I"])
        .arg(here)
        .arg(here.join("tests/programs/lid.c"))
        .arg("-o")
        .arg(&program)
        .arg("-L")
        .arg(&library)
        .args(["-lmercury", "-lm"])
        .arg(format!("-Wl,-rpath,{}", library.display()))
        .status();
    assert!(compiled.unwrap().success());
    let [a, b] = ["there-and-back", "straight"].map(|name| folder.join(name));
    let ran = Command::new(&program)
        .args([&scene, &a, &b])
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
    println!("{}", String::from_utf8_lossy(&ran.stdout));
    // Also the files know nothing of the ways that were thrown away.
    let (a, b) = (contents(&a), contents(&b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    assert!(a.len() >= 4);
    for (name, bytes) in &a {
        assert!(*bytes == b[name], "{name} differs");
    }
}
