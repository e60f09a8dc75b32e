//! `mercury-solve new`: its files, messages and refusals, and that its scenes run. Whole runs with their pictures: `.ci/run`.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use mercury_solver::starters::STARTERS;

fn solve(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn every_scene_is_written_planned_without_warning_and_runs() {
    let folder = tempfile::tempdir().unwrap();
    for starter in STARTERS {
        let name = starter.name;
        let output = solve(folder.path(), &["new", name, name]);
        let text = said(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output.stderr));
        let begin = format!("{name}/{name}.toml");
        assert!(text.starts_with(&begin), "{text}");
        assert!(text.contains(&format!("\n  cd {name}\n")), "{text}");
        for (command, _) in starter.next() {
            assert!(text.contains(&command), "{command} is not in\n{text}");
        }

        let inside = folder.path().join(name);
        let scene = format!("{name}.toml");
        let plan = said(&solve(&inside, &[&scene, "--check"]).stdout);
        assert!(plan.contains("shortest contact"), "{plan}");
        assert!(!plan.to_lowercase().contains("warning"), "{plan}");
        // As far as the first frame, for all but what comes later. (0.004 s are some hundred steps.)
        let short = ["--set", "time.end=0.004", "--json", "--quiet"];
        let output = solve(&inside, &[&[scene.as_str()], &short[..]].concat());
        assert_eq!(
            output.status.code(),
            Some(0),
            "{name}: {}",
            said(&output.stderr)
        );
        assert!(inside.join(name).join(format!("{name}.final.png")).exists());
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(summary["inserted"].as_u64() > Some(0), "{summary}");
    }
}

#[test]
fn a_scene_is_written_here_and_nothing_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let text = said(&solve(folder.path(), &["new", "clumps"]).stdout);
    assert!(text.starts_with("clumps.toml, bean.clump.toml: "), "{text}");
    assert!(!text.contains("  cd "), "{text}");
    let scene = folder.path().join("clumps.toml");
    fs::write(&scene, "mine").unwrap();
    fs::remove_file(folder.path().join("bean.clump.toml")).unwrap();
    let again = solve(folder.path(), &["new", "clumps"]);
    assert_eq!(again.status.code(), Some(2));
    assert_eq!(
        said(&again.stderr),
        "clumps.toml: this file is there already, and nothing was written\nhelp: name another folder: mercury-solve new clumps FOLDER\n"
    );
    assert_eq!(fs::read_to_string(&scene).unwrap(), "mine");
    assert!(!folder.path().join("bean.clump.toml").exists());
    // A folder with a blank is printed as a shell takes it.
    let text = said(&solve(folder.path(), &["new", "clumps", "my beans"]).stdout);
    assert!(text.contains("\n  cd 'my beans'\n"), "{text}");
}

#[test]
fn slips_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str]| {
        let output = solve(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        said(&output.stderr)
    };
    let text = refused(&["new", "hoper"]);
    assert!(text.contains("'hopper'"), "{text}");
    let text = refused(&["new"]);
    assert!(text.contains("<WHICH>"), "{text}");
    // A folder that is a file is the system's refusal.
    fs::write(folder.path().join("file"), "").unwrap();
    let output = solve(folder.path(), &["new", "drum", "file/inside"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output.stderr).contains("file/inside"));
    // A scene of that name is still run, by its path.
    let text = refused(&["./new"]);
    assert!(text.contains("./new"), "{text}");
}
