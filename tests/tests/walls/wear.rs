//! Walls that wear, from the scene to the files: what is written agrees with itself, runs end where they should, and the bytes do not depend on threads and stops.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use mercury_common::formats::table_head;
use mercury_common::frames::{WallReader, WearReader, WearTriangleReader};
use mercury_common::surfaces::Surface;
use mercury_solver::plan::{Plan, plan, read_scene};
use mercury_solver::run::{
    Checkpoints, Ending, Report, Run, RunOptions, checkpoint, run, run_from,
};

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenes/wear")
        .join(name)
}

fn planned(name: &str, changes: &[&str]) -> Plan {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let scene = read_scene(&scene(name), &changes).unwrap_or_else(|errors| panic!("{errors}"));
    plan(&scene).unwrap_or_else(|errors| panic!("{errors}"))
}

fn options(folder: &Path, threads: usize) -> RunOptions {
    RunOptions {
        folder: folder.to_owned(),
        threads,
        checkpoints: Some(Checkpoints::default()),
        ..RunOptions::default()
    }
}

fn run_in(folder: &Path, plan: Plan) -> Report {
    run(plan, &options(folder, 1), &mut |_| ()).unwrap()
}

fn rows(folder: &Path, name: &str) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap().split(',');
    let head: Vec<&str> = head.map(table_head::name).collect();
    let row = |line: &str| {
        let cells = line.split(',').map(str::to_owned);
        head.iter()
            .map(|&name| name.to_owned())
            .zip(cells)
            .collect()
    };
    lines.map(row).collect()
}

const SHORT: [&str; 4] = [
    "time.end=0.1",
    "time.step=5e-5",
    "output.pictures=false",
    "output.interval=0.02",
];

#[test]
fn files_agree_with_each_other_and_with_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    let report = run_in(folder.path(), planned("wear-plate.toml", &SHORT));
    let rows = rows(folder.path(), "wear-plate.wear.csv");
    assert_eq!(rows.len(), 6);
    let number = |row: &BTreeMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
    let last = rows.last().unwrap();
    assert_eq!(last["name"], "plate");
    let [summary] = &report.summary.wear[..] else {
        panic!("{:?}", report.summary.wear)
    };
    assert_eq!(number(last, "owed"), summary.owed);
    assert_eq!(number(last, "removed"), summary.removed);
    assert_eq!(number(last, "max_depth"), summary.max_depth);
    assert_eq!(summary.blocked, 0);
    for row in &rows {
        let difference = number(row, "owed") - number(row, "removed") - number(row, "pending");
        assert!(difference.abs() < 1e-12 * summary.owed, "{row:?}");
        assert_eq!(number(row, "front"), number(row, "owed"));
    }
    // Before the end something waits, at the end nothing.
    assert!(number(&rows[3], "pending") > 0.0);
    assert!(number(last, "pending").abs() < 1e-12 * summary.owed);

    let read = |kind: &str| folder.path().join(format!("wear-plate.{kind}.arrow"));
    let vertices = WearReader::open(read("wear")).unwrap();
    let triangles = WearTriangleReader::open(read("wear_triangles")).unwrap();
    let walls = WallReader::open(read("walls")).unwrap();
    let Surface::Mesh(mesh) = &walls.surfaces()[0] else {
        panic!("a mesh")
    };
    assert_eq!(vertices.frames().len(), 6);
    for (k, row) in rows.iter().enumerate() {
        let (vertices, triangles) = (vertices.frame(k).unwrap(), triangles.frame(k).unwrap());
        let owed: f64 = vertices.owed.iter().sum();
        assert!((owed - number(row, "pending")).abs() < 1e-12 * summary.owed);
        let sums = [&triangles.owed, &triangles.removed].map(|all| all.iter().sum::<f64>());
        assert!((sums[0] - number(row, "owed")).abs() < 1e-12 * summary.owed);
        assert!((sums[1] - number(row, "removed")).abs() < 1e-12 * summary.owed);
        let deepest = vertices.depth.iter().copied().fold(0.0, f64::max);
        assert_eq!(deepest, number(row, "max_depth"));
        for (at, &vertex) in vertices.vertex.iter().enumerate() {
            // Numbers are those of the first appearance in the file of surfaces.
            assert_eq!(mesh.vertices[vertex as usize], vertices.first[at]);
        }
        let (worn, depths) = vertices.worn(0, mesh);
        let moved = worn
            .vertices
            .iter()
            .zip(&mesh.vertices)
            .filter(|(new, old)| new != old);
        let displaced = vertices
            .displacement
            .iter()
            .filter(|way| **way != DVec3::ZERO);
        assert_eq!(moved.count(), displaced.count());
        assert_eq!(depths.iter().copied().fold(0.0, f64::max), deepest);
    }
    let grid = std::fs::read(folder.path().join("vtk/wear-plate.walls.0005.vtu")).unwrap();
    let text = String::from_utf8_lossy(&grid);
    assert!(
        text.contains("Name=\"depth\""),
        "no depth in the files for ParaView"
    );
    let log = report.to_string();
    assert!(log.contains("  wear       plate: "), "{log}");
}

#[test]
fn a_run_ends_with_the_step_after_the_wall_is_worn() {
    // At what depth the scene is after a while.
    let folder = tempfile::tempdir().unwrap();
    let deep = run_in(folder.path(), planned("wear-plate.toml", &SHORT))
        .summary
        .wear[0]
        .max_depth;
    let depth = format!("walls.plate.wear.until_depth={}", 0.5 * deep);
    let mut changes = SHORT.to_vec();
    changes.push(&depth);
    let mut reports = Vec::new();
    for threads in [1, 2] {
        let folder = tempfile::tempdir().unwrap();
        let plan = planned("wear-plate.toml", &changes);
        let report = run(plan, &options(folder.path(), threads), &mut |_| ()).unwrap();
        assert_eq!(report.ending, Ending::Worn);
        assert!(
            report.to_string().contains("worn to until_depth"),
            "{report}"
        );
        let last = rows(folder.path(), "wear-plate.wear.csv").pop().unwrap();
        let reached: f64 = last["max_depth"].parse().unwrap();
        assert!(
            reached >= 0.5 * deep && reached < 0.51 * deep,
            "{reached} {deep}"
        );
        reports.push((report.summary.steps, last));
    }
    assert_eq!(reports[0], reports[1]);
    // In pieces it ends at the same step.
    let folder = tempfile::tempdir().unwrap();
    let mut pieces = Run::new(
        planned("wear-plate.toml", &changes),
        options(folder.path(), 1),
    )
    .unwrap();
    for k in 1..=400 {
        pieces
            .advance(f64::from(k) * 0.1 / 400.0, &mut |_| ())
            .unwrap();
    }
    assert_eq!(pieces.finish().unwrap().summary.steps, reports[0].0);
    // Of a wear map as well, whose surface stays.
    changes.push("walls.plate.wear.moves=false");
    let folder = tempfile::tempdir().unwrap();
    let report = run_in(folder.path(), planned("wear-plate.toml", &changes));
    assert_eq!(report.ending, Ending::Worn);
    assert_eq!(
        (report.summary.wear[0].removed, report.summary.wear[0].moves),
        (0.0, 0)
    );
}

fn bytes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let ends = [".data", ".ene", ".arrow", ".csv"];
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap());
    let named = entries.map(|entry| {
        (
            entry.file_name().to_string_lossy().into_owned(),
            entry.path(),
        )
    });
    let wanted = named.filter(|(name, _)| ends.iter().any(|end| name.ends_with(end)));
    wanted
        .map(|(name, path)| (name, std::fs::read(path).unwrap()))
        .collect()
}

#[test]
fn stops_and_threads_change_no_byte() {
    let changes = [
        "time.end=0.12",
        "output.pictures=false",
        "output.interval=0.01",
        "walls.bars.wear.acceleration=1e8",
        "insertions.feed.rate.number=1000.0",
    ];
    let whole = tempfile::tempdir().unwrap();
    run_in(whole.path(), planned("screen.toml", &changes));
    let expected = bytes(whole.path());
    assert!(expected.contains_key("screen.wear.arrow"));
    for (threads, stops) in [(2, vec![0.08]), (1, vec![0.06, 0.09, 0.0999])] {
        let folder = tempfile::tempdir().unwrap();
        let mut from = None;
        for stop in stops {
            let asked = Arc::new(AtomicBool::new(false));
            let options = RunOptions {
                stop: Arc::clone(&asked),
                ..options(folder.path(), threads)
            };
            let plan = planned("screen.toml", &changes);
            let mut run = match from.take() {
                None => Run::new(plan, options).unwrap(),
                Some(from) => Run::resume(plan, options, from).unwrap(),
            };
            run.advance(stop, &mut |_| ()).unwrap();
            run.finish().unwrap();
            from = checkpoint::newest(folder.path(), "screen")
                .unwrap()
                .map(|(found, _)| found);
            assert!(from.as_ref().is_some_and(|from| {
                from.snapshot
                    .sections()
                    .iter()
                    .any(|(name, _)| name == "wear")
            }));
        }
        let plan = planned("screen.toml", &changes);
        run_from(from, plan, &options(folder.path(), threads), &mut |_| ()).unwrap();
        let found = bytes(folder.path());
        for (name, bytes) in &expected {
            assert!(
                found.get(name) == Some(bytes),
                "{name} differs with {threads} threads"
            );
        }
    }
    let last = rows(whole.path(), "screen.wear.csv").pop().unwrap();
    assert!(last["moves"].parse::<u64>().unwrap() > 1, "{last:?}");
}

#[test]
fn doubtful_scenes_draw_warnings() {
    let warned = |changes: &[&str], words: &str| {
        let plan = planned("wear-plate.toml", changes);
        let warnings = plan.notes().warnings().join("\n");
        assert!(
            warnings.contains(words),
            "{changes:?}: {words:?} not in\n{warnings}"
        );
    };
    warned(
        &["walls.plate.wear.acceleration=1e6"],
        "times what `step` allows",
    );
    warned(
        &["walls.plate.wear.moves=false", "walls.plate.from=2.0"],
        "no particle can wear the wall",
    );
    warned(
        &[
            "gravity=[0, 0, 0]",
            "particles.slider.velocity=[0, 0, 0]",
            "walls.plate.wear.moves=false",
            "particles.slider.prescribed={ velocity = [0.0, 0.0, \"free\"] }",
        ],
        "no particle can wear the wall",
    );
    let plain = planned("wear-plate.toml", &[]);
    assert!(!plain.notes().warnings().join("\n").contains("wear"));
}
