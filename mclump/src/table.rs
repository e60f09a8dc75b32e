//! Results as a table of text and as JSON.

use std::fmt::Write as _;

use glam::DVec3;
use mercury_common::formats::clump::{ClumpFile, Remark};
use serde_json::{Map, Value, json};

use crate::clump::Built;
use crate::inertia::comparison::{Route, Row};

/// All routes side by side; `chosen` is marked.
#[must_use]
pub fn routes(rows: &[Row], chosen: Option<Route>, density: f64) -> String {
    let mut out = format!(
        "  {:<9}{:>15}  {:>42}  {:>42}  {:>8}\n",
        "route", "mass (kg)", "centre of mass (m)", "principal moments (kg m2)", "error"
    );
    for row in rows {
        let mark = if Some(row.route) == chosen { '*' } else { ' ' };
        let properties = &row.properties;
        let error = row
            .relative_error
            .map_or("exact".to_owned(), |error| format!("{error:.0e}"));
        let _ = writeln!(
            out,
            "{mark} {:<9}{:>15}  {:>42}  {:>42}  {:>8}",
            row.route,
            number(density * properties.volume),
            vector(properties.centre),
            vector(density * properties.principal_moments()),
            error
        );
    }
    if chosen.is_some() {
        out.push_str("  * taken for the clump; centres in the frame of the input\n");
    }
    out
}

/// Seven digits.
pub(crate) fn number(x: f64) -> String {
    if x != 0.0 && !(1e-3..1e6).contains(&x.abs()) {
        format!("{x:.6e}")
    } else {
        let rounded: f64 = format!("{x:.6e}").parse().unwrap_or(x);
        format!("{rounded}")
    }
}

fn vector(v: DVec3) -> String {
    format!("{} {} {}", number(v.x), number(v.y), number(v.z))
}

/// The clump and what was found on the way, for scripts.
#[must_use]
pub fn json(built: &Built, files: &[std::path::PathBuf]) -> Value {
    let mut value = clump_json(&built.file);
    if let Some(object) = value.as_object_mut() {
        object.insert("warnings".into(), json!(built.warnings));
        let files: Vec<String> = files
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        object.insert("files".into(), json!(files));
    }
    value
}

fn clump_json(clump: &ClumpFile) -> Value {
    let rows = [0, 1, 2].map(|row| clump.rotation.row(row).to_array());
    let pebbles: Vec<Value> = clump
        .pebbles
        .iter()
        .map(|p| json!({ "position": p.position.to_array(), "radius": p.radius }))
        .collect();
    json!({
        "name": clump.name,
        "density": clump.density,
        "mass": clump.mass,
        "volume": clump.volume,
        "centre_of_mass": clump.centre_of_mass.to_array(),
        "principal_moments": clump.principal_moments.to_array(),
        "rotation": rows,
        "inertia_method": clump.inertia_method,
        "pebbles": pebbles,
        "source": remarks(&clump.source),
        "checks": remarks(&clump.checks),
    })
}

/// Routes without a clump, for scripts.
#[must_use]
pub fn routes_json(rows: &[Row], density: f64) -> Value {
    let entries = rows.iter().map(|row| {
        let p = &row.properties;
        let value = json!({
            "mass": density * p.volume,
            "centre_of_mass": p.centre.to_array(),
            "principal_moments": (density * p.principal_moments()).to_array(),
            "relative_error": row.relative_error,
        });
        (row.route.name().to_owned(), value)
    });
    Value::Object(entries.collect::<Map<_, _>>())
}

fn remarks(entries: &[(String, Remark)]) -> Value {
    let entries = entries
        .iter()
        .map(|(key, value)| (key.clone(), remark(value)));
    Value::Object(entries.collect::<Map<_, _>>())
}

fn remark(value: &Remark) -> Value {
    match value {
        Remark::Number(x) => json!(x),
        Remark::Whole(x) => json!(x),
        Remark::Flag(x) => json!(x),
        Remark::Text(x) => json!(x),
        Remark::List(x) => Value::Array(x.iter().map(remark).collect()),
        Remark::Table(x) => remarks(x),
    }
}
