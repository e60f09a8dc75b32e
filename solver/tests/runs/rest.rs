//! `until_at_rest`: a run ends when nothing is left that moves, will move, or can set something in motion, and not before.

use std::fs;
use std::process::Command;

/// A ball of 5 mm over a floor, with a linear contact of 2e-3 s or so.
fn scene(ball: &str, more: &str) -> String {
    format!(
        r#"
        gravity = [0, 0, -9.81]
        time = {{ end = 2.0, step = 2e-5, until_at_rest = true }}
        domain = {{ min = [-0.05, -0.05, 0], max = [0.05, 0.05, 0.1] }}
        materials.m = {{ density = 2500.0, normal = {{ law = "linear", stiffness = 1000, restitution = 0.3 }}, tangential = {{ law = "linear", stiffness_ratio = 0.3, friction = 0.5 }} }}
        output = {{ interval = 0.5, pictures = false }}
        [[walls]]
        name = "floor"
        shape = "plane"
        normal = [0, 0, 1]
        point = [0, 0, 0]
        material = "m"
        [[particles]]
        name = "ball"
        material = "m"
        radius = 5e-3
        {ball}
        {more}
        "#
    )
}

/// The time at which it ended, and why it was not at rest then.
fn ended(text: &str) -> (f64, Option<String>) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder.path())
        .args(["a.toml", "--quiet"])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let text = fs::read_to_string(folder.path().join("a/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    // A run that was to come to rest and did not is a warning, and the only one here.
    let warnings = summary["warnings"].as_array().unwrap();
    assert!(warnings.len() <= 1, "{warnings:?}");
    let why = warnings.first().map(|warning| {
        let why = warning.as_str().unwrap().strip_prefix("not at rest: ");
        let why = why.and_then(|why| why.strip_suffix(", at the end of the run"));
        why.unwrap_or_else(|| panic!("{warning}")).to_owned()
    });
    (summary["time"].as_f64().unwrap(), why)
}

const ON_FLOOR: &str = "position = [0, 0, 5e-3]";

/// A ball that lies is at rest after 1,000 steps; whatever is still to happen to a wall is waited for.
#[test]
fn what_walls_will_do_is_waited_for() {
    let (alone, why) = ended(&scene(ON_FLOOR, ""));
    assert_eq!(why, None);
    // 1,000 steps of 2e-5 s, or a tenth of sqrt(d/g) = 3.2 ms; the ball sinks in by m g / k first.
    assert!((0.02..0.1).contains(&alone), "{alone}");

    let wall = |keys: &str| {
        format!(
            "[[walls]]\nname = \"other\"\nmaterial = \"m\"\nshape = \"disc\"\naxis = [0, 0, 1]\nradius = 0.02\n{keys}"
        )
    };
    let above = "origin = [0, 0, 0.05]";
    let motion = |kind: &str| format!("{above}\nmotion = [{{ {kind} }}]");
    for (keys, last) in [
        (format!("{above}\nfrom = 0.3"), 0.3),
        (format!("{above}\nuntil = 0.3"), 0.3),
        (
            motion(r#"kind = "translation", velocity = [0, 0, -0.1], from = 0.3, until = 0.5"#),
            0.5,
        ),
        (
            motion(
                r#"kind = "rotation", axis = [0, 0, 1], origin = [0, 0, 0], angular_velocity = 9, until = 0.4"#,
            ),
            0.4,
        ),
        (
            motion(
                r#"kind = "oscillation", amplitude = [0, 0, 0.01], frequency = 5, from = 0.2, until = 0.4"#,
            ),
            0.4,
        ),
        // Down to the ball at 0.1 m/s, which takes 0.4 s, and then at rest with it.
        (
            motion(r#"kind = "servo", axis = [0, 0, -1], force = 0.1, max_speed = 0.1"#),
            0.4,
        ),
    ] {
        let (time, why) = ended(&scene(ON_FLOOR, &wall(&keys)));
        assert_eq!(why, None, "{keys}");
        assert!((last..last + 0.35).contains(&time), "{keys}: {time}");
    }
    // The ball lies on a shelf that goes: it falls to the floor, and rests there.
    let shelf = wall("origin = [0, 0, 0.05]\nuntil = 0.3");
    let (time, why) = ended(&scene("position = [0, 0, 0.055]", &shelf));
    assert_eq!(why, None);
    // A fall of 5 cm takes 0.1 s.
    assert!((0.4..1.0).contains(&time), "{time}");
    // A blade that turns to the end.
    let blade = wall(&motion(
        r#"kind = "rotation", axis = [0, 0, 1], origin = [0, 0, 0], angular_velocity = 1"#,
    ));
    let (time, why) = ended(&scene(ON_FLOOR, &blade));
    assert_eq!(time, 2.0);
    assert!(why.is_some_and(|why| why.contains("wall `other` moves, at up to ")));
}

/// About the normal of its one contact nothing slows a grain down: it spins for ever, and moves nothing. One that spins across it is set in motion.
#[test]
fn spin_that_moves_nothing_is_no_motion() {
    // With space to roll: two sevenths of the spin's speed at the surface, 7 cm/s, for 2 s.
    let wide =
        |text: String| text.replace("[-0.05, -0.05, 0], max = [0.05,", "[-1, -1, 0], max = [1,");
    let spin = |axis: &str| wide(scene(&format!("{ON_FLOOR}\nangular_velocity = {axis}"), ""));
    let (time, why) = ended(&spin("[0, 0, 50]"));
    assert!(time < 0.1 && why.is_none(), "{time} {why:?}");
    let (time, why) = ended(&spin("[0, 50, 0]"));
    // It rolls to the end of time: nothing stops it.
    assert!(time == 2.0 && why.is_some(), "{time} {why:?}");
}

/// Without gravity the reference speed is the measure: two balls that keep a third of their speed at each meeting.
#[test]
fn without_gravity_rest_is_a_thousandth_of_the_reference_speed() {
    let second = "[[particles]]\nname = \"other\"\nmaterial = \"m\"\nradius = 5e-3\nposition = [0.02, 0, 0.05]\nvelocity = [-1, 0, 0]";
    let box_ = "[[walls]]\nname = \"box\"\nshape = \"box\"\nmaterial = \"m\"";
    let text = scene(
        "position = [-0.02, 0, 0.05]\nvelocity = [1, 0, 0]",
        &format!("{second}\n{box_}"),
    );
    let text = text
        .replace("gravity = [0, 0, -9.81]", "")
        .replace("end = 2.0", "end = 60.0");
    let (time, why) = ended(&text);
    // Back and forth over 4 cm at 1, 0.3, 0.09 ... m/s: six meetings to a thousandth, the last of 20 s or so.
    assert!((1.0..60.0).contains(&time), "{time}");
    assert_eq!(why, None);
}
