//! Cost of a step in which the loads on walls are summed up over one in which they are not, and of saving and restoring a state, in steps. Time it on a machine that does
//! nothing else: `cargo run --release -p c-interface --example costs [BEADS]`.

use std::time::Instant;

use mercury_solver::run::{Run, RunOptions, SceneInput};

/// Beads that settle in a box under a lid.
fn scene(beads: usize) -> String {
    let side = 0.002 * libm::cbrt(beads as f64 / 2.0);
    format!(
        r#"
seed = 1
gravity = [0, 0, -9.81]
[time]
end = 10.0
[domain]
min = [0, 0, 0]
max = [{side}, {side}, {high}]
[materials.glass]
density = 2500.0
normal = {{ law = "linear", stiffness = 200.0, restitution = 0.6 }}
tangential = {{ law = "linear", stiffness_ratio = 0.2857, friction = 0.3 }}
[[walls]]
name = "box"
shape = "box"
material = "glass"
[[insertions]]
name = "fill"
region = {{ shape = "box", min = [0, 0, 0], max = [{side}, {side}, {high}] }}
material = "glass"
psd = {{ kind = "uniform", min_diameter = 1.8e-3, max_diameter = 2.2e-3, weighting = "number" }}
total = {{ number = {beads} }}
[output]
interval = 10.0
"#,
        high = 8.0 * side
    )
}

fn run(beads: usize, wall_loads: bool) -> (Run, tempfile::TempDir) {
    let input = SceneInput {
        path: "bed.toml".into(),
        text: scene(beads),
        set: Vec::new(),
    };
    let (_, plan, _) = input.plan().expect("the scene");
    let folder = tempfile::tempdir().expect("a folder");
    let options = RunOptions {
        folder: folder.path().to_owned(),
        threads: 1,
        wall_loads,
        ..RunOptions::default()
    };
    let mut run = Run::new(plan, options).expect("a run");
    run.advance(0.3, &mut |_| ()).expect("settled");
    (run, folder)
}

/// Seconds of a step, the least of several series.
fn step(run: &mut Run) -> f64 {
    const STEPS: u64 = 400;
    let dt = run.plan().physics().time_step;
    let begin = Instant::now();
    let until = (run.engine().steps() + STEPS) as f64 * dt;
    run.advance(until, &mut |_| ()).expect("steps");
    begin.elapsed().as_secs_f64() / STEPS as f64
}

fn main() {
    let beads = std::env::args()
        .nth(1)
        .map_or(2000, |text| text.parse().expect("a number"));
    let (mut with, _a) = run(beads, true);
    let (mut without, _b) = run(beads, false);
    let (mut least, mut ratios) = (f64::INFINITY, Vec::new());
    for _ in 0..15 {
        let [a, b] = [step(&mut with), step(&mut without)];
        least = least.min(b);
        ratios.push(a / b);
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "{beads} beads: a step takes {:.1} us; with loads on walls {:.3} of it",
        least * 1e6,
        ratios[7]
    );
    let mut times = Vec::new();
    for _ in 0..15 {
        let begin = Instant::now();
        let saved = with.save().expect("saved");
        let save = begin.elapsed().as_secs_f64();
        step(&mut with);
        let begin = Instant::now();
        with.restore(&saved).expect("restored");
        times.push([save, begin.elapsed().as_secs_f64()]);
    }
    for (what, place) in [("save", 0), ("restore", 1)] {
        let mut all: Vec<f64> = times.iter().map(|times| times[place] / least).collect();
        all.sort_by(f64::total_cmp);
        println!("{what}: {:.1} steps", all[7]);
    }
}
