//! Blocks that are computed on other ranks: their shares of contacts with rows of this one, histories that change their rank, and contacts for a
//! checkpoint.
//!
//! A block of another rank is an empty shell here. Its outbox has the targets that lie on this rank, so that what it sends is delivered like
//! what a block of this rank has parked.

use std::ops::Range;

use super::block::Block;
use super::carry_histories::CarriedFromWall;
use super::slots::{IMAGE, Slot, WallSlot};
use super::{ContactLoop, ContactSection};
use crate::contact::{
    AdhesionLaw, FrictionNow, Histories, History, NormalLaw, RollingLaw, TangentialLaw,
};
use crate::forces::blocks::Outbox;
use crate::forces::{FeatureKey, FeatureLoad, FeatureLoads, Observation, SavedSlots};
use crate::ranks::Across;
use crate::state::{Pieces, Plain, WallIndex};

/// A history of a pair by its new rows, the lower one first.
pub(super) type PairHistory<H> = (u32, u32, H);

/// The bytes for each rank of values that go to the rank of a row.
fn by_rank<T>(
    across: &Across<'_>,
    block_size: usize,
    values: impl IntoIterator<Item = (u32, T)>,
    put: impl Fn(u32, T, &mut Vec<u8>),
) -> Vec<Vec<u8>> {
    let mut out = vec![Vec::new(); across.cut.len() - 1];
    for (row, value) in values {
        let block = row as usize / block_size;
        put(row, value, &mut out[across.rank_of(block)]);
    }
    out
}

pub(super) fn put_history<H: History>(history: &H, numbers: &mut Vec<f64>, bytes: &mut Vec<u8>) {
    numbers.clear();
    history.write(numbers);
    bytes.extend_from_slice(bytemuck::cast_slice(numbers));
}

pub(super) fn take_history<H: History>(bytes: &mut &[u8]) -> Option<H> {
    let (front, rest) = bytes.split_at_checked(H::LENGTH * size_of::<f64>())?;
    *bytes = rest;
    Some(H::read(&bytemuck::pod_collect_to_vec::<u8, f64>(front)))
}

/// Sends histories of pairs to the ranks of their lower rows, and returns those that have come here.
pub(super) fn send_pairs<H: History>(
    across: &mut Across<'_>,
    block_size: usize,
    leaving: Vec<PairHistory<H>>,
) -> Vec<PairHistory<H>> {
    let leaving = leaving
        .into_iter()
        .map(|(row, partner, history)| (row, (partner, history)));
    let out = by_rank(
        across,
        block_size,
        leaving,
        |row, (partner, history), bytes| {
            (row, partner).put(bytes);
            put_history(&history, &mut Vec::new(), bytes);
        },
    );
    let mut came = Vec::new();
    for bytes in (across.exchange)(out) {
        let mut bytes = &bytes[..];
        while let Ok((row, partner)) = <(u32, u32)>::take(&mut bytes)
            && let Some(history) = take_history(&mut bytes)
        {
            came.push((row, partner, history));
        }
    }
    came
}

/// Sends slots at walls to the ranks of their rows, and returns those that have come here.
pub(super) fn send_from_walls<H: History>(
    across: &mut Across<'_>,
    block_size: usize,
    leaving: Vec<CarriedFromWall<H>>,
) -> Vec<CarriedFromWall<H>> {
    let leaving = leaving.into_iter().map(|carried| (carried.0.0, carried));
    let out = by_rank(
        across,
        block_size,
        leaving,
        |row, ((_, wall, image), slot), bytes| {
            (row, (wall.number(), image)).put(bytes);
            (slot.feature, slot.state).put(bytes);
            slot.friction.put(bytes);
            put_history(&slot.history, &mut Vec::new(), bytes);
        },
    );
    let mut came = Vec::new();
    for bytes in (across.exchange)(out) {
        let mut bytes = &bytes[..];
        while let Ok((row, (wall, image))) = <(u32, (u16, u32))>::take(&mut bytes)
            && let Ok((feature, state)) = Plain::take(&mut bytes)
            && let Ok(friction) = Plain::take(&mut bytes)
            && let Some(history) = take_history(&mut bytes)
        {
            let slot = WallSlot {
                feature,
                state,
                history,
                friction,
            };
            came.push(((row, WallIndex::new(wall), image), slot));
        }
    }
    came
}

/// The shares that own blocks have parked for each rank, source by source, target by target.
pub(super) fn parked_for_ranks<'b, H: 'b>(
    across: &Across<'_>,
    own: impl Iterator<Item = &'b Block<H>>,
) -> Vec<Vec<u8>> {
    let mut out = vec![Vec::new(); across.cut.len() - 1];
    for block in own {
        for target in &block.outbox.targets {
            let rank = across.rank_of(target.block);
            if rank != across.rank {
                target.put(&mut out[rank]);
            }
        }
    }
    out
}

/// Puts shares that have come from the rank of some shells into these.
pub(super) fn take_parked<'b, H: 'b>(
    shells: impl Iterator<Item = &'b mut Block<H>>,
    mut bytes: &[u8],
) {
    for shell in shells {
        for target in &mut shell.outbox.targets {
            target.take(&mut bytes);
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactLoop<N, T, R, A> {
    /// The blocks of this rank.
    pub(super) fn own_blocks(&self) -> &[Block<Histories<N, T, R, A>>] {
        &self.blocks[self.own.clone()]
    }

    /// The blocks of other ranks.
    fn shells(&mut self) -> impl Iterator<Item = &mut Block<Histories<N, T, R, A>>> {
        let own = self.own.clone();
        let blocks = self.blocks.iter_mut().enumerate();
        blocks
            .filter(move |(number, _)| !own.contains(number))
            .map(|(_, block)| block)
    }

    /// Keeps the blocks of this rank alone, and notes which blocks of earlier ranks reach into them.
    pub(super) fn keep_own_blocks(&mut self, across: Across<'_>) {
        self.own = across.own();
        for shell in self.shells() {
            *shell = Block::empty(shell.rows.clone());
        }
        let mut out = vec![Vec::new(); across.cut.len() - 1];
        for (number, block) in self.own.clone().zip(self.own_blocks()) {
            for target in &block.outbox.targets {
                let rank = across.rank_of(target.block);
                if rank != across.rank {
                    (number as u32, target.block as u32).put(&mut out[rank]);
                }
            }
        }
        let block_size = self.block_size;
        for bytes in (across.exchange)(out) {
            let mut bytes = &bytes[..];
            let mut links = Vec::new();
            while let Ok((source, target)) = <(u32, u32)>::take(&mut bytes) {
                links.push((source as usize, target as usize));
            }
            for of_source in links.chunk_by(|one, other| one.0 == other.0) {
                let source = of_source[0].0;
                let partners = of_source.iter().map(|(_, target)| target * block_size);
                self.blocks[source].outbox = Outbox::of(source, partners, block_size);
            }
        }
        self.link();
    }

    /// Rows of later ranks that pairs of this one read, ascending.
    pub(super) fn rows_of_others(&self) -> Vec<u32> {
        let Some(end) = self.own_blocks().last().map(|block| block.rows.end) else {
            return Vec::new();
        };
        let slots = self.own_blocks().iter().flat_map(|block| &block.slots);
        let partners = slots.map(|slot| slot.partner);
        let mut rows: Vec<u32> = partners.filter(|&row| row as usize >= end).collect();
        rows.sort_unstable();
        rows.dedup();
        rows
    }

    /// Appends what own blocks have observed.
    pub(super) fn put_own_observations(&self, bytes: &mut Vec<u8>) {
        for block in self.own_blocks() {
            block.reports.observation.put(bytes);
        }
    }

    /// Takes what the blocks of another rank have observed.
    pub(super) fn take_observations(
        &mut self,
        blocks: Range<usize>,
        bytes: &mut &[u8],
    ) -> Result<(), String> {
        for block in &mut self.blocks[blocks] {
            block.reports.observation = Observation::take(bytes)?;
        }
        Ok(())
    }

    /// Appends the loads on features of mesh walls in own blocks.
    pub(super) fn put_own_feature_loads(&self, bytes: &mut Vec<u8>) {
        for block in self.own_blocks() {
            block.reports.feature_loads.sorted().put(bytes);
        }
    }

    /// Takes the loads in the blocks of another rank in place of those that it had before.
    pub(super) fn take_feature_loads(
        &mut self,
        blocks: Range<usize>,
        bytes: &mut &[u8],
    ) -> Result<(), String> {
        for block in &mut self.blocks[blocks] {
            let loads: Vec<(FeatureKey, FeatureLoad)> = Plain::take(bytes)?;
            let sums = &mut block.reports.feature_loads;
            *sums = FeatureLoads::default();
            loads.iter().for_each(|(key, load)| sums.add(*key, load));
        }
        Ok(())
    }

    /// Appends all contacts of own blocks.
    pub(super) fn put_own_contacts(&self, bytes: &mut Vec<u8>) {
        for section in [ContactSection::Pairs, ContactSection::NearWalls] {
            let mut pieces = Pieces::default();
            self.put_section(section, &mut pieces, None);
            pieces.into_bytes().put(bytes);
        }
        let slots = self.own_blocks().iter().flat_map(|block| &block.wall_slots);
        let friction: Vec<Option<FrictionNow>> = slots.map(|slot| slot.friction).collect();
        friction.put(bytes);
    }

    /// Fills the shells of another rank with its contacts, until the next list or checkpoint.
    pub(super) fn take_contacts(
        &mut self,
        blocks: Range<usize>,
        bytes: &mut &[u8],
    ) -> Result<(), String> {
        let of_section = |bytes: &mut &[u8]| SavedSlots::take(&mut &Vec::<u8>::take(bytes)?[..]);
        let (pairs, walls) = (of_section(bytes)?, of_section(bytes)?);
        for saved in pairs.iter() {
            let block = &mut self.blocks[saved.row as usize / self.block_size];
            let owner = saved.row as usize - block.rows.start;
            let history = <Histories<N, T, R, A>>::read(saved.history);
            let state = saved.state.bits();
            let slot = Slot::new(owner, saved.partner, saved.image & IMAGE, state, history);
            block.slots.push(slot);
        }
        for saved in walls.iter() {
            let block = &mut self.blocks[saved.row as usize / self.block_size];
            block.push_saved_at_wall(&saved, <Histories<N, T, R, A>>::read(saved.history));
        }
        let friction: Vec<Option<FrictionNow>> = Plain::take(bytes)?;
        let slots = (self.blocks[blocks].iter_mut()).flat_map(|block| &mut block.wall_slots);
        for (slot, friction) in slots.zip(friction) {
            slot.friction = friction;
        }
        Ok(())
    }

    /// Empties shells that were filled.
    pub(super) fn empty_shells(&mut self) {
        for shell in self.shells() {
            shell.slots.clear();
            shell.near_walls.clear();
            shell.wall_slots.clear();
        }
    }
}
