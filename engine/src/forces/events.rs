//! The memory that the laws of contacts share with parts of the step, and their events.

use std::any::Any;

use super::{ContactForces, Partner};
use crate::ranks::Share;
use crate::state::Particles;

/// Sends bytes to all ranks and returns those of all, in their order.
pub type ToAllRanks<'a> = dyn FnMut(Vec<u8>) -> Vec<Vec<u8>> + 'a;

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
    /// none where the adhesion law shares no memory of this kind. Where several ranks divide the rows: within a step those of this one
    /// ([`SharedContacts`] has all), between steps on the first rank all.
    #[must_use]
    pub fn memories_of<M: 'static>(&self, wanted: &dyn Fn(usize) -> bool) -> Vec<ContactMemory<M>> {
        let all = self.memories(wanted, None).downcast();
        all.map_or_else(|_| Vec::new(), |all| *all)
    }
}

/// The contacts of all ranks, as far as their laws share memory with parts of the step. Every rank makes the same calls.
pub struct SharedContacts<'a> {
    contacts: &'a mut dyn ContactForces,
    share: Option<&'a mut Share>,
}

impl<'a> SharedContacts<'a> {
    /// Of the contacts of this rank, and the way to the others if there are any.
    pub fn new(contacts: &'a mut dyn ContactForces, share: Option<&'a mut Share>) -> Self {
        Self {
            contacts,
            share: share.filter(|share| share.is_divided()),
        }
    }

    /// The events of the last force evaluation, of all ranks block by block.
    #[must_use]
    pub fn events_of<E: 'static, M: 'static>(&self) -> &[ContactEvent<E, M>] {
        self.contacts.events_of()
    }

    /// The contacts that have something to lose and of which a row, at either end, is one that `wanted` names, in the order of their slots.
    pub fn memories_of<M: 'static>(
        &mut self,
        wanted: &dyn Fn(usize) -> bool,
    ) -> Vec<ContactMemory<M>> {
        let all = match &mut self.share {
            Some(share) => (self.contacts).memories(wanted, Some(&mut |own| share.to_all(own))),
            None => self.contacts.memories(wanted, None),
        };
        all.downcast().map_or_else(|_| Vec::new(), |all| *all)
    }

    /// Replaces the memory that the law of a contact shares, on the rank that has the contact.
    pub fn set_memory(&mut self, place: &SlotPlace, memory: &dyn Any) {
        self.contacts.set_memory(place, memory);
    }

    /// Brings the motion of some particles up to date; `rows`: in any order, perhaps repeated.
    pub fn complete(&mut self, particles: &mut Particles, rows: impl Iterator<Item = u32>) {
        if let Some(share) = &mut self.share {
            let mut rows: Vec<u32> = rows.collect();
            rows.sort_unstable();
            rows.dedup();
            share.complete_some(&mut particles.records, &rows);
        }
    }

    /// Brings the motion of all particles up to date.
    pub fn complete_all(&mut self, particles: &mut Particles) {
        if let Some(share) = &mut self.share {
            share.complete(particles);
        }
    }
}
