//! Runs of a study, and its file.

use std::path::Path;

use proptest::prelude::*;

use super::table::{State, StudyTable};
use super::{Study, Sweep, earlier, file, grid, plot};

fn sweeps(texts: &[&str]) -> Vec<Sweep> {
    texts
        .iter()
        .map(|text| Sweep::parse(text).unwrap())
        .collect()
}

fn names(texts: &[&str]) -> Vec<String> {
    let (_, runs) = grid(&sweeps(texts), "--sweep").unwrap();
    runs.into_iter().map(|run| run.name).collect()
}

#[test]
fn a_grid_has_every_combination_once() {
    let found = names(&["materials.glass.tangential.friction=0.1,0.5", "seed=1,2"]);
    let expected = [
        "friction=0.1_seed=1",
        "friction=0.1_seed=2",
        "friction=0.5_seed=1",
        "friction=0.5_seed=2",
    ];
    assert_eq!(found, expected);
    // As much of a key as distinguishes it from the others; what no file system takes is left out.
    assert_eq!(
        names(&["a.b.friction=1", "a.c.friction=\"x/y\""]),
        ["b.friction=1_c.friction=x-y"]
    );
    assert_eq!(
        names(&["walls[0].radius=1", "walls[1].radius=2"]),
        ["0.radius=1_1.radius=2"]
    );
    assert_eq!(names(&["gravity=[0, 0, -1]"]), ["gravity=-0,0,-1-"]);
    let long = format!("title=\"{}\",\"{}\"", "x".repeat(200), "x".repeat(201));
    let long = names(&[&long]);
    assert!(
        long[0] != long[1] && long.iter().all(|name| name.len() < 100),
        "{long:?}"
    );
}

#[test]
fn what_stands_twice_or_is_too_much_is_refused() {
    for (texts, part) in [
        (vec!["a=1,1"], "two runs would be `a=1`"),
        (
            vec!["a=5 mm,0.005"],
            "the runs `a=5mm` and `a=0.005` are the same",
        ),
        (vec!["a=1,1.0"], "the runs `a=1` and `a=1.0` are the same"),
        (vec!["a=1", "a=2"], "the key `a` is given twice"),
        (vec!["a=0..1/200", "b=0..1/200"], "40000 runs"),
    ] {
        let error = grid(&sweeps(&texts), "--sweep").unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

const FILE: &str = r#"
[study]
scene   = "drum.toml"
set     = { "time.end" = 0.5 }
plots   = ["torque"]
jobs    = 2

[study.sweep]
"walls.drum.motion.0.angular_velocity" = [1.0, 2.0]
seed = "1..3/3"

[study.results]
torque = "mean(walls.drum.ty, 0.2..)"
"#;

#[test]
fn a_file_says_the_same_as_options() {
    assert!(file::is_study(FILE));
    let study = file::parse(Path::new("some/spin.toml"), FILE).unwrap();
    assert_eq!(study.scene, Path::new("some/drum.toml"));
    assert_eq!(study.folder, Path::new("spin"));
    assert_eq!(study.runs.len(), 6);
    assert_eq!(study.runs[3].name, "angular_velocity=2.0_seed=1");
    assert_eq!(
        study.overrides(&study.runs[3]),
        [
            "time.end=0.5",
            "walls.drum.motion.0.angular_velocity=2.0",
            "seed=1"
        ]
    );
    assert_eq!(
        (study.jobs, study.threads, study.results.len()),
        (Some(2), None, 1)
    );
}

#[test]
fn a_list_of_runs_may_leave_keys_to_the_scene() {
    let text = "[study]\nscene = \"a.toml\"\n[[study.runs]]\nname = \"base\"\n[[study.runs]]\nseed = 2\n\"time.end\" = 3.0\n";
    let study = file::parse(Path::new("b.toml"), text).unwrap();
    let runs: Vec<_> = study
        .runs
        .iter()
        .map(|run| (run.name.as_str(), study.overrides(run)))
        .collect();
    let own = vec!["seed=2".to_owned(), "time.end=3.0".to_owned()];
    assert_eq!(runs, [("base", vec![]), ("seed=2_end=3.0", own)]);
}

#[test]
fn slips_in_a_file_are_reported() {
    for (text, part) in [
        (
            "[study]\nscen = \"a\"",
            "study.scen: this key is not known\nhelp: did you mean `scene`?",
        ),
        ("[study]\n", "study.scene: is missing"),
        ("[study]\nscene = 1", "study.scene: must be a string"),
        ("[study]\nscene = \"a\"", "study: says nothing of values"),
        ("study = 1", "study: must be a table"),
        (
            "[study]\nscene = \"a\"\n[time]\nend = 1",
            "time: is not known beside [study]",
        ),
        (
            "[study]\nscene = \"a\"\nsweep = 3",
            "study.sweep: must be a table",
        ),
        ("[study]\nscene = \"a\"\n[study.sweep]\n", "names no key"),
        (
            "[study]\nscene = \"a\"\n[study.sweep]\na = 1",
            "study.sweep.a: must be a list",
        ),
        (
            "[study]\nscene = \"a\"\n[study.sweep]\na = []",
            "study.sweep.a: has no values",
        ),
        (
            "[study]\nscene = \"a\"\n[study.sweep]\na.b = [1]",
            "write the path of a key in quotes",
        ),
        (
            "[study]\nscene = \"a\"\n[study.sweep]\na = \"1..\"",
            "is no range",
        ),
        ("[study]\nscene = \"a\"\nruns = []", "has no runs"),
        (
            "[study]\nscene = \"a\"\nruns = [1]",
            "study.runs[0]: must be a table",
        ),
        (
            "[study]\nscene = \"a\"\nruns = [{ name = \"../b\" }]",
            "study.runs[0].name: must be a name",
        ),
        (
            "[study]\nscene = \"a\"\nruns = [{ seed = 1 }, { seed = 1 }]",
            "two runs would be `seed=1`",
        ),
        (
            "[study]\nscene = \"a\"\njobs = 0\nruns = [{ seed = 1 }]",
            "study.jobs: must be a number from 1",
        ),
        (
            "[study]\nscene = \"a\"\nplots = [1]\nruns = [{ seed = 1 }]",
            "study.plots: must be a list of strings",
        ),
        (
            "[study]\nscene = \"a\"\nruns = [{ seed = 1 }]\n[study.results]\nx = \"mean\"",
            "study.results.x: `mean` is no result",
        ),
        (
            "[study]\nscene = \"a\"\nruns = [{ seed = 1 }]\n[study.results]\nx = 1",
            "study.results.x: must be a string",
        ),
        ("[study\n", "TOML parse error"),
    ] {
        let error = file::parse(Path::new("s.toml"), text)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(part) && error.starts_with("s.toml"),
            "{text}:\n{error}"
        );
    }
}

/// A study whose runs have ended with these values of a column.
fn table(study: &Study, column: &str, values: &[f64]) -> StudyTable {
    let states = vec![State::Waiting; study.runs.len()];
    let mut table = StudyTable::of(study, &states, "a", &earlier::Rows::new());
    table.columns.push(column.to_owned());
    table.units.push(study.unit(column));
    let cells = values.iter().map(|value| format!("{value:?}"));
    for (row, cell) in (table.rows.iter_mut()).zip(cells.chain(std::iter::repeat_with(String::new)))
    {
        row.push(cell);
    }
    table
}

fn study(texts: &[&str]) -> Study {
    let (keys, runs) = grid(&sweeps(texts), "--sweep").unwrap();
    let text = "[study]\nscene = \"a\"\nruns = [{ seed = 1 }]";
    Study {
        keys,
        runs,
        ..file::parse(Path::new("s.toml"), text).unwrap()
    }
}

#[test]
fn plots_have_a_line_for_each_other_value_and_join_seeds() {
    let lines = study(&["friction=0.1,0.5", "time.end=1,2,3"]);
    let text = plot::page(&lines, &table(&lines, "x", &[1.0; 6]), "x")
        .unwrap()
        .svg()
        .unwrap();
    assert!(
        text.contains("time.end = 2") && text.contains("friction"),
        "{text}"
    );
    let seeds = study(&["seed=1,2,3", "friction=0.1,0.5"]);
    let text = plot::page(
        &seeds,
        &table(&seeds, "x", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        "x",
    )
    .unwrap()
    .svg()
    .unwrap();
    assert!(!text.contains("seed"), "{text}");

    let error = |study: &Study, column: &str| {
        plot::page(study, &table(study, "x", &[]), column).unwrap_err()
    };
    assert!(error(&lines, "z").contains("no column `z`"));
    assert!(error(&lines, "x").contains("no numbers yet"));
    assert!(
        error(&study(&["title=a,b"]), "x").contains("no key of the study has different numbers")
    );
}

#[test]
fn values_with_units_are_drawn_over_their_si_numbers() {
    let study = study(&["radius=5 mm,10 mm", "rotate.degrees=30 deg,1 rev"]);
    let table = table(&study, "x", &[1.0, 2.0, 3.0, 4.0]);
    let numbers =
        |key: &str| -> Vec<f64> { table.numbers(key).unwrap().into_iter().flatten().collect() };
    assert_eq!(numbers("radius"), [0.005, 0.005, 0.01, 0.01]);
    assert_eq!(numbers("rotate.degrees"), [30.0, 360.0, 30.0, 360.0]);
    assert!(plot::page(&study, &table, "x").is_ok());
}

/// The statements of the scene of each run on the values.
fn settled(mut study: Study) -> Study {
    let scene = r#"
title = "a drum"
time = { end = 1, step = 0.1 }
domain = { min = [0, 0, 0], max = [1, 1, 1] }
output = { interval = 0.1 }
materials.m = { density = 1, normal = { law = "linear", stiffness = 1, dissipation = 0 } }
walls = [{ name = "w", shape = "box", material = "m", motion = [
    { kind = "rotation", axis = [0, 0, 1], origin = [0, 0, 0], angular_velocity = 1 },
    { kind = "oscillation", amplitude = [0, 0, 1], frequency = 1, phase_degrees = 0 },
] }]
"#;
    for run in 0..study.runs.len() {
        let overrides = study.overrides(&study.runs[run]);
        let files = mercury_common::scene::Files::Unchecked;
        let scene = crate::plan::parse_scene(Path::new("a.toml"), scene, &overrides, files);
        study.settle(run, &scene.unwrap_or_else(|errors| panic!("{errors}")));
    }
    study
}

#[test]
fn values_are_drawn_in_the_unit_in_which_they_were_typed() {
    let spin = "walls.w.motion.0.angular_velocity";
    let svg = |study: &Study, values: &[f64]| {
        let page = plot::page(study, &table(study, "x", values), "x").unwrap();
        page.svg().unwrap()
    };
    let drum = settled(study(&[
        &format!("{spin}=5 rpm,20 rpm"),
        "walls.w.motion.1.phase_degrees=0 deg,0.25 rev",
    ]));
    assert_eq!(drum.units, ["rad/s", "deg"]);
    let cells = table(&drum, "x", &[]);
    let rpm = 2.0 * std::f64::consts::PI / 60.0;
    let speeds: Vec<f64> = cells.numbers(spin).unwrap().into_iter().flatten().collect();
    assert!(
        speeds
            .iter()
            .zip([5.0, 5.0, 20.0, 20.0])
            .all(|(found, typed)| (found - typed * rpm).abs() < 1e-15),
        "{speeds:?}"
    );
    assert_eq!(cells.rows[1][2], "90.0");
    assert!(cells.csv().starts_with(&format!(
        "run,{spin} [rad/s],walls.w.motion.1.phase_degrees [deg],status"
    )));
    let text = svg(&drum, &[1.0, 2.0, 3.0, 4.0]);
    for part in [
        "angular_velocity (rpm)",
        "phase_degrees = 0.25 rev",
        "a drum",
        ">20<",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // Of several units that of SI is drawn.
    let mixed = settled(study(&[&format!("{spin}=5 rpm,1 rev/s,7")]));
    assert!(svg(&mixed, &[1.0, 2.0, 3.0]).contains("angular_velocity (rad/s)"));
    let plain = settled(study(&[&format!("{spin}=0.50,1e0")]));
    assert_eq!(table(&plain, "x", &[]).rows[0][1], "0.50");
    assert!(svg(&plain, &[1.0, 2.0]).contains("angular_velocity (rad/s)"));
    let lists = settled(study(&["domain.max=[1,1,1],[\"20 cm\",1,1]"]));
    let cells = table(&lists, "x", &[]);
    assert_eq!(
        (cells.rows[0][1].as_str(), cells.rows[1][1].as_str()),
        ("[1,1,1]", "[0.2, 1, 1]")
    );
    assert_eq!(lists.units, ["m"]);
}

#[test]
fn results_have_names_of_their_own() {
    let result = |text: &str| crate::results::NamedResult::parse(text).unwrap();
    for (results, name) in [
        (
            vec![result("h=max(particles.z)"), result("h=min(particles.z)")],
            "h",
        ),
        (vec![result("run=max(particles.z)")], "run"),
        (vec![result("seed=max(particles.z)")], "seed"),
    ] {
        let study = Study {
            results,
            ..study(&["seed=1,2"])
        };
        let error = study.check_names().unwrap_err().to_string();
        assert!(
            error.contains(&format!("another column `{name}`")),
            "{error}"
        );
    }
}

#[test]
fn cells_of_the_table_are_quoted() {
    let study = study(&["title=\"a,b\",c"]);
    let states = [
        State::Failed("it \"broke\"\nbadly".to_owned()),
        State::Waiting,
    ];
    let text = StudyTable::of(&study, &states, "a", &earlier::Rows::new()).csv();
    assert_eq!(
        text,
        "run,title,status,problem\n\"title=a,b\",\"a,b\",failed,\"it \"\"broke\"\"\"\ntitle=c,c,waiting,\n"
    );
}

proptest! {
    #[test]
    fn no_text_makes_a_panic(text in "[a-z0-9.,=\"'\\[\\]{}/ -]{0,40}") {
        if let Ok(sweep) = Sweep::parse(&text) {
            let _ = grid(&[sweep], "--sweep");
        }
        let _ = crate::results::NamedResult::parse(&text);
        let _ = file::parse(Path::new("s"), &format!("[study]\nscene = \"a\"\n[study.sweep]\n{text}"));
    }

    #[test]
    fn values_of_a_list_come_back(values in proptest::collection::vec(-1e6f64..1e6, 1..8)) {
        let list: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        let sweep = Sweep::parse(&format!("key = {}", list.join(", "))).unwrap();
        prop_assert_eq!(sweep.values, list);
    }
}
