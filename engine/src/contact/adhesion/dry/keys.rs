//! Keys of dry cohesion in scenes.

use mercury_common::scene::{Key, LawKeys, LawPart, Mixing, Range};

/// The table of keys of each law.
pub(in crate::contact) const KEYS: [&LawKeys; 6] = [
    &law(
        "jkr",
        "Johnson, Kendall & Roberts (1971), with the normal law `hertz`: soft, sticky spheres that form a neck",
        &[WORK],
        &[],
    ),
    &law(
        "dmt",
        "Derjaguin, Muller & Toporov (1975): the pull 2 pi W R* while they touch, for hard spheres",
        &[WORK],
        &[],
    ),
    &law(
        "van-der-waals",
        "attraction of two spheres over a gap by Hamaker (1937)",
        &[
            Key::new("hamaker", "J", Range::NonNegative, "Hamaker constant A").mixes(GEOMETRIC),
            Key::new(
                "separation",
                "m",
                Range::Positive,
                "least separation z0 of the surfaces",
            ),
            Key::new("range", "m", Range::Positive, "gap at which the force ends"),
        ],
        &[],
    ),
    &law(
        "reversible",
        "a constant pull in contact that falls linearly over a gap, before the touch and behind it",
        LINEAR,
        FORCE_OR_WORK,
    ),
    &law(
        "irreversible",
        "the same pull, over a gap after a touch alone",
        LINEAR,
        FORCE_OR_WORK,
    ),
    &law(
        "charged",
        "charges: like ones repel, unlike ones attract by the law `reversible`; with a van der Waals pull between charged ones",
        &[
            Key::new("charge", "", Range::Between(-1.0, 1.0), "-1, 0 or 1")
                .mixes(Mixing::Derived("like charges repel, unlike ones attract")),
            FORCE,
            STIFFNESS,
            Key::new(
                "van_der_waals_force",
                "N",
                Range::NonNegative,
                "van der Waals pull in contact",
            )
            .or(0.0),
            Key::new(
                "van_der_waals_stiffness",
                "N/m",
                Range::Positive,
                "fall of this pull over a gap",
            )
            .or_open("`stiffness`"),
        ],
        &[],
    ),
];

const fn law(
    name: &'static str,
    text: &'static str,
    keys: &'static [Key],
    choices: &'static [&'static [&'static [&'static str]]],
) -> LawKeys {
    LawKeys {
        parts: &[LawPart::Adhesion],
        name,
        text,
        keys,
        choices,
    }
}

/// Berthelot's rule.
const GEOMETRIC: Mixing = Mixing::Derived("geometric mean");

const WORK: Key = Key::new(
    "work_of_adhesion",
    "J/m2",
    Range::NonNegative,
    "work of adhesion W, of like surfaces twice the surface energy",
)
.mixes(GEOMETRIC);

const FORCE: Key = Key::new("force", "N", Range::NonNegative, "force f in contact");

const STIFFNESS: Key = Key::new(
    "stiffness",
    "N/m",
    Range::Positive,
    "fall k_a of the force over a gap s: f - k_a s",
);

const LINEAR: &[Key] = &[FORCE, WORK, STIFFNESS];

/// f, or W for f = 3/2 pi W R*.
const FORCE_OR_WORK: &[&[&[&str]]] = &[&[&["force"], &["work_of_adhesion"]]];
