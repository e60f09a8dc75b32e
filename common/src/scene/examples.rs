//! A line to copy where a key is missing: with its unit, and with a value that makes sense for grains of some millimetres.

/// Section (the first word of the path), key, and the line.
const LINES: &[(&str, &str, &str)] = &[
    ("", "time", "time = { end = 1.0 }   # s"),
    (
        "",
        "domain",
        "domain = { min = [0, 0, 0], max = [0.1, 0.1, 0.2] }   # m",
    ),
    ("", "output", "output = { interval = 0.01 }   # s"),
    ("time", "end", "end = 1.0   # s"),
    ("domain", "min", "min = [0, 0, 0]   # m"),
    ("domain", "max", "max = [0.1, 0.1, 0.2]   # m"),
    ("output", "interval", "interval = 0.01   # s between frames"),
    ("materials", "density", "density = 2500.0   # kg/m3"),
    (
        "materials",
        "normal",
        "normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.8 }   # Pa",
    ),
    ("materials", "youngs_modulus", "youngs_modulus = 1e7   # Pa"),
    (
        "walls",
        "shape",
        "shape = \"box\"   # or plane, disc, cylinder, cone, sphere, revolution, mesh",
    ),
    ("walls", "point", "point = [0, 0, 0]   # m, on the plane"),
    (
        "walls",
        "normal",
        "normal = [0, 0, 1]   # towards the particles",
    ),
    ("walls", "origin", "origin = [0, 0, 0]   # m"),
    ("walls", "axis", "axis = [0, 0, 1]   # of any length"),
    ("walls", "radius", "radius = 0.05   # m"),
    (
        "walls",
        "file",
        "file = \"hopper.stl\"   # beside the scene",
    ),
    (
        "walls",
        "along",
        "along = [0.0, 0.1]   # m from the origin along the axis",
    ),
    ("walls", "velocity", "velocity = [0, 0, -0.01]   # m/s"),
    (
        "walls",
        "angular_velocity",
        "angular_velocity = 3.0   # rad/s",
    ),
    ("walls", "frequency", "frequency = 50.0   # 1/s"),
    (
        "walls",
        "force",
        "force = -10.0   # N of the wall on the particles, along the axis; or pressure in Pa",
    ),
    ("walls", "max_speed", "max_speed = 0.1   # m/s"),
    ("particles", "radius", "radius = 1e-3   # m"),
    (
        "particles",
        "position",
        "position = [0.05, 0.05, 0.01]   # m",
    ),
    ("particles", "spacing", "spacing = 2.1e-3   # m"),
    (
        "insertions",
        "region",
        "region = { shape = \"box\", min = [0, 0, 0.1], max = [0.1, 0.1, 0.2] }   # m",
    ),
    (
        "insertions",
        "psd",
        "psd = { kind = \"monodisperse\", diameter = 2e-3 }   # m",
    ),
    (
        "insertions",
        "total",
        "total = { number = 1000 }   # or mass in kg, volume in m3, full = true",
    ),
    ("insertions", "diameter", "diameter = 2e-3   # m"),
    (
        "deletions",
        "region",
        "region = { shape = \"box\", min = [0, 0, 0], max = [0.1, 0.1, 0.01] }   # m",
    ),
];

/// The line for a key that is missing in the table of this path (empty: the top level).
pub(super) fn example(table: &str, key: &str) -> Option<String> {
    let section = table.split(['.', '[']).next().unwrap_or_default();
    let found = LINES
        .iter()
        .find(|(of, name, _)| *of == section && *name == key);
    let line = found.map(|(_, _, line)| *line).or(match key {
        "material" => Some("material = \"glass\"   # the name of a table [materials.glass]"),
        _ => None,
    });
    line.map(|line| format!("for example: {line}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_states_its_key() {
        for (section, key, line) in LINES {
            let table: toml::Table = line
                .parse()
                .unwrap_or_else(|error| panic!("{line}: {error}"));
            assert_eq!(table.keys().collect::<Vec<_>>(), [key], "{section}: {line}");
        }
    }
}
