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
    ("materials", "friction", "friction = 0.5"),
    ("materials", "poisson_ratio", "poisson_ratio = 0.3"),
    ("materials", "restitution", "restitution = 0.8"),
    ("materials", "stiffness", "stiffness = 1e4   # N/m"),
    (
        "materials",
        "loading_stiffness",
        "loading_stiffness = 1e4   # N/m",
    ),
    (
        "materials",
        "unloading_stiffness",
        "unloading_stiffness = 5e4   # N/m",
    ),
    (
        "materials",
        "cohesion_stiffness",
        "cohesion_stiffness = 1e3   # N/m; 0: no cohesion",
    ),
    (
        "materials",
        "penetration_depth",
        "penetration_depth = 0.05   # of 2 R*",
    ),
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
        "walls",
        "radii",
        "radii = [0.01, 0.05]   # m, at the two ends of `along`",
    ),
    (
        "walls",
        "profile",
        "profile = [[0.01, 0.0], [0.01, 0.02], [0.05, 0.1]]   # m, points [r, z]",
    ),
    ("walls", "amplitude", "amplitude = [0, 0, 1e-3]   # m"),
    (
        "walls",
        "kind",
        "kind = \"rotation\"   # or translation, oscillation, table, servo",
    ),
    ("walls", "degrees", "degrees = 90.0"),
    (
        "particles",
        "min",
        "min = [0.01, 0.01, 0.01]   # m, the first site",
    ),
    (
        "particles",
        "max",
        "max = [0.09, 0.09, 0.05]   # m, bound of the last site",
    ),
    (
        "contacts",
        "between",
        "between = [\"glass\", \"steel\"]   # names of two materials",
    ),
    (
        "insertions",
        "kind",
        "kind = \"monodisperse\"   # or uniform, normal, lognormal, rosin-rammler, ggs, phi-normal, mixture, classes, file",
    ),
    (
        "insertions",
        "share",
        "share = 0.5   # of the mass, unless share_by says otherwise",
    ),
    ("insertions", "min_diameter", "min_diameter = 1e-3   # m"),
    ("insertions", "max_diameter", "max_diameter = 3e-3   # m"),
    ("insertions", "mean_diameter", "mean_diameter = 2e-3   # m"),
    (
        "insertions",
        "standard_deviation",
        "standard_deviation = 2e-4   # m",
    ),
    (
        "insertions",
        "median_diameter",
        "median_diameter = 2e-3   # m",
    ),
    ("insertions", "sigma", "sigma = 0.2   # of ln d"),
    (
        "insertions",
        "sigma_phi",
        "sigma_phi = 0.3   # of -log2(d / 1 mm)",
    ),
    ("insertions", "d63", "d63 = 2e-3   # m"),
    ("insertions", "exponent", "exponent = 4.0"),
    (
        "insertions",
        "diameters",
        "diameters = [1e-3, 2e-3, 3e-3]   # m, one more than shares",
    ),
    ("insertions", "shares", "shares = [0.4, 0.6]"),
    ("insertions", "min", "min = [0, 0, 0.1]   # m"),
    ("insertions", "max", "max = [0.1, 0.1, 0.2]   # m"),
    (
        "insertions",
        "shape",
        "shape = \"box\"   # or cylinder, sphere, cone, mesh, half-space, union, intersection, difference",
    ),
    (
        "regions",
        "region",
        "region = { shape = \"box\", min = [0, 0, 0], max = [0.1, 0.1, 0.05] }   # m",
    ),
    (
        "fluxes",
        "plane",
        "plane = { point = [0.05, 0.05, 0.02], normal = [0, 0, -1] }   # m; counted along the normal",
    ),
    (
        "fluxes",
        "point",
        "point = [0.05, 0.05, 0.02]   # m, on the plane",
    ),
    (
        "fluxes",
        "normal",
        "normal = [0, 0, -1]   # the direction that counts",
    ),
    (
        "fields",
        "name",
        "name = \"profile\"   # part of the file's name",
    ),
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
