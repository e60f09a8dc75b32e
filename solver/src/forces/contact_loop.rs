//! The contact loop: every listed pair and every particle near a wall, once, with the laws compiled in.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::Outbox;
use super::{
    ContactForces, ContactRecord, Fastest, Finish, NearWall, Observation, Partner, SavedSlot,
    StepContext, Watch, block_size,
};
use crate::contact::{
    Action, Contact, History, HistoryNumber, NormalLaw, PairLaw, RollingLaw, TangentialLaw,
};
use crate::neighbours::{CandidateList, opposite};
use crate::particles::{Load, Particle, Particles};
use crate::walls::{Shape, Touch, Touches, Wall, WallState};

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

/// Slots that are searched for contacts before the contacts found are evaluated.
const CHUNK: usize = 128;

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
        near_walls: &[NearWall],
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
        let begin = near_walls.partition_point(|near| near.row < first);
        let end = near_walls.partition_point(|near| (near.row as usize) < self.rows.end);
        for near in &near_walls[begin..end] {
            let key = (near.row, near.wall, near.image);
            let run = from_walls.partition_point(|kept| kept.0 < key);
            let mut kept = from_walls[run..].iter().take_while(|kept| kept.0 == key);
            // As many slots as features may be touched, and no fewer than hold a history.
            let held = kept.clone().count().max(near.features as usize);
            self.near_walls.push(NearWall {
                features: held as u8,
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
        near_walls: &[NearWall],
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
                });
            }
            let mut first = 0;
            for near in &block.near_walls {
                for slot in &block.wall_slots[first..first + near.features as usize] {
                    walls.push(SavedSlot {
                        row: near.row,
                        partner: u32::from(near.wall),
                        image: u32::from(near.image),
                        touching: slot.feature != FREE,
                        feature: slot.feature,
                        history: numbers(&slot.history),
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
                let near = NearWall {
                    row: saved.row,
                    wall: saved.partner as u16,
                    image: saved.image as u8,
                    features: 1,
                };
                match block.near_walls.last_mut() {
                    Some(last)
                        if NearWall {
                            features: 1,
                            ..*last
                        } == near =>
                    {
                        last.features += 1
                    }
                    _ => block.near_walls.push(near),
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

    fn pairs<const PERIODIC: bool, const WATCHED: bool>(
        &self,
        block: &mut Block<Histories<N, T, R>>,
        loads: &mut [Load],
    ) {
        let first_row = block.rows.start;
        let records = self.records;
        let mut found = Found::NOTHING;
        for slots in block.slots.chunks_mut(CHUNK) {
            // Which slots touch can hardly be predicted; finding them without a branch first keeps the processor from
            // throwing away half-done contacts.
            let mut count = 0;
            for (k, slot) in slots.iter_mut().enumerate() {
                let a = &records[first_row + slot.owner()];
                let b = &records[slot.partner as usize];
                let squared = self.offset::<PERIODIC, _>(a, b, slot).length_squared();
                let reach = a.radius + b.radius;
                let touches = squared < reach * reach;
                found.slot[count] = k as u32;
                found.distance[count] = squared;
                found.reach[count] = reach;
                found.radius[count] = a.radius * b.radius;
                found.mass[count] = a.inverse_mass + b.inverse_mass;
                count += usize::from(touches);
                if !touches && slot.state & TOUCHING != 0 {
                    slot.state &= !TOUCHING;
                    slot.history = Default::default();
                }
            }
            found.evaluate(count);
            for k in 0..count {
                let slot = &mut slots[found.slot[k] as usize];
                let owner = slot.owner();
                let a = &records[first_row + owner];
                let b = &records[slot.partner as usize];
                let offset = self.offset::<PERIODIC, _>(a, b, slot);
                slot.state |= TOUCHING;
                let (contact, lever_a, lever_b) = meet::<T, R>(a, b, offset, &found, k);
                let law = &self.laws[a.material as usize * self.materials + b.material as usize];
                let before = slot.history;
                let action = law.act(&contact, self.context.spring_time, &mut slot.history);
                let ahead = slot.partner as usize - first_row;
                if T::ACTIVE || R::ACTIVE {
                    let turning = contact.normal.cross(action.tangential);
                    loads[owner].add(action.force, action.couple - turning * lever_a);
                    let torque = -action.couple - turning * lever_b;
                    match loads.get_mut(ahead) {
                        Some(partner) => partner.add(-action.force, torque),
                        None => block.outbox.park(
                            ahead - self.block_size,
                            self.block_size,
                            -action.force,
                            torque,
                        ),
                    }
                } else {
                    // Nothing turns the particles.
                    loads[owner].force += action.force;
                    match loads.get_mut(ahead) {
                        Some(partner) => partner.force -= action.force,
                        None => block.outbox.park(
                            ahead - self.block_size,
                            self.block_size,
                            -action.force,
                            DVec3::ZERO,
                        ),
                    }
                }
                if WATCHED {
                    let partner = Partner::Particle {
                        row: slot.partner,
                        image: slot.state & IMAGE,
                    };
                    block.observation.particle_contacts += 1;
                    let depth = contact.overlap / a.radius.min(b.radius);
                    let seen = Seen {
                        row: first_row + owner,
                        partner,
                        lever: lever_a,
                        depth,
                    };
                    let histories = (before, slot.history);
                    self.see(
                        &mut block.observation,
                        a,
                        seen,
                        law,
                        &contact,
                        &action,
                        histories,
                    );
                }
            }
        }
    }

    /// x_A - x_B, of the image of B that is listed, m.
    #[inline(always)]
    fn offset<const PERIODIC: bool, H>(&self, a: &Particle, b: &Particle, slot: &Slot<H>) -> DVec3 {
        let offset = a.position - b.position;
        if PERIODIC {
            offset - self.context.images.shift(slot.state & IMAGE)
        } else {
            offset
        }
    }

    fn walls<const WATCHED: bool>(
        &self,
        block: &mut Block<Histories<N, T, R>>,
        loads: &mut [Load],
    ) {
        let context = self.context;
        let mut touches = Touches::default();
        let mut first = 0;
        for near in &mut block.near_walls {
            let wall = &context.walls[near.wall as usize];
            let state = &context.wall_states[near.wall as usize];
            let a = &self.records[near.row as usize];
            let centre = a.position + context.images.shift(u32::from(near.image));
            if !matches!(wall.shape, Shape::Plane(_)) {
                touches.clear();
                if state.present {
                    wall.shape
                        .touches(state.into_wall(centre), a.radius, &mut touches);
                }
                // On its way into a concave corner a particle may meet a face onto which its centre did not project when
                // the list was built.
                while (near.features as usize) < touches.len() {
                    let end = first + near.features as usize;
                    block.wall_slots.insert(end, WallSlot::free());
                    near.features += 1;
                }
            }
            let slots = &mut block.wall_slots[first..first + near.features as usize];
            first += near.features as usize;
            let side = WallSide {
                near,
                wall,
                state,
                centre,
            };
            let load = &mut loads[near.row as usize - block.rows.start];
            let observation = &mut block.observation;
            if let Shape::Plane(plane) = &wall.shape {
                // A plane has one feature: most walls of most scenes need no search.
                let touch = if state.present {
                    plane.touch(state.into_wall(centre), a.radius)
                } else {
                    None
                };
                match touch {
                    Some(touch) => {
                        slots[0].feature = touch.feature;
                        self.touch_wall::<WATCHED>(
                            a,
                            &side,
                            &touch,
                            &mut slots[0],
                            load,
                            observation,
                        );
                    }
                    None => slots[0].clear(),
                }
                continue;
            }
            assign(slots, &touches, &wall.shape);
            for slot in slots {
                match touches.iter().find(|touch| touch.feature == slot.feature) {
                    Some(touch) => {
                        self.touch_wall::<WATCHED>(a, &side, touch, slot, load, observation);
                    }
                    None => slot.clear(),
                }
            }
        }
    }

    /// The contact of a particle with one feature of a wall.
    #[inline(always)]
    fn touch_wall<const WATCHED: bool>(
        &self,
        a: &Particle,
        side: &WallSide<'_>,
        touch: &Touch,
        slot: &mut WallSlot<Histories<N, T, R>>,
        load: &mut Load,
        observation: &mut Observation,
    ) {
        let (context, state) = (self.context, side.state);
        let normal = state.out_of_wall(touch.normal);
        let overlap = a.radius - touch.distance;
        let lever = a.radius - 0.5 * overlap;
        let arm = normal * -lever;
        let mut velocity = a.velocity + a.angular_velocity.cross(arm);
        let mut spin = a.angular_velocity;
        if state.moves {
            velocity -= state.velocity.at(side.centre + arm);
            spin -= state.velocity.angular_velocity;
        }
        let normal_velocity = velocity.dot(normal);
        let contact = Contact {
            normal,
            distance: touch.distance,
            overlap,
            effective_radius: if context.wall_curvature {
                curved_radius(a.radius, touch.curvature)
            } else {
                a.radius
            },
            effective_mass: 1.0 / a.inverse_mass,
            normal_velocity,
            tangential_velocity: velocity - normal * normal_velocity,
            centre_velocity: DVec3::ZERO,
            spin,
        };
        let law = &self.laws[a.material as usize * self.materials + side.wall.material as usize];
        let before = slot.history;
        let action = law.act(&contact, context.spring_time, &mut slot.history);
        load.add(action.force, action.couple + arm.cross(action.tangential));
        if WATCHED {
            observation.wall_contacts += 1;
            let partner = Partner::Wall {
                wall: side.near.wall,
                image: u32::from(side.near.image),
            };
            let depth = overlap / a.radius;
            let seen = Seen {
                row: side.near.row as usize,
                partner,
                lever,
                depth,
            };
            self.see(
                observation,
                a,
                seen,
                law,
                &contact,
                &action,
                (before, slot.history),
            );
            let point = side.centre + arm;
            let (wall_load, power) = &mut observation.walls[side.near.wall as usize];
            let about = point - state.reference;
            wall_load.add(-action.force, -about.cross(action.force) - action.couple);
            let watts = action.force.dot(state.velocity.at(point))
                + action.couple.dot(state.velocity.angular_velocity);
            *power += watts;
            if let Some(Watch {
                audit: Some(dt), ..
            }) = context.watch
            {
                observation.wall_work += watts * dt;
            }
        }
    }

    /// Adds a contact to an observation.
    #[inline(never)]
    fn see(
        &self,
        observation: &mut Observation,
        a: &Particle,
        seen: Seen,
        law: &PairLaw<N, T, R>,
        contact: &Contact,
        action: &Action,
        (before, after): (Histories<N, T, R>, Histories<N, T, R>),
    ) {
        observation.elastic_energy += law.energy(contact, &after);
        observation.largest_overlap = observation.largest_overlap.max(seen.depth);
        let Some(watch) = self.context.watch else {
            return;
        };
        if let Some(dt) = watch.audit {
            // The elastic work by the trapezoidal rule over this step's overlaps: exact for straight branches.
            let mut last = *contact;
            last.overlap = contact.overlap + contact.normal_velocity * dt;
            let (mut work, mut gained) = (0.0, law.normal.energy(contact, &after.0));
            if last.overlap > 0.0 {
                let mut history = before.0;
                let elastic = law.normal.force(&last, &mut history).elastic;
                work = 0.5 * (elastic + action.normal.elastic);
                gained -= law.normal.energy(&last, &before.0);
            } else {
                last.overlap = 0.0;
                work += 0.5 * action.normal.elastic;
            }
            let elastic_loss = work * (contact.overlap - last.overlap) - gained;
            observation.dissipated_normal +=
                elastic_loss - action.normal.viscous * contact.normal_velocity * dt;
            // Springs count at the stiffness of their own time: what a change of stiffness takes or gives is part of the
            // dissipation, as the forces do no work for it.
            let stiffness = law.tangential.stiffness(contact);
            let tangential_gain =
                law.tangential.energy(contact, &after.1) - law.tangential.energy(&last, &before.1);
            observation.dissipated_tangential -=
                action.tangential.dot(contact.tangential_velocity) * dt + tangential_gain;
            if R::ACTIVE {
                let gain = law.rolling.energy(stiffness, &after.2)
                    - law
                        .rolling
                        .energy(law.tangential.stiffness(&last), &before.2);
                observation.dissipated_rolling -= action.couple.dot(contact.spin) * dt + gain;
            }
        }
        if watch.records {
            let record = self.record(a, seen, law, contact, action, after);
            observation.records.push(record);
        }
    }

    /// The record of a contact, of two particles from the side of the lower id: an order that sorting does not change.
    fn record(
        &self,
        a: &Particle,
        seen: Seen,
        law: &PairLaw<N, T, R>,
        contact: &Contact,
        action: &Action,
        memory: Histories<N, T, R>,
    ) -> ContactRecord {
        let mut record = ContactRecord {
            row: seen.row as u32,
            partner: seen.partner,
            point: a.position - contact.normal * seen.lever,
            normal: contact.normal,
            overlap: contact.overlap,
            force: action.force,
            tangential: action.tangential,
            couple: action.couple,
            tangential_overlap: 0.0,
            history: Vec::with_capacity(<Histories<N, T, R>>::LENGTH),
        };
        let mut memory = memory;
        if let Partner::Particle { row, image } = seen.partner
            && self.ids[row as usize] < self.ids[seen.row]
        {
            let b = &self.records[row as usize];
            record.row = row;
            record.partner = Partner::Particle {
                row: seen.row as u32,
                image: opposite(image),
            };
            record.point = b.position + contact.normal * (b.radius - 0.5 * contact.overlap);
            record.normal = -contact.normal;
            record.force = -action.force;
            record.tangential = -action.tangential;
            record.couple = -action.couple;
            memory = memory.swapped();
        }
        record.tangential_overlap = law.tangential.tangential_overlap(contact, &memory.1);
        memory.write(&mut record.history);
        record
    }
}

/// The wall's side of a contact.
struct WallSide<'a> {
    near: &'a NearWall,
    wall: &'a Wall,
    state: &'a WallState,
    /// Centre of the particle's image that is near, m.
    centre: DVec3,
}

/// Gives every touched feature a slot. A feature that was touched before keeps its own; a new one takes the slot, and the
/// history, of an adjacent feature that is no longer touched, or else a free slot without history.
fn assign<H: History>(slots: &mut [WallSlot<H>], touches: &Touches, shape: &Shape) {
    for touch in touches.iter() {
        if slots.iter().any(|slot| slot.feature == touch.feature) {
            continue;
        }
        let left = |slot: &WallSlot<H>| {
            slot.feature == FREE || !touches.iter().any(|touch| touch.feature == slot.feature)
        };
        let from = slots.iter().position(|slot| {
            slot.feature != FREE && left(slot) && shape.adjacent(slot.feature, touch.feature)
        });
        match from.or_else(|| slots.iter().position(left)) {
            Some(index) => {
                if from.is_none() {
                    slots[index].clear();
                }
                slots[index].feature = touch.feature;
            }
            // There are at least as many slots as touches.
            None => debug_assert!(false, "no slot for a feature of a wall"),
        }
    }
}

/// A contact that is being observed.
struct Seen {
    row: usize,
    partner: Partner,
    /// R_A - overlap/2, m.
    lever: f64,
    /// Overlap over the smaller radius.
    depth: f64,
}

/// The contacts found in a chunk of slots. Roots and divisions that need nothing but sizes and distances are made for all of
/// them at once, two at a time and ahead of the long chains of each contact.
struct Found {
    /// Index in the chunk.
    slot: [u32; CHUNK],
    /// First the squared distance, then the distance, m.
    distance: [f64; CHUNK],
    /// One over the distance, 1/m.
    inverse_distance: [f64; CHUNK],
    /// R_A + R_B, m.
    reach: [f64; CHUNK],
    /// First R_A R_B, then R*, m.
    radius: [f64; CHUNK],
    /// First 1/m_A + 1/m_B, then m*, kg.
    mass: [f64; CHUNK],
}

impl Found {
    const NOTHING: Self = Self {
        slot: [0; CHUNK],
        distance: [0.0; CHUNK],
        inverse_distance: [0.0; CHUNK],
        reach: [0.0; CHUNK],
        radius: [0.0; CHUNK],
        mass: [0.0; CHUNK],
    };

    /// Takes the second step for the first `count` contacts.
    #[inline(always)]
    fn evaluate(&mut self, count: usize) {
        let count = count.min(CHUNK);
        for k in 0..count {
            let distance = self.distance[k].sqrt();
            self.distance[k] = distance;
            self.inverse_distance[k] = 1.0 / distance;
            self.radius[k] /= self.reach[k];
            self.mass[k] = 1.0 / self.mass[k];
        }
    }
}

/// Geometry and kinematics of two particles that overlap, contact `k` of those found, and the lever arms R - overlap/2 of
/// both. `offset` = x_A - x_B (of the image that is near).
#[inline(always)]
fn meet<T: TangentialLaw, R: RollingLaw>(
    a: &Particle,
    b: &Particle,
    offset: DVec3,
    found: &Found,
    k: usize,
) -> (Contact, f64, f64) {
    let distance = found.distance[k];
    // Concentric particles have no normal; any will do to push them apart.
    let normal = if distance > 0.0 {
        offset * found.inverse_distance[k]
    } else {
        DVec3::X
    };
    let overlap = found.reach[k] - distance;
    let (lever_a, lever_b) = (a.radius - 0.5 * overlap, b.radius - 0.5 * overlap);
    let centre_velocity = a.velocity - b.velocity;
    let normal_velocity = centre_velocity.dot(normal);
    let (mut tangential_velocity, mut spin) = (DVec3::ZERO, DVec3::ZERO);
    if T::ACTIVE {
        let turning = a.angular_velocity * lever_a + b.angular_velocity * lever_b;
        tangential_velocity = centre_velocity - normal * normal_velocity - turning.cross(normal);
    }
    if R::ACTIVE {
        spin = a.angular_velocity - b.angular_velocity;
    }
    let contact = Contact {
        normal,
        distance,
        overlap,
        effective_radius: found.radius[k],
        effective_mass: found.mass[k],
        normal_velocity,
        tangential_velocity,
        centre_velocity,
        spin,
    };
    (contact, lever_a, lever_b)
}

/// R* at a wall with the given principal curvatures (1/m, positive if convex towards the particle): the geometric mean of the
/// effective radii in the two principal planes, which Hertz' theory gives for nearly circular contacts (Johnson 1985, eq. 4.28).
fn curved_radius(radius: f64, curvature: [f64; 2]) -> f64 {
    // A concave wall of nearly the particle's own radius would conform to it; the radius is bounded at ten times.
    let in_plane = |kappa: f64| 1.0 / (1.0 / radius + kappa).max(0.1 / radius);
    (in_plane(curvature[0]) * in_plane(curvature[1])).sqrt()
}
