//! A request to stop takes effect at once, also while a run makes no steps, and the remaining files are whole.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::common::{code, command, errors, facts, folder_with, results, signal, solve};
use mercury_common::scene::Files;
use mercury_engine::task::{Task, TaskProgress};
use mercury_solver::output::folder::{Earlier, prepare};
use mercury_solver::plan::{Plan, parse_scene, plan};
use mercury_solver::run::{Checkpoints, Report, RunOptions, checkpoint, run_from};

/// Small grains in a large domain: any number finds its place, one after the other.
fn rain(number: u64, from: f64) -> String {
    format!(
        r#"
title = "Rain"
gravity = [0, 0, -9.81]
time = {{ end = 2e-4, step = 1e-5 }}
domain = {{ min = [0, 0, 0], max = [1, 1, 1] }}
output = {{ interval = 2e-5, pictures = false }}
[materials.glass]
density = 2500.0
normal = {{ law = "linear", stiffness = 1.0, restitution = 0.8 }}
[[particles]]
material = "glass"
radius = 1e-4
position = [0.5, 0.5, 0.5]
[[insertions]]
name = "rain"
region = {{ shape = "box", min = [0, 0, 0], max = [1, 1, 1] }}
material = "glass"
psd = {{ kind = "uniform", min_diameter = 1e-4, max_diameter = 2e-4, weighting = "number" }}
total = {{ number = {number} }}
from = {from}
"#
    )
}

#[test]
fn a_stop_during_the_start_leaves_no_trace() {
    // Hundreds of millions would take minutes.
    let folder = folder_with("rain.toml", &rain(400_000_000, 0.0));
    let lock = folder.path().join("rain/.lock");
    for (signal_name, more) in [("INT", None), ("TERM", Some("--resume"))] {
        let arguments = ["rain.toml", "--force-memory"].into_iter().chain(more);
        let arguments: Vec<&str> = arguments.collect();
        let mut command = command(folder.path(), &arguments);
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        while !lock.exists() {
            assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
            std::thread::sleep(Duration::from_millis(2));
        }
        // It is inserting by now, or about to.
        std::thread::sleep(Duration::from_millis(300));
        signal(&child, signal_name);
        let output = child.wait_with_output().unwrap();
        assert_eq!(code(&output), Some(75), "{}", errors(&output));
        let reported = errors(&output);
        assert!(
            reported.contains("stopped before the first step"),
            "{reported}"
        );
        assert!(reported.contains("help: "), "{reported}");
        assert!(!folder.path().join("rain").exists(), "a folder is left");
    }
    // Files of the user stay.
    fs::create_dir(folder.path().join("rain")).unwrap();
    fs::write(folder.path().join("rain/notes.txt"), "mine").unwrap();
    let mut command = command(folder.path(), &["rain.toml", "--force-memory", "--quiet"]);
    let child = command.stderr(Stdio::piped()).spawn().unwrap();
    while !lock.exists() {
        std::thread::sleep(Duration::from_millis(2));
    }
    signal(&child, "INT");
    assert_eq!(code(&child.wait_with_output().unwrap()), Some(75));
    let left: Vec<_> = fs::read_dir(folder.path().join("rain")).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn a_study_that_is_stopped_while_its_runs_begin_goes_on_later() {
    let folder = folder_with("rain.toml", &rain(400_000_000, 0.0));
    let arguments = [
        "rain.toml",
        "--sweep",
        "seed=1,2",
        "--jobs",
        "2",
        "--force-memory",
    ];
    let lock = folder.path().join("rain-study/seed=1/.lock");
    let mut command = command(folder.path(), &arguments);
    let mut child = command
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    while !lock.exists() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), Some(75), "{}", errors(&output));
    assert!(
        errors(&output).contains("stopped: 2 of 2 runs to go on with"),
        "{}",
        errors(&output)
    );
    assert!(!folder.path().join("rain-study/seed=1").exists());
    let few = [
        "rain.toml",
        "--sweep",
        "seed=1,2",
        "--set",
        "insertions.rain.total.number=5",
    ];
    let output = solve(folder.path(), &few);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
}

fn planned(text: &str) -> Plan {
    plan(&parse_scene(Path::new("rain.toml"), text, &[], Files::Unchecked).unwrap()).unwrap()
}

/// Runs it, or goes on with it; with `stops`, it is stopped as soon as the insertion has placed some.
fn go(plan: Plan, folder: &Path, stops: bool) -> Report {
    let stop = Arc::new(AtomicBool::new(false));
    let task_progress = Arc::new(TaskProgress::new(Arc::clone(&stop)));
    let (lock, _) = prepare(folder, "rain", Earlier::Continue).unwrap();
    let from = checkpoint::newest(folder, "rain")
        .unwrap()
        .map(|(newest, _)| newest);
    let options = RunOptions {
        folder: folder.to_owned(),
        threads: 1,
        plan_document: Some("prefix = \"rain\"\n".to_owned()),
        stop: Arc::clone(&stop),
        task_progress: Arc::clone(&task_progress),
        checkpoints: Some(Checkpoints {
            at_end: true,
            ..Checkpoints::default()
        }),
        ..RunOptions::default()
    };
    let is_over = Arc::new(AtomicBool::new(false));
    let watcher = stops.then(|| {
        let is_over = Arc::clone(&is_over);
        std::thread::spawn(move || {
            while !is_over.load(Ordering::Relaxed) {
                if task_progress.task() == Task::Inserting && task_progress.placed().0 > 10 {
                    stop.store(true, Ordering::Relaxed);
                    return;
                }
            }
        })
    });
    let report = run_from(from, plan, &options, &mut |_| ()).unwrap();
    is_over.store(true, Ordering::Relaxed);
    if let Some(watcher) = watcher {
        watcher.join().unwrap();
    }
    drop(lock);
    report
}

#[test]
fn a_stop_during_a_long_insertion_keeps_the_step_before_it() {
    // It begins in step 7, of 20.
    let text = rain(30_000, 7e-5);
    let place = tempfile::tempdir().unwrap();
    let (straight, stopped) = (place.path().join("straight"), place.path().join("stopped"));
    assert_eq!(go(planned(&text), &straight, false).summary.steps, 20);
    let report = go(planned(&text), &stopped, true);
    assert_eq!((report.summary.steps, report.summary.particles), (6, 1));
    assert!(matches!(
        report.ending,
        mercury_solver::run::Ending::Stopped(_)
    ));
    let (newest, _) = checkpoint::newest(&stopped, "rain").unwrap().unwrap();
    assert_eq!(newest.head.step, 6);
    // And goes on to the same bytes.
    let report = go(planned(&text), &stopped, false);
    assert_eq!(
        (report.summary.steps, report.summary.particles),
        (20, 30_001)
    );
    assert!(results(&straight, "rain") == results(&stopped, "rain"));
    assert_eq!(facts(&straight), facts(&stopped));
}
