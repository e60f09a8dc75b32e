//! The contact loop: every listed pair and every particle near a wall, once, with the laws compiled in.

mod alarming;
mod block;
mod bonds;
mod carry_histories;
mod contact_batch;
mod contact_point;
mod joined;
mod memory;
mod pairs;
mod pass;
mod prefetch;
mod sharing;
mod sheets;
mod sides;
mod sleepers;
mod slots;
mod vertices;
mod walls;
mod watching;

use rayon::prelude::*;

use super::saved::{MOST_AT_WALL, Stretch, most_bytes_of_pairs, put_stretches};
use super::{
    Alarms, Bond, BondPlace, ContactEvent, ContactForces, FeatureKey, FeatureLoad, FeatureLoads,
    Finish, MotionBound, NearWall, Needs, Observation, Rub, SavedLoads, SavedSlot, SavedSlots,
    SlotState, StepContext, block_size,
};
use crate::contact::{
    AdhesionLaw, Bridge, Histories, History, HistoryNumber, NoAdhesion, NormalLaw, PairLaw,
    RollingLaw, TangentialLaw,
};
use crate::neighbours::CandidateList;
use crate::state::{Load, Particle, Particles, Pieces, Row, WallIndex};
use crate::surface::SurfaceLoad;
use block::Block;
use contact_batch::Numbers;
use memory::Memory;
use pass::Pass;
pub(super) use slots::FREE;
use slots::{IMAGE, Slot, WITH_HISTORY};
use vertices::VertexBlocks;

/// The contact loop for one combination of laws.
#[derive(Debug)]
pub struct ContactLoop<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw = NoAdhesion> {
    /// Laws of all pairs of materials, row by row.
    laws: Vec<PairLaw<N, T, R, A>>,
    materials: usize,
    memory: Memory,
    block_size: usize,
    blocks: Vec<Block<Histories<N, T, R, A>>>,
    /// For each block the earlier blocks that reach into it, ascending.
    sources: Vec<Vec<usize>>,
    /// Contacts of the vertices of each sheet with walls, in pieces that threads share.
    of_sheets: Vec<VertexBlocks<Histories<N, T, R, A>>>,
    /// Loads on features of mesh walls from blocks that have been replaced since.
    feature_loads: FeatureLoads,
    /// Working memory of a pass on one thread. It is kept from step to step, because clearing it costs as much as some contacts.
    numbers: Box<Numbers>,
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactLoop<N, T, R, A> {
    /// A loop without slots; [`ContactForces::adopt`] adds them.
    #[must_use]
    pub fn new(laws: Vec<PairLaw<N, T, R, A>>, materials: usize) -> Self {
        Self {
            memory: Memory::of(&laws),
            laws,
            materials,
            block_size: block_size(0),
            blocks: Vec::new(),
            sources: Vec::new(),
            of_sheets: Vec::new(),
            feature_loads: FeatureLoads::default(),
            numbers: Box::new(Numbers::new()),
        }
    }

    /// Gap up to which adhesion acts between any pair of materials, m.
    #[must_use]
    pub fn range(&self) -> f64 {
        let ranges = self.laws.iter().map(|law| law.adhesion.range());
        ranges.fold(0.0, f64::max)
    }

    /// The numbers of an empty history.
    fn nothing() -> Vec<f64> {
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

    /// Cuts `rows` rows into empty blocks.
    fn cut(&mut self, rows: usize) {
        for block in &self.blocks {
            self.feature_loads.merge(&block.feature_loads);
        }
        self.block_size = block_size(rows);
        let count = rows.div_ceil(self.block_size);
        self.blocks = (0..count)
            .map(|index| {
                let first = index * self.block_size;
                let rows = first..rows.min(first + self.block_size);
                Block::empty(rows)
            })
            .collect();
    }

    /// Notes which block reaches into which, once the targets of all blocks are known.
    fn link(&mut self) {
        self.sources = vec![Vec::new(); self.blocks.len()];
        for (index, block) in self.blocks.iter_mut().enumerate() {
            for &target in &block.targets {
                self.sources[target].push(index);
            }
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactForces
    for ContactLoop<N, T, R, A>
{
    fn needs(&self) -> Needs {
        Needs {
            range: self.range(),
            ..Needs::default()
        }
    }

    fn adopt(
        &mut self,
        list: &CandidateList,
        near_walls: &[NearWall],
        new_row: &[Option<Row>],
        parallel: bool,
    ) {
        let rows = list.start.len() - 1;
        let carried = self.carried(new_row, rows, parallel);
        let from_walls = self.carried_from_walls(new_row, parallel);
        let near_meshes = self.carried_near_meshes(new_row, parallel);
        self.cut(rows);
        let block_size = self.block_size;
        let fill = |block: &mut Block<_>| {
            block.fill(list, &carried, near_walls, &from_walls);
            if A::HAS_EVENTS {
                block.note_lost(|row| carried.of(row), &from_walls);
            }
            block.take_over(&near_meshes);
            block.note_targets(block_size);
        };
        if parallel {
            self.blocks.par_iter_mut().for_each(fill);
        } else {
            self.blocks.iter_mut().for_each(fill);
        }
        self.link();
    }

    fn rename_images(&mut self, new_name: &dyn Fn(u32, WallIndex, u32) -> u32) {
        for near in self
            .blocks
            .iter_mut()
            .flat_map(|block| &mut block.near_walls)
        {
            near.image = new_name(near.row, near.wall, near.image);
        }
    }

    fn compute(
        &mut self,
        particles: &mut Particles,
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        finish: &Finish<'_>,
    ) -> MotionBound {
        let Particles {
            records,
            loads,
            ids,
            bodies,
            ..
        } = particles;
        let pass = Pass::new(
            (&self.laws, self.materials),
            (&self.memory, self.block_size),
            (ids, bodies.as_ref()),
            context,
        );
        match pool {
            Some(pool) if self.blocks.len() > 1 => pass.shared(
                &mut self.blocks,
                &self.sources,
                records,
                loads,
                finish,
                pool,
            ),
            _ => pass.in_turn(
                &mut self.blocks,
                &self.sources,
                records,
                loads,
                finish,
                &mut self.numbers,
            ),
        }
    }

    fn settle(
        &mut self,
        particles: &Particles,
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        roused: Option<&[u32]>,
    ) {
        let pass = Pass::new(
            (&self.laws, self.materials),
            (&self.memory, self.block_size),
            (&particles.ids, particles.bodies.as_ref()),
            context,
        );
        let records = &particles.records;
        match roused {
            Some(roused) => pass.release(&mut self.blocks, records, roused),
            None => pass.hold(&mut self.blocks, &self.sources, records, pool),
        }
    }

    fn visit_borders(&self, visit: &mut dyn FnMut(usize)) {
        let rows = self.blocks.iter().flat_map(|block| &block.borders);
        rows.for_each(|&row| visit(row as usize));
    }

    fn mark_disturbed(&self, particles: &Particles, walls: &[bool], disturbed: &mut [bool]) {
        for block in &self.blocks {
            block.mark_disturbed(particles, walls, disturbed);
        }
    }

    fn save_held(&self) -> Vec<Load> {
        let held = |block: &Block<_>| {
            let mut held = block.held.clone();
            held.resize(block.rows.len(), Load::default());
            held
        };
        self.blocks.iter().flat_map(held).collect()
    }

    fn restore_held(&mut self, particles: &Particles, held: &[Load]) {
        for block in &mut self.blocks {
            block.restore_held(&particles.records, held);
        }
    }

    fn take_events(&mut self) -> Vec<ContactEvent> {
        let mut all = Vec::new();
        if A::HAS_EVENTS {
            for (number, block) in (0..).zip(&mut self.blocks) {
                block.take_events(number, &mut all);
            }
        }
        all
    }

    fn bonds(&self, wanted: &dyn Fn(usize) -> bool) -> Vec<Bond> {
        let mut all = Vec::new();
        if A::HAS_EVENTS {
            for (number, block) in (0..).zip(&self.blocks) {
                block.add_bonds(number, wanted, &mut all);
            }
        }
        all
    }

    fn set_bridge(&mut self, place: &BondPlace, bridge: Bridge) {
        if let Some(block) = self.blocks.get_mut(place.block as usize) {
            block.set_bridge(place, bridge);
        }
    }

    fn take_alarms(&mut self) -> Alarms {
        let mut all = Alarms::default();
        for block in &mut self.blocks {
            all.take_from(&mut block.alarms);
        }
        all
    }

    fn observation(&self, walls: usize) -> Observation {
        let mut sum = Observation::empty(walls);
        for block in self.blocks.iter().chain(self.of_sheets.iter().flatten()) {
            sum.merge(&block.observation);
        }
        sum
    }

    fn sums(&self, walls: usize) -> Observation {
        let mut sum = Observation::empty(walls);
        for block in self.blocks.iter().chain(self.of_sheets.iter().flatten()) {
            sum.merge_sums(&block.observation);
        }
        sum
    }

    fn take_observation(&mut self, walls: usize) -> Observation {
        let blocks = &mut self.blocks;
        let of_sheets = &mut self.of_sheets;
        let records = blocks.iter().map(|block| block.observation.records.len());
        let mut sum = Observation::empty(walls);
        sum.records.reserve_exact(records.sum());
        for block in blocks.iter_mut().chain(of_sheets.iter_mut().flatten()) {
            sum.merge(&block.observation);
            block.observation.records = Vec::new();
        }
        sum
    }

    fn take_feature_loads(&mut self) -> Vec<(FeatureKey, FeatureLoad)> {
        let mut all = std::mem::take(&mut self.feature_loads);
        for block in &mut self.blocks {
            all.merge(&std::mem::take(&mut block.feature_loads));
        }
        all.sorted()
    }

    fn save_feature_loads(&self) -> Vec<SavedLoads> {
        let of_blocks = (0..).zip(&self.blocks);
        let all = std::iter::once((None, &self.feature_loads))
            .chain(of_blocks.map(|(index, block)| (Some(index), &block.feature_loads)));
        all.map(|(index, loads)| (index, loads.sorted()))
            .filter(|(_, loads)| !loads.is_empty())
            .collect()
    }

    fn restore_feature_loads(&mut self, saved: &[SavedLoads]) {
        for (index, loads) in saved {
            let place = match index {
                None => Some(&mut self.feature_loads),
                Some(index) => {
                    let block = self.blocks.get_mut(*index as usize);
                    block.map(|block| &mut block.feature_loads)
                }
            };
            if let Some(place) = place {
                loads.iter().for_each(|(key, load)| place.add(*key, load));
            }
        }
    }

    fn take_rubs(&mut self, all: &mut Vec<Rub>) {
        for block in &mut self.blocks {
            all.append(&mut block.rubs);
        }
    }

    fn visit_surface_loads(&self, visit: &mut dyn FnMut(&SurfaceLoad)) {
        let loads = self.blocks.iter().flat_map(|block| &block.surface_loads);
        loads.for_each(visit);
    }

    fn adopt_vertices(&mut self, near_walls: &[Vec<NearWall>]) {
        self.take_near_vertices(near_walls);
    }

    fn compute_vertices(
        &mut self,
        sheet: (usize, usize),
        vertices: &[Particle],
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        loads: &mut [Load],
    ) {
        self.touch_vertices(sheet, vertices, context, pool, loads);
    }

    fn save_vertices(&self) -> Vec<SavedSlots> {
        self.saved_vertices()
    }

    fn restore_vertices(&mut self, saved: &[SavedSlots]) {
        self.restored_vertices(saved);
    }

    fn listed(&self) -> usize {
        self.blocks.iter().map(|block| block.slots.len()).sum()
    }

    fn listed_at_walls(&self) -> usize {
        self.blocks.iter().map(|block| block.wall_slots.len()).sum()
    }

    fn touching(&self) -> usize {
        let slots = self.blocks.iter().flat_map(|block| &block.slots);
        slots.filter(|slot| slot.state & WITH_HISTORY != 0).count()
    }

    fn save(&self) -> (SavedSlots, SavedSlots) {
        let nothing = Self::nothing();
        let (mut pairs, mut walls) = (SavedSlots::new(nothing.clone()), SavedSlots::new(nothing));
        pairs.reserve(self.listed());
        for (slot, history) in Self::saved_pairs(&self.blocks) {
            pairs.push(slot, history, Histories::<N, T, R, A>::write);
        }
        for (slot, history) in self.saved_near_walls() {
            walls.push(slot, history, Histories::<N, T, R, A>::write);
        }
        (pairs, walls)
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
        match pool {
            Some(pool) => pool.install(|| {
                (stretches.par_iter_mut().zip(self.blocks.par_chunks(share)))
                    .for_each(|(stretch, blocks)| Self::put_blocks(stretch, blocks, &nothing));
            }),
            None => (stretches.iter_mut().zip(self.blocks.chunks(share)))
                .for_each(|(stretch, blocks)| Self::put_blocks(stretch, blocks, &nothing)),
        }
        put_stretches(pieces, &nothing, stretches);
    }

    fn put_near_walls(&self, pieces: &mut Pieces) {
        let nothing = Self::nothing();
        let mut stretch = Stretch::reusing(pieces.memory(), pieces.memory());
        let slots = self.listed_at_walls();
        // A sphere at a wall usually has a history there.
        stretch.reserve(slots * MOST_AT_WALL, slots, nothing.len());
        let slots = self.saved_near_walls();
        stretch.extend(&nothing, slots, Histories::<N, T, R, A>::write);
        put_stretches(pieces, &nothing, vec![stretch]);
    }

    fn saved_bytes(&self, rows: f64, slots: f64, remembering: f64) -> f64 {
        let history = <Histories<N, T, R, A>>::LENGTH * size_of::<f64>();
        most_bytes_of_pairs(slots as usize, rows as usize) as f64 + remembering * history as f64
    }

    fn restore(&mut self, rows: usize, pairs: &SavedSlots, walls: &SavedSlots) {
        self.cut(rows);
        let (mut pairs, mut walls) = (pairs.iter().peekable(), walls.iter().peekable());
        for block in &mut self.blocks {
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
            while let Some(saved) = walls.next_if(|saved| (saved.row as usize) < block.rows.end) {
                block.push_saved_at_wall(&saved, <Histories<N, T, R, A>>::read(saved.history));
            }
            block.note_targets(self.block_size);
        }
        self.link();
    }

    fn saved_numbers(&self) -> usize {
        <Histories<N, T, R, A>>::LENGTH
    }

    fn history_columns(&self) -> Vec<HistoryNumber> {
        self.memory.columns.clone()
    }

    fn pair_bytes(&self) -> [usize; 2] {
        let slot = size_of::<Slot<Histories<N, T, R, A>>>();
        match <Histories<N, T, R, A>>::LENGTH {
            0 => [slot, 0],
            _ => [slot, size_of::<(u32, u32, Histories<N, T, R, A>)>()],
        }
    }
}
