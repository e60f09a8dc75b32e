//! The plan's estimate of memory against what a run allocates: a packing of 100,000 spheres, copied side by side from that of the
//! benchmark, read from a table.

use std::fs;
use std::path::Path;

use mercury_solver::output::folder;
use mercury_solver::plan::{plan, read_scene};
use mercury_solver::run::{Checkpoints, RunOptions, memory, run};
use peak_alloc::PeakAlloc;

#[global_allocator]
static COUNTED: PeakAlloc = PeakAlloc;

/// Width of the benchmark's box, m.
const WIDTH: f64 = 0.104;
const COPIES: usize = 5;

/// Writes a scene of copies of the benchmark side by side, all moving, so that lists are built anew.
fn write_scene(folder: &Path) {
    let bench = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/bench");
    let table = fs::read_to_string(bench.join("dense-20k.csv")).unwrap();
    let mut rows = table.lines();
    let mut copied = rows.next().unwrap().to_owned() + "\n";
    let rows: Vec<&str> = rows.collect();
    for copy in 0..COPIES {
        for row in &rows {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            let x: f64 = cells[0].parse().unwrap();
            cells[0] = format!("{}", x + copy as f64 * WIDTH);
            cells[4] = "0.5".to_owned();
            copied += &(cells.join(",") + "\n");
        }
    }
    fs::write(folder.join("wide.csv"), copied).unwrap();
    let scene = fs::read_to_string(bench.join("dense-20k.toml")).unwrap();
    let scene = scene
        .replace("dense-20k.csv", "wide.csv")
        .replace(
            "max = [0.104,",
            &format!("max = [{},", COPIES as f64 * WIDTH),
        )
        .replace("end  = 0.018", "end = 1.8e-3")
        .replace(
            "data = false",
            "data = false\npictures = false\nrestart_interval = 9e-4",
        );
    fs::write(folder.join("wide.toml"), scene).unwrap();
}

/// Panics unless the estimate is within 15 % of what was allocated.
fn compare(what: &str, estimate: f64, allocated: f64) {
    let ratio = estimate / allocated;
    println!("{what}: {estimate:.3e} bytes are estimated, {allocated:.3e} allocated");
    assert!(
        (0.85..1.15).contains(&ratio),
        "{what}: {estimate:.3e} bytes are estimated, {allocated:.3e} allocated"
    );
}

#[test]
fn the_estimate_is_what_a_run_allocates() {
    let place = tempfile::tempdir().unwrap();
    write_scene(place.path());
    COUNTED.reset_peak_usage();
    let plan = {
        let scene = read_scene(&place.path().join("wide.toml"), &[]).unwrap();
        plan(&scene).unwrap()
    };
    let estimate = memory(&plan);
    let start = COUNTED.peak_usage() as f64;
    let program = 16e6;
    compare("start", estimate.start - program, start);

    COUNTED.reset_peak_usage();
    let options = RunOptions {
        folder: place.path().join("run"),
        threads: 2,
        checkpoints: Some(Checkpoints::default()),
        ..RunOptions::default()
    };
    let _lock = folder::prepare(&options.folder, "wide", folder::Earlier::Replace).unwrap();
    // Between two looks a list is built and the first frame written; the last look is behind the last frame.
    let mut steps = f64::INFINITY;
    run(plan, &options, &mut |_| {
        steps = steps.min(COUNTED.current_usage() as f64);
    })
    .unwrap();
    let most = COUNTED.peak_usage() as f64;
    // The first look is before the first checkpoint, whose memory is kept; of the lists one is built after it.
    let allocated = estimate.steps - estimate.kept_free;
    compare("time loop", allocated - program, steps);
    compare("most", estimate.most + estimate.checkpoint - program, most);
}
