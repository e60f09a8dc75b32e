//! Tests of the plan, by subject.

mod shared;

use std::path::Path;

use mercury_common::scene::{Files, SceneErrors, parse_scene};

use super::{Plan, plan};

/// The plan of a scene text that names no files.
fn planned(text: &str) -> Result<Plan, SceneErrors> {
    let scene = parse_scene(Path::new("test.toml"), text, &[], Files::Unchecked)
        .unwrap_or_else(|errors| panic!("{errors}"));
    plan(&scene)
}
