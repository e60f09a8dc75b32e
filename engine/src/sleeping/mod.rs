//! Particles at rest fall asleep, and sleepers out of balance are woken (`docs/theory/sleeping.md`).
//!
//! All particles are checked at a fixed interval of steps. A particle that was slow then and is slow now, has hardly moved in
//! between, and is in balance, is put to rest. A sleeper is woken as soon as the load on it is out of balance by more than a part
//! of its weight, when a wall begins to move near it, or when a wall near it appears or disappears. Both happen between the drift
//! and the forces of a step, whatever is fused with what.

mod part;

pub(crate) use part::Sleep;

use glam::DVec3;

use crate::state::Load;

/// When particles fall asleep, and what wakes them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sleeping {
    /// Steps between two checks of all particles: a particle at rest in two consecutive checks falls asleep.
    pub every: u64,
    /// A particle below this speed is at rest, m/s.
    pub speed: f64,
    /// Imbalance of the forces on a sleeper that wakes it, as a part of its weight.
    pub imbalance: f64,
}

/// What was counted of sleepers since the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SleepCounts {
    /// Steps times rows: spheres, and pebbles of clumps.
    pub steps: u64,
    /// Of them, those that were not made, as the particle slept.
    pub slept: u64,
    /// How often a particle fell asleep, a clump as one.
    pub fell_asleep: u64,
    /// How often one was woken.
    pub woken: u64,
    /// Kinetic energy that was removed when particles fell asleep, J.
    pub energy: f64,
}

crate::state::plain!(SleepCounts {
    steps,
    slept,
    fell_asleep,
    woken,
    energy
});

/// What a run keeps of each row at most, bytes; a checkpoint holds it without what pads the loads.
#[must_use]
pub const fn bytes_per_row() -> usize {
    size_of::<DVec3>() + size_of::<Load>()
}
