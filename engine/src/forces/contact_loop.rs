//! The contact loop: every listed pair and every particle near a wall, once, with the laws compiled in.

mod across;
mod alarming;
mod block;
mod carry_histories;
mod contact_batch;
mod contact_point;
mod glued;
mod joined;
mod memory;
mod pairs;
mod pass;
mod prefetch;
mod saving;
mod separated;
mod sharing;
mod sheets;
mod sides;
mod slot_events;
mod slots;
mod touch_wall;
mod vertices;
mod walls;
mod watching;

use std::any::Any;
use std::ops::Range;

use super::blocks::Source;
use super::{
    ContactEvent, ContactForces, ContactMemory, ContactSection, Finish, HistoryLayout, MotionBound,
    NearWall, OfBlocks, Reports, SavedContacts, SlotPlace, StepContext, ToAllRanks, block_size,
};
use crate::contact::{
    AdhesionLaw, EventOf, Histories, History, LawEvents, MemoryOf, NoAdhesion, NormalLaw, PairLaw,
    RollingLaw, TangentialLaw,
};
use crate::neighbours::CandidateList;
use crate::parallel::each_part;
use crate::ranks::Across;
use crate::state::{Load, Particle, Particles, Pieces, Row, WallIndex};
use block::Block;
use contact_batch::BatchColumns;
use memory::Memory;
use pass::Pass;
use slot_events::of_all_ranks;
pub(super) use slots::FREE;
use slots::{Slot, WITH_HISTORY};
use vertices::VertexBlocks;
pub(super) use walls::held_depth;

/// The contact loop for one combination of laws.
#[derive(Debug)]
pub struct ContactLoop<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw = NoAdhesion> {
    /// Laws of all pairs of materials, row by row.
    laws: Vec<PairLaw<N, T, R, A>>,
    materials: usize,
    memory: Memory,
    block_size: usize,
    blocks: Vec<Block<Histories<N, T, R, A>>>,
    /// The blocks that are computed here; the others are those of other ranks.
    own: Range<usize>,
    /// For each block the earlier blocks that reach into it, ascending.
    sources: Vec<Vec<Source>>,
    /// Contacts of the vertices of each sheet with walls, in pieces that threads share.
    of_sheets: Vec<VertexBlocks<Histories<N, T, R, A>>>,
    /// Loads on features of mesh walls from blocks that have been replaced since.
    earlier: Reports,
    /// Working memory of a pass on one thread. It is kept from step to step, because clearing it costs as much as some contacts.
    numbers: Box<BatchColumns>,
    /// Contacts with an event in the last force evaluation, or in the list before it.
    eventful: Vec<ContactMemory<A::History<f64>>>,
    /// Their events.
    log: Vec<ContactEvent<EventOf<A>, MemoryOf<A>>>,
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
            own: 0..0,
            sources: Vec::new(),
            of_sheets: Vec::new(),
            earlier: Reports::default(),
            numbers: Box::new(BatchColumns::new()),
            eventful: Vec::new(),
            log: Vec::new(),
        }
    }

    /// Cuts `rows` rows into empty blocks.
    fn cut(&mut self, rows: usize) {
        for block in &self.blocks {
            let loads = &block.reports.feature_loads;
            self.earlier.feature_loads.merge(loads);
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
        self.own = 0..count;
    }

    /// Notes which block reaches into which, once the targets of all blocks are known.
    fn link(&mut self) {
        self.sources = vec![Vec::new(); self.blocks.len()];
        for (index, block) in self.blocks.iter().enumerate() {
            for (target, to) in block.outbox.targets.iter().enumerate() {
                let block = index;
                self.sources[to.block].push(Source { block, target });
            }
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactForces
    for ContactLoop<N, T, R, A>
{
    fn ranges(&self) -> Vec<f64> {
        let of_each = self.laws.chunks(self.materials.max(1)).map(|laws| {
            let ranges = laws.iter().map(|law| law.adhesion.range());
            ranges.fold(0.0, f64::max)
        });
        let ranges: Vec<f64> = of_each.collect();
        if ranges.iter().any(|range| *range > 0.0) {
            ranges
        } else {
            Vec::new()
        }
    }

    fn layout(&self) -> HistoryLayout {
        let numbers = <Histories<N, T, R, A>>::LENGTH;
        HistoryLayout {
            numbers,
            columns: self.memory.columns.clone(),
            slot: size_of::<Slot<Histories<N, T, R, A>>>(),
            carried: match numbers {
                0 => 0,
                _ => size_of::<(u32, u32, Histories<N, T, R, A>)>(),
            },
        }
    }

    fn adopt(
        &mut self,
        list: &CandidateList,
        near_walls: &[NearWall],
        new_row: &[Option<Row>],
        mut across: Option<Across<'_>>,
        parallel: bool,
    ) {
        let rows = list.start.len() - 1;
        let carried = self.carried(new_row, rows, across.as_mut(), parallel);
        let from_walls = self.carried_from_walls(new_row, rows, across.as_mut(), parallel);
        let near_meshes = self.carried_near_meshes(new_row, parallel);
        self.cut(rows);
        if let Some(across) = &across {
            self.own = across.own();
        }
        let block_size = self.block_size;
        let fill = |block: &mut Block<_>| {
            block.fill(list, &carried, near_walls, &from_walls);
            if A::HAS_EVENTS {
                let ends = |history: &Histories<N, T, R, A>| A::Events::end(&history.3).is_some();
                block.note_lost(|row| carried.of(row), &from_walls, ends);
            }
            block.take_over(&near_meshes);
            block.note_targets(block_size);
        };
        each_part(parallel, &mut self.blocks[self.own.clone()], fill);
        match across {
            Some(across) => self.keep_own_blocks(across),
            None => self.link(),
        }
    }

    fn keep_own(&mut self, across: Across<'_>) {
        if across.rank > 0 {
            self.earlier = Reports::default();
        }
        self.keep_own_blocks(across);
    }

    fn read_rows(&self) -> Vec<u32> {
        self.rows_of_others()
    }

    fn put_own(&self, what: OfBlocks, bytes: &mut Vec<u8>) {
        match what {
            OfBlocks::Contacts => self.put_own_contacts(bytes),
            OfBlocks::Observations => self.put_own_observations(bytes),
            OfBlocks::FeatureLoads => self.put_own_feature_loads(bytes),
        }
    }

    fn take_others(
        &mut self,
        what: OfBlocks,
        blocks: Range<usize>,
        bytes: &mut &[u8],
    ) -> Result<(), String> {
        match what {
            OfBlocks::Contacts => self.take_contacts(blocks, bytes),
            OfBlocks::Observations => self.take_observations(blocks, bytes),
            OfBlocks::FeatureLoads => self.take_feature_loads(blocks, bytes),
        }
    }

    fn forget_others(&mut self) {
        self.empty_shells();
    }

    fn own_reports(&self, vertices: bool) -> Vec<&Reports> {
        let blocks = self.own_blocks().iter();
        let of_vertices = self.of_sheets.iter().flatten().filter(|_| vertices);
        let blocks = blocks.chain(of_vertices);
        blocks.map(|block| &block.reports).collect()
    }

    fn adopt_vertices(&mut self, near_walls: &[Vec<NearWall>]) {
        self.take_near_vertices(near_walls);
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
        across: Option<Across<'_>>,
    ) -> MotionBound {
        let Particles {
            records,
            loads,
            ids,
            bodies,
            films,
            ..
        } = particles;
        let pass = Pass::new(
            (&self.laws, self.materials),
            &self.memory,
            (ids, bodies.as_ref(), films.as_deref()),
            context,
        );
        let own = self.own.clone();
        let fastest = match pool {
            Some(pool) if own.len() > 1 => pass.shared(
                &mut self.blocks,
                own,
                &self.sources,
                records,
                loads,
                finish,
                across,
                pool,
            ),
            _ => pass.in_turn(
                &mut self.blocks,
                own,
                &self.sources,
                records,
                loads,
                finish,
                across,
                &mut self.numbers,
            ),
        };
        if A::HAS_EVENTS {
            self.eventful.clear();
            for (number, block) in (0..).zip(&mut self.blocks) {
                block.take_eventful(number, &mut self.eventful);
            }
            self.log_events();
        }
        fastest
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

    fn count(&self) -> [usize; 2] {
        let slots = self.own_blocks().iter().flat_map(|block| &block.slots);
        let listed = (self.own_blocks().iter())
            .map(|block| block.slots.len())
            .sum();
        let held = slots.filter(|slot| slot.state & WITH_HISTORY != 0);
        [listed, held.count()]
    }

    fn events(&self) -> &dyn Any {
        &self.log
    }

    fn join_events(&mut self, to_all: &mut ToAllRanks<'_>) {
        self.eventful = of_all_ranks(&self.eventful, to_all);
        self.log_events();
    }

    fn memories(
        &self,
        wanted: &dyn Fn(usize) -> bool,
        to_all: Option<&mut ToAllRanks<'_>>,
    ) -> Box<dyn Any> {
        let mut all = Vec::new();
        if A::HAS_EVENTS {
            for (number, block) in (0..).zip(&self.blocks) {
                block.add_memories::<A>(number, wanted, &mut all);
            }
            if let Some(to_all) = to_all {
                all = of_all_ranks(&all, to_all);
            }
        }
        let all = all.iter().map(ContactMemory::shared::<A>);
        Box::new(all.collect::<Vec<_>>())
    }

    fn reports(&self) -> Vec<&Reports> {
        let blocks = self.blocks.iter().chain(self.of_sheets.iter().flatten());
        let reports = blocks.map(|block| &block.reports);
        std::iter::once(&self.earlier).chain(reports).collect()
    }

    fn reports_mut(&mut self) -> Vec<&mut Reports> {
        let of_sheets = self.of_sheets.iter_mut().flatten();
        let blocks = self.blocks.iter_mut().chain(of_sheets);
        let reports = blocks.map(|block| &mut block.reports);
        std::iter::once(&mut self.earlier).chain(reports).collect()
    }

    fn put(&self, section: ContactSection, pieces: &mut Pieces, pool: Option<&rayon::ThreadPool>) {
        self.put_section(section, pieces, pool);
    }

    fn restore(&mut self, saved: &SavedContacts<'_>) {
        self.restore_saved(saved);
    }

    fn set_memory(&mut self, place: &SlotPlace, memory: &dyn Any) {
        if self.own.contains(&(place.block as usize))
            && let Some(block) = self.blocks.get_mut(place.block as usize)
            && let Some(memory) = memory.downcast_ref()
        {
            block.set_memory::<A>(place, memory);
        }
    }
}
