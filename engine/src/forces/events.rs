//! The memory that the laws of contacts share with parts of the step, and their events.

use super::{ContactForces, Partner};

/// The place of a contact in memory: valid until the next list or force evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlotPlace {
    pub(super) block: u32,
    pub(super) slot: u32,
    pub(super) at_wall: bool,
}

impl SlotPlace {
    /// Block, slot in the block, and whether it is a slot at a wall: together they identify a place.
    #[must_use]
    pub fn numbers(&self) -> (u32, u32, bool) {
        (self.block, self.slot, self.at_wall)
    }
}

/// A contact with the memory that its law shares ([`LawEvents::Memory`](crate::contact::LawEvents::Memory)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactMemory<M> {
    /// Where it is kept; `None` where the contact is gone.
    pub place: Option<SlotPlace>,
    /// Row of the particle.
    pub row: u32,
    /// The other side.
    pub partner: Partner,
    /// Feature of the wall, if that is one.
    pub feature: u32,
    /// Whether the two overlapped in the last force evaluation.
    pub touches: bool,
    /// The memory.
    pub memory: M,
}

/// An event of a contact in the last force evaluation, or in the list before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEvent<E, M> {
    /// The kind of event.
    pub event: E,
    /// The contact, as it was then.
    pub contact: ContactMemory<M>,
}

impl dyn ContactForces + '_ {
    /// The events of the last force evaluation, block by block; none where the adhesion law has no events of this kind. Any number of
    /// parts may read them.
    #[must_use]
    pub fn events_of<E: 'static, M: 'static>(&self) -> &[ContactEvent<E, M>] {
        let log = self.events().downcast_ref::<Vec<ContactEvent<E, M>>>();
        log.map_or(&[], Vec::as_slice)
    }

    /// The contacts that have something to lose and of which a row, at either end, is one that `wanted` names, in the order of their slots;
    /// none where the adhesion law shares no memory of this kind.
    #[must_use]
    pub fn memories_of<M: 'static>(&self, wanted: &dyn Fn(usize) -> bool) -> Vec<ContactMemory<M>> {
        let all = self.memories(wanted).downcast();
        all.map_or_else(|_| Vec::new(), |all| *all)
    }
}
