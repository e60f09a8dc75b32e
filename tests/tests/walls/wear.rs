//! Walls that wear, from the scene to the files: what is written agrees with itself, runs end where they should, and the bytes do not depend on threads and stops.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use mercury_common::formats::table_head;
use mercury_common::frames::{WallReader, WearReader, WearTriangleReader};
use mercury_common::surfaces::Surface;
use mercury_engine::step::Engine;
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

/// A scene in a folder of its own, with a plate of squares of 6 mm (each of two triangles) at z = 0, every `turned`-th of whose triangles is turned over.
fn with_plate(scene: &str, turned: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut obj = String::new();
    const CELLS: usize = 10;
    for j in 0..=CELLS {
        for i in 0..=CELLS {
            let [x, y] = [i, j].map(|k| 6e-3 * (k as f64 - 5.0));
            obj += &format!("v {x} {y} 0\n");
        }
    }
    let mut count = 0;
    for j in 0..CELLS {
        for i in 0..CELLS {
            let a = 1 + i + (CELLS + 1) * j;
            let [b, c, d] = [a + 1, a + CELLS + 2, a + CELLS + 1];
            for [one, other, last] in [[a, b, c], [a, c, d]] {
                count += 1;
                let [other, last] = if count % turned == 0 {
                    [last, other]
                } else {
                    [other, last]
                };
                obj += &format!("f {one} {other} {last}\n");
            }
        }
    }
    std::fs::write(folder.path().join("p.obj"), obj).unwrap();
    std::fs::write(folder.path().join("bounce.toml"), scene).unwrap();
    folder
}

/// A ball that bounces off a plate at an angle.
fn bounce(laws: &str) -> String {
    format!(
        r#"gravity = [0.0, 0.0, -9.81]
[time]
end = 0.025
step = "auto"
[domain]
min = [-0.1, -0.1, -0.1]
max = [0.1, 0.1, 0.1]
[materials.a]
density = 2500.0
{laws}
[[walls]]
name = "plate"
material = "a"
shape = "mesh"
file = "p.obj"
wear = {{ law = "archard", coefficient = 1e-3, hardness = 1e6, acceleration = 1e-3, basis = "friction-work" }}
[[particles]]
material = "a"
radius = 0.005
position = [-0.02, 0.001, 0.0051]
velocity = [0.05, 0.0, -0.5]
angular_velocity = [0.0, 0.0, 0.0]
[output]
interval = 0.03
energy_budget = true
triangle_loads = true
pictures = false
"#
    )
}

/// Friction-work and the sum of `slip_power` over the energy in the audit of the same run, and the time step; `part` of the
/// automatic step.
fn friction_work(folder: &Path, part: f64) -> ([f64; 2], f64) {
    let planned = |changes: &[String]| {
        let scene = read_scene(&folder.join("bounce.toml"), changes);
        plan(&scene.unwrap_or_else(|errors| panic!("{errors}"))).unwrap()
    };
    let step = part * planned(&[]).physics().time_step;
    let plan = planned(&[format!("time.step={step}")]);
    let steps = plan.physics().steps;
    let mut engine = Engine::new(Arc::new(plan), 1).unwrap();
    engine.steps_at_once(steps, None).unwrap();
    let audit = engine.audit().losses.of("tangential");
    let owed = engine.wear().unwrap().walls[0].row().owed;
    let [loads, _] = engine.take_load_sums(true, false);
    let slip: f64 = loads.unwrap().loads.values().map(|load| load.slip).sum();
    // K a/H of the scene, 1/Pa.
    ([owed / 1e-12 / audit, slip / audit], step)
}

/// Friction work of a bounce is that of the energy audit, to second order in the step: with springs alone, with dashpots, and by
/// Hertz and Mindlin.
#[test]
fn friction_work_is_that_of_the_audit() {
    const SPRINGS: &str = r#"normal = { law = "linear", stiffness = 2000.0, restitution = 1.0 }
tangential = { law = "linear", stiffness = 1500.0, friction = 0.3 }"#;
    const DASHPOTS: &str = r#"normal = { law = "linear", stiffness = 2000.0, restitution = 0.6 }
tangential = { law = "linear", stiffness = 1500.0, dissipation = 0.3, friction = 0.3 }"#;
    const MINDLIN: &str = r#"normal = { law = "hertz", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.6 }
tangential = { law = "mindlin", friction = 0.3 }"#;
    for laws in [SPRINGS, DASHPOTS, MINDLIN] {
        let folder = with_plate(&bounce(laws), usize::MAX);
        for part in [1.0, 0.5, 0.25, 0.125] {
            let (ratios, step) = friction_work(folder.path(), part);
            // A contact has some fifty automatic steps. Each of its two ends, and the course between them, is known to a step: errors of a few of
            // (1/50)^2, far below the 4 to 20 % of a rule of first order.
            let most = 4.0 * (part / 50.0) * (part / 50.0);
            for ratio in ratios {
                assert!(
                    (ratio - 1.0).abs() < most,
                    "{ratios:?} with {part} of the automatic step, {step} s: {laws}"
                );
            }
        }
    }
}

/// Triangles that are turned over are refused by their numbers where a wall wears, and only there.
#[test]
fn a_plate_with_turned_triangles_is_refused() {
    let laws = r#"normal = { law = "linear", stiffness = 2000.0, restitution = 1.0 }"#;
    let folder = with_plate(&bounce(laws), 67);
    let path = folder.path().join("bounce.toml");
    let scene = read_scene(&path, &[]).unwrap();
    let errors = plan(&scene).err().unwrap().to_string();
    // The 67th, the 134th and the 201st of 200 are turned: two triangles with three edges each.
    for part in [
        "walls.plate.file",
        "triangle 66 is turned the other way than its neighbour, triangle ",
        "and 6 of its edges have them on both",
        "leave `wear` out",
    ] {
        assert!(errors.contains(part), "{errors}");
    }
    let text = std::fs::read_to_string(&path).unwrap();
    let without: String = text
        .lines()
        .filter(|line| !line.starts_with("wear"))
        .map(|line| format!("{line}\n"))
        .collect();
    std::fs::write(&path, without).unwrap();
    assert!(plan(&read_scene(&path, &[]).unwrap()).is_ok());
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

/// A wear map that no grain can reach: behind a plane by more than a ball can overlap it, outside of the domain, or before the plane, where it is reached.
#[test]
fn a_plate_out_of_reach_is_warned_about() {
    const LAWS: &str = r#"normal = { law = "linear", stiffness = 2000.0, restitution = 1.0 }
[[walls]]
name = "floor"
material = "a"
shape = "plane"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]"#;
    let folder = with_plate(&bounce(LAWS), usize::MAX);
    let warnings = |height: f64| {
        let changes = [format!("walls.plate.offset=[0.0, 0.0, {height:?}]")];
        let scene = read_scene(&folder.path().join("bounce.toml"), &changes);
        let plan = plan(&scene.unwrap_or_else(|errors| panic!("{errors}"))).unwrap();
        let all = plan.notes().warnings().iter();
        let of_wear = all.filter(|warning| warning.starts_with("walls.plate.wear"));
        of_wear.cloned().collect::<Vec<_>>()
    };
    // The radius is 5 mm.
    for height in [0.05, 0.0, -0.009] {
        assert_eq!(warnings(height), Vec::<String>::new(), "{height}");
    }
    for (height, why) in [
        (-0.011, "it lies wholly behind the wall `floor`"),
        (0.2, "it lies outside of the domain"),
    ] {
        let found = warnings(height);
        assert_eq!(found.len(), 1, "{height}: {found:?}");
        assert!(found[0].contains(why), "{found:?}");
    }
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
