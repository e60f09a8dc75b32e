//! Contacts that pass from one image of a wall to another, where the images form one surface.

use super::pass::Pass;
use super::slots::{FREE, WITH_HISTORY, WallSlot};
use crate::contact::{AdhesionLaw, Histories, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::NearWall;
use crate::state::Particle;
use crate::walls::{Touches, WallNow};

/// A contact continues by another image if the points of contact are this close, in radii.
const GOES_ON: f64 = 0.5;

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// Moves the histories of contacts with a wall that ended by one image to those that began by another one. `of_wall`: the
    /// images by which a particle is near the wall; their slots begin at `first`.
    pub(super) fn hand_over(
        &self,
        a: &Particle,
        wall: &WallNow,
        of_wall: &mut [NearWall],
        first: usize,
        slots: &mut Vec<WallSlot<Histories<N, T, R, A>>>,
    ) {
        if of_wall.len() < 2 || !wall.state.present {
            return;
        }
        let cell = self.context.cell;
        let (mut touches, mut scratch) = (Touches::default(), Touches::default());
        // Number of the image, and where its slots begin.
        let (mut ended, mut begun) = (Vec::new(), Vec::new());
        let mut start = first;
        for (number, near) in of_wall.iter().enumerate() {
            let own = &slots[start..start + near.features as usize];
            let held = own.iter().any(|slot| slot.state & WITH_HISTORY != 0);
            let reach = self.wall_reach(a, wall);
            let place = a.position + cell.any_shift(near.image);
            (wall.shape()).touches(wall.state.into_wall(place), reach, &mut touches);
            let by = (near.image, reach);
            wall.keep_own(cell, a.position, by, &mut touches, &mut scratch);
            let nearest = (touches.iter()).min_by(|a, b| a.distance.total_cmp(&b.distance));
            match nearest {
                None if held => ended.push((number, start)),
                Some(touch) if !held => begun.push((number, *touch)),
                _ => {}
            }
            start += near.features as usize;
        }
        for (to, touch) in begun {
            let foot = a.position - wall.state.out_of_wall(touch.normal) * touch.distance;
            let mut is_here = |&(from, _): &(usize, usize)| {
                let (image, reach) = (of_wall[from].image, GOES_ON * a.radius);
                wall.is_near_by(cell, foot, (image, reach), &mut scratch)
            };
            let Some(which) = ended.iter().position(&mut is_here) else {
                continue;
            };
            let (from, start) = ended.remove(which);
            let own = &mut slots[start..start + of_wall[from].features as usize];
            let Some(slot) = own.iter_mut().find(|slot| slot.state & WITH_HISTORY != 0) else {
                continue;
            };
            let goes_on = WallSlot {
                feature: touch.feature,
                ..*slot
            };
            slot.clear();
            let features = of_wall[..to].iter().map(|near| near.features as usize);
            let start = first + features.sum::<usize>();
            let own = &mut slots[start..start + of_wall[to].features as usize];
            match own.iter_mut().find(|slot| slot.feature == FREE) {
                Some(slot) => *slot = goes_on,
                None => {
                    slots.insert(start, goes_on);
                    of_wall[to].features += 1;
                    for (number, start) in &mut ended {
                        *start += usize::from(*number > to);
                    }
                }
            }
        }
    }
}
