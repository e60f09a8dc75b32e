//! Rules that make the content of a clump file a rigid body.

use std::collections::HashSet;
use std::fmt;

use glam::{DMat3, DVec3};

use super::{ClumpFile, Remark};
use crate::readable::significant;

/// Mass and density times volume may differ by this fraction: enough for rounded numbers, too little for a wrong unit.
const MASS_TOLERANCE: f64 = 1e-3;
/// Largest deviation of the rotation's columns from unit length and right angles.
const ROTATION_TOLERANCE: f64 = 1e-6;
/// Relative excess of the largest moment over the sum of the others that counts as round-off of a flat body.
const TRIANGLE_TOLERANCE: f64 = 1e-9;

/// A value that cannot belong to a rigid body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClumpProblem {
    /// The key as the file has it, for example `pebbles[3].radius`.
    pub key: String,
    /// Description of the problem.
    pub message: String,
}

impl fmt::Display for ClumpProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.key, self.message)
    }
}

impl std::error::Error for ClumpProblem {}

pub(super) fn problems(clump: &ClumpFile) -> Vec<ClumpProblem> {
    let mut found = Found(Vec::new());
    if clump.name.trim().is_empty() {
        found.add("name", "must not be empty");
    } else if clump.name.chars().any(char::is_control) {
        found.add(
            "name",
            "must not hold line breaks or other control characters",
        );
    }
    let scalars = [
        ("density", clump.density),
        ("mass", clump.mass),
        ("volume", clump.volume),
    ];
    for (key, value) in scalars {
        found.positive(key, value);
    }
    let expected = clump.density * clump.volume;
    if found.0.iter().all(|problem| problem.key == "name")
        && (clump.mass - expected).abs() > MASS_TOLERANCE * expected
    {
        let message = format!(
            "must be density times volume, {expected} kg, got {}",
            clump.mass
        );
        found.add("mass", message);
    }
    found.finite("centre_of_mass", clump.centre_of_mass);
    moments(&mut found, clump.principal_moments);
    rotation(&mut found, clump.rotation);
    if clump.pebbles.is_empty() {
        found.add("pebbles", "at least one is needed");
    }
    for (index, pebble) in clump.pebbles.iter().enumerate() {
        if !pebble.position.is_finite() {
            found.finite(&format!("pebbles[{index}].position"), pebble.position);
        }
        if !(pebble.radius > 0.0 && pebble.radius.is_finite()) {
            found.positive(&format!("pebbles[{index}].radius"), pebble.radius);
        }
    }
    if let Some(surface) = &clump.surface {
        if surface.trim().is_empty() {
            found.add("surface", "must not be empty");
        } else if surface.chars().any(char::is_control) {
            let message = "must not hold line breaks or other control characters";
            found.add("surface", message);
        }
    }
    for (section, remarks) in [("source", &clump.source), ("checks", &clump.checks)] {
        table(&mut found, section, remarks);
    }
    found.0
}

struct Found(Vec<ClumpProblem>);

impl Found {
    fn add(&mut self, key: &str, message: impl Into<String>) {
        self.0.push(ClumpProblem {
            key: key.to_owned(),
            message: message.into(),
        });
    }

    fn positive(&mut self, key: &str, value: f64) {
        if !value.is_finite() {
            self.add(key, format!("must be finite, got {value}"));
        } else if value <= 0.0 {
            self.add(key, format!("must be > 0, got {}", significant(value, 9)));
        }
    }

    fn finite(&mut self, key: &str, value: DVec3) {
        if !value.is_finite() {
            self.add(key, format!("must be finite, got {value}"));
        }
    }
}

fn moments(found: &mut Found, moments: DVec3) {
    let key = "principal_moments";
    let [a, b, c] = moments.to_array();
    if !moments.is_finite() {
        found.finite(key, moments);
    } else if moments.min_element() <= 0.0 {
        found.add(
            key,
            format!(
                "must all be > 0, got {}",
                significant(moments.min_element(), 9)
            ),
        );
    } else if a > b || b > c {
        found.add(key, "must be ascending");
    } else if c > (a + b) * (1.0 + TRIANGLE_TOLERANCE) {
        let message = format!(
            "the largest, {c}, must not exceed the sum of the others, {}: no body has such moments",
            a + b
        );
        found.add(key, message);
    }
}

fn rotation(found: &mut Found, rotation: DMat3) {
    let key = "rotation";
    let excess = rotation.transpose() * rotation - DMat3::IDENTITY;
    let deviation = excess
        .to_cols_array()
        .into_iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    if !rotation.is_finite() {
        found.add(key, "must be finite");
    } else if deviation > ROTATION_TOLERANCE {
        let message = format!(
            "its columns must be perpendicular and of length 1, they are off by {deviation:.1e}"
        );
        found.add(key, message);
    } else if rotation.determinant() < 0.0 {
        found.add(
            key,
            "must be right-handed (determinant +1): this one is a reflection",
        );
    }
}

fn table(found: &mut Found, path: &str, remarks: &[(String, Remark)]) {
    let mut known = HashSet::new();
    for (key, value) in remarks {
        let path = format!("{path}.{key}");
        if !known.insert(key) {
            found.add(&path, "is given twice");
        }
        remark(found, &path, value);
    }
}

fn remark(found: &mut Found, path: &str, value: &Remark) {
    match value {
        Remark::Number(value) if !value.is_finite() => {
            found.add(path, format!("must be finite, got {value}"));
        }
        Remark::List(values) => {
            for (index, value) in values.iter().enumerate() {
                remark(found, &format!("{path}[{index}]"), value);
            }
        }
        Remark::Table(remarks) => table(found, path, remarks),
        _ => {}
    }
}
