//! The plastic law of a pair.

use mercury_common::scene::{NormalLaw, NormalOverride};

use super::{Normal, Origin, Pair};
use crate::contact::{AnyNormal, Plastic};

pub(super) fn resolve(pair: &mut Pair<'_>, replaced: Option<&NormalOverride>) -> Option<Normal> {
    let sides = pair.sides.map(|side| match &side.normal.value {
        NormalLaw::Plastic {
            loading_stiffness,
            unloading_stiffness,
            cohesion_stiffness,
            penetration_depth,
            dissipation,
        } => Some([
            **loading_stiffness,
            **unloading_stiffness,
            **cohesion_stiffness,
            **penetration_depth,
            **dissipation,
        ]),
        _ => None,
    });
    let over = replaced.map(|n| {
        [
            &n.loading_stiffness,
            &n.unloading_stiffness,
            &n.cohesion_stiffness,
            &n.penetration_depth,
            &n.dissipation,
        ]
        .map(|value| value.as_deref().copied())
    });
    const KEYS: [(&str, &str); 5] = [
        ("normal.loading_stiffness", "N/m"),
        ("normal.unloading_stiffness", "N/m"),
        ("normal.cohesion_stiffness", "N/m"),
        ("normal.penetration_depth", ""),
        ("normal.dissipation", "kg/s"),
    ];
    let mut numbers = [0.0; 5];
    for (i, (key, unit)) in KEYS.into_iter().enumerate() {
        let over = over.and_then(|over| over[i]);
        let own = sides.map(|side| side.map(|side| side[i]));
        let (value, origin) = match pair.mix(over, own) {
            None if i == 4 => (0.0, Origin::Default),
            _ => pair.need(key, over, own)?,
        };
        numbers[i] = value;
        pair.record(key, unit, value, origin);
    }
    let [k1, k2, kc, phi, gamma] = numbers;
    if k2 < k1 {
        let message = format!(
            "unloading_stiffness = {k2} of the contacts of {} lies below loading_stiffness = {k1}",
            pair.name()
        );
        pair.error(message, "replace both".to_owned());
        return None;
    }
    Some(Normal {
        law: AnyNormal::Plastic(Plastic {
            loading_stiffness: k1,
            unloading_stiffness: k2,
            cohesion_stiffness: kc,
            penetration_depth: phi,
            dissipation: gamma,
            clamp_tension: pair.conventions.clamp_tension,
        }),
        beta: None,
        stiffness: Some(k1),
    })
}
