//! `[sleeping]`: whether particles at rest are left out of the steps.

use super::cursor::Fields;
use super::source::{Located, Place};

/// `[sleeping]`: particles at rest fall asleep; without the table no particle sleeps.
#[derive(Debug, Clone, PartialEq)]
pub struct Sleeping {
    /// Where the table stands.
    pub place: Place,
    /// How long they must have rested, s; default by gravity and size.
    pub after: Option<Located<f64>>,
    /// A particle below this speed is at rest, m/s; the default follows from gravity and size.
    pub speed: Option<Located<f64>>,
    /// Imbalance of the forces on a sleeper that wakes it, as a part of its weight; default 0.1.
    pub imbalance: Located<f64>,
}

pub(super) fn read(fields: &Fields<'_>) -> Option<Sleeping> {
    let optional = |key| match fields.get(key) {
        Some(item) => item.positive().map(Some),
        None => Some(None),
    };
    let (after, speed) = (optional("after"), optional("speed"));
    let imbalance = match fields.get("imbalance") {
        Some(item) => item.positive(),
        None => Some(fields.default("imbalance", 0.1)),
    };
    fields.finish();
    Some(Sleeping {
        place: fields.place().clone(),
        after: after?,
        speed: speed?,
        imbalance: imbalance?,
    })
}
