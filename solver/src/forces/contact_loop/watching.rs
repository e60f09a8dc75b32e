//! What is seen of a contact in the steps that are written out or audited.

use glam::DVec3;

use super::{ContactSite, Pass};
use crate::contact::{
    Action, AdhesionLaw, Contact, Histories, History, NormalLaw, RollingLaw, TangentialLaw,
};
use crate::forces::{ContactRecord, Observation, Partner};
use crate::neighbours::opposite;
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
        observation.elastic_energy += if site.touches {
            law.energy(contact, &after)
        } else {
            law.adhesion.energy(contact, &after.3)
        };
        observation.largest_overlap = observation.largest_overlap.max(site.depth);
        let Some(watch) = self.context.watch else {
            return;
        };
        if let Some(dt) = watch.audit
            && A::ACTIVE
        {
            observation.dissipated_normal +=
                law.adhesion_loss(contact, action, &before, &after, dt);
        }
        if let Some(dt) = watch.audit
            && site.touches
        {
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
            // As in the sliding loss, springs count at the stiffness of their own time.
            let stiffness = law.tangential.stiffness(contact);
            observation.dissipated_tangential +=
                law.sliding_loss(contact, action, &before, &after, dt);
            if R::ACTIVE {
                let gain = law.rolling.energy(stiffness, &after.2)
                    - law
                        .rolling
                        .energy(law.tangential.stiffness(&last), &before.2);
                observation.dissipated_rolling -= action.couple.dot(contact.spin) * dt + gain;
            }
        }
        if watch.records {
            let record = self.record(a, site, contact, action, after);
            observation.records.push(record);
        }
    }

    /// The record of a contact, of two particles from the side of the lower id: an order that sorting does not change.
    fn record(
        &self,
        a: &Particle,
        site: ContactSite<'_>,
        contact: &Contact,
        action: &Action,
        memory: Histories<N, T, R, A>,
    ) -> ContactRecord {
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
            memory = memory.swapped();
        }
        if site.touches {
            record.tangential_overlap = law.tangential.tangential_overlap(contact, &memory.1);
        }
        record.history = self.memory.show(site.pair, &memory);
        record
    }
}
