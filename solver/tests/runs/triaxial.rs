//! `scenes/triaxial.toml` in small: three servos at once hold their pressures, and the stress inside the sample, as the code of mercury-cg
//! finds it from the contacts, is that of the plates' loads.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use mercury_common::formats::table_head;

/// Edge of the box, m.
const EDGE: f64 = 0.013;
/// Pa.
const PRESSURE: f64 = 2e4;

/// The rows of a table with a header, by the names of the columns; comments are left out.
fn table(text: &str) -> Vec<HashMap<String, String>> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
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

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap()
}

#[test]
fn three_axes_are_pressed_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/triaxial.toml");
    let run = folder.path().join("run");
    let mut command = Command::new(env!("CARGO_BIN_EXE_mercury-solve"));
    command.arg(scene).arg("--output").arg(&run).arg("--quiet");
    for set in [
        "time.end=0.16".to_owned(),
        "time.step=4e-6".to_owned(),
        format!("domain.max=[{EDGE}, {EDGE}, {EDGE}]"),
        format!("walls.right.point=[{EDGE}, 0, 0]"),
        format!("walls.back.point=[0, {EDGE}, 0]"),
        format!("walls.top.point=[0, 0, {EDGE}]"),
        format!("insertions.sample.region.max=[{EDGE}, {EDGE}, {EDGE}]"),
        "insertions.sample.total.number=100".to_owned(),
        "output.pictures=false".to_owned(),
    ] {
        command.args(["--set", &set]);
    }
    let output = command.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let summary = fs::read_to_string(run.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    // Every servo was within 5 % of its target when its time was over: otherwise there would be a warning.
    assert_eq!(summary["warnings"].to_string(), "[]");

    let walls = table(&fs::read_to_string(run.join("triaxial.walls.csv")).unwrap());
    let fields = table(&fs::read_to_string(run.join("triaxial.fields.mean.csv")).unwrap());
    // Loads (N) on the plates and on those across, and the edges of the sample (m), by axis.
    let state = |time: f64| {
        let at = |name: &str| {
            let mut rows = walls.iter();
            let is_it = |row: &&HashMap<String, String>| {
                row["name"] == name && (number(row, "time") - time).abs() < 1e-6
            };
            rows.find(is_it).unwrap()
        };
        [
            ("right", "fixed.-x", "x"),
            ("back", "fixed.-y", "y"),
            ("top", "fixed.-z", "z"),
        ]
        .map(|(plate, across, axis)| {
            let force = format!("f{axis}");
            let loads = [number(at(plate), &force), -number(at(across), &force)];
            (loads, number(at(plate), axis))
        })
    };
    let stresses = |time: f64| {
        let axes = state(time);
        let volume: f64 = axes.iter().map(|(_, edge)| edge).product();
        let mut inside = fields.iter();
        let inside = inside.find(|row| (number(row, "time") - time).abs() < 1e-6);
        let inside = inside.unwrap();
        let share = EDGE * EDGE * EDGE / volume;
        let axis = |k: usize| {
            let ([plate, across], edge) = axes[k];
            let column = [
                "contact_stress_xx",
                "contact_stress_yy",
                "contact_stress_zz",
            ][k];
            let mean = number(inside, column);
            (plate * edge / volume, across * edge / volume, mean * share)
        };
        [axis(0), axis(1), axis(2)]
    };

    // Isotropic: the plates are at rest, and all three axes are within 1 % of the pressure.
    for (plate, across, mean) in stresses(0.1) {
        assert!((plate / PRESSURE - 1.0).abs() < 0.01, "{plate}");
        assert!((across / PRESSURE - 1.0).abs() < 0.01, "{across}");
        // The sum of forces times branches over all contacts is that of the loads times the places of the plates, but for what
        // accelerates and for half of the overlaps at the plates: 1 % is well above both.
        assert!((mean / PRESSURE - 1.0).abs() < 0.01, "{mean}");
    }
    // Sheared: the plates at the sides give way at less than 1 mm/s and hold their pressure within 5 %, while that along z has grown.
    let [x, y, z] = stresses(0.16);
    for side in [x, y] {
        assert!((side.0 / PRESSURE - 1.0).abs() < 0.05, "{side:?}");
    }
    assert!(z.0 > 1.1 * PRESSURE, "{z:?}");
    for (plate, _, mean) in [x, y, z] {
        // It is not at rest now: the loads across differ by what accelerates, a few inertial numbers of 1e-3.
        assert!((mean / plate - 1.0).abs() < 0.03, "{mean} and {plate}");
    }
}
