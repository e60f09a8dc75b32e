//! Events of contacts, and the liquid bridges in the slots, for the rules that apply beyond one pair.

use super::block::Block;
use super::carry_histories::CarriedFromWall;
use super::slots::{FREE, IMAGE, TOUCHING, WITH_HISTORY, WallSlot, with_history};
use crate::contact::{Bridge, BridgeEvent, History};
use crate::forces::{Bond, BondPlace, ContactEvent, NearWall, Partner};
use crate::state::WallIndex;

/// A contact with an event, as the evaluation of a block notes it.
#[derive(Debug, Clone, Copy)]
pub(super) enum SlotEvent {
    /// A listed pair, by the number of its slot.
    Pair { slot: u32, event: BridgeEvent },
    /// A particle and a feature of a wall, by the number of the entry among those near walls. Slots at walls may still move.
    Wall {
        near: u32,
        feature: u32,
        event: BridgeEvent,
    },
    /// A contact whose slot is gone, with the bridge that it had.
    Gone {
        row: u32,
        partner: Partner,
        feature: u32,
        bridge: Bridge,
    },
}

impl SlotEvent {
    /// Records an event for a slot at a wall that is about to be cleared, if it has a bridge.
    #[inline(always)]
    pub(super) fn forgotten<H: History>(near: &NearWall, slot: &WallSlot<H>) -> Option<Self> {
        let bridge = slot.history.bridge();
        (bridge.volume > 0.0).then_some(Self::Gone {
            row: near.row,
            partner: Partner::Wall {
                wall: near.wall,
                image: near.image,
            },
            feature: slot.feature,
            bridge,
        })
    }
}

impl<H: History> Block<H> {
    /// The events of the block with the places of their slots, which are removed from the block; `number` is that of the block.
    pub(super) fn take_events(&mut self, number: u32, all: &mut Vec<ContactEvent>) {
        if self.events.is_empty() {
            return;
        }
        let at_walls = |event: &SlotEvent| matches!(event, SlotEvent::Wall { .. });
        let firsts = if self.events.iter().any(at_walls) {
            self.first_wall_slots()
        } else {
            Vec::new()
        };
        for event in std::mem::take(&mut self.events) {
            let place = |slot: u32, at_wall: bool| BondPlace {
                block: number,
                slot,
                at_wall,
            };
            let (event, bond) = match event {
                SlotEvent::Pair { slot, event } => {
                    (event, self.pair_bond(place(slot, false), slot as usize))
                }
                SlotEvent::Wall {
                    near,
                    feature,
                    event,
                } => {
                    let index = near as usize;
                    let (near, first) = (self.near_walls[index], firsts[index]);
                    let slots = &self.wall_slots[first..first + near.features as usize];
                    let Some(at) = slots.iter().position(|slot| slot.feature == feature) else {
                        continue;
                    };
                    let slot = first + at;
                    (event, self.wall_bond(place(slot as u32, true), &near, slot))
                }
                SlotEvent::Gone {
                    row,
                    partner,
                    feature,
                    bridge,
                } => {
                    let bond = Bond {
                        place: None,
                        row,
                        partner,
                        feature,
                        touches: false,
                        bridge,
                    };
                    (BridgeEvent::End, bond)
                }
            };
            all.push(ContactEvent { event, bond });
        }
    }

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

    fn pair_bond(&self, place: BondPlace, slot: usize) -> Bond {
        let slot = &self.slots[slot];
        Bond {
            place: Some(place),
            row: (self.rows.start + slot.owner()) as u32,
            partner: Partner::Particle {
                row: slot.partner,
                image: slot.state & IMAGE,
            },
            feature: FREE,
            touches: slot.state & TOUCHING != 0,
            bridge: slot.history.bridge(),
        }
    }

    fn wall_bond(&self, place: BondPlace, near: &NearWall, slot: usize) -> Bond {
        let slot = &self.wall_slots[slot];
        Bond {
            place: Some(place),
            row: near.row,
            partner: Partner::Wall {
                wall: near.wall,
                image: near.image,
            },
            feature: slot.feature,
            touches: slot.state & TOUCHING != 0,
            bridge: slot.history.bridge(),
        }
    }

    /// Appends the bridges of rows that `wanted` names, at either end, in the order of the slots.
    pub(super) fn add_bonds(
        &self,
        number: u32,
        wanted: &dyn Fn(usize) -> bool,
        all: &mut Vec<Bond>,
    ) {
        let place = |slot: usize, at_wall: bool| BondPlace {
            block: number,
            slot: slot as u32,
            at_wall,
        };
        for (index, slot) in self.slots.iter().enumerate() {
            if slot.state & WITH_HISTORY != 0
                && (wanted(self.rows.start + slot.owner()) || wanted(slot.partner as usize))
                && slot.history.bridge().volume > 0.0
            {
                all.push(self.pair_bond(place(index, false), index));
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
                if self.wall_slots[index].history.bridge().volume > 0.0 {
                    all.push(self.wall_bond(place(index, true), near, index));
                }
            }
        }
    }

    /// Puts a bridge into a slot.
    pub(super) fn set_bridge(&mut self, place: &BondPlace, bridge: Bridge) {
        let slot = place.slot as usize;
        if place.at_wall {
            let slot = &mut self.wall_slots[slot];
            slot.history.set_bridge(bridge);
            put_state(&mut slot.state, bridge);
            if slot.state & WITH_HISTORY == 0 {
                slot.clear();
            }
        } else {
            let slot = &mut self.slots[slot];
            slot.history.set_bridge(bridge);
            put_state(&mut slot.state, bridge);
        }
    }

    /// Records the bridges for which a new list has no slot, from `kept` for each row and from the walls.
    pub(super) fn note_lost<'a>(
        &mut self,
        kept: impl Fn(usize) -> &'a [(u32, H)],
        from_walls: &[CarriedFromWall<H>],
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
                let bridge = history.bridge();
                if bridge.volume > 0.0 && !slots.iter().any(|slot| slot.partner == *partner) {
                    self.events.push(SlotEvent::Gone {
                        row: row as u32,
                        partner: Partner::Particle {
                            row: *partner,
                            image: crate::cell::NO_SHIFT,
                        },
                        feature: FREE,
                        bridge,
                    });
                }
            }
        }
        let begin = from_walls.partition_point(|kept| (kept.0.0 as usize) < self.rows.start);
        let end = from_walls.partition_point(|kept| (kept.0.0 as usize) < self.rows.end);
        for ((row, wall, image), slot) in &from_walls[begin..end] {
            let near = NearWall {
                row: *row,
                wall: *wall,
                image: *image,
                features: 0,
            };
            if let Some(event) = SlotEvent::forgotten(&near, slot)
                && !self.holds_at_wall(*row, *wall, slot)
            {
                self.events.push(event);
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

/// The state of a slot whose bridge was changed.
fn put_state(state: &mut u32, bridge: Bridge) {
    let touches = *state & TOUCHING != 0;
    *state = *state & !WITH_HISTORY | with_history(touches, &bridge);
}
