//! Elastic sheets in whole runs: their files, laws of pressure, walls that hold them, the guard.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use mercury_common::formats::table_head;
use mercury_common::frames::MembraneReader;

use crate::common::{code, errors, folder_with, said, solve};

const HEAD: &str = r#"
[time]
end = 0.02
step = 1e-5
[domain]
min = [-0.2, -0.2, -0.2]
max = [0.2, 0.2, 0.2]
[materials.rubber]
density = 1000.0
normal = { law = "hertz", youngs_modulus = 1e6, poisson_ratio = 0.4, restitution = 0.3 }
[output]
interval = 2e-3
pictures = false
"#;

fn balloon(pressure: &str) -> String {
    format!(
        "{HEAD}[[membranes]]\nname = \"balloon\"\nshape = \"sphere\"\norigin = [0.0, 0.0, 0.0]\nradius = 0.05\nedge = 0.02\nmaterial = \"rubber\"\nthickness = 3e-4\nyoungs_modulus = 1.25e6\ndamping_ratio = 0.2\npressure = {pressure}\n"
    )
}

type Row = HashMap<String, String>;

fn table(path: &Path) -> Vec<Row> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap().split(',');
    let names: Vec<&str> = head.map(table_head::name).collect();
    let row = |line: &str| {
        let cells = line.split(',').map(str::to_owned);
        names
            .iter()
            .map(|name| (*name).to_owned())
            .zip(cells)
            .collect()
    };
    lines.map(row).collect()
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap()
}

fn membranes_of(scene: &str) -> Vec<Row> {
    let folder = folder_with("run.toml", scene);
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    table(&folder.path().join("run/run.membranes.csv"))
}

/// The pressure of each row is that of its volume to 1e-6 Pa.
#[test]
fn gas_and_fluid_follow_their_laws() {
    let rows = membranes_of(&balloon("{ gas = 1.02e5, ambient = 1e5, exponent = 1.4 }"));
    let first = number(&rows[0], "volume");
    for row in &rows {
        let expected = 1.02e5 * (first / number(row, "volume")).powf(1.4) - 1e5;
        assert!((number(row, "pressure") - expected).abs() < 1e-6, "{row:?}");
    }
    // It has blown the sheet up.
    let last = rows.last().unwrap();
    assert!(number(last, "volume") > 1.001 * first);
    let rows = membranes_of(&balloon(
        "{ fluid = 2e3, bulk_modulus = 1e6, ambient = 0.0 }",
    ));
    for row in &rows {
        let expected = 2e3 + 1e6 * (first - number(row, "volume")) / first;
        assert!((number(row, "pressure") - expected).abs() < 1e-6, "{row:?}");
    }
}

/// At each time the works and energies of a sheet that only the pressure moves close, as nothing else gives or takes.
#[test]
fn works_and_energies_close() {
    let rows = membranes_of(&balloon("[[0.0, 0.0], [0.01, 2000.0]]"));
    let largest = rows
        .iter()
        .map(|row| number(row, "pressure_work"))
        .fold(0.0, f64::max);
    assert!(largest > 0.0);
    for row in &rows {
        let stored = number(row, "kinetic") + number(row, "stretching") + number(row, "bending");
        let gap = number(row, "pressure_work") - number(row, "dissipated") - stored;
        assert!(gap.abs() < 5e-3 * largest, "{gap} of {largest}");
    }
}

/// A sleeve whose rims two walls hold, one of which goes away from the other: what it pulls is in the forces of the walls.
#[test]
fn walls_feel_the_sheets_that_they_hold() {
    let scene = format!(
        r#"{HEAD}
[[walls]]
name = "base"
shape = "plane"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
material = "rubber"
[[walls]]
name = "lid"
shape = "disc"
axis = [0.0, 0.0, -1.0]
origin = [0.0, 0.0, 0.05]
radius = 0.02
material = "rubber"
motion = [{{ kind = "translation", velocity = [0.0, 0.0, 0.1] }}]
[[membranes]]
name = "sleeve"
shape = "cylinder"
axis = [0.0, 0.0, 1.0]
origin = [0.0, 0.0, 0.0]
radius = 0.02
along = [0.0, 0.05]
edge = 0.01
material = "rubber"
thickness = 3e-4
youngs_modulus = 1.25e6
damping_ratio = 0.3
holds = [{{ name = "low", on = "rim", region = {{ shape = "half-space", point = [0.0, 0.0, 0.01], normal = [0.0, 0.0, -1.0] }}, wall = "base" }},
         {{ name = "high", on = "rim", region = {{ shape = "half-space", point = [0.0, 0.0, 0.04], normal = [0.0, 0.0, 1.0] }}, wall = "lid" }}]
"#
    );
    let folder = folder_with("run.toml", &scene);
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let walls = table(&folder.path().join("run/run.walls.csv"));
    let holds = table(&folder.path().join("run/run.holds.csv"));
    let sheets = table(&folder.path().join("run/run.membranes.csv"));
    let pull = |wall: &str| number(walls.iter().rfind(|row| row["name"] == wall).unwrap(), "fz");
    let load = |hold: &str| number(holds.iter().rfind(|row| row["name"] == hold).unwrap(), "fz");
    assert_eq!(pull("lid"), load("high"));
    assert_eq!(pull("base"), load("low"));
    // It pulls the lid down and the base up, with about the tension around.
    assert!(pull("lid") < 0.0 && pull("base") > 0.0);
    let tension = number(sheets.last().unwrap(), "nzz") * std::f64::consts::TAU * 0.02;
    assert!(
        (pull("base") / tension - 1.0).abs() < 0.2,
        "{} {tension}",
        pull("base")
    );
    // The stretch is that of the lid: 2 mm of 50 mm.
    assert!((number(sheets.last().unwrap(), "max_stretch") - 1.04).abs() < 0.02);
    // Work of the holds is what is stored and lost.
    let last = sheets.last().unwrap();
    let stored = number(last, "kinetic") + number(last, "stretching");
    let work = number(last, "hold_work");
    assert!((work - stored - number(last, "dissipated")).abs() < 5e-3 * work);
}

#[test]
fn what_is_stretched_too_far_stops_the_run_by_its_name() {
    let folder = folder_with("run.toml", &balloon("2e5"));
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    assert_eq!(code(&output), Some(1));
    let said = errors(&output);
    assert!(said.contains("membranes.balloon"), "{said}");
    assert!(
        said.contains("help: the time step is too large for the sheet"),
        "{said}"
    );
}

/// With threads and without the same bytes, in a sheet that is large enough to be shared among them.
#[test]
fn threads_change_no_byte() {
    let scene = balloon("[[0.0, 0.0], [1e-3, 2000.0]]")
        .replace("edge = 0.02", "edge = 2.5e-3")
        .replace("end = 0.02", "end = 2e-3")
        .replace("step = 1e-5", "step = 5e-6");
    let folder = folder_with("run.toml", &scene);
    let mut all = Vec::new();
    for threads in ["1", "2"] {
        let arguments = [
            "run.toml",
            "--quiet",
            "--threads",
            threads,
            "--fixed-threads",
            "--output",
            threads,
        ];
        let output = solve(folder.path(), &arguments);
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
        let of = |name: &str| fs::read(folder.path().join(threads).join(name)).unwrap();
        all.push([
            of("run.membranes.csv"),
            of("run.membranes.arrow"),
            of("run.membrane_triangles.arrow"),
        ]);
    }
    assert_eq!(all[0], all[1]);
}

/// A strip of rubber, 100 x 20 x 0.3 mm, that a servo pulls by 0.05 N at the wall that holds its end: it comes to rest at the stretch of that force.
const PULLED: &str = r#"
[[walls]]
name = "grip"
shape = "disc"
axis = [1.0, 0.0, 0.0]
origin = [0.15, 0.0, 0.1]
radius = 0.01
material = "rubber"
motion = [{ kind = "servo", axis = [1.0, 0.0, 0.0], force = 0.05, max_speed = 0.2 }]
[[membranes]]
name = "strip"
shape = "rectangle"
corner = [0.0, 0.0, 0.0]
along = [0.1, 0.0, 0.0]
across = [0.0, 0.02, 0.0]
edge = 1e-2
material = "rubber"
thickness = 3e-4
youngs_modulus = 1e6
elasticity = "continuum"
poisson_ratio = 0.0
damping_ratio = 0.3
drag = 50.0
[[membranes.holds]]
name = "left"
region = { shape = "half-space", point = [1e-6, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] }
velocity = [0.0, "free", 0.0]
[[membranes.holds]]
name = "right"
region = { shape = "half-space", point = [0.099999, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }
wall = "grip"
"#;

/// The strip carries E t w (l^3 - l)/2 at the stretch l, of uniform strain without lateral contraction.
#[test]
fn a_servo_on_a_wall_that_a_sheet_alone_loads_settles() {
    let scene = format!("{HEAD}{PULLED}")
        .replace("end = 0.02", "end = 0.5")
        .replace("step = 1e-5", "step = \"auto\"")
        .replace("interval = 2e-3", "interval = 0.02");
    let folder = folder_with("run.toml", &scene);
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let rows = table(&folder.path().join("run/run.walls.csv"));
    let late = rows.iter().filter(|row| number(row, "time") > 0.29);
    let mut count = 0;
    for row in late {
        // Its coefficient over the stiffness of the strip is some 30 ms: exp(-0.3/0.03) is left.
        let force = -number(row, "fx");
        assert!((force / 0.05 - 1.0).abs() < 1e-3, "{row:?}");
        assert!(number(row, "vx").abs() < 1e-4, "{row:?}");
        count += 1;
    }
    assert!(count > 9);
    let last = rows.last().unwrap();
    let stretch = 1.0 + (number(last, "x") - 0.15) / 0.1;
    let carried = 1e6 * 3e-4 * 0.02 * (stretch * stretch * stretch - stretch) / 2.0;
    assert!(
        (carried / 0.05 - 1.0).abs() < 1e-4,
        "{carried} N at {stretch}"
    );
}

/// The closing report and `summary.json` say of each sheet what its last row does.
#[test]
fn the_summary_has_the_sheets() {
    let folder = folder_with("run.toml", &balloon("[[0.0, 0.0], [0.01, 2000.0]]"));
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let rows = table(&folder.path().join("run/run.membranes.csv"));
    let last = rows.last().unwrap();
    let text = fs::read_to_string(folder.path().join("run/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let sheet = &summary["membranes"][0];
    assert_eq!(sheet["name"], "balloon");
    for key in ["area", "volume", "pressure", "min_stretch", "max_stretch"] {
        assert_eq!(sheet[key].as_f64(), Some(number(last, key)), "{key}");
    }
    let log = fs::read_to_string(folder.path().join("run/run.log")).unwrap();
    assert!(log.contains("  membrane   balloon: area "), "{log}");
}

/// Vertices have the numbers of the lines `v` of the file; those of no triangle are left out.
#[test]
fn vertices_keep_the_order_of_the_file() {
    let obj = "v 0.02 0.02 0\nv 0 0 0\nv 9 9 9\nv 0 0.02 0\nv 0.02 0 0\nf 2 5 1\nf 2 1 4\n";
    let scene = format!("{HEAD}[[membranes]]\nname = \"sheet\"\nfile = \"sheet.obj\"\nmaterial = \"rubber\"\nthickness = 3e-4\nyoungs_modulus = 1e6\n")
        .replace("end = 0.02", "end = 1e-5");
    let folder = folder_with("run.toml", &scene);
    fs::write(folder.path().join("sheet.obj"), obj).unwrap();
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let reader = MembraneReader::open(folder.path().join("run/run.membranes.arrow")).unwrap();
    let frame = reader.frame(0).unwrap();
    let places: Vec<[f64; 2]> = frame.position.iter().map(|x| [x.x, x.y]).collect();
    assert_eq!(places, [[0.02, 0.02], [0.0, 0.0], [0.0, 0.02], [0.02, 0.0]]);
}

#[test]
fn the_help_names_the_lanes_that_there_are() {
    let folder = tempfile::tempdir().unwrap();
    let help = said(&solve(folder.path(), &["--help"]));
    let line = help
        .lines()
        .find(|line| line.contains("side by side"))
        .unwrap();
    assert!(line.contains("1, 2 or 4"), "{line}");
}
