//! The number of the physics: it must rise when twelve frozen scenes give other chains.
//!
//! `MERCURY_BLESS=1 cargo test -p tests --test scenes physics` writes the sums anew, behind a raised number.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use mercury_solver::output::chain::{CHAIN, Chain, Content, Link, PHYSICS};
use mercury_solver::output::folder::Earlier;
use mercury_solver::plan::sha256;
use mercury_solver::run::{OpenRun, SceneInput};

/// Scenes in `tests/scenes/good`, which together have all kinds of physics that run for no more than some hundred steps.
const SCENES: [&str; 12] = [
    "bonds",
    "clumps",
    "discs",
    "fluxes",
    "insertion-mass-rate",
    "law-hertz",
    "law-plastic",
    "law-rolling-torsion",
    "mixed-laws",
    "periodic",
    "servo-and-region",
    "wall-mesh",
];

/// Sum of all links of a scene, without what names the program.
fn sum_of(name: &str) -> String {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/good");
    let place = tempfile::tempdir().expect("a folder for the run");
    let open = OpenRun {
        input: SceneInput::read(&scenes.join(format!("{name}.toml"))).expect("a scene"),
        folder: place.path().to_owned(),
        earlier: Earlier::Replace,
        results: Vec::new(),
        threads: Some(1),
        checkpoint_every: None,
        called: String::new(),
        pause: Arc::default(),
        pieces_observed: true,
    };
    let (mut run, claim) = open.begin().expect("a run");
    run.advance(f64::INFINITY, &mut |_| ()).expect("its steps");
    run.finish().expect("its end");
    drop(claim);
    let chain = Chain::read(&place.path().join(format!("{name}.{CHAIN}"))).expect("its chain");
    assert!(chain.end().is_some(), "{name}");
    let mut text = String::new();
    for line in &chain.lines {
        let link: &Link = match &line.content {
            Content::Link(link) => link,
            Content::End(end) => &end.link,
            _ => continue,
        };
        let _ = writeln!(text, "{} {} {:?}", link.step, link.state, link.outputs);
    }
    sha256(text.as_bytes())
}

#[test]
fn the_number_of_the_physics_rises_with_every_change_of_it() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/physics.txt");
    let mut now = format!("physics {PHYSICS}\n");
    for name in SCENES {
        let _ = writeln!(now, "{name} {}", sum_of(name));
    }
    if std::env::var_os("MERCURY_BLESS").is_some() {
        std::fs::write(&path, &now).expect("the sums can be written");
    }
    let frozen = std::fs::read_to_string(&path).unwrap_or_default();
    let both = frozen.lines().zip(now.lines());
    let changed = both.filter(|(then, now)| then != now);
    let changed: Vec<&str> = changed
        .filter_map(|(_, now)| now.split(' ').next())
        .collect();
    assert!(
        frozen == now,
        "the chains of these scenes have changed: {}.\n\
         States or outputs of runs that exist cannot be made again by this program, so it needs another number: raise PHYSICS in solver/src/output/chain/lines.rs, \
         say in CHANGELOG.md under Physics what has changed, and write the sums anew: MERCURY_BLESS=1 cargo test -p tests --test scenes physics.\n\
         If only a scene of this test was edited, write the sums anew and leave the number as it is.",
        changed.join(", ")
    );
}
