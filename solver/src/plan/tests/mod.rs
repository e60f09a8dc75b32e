//! Tests of the plan, by subject.

mod checks;
mod laws;
mod membranes;
mod meshes;
mod mixing;
mod reports;
mod settled;
mod shared;
mod time_step;

use std::path::Path;

use crate::plan::parse_scene;
use mercury_common::scene::{Files, SceneErrors};

use super::{Parameter, Plan, Value, plan};

/// Time, domain and output of a small scene; what a test is about follows.
const HEAD: &str = "[time]\nend = 1.0\nstep = \"auto\"\n\
    [domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n\
    [output]\ninterval = 0.1\n";

/// A linear material named `ball`: 1 kg at R = 0.5 m, a collision takes 0.02 s and has restitution 0.7.
const BALL: &str = "[materials.ball]\ndensity = 1.909859317102744\n\
    normal = { law = \"linear\", stiffness = 12496.02677090382, dissipation = 17.83374719693662 }\n";

/// The plan of a scene text, with `--set` arguments.
fn planned_with(text: &str, overrides: &[&str]) -> Result<Plan, SceneErrors> {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    let scene = parse_scene(Path::new("test.toml"), text, &overrides, Files::Unchecked)
        .unwrap_or_else(|errors| panic!("{errors}"));
    plan(&scene)
}

/// The plan of [`HEAD`] and `body`.
fn planned(body: &str) -> Plan {
    planned_with(&format!("{HEAD}{body}"), &[]).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Errors of the plan of [`HEAD`] and `body`: key, message and help, without the excerpt.
fn complaints(body: &str) -> Vec<String> {
    complaints_with(body, &[])
}

fn complaints_with(body: &str, overrides: &[&str]) -> Vec<String> {
    let errors = planned_with(&format!("{HEAD}{body}"), overrides).expect_err("a wrong scene");
    let words = |error: &mercury_common::scene::SceneError| {
        let help = error.help.as_ref().map(|help| format!(" | {help}"));
        format!(
            "{}: {}{}",
            error.path(),
            error.message,
            help.unwrap_or_default()
        )
    };
    errors.0.iter().map(words).collect()
}

/// An entry of `[[particles]]`.
fn particle(material: &str, radius: f64, position: [f64; 3], more: &str) -> String {
    format!(
        "[[particles]]\nmaterial = \"{material}\"\nradius = {radius:?}\nposition = {position:?}\n{more}\n"
    )
}

/// Two spheres of a material that do not touch.
fn two(material: &str, radius: f64) -> String {
    particle(material, radius, [-0.49, 0.0, 0.0], "")
        + &particle(material, radius, [0.52, 0.0, 0.0], "")
}

/// A parameter of the pair of materials `names`.
fn parameter<'a>(plan: &'a Plan, names: [&str; 2], key: &str) -> &'a Parameter {
    let pair = plan.notes().pairs().iter().find(|pair| pair.names == names);
    let pair = pair.unwrap_or_else(|| panic!("no pair {names:?}"));
    let found = pair
        .parameters
        .iter()
        .find(|parameter| parameter.name == key);
    found.unwrap_or_else(|| panic!("no {key} among {:?}", pair.parameters))
}

fn number(plan: &Plan, names: [&str; 2], key: &str) -> f64 {
    match parameter(plan, names, key).value {
        Value::Number(number) => number,
        Value::Word(word) => panic!("{key} is {word}"),
    }
}

fn origin(plan: &Plan, names: [&str; 2], key: &str) -> String {
    parameter(plan, names, key).origin.to_string()
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a / b - 1.0).abs() < tolerance, "{a} is not {b}");
}
