//! Writing the clump file.

use std::io::Write as _;

use glam::DVec3;

use super::{ClumpFile, ClumpProblem, Remark};

/// Appends a clump file. Numbers are the shortest decimals that read back exactly.
///
/// # Errors
/// The first of [`ClumpFile::problems`]: what does not read back is not written.
pub fn push_clump(clump: &ClumpFile, out: &mut Vec<u8>) -> Result<(), ClumpProblem> {
    if let Some(problem) = clump.problems().into_iter().next() {
        return Err(problem);
    }
    line(out, format_args!("name = {}", quoted(&clump.name)));
    scalar(out, "density", clump.density, "kg/m3");
    scalar(out, "mass", clump.mass, "kg");
    scalar(out, "volume", clump.volume, "m3");
    vector(
        out,
        "centre_of_mass",
        clump.centre_of_mass,
        "m, in the frame of the input",
    );
    vector(
        out,
        "principal_moments",
        clump.principal_moments,
        "kg m2, about the centre of mass",
    );
    line(
        out,
        format_args!("# columns: the principal axes in the frame of the input"),
    );
    let rows = [0, 1, 2].map(|row| numbers(clump.rotation.row(row)));
    line(out, format_args!("rotation = [{}]", rows.join(", ")));
    line(
        out,
        format_args!("inertia_method = {}", quoted(&clump.inertia_method)),
    );
    if let Some(surface) = &clump.surface {
        line(
            out,
            format_args!(
                "surface = {}  # m, in the frame of the principal axes",
                quoted(surface)
            ),
        );
    }
    line(
        out,
        format_args!("# m, in the frame of the principal axes with the centre of mass as origin"),
    );
    line(out, format_args!("pebbles = ["));
    for pebble in &clump.pebbles {
        line(
            out,
            format_args!(
                "  {{ position = {}, radius = {:?} }},",
                numbers(pebble.position),
                pebble.radius
            ),
        );
    }
    line(out, format_args!("]"));
    for (section, remarks) in [("source", &clump.source), ("checks", &clump.checks)] {
        if !remarks.is_empty() {
            line(out, format_args!("\n[{section}]"));
            for (key, value) in remarks {
                line(out, format_args!("{} = {}", bare(key), text(value)));
            }
        }
    }
    Ok(())
}

fn line(out: &mut Vec<u8>, content: std::fmt::Arguments<'_>) {
    // Writing to a vector cannot fail.
    let _ = writeln!(out, "{content}");
}

fn scalar(out: &mut Vec<u8>, key: &str, value: f64, unit: &str) {
    line(out, format_args!("{key} = {value:?}  # {unit}"));
}

fn vector(out: &mut Vec<u8>, key: &str, value: DVec3, unit: &str) {
    line(out, format_args!("{key} = {}  # {unit}", numbers(value)));
}

fn numbers(vector: DVec3) -> String {
    format!("[{:?}, {:?}, {:?}]", vector.x, vector.y, vector.z)
}

fn text(value: &Remark) -> String {
    match value {
        Remark::Number(value) => format!("{value:?}"),
        Remark::Whole(value) => value.to_string(),
        Remark::Flag(value) => value.to_string(),
        Remark::Text(value) => quoted(value),
        Remark::List(values) => {
            let values: Vec<String> = values.iter().map(text).collect();
            format!("[{}]", values.join(", "))
        }
        Remark::Table(entries) => {
            let entries: Vec<String> = entries
                .iter()
                .map(|(key, value)| format!("{} = {}", bare(key), text(value)))
                .collect();
            format!("{{ {} }}", entries.join(", "))
        }
    }
}

/// A key, quoted where TOML needs it.
fn bare(key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !key.is_empty() && key.chars().all(is_bare) {
        key.to_owned()
    } else {
        quoted(key)
    }
}

/// A basic string of TOML 1.0.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => out.push_str(&format!("\\u{:04X}", u32::from(c))),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
