//! Helpers of the tests of the command line: a program in a folder, its output, signals to it, and the files of a run.
#![allow(dead_code, reason = "each test uses a part of it")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use mercury_solver::run::checkpoint;

/// A folder with one file in it.
pub(crate) fn folder_with(name: &str, text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), text).unwrap();
    folder
}

/// `mercury-solve` in a folder.
pub(crate) fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mercury-solve"));
    command.current_dir(folder).args(arguments);
    command
}

/// Runs it to its end.
pub(crate) fn solve(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

/// Its exit code.
pub(crate) fn code(output: &Output) -> Option<i32> {
    output.status.code()
}

/// Text on standard error.
pub(crate) fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Text on standard output.
pub(crate) fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Sends a signal by its name.
pub(crate) fn signal(child: &Child, name: &str) {
    // The process may have ended meanwhile.
    let _ = Command::new("kill")
        .args([&format!("-{name}"), &child.id().to_string()])
        .stderr(Stdio::null())
        .status();
}

/// The files of a run that must not depend on how often it was interrupted; of the two checkpoints the newest, whose name may
/// differ.
pub(crate) fn results(folder: &Path, prefix: &str) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let kept = folder.join(format!("{prefix}.checkpoints"));
    for inside in [folder.to_owned(), folder.join("vtk"), kept] {
        let Ok(entries) = fs::read_dir(&inside) else {
            continue;
        };
        for entry in entries {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            let tells_times = ["summary.json", "run.log", "plan.toml"];
            let alternates = name.ends_with(".restart") && inside == folder;
            if path.is_file() && !tells_times.contains(&name.as_str()) && !alternates {
                all.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    let (newest, damaged) = checkpoint::newest(folder, prefix).unwrap().unwrap();
    assert_eq!(damaged, [""; 0]);
    all.insert("checkpoint".to_owned(), fs::read(&newest.path).unwrap());
    all
}

/// Entries of a summary without times, rates and numbers of threads.
pub(crate) fn facts(folder: &Path) -> serde_json::Value {
    let text = fs::read_to_string(folder.join("summary.json")).unwrap();
    let mut summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let object = summary.as_object_mut().unwrap();
    for key in ["wall_seconds", "particle_steps_per_second", "threads"] {
        assert!(object.remove(key).is_some(), "{key}");
    }
    summary
}
