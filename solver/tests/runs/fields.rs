//! `[[fields]]`: what a run writes as it goes is what coarse-graining makes of its stored frames, byte for byte.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use mercury_cg::analysis::{Reference, TimeMode};
use mercury_cg::input::{FrameChoice, Given};
use mercury_cg::kernel::KernelShape;
use mercury_cg::options::{Cells, Width};
use mercury_cg::output::push_table;
use mercury_cg::setup::{Wanted, mean_diameter};

/// Grains of two materials that fall on each other, with friction and rolling resistance, in a box that is periodic along x; one is fixed.
const SCENE: &str = r#"
gravity = [2.0, 0.0, -9.81]

[time]
end = 0.03
step = "auto"

[domain]
min = [0.0, 0.0, 0.0]
max = [0.1, 0.05, 0.1]
periodic = ["x"]

[materials.glass]
density = 2500.0
normal = { law = "linear", stiffness = 200.0, restitution = 0.6 }
tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
rolling = { law = "luding", friction = 0.1 }

[materials.steel]
density = 7800.0
normal = { law = "linear", stiffness = 200.0, restitution = 0.6 }
tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
rolling = { law = "luding", friction = 0.1 }

[[walls]]
name = "box"
shape = "box"
material = "steel"

[[particles]]
material = "glass"
radius = 0.006
lattice = { min = [0.006, 0.008, 0.007], max = [0.1, 0.044, 0.05], spacing = 0.0125, jitter = 0.0002 }

[[particles]]
material = "steel"
radius = 0.004
lattice = { min = [0.01, 0.01, 0.07], max = [0.09, 0.04, 0.08], spacing = 0.009, jitter = 0.0002 }

[[particles]]
material = "steel"
radius = 0.005
position = [0.05, 0.025, 0.06]
fixed = true

[output]
interval = 0.005
fstat = true
pictures = false
"#;

/// Clumps to add to the scene.
const CLUMPS: &str = r#"
[clumps.rod]
file = "rod.clump.toml"
material = "glass"

[[particles]]
clump = "rod"
position = [0.05, 0.025, 0.09]
orientation = [0.9, 0.3, 0.1, 0.2]
scale = 0.004
"#;

fn solve(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder)
        .arg("run.toml")
        .args(arguments)
        .output()
        .unwrap()
}

fn solved(folder: &Path, scene: &str, arguments: &[&str]) {
    fs::write(folder.join("run.toml"), scene).unwrap();
    let rod = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/rod.clump.toml");
    fs::copy(rod, folder.join("rod.clump.toml")).unwrap();
    let output = solve(folder, arguments);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{errors}");
}

fn table(folder: &Path, name: &str) -> String {
    let path = folder.join(format!("run/run.fields.{name}.csv"));
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The table that coarse-graining makes of the frames of a run.
fn from_frames(folder: &Path, wanted: &Wanted, times: std::ops::RangeInclusive<f64>) -> String {
    let (source, fields) = wanted.open(&folder.join("run"), &Given::default()).unwrap();
    let states = || {
        let inside = |state: &Result<mercury_cg::state::State, _>| {
            times.contains(&state.as_ref().unwrap().time)
        };
        source.states(FrameChoice::All).filter(inside)
    };
    let first = states().next().unwrap().unwrap();
    let analysis = wanted.analysis(source.materials(), &first, fields).unwrap();
    let timed = analysis.time != TimeMode::Average;
    let mut out = Vec::new();
    analysis
        .run(states(), |block| {
            let is_first = out.is_empty();
            push_table(&mut out, &analysis, &block, is_first, timed);
            Ok(())
        })
        .unwrap();
    String::from_utf8(out).unwrap()
}

/// The mean diameter at the start, as a width in m.
fn profile_width(folder: &Path) -> Wanted {
    let source = Wanted::default();
    let (source, _) = source.open(&folder.join("run"), &Given::default()).unwrap();
    let first = source.states(FrameChoice::All).next().unwrap().unwrap();
    Wanted {
        width: Some(Width::Metres(mean_diameter(&first).unwrap())),
        ..Wanted::default()
    }
}

fn names(words: &[&str]) -> Vec<String> {
    words.iter().map(|&word| word.to_owned()).collect()
}

#[test]
fn tables_are_those_of_the_stored_frames() {
    let tables = r#"
[[fields]]
name = "profile"
coordinates = "Z"
grid = [12]
width = "0.8d"

[[fields]]
name = "mean"
fields = ["density", "stress", "velocity_gradient", "couple_stress", "coordination", "drag", "boundary_force"]
coordinates = "XZ"
spacing = [0.02]
kernel = "lucy"
width = 0.02
by_material = true
average = true
from = 0.0075
until = 0.0275

[[fields]]
name = "displaced"
fields = ["displacement", "strain", "angular_velocity", "spin"]
coordinates = "O"

[[fields]]
name = "smooth"
fields = ["density", "displacement", "kinetic_stress"]
coordinates = "XZ"
points = "points.txt"
materials = ["steel"]
since = "first"
smooth = [0.005, 0.004]
from = 0.005
"#;
    for clumps in ["", CLUMPS] {
        let folder = tempfile::tempdir().unwrap();
        let points = folder.path().join("points.txt");
        fs::write(&points, "x z\n0.02 0.01\n0.05 0.03\n").unwrap();
        solved(folder.path(), &format!("{SCENE}{clumps}{tables}"), &[]);
        let profile = Wanted {
            coordinates: "Z".parse().ok(),
            grid: Some(Cells(vec![12])),
            width: Some(Width::Diameters(0.8)),
            errors: true,
            ..Wanted::default()
        };
        let mean = Wanted {
            fields: names(&[
                "density",
                "stress",
                "velocity_gradient",
                "couple_stress",
                "coordination",
                "drag",
                "boundary_force",
            ]),
            coordinates: "XZ".parse().ok(),
            spacing: "0.02".parse().ok(),
            shape: KernelShape::Lucy,
            width: Some(Width::Metres(0.02)),
            by_material: true,
            time: Some(TimeMode::Average),
            errors: true,
            ..Wanted::default()
        };
        let displaced = Wanted {
            fields: names(&["displacement", "strain", "angular_velocity", "spin"]),
            coordinates: "O".parse().ok(),
            errors: true,
            ..Wanted::default()
        };
        let smooth = Wanted {
            fields: names(&["density", "displacement", "kinetic_stress"]),
            coordinates: "XZ".parse().ok(),
            points: Some(points),
            materials: names(&["steel"]),
            reference: Reference::First,
            time: Some(TimeMode::Smooth {
                width: 0.005,
                step: 0.004,
            }),
            errors: true,
            // The width that a table takes is that of the start.
            ..profile_width(folder.path())
        };
        let always = 0.0..=f64::INFINITY;
        for (name, wanted, times) in [
            ("profile", profile, always.clone()),
            ("mean", mean, 0.0075..=0.0275),
            ("displaced", displaced, always),
            ("smooth", smooth, 0.00499..=f64::INFINITY),
        ] {
            let expected = from_frames(folder.path(), &wanted, times);
            let found = table(folder.path(), name);
            assert!(found.lines().count() > 6, "{name}: {found}");
            assert!(found == expected, "{name}:\n{found}\n{expected}");
        }
    }
}

#[test]
fn no_frame_needs_to_be_stored_and_threads_change_nothing() {
    let tables = "
[[fields]]
name = \"fine\"
coordinates = \"Z\"
width = 0.01
interval = 0.002
";
    let quiet = "output.frames=false output.data=false output.fstat=false output.ene=false output.walls=false";
    let quiet: Vec<&str> = quiet.split(' ').flat_map(|set| ["--set", set]).collect();
    let folders = [1, 2].map(|threads| {
        let folder = tempfile::tempdir().unwrap();
        let threads = threads.to_string();
        let arguments: Vec<&str> =
            [&quiet[..], &["--fixed-threads", "--threads", &threads]].concat();
        solved(folder.path(), &format!("{SCENE}{tables}"), &arguments);
        folder
    });
    let [one, two] = folders
        .each_ref()
        .map(|folder| table(folder.path(), "fine"));
    assert_eq!(one, two);
    let mut times: Vec<&str> = one
        .lines()
        .skip(3)
        .filter_map(|row| row.split(',').next())
        .collect();
    times.dedup();
    // At the start, every 0.002 s, and at the end, which is one of these.
    assert_eq!(times.len(), 16, "{times:?}");
    let stored = |entry: std::io::Result<fs::DirEntry>| {
        let name = entry.unwrap().file_name().into_string().unwrap();
        [".arrow", ".data", ".fstat"]
            .iter()
            .any(|ending| name.ends_with(ending))
    };
    let mut entries = fs::read_dir(folders[0].path().join("run")).unwrap();
    assert!(!entries.any(stored));
    // A table of fields is part of a run: not written over, and removed with it.
    let again = solve(folders[0].path(), &[]);
    assert_eq!(again.status.code(), Some(2));
    let scene = fs::read_to_string(folders[0].path().join("run.toml")).unwrap();
    solved(
        folders[0].path(),
        &scene.replace("\"fine\"", "\"other\""),
        &["--force"],
    );
    assert!(!folders[0].path().join("run/run.fields.fine.csv").exists());
}

#[test]
fn mistakes_are_reported_with_their_place() {
    let mistakes = [
        ("name = \"a b\"", "is part of a file's name"),
        (
            "name = \"a\"\nfields = [\"densty\"]",
            "there is no field densty",
        ),
        (
            "name = \"a\"\ncoordinates = \"XX\"",
            "coordinates: expected O, X, Y, Z",
        ),
        (
            "name = \"a\"\ngrid = [3, 4]",
            "grid: 2 numbers for the coordinates XYZ",
        ),
        (
            "name = \"a\"\ngrid = [3]\nspacing = [0.1]",
            "cannot be given together",
        ),
        ("name = \"a\"\nwidth = \"2\"", "mean diameters as in"),
        ("name = \"a\"\nwidth = -1.0", "must be > 0"),
        (
            "name = \"a\"\nmirror = [\"-x\"]",
            "mirror[0]: the domain is periodic along x",
        ),
        (
            "name = \"a\"\nmirror = [\"z\"]",
            "mirror[0]: expected faces",
        ),
        (
            "name = \"a\"\nlimits = { q = [0, 1] }",
            "is not a known key",
        ),
        (
            "name = \"a\"\ncoordinates = \"X\"\nlimits = { z = [0, 1] }",
            "limits.z: z is not among",
        ),
        ("name = \"a\"\nkernel = \"gauss\"", "there is no kernel"),
        (
            "name = \"a\"\nkernel = \"heaviside\"\nfields = [\"strain_rate\"]",
            "has a jump and no gradient",
        ),
        (
            "name = \"a\"\nfrom = 0.03\nuntil = 0.02",
            "until: must not be before `from` = 0.03 s, got 0.02",
        ),
        (
            "name = \"a\"\nspacing = [1e-6]",
            "help: a larger `spacing`, or `grid`",
        ),
        ("name = \"a\"\ncutof = 3.0", "did you mean `cutoff`?"),
        (
            "name = \"a\"\nmaterials = [\"glas\"]",
            "there is no material \"glas\"",
        ),
        (
            "name = \"a\"\npoints = \"none.txt\"",
            "the file does not exist",
        ),
        ("name = \"a\"\npoints = \"run.toml\"", "points: run.toml:"),
        (
            "name = \"a\"\npoints = \"run.toml\"\ngrid = [3]",
            "cannot be given together",
        ),
        (
            "name = \"a\"\nsince = \"start\"",
            "there are: first, previous",
        ),
        (
            "name = \"a\"\nsmooth = [0.1, 0.0]",
            "must be > 0 in each component",
        ),
        (
            "name = \"a\"\nsmooth = [0.1, 1e-5]",
            "the step must be at least 0.01 of the width",
        ),
        (
            "name = \"a\"\nsmooth = [1e-4, 0.01]",
            "smooths nothing: samples are 0.005 s apart",
        ),
        (
            "name = \"a\"\nsmooth = [0.01, 0.01]\naverage = true",
            "smooth: cannot be used together with average = true",
        ),
        ("name = \"a\"\n[[fields]]\nname = \"a\"", "is used twice"),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (table, expected) in mistakes {
        fs::write(
            folder.path().join("run.toml"),
            format!("{SCENE}[[fields]]\n{table}\n"),
        )
        .unwrap();
        let output = solve(folder.path(), &["--check"]);
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{table}: {errors}");
        assert!(
            errors.contains(expected) && errors.contains("run.toml:"),
            "{table}: {errors}"
        );
    }
}
