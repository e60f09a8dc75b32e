//! The contact loop: every listed pair and every particle near a wall, once, with the laws compiled in.

mod pairs;
mod walls;
mod watching;

use std::ops::Range;

use rayon::prelude::*;

use super::blocks::Outbox;
use super::{
    ContactForces, Fastest, Finish, NO_MESH, NearMeshes, NearWall, NearWalls, Observation, Partner,
    SavedSlot, StepContext, block_size,
};
use crate::contact::{History, HistoryNumber, NormalLaw, PairLaw, RollingLaw, TangentialLaw};
use crate::neighbours::CandidateList;
use crate::particles::{Load, Particle, Particles};

type Histories<N, T, R> = (
    <N as NormalLaw>::History,
    <T as TangentialLaw>::History,
    <R as RollingLaw>::History,
);

/// A listed pair with its history.
#[derive(Debug, Clone, Copy)]
struct Slot<H> {
    /// Row of the partner.
    partner: u32,
    /// Image code of the partner, [`TOUCHING`], and the owner.
    state: u32,
    history: H,
}

/// Set in [`Slot::state`] while the two touch.
const TOUCHING: u32 = 1 << 8;
/// The image code's bits in [`Slot::state`].
const IMAGE: u32 = TOUCHING - 1;
/// The row within the block that owns the slot stands in the upper half of [`Slot::state`].
const OWNER_SHIFT: u32 = 16;

impl<H> Slot<H> {
    /// Row of the owner within the block.
    #[inline(always)]
    fn owner(&self) -> usize {
        (self.state >> OWNER_SHIFT) as usize
    }
}

/// A feature of a wall that a particle touches, with its history.
#[derive(Debug, Clone, Copy)]
struct WallSlot<H> {
    /// Feature of the wall; [`FREE`] while the slot holds no contact.
    feature: u32,
    history: H,
}

const FREE: u32 = u32::MAX;

impl<H: History> WallSlot<H> {
    /// Without a contact.
    fn free() -> Self {
        Self {
            feature: FREE,
            history: H::default(),
        }
    }

    /// The contact has ended.
    #[inline(always)]
    fn clear(&mut self) {
        if self.feature != FREE {
            *self = Self::free();
        }
    }
}

/// A block of consecutive rows with the slots that they own.
#[derive(Debug)]
struct Block<H> {
    rows: Range<usize>,
    /// In the order of their owners.
    slots: Vec<Slot<H>>,
    near_walls: Vec<NearWall>,
    /// `features` slots for each entry of `near_walls`.
    wall_slots: Vec<WallSlot<H>>,
    /// Facets for those of `near_walls` that are near a mesh.
    near_meshes: NearMeshes,
    outbox: Outbox,
    observation: Observation,
}

impl<H: History> Block<H> {
    /// Fills an empty block with the listed pairs and the walls near its rows; `carried` and `from_walls` are the histories
    /// of contacts that go on, sorted by row.
    fn fill(
        &mut self,
        list: &CandidateList,
        carried: &[(u32, u32, H)],
        near_walls: &NearWalls,
        from_walls: &[CarriedFromWall<H>],
    ) {
        let first = self.rows.start as u32;
        let mut carried = &carried[carried.partition_point(|kept| kept.0 < first)..];
        for (owner, row) in self.rows.clone().enumerate() {
            let entries = &list.entries[list.start[row] as usize..list.start[row + 1] as usize];
            // What this row carries lies in one run, in no particular relation to the order of its entries.
            let run = carried
                .iter()
                .take_while(|kept| kept.0 == row as u32)
                .count();
            let (kept, rest) = carried.split_at(run);
            carried = rest;
            for entry in entries {
                let history = kept
                    .iter()
                    .find(|kept| kept.1 == entry.partner)
                    .map(|kept| kept.2);
                let touching = if history.is_some() { TOUCHING } else { 0 };
                self.slots.push(Slot {
                    partner: entry.partner,
                    state: entry.image | touching | (owner as u32) << OWNER_SHIFT,
                    history: history.unwrap_or_default(),
                });
            }
        }
        let near = &near_walls.near;
        let begin = near.partition_point(|near| near.row < first);
        let end = near.partition_point(|near| (near.row as usize) < self.rows.end);
        for near in &near[begin..end] {
            let key = (near.row, near.wall, near.image);
            let run = from_walls.partition_point(|kept| kept.0 < key);
            let mut kept = from_walls[run..].iter().take_while(|kept| kept.0 == key);
            // As many slots as features may be touched, and no fewer than hold a history.
            let held = kept.clone().count().max(near.features as usize);
            self.near_walls.push(NearWall {
                features: held as u8,
                mesh: match near.mesh {
                    NO_MESH => NO_MESH,
                    mesh => {
                        let (centre, facets) = near_walls.meshes.list(mesh);
                        self.near_meshes.push(centre, facets)
                    }
                },
                ..*near
            });
            for _ in 0..held {
                let slot = kept.next().map(|kept| kept.1);
                self.wall_slots.push(slot.unwrap_or(WallSlot::free()));
            }
        }
    }
}

/// The loop over contacts for one combination of laws.
#[derive(Debug)]
pub struct ContactLoop<N: NormalLaw, T: TangentialLaw, R: RollingLaw> {
    /// Laws of all pairs of materials, row by row.
    laws: Vec<PairLaw<N, T, R>>,
    materials: usize,
    block_size: usize,
    blocks: Vec<Block<Histories<N, T, R>>>,
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw> ContactLoop<N, T, R> {
    /// Without slots; [`ContactForces::adopt`] brings them.
    #[must_use]
    pub fn new(laws: Vec<PairLaw<N, T, R>>, materials: usize) -> Self {
        Self {
            laws,
            materials,
            block_size: block_size(0),
            blocks: Vec::new(),
        }
    }

    /// Cuts `rows` rows into empty blocks.
    fn cut(&mut self, rows: usize) {
        self.block_size = block_size(rows);
        let count = rows.div_ceil(self.block_size);
        self.blocks = (0..count)
            .map(|index| {
                let first = index * self.block_size;
                Block {
                    rows: first..rows.min(first + self.block_size),
                    slots: Vec::new(),
                    near_walls: Vec::new(),
                    wall_slots: Vec::new(),
                    near_meshes: NearMeshes::default(),
                    outbox: Outbox::new(count - 1 - index),
                    observation: Observation::default(),
                }
            })
            .collect();
    }

    /// Histories of touching pairs by their new rows, lower row first, in no order.
    fn carried(&self, new_row: &[u32]) -> Vec<(u32, u32, Histories<N, T, R>)> {
        let mut carried = Vec::new();
        if <Histories<N, T, R>>::LENGTH == 0 {
            return carried;
        }
        for block in &self.blocks {
            for slot in block.slots.iter().filter(|slot| slot.state & TOUCHING != 0) {
                let row = new_row[block.rows.start + slot.owner()];
                let partner = new_row[slot.partner as usize];
                if row != u32::MAX && partner != u32::MAX {
                    carried.push(if row < partner {
                        (row, partner, slot.history)
                    } else {
                        (partner, row, slot.history.swapped())
                    });
                }
            }
        }
        carried
    }

    /// Wall histories by new row, wall and image.
    fn carried_from_walls(&self, new_row: &[u32]) -> Vec<CarriedFromWall<Histories<N, T, R>>> {
        let mut carried = Vec::new();
        for block in &self.blocks {
            let mut first = 0;
            for near in &block.near_walls {
                let row = new_row[near.row as usize];
                for slot in &block.wall_slots[first..first + near.features as usize] {
                    if slot.feature != FREE && row != u32::MAX {
                        carried.push(((row, near.wall, near.image), *slot));
                    }
                }
                first += near.features as usize;
            }
        }
        carried.sort_by_key(|&(key, _)| key);
        carried
    }
}

type CarriedFromWall<H> = ((u32, u16, u8), WallSlot<H>);

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw> ContactForces for ContactLoop<N, T, R> {
    fn adopt(
        &mut self,
        list: &CandidateList,
        near_walls: &NearWalls,
        new_row: &[u32],
        parallel: bool,
    ) {
        let mut carried = self.carried(new_row);
        let key = |kept: &(u32, u32, _)| (kept.0, kept.1);
        if parallel {
            carried.par_sort_unstable_by_key(key);
        } else {
            carried.sort_unstable_by_key(key);
        }
        let from_walls = self.carried_from_walls(new_row);
        self.cut(list.start.len() - 1);
        let fill = |block: &mut Block<_>| block.fill(list, &carried, near_walls, &from_walls);
        if parallel {
            self.blocks.par_iter_mut().for_each(fill);
        } else {
            self.blocks.iter_mut().for_each(fill);
        }
    }

    fn compute(
        &mut self,
        particles: &mut Particles,
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        finish: &Finish<'_>,
    ) -> Fastest {
        let size = self.block_size;
        let (laws, materials) = (&self.laws[..], self.materials);
        let Particles {
            records,
            loads,
            ids,
            ..
        } = particles;
        let ids = &ids[..];
        let compute = |block: &mut Block<_>, records: &[Particle], loads: &mut [Load]| {
            let pass = Pass {
                laws,
                materials,
                block_size: size,
                records,
                ids,
                context,
            };
            match (context.images.any(), context.watch) {
                (false, None) => pass.run::<false, false>(block, loads),
                (false, Some(_)) => pass.run::<false, true>(block, loads),
                (true, None) => pass.run::<true, false>(block, loads),
                (true, Some(_)) => pass.run::<true, true>(block, loads),
            }
        };
        match pool {
            Some(pool) if self.blocks.len() > 1 => pool.install(|| {
                let with_loads = self.blocks.par_iter_mut().zip(loads.par_chunks_mut(size));
                with_loads.for_each(|(block, loads)| compute(block, records, loads));
                let blocks = &self.blocks;
                let chunks = records.par_chunks_mut(size).zip(loads.par_chunks_mut(size));
                chunks
                    .enumerate()
                    .map(|(index, (records, loads))| {
                        deliver(&blocks[..index], loads);
                        finish(records, loads)
                    })
                    .reduce(Fastest::default, Fastest::merge)
            }),
            // Later blocks read neither the records nor the loads of earlier ones, so a block can be finished at once.
            _ => (0..self.blocks.len())
                .map(|index| {
                    let (earlier, rest) = self.blocks.split_at_mut(index);
                    let block = &mut rest[0];
                    let loads = &mut loads[block.rows.clone()];
                    compute(block, records, loads);
                    deliver(earlier, loads);
                    finish(&mut records[block.rows.clone()], loads)
                })
                .fold(Fastest::default(), Fastest::merge),
        }
    }

    fn observation(&self, walls: usize) -> Observation {
        let mut sum = Observation::empty(walls);
        for block in &self.blocks {
            sum.merge(&block.observation);
        }
        sum
    }

    fn listed(&self) -> usize {
        self.blocks.iter().map(|block| block.slots.len()).sum()
    }

    fn touching(&self) -> usize {
        let slots = self.blocks.iter().flat_map(|block| &block.slots);
        slots.filter(|slot| slot.state & TOUCHING != 0).count()
    }

    fn save(&self) -> (Vec<SavedSlot>, Vec<SavedSlot>) {
        let numbers = |history: &Histories<N, T, R>| {
            let mut numbers = Vec::new();
            history.write(&mut numbers);
            numbers
        };
        let (mut pairs, mut walls) = (Vec::new(), Vec::new());
        for block in &self.blocks {
            for slot in &block.slots {
                pairs.push(SavedSlot {
                    row: (block.rows.start + slot.owner()) as u32,
                    partner: slot.partner,
                    image: slot.state & IMAGE,
                    touching: slot.state & TOUCHING != 0,
                    feature: FREE,
                    history: numbers(&slot.history),
                    near_mesh: None,
                });
            }
            let mut first = 0;
            for near in &block.near_walls {
                let slots = &block.wall_slots[first..first + near.features as usize];
                for (k, slot) in slots.iter().enumerate() {
                    let near_mesh = (k == 0 && near.mesh != NO_MESH).then(|| {
                        let (centre, facets) = block.near_meshes.list(near.mesh);
                        (centre, facets.to_vec())
                    });
                    walls.push(SavedSlot {
                        row: near.row,
                        partner: u32::from(near.wall),
                        image: u32::from(near.image),
                        touching: slot.feature != FREE,
                        feature: slot.feature,
                        history: numbers(&slot.history),
                        near_mesh,
                    });
                }
                first += near.features as usize;
            }
        }
        (pairs, walls)
    }

    fn restore(&mut self, rows: usize, pairs: &[SavedSlot], walls: &[SavedSlot]) {
        self.cut(rows);
        let (mut next, mut next_wall) = (0, 0);
        for block in &mut self.blocks {
            for (owner, row) in block.rows.clone().enumerate() {
                while next < pairs.len() && pairs[next].row as usize == row {
                    let saved = &pairs[next];
                    let touching = if saved.touching { TOUCHING } else { 0 };
                    block.slots.push(Slot {
                        partner: saved.partner,
                        state: saved.image | touching | (owner as u32) << OWNER_SHIFT,
                        history: <Histories<N, T, R>>::read(&saved.history),
                    });
                    next += 1;
                }
            }
            while next_wall < walls.len() && (walls[next_wall].row as usize) < block.rows.end {
                let saved = &walls[next_wall];
                next_wall += 1;
                let same = |last: &NearWall| {
                    (last.row, u32::from(last.wall), u32::from(last.image))
                        == (saved.row, saved.partner, saved.image)
                };
                match block.near_walls.last_mut() {
                    Some(last) if same(last) => last.features += 1,
                    _ => block.near_walls.push(NearWall {
                        row: saved.row,
                        wall: saved.partner as u16,
                        image: saved.image as u8,
                        features: 1,
                        mesh: match &saved.near_mesh {
                            Some((centre, facets)) => block.near_meshes.push(*centre, facets),
                            None => NO_MESH,
                        },
                    }),
                }
                block.wall_slots.push(WallSlot {
                    feature: saved.feature,
                    history: <Histories<N, T, R>>::read(&saved.history),
                });
            }
        }
    }

    fn history_columns(&self) -> Vec<HistoryNumber> {
        <Histories<N, T, R>>::columns()
    }

    fn slot_bytes(&self) -> usize {
        size_of::<Slot<Histories<N, T, R>>>()
    }
}

/// Adds what earlier blocks parked for the block that follows them, in their order.
fn deliver<H>(earlier: &[Block<H>], loads: &mut [Load]) {
    for (index, block) in earlier.iter().enumerate() {
        block.outbox.deliver(earlier.len() - 1 - index, loads);
    }
}

/// What all blocks of one force evaluation share.
struct Pass<'a, N, T, R> {
    laws: &'a [PairLaw<N, T, R>],
    materials: usize,
    block_size: usize,
    records: &'a [Particle],
    ids: &'a [u32],
    context: &'a StepContext<'a>,
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw> Pass<'_, N, T, R> {
    /// Contacts of one block: loads of its own rows at once, those of later blocks into its outbox.
    fn run<const PERIODIC: bool, const WATCHED: bool>(
        &self,
        block: &mut Block<Histories<N, T, R>>,
        loads: &mut [Load],
    ) {
        loads.fill(Load::default());
        block.outbox.clear();
        if WATCHED {
            block.observation = Observation::empty(self.context.walls.len());
        }
        self.pairs::<PERIODIC, WATCHED>(block, loads);
        self.walls::<WATCHED>(block, loads);
    }
}

/// A contact that is being observed.
struct Seen {
    row: usize,
    partner: Partner,
    /// Feature of the wall.
    feature: u32,
    /// R_A - overlap/2, m.
    lever: f64,
    /// Overlap over the smaller radius.
    depth: f64,
}
