//! `[guard]`: what a run may not do in silence.

use super::cursor::Fields;
use super::keys::{TableKeys, Word, key, positive, word};
use super::source::Located;

/// `[guard]`: limits beyond which a simulation is not to be trusted, and what happens there.
#[derive(Debug, Clone, PartialEq)]
pub struct Guard {
    /// Action beyond a limit; default strict.
    pub policy: GuardPolicy,
    /// Largest overlap, in smaller radii; default 0.5, or `contact.overlap_error` if that is more.
    pub overlap: Located<f64>,
    /// Longest way in one step, in radii; default 0.5.
    pub way: Located<f64>,
}

/// Action beyond a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GuardPolicy {
    /// The run stops.
    Strict,
    /// The run goes on; the number of cases, and the worst case, are reported at the end.
    Warn,
    /// The run goes on without a message.
    Off,
}

impl Word for GuardPolicy {
    const WHAT: &'static str = "policy of the guard";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("strict", Self::Strict),
        ("warn", Self::Warn),
        ("off", Self::Off),
    ];
}

/// `[guard]`
#[rustfmt::skip]
pub(super) static GUARD: TableKeys = TableKeys::new(&[&[
    key("policy", word::<GuardPolicy>(), "\"warn\"", "what happens beyond a limit: the run stops; `\"warn\"`: it goes on, and the final report gives the number of cases and the worst; `\"off\"`").or_word("strict"),
    key("overlap", positive(""), "0.5", "largest overlap, as a fraction of the smaller radius").or_open("0.5, or `contact.overlap_error` if that is more"),
    key("way", positive(""), "0.5", "longest way in one step, as a fraction of the radius").or(0.5),
]]);

/// `overlap_error`: the limit of the start, which this one is not below unless it is given.
pub(super) fn read(fields: &Fields<'_>, overlap_error: f64) -> Guard {
    let overlap: Option<Located<f64>> = fields.read("overlap");
    Guard {
        policy: fields.read("policy"),
        overlap: overlap.unwrap_or_else(|| fields.default("overlap", overlap_error.max(0.5))),
        way: fields.read("way"),
    }
}
