//! The data of a listed pair, and of a feature of a wall near a particle.

use crate::contact::{FrictionNow, History};
use crate::forces::SlotState;

/// A listed pair with its history.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot<H> {
    /// Row of the partner.
    pub(super) partner: u32,
    /// Image code of the partner, [`TOUCHING`], [`ADHERING`], and the owner.
    pub(super) state: u32,
    pub(super) history: H,
}

/// Set in [`Slot::state`] while the two touch.
pub(super) const TOUCHING: u32 = 1 << 8;
/// Set in [`Slot::state`] while the two are apart and adhesion holds them together.
pub(super) const ADHERING: u32 = 1 << 9;
/// Set in [`WallSlot::state`] while the wall is touched from behind.
pub(super) const BEHIND: u32 = 1 << 10;
/// Set in [`WallSlot::state`] while the centre of a particle that came from the front is behind the wall.
pub(super) const THROUGH: u32 = 1 << 11;
/// Set in [`WallSlot::state`] while a contact with a sheet joins a nearer one of the same particle.
pub(super) const JOINED: u32 = 1 << 12;
/// Either of the two: there is a history.
pub(super) const WITH_HISTORY: u32 = TOUCHING | ADHERING;
/// The image code's bits in [`Slot::state`].
pub(super) const IMAGE: u32 = TOUCHING - 1;
/// The row within the block that owns the slot stands in the upper half of [`Slot::state`].
const OWNER_SHIFT: u32 = 16;

impl<H> Slot<H> {
    /// `owner`: row within the block.
    pub(super) fn new(owner: usize, partner: u32, image: u32, state: u32, history: H) -> Self {
        Self {
            partner,
            state: image | state | (owner as u32) << OWNER_SHIFT,
            history,
        }
    }

    /// Row of the owner within the block.
    #[inline(always)]
    pub(super) fn owner(&self) -> usize {
        (self.state >> OWNER_SHIFT) as usize
    }
}

/// A feature of a wall that a particle is near, with its history.
#[derive(Debug, Clone, Copy)]
pub(super) struct WallSlot<H> {
    /// Feature of the wall; [`FREE`] while the slot holds none.
    pub(super) feature: u32,
    /// [`TOUCHING`], [`ADHERING`], or neither; with [`BEHIND`], [`THROUGH`] or [`JOINED`].
    pub(super) state: u32,
    pub(super) history: H,
    /// Friction in the last evaluation; of walls alone whose wear or loads on triangles are of interest.
    pub(super) friction: Option<FrictionNow>,
}

pub(in crate::forces) const FREE: u32 = u32::MAX;

impl<H: History> WallSlot<H> {
    /// Without a feature.
    pub(super) fn free() -> Self {
        Self {
            feature: FREE,
            state: 0,
            history: H::default(),
            friction: None,
        }
    }

    /// The contact has ended.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        if self.feature != FREE {
            *self = Self::free();
        }
    }
}

/// The bits of a slot whose pair was just evaluated: `touches`, or else adhering if the history of the adhesion (`memory`) is not
/// empty.
#[inline(always)]
pub(super) fn with_history<H: History>(touches: bool, memory: &H) -> u32 {
    if touches {
        TOUCHING
    } else if *memory != H::default() {
        ADHERING
    } else {
        0
    }
}

impl SlotState {
    /// From the bits of a slot.
    pub(super) fn of(state: u32) -> Self {
        if state & BEHIND != 0 {
            Self::Behind
        } else if state & THROUGH != 0 {
            Self::Through
        } else if state & JOINED != 0 {
            Self::Joined
        } else if state & TOUCHING != 0 {
            Self::Touching
        } else if state & ADHERING != 0 {
            Self::Adhering
        } else {
            Self::Near
        }
    }

    /// Its bits in a slot.
    pub(super) fn bits(self) -> u32 {
        match self {
            Self::Near => 0,
            Self::Touching => TOUCHING,
            Self::Adhering => ADHERING,
            Self::Behind => TOUCHING | BEHIND,
            Self::Through => TOUCHING | THROUGH,
            Self::Joined => TOUCHING | JOINED,
        }
    }
}
