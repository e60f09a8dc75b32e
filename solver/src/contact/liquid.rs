//! The laws of liquid bridges: scenes can name them; the plan of this version refuses them.

use mercury_common::scene::{Key, LawKeys, Mixing, Part, Range};

/// Every one of them.
pub(super) const KEYS: [&LawKeys; 4] = [
    &law("willett", "Willett et al. (2000), the short approximation"),
    &law("willett-classical", "Willett et al. (2000), the full fit"),
    &law("bagheri", "Bagheri et al. (2024)"),
    &law("lian-seville", "Lian & Seville (2016)"),
];

const fn law(name: &'static str, text: &'static str) -> LawKeys {
    LawKeys {
        parts: &[Part::Liquid],
        name,
        text,
        keys: BRIDGE,
        choices: &[],
    }
}

const fn key(name: &'static str, unit: &'static str, range: Range, text: &'static str) -> Key {
    Key::new(name, unit, range, text).mixes(Mixing::Derived("not in this version"))
}

/// All of them have the same keys.
const BRIDGE: &[Key] = &[
    key("surface_tension", "N/m", Range::NonNegative, "gamma"),
    key(
        "contact_angle_degrees",
        "degrees",
        Range::Between(0.0, 180.0),
        "theta",
    ),
    key(
        "max_bridge_volume",
        "m3",
        Range::NonNegative,
        "largest volume of a bridge",
    ),
    key(
        "viscosity",
        "Pa s",
        Range::NonNegative,
        "dynamic; 0: no lubrication force",
    )
    .or(0.0),
    key(
        "min_bridge_volume",
        "m3",
        Range::NonNegative,
        "smallest volume of a bridge that forms",
    )
    .or(0.0),
    key(
        "distribution",
        "",
        Range::Fraction,
        "share of a ruptured bridge's liquid that goes to neighbouring bridges, the rest to the films",
    )
    .or(1.0),
    key(
        "roughness",
        "m",
        Range::NonNegative,
        "least gap of the lubrication force",
    )
    .or_word("default", "R*/100"),
];
