//! Observation of a contact in the steps that are written out or audited.

use glam::DVec3;

use super::pass::{ContactSite, Pass};
use crate::cell::opposite;
use crate::contact::{
    Action, AdhesionLaw, Contact, Histories, History, NormalLaw, PairLaw, RollingLaw, TangentialLaw,
};
use crate::forces::{ContactRecord, Exchange, Observation, Partner, SpringEnergy};
use crate::state::Particle;

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// Adds a contact to an observation.
    #[inline(never)]
    pub(super) fn see(
        &self,
        observation: &mut Observation,
        a: &Particle,
        site: ContactSite<'_>,
        contact: &Contact,
        action: &Action,
        [before, after]: [Histories<N, T, R, A>; 2],
    ) {
        let law = &self.laws[site.pair];
        let mut stored = if site.touches {
            law.energy(contact, &after)
        } else {
            law.adhesion.energy(contact, &after.3)
        };
        if let Some(joined) = &site.joined {
            stored = joined.stored(stored, law.friction_energy(contact, &after));
        }
        observation.elastic_energy += stored;
        observation.largest_overlap = observation.largest_overlap.max(site.depth);
        let Some(watch) = self.context.watch else {
            return;
        };
        if let Some(dt) = watch.audit {
            self.audit(
                observation,
                a,
                &site,
                contact,
                action,
                [&before, &after],
                dt,
            );
        }
        // A pair that has just come apart is evaluated once more, for its losses.
        let is_over = !site.touches
            && after.3 == A::History::default()
            && DVec3::from(action.force) == DVec3::ZERO;
        if watch.records && !is_over {
            let record = self.record(a, site, contact, action, after);
            observation.records.push(record);
        }
    }

    /// Notes the loads of a contact, the energy of its springs, and the loss of its adhesion.
    fn audit(
        &self,
        observation: &mut Observation,
        a: &Particle,
        site: &ContactSite<'_>,
        contact: &Contact,
        action: &Action,
        [before, after]: [&Histories<N, T, R, A>; 2],
        dt: f64,
    ) {
        let law = &self.laws[site.pair];
        let normal = DVec3::from(contact.normal);
        let image = match site.partner {
            Partner::Particle { .. } => 0,
            Partner::Wall { image, .. } => image,
        };
        let arm = -normal * site.lever;
        let mut lossy = action.normal.viscous;
        if site.touches && !law.normal.is_elastic() {
            lossy += action.normal.elastic;
        }
        let left = |springs: SpringEnergy| match &site.joined {
            Some(joined) => joined.springs(&springs),
            None => springs,
        };
        let stored = left(springs(law, contact, after));
        observation.stored.add(&stored, 1.0);
        let mut next_stored = stored;
        if dt > 0.0 {
            let last = left(springs(law, &contact.one_step_before(dt), before));
            next_stored.add(&stored, 0.5);
            next_stored.add(&last, -0.5);
        }
        observation.exchanges.push(Exchange {
            row: site.row as u32,
            partner: site.partner,
            sheet: site.sheet,
            normal,
            levers: [
                site.lever,
                site.b.map_or(0.0, |b| b.radius - 0.5 * contact.overlap),
            ],
            point: a.position + self.context.cell.any_shift(image) + arm,
            force: action.force.into(),
            lossy,
            tangential: action.tangential.into(),
            adhesive: normal * action.adhesion.normal.viscous
                + DVec3::from(action.adhesion.tangential),
            couple: action.couple.into(),
            adhesive_couple: action.adhesion.couple.into(),
            next_stored,
        });
        if A::ACTIVE && dt > 0.0 {
            let last = contact.one_step_before(dt);
            let loss = law.adhesion_loss(contact, &last, action, [before, after]);
            if law.adhesion.is_dry() {
                observation.dissipated_by_adhesion += loss;
            } else {
                observation.dissipated_by_liquid += loss;
            }
        }
    }

    /// The record of a contact; for two particles as seen from the lower id, an order that sorting does not change.
    fn record(
        &self,
        a: &Particle,
        site: ContactSite<'_>,
        contact: &Contact,
        action: &Action,
        memory: Histories<N, T, R, A>,
    ) -> ContactRecord {
        let is_dry = self.laws[site.pair].adhesion.is_dry();
        let along = action.adhesion.normal.total();
        let mut record = ContactRecord {
            row: site.row as u32,
            partner: site.partner,
            feature: site.feature,
            point: a.position - DVec3::from(contact.normal * site.lever),
            normal: contact.normal.into(),
            overlap: contact.overlap,
            force: action.force.into(),
            tangential: action.tangential.into(),
            couple: action.couple.into(),
            tangential_overlap: 0.0,
            bridge_volume: 0.0,
            bridge_normal: if is_dry { 0.0 } else { along },
            bridge_shear: action.adhesion.tangential.into(),
            adhesion: if is_dry { along } else { 0.0 },
            history: Vec::new(),
        };
        let (law, mut memory) = (&self.laws[site.pair], memory);
        if let (Partner::Particle { row, image }, Some(b)) = (site.partner, site.b)
            && self.ids[row as usize] < self.ids[site.row]
        {
            record.row = row;
            record.partner = Partner::Particle {
                row: site.row as u32,
                image: opposite(image),
            };
            record.point = b.position + record.normal * (b.radius - 0.5 * contact.overlap);
            record.normal = -record.normal;
            record.force = -record.force;
            record.tangential = -record.tangential;
            record.couple = -record.couple;
            record.bridge_shear = -record.bridge_shear;
            memory = memory.swapped();
        }
        if site.touches {
            let contact = law.adhesion.as_hertz(contact);
            record.tangential_overlap = law.tangential.tangential_overlap(&contact, &memory.1);
        }
        record.history = self.memory.show(site.pair, &memory);
        record
    }
}

/// The energy that the springs of a contact store.
fn springs<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw>(
    law: &PairLaw<N, T, R, A>,
    contact: &Contact,
    memory: &Histories<N, T, R, A>,
) -> SpringEnergy {
    let mut stored = SpringEnergy::default();
    let touches = law.touches(contact, memory);
    let seen = if touches {
        law.adhesion.as_hertz(contact)
    } else {
        *contact
    };
    let contact = &seen;
    if A::ACTIVE && -contact.overlap < law.adhesion.range() {
        stored.normal += law.adhesion.energy(contact, &memory.3);
    }
    if touches {
        let normal = law.normal.energy(contact, &memory.0);
        if law.normal.is_elastic() {
            stored.normal += normal;
        } else {
            stored.plastic += normal;
        }
        stored.tangential += law.tangential.energy(contact, &memory.1);
        if R::ACTIVE {
            let stiffness = law.tangential.stiffness(contact);
            stored.rolling += law.rolling.energy(stiffness, &memory.2);
        }
    }
    stored
}
