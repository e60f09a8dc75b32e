//! Events of contacts whose law requests them, and the liquid bridges that contacts hold.

use super::Partner;
use crate::contact::{Bridge, BridgeEvent};

/// The place of a bridge: valid until the next list or force evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BondPlace {
    pub(super) block: u32,
    pub(super) slot: u32,
    pub(super) at_wall: bool,
}

impl BondPlace {
    /// Block, slot in the block, and whether it is a slot at a wall: together they identify a place.
    #[must_use]
    pub fn numbers(&self) -> (u32, u32, bool) {
        (self.block, self.slot, self.at_wall)
    }
}

/// A contact with its liquid bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bond {
    /// Where it is kept; `None` where the contact is gone.
    pub place: Option<BondPlace>,
    /// Row of the particle.
    pub row: u32,
    /// The other side.
    pub partner: Partner,
    /// Feature of the wall, if that is one.
    pub feature: u32,
    /// Whether the two overlapped in the last force evaluation.
    pub touches: bool,
    /// The bridge.
    pub bridge: Bridge,
}

/// An event of a contact in the last force evaluation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEvent {
    /// The kind of event.
    pub event: BridgeEvent,
    /// The contact, as it was then.
    pub bond: Bond,
}
