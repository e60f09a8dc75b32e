//! The limits beyond which a simulation is not to be trusted.

pub use mercury_common::scene::GuardPolicy;

/// Limits, and what happens beyond them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guard {
    /// Action beyond a limit.
    pub policy: GuardPolicy,
    /// Largest overlap over the smaller radius.
    pub overlap: f64,
    /// Longest way in a step over the radius.
    pub way: f64,
}

impl Guard {
    /// Nothing is looked at.
    pub const OFF: Self = Self {
        policy: GuardPolicy::Off,
        overlap: 0.5,
        way: 0.5,
    };
}
