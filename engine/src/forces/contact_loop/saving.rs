//! The slots of a contact loop as bytes, and back.

use super::ContactLoop;
use super::block::Block;
use super::slots::{FREE, IMAGE, Slot, WITH_HISTORY};
use crate::contact::{
    AdhesionLaw, FrictionNow, Histories, History, NormalLaw, RollingLaw, TangentialLaw,
};
use crate::forces::saved::{MOST_AT_WALL, Stretch, most_bytes_of_pairs, put_stretches};
use crate::forces::{ContactSection, Reports, SavedContacts, SavedSlot, SavedSlots, SlotState};
use crate::parallel::each_part_by;
use crate::state::{Pieces, Plain};

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactLoop<N, T, R, A> {
    /// The numbers of an empty history.
    pub(super) fn nothing() -> Vec<f64> {
        let mut nothing = Vec::new();
        <Histories<N, T, R, A>>::default().write(&mut nothing);
        nothing
    }

    /// Every listed pair and its history, if it may have one, in order.
    fn saved_pairs(
        blocks: &[Block<Histories<N, T, R, A>>],
    ) -> impl Iterator<Item = (SavedSlot<'static>, Option<&Histories<N, T, R, A>>)> {
        blocks.iter().flat_map(move |block| {
            let first = block.rows.start;
            block.slots.iter().map(move |slot| {
                let saved = SavedSlot {
                    row: (first + slot.owner()) as u32,
                    partner: slot.partner,
                    image: slot.state & IMAGE,
                    state: SlotState::of(slot.state),
                    feature: FREE,
                    history: &[],
                };
                // Without adhesion only touching pairs have a history.
                let may_remember = A::ACTIVE || slot.state & WITH_HISTORY != 0;
                (saved, may_remember.then_some(&slot.history))
            })
        })
    }

    /// Appends the pairs of some blocks to a stretch.
    fn put_blocks(stretch: &mut Stretch, blocks: &[Block<Histories<N, T, R, A>>], nothing: &[f64]) {
        let slots = || blocks.iter().flat_map(|block| &block.slots);
        let held = || {
            slots()
                .filter(|slot| slot.state & WITH_HISTORY != 0)
                .count()
        };
        // The space is reserved at once, because a growing list would be copied over and over. Laws without history need no
        // count.
        let is_new = stretch.is_new() && !nothing.is_empty();
        let remembering = if is_new { held() } else { 0 };
        let most = |block: &Block<_>| most_bytes_of_pairs(block.slots.len(), block.rows.len());
        let most = blocks.iter().map(most).sum();
        stretch.reserve(most, remembering, nothing.len());
        let slots = Self::saved_pairs(blocks);
        stretch.extend(nothing, slots, Histories::<N, T, R, A>::write);
    }

    /// Every slot at a wall and its history, in order.
    fn saved_near_walls(
        &self,
    ) -> impl Iterator<Item = (SavedSlot<'static>, Option<&Histories<N, T, R, A>>)> {
        self.blocks.iter().flat_map(Block::saved_near_walls)
    }

    fn restore_pairs(&mut self, rows: usize, saved: &SavedSlots) {
        self.cut(rows);
        let mut pairs = saved.iter().peekable();
        let mut begin = 0;
        for block in &mut self.blocks {
            // The space is reserved at once, because a growing list would be copied over and over.
            let end = saved.before(block.rows.end);
            block.slots.reserve(end.saturating_sub(begin));
            begin = end;
            for (owner, row) in block.rows.clone().enumerate() {
                while let Some(saved) = pairs.next_if(|saved| saved.row as usize == row) {
                    block.slots.push(Slot::new(
                        owner,
                        saved.partner,
                        saved.image,
                        saved.state.bits(),
                        <Histories<N, T, R, A>>::read(saved.history),
                    ));
                }
            }
            block.note_targets(self.block_size);
        }
        self.link();
    }

    /// Into blocks that are cut.
    fn restore_near_walls(&mut self, walls: &SavedSlots) {
        let mut walls = walls.iter().peekable();
        for block in &mut self.blocks {
            while let Some(saved) = walls.next_if(|saved| (saved.row as usize) < block.rows.end) {
                block.push_saved_at_wall(&saved, <Histories<N, T, R, A>>::read(saved.history));
            }
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactLoop<N, T, R, A> {
    pub(super) fn put_section(
        &self,
        section: ContactSection,
        pieces: &mut Pieces,
        pool: Option<&rayon::ThreadPool>,
    ) {
        match section {
            ContactSection::Pairs => self.put_pairs(pieces, pool),
            ContactSection::NearWalls => self.put_near_walls(pieces),
            ContactSection::Friction => self.friction_at_walls().put(pieces.end()),
            ContactSection::Vertices => self.saved_vertices().put(pieces.end()),
        }
    }

    pub(super) fn restore_saved(&mut self, saved: &SavedContacts<'_>) {
        match *saved {
            SavedContacts::Pairs(rows, pairs) => {
                // Of the state before nothing is left: a loop from outside may have made steps.
                self.blocks.clear();
                self.of_sheets.clear();
                self.eventful.clear();
                self.log.clear();
                self.earlier = Reports::default();
                self.restore_pairs(rows, pairs);
            }
            SavedContacts::NearWalls(walls) => self.restore_near_walls(walls),
            SavedContacts::Friction(friction) => self.restore_friction_at_walls(friction),
            SavedContacts::Vertices(vertices) => self.restore_vertices(vertices),
        }
    }

    fn put_pairs(&self, pieces: &mut Pieces, pool: Option<&rayon::ThreadPool>) {
        let nothing = Self::nothing();
        let threads = pool.map_or(1, rayon::ThreadPool::current_num_threads);
        let share = self.blocks.len().div_ceil(threads).max(1);
        let shares = self.blocks.chunks(share).len();
        // In the order in which they are handed over.
        let heads: Vec<_> = (0..shares).map(|_| pieces.memory()).collect();
        let mut stretches: Vec<Stretch> = heads
            .into_iter()
            .map(|heads| Stretch::reusing(heads, pieces.memory()))
            .collect();
        let parts = stretches.iter_mut().zip(self.blocks.chunks(share));
        each_part_by(pool, parts, |(stretch, blocks)| {
            Self::put_blocks(stretch, blocks, &nothing);
        });
        put_stretches(pieces, &nothing, stretches);
    }

    fn put_near_walls(&self, pieces: &mut Pieces) {
        let nothing = Self::nothing();
        let mut stretch = Stretch::reusing(pieces.memory(), pieces.memory());
        let slots = self.blocks.iter().map(|block| block.wall_slots.len()).sum();
        // A sphere at a wall usually has a history there.
        stretch.reserve(slots * MOST_AT_WALL, slots, nothing.len());
        let slots = self.saved_near_walls();
        stretch.extend(&nothing, slots, Histories::<N, T, R, A>::write);
        put_stretches(pieces, &nothing, vec![stretch]);
    }

    fn friction_at_walls(&self) -> Vec<(u32, FrictionNow)> {
        let slots = self.blocks.iter().flat_map(|block| &block.wall_slots);
        let places = (0u32..).zip(slots);
        places
            .filter_map(|(place, slot)| Some((place, slot.friction?)))
            .collect()
    }

    fn restore_friction_at_walls(&mut self, saved: &[(u32, FrictionNow)]) {
        let slots = self.blocks.iter_mut();
        let slots = slots.flat_map(|block| &mut block.wall_slots);
        let mut saved = saved.iter().peekable();
        for (place, slot) in (0u32..).zip(slots) {
            let own = saved.next_if(|(other, _)| *other == place);
            slot.friction = own.map(|(_, friction)| *friction);
        }
    }
}
