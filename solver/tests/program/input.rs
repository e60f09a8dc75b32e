//! Scenes from standard input and in JSON, the copy that a run keeps of its scene, and messages for names that are no files.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use crate::common::{code, command, errors, folder_with, results, said, solve};

const SCENE: &str = r#"
title = "Two balls"

[time]
end = 0.004
step = 1e-5

[domain]
min = [0.0, 0.0, 0.0]
max = [0.1, 0.1, 0.1]

[materials.ball]
density = 2500.0
normal = { law = "linear", stiffness = 1e5, restitution = 0.8 }

[[particles]]
material = "ball"
radius = 0.01
position = [0.05, 0.05, 0.05]
velocity = [0.1, 0.0, -1.0]

[output]
interval = 0.001
pictures = false
"#;

const JSON: &str = r#"{
  "title": "Two balls",
  "time": {"end": 0.004, "step": 1e-5},
  "domain": {"min": [0, 0, 0], "max": [0.1, 0.1, 0.1]},
  "materials": {"ball": {"density": 2500, "normal": {"law": "linear", "stiffness": 1e5, "restitution": 0.8}}},
  "particles": [{"material": "ball", "radius": "1 cm", "position": [0.05, 0.05, 0.05], "velocity": [0.1, 0, -1]}],
  "output": {"interval": 0.001, "pictures": false}
}
"#;

fn solve_from(folder: &Path, text: &str, arguments: &[&str]) -> Output {
    let mut command = command(folder, arguments);
    command.stdin(Stdio::piped());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // A program that refuses its arguments does not read.
    let _ = child.stdin.take().unwrap().write_all(text.as_bytes());
    child.wait_with_output().unwrap()
}

#[test]
fn a_scene_from_standard_input_runs_as_one_from_a_file_and_json_as_toml() {
    let folder = folder_with("scene.toml", SCENE);
    let place = folder.path();
    fs::write(place.join("scene.json"), JSON).unwrap();
    for (text, arguments) in [
        ("", ["scene.toml", "--output", "file"]),
        ("", ["scene.json", "--output", "json"]),
        (SCENE, ["-", "--output", "piped"]),
        (JSON, ["-", "--output", "piped-json"]),
    ] {
        let output = solve_from(place, text, &arguments);
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
    }
    let of = |run: &str, ending: &str| {
        let mut all = results(&place.join(run), "scene");
        let copy = all.remove(&format!("scene.scene.{ending}"));
        // It has the sum of the text of the scene.
        assert!(all.remove("scene.chain.jsonl").is_some());
        (all, copy.unwrap())
    };
    let (expected, copy) = of("file", "toml");
    assert!(copy == SCENE.as_bytes());
    for (run, ending, text) in [
        ("json", "json", JSON),
        ("piped", "toml", SCENE),
        ("piped-json", "json", JSON),
    ] {
        let (found, copy) = of(run, ending);
        assert!(found == expected, "{run}");
        assert!(copy == text.as_bytes(), "{run}");
    }
    // Without --output by the name of no file.
    assert_eq!(code(&solve_from(place, SCENE, &["-"])), Some(0));
    assert!(place.join("scene/scene.data").exists());
}

#[test]
fn mistakes_from_standard_input_have_their_line() {
    let folder = tempfile::tempdir().unwrap();
    for (text, message) in [
        (
            SCENE.replace("radius = 0.01", "radius = -0.01"),
            "<stdin>:18:10: particles[0].radius: must be > 0",
        ),
        (
            JSON.replace("\"1 cm\"", "-1"),
            "<stdin>:6:48: particles[0].radius: must be > 0",
        ),
        (
            JSON.replace("\"1 cm\"", "1 cm"),
            "<stdin>:6:50: not valid JSON: unexpected token",
        ),
        (String::new(), ": time: is missing"),
    ] {
        let output = solve_from(folder.path(), &text, &["-"]);
        assert_eq!(code(&output), Some(2));
        assert!(errors(&output).contains(message), "{}", errors(&output));
        let output = solve_from(folder.path(), &text, &["-", "--json"]);
        let problems: serde_json::Value = serde_json::from_str(&said(&output)).unwrap();
        assert_eq!(problems["problems"][0]["file"], "<stdin>");
    }
    let output = solve_from(folder.path(), "", &["-", "--json"]);
    assert_eq!(code(&output), Some(2));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_run_from_standard_input_is_resumed_and_swept() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    assert_eq!(code(&solve_from(place, SCENE, &["-"])), Some(0));
    let longer = ["-", "--resume", "--set", "time.end=0.006"];
    let output = solve_from(place, JSON, &longer);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    assert!(
        said(&output).contains("resumed    from t = 0.004 s"),
        "{}",
        said(&output)
    );
    // The copy is that of the scene that was gone on with.
    assert_eq!(
        fs::read_to_string(place.join("scene/scene.scene.json")).unwrap(),
        JSON
    );
    assert!(!place.join("scene/scene.scene.toml").exists());
    let sweep = ["-", "--sweep", "particles.0.radius=5 mm,1 cm"];
    let output = solve_from(place, SCENE, &sweep);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let copy = place.join("scene-study/radius=5mm/scene.scene.toml");
    assert_eq!(fs::read_to_string(copy).unwrap(), SCENE);
    let study = r#"{"study": {"scene": "scene/scene.scene.json", "sweep": {"seed": [1, 2]}}}"#;
    let output = solve_from(place, study, &["-", "--check"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    assert!(
        said(&output).starts_with("2 runs in study:"),
        "{}",
        said(&output)
    );
    let output = solve_from(place, "{\"study\": {\"scene\": }}", &["-", "--check"]);
    let message = "<stdin>:1:21: not valid JSON: expected value";
    assert!(errors(&output).contains(message), "{}", errors(&output));
}

#[test]
fn force_replaces_the_copy_and_never_the_scene_that_is_run() {
    let folder = folder_with("ball.toml", SCENE);
    let place = folder.path();
    let run = ["ball.toml", "--output", "."];
    assert_eq!(code(&solve(place, &run)), Some(0));
    let other = SCENE.replace("Two balls", "Two other balls");
    fs::write(place.join("ball.toml"), &other).unwrap();
    let output = solve(place, &[&run[..], &["--force"]].concat());
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    assert_eq!(fs::read_to_string(place.join("ball.toml")).unwrap(), other);
    let copy = place.join("ball.scene.toml");
    assert_eq!(fs::read_to_string(&copy).unwrap(), other);
    // The copy as a scene of its own, in the folder of its run.
    let output = solve(place, &["ball.scene.toml", "--output", ".", "--force"]);
    assert_eq!(code(&output), Some(2), "{}", errors(&output));
    let message = "ball.scene.toml: this scene is a file of the run in ., which would be replaced";
    assert!(errors(&output).contains(message), "{}", errors(&output));
    assert_eq!(fs::read_to_string(&copy).unwrap(), other);
    assert_eq!(code(&solve(place, &["ball.scene.toml"])), Some(0));
}

#[test]
fn a_link_that_leads_nowhere_is_named() {
    let folder = folder_with("ball.toml", SCENE);
    let place = folder.path();
    std::os::unix::fs::symlink("gone", place.join("link")).unwrap();
    for output in ["link", "link/below"] {
        for more in [&[][..], &["--sweep", "seed=1,2"]] {
            let arguments = [&["ball.toml", "--output", output], more].concat();
            let found = solve(place, &arguments);
            assert_eq!(code(&found), Some(2), "{}", errors(&found));
            let message =
                "link: this link leads to gone, which is not there\nhelp: make that folder";
            assert!(errors(&found).contains(message), "{}", errors(&found));
        }
    }
}

#[test]
fn what_is_no_scene_and_no_checkpoint_is_said_in_plain_words() {
    let folder = folder_with("ball.toml", SCENE);
    let place = folder.path();
    let reported = |arguments: &[&str], message: &str| {
        let output = solve(place, arguments);
        assert_eq!(code(&output), Some(2), "{arguments:?}");
        assert!(errors(&output).contains(message), "{}", errors(&output));
    };
    reported(&["nosuch.toml"], "nosuch.toml: the scene cannot be read: ");
    assert!(!errors(&solve(place, &["nosuch.toml"])).contains("1:1"));
    fs::write(place.join("empty.restart"), "").unwrap();
    reported(
        &["--inspect", "empty.restart"],
        "the file is empty: there is no state of a run in it",
    );
    fs::write(place.join("cut.restart"), "MERC").unwrap();
    reported(&["--inspect", "cut.restart"], "cut off in section `head`");
}

#[test]
fn a_run_without_frames_takes_some_room_all_the_same() {
    let quiet = SCENE.replace(
        "interval = 0.001",
        "interval = 0.001\ndata = false\nframes = false\nene = false\nwalls = false",
    );
    let folder = folder_with("ball.toml", &quiet);
    let output = solve(folder.path(), &["ball.toml", "--check"]);
    assert!(said(&output).contains("about 10 kB"), "{}", said(&output));
}

/// A filling is a fraction of the volume of a region within the domain: here of a ball of 20 mm, and of the half of it that is in the domain.
#[test]
fn a_filling_is_a_fraction_of_a_region() {
    let scene = |total: &str, origin: &str| {
        format!(
            "[time]\nend = 1e-3\nstep = 1e-5\n[domain]\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\n\
            [materials.m]\ndensity = 2500\nnormal = {{ law = \"linear\", stiffness = 1e3, restitution = \"50 %\" }}\n\
            [[regions]]\nname = \"ball\"\nregion = {{ shape = \"sphere\", origin = {origin}, radius = 0.02 }}\n\
            [[insertions]]\nregion = {{ shape = \"box\", min = [0, 0, 0.04], max = [0.1, 0.1, 0.1] }}\nmaterial = \"m\"\n\
            psd = {{ kind = \"monodisperse\", diameter = 2e-3 }}\ntotal = {{ {total} }}\n[output]\ninterval = 1e-3\n"
        )
    };
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 8e-6;
    for (total, origin, volume) in [
        (
            "fill = 0.4, of = \"ball\"",
            "[0.05, 0.05, 0.05]",
            0.4 * ball,
        ),
        (
            "fill = \"10 %\"",
            "[0.05, 0.05, 0.05]",
            0.1 * 0.1 * 0.1 * 0.06,
        ),
        ("fill = 0.4, of = \"ball\"", "[0.05, 0.05, 0]", 0.2 * ball),
    ] {
        // Shapes that lie wholly in the domain are exact, parts of them are summed by cells, to about a thousandth.
        let error = if origin.ends_with(", 0]") {
            2e-3
        } else {
            1e-12
        };
        let folder = folder_with("fill.toml", &scene(total, origin));
        let output = solve(folder.path(), &["fill.toml", "--check", "--json"]);
        let text = said(&output);
        let plan: serde_json::Value =
            serde_json::from_str(&text).unwrap_or_else(|_| panic!("{text}"));
        let found = plan["insertions"][0]["total"]["volume"].as_f64();
        let found = found.unwrap_or_else(|| panic!("{plan}"));
        assert!(
            (found - volume).abs() < error * volume,
            "{total}: {found} for {volume}"
        );
    }
    let wrong = scene("fill = 0.4, of = \"bal\"", "[0.05, 0.05, 0.05]");
    let folder = folder_with("fill.toml", &wrong);
    let output = solve(folder.path(), &["fill.toml", "--check"]);
    let text = errors(&output);
    let refused = "fill.toml:17:28: insertions[0].total.of: there is no region \"bal\"";
    assert!(text.starts_with(refused), "{text}");
    assert!(text.contains("help: did you mean `ball`?"), "{text}");
}

/// A plan of it can be looked at; a run needs the other program.
#[test]
fn a_wall_that_another_program_drives_is_not_run_from_here() {
    let wall = "[[walls]]\nname = \"lid\"\nshape = \"plane\"\npoint = [0, 0, 0.09]\nnormal = [0, 0, -1]\nmaterial = \"ball\"\nmotion = \"external\"\n";
    let folder = folder_with("scene.toml", &format!("{SCENE}{wall}"));
    let checked = solve(folder.path(), &["scene.toml", "--check"]);
    assert_eq!(code(&checked), Some(0), "{}", errors(&checked));
    assert!(said(&checked).contains("driven by another program"));
    let run = solve(folder.path(), &["scene.toml"]);
    assert_eq!(code(&run), Some(2));
    let message = errors(&run);
    assert!(
        message.contains("wall `lid` is driven by another program"),
        "{message}"
    );
    assert!(!folder.path().join("scene").exists());
    fs::write(
        folder.path().join("scene.toml"),
        format!("{SCENE}{wall}").replace("external", "outside"),
    )
    .unwrap();
    let wrong = solve(folder.path(), &["scene.toml", "--check"]);
    assert_eq!(code(&wrong), Some(2));
    assert!(errors(&wrong).contains("external"), "{}", errors(&wrong));
}
