//! Space behind a wall: one that acts on one side, or one that has moved.

use glam::DVec3;

use super::mesh::{Mesh, Scratch};
use super::touch::{Touch, Touches};
use super::{Shape, Side, WallNow};
use crate::cell::Cell;

/// Halvings by which the distance to a mesh is bracketed: then few of its triangles are evaluated.
const HALVINGS: u32 = 6;

impl Shape {
    /// Whether it acts on one side only.
    #[must_use]
    pub fn is_one_sided(&self) -> bool {
        match self {
            Self::Plane(_) => true,
            Self::Mesh(mesh) => mesh.is_front_only(),
            shape => shape.side().is_some_and(|side| side != Side::Both),
        }
    }

    /// Whether it is the surface of a solid: particles are outside.
    fn is_solid(&self) -> bool {
        self.side() == Some(Side::Outside)
    }

    /// Distance of a place (m, in the wall's own frame) from the surface; negative behind one that acts on one side. Where the nearest point is
    /// on a rim, a place is on no side, and not behind.
    #[must_use]
    pub fn signed_distance(&self, place: DVec3, scratch: &mut Scratch) -> f64 {
        let nearest = self.nearest(place, scratch);
        nearest.map_or(f64::INFINITY, |touch| touch.distance)
    }

    /// The nearest point of the surface, as seen from a place (m, in the wall's own frame).
    fn nearest(&self, place: DVec3, scratch: &mut Scratch) -> Option<Touch> {
        let mut touches = Touches::new();
        match self {
            Self::Mesh(mesh) => mesh.near_nearest(place, scratch, &mut touches),
            shape => shape.touches(place, f64::INFINITY, &mut touches),
        }
        let nearest = touches
            .iter()
            .min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
        nearest.copied()
    }
}

impl Mesh {
    /// The contacts of the sphere that reaches just beyond the nearest point.
    fn near_nearest(&self, place: DVec3, scratch: &mut Scratch, out: &mut Touches) {
        let (low, high) = self.bounds();
        let size = (high - low).length();
        let beside = (low - place).max(place - high).max(DVec3::ZERO).length();
        // The farthest point is no farther, the nearest no nearer.
        let (mut near, mut far) = (beside, beside + size);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            if self.may_be_near(place, middle, scratch) {
                far = middle;
            } else {
                near = middle;
            }
        }
        // "May be" is sometimes wrong, by round-off of single precision or the size of a box.
        while out.is_empty() && far <= 4.0 * (beside + size) {
            far = far * (1.0 + 1e-5) + 1e-6 * size;
            self.touches(place, far, out);
            if out.is_empty() {
                far *= 1.5;
            }
        }
    }
}

impl WallNow {
    /// Whether a place (m) lies behind the wall where it stands, as it and its images are seen from there: behind the nearest of them, or in any of
    /// them if they are solids, which may cross.
    #[must_use]
    pub fn is_behind(&self, cell: &Cell, place: DVec3, scratch: &mut Scratch) -> bool {
        if !self.shape().is_one_sided() {
            return false;
        }
        let mut nearest = f64::INFINITY;
        for &code in self.met_by() {
            let code = self.image_of(place, code);
            let place = self.state.into_wall(place + cell.any_shift(code));
            let distance = self.shape().signed_distance(place, scratch);
            if distance < 0.0 && self.shape().is_solid() {
                return true;
            }
            if distance.abs() < nearest.abs() {
                nearest = distance;
            }
        }
        nearest < 0.0
    }

    /// Whether a place (m) lies on the side from which the wall has come: where the way of its nearest point since the start leads away from the
    /// place. Of a wall that acts on one side, which is behind or in front, never.
    #[must_use]
    pub fn is_in_wake(&self, cell: &Cell, place: DVec3, scratch: &mut Scratch) -> bool {
        if self.shape().is_one_sided() {
            return false;
        }
        let mut found: Option<(f64, bool)> = None;
        for &code in self.met_by() {
            let code = self.image_of(place, code);
            let place = self.state.into_wall(place + cell.any_shift(code));
            let Some(touch) = self.shape().nearest(place, scratch) else {
                continue;
            };
            if found.is_none_or(|(distance, _)| touch.distance < distance) {
                let point = place - touch.distance * touch.normal;
                let way = self.way_of(point).dot(self.state.out_of_wall(touch.normal));
                found = Some((touch.distance, way < 0.0));
            }
        }
        found.is_some_and(|(_, is_in_wake)| is_in_wake)
    }
}
