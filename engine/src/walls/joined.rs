//! Walls whose images are one surface: a disc wider than a period overlaps its own images, a profile as long as a period goes on in the
//! next one.
//!
//! A particle feels a place once that lies on several images. A rim of one image that lies on the surface of another one is no rim of
//! what both are together.

use glam::DVec3;

use super::{Touches, WallNow};
use crate::cell::Cell;

/// Places that are no farther apart than this part of the reach of a particle are one: far above round-off, far below any overlap.
const SAME: f64 = 1e-9;
/// Part of the reach below which two feet of one particle on two images are one, which round-off moves along the surface.
const SAME_FOOT: f64 = 1e-6;

impl WallNow {
    /// Takes those of the `touches` of a particle at `position` (m) within `reach` (m) by one image out that belong to another image: they
    /// lie on its surface, and there it is touched elsewhere, or in a place that only it has, or in the same place and has the lower code.
    /// `scratch`: any memory.
    pub fn keep_own(
        &self,
        cell: &Cell,
        position: DVec3,
        (image, reach): (u32, f64),
        touches: &mut Touches,
        scratch: &mut Touches,
    ) {
        let state = &self.state;
        let centre = state.into_wall(position + cell.any_shift(image));
        let all = std::mem::take(touches);
        for touch in &all {
            let foot = centre - touch.normal * touch.distance;
            let belongs_to = |other: u32| {
                let way = cell.any_shift(other) - cell.any_shift(image);
                let way = state.turn_into_wall(way);
                self.shape().touches(foot + way, SAME * reach, scratch);
                if scratch.is_empty() {
                    return false;
                }
                self.shape().touches(centre + way, reach, scratch);
                let its_foot = (scratch.iter())
                    .map(|its| centre - its.normal * its.distance)
                    .find(|its| its.distance(foot) <= SAME_FOOT * reach);
                let Some(its_foot) = its_foot else {
                    return true;
                };
                if other < image {
                    return true;
                }
                // Beyond the rim of this image the place is the other's alone, whatever the codes are.
                self.shape().touches(its_foot, SAME * reach, scratch);
                scratch.is_empty()
            };
            let mut others = (self.met_by().iter())
                .map(|&code| self.image_of(position, code))
                .filter(|&other| other != image);
            if !others.any(belongs_to) {
                touches.push(*touch);
            }
        }
    }

    /// Distance of a place (m) from the surface by the nearest image, m; infinite where that is farther than the domain is long. `scratch`: any memory.
    #[must_use]
    pub fn distance(&self, cell: &Cell, place: DVec3, scratch: &mut Touches) -> f64 {
        let reach = cell.diagonal();
        let mut least = f64::INFINITY;
        for &code in self.met_by() {
            let shift = cell.any_shift(self.image_of(place, code));
            let place = self.state.into_wall(place + shift);
            self.shape().touches(place, reach, scratch);
            for touch in scratch.iter() {
                least = least.min(touch.distance.abs());
            }
        }
        least
    }

    /// Whether a place (m) is within `reach` (m) of the surface by an image.
    #[must_use]
    pub fn is_near_by(
        &self,
        cell: &Cell,
        place: DVec3,
        (image, reach): (u32, f64),
        scratch: &mut Touches,
    ) -> bool {
        let place = (self.state).into_wall(place + cell.any_shift(image));
        self.shape().touches(place, reach, scratch);
        !scratch.is_empty()
    }
}
