//! Contacts beyond a limit: found by a comparison in the loop, named here, apart from it.

use super::pass::{Pass, Rows};
use super::sheets::AtSheet;
use super::sides::THROUGH_OR_BEHIND;
use super::slots::{BEHIND, Slot, THROUGH};
use super::walls::WallSide;
use crate::contact::{AdhesionLaw, Histories, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::{Alarm, AlarmKind, Alarms, Other, Subject};
use crate::state::Particle;
use crate::walls::{Touch, WallNow};

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// Names the contacts of a chunk of slots that overlap too much, if any. `contacts`: slot and overlap (m) of each.
    #[cold]
    #[inline(never)]
    pub(super) fn alarm_pairs(
        &self,
        alarms: &mut Alarms,
        slots: &[Slot<Histories<N, T, R, A>>],
        (first_row, rows): (usize, &Rows<'_>),
        contacts: impl Iterator<Item = (u8, f64)>,
    ) {
        for (slot, overlap) in contacts {
            let slot = &slots[usize::from(slot)];
            let (row, partner) = (first_row + slot.owner(), slot.partner as usize);
            let (a, b) = (&rows.own[slot.owner()], rows.ahead(partner - first_row));
            let radius = a.radius.min(b.radius);
            if overlap > self.context.overlap_limit * radius {
                let offset = self.offset(a, b, slot);
                let alarm = Alarm {
                    of: Subject::Particle(self.ids[row]),
                    other: Other::Particle(self.ids[partner]),
                    position: a.position,
                    radius,
                    overlap,
                    speed: (b.velocity - a.velocity).dot(offset.normalize_or_zero()),
                };
                alarms.note(AlarmKind::Overlap, alarm);
            }
        }
    }

    /// Whether a touch of a wall is beyond a limit; `at`: the bits of its side.
    #[inline(always)]
    pub(super) fn is_alarming(&self, a: &Particle, wall: &WallNow, touch: &Touch, at: u32) -> bool {
        let overlap = a.radius + wall.half_thickness() - touch.distance;
        at & THROUGH_OR_BEHIND != 0 || overlap > self.context.deep * a.radius
    }

    /// Names a touch of a wall.
    #[cold]
    #[inline(never)]
    pub(super) fn alarm_wall(
        &self,
        alarms: &mut Alarms,
        a: &Particle,
        (side, sheet): (&WallSide<'_>, Option<&AtSheet<'_>>),
        touch: &Touch,
        at: u32,
    ) {
        if self.context.overlap_limit.is_infinite() {
            return;
        }
        let reach = a.radius + side.wall.half_thickness();
        let normal = side.state.out_of_wall(touch.normal);
        let velocity = a.velocity - side.velocity(sheet, touch.feature, side.centre);
        // On a surface that acts on both sides the distance has no sign: a step before, it was on the other side.
        let last = touch.distance - velocity.dot(normal) * self.context.spring_time;
        let has_crossed = at != THROUGH && last < 0.0 && !side.wall.shape().is_one_sided();
        let kind = if at == BEHIND {
            AlarmKind::Behind
        } else if at == THROUGH || touch.distance < 0.0 || has_crossed {
            AlarmKind::Through
        } else if reach - touch.distance > self.context.overlap_limit * a.radius {
            AlarmKind::Overlap
        } else {
            return;
        };
        // The normal points to the side from which the particle came.
        let front = if has_crossed { -1.0 } else { 1.0 };
        let alarm = Alarm {
            of: self.subject(side.near.row),
            other: Other::Wall(side.near.wall),
            position: a.position,
            radius: a.radius,
            overlap: reach - front * touch.distance,
            speed: -front * velocity.dot(normal),
        };
        alarms.note(kind, alarm);
    }

    /// The particle or vertex of a row.
    fn subject(&self, row: u32) -> Subject {
        match self.sheet {
            None => Subject::Particle(self.ids[row as usize]),
            Some(surface) => Subject::Vertex {
                surface,
                vertex: row,
            },
        }
    }
}
