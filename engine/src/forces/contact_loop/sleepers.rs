//! Contacts among sleepers.
//!
//! Sleepers do not move, so the loads that sleepers, fixed particles and walls at rest exert on one another stay the same: they
//! are summed up once, *held*, and every step begins its sums with them. Only contacts with awake particles are evaluated, so the
//! loads on sleepers are complete in each step, and a sleeper out of balance can be woken.
//!
//! Held loads are evaluated on copies of the slots: histories stay as they were when the two fell asleep, however often the loads
//! are evaluated.

use std::ops::Range;

use bytemuck::bytes_of;
use rayon::prelude::*;

use super::ContactLoop;
use super::block::Block;
use super::contact_batch::Numbers;
use super::pass::{Pass, Rows};
use super::slots::WITH_HISTORY;
use crate::contact::{AdhesionLaw, Histories, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::blocks::Outbox;
use crate::forces::{HoldsContacts, StepContext};
use crate::state::{ASLEEP, FIXED, Load, PRESCRIBED, Particle, Particles, WOKEN};

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> HoldsContacts
    for ContactLoop<N, T, R, A>
{
    fn hold(
        &mut self,
        particles: &Particles,
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        woken: Option<&[u32]>,
    ) {
        let pass = Pass::new(
            (&self.laws, self.materials),
            (&self.memory, self.block_size),
            (&particles.ids, particles.bodies.as_ref()),
            context,
        );
        let records = &particles.records;
        match woken {
            Some(woken) => pass.release(&mut self.blocks, records, woken),
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

    fn held(&self) -> Vec<Load> {
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
}

/// Whether the load of a contact is held: neither particle moves, and not because both are fixed.
#[inline(always)]
fn is_held(a: &Particle, b: &Particle) -> bool {
    rests(a, ASLEEP) && rests(b, ASLEEP) && (a.flags | b.flags) & ASLEEP != 0
}

/// Whether the load was held until one of them was woken.
#[inline(always)]
fn is_released(a: &Particle, b: &Particle) -> bool {
    let both = rests(a, ASLEEP | WOKEN) && rests(b, ASLEEP | WOKEN);
    both && (a.flags | b.flags) & WOKEN != 0
}

#[inline(always)]
fn rests(particle: &Particle, flags: u32) -> bool {
    particle.flags & (FIXED | flags) != 0
}

fn has_sleeper(records: &[Particle]) -> bool {
    records.iter().any(|record| record.flags & ASLEEP != 0)
}

impl<H> Block<H> {
    /// Notes which slots are evaluated, and which of their particles sleep.
    fn mark(&mut self, rows: &Rows<'_>) {
        let first = self.rows.start;
        let (mut begin, mut active, mut touching) = (0, 0, 0);
        self.stretches.clear();
        self.borders.clear();
        for (k, slot) in self.slots.iter().enumerate() {
            let (a, b) = rows.pair(slot.owner(), slot.partner as usize - first);
            if is_held(a, b) {
                if begin < k {
                    self.stretches.push(begin..k);
                }
                begin = k + 1;
                continue;
            }
            active += 1;
            touching += usize::from(slot.state & WITH_HISTORY != 0);
            if a.flags & ASLEEP != 0 {
                self.borders.push((first + slot.owner()) as u32);
            }
            if b.flags & ASLEEP != 0 {
                self.borders.push(slot.partner);
            }
        }
        if begin < self.slots.len() {
            self.stretches.push(begin..self.slots.len());
        }
        self.borders.sort_unstable();
        self.borders.dedup();
        self.work = 2 * active + 25 * touching + 8 * self.rows.len();
    }

    /// Subtracts a load from the held load of a row, if there is one.
    fn take_off(&mut self, row: usize, load: &Load) {
        if let Some(held) = self.held.get_mut(row) {
            held.add(-load.force, -load.torque);
        }
    }

    /// Marks, by row, the particles listed near one of these walls, or with a particle whose motion is prescribed.
    pub(super) fn mark_disturbed(
        &self,
        particles: &Particles,
        walls: &[bool],
        disturbed: &mut [bool],
    ) {
        for near in &self.near_walls {
            disturbed[near.row as usize] |= walls[near.wall.index()];
        }
        if !particles.has_prescribed() {
            return;
        }
        let drives = |row: usize| particles.records[row].flags & (PRESCRIBED | FIXED) == PRESCRIBED;
        for slot in &self.slots {
            let (a, b) = (self.rows.start + slot.owner(), slot.partner as usize);
            disturbed[a] |= drives(b);
            disturbed[b] |= drives(a);
        }
    }

    /// Restores the held loads of its rows.
    pub(super) fn restore_held(&mut self, records: &[Particle], held: &[Load]) {
        let own = self.rows.clone();
        self.mark(&Rows::together(&records[own.start..]));
        // Woken rows may keep the round-off of the subtraction.
        let held = &held[own.clone()];
        let is_felt = held
            .iter()
            .any(|load| bytes_of(load).iter().any(|&byte| byte != 0));
        if is_felt || self.rests_in_part() || has_sleeper(&records[own]) {
            self.held = held.to_vec();
        }
    }

    /// Whether some of its slots are not evaluated.
    fn rests_in_part(&self) -> bool {
        let evaluated: usize = self.stretches.iter().map(Range::len).sum();
        evaluated < self.slots.len()
    }
}

impl Rows<'_> {
    /// The owner of a slot, and its partner `ahead` rows behind the first row of the block.
    #[inline(always)]
    fn pair(&self, owner: usize, ahead: usize) -> (&Particle, &Particle) {
        (&self.own[owner], self.ahead(ahead))
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// A copy of the slots of a block whose particles satisfy `is_meant`.
    fn copy(
        block: &Block<Histories<N, T, R, A>>,
        rows: &Rows<'_>,
        is_meant: impl Fn(&Particle, &Particle) -> bool,
    ) -> Block<Histories<N, T, R, A>> {
        let first = block.rows.start;
        let mut copy = Block::empty(block.rows.clone());
        let meant = block.slots.iter().filter(|slot| {
            let (a, b) = rows.pair(slot.owner(), slot.partner as usize - first);
            is_meant(a, b)
        });
        copy.slots.extend(meant);
        copy.stretches.push(0..copy.slots.len());
        copy
    }

    /// A copy of all held slots of a block.
    fn copy_held(
        block: &Block<Histories<N, T, R, A>>,
        rows: &Rows<'_>,
    ) -> Block<Histories<N, T, R, A>> {
        let mut copy = Self::copy(block, rows, is_held);
        let mut first = 0;
        for (index, near) in block.near_walls.iter().enumerate() {
            let slots = first..first + near.features as usize;
            first = slots.end;
            if rows.own[near.row as usize - block.rows.start].flags & ASLEEP == 0 {
                continue;
            }
            if block.near_meshes.holds(index) {
                let lists = &block.near_meshes;
                copy.near_meshes
                    .take_over(copy.near_walls.len(), lists, index);
            }
            copy.near_walls.push(*near);
            copy.wall_slots.extend_from_slice(&block.wall_slots[slots]);
        }
        copy
    }

    /// The loads by the contacts in a copy, on its own rows; the loads on later rows are in its outbox then.
    fn evaluate(
        &self,
        copy: &mut Block<Histories<N, T, R, A>>,
        rows: &Rows<'_>,
        numbers: &mut Numbers,
    ) -> Vec<Load> {
        let mut loads = vec![Load::default(); copy.rows.len()];
        let pass = Pass {
            skipped: 0,
            ..*self
        };
        pass.compute(copy, rows, &mut loads, numbers);
        loads
    }

    /// Adds the held contacts of a block to its observation.
    #[inline(never)]
    pub(super) fn see_held(
        &self,
        block: &mut Block<Histories<N, T, R, A>>,
        rows: &Rows<'_>,
        numbers: &mut Numbers,
    ) {
        let mut copy = Self::copy_held(block, rows);
        self.evaluate(&mut copy, rows, numbers);
        block.observation.merge(&copy.observation);
    }

    /// Sums up all held loads anew.
    pub(super) fn hold(
        &self,
        blocks: &mut [Block<Histories<N, T, R, A>>],
        sources: &[Vec<usize>],
        records: &[Particle],
        pool: Option<&rayon::ThreadPool>,
    ) {
        let hold = |numbers: &mut Numbers, block: &mut Block<Histories<N, T, R, A>>| {
            let rows = Rows::together(&records[block.rows.start..]);
            block.mark(&rows);
            let mut copy = Self::copy_held(block, &rows);
            // The loads of sleepers on fixed particles are held, too: files contain them.
            block.held = if copy.slots.is_empty() && copy.near_walls.is_empty() {
                Vec::new()
            } else {
                self.evaluate(&mut copy, &rows, numbers)
            };
            copy.outbox
        };
        let parked: Vec<Outbox> = match pool {
            Some(pool) => pool.install(|| {
                let blocks = blocks.par_iter_mut();
                blocks.map_init(Numbers::new, hold).collect()
            }),
            None => {
                let mut numbers = Numbers::new();
                let blocks = blocks.iter_mut();
                blocks.map(|block| hold(&mut numbers, block)).collect()
            }
        };
        for (index, (block, sources)) in blocks.iter_mut().zip(sources).enumerate() {
            for &source in sources {
                let (outbox, ahead) = (&parked[source], index - source - 1);
                if block.held.is_empty() && outbox.parked(ahead).next().is_some() {
                    block.held = vec![Load::default(); block.rows.len()];
                }
                outbox.deliver(ahead, &mut block.held);
            }
        }
    }

    /// Subtracts the contacts of the woken rows from the held loads.
    pub(super) fn release(
        &self,
        blocks: &mut [Block<Histories<N, T, R, A>>],
        records: &[Particle],
        woken: &[u32],
    ) {
        let mut is_hit = vec![false; blocks.len()];
        for &row in woken {
            is_hit[row as usize / self.block_size] = true;
        }
        let mut numbers = Numbers::new();
        for index in 0..blocks.len() {
            let block = &mut blocks[index];
            if !is_hit[index] && !block.targets.iter().any(|&target| is_hit[target]) {
                continue;
            }
            let rows = Rows::together(&records[block.rows.start..]);
            block.mark(&rows);
            let mut copy = Self::copy(block, &rows, is_released);
            if copy.slots.is_empty() {
                continue;
            }
            let loads = self.evaluate(&mut copy, &rows, &mut numbers);
            for (row, load) in loads.iter().enumerate() {
                block.take_off(row, load);
            }
            for (ahead, later) in blocks[index + 1..].iter_mut().enumerate() {
                for (row, load) in copy.outbox.parked(ahead) {
                    later.take_off(row, &load);
                }
            }
        }
        for &row in woken {
            let block = &mut blocks[row as usize / self.block_size];
            let own = row as usize - block.rows.start;
            if let Some(held) = block.held.get_mut(own) {
                *held = Load::default();
            }
        }
    }
}
