//! The law of rolling and torsion of a pair.

use mercury_common::scene::{LawKeys, LawPart};

use super::Pair;
use crate::contact::{AnyRolling, AnyTangential};

/// The law that the tables of both parts name, at either side or for the pair; `None` where there is none.
fn law_of(pair: &mut Pair<'_>) -> Option<Option<&'static LawKeys>> {
    pair.ask(LawPart::Rolling, &LawKeys::NONE);
    let mut names: Vec<String> = Vec::new();
    for part in [LawPart::Rolling, LawPart::Torsion] {
        let over = pair.contact.and_then(|(_, contact)| contact.law(part));
        let over = over.and_then(|law| law.name.as_ref());
        let own = pair.laws(part).into_iter().flatten().map(|law| &law.name);
        for name in over.into_iter().chain(own) {
            if !names.contains(&name.value) {
                names.push(name.value.clone());
            }
        }
    }
    match names.as_slice() {
        // Keys in [[contacts]] alone, without a name, are those of the only law.
        [] => Some(AnyRolling::KEYS.first().copied()),
        [name] => pair.known(AnyRolling::KEYS, name).map(Some),
        _ => {
            let message = format!(
                "the contacts of {} have no law of rolling in common: {}",
                pair.name(),
                names.join(", ")
            );
            pair.error(message, "give rolling and torsion one law".to_owned());
            None
        }
    }
}

/// Whether the law takes its stiffness from the tangential law.
pub(super) fn needs_tangential_stiffness(pair: &mut Pair<'_>) -> bool {
    let errors = pair.errors.len();
    let law = law_of(pair).flatten();
    // `resolve` reports it.
    pair.errors.truncate(errors);
    law.is_some_and(|law| {
        pair.ask(LawPart::Rolling, law);
        AnyRolling::needs_tangential_stiffness(pair)
    })
}

pub(super) fn resolve(pair: &mut Pair<'_>, tangential: &AnyTangential) -> Option<AnyRolling> {
    match law_of(pair)? {
        Some(law) => {
            pair.ask(LawPart::Rolling, law);
            AnyRolling::of_scene(pair, tangential)
        }
        None => Some(AnyRolling::None),
    }
}
