//! Output of the program for other programs: `docs/formats/machine.md`.

use std::fs;
use std::path::Path;

use crate::common::{code, errors, folder_with, said, solve};
use serde_json::{Value, json};

const SCENE: &str = r#"title = "Two spheres"

[time]
end = 0.002
step = 1e-5

[domain]
min = [0.0, 0.0, 0.0]
max = [0.1, 0.1, 0.1]

[materials.glass]
density = 2500.0
normal = { law = "linear", stiffness = 1000.0, restitution = 0.8 }

[[particles]]
material = "glass"
radius = 0.01
position = [0.03, 0.05, 0.05]
velocity = [0.1, 0.0, 0.0]

[[particles]]
material = "glass"
radius = 0.01
position = [0.0501, 0.05, 0.05]
velocity = [-0.1, 0.0, 0.0]

[output]
interval = 0.001
pictures = false
"#;

const TRIANGLE: &str = "solid plate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid plate\n";

/// Object on standard output, which holds nothing else.
fn object(output: &std::process::Output) -> Value {
    let text = said(output);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text:?}"))
}

fn problems(folder: &Path, arguments: &[&str]) -> Vec<Value> {
    let output = solve(folder, arguments);
    assert_eq!(code(&output), Some(2), "{}", errors(&output));
    // People still read what is wrong.
    assert!(!errors(&output).is_empty());
    let object = object(&output);
    object["problems"].as_array().expect("a list").clone()
}

#[test]
fn problems_have_their_places() {
    let text = SCENE
        .replace("density = 2500.0", "density = -1.0")
        .replace("[output]\n", "[output]\nintervall = 1\n");
    let folder = folder_with("pair.toml", &text);
    for check in [&["--check"][..], &[]] {
        let found = problems(
            folder.path(),
            &[&["pair.toml", "--json", "--set", "time.step=0"], check].concat(),
        );
        let expected = json!([
            {
                "file": "pair.toml", "line": 12, "column": 11, "end_line": 12, "end_column": 15,
                "key": "materials.glass.density", "message": "must be > 0, got -1.0", "help": null
            },
            {
                "file": "pair.toml", "line": 28, "column": 1, "end_line": 28, "end_column": 10,
                "key": "output.intervall", "message": "is not a known key", "help": "did you mean `interval`?"
            },
            {
                "file": null, "line": null, "column": null, "end_line": null, "end_column": null,
                "key": "time.step", "message": "must be > 0, got 0", "help": null, "set": "time.step=0"
            },
        ]);
        assert_eq!(Value::from(found), expected);
    }
}

#[test]
fn whatever_ends_without_its_object_says_why_in_one() {
    let folder = folder_with("pair.toml", SCENE);
    let one = |arguments: &[&str]| {
        let found = problems(folder.path(), arguments);
        assert_eq!(found.len(), 1, "{found:?}");
        found[0].clone()
    };
    let missing = one(&["pear.toml", "--json"]);
    assert_eq!(missing["file"], "pear.toml");
    assert_eq!(missing["line"], Value::Null);
    assert_eq!(missing["help"], "did you mean `pair.toml`?");
    let usage = one(&["pair.toml", "--json", "--nonsense"]);
    assert_eq!(usage["message"], "unexpected argument '--nonsense' found");
    assert!(usage["help"].as_str().unwrap().starts_with("to pass "));
    let broken = one(&["pair.toml", "--json", "--set", "time=["]);
    assert_eq!(broken["set"], "time=[");
    // A folder with a run in it.
    assert_eq!(code(&solve(folder.path(), &["pair.toml"])), Some(0));
    let there = one(&["pair.toml", "--json"]);
    assert!(
        there["message"]
            .as_str()
            .unwrap()
            .contains("holds a run already")
    );
    assert!(there["help"].as_str().unwrap().contains("--force"));
    let checkpoint = one(&["--inspect", "pair.toml", "--json"]);
    assert!(
        checkpoint["message"]
            .as_str()
            .unwrap()
            .starts_with("pair.toml: ")
    );
    // Without --json nothing but text.
    let output = solve(folder.path(), &["pear.toml"]);
    assert_eq!((said(&output), code(&output)), (String::new(), Some(2)));
}

/// A thousand of a hundred thousand are listed, and the others are counted.
#[test]
fn problems_have_an_end() {
    let walls = "[[walls]]\nshape = \"ball\"\nmaterial = \"glass\"\n".repeat(1200);
    let folder = folder_with("pair.toml", &format!("{SCENE}{walls}"));
    let output = solve(folder.path(), &["pair.toml", "--check", "--json"]);
    let object = object(&output);
    let (listed, more) = (&object["problems"], &object["more"]);
    assert_eq!(listed.as_array().unwrap().len(), 1000);
    assert_eq!(more, 200);
}

#[test]
fn a_plan_that_does_not_fit_is_reported_with_its_problem() {
    // A terabyte, which no machine of a test has.
    let rain = "[[insertions]]\nname = \"rain\"\nmaterial = \"glass\"\ntotal = { number = 1_000_000_000 }\n\
        region = { shape = \"box\", min = [0, 0, 0], max = [0.1, 0.1, 0.1] }\n\
        psd = { kind = \"monodisperse\", diameter = 1e-5 }\n";
    let folder = folder_with("pair.toml", &format!("{SCENE}{rain}"));
    let arguments = ["pair.toml", "--check", "--json", "--set", "time.step=auto"];
    let output = solve(folder.path(), &arguments);
    assert_eq!(code(&output), Some(2));
    let plan = object(&output);
    assert_eq!(plan["title"], "Two spheres");
    assert_eq!(plan["problems"][0]["key"], "insertions.rain");
}

#[test]
fn the_plan_states_version_files_and_walls() {
    let scene = format!(
        "{SCENE}{}",
        r#"
[[walls]]
name = "plate"
material = "glass"
shape = "mesh"
file = "in/plate.stl"
motion = [{ kind = "table", file = "in/motion.csv" }]

[[walls]]
name = "floor"
material = "glass"
shape = "plane"
point = [0.0, 0.0, 0.01]
normal = [0.0, 0.0, 2.0]

[[insertions]]
name = "rain"
material = "glass"
total = { number = 1 }
region = { shape = "box", min = [0, 0, 0.05], max = [0.1, 0.1, 0.1] }
psd = { file = "in/law.toml" }
"#
    );
    let folder = folder_with("pair.toml", &scene);
    fs::create_dir(folder.path().join("in")).unwrap();
    let files = [
        ("plate.stl", TRIANGLE),
        (
            "motion.csv",
            "t,x,y,z,angle_x,angle_y,angle_z\n-1,0,0,0,0,0,0\n1,0.2,0,0,0,0,0\n",
        ),
        (
            "law.toml",
            "kind = \"mixture\"\nweighting = \"volume\"\nof = [{ share = 1, file = \"sizes.csv\" }]\n",
        ),
        (
            "sizes.csv",
            "diameter [mm],cumulative volume [%]\n1,0\n2,100\n",
        ),
    ];
    for (name, text) in files {
        fs::write(folder.path().join("in").join(name), text).unwrap();
    }
    let output = solve(
        folder.path(),
        &[
            "pair.toml",
            "--check",
            "--json",
            "--set",
            "seed=18446744073709551615",
        ],
    );
    // Above 2^63 TOML has no integers.
    assert_eq!(code(&output), Some(2), "{}", said(&output));
    let output = solve(
        folder.path(),
        &["pair.toml", "--check", "--json", "--set", "seed=7"],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let plan = object(&output);
    assert_eq!(plan["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(plan["seed"], 7);
    assert_eq!(plan["scene"]["name"], "pair.toml");
    assert_eq!(plan["scene"]["bytes"], scene.len());

    let listed: Vec<[String; 3]> = (plan["files"].as_array().unwrap().iter())
        .map(|file| {
            let text = |key: &str| file[key].as_str().unwrap_or_default().to_owned();
            let name = text("name");
            // By the program of the system, where it has one.
            if let Ok(output) = std::process::Command::new("sha256sum")
                .arg(
                    folder
                        .path()
                        .join("in")
                        .join(name.trim_start_matches("in/")),
                )
                .output()
            {
                let sum = String::from_utf8(output.stdout).unwrap();
                assert_eq!(sum.split(' ').next(), file["sha256"].as_str(), "{name}");
            }
            assert!(file["bytes"].is_u64());
            [text("key"), name, text("from")]
        })
        .collect();
    let expected = [
        ["walls.plate.file", "in/plate.stl", ""],
        ["walls.plate.motion[0].file", "in/motion.csv", ""],
        ["insertions.rain.psd.file", "in/law.toml", ""],
        ["insertions.rain.psd.file", "sizes.csv", "in/law.toml"],
    ];
    let mut sorted = listed.clone();
    sorted.sort();
    let mut wanted = expected.map(|row| row.map(str::to_owned)).to_vec();
    wanted.sort();
    assert_eq!(sorted, wanted);

    let walls = plan["walls"].as_array().unwrap();
    assert_eq!(
        walls[0]["shape"],
        json!({ "kind": "mesh", "triangles": 1, "min": [0.0, 0.0, 0.0], "max": [0.1, 0.1, 0.0] })
    );
    // Half-way between the rows of its table.
    assert_eq!(
        walls[0]["pose"],
        json!({ "x": [0.1, 0.0, 0.0], "q": [1.0, 0.0, 0.0, 0.0] })
    );
    assert_eq!(
        walls[1]["shape"],
        json!({ "kind": "plane", "point": [0.0, 0.0, 0.01], "normal": [0.0, 0.0, 1.0] })
    );
    assert_eq!(walls[1]["pose"]["q"], json!([1.0, 0.0, 0.0, 0.0]));
}

#[test]
fn a_study_is_reported_run_by_run() {
    let folder = folder_with("pair.toml", SCENE);
    let arguments = [
        "pair.toml",
        "--sweep",
        "time.end=0.001,0.002",
        "--set",
        "seed=3",
        "--result",
        "v=max(particles.vx)",
        "--json",
    ];
    let reported = object(&solve(
        folder.path(),
        &[&arguments[..], &["--check"]].concat(),
    ));
    let study = &reported["study"];
    // The size of each run is that in the plan of the same run.
    let runs = study["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    for (run, end) in runs.iter().zip(["0.001", "0.002"]) {
        assert_eq!(run["name"], format!("end={end}"));
        assert_eq!(run["set"], json!(["seed=3", format!("time.end={end}")]));
        let set = format!("time.end={end}");
        let one = [
            "pair.toml",
            "--check",
            "--json",
            "--set",
            "seed=3",
            "--set",
            &set,
        ];
        let plan = object(&solve(folder.path(), &one));
        assert_eq!(run["steps"], plan["time"]["steps"]);
        assert_eq!(run["memory"], plan["memory"]["at_most"]);
        assert_eq!(run["disk"], plan["disk"]["bytes"]);
    }
    assert_eq!(study["results"], json!({ "v": "max(particles.vx)" }));
    assert_eq!(study["scene"], "pair.toml");
    assert!(study["title"].is_string());
    let output = solve(folder.path(), &arguments);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let reported = object(&output);
    let rows = reported["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[1]["run"], "end=0.002");
    assert_eq!(rows[1]["status"], "finished");
    assert_eq!(rows[1]["time.end"], 0.002);
    assert_eq!(rows[1]["steps"], 200);
    assert!(rows[1]["v"].is_f64());
    // An error of the scene in all runs is reported once.
    let wrong = [&arguments[..], &["--set", "time.step=-1", "--force"]].concat();
    let found = problems(folder.path(), &wrong);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0]["set"], "time.step=-1");
}

#[test]
fn a_checkpoint_is_reported_in_numbers() {
    let folder = folder_with("pair.toml", SCENE);
    assert_eq!(
        code(&solve(folder.path(), &["pair.toml", "--quiet"])),
        Some(0)
    );
    let output = solve(
        folder.path(),
        &["--inspect", "pair/pair.0.restart", "--json"],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let reported = object(&output);
    assert_eq!(reported["step"], 200);
    assert_eq!(reported["time_step"], 1e-5);
    assert_eq!(reported["particles"], 2);
    assert_eq!(reported["frames"], 3);
    assert_eq!(reported["title"], "Two spheres");
    let bytes = fs::metadata(folder.path().join("pair/pair.0.restart"))
        .unwrap()
        .len();
    assert_eq!(reported["bytes"], bytes);
    assert_eq!(reported["scene"]["time.end"], 0.002);
    assert_eq!(reported["scene"]["materials.glass.normal.law"], "linear");
    assert_eq!(reported["scene"]["output.pictures"], false);
}

/// Text of a file outside of the folder must be in no answer, nor whether the file is there.
#[cfg(unix)]
#[test]
fn nothing_outside_of_a_folder_is_read() {
    use std::os::unix::fs::symlink;
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("inside");
    fs::create_dir_all(folder.join("in")).unwrap();
    fs::create_dir(place.path().join("outside")).unwrap();
    const SECRET: &str = "root-x-0-0";
    let secret = place.path().join("outside/secret");
    fs::write(&secret, format!("{SECRET}:{SECRET},{SECRET}\n")).unwrap();
    // A checkpoint out there, and links to all.
    fs::write(place.path().join("outside/pair.toml"), SCENE).unwrap();
    let outside = place.path().join("outside");
    assert_eq!(code(&solve(&outside, &["pair.toml", "--quiet"])), Some(0));
    symlink(&secret, folder.join("in/link")).unwrap();
    symlink(&secret, folder.join("in/link.csv")).unwrap();
    symlink(&secret, folder.join("in/link.stl")).unwrap();
    symlink(&secret, folder.join("in/link.toml")).unwrap();
    symlink(outside.join("nothing"), folder.join("in/dangling.csv")).unwrap();
    symlink(outside.join("pair"), folder.join("in/run")).unwrap();
    fs::create_dir(folder.join("in/linked-run")).unwrap();
    symlink(
        outside.join("pair/pair.0.restart"),
        folder.join("in/linked-run/pair.0.restart"),
    )
    .unwrap();
    fs::write(folder.join("in/names-one.toml"), "kind = \"mixture\"\nweighting = \"volume\"\nof = [{ share = 1, file = \"../../outside/secret\" }]\n").unwrap();
    let clump =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/rod.clump.toml"))
            .unwrap();
    let surface = "surface = \"../../outside/secret\"\n";
    fs::write(
        folder.join("in/rod.clump.toml"),
        format!("{surface}{clump}"),
    )
    .unwrap();
    fs::write(folder.join("in/plate.stl"), TRIANGLE).unwrap();

    let absolute = secret.display().to_string();
    let names = [
        absolute.as_str(),
        "../outside/secret",
        "../outside/nothing",
        "in/../../outside/secret",
        "in/link",
        "in/link.csv",
        "in/link.stl",
        "in/link.toml",
        "in/dangling.csv",
    ];
    let wall = |name: &str| {
        format!("[[walls]]\nmaterial = \"glass\"\nshape = \"mesh\"\nfile = {name:?}\n")
    };
    let plane =
        "[[walls]]\nmaterial = \"glass\"\nshape = \"plane\"\npoint = [0,0,0]\nnormal = [0,0,1]\n";
    let insertion = "[[insertions]]\nmaterial = \"glass\"\nregion = { shape = \"box\", min = [0,0,0.06], max = [0.1,0.1,0.1] }\n";
    let sizes = "psd = { kind = \"monodisperse\", diameter = 1e-3 }\ntotal = { number = 1 }\n";
    let mut scenes = Vec::new();
    for name in names {
        scenes.extend([
            wall(name),
            format!("{plane}motion = [{{ kind = \"table\", file = {name:?} }}]\n"),
            format!("{plane}motion = [{{ kind = \"servo\", axis = [0,0,1], max_speed = 1, force = {{ table = {name:?} }} }}]\n"),
            format!("[[particles]]\nmaterial = \"glass\"\nfile = {name:?}\n"),
            format!("[clumps.rod]\nmaterial = \"glass\"\nfile = {name:?}\n"),
            format!("{insertion}total = {{ number = 1 }}\npsd = {{ kind = \"file\", file = {name:?} }}\n"),
            format!("{insertion}{sizes}rate = {{ table = {name:?} }}\n"),
            format!("[[regions]]\nregion = {{ shape = \"mesh\", file = {name:?} }}\n"),
            format!("[[fields]]\nname = \"f\"\npoints = {name:?}\nfields = [\"density\"]\n"),
        ]);
    }
    for name in ["../outside/pair", "in/run", "in/linked-run"] {
        scenes.push(format!("[[particles]]\nrun = {name:?}\n"));
    }
    scenes.push(format!(
        "{insertion}total = {{ number = 1 }}\npsd = {{ file = \"in/names-one.toml\" }}\n"
    ));
    for (number, more) in scenes.iter().enumerate() {
        fs::write(folder.join("scene.toml"), format!("{SCENE}{more}")).unwrap();
        for more_arguments in [&["--check", "--json"][..], &[]] {
            let arguments = [&["scene.toml", "--within", "."], more_arguments].concat();
            let output = solve(&folder, &arguments);
            let text = said(&output) + &errors(&output);
            assert_eq!(code(&output), Some(2), "{number}: {more}{text}");
            assert!(!text.contains(SECRET), "{number}: {more}{text}");
            assert!(text.contains("--within"), "{number}: {more}{text}");
            // No path of the machine but the one that was typed.
            let others = text.replace(&absolute, "");
            assert!(
                !others.contains(&*place.path().to_string_lossy()),
                "{number}: {more}{text}"
            );
        }
    }
    // A surface is looked at only, and missed with a warning.
    let rod = "[clumps.rod]\nmaterial = \"glass\"\nfile = \"in/rod.clump.toml\"\n";
    fs::write(folder.join("scene.toml"), format!("{SCENE}{rod}")).unwrap();
    let output = solve(
        &folder,
        &["scene.toml", "--within", ".", "--check", "--json"],
    );
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    assert!(!said(&output).contains(SECRET));
    let plan = object(&output);
    assert!(
        plan["warnings"][0]
            .as_str()
            .unwrap()
            .contains("leads out of the folder")
    );
    assert_eq!(
        plan["files"].as_array().unwrap().len(),
        1,
        "{}",
        plan["files"]
    );

    // Files inside are read, by whatever name the folder has.
    fs::write(
        folder.join("scene.toml"),
        format!("{SCENE}{}", wall("in/../in/plate.stl")),
    )
    .unwrap();
    for within in [".", "../inside", &folder.display().to_string()] {
        let output = solve(&folder, &["scene.toml", "--within", within, "--check"]);
        assert_eq!(code(&output), Some(0), "{within}: {}", errors(&output));
    }
    // The scene itself, the run's folder, studies and checkpoints.
    fs::write(
        folder.join("study.toml"),
        "[study]\nscene = \"../outside/pair.toml\"\nsweep = { seed = [1, 2] }\n",
    )
    .unwrap();
    fs::write(folder.join("far.toml"), "[study]\nscene = \"scene.toml\"\nfolder = \"../outside/table\"\nsweep = { seed = [1, 2] }\n").unwrap();
    fs::create_dir(folder.join("own")).unwrap();
    symlink(
        outside.join("pair/pair.data"),
        folder.join("own/scene.data"),
    )
    .unwrap();
    for arguments in [
        &["../outside/pair.toml"][..],
        &["in/link.toml"],
        &["scene.toml", "--output", "../outside/new"],
        &["scene.toml", "--output", "in/run", "--force"],
        &["scene.toml", "--output", "own", "--force"],
        &["study.toml"],
        &["far.toml"],
        &["--inspect", "../outside/pair/pair.0.restart"],
        &["--inspect", "in/linked-run/pair.0.restart"],
    ] {
        let arguments = [arguments, &["--within", "."]].concat();
        let output = solve(&folder, &arguments);
        assert_eq!(code(&output), Some(2), "{arguments:?}: {}", said(&output));
        assert!(
            errors(&output).contains("--within"),
            "{arguments:?}: {}",
            errors(&output)
        );
    }
    assert!(!outside.join("new").exists() && !outside.join("table").exists());
    assert!(
        fs::read_to_string(outside.join("pair/pair.data"))
            .unwrap()
            .len()
            > 100
    );
    let nowhere = solve(&folder, &["scene.toml", "--within", "nowhere"]);
    assert_eq!(code(&nowhere), Some(2));
}

/// A ball that crosses a plane of a known mass rate, and what is there of it.
const RESULTS: &str = r#"
[[fluxes]]
name = "gate"
plane = { point = [0.04, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }

[[regions]]
name = "all"
region = { shape = "box", min = [0, 0, 0], max = [0.1, 0.1, 0.1] }
"#;

#[test]
fn one_run_has_results_too() {
    // One ball alone, at 0.1 m/s from x = 0.03 to 0.05: through the gate at t = 0.1 s of 0.2.
    let first = SCENE.find("[[particles]]").unwrap();
    let second = SCENE.rfind("[[particles]]").unwrap();
    let output = SCENE.find("[output]").unwrap();
    let scene = [
        &SCENE[..first],
        &SCENE[first..second],
        RESULTS,
        &SCENE[output..],
    ]
    .concat();
    let folder = folder_with("one.toml", &scene);
    let run = [
        "one.toml",
        "--set",
        "time.end=0.2",
        "--set",
        "output.interval=0.04",
        "--result",
        "flow=rate(flux.gate.mass)",
        "--result",
        "behind=rate(flux.gate.mass, 0.12..)",
        "--result",
        "speed=mean(particles.vx)",
        "--result",
        "never=rate(flux.gate.mass, 0.3..)",
    ];
    let output = solve(folder.path(), &[&run[..], &["--json"]].concat());
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let summary = object(&output);
    let kept = fs::read_to_string(folder.path().join("one/summary.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&kept).unwrap(), summary);
    let results = &summary["results"];
    let names: Vec<&String> = results.as_object().unwrap().keys().collect();
    assert_eq!(names, ["flow", "behind", "speed", "never"]);
    // 2500 kg/m3 of 4/3 pi 0.01^3 m3 in 0.2 s.
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    let flow = results["flow"]["value"].as_f64().unwrap();
    assert!((flow / (mass / 0.2) - 1.0).abs() < 1e-12, "{flow}");
    assert_eq!(results["flow"]["unit"], "kg/s");
    assert_eq!(results["flow"]["of"], "rate(flux.gate.mass)");
    for (name, of, value, unit, why) in [
        (
            "behind",
            "rate(flux.gate.mass, 0.12..)",
            0.0,
            "kg/s",
            "2 rows lie in its window",
        ),
        ("speed", "mean(particles.vx)", 0.1, "m/s", "of one state"),
    ] {
        let result = &results[name];
        assert_eq!(
            (&result["of"], &result["value"], &result["unit"]),
            (&json!(of), &json!(value), &json!(unit))
        );
        assert_eq!(result["error"], Value::Null);
        let said = result["why_no_error"].as_str().unwrap();
        assert!(said.contains(why), "{said}");
    }
    assert_eq!(results["never"]["value"], Value::Null);
    assert!(
        results["never"]["problem"]
            .as_str()
            .unwrap()
            .contains("two rows")
    );
    // People read them in the report.
    let output = solve(folder.path(), &[&run[..], &["--force"]].concat());
    assert!(
        said(&output).contains("  result     flow = 0.05"),
        "{}",
        said(&output)
    );
    assert!(said(&output).contains(" kg/s\n"), "{}", said(&output));
    // One that was forgotten is had of the finished run.
    let more = [
        "one.toml",
        "--set",
        "time.end=0.2",
        "--set",
        "output.interval=0.04",
        "--resume",
        "--json",
        "--result",
        "x=last(particles.x)",
    ];
    let output = solve(folder.path(), &more);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let again = object(&output);
    assert!((again["results"]["x"]["value"].as_f64().unwrap() - 0.05).abs() < 1e-9);
    assert_eq!(again["results"]["flow"], results["flow"]);
    assert_eq!(again["steps"], summary["steps"]);
    let kept = fs::read_to_string(folder.path().join("one/summary.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&kept).unwrap(), again);
}

#[test]
fn results_that_a_run_will_not_have_are_refused_before_it() {
    let folder = folder_with("pair.toml", &format!("{SCENE}{RESULTS}"));
    for (result, more, message, help) in [
        (
            "a=mean(walls.drum.ty)",
            "seed=1",
            "there is no wall `drum`",
            None,
        ),
        (
            "a=sum(flux.gates.mass)",
            "seed=1",
            "there is no plane of [[fluxes]] `gates`",
            Some("did you mean `gate`?"),
        ),
        (
            "a=mean(regions.none.mass)",
            "seed=1",
            "there is no region `none`",
            Some("there are: all"),
        ),
        (
            "a=mean(regions.all.glas.mass)",
            "seed=1",
            "there is no material of particles `glas`",
            Some("did you mean `glass`?"),
        ),
        (
            "a=max(particles.w)",
            "seed=1",
            "there is no column of particles `w`",
            None,
        ),
        (
            "a=max(particles.z)",
            "output.frames=false",
            "output.frames = false leaves it out",
            Some("set output.frames = true, or leave the key out"),
        ),
        (
            "a=last(energy.time)",
            "output.ene=false",
            "output.ene = false leaves it out",
            None,
        ),
    ] {
        for check in [&["--check"][..], &[], &["--sweep", "time.end=0.001,0.002"]] {
            let arguments = ["pair.toml", "--json", "--result", result, "--set", more];
            let found = problems(folder.path(), &[&arguments[..], check].concat());
            assert_eq!(found.len(), 1, "{found:?}");
            let text = found[0]["message"].as_str().unwrap();
            assert!(text.contains(message), "{text}");
            if let Some(help) = help {
                assert_eq!(found[0]["help"], help);
            }
        }
    }
    assert!(!folder.path().join("pair").exists() && !folder.path().join("pair-study").exists());
    let twice = [
        "pair.toml",
        "--json",
        "--result",
        "a=max(particles.z)",
        "--result",
        "a=min(particles.z)",
    ];
    assert!(
        problems(folder.path(), &twice)[0]["message"]
            .as_str()
            .unwrap()
            .contains("given before")
    );
}
