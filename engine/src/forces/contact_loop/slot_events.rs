//! Events of contacts, and the memory that their laws share with parts of the step.

use super::ContactLoop;
use super::across::{put_history, take_history};
use super::block::Block;
use super::carry_histories::CarriedFromWall;
use super::pass::Pass;
use super::slots::{FREE, IMAGE, Slot, TOUCHING, WITH_HISTORY, WallSlot, with_history};
use crate::contact::{
    AdhesionLaw, Histories, History, LawEvents, MemoryOf, NormalLaw, RollingLaw, TangentialLaw,
};
use crate::forces::{ContactEvent, ContactMemory, NearWall, Partner, SlotPlace, ToAllRanks};
use crate::state::{Plain, WallIndex};

/// A contact with an event, as the evaluation of a block notes it.
#[derive(Debug, Clone, Copy)]
pub(super) enum SlotEvent<H> {
    /// A listed pair, by the number of its slot.
    Pair { slot: u32 },
    /// A particle and a feature of a wall, by the number of the entry among those near walls. Slots at walls may still move.
    Wall { near: u32, feature: u32 },
    /// A contact whose slot is gone, with the history that it had.
    Gone {
        row: u32,
        partner: Partner,
        feature: u32,
        history: H,
    },
}

/// Events of a block.
pub(super) type SlotEvents<H> = Vec<SlotEvent<H>>;

impl<H: History> SlotEvent<H> {
    /// The event of a slot at a wall that is about to be cleared.
    fn gone_from_wall(near: &NearWall, slot: &WallSlot<H>) -> Self {
        Self::Gone {
            row: near.row,
            partner: Partner::Wall {
                wall: near.wall,
                image: near.image,
            },
            feature: slot.feature,
            history: slot.history,
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// The event of a slot at a wall that is about to be cleared, if its history has something to lose.
    #[inline(always)]
    pub(super) fn forgotten(
        near: &NearWall,
        slot: &WallSlot<Histories<N, T, R, A>>,
    ) -> Option<SlotEvent<Histories<N, T, R, A>>> {
        let ends = A::Events::end(&slot.history.3).is_some();
        ends.then(|| SlotEvent::gone_from_wall(near, slot))
    }

    /// The event of a listed pair whose history is about to be cleared, likewise.
    pub(super) fn gone(
        row: usize,
        slot: &Slot<Histories<N, T, R, A>>,
    ) -> Option<SlotEvent<Histories<N, T, R, A>>> {
        let ends = A::Events::end(&slot.history.3).is_some();
        ends.then_some(SlotEvent::Gone {
            row: row as u32,
            partner: Partner::Particle {
                row: slot.partner,
                image: slot.state & IMAGE,
            },
            feature: FREE,
            history: slot.history,
        })
    }
}

impl<N: History, T: History, R: History, B: History> Block<(N, T, R, B)> {
    /// Moves the contacts of the block that had an event, with the places of their slots, to those of all blocks; `number` is that of the
    /// block.
    pub(super) fn take_eventful(&mut self, number: u32, all: &mut Vec<ContactMemory<B>>) {
        if self.events.is_empty() {
            return;
        }
        let at_walls = |event: &SlotEvent<_>| matches!(event, SlotEvent::Wall { .. });
        let firsts = if self.events.iter().any(at_walls) {
            self.first_wall_slots()
        } else {
            Vec::new()
        };
        for event in std::mem::take(&mut self.events) {
            all.push(match event {
                SlotEvent::Pair { slot } => self.at_pair(number, slot as usize),
                SlotEvent::Wall { near, feature } => {
                    let index = near as usize;
                    let (near, first) = (self.near_walls[index], firsts[index]);
                    let slots = &self.wall_slots[first..first + near.features as usize];
                    let Some(at) = slots.iter().position(|slot| slot.feature == feature) else {
                        continue;
                    };
                    self.at_wall(number, &near, first + at)
                }
                SlotEvent::Gone {
                    row,
                    partner,
                    feature,
                    history,
                } => ContactMemory {
                    place: None,
                    row,
                    partner,
                    feature,
                    touches: false,
                    memory: history.3,
                },
            });
        }
    }

    fn at_pair(&self, block: u32, index: usize) -> ContactMemory<B> {
        let slot = &self.slots[index];
        ContactMemory {
            place: Some(SlotPlace {
                block,
                slot: index as u32,
                at_wall: false,
            }),
            row: (self.rows.start + slot.owner()) as u32,
            partner: Partner::Particle {
                row: slot.partner,
                image: slot.state & IMAGE,
            },
            feature: FREE,
            touches: slot.state & TOUCHING != 0,
            memory: slot.history.3,
        }
    }

    fn at_wall(&self, block: u32, near: &NearWall, index: usize) -> ContactMemory<B> {
        let slot = &self.wall_slots[index];
        ContactMemory {
            place: Some(SlotPlace {
                block,
                slot: index as u32,
                at_wall: true,
            }),
            row: near.row,
            partner: Partner::Wall {
                wall: near.wall,
                image: near.image,
            },
            feature: slot.feature,
            touches: slot.state & TOUCHING != 0,
            memory: slot.history.3,
        }
    }

    /// Appends the contacts of rows that `wanted` names, at either end, that have something to lose, in the order of the slots.
    pub(super) fn add_memories<A: AdhesionLaw<History<f64> = B>>(
        &self,
        number: u32,
        wanted: &dyn Fn(usize) -> bool,
        all: &mut Vec<ContactMemory<B>>,
    ) {
        for (index, slot) in self.slots.iter().enumerate() {
            if slot.state & WITH_HISTORY != 0
                && (wanted(self.rows.start + slot.owner()) || wanted(slot.partner as usize))
                && A::Events::end(&slot.history.3).is_some()
            {
                all.push(self.at_pair(number, index));
            }
        }
        let mut next = 0;
        for near in &self.near_walls {
            let first = next;
            next += near.features as usize;
            if !wanted(near.row as usize) {
                continue;
            }
            for index in first..next {
                if A::Events::end(&self.wall_slots[index].history.3).is_some() {
                    all.push(self.at_wall(number, near, index));
                }
            }
        }
    }

    /// Replaces the memory in a slot.
    pub(super) fn set_memory<A: AdhesionLaw<History<f64> = B>>(
        &mut self,
        place: &SlotPlace,
        memory: &MemoryOf<A>,
    ) {
        let slot = place.slot as usize;
        let replace = |history: &mut (N, T, R, B), state: &mut u32| {
            A::Events::replace(&mut history.3, memory);
            let touches = *state & TOUCHING != 0;
            *state = *state & !WITH_HISTORY | with_history(touches, &history.3);
        };
        if place.at_wall {
            let slot = &mut self.wall_slots[slot];
            replace(&mut slot.history, &mut slot.state);
            if slot.state & WITH_HISTORY == 0 {
                slot.clear();
            }
        } else {
            let slot = &mut self.slots[slot];
            replace(&mut slot.history, &mut slot.state);
        }
    }
}

impl<B: History> ContactMemory<B> {
    /// In the form in which parts of the step read it.
    pub(super) fn shared<A: AdhesionLaw<History<f64> = B>>(&self) -> ContactMemory<MemoryOf<A>> {
        let Self {
            place,
            row,
            partner,
            feature,
            touches,
            ref memory,
        } = *self;
        ContactMemory {
            place,
            row,
            partner,
            feature,
            touches,
            memory: A::Events::memory(memory),
        }
    }

    fn put(&self, bytes: &mut Vec<u8>) {
        let place = self
            .place
            .map(|place| (place.block, (place.slot, place.at_wall)));
        place.put(bytes);
        (self.row, self.partner).put(bytes);
        (self.feature, self.touches).put(bytes);
        put_history(&self.memory, &mut Vec::new(), bytes);
    }

    fn take(bytes: &mut &[u8]) -> Option<Self> {
        let place: Option<(u32, (u32, bool))> = Plain::take(bytes).ok()?;
        let (row, partner) = Plain::take(bytes).ok()?;
        let (feature, touches) = Plain::take(bytes).ok()?;
        Some(Self {
            place: place.map(|(block, (slot, at_wall))| SlotPlace {
                block,
                slot,
                at_wall,
            }),
            row,
            partner,
            feature,
            touches,
            memory: take_history(bytes)?,
        })
    }
}

/// Contacts that each rank has found in its own blocks, put together in the order of blocks.
pub(super) fn of_all_ranks<B: History>(
    own: &[ContactMemory<B>],
    to_all: &mut ToAllRanks<'_>,
) -> Vec<ContactMemory<B>> {
    let mut bytes = Vec::new();
    own.iter().for_each(|contact| contact.put(&mut bytes));
    let mut all = Vec::new();
    for bytes in to_all(bytes) {
        let mut bytes = &bytes[..];
        all.extend(std::iter::from_fn(|| ContactMemory::take(&mut bytes)));
    }
    all
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactLoop<N, T, R, A> {
    /// Logs the events of contacts that have one.
    pub(super) fn log_events(&mut self) {
        let event = |contact: &ContactMemory<A::History<f64>>| {
            let event = match contact.place {
                Some(_) => A::Events::event(&contact.memory),
                None => A::Events::end(&contact.memory)?,
            };
            let contact = contact.shared::<A>();
            Some(ContactEvent { event, contact })
        };
        self.log.clear();
        self.log.extend(self.eventful.iter().filter_map(event));
    }
}

impl<H: History> Block<H> {
    /// The first slot of each entry near a wall.
    fn first_wall_slots(&self) -> Vec<usize> {
        let mut next = 0;
        let first = |near: &NearWall| {
            let first = next;
            next += near.features as usize;
            first
        };
        self.near_walls.iter().map(first).collect()
    }

    /// Records the contacts for which a new list has no slot, from `kept` for each row and from the walls; of those alone whose history
    /// `ends` with an event.
    pub(super) fn note_lost<'a>(
        &mut self,
        kept: impl Fn(usize) -> &'a [(u32, H)],
        from_walls: &[CarriedFromWall<H>],
        ends: impl Fn(&H) -> bool,
    ) where
        H: 'a,
    {
        let mut next = 0;
        for (owner, row) in self.rows.clone().enumerate() {
            let first = next;
            while self
                .slots
                .get(next)
                .is_some_and(|slot| slot.owner() == owner)
            {
                next += 1;
            }
            let slots = &self.slots[first..next];
            for (partner, history) in kept(row) {
                if ends(history) && !slots.iter().any(|slot| slot.partner == *partner) {
                    self.events.push(SlotEvent::Gone {
                        row: row as u32,
                        partner: Partner::Particle {
                            row: *partner,
                            image: crate::cell::NO_SHIFT,
                        },
                        feature: FREE,
                        history: *history,
                    });
                }
            }
        }
        let begin = from_walls.partition_point(|kept| (kept.0.0 as usize) < self.rows.start);
        let end = from_walls.partition_point(|kept| (kept.0.0 as usize) < self.rows.end);
        for ((row, wall, image), slot) in &from_walls[begin..end] {
            if ends(&slot.history) && !self.holds_at_wall(*row, *wall, slot) {
                let near = NearWall {
                    row: *row,
                    wall: *wall,
                    image: *image,
                    features: 0,
                };
                self.events.push(SlotEvent::gone_from_wall(&near, slot));
            }
        }
    }

    /// Whether one of the slots at a wall now has the history of `slot`.
    fn holds_at_wall(&self, row: u32, wall: WallIndex, slot: &WallSlot<H>) -> bool {
        let begin = self.near_walls.partition_point(|near| near.row < row);
        let mut first: usize = self.near_walls[..begin]
            .iter()
            .map(|near| near.features as usize)
            .sum();
        for near in &self.near_walls[begin..] {
            if near.row != row {
                break;
            }
            let slots = &self.wall_slots[first..first + near.features as usize];
            first += near.features as usize;
            let same = |other: &WallSlot<H>| {
                other.feature == slot.feature && other.history == slot.history
            };
            if near.wall == wall && slot.feature != FREE && slots.iter().any(same) {
                return true;
            }
        }
        false
    }
}
