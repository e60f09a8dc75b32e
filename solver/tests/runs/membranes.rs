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

/// The closing report and `summary.json` give the last row of each sheet.
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

/// A sheet of 3 mm triangles that falls from `height` (m) onto `walls`, for `end` (s).
fn falling(walls: &str, keys: &str, (height, end): (f64, f64)) -> String {
    let head = HEAD.replace("end = 0.02", &format!("end = {end:?}"));
    format!(
        "gravity = [0.0, 0.0, -9.81]\n{head}{walls}\n[[membranes]]\nname = \"sheet\"\nshape = \"rectangle\"\ncorner = [-0.01, -0.01, {height:?}]\nalong = [0.02, 0.0, 0.0]\nacross = [0.0, 0.02, 0.0]\nedge = 3e-3\nmaterial = \"rubber\"\nthickness = 3e-4\nyoungs_modulus = 1e6\nelasticity = \"continuum\"\ndamping_ratio = 0.2\n{keys}\n"
    )
}

const FLOOR: &str = "v -0.15 -0.15 0\nv 0.15 -0.15 0\nv 0.15 0.15 0\nv -0.15 0.15 0\nf 1 2 3 4\n";

/// Lowest place of a vertex at any time, m.
fn lowest(folder: &Path) -> f64 {
    let file = folder.join("run/run.membranes.arrow");
    let reader = mercury_common::frames::MembraneReader::open(&file).unwrap();
    let frames = 0..reader.frames().len();
    let heights = frames.flat_map(|k| reader.frame(k).unwrap().position);
    heights.map(|place| place.z).fold(f64::INFINITY, f64::min)
}

/// Vertices on a mesh and on a disc: held where their contacts are stiff enough; else the guard stops the run, or counts, by the name of the sheet, and the walls
/// hold them nevertheless.
#[test]
fn meshes_and_discs_hold_sheets_or_the_guard_says_so() {
    for shape in [
        "shape = \"mesh\"\nfile = \"floor.obj\"",
        "shape = \"disc\"\naxis = [0.0, 0.0, 1.0]\norigin = [0.0, 0.0, 0.0]\nradius = 0.1",
    ] {
        let wall = format!("[[walls]]\nname = \"floor\"\nmaterial = \"rubber\"\n{shape}");
        // It arrives at 1 m/s after 0.1 s.
        let scene = falling(&wall, "walls = true", (0.0515, 0.12));
        let folder = folder_with("run.toml", &scene);
        fs::write(folder.path().join("floor.obj"), FLOOR).unwrap();
        let output = solve(folder.path(), &["run.toml", "--quiet"]);
        let said = errors(&output);
        assert_eq!(code(&output), Some(1), "{said}");
        let words = ["membranes.sheet: vertex ", "wall `floor`", "help: "];
        assert!(words.iter().all(|word| said.contains(word)), "{said}");

        let set = ["--set", "guard.policy=\"warn\"", "--force"];
        let output = solve(
            folder.path(),
            &[&["run.toml", "--quiet"], &set[..]].concat(),
        );
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
        let summary = fs::read_to_string(folder.path().join("run/summary.json")).unwrap();
        assert!(summary.contains("membranes.sheet: vertex "), "{summary}");
        // Four times the thickness are the deepest at which it is held.
        assert!(lowest(folder.path()) > -1.2e-3, "{}", lowest(folder.path()));
        let last = membranes_in(folder.path()).pop().unwrap();
        assert!(number(&last, "z") > 0.0, "{last:?}");

        // A vertex of 2.6 mg, v = 1 m/s and m v^2/2 = 8/15 E* sqrt(R) d^(5/2) with E* = 6e8 Pa, R = 0.15 mm: d = 0.07 R.
        let stiff = scene
            .replace(
                "youngs_modulus = 1e6, poisson",
                "youngs_modulus = 1e9, poisson",
            )
            .replace("step = 1e-5", "step = 2e-6");
        fs::write(folder.path().join("run.toml"), &stiff).unwrap();
        let output = solve(folder.path(), &["run.toml", "--quiet", "--force"]);
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
        assert!(
            lowest(folder.path()) > 0.5 * 1.5e-4,
            "{}",
            lowest(folder.path())
        );
    }
}

fn membranes_in(folder: &Path) -> Vec<Row> {
    table(&folder.join("run/run.membranes.csv"))
}

/// A step in which a vertex goes by ten times its radius leads through a wall: that is seen, too.
#[test]
fn vertices_that_are_fast_go_through_no_wall_in_silence() {
    let wall = "[[walls]]\nname = \"floor\"\nmaterial = \"rubber\"\nshape = \"disc\"\naxis = [0.0, 0.0, 1.0]\norigin = [0.0, 0.0, 0.0]\nradius = 0.1";
    let scene = falling(wall, "walls = true", (0.0037, 0.01))
        .replace("step = 1e-5", "step = 2e-5")
        .replace(
            "gravity = [0.0, 0.0, -9.81]",
            "gravity = [0.0, 0.0, -1.5e6]",
        );
    let folder = folder_with("run.toml", &scene);
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    let said = errors(&output);
    assert_eq!(code(&output), Some(1), "{said}");
    assert!(said.contains("membranes.sheet: vertex "), "{said}");
    assert!(said.contains("has gone through wall `floor`"), "{said}");
}

/// Sheets that leave the domain stop the run, or are counted, by name.
#[test]
fn a_sheet_that_leaves_the_domain_does_not_go_in_silence() {
    // It falls by 0.2 m in 0.2 s.
    let folder = folder_with("run.toml", &falling("", "", (0.0, 0.21)));
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    let said = errors(&output);
    assert_eq!(code(&output), Some(1), "{said}");
    assert!(said.contains("membranes.sheet: vertex "), "{said}");
    assert!(said.contains("has left the domain"), "{said}");
    let set = ["--set", "guard.policy=\"warn\"", "--force"];
    let output = solve(
        folder.path(),
        &[&["run.toml", "--quiet"], &set[..]].concat(),
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let summary = fs::read_to_string(folder.path().join("run/summary.json")).unwrap();
    assert!(summary.contains("has left the domain by"), "{summary}");
}

/// The guard names the sheet that a particle goes through, not a wall by a number.
#[test]
fn the_guard_names_sheets() {
    let ball = "[[walls]]\nname = \"floor\"\nmaterial = \"rubber\"\nshape = \"plane\"\npoint = [0.0, 0.0, -0.1]\nnormal = [0.0, 0.0, 1.0]\n\
        [[particles]]\nmaterial = \"rubber\"\nradius = 5e-4\nposition = [0.001, 0.001, 0.003]\nvelocity = [0.0, 0.0, -20.0]";
    let scene = falling(ball, "fixed = \"rim\"", (0.0, 0.01));
    let folder = folder_with("run.toml", &scene);
    let output = solve(folder.path(), &["run.toml", "--quiet"]);
    let said = errors(&output);
    assert_eq!(code(&output), Some(1), "{said}");
    assert!(said.contains("membrane `sheet`"), "{said}");
    // The plan's line about the floor.
    let output = solve(folder.path(), &["run.toml", "--check"]);
    let plan = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(
        plan.contains("membranes.sheet: it does not touch walls"),
        "{plan}"
    );
}

/// A hold that begins away from its wall, and one whose wall is removed, are named.
#[test]
fn holds_away_from_their_walls_are_named() {
    let scene = |height: f64, until: &str| {
        let walls = format!(
            "[[walls]]\nname = \"lid\"\nmaterial = \"rubber\"\nshape = \"disc\"\naxis = [0.0, 0.0, -1.0]\norigin = [0.0, 0.0, {height:?}]\nradius = 0.02\nuntil = 0.015"
        );
        let hold = format!(
            "holds = [{{ name = \"top\", on = \"rim\", wall = \"lid\", from = 5e-3{until} }}]"
        );
        falling(&walls, &hold, (0.0, 0.02)).replace("gravity = [0.0, 0.0, -9.81]", "")
    };
    // A little more, and a little less, than an edge away.
    for (height, until, is_far, is_left) in [
        (0.0035, "", true, true),
        (0.0025, "", false, true),
        (0.0025, ", until = 0.015", false, false),
    ] {
        let folder = folder_with("run.toml", &scene(height, until));
        let output = solve(folder.path(), &["run.toml", "--quiet"]);
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
        let log = fs::read_to_string(folder.path().join("run/run.log")).unwrap();
        let far = "the hold `top` began at 0.005 s, when its vertex";
        assert_eq!(log.contains(far), is_far, "{height}: {log}");
        assert_eq!(
            log.contains("0.0035 m away from wall `lid`"),
            is_far,
            "{log}"
        );
        let left = "the hold `top` ends at 0.015 s, when its wall `lid` is removed";
        assert_eq!(log.contains(left), is_left, "{until}: {log}");
    }
}
