//! Stop and resume with real processes and signals: a run that was interrupted, however and however often, leaves the bytes of one
//! that was not.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::common::{errors as reported, facts, results, signal};

use mercury_engine::forces::Watch;
use mercury_engine::step::Engine;
use mercury_solver::output::chain::state_sum;
use mercury_solver::plan::{plan, read_scene};
use mercury_solver::run::checkpoint;
use rayon::prelude::*;

/// Kills in one run of this test; `MERCURY_KILLS` sets more.
const KILLS: usize = 120;

fn scenes_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

/// Every scene that runs as it stands takes part by itself, so that a new feature with an example cannot be forgotten.
fn scenes() -> Vec<PathBuf> {
    let mut files = Vec::new();
    for folder in ["", "clumps", "bench", "wear"] {
        let entries = fs::read_dir(scenes_folder().join(folder)).unwrap();
        files.extend(entries.map(|entry| entry.unwrap().path()));
    }
    files.retain(|path| {
        let name = path.to_string_lossy();
        name.ends_with(".toml") && !name.ends_with(".clump.toml") && !name.ends_with("keys.toml")
    });
    files.sort();
    assert!(files.len() > 15, "the example scenes are found");
    files
}

/// A scene cut short to a hundred thousand particle-steps or so, with everything written, and its frames and checkpoints at times
/// that are no multiples of each other.
struct Case {
    scene: PathBuf,
    settings: Vec<String>,
}

impl Case {
    fn new(scene: PathBuf) -> Self {
        let read = read_scene(&scene, &[]).unwrap();
        let planned = plan(&read).unwrap();
        let physics = planned.physics();
        let expected = physics.particles.len().max(500) as f64;
        let steps = (1.5e5 / expected).clamp(40.0, 1000.0);
        let end = (steps * physics.time_step).min(physics.steps as f64 * physics.time_step);
        let mut settings = vec![
            format!("time.end={end:?}"),
            format!("output.interval={:?}", end / 7.3),
            format!("output.rows_interval={:?}", end / 13.9),
            format!("output.restart_interval={:?}", end / 11.7),
            format!("output.link_interval={:?}", end / 13.1),
            "output.keep_checkpoints=4".to_owned(),
            "output.pictures=false".to_owned(),
            "output.vtk=true".to_owned(),
            format!("output.vtk_interval={:?}", end / 3.1),
            "output.fstat=true".to_owned(),
            format!("output.fstat_interval={:?}", end / 4.7),
        ];
        // Its sums go on, too; where they are not kept, forces and kicks are fused, which is to be seen as well.
        let mut walls = physics.walls.iter();
        let has_servos = walls.any(|wall| wall.motion.all_servos().next().is_some());
        if has_servos || !physics.insertions.is_empty() {
            settings.push("output.energy_budget=true".to_owned());
        }
        for table in 0..read.fields.len() {
            settings.push(format!("fields[{table}].from={:?}", end / 5.3));
            settings.push(format!("fields[{table}].interval={:?}", end / 9.1));
        }
        Self { scene, settings }
    }

    fn name(&self) -> String {
        self.scene
            .file_stem()
            .unwrap()
            .to_string_lossy()
            .into_owned()
    }

    fn command(&self, output: &Path, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mercury-solve"));
        command.arg(&self.scene).arg("--output").arg(output);
        for setting in &self.settings {
            command.arg("--set").arg(setting);
        }
        command.args(more).arg("--quiet").stderr(Stdio::piped());
        command
    }
}

/// A small generator of numbers for when to kill (Marsaglia 2003, xorshift64).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % limit.max(1)
    }
}

/// A run of this case that is interrupted so many times by KILL or TERM, at random, with one to three threads, against one that is not: the same
/// bytes. Returns how often it was killed and how often it was stopped.
fn interrupted(case: &Case, interruptions: usize, random: &mut Random) -> [usize; 2] {
    let [mut killed, mut stopped] = [0; 2];
    let place = tempfile::tempdir().unwrap();
    let (straight, resumed) = (place.path().join("straight"), place.path().join("resumed"));
    let begun = Instant::now();
    let run = |folder: &Path, more: &[&str]| case.command(folder, more).output().unwrap();
    let output = run(&straight, &["--threads", "1"]);
    assert!(
        output.status.success(),
        "{}: {}",
        case.name(),
        reported(&output)
    );
    let length = begun.elapsed();
    let mut left = interruptions;
    let mut tries = 0;
    while left > 0 && tries < 100 * interruptions {
        tries += 1;
        let threads = (1 + random.below(3)).to_string();
        let arguments = [
            "--resume",
            "--checkpoint-every",
            "0.01s",
            "--fixed-threads",
            "--threads",
            &threads,
        ];
        let mut child = case.command(&resumed, &arguments).spawn().unwrap();
        let wait = random.below(length.as_micros() as u64);
        std::thread::sleep(Duration::from_micros(wait));
        let kills_it = random.below(2) == 0;
        signal(&child, if kills_it { "KILL" } else { "TERM" });
        let status = child.wait().unwrap();
        match status.code() {
            // Before signals are caught it ends as any process.
            None => killed += 1,
            Some(75) => stopped += 1,
            // It had come to its end before; from now on there is nothing to interrupt.
            Some(0) => {
                let _ = fs::remove_dir_all(&resumed);
                continue;
            }
            Some(code) => panic!("{}: ended with {code}", case.name()),
        }
        left -= 1;
    }
    let output = run(&resumed, &["--resume", "--threads", "2", "--fixed-threads"]);
    assert!(
        output.status.success(),
        "{}: {}",
        case.name(),
        reported(&output)
    );
    let (one, other) = (
        results(&straight, &case.name()),
        results(&resumed, &case.name()),
    );
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&one), names(&other), "{}", case.name());
    for (name, bytes) in &one {
        assert!(*bytes == other[name], "{}: {name} differs", case.name());
    }
    assert_eq!(facts(&straight), facts(&resumed), "{}", case.name());
    [killed, stopped]
}

#[test]
fn interrupted_runs_of_all_scenes_end_with_the_same_bytes() {
    let kills = std::env::var("MERCURY_KILLS").map_or(KILLS, |text| text.parse().unwrap());
    let scenes = scenes();
    let count = scenes.len();
    // Several at a time, as each waits for its runs most of the time.
    let interruptions = scenes.into_par_iter().enumerate().map(|(number, scene)| {
        // They are shared out evenly.
        let own = kills * (number + 1) / count - kills * number / count;
        let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ number as u64);
        interrupted(&Case::new(scene), own, &mut random)
    });
    let [killed, stopped] = interruptions.reduce(|| [0; 2], |[a, b], [c, d]| [a + c, b + d]);
    assert!(
        killed + stopped >= kills,
        "{killed} killed, {stopped} stopped"
    );
    assert!(
        killed > kills / 4 && stopped > kills / 8,
        "{killed} killed, {stopped} stopped"
    );
}

/// A ball around which a sheet bends, so that it has several contacts with it that join, with springs of friction and rolling.
const BENT: &str = r#"
time = { end = 0.012, step = 1e-5 }
domain = { min = [-0.2, -0.2, -0.2], max = [0.2, 0.2, 0.4] }
output = { interval = 1e-3, fstat = true, pictures = false }
[materials.m]
density = 1000.0
normal = { law = "linear", stiffness = 500.0, restitution = 0.6 }
tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
rolling = { law = "luding", friction = 0.1, dissipation = 1e-3 }
torsion = { law = "luding", friction = 0.1, dissipation = 1e-3 }
[[particles]]
material = "m"
radius = 0.1
position = [0.001, 0.002, 0.101]
velocity = [0.1, 0.0, -2.0]
angular_velocity = [3.0, 1.0, 0.0]
[[membranes]]
name = "sheet"
shape = "disc"
axis = [0.0, 0.0, 1.0]
origin = [0.0, 0.0, 0.0]
radius = 0.05
edge = 0.01
material = "m"
thickness = 3e-4
youngs_modulus = 1e5
"#;

#[test]
fn contacts_that_join_go_on_with_the_same_bytes() {
    let place = tempfile::tempdir().unwrap();
    let scene = place.path().join("bent.toml");
    fs::write(&scene, BENT).unwrap();
    let planned = Arc::new(plan(&read_scene(&scene, &[]).unwrap()).unwrap());
    let mut engine = Engine::new(Arc::clone(&planned), 1).unwrap();
    let watch = Watch {
        records: true,
        audit: None,
    };
    let mut most = 0;
    for _ in 0..planned.physics().steps / 50 {
        engine.steps_at_once(50, Some(watch)).unwrap();
        most = most.max(engine.observation().records.len());
    }
    assert!(most > 3, "{most} contacts at most");
    let case = Case {
        scene,
        settings: Vec::new(),
    };
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let [killed, stopped] = interrupted(&case, 12, &mut random);
    assert!(killed > 0 && stopped > 0, "{killed}, {stopped}");
}

/// Spheres that fall on each other; by default for seconds.
const SCENE: &str = r#"
title = "Heap"
gravity = [0, 0, -9.81]
time = { end = 1000.0, step = 2e-5 }
domain = { min = [0, 0, 0], max = [0.05, 0.05, 0.05] }
output = { interval = 0.002, fstat = true, pictures = false }
[materials.glass]
density = 2500.0
normal = { law = "linear", stiffness = 1000.0, restitution = 0.8 }
tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
[[walls]]
name = "box"
shape = "box"
material = "glass"
[[particles]]
material = "glass"
radius = 2e-3
lattice = { min = [0.003, 0.003, 0.003], max = [0.047, 0.047, 0.02], spacing = 0.0045, jitter = 1e-4 }
"#;

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("heap.toml"), SCENE).unwrap();
        Self(place)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mercury-solve"));
        command.current_dir(self.0.path()).args(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn solve(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// A run of hours, as soon as it has written some frames.
    fn running(&self, arguments: &[&str]) -> Child {
        let written = |place: &Self| fs::metadata(place.file("heap.ene")).map_or(0, |e| e.len());
        let before = written(self);
        let mut child = self.command(arguments).spawn().unwrap();
        self.wait(&mut child, |place| written(place) > before + 1000);
        child
    }

    fn wait(&self, child: &mut Child, is_reached: impl Fn(&Self) -> bool) {
        while !is_reached(self) {
            assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join("heap").join(name)
    }

    fn times(&self) -> Vec<String> {
        let text = fs::read_to_string(self.file("heap.ene")).unwrap();
        let time = |line: &str| line.split_whitespace().next().unwrap().to_owned();
        text.lines().skip(1).map(time).collect()
    }

    fn newest(&self) -> checkpoint::Checkpoint {
        let folder = self.0.path().join("heap");
        checkpoint::newest(&folder, "heap").unwrap().unwrap().0
    }
}

#[test]
fn a_stop_keeps_the_step_and_writes_no_frame_of_its_own() {
    let place = Place::new();
    for (name, resume) in [("INT", None), ("TERM", Some("--resume"))] {
        let arguments: Vec<&str> = ["heap.toml", "--quiet"].into_iter().chain(resume).collect();
        let child = place.running(&arguments);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(75), "{}", reported(&output));
        assert!(
            reported(&output).contains("stopped at t = "),
            "{}",
            reported(&output)
        );
        assert!(
            reported(&output).contains("--resume"),
            "{}",
            reported(&output)
        );
        let checkpoint = place.newest();
        let times = place.times();
        for time in &times {
            let steps: f64 = time.parse::<f64>().unwrap() / 2e-3;
            assert!(
                (steps - steps.round()).abs() < 1e-6,
                "a frame at t = {time} s"
            );
        }
        let last: f64 = times.last().unwrap().parse().unwrap();
        assert!(last <= checkpoint.head.time() + 1e-12);
        assert!(checkpoint.head.time() < last + 2e-3, "all frames are there");
        assert!(!place.file(".lock").exists());
    }
}

#[test]
fn a_second_request_ends_at_once_with_the_checkpoint_whole() {
    let place = Place::new();
    let mut child = place.running(&["heap.toml", "--quiet", "--checkpoint-every", "0.01s"]);
    place.wait(&mut child, |place| place.file("heap.1.restart").exists());
    signal(&child, "INT");
    signal(&child, "INT");
    let code = child.wait().unwrap().code();
    // The first may have been enough already.
    assert!(matches!(code, Some(130 | 75)), "{code:?}");
    assert!(!place.file(".lock").exists(), "it would puzzle people");
    assert!(place.newest().head.step > 0);
}

#[test]
fn checkpoints_on_request_while_the_run_goes_on() {
    let place = Place::new();
    let mut child = place.running(&["heap.toml", "--quiet"]);
    assert!(!place.file("heap.0.restart").exists());
    signal(&child, "USR1");
    place.wait(&mut child, |place| place.file("heap.0.restart").exists());
    let first = place.newest().head.step;
    signal(&child, "USR1");
    place.wait(&mut child, |place| place.file("heap.1.restart").exists());
    assert!(place.newest().head.step > first);
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_stop_file_and_a_time_limit_stop_a_run() {
    let place = Place::new();
    let child = place.running(&["heap.toml"]);
    fs::write(place.file("STOP"), "").unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(75), "{}", reported(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("stopped by the file STOP at t = "), "{said}");
    assert!(
        !place.file("STOP").exists(),
        "it would stop the next run, too"
    );

    let before = place.newest().head.step;
    let output = place.solve(&["heap.toml", "--resume", "--time-limit", "0.2s"]);
    assert_eq!(output.status.code(), Some(75), "{}", reported(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("stopped by the time limit at t = "), "{said}");
    assert!(said.contains("resumed    from t = "), "{said}");
    assert!(place.newest().head.step > before);
}

/// Files of a run of the heap whose scene was changed on the way, which its chain says; of the newest checkpoint the state.
fn results_but_chain(folder: &Path) -> (BTreeMap<String, Vec<u8>>, String) {
    let mut files = results(folder, "heap");
    files.retain(|name, _| name != "heap.chain.jsonl" && name != "checkpoint");
    let (newest, _) = checkpoint::newest(folder, "heap").unwrap().unwrap();
    let sections = newest.sections();
    let sections = sections
        .iter()
        .map(|(name, content)| (*name, [&content[..]]));
    (files, state_sum(sections))
}

#[test]
fn a_finished_run_can_be_made_longer() {
    let place = Place::new();
    // The short end is no multiple of the interval: its last frame is not one of the long run.
    let settings = |end: &'static str| ["heap.toml", "--quiet", "--set", end];
    let short = place.solve(&settings("time.end=0.0071"));
    assert_eq!(short.status.code(), Some(0), "{}", reported(&short));
    assert_eq!(place.times().last().unwrap().as_str(), "0.0071");
    // There is nothing to do as long as it is not.
    let again = place.solve(&["heap.toml", "--resume", "--set", "time.end=0.0071"]);
    assert_eq!(again.status.code(), Some(0), "{}", reported(&again));
    let said = String::from_utf8(again.stdout).unwrap();
    assert!(
        said.contains("has come to its end at t = 0.0071 s already"),
        "{said}"
    );
    let mut longer = settings("time.end=0.0133").to_vec();
    longer.push("--resume");
    let longer = place.solve(&longer);
    assert_eq!(longer.status.code(), Some(0), "{}", reported(&longer));

    let straight = Place::new();
    let output = straight.solve(&settings("time.end=0.0133"));
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let (one, other) = (straight.0.path().join("heap"), place.0.path().join("heap"));
    assert!(results_but_chain(&one) == results_but_chain(&other));
    let facts_but_link = |folder: &Path| {
        let mut facts = facts(folder);
        facts["link"].take();
        facts
    };
    assert_eq!(facts_but_link(&one), facts_but_link(&other));
    // Not shorter than it is.
    let output = place.solve(&["heap.toml", "--resume", "--set", "time.end=0.01"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        reported(&output).contains("the checkpoint is at t = 0.0133 s, behind time.end = 0.01 s"),
        "{}",
        reported(&output)
    );
}

#[test]
fn another_scene_is_refused_by_what_differs() {
    let place = Place::new();
    let output = place.solve(&["heap.toml", "--quiet", "--set", "time.end=0.004"]);
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let before = fs::read(place.file("heap.data")).unwrap();
    let refused = |more: &[&str]| {
        let all = ["heap.toml", "--resume", "--set", "time.end=0.01"];
        let output = place.solve(&[&all, more].concat());
        assert_eq!(output.status.code(), Some(2), "{}", reported(&output));
        reported(&output)
    };
    let reported = refused(&[
        "--set",
        "materials.glass.tangential.friction=0.3",
        "--set",
        "seed=7",
    ]);
    for line in [
        "the checkpoint is of another scene:",
        "  materials.glass.tangential.friction: 0.5 then, 0.3 now",
        "  seed: absent then, 7 now",
        "help: only title, time.end, time.until, results, sprays[].max_droplets, output.interval",
    ] {
        assert!(reported.contains(line), "no {line:?} in {reported}");
    }
    let reported = refused(&["--set", "walls.box.until=0.5"]);
    assert!(
        reported.contains("walls[0].until: absent then, 0.5 now"),
        "{reported}"
    );
    assert_eq!(
        fs::read(place.file("heap.data")).unwrap(),
        before,
        "nothing is touched"
    );
}

#[test]
fn a_damaged_checkpoint_is_named_and_the_older_one_used() {
    let place = Place::new();
    let settings = [
        "heap.toml",
        "--set",
        "time.end=0.01",
        "--set",
        "output.restart_interval=0.003",
    ];
    let output = place.solve(&settings);
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let newest = place.newest();
    let whole = results(&place.0.path().join("heap"), "heap");
    let mut bytes = fs::read(&newest.path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&newest.path, &bytes).unwrap();
    let resume = [&settings[..], &["--resume"]].concat();
    let output = place.solve(&resume);
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let name = newest
        .path
        .file_name()
        .unwrap()
        .to_string_lossy()
        .into_owned();
    let said = reported(&output);
    assert!(
        said.contains("not used: ") && said.contains(&name),
        "{said}"
    );
    assert!(said.contains("is damaged"), "{said}");
    assert!(
        said.contains("resumed from ") && said.contains("t = 0.009 s"),
        "{said}"
    );
    assert!(results(&place.0.path().join("heap"), "heap") == whole);
    // Both: no guess.
    for number in [0, 1] {
        fs::write(place.file(&format!("heap.{number}.restart")), "half").unwrap();
    }
    let output = place.solve(&resume);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        reported(&output).contains("no checkpoint can be used"),
        "{}",
        reported(&output)
    );
}

#[test]
fn what_is_in_a_checkpoint_is_reported() {
    let place = Place::new();
    let output = place.solve(&["heap.toml", "--quiet", "--set", "time.end=0.004"]);
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let output = place.solve(&["--inspect", "heap/heap.0.restart"]);
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    for part in [
        "a checkpoint of `Heap`",
        "all checksums right",
        "0.004 s, step 200 of 2e-5 s",
        "particles     400 in 400 rows",
        "materials.glass.density = 2500",
    ] {
        assert!(said.contains(part), "no {part:?} in {said}");
    }
    let output = place.solve(&["--inspect", "heap.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        reported(&output).contains("this is not the state of a run"),
        "{}",
        reported(&output)
    );
    let output = place.solve(&["--inspect", "nothing"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        reported(&output).contains("cannot be read"),
        "{}",
        reported(&output)
    );
}

#[test]
fn resume_without_a_checkpoint_begins_anew() {
    let place = Place::new();
    let end = ["heap.toml", "--resume", "--set", "time.end=0.004"];
    let output = place.solve(&end);
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let whole = results(&place.0.path().join("heap"), "heap");
    fs::remove_dir_all(place.0.path().join("heap")).unwrap();

    let mut child = place.running(&["heap.toml", "--quiet"]);
    child.kill().unwrap();
    child.wait().unwrap();
    let output = place.solve(&end);
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    assert!(reported(&output).contains("no checkpoint yet: from the beginning"));
    assert!(results(&place.0.path().join("heap"), "heap") == whole);
    // A whole run is not thrown away because a checkpoint is missing.
    fs::remove_file(place.newest().path).unwrap();
    let output = place.solve(&end);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        reported(&output).contains("no checkpoint of it"),
        "{}",
        reported(&output)
    );
}

#[test]
fn a_full_disk_ends_the_run_in_words_with_the_last_checkpoint_whole() {
    let place = Place::new();
    // No file may become larger than this; what is written beyond fails, as on a full disk.
    let limited = "trap '' XFSZ; ulimit -f 600; exec \"$0\" heap.toml --quiet --set output.restart_interval=0.004";
    let output = Command::new("sh")
        .current_dir(place.0.path())
        .args(["-c", limited, env!("CARGO_BIN_EXE_mercury-solve")])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", reported(&output));
    assert!(
        reported(&output).contains("the run failed: heap/heap.")
            && reported(&output).contains("cannot be written"),
        "{}",
        reported(&output)
    );
    let at = place.newest().head.step;
    assert!(at > 0);
    // With free space again it goes on, and nothing was lost.
    let time = format!("time.end={:?}", (at + 100) as f64 * 2e-5);
    let interval = "output.restart_interval=0.004";
    let settings = ["heap.toml", "--quiet", "--set", interval, "--set", &time];
    let output = place.solve(&[&settings[..], &["--resume"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let straight = Place::new();
    let output = straight.solve(&settings);
    assert_eq!(output.status.code(), Some(0), "{}", reported(&output));
    let (one, other) = (straight.0.path().join("heap"), place.0.path().join("heap"));
    assert!(results_but_chain(&one) == results_but_chain(&other));
}

#[test]
fn a_folder_that_vanishes_ends_the_run_in_words() {
    let place = Place::new();
    let child = place.running(&["heap.toml", "--quiet"]);
    fs::remove_dir_all(place.0.path().join("heap")).unwrap();
    signal(&child, "USR1");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", reported(&output));
    assert!(
        reported(&output).contains("the run failed: heap/heap.0.restart"),
        "{}",
        reported(&output)
    );
}

/// The scene comes through a pipe, so that the run has begun and knows nothing yet: a request at this time is carried out as soon
/// as possible.
#[cfg(target_os = "linux")]
#[test]
fn requests_in_the_first_instants_are_heard() {
    let place = Place::new();
    let path = place.0.path().join("heap.toml");
    let text = fs::read_to_string(&path).unwrap();
    for (name, code) in [("TERM", 75), ("USR1", 0)] {
        fs::remove_file(&path).unwrap();
        let made = Command::new("mkfifo").arg(&path).status().unwrap();
        assert!(made.success());
        let mut command = Command::new(env!("CARGO_BIN_EXE_mercury-solve"));
        let mut child = (command.current_dir(place.0.path()))
            .args(["heap.toml", "--quiet", "--force", "--set", "time.end=0.004"])
            .spawn()
            .unwrap();
        // Its mask of caught signals, of which SIGUSR1 is number 10 and SIGTERM number 15.
        let catches = || {
            let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
            let mask = status.split("SigCgt:").nth(1).unwrap();
            let mask = mask.split_whitespace().next().unwrap();
            let mask = u64::from_str_radix(mask, 16).unwrap();
            mask & (1 << 14) != 0 && mask & (1 << 9) != 0
        };
        let begun = Instant::now();
        while !catches() && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        signal(&child, name);
        if name == "TERM" {
            // Nothing is there that could be kept, and the pipe need not be read to the end.
            assert_eq!(child.wait().unwrap().code(), Some(code));
            assert!(!place.0.path().join("heap").exists());
            continue;
        }
        // From now on a reader that opens it finds a file.
        let mut pipe = fs::OpenOptions::new().write(true).open(&path).unwrap();
        fs::remove_file(&path).unwrap();
        fs::write(&path, &text).unwrap();
        pipe.write_all(text.as_bytes()).unwrap();
        drop(pipe);
        let status = child.wait().unwrap();
        assert_eq!(status.code(), Some(code), "{name}");
        assert!(place.newest().head.step > 1);
    }
}
