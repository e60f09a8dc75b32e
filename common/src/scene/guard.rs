//! `[guard]`: what a run may not do in silence.

use super::cursor::Fields;
use super::source::Located;

/// `[guard]`: limits beyond which a simulation is not to be trusted, and what happens there.
#[derive(Debug, Clone, PartialEq)]
pub struct Guard {
    /// What happens beyond a limit; default strict.
    pub policy: GuardPolicy,
    /// Largest overlap, in smaller radii; default 0.5, or `contact.overlap_error` if that is more.
    pub overlap: Located<f64>,
    /// Longest way in one step, in radii; default 0.5.
    pub way: Located<f64>,
}

/// What happens beyond a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GuardPolicy {
    /// The run stops.
    Strict,
    /// It goes on; how often it happened, and the worst case, are reported at the end.
    Warn,
    /// It goes on and nothing is said.
    Off,
}

/// `overlap_error`: the limit of the start, which this one is not below unless it is said.
pub(super) fn read(fields: &Fields<'_>, overlap_error: f64) -> Option<Guard> {
    let positive = |key, default| match fields.get(key) {
        Some(item) => item.positive(),
        None => Some(fields.default(key, default)),
    };
    let words = [
        ("strict", GuardPolicy::Strict),
        ("warn", GuardPolicy::Warn),
        ("off", GuardPolicy::Off),
    ];
    let policy = match fields.get("policy") {
        Some(item) => item.word("policy of the guard", &words),
        None => Some(GuardPolicy::Strict),
    };
    let overlap = positive("overlap", overlap_error.max(0.5));
    let way = positive("way", 0.5);
    fields.finish();
    Some(Guard {
        policy: policy?,
        overlap: overlap?,
        way: way?,
    })
}
