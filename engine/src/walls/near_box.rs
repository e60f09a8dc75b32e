//! Whether a wall may be near anything in a box: never wrong where the answer is no, so that whole boxes of particles need no
//! test.

use glam::DVec3;

use super::{Pose, Scratch, Shape, WallNow};
use crate::cell::Cell;
use crate::neighbours::Block;

/// Largest error of sums of a few products, over the largest coordinate that is met.
const ROUND_OFF: f64 = 1e-12;
/// Largest error of a distance, over the distance itself.
const RELATIVE: f64 = 1e-9;

/// A box, m; unbounded axes reach from minus to plus infinity.
pub(super) type Corners = (DVec3, DVec3);

impl WallNow {
    /// The box around the wall as it stands, m: a particle that the wall is near is as near to it or inside.
    #[must_use]
    pub fn outer_box(&self) -> Corners {
        let (mut low, mut high) = self.shape().bounds();
        match self.shape() {
            // It acts behind its surface too.
            Shape::Plane(_) => (low, high) = (DVec3::NEG_INFINITY, DVec3::INFINITY),
            Shape::Mesh(mesh) => {
                for period in mesh.periods() {
                    (low[period.axis], high[period.axis]) = (f64::NEG_INFINITY, f64::INFINITY);
                }
            }
            _ => {}
        }
        if !self.state.moves {
            return (low, high);
        }
        posed(&self.state.pose, (low, high))
    }

    /// Whether the wall, with half the thickness of a sheet, may be within the radius of a particle of the block, and `margin` (m) more, by the image that goes with the
    /// code `met_by`. `outer`: [`WallNow::outer_box`].
    #[must_use]
    pub fn may_be_near(
        &self,
        outer: &Corners,
        block: &Block,
        margin: f64,
        (cell, met_by): (&Cell, u32),
        scratch: &mut Scratch,
    ) -> bool {
        let reach = block.radius + margin + self.half_thickness();
        // The period in which a particle lies can differ from that of its box: all images with the code are tested.
        let corners = (block.low, block.high);
        self.images_of_box(cell, corners, met_by).any(|code| {
            let shift = cell.any_shift(code);
            let corners = (block.low + shift, block.high + shift);
            self.may_be_near_box(outer, corners, reach, scratch)
        })
    }

    fn may_be_near_box(
        &self,
        (outer_low, outer_high): &Corners,
        (low, high): Corners,
        reach: f64,
        scratch: &mut Scratch,
    ) -> bool {
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        let place = self.state.into_wall(centre);
        let scale = low.abs().max(high.abs()).max_element()
            + place.abs().max_element()
            + self.state.pose.translation.abs().max_element()
            + self.shape().scale();
        let reach = reach * (1.0 + RELATIVE) + ROUND_OFF * scale;
        if (low - reach).cmpgt(*outer_high).any() || (high + reach).cmplt(*outer_low).any() {
            return false;
        }
        match self.shape() {
            Shape::Plane(plane) => {
                let touch = plane.touch(place, f64::INFINITY);
                touch.is_some_and(|touch| {
                    let across = self.state.out_of_wall(touch.normal).abs().dot(half);
                    touch.distance < reach + across * (1.0 + RELATIVE)
                })
            }
            shape => {
                let within = half.length() * (1.0 + RELATIVE);
                shape.may_be_near(place, within, reach, scratch)
            }
        }
    }
}

/// The box around a box that was put somewhere.
fn posed(pose: &Pose, (low, high): Corners) -> Corners {
    let columns = DVec3::AXES.map(|axis| pose.rotation * axis);
    let (mut new_low, mut new_high) = (pose.translation, pose.translation);
    for (axis, column) in columns.into_iter().enumerate() {
        for to in 0..3 {
            // Infinity times zero would be no number.
            if column[to] != 0.0 {
                let ends = [low[axis] * column[to], high[axis] * column[to]];
                new_low[to] += ends[0].min(ends[1]);
                new_high[to] += ends[0].max(ends[1]);
            }
        }
    }
    (new_low, new_high)
}
