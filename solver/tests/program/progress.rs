//! `--progress FILE`: the events that a run reports while it goes on, and that a service can rely on them.

use std::fs;
use std::path::Path;

use crate::common::{code, command, errors, results, said, signal, solve};
use mercury_common::frames::{FrameReader, ParticleReader};
use serde_json::Value;

const SCENE: &str = r#"
gravity = [0.0, 0.0, -9.81]

[time]
end = 0.004
step = 1e-5

[domain]
min = [0.0, 0.0, 0.0]
max = [0.1, 0.1, 0.1]

[materials.glass]
density = 2500.0
normal = { law = "linear", stiffness = 1000.0, restitution = 0.8 }

[[walls]]
name = "plate"
material = "glass"
shape = "mesh"
file = "plate.stl"

[[particles]]
material = "glass"
radius = 0.01
position = [0.03, 0.03, 0.0101]
velocity = [0.1, 0.0, -0.1]

[[particles]]
material = "glass"
radius = 0.01
position = [0.0501, 0.03, 0.0101]
velocity = [-0.1, 0.0, 0.0]

[[regions]]
name = "all"
region = { shape = "box", min = [0, 0, 0], max = [0.1, 0.1, 0.1] }

[[fields]]
name = "mean"
fields = ["density"]
grid = [2]
coordinates = "Z"
width = 0.01
average = true

[[fields]]
name = "looks"
fields = ["density"]
grid = [2]
coordinates = "Z"
width = 0.01

[output]
interval = 0.001
restart_interval = 0.002
fstat = true
vtk = true
pictures = false
"#;

const PLATE: &str = "solid plate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid plate\n";

fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("pair.toml"), SCENE).unwrap();
    fs::write(folder.path().join("plate.stl"), PLATE).unwrap();
    folder
}

/// The lines of a complete file.
fn lines(path: &Path) -> Vec<Value> {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.ends_with('\n'));
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}")))
        .collect()
}

fn of<'a>(lines: &'a [Value], event: &str) -> Vec<&'a Value> {
    lines.iter().filter(|line| line["event"] == event).collect()
}

fn outputs(line: &Value) -> Vec<(String, usize)> {
    let files = line["outputs"].as_array().unwrap().iter();
    files
        .map(|file| {
            let bytes = file["bytes"].as_u64().unwrap() as usize;
            (file["name"].as_str().unwrap().to_owned(), bytes)
        })
        .collect()
}

#[test]
fn a_run_is_reported_from_its_begin_to_its_end() {
    let folder = place();
    let output = solve(
        folder.path(),
        &["pair.toml", "--quiet", "--json", "--progress", "log"],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let summary: Value = serde_json::from_str(&said(&output)).unwrap();
    let reported = lines(&folder.path().join("log"));
    let (first, last) = (&reported[0], &reported[reported.len() - 1]);
    assert_eq!(first["event"], "begin");
    assert_eq!(first["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(first["scene"], "pair.toml");
    let clocks: Vec<f64> = reported
        .iter()
        .map(|line| line["clock"].as_f64().unwrap())
        .collect();
    // Of this century, and none before the one above it.
    assert!(clocks[0] > 1.7e9 && clocks.is_sorted(), "{clocks:?}");
    let mut phases: Vec<&str> = (of(&reported, "phase").iter())
        .map(|line| line["phase"].as_str().unwrap())
        .collect();
    // More than once where one lasts for a second.
    phases.dedup();
    assert_eq!(phases, ["planning", "starting", "stepping", "finishing"]);
    let run = of(&reported, "run")[0];
    assert_eq!(
        (&run["folder"], &run["prefix"]),
        (&"pair".into(), &"pair".into())
    );
    assert_eq!(
        (&run["steps"], &run["resumed"]),
        (&400.into(), &Value::Null)
    );
    let steps: Vec<u64> = (of(&reported, "frame").iter())
        .map(|line| line["step"].as_u64().unwrap())
        .collect();
    assert_eq!(steps, [0, 100, 200, 300, 400]);
    let checkpoints: Vec<(u64, &str)> = (of(&reported, "checkpoint").iter())
        .map(|line| {
            (
                line["step"].as_u64().unwrap(),
                line["file"].as_str().unwrap(),
            )
        })
        .collect();
    assert_eq!(
        checkpoints,
        [(200, "pair.0.restart"), (400, "pair.1.restart")]
    );
    for line in of(&reported, "checkpoint") {
        let path = folder
            .path()
            .join("pair")
            .join(line["file"].as_str().unwrap());
        assert_eq!(fs::metadata(path).unwrap().len(), line["bytes"]);
    }
    assert_eq!(last["event"], "end");
    assert_eq!(
        (&last["code"], &last["status"]),
        (&0.into(), &"finished".into())
    );
    assert_eq!(
        (&last["cause"], &last["step"]),
        (&"planned".into(), &400.into())
    );
    assert_eq!(last["time"], summary["time"]);
    let files = last["files"].as_array().unwrap();
    for file in files {
        let path = folder
            .path()
            .join("pair")
            .join(file["name"].as_str().unwrap());
        assert_eq!(fs::metadata(path).unwrap().len(), file["bytes"]);
    }
    let names: Vec<&str> = files
        .iter()
        .map(|file| file["name"].as_str().unwrap())
        .collect();
    assert!(
        names.contains(&"summary.json") && names.contains(&"pair.fields.mean.csv"),
        "{names:?}"
    );
}

/// Lines of frames stay true for ever: each gives the first bytes of a file, and the number of whole frames in them.
#[test]
fn what_is_reported_of_a_frame_is_whole_and_stays() {
    let folder = place();
    let output = solve(
        folder.path(),
        &["pair.toml", "--quiet", "--progress", "log"],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let reported = lines(&folder.path().join("log"));
    let run = folder.path().join("pair");
    let mut seen = std::collections::BTreeSet::new();
    for (number, line) in of(&reported, "frame").iter().enumerate() {
        for (name, bytes) in outputs(line) {
            let whole = fs::read(run.join(&name)).unwrap();
            assert!(bytes <= whole.len(), "{name}");
            seen.insert(name.clone());
            let part = folder.path().join("part.arrow");
            if name.ends_with(".arrow") {
                // Arrow's end-of-stream marker.
                let marked = [&whole[..bytes], &[0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0]].concat();
                fs::write(&part, marked).unwrap();
                let reader = FrameReader::open(&part).unwrap();
                assert!(reader.damage().is_none());
                assert_eq!(reader.len(), number + 1, "{name}");
            } else if name.ends_with(".vtu") {
                assert_eq!(bytes, whole.len(), "{name}");
                assert!(name.ends_with(&format!(".{number:04}.vtu")), "{name}");
            } else {
                assert_eq!(whole[bytes - 1], b'\n', "{name}");
                let text = String::from_utf8(whole[..bytes].to_vec()).unwrap();
                let count = match name.as_str() {
                    // A head, and a line for each of two particles.
                    "pair.data" => text.lines().count() / 3,
                    "pair.ene" | "pair.walls.csv" | "pair.regions.csv" => text.lines().count() - 1,
                    _ => number + 1,
                };
                assert_eq!(count, number + 1, "{name}");
            }
        }
    }
    for name in [
        "pair.data",
        "pair.ene",
        "pair.fstat",
        "pair.particles.arrow",
        "pair.contacts.arrow",
        "pair.walls.arrow",
        "pair.walls.csv",
        "pair.regions.csv",
        "vtk/pair.particles.0004.vtu",
        "vtk/pair.walls.0000.vtu",
    ] {
        assert!(seen.contains(name), "{name}: {seen:?}");
    }
}

/// A service keeps a checkpoint and, of each file that grows, the bytes that it counts on: with these alone a run goes on elsewhere, to the
/// same bytes.
#[test]
fn a_run_goes_on_elsewhere_from_what_a_checkpoint_counts_on() {
    let folder = place();
    let output = solve(
        folder.path(),
        &["pair.toml", "--quiet", "--progress", "log"],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let reported = lines(&folder.path().join("log"));
    let checkpoint = of(&reported, "checkpoint")[0];
    let (here, there) = (folder.path().join("pair"), folder.path().join("elsewhere"));
    fs::create_dir_all(there.join("vtk")).unwrap();
    let name = checkpoint["file"].as_str().unwrap();
    for whole in [
        name,
        "pair.surfaces.arrow",
        "plan.toml",
        "pair.fields.mean.csv",
    ] {
        fs::copy(here.join(whole), there.join(whole)).unwrap();
    }
    for (name, bytes) in outputs(checkpoint) {
        let all = fs::read(here.join(&name)).unwrap();
        fs::write(there.join(&name), &all[..bytes]).unwrap();
    }
    // Of the files for ParaView those that were reported until then, and the lists as they are.
    for line in &reported {
        if line["event"] == "frame" && line["step"].as_u64() <= checkpoint["step"].as_u64() {
            for (name, _) in outputs(line)
                .iter()
                .filter(|(name, _)| name.starts_with("vtk/"))
            {
                fs::copy(here.join(name), there.join(name)).unwrap();
            }
        }
    }
    for entry in fs::read_dir(here.join("vtk")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "pvd") {
            fs::copy(&path, there.join("vtk").join(path.file_name().unwrap())).unwrap();
        }
    }
    let arguments = [
        "pair.toml",
        "--quiet",
        "--resume",
        "--output",
        "elsewhere",
        "--progress",
        "more",
    ];
    let output = solve(folder.path(), &arguments);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let (expected, found) = (results(&here, "pair"), results(&there, "pair"));
    assert_eq!(
        found.keys().collect::<Vec<_>>(),
        expected.keys().collect::<Vec<_>>()
    );
    for (name, bytes) in &expected {
        assert!(found[name] == *bytes, "{name} differs");
    }
    let more = lines(&folder.path().join("more"));
    let resumed = &of(&more, "run")[0]["resumed"];
    assert_eq!(
        (&resumed["file"], &resumed["step"]),
        (&checkpoint["file"], &200.into())
    );
    let frames: Vec<u64> = (of(&more, "frame").iter())
        .map(|line| line["step"].as_u64().unwrap())
        .collect();
    assert_eq!(frames, [300, 400]);
    let reader = ParticleReader::open(there.join("pair.particles.arrow")).unwrap();
    assert_eq!(reader.frames().len(), 5);
    // Nothing is left to do: the same end again, with the summary.
    let arguments = ["pair.toml", "--json", "--resume", "--progress", "again"];
    let output = solve(folder.path(), &arguments);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let kept = fs::read_to_string(here.join("summary.json")).unwrap();
    assert_eq!(said(&output).trim(), kept.trim());
    let again = lines(&folder.path().join("again"));
    let last = &again[again.len() - 1];
    assert_eq!(
        (&last["code"], &last["status"]),
        (&0.into(), &"finished".into())
    );
}

#[cfg(unix)]
#[test]
fn a_long_run_is_reported_by_the_clock_and_stopped() {
    let folder = place();
    // Steps so short that the grains are still in the domain when a fast machine has made some seconds' worth of them.
    let arguments = [
        "pair.toml",
        "--quiet",
        "--set",
        "time.end=1",
        "--set",
        "time.step=1e-8",
        "--set",
        "output.interval=1",
        "--progress",
        "log",
    ];
    let mut child = command(folder.path(), &arguments).spawn().unwrap();
    let path = folder.path().join("log");
    let seen = || {
        let text = fs::read_to_string(&path).unwrap_or_default();
        text.matches("\"event\":\"step\"").count()
    };
    while seen() < 2 {
        assert!(
            child.try_wait().unwrap().is_none(),
            "the run ended by itself"
        );
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    signal(&child, "TERM");
    assert_eq!(child.wait().unwrap().code(), Some(75));
    let reported = lines(&path);
    let steps = of(&reported, "step");
    let step = |line: &Value| line["step"].as_u64().unwrap();
    assert!(step(steps[1]) > step(steps[0]), "{steps:?}");
    let clock = |line: &Value| line["clock"].as_f64().unwrap();
    // By the clock, not by steps: a tenth of a second is the slack of a busy machine in one direction, the other has none.
    assert!(clock(steps[1]) - clock(steps[0]) > 0.9, "{steps:?}");
    let one = steps[0];
    assert_eq!(
        (&one["of_steps"], &one["particles"]),
        (&100_000_000.into(), &2.into())
    );
    for number in [
        "time",
        "end",
        "kinetic_energy",
        "particle_steps_per_second",
        "seconds_left",
    ] {
        assert!(one[number].as_f64().unwrap() > 0.0, "{number}: {one}");
    }
    let (checkpoint, last) = (of(&reported, "checkpoint"), &reported[reported.len() - 1]);
    assert_eq!(
        (&last["code"], &last["status"]),
        (&75.into(), &"stopped".into())
    );
    assert_eq!(
        (&last["cause"], &last["step"]),
        (&"request".into(), &checkpoint[checkpoint.len() - 1]["step"])
    );
    assert_eq!(last["problems"], Value::Null);
}

#[test]
fn what_cannot_be_run_is_reported_too() {
    let folder = place();
    let reported = |arguments: &[&str]| {
        let arguments = [arguments, &["--progress", "log"]].concat();
        let output = solve(folder.path(), &arguments);
        let reported = lines(&folder.path().join("log"));
        (code(&output), reported[reported.len() - 1].clone())
    };
    let (code, last) = reported(&["pair.toml", "--set", "time.step=-1"]);
    assert_eq!(
        (code, &last["code"], &last["status"]),
        (Some(2), &2.into(), &"refused".into())
    );
    assert_eq!(last["problems"][0]["key"], "time.step");
    assert_eq!(
        (&last["step"], &last["files"]),
        (&Value::Null, &Value::Null)
    );
    // Two grains inside each other: the guard ends the run.
    let (code, last) = reported(&["pair.toml", "--set", "particles.0.velocity=[1e3,0,0]"]);
    assert_eq!(
        (code, &last["code"], &last["status"]),
        (Some(1), &1.into(), &"failed".into())
    );
    assert!(
        last["problems"][0]["message"]
            .as_str()
            .unwrap()
            .starts_with("the run failed: ")
    );
    let output = solve(
        folder.path(),
        &["pair.toml", "--progress", "no/such/folder"],
    );
    assert_eq!(output.status.code(), Some(2));
    assert!(
        errors(&output).contains("--progress no/such/folder"),
        "{}",
        errors(&output)
    );
    fs::write(
        folder.path().join("study.toml"),
        "[study]\nscene = \"pair.toml\"\nsweep = { seed = [1, 2] }\n",
    )
    .unwrap();
    let (code, last) = reported(&["study.toml"]);
    assert_eq!(code, Some(2));
    assert!(
        last["problems"][0]["help"]
            .as_str()
            .unwrap()
            .contains("--check --json")
    );
}

/// The run is what matters.
#[cfg(target_os = "linux")]
#[test]
fn a_file_that_takes_nothing_does_not_end_the_run() {
    let folder = place();
    let output = solve(
        folder.path(),
        &["pair.toml", "--quiet", "--progress", "/dev/full"],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let reported = errors(&output);
    assert_eq!(
        reported.matches("warning: --progress /dev/full").count(),
        1,
        "{reported}"
    );
}
