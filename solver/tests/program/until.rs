//! `[results]` and `time.until`: a run ends when its results are known, whatever the threads and wherever it was interrupted.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{code, errors, folder_with, said, solve};

/// A gas of elastic balls in a box: the load on a wall has a mean from the start, and a correlation of some rows.
const GAS: &str = r#"title = "A gas of elastic balls"
seed = 3

[time]
end = 200.0
step = 5e-4
until = { result = "load", error = "8 %" }

[domain]
min = [0.0, 0.0, 0.0]
max = [1.0, 1.0, 1.0]

[materials.ball]
density = 1000.0
normal = { law = "linear", stiffness = 5e3, dissipation = 0.0 }

[[walls]]
name = "box"
shape = "box"
material = "ball"

[[insertions]]
name = "fill"
material = "ball"
region = { shape = "box", min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }
psd = { kind = "monodisperse", diameter = 0.12 }
total = { number = 40 }
velocity = { mean = [0.0, 0.0, 0.0], spread = [1.0, 1.0, 1.0] }

[results]
load = "mean(walls.\"box.-z\".fz, steady..)"

[output]
interval = 0.01
frames = false
pictures = false
"#;

fn summary(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("summary.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn run(folder: &Path, arguments: &[&str]) {
    let output = solve(folder, arguments);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
}

#[test]
fn a_run_ends_when_its_result_is_known() {
    let folder = folder_with("gas.toml", GAS);
    let arguments = ["gas.toml", "--quiet", "--threads", "2", "--fixed-threads"];
    let reported = [&arguments[..], &["--progress", "events"]].concat();
    run(folder.path(), &reported);
    let whole = summary(&folder.path().join("gas"));
    assert_eq!(whole["status"], "finished");
    let until = &whole["until"][0];
    assert_eq!(
        (&until["result"], &until["reached"]),
        (&"load".into(), &true.into())
    );
    let load = &whole["results"]["load"];
    let number = |key: &str| load[key].as_f64().unwrap();
    assert!(number("batches") >= 32.0);
    // The last step adds a row behind the look, which changes neither much.
    assert!(number("error") <= 0.081 * number("value").abs());
    let end = whole["time"].as_f64().unwrap();
    assert!((0.64..200.0).contains(&end), "{end}");

    // A row and an event for each look; it is known at the last two.
    let table = fs::read_to_string(folder.path().join("gas/gas.results.csv")).unwrap();
    let head =
        "time [s],name,unit,value,error,low,high,wanted,batches,from [s],to [s],steady,more [s]";
    assert_eq!(table.lines().next(), Some(head));
    let rows: Vec<Vec<&str>> = (table.lines().skip(1))
        .map(|line| line.split(',').collect())
        .collect();
    let events = fs::read_to_string(folder.path().join("events")).unwrap();
    let events: Vec<Value> = (events.lines())
        .map(|line| serde_json::from_str::<Value>(line).unwrap())
        .filter(|event| event["event"] == "result")
        .collect();
    assert_eq!(events.len(), rows.len());
    for (row, event) in rows.iter().zip(&events) {
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        assert_eq!((row[1], row[2]), ("load", "N"));
        let members = ["time", "value", "error", "wanted", "batches", "more"]
            .map(|name| event[name].as_f64().unwrap());
        assert_eq!(members, [0, 3, 4, 7, 8, 12].map(number));
        assert!(number(5) < number(3) && number(3) < number(6));
    }
    let known: Vec<bool> = rows.iter().map(|row| row[12] == "0.0").collect();
    assert!(
        known.ends_with(&[true, true])
            && !known[..known.len() - 2]
                .windows(2)
                .any(|two| two == [true, true])
    );

    // Stopped in the middle, and one step after the result was known: the same bytes.
    for stop in [0.4 * end, end - 1e-4] {
        // A multiple of the interval, as the end of a run is a row, too.
        let stop = format!("time.end={}", (stop * 100.0).floor() / 100.0);
        let again = [
            "gas.toml", "--quiet", "--force", "--output", "again", "--set", &stop,
        ];
        run(folder.path(), &again);
        let on = [
            "gas.toml",
            "--quiet",
            "--resume",
            "--output",
            "again",
            "--threads",
            "1",
            "--lanes",
            "1",
        ];
        run(folder.path(), &on);
        for file in ["gas.walls.csv", "gas.ene", "gas.data", "gas.results.csv"] {
            let [one, other] =
                ["gas", "again"].map(|run| fs::read(folder.path().join(run).join(file)).unwrap());
            assert!(one == other, "{file}, {stop}");
        }
        assert_eq!(
            summary(&folder.path().join("again"))["until"],
            whole["until"]
        );
    }
    // It has come to its end: nothing is added, and its last row stays.
    let steps = summary(&folder.path().join("again"))["steps"].clone();
    let rows = || fs::read(folder.path().join("again/gas.walls.csv")).unwrap();
    let before = rows();
    run(
        folder.path(),
        &["gas.toml", "--quiet", "--resume", "--output", "again"],
    );
    assert_eq!(summary(&folder.path().join("again"))["steps"], steps);
    assert!(rows() == before);
    // A smaller error makes it longer.
    let finer = "time.until={ result = \"load\", error = \"7 %\" }";
    run(
        folder.path(),
        &[
            "gas.toml", "--quiet", "--resume", "--output", "again", "--set", finer,
        ],
    );
    assert!(
        summary(&folder.path().join("again"))["time"]
            .as_f64()
            .unwrap()
            > end
    );
}

#[test]
fn a_run_that_ends_before_says_what_is_missing() {
    let folder = folder_with("gas.toml", GAS);
    run(
        folder.path(),
        &["gas.toml", "--quiet", "--set", "time.end=3"],
    );
    let short = summary(&folder.path().join("gas"));
    assert_eq!(short["until"][0]["reached"], false);
    assert!(short["until"][0]["more"].as_f64().unwrap() > 0.0);
    let warnings = short["warnings"].to_string();
    assert!(warnings.contains("8 % are wanted"), "{warnings}");
}

#[test]
fn wrong_results_are_refused_at_their_place() {
    let until = "until = { result = \"load\", error = \"8 %\" }";
    let load = "load = \"mean(walls.\\\"box.-z\\\".fz, steady..)\"";
    for (from, to, parts) in [
        (
            "result = \"load\"",
            "result = \"laod\"",
            &[
                "gas.toml:7:20: time.until.result: there is no result `laod`",
                "did you mean `load`?",
            ][..],
        ),
        (
            "\"8 %\"",
            "\"0 %\"",
            &["gas.toml:7:36: time.until.error: must be above 0"],
        ),
        ("\"8 %\"", "\"-1 %\"", &["must be above 0"]),
        ("\"8 %\"", "\"nan %\"", &["must be above 0"]),
        (
            "\"8 %\"",
            "\"2 m\"",
            &["is a length, and the result is in N"],
        ),
        (
            "\"8 %\"",
            "\"much\"",
            &["expected a share of the value, \"2 %\", or a number with its unit, \"0.1 N\""],
        ),
        (
            until,
            "until = [{ result = \"load\", error = \"8 %\" }, { result = \"load\", error = \"1 N\" }]",
            &["`load` is there twice"],
        ),
        (
            until,
            "until = { result = \"load\", error = \"8 %\", at_least = 300.0 }",
            &["time.until.at_least: 300 s are needed", "time.end is 200 s"],
        ),
        (
            "interval = 0.01",
            "interval = 4.0",
            &[
                "results.load: 51 rows lie in 0..200 s, an error that ends the run needs 64",
                "help: output.rows_interval = 0.6",
            ],
        ),
        (
            load,
            "load = \"max(walls.\\\"box.-z\\\".fz)\"",
            &[
                "`load` has no error from one run: it is one value of the window",
                "a study with several seeds",
            ],
        ),
        (
            load,
            "load = \"mean(walls.lid.fz)\"",
            &["results.load: ", "no wall `lid`"],
        ),
        (
            load,
            "load = \"meen(walls.lid.fz)\"",
            &["results.load: ", "did you mean `mean`?"],
        ),
        (
            load,
            "load = 3",
            &["results.load: expected a string, got a number"],
        ),
    ] {
        assert!(GAS.contains(from), "{from}");
        let folder = folder_with("gas.toml", &GAS.replace(from, to));
        let output = solve(folder.path(), &["gas.toml", "--check"]);
        assert_eq!(code(&output), Some(2), "{to}: {}", said(&output));
        for part in parts {
            assert!(errors(&output).contains(part), "{to}: {}", errors(&output));
        }
    }
}

/// Rows at another interval than frames: the looks follow the rows, so that the run ends as one whose frames come with its rows.
#[test]
fn rows_between_frames_end_a_run_at_the_same_step() {
    let folder = folder_with("gas.toml", GAS);
    run(folder.path(), &["gas.toml", "--quiet"]);
    let rare = ["gas.toml", "--quiet", "--output", "rare", "--set"];
    let between = "output={ interval = 3.0, rows_interval = 0.01, pictures = false }";
    run(folder.path(), &[&rare[..], &[between]].concat());
    for file in ["gas.walls.csv", "gas.ene", "gas.results.csv"] {
        let [one, other] =
            ["gas", "rare"].map(|run| fs::read(folder.path().join(run).join(file)).unwrap());
        assert!(one == other, "{file}");
    }
    let [one, other] = ["gas", "rare"].map(|run| summary(&folder.path().join(run)));
    for member in ["steps", "until", "results"] {
        assert_eq!(one[member], other[member], "{member}");
    }
    let [one, other] = ["gas", "rare"].map(|run| {
        let data = folder.path().join(run).join("gas.data");
        fs::metadata(data).unwrap().len()
    });
    assert!(10 * other < one);

    // Interrupted at a frame.
    let again = ["gas.toml", "--quiet", "--output", "again", "--set", between];
    run(
        folder.path(),
        &[&again[..], &["--set", "time.end=3"]].concat(),
    );
    run(folder.path(), &[&again[..], &["--resume"]].concat());
    for file in ["gas.walls.csv", "gas.ene", "gas.results.csv"] {
        let [one, other] =
            ["gas", "again"].map(|run| fs::read(folder.path().join(run).join(file)).unwrap());
        assert!(one == other, "{file}");
    }
}

#[test]
fn few_rows_are_warned_of_by_check() {
    let text = GAS
        .replace("until = {", "# until = {")
        .replace("interval = 0.01", "interval = 2.0");
    let folder = folder_with("gas.toml", &text);
    let few = "results.load: 101 rows lie in 0..200 s, an error is good from 256 on: output.rows_interval = 0.6";
    let output = solve(folder.path(), &["gas.toml", "--check"]);
    assert_eq!(code(&output), Some(0));
    let report = said(&output);
    assert!(report.contains(few), "{report}");
    assert!(report.contains(", N, a row every 2 s"), "{report}");
    let output = solve(folder.path(), &["gas.toml", "--check", "--json"]);
    let object: Value = serde_json::from_str(&said(&output)).unwrap();
    let warnings = object["warnings"].as_array().unwrap();
    assert!(warnings.contains(&few.into()), "{warnings:?}");
    let enough = ["gas.toml", "--check", "--set", "output.rows_interval=0.6"];
    let report = said(&solve(folder.path(), &enough));
    assert!(!report.contains("rows lie in"), "{report}");
    assert!(report.contains("rows of tables"), "{report}");
}

/// The looks follow the rows of tables, also for a result whose own table has rows at other times: a run that goes on ends at the same step.
#[test]
fn rows_of_another_interval_end_an_interrupted_run_at_the_same_step() {
    let tracer = "[[particles]]\nname = \"tracer\"\nmaterial = \"ball\"\nradius = 0.06\nposition = [0.5, 0.5, 0.5]\nvelocity = [1.0, 0.3, 0.2]\n\n[results]\nvx = \"mean(track.tracer.vx, steady..)\"\n";
    let text = GAS
        .replace("[results]\n", tracer)
        .replace("error = \"8 %\"", "error = \"0.2 m/s\"")
        .replace("result = \"load\"", "result = \"vx\"")
        .replace(
            "interval = 0.01",
            "interval = 0.01\ntrack = [\"tracer\"]\ntrack_interval = 0.003",
        );
    let folder = folder_with("gas.toml", &text);
    run(folder.path(), &["gas.toml", "--quiet"]);
    let whole = summary(&folder.path().join("gas"));
    assert_eq!(whole["until"][0]["reached"], true);
    let end = whole["time"].as_f64().unwrap();
    let stop = format!("time.end={}", (0.6 * end * 100.0).floor() / 100.0);
    run(
        folder.path(),
        &["gas.toml", "--quiet", "--output", "again", "--set", &stop],
    );
    run(
        folder.path(),
        &["gas.toml", "--quiet", "--output", "again", "--resume"],
    );
    assert_eq!(
        summary(&folder.path().join("again"))["steps"],
        whole["steps"]
    );
}
