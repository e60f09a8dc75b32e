//! The command line as a user meets it: exit codes, messages, files.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{cuboid, shared, turned_round};
use glam::DVec3;
use mercury_common::formats::clump::{Remark, read_clump};
use mercury_common::formats::mesh::{TriangleMesh, push_binary_stl, push_obj, read_mesh};
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::pebble_list::read_pebble_list;

const ROD: &str = "x,y,z,r\n0,-1,0,0.5\n0,0,0,0.5\n0,1,0,0.5\n";

/// Runs without pictures, which take a while.
fn mclump(folder: &Path, arguments: &[&str]) -> Output {
    let quick: &[&str] = if arguments.is_empty() {
        &[]
    } else {
        &["--no-picture"]
    };
    run(folder, &[arguments, quick].concat())
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mclump"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = mclump(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    said(&output)
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = mclump(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).is_empty());
    errors(&output)
}

fn with_rod() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rod.csv"), ROD).unwrap();
    folder
}

fn write_stl(path: &Path, mesh: &TriangleMesh) {
    let mut bytes = Vec::new();
    push_binary_stl(mesh, &mut bytes).unwrap();
    fs::write(path, bytes).unwrap();
}

#[test]
fn pebbles_become_a_clump() {
    let folder = with_rod();
    let output = run(folder.path(), &["rod.csv", "--density", "2"]);
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    let text = said(&output);
    assert!(text.contains("* pebbles"), "{text}");
    let clump = read_clump(folder.path().join("rod.clump.toml")).unwrap();
    assert_eq!(
        (clump.name.as_str(), clump.inertia_method.as_str()),
        ("rod", "pebbles")
    );
    // (pi/6) rho d^5 (0.3, 2.3, 2.3), the long axis first.
    let expected = std::f64::consts::PI / 6.0 * 2.0 * DVec3::new(0.3, 2.3, 2.3);
    assert!(clump.principal_moments.abs_diff_eq(expected, 1e-14));
    assert!(clump.pebbles[2].position.abs_diff_eq(DVec3::X, 1e-15));
    let list = read_pebble_list(folder.path().join("rod.pebbles.csv")).unwrap();
    assert_eq!(list, clump.pebbles);
    let vtu = fs::read(folder.path().join("rod.pebbles.vtu")).unwrap();
    assert!(vtu.starts_with(b"<?xml"), "{:?}", &vtu[..20]);
    let names: Vec<String> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(names.len(), 5, "no temporary files: {names:?}");
    let picture = fs::read(folder.path().join("rod.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 5000);
    let Some((_, Remark::Table(source))) = clump.source.iter().find(|(key, _)| key == "pebbles")
    else {
        panic!("{:?}", clump.source);
    };
    // sha256sum of the file.
    assert_eq!(source[0].1, "rod.csv".into());
    let Remark::Text(hash) = &source[1].1 else {
        panic!()
    };
    assert_eq!(hash.len(), 64);
}

#[test]
fn the_t_bar_of_the_scene_is_exact() {
    let Some(list) = shared("data/shapes/pebbles/clump02_shipped.csv") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let list = list.display().to_string();
    succeeds(
        folder.path(),
        &[
            &list,
            "--density",
            "1",
            "--inertia",
            "pebbles",
            "-o",
            "t-bar.clump.toml",
        ],
    );
    let clump = read_clump(folder.path().join("t-bar.clump.toml")).unwrap();
    assert_eq!(clump.name, "t-bar");
    let expected = std::f64::consts::PI / 6.0 * DVec3::new(11.4, 29.0, 39.4);
    assert!(
        clump.principal_moments.abs_diff_eq(expected, 1e-12),
        "{}",
        clump.principal_moments
    );
}

/// A defect of the existing tool: four decimals in m, so that pebbles of a micrometre were all at 0.
#[test]
fn files_for_paraview_keep_every_digit_of_small_pebbles() {
    let folder = tempfile::tempdir().unwrap();
    let list = "1.2345678901e-6,0,0,3.3e-7\n-2.3456789012e-6,1e-7,0,4.4e-7\n";
    fs::write(folder.path().join("dust.csv"), list).unwrap();
    succeeds(folder.path(), &["dust.csv"]);
    let clump = read_clump(folder.path().join("dust.clump.toml")).unwrap();
    let vtu = fs::read(folder.path().join("dust.pebbles.vtu")).unwrap();
    for pebble in &clump.pebbles {
        let [x, y, z] = pebble.position.to_array();
        for value in [x, y, z, pebble.radius] {
            let bytes = value.to_le_bytes();
            assert!(vtu.windows(8).any(|window| window == bytes), "{value}");
        }
    }
}

/// Two of the existing tool's entry points did not start at all: every route runs here from the command line.
#[test]
fn every_route_runs() {
    let folder = with_rod();
    write_stl(
        &folder.path().join("hull.stl"),
        &cuboid(DVec3::new(0.5, 1.5, 0.5)),
    );
    for route in ["surface", "union", "voxels", "pebbles"] {
        succeeds(
            folder.path(),
            &["hull.stl", "rod.csv", "--inertia", route, "--force"],
        );
        let clump = read_clump(folder.path().join("hull.clump.toml")).unwrap();
        assert_eq!(clump.inertia_method, route);
        assert!(clump.checks.iter().any(|(key, _)| key == "fidelity"));
    }
}

#[test]
fn nothing_is_overwritten_without_force() {
    let folder = with_rod();
    succeeds(folder.path(), &["rod.csv"]);
    let before = fs::read(folder.path().join("rod.clump.toml")).unwrap();
    assert_eq!(
        refused(folder.path(), &["rod.csv", "--density", "3"]),
        "rod.clump.toml is there already: add --force to replace it, or -o to write elsewhere\n"
    );
    assert_eq!(
        fs::read(folder.path().join("rod.clump.toml")).unwrap(),
        before
    );
    succeeds(folder.path(), &["rod.csv", "--density", "3", "--force"]);
    assert_ne!(
        fs::read(folder.path().join("rod.clump.toml")).unwrap(),
        before
    );
}

#[test]
fn a_surface_gives_the_inertia_and_is_aligned_with_its_pebbles() {
    let folder = tempfile::tempdir().unwrap();
    // In mm, turned inward: both are dealt with, the latter with a word.
    let slab = cuboid(DVec3::new(1.0, 2.0, 3.0));
    write_stl(&folder.path().join("slab.stl"), &turned_round(&slab));
    fs::write(
        folder.path().join("slab.csv"),
        "0 0 2 1\n0 0 -2 1\n0 0 0 1\n",
    )
    .unwrap();
    let text = succeeds(
        folder.path(),
        &[
            "slab.stl",
            "slab.csv",
            "--scale",
            "1e-3",
            "--density",
            "1000",
        ],
    );
    assert!(text.contains("it is turned round"), "{text}");
    assert!(text.contains("* surface"), "{text}");
    assert!(text.contains("% less than the surface encloses"), "{text}");
    let clump = read_clump(folder.path().join("slab.clump.toml")).unwrap();
    // m/3 (b² + c²) with half edges, ascending: about z, y, x.
    let mass = 1000.0 * 8.0 * 6.0 * 1e-9;
    let expected = mass / 3.0 * DVec3::new(5.0, 10.0, 13.0) * 1e-6;
    assert!((clump.mass / mass - 1.0).abs() < 1e-12);
    assert!((clump.principal_moments / expected).abs_diff_eq(DVec3::ONE, 1e-12));
    // The longest edge lies along the first axis now, of surface and pebbles. The clump file names the surface beside it.
    let surface = clump.surface_path(&folder.path().join("slab.clump.toml"));
    assert_eq!(clump.surface.as_deref(), Some("slab.surface.stl"));
    let aligned = read_mesh(surface.unwrap()).unwrap();
    let (low, high) = aligned.bounds().unwrap();
    assert!(
        (high - low).abs_diff_eq(DVec3::new(6e-3, 4e-3, 2e-3), 1e-9),
        "{low} {high}"
    );
    assert!((clump.pebbles[0].position.x.abs() - 2e-3).abs() < 1e-15);
    assert!(folder.path().join("slab.surface.vtu").exists());
}

#[test]
fn a_surface_alone_is_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let mut obj = Vec::new();
    push_obj(&cuboid(DVec3::splat(0.5)), NumberStyle::Shortest, &mut obj);
    fs::write(folder.path().join("cube.obj"), obj).unwrap();
    let text = succeeds(folder.path(), &["cube.obj"]);
    assert!(text.contains("closed: yes"), "{text}");
    assert!(
        text.contains("no clump is written without pebbles"),
        "{text}"
    );
    assert!(!folder.path().join("cube.clump.toml").exists());
    let json: serde_json::Value =
        serde_json::from_str(&succeeds(folder.path(), &["cube.obj", "--json"])).unwrap();
    assert_eq!(json["surface"]["mass"], 1.0);
}

#[test]
fn json_is_one_object_with_all_routes() {
    let folder = with_rod();
    let json: serde_json::Value =
        serde_json::from_str(&succeeds(folder.path(), &["rod.csv", "--json"])).unwrap();
    assert_eq!(json["inertia_method"], "pebbles");
    assert_eq!(json["pebbles"].as_array().unwrap().len(), 3);
    for route in ["union", "voxels", "pebbles"] {
        let mass = json["checks"][route]["mass"].as_f64().unwrap();
        assert!(
            (mass / (std::f64::consts::PI / 2.0) - 1.0).abs() < 0.02,
            "{route}: {mass}"
        );
    }
    assert_eq!(json["files"].as_array().unwrap().len(), 3);
}

#[test]
fn overlaps_take_the_union_by_default_and_are_reported_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("pair.csv"), "0,0,0,1\n0.5,0,0,1\n").unwrap();
    let text = succeeds(folder.path(), &["pair.csv"]);
    assert!(text.contains("* union"), "{text}");
    let text = succeeds(
        folder.path(),
        &["pair.csv", "--inertia", "pebbles", "--force"],
    );
    assert!(
        text.contains("warning: the pebbles overlap: counted one by one they have 1.463 times the volume that they cover"),
        "{text}"
    );
}

#[test]
fn wrong_units_are_suspected() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.csv"), "0,0,0,60\n").unwrap();
    let text = succeeds(folder.path(), &["p.csv", "--density", "2500000"]);
    assert!(
        text.contains(
            "warning: the body is 120.000 m long: if the file is in mm, add --scale 1e-3"
        ),
        "{text}"
    );
    assert!(
        text.contains("warning: no solid has a density of 2500000 kg/m3"),
        "{text}"
    );
    // 4 mm without the mm, and 2.5 g/cm3 without the unit.
    fs::write(folder.path().join("q.csv"), "0,0,0,2\n").unwrap();
    let text = succeeds(folder.path(), &["q.csv", "--density", "2.5"]);
    assert!(
        text.contains("warning: the body is 4.000 m long: if the file is in mm"),
        "{text}"
    );
    assert!(
        text.contains("warning: a density of 2.5 kg/m3 is that of a light foam"),
        "{text}"
    );
}

#[test]
fn bad_input_is_named() {
    let folder = with_rod();
    let path = folder.path();
    let mut open = cuboid(DVec3::splat(0.5));
    open.triangles.pop();
    write_stl(&path.join("open.stl"), &open);
    fs::write(path.join("empty.stl"), "").unwrap();
    let mut cut = Vec::new();
    push_binary_stl(&cuboid(DVec3::ONE), &mut cut).unwrap();
    fs::write(path.join("cut.stl"), &cut[..300]).unwrap();
    let mut damaged = cut.clone();
    damaged[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(path.join("nan.stl"), damaged).unwrap();
    fs::write(
        path.join("text.stl"),
        "solid a\n facet normal 0 0 1\n outer loop\n vertex 0 0 zero\n",
    )
    .unwrap();
    fs::write(path.join("bad.csv"), "0,0,0,1\n0,0,0,-1\n").unwrap();
    for (line, expected) in [
        ("open.stl rod.csv", "open.stl: the surface is not closed"),
        ("open.stl", "closed: no, 3 edges open"),
        ("empty.stl", "empty.stl: the file is empty"),
        (
            "cut.stl rod.csv",
            "cut.stl: a binary STL of 4 whole triangles (300 bytes), expected 12 triangles",
        ),
        ("nan.stl", "in triangle 1, expected finite coordinates"),
        (
            "text.stl",
            "text.stl:4:13: \"zero\" for a coordinate, expected a finite number",
        ),
        (
            "bad.csv",
            "bad.csv:2:7: \"-1\" for radius, expected a radius above 0",
        ),
        ("none.csv", "none.csv: the file cannot be read"),
        (
            "rod.csv --inertia surface",
            "--inertia surface needs a surface",
        ),
        (
            "rod.csv bad.csv",
            "rod.csv and bad.csv are both taken for pebble lists",
        ),
        ("rod.csv --generate tangent", "--generate makes the pebbles"),
        ("rod.csv --density 0", "must be above 0"),
        ("rod.csv --scale nan", "expected a number above 0"),
        ("", "required"),
    ] {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        let text = refused(path, &arguments);
        assert!(text.contains(expected), "{line}: {text}");
    }
    assert!(!path.join("open.clump.toml").exists() && !path.join("bad.clump.toml").exists());
    // With --repair the program reads the same surface and lists its changes.
    let text = succeeds(path, &["open.stl", "rod.csv", "--repair"]);
    assert!(text.contains("done: 1 hole closed"), "{text}");
}

#[test]
fn pebbles_are_made_for_a_surface() {
    let folder = tempfile::tempdir().unwrap();
    write_stl(
        &folder.path().join("slab.stl"),
        &cuboid(DVec3::new(1.0, 1.0, 3.0)),
    );
    let arguments = [
        "slab.stl",
        "--generate",
        "euclidean",
        "--pebbles",
        "5",
        "--seed",
        "1",
    ];
    succeeds(folder.path(), &arguments);
    let clump = read_clump(folder.path().join("slab.clump.toml")).unwrap();
    assert_eq!(clump.pebbles.len(), 5);
    assert_eq!(clump.inertia_method, "surface");
}

#[test]
fn help_version_and_completions_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let help = succeeds(folder.path(), &["--help"]);
    assert!(
        help.contains("Examples:") && help.contains("Exit codes:"),
        "{help}"
    );
    assert!(succeeds(folder.path(), &["--version"]).starts_with("mclump "));
    assert!(succeeds(folder.path(), &["--completions", "bash"]).contains("_mclump"));
}

#[test]
fn lengths_that_cannot_be_computed_with_are_refused_with_their_line() {
    const RANGE: &str = "help: moments of inertia are fifth powers of lengths and would leave the range of numbers: correct the value or --scale\n";
    const DIGITS: &str = "help: numbers have 16 digits, so the pebble would vanish: correct the value, or move the origin into the body\n";
    const FAR: &str = "help: the pebbles would vanish against their distances: correct the one that is far away\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let radius = "expected a radius from 1e-30 m to 1e30 m";
    for (list, scale, expected) in [
        (
            "0,0,0,1e100\n",
            "1",
            format!("h.csv:1: the radius 1e100 m, {radius}\n{RANGE}"),
        ),
        (
            "x,y,z,r\n\n0,0,0,1\n0,0,0,1e-300\n",
            "1",
            format!("h.csv:4: the radius 1e-300 m, {radius}\n{RANGE}"),
        ),
        (
            "0,0,0,1\n",
            "1e-200",
            format!("h.csv:1: the radius 1e-200 m (with --scale 1e-200), {radius}\n{RANGE}"),
        ),
        (
            "0,0,0,1\n0,-1e200,0,1\n",
            "1",
            format!("h.csv:2: y = -1e200 m, expected at most 1e30 m in size\n{RANGE}"),
        ),
        (
            "1e30,0,0,1\n0,0,0,1\n",
            "1",
            format!(
                "h.csv:1: the radius 1 m beside x = 1e30 m, expected at least 1e-12 of the coordinate\n{DIGITS}"
            ),
        ),
        (
            "1e10,0,0,1\n0,0,0,1\n",
            "1",
            format!(
                "h.csv:1: x = 1e10 m, which spreads the pebbles over 1e10 m, while the largest radius is 1 m, \
                 expected at least 1e-6 of the spread\n{FAR}"
            ),
        ),
    ] {
        fs::write(path.join("h.csv"), list).unwrap();
        assert_eq!(refused(path, &["h.csv", "--scale", scale]), expected);
    }
    fs::write(
        path.join("huge.obj"),
        "v 0 0 0\nv 3e99 0 0\nv 0 2 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    )
    .unwrap();
    assert_eq!(
        refused(path, &["huge.obj"]),
        format!(
            "huge.obj: a vertex with the coordinate 3e99 m in size, expected at most 1e30 m in size\n{RANGE}"
        )
    );
}

#[test]
fn a_surface_alone_of_a_suspicious_size_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (half, expected) in [
        (
            51.0,
            "the body is 102.000 m long: if the file is in mm, add --scale 1e-3",
        ),
        (
            2e9,
            "the body is 4.000e9 m long: if the file is in mm, add --scale 1e-3",
        ),
        (1e-9, "the body is only 2.0e-9 m long: is --scale right?"),
    ] {
        write_stl(&path.join("drum.stl"), &cuboid(DVec3::splat(half)));
        let text = succeeds(path, &["drum.stl"]);
        let line = format!("warning: {expected}");
        assert!(text.lines().any(|found| found == line), "{text}");
        let json: serde_json::Value =
            serde_json::from_str(&succeeds(path, &["drum.stl", "--json"])).unwrap();
        assert_eq!(json["warnings"], serde_json::json!([expected]));
    }
    write_stl(&path.join("drum.stl"), &cuboid(DVec3::splat(5.0)));
    assert!(!succeeds(path, &["drum.stl"]).contains("warning"));
}

#[test]
fn negative_numbers_reach_the_validator() {
    let folder = with_rod();
    for (option, value, reason) in [
        ("--density <RHO>", "-1", "must be above 0"),
        ("--scale <LENGTH>", "-0.001", "must be above 0"),
        ("--fidelity <FRACTION>", "-1", "must be above 0"),
        ("--protrusion <LENGTH>", "-0.5", "must be above 0"),
        ("--smallest-radius <LENGTH>", "-1", "must be above 0"),
        ("--voxel-tolerance <FRACTION>", "-1", "must be above 0"),
        ("--pebbles <N>", "-1", "-1 is not in 1..=100000"),
        ("--voxels <N>", "-1", "-1 is not in 1..=2000"),
    ] {
        let name = option.split(' ').next().unwrap();
        assert_eq!(
            refused(folder.path(), &["rod.csv", name, value]),
            format!(
                "error: invalid value '{value}' for '{option}': {reason}\n\nFor more information, try '--help'.\n"
            )
        );
    }
}

#[test]
fn pebbles_that_do_not_stand_for_the_surface_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // One ball of radius 1/2 in a plate of 200 x 200 x 1: pi/6 of 40,000, 0.00131 %.
    write_stl(
        &path.join("plate.stl"),
        &cuboid(DVec3::new(100.0, 100.0, 0.5)),
    );
    let little = "the pebbles cover 0.001309 % of the volume that the surface encloses, expected at least 1 %: they do not represent the body\n";
    assert_eq!(
        refused(
            path,
            &["plate.stl", "--generate", "euclidean", "--pebbles", "1"]
        ),
        format!(
            "{little}help: the body is thin or hollow: make more pebbles (--pebbles), let them stand out (--protrusion), or take another surface\n"
        )
    );
    fs::write(path.join("plate.csv"), "0,0,0,0.5\n").unwrap();
    assert_eq!(
        refused(path, &["plate.stl", "plate.csv"]),
        format!(
            "{little}help: give more or larger pebbles, in the unit of the surface (--scale goes for both), or --generate tangent --pebbles 100\n"
        )
    );
    fs::write(path.join("other.csv"), "0,0,0,0.5\n0,0,7.5,1\n").unwrap();
    assert_eq!(
        refused(path, &["plate.stl", "other.csv"]),
        "1 of 2 pebbles lie wholly outside the box around the surface, the first is pebble 2: \
         the surface spans x -100 to 100 m, y -100 to 100 m, z -0.5 to 0.5 m, \
         the pebbles span x -1 to 1 m, y -1 to 1 m, z -0.5 to 8.5 m\n\
         help: both must be in the same frame and unit (--scale goes for both): are they of the same body?\n"
    );
    assert!(!path.join("plate.clump.toml").exists());
}

/// Pebbles made from the surface are in its frame and unit, whatever else is wrong with them.
#[test]
fn names_with_points_and_lengths_with_units_are_taken() {
    let folder = with_rod();
    let at = folder.path();
    let units = ["--scale", "1 mm", "--density", "2.5 g/cm3"];
    succeeds(at, &[&["rod.csv", "-o", "b0.1e-3"], &units[..]].concat());
    let clump = read_clump(at.join("b0.1e-3.clump.toml")).unwrap();
    assert_eq!(clump.name, "b0.1e-3");
    assert_eq!(clump.density, 2500.0);
    // Three balls of 0.5 mm that touch.
    let volume = 3.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.5e-3_f64.powi(3);
    assert!((clump.volume / volume - 1.0).abs() < 1e-12);
    let error = refused(at, &["rod.csv", "--scale", "1 kg"]);
    assert!(error.contains("is a mass, expected a length"), "{error}");
}

#[test]
fn an_automatic_protrusion_is_written_and_needs_a_number_of_pebbles() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut bytes = Vec::new();
    push_binary_stl(&cuboid(DVec3::new(1.0, 0.7, 0.5)), &mut bytes).unwrap();
    fs::write(at.join("box.stl"), bytes).unwrap();
    let generate = ["box.stl", "--generate", "euclidean", "--protrusion", "auto"];
    let error = refused(at, &generate);
    assert!(error.contains("give the number (--pebbles)"), "{error}");
    succeeds(
        at,
        &[&generate[..], &["--pebbles", "6", "--scale", "1mm"]].concat(),
    );
    let clump = read_clump(at.join("box.clump.toml")).unwrap();
    let check = clump.checks.iter().find(|(key, _)| key == "fidelity");
    let Some((_, Remark::Table(fidelity))) = check else {
        panic!("{check:?}")
    };
    let error = fidelity.iter().find(|(key, _)| key == "volume_error");
    let Some((_, Remark::Number(error))) = error else {
        panic!("{error:?}")
    };
    assert!(error.abs() < 5e-3, "{error}");
}

#[test]
fn generated_pebbles_need_no_frame_and_unit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(
        path.join("wedge.obj"),
        "v 0 0 0\nv 3 0 0\nv 0 2 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    )
    .unwrap();
    let shift = "warning: the centre of the pebbles' union is ";
    let text = succeeds(
        path,
        &["wedge.obj", "--generate", "tangent", "--pebbles", "1"],
    );
    // (6 V / pi)^(1/3) of the surface's volume, 1 m^3.
    let size = "equal-volume diameter 1.240701 m\n";
    assert!(text.contains(size), "{text}");
    let file = fs::read_to_string(path.join("wedge.clump.toml")).unwrap();
    assert!(
        file.contains("\nequal_volume_diameter = 1.24070098"),
        "{file}"
    );
    let line = text.lines().find(|line| line.starts_with(shift)).unwrap();
    assert!(
        line.ends_with("% of the body's size away from that of the surface"),
        "{line}"
    );
    fs::write(path.join("wedge.csv"), "1,0.5,0.2,0.3\n").unwrap();
    let text = succeeds(path, &["wedge.obj", "wedge.csv", "--force"]);
    let line = text.lines().find(|line| line.starts_with(shift)).unwrap();
    assert!(
        line.ends_with("of the surface: are both in the same frame and unit?"),
        "{line}"
    );
}

#[test]
fn generators_name_the_options_that_help() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_stl(&path.join("cube.stl"), &cuboid(DVec3::splat(0.5)));
    for (options, expected) in [
        (
            vec!["tangent"],
            "a generator needs an end: give a number of pebbles (--pebbles), a volume error (--fidelity), or both\n",
        ),
        (
            vec![
                "tangent",
                "--pebbles",
                "3",
                "--smallest-radius",
                "100",
                "--scale",
                "3",
            ],
            "no pebble fits: there is no inscribed ball with a radius of 100 m or more; allow smaller pebbles (--smallest-radius)\n",
        ),
        (
            vec![
                "euclidean",
                "--fidelity",
                "0.05",
                "--smallest-radius",
                "0.3",
            ],
            "1 pebbles, all that fit, reach a volume error of 0.4764, not 0.05; allow smaller pebbles (--smallest-radius) or some protrusion \
             (--protrusion), ask for a number of pebbles (--pebbles) instead, or use another method (--generate)\n",
        ),
    ] {
        let arguments = [&["cube.stl", "--generate"], options.as_slice()].concat();
        assert_eq!(refused(path, &arguments), expected);
    }
}

#[test]
fn the_input_is_looked_at_before_the_output() {
    let folder = with_rod();
    let path = folder.path();
    succeeds(path, &["rod.csv"]);
    assert_eq!(
        refused(path, &["rod.foo"]),
        "rod.foo: the file cannot be read: No such file or directory (os error 2)\n"
    );
}

#[test]
fn a_name_without_suffix_gets_one_and_a_missing_folder_is_bad_usage() {
    let folder = with_rod();
    let path = folder.path();
    succeeds(path, &["rod.csv", "-o", "rb"]);
    let clump = read_clump(path.join("rb.clump.toml")).unwrap();
    assert_eq!(clump.name, "rb");
    assert!(path.join("rb.pebbles.csv").exists() && !path.join("rb").exists());
    succeeds(path, &["rod.csv", "-o", "other.toml"]);
    assert!(path.join("other.toml").exists());
    for (output, file, missing) in [
        ("no/rb", "no/rb.clump.toml", "no"),
        ("rod.csv/rb.toml", "rod.csv/rb.toml", "rod.csv"),
    ] {
        assert_eq!(
            refused(path, &["rod.csv", "-o", output]),
            format!(
                "{file}: there is no folder {missing}: make it first, or -o to write elsewhere\n"
            )
        );
    }
}
