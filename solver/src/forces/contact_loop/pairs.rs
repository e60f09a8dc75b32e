//! Contacts between particles: found without a branch, then evaluated, both several at once.
//!
//! A chunk of slots goes through four stages, each a short loop without long chains of dependent numbers:
//!
//! - search: which of the two of a slot touch; their offset
//! - prepare: velocities; roots and divisions that need nothing but sizes and distances
//! - act: the laws, histories one step on
//! - share: forces and torques to both, in the order of the slots
//!
//! The first three work in lanes; nothing is summed up there, so that their number changes no bit. Where pairs follow different laws, those of each
//! law are put side by side between search and prepare.

use glam::DVec3;

use super::contact_point::mobility;
use super::slots::{FREE, HELD, IMAGE, Slot, TOUCHING, held};
use super::{Block, ContactSite, Pass, Rows};
use crate::contact::{
    Action, AdhesionLaw, Contact, Histories, History, NormalLaw, RollingLaw, TangentialLaw,
};
use crate::forces::{Observation, Partner};
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Task, Vector};
use crate::neighbours::NO_SHIFT;
use crate::state::{Bodies, Load, Particle};

/// Slots that are searched for contacts before the contacts found are evaluated.
const CHUNK: usize = 128;

/// Room for what is known of a chunk: more than it needs, so that a `u8` is always an index into it.
const ROOM: usize = 256;

const _: () = assert!(CHUNK + MOST_LANES <= ROOM);

/// Pairs of materials that are told apart when contacts of one law are put side by side: those of eight materials. Where there are more, groups with
/// several laws are evaluated one by one.
const PAIRS: usize = 64;

/// All listed pairs of one block.
pub(super) struct Pairs<'p, 'a, N, T, R, A, H, const PERIODIC: bool, const WATCHED: bool> {
    pub(super) pass: &'p Pass<'a, N, T, R, A>,
    pub(super) block: &'p mut Block<H>,
    pub(super) rows: &'p Rows<'p>,
    pub(super) loads: &'p mut [Load],
    /// Room for what is found.
    pub(super) numbers: &'p mut Numbers,
}

impl<N, T, R, A, const PERIODIC: bool, const WATCHED: bool> Task
    for Pairs<'_, '_, N, T, R, A, Histories<N, T, R, A>, PERIODIC, WATCHED>
where
    N: NormalLaw,
    T: TangentialLaw,
    R: RollingLaw,
    A: AdhesionLaw,
{
    type Output = ();

    #[inline(always)]
    fn run<L: Real>(self) {
        let Self {
            pass,
            block,
            rows,
            loads,
            numbers,
        } = self;
        let Some(nobody) = rows.own.first() else {
            return;
        };
        if block.slots.is_empty() {
            return;
        }
        let mut found = Found::new(nobody, numbers);
        let first_row = block.rows.start;
        for slots in block.slots.chunks_mut(CHUNK) {
            let count = pass.search::<L, PERIODIC>(slots, first_row, rows, &mut found);
            let end = found.put_in_turn(count, pass.materials, L::LANES);
            if found.prepare::<L>(end, pass.context.overlap_limit) {
                let contacts = found.numbers.places[..count].iter().map(|&at| {
                    let at = usize::from(at);
                    (found.numbers.slot[at], found.numbers.overlap.0[at])
                });
                pass.alarm_pairs(&mut block.alarms, slots, (first_row, rows), contacts);
            }
            if let Some(bodies) = pass.bodies {
                pass.masses_at_contacts(bodies, slots, first_row, rows, &mut found, end);
            }
            let observation = &mut block.observation;
            pass.act::<L, WATCHED>(slots, first_row, &mut found, end, observation);
            for &at in &found.numbers.places[..count] {
                let at = usize::from(at);
                let slot = &slots[usize::from(found.numbers.slot[at])];
                let owner = &mut loads[slot.owner()];
                let force = found.numbers.force[at];
                let ahead = slot.partner as usize - first_row;
                if T::ACTIVE || R::ACTIVE {
                    let [on_a, on_b] = [found.numbers.torques[0][at], found.numbers.torques[1][at]];
                    let [force_a, torque_a] = owner.quads_mut();
                    *force_a += force;
                    *torque_a += on_a;
                    match loads.get_mut(ahead) {
                        Some(partner) => {
                            let [force_b, torque_b] = partner.quads_mut();
                            *force_b -= force;
                            *torque_b += on_b;
                        }
                        None => block.outbox.park(
                            ahead - pass.block_size,
                            pass.block_size,
                            -DVec3::from(force),
                            on_b.into(),
                        ),
                    }
                } else {
                    // Nothing turns the particles.
                    owner.quads_mut()[0] += force;
                    match loads.get_mut(ahead) {
                        Some(partner) => partner.quads_mut()[0] -= force,
                        None => block.outbox.park(
                            ahead - pass.block_size,
                            pass.block_size,
                            -DVec3::from(force),
                            DVec3::ZERO,
                        ),
                    }
                }
            }
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// Finds those of a chunk of slots that act on each other, and how they stand; returns how many. Which slots touch can hardly be predicted;
    /// finding them without a branch first keeps the processor from throwing away half-done contacts. Histories of contacts that have ended are
    /// forgotten.
    #[inline(always)]
    fn search<'a, L: Real, const PERIODIC: bool>(
        &self,
        slots: &mut [Slot<Histories<N, T, R, A>>],
        first_row: usize,
        rows: &Rows<'a>,
        found: &mut Found<'a>,
    ) -> usize {
        let (mut count, mut base) = (0, 0);
        let mut groups = slots.chunks_exact_mut(L::LANES);
        for group in &mut groups {
            let change =
                self.look::<L, PERIODIC>(group, (base, first_row), rows, found, &mut count);
            if change.any() {
                change.make(group);
            }
            base += L::LANES;
        }
        let rest = groups.into_remainder();
        if let Some(&last) = rest.last() {
            // Filled up with the last slot.
            let mut group = [last; MOST_LANES];
            group[..rest.len()].copy_from_slice(rest);
            let group = &group[..L::LANES];
            let mut all = count;
            let mut change =
                self.look::<L, PERIODIC>(group, (base, first_row), rows, found, &mut all);
            change.keep_first(rest.len());
            change.make(rest);
            let is_real = |slot: &&u8| usize::from(**slot) < base + rest.len();
            count += found.numbers.slot[count..all]
                .iter()
                .filter(is_real)
                .count();
        }
        count
    }

    /// Looks at a group of as many slots as there are lanes, which stand in the chunk from `base` on: appends those that act to the `count` contacts
    /// found, and says whose state changes.
    #[inline(always)]
    fn look<'a, L: Real, const PERIODIC: bool>(
        &self,
        group: &[Slot<Histories<N, T, R, A>>],
        (base, first_row): (usize, usize),
        rows: &Rows<'a>,
        found: &mut Found<'a>,
        count: &mut usize,
    ) -> Change {
        let (mut a, mut b) = ([found.a[0]; MOST_LANES], [found.b[0]; MOST_LANES]);
        let (mut touched, mut held, mut shifted) = (0, 0, 0);
        for (k, slot) in group[..L::LANES].iter().enumerate() {
            a[k] = &rows.own[slot.owner()];
            b[k] = rows.ahead(slot.partner as usize - first_row);
            touched |= (slot.state & TOUCHING) >> TOUCHING.trailing_zeros() << k;
            if A::ACTIVE {
                held |= u32::from(slot.state & HELD != 0) << k;
            }
            if PERIODIC {
                shifted |= (slot.state & IMAGE) ^ NO_SHIFT;
            }
        }
        found.a[base % ROOM..][..L::LANES].copy_from_slice(&a[..L::LANES]);
        found.b[base % ROOM..][..L::LANES].copy_from_slice(&b[..L::LANES]);
        let [x, y, z, reach] = L::differences(|k| &a[k].quads()[0], |k| &b[k].quads()[0]);
        let mut offset = Vector::new(x, y, z);
        if PERIODIC && shifted != 0 {
            let images = self.context.images;
            offset -= Vector::gather(|k| images.shift(group[k].state & IMAGE).into());
        }
        let squared = offset.length_squared();
        let mut acts = squared.below(reach * reach).bits();
        if A::ACTIVE {
            for (k, slot) in group[..L::LANES].iter().enumerate() {
                let (squared, reach) = (squared.lane(k), reach.lane(k));
                acts |= u32::from(self.acts_apart(a[k], b[k], slot, squared, reach)) << k;
            }
        }
        let places = packed_places(acts).wrapping_add(base as u64 * 0x0101_0101_0101_0101);
        found.numbers.slot[*count % ROOM..][..MOST_LANES].copy_from_slice(&places.to_le_bytes());
        found.numbers.offset[0].put(*count, offset.x.packed(acts));
        found.numbers.offset[1].put(*count, offset.y.packed(acts));
        found.numbers.offset[2].put(*count, offset.z.packed(acts));
        found.numbers.squared.put(*count, squared.packed(acts));
        found.numbers.reach.put(*count, reach.packed(acts));
        *count += acts.count_ones() as usize;
        if A::ACTIVE {
            // Who begins to touch is seen when the law has been asked.
            Change {
                begin: 0,
                end: held & !acts,
            }
        } else {
            Change {
                begin: acts & !touched,
                end: touched & !acts,
            }
        }
    }

    /// The laws of the contacts up to `end`: their forces and torques, and their histories one step on. Who is there twice is evaluated twice, to
    /// the same numbers.
    #[inline(always)]
    fn act<L: Real, const WATCHED: bool>(
        &self,
        slots: &mut [Slot<Histories<N, T, R, A>>],
        first_row: usize,
        found: &mut Found<'_>,
        end: usize,
        observation: &mut Observation,
    ) {
        let dt = self.context.spring_time;
        let mut base = 0;
        while base < end {
            let at = found.slots(base);
            let pair = |k: usize| found.numbers.pair[(base + k) % ROOM] as usize;
            let (contact, levers) = found.meet::<L, T, R>(base, &at);
            let one_law = (1..L::LANES).all(|k| pair(k) == pair(0));
            let mut before = [Default::default(); MOST_LANES];
            if WATCHED {
                for k in 0..L::LANES {
                    before[k] = slots[at[k]].history;
                }
            }
            let touches = !A::ACTIVE || contact.overlap.lane(0) > 0.0;
            let action = if one_law {
                let mut history = History::gather(|k| slots[at[k]].history);
                let law = &self.laws[pair(0)];
                let action = if touches {
                    law.act(&contact, dt, &mut history)
                } else {
                    debug_assert_eq!(L::LANES, 1, "adhesion is asked one by one");
                    law.act_apart(&contact, dt, &mut history)
                };
                for (k, &at) in at[..L::LANES].iter().enumerate() {
                    slots[at].history = history.lane(k);
                }
                action
            } else {
                // Each law to its lane; who is there twice must find its history as it was.
                let mut own = [Default::default(); MOST_LANES];
                for (own, &at) in own[..L::LANES].iter_mut().zip(&at) {
                    *own = slots[at].history;
                }
                let mut actions = [Action::NONE; MOST_LANES];
                for k in 0..L::LANES {
                    let law = &self.laws[pair(k)];
                    actions[k] = law.act(&contact.lane(k), dt, &mut own[k]);
                    slots[at[k]].history = own[k];
                }
                Action::gather(|k| actions[k])
            };
            if A::ACTIVE {
                for &at in &at[..L::LANES] {
                    let slot = &mut slots[at];
                    slot.state = slot.state & !HELD | held(touches, &slot.history.3);
                }
            }
            put(action.force, &mut found.numbers.force[base..]);
            if T::ACTIVE || R::ACTIVE {
                let turning = contact.normal.cross(action.tangential);
                let on_a = action.couple - turning * levers[0];
                let on_b = -action.couple - turning * levers[1];
                put(on_a, &mut found.numbers.torques[0][base..]);
                put(on_b, &mut found.numbers.torques[1][base..]);
            }
            if WATCHED {
                for (k, &at) in at[..L::LANES].iter().enumerate() {
                    let (slot, a, b) = (&slots[at], found.a[at], found.b[at]);
                    let partner = Partner::Particle {
                        row: slot.partner,
                        image: slot.state & IMAGE,
                    };
                    let contact = contact.lane(k);
                    observation.particle_contacts += u64::from(touches);
                    let site = ContactSite {
                        pair: pair(k),
                        row: first_row + slot.owner(),
                        partner,
                        b: Some(b),
                        feature: FREE,
                        lever: levers[0].lane(k),
                        depth: contact.overlap / a.radius.min(b.radius),
                        touches,
                    };
                    let histories = [before[k], slot.history];
                    self.see(observation, a, site, &contact, &action.lane(k), histories);
                }
            }
            base += L::LANES;
        }
    }

    /// Replaces the effective masses of the contacts up to `end` by those at the contact points. Apart from the evaluation,
    /// where even a call that is never made costs registers.
    #[inline(never)]
    fn masses_at_contacts(
        &self,
        bodies: &Bodies,
        slots: &[Slot<Histories<N, T, R, A>>],
        first_row: usize,
        rows: &Rows<'_>,
        found: &mut Found<'_>,
        end: usize,
    ) {
        for k in 0..end {
            let slot = &slots[usize::from(found.numbers.slot[k])];
            let (row, partner) = (first_row + slot.owner(), slot.partner as usize);
            let (a, b) = (&rows.own[slot.owner()], rows.ahead(partner - first_row));
            let normal = DVec3::from_array([0, 1, 2].map(|axis| found.numbers.normal[axis].0[k]));
            let inverse = mobility(bodies, row, a, normal) + mobility(bodies, partner, b, normal);
            found.numbers.mass.0[k] = 1.0 / inverse;
        }
    }

    /// Whether two that do not touch act on each other by adhesion. `squared`: distance of the centres, m^2.
    #[inline(always)]
    fn acts_apart<H>(
        &self,
        a: &Particle,
        b: &Particle,
        slot: &Slot<H>,
        squared: f64,
        reach: f64,
    ) -> bool {
        if !A::ACTIVE || (A::FORMS_ON_CONTACT && slot.state & HELD == 0) {
            return false;
        }
        let pair = a.material.index() * self.materials + b.material.index();
        let range = reach + self.laws[pair].adhesion.range();
        squared < range * range
    }

    /// x_A - x_B, of the image of B that is listed, m.
    pub(super) fn offset<H>(&self, a: &Particle, b: &Particle, slot: &Slot<H>) -> DVec3 {
        a.position - b.position - self.context.images.shift(slot.state & IMAGE)
    }
}

/// Slots of a group that begin to touch, or whose contact has ended, one bit each.
#[derive(Clone, Copy)]
struct Change {
    begin: u32,
    end: u32,
}

impl Change {
    #[inline(always)]
    fn any(self) -> bool {
        self.begin | self.end != 0
    }

    /// Leaves alone all but the first `count`.
    fn keep_first(&mut self, count: usize) {
        let first = (1 << count) - 1;
        self.begin &= first;
        self.end &= first;
    }

    /// Makes it; histories of contacts that have ended are forgotten.
    #[inline(always)]
    fn make<H: History>(self, group: &mut [Slot<H>]) {
        for (k, slot) in group.iter_mut().enumerate() {
            if self.begin >> k & 1 == 1 {
                slot.state |= TOUCHING;
            }
            if self.end >> k & 1 == 1 {
                slot.state &= !HELD;
                slot.history = H::default();
            }
        }
    }
}

/// The places of the bits that are set, one after the other from the lowest byte on.
#[inline(always)]
fn packed_places(bits: u32) -> u64 {
    const PLACES: [u64; 256] = {
        let mut places = [0; 256];
        let mut bits = 0;
        while bits < 256 {
            let (mut place, mut count) = (0, 0);
            while place < 8 {
                if bits >> place & 1 == 1 {
                    places[bits] |= place << (8 * count);
                    count += 1;
                }
                place += 1;
            }
            bits += 1;
        }
        places
    };
    PLACES[bits as usize & 255]
}

/// Each number at its own place.
const IN_ORDER: [u8; ROOM] = {
    let mut places = [0; ROOM];
    let mut k = 0;
    while k < ROOM {
        places[k] = k as u8;
        k += 1;
    }
    places
};

/// A number of each contact found.
#[repr(align(64))]
struct Column([f64; ROOM]);

impl Column {
    const ZERO: Self = Self([0.0; ROOM]);

    /// The numbers of contact `k` and those behind it.
    #[inline(always)]
    fn at<L: Real>(&self, k: usize) -> L {
        L::load(&self.0[k..])
    }

    #[inline(always)]
    fn put<L: Real>(&mut self, k: usize, numbers: L) {
        numbers.store(&mut self.0[k..]);
    }
}

/// The contacts found in a chunk of slots.
struct Found<'a> {
    /// The two of every slot of the chunk.
    a: [&'a Particle; ROOM],
    b: [&'a Particle; ROOM],
    numbers: &'a mut Numbers,
}

/// The numbers of the contacts found in a chunk of slots. One for all blocks that a thread evaluates: making it takes as long as some contacts.
pub(super) struct Numbers {
    // As they were found, in the order of the slots.
    /// x_A - x_B, of the image of B that is listed, m.
    offset: [Column; 3],
    /// Its square, m^2.
    squared: Column,
    /// R_A + R_B, m.
    reach: Column,
    /// Where each stands in what follows.
    places: [u8; ROOM],

    // As they are evaluated: those of one law side by side, groups filled up by repetition.
    /// Whether that is another order.
    is_sorted: bool,
    /// Which of those that were found.
    turn: [u8; ROOM],
    /// Slot in the chunk.
    slot: [u8; ROOM],
    /// The index of its law.
    pair: [u32; ROOM],
    /// From B to A.
    normal: [Column; 3],
    /// Of the centres, m.
    distance: Column,
    /// m.
    overlap: Column,
    /// R*, m.
    radius: Column,
    /// m*, kg.
    mass: Column,
    /// v_A - v_B, m/s.
    velocity: [Column; 3],
    /// On A, N.
    force: [Quad; ROOM],
    /// On A and on B, N m.
    torques: [[Quad; ROOM]; 2],
}

impl Numbers {
    /// Those of no contact.
    pub(super) fn new() -> Self {
        Self {
            offset: [Column::ZERO; 3],
            squared: Column::ZERO,
            reach: Column::ZERO,
            places: IN_ORDER,
            is_sorted: false,
            turn: IN_ORDER,
            slot: [0; ROOM],
            pair: [0; ROOM],
            normal: [Column::ZERO; 3],
            distance: Column::ZERO,
            overlap: Column::ZERO,
            radius: Column::ZERO,
            mass: Column::ZERO,
            velocity: [Column::ZERO; 3],
            force: [Quad::default(); ROOM],
            torques: [[Quad::default(); ROOM]; 2],
        }
    }
}

impl<'a> Found<'a> {
    /// Nothing yet; `nobody` stands for all.
    fn new(nobody: &'a Particle, numbers: &'a mut Numbers) -> Self {
        Self {
            a: [nobody; ROOM],
            b: [nobody; ROOM],
            numbers,
        }
    }

    /// Says in which order the first `count` contacts found are evaluated, in groups of `lanes`; returns the end of the last group.
    #[inline(always)]
    fn put_in_turn(&mut self, count: usize, materials: usize, lanes: usize) -> usize {
        if materials > 1
            && let Some(end) = self.put_laws_side_by_side(count, materials, lanes)
        {
            return end;
        }
        let end = count.next_multiple_of(lanes);
        for k in count..end {
            let last = count - 1;
            self.numbers.slot[k] = self.numbers.slot[last];
            self.numbers.pair[k] = self.numbers.pair[last];
            for axis in &mut self.numbers.offset {
                axis.0[k] = axis.0[last];
            }
            self.numbers.squared.0[k] = self.numbers.squared.0[last];
            self.numbers.reach.0[k] = self.numbers.reach.0[last];
        }
        end
    }

    /// The same where they may follow several laws, whose indices are noted; `None` if they are evaluated in the order of their slots.
    #[inline(never)]
    fn put_laws_side_by_side(
        &mut self,
        count: usize,
        materials: usize,
        lanes: usize,
    ) -> Option<usize> {
        let found: [u8; CHUNK] = std::array::from_fn(|k| self.numbers.slot[k]);
        let (mut least, mut most) = (u32::MAX, 0);
        for (pair, &at) in self
            .numbers
            .pair
            .iter_mut()
            .zip(&self.numbers.slot[..count])
        {
            let at = usize::from(at);
            let (a, b) = (self.a[at].material.index(), self.b[at].material.index());
            // That of two materials is the same both ways.
            *pair = (a.min(b) * materials + a.max(b)) as u32;
            (least, most) = (least.min(*pair), most.max(*pair));
        }
        (
            self.numbers.places,
            self.numbers.turn,
            self.numbers.is_sorted,
        ) = (IN_ORDER, IN_ORDER, false);
        if lanes == 1 || least >= most || most as usize >= PAIRS {
            return None;
        }
        // A counting sort without branches: which law comes next can hardly be predicted.
        let pairs: [u8; CHUNK] = std::array::from_fn(|k| self.numbers.pair[k] as u8);
        let pairs = &pairs[..count];
        let mut counts = [0; PAIRS];
        for &pair in pairs {
            counts[usize::from(pair) % PAIRS] += 1;
        }
        let mut next = [0; PAIRS];
        let mut end = 0;
        for (next, count) in next.iter_mut().zip(counts) {
            *next = end;
            end += usize::next_multiple_of(count, lanes);
        }
        if end > ROOM {
            return None;
        }
        for (k, &pair) in pairs.iter().enumerate() {
            let place = &mut next[usize::from(pair) % PAIRS];
            self.numbers.places[k] = *place as u8;
            self.numbers.turn[*place % ROOM] = k as u8;
            self.numbers.pair[*place % ROOM] = u32::from(pair);
            *place += 1;
        }
        // Each run is filled up by its last contact: in the same group, which finds one history and leaves one.
        for (&filled, count) in next.iter().zip(counts) {
            for k in filled..filled - count + usize::next_multiple_of(count, lanes) {
                self.numbers.turn[k] = self.numbers.turn[filled - 1];
                self.numbers.pair[k] = self.numbers.pair[filled - 1];
            }
        }
        for (slot, &from) in self.numbers.slot[..end].iter_mut().zip(&self.numbers.turn) {
            *slot = found[usize::from(from) % CHUNK];
        }
        self.numbers.is_sorted = true;
        Some(end)
    }

    /// The slots of the contacts from `base` on.
    #[inline(always)]
    fn slots(&self, base: usize) -> [usize; MOST_LANES] {
        std::array::from_fn(|k| usize::from(self.numbers.slot[(base + k) % ROOM]))
    }

    /// The numbers of a column of contacts as they were found, of those that are evaluated from `base` on.
    #[inline(always)]
    fn found<L: Real>(&self, column: &Column, base: usize, is_sorted: bool) -> L {
        if is_sorted {
            L::from_lanes(|k| column.0[usize::from(self.numbers.turn[(base + k) % ROOM])])
        } else {
            column.at(base)
        }
    }

    /// Normals, velocities, masses and radii of the contacts up to `end`, with the roots and divisions that need nothing else: all of them at once
    /// and ahead of the long chains of each contact. Says whether one of them may overlap by more than `limit` of the smaller radius, which is
    /// at least R*.
    #[inline(always)]
    fn prepare<L: Real>(&mut self, end: usize, limit: f64) -> bool {
        let is_sorted = self.numbers.is_sorted;
        let mut is_deep = 0;
        let mut base = 0;
        while base < end {
            let at = self.slots(base);
            let (a, b) = (
                |k: usize| self.a[at[k] % ROOM],
                |k: usize| self.b[at[k] % ROOM],
            );
            let [x, y, z, mobility] = L::differences(|k| &a(k).quads()[1], |k| &b(k).quads()[1]);
            let radii = L::from_lanes(|k| a(k).radius) * L::from_lanes(|k| b(k).radius);
            let distance: L = self
                .found::<L>(&self.numbers.squared, base, is_sorted)
                .sqrt();
            let reach: L = self.found(&self.numbers.reach, base, is_sorted);
            let offset: Vector<L> = Vector::new(
                self.found(&self.numbers.offset[0], base, is_sorted),
                self.found(&self.numbers.offset[1], base, is_sorted),
                self.found(&self.numbers.offset[2], base, is_sorted),
            );
            let mut normal = offset * (L::ONE / distance);
            let apart = L::ZERO.below(distance);
            if !apart.all() {
                // Concentric particles have no normal; any will do to push them apart.
                normal = Vector::select(apart, normal, Vector::X);
            }
            let (radius, overlap) = (radii / reach, reach - distance);
            is_deep |= (radius * limit).below(overlap).bits();
            self.numbers.velocity[0].put(base, x);
            self.numbers.velocity[1].put(base, y);
            self.numbers.velocity[2].put(base, z);
            self.numbers.normal[0].put(base, normal.x);
            self.numbers.normal[1].put(base, normal.y);
            self.numbers.normal[2].put(base, normal.z);
            self.numbers.mass.put(base, L::ONE / mobility);
            self.numbers.radius.put(base, radius);
            self.numbers.distance.put(base, distance);
            self.numbers.overlap.put(base, overlap);
            base += L::LANES;
        }
        is_deep != 0
    }

    /// Geometry and kinematics of the contacts from `base` on, whose slots are `at`, and the lever arms R - overlap/2 of both.
    #[inline(always)]
    fn meet<L: Real, T: TangentialLaw, R: RollingLaw>(
        &self,
        base: usize,
        at: &[usize; MOST_LANES],
    ) -> (Contact<L>, [L; 2]) {
        let (a, b) = (
            |k: usize| self.a[at[k] % ROOM],
            |k: usize| self.b[at[k] % ROOM],
        );
        let (distance, overlap): (L, L) = (
            self.numbers.distance.at(base),
            self.numbers.overlap.at(base),
        );
        let normal: Vector<L> = columns(&self.numbers.normal, base);
        let half = overlap * 0.5;
        let levers = [
            L::from_lanes(|k| a(k).radius) - half,
            L::from_lanes(|k| b(k).radius) - half,
        ];
        let centre_velocity: Vector<L> = columns(&self.numbers.velocity, base);
        let normal_velocity = centre_velocity.dot(normal);
        let (mut tangential_velocity, mut spin) = (Vector::ZERO, Vector::ZERO);
        if T::ACTIVE || R::ACTIVE {
            let spin_a: Vector<L> = L::vectors(|k| &a(k).quads()[2]);
            let spin_b: Vector<L> = L::vectors(|k| &b(k).quads()[2]);
            if T::ACTIVE {
                let turning = spin_a * levers[0] + spin_b * levers[1];
                tangential_velocity =
                    centre_velocity - normal * normal_velocity - turning.cross(normal);
            }
            if R::ACTIVE {
                spin = spin_a - spin_b;
            }
        }
        let contact = Contact {
            normal,
            distance,
            overlap,
            effective_radius: self.numbers.radius.at(base),
            effective_mass: self.numbers.mass.at(base),
            normal_velocity,
            tangential_velocity,
            centre_velocity,
            spin,
        };
        (contact, levers)
    }
}

/// Writes lane `k` of a vector to `quads[k]`.
#[inline(always)]
fn put<L: Real>(vector: Vector<L>, quads: &mut [Quad]) {
    let rows = L::rows(vector, L::ZERO);
    quads[..L::LANES].copy_from_slice(&rows[..L::LANES]);
}

#[inline(always)]
fn columns<L: Real>(columns: &[Column; 3], k: usize) -> Vector<L> {
    Vector::new(columns[0].at(k), columns[1].at(k), columns[2].at(k))
}
