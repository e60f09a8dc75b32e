//! Starts from the last state of another run: grains, velocities and contacts go on; losses are reported.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;

use glam::DVec3;
use mercury_engine::state::Particles;
use mercury_engine::step::Engine;
use mercury_solver::plan::{Plan, plan, read_scene};
use mercury_solver::run::checkpoint;

/// Spheres and rods that have fallen onto a floor in a box that is periodic along x and y, with friction and rolling resistance;
/// gravity leans, so that the bed is held by its tangential springs. A plate is moved, a ball spins.
const BED: &str = r#"
title = "Bed"
gravity = [2.0, 0.0, -9.0]
[time]
end = END
step = 4e-5
[domain]
min = [0, 0, 0]
max = [0.05, 0.05, 0.2]
periodic = ["x", "y"]
[materials.grain]
density = 2000
normal = { law = "linear", stiffness = 1e3, restitution = 0.3 }
tangential = { law = "linear", stiffness_ratio = 0.3, friction = 0.6 }
rolling = { law = "luding", stiffness = 200, friction = 0.1, dissipation = 0 }
[clumps.rod]
file = "rod.clump.toml"
material = "grain"
[[walls]]
name = "floor"
shape = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
material = "grain"
[output]
interval = 0.1
pictures = false
"#;

const GRAINS: &str = r#"
[[particles]]
material = "grain"
radius = 0.004
lattice = { min = [0.005, 0.005, 0.005], max = [0.045, 0.045, 0.03], spacing = 0.0095, jitter = 0.0005 }
[[particles]]
clump = "rod"
lattice = { min = [0.0125, 0.0125, 0.06], max = [0.0375, 0.0375, 0.09], spacing = 0.025 }
orientation = "random"
scale = 0.008
[[particles]]
material = "grain"
radius = 0.003
position = [0.025, 0.025, 0.19]
prescribed = { velocity = [0.1, "free", 0.0], angular_velocity = ["free", 3.0, "free"] }
[[particles]]
material = "grain"
radius = 0.003
position = [0.025, 0.045, 0.19]
fixed = true
"#;

const FROM_RUN: &str = "[[particles]]\nrun = \"first\"\n";

fn folder_with(scenes: &[(&str, String)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let clump = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/clumps/rod.clump.toml");
    fs::copy(clump, folder.path().join("rod.clump.toml")).unwrap();
    for (name, text) in scenes {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn solve(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-solve"))
        .current_dir(folder)
        .args(arguments)
        .arg("--quiet")
        .output()
        .unwrap()
}

fn must_run(folder: &Path, arguments: &[&str]) {
    let output = solve(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
}

/// Message of a refused scene.
fn refusal(folder: &Path, scene: &str) -> String {
    let output = solve(folder, &[scene, "--output", "refused"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(!folder.join("refused").exists());
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn planned(folder: &Path, scene: &str) -> Plan {
    plan(&read_scene(&folder.join(scene), &[]).unwrap()).unwrap()
}

/// The state at the end of a run.
fn left_by(folder: &Path, run: &str, prefix: &str) -> checkpoint::Checkpoint {
    checkpoint::newest(&folder.join(run), prefix)
        .unwrap()
        .unwrap()
        .0
}

fn bed(end: f64, grains: &str) -> String {
    BED.replace("END", &format!("{end:?}")) + grains
}

/// Grains of a state, by ids: of bodies their centre, velocity and spin.
fn grains(particles: &Particles) -> Vec<[DVec3; 3]> {
    let rows = particles.rows_by_id().into_iter().map(|row| row as usize);
    let spheres = rows.filter(|&row| !particles.is_pebble(row)).map(|row| {
        let record = &particles.records[row];
        [record.position, record.velocity, record.angular_velocity]
    });
    let bodies = (particles.bodies().iter())
        .map(|body| [body.position, body.velocity, body.angular_velocity]);
    spheres.chain(bodies).collect()
}

/// How far a grain of two states is from itself, m, in a box that is periodic along x and y.
fn apart(one: &[DVec3; 3], other: &[DVec3; 3]) -> f64 {
    let mut way = one[0] - other[0];
    way.x -= (way.x / 0.05).round() * 0.05;
    way.y -= (way.y / 0.05).round() * 0.05;
    way.length()
}

/// The farthest that any is, m.
fn farthest(one: &Particles, other: &Particles) -> f64 {
    let (one, other) = (grains(one), grains(other));
    assert_eq!(one.len(), other.len());
    let pairs = one.iter().zip(&other);
    pairs.map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
}

#[test]
fn a_bed_goes_on_as_if_it_had_not_stopped() {
    let folder = folder_with(&[
        // Long enough for the bed to come to rest but for some micrometres a second.
        ("first.toml", bed(2.0, GRAINS)),
        ("second.toml", bed(0.04, FROM_RUN)),
        // Another name: its contacts are new ones.
        (
            "other.toml",
            bed(0.04, FROM_RUN).replace("\"floor\"", "\"ground\""),
        ),
    ]);
    let path = folder.path();
    must_run(path, &["first.toml"]);

    // The start is the state that was left, velocities of the same time as the positions.
    let mut left = Engine::new(Arc::new(planned(path, "first.toml")), 1).unwrap();
    while left.steps() < left.physics().steps {
        left.step(None).unwrap();
    }
    left.complete_step().unwrap();
    let start = Engine::new(Arc::new(planned(path, "second.toml")), 1).unwrap();
    let (then, now) = (grains(&left.particles), grains(&start.particles));
    assert_eq!(then.len(), now.len());
    for ([_, v, w], [_, v_now, w_now]) in then.iter().zip(&now) {
        // Spins of bodies are computed anew from their angular momentum: some roundings of products of three matrices.
        assert!((*v - *v_now).length() <= 1e-14 * v.length(), "{v} {v_now}");
        assert!((*w - *w_now).length() <= 1e-13 * w.length(), "{w} {w_now}");
    }
    assert!(farthest(&left.particles, &start.particles) < 1e-15);

    must_run(path, &["second.toml"]);
    must_run(path, &["other.toml", "--threads", "2", "--fixed-threads"]);
    for _ in 0..start.physics().steps {
        left.step(None).unwrap();
    }
    let whole = &left.particles;
    let second = left_by(path, "second", "second")
        .snapshot
        .particles()
        .unwrap();
    let other = left_by(path, "other", "other")
        .snapshot
        .particles()
        .unwrap();
    // Sums come in another order from the first list on, and the dashpots of the first forces see velocities of the time of the
    // positions, half a step later than those of a run that goes on: less than the way of the fastest in a step.
    let in_the_bed = now.iter().filter(|grain| grain[0].z < 0.15);
    let fastest = in_the_bed
        .map(|grain| grain[1].length())
        .fold(0.0, f64::max);
    assert!(fastest < 1e-3, "{fastest:e} m/s: the bed is not at rest");
    let (goes_on, anew) = (farthest(whole, &second), farthest(whole, &other));
    assert!(goes_on < fastest * 4e-5, "{goes_on:e} m");
    // The springs at the floor held the bed against g sin(slope): without them it slides by about the stretch of one,
    // m g / k of a column of grains, some 1e-5 m.
    assert!(anew > 1e-7, "{anew:e} m");
    let remarks = planned(path, "second.toml").notes().remarks().join("\n");
    assert!(
        remarks.contains("particles[0].run: 77 particles and 8 bodies of `Bed` at t = 2 s"),
        "{remarks}"
    );
    assert!(!remarks.contains("anew"), "{remarks}");
    let remarks = planned(path, "other.toml").notes().remarks().join("\n");
    assert!(remarks.contains("begin anew"), "{remarks}");
}

/// In the midst of a run velocities lack half a kick: of grains that fly, slide and turn.
#[test]
fn a_state_in_the_midst_of_a_run_is_completed() {
    let flying = "[[particles]]\nmaterial = \"grain\"\nradius = 0.004\nposition = [0.02, 0.02, 0.1]\n\
                  [[particles]]\nmaterial = \"grain\"\nradius = 0.004\nposition = [0.02, 0.02, 0.00399]\nvelocity = [0.5, 0, 0]\n\
                  [[particles]]\nclump = \"rod\"\nposition = [0.03, 0.03, 0.15]\nscale = 0.008\nangular_velocity = [3, 4, 5]\n";
    let folder = folder_with(&[
        ("first.toml", bed(0.015, flying)),
        ("second.toml", bed(0.04, FROM_RUN)),
    ]);
    let path = folder.path();
    must_run(
        path,
        &["first.toml", "--set", "output.restart_interval=0.01"],
    );
    // As if it had died before its end.
    fs::remove_file(left_by(path, "first", "first").path).unwrap();
    let steps = left_by(path, "first", "first").head.step;
    assert_eq!(steps, 250);
    let mut left = Engine::new(Arc::new(planned(path, "first.toml")), 1).unwrap();
    while left.steps() < steps {
        left.step(None).unwrap();
    }
    left.complete_step().unwrap();
    let start = Engine::new(Arc::new(planned(path, "second.toml")), 1).unwrap();
    let (then, now) = (grains(&left.particles), grains(&start.particles));
    assert_eq!((then.len(), now.len()), (3, 3));
    for ([_, v, w], [_, v_now, w_now]) in then.iter().zip(&now) {
        // Roundings of the same sums; half a kick is 1.8e-4 m/s.
        assert!((*v - *v_now).length() <= 1e-14 * v.length(), "{v} {v_now}");
        assert!((*w - *w_now).length() <= 1e-13 * w.length(), "{w} {w_now}");
    }
}

#[test]
fn grains_of_several_sources_stand_side_by_side() {
    let lid =
        "[[particles]]\nmaterial = \"grain\"\nradius = 0.005\nposition = [0.025, 0.025, 0.15]\n";
    let folder = folder_with(&[
        ("first.toml", bed(0.4, GRAINS)),
        ("second.toml", bed(0.02, &format!("{lid}{FROM_RUN}"))),
        ("alone.toml", bed(0.02, FROM_RUN)),
    ]);
    let path = folder.path();
    must_run(path, &["first.toml"]);
    must_run(path, &["second.toml"]);
    must_run(path, &["alone.toml"]);
    // A ball in the air disturbs no other particle, though it takes the first id and shifts all others.
    let with_ball = grains(
        &left_by(path, "second", "second")
            .snapshot
            .particles()
            .unwrap(),
    );
    let alone = grains(
        &left_by(path, "alone", "alone")
            .snapshot
            .particles()
            .unwrap(),
    );
    assert_eq!(with_ball.len(), alone.len() + 1);
    for (one, other) in with_ball[1..].iter().zip(&alone) {
        // 500 steps of a bed that still moves: round-off grows, by less than a factor of 1e5 so soon.
        let way = apart(one, other);
        assert!(way < 1e-9 * 0.004, "{way:e} m");
    }
}

#[test]
fn a_run_that_started_from_another_can_be_resumed() {
    let folder = folder_with(&[
        ("first.toml", bed(0.05, GRAINS)),
        ("second.toml", bed(0.02, FROM_RUN)),
    ]);
    let path = folder.path();
    must_run(path, &["first.toml"]);
    must_run(
        path,
        &["second.toml", "--output", "whole", "--set", "time.end=0.04"],
    );
    must_run(path, &["second.toml", "--output", "parts"]);
    must_run(
        path,
        &[
            "second.toml",
            "--output",
            "parts",
            "--set",
            "time.end=0.04",
            "--resume",
        ],
    );
    let [whole, parts] = ["whole", "parts"].map(|run| left_by(path, run, "second").snapshot);
    assert_eq!(whole, parts);
    // The run from which it started is another one now.
    must_run(path, &["first.toml", "--force", "--set", "time.end=0.06"]);
    let output = solve(path, &["second.toml", "--output", "parts", "--resume"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("state of particles[0].run: step 1250, checksum"),
        "{said}"
    );
}

#[test]
fn what_cannot_go_on_is_refused_by_name() {
    let folder = folder_with(&[
        ("first.toml", bed(0.01, GRAINS)),
        ("second.toml", bed(0.01, FROM_RUN)),
        (
            "flat.toml",
            bed(0.01, FROM_RUN).replace("[domain]", "[domain]\ndimensions = 2"),
        ),
        (
            "renamed.toml",
            bed(0.01, FROM_RUN)
                .replace("\"grain\"", "\"sand\"")
                .replace("materials.grain", "materials.sand"),
        ),
        (
            "no-rods.toml",
            bed(0.01, FROM_RUN).replace("clumps.rod", "clumps.pole"),
        ),
    ]);
    let path = folder.path();
    let said = refusal(path, "second.toml");
    assert!(said.contains("the folder does not exist"), "{said}");
    fs::create_dir(path.join("first")).unwrap();
    let said = refusal(path, "second.toml");
    assert!(said.contains("there is no checkpoint in"), "{said}");
    fs::remove_dir(path.join("first")).unwrap();

    must_run(path, &["first.toml"]);
    let said = refusal(path, "renamed.toml");
    assert!(
        said.contains("of the material `grain`") && said.contains("add [materials.grain]"),
        "{said}"
    );
    let said = refusal(path, "no-rods.toml");
    assert!(said.contains("of the clump `rod`"), "{said}");
    let said = refusal(path, "flat.toml");
    assert!(
        said.contains("that run has 3 dimensions, this scene 2"),
        "{said}"
    );
    let own = solve(path, &["second.toml", "--output", "first", "--force"]);
    assert_eq!(own.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&own.stderr).contains("its own folder"));
    assert!(path.join("first/summary.json").exists());

    // Pebbles as large, and elsewhere.
    let clump = fs::read_to_string(path.join("rod.clump.toml")).unwrap();
    let moved = clump.replace("{ position = [0.0, 0.0", "{ position = [0.1, 0.0");
    assert_ne!(moved, clump);
    fs::write(path.join("rod.clump.toml"), moved).unwrap();
    let said = refusal(path, "second.toml");
    fs::write(path.join("rod.clump.toml"), clump).unwrap();
    assert!(said.contains("other pebbles"), "{said}");

    // A damaged file is named; without another one there is no start.
    let file = left_by(path, "first", "first").path;
    let mut bytes = fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&file, bytes).unwrap();
    let said = refusal(path, "second.toml");
    assert!(
        said.contains("no checkpoint of that run can be used") && said.contains("is damaged"),
        "{said}"
    );
}

/// Two grains that touch, one at a floor with a film, a rod at the floor, and a dry grain with a film: after the first forces most of
/// their liquid is in bridges.
const WET: &str = r#"
[time]
end = 1e-4
step = 1e-5
[domain]
min = [-0.01, -0.01, 0]
max = [0.01, 0.01, 0.02]
[materials.wet]
density = 2500.0
normal = { law = "linear", stiffness = 500.0, restitution = 0.3 }
liquid = { law = "bagheri", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-11 }
[materials.dry]
density = 2500.0
normal = { law = "linear", stiffness = 500.0, restitution = 0.3 }
[clumps.rod]
file = "rod.clump.toml"
material = "wet"
[[walls]]
name = "floor"
shape = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
material = "wet"
film = { thickness = 1e-8, keeps = 0.25 }
[output]
interval = 1e-4
pictures = false
"#;

const WET_GRAINS: &str = r#"
[[particles]]
material = "wet"
radius = 1e-3
position = [-0.9999e-3, 0.0, 0.01]
film_volume = 5e-12
[[particles]]
material = "wet"
radius = 1e-3
position = [0.9999e-3, 0.0, 0.01]
film_volume = 4e-12
[[particles]]
material = "wet"
radius = 1e-3
position = [0.005, 0.005, 0.9999e-3]
film_volume = 3e-12
[[particles]]
material = "dry"
radius = 1e-3
position = [-0.005, -0.005, 0.01]
film_volume = 2e-12
[[particles]]
clump = "rod"
position = [0.0, -0.006, 1.9999e-3]
scale = 0.004
film_volume = 6e-12
"#;

/// The volume of liquid is kept, whatever ends the bridges: films take what they held, half of a pair's each, and at a wall all but
/// the share that its film keeps.
#[test]
fn liquid_of_bridges_that_do_not_go_on_goes_to_films() {
    for law in ["bagheri", "young-laplace"] {
        let wet = WET.replace("bagheri", law);
        let other_law = match law {
            "bagheri" => "young-laplace",
            _ => "willett-classical",
        };
        let next = |text: &str| format!("{text}{FROM_RUN}");
        let friction = "max_bridge_volume = 1e-11 }\ntangential = { law = \"linear\", stiffness_ratio = 0.3, friction = 0.3 }";
        let film = "film = { thickness = 1e-8, keeps = 0.25 }\n";
        let (wall, liquid) = (
            wet.find("[[walls]]").unwrap(),
            wet.find("liquid =").unwrap(),
        );
        let behind_wall = wet.find("[output]").unwrap();
        let behind_liquid = wet.find("[materials.dry]").unwrap();
        let no_wall = format!("{}{}", &wet[..wall], &wet[behind_wall..]);
        let dry = format!("{}{}", &wet[..liquid], &wet[behind_liquid..]);
        let nexts = [
            ("same", wet.clone(), 0),
            ("law", wet.replace(law, other_law), 5),
            (
                "friction",
                wet.replacen("max_bridge_volume = 1e-11 }", friction, 1),
                5,
            ),
            ("renamed", wet.replace("\"floor\"", "\"ground\""), 4),
            (
                "without-film",
                wet.replace("\"floor\"", "\"ground\"").replace(film, ""),
                4,
            ),
            ("no-wall", no_wall, 4),
            ("dry", dry, 5),
        ];
        let mut scenes = vec![("first.toml", format!("{wet}{WET_GRAINS}"))];
        let names: Vec<String> = nexts
            .iter()
            .map(|(name, ..)| format!("{name}.toml"))
            .collect();
        scenes.extend(
            names
                .iter()
                .zip(&nexts)
                .map(|(name, (_, text, _))| (&**name, next(text))),
        );
        let folder = folder_with(&scenes);
        let path = folder.path();
        must_run(path, &["first.toml"]);
        let mut first = Engine::new(Arc::new(planned(path, "first.toml")), 1).unwrap();
        while first.steps() < first.physics().steps {
            first.step(None).unwrap();
        }
        let then = first.liquid().unwrap();
        assert!(then.bridges > 0.5 * then.films, "{then:?}");
        let on_grains = then.films + then.bridges;

        for (name, _, ends) in nexts {
            // Tables of exact bridges take a while: one way to end is enough for them.
            if law == "young-laplace" && !["law", "no-wall"].contains(&name) {
                continue;
            }
            let plan = planned(path, &format!("{name}.toml"));
            let remarks = plan.notes().remarks().join("\n");
            let warnings = plan.notes().warnings().join("\n");
            // A bridge of a pair, one of the grain at the floor, and those of the rod's pebbles there.
            let said = match ends {
                0 => !remarks.contains("the liquid of "),
                ends => remarks.contains(&format!("; the liquid of {ends} bridges among these, ")),
            };
            assert!(said, "{law} {name}: {remarks}");
            // The film of the wall is that of the scene, which is no secret.
            assert!(
                warnings.contains("m3 on walls; walls begin with"),
                "{law} {name}: {warnings}"
            );
            let start = Engine::new(Arc::new(plan), 1).unwrap();
            let now = start.liquid().unwrap();
            let of_scene = if ["without-film", "no-wall"].contains(&name) {
                0.0
            } else {
                // The section of the domain, 0.02 m squared.
                1e-8 * 4e-4
            };
            let there = now.films + now.bridges + now.wall_films;
            // Some ten additions and halvings.
            let tolerance = 1e-14 * on_grains;
            let error = there - on_grains - of_scene;
            assert!(
                error.abs() < tolerance,
                "{law} {name}: {there:e} m3, not {:e}",
                on_grains + of_scene
            );
            if name == "dry" {
                // No bridge forms: each film shows what the bridges gave.
                assert_eq!(now.bridges, 0.0);
                let particles = &start.particles;
                let films = particles.columns.get("film_volume").unwrap();
                let of_id = |id: usize| films[particles.rows_by_id()[id] as usize];
                let close = |found: f64, expected: f64| {
                    assert!(
                        (found - expected).abs() < tolerance,
                        "{law}: {found:e}, not {expected:e}"
                    );
                };
                // The pair: all 9e-12 was in the bridge. The floor: 3e-12 and what the shadow of the grain takes of the film.
                close(of_id(0), 4.5e-12);
                close(of_id(1), 4.5e-12);
                let of_wall = std::f64::consts::PI * 1e-6 * 1e-8;
                close(of_id(2), 0.75 * (3e-12 + of_wall));
                close(of_id(3), 2e-12);
            }
        }
    }
}

/// A frame has no bridges, but what they hold: all of it is in the films of a run that starts there.
#[test]
fn liquid_of_a_frame_goes_on_in_films() {
    let longer = WET.replace("end = 1e-4", "end = 3e-4");
    let from_frame = "[[particles]]\nrun = \"first\"\nat = 1e-4\n";
    let folder = folder_with(&[
        ("first.toml", format!("{longer}{WET_GRAINS}")),
        ("next.toml", format!("{longer}{from_frame}")),
    ]);
    let path = folder.path();
    must_run(path, &["first.toml"]);
    let mut first = Engine::new(Arc::new(planned(path, "first.toml")), 1).unwrap();
    while first.steps() < 10 {
        first.step(None).unwrap();
    }
    let then = first.liquid().unwrap();
    assert!(then.bridges > 0.5 * then.films, "{then:?}");
    let on_grains = then.films + then.bridges;

    let plan = planned(path, "next.toml");
    assert!(
        plan.notes()
            .warnings()
            .iter()
            .all(|warning| !warning.contains("is left out"))
    );
    let start = Engine::new(Arc::new(plan), 1).unwrap();
    let now = start.liquid().unwrap();
    // The section of the domain, 0.02 m squared, with the film of the scene.
    let of_wall = 1e-8 * 4e-4;
    let there = now.films + now.bridges + now.wall_films - of_wall;
    // Some ten additions and halvings.
    assert!(
        (there - on_grains).abs() < 1e-14 * on_grains,
        "{there:e} m3, not {on_grains:e}"
    );
}

/// A ball flies freely past a plate that is pushed and a disc that turns; a second ball is in contact with the floor.
const MOVING: &str = r#"
[time]
end = END
step = 2e-5
[domain]
min = [0, 0, 0]
max = [0.1, 0.1, 0.1]
[materials.m]
density = 2000
normal = { law = "linear", stiffness = 1e3, restitution = 0.5 }
tangential = { law = "linear", stiffness_ratio = 0.3, friction = 0.5 }
[[walls]]
name = "floor"
shape = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
material = "m"
[[walls]]
name = "plate"
shape = "plane"
point = [0.09, 0, 0]
normal = [-1, 0, 0]
material = "m"
motion = [{ kind = "translation", velocity = [-0.1, 0, 0] }]
[[walls]]
name = "disc"
shape = "disc"
axis = [0, 0, 1]
origin = [0.05, 0.05, 0.08]
radius = 0.01
material = "m"
motion = [{ kind = "rotation", axis = [0, 1, 0], origin = [0.05, 0.05, 0.09], angular_velocity = 2.0 }]
[output]
interval = 0.02
pictures = false
"#;

/// At a time between two frames a run starts from the nearer one, with the walls where they were: v t and omega t after their start.
#[test]
fn a_time_in_between_gives_grains_and_walls_of_then() {
    use mercury_common::surfaces::Surface;
    let balls = "[[particles]]\nmaterial = \"m\"\nradius = 0.005\nposition = [0.02, 0.02, 0.04]\nvelocity = [0.1, 0.2, 0]\n\
        [[particles]]\nmaterial = \"m\"\nradius = 0.005\nposition = [0.02, 0.08, 0.004999]\nfixed = true\n";
    let scene = |end: f64, grains: &str| MOVING.replace("END", &format!("{end:?}")) + grains;
    let from = |at: &str| {
        scene(
            0.02,
            &format!("[[particles]]\nrun = \"first\"\nat = {at}\n"),
        )
    };
    let renamed = from("0.043").replace("\"plate\"", "\"other\"");
    let folder = folder_with(&[
        ("first.toml", scene(0.1, balls)),
        ("middle.toml", from("0.043")),
        ("end.toml", from("0.1")),
        ("beyond.toml", from("0.3")),
        ("renamed.toml", renamed),
        ("last.toml", scene(0.02, FROM_RUN)),
    ]);
    let path = folder.path();
    must_run(path, &["first.toml"]);

    // The nearest frame is that of 0.04 s.
    let time = 0.04;
    let plan = planned(path, "middle.toml");
    let ball = &plan.physics().particles[0];
    let place = DVec3::new(0.02 + 0.1 * time, 0.02 + 0.2 * time, 0.04);
    // 2,000 steps, each with a rounding of a number below 0.1.
    assert!(
        (ball.position - place).length() < 2000.0 * 2e-17,
        "{}",
        ball.position
    );
    assert_eq!(ball.velocity, DVec3::new(0.1, 0.2, 0.0));
    assert!(plan.physics().particles[1].fixed);
    let outline = |plan: &Plan, index: usize| plan.physics().walls[index].shape.outline();
    let Surface::Plane { point, normal } = outline(&plan, 1) else {
        panic!("a plane");
    };
    assert_eq!(normal, DVec3::NEG_X);
    // Any point of a plane may stand for it.
    assert!((point.x - (0.09 - 0.1 * time)).abs() < 1e-15, "{point}");
    let Surface::Turned {
        origin,
        direction,
        profile,
        ..
    } = outline(&plan, 2)
    else {
        panic!("a disc");
    };
    // A turn about y by omega t = 0.08, about a point 0.01 m above the disc.
    let (sin, cos) = (libm::sin(0.08), libm::cos(0.08));
    assert!((direction.cross(DVec3::new(sin, 0.0, cos))).length() < 1e-15);
    let centre = origin + direction * profile[0].y;
    let expected = DVec3::new(0.05 - 0.01 * sin, 0.05, 0.09 - 0.01 * cos);
    assert!((centre - expected).length() < 1e-15, "{centre} {expected}");
    let remarks = plan.notes().remarks().join("\n");
    assert!(remarks.contains("at t = 0.04 s"), "{remarks}");
    assert!(
        remarks.contains("a frame has no contacts, all begin anew"),
        "{remarks}"
    );
    assert!(
        remarks.contains("walls.plate: it stands where it was in that run"),
        "{remarks}"
    );
    assert!(!remarks.contains("walls.floor"), "{remarks}");
    // The motions go on from there.
    must_run(path, &["middle.toml"]);
    let rows = fs::read_to_string(path.join("middle/middle.walls.csv")).unwrap();
    assert!(rows.lines().count() > 3);

    // At the end there is a checkpoint as well as a frame: contacts go on.
    let end = planned(path, "end.toml");
    let remarks = end.notes().remarks().join("\n");
    assert!(remarks.contains("at t = 0.1 s"), "{remarks}");
    assert!(!remarks.contains("a frame has no contacts"), "{remarks}");
    let Surface::Plane { point, .. } = outline(&end, 1) else {
        panic!("a plane");
    };
    assert!((point.x - 0.08).abs() < 1e-15, "{point}");
    assert!(
        end.notes().warnings().is_empty(),
        "{:?}",
        end.notes().warnings()
    );

    // Behind the end the last state is taken, with a warning; another wall begins where the scene has it, and so do all without `at`.
    let beyond = planned(path, "beyond.toml").notes().warnings().join("\n");
    assert!(
        beyond.contains("that run has no state behind t = 0.1 s"),
        "{beyond}"
    );
    for scene in ["renamed.toml", "last.toml"] {
        let Surface::Plane { point, .. } = outline(&planned(path, scene), 1) else {
            panic!("a plane");
        };
        assert_eq!(point.x, 0.09, "{scene}");
    }

    // A run that is of another scene cannot go on, and the message gives advice.
    let output = solve(
        path,
        &["first.toml", "--resume", "--set", "materials.m.density=1"],
    );
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let help = "another scene starts from a state of this run with [[particles]] run = \"FOLDER\", at = TIME";
    assert!(said.contains(help), "{said}");
}

/// Bodies come from a frame as well as spheres; a prescribed motion is in no frame.
#[test]
fn a_frame_has_bodies_and_no_prescribed_motion() {
    let prescribed = GRAINS
        .rfind("[[particles]]\nmaterial = \"grain\"\nradius = 0.003\nposition = [0.025, 0.025")
        .unwrap();
    let at = "[[particles]]\nrun = \"first\"\nat = 0.02\n";
    let interval = |text: String| text.replace("interval = 0.1", "interval = 0.02");
    let folder = folder_with(&[
        ("first.toml", interval(bed(0.04, &GRAINS[..prescribed]))),
        ("second.toml", interval(bed(0.02, at))),
        ("whole.toml", interval(bed(0.02, &GRAINS[..prescribed]))),
    ]);
    let path = folder.path();
    must_run(path, &["first.toml"]);
    must_run(path, &["whole.toml"]);
    // The checkpoint of a run that ends at that time has the same grains.
    let start = Engine::new(Arc::new(planned(path, "second.toml")), 1).unwrap();
    let mut whole = Engine::new(Arc::new(planned(path, "whole.toml")), 1).unwrap();
    while whole.steps() < whole.physics().steps {
        whole.step(None).unwrap();
    }
    whole.complete_step().unwrap();
    assert!(!start.particles.bodies().is_empty());
    // Positions in frames have all their bits; those of pebbles follow from the body.
    assert!(farthest(&whole.particles, &start.particles) < 1e-15);
    for ([_, v, w], [_, v_now, w_now]) in grains(&whole.particles)
        .iter()
        .zip(&grains(&start.particles))
    {
        assert!((*v - *v_now).length() <= 1e-14 * v.length(), "{v} {v_now}");
        assert!((*w - *w_now).length() <= 1e-13 * w.length(), "{w} {w_now}");
    }

    fs::write(path.join("first.toml"), interval(bed(0.04, GRAINS))).unwrap();
    must_run(path, &["first.toml", "--force"]);
    let said = refusal(path, "second.toml");
    assert!(
        said.contains("have a prescribed motion, which frames do not hold"),
        "{said}"
    );
}
