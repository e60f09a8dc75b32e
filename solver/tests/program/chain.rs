//! The chain of a run, and checkpoints that stay.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mercury_solver::output::chain::{Chain, kept_checkpoints, state_sum};
use mercury_solver::plan::sha256;
use mercury_solver::run::checkpoint;

use crate::common::{errors, facts, folder_with, results, solve};

/// Spheres that fall on each other and on a plane that shakes.
pub(crate) const HEAP: &str = r#"
title = "A heap"
gravity = [0.0, 0.0, -9.81]
[time]
end = 0.05
step = 2e-5
[domain]
min = [0, 0, 0]
max = [0.04, 0.04, 0.2]
periodic = ["x", "y"]
[output]
interval = 1.3e-3
fstat = true
fstat_interval = 3.1e-3
pictures = false
link_interval = 2e-3
keep_checkpoints = 5
[results]
load = "mean(walls.base.fz)"
[materials.m]
density = 2000.0
normal = { law = "linear", stiffness = 400.0, restitution = 0.7 }
tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
[[walls]]
name = "base"
shape = "plane"
normal = [0, 0, 1]
point = [0, 0, 0]
material = "m"
motion = [{ kind = "oscillation", amplitude = [1e-3, 0, 0], frequency = 40.0 }]
[[insertions]]
name = "rain"
material = "m"
region = { shape = "box", min = [0, 0, 0.004], max = [0.04, 0.04, 0.06] }
velocity = { mean = [0, 0, -0.6], spread = [0.2, 0.2, 0.1] }
total = { number = 150 }
psd = { kind = "uniform", min_diameter = 4e-3, max_diameter = 6e-3, weighting = "number" }
"#;

/// Runs the heap in a folder, to a folder in it.
pub(crate) fn run(place: &Path, output: &str, more: &[&str]) {
    let ran = solve(
        place,
        &[&["heap.toml", "--quiet", "--output", output], more].concat(),
    );
    assert!(ran.status.success(), "{}", errors(&ran));
}

/// Files of a run without those that differ by a setting of links.
fn outputs(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = results(folder, "heap");
    files.retain(|name, _| !name.contains("chain") && !name.contains("checkpoint"));
    files
}

#[test]
fn a_chain_is_the_same_at_any_number_of_threads_and_lanes() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &["--threads", "1"]);
    let more = [
        &["--threads", "2", "--fixed-threads"][..],
        &["--threads", "3", "--fixed-threads"],
        &["--threads", "1", "--lanes", "1"],
        &["--threads", "1", "--checkpoint-every", "0.01s"],
    ];
    let of = |name: &str| results(&place.path().join(name), "heap");
    let one = of("a");
    assert!(one.contains_key("heap.chain.jsonl"));
    for (number, more) in more.into_iter().enumerate() {
        let name = number.to_string();
        run(place.path(), &name, more);
        let other = of(&name);
        assert!(one.keys().eq(other.keys()), "{more:?}");
        for (name, bytes) in &one {
            assert!(*bytes == other[name], "{name} differs with {more:?}");
        }
        let folders = ["a", &name].map(|name| facts(&place.path().join(name)));
        assert_eq!(folders[0], folders[1]);
    }
}

#[test]
fn links_say_what_is_in_the_files_and_change_nothing() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &[]);
    let folder = place.path().join("a");
    let chain = Chain::read(&folder.join("heap.chain.jsonl")).unwrap();
    // 2500 steps, a link for each 100.
    let steps: Vec<u64> = chain.links().map(|(link, _)| link.step).collect();
    assert_eq!(steps, (1..=25).map(|k| 100 * k).collect::<Vec<_>>());
    let end = chain.end().unwrap();
    assert_eq!((end.end.as_str(), end.link.step), ("planned", 2500));
    for (link, _) in chain.links().chain([(&end.link, "")]) {
        assert!(link.outputs.len() > 5, "{:?}", link.outputs.keys());
        for (name, (bytes, sum)) in &link.outputs {
            let file = fs::read(folder.join(name)).unwrap();
            assert_eq!(sha256(&file[..*bytes as usize]), *sum, "{name}");
        }
    }
    for (name, (bytes, _)) in &end.link.outputs {
        let length = fs::metadata(folder.join(name)).unwrap().len();
        assert_eq!(length, *bytes, "{name}");
    }
    let summary = facts(&folder);
    assert_eq!(summary["link"], chain.last());
    assert_eq!(summary["physics"], chain.first().physics);
    let value = summary["results"]["load"]["value"].as_f64();
    assert_eq!(end.results["load"].value, value);
    assert!(value.is_some());

    // At every eighth link, as at most 5 of 25 stay.
    let kept = kept_checkpoints(&folder, "heap");
    let expected = [800, 1600, 2400];
    let spaced: Vec<u64> = kept.keys().copied().collect();
    assert!(spaced.len() <= 5, "{spaced:?}");
    assert_eq!(spaced, expected);
    for (step, path) in kept {
        let checkpoint = checkpoint::read(&path).unwrap();
        let (link, _) = chain.links().find(|(link, _)| link.step == step).unwrap();
        let sections = checkpoint.sections();
        assert_eq!(
            state_sum(
                sections
                    .iter()
                    .map(|(name, content)| (*name, [&content[..]]))
            ),
            link.state
        );
        for (name, (bytes, _)) in &link.outputs {
            let at = checkpoint.positions.streams()[name.strip_prefix("heap.").unwrap()];
            assert!(name.ends_with(".arrow") || at == *bytes, "{name}");
        }
    }

    run(
        place.path(),
        "b",
        &[
            "--set",
            "output.link_interval=0.02",
            "--set",
            "output.keep_checkpoints=0",
        ],
    );
    let other = place.path().join("b");
    assert_eq!(outputs(&folder), outputs(&other));
    assert!(!other.join("heap.checkpoints").exists());
    // By default a hundredth of the end, but no more often than every 200 steps.
    let plain = HEAP.replace("link_interval = 2e-3\n", "");
    fs::write(place.path().join("heap.toml"), plain).unwrap();
    run(place.path(), "c", &[]);
    let chain = Chain::read(&place.path().join("c/heap.chain.jsonl")).unwrap();
    assert_eq!(chain.links().count(), 12);
}

#[test]
fn a_run_that_goes_on_with_another_scene_says_so_in_its_chain() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &["--set", "time.end=0.03"]);
    run(place.path(), "a", &["--resume"]);
    run(place.path(), "b", &[]);
    let [a, b] = ["a", "b"].map(|name| {
        let folder = place.path().join(name);
        Chain::read(&folder.join("heap.chain.jsonl")).unwrap()
    });
    assert_eq!(a.stated().1, 1500);
    assert_eq!(a.stated().0, b.stated().0);
    assert_eq!(a.first().stated.set, ["time.end=0.03"]);
    let states =
        |chain: &Chain| -> Vec<_> { chain.links().map(|(link, _)| link.clone()).collect() };
    assert_eq!(states(&a), states(&b));
    // --force replaces what stayed, too.
    assert!(kept_checkpoints(&place.path().join("a"), "heap").len() > 2);
    run(
        place.path(),
        "a",
        &["--force", "--set", "output.keep_checkpoints=0"],
    );
    assert!(!place.path().join("a/heap.checkpoints").exists());
}
