//! Limits of the guard: a state beyond them stops the run, or is counted, and is named.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A ball of 1 mm that flies at the wall of a closed box; `law`, its speed (m/s) and the time step (s) decide what happens.
fn box_with_ball(law: &str, speed: f64, step: f64) -> String {
    format!(
        r#"
        time = {{ end = {end}, step = {step} }}
        domain = {{ min = [0, 0, 0], max = [0.02, 0.02, 0.02] }}
        materials.m = {{ density = 2500.0, normal = {{ {law}, restitution = 0.9 }} }}
        output = {{ interval = {end}, pictures = false }}
        [[walls]]
        name = "box"
        shape = "box"
        material = "m"
        [[particles]]
        name = "ball"
        material = "m"
        radius = 1e-3
        position = [0.01, 0.011, 0.01]
        velocity = [{speed}, 0.3, 0]
        "#,
        end = 400.0 * step,
    )
}

const HERTZ: &str = r#"law = "hertz", youngs_modulus = 1e7, poisson_ratio = 0.3"#;
const LINEAR: &str = r#"law = "linear", stiffness = 100"#;

fn solve(folder: &Path, text: &str, arguments: &[&str]) -> Output {
    fs::write(folder.join("a.toml"), text).unwrap();
    Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder)
        .args(["a.toml", "--quiet", "--force", "--output", "out"])
        .args(arguments)
        .output()
        .unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Times of the frames, s: the first column of the energies, which are written with each.
fn times(folder: &Path) -> Vec<f64> {
    let text = fs::read_to_string(folder.join("out/a.ene")).unwrap();
    let first = |line: &str| line.split_whitespace().next()?.parse().ok();
    text.lines().filter_map(first).collect()
}

/// The cases of the report: the ball was gone from a closed box, with exit code 0 and no warning.
#[test]
fn no_particle_leaves_a_closed_box_in_silence() {
    for (law, speed, step, what) in [
        (HERTZ, 60.0, 1e-6, "overlaps wall `box.+x` by 0.5"),
        (LINEAR, 30.0, 5e-6, "overlaps wall `box.+x` by 0.5"),
        // Three radii in a step.
        (LINEAR, 60.0, 5e-5, "moves by 3.0"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let text = box_with_ball(law, speed, step);
        let output = solve(folder.path(), &text, &[]);
        let said = errors(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(what), "{what}: {said}");
        for part in ["particle 0", "step ", "t = ", " m/s", "help: "] {
            assert!(said.contains(part), "{part}: {said}");
        }
        // Round-off of the time is not shown: at most 12 digits.
        let time = said.split("t = ").nth(1).unwrap();
        let digits = time.split(" s").next().unwrap();
        assert!(digits.len() <= 14, "{said}");
        // The step of the message, or the one after, is there to be looked at.
        let step_of = said.split("step ").nth(1).unwrap();
        let number: f64 = step_of.split_whitespace().next().unwrap().parse().unwrap();
        let last = *times(folder.path()).last().unwrap();
        let steps = last / step - number;
        assert!((-0.01..1.01).contains(&steps), "{last} {said}");
        assert!(!folder.path().join("out/summary.json").exists());
        let log = fs::read_to_string(folder.path().join("out/run.log")).unwrap();
        assert!(log.contains(what), "{log}");

        // Counted, not repeated.
        let output = solve(folder.path(), &text, &["--set", "guard.policy=\"warn\""]);
        assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
        let summary = fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
        let lines: Vec<&str> = summary
            .lines()
            .filter(|l| l.contains("guard: in "))
            .collect();
        assert!((1..=3).contains(&lines.len()), "{summary}");
        assert!(
            lines.iter().all(|line| line.contains("at step ")),
            "{summary}"
        );

        let output = solve(folder.path(), &text, &["--set", "guard.policy=\"off\""]);
        assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
        let summary = fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
        assert!(!summary.contains("guard:"), "{summary}");
    }
}

/// v/omega = 0.4 of the radius, and a way of 0.03 radii in a step: what keeps the limits is left alone, to the same bytes.
#[test]
fn what_keeps_the_limits_is_left_alone() {
    // omega = sqrt(k/m) = sqrt(100 N/m / 10.5 mg) = 3090/s.
    let text = box_with_ball(LINEAR, 0.4 * 3.09, 2e-5);
    let folder = tempfile::tempdir().unwrap();
    let mut last = Vec::new();
    for policy in ["strict", "warn", "off"] {
        let set = format!("guard.policy=\"{policy}\"");
        let output = solve(folder.path(), &text, &["--set", &set]);
        assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
        let state = fs::read(folder.path().join("out/a.data")).unwrap();
        assert!(last.is_empty() || last == state);
        last = state;
        let summary = fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
        assert!(!summary.contains("guard:"), "{summary}");
    }
    // With a lower limit it is too much.
    for limit in ["guard.overlap=0.3", "guard.way=0.02"] {
        let output = solve(folder.path(), &text, &["--set", limit]);
        assert_eq!(output.status.code(), Some(1), "{limit}");
        assert!(errors(&output).contains(limit.replace('=', " = ").as_str()));
    }
}

/// Limits are parts of a particle's own radius, of a pair of the smaller one: beside a large neighbour they are what they are
/// without it. And of the cases beyond them the worst is reported, not the last.
#[test]
fn limits_are_parts_of_the_smallest_radius_and_the_worst_is_reported() {
    let neighbour = |position: &str| {
        format!(
            r#"
        [[particles]]
        name = "neighbour"
        material = "m"
        radius = 4e-3
        fixed = true
        position = {position}
    "#
        )
    };
    let beside = neighbour("[0.005, 0.005, 0.005]");
    let folder = tempfile::tempdir().unwrap();
    // 0.8 radii in a step, a third of the mean radius.
    let text = box_with_ball(LINEAR, 8.0, 1e-4) + &beside;
    let output = solve(folder.path(), &text, &["--set", "guard.way=0.6"]);
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert!(
        errors(&output).contains("moves by 0.8"),
        "{}",
        errors(&output)
    );

    // At a wall and at a sphere in the way the ball's overlap is v/omega = 0.4 of its radius, less what the dashpot takes: a contact of
    // exp(-zeta (pi/2 - zeta)) of that with zeta = 0.033 for e = 0.9, 0.38.
    let ahead = neighbour("[0.016, 0.011, 0.01]");
    for (around, what) in [(beside, "of its radius"), (ahead, "of the smaller radius")] {
        let text = box_with_ball(LINEAR, 0.4 * 3.09, 2e-5) + &around;
        let warn = [
            "--set",
            "guard.policy=\"warn\"",
            "--set",
            "guard.overlap=0.3",
        ];
        let output = solve(folder.path(), &text, &warn);
        assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
        let summary = fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
        let line = summary.lines().find(|line| line.contains(what));
        let line = line.unwrap_or_else(|| panic!("{what}: {summary}"));
        assert!(line.contains("the worst of them"), "{line}");
        let part = line.split(" by ").nth(1).unwrap();
        let part: f64 = part.split_whitespace().next().unwrap().parse().unwrap();
        assert!((0.37..0.4).contains(&part), "{line}");
    }
}

/// Two balls that meet too fast are both named; a ball behind a wall is, too, and bounces there.
#[test]
fn partners_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let second = r#"
        [[particles]]
        name = "other"
        material = "m"
        radius = 2e-3
        position = [0.016, 0.011, 0.01]
    "#;
    let text = box_with_ball(LINEAR, 30.0, 5e-6) + second;
    let said = errors(&solve(folder.path(), &text, &[]));
    let names = said.contains("particle 0") && said.contains("particle 1");
    assert!(names && said.contains("of the smaller radius"), "{said}");

    let behind = r#"
        [[walls]]
        name = "shell"
        shape = "sphere"
        origin = [0.016, 0.01, 0.01]
        radius = 2e-3
        side = "inside"
        material = "m"
    "#;
    let text = box_with_ball(LINEAR, 1.0, 2e-5) + behind;
    let output = solve(folder.path(), &text, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    let summary = fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
    assert!(summary.contains("starts behind wall `shell`"), "{summary}");
    assert!(summary.contains("touches wall `shell`"), "{summary}");
}

#[test]
fn wrong_keys_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text = box_with_ball(LINEAR, 1.0, 2e-5);
    for (set, what) in [
        ("guard.policy=\"loud\"", "loud"),
        ("guard.overlap=0", "must be > 0"),
        ("guard.way=-1", "must be > 0"),
        ("guard.ways=1", "ways"),
    ] {
        let output = solve(folder.path(), &text, &["--set", set]);
        assert_eq!(output.status.code(), Some(2), "{set}: {}", errors(&output));
        assert!(errors(&output).contains(what), "{}", errors(&output));
    }
}

/// A ball of 1 mm at rest where a wall passes by; the time step is 1e-5 s, so that 100 m/s are a radius in a step.
fn ball_and_wall(wall: &str, motion: &str, position: [f64; 3], steps: u32) -> String {
    let end = f64::from(steps) * 1e-5;
    format!(
        r#"
        time = {{ end = {end}, step = 1e-5 }}
        domain = {{ min = [-0.2, -0.2, -0.2], max = [0.2, 0.2, 0.2] }}
        materials.m = {{ density = 2500.0, normal = {{ {LINEAR}, restitution = 0.9 }} }}
        output = {{ interval = {end}, pictures = false }}
        [[walls]]
        name = "wall"
        material = "m"
        {wall}
        motion = [{{ {motion} }}]
        [[particles]]
        name = "ball"
        material = "m"
        radius = 1e-3
        position = {position:?}
        "#
    )
}

/// A sheet of two triangles normal to x, acting on both sides.
const SHEET: &str = "solid sheet\n\
    facet normal 1 0 0\nouter loop\nvertex 0 -0.05 -0.05\nvertex 0 0.05 -0.05\nvertex 0 0.05 0.05\nendloop\nendfacet\n\
    facet normal 1 0 0\nouter loop\nvertex 0 -0.05 -0.05\nvertex 0 0.05 0.05\nvertex 0 -0.05 0.05\nendloop\nendfacet\n\
    endsolid sheet\n";

/// The wall comes from the left at any speed from a tenth of a radius in a step to ten: no wall passes a resting ball in silence, from wherever its last step
/// begins. (Beyond 1.2 radii a step those with two sides did, beyond 1.8 those with one.)
#[test]
fn no_wall_is_too_fast_to_be_noticed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("sheet.stl"), SHEET).unwrap();
    for wall in [
        r#"shape = "disc", origin = [0, 0, 0], axis = [1, 0, 0], radius = 0.05"#,
        r#"shape = "mesh", file = "sheet.stl""#,
        r#"shape = "sphere", origin = [-0.02, 0, 0], radius = 0.02, side = "outside""#,
        r#"shape = "cylinder", origin = [0.01, 0, 0], axis = [0, 0, 1], radius = 0.01, along = [-0.05, 0.05], side = "inside""#,
    ] {
        let lines = split_keys(wall);
        for part in [0.2, 0.6, 1.3, 1.9, 2.5, 4.0, 10.0] {
            for place in 0..3 {
                let x = 0.0105 + 0.0004 * f64::from(place);
                let speed = part * 100.0;
                let motion = format!(r#"kind = "translation", velocity = [{speed}, 0, 0]"#);
                let steps = (15.0 / part) as u32 + 4;
                let text = ball_and_wall(&lines, &motion, [x, 1e-4, 2e-4], steps);
                let output = solve(folder.path(), &text, &[]);
                let said = errors(&output);
                assert_eq!(output.status.code(), Some(1), "{wall} {part} {x}: {said}");
                let is_named = ["overlaps wall `wall`", "has gone through wall `wall`"];
                assert!(is_named.iter().any(|name| said.contains(name)), "{said}");
            }
        }
    }
}

/// Keys of an inline table, a line each.
fn split_keys(keys: &str) -> String {
    let mut depth = 0;
    let split = |c: char| {
        depth += match c {
            '[' => 1,
            ']' => -1,
            _ => 0,
        };
        if c == ',' && depth == 0 { '\n' } else { c }
    };
    keys.chars().map(split).collect()
}

/// Surfaces that move fast in themselves, that leave, or that pass beside a ball: nothing comes near, and there is no message.
#[test]
fn fast_walls_that_do_not_come_near_are_no_alarm() {
    let folder = tempfile::tempdir().unwrap();
    let turning = |speed: f64| {
        format!(
            r#"kind = "rotation", origin = [0, 0, 0], axis = [0, 0, 1], angular_velocity = {speed}"#
        )
    };
    let away = r#"kind = "translation", velocity = [300, 0, 0]"#.to_owned();
    let drum = r#"shape = "cylinder", origin = [0, 0, 0], axis = [0, 0, 1], radius = 0.1"#;
    let disc = |origin: &str, axis: &str| {
        format!(r#"shape = "disc", origin = {origin}, axis = {axis}, radius = 0.05"#)
    };
    for (wall, motion, position) in [
        // 20 radii a step along the surface, which the ball nearly touches, inside and outside.
        (
            format!(r#"{drum}, side = "inside""#),
            turning(2e4),
            [0.0989, 0.0, 0.0],
        ),
        (
            format!(r#"{drum}, side = "outside""#),
            turning(2e4),
            [0.1011, 0.0, 0.0],
        ),
        (disc("[0, 0, 0]", "[1, 0, 0]"), away, [-0.0011, 0.0, 0.0]),
        // A blade whose tip, 10 radii a step fast, passes a tenth of a radius before the ball.
        (
            disc("[0.05, 0, 0]", "[0, 1, 0]"),
            turning(1e4),
            [0.0, 0.1011, 0.0],
        ),
    ] {
        let text = ball_and_wall(&split_keys(&wall), &motion, position, 200);
        let output = solve(folder.path(), &text, &[]);
        let said = errors(&output);
        assert_eq!(output.status.code(), Some(0), "{wall}: {said}");
        let summary = fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
        assert!(!summary.contains("guard:"), "{wall}: {summary}");
    }
}

/// However large `guard.overlap` and `guard.way` are: a centre that goes through a wall is named, also where the wall stands at the face of the domain, so that it is removed
/// in that very step.
#[test]
fn passing_through_is_named_whatever_the_limits() {
    let folder = tempfile::tempdir().unwrap();
    let disc = split_keys(r#"shape = "disc", origin = [0, 0, 0], axis = [1, 0, 0], radius = 0.05"#);
    let slow = r#"kind = "translation", velocity = [20, 0, 0]"#;
    let by_disc = ball_and_wall(&disc, slow, [0.0112, 1e-4, 2e-4], 70);
    // 0.2 radii in a step, and 3.
    for (text, wall) in [
        (by_disc, "wall"),
        (box_with_ball(LINEAR, 40.0, 5e-6), "box.+x"),
        (box_with_ball(LINEAR, 60.0, 5e-5), "box.+x"),
    ] {
        for overlap in ["guard.overlap=1", "guard.overlap=5"] {
            let limits = ["--set", overlap, "--set", "guard.way=9"];
            let output = solve(folder.path(), &text, &limits);
            let said = errors(&output);
            assert_eq!(output.status.code(), Some(1), "{wall}: {said}");
            let reported = format!("has gone through wall `{wall}`: its centre is ");
            assert!(
                said.contains(&reported) && said.contains("approaching"),
                "{said}"
            );

            let warn = [&limits[..], &["--set", "guard.policy=\"warn\""]].concat();
            let output = solve(folder.path(), &text, &warn);
            assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
            let summary = fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
            assert!(summary.contains(&reported), "{summary}");
        }
    }
}

/// A rod of three spheres parallel to the wall at the face of the domain, pressed through it at 0.2 radii a step: all of it is beyond, and leaves, in one step.
#[test]
fn a_body_that_leaves_through_a_wall_is_named() {
    let folder = tempfile::tempdir().unwrap();
    // Three touching spheres of 1 mm: m = 3 (4/3 pi r^3) rho, I = m r^2 (0.4, 0.4 + 8/3, 0.4 + 8/3).
    let mass = 3.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-9 * 2500.0;
    let [along, across] = [0.4, 0.4 + 8.0 / 3.0].map(|factor| factor * mass * 1e-6);
    let clump = format!(
        r#"
        name = "rod"
        density = 2500.0
        mass = {mass}
        volume = {volume}
        centre_of_mass = [0.0, 0.0, 0.0]
        principal_moments = [{along}, {across}, {across}]
        rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        inertia_method = "pebbles"
        pebbles = [
            {{ position = [-2e-3, 0.0, 0.0], radius = 1e-3 }},
            {{ position = [0.0, 0.0, 0.0], radius = 1e-3 }},
            {{ position = [2e-3, 0.0, 0.0], radius = 1e-3 }},
        ]
        "#,
        volume = mass / 2500.0,
    );
    fs::write(folder.path().join("rod.clump.toml"), clump).unwrap();
    let ball = box_with_ball(LINEAR, 0.0, 5e-6);
    let (head, _) = ball.split_once("[[particles]]").unwrap();
    let text = format!(
        "{head}
        [clumps.rod]
        file = \"rod.clump.toml\"
        material = \"m\"
        [[particles]]
        name = \"rod\"
        clump = \"rod\"
        position = [0.01, 0.015, 0.01]
        velocity = [0, 40, 0]
        "
    );
    let output = solve(folder.path(), &text, &["--set", "guard.overlap=5"]);
    let said = errors(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("has gone through wall `box.+y`: its centre is "),
        "{said}"
    );
}

/// Too many droplets end the run with exit code 1; frame and checkpoint of that state are written, and with a larger limit the run goes on
/// from there to the same end as one that had it from the start.
#[test]
fn too_many_droplets_leave_a_state_from_which_the_run_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // A droplet of 5.2e-13 m^3 each 5.2e-7 s, and some 10 ms of flight: 1000 are exceeded at 0.53 ms.
    let text = r#"
        time = { end = 1e-3, step = 1e-5 }
        domain = { min = [-0.03, -0.03, -0.03], max = [0.03, 0.03, 0.03] }
        output = { interval = 5e-4, pictures = false, ene = true }
        [materials.m]
        density = 2500.0
        normal = { law = "linear", stiffness = 1000.0, restitution = 0.9 }
        [[particles]]
        material = "m"
        radius = 3e-3
        position = [0, 0, 0]
        fixed = true
        [[sprays]]
        name = "n"
        position = [0, 0, 0.02]
        axis = [0, 0, -1]
        pattern = { kind = "full-cone", half_angle_degrees = 5.0 }
        flow_rate = 1e-6
        speed = 1.0
        droplets = { kind = "monodisperse", diameter = 1e-4 }
        liquid_density = 1000.0
        max_droplets = 1000
    "#;
    let output = solve(path, text, &[]);
    assert_eq!(output.status.code(), Some(1));
    let said = errors(&output);
    assert!(
        said.contains("spray \"n\": more than 1000 droplets") && said.contains("--resume"),
        "{said}"
    );
    // 1001 droplets of 5.236e-13 m^3 at 1e-6 m^3/s: 5.241e-4 s, in the step that ends at 5.3e-4 s; it is shown after one more.
    let last = *times(path).last().unwrap();
    assert!((last - 5.4e-4).abs() < 1e-12, "{last}");
    assert!(path.join("out/a.0.restart").exists() || path.join("out/a.1.restart").exists());
    let liquid = || {
        let text = fs::read_to_string(path.join("out/a.liquid.csv")).unwrap();
        text.lines().last().unwrap().to_owned()
    };
    let more = "sprays.n.max_droplets=100000";
    let resumed = Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(path)
        .args([
            "a.toml", "--quiet", "--resume", "--output", "out", "--set", more,
        ])
        .output()
        .unwrap();
    assert_eq!(resumed.status.code(), Some(0), "{}", errors(&resumed));
    let parts = liquid();
    assert_eq!(solve(path, text, &["--set", more]).status.code(), Some(0));
    assert_eq!(parts, liquid());
    assert!(
        parts.starts_with("1e-3,") || parts.starts_with("0.001,"),
        "{parts}"
    );
}
