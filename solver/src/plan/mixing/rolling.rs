//! The laws of rolling and torsion of a pair.

use mercury_common::scene::{Couple, CoupleOverride, OrDefault, RollingLaw, TorsionLaw};

use super::tangential::resolve_static;
use super::{Origin, Pair};
use crate::contact::rolling::FrictionSpring;
use crate::contact::{AnyRolling, AnyTangential, Luding, SpringRotation};

/// One of the two couples.
#[derive(Clone, Copy)]
enum Kind {
    Rolling,
    Torsion,
}

/// Keys of the two couples: friction, static friction, stiffness, dissipation.
const KEYS: [[&str; 4]; 2] = [
    [
        "rolling.friction",
        "rolling.static_friction",
        "rolling.stiffness",
        "rolling.dissipation",
    ],
    [
        "torsion.friction",
        "torsion.static_friction",
        "torsion.stiffness",
        "torsion.dissipation",
    ],
];

impl Kind {
    fn keys(self) -> [&'static str; 4] {
        KEYS[self as usize]
    }

    fn sides<'a>(self, pair: &Pair<'a>) -> [Option<&'a Couple>; 2] {
        pair.sides.map(|side| match self {
            Self::Rolling => side
                .rolling
                .as_deref()
                .map(|RollingLaw::Luding(couple)| couple),
            Self::Torsion => side
                .torsion
                .as_deref()
                .map(|TorsionLaw::Luding(couple)| couple),
        })
    }

    fn replaced<'a>(self, pair: &Pair<'a>) -> Option<&'a CoupleOverride> {
        let (_, contact) = pair.contact?;
        match self {
            Self::Rolling => contact.rolling.as_ref(),
            Self::Torsion => contact.torsion.as_ref(),
        }
    }

    /// The coefficient of the pair: a material without the law has none.
    fn friction(self, pair: &Pair<'_>) -> (f64, Origin) {
        let over = self
            .replaced(pair)
            .and_then(|couple| couple.friction.as_deref().copied());
        let sides = self
            .sides(pair)
            .map(|couple| Some(couple.map_or(0.0, |couple| *couple.friction)));
        pair.mix(over, sides).unwrap_or((0.0, Origin::Default))
    }

    /// The stiffness; `None`: k_t of the contact. A side that leaves it open leaves it to the other one.
    fn stiffness(self, pair: &Pair<'_>) -> Option<(f64, Origin)> {
        match self.replaced(pair).and_then(|c| c.stiffness.as_ref()) {
            Some(OrDefault::Given(k)) => return Some((**k, pair.contact_origin())),
            Some(OrDefault::Default) => return None,
            None => {}
        }
        let typed = self.sides(pair).map(|couple| match &couple?.stiffness {
            OrDefault::Given(k) => Some(**k),
            OrDefault::Default => None,
        });
        pair.mix(None, typed)
    }
}

/// Whether a couple of the pair takes its stiffness from the tangential law.
pub(super) fn needs_tangential_stiffness(pair: &Pair<'_>) -> bool {
    [Kind::Rolling, Kind::Torsion]
        .into_iter()
        .any(|kind| kind.friction(pair).0 > 0.0 && kind.stiffness(pair).is_none())
}

pub(super) fn resolve(pair: &mut Pair<'_>, tangential: &AnyTangential) -> Option<AnyRolling> {
    let rolling = spring(pair, Kind::Rolling, tangential);
    let torsion = spring(pair, Kind::Torsion, tangential);
    let (rolling, torsion) = (rolling?, torsion?);
    if rolling.friction == 0.0 && torsion.friction == 0.0 {
        return Some(AnyRolling::None);
    }
    let is_mindlin = matches!(
        tangential,
        AnyTangential::Mindlin(_) | AnyTangential::MindlinRescaled(_)
    );
    pair.record(
        "rolling.lever",
        "R*",
        pair.lever(),
        Origin::Derived("contact.rolling_lever"),
    );
    Some(AnyRolling::Luding(Luding {
        rolling,
        torsion,
        lever: pair.lever(),
        // Beside Mindlin's law, whose springs are always projected, these are too.
        rotation: if is_mindlin {
            SpringRotation::Project
        } else {
            pair.rotation()
        },
    }))
}

fn spring(pair: &mut Pair<'_>, kind: Kind, tangential: &AnyTangential) -> Option<FrictionSpring> {
    let [friction_key, static_key, stiffness_key, dissipation_key] = kind.keys();
    let (friction, origin) = kind.friction(pair);
    if friction == 0.0 {
        return Some(FrictionSpring {
            stiffness: None,
            dissipation: 0.0,
            friction: 0.0,
            static_friction: 0.0,
        });
    }
    pair.record(friction_key, "", friction, origin);
    let (sides, replaced) = (kind.sides(pair), kind.replaced(pair));
    let static_friction = resolve_static(
        pair,
        static_key,
        replaced.and_then(|c| c.static_friction.as_deref().copied()),
        sides.map(|c| c.and_then(|c| c.static_friction.as_deref().copied())),
        sides.map(|c| c.map_or(0.0, |c| *c.friction)),
        friction,
    )?;
    let stiffness = kind.stiffness(pair);
    let is_absent = match (&stiffness, tangential) {
        (Some((k, _)), _) => *k == 0.0,
        (None, AnyTangential::None) => true,
        (None, AnyTangential::Linear(law)) => law.stiffness == 0.0,
        (None, _) => false,
    };
    if is_absent {
        let message = format!(
            "{stiffness_key} of the contacts of {} is missing: the pair has no tangential stiffness to take it from",
            pair.name()
        );
        let (table, _) = stiffness_key.split_once('.').unwrap_or((stiffness_key, ""));
        let help = format!("give {table} = {{ stiffness = ... }} in N/m, or a tangential law");
        pair.error(message, help);
        return None;
    }
    match &stiffness {
        Some((k, origin)) => pair.record(stiffness_key, "N/m", *k, origin.clone()),
        None => pair.record_word(stiffness_key, "k_t of the contact", Origin::Default),
    }
    let (dissipation, dissipation_origin) = pair
        .mix(
            replaced.and_then(|c| c.dissipation.as_deref().copied()),
            sides.map(|c| c.map(|c| *c.dissipation)),
        )
        .unwrap_or((0.0, Origin::Default));
    pair.record(dissipation_key, "kg/s", dissipation, dissipation_origin);
    Some(FrictionSpring {
        stiffness: stiffness.map(|(k, _)| k),
        dissipation,
        friction,
        static_friction,
    })
}
