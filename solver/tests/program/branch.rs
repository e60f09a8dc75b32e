//! Branches of runs: `--from RUN --at TIME`.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

use mercury_engine::step::Engine;
use mercury_solver::output::chain::{Chain, kept_checkpoints};
use mercury_solver::plan::{plan, read_scene};
use mercury_solver::run::{Branch, RunOptions, checkpoint};

use super::chain::{HEAP, run};
use crate::common::{code, errors, facts, folder_with, results, solve};

/// All files of a folder.
fn all(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let files = entries.filter(|entry| entry.path().is_file());
    files
        .map(|entry| {
            let name = entry.file_name().into_string().unwrap();
            (name, fs::read(entry.path()).unwrap())
        })
        .collect()
}

/// Branches off from the run `a` in a folder.
fn branch(place: &Path, at: &str, output: &str, more: &[&str]) {
    let command = ["--from", "a", "--at", at, "--output", output, "--quiet"];
    let ran = solve(place, &[&command, more].concat());
    assert!(ran.status.success(), "{at}: {}", errors(&ran));
}

#[test]
fn a_branch_without_changes_has_the_bytes_of_its_run() {
    let place = folder_with("heap.toml", HEAP);
    run(
        place.path(),
        "a",
        &[
            "--set",
            "output.vtk=true",
            "--set",
            "output.vtk_interval=0.004",
        ],
    );
    let parent = place.path().join("a");
    let before = all(&parent);
    let kept = kept_checkpoints(&parent, "heap");
    assert_eq!(kept.keys().copied().collect::<Vec<_>>(), [800, 1600, 2400]);
    let one = results(&parent, "heap");
    // Before the first checkpoint, at one, at a link without, between links, and at a frame.
    let times = [
        ("0.0021", 105, Some(100)),
        ("16 ms", 800, Some(800)),
        ("0.02", 1000, Some(1000)),
        ("0.04101", 2051, Some(2000)),
        ("0.0494", 2470, Some(2400)),
    ];
    for (at, step, link) in times {
        branch(place.path(), at, at, &["--threads", "2"]);
        let folder = place.path().join(at);
        let other = results(&folder, "heap");
        assert!(one.keys().eq(other.keys()), "{at}");
        for (name, bytes) in &one {
            assert!(*bytes == other[name], "{at}: {name} differs");
        }
        let [mut there, mut here] = [&parent, &folder].map(|folder| facts(folder));
        let origin = here["branch_of"].take();
        there["branch_of"].take();
        assert_eq!(there, here, "{at}");
        assert_eq!(
            (&origin["run"], &origin["step"]),
            (&"a".into(), &step.into())
        );
        let chain = Chain::read(&parent.join("heap.chain.jsonl")).unwrap();
        let linked = chain.links().find(|(of, _)| Some(of.step) == link);
        assert_eq!(
            origin["link"].as_str(),
            linked.map(|(_, link)| link),
            "{at}"
        );
    }
    assert!(before == all(&parent), "the run was changed");
}

#[test]
fn a_branch_goes_on_as_if_the_library_had_changed_the_scene_at_its_step() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &[]);
    let gravity = "gravity=[1.5,0,-4]";
    branch(place.path(), "0.0257", "b", &["--set", gravity]);
    let planned = |set: &[&str]| {
        let set: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
        let scene = read_scene(&place.path().join("heap.toml"), &set).unwrap();
        Arc::new(plan(&scene).unwrap())
    };
    let mut engine = Engine::new(planned(&[]), 1).unwrap();
    engine.steps_at_once(1285, None).unwrap();
    engine.complete_step().unwrap();
    let mut engine = Engine::restore(planned(&[gravity]), engine.snapshot(), 1).unwrap();
    engine.steps_at_once(2500 - 1285, None).unwrap();
    engine.complete_step().unwrap();
    let folder = place.path().join("b");
    let (newest, _) = checkpoint::newest(&folder, "heap").unwrap().unwrap();
    assert_eq!(newest.head.step, 2500);
    assert_eq!(newest.snapshot, engine.snapshot());
    // The links up to there are those of the run, then the chain has the new scene.
    let [one, other] = ["a", "b"].map(|name| place.path().join(name).join("heap.chain.jsonl"));
    let [one, other] = [one, other].map(|path| Chain::read(&path).unwrap());
    assert_eq!(one.lines[..13], other.lines[..13]);
    assert_eq!(other.stated().1, 1285);
    assert_eq!(other.stated().0.set, [gravity]);
    assert_ne!(one.last(), other.last());
    // It can be made longer like any run, and keeps its origin.
    let longer = ["--resume", "--set", gravity, "--set", "time.end=0.06"];
    run(place.path(), "b", &longer);
    assert_eq!(facts(&folder)["branch_of"]["step"], 1285);
    assert_eq!(facts(&folder)["steps"], 3000);
    // And a branch of a branch.
    let ran = solve(
        place.path(),
        &["--from", "b", "--at", "0.055", "--output", "c", "--quiet"],
    );
    assert!(ran.status.success(), "{}", errors(&ran));
    assert_eq!(
        results(&folder, "heap"),
        results(&place.path().join("c"), "heap")
    );
}

#[test]
fn steps_that_are_made_again_have_progress() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &[]);
    let options = RunOptions {
        folder: place.path().join("b"),
        ..RunOptions::default()
    };
    fs::create_dir(&options.folder).unwrap();
    let branch = Branch::plan(&place.path().join("a"), 0.0257, &[]).unwrap();
    let mut steps = Vec::new();
    let made = branch.make(&options, &mut |progress| {
        steps.push(progress.engine.steps());
    });
    assert_eq!(made.unwrap().head.step, 1285);
    assert!(!steps.is_empty() && steps.iter().all(|step| (1..=1285).contains(step)));
}

#[test]
fn motions_and_laws_may_change_where_nothing_jumps() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &[]);
    // It stands at 1 mm x sin(2 pi 40/s t) = 0 after every half period of 12.5 ms.
    let stop = "walls.base.motion[0].until=0.025";
    let stiffness = "materials.m.normal.stiffness=300";
    branch(
        place.path(),
        "0.025",
        "b",
        &["--set", stop, "--set", stiffness],
    );
    let refused = solve(
        place.path(),
        &[
            "--from",
            "a",
            "--at",
            "0.03",
            "--output",
            "c",
            "--set",
            "walls.base.motion[0].frequency=41",
        ],
    );
    assert_eq!(code(&refused), Some(2));
    let said = errors(&refused);
    assert!(
        said.contains("--from: walls[0].motion: wall `base` would stand elsewhere at t = 0.03 s"),
        "{said}"
    );
    assert!(!place.path().join("c/heap.0.restart").exists());
}

#[test]
fn branches_that_cannot_be_are_refused_in_words() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &[]);
    let refused = |run: &str, at: &str, more: &[&str], text: &str| {
        let command = ["--from", run, "--at", at, "--output", "x"];
        let ran = solve(place.path(), &[&command, more].concat());
        assert_eq!(code(&ran), Some(2), "{more:?} {}", errors(&ran));
        assert!(
            errors(&ran).contains(text),
            "{more:?} {text}: {}",
            errors(&ran)
        );
        assert!(!place.path().join("x/heap.ene").exists());
    };
    refused("none", "0.02", &[], "none: there is no run in this folder");
    refused(
        "a",
        "0.07",
        &[],
        "--at 0.07: the run was made from 0 to 0.05 s",
    );
    refused("a", "-1", &[], "must be above 0");
    refused("a", "nan", &[], "invalid value 'nan'");
    refused(
        "a",
        "0.02",
        &["--set", "time.end=0.01"],
        "--at 0.02: time.end is 0.01 s",
    );
    let set = |set: &str, text: &str| refused("a", "0.02", &["--set", set], text);
    set(
        "walls.base.point[2]=-0.001",
        "walls[0].point[2]: 0 then, -0.001 now",
    );
    set(
        "walls.base.name=\"lid\"",
        "walls[0].name: \"base\" then, \"lid\" now",
    );
    set(
        "materials.m.density=2100",
        "materials.m.density: 2000 then, 2100 now",
    );
    set("materials.m.normal.law=\"hertz\"", "law");
    set("domain.max[2]=0.3", "domain.max[2]: 0.2 then, 0.3 now");
    set("seed=3", "seed: absent then, 3 now");
    set(
        "insertions.rain.total.number=3",
        "insertions[0].total.number: 150 then, 3 now",
    );
    set(
        "output.energy_budget=true",
        "output.energy_budget: absent then, true now",
    );
    set(
        "time.step=1e-5",
        "time.step is 0.00002 s in the run and 0.00001 s here",
    );
    set(
        "materials.m.normal.stiffness=1e7",
        "the integration would be unstable",
    );
    set(
        "insertions.rain.rate.number=1e4",
        "insertions[0].rate: by t = 0.02 s",
    );
    set("materials.m.tangential.friction=0", "laws of a pair: ");
    let command = ["--from", "a", "--at", "0.02", "--output", "a", "--force"];
    let same = solve(place.path(), &command);
    assert_eq!(code(&same), Some(2));
    assert!(errors(&same).contains("this is the folder of the run itself"));
    let with = ["heap.toml", "--from", "a", "--at", "0.02", "--output", "x"];
    assert_eq!(code(&solve(place.path(), &with)), Some(2));
    // A run that is written, a scene that was edited, a chain that was lost.
    let lock = File::create(place.path().join("a/.lock")).unwrap();
    lock.lock().unwrap();
    refused(
        "a",
        "0.02",
        &[],
        "a: this folder is being written by another run",
    );
    drop(lock);
    fs::remove_file(place.path().join("a/.lock")).unwrap();
    let scene = place.path().join("a/heap.scene.toml");
    fs::write(&scene, HEAP.replace("9.81", "9.82")).unwrap();
    refused(
        "a",
        "0.02",
        &[],
        "heap.scene.toml: the file (scene) is not the one of which the run was made",
    );
    fs::write(&scene, HEAP).unwrap();
    // Checkpoints that stayed, cut and foreign: without them the steps are made from the start.
    for path in kept_checkpoints(&place.path().join("a"), "heap").into_values() {
        fs::write(path, "foreign").unwrap();
    }
    branch(place.path(), "0.03", "y", &[]);
    assert_eq!(
        results(&place.path().join("a"), "heap")["heap.particles.arrow"],
        results(&place.path().join("y"), "heap")["heap.particles.arrow"]
    );
    fs::remove_file(place.path().join("a/heap.chain.jsonl")).unwrap();
    refused(
        "a",
        "0.02",
        &[],
        "a: the run has no chain (there is no heap.chain.jsonl)",
    );
}
