//! Contacts of glued pairs: only what they overlap more than when they were glued counts.

use super::contact_batch::ContactBatch;
use super::pass::{Pass, Rows};
use super::slot_events::SlotEvents;
use super::slots::{Slot, WITH_HISTORY};
use crate::contact::{AdhesionLaw, Histories, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::OverlapOffsets;

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// Shortens the reach of the glued pairs among the first `count` contacts found in a chunk of slots, takes out those that act no more, and ends
    /// what they remember; returns how many are left. Only distances below the reach count as overlaps.
    #[cold]
    #[inline(never)]
    pub(super) fn take_off_overlaps(
        &self,
        offsets: &OverlapOffsets,
        slots: &mut [Slot<Histories<N, T, R, A>>],
        (first_row, rows): (usize, &Rows<'_>),
        (found, count): (&mut ContactBatch<'_>, usize),
        events: &mut SlotEvents<Histories<N, T, R, A>>,
    ) -> usize {
        let mut kept = 0;
        for k in 0..count {
            let slot = &mut slots[usize::from(found.numbers.slot[k])];
            let (row, partner) = (first_row + slot.owner(), slot.partner as usize);
            let offset = offsets.of_pair(row, partner);
            if offset > 0.0 {
                let reach = found.numbers.reach.0[k] - offset;
                let squared = found.numbers.squared.0[k];
                let (a, b) = (&rows.own[slot.owner()], rows.ahead(partner - first_row));
                let acts = squared < reach * reach
                    || self.acts_apart(a, b, slot, squared, (first_row, reach));
                if !acts {
                    events.extend(Self::gone(row, slot));
                    slot.state &= !WITH_HISTORY;
                    slot.history = Histories::<N, T, R, A>::default();
                    continue;
                }
                found.numbers.reach.0[k] = reach;
            }
            found.numbers.keep(k, kept);
            kept += 1;
        }
        kept
    }
}
