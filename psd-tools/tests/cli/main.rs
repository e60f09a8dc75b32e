//! The program as its users meet it: what it prints, which files it writes, how it ends.

mod runs;
mod samples;
mod tables_and_laws;
mod usage;

use std::path::Path;
use std::process::{Command, Output};

use glam::DVec3;
use mercury_common::frames::{
    BodyFrame, BodyWriter, ClumpKind, FLAG_FIXED, FramesHeader, ParticleColumns, ParticleFrame,
    ParticleWriter,
};
use mercury_common::scene::parse_psd;
use mercury_common::sizes::SizeDistribution;
use mercury_psd::draw::{Method, draw};
use serde_json::Value;

/// Arguments, as typed on one line.
fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn psd(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-psd"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Standard output of a run that succeeds.
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = psd(folder, arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        text(&output.stderr)
    );
    text(&output.stdout)
}

/// Message of a run whose input is wrong.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = psd(folder, arguments);
    assert_eq!(
        output.status.code(),
        Some(2),
        "{arguments:?}: {}",
        text(&output.stdout)
    );
    text(&output.stderr)
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&done(folder, arguments)).expect("JSON")
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let grain = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/grain.psd.csv");
    std::fs::copy(grain, folder.path().join("grain.psd.csv")).expect("copied");
    folder
}

const LOGNORMAL: &str =
    "{ kind = \"lognormal\", median_diameter = 3e-3, sigma = 0.2, weighting = \"volume\" }";
