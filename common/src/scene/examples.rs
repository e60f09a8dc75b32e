//! A line to copy where a key of a contact law is missing: with its unit, and with a value that makes sense for grains of some millimetres.

/// Key and line.
const LINES: &[(&str, &str)] = &[
    ("youngs_modulus", "youngs_modulus = 1e7   # Pa"),
    ("friction", "friction = 0.5"),
    ("poisson_ratio", "poisson_ratio = 0.3"),
    ("restitution", "restitution = 0.8"),
    ("stiffness", "stiffness = 1e4   # N/m"),
    ("loading_stiffness", "loading_stiffness = 1e4   # N/m"),
    ("unloading_stiffness", "unloading_stiffness = 5e4   # N/m"),
    (
        "cohesion_stiffness",
        "cohesion_stiffness = 1e3   # N/m; 0: no cohesion",
    ),
    ("penetration_depth", "penetration_depth = 0.05   # of 2 R*"),
];

/// The line for a key that is missing.
pub(super) fn example(key: &str) -> Option<String> {
    let found = LINES.iter().find(|(name, _)| *name == key);
    found.map(|(_, line)| format!("for example: {line}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_states_its_key() {
        for (key, line) in LINES {
            let table: toml::Table = line
                .parse()
                .unwrap_or_else(|error| panic!("{line}: {error}"));
            assert_eq!(table.keys().collect::<Vec<_>>(), [key], "{line}");
        }
    }
}
