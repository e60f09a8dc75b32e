//! `--check --trial` as a user meets it: a time, and nothing written.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::Stdio;
use std::time::Duration;

use crate::common::{code, command, errors, folder_with, said, signal, solve};

const SCENE: &str = r#"
title = "Grains that never meet"
time = { end = 1.0, step = 1e-6 }
domain = { min = [0, 0, 0], max = [1, 1, 1], periodic = ["x", "y", "z"] }
output = { interval = 0.1, pictures = false }
[materials.glass]
density = 2500.0
normal = { law = "linear", stiffness = 1000.0, restitution = 0.8 }
[[particles]]
material = "glass"
radius = 0.01
lattice = { min = [0.1, 0.1, 0.1], max = [0.9, 0.9, 0.9], spacing = 0.1 }
"#;

#[test]
fn a_trial_states_a_time_and_writes_nothing() {
    let folder = folder_with("far.toml", SCENE);
    let output = solve(
        folder.path(),
        &[
            "far.toml",
            "--check",
            "--trial",
            "0.05s",
            "--threads",
            "1",
            "--set",
            "time.end=2.0",
        ],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let reported = said(&output);
    assert!(reported.contains("of 2,000,000 steps in"), "{reported}");
    assert!(
        reported.contains("all of it               about"),
        "{reported}"
    );
    assert!(reported.contains("on 1 thread"), "{reported}");
    assert!(reported.contains("729 in the trial\n"), "{reported}");
    let as_json = solve(
        folder.path(),
        &["far.toml", "--check", "--json", "--trial=0.05s"],
    );
    assert_eq!(code(&as_json), Some(0), "{}", errors(&as_json));
    let plan: serde_json::Value = serde_json::from_str(&said(&as_json)).unwrap();
    let trial = &plan["trial"];
    let number = |key: &str| trial[key].as_f64().unwrap();
    assert_eq!(number("of_steps"), 1e6);
    // Constant work: what was made, and the rest at the cost of a particle-step.
    let rest = 729.0 * (1e6 - number("steps")) * number("seconds_per_particle_step");
    let all = number("starting") + number("stepping") + rest;
    assert!(
        (trial["seconds"][0].as_f64().unwrap() - all).abs() < 1e-6 * all,
        "{trial}"
    );
    // The output of --check alone mentions no trial.
    let alone = said(&solve(folder.path(), &["far.toml", "--check"]));
    assert!(!alone.contains("trial"), "{alone}");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn what_is_no_trial_is_refused() {
    let folder = folder_with("far.toml", SCENE);
    for (arguments, why) in [
        (&["far.toml", "--trial"][..], "--check"),
        (&["far.toml", "--check", "--trial=0s"], "must be above 0"),
        (&["far.toml", "--check", "--trial=soon"], "90s"),
        (&["--check", "--trial", "far.toml"], "--trial=5s far.toml"),
        (
            &["far.toml", "--check", "--trial", "--sweep", "seed=1,2"],
            "a study of 2 runs",
        ),
    ] {
        let output = solve(folder.path(), arguments);
        assert_eq!(code(&output), Some(2), "{arguments:?}");
        assert!(
            errors(&output).contains(why),
            "{arguments:?}: {}",
            errors(&output)
        );
    }
}

#[test]
fn a_trial_that_is_ended_states_what_it_has() {
    let folder = folder_with("far.toml", SCENE);
    let mut command = command(folder.path(), &["far.toml", "--check", "--trial=10m"]);
    let child = command
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    // It is stepping by now, most likely; if not, it ends before its first step.
    std::thread::sleep(Duration::from_millis(1500));
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), Some(130), "{}", errors(&output));
    assert!(
        errors(&output).contains("nothing was written"),
        "{}",
        errors(&output)
    );
    assert!(
        said(&output).contains("it was ended before its time"),
        "{}",
        said(&output)
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
