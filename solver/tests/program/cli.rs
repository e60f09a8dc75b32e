//! The command line as a user meets it: exit codes, messages, files.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::{code, errors, folder_with, said, solve};

const SCENE: &str = r#"
title = "Two spheres"

[time]
end = 0.002
step = 1e-5

[domain]
min = [0.0, 0.0, 0.0]
max = [0.1, 0.1, 0.1]

[materials.glass]
density = 2500.0
normal = { law = "linear", stiffness = 1000.0, restitution = 0.8 }

[[particles]]
name = "left"
material = "glass"
radius = 0.01
position = [0.03, 0.05, 0.05]
velocity = [0.1, 0.0, 0.0]

[[particles]]
name = "right"
material = "glass"
radius = 0.01
position = [0.0501, 0.05, 0.05]
velocity = [-0.1, 0.0, 0.0]

[output]
interval = 0.001
pictures = false
"#;

fn folder_with_scene(text: &str) -> tempfile::TempDir {
    folder_with("pair.toml", text)
}

#[test]
fn a_run_ends_with_0_and_a_report() {
    let folder = folder_with_scene(SCENE);
    let output = solve(folder.path(), &["pair.toml"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let report = said(&output);
    assert!(
        report.contains("Two spheres: finished at t = 0.002 s after 200 steps"),
        "{report}"
    );
    assert!(report.contains("pair.data"), "{report}");
    let data = fs::read_to_string(folder.path().join("pair/pair.data")).unwrap();
    assert_eq!(data.lines().count(), 3 * (1 + 2), "t = 0, 0.001 and 0.002");
    let log = fs::read_to_string(folder.path().join("pair/run.log")).unwrap();
    assert!(log.contains("pair.toml"), "{log}");
    let plan = fs::read_to_string(folder.path().join("pair/plan.toml")).unwrap();
    assert!(toml::from_str::<toml::Table>(&plan).is_ok(), "{plan}");
}

#[test]
fn a_folder_with_a_run_needs_force() {
    let folder = folder_with_scene(SCENE);
    assert_eq!(code(&solve(folder.path(), &["pair.toml"])), Some(0));
    fs::write(folder.path().join("pair/notes.txt"), "mine").unwrap();
    let refused = solve(folder.path(), &["pair.toml"]);
    assert_eq!(code(&refused), Some(2));
    assert!(errors(&refused).contains("--force"), "{}", errors(&refused));
    assert_eq!(
        code(&solve(folder.path(), &["pair.toml", "--output", "other"])),
        Some(0)
    );
    assert_eq!(
        code(&solve(folder.path(), &["pair.toml", "--force"])),
        Some(0)
    );
    assert_eq!(
        fs::read_to_string(folder.path().join("pair/notes.txt")).unwrap(),
        "mine"
    );
}

#[test]
fn an_output_that_is_a_file_is_refused() {
    let folder = folder_with_scene(SCENE);
    let output = solve(
        folder.path(),
        &["pair.toml", "--output", "pair.toml", "--force"],
    );
    assert_eq!(code(&output), Some(2));
    assert!(
        errors(&output).contains("not a folder"),
        "{}",
        errors(&output)
    );
    assert_eq!(
        fs::read_to_string(folder.path().join("pair.toml")).unwrap(),
        SCENE
    );
}

#[test]
fn the_folder_of_the_scene_can_be_the_folder_of_the_run() {
    let folder = folder_with_scene(SCENE);
    for _ in 0..2 {
        let output = solve(folder.path(), &["pair.toml", "--output", ".", "--force"]);
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
    }
    assert_eq!(
        fs::read_to_string(folder.path().join("pair.toml")).unwrap(),
        SCENE
    );
}

/// Nothing is wrong with the input: the run fails.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_cannot_be_written_ends_the_run_with_1() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = folder_with_scene(SCENE);
    let locked = folder.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser may write into any folder but one that is no place for files.
    for name in ["locked", "/proc/mercury", "/proc/self"] {
        if name == "locked" && fs::write(locked.join("probe"), "").is_ok() {
            continue;
        }
        for asked in [None, Some("--force"), Some("--resume")] {
            let arguments = ["pair.toml", "--output", name];
            let output = solve(folder.path(), &[&arguments[..], asked.as_slice()].concat());
            assert_eq!(code(&output), Some(1), "{}", errors(&output));
            assert!(errors(&output).contains(name), "{}", errors(&output));
            assert!(errors(&output).contains("help: "), "{}", errors(&output));
        }
    }
}

#[test]
fn a_wrong_scene_ends_with_2_and_says_where() {
    let folder = folder_with_scene(&SCENE.replace("density = 2500.0", "density = -1.0"));
    let output = solve(folder.path(), &["pair.toml"]);
    assert_eq!(code(&output), Some(2));
    let message = errors(&output);
    assert!(message.contains("pair.toml:13:"), "{message}");
    assert!(message.contains("1 problem"), "{message}");
    assert!(
        !folder.path().join("pair").exists(),
        "nothing is made for a wrong scene"
    );
    let missing = solve(folder.path(), &["missing.toml"]);
    assert_eq!(code(&missing), Some(2));
    assert!(
        errors(&missing).contains("missing.toml"),
        "{}",
        errors(&missing)
    );
}

#[test]
fn set_changes_the_scene() {
    let folder = folder_with_scene(SCENE);
    let output = solve(
        folder.path(),
        &["pair.toml", "--set", "time.end=0.001", "--json"],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let summary: serde_json::Value = serde_json::from_str(&said(&output)).unwrap();
    assert_eq!(summary["steps"], 100);
    assert_eq!(summary["status"], "finished");
    let file = fs::read_to_string(folder.path().join("pair/summary.json")).unwrap();
    assert_eq!(
        serde_json::from_str::<serde_json::Value>(&file).unwrap(),
        summary
    );
    let wrong = solve(
        folder.path(),
        &["pair.toml", "--set", "time.ende=1", "--force"],
    );
    assert_eq!(code(&wrong), Some(2));
}

#[test]
fn check_prints_the_plan_and_runs_nothing() {
    let folder = folder_with_scene(SCENE);
    let output = solve(folder.path(), &["pair.toml", "--check"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    assert!(said(&output).contains("Two spheres"), "{}", said(&output));
    let output = solve(folder.path(), &["pair.toml", "--check", "--json"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let plan: serde_json::Value = serde_json::from_str(&said(&output)).unwrap();
    assert!(plan.is_object());
    assert!(!folder.path().join("pair").exists());
    let wrong = solve(
        folder.path(),
        &["pair.toml", "--check", "--set", "time.end=-1"],
    );
    assert_eq!(code(&wrong), Some(2));
}

/// 1e9 sites, and 1e9 particles to come: a terabyte, which no machine of a test has. The error is a message and comes at once,
/// not from the allocator.
#[test]
fn a_run_that_cannot_fit_is_refused() {
    let scene = SCENE.replace("step = 1e-5", "step = \"auto\"");
    let lattice = scene.replacen("radius = 0.01", "radius = 4e-5", 1).replace(
        "position = [0.03, 0.05, 0.05]",
        "lattice = { min = [0, 0, 0], max = [0.0999, 0.0999, 0.0999], spacing = 1e-4 }",
    );
    let folder = folder_with_scene(&lattice.replace("name = \"left\"\n", ""));
    for more in [&["--check"][..], &["--check", "--json"], &[]] {
        let output = solve(folder.path(), &[&["pair.toml"], more].concat());
        assert_eq!(code(&output), Some(2), "{}", said(&output));
        let errors = errors(&output);
        assert!(
            errors.contains("particles[0]: the run is expected to need ")
                && errors.contains(" TB of memory, and this machine has ")
                && errors.contains("this lattice has 1,000,000,000 of its 1,000,000,001 spheres")
                && errors.contains("--force-memory"),
            "{errors}"
        );
    }

    let rain = "[[insertions]]\nname = \"rain\"\nmaterial = \"glass\"\ntotal = { number = 1_000_000_000 }\n\
        region = { shape = \"box\", min = [0, 0, 0], max = [0.1, 0.1, 0.1] }\n\
        psd = { kind = \"monodisperse\", diameter = 1e-5 }\n";
    let folder = folder_with_scene(&format!("{scene}{rain}"));
    let output = solve(folder.path(), &["pair.toml", "--check"]);
    assert_eq!(code(&output), Some(2), "{}", errors(&output));
    // The plan is printed all the same.
    assert!(
        said(&output).contains("THE RUN DOES NOT FIT"),
        "{}",
        said(&output)
    );
    assert!(errors(&output).contains("this insertion brings up to 1,000,000,000"));
    let output = solve(folder.path(), &["pair.toml"]);
    assert_eq!(code(&output), Some(2));
    assert!(!folder.path().join("pair").exists());
    let output = solve(folder.path(), &["pair.toml", "--check", "--force-memory"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
}

#[test]
fn quiet_says_nothing() {
    let folder = folder_with_scene(SCENE);
    let output = solve(folder.path(), &["pair.toml", "--quiet"]);
    assert_eq!(
        (code(&output), said(&output), errors(&output)),
        (Some(0), String::new(), String::new())
    );
}

/// Runs with standard output and standard error closed at the reader's end before the program starts.
#[cfg(unix)]
fn solve_into_closed_pipes(folder: &Path, arguments: &[&str]) -> Option<i32> {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder)
        .args(arguments)
        .stdout(writer.try_clone().unwrap())
        .stderr(writer)
        .status()
        .unwrap()
        .code()
}

/// Warnings of a scene appear before the first step, not after a night.
#[test]
fn warnings_come_before_the_run() {
    let folder = folder_with_scene(SCENE);
    // A step beyond a fifth of a contact.
    let long = ["pair.toml", "--set", "time.step=2e-3"];
    let output = solve(folder.path(), &long);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let text = errors(&output);
    assert!(text.contains("warning: "), "{text}");
    let quiet = solve(
        folder.path(),
        &[&long[..], &["--force", "--quiet"]].concat(),
    );
    assert!(!errors(&quiet).contains("warning: "), "{}", errors(&quiet));
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_gone_away_changes_no_exit_code() {
    let folder = folder_with_scene(SCENE);
    for (arguments, expected) in [
        (&["pair.toml", "--set", "time.end=-1"][..], 2),
        (&["pair.toml", "--nonsense"], 2),
        (&["pair.toml", "--check"], 0),
        (&["pair.toml", "--completions", "bash"], 0),
        (&["pair.toml"], 0),
        (&["pair.toml", "--force", "--json"], 0),
    ] {
        let code = solve_into_closed_pipes(folder.path(), arguments);
        assert_eq!(code, Some(expected), "{arguments:?}");
    }
}

/// `--threads` is the most: two spheres are one thread's work. A measurement with threads gets the requested number.
#[test]
fn no_more_threads_than_are_useful() {
    let folder = folder_with_scene(SCENE);
    for (more, threads) in [(&[][..], 1), (&["--fixed-threads"], 3)] {
        let arguments = [&["pair.toml", "--force", "--json", "--threads", "3"], more].concat();
        let output = solve(folder.path(), &arguments);
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
        let summary: serde_json::Value = serde_json::from_str(&said(&output)).unwrap();
        assert_eq!(summary["threads"], threads, "{arguments:?}");
    }
}

#[test]
fn wrong_usage_ends_with_2() {
    let folder = folder_with_scene(SCENE);
    for arguments in [
        &["pair.toml", "--threads", "0"][..],
        &["pair.toml", "--threads", "100000"],
        &["pair.toml", "--fixed-threads"],
        &["pair.toml", "--nonsense"],
        &[],
    ] {
        let output = solve(folder.path(), arguments);
        assert_eq!(code(&output), Some(2), "{arguments:?}");
        assert!(!errors(&output).is_empty());
    }
}

#[test]
fn help_version_and_completions() {
    let folder = tempfile::tempdir().unwrap();
    let help = solve(folder.path(), &["--help"]);
    assert_eq!(code(&help), Some(0));
    assert!(said(&help).contains("Examples:") && said(&help).contains("--set"));
    let version = solve(folder.path(), &["--version"]);
    // With MPI another line says so.
    assert_eq!(
        said(&version).lines().next(),
        Some(concat!("mercury-solve ", env!("CARGO_PKG_VERSION")))
    );
    let completions = solve(folder.path(), &["--completions", "bash"]);
    assert_eq!(code(&completions), Some(0));
    assert!(said(&completions).contains("--output"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_request_to_stop_ends_with_75_and_whole_files() {
    let folder = folder_with_scene(SCENE);
    // A run of hours, stopped as soon as its first frame is there.
    let mut child = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder.path())
        .args(["pair.toml", "--quiet", "--set", "time.end=1000"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let data = folder.path().join("pair/pair.data");
    while fs::metadata(&data).map_or(0, |data| data.len()) == 0 {
        assert!(
            child.try_wait().unwrap().is_none(),
            "the run ended by itself"
        );
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), Some(75));
    assert!(
        errors(&output).contains("stopped at t ="),
        "{}",
        errors(&output)
    );
    let summary = fs::read_to_string(folder.path().join("pair/summary.json")).unwrap();
    assert!(summary.contains("\"status\": \"stopped\""), "{summary}");
    assert!(fs::read_to_string(&data).unwrap().ends_with('\n'));
}

/// A run of hours in the folder `pair`, as soon as its first frame is there.
fn long_run(folder: &Path) -> std::process::Child {
    let mut child = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder)
        .args(["pair.toml", "--quiet", "--set", "time.end=1000"])
        .spawn()
        .unwrap();
    let data = folder.join("pair/pair.data");
    while fs::metadata(&data).map_or(0, |data| data.len()) == 0 {
        assert!(
            child.try_wait().unwrap().is_none(),
            "the run ended by itself"
        );
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    child
}

#[test]
fn the_folder_of_a_running_run_is_refused_even_with_force() {
    let folder = folder_with_scene(SCENE);
    let mut running = long_run(folder.path());
    for arguments in [&["pair.toml"][..], &["pair.toml", "--force"]] {
        let output = solve(folder.path(), arguments);
        assert_eq!(code(&output), Some(2));
        let reported = errors(&output);
        assert!(
            reported.starts_with("pair: this folder is being written by another run (process "),
            "{reported}"
        );
        assert!(
            reported.contains("help: wait for its end or stop it"),
            "{reported}"
        );
    }
    running.kill().unwrap();
    running.wait().unwrap();
    // A killed run cannot clean up; what it leaves is no obstacle.
    assert!(folder.path().join("pair/.lock").exists());
    let output = solve(folder.path(), &["pair.toml", "--force", "--quiet"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    assert!(!folder.path().join("pair/.lock").exists());
}
