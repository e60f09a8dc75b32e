//! Keys of liquid bridges in scenes.

use mercury_common::scene::{Key, LawKeys, LawPart, Mixing, Range};

use super::Fit;

/// The table of keys of each law.
pub(in crate::contact) const KEYS: [&LawKeys; 5] = [
    &law(
        "bagheri",
        "Bagheri et al. (2024): the best choice for most scenes",
        BRIDGE,
    ),
    &law(
        "willett-classical",
        "Willett et al. (2000), the full fit",
        BRIDGE,
    ),
    &law("lian-seville", "Lian & Seville (2016)", LIAN_SEVILLE),
    &law(
        "willett",
        "Willett et al. (2000), the short approximation",
        BRIDGE,
    ),
    &law(
        "young-laplace",
        "exact forces from a table that is made before the run: for walls, unequal radii and contact angles above 30 degrees",
        YOUNG_LAPLACE,
    ),
];

impl Fit {
    /// The law of this name.
    pub(in crate::contact) fn named(name: &str) -> Option<Self> {
        [
            Self::Bagheri,
            Self::WillettClassical,
            Self::LianSeville,
            Self::Willett,
            Self::YoungLaplace,
        ]
        .into_iter()
        .find(|fit| fit.name() == name)
    }
}

const fn law(name: &'static str, text: &'static str, keys: &'static [Key]) -> LawKeys {
    LawKeys {
        parts: &[LawPart::Liquid],
        name,
        text,
        keys,
        choices: &[],
    }
}

const SURFACE_TENSION: Key = Key::new(
    "surface_tension",
    "N/m",
    Range::NonNegative,
    "surface tension gamma",
);
const CONTACT_ANGLE: Key = Key::new(
    "contact_angle_degrees",
    "degrees",
    Range::Between(0.0, 90.0),
    "contact angle theta",
)
.mixes(Mixing::Derived("mean of the cosines"));
const MAX_VOLUME: Key = Key::new(
    "max_bridge_volume",
    "m3",
    Range::NonNegative,
    "largest volume of a bridge; 0: no bridges",
);
const VISCOSITY: Key = Key::new(
    "viscosity",
    "Pa s",
    Range::NonNegative,
    "dynamic viscosity; 0: no viscous force",
);
const MIN_VOLUME: Key = Key::new(
    "min_bridge_volume",
    "m3",
    Range::NonNegative,
    "least volume of a bridge that forms",
)
.or(0.0);
const DISTRIBUTION: Key = Key::new(
    "distribution",
    "",
    Range::Fraction,
    "share of a broken bridge's liquid that goes to neighbouring bridges; the rest goes to the films",
)
.or(1.0);
const ROUGHNESS: Key = Key::new(
    "roughness",
    "m",
    Range::Positive,
    "least gap of the viscous force",
)
.or_word("default", "R*/100");
const RUPTURE: Key = Key::new(
    "rupture",
    "",
    Range::Words(&["default", "radii", "willett", "lian"]),
    "gap at which a bridge breaks",
)
.or_word("default", "`radii`, of `willett` `lian`")
.mixes(Mixing::Same);

const ACCURACY: Key = Key::new(
    "accuracy",
    "",
    Range::Between(1e-6, 0.1),
    "largest relative error of the force, up to 0.95 of the rupture",
)
.or(1e-3);

const BRIDGE: &[Key] = &[
    SURFACE_TENSION,
    CONTACT_ANGLE,
    MAX_VOLUME,
    VISCOSITY.or(0.0),
    MIN_VOLUME,
    DISTRIBUTION,
    ROUGHNESS,
    RUPTURE,
];

/// The viscosity has to be named: codes that offer this law without one leave out half of it.
const LIAN_SEVILLE: &[Key] = &[
    SURFACE_TENSION,
    CONTACT_ANGLE,
    MAX_VOLUME,
    VISCOSITY,
    MIN_VOLUME,
    DISTRIBUTION,
    ROUGHNESS,
    RUPTURE,
];

/// The rupture is that of the table.
const YOUNG_LAPLACE: &[Key] = &[
    SURFACE_TENSION,
    CONTACT_ANGLE,
    MAX_VOLUME,
    VISCOSITY.or(0.0),
    MIN_VOLUME,
    DISTRIBUTION,
    ROUGHNESS,
    ACCURACY,
];
