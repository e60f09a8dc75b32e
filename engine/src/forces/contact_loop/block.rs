//! A block of rows with the slots that they own.

use std::ops::Range;

use super::slot_events::SlotEvent;
use super::slots::{Slot, WITH_HISTORY, WallSlot};
use crate::contact::History;
use crate::forces::blocks::Outbox;
use crate::forces::{NearWall, Reports, SavedSlot, SlotState};
use crate::state::WallIndex;
use crate::walls::NearMeshes;

/// A block of consecutive rows with the slots that they own.
#[derive(Debug)]
pub(super) struct Block<H> {
    pub(super) rows: Range<usize>,
    /// In the order of their owners.
    pub(super) slots: Vec<Slot<H>>,
    pub(super) near_walls: Vec<NearWall>,
    /// `features` slots for each entry of `near_walls`.
    pub(super) wall_slots: Vec<WallSlot<H>>,
    /// Facets for those of `near_walls` that are near a mesh, by index.
    pub(super) near_meshes: NearMeshes,
    pub(super) outbox: Outbox,
    /// The approximate time to compute and to finish the block, ns. Only ratios matter, and only for the distribution of the
    /// work.
    pub(super) work: usize,
    pub(super) reports: Reports,
    /// Contacts with an event since the last call; none where no law requests them.
    pub(super) events: Vec<SlotEvent<H>>,
}

impl<H> Block<H> {
    /// Of these rows, without slots.
    pub(super) fn empty(rows: Range<usize>) -> Self {
        Self {
            rows,
            slots: Vec::new(),
            near_walls: Vec::new(),
            wall_slots: Vec::new(),
            near_meshes: NearMeshes::default(),
            outbox: Outbox::default(),
            work: 0,
            reports: Reports::default(),
            events: Vec::new(),
        }
    }
}

impl<H: History> Block<H> {
    /// Every slot at a wall and its history, in order.
    pub(super) fn saved_near_walls(
        &self,
    ) -> impl Iterator<Item = (SavedSlot<'static>, Option<&H>)> {
        let near = self.near_walls.iter();
        let near = near.flat_map(|near| std::iter::repeat_n(near, near.features as usize));
        near.zip(&self.wall_slots).map(|(near, slot)| {
            let saved = SavedSlot {
                row: near.row,
                partner: u32::from(near.wall.number()),
                image: near.image,
                state: SlotState::of(slot.state),
                feature: slot.feature,
                history: &[],
            };
            (saved, Some(&slot.history))
        })
    }

    /// Takes back the next of these.
    pub(super) fn push_saved_at_wall(&mut self, saved: &SavedSlot<'_>, history: H) {
        let same = |last: &NearWall| {
            (last.row, u32::from(last.wall.number()), last.image)
                == (saved.row, saved.partner, saved.image)
        };
        match self.near_walls.last_mut() {
            Some(last) if same(last) => last.features += 1,
            _ => self.near_walls.push(NearWall {
                row: saved.row,
                wall: WallIndex::new(saved.partner as u16),
                image: saved.image,
                features: 1,
            }),
        }
        self.wall_slots.push(WallSlot {
            feature: saved.feature,
            state: saved.state.bits(),
            history,
            friction: None,
        });
    }

    /// Notes which later blocks its slots reach into, and the cost of the slots.
    pub(super) fn note_targets(&mut self, block_size: usize) {
        self.work = 2 * self.slots.len() + 8 * self.rows.len();
        let remember = (self.slots.iter()).filter(|slot| slot.state & WITH_HISTORY != 0);
        self.work += 25 * remember.count();
        let partners = self.slots.iter().map(|slot| slot.partner as usize);
        let later = partners.filter(|&partner| partner >= self.rows.end);
        self.outbox = Outbox::of(self.rows.start / block_size, later, block_size);
    }
}
