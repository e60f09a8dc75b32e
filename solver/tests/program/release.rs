//! Checkpoints are readable within a minor version: a run of version 0.1 that was stopped halfway is kept, and goes on.
//!
//! A checkpoint that cannot be read any more needs a new minor version. Before the release
//! `MERCURY_BLESS=release cargo test -p solver --test program release` makes the run anew.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Half of the run, s.
const HALF: &str = "--set=time.end=0.1";

fn run(folder: &Path, output: &str, more: &[&str]) {
    let said = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder)
        .args(["bed.toml", "--quiet", "--threads", "1", "--output", output])
        .args(more)
        .output()
        .unwrap();
    assert!(
        said.status.success(),
        "{}",
        String::from_utf8_lossy(&said.stderr)
    );
}

#[test]
fn a_checkpoint_of_version_0_1_goes_on_to_the_same_bytes() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/release_0_1");
    if std::env::var("MERCURY_BLESS").is_ok_and(|what| what == "release") {
        let _ = fs::remove_dir_all(kept.join("bed"));
        run(&kept, "bed", &[HALF]);
        for file in ["run.log", "summary.json", "plan.toml", "bed.scene.toml"] {
            fs::remove_file(kept.join("bed").join(file)).unwrap();
        }
    }
    let folder = tempfile::tempdir().unwrap();
    fs::copy(kept.join("bed.toml"), folder.path().join("bed.toml")).unwrap();
    fs::create_dir(folder.path().join("bed")).unwrap();
    for entry in fs::read_dir(kept.join("bed")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(
            entry.path(),
            folder.path().join("bed").join(entry.file_name()),
        )
        .unwrap();
    }
    run(folder.path(), "bed", &["--resume"]);
    run(folder.path(), "fresh", &[]);
    for file in ["bed.data", "bed.ene", "bed.budget.csv"] {
        let [old, fresh] =
            ["bed", "fresh"].map(|run| fs::read(folder.path().join(run).join(file)).unwrap());
        assert!(
            old == fresh,
            "{file} differs from that of a run that was never stopped"
        );
        assert!(old.len() > 1000, "{file} is nearly empty");
    }
}
