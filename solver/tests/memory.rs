//! The plan's estimate of memory against what a run allocates: a packing of 100,000 spheres, copied side by side from that of the
//! benchmark, read from a table.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use mercury_engine::physics::ToSetup;
use mercury_engine::step::{Engine, SizeEstimate, bytes_of_parts};
use mercury_solver::output::folder;
use mercury_solver::plan::{plan, read_scene};
use mercury_solver::run::{Checkpoints, RunOptions, memory, run};
use peak_alloc::PeakAlloc;

#[global_allocator]
static COUNTED: PeakAlloc = PeakAlloc;

/// Lock of the tests, one at a time: allocations are counted for the whole program.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

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
    let _alone = alone();
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

/// Lattices of 27,000 spheres that overlap by a little along each axis, between walls beyond which nothing is.
const GRAINS: &str = r#"
[time]
end = 1.0
step = 1e-6
[domain]
min = [-0.1, -0.1, -0.1]
max = [0.4, 0.4, 0.4]
[materials.glass]
density = 2500.0
normal = { law = "linear", stiffness = 1000.0, restitution = 0.8 }
[[particles]]
material = "glass"
radius = 5.01e-3
lattice = { min = [5e-3, 5e-3, 5e-3], max = [0.295, 0.295, 0.295], spacing = 0.01 }
"#;

/// Bytes that a scene allocates for its plan and an engine that has made some steps, and the estimate for its parts.
fn allocated(folder: &Path, text: &str) -> (f64, f64) {
    let path = folder.join("scene.toml");
    fs::write(&path, text).unwrap();
    let before = COUNTED.current_usage() as f64;
    let plan = {
        let scene = read_scene(&path, &[]).unwrap();
        Arc::new(plan(&scene).unwrap())
    };
    let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
    engine.steps_at_once(3, None).unwrap();
    engine.complete_step().unwrap();
    // Contacts in an observation belong to no part.
    let observed = engine.take_observation();
    let crowd = SizeEstimate {
        rows: engine.particles.len() as f64,
        touching: observed.particle_contacts as f64,
    };
    drop(observed);
    let now = COUNTED.current_usage() as f64;
    (now - before, bytes_of_parts(&plan.to_setup(), &crowd))
}

/// A flat square of 2 n^2 triangles, 0.1 m below the domain's middle.
fn plate(n: u32) -> String {
    let mut text = String::new();
    for k in 0..(n + 1) * (n + 1) {
        let at = |k: u32| 0.29 * f64::from(k) / f64::from(n);
        writeln!(text, "v {} {} -0.05", at(k % (n + 1)), at(k / (n + 1))).unwrap();
    }
    for k in (0..n * n).map(|k| k / n * (n + 1) + k % n + 1) {
        let above = k + n + 1;
        writeln!(text, "f {k} {} {}", k + 1, above + 1).unwrap();
        writeln!(text, "f {k} {} {above}", above + 1).unwrap();
    }
    text
}

/// A sheet below the grains, of triangles of this edge (m).
fn sheet(edge: f64, keys: &str) -> String {
    format!(
        "[[membranes]]\nname = \"sheet\"\nshape = \"rectangle\"\ncorner = [0.0, 0.0, -0.05]\nalong = [0.3, 0.0, 0.0]\nacross = [0.0, 0.3, 0.0]\n\
         edge = {edge}\nmaterial = \"glass\"\nthickness = 1e-3\nyoungs_modulus = 1e5\nfixed = \"rim\"\n{keys}\n"
    )
}

/// With a part and without it: what is allocated in addition is what the part is estimated to take, to within 15 %.
#[test]
fn parts_take_what_is_estimated() {
    let _alone = alone();
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("plate.obj"), plate(120)).unwrap();
    let output = |keys: &str| format!("[output]\ninterval = 0.1\npictures = false\n{keys}\n");
    let wall = |keys: &str| {
        format!(
            "[[walls]]\nname = \"plate\"\nshape = \"mesh\"\nfile = \"plate.obj\"\nmaterial = \"glass\"\n{keys}\n"
        )
    };
    let archard = "wear = { law = \"archard\", coefficient = 1e-3, hardness = 1e9, acceleration = 1.0, moves = false, basis = \"sliding\" }";
    let bending = "damping_ratio = 0.1\npressure = 10.0\nbending = { law = \"bridson\", stiffness = 1e-6, damping = 1e-9 }";
    let with_and_without = [
        ("springs", sheet(3e-3, ""), String::new()),
        ("hinges", sheet(3e-3, bending), String::new()),
        (
            "a continuum",
            sheet(3e-3, "elasticity = \"continuum\""),
            String::new(),
        ),
        ("wear", wall(archard), wall("")),
        ("audit", "energy_budget = true".to_owned(), String::new()),
    ];
    for (name, with, without) in with_and_without {
        let is_output = name == "audit";
        let scene = |part: &str| match is_output {
            true => format!("{}{GRAINS}", output(part)),
            false => format!("{}{GRAINS}{part}", output("")),
        };
        let (with, estimate) = allocated(place.path(), &scene(&with));
        let (without, none) = allocated(place.path(), &scene(&without));
        let (taken, estimate) = (with - without, estimate - none);
        compare(name, estimate, taken);
    }
}

/// A run of a sheet of some 100,000 triangles among grains.
#[test]
fn the_estimate_holds_for_a_large_sheet() {
    let _alone = alone();
    let place = tempfile::tempdir().unwrap();
    let text = format!(
        "[output]\ninterval = 1e-6\npictures = false\n{GRAINS}{}",
        sheet(1.3e-3, "")
    );
    let path = place.path().join("scene.toml");
    fs::write(&path, text.replace("end = 1.0", "end = 4e-6")).unwrap();
    COUNTED.reset_peak_usage();
    let plan = plan(&read_scene(&path, &[]).unwrap()).unwrap();
    let estimate = memory(&plan);
    COUNTED.reset_peak_usage();
    let options = RunOptions {
        folder: place.path().join("run"),
        threads: 2,
        checkpoints: Some(Checkpoints::default()),
        ..RunOptions::default()
    };
    let _lock = folder::prepare(&options.folder, "scene", folder::Earlier::Replace).unwrap();
    run(plan, &options, &mut |_| ()).unwrap();
    let most = COUNTED.peak_usage() as f64;
    compare("most", estimate.most + estimate.checkpoint - 16e6, most);
}
