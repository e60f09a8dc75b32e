//! Scenes under `tests/scenes`: the good ones run to their end, the bad ones are refused in exactly the words beside them.
//!
//! `MERCURY_BLESS=1 cargo test -p tests --test scenes frozen_scenes` writes the words anew. Read what it wrote.

use std::path::{Path, PathBuf};

use mercury_common::scene::SceneErrors;
use mercury_solver::output::folder;
use mercury_solver::output::summary::Status;
use mercury_solver::plan::{Plan, plan, read_scene, refusal};
use mercury_solver::run::{RunOptions, SceneInput, run};

fn folder_of(kind: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(kind)
}

/// The scenes of a folder, in the order of their names.
fn scenes(kind: &str) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder_of(kind))
        .expect("the folder can be listed")
        .map(|entry| entry.expect("the folder can be listed").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .filter(|path| !path.to_string_lossy().ends_with(".clump.toml"))
        .collect();
    files.sort();
    files
}

fn planned(path: &Path) -> Result<Plan, SceneErrors> {
    plan(&read_scene(path, &[])?)
}

/// Standard error of `mercury-solve NAME.toml --check` in the folder of the bad scenes, with that folder's own name left out.
fn complaint(path: &Path) -> String {
    let folder = format!(
        "{}{}",
        folder_of("bad").display(),
        std::path::MAIN_SEPARATOR
    );
    let read = SceneInput::read(path).and_then(|input| input.scene());
    let planned = read.and_then(|scene| plan(&scene));
    match planned {
        Ok(_) => "no error\n".to_owned(),
        Err(errors) => refusal(&errors).replace(&folder, "") + "\n",
    }
}

/// The two texts line by line, where they differ marked with - (frozen) and + (now).
fn difference(frozen: &str, now: &str) -> String {
    let (frozen, now): (Vec<_>, Vec<_>) = (frozen.lines().collect(), now.lines().collect());
    let mut text = String::new();
    for row in 0..frozen.len().max(now.len()) {
        match (frozen.get(row), now.get(row)) {
            (Some(a), Some(b)) if a == b => text += &format!("    {a}\n"),
            (a, b) => {
                for (mark, line) in [('-', a), ('+', b)] {
                    if let Some(line) = line {
                        text += &format!("  {mark} {line}\n");
                    }
                }
            }
        }
    }
    text
}

#[test]
fn bad_scenes_are_refused_in_their_words() {
    let files = scenes("bad");
    assert!(files.len() >= 50, "only {} scenes", files.len());
    let bless = std::env::var_os("MERCURY_BLESS").is_some();
    let mut differences = String::new();
    for path in files {
        let now = complaint(&path);
        assert_ne!(now, "no error\n", "{} is accepted", path.display());
        let words = path.with_extension("stderr");
        if bless {
            std::fs::write(&words, &now).expect("the words can be written");
        }
        let frozen = std::fs::read_to_string(&words).unwrap_or_default();
        if frozen != now {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            differences += &format!("{name}\n{}\n", difference(&frozen, &now));
        }
    }
    assert!(differences.is_empty(), "- frozen, + now:\n\n{differences}");
}

#[test]
fn every_frozen_text_has_its_scene() {
    for entry in std::fs::read_dir(folder_of("bad")).expect("the folder can be listed") {
        let path = entry.expect("the folder can be listed").path();
        if path.extension().is_some_and(|ending| ending == "stderr") {
            assert!(path.with_extension("toml").exists(), "{}", path.display());
        }
    }
}

/// Good scenes in which nothing touches anything: bodies fall after they came, or are deleted.
const WITHOUT_CONTACT: [&str; 10] = [
    "deletions",
    "insertion-full",
    "insertion-mass-rate",
    "insertion-mixture",
    "insertion-number",
    "insertion-partly-outside",
    "insertion-quota",
    "insertion-table",
    "insertion-volume",
    "lattice-and-table",
];

#[test]
fn good_scenes_run_to_their_end() {
    let files = scenes("good");
    assert!(files.len() >= 30, "only {} scenes", files.len());
    for path in files {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let plan = planned(&path).unwrap_or_else(|errors| panic!("{name}:\n{errors}"));
        assert!(
            plan.notes().warnings().is_empty(),
            "{name}: {:?}",
            plan.notes().warnings()
        );
        assert!(
            plan.physics().steps <= 500,
            "{name}: {} steps are many",
            plan.physics().steps
        );
        let inserts = !plan.physics().insertions.is_empty();
        let deletes = !plan.physics().deletions.is_empty();
        let target = tempfile::tempdir().expect("a folder for the run");
        folder::prepare(
            target.path(),
            plan.outputs().prefix(),
            folder::Earlier::Replace,
        )
        .expect("the folder is ready");
        let options = RunOptions {
            folder: target.path().to_owned(),
            threads: 1,
            ..RunOptions::default()
        };
        let report =
            run(plan, &options, &mut |_| ()).unwrap_or_else(|failure| panic!("{name}: {failure}"));
        let summary = report.summary;
        assert_eq!(summary.status, Status::Finished, "{name}");
        // The lid of one of them has only begun to press when the run ends, another one ends long before it is at rest: their
        // warnings are expected.
        let is_expected = |warning: &str| match &*name {
            "servo-and-region" => warning.starts_with("servo of `lid`: "),
            "automatic-step" => warning.starts_with("not at rest: "),
            _ => false,
        };
        let warnings = summary.warnings.iter();
        let unexpected: Vec<_> = warnings.filter(|reported| !is_expected(reported)).collect();
        assert!(unexpected.is_empty(), "{name}: {unexpected:?}");
        let energy = &summary.energy;
        let parts = [
            energy.kinetic,
            energy.rotational,
            energy.gravitational,
            energy.elastic,
        ];
        assert!(
            parts.iter().all(|part| part.is_finite()),
            "{name}: {parts:?}"
        );
        assert!(energy.kinetic >= 0.0 && energy.rotational >= 0.0, "{name}");
        assert_eq!(summary.inserted > 0, inserts, "{name}");
        assert_eq!(summary.deleted > 0, deletes, "{name}");
        // Bodies of a scene with contacts touch, and lose energy.
        if !WITHOUT_CONTACT.contains(&&*name) {
            let lost = (energy.dissipated.as_ref()).map_or(0.0, |lost| lost.of("normal"));
            assert!(lost > 0.0, "{name}: nothing has touched anything");
        }
    }
}
