//! Studies from the command line: a run for each value, a table, a plot; stopped and gone on with.

use crate::common;
use std::fs;
use std::path::Path;

use crate::common::{code, command, errors, folder_with, said, signal};

const SCENE: &str = r#"
title = "A ball falls on a plate"
gravity = [0.0, 0.0, -9.81]

[time]
end = 0.02
step = 1e-5

[domain]
min = [0.0, 0.0, 0.0]
max = [0.1, 0.1, 0.1]

[materials.ball]
density = 2500.0
normal = { law = "linear", stiffness = 1e5, restitution = 0.8 }
tangential = { law = "linear", stiffness_ratio = 0.2857142857142857, friction = 0.5 }

[[walls]]
name = "plate"
shape = "plane"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
material = "ball"

[[particles]]
material = "ball"
radius = 0.01
position = [0.05, 0.05, 0.0101]
velocity = [0.1, 0.0, -1.0]

[output]
interval = 0.005
pictures = false
"#;

fn folder() -> tempfile::TempDir {
    folder_with("ball.toml", SCENE)
}

fn solve(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = common::solve(folder, arguments);
    (code(&output), said(&output), errors(&output))
}

/// The columns of the study's table by name.
fn column(folder: &Path, name: &str) -> Vec<String> {
    let text = fs::read_to_string(folder.join("study.csv")).unwrap();
    let mut lines = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let place = (header.iter()).position(|column| column.split(" [").next() == Some(name));
    let place = place.unwrap_or_else(|| panic!("no {name} in {header:?}"));
    lines.map(|line| line[place].clone()).collect()
}

#[test]
fn a_sweep_runs_every_value_and_makes_table_and_plot() {
    let folder = folder();
    let arguments = [
        "ball.toml",
        "--sweep",
        "materials.0.normal.restitution=0.5,1",
        "--sweep",
        "particles.0.velocity[2]=-1,-2",
        "--result",
        "push=max(walls.plate.fz)",
        "--result",
        "speed=last(particles.vz)",
        "--jobs",
        "2",
    ];
    let (code, said, errors) = solve(folder.path(), &arguments);
    assert_eq!(code, Some(0), "{errors}");
    assert!(
        said.starts_with("4 runs of 4 finished") || said.starts_with("4 of 4 runs finished"),
        "{said}"
    );
    let study = folder.path().join("ball-study");
    assert_eq!(
        column(&study, "materials.0.normal.restitution"),
        ["0.5", "0.5", "1", "1"]
    );
    assert_eq!(column(&study, "status"), ["finished"; 4]);
    assert_eq!(column(&study, "particles"), ["1"; 4]);
    // A ball that left the plate with e v, less what gravity took since: the contact lasts for
    // pi sqrt(m/k) = 1 ms, in which gravity takes 0.01 m/s.
    let speeds: Vec<f64> = column(&study, "speed")
        .iter()
        .map(|text| text.parse().unwrap())
        .collect();
    for (speed, bounce) in speeds.iter().zip([0.5, 1.0, 1.0, 2.0]) {
        assert!((speed - (bounce - 9.81 * 0.02)).abs() < 0.02, "{speeds:?}");
    }
    for file in ["study.push.svg", "study.push.png", "study.speed.svg"] {
        assert!(study.join(file).exists(), "{file}");
    }
    // A single run of this value has the same bytes.
    let one = [
        "ball.toml",
        "--set",
        "materials.ball.normal.restitution=0.5",
        "--set",
        "particles.0.velocity[2]=-2",
        "--output",
        "one",
    ];
    assert_eq!(solve(folder.path(), &one).0, Some(0));
    let run = study.join("restitution=0.5_2=-2");
    let bytes = |folder: &Path| fs::read(folder.join("ball.particles.arrow")).unwrap();
    assert!(bytes(&run) == bytes(&folder.path().join("one")));

    // Again: nothing is run, table and plots are made anew.
    let before = fs::metadata(run.join("ball.particles.arrow"))
        .unwrap()
        .modified()
        .unwrap();
    fs::remove_file(study.join("study.csv")).unwrap();
    let (code, said, _) = solve(folder.path(), &arguments);
    assert_eq!(code, Some(0));
    assert!(said.contains("(4 before)"), "{said}");
    assert_eq!(column(&study, "status"), ["finished"; 4]);
    let after = fs::metadata(run.join("ball.particles.arrow"))
        .unwrap()
        .modified()
        .unwrap();
    assert_eq!(before, after);
    // One value more is one run more.
    let mut more = arguments;
    more[2] = "materials.0.normal.restitution=0.5,0.7,1";
    let (code, said, _) = solve(folder.path(), &more);
    assert_eq!(code, Some(0));
    assert!(said.contains("(4 before)"), "{said}");
    assert_eq!(column(&study, "status"), ["finished"; 6]);
    // Another scene does not go on with what is there.
    fs::write(
        folder.path().join("ball.toml"),
        SCENE.replace("stiffness = 1e5", "stiffness = 2e5"),
    )
    .unwrap();
    let (code, _, errors) = solve(folder.path(), &more);
    assert_eq!(code, Some(1));
    assert!(
        errors.contains("stiffness")
            && errors.contains("6 of 6 runs failed")
            && errors.contains("--force"),
        "{errors}"
    );
    more[more.len() - 1] = "1";
    let forced: Vec<&str> = more.iter().copied().chain(["--force"]).collect();
    assert_eq!(solve(folder.path(), &forced).0, Some(0));
}

#[cfg(unix)]
#[test]
fn a_study_that_is_stopped_goes_on_to_the_same_table() {
    use std::time::{Duration, Instant};
    let folder = folder();
    // Long enough to be stopped, with a checkpoint of the first two and nothing of the others.
    let arguments = [
        "ball.toml",
        "--set",
        "time.end=2.0",
        "--set",
        "time.step=2e-6",
        "--sweep",
        "materials.ball.normal.restitution=0.1..0.9/4",
        "--result",
        "x=last(particles.x)",
        "--jobs",
        "2",
    ];
    let mut child = command(folder.path(), &arguments)
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let study = folder.path().join("ball-study");
    let begun = Instant::now();
    while !study.join("restitution=0.1/ball.particles.arrow").exists() {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "the study does not begin"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(100));
    signal(&child, "INT");
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(75));
    let states = column(&study, "status");
    assert!(
        states.contains(&"stopped".to_owned()) && states.contains(&"waiting".to_owned()),
        "{states:?}"
    );
    // The checkpoints of those that were stopped are there, and no lock.
    assert!(!study.join("restitution=0.1/.lock").exists());
    let (code, said, errors) = solve(folder.path(), &arguments);
    assert_eq!(code, Some(0), "{errors}");
    assert!(said.contains("4 runs finished"), "{said}");
    let stopped = fs::read_to_string(study.join("restitution=0.1/run.log")).unwrap();
    assert!(stopped.contains("resumed"), "{stopped}");
    // Without a stop.
    let whole: Vec<&str> = arguments
        .iter()
        .copied()
        .chain(["--output", "whole"])
        .collect();
    assert_eq!(solve(folder.path(), &whole).0, Some(0));
    let whole = folder.path().join("whole");
    assert_eq!(column(&study, "x"), column(&whole, "x"));
    assert_eq!(
        column(&study, "energy_kinetic"),
        column(&whole, "energy_kinetic")
    );
    for run in ["restitution=0.1", "restitution=0.9"] {
        let bytes =
            |folder: &Path| fs::read(folder.join(run).join("ball.particles.arrow")).unwrap();
        assert!(bytes(&study) == bytes(&whole), "{run}");
    }
}

#[test]
fn slips_are_reported_before_anything_runs() {
    let folder = folder();
    let refused = |arguments: &[&str]| {
        let (code, _, errors) = solve(folder.path(), &[&["ball.toml"], arguments].concat());
        assert_eq!(code, Some(2), "{errors}");
        assert!(!folder.path().join("ball-study").exists());
        errors
    };
    // The reader's own words, with the run.
    let errors = refused(&["--sweep", "materials.ball.tangential.friction=0.1,-0.2"]);
    assert!(
        errors.contains("run `friction=-0.2`:") && errors.contains("must be >= 0, got -0.2"),
        "{errors}"
    );
    assert!(
        errors.contains("1 of 2 runs cannot be run; no run of the study was begun"),
        "{errors}"
    );
    let errors = refused(&["--sweep", "materials.bal.tangential.friction=0.1"]);
    assert!(errors.contains("did you mean `ball`?"), "{errors}");
    let errors = refused(&["--sweep", "materials.ball.tangential.frction=0.1"]);
    assert!(errors.contains("`friction`"), "{errors}");
    let errors = refused(&["--sweep", "walls.plte.point[2]=0.1..0.9/9"]);
    assert!(
        errors.contains("did you mean `plate`?") && errors.contains("and 6 more"),
        "{errors}"
    );
    let errors = refused(&["--sweep", "seed"]);
    assert!(errors.contains("--sweep seed: there is no `=`"), "{errors}");
    let errors = refused(&["--sweep", "seed=1,2", "--result", "f=mean(walls.plat.fz)"]);
    assert!(errors.contains("did you mean `plate`?"), "{errors}");
    let errors = refused(&["--sweep", "seed=1,2", "--result", "f=mean(wall.plate.fz)"]);
    assert!(errors.contains("did you mean `walls`?"), "{errors}");
    let errors = refused(&["--plot", "f"]);
    assert!(errors.contains("--plot is for studies"), "{errors}");
    let (code, said, _) = solve(
        folder.path(),
        &["ball.toml", "--sweep", "seed=1,2", "--check"],
    );
    assert_eq!(code, Some(0));
    assert!(
        said.contains("  seed=2") && said.contains("nothing was run"),
        "{said}"
    );
    assert!(!folder.path().join("ball-study").exists());
}

#[test]
fn a_run_that_fails_leaves_the_others_alone() {
    let folder = folder();
    // Far too long a step: the guard stops the second run.
    let arguments = [
        "ball.toml",
        "--sweep",
        "particles.0.velocity[2]=-1,-20000",
        "--quiet",
    ];
    let (code, said, errors) = solve(folder.path(), &arguments);
    assert_eq!((code, said.as_str()), (Some(1), ""), "{errors}");
    assert!(
        errors.contains("run `2=-20000`:") && errors.contains("1 of 2 runs failed"),
        "{errors}"
    );
    let study = folder.path().join("ball-study");
    assert_eq!(column(&study, "status"), ["finished", "failed"]);
}

#[test]
fn a_file_is_a_study() {
    let folder = folder();
    let text = "[study]\nscene = \"ball.toml\"\nset = { \"time.end\" = 0.01 }\n\n[[study.runs]]\nname = \"as-it-is\"\n\n[[study.runs]]\nname = \"hard\"\n\"materials.ball.normal.stiffness\" = 4000.0\n\n[study.results]\ndeep = \"min(energy.time)\"\n";
    fs::write(folder.path().join("hardness.toml"), text).unwrap();
    let (code, said, errors) = solve(folder.path(), &["hardness.toml"]);
    assert_eq!(code, Some(0), "{errors}");
    assert!(said.contains("hardness: study.csv"), "{said}");
    assert!(errors.contains("plot of `deep`"), "{errors}");
    let study = folder.path().join("hardness");
    assert_eq!(column(&study, "run"), ["as-it-is", "hard"]);
    assert_eq!(
        column(&study, "materials.ball.normal.stiffness"),
        ["", "4000.0"]
    );
    assert_eq!(column(&study, "time"), ["0.01"; 2]);
    fs::write(
        folder.path().join("hardness.toml"),
        text.replace("runs", "rns"),
    )
    .unwrap();
    let (code, _, errors) = solve(folder.path(), &["hardness.toml"]);
    assert_eq!(code, Some(2));
    assert!(
        errors.contains("study.rns: this key is not known\nhelp: did you mean `runs`?"),
        "{errors}"
    );
    let (code, _, errors) = solve(folder.path(), &["hardness.toml", "--sweep", "seed=1"]);
    assert_eq!(code, Some(2));
    assert!(errors.contains("[study.sweep]"), "{errors}");
}

/// Both wrote the same table, each with the other's runs as failed.
#[test]
fn two_studies_in_one_folder_are_refused() {
    let folder = folder();
    let study = folder.path().join("ball-study");
    fs::create_dir(&study).unwrap();
    let arguments = ["ball.toml", "--sweep", "seed=1,2"];
    let other = mercury_solver::output::folder::take(&study).unwrap();
    let (code, _, errors) = solve(folder.path(), &arguments);
    assert_eq!(code, Some(2), "{errors}");
    assert!(
        errors.contains("ball-study: another study is being run in this folder (process "),
        "{errors}"
    );
    assert!(errors.contains("help: wait for its end"), "{errors}");
    let left: Vec<_> = fs::read_dir(&study).unwrap().flatten().collect();
    assert_eq!(left.len(), 1, "{left:?}");
    drop(other);
    assert_eq!(solve(folder.path(), &arguments).0, Some(0));
    assert!(!study.join(".lock").exists());
}

#[test]
fn a_file_of_a_run_that_is_gone_is_reported_with_what_to_do() {
    let folder = folder();
    let arguments = [
        "ball.toml",
        "--sweep",
        "seed=1,2",
        "--result",
        "push=max(walls.plate.fz)",
    ];
    assert_eq!(solve(folder.path(), &arguments).0, Some(0));
    let study = folder.path().join("ball-study");
    let run = study.join("seed=2");
    fs::remove_file(run.join("ball.walls.csv")).unwrap();
    let (code, _, errors) = solve(folder.path(), &arguments);
    assert_eq!(code, Some(0), "{errors}");
    let reported = "warning: seed=2: push: ball-study/seed=2/ball.walls.csv cannot be read:";
    assert!(errors.contains(reported), "{errors}");
    assert!(errors.contains("remove the folder of the run"), "{errors}");
    assert_eq!(column(&study, "push")[1], "");
    // The advice of the message helps.
    fs::remove_dir_all(&run).unwrap();
    let (code, _, errors) = solve(folder.path(), &arguments);
    assert_eq!(
        (code, errors.contains("warning")),
        (Some(0), false),
        "{errors}"
    );
    assert_ne!(column(&study, "push")[1], "");
}

/// The second study wrote its table over that of the first one, whose plot stayed beside it.
#[test]
fn the_table_of_another_study_is_not_replaced() {
    let folder = folder();
    let friction = "materials.ball.tangential.friction=0.1..0.5/3";
    let first = [
        "ball.toml",
        "--sweep",
        friction,
        "--result",
        "height=max(particles.z)",
    ];
    assert_eq!(solve(folder.path(), &first).0, Some(0));
    let study = folder.path().join("ball-study");
    let table = || fs::read(study.join("study.csv")).unwrap();
    let before = table();
    let refused = |arguments: &[&str], part: &str| {
        let (code, _, errors) = solve(folder.path(), &[&["ball.toml"], arguments].concat());
        assert_eq!(code, Some(2), "{errors}");
        for part in ["table of another study", part, "--output OTHER", "--force"] {
            assert!(errors.contains(part), "{part}: {errors}");
        }
        assert!(table() == before);
        assert!(study.join("study.height.png").exists());
        assert!(!study.join("seed=1").exists());
    };
    refused(&["--sweep", "seed=1,2"], "those of this one in seed");
    refused(
        &["--sweep", "seed=1,2", "--check"],
        "those of this one in seed",
    );
    refused(
        &["--sweep", friction],
        "height=max(particles.z) is not requested here",
    );
    refused(
        &["--sweep", friction, "--result", "height=min(particles.z)"],
        "`height` is max(particles.z), that of this one min(particles.z)",
    );
    let end = ["--set", "time.end=0.01"];
    refused(
        &[&first[1..], &end].concat(),
        "--set time.end=0.01 was not given there",
    );

    // A result more costs no run, and values of another day stand beside the first ones.
    let more = ["--result", "speed=last(particles.vz)"];
    let mut later = [&first[..], &more].concat();
    let (code, said, errors) = solve(folder.path(), &later);
    assert_eq!(code, Some(0), "{errors}");
    assert!(said.contains("(3 before)"), "{said}");
    later[2] = "materials.ball.tangential.friction=0.5,0.7";
    assert_eq!(solve(folder.path(), &later).0, Some(0));
    let names = [
        "friction=0.5",
        "friction=0.7",
        "friction=0.1",
        "friction=0.3",
    ];
    assert_eq!(column(&study, "run"), names);
    assert!(!column(&study, "speed").contains(&String::new()));

    // Runs that cannot be made again keep what they had, and the table gives the reason.
    let scene = folder.path().join("ball.toml");
    let other = SCENE.replace("stiffness = 1e5", "stiffness = 2e5");
    let heights = column(&study, "height");
    fs::write(&scene, other).unwrap();
    assert_eq!(solve(folder.path(), &later).0, Some(1));
    assert_eq!(column(&study, "height"), heights);
    assert_ne!(column(&study, "problem")[0], "");

    let forced = ["ball.toml", "--sweep", "seed=1,2", "--force"];
    let (code, _, errors) = solve(folder.path(), &forced);
    assert_eq!(code, Some(0), "{errors}");
    assert_eq!(column(&study, "run"), ["seed=1", "seed=2"]);
    assert!(!study.join("study.height.png").exists());
    assert!(!study.join("study.height.svg").exists());
}

/// The message was that `time` is missing.
#[test]
fn a_study_of_a_study_is_refused_by_that_name() {
    let folder = folder();
    let study = |scene: &str| format!("[study]\nscene = \"{scene}\"\n[study.sweep]\nseed = [1]\n");
    let inline = "study = { scene = \"ball.toml\", sweep = { seed = [1] } }\n";
    fs::write(folder.path().join("inner.toml"), inline).unwrap();
    fs::write(folder.path().join("outer.toml"), study("inner.toml")).unwrap();
    fs::write(folder.path().join("self.toml"), study("self.toml")).unwrap();
    for (name, scene, help) in [
        ("outer", "inner", "name the scene of that study, ball.toml,"),
        ("self", "self", "name a scene, with [time]"),
    ] {
        let (code, _, errors) = solve(folder.path(), &[&format!("{name}.toml")]);
        let message = format!("{name}.toml: study.scene: {scene}.toml is a study, not a scene");
        assert_eq!(code, Some(2), "{errors}");
        assert!(errors.contains(&message), "{errors}");
        assert!(errors.contains(help), "{errors}");
        assert!(!folder.path().join(name).exists());
    }
    // A study in one line is one.
    assert_eq!(solve(folder.path(), &["inner.toml", "--check"]).0, Some(0));
}

/// The key's column was text ("8 mm"), results had no unit, and plots no title.
#[test]
fn the_table_is_in_si_and_says_its_units() {
    let folder = folder();
    let arguments = [
        "ball.toml",
        "--sweep",
        "particles.0.radius=8 mm,9 mm",
        "--result",
        "push=max(walls.plate.fz)",
        "--result",
        "bounce=rate(walls.plate.z)",
        "--json",
    ];
    let (code, said, errors) = solve(folder.path(), &arguments);
    assert_eq!(code, Some(0), "{errors}");
    let study = folder.path().join("ball-study");
    let table = fs::read_to_string(study.join("study.csv")).unwrap();
    let header = table.lines().next().unwrap();
    for name in [
        "run,",
        ",particles.0.radius [m],",
        ",time [s],",
        ",energy_kinetic [J],",
        ",push [N],",
        ",bounce [m/s]",
    ] {
        assert!(header.contains(name), "{header}");
    }
    assert_eq!(column(&study, "particles.0.radius"), ["0.008", "0.009"]);
    assert_eq!(column(&study, "run"), ["radius=8mm", "radius=9mm"]);
    let object: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(object["rows"][1]["particles.0.radius"], 0.009);
    assert_eq!(object["units"]["push"], "N");
    assert_eq!(object["units"]["particles.0.radius"], "m");
    let plot = fs::read_to_string(study.join("study.push.svg")).unwrap();
    for text in [
        "particles.0.radius (mm)",
        "A ball falls on a plate",
        "push (",
    ] {
        assert!(plot.contains(text), "{text}: {plot}");
    }

    // A table of a version that kept what was typed is gone on with.
    let old = (table.lines().next().unwrap().split(','))
        .map(|name| name.split(" [").next().unwrap())
        .collect::<Vec<_>>()
        .join(",");
    let rows: String = (table.lines().skip(1))
        .map(|line| line.replace(",0.008,", ",8 mm,") + "\n")
        .collect();
    fs::write(study.join("study.csv"), format!("{old}\n{rows}")).unwrap();
    let mut later = arguments;
    later[2] = "particles.0.radius=9 mm,1 cm";
    assert_eq!(solve(folder.path(), &later).0, Some(0));
    assert_eq!(
        column(&study, "particles.0.radius"),
        ["0.009", "0.01", "0.008"]
    );
}

#[test]
fn nothing_is_drawn_of_runs_that_all_failed() {
    let folder = folder();
    let arguments = [
        "ball.toml",
        "--sweep",
        "seed=1,2",
        "--result",
        "push=max(walls.plate.fz)",
        "--set",
        "guard.overlap=1e-9",
        "--set",
        "guard.policy=strict",
    ];
    let (code, said, errors) = solve(folder.path(), &arguments);
    assert_eq!(code, Some(1), "{said}{errors}");
    assert!(!errors.contains("plot of"), "{errors}");
    assert!(errors.contains("2 of 2 runs failed"), "{errors}");
    assert!(!folder.path().join("ball-study/study.push.svg").exists());
}

/// A run that was to come to rest and did not has a warning, and the table names it.
#[test]
fn a_run_that_is_not_at_rest_says_so_in_the_table() {
    let folder = folder();
    let scene = SCENE.replace("step = 1e-5", "step = 1e-5\nuntil_at_rest = true");
    fs::write(folder.path().join("ball.toml"), scene).unwrap();
    let arguments = ["ball.toml", "--sweep", "seed=1,2"];
    let (code, _, errors) = solve(folder.path(), &arguments);
    assert_eq!(code, Some(0), "{errors}");
    let study = folder.path().join("ball-study");
    assert_eq!(column(&study, "status"), ["finished", "finished"]);
    let text = fs::read_to_string(study.join("study.csv")).unwrap();
    let rows: Vec<&str> = text.lines().skip(1).collect();
    for row in rows {
        assert!(
            row.contains("\"not at rest: the kinetic energy per particle is "),
            "{row}"
        );
        assert!(row.ends_with(",1"), "one warning: {row}");
    }
}

/// The ball, and grains whose sizes follow from the seed: they fly and touch nothing.
fn with_random_grains() -> tempfile::TempDir {
    let grains = r#"
[[insertions]]
name = "grains"
region = { shape = "box", min = [0.02, 0.02, 0.06], max = [0.08, 0.08, 0.09] }
material = "ball"
psd = { kind = "uniform", min_diameter = 2e-3, max_diameter = 6e-3, weighting = "number" }
total = { number = 10 }
velocity = { mean = [1.0, 0.0, 0.0] }
"#;
    let scene = SCENE.replace("end = 0.02", "end = 0.001");
    folder_with("grains.toml", &format!("{scene}{grains}"))
}

/// How many seeds a point has follows from their outcomes alone, not from how many runs go on at a time; the interval holds what more seeds find.
#[test]
fn seeds_are_added_until_the_error_is_small_enough() {
    let folder = with_random_grains();
    let run = |jobs: &str, output: &str| {
        let arguments = [
            "grains.toml",
            "--sweep",
            "insertions.grains.velocity.mean.0=1,2",
            "--seeds",
            "4..40",
            "--error",
            "energy=2.5%",
            "--result",
            "energy=last(energy.traKineticEnergy)",
            "--jobs",
            jobs,
            "--output",
            output,
        ];
        let (code, _, errors) = solve(folder.path(), &arguments);
        assert_eq!(code, Some(0), "{errors}");
        let read = |name: &str| fs::read_to_string(folder.path().join(output).join(name)).unwrap();
        (
            read("study.means.csv"),
            read("study.differences.csv"),
            errors,
        )
    };
    let (means, differences, errors) = run("1", "one");
    assert!(errors.contains("fewer than 8"), "{errors}");
    assert_eq!(
        run("4", "four"),
        (means.clone(), differences.clone(), errors)
    );
    let rows: Vec<Vec<f64>> = (means.lines().skip(1))
        .map(|line| {
            line.split(',')
                .map(|cell| cell.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    let header = "insertions.grains.velocity.mean.0 [m/s],seeds,energy [J],energy_error [J],energy_low [J],energy_high [J],energy_spread [J],energy_within [J]";
    assert_eq!(means.lines().next(), Some(header));
    for row in &rows {
        assert!(
            row[1] > 4.0 && row[1] < 40.0 && row[3] <= 0.025 * row[2],
            "{row:?}"
        );
    }
    // Grains of the same seeds fly four times as high in energy, but for the ball's share and for gravity; so the two are correlated.
    let correlation: f64 = differences
        .lines()
        .nth(1)
        .unwrap()
        .rsplit(',')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!(correlation > 0.99, "{differences}");
    // The same command again finds all that it needs.
    let again = run("2", "one");
    assert_eq!((again.0, again.1), (means, differences));
}

#[test]
fn a_fixed_number_of_seeds_needs_no_sweep() {
    let folder = with_random_grains();
    let file = "[study]\nscene = \"grains.toml\"\nseeds = 3\n[study.results]\nenergy = \"last(energy.traKineticEnergy)\"\n";
    fs::write(folder.path().join("many.toml"), file).unwrap();
    let (code, said, errors) = solve(folder.path(), &["many.toml"]);
    assert_eq!(code, Some(0), "{errors}");
    assert!(said.contains("3 of 3 runs finished"), "{said}");
    let study = folder.path().join("many");
    assert_eq!(column(&study, "run"), ["seed=1", "seed=2", "seed=3"]);
    assert!(!study.join("study.differences.csv").exists());
    let (code, said, _) = solve(folder.path(), &["grains.toml", "--seeds", "3", "--check"]);
    assert_eq!(code, Some(0));
    assert!(said.starts_with("3 runs in grains-study"), "{said}");
}

#[test]
fn seeds_that_cannot_be_are_refused_before_a_run() {
    let folder = with_random_grains();
    let result = ["--result", "energy=last(energy.traKineticEnergy)"];
    for (arguments, part) in [
        (vec!["--seeds", "0"], "1 at least"),
        (vec!["--seeds", "1000000"], "more than 10000 runs"),
        (
            vec!["--seeds", "2", "--sweep", "seed=1,2"],
            "values of `seed` itself",
        ),
        (
            vec!["--seeds", "2", "--set", "seed=5"],
            "values of `seed` itself",
        ),
        (vec!["--seeds", "8..64"], "needs --error"),
        (vec!["--seeds", "8", "--error", "energy=2%"], "fixed at 8"),
        (
            vec!["--seeds", "8..64", "--error", "enrgy=2%"],
            "did you mean `energy`?",
        ),
        (
            vec!["--seeds", "8..64", "--error", "energy=2 m"],
            "the result is in J",
        ),
        (vec!["--error", "energy=2%"], "--seeds"),
    ] {
        let all: Vec<&str> = [&["grains.toml"][..], &arguments, &result].concat();
        let (code, _, errors) = solve(folder.path(), &all);
        assert_eq!(code, Some(2), "{arguments:?}: {errors}");
        assert!(errors.contains(part), "{arguments:?}: {errors}");
    }
    assert!(!folder.path().join("grains-study").exists());
}
