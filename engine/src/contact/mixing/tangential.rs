//! The law of sliding of a pair.

use mercury_common::scene::{LawKeys, LawPart};

use super::{Origin, Pair};
use crate::contact::{AnyNormal, AnyTangential};

/// Parameters that all laws of sliding have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// mu while sliding.
    pub mu_dynamic: f64,
    /// mu while sticking.
    pub mu_static: f64,
}

/// `needs_stiffness`: a rolling law takes its stiffness from this one, so it stays even without friction.
pub(super) fn resolve(
    pair: &mut Pair<'_>,
    normal: &AnyNormal,
    needs_stiffness: bool,
) -> Option<AnyTangential> {
    pair.ask(LawPart::Tangential, &LawKeys::NONE);
    let own = pair.laws(LawPart::Tangential);
    // A material without a law of sliding is smooth.
    let sides = own.map(|law| law.map_or(Some(0.0), |law| law.values.number("friction")));
    let (mu_dynamic, origin) = pair.mix(pair.over("friction"), sides)?;
    if mu_dynamic == 0.0 && !(needs_stiffness && own.iter().any(Option::is_some)) {
        pair.record("friction", 0.0, origin);
        return Some(AnyTangential::None);
    }
    let (law, law_origin) = law_of(pair)?;
    pair.ask(LawPart::Tangential, law);
    pair.record_word("law", law.name, law_origin);
    pair.record("friction", mu_dynamic, origin);
    let mu_static = pair.static_friction(mu_dynamic)?;
    AnyTangential::of_scene(
        pair,
        normal,
        Friction {
            mu_dynamic,
            mu_static,
        },
    )
}

fn law_of(pair: &mut Pair<'_>) -> Option<(&'static LawKeys, Origin)> {
    let over = pair
        .contact
        .and_then(|(_, contact)| contact.tangential.as_ref()?.name.as_ref());
    let own = pair
        .laws(LawPart::Tangential)
        .map(|law| law.map(|law| law.name.value.as_str()));
    let (name, origin) = match (over, own) {
        (Some(name), _) => (name.value.as_str(), pair.contact_origin()),
        (None, [Some(a), Some(b)]) if a == b => (a, pair.mixed_origin([true; 2])),
        (None, [Some(a), None]) => (a, pair.mixed_origin([true, false])),
        (None, [None, Some(b)]) => (b, pair.mixed_origin([false, true])),
        (None, laws) => {
            let [a, b] = laws.map(|law| law.unwrap_or("none"));
            let message = format!(
                "the contacts of {} have no tangential law: `{}` is {a}, `{}` is {b}",
                pair.name(),
                pair.sides[0].name.value,
                pair.sides[1].name.value,
            );
            let help = format!(
                "name it: {}",
                pair.entry("tangential = { law = \"...\", ... }")
            );
            pair.error(message, help);
            return None;
        }
    };
    Some((pair.known(AnyTangential::KEYS, name)?, origin))
}
