//! The program as users call it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use glam::DVec3;
use mercury_common::frames::{FramesHeader, ParticleColumns, ParticleFrame, ParticleWriter};
use mercury_tables::Table;
use tempfile::TempDir;

/// Arguments, as typed on one line.
fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../tests/data/dense2k")
        .join(name)
}

fn run(words: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-cg"))
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn good(words: &[&str], folder: &Path) -> String {
    let output = run(words, folder);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{words:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

fn bad(words: &[&str], folder: &Path, expected: &str) {
    let output = run(words, folder);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{words:?}: {errors}");
    assert!(errors.contains(expected), "{words:?}: {errors}");
}

/// The columns of a table by name.
fn columns(text: &str) -> Vec<(String, Vec<f64>)> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<String> = lines
        .next()
        .unwrap()
        .split(',')
        .map(|cell| mercury_common::formats::table_head::name(cell).to_owned())
        .collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|word| word.parse().unwrap()).collect())
        .collect();
    names
        .into_iter()
        .enumerate()
        .map(|(k, name)| (name, rows.iter().map(|row| row[k]).collect()))
        .collect()
}

fn column(text: &str, name: &str) -> Vec<f64> {
    let all = columns(text);
    all.into_iter()
        .find(|(other, _)| other == name)
        .unwrap_or_else(|| panic!("no column {name}"))
        .1
}

#[test]
fn a_profile_as_table_as_stat_and_as_mercury_cg_writes_it() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    let input = input.to_str().unwrap();
    let said = good(
        &[
            input,
            "--density",
            "2500",
            "--coordinates",
            "Z",
            "--grid",
            "50",
            "--width",
            "0.002",
            "--compat",
            "mercury",
            "-o",
            "a.csv",
            "-o",
            "a.stat",
        ],
        folder.path(),
    );
    assert!(
        said.contains("a.csv") && said.contains("1 frame,"),
        "{said}"
    );
    // Digit by digit, header included.
    let (found, expected) = (
        fs::read_to_string(folder.path().join("a.stat")).unwrap(),
        fs::read_to_string(data("dense2k.Z.Gauss.stat")).unwrap(),
    );
    for (line, (a, b)) in found.lines().zip(expected.lines()).enumerate() {
        if line < 2 {
            assert_eq!(a, b);
            continue;
        }
        for (a, b) in a.split_ascii_whitespace().zip(b.split_ascii_whitespace()) {
            let (a, b): (f64, f64) = (a.parse().unwrap(), b.parse().unwrap());
            assert!(
                (a - b).abs() <= 1.1e-5 * b.abs() + 1e-9,
                "line {line}: {a} {b}"
            );
        }
    }
    let table = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert!(
        table.starts_with("# mercury-cg ") && table.contains("\n# units: s,m,1,kg/m^3,"),
        "{}",
        &table[..200]
    );
    assert!(table.contains("\ntime [s],z [m],"), "{}", &table[..400]);
    let density = column(&table, "density");
    let names: Vec<String> = columns(&table).into_iter().map(|(name, _)| name).collect();
    assert_eq!(
        (density.len(), &names[..2]),
        (50, &["time".to_owned(), "z".to_owned()][..])
    );
    assert!((density[10] / 1380.0 - 1.0).abs() < 0.05, "{}", density[10]);
    let (pressure, xx, yy, zz) = (
        column(&table, "pressure"),
        column(&table, "stress_xx"),
        column(&table, "stress_yy"),
        column(&table, "stress_zz"),
    );
    assert!((pressure[5] - (xx[5] + yy[5] + zz[5]) / 3.0).abs() < 1e-9 * pressure[5]);
}

#[test]
fn parquet_holds_what_a_table_holds() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    let input = input.to_str().unwrap();
    let words = [
        input,
        "--density",
        "2500",
        "--coordinates",
        "Z",
        "--grid",
        "12",
        "--fields",
        "density,stress,size_moments",
        "-o",
        "profile.csv",
        "-o",
        "profile.parquet",
    ];
    for average in [None, Some("--average=time")] {
        let words: Vec<&str> = words
            .into_iter()
            .chain(average)
            .chain(["--force"])
            .collect();
        let said = good(&words, folder.path());
        assert!(said.contains("at 12 points: profile.parquet"), "{said}");
        let [csv, parquet] =
            ["profile.csv", "profile.parquet"].map(|name| folder.path().join(name));
        let text = fs::read_to_string(csv).unwrap();
        let table = Table::read(&parquet).unwrap();
        let units = text.lines().find_map(|line| line.strip_prefix("# units: "));
        let units: Vec<&str> = units.unwrap().split(',').collect();
        let expected = columns(&text);
        assert_eq!(table.columns().len(), expected.len());
        assert_eq!(table.columns().len(), units.len());
        for ((column, (name, values)), unit) in table.columns().iter().zip(expected).zip(units) {
            assert_eq!((&column.name, column.unit.as_str()), (&name, unit));
            // The decimals of the one read back to the bits of the other.
            assert_eq!(table.values::<f64>(&name).unwrap(), values, "{name}");
        }
    }
    bad(
        &[
            input,
            "--density",
            "2500",
            "--scan",
            "1d..2d/2",
            "-o",
            "widths.parquet",
        ],
        folder.path(),
        "--scan writes a table, .csv, or pictures",
    );
}

#[test]
fn images_for_paraview_hold_every_field() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    good(
        &[
            input.to_str().unwrap(),
            "--density",
            "2500",
            "--coordinates",
            "XZ",
            "--grid",
            "4x5",
            "--frames",
            "last",
            "--fields",
            "density,velocity,fabric",
            "-o",
            "a.vti",
        ],
        folder.path(),
    );
    let bytes = fs::read(folder.path().join("a.vti")).unwrap();
    // Units are field data: a text as the numbers of its bytes.
    let text = String::from_utf8_lossy(&bytes);
    let unit = "<Array type=\"String\" Name=\"density_unit\" NumberOfTuples=\"1\" format=\"ascii\">107 103 47 109 94 51 0</Array>";
    assert!(text.contains(unit), "{}", &text[..2000.min(text.len())]);
    let text = String::from_utf8_lossy(&bytes);
    let head = text.split("  <AppendedData").next().unwrap().to_owned() + "</VTKFile>";
    let document = roxmltree::Document::parse(&head).unwrap();
    let image = document
        .descendants()
        .find(|node| node.has_tag_name("ImageData"))
        .unwrap();
    assert_eq!(image.attribute("WholeExtent"), Some("0 4 0 1 0 5"));
    let arrays: Vec<(String, usize)> = document
        .descendants()
        .filter(|node| {
            node.has_tag_name("DataArray") && node.attribute("format") == Some("appended")
        })
        .map(|node| {
            (
                node.attribute("Name").unwrap().to_owned(),
                node.attribute("NumberOfComponents")
                    .map_or(1, |n| n.parse().unwrap()),
            )
        })
        .collect();
    assert_eq!(
        arrays,
        [
            ("density".to_owned(), 1),
            ("velocity".to_owned(), 3),
            ("fabric".to_owned(), 9)
        ]
    );
    // The blocks have the stated length.
    let marker = b"encoding=\"raw\">\n_";
    let start = bytes
        .windows(marker.len())
        .position(|window| window == marker)
        .unwrap()
        + marker.len();
    let length = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    assert_eq!(length(start), 20 * 8);
    assert_eq!(length(start + 8 + 20 * 8), 20 * 24);
}

#[test]
fn pictures_show_profiles_and_maps() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    let with = |words: &[&'static str]| -> Vec<String> {
        [input.to_str().unwrap(), "--density", "2500"]
            .into_iter()
            .chain(words.iter().copied())
            .map(str::to_owned)
            .collect()
    };
    let call = |words: &[&'static str]| {
        let words = with(words);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        good(&words, folder.path());
    };
    call(&words(
        "--coordinates Z --grid 9 --average time -o a.svg -o a.png",
    ));
    let svg = fs::read_to_string(folder.path().join("a.svg")).unwrap();
    assert!(roxmltree::Document::parse(&svg).is_ok() && svg.contains("granular temperature"));
    assert!(
        fs::read(folder.path().join("a.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    // One file per frame of a series.
    call(&words(
        "--coordinates XZ --grid 3x4 --fields density,velocity -o b.svg",
    ));
    let svg = fs::read_to_string(folder.path().join("b.0000.svg")).unwrap();
    assert!(svg.contains("velocity x") && svg.contains("density"));
    let words = with(&["--grid", "2x2x2", "-o", "c.svg"]);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    bad(&words, folder.path(), "of one or two coordinates");
}

#[test]
fn a_scan_has_the_width_in_front() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    good(
        &[
            input.to_str().unwrap(),
            "--density",
            "2500",
            "--coordinates",
            "Z",
            "--grid",
            "3",
            "--scan",
            "0.5d..2d/3",
            "--fields",
            "density,stress_ratio",
            "-o",
            "a.csv",
            "-o",
            "a.svg",
            "-o",
            "a.png",
        ],
        folder.path(),
    );
    // A chart for each field with a line for each of the three heights.
    let picture = fs::read_to_string(folder.path().join("a.svg")).unwrap();
    for word in ["density", "stress ratio", "kernel width (", "z = 0.0"] {
        assert!(picture.contains(word), "{word}");
    }
    assert!(
        fs::read(folder.path().join("a.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    bad(
        &[
            input.to_str().unwrap(),
            "--density",
            "2500",
            "--scan",
            "1d..2d/3",
            "-o",
            "b.svg",
        ],
        folder.path(),
        "pictures of a scan show at most 8 points",
    );
    let table = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let widths = column(&table, "width");
    assert_eq!(widths.len(), 9);
    for (found, expected) in [(widths[0], 0.002), (widths[3], 0.004), (widths[8], 0.008)] {
        assert!((found - expected).abs() < 1e-12, "{widths:?}");
    }
}

#[test]
fn points_of_a_file_and_round_coordinates() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    let input = input.to_str().unwrap();
    fs::write(
        folder.path().join("points.csv"),
        "# two points\nx,z\n0.01,0.02\n0.03 0.02\n",
    )
    .unwrap();
    good(
        &[
            input,
            "--density",
            "2500",
            "--coordinates",
            "XZ",
            "--points",
            "points.csv",
            "-o",
            "a.csv",
        ],
        folder.path(),
    );
    assert_eq!(
        column(
            &fs::read_to_string(folder.path().join("a.csv")).unwrap(),
            "x"
        ),
        [0.01, 0.03]
    );
    good(
        &[
            input,
            "--density",
            "2500",
            "--coordinates",
            "RZ",
            "--spacing",
            "0.006",
            "--fields",
            "density,velocity",
            "-o",
            "r.csv",
        ],
        folder.path(),
    );
    let table = fs::read_to_string(folder.path().join("r.csv")).unwrap();
    let names: Vec<String> = columns(&table).into_iter().map(|(name, _)| name).collect();
    assert_eq!(
        names,
        [
            "time",
            "r",
            "z",
            "density",
            "velocity_r",
            "velocity_phi",
            "velocity_z"
        ]
    );
}

/// Heights along the axis of a cylinder are those of the input, as profiles over z have them.
#[test]
fn heights_in_a_cylinder_are_heights() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    let with = |words: &[&str]| {
        let first = [input.to_str().unwrap(), "--density", "2500", "--grid"];
        let words: Vec<&str> = first.iter().chain(words).copied().collect();
        good(&words, folder.path());
    };
    let ends = ["--fields", "density", "--exact", "-o"];
    let limits = ["--limits", "r=0..0.001"];
    with(
        &[
            &["1x9", "--coordinates", "RZ"],
            &limits[..],
            &ends[..],
            &["rz.csv"],
        ]
        .concat(),
    );
    with(&[&["9", "--coordinates", "Z"], &ends[..], &["z.csv"]].concat());
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let (rz, z) = (read("rz.csv"), read("z.csv"));
    assert_eq!(column(&rz, "z"), column(&z, "z"));
    // The packing fills the lower two thirds on the axis, too.
    let both = column(&rz, "density")
        .into_iter()
        .zip(column(&z, "density"));
    let in_packing = |on_axis: f64, mean: f64| (0.6..1.7).contains(&(on_axis / mean));
    for (on_axis, mean) in both {
        let fits = if mean > 500.0 {
            in_packing(on_axis, mean)
        } else {
            on_axis < 500.0
        };
        assert!(fits, "{on_axis} {mean}");
    }
}

#[test]
fn one_frame_has_no_displacements() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    let words = [
        "--density",
        "2500",
        "--coordinates",
        "O",
        "--fields",
        "displacement",
    ];
    let words = [&[input.to_str().unwrap()][..], &words, &["-o", "a.csv"]].concat();
    let output = run(&words, folder.path());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("displacements are zero"), "{said}");
}

#[test]
fn materials_and_no_contacts() {
    let folder = TempDir::new().unwrap();
    fs::copy(data("dense2k.data.gz"), folder.path().join("alone.data.gz")).unwrap();
    let output = run(
        &words("alone.data.gz --density 2500 --coordinates O --by-material"),
        folder.path(),
    );
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.success() && said.contains("fields of contacts are left out"),
        "{said}"
    );
    let table = fs::read_to_string(folder.path().join("alone.fields.csv")).unwrap();
    assert_eq!(
        column(&table, "density"),
        column(&table, "material_0.density")
    );
    assert!(!table.contains("contact_stress"));
    bad(
        &words("alone.data.gz --density 2500 --fields stress -o b.csv"),
        folder.path(),
        "alone.fstat: there is no such file",
    );
}

#[test]
fn mistakes_are_reported_with_a_way_out() {
    let folder = TempDir::new().unwrap();
    let input = data("dense2k.data.gz");
    let input = input.to_str().unwrap();
    let with = |line: &'static str| {
        let input = [input, "--density", "2500"];
        [&input[..], &words(line)].concat()
    };
    for (line, expected) in [
        (
            "--fields densty",
            "there is no field densty\nhelp: did you mean density? There are standard",
        ),
        ("--fields couple_stress", "no torques"),
        ("--coordinates YX", "expected O, X, Y"),
        (
            "--coordinates Z --grid 2x3",
            "2 numbers for the coordinates Z",
        ),
        (
            "--grid 0",
            "expected numbers of cells, each from 1 to 1000000,",
        ),
        ("--grid 1e8", "each from 1 to 1000000,"),
        ("--grid 100000000", "each from 1 to 1000000,"),
        ("--grid 2x2x2 --spacing 0.1", "one of them"),
        ("--spacing 1e-6", "a larger --spacing"),
        (
            "--coordinates Z --limits x=0..1",
            "x is not among the coordinates",
        ),
        (
            "--points nothing.csv",
            "nothing.csv: the file cannot be read",
        ),
        ("--width 0", "expected a positive length"),
        (
            "--kernel lucy --cutoff 3",
            "the kernel lucy ends at its width",
        ),
        (
            "--kernel heaviside --fields shear_rate",
            "has a jump and no gradient",
        ),
        ("--mirror w", "expected faces"),
        (
            "--coordinates Z --mirror -x",
            "means over x, along which there is nothing to mirror",
        ),
        (
            "--mirror -z,+z --width 1e5 --spacing 0.01",
            "mirror images of each particle",
        ),
        (
            "--grid 20000x20000x10 --fields density",
            "of memory; this machine has",
        ),
        ("--smooth 1,1e-9", "the step must be at least"),
        ("--frames 7", "no frame is selected"),
        (
            "--from 1",
            "no frame is selected, or the input has none\nhelp: its frames are from t = ",
        ),
        ("--follow", "only the Arrow frames"),
        (
            "-o a.txt",
            "must end in .csv, .parquet, .stat, .vti, .svg or .png",
        ),
        ("--coordinates R -o a.vti", "on a grid of x, y, z"),
        ("--scan 1d..2d/3 -o a.stat", "writes a table"),
        ("--material 5 --fixed 1..1", "is empty"),
    ] {
        bad(&with(line), folder.path(), expected);
    }
    // The requested name, not the temporary one of the unfinished file.
    let output = run(&with("--coordinates O -o nowhere/b.csv"), folder.path());
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(
        errors.contains("nowhere/b.csv: the file cannot be written"),
        "{errors}"
    );
    bad(&[input], folder.path(), "no masses");
    bad(
        &["nothing"],
        folder.path(),
        "there is no such file or folder",
    );
    // A file that exists is kept.
    fs::write(folder.path().join("a.csv"), "mine").unwrap();
    let kept = with("--coordinates O -o a.csv");
    bad(&kept, folder.path(), "--force replaces it");
    assert_eq!(
        fs::read_to_string(folder.path().join("a.csv")).unwrap(),
        "mine"
    );
    good(&with("--coordinates O -o a.csv --force"), folder.path());
    let names: Vec<String> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(names, ["a.csv"], "nothing is left behind");
}

/// A run of one particle, as far as it has come.
struct Growing {
    writer: ParticleWriter,
    step: u64,
}

impl Growing {
    fn begin(folder: &Path) -> Self {
        let header = FramesHeader {
            materials: vec!["glass".to_owned()],
            domain: Some((DVec3::ZERO, DVec3::ONE)),
            dimensions: Some(3),
            ..FramesHeader::default()
        };
        let path = folder.join("a.particles.arrow");
        let writer = ParticleWriter::create(path, &header, &ParticleColumns::default());
        Self {
            writer: writer.unwrap(),
            step: 0,
        }
    }

    /// One frame more: at the times 0, 1, 2 ... s.
    fn go_on(&mut self) {
        let frame = ParticleFrame {
            time: self.step as f64,
            step: self.step,
            id: vec![0],
            material: vec![0],
            flags: vec![0],
            mass: vec![1.0 + self.step as f64],
            volume: vec![0.1],
            radius: vec![0.1],
            position: vec![DVec3::splat(0.5)],
            velocity: vec![DVec3::ZERO],
            ..ParticleFrame::default()
        };
        self.writer.append(frame).unwrap();
        self.step += 1;
    }
}

#[test]
fn a_run_is_followed_from_a_time_that_it_has_not_reached() {
    let folder = TempDir::new().unwrap();
    let mut growing = Growing::begin(folder.path());
    growing.go_on();
    let words = [".", "--follow", "--from", "2", "--coordinates", "O"];
    let child = Command::new(env!("CARGO_BIN_EXE_mercury-cg"))
        .args(words)
        .args(["--fields", "density", "--quiet", "-o", "f.csv"])
        .current_dir(folder.path())
        .stderr(std::process::Stdio::piped())
        .spawn();
    let mut child = child.unwrap();
    // Long enough for a program without a wait limit to give up.
    for _ in 0..20 {
        std::thread::sleep(std::time::Duration::from_millis(20));
        assert!(child.try_wait().unwrap().is_none(), "it did not wait");
    }
    for _ in 1..5 {
        growing.go_on();
    }
    drop(growing);
    fs::write(folder.path().join("summary.json"), "{}").unwrap();
    let output = child.wait_with_output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && errors.is_empty(), "{errors}");
    let table = fs::read_to_string(folder.path().join("f.csv")).unwrap();
    assert_eq!(column(&table, "time"), [2.0, 3.0, 4.0]);
    assert_eq!(column(&table, "density"), [3.0, 4.0, 5.0]);
}

#[test]
fn help_lists_every_field() {
    let folder = TempDir::new().unwrap();
    let listed = good(&["--list-fields"], folder.path());
    assert_eq!(listed.lines().count(), mercury_cg::fields::FIELDS.len());
    assert!(listed.contains("compression positive"));
    assert!(good(&["--help"], folder.path()).contains("--coordinates"));
    assert!(good(&["--completions", "bash"], folder.path()).contains("mercury-cg"));
}
