//! Pairs that a sheet separates: they do not act on each other.
//!
//! Two particles that press on a sheet from either side may reach through it, as it is thinner than their overlaps. A sheet separates a pair if the line
//! between the centres leads through it. Only pairs of which one is near a sheet are tested, and of these only those that would act.

use glam::DVec3;

use super::contact_batch::ContactBatch;
use super::pass::{Pass, Rows};
use super::slot_events::SlotEvents;
use super::slots::{Slot, WITH_HISTORY};
use crate::contact::{AdhesionLaw, Histories, NormalLaw, RollingLaw, TangentialLaw};
use crate::walls::{Scratch, Shape};

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// Takes the pairs that a sheet separates out of the first `count` contacts found in a chunk of slots, and ends what they remember; returns
    /// how many are left. `beside`: whether each row is near a sheet; rows that it lacks may be.
    #[cold]
    #[inline(never)]
    pub(super) fn leave_out_separated(
        &self,
        beside: &[bool],
        slots: &mut [Slot<Histories<N, T, R, A>>],
        (first_row, rows): (usize, &Rows<'_>),
        (found, count): (&mut ContactBatch<'_>, usize),
        events: &mut SlotEvents<Histories<N, T, R, A>>,
    ) -> usize {
        let is_beside = |row: usize| beside.get(row).copied().unwrap_or(true);
        let mut scratch = Scratch::default();
        let mut kept = 0;
        for k in 0..count {
            let slot = &mut slots[usize::from(found.numbers.slot[k])];
            let (row, partner) = (first_row + slot.owner(), slot.partner as usize);
            if is_beside(row) || is_beside(partner) {
                let from = rows.own[slot.owner()].position;
                let [x, y, z] = [0, 1, 2].map(|axis| found.numbers.offset[axis].0[k]);
                if self.is_separated(from, DVec3::new(-x, -y, -z), &mut scratch) {
                    events.extend(Self::gone(row, slot));
                    slot.state &= !WITH_HISTORY;
                    slot.history = Histories::<N, T, R, A>::default();
                    continue;
                }
            }
            found.numbers.keep(k, kept);
            kept += 1;
        }
        kept
    }

    /// Whether the way from a centre (m) to another one leads through a sheet.
    fn is_separated(&self, from: DVec3, way: DVec3, scratch: &mut Scratch) -> bool {
        let sheets = (self.context.walls.iter()).filter(|wall| wall.surface().is_some());
        for wall in sheets {
            let Shape::Mesh(mesh) = wall.shape() else {
                continue;
            };
            for &code in wall.met_by() {
                let image = wall.image_of(from, code);
                let start = (wall.state).into_wall(from + self.context.cell.any_shift(image));
                if mesh.is_crossed(start, start + way, scratch) {
                    return true;
                }
            }
        }
        false
    }
}
