//! The normal law of a pair.

use mercury_common::scene::{LawKeys, LawPart};

use super::Pair;
use crate::contact::{AnyNormal, PlannedNormal};

pub(super) fn resolve(pair: &mut Pair<'_>) -> Option<AnyNormal> {
    pair.ask(LawPart::Normal, &LawKeys::NONE);
    let own = pair.sides.map(|side| side.normal.name.value.as_str());
    let over = pair
        .contact
        .and_then(|(_, contact)| contact.normal.as_ref());
    let (name, origin) = match over.and_then(|law| law.name.as_ref()) {
        Some(name) => (name.value.as_str(), pair.contact_origin()),
        None if own[0] == own[1] => (own[0], pair.mixed_origin([true; 2])),
        None => {
            let message = format!(
                "the contacts of {} have no normal law: `{}` is {}, `{}` is {}",
                pair.name(),
                pair.sides[0].name.value,
                own[0],
                pair.sides[1].name.value,
                own[1],
            );
            let help = format!("name it: {}", pair.entry("normal = { law = \"...\", ... }"));
            pair.error(message, help);
            return None;
        }
    };
    let law = pair.known(AnyNormal::KEYS, name)?;
    pair.ask(LawPart::Normal, law);
    pair.record_word("law", law.name, origin);
    AnyNormal::of_scene(pair)
}
