//! Contacts between particles: found without a branch, then evaluated, in lanes in both cases.
//!
//! A chunk of slots goes through four stages, each a short loop without long chains of dependent numbers:
//!
//! - search: which of the two of a slot touch, and no sheet is between; their offset
//! - prepare: velocities; roots and divisions that depend only on sizes and distances
//! - act: the laws, histories one step on
//! - share: forces and torques to both, in the order of the slots
//!
//! The first three work in lanes; nothing is summed up there, so that their number changes no bit. Where pairs follow different laws, those of each
//! law are put side by side between search and prepare.

use std::ops::Range;

use glam::DVec3;

use super::block::Block;
use super::contact_batch::{BatchColumns, CHUNK, ContactBatch, ROOM};
use super::contact_point::mobility;
use super::pass::{ContactSite, Pass, Rows};
use super::prefetch::{PORTION, prefetch_ahead};
use super::slot_events::{SlotEvent, SlotEvents};
use super::slots::{FREE, IMAGE, Slot, TOUCHING, WITH_HISTORY, with_history};
use crate::cell::NO_SHIFT;
use crate::contact::{
    Action, AdhesionLaw, Histories, History, NormalLaw, PairLaw, RollingLaw, TangentialLaw,
};
use crate::forces::{Observation, Partner};
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Task, Vector};
use crate::state::{Bodies, Load, Particle};

/// All listed pairs of one block.
pub(super) struct Pairs<'p, 'a, N, T, R, A, H, const PERIODIC: bool, const WATCHED: bool> {
    pub(super) pass: &'p Pass<'a, N, T, R, A>,
    pub(super) block: &'p mut Block<H>,
    pub(super) rows: &'p Rows<'p>,
    pub(super) loads: &'p mut [Load],
    /// Buffers for the contacts that are found.
    pub(super) numbers: &'p mut BatchColumns,
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
        let Some(filler) = rows.own.first() else {
            return;
        };
        if block.slots.is_empty() {
            return;
        }
        let mut found = ContactBatch::new(filler, numbers);
        let first_row = block.rows.start;
        let turns = PairLaw::<N, T, R, A>::TURNS;
        let lag = turns.then(|| pass.context.sliding_lag());
        let mut rest = block.slots.as_mut_slice();
        let mut next_slot = 0;
        while !rest.is_empty() {
            let (slots, later) = rest.split_at_mut(rest.len().min(CHUNK));
            let first_slot = next_slot;
            next_slot += slots.len();
            rest = later;
            let mut count = pass.search::<L, PERIODIC>(slots, first_row, rows, &mut found);
            if let Some(beside) = pass.context.beside_sheets
                && count > 0
            {
                let (rows, found) = ((first_row, rows), (&mut found, count));
                let events = &mut block.events;
                count = pass.leave_out_separated(beside, slots, rows, found, events);
            }
            if let Some(offsets) = pass.context.offsets
                && count > 0
            {
                let (rows, found) = ((first_row, rows), (&mut found, count));
                let events = &mut block.events;
                count = pass.take_off_overlaps(offsets, slots, rows, found, events);
            }
            let by_touch = A::ACTIVE && L::LANES > 1;
            let turn = found.put_in_turn(count, pass.materials, L::LANES, by_touch);
            let end = turn.end;
            if found.prepare::<L>(turn, pass.context.overlap_limit, lag) {
                let contacts = found.places(turn, count).iter().map(|&at| {
                    let at = usize::from(at);
                    (found.numbers.slot[at], found.numbers.overlap.0[at])
                });
                pass.alarm_pairs(
                    &mut block.reports.alarms,
                    slots,
                    (first_row, rows),
                    contacts,
                );
            }
            if let Some(bodies) = pass.bodies {
                pass.masses_at_contacts(bodies, slots, first_row, rows, &mut found, end);
            }
            let observation = &mut block.reports.observation;
            let portion = if pass.asks_ahead { PORTION } else { ROOM };
            for base in (0..end).step_by(portion) {
                if pass.asks_ahead {
                    prefetch_ahead(rest, rows, first_row, base);
                }
                let some = base..end.min(base + portion);
                let first = (first_row, first_slot);
                let seen = (&mut *observation, &mut block.events);
                pass.act::<L, WATCHED>(slots, first, &mut found, some, seen);
            }
            for &at in found.places(turn, count) {
                let at = usize::from(at);
                let slot = &slots[usize::from(found.numbers.slot[at])];
                let owner = &mut loads[slot.owner()];
                let force = found.numbers.force[at];
                let ahead = slot.partner as usize - first_row;
                if turns {
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
                        None => (block.outbox).park(ahead, -DVec3::from(force), on_b.into()),
                    }
                } else {
                    // No torques on the particles.
                    owner.quads_mut()[0] += force;
                    match loads.get_mut(ahead) {
                        Some(partner) => partner.quads_mut()[0] -= force,
                        None => (block.outbox).park(ahead, -DVec3::from(force), DVec3::ZERO),
                    }
                }
            }
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// Finds the slots of a chunk whose particles act on each other, and their geometry; returns the number. Touching slots can
    /// hardly be predicted; a search without branches keeps the processor from discarding half-done contacts. Histories of
    /// contacts that have ended are cleared.
    #[inline(always)]
    fn search<'a, L: Real, const PERIODIC: bool>(
        &self,
        slots: &mut [Slot<Histories<N, T, R, A>>],
        first_row: usize,
        rows: &Rows<'a>,
        found: &mut ContactBatch<'a>,
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
            // Filled up with copies of the last slot.
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

    /// Tests a group of as many slots as there are lanes, from `base` on in the chunk: appends those that act to the `count`
    /// contacts found, and returns those whose state changes.
    #[inline(always)]
    fn look<'a, L: Real, const PERIODIC: bool>(
        &self,
        group: &[Slot<Histories<N, T, R, A>>],
        (base, first_row): (usize, usize),
        rows: &Rows<'a>,
        found: &mut ContactBatch<'a>,
        count: &mut usize,
    ) -> Change {
        let (mut a, mut b) = ([found.a[0]; MOST_LANES], [found.b[0]; MOST_LANES]);
        let (mut touched, mut held, mut shifted) = (0, 0, 0);
        for (k, slot) in group[..L::LANES].iter().enumerate() {
            a[k] = &rows.own[slot.owner()];
            b[k] = rows.ahead(slot.partner as usize - first_row);
            touched |= (slot.state & TOUCHING) >> TOUCHING.trailing_zeros() << k;
            if A::ACTIVE {
                held |= u32::from(slot.state & WITH_HISTORY != 0) << k;
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
            let cell = self.context.cell;
            offset -= Vector::gather(|k| cell.shift(group[k].state & IMAGE).into());
        }
        let squared = offset.length_squared();
        let mut acts = squared.below(reach * reach).bits();
        if A::ACTIVE {
            for (k, slot) in group[..L::LANES].iter().enumerate() {
                let (squared, reach) = (squared.lane(k), reach.lane(k));
                let at = (first_row, reach);
                acts |= u32::from(self.acts_apart(a[k], b[k], slot, squared, at)) << k;
            }
        }
        let places = packed_places(acts).wrapping_add(base as u32 * 0x0101_0101);
        found.numbers.slot[*count % ROOM..][..MOST_LANES].copy_from_slice(&places.to_le_bytes());
        found.numbers.offset[0].put(*count, offset.x.packed(acts));
        found.numbers.offset[1].put(*count, offset.y.packed(acts));
        found.numbers.offset[2].put(*count, offset.z.packed(acts));
        found.numbers.squared.put(*count, squared.packed(acts));
        found.numbers.reach.put(*count, reach.packed(acts));
        *count += acts.count_ones() as usize;
        if A::ACTIVE {
            // Whether a contact has just begun is known after its law has been evaluated.
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

    /// The laws of some contacts: their forces and torques, and their histories one step on. A repeated contact is evaluated
    /// twice and gives identical results.
    #[inline(always)]
    fn act<L: Real, const WATCHED: bool>(
        &self,
        slots: &mut [Slot<Histories<N, T, R, A>>],
        (first_row, first_slot): (usize, usize),
        found: &mut ContactBatch<'_>,
        some: Range<usize>,
        (observation, events): (&mut Observation, &mut SlotEvents<Histories<N, T, R, A>>),
    ) {
        let dt = self.context.spring_time;
        let mut base = some.start;
        while base < some.end {
            let at = found.slots(base);
            let pair = |k: usize| found.numbers.pair[(base + k) % ROOM] as usize;
            let (contact, levers) = found.meet::<L, T, R, A>(base, &at);
            let one_law = (1..L::LANES).all(|k| pair(k) == pair(0));
            let mut before = [Default::default(); MOST_LANES];
            if WATCHED {
                for k in 0..L::LANES {
                    before[k] = slots[at[k]].history;
                }
            }
            let mut touching = L::ZERO.below(contact.overlap).bits();
            if A::JOINS {
                for k in 0..L::LANES {
                    let law = &self.laws[pair(k)];
                    let touches = law.touches(&contact.lane(k), &slots[at[k]].history);
                    touching |= u32::from(touches) << k;
                }
            }
            let all_touch = !A::ACTIVE || touching == (1 << L::LANES) - 1;
            let one_kind = all_touch || touching == 0;
            let touches = |k: usize| !A::ACTIVE || touching >> k & 1 == 1;
            // Which of them have an event, where they are of one kind.
            let mut happens = 0;
            let action = if one_law && one_kind {
                // Without adhesion the same code as ever: one more layer of closures is not always inlined.
                let mut history = if A::ACTIVE && all_touch {
                    History::gather_touching(|k| &slots[at[k]].history)
                } else {
                    History::gather_from(|k| &slots[at[k]].history)
                };
                let law = &self.laws[pair(0)];
                let action = if all_touch {
                    law.act(&contact, dt, &mut history)
                } else {
                    law.act_apart(&contact, dt, &mut history)
                };
                if A::HAS_EVENTS {
                    happens = law.adhesion.event(&contact, &history.3).bits();
                }
                for (k, &at) in at[..L::LANES].iter().enumerate() {
                    history.put(k, &mut slots[at].history);
                }
                action
            } else {
                // Each law to its lane; a repeated contact must find its history as it was.
                let mut own = [Default::default(); MOST_LANES];
                for (own, &at) in own[..L::LANES].iter_mut().zip(&at) {
                    *own = slots[at].history;
                }
                let mut actions = [Action::NONE; MOST_LANES];
                for k in 0..L::LANES {
                    let (law, contact) = (&self.laws[pair(k)], contact.lane(k));
                    actions[k] = if touches(k) {
                        law.act(&contact, dt, &mut own[k])
                    } else {
                        law.act_apart(&contact, dt, &mut own[k])
                    };
                    slots[at[k]].history = own[k];
                    if A::HAS_EVENTS {
                        let happened = law.adhesion.event(&contact, &own[k].3);
                        happens |= u32::from(happened) << k;
                    }
                }
                Action::gather(|k| actions[k])
            };
            if A::ACTIVE {
                for (k, &at) in at[..L::LANES].iter().enumerate() {
                    let slot = &mut slots[at];
                    slot.state =
                        slot.state & !WITH_HISTORY | with_history(touches(k), &slot.history.3);
                }
            }
            if A::HAS_EVENTS && happens != 0 {
                for k in (0..L::LANES).filter(|k| happens >> k & 1 == 1) {
                    // One that fills up a group is there twice.
                    if !at[..k].contains(&at[k]) {
                        events.push(SlotEvent::Pair {
                            slot: (first_slot + at[k]) as u32,
                        });
                    }
                }
            }
            put(action.force, &mut found.numbers.force[base..]);
            if PairLaw::<N, T, R, A>::TURNS {
                let turning = contact.normal.cross(action.shear(A::SHEARS));
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
                    observation.particle_contacts += u64::from(touches(k));
                    let site = ContactSite {
                        pair: pair(k),
                        row: first_row + slot.owner(),
                        partner,
                        sheet: None,
                        joined: None,
                        b: Some(b),
                        feature: FREE,
                        lever: levers[0].lane(k),
                        depth: contact.overlap / a.radius.min(b.radius),
                        touches: touches(k),
                    };
                    let histories = [before[k], slot.history];
                    self.see(observation, a, site, &contact, &action.lane(k), histories);
                }
            }
            base += L::LANES;
        }
    }

    /// Replaces the effective masses of the contacts up to `end` by those at the contact points. Separate from the evaluation,
    /// where even a call that is never made costs registers.
    #[inline(never)]
    fn masses_at_contacts(
        &self,
        bodies: &Bodies,
        slots: &[Slot<Histories<N, T, R, A>>],
        first_row: usize,
        rows: &Rows<'_>,
        found: &mut ContactBatch<'_>,
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
    pub(super) fn acts_apart<H>(
        &self,
        a: &Particle,
        b: &Particle,
        slot: &Slot<H>,
        squared: f64,
        (first_row, reach): (usize, f64),
    ) -> bool {
        if !A::ACTIVE {
            return false;
        }
        let pair = a.material.index() * self.materials + b.material.index();
        let law = &self.laws[pair].adhesion;
        let has_memory = slot.state & WITH_HISTORY != 0;
        if law.forms_on_contact() && !has_memory {
            let Some(films) = self.films.filter(|_| A::HAS_EVENTS) else {
                return false;
            };
            let [own, other] = [first_row + slot.owner(), slot.partner as usize];
            let (one, two) = (films[own], films[other]);
            let range = reach + one[0] + two[0];
            if squared > range * range {
                return false;
            }
            return one[1] + two[1] >= law.least_films();
        }
        if A::HAS_EVENTS && law.forms_on_contact() || A::JOINS && has_memory {
            // At any distance, so that the end of adhesion is seen.
            return true;
        }
        let range = reach + law.range();
        squared < range * range
    }

    /// x_A - x_B, of the image of B that is listed, m.
    pub(super) fn offset<H>(&self, a: &Particle, b: &Particle, slot: &Slot<H>) -> DVec3 {
        a.position - b.position - self.context.cell.shift(slot.state & IMAGE)
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

    /// Clears the bits of all but the first `count`.
    fn keep_first(&mut self, count: usize) {
        let first = (1 << count) - 1;
        self.begin &= first;
        self.end &= first;
    }

    /// Changes the states; histories of contacts that have ended are cleared.
    #[inline(always)]
    fn make<H: History>(self, group: &mut [Slot<H>]) {
        for (k, slot) in group.iter_mut().enumerate() {
            if self.begin >> k & 1 == 1 {
                slot.state |= TOUCHING;
            }
            if self.end >> k & 1 == 1 {
                slot.state &= !WITH_HISTORY;
                slot.history = H::default();
            }
        }
    }
}

/// The places of the bits that are set, one after the other from the lowest byte on.
#[inline(always)]
fn packed_places(bits: u32) -> u32 {
    const SETS: usize = 1 << MOST_LANES;
    const PLACES: [u32; SETS] = {
        let mut places = [0; SETS];
        let mut bits = 0;
        while bits < SETS {
            let (mut place, mut count) = (0, 0);
            while place < MOST_LANES {
                if bits >> place & 1 == 1 {
                    places[bits] |= (place as u32) << (8 * count);
                    count += 1;
                }
                place += 1;
            }
            bits += 1;
        }
        places
    };
    PLACES[bits as usize & (SETS - 1)]
}

/// Writes lane `k` of a vector to `quads[k]`.
#[inline(always)]
fn put<L: Real>(vector: Vector<L>, quads: &mut [Quad]) {
    let rows = L::rows(vector, L::ZERO);
    quads[..L::LANES].copy_from_slice(&rows[..L::LANES]);
}
