//! Contacts between particles: found without a branch, then evaluated, both several at once.
//!
//! A chunk of slots goes through four stages, each a short loop without long chains of dependent numbers:
//!
//!     search    which of the two of a slot touch; their offset
//!     prepare   velocities; roots and divisions that need nothing but sizes and distances
//!     act       the laws, histories one step on
//!     share     forces and torques to both, in the order of the slots
//!
//! The first three work in lanes; nothing is summed up there, so that their number changes no bit.

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

/// All listed pairs of one block.
pub(super) struct Pairs<'p, 'a, N, T, R, A, H, const PERIODIC: bool, const WATCHED: bool> {
    pub(super) pass: &'p Pass<'a, N, T, R, A>,
    pub(super) block: &'p mut Block<H>,
    pub(super) rows: &'p Rows<'p>,
    pub(super) loads: &'p mut [Load],
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
        } = self;
        let Some(nobody) = rows.own.first() else {
            return;
        };
        let mut found = Found::new(nobody);
        let first_row = block.rows.start;
        for slots in block.slots.chunks_mut(CHUNK) {
            let count = pass.search::<L, PERIODIC>(slots, first_row, rows, &mut found);
            if found.prepare::<L>(count, pass.context.overlap_limit) {
                let contacts = (0..count)
                    .map(|k| (u32::from(found.slot[k]), found.distance[k], found.reach[k]));
                pass.alarm_pairs(&mut block.alarms, slots, (first_row, rows), contacts);
            }
            if let Some(bodies) = pass.bodies {
                pass.masses_at_contacts(bodies, slots, first_row, rows, &mut found, count);
            }
            let observation = &mut block.observation;
            pass.act::<L, WATCHED>(slots, first_row, &mut found, count, observation);
            for (k, &slot) in found.slot[..count].iter().enumerate() {
                let slot = &slots[usize::from(slot)];
                let owner = &mut loads[slot.owner()];
                let force = found.force[k];
                let ahead = slot.partner as usize - first_row;
                if T::ACTIVE || R::ACTIVE {
                    let [on_a, on_b] = [found.torques[0][k], found.torques[1][k]];
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
        let (mut count, mut base, last) = (0, 0, slots.len() - 1);
        while base <= last {
            let (mut a, mut b) = ([found.a[0]; MOST_LANES], [found.b[0]; MOST_LANES]);
            let (mut had, mut shifted) = (0, 0);
            for k in 0..L::LANES {
                // The last group is filled up with the last slot.
                let slot = &slots[(base + k).min(last)];
                a[k] = &rows.own[slot.owner()];
                b[k] = rows.ahead(slot.partner as usize - first_row);
                had |= u32::from(slot.state & HELD != 0) << k;
                if PERIODIC {
                    shifted |= (slot.state & IMAGE) ^ NO_SHIFT;
                }
            }
            found.a[base..base + L::LANES].copy_from_slice(&a[..L::LANES]);
            found.b[base..base + L::LANES].copy_from_slice(&b[..L::LANES]);
            let [x, y, z, reach] = L::differences(|k| &a[k].quads()[0], |k| &b[k].quads()[0]);
            let mut offset = Vector::new(x, y, z);
            if PERIODIC && shifted != 0 {
                let images = self.context.images;
                let shift = |k: usize| {
                    let slot = &slots[(base + k).min(last)];
                    images.shift(slot.state & IMAGE).into()
                };
                offset -= Vector::gather(shift);
            }
            let squared = offset.length_squared();
            let mut acts = squared.below(reach * reach).bits();
            if A::ACTIVE {
                for k in 0..L::LANES {
                    let slot = &slots[(base + k).min(last)];
                    let (squared, reach) = (squared.lane(k), reach.lane(k));
                    let act = self.acts_apart(a[k], b[k], slot, squared, reach);
                    acts |= u32::from(act) << k;
                }
            }
            acts &= ((1u64 << (last + 1 - base).min(L::LANES)) - 1) as u32;
            let mut end = count;
            for k in 0..L::LANES {
                // Where it does not act the next one that does takes its place.
                found.slot[end % ROOM] = (base + k) as u8;
                end += (acts >> k & 1) as usize;
            }
            found.offset[0].put(count, offset.x.packed(acts));
            found.offset[1].put(count, offset.y.packed(acts));
            found.offset[2].put(count, offset.z.packed(acts));
            found.distance.put(count, squared.packed(acts));
            found.reach.put(count, reach.packed(acts));
            count = end;
            let ended = had & !acts;
            if ended != 0 {
                forget(slots, base, ended, L::LANES);
            }
            base += L::LANES;
        }
        // The last group is filled up with the last contact, so that all lanes hold numbers.
        if count > 0 {
            found.fill_up::<L>(count);
        }
        count
    }

    /// The laws of the first `count` contacts found: their forces and torques, and their histories one step on.
    #[inline(always)]
    fn act<L: Real, const WATCHED: bool>(
        &self,
        slots: &mut [Slot<Histories<N, T, R, A>>],
        first_row: usize,
        found: &mut Found<'_>,
        count: usize,
        observation: &mut Observation,
    ) {
        let dt = self.context.spring_time;
        let mut base = 0;
        while base < count {
            let at = found.slots(base);
            let lanes = (count - base).min(L::LANES);
            let pair = |k: usize| {
                let (a, b) = (found.a[at[k] % ROOM], found.b[at[k] % ROOM]);
                a.material.index() * self.materials + b.material.index()
            };
            let (contact, levers) = found.meet::<L, T, R>(base, &at);
            let one_law = self.materials == 1 || (1..L::LANES).all(|k| pair(k) == pair(0));
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
                for (k, &at) in at[..lanes].iter().enumerate() {
                    slots[at].history = history.lane(k);
                }
                action
            } else {
                // Each law to its lane.
                let mut actions = [Action::NONE; MOST_LANES];
                for (k, &at) in at[..lanes].iter().enumerate() {
                    let law = &self.laws[pair(k)];
                    actions[k] = law.act(&contact.lane(k), dt, &mut slots[at].history);
                }
                Action::gather(|k| actions[k])
            };
            for &at in &at[..lanes] {
                let slot = &mut slots[at];
                if A::ACTIVE {
                    slot.state = slot.state & !HELD | held(touches, &slot.history.3);
                } else {
                    slot.state |= TOUCHING;
                }
            }
            put(action.force, &mut found.force[base..]);
            if T::ACTIVE || R::ACTIVE {
                let turning = contact.normal.cross(action.tangential);
                let on_a = action.couple - turning * levers[0];
                let on_b = -action.couple - turning * levers[1];
                put(on_a, &mut found.torques[0][base..]);
                put(on_b, &mut found.torques[1][base..]);
            }
            if WATCHED {
                for (k, &at) in at[..lanes].iter().enumerate() {
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

    /// Replaces the effective masses of the first `count` contacts found by those at the contact points. Apart from the evaluation,
    /// where even a call that is never made costs registers.
    #[inline(never)]
    fn masses_at_contacts(
        &self,
        bodies: &Bodies,
        slots: &[Slot<Histories<N, T, R, A>>],
        first_row: usize,
        rows: &Rows<'_>,
        found: &mut Found<'_>,
        count: usize,
    ) {
        for k in 0..count {
            let slot = &slots[usize::from(found.slot[k])];
            let (row, partner) = (first_row + slot.owner(), slot.partner as usize);
            let (a, b) = (&rows.own[slot.owner()], rows.ahead(partner - first_row));
            let offset = DVec3::from_array([0, 1, 2].map(|axis| found.offset[axis].0[k]));
            let normal = offset * found.inverse_distance.0[k];
            let inverse = mobility(bodies, row, a, normal) + mobility(bodies, partner, b, normal);
            found.mass.0[k] = 1.0 / inverse;
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

/// Forgets the histories of slots behind `base` whose bits are set.
#[inline(always)]
fn forget<H: History>(slots: &mut [Slot<H>], base: usize, bits: u32, lanes: usize) {
    for k in 0..lanes {
        if bits >> k & 1 == 1
            && let Some(slot) = slots.get_mut(base + k)
        {
            slot.state &= !HELD;
            slot.history = H::default();
        }
    }
}

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

impl std::ops::Index<usize> for Column {
    type Output = f64;

    fn index(&self, k: usize) -> &f64 {
        &self.0[k]
    }
}

/// The contacts found in a chunk of slots.
struct Found<'a> {
    /// The two of every slot of the chunk.
    a: [&'a Particle; ROOM],
    b: [&'a Particle; ROOM],
    /// Of each contact, as all that follows: its slot in the chunk.
    slot: [u8; ROOM],
    /// x_A - x_B, of the image of B that is listed, m.
    offset: [Column; 3],
    /// First the squared distance, then the distance, m.
    distance: Column,
    /// One over the distance, 1/m.
    inverse_distance: Column,
    /// R_A + R_B, m.
    reach: Column,
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

impl<'a> Found<'a> {
    /// Nothing yet; `nobody` stands for all.
    fn new(nobody: &'a Particle) -> Self {
        Self {
            a: [nobody; ROOM],
            b: [nobody; ROOM],
            slot: [0; ROOM],
            offset: [Column::ZERO; 3],
            distance: Column::ZERO,
            inverse_distance: Column::ZERO,
            reach: Column::ZERO,
            radius: Column::ZERO,
            mass: Column::ZERO,
            velocity: [Column::ZERO; 3],
            force: [Quad::default(); ROOM],
            torques: [[Quad::default(); ROOM]; 2],
        }
    }

    /// The slots of the contacts from `base` on.
    #[inline(always)]
    fn slots(&self, base: usize) -> [usize; MOST_LANES] {
        std::array::from_fn(|k| usize::from(self.slot[(base + k) % ROOM]))
    }

    /// Repeats the last of the first `count` > 0 contacts behind them, as often as the last group has lanes to spare.
    #[inline(always)]
    fn fill_up<L: Real>(&mut self, count: usize) {
        let last = count - 1;
        for k in count..count.next_multiple_of(L::LANES) {
            self.slot[k] = self.slot[last];
            for axis in &mut self.offset {
                axis.0[k] = axis.0[last];
            }
            self.distance.0[k] = self.distance.0[last];
            self.reach.0[k] = self.reach.0[last];
        }
    }

    /// Velocities, masses and radii of the first `count` contacts, with the roots and divisions that need nothing else: all of them at once
    /// and ahead of the long chains of each contact. Says whether one of them may overlap by more than `limit` of the smaller radius, which is
    /// at least R*.
    #[inline(always)]
    fn prepare<L: Real>(&mut self, count: usize, limit: f64) -> bool {
        let mut is_deep = 0;
        let mut base = 0;
        while base < count {
            let at = self.slots(base);
            let (a, b) = (
                |k: usize| self.a[at[k] % ROOM],
                |k: usize| self.b[at[k] % ROOM],
            );
            let [x, y, z, mobility] = L::differences(|k| &a(k).quads()[1], |k| &b(k).quads()[1]);
            let radii = L::from_lanes(|k| a(k).radius) * L::from_lanes(|k| b(k).radius);
            let (distance, reach): (L, L) =
                (self.distance.at::<L>(base).sqrt(), self.reach.at(base));
            let radius = radii / reach;
            is_deep |= (radius * limit).below(reach - distance).bits();
            self.velocity[0].put(base, x);
            self.velocity[1].put(base, y);
            self.velocity[2].put(base, z);
            self.mass.put(base, L::ONE / mobility);
            self.radius.put(base, radius);
            self.distance.put(base, distance);
            self.inverse_distance.put(base, L::ONE / distance);
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
        let distance: L = self.distance.at(base);
        let offset: Vector<L> = columns(&self.offset, base);
        let mut normal = offset * self.inverse_distance.at(base);
        let apart = L::ZERO.below(distance);
        if !apart.all() {
            // Concentric particles have no normal; any will do to push them apart.
            normal = Vector::select(apart, normal, Vector::X);
        }
        let overlap = self.reach.at::<L>(base) - distance;
        let half = overlap * 0.5;
        let levers = [
            L::from_lanes(|k| a(k).radius) - half,
            L::from_lanes(|k| b(k).radius) - half,
        ];
        let centre_velocity: Vector<L> = columns(&self.velocity, base);
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
            effective_radius: self.radius.at(base),
            effective_mass: self.mass.at(base),
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
