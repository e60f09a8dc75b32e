//! Contacts between particles: found without a branch, then evaluated.

use glam::DVec3;

use super::contact_point::mobility;
use super::slots::{FREE, HELD, IMAGE, Slot, TOUCHING, held};
use super::{Block, ContactSite, Pass, Rows};
use crate::contact::{AdhesionLaw, Contact, Histories, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::Partner;
use crate::state::{Bodies, Load, Particle};

/// Slots that are searched for contacts before the contacts found are evaluated.
const CHUNK: usize = 128;

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    pub(super) fn pairs<const PERIODIC: bool, const WATCHED: bool>(
        &self,
        block: &mut Block<Histories<N, T, R, A>>,
        rows: &Rows<'_>,
        loads: &mut [Load],
    ) {
        let first_row = block.rows.start;
        let mut found = Found::NOTHING;
        for slots in block.slots.chunks_mut(CHUNK) {
            // Which slots touch can hardly be predicted; finding them without a branch first keeps the processor from
            // throwing away half-done contacts.
            let mut count = 0;
            for (k, slot) in slots.iter_mut().enumerate() {
                let a = &rows.own[slot.owner()];
                let b = rows.ahead(slot.partner as usize - first_row);
                let squared = self.offset::<PERIODIC, _>(a, b, slot).length_squared();
                let reach = a.radius + b.radius;
                let acts = squared < reach * reach || self.acts_apart(a, b, slot, squared, reach);
                found.slot[count] = k as u32;
                found.distance[count] = squared;
                found.reach[count] = reach;
                found.radius[count] = a.radius * b.radius;
                found.mass[count] = a.inverse_mass + b.inverse_mass;
                count += usize::from(acts);
                if !acts && slot.state & HELD != 0 {
                    slot.state &= !HELD;
                    slot.history = Default::default();
                }
            }
            if found.evaluate(count, self.context.overlap_limit) {
                let contacts =
                    (0..count).map(|k| (found.slot[k], found.distance[k], found.reach[k]));
                self.alarm_pairs(&mut block.alarms, slots, (first_row, rows), contacts);
            }
            if let Some(bodies) = self.bodies {
                self.masses_at_contacts(bodies, slots, first_row, rows, &mut found, count);
            }
            for k in 0..count {
                let slot = &mut slots[found.slot[k] as usize];
                let owner = slot.owner();
                let a = &rows.own[owner];
                let b = rows.ahead(slot.partner as usize - first_row);
                let offset = self.offset::<PERIODIC, _>(a, b, slot);
                let (contact, lever_a, lever_b) = meet::<T, R>(a, b, offset, &found, k);
                let pair = a.material.index() * self.materials + b.material.index();
                let law = &self.laws[pair];
                let before = slot.history;
                let dt = self.context.spring_time;
                let touches = !A::ACTIVE || contact.overlap > 0.0;
                let action = if touches {
                    law.act(&contact, dt, &mut slot.history)
                } else {
                    law.act_apart(&contact, dt, &mut slot.history)
                };
                if A::ACTIVE {
                    slot.state = slot.state & !HELD | held(touches, &slot.history.3);
                } else {
                    slot.state |= TOUCHING;
                }
                let force = DVec3::from(action.force);
                let ahead = slot.partner as usize - first_row;
                if T::ACTIVE || R::ACTIVE {
                    let turning = contact.normal.cross(action.tangential);
                    let torque = action.couple - turning * lever_a;
                    loads[owner].add(force, torque.into());
                    let torque = DVec3::from(-action.couple - turning * lever_b);
                    match loads.get_mut(ahead) {
                        Some(partner) => partner.add(-force, torque),
                        None => block.outbox.park(
                            ahead - self.block_size,
                            self.block_size,
                            -force,
                            torque,
                        ),
                    }
                } else {
                    // Nothing turns the particles.
                    loads[owner].force += force;
                    match loads.get_mut(ahead) {
                        Some(partner) => partner.force -= force,
                        None => block.outbox.park(
                            ahead - self.block_size,
                            self.block_size,
                            -force,
                            DVec3::ZERO,
                        ),
                    }
                }
                if WATCHED {
                    let partner = Partner::Particle {
                        row: slot.partner,
                        image: slot.state & IMAGE,
                    };
                    block.observation.particle_contacts += u64::from(touches);
                    let depth = contact.overlap / a.radius.min(b.radius);
                    let site = ContactSite {
                        pair,
                        row: first_row + owner,
                        partner,
                        b: Some(b),
                        feature: FREE,
                        lever: lever_a,
                        depth,
                        touches,
                    };
                    let histories = [before, slot.history];
                    self.see(
                        &mut block.observation,
                        a,
                        site,
                        &contact,
                        &action,
                        histories,
                    );
                }
            }
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
        found: &mut Found,
        count: usize,
    ) {
        for k in 0..count {
            let slot = &slots[found.slot[k] as usize];
            let (row, partner) = (first_row + slot.owner(), slot.partner as usize);
            let (a, b) = (&rows.own[slot.owner()], rows.ahead(partner - first_row));
            let normal = self.offset::<true, _>(a, b, slot) * found.inverse_distance[k];
            let inverse = mobility(bodies, row, a, normal) + mobility(bodies, partner, b, normal);
            found.mass[k] = 1.0 / inverse;
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
    #[inline(always)]
    pub(super) fn offset<const PERIODIC: bool, H>(
        &self,
        a: &Particle,
        b: &Particle,
        slot: &Slot<H>,
    ) -> DVec3 {
        let offset = a.position - b.position;
        if PERIODIC {
            offset - self.context.images.shift(slot.state & IMAGE)
        } else {
            offset
        }
    }
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

    /// Takes the second step for the first `count` contacts. Says whether one of them may overlap by more than `limit` of the smaller radius, which is
    /// at least R*.
    #[inline(always)]
    fn evaluate(&mut self, count: usize, limit: f64) -> bool {
        let count = count.min(CHUNK);
        let mut is_deep = false;
        for k in 0..count {
            let distance = self.distance[k].sqrt();
            self.distance[k] = distance;
            self.inverse_distance[k] = 1.0 / distance;
            self.radius[k] /= self.reach[k];
            self.mass[k] = 1.0 / self.mass[k];
            is_deep |= self.reach[k] - distance > limit * self.radius[k];
        }
        is_deep
    }
}

/// Geometry and kinematics of two particles that overlap or act across a gap, contact `k` of those found, and the lever arms R - overlap/2 of
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
        normal: normal.into(),
        distance,
        overlap,
        effective_radius: found.radius[k],
        effective_mass: found.mass[k],
        normal_velocity,
        tangential_velocity: tangential_velocity.into(),
        centre_velocity: centre_velocity.into(),
        spin: spin.into(),
    };
    (contact, lever_a, lever_b)
}
