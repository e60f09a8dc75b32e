//! The sphere, as a wall.

use crate::walls::error::{WallError, finite_vector, positive};
use crate::walls::pose::Pose;
use crate::walls::side::Side;
use crate::walls::symmetry;
use crate::walls::touch::{Touch, Touches, Turning};
use glam::DVec3;
use mercury_common::surfaces::Surface;

/// A spherical shell. Features: 0 the inside (or the only side), 1 the outside of [`Side::Both`].
#[derive(Debug, Clone, PartialEq)]
pub struct SphereShell {
    centre: DVec3,
    radius: f64,
    side: Side,
}

impl SphereShell {
    /// The shell of `radius` (m) about `origin` (m).
    ///
    /// # Errors
    /// If the origin is not finite or the radius is not finite and positive.
    pub fn new(origin: DVec3, radius: f64, side: Side) -> Result<Self, WallError> {
        Ok(Self {
            centre: finite_vector("origin", origin)?,
            radius: positive("radius", radius)?,
            side,
        })
    }

    pub(super) fn side(&self) -> Side {
        self.side
    }

    #[inline]
    pub(super) fn touches(&self, centre: DVec3, reach: f64, out: &mut Touches) {
        let offset = centre - self.centre;
        let r = offset.length();
        let height = self.radius - r;
        if height.abs() >= reach {
            return;
        }
        // At the very centre all directions are equally near.
        let outward = if r > 0.0 { offset / r } else { DVec3::X };
        let (distance, sign, feature) = match self.side {
            Side::Inside => (height, -1.0, 0),
            Side::Outside => (-height, 1.0, 0),
            Side::Both if height >= 0.0 => (height, -1.0, 0),
            Side::Both => (-height, 1.0, 1),
        };
        out.push(Touch {
            distance,
            normal: outward * sign,
            feature,
            curvature: [sign / self.radius; 2],
            turning: Turning {
                along: outward.any_orthonormal_vector(),
                rates: [if r > 0.0 { sign / r } else { 0.0 }; 2],
            },
        });
    }

    /// Whether a place is closer than `reach` (m) to the surface.
    pub(super) fn is_near(&self, centre: DVec3, reach: f64) -> bool {
        (self.radius - centre.distance(self.centre)).abs() < reach
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        let [x, y, z] = self.centre.to_array();
        vec![x, y, z, self.radius]
    }

    pub(super) fn with_numbers(&self, numbers: &[f64]) -> Option<Self> {
        let &[x, y, z, radius] = numbers else {
            return None;
        };
        let centre = DVec3::new(x, y, z);
        Some(Self {
            centre,
            radius,
            side: self.side,
        })
    }

    /// See [`super::Shape::way_to`].
    pub(super) fn way_to(&self, other: &Self) -> Option<f64> {
        let way = self.centre.distance(other.centre) + (self.radius - other.radius).abs();
        (self.side == other.side).then_some(way)
    }

    /// See [`super::Shape::scale`].
    pub(super) fn scale(&self) -> f64 {
        self.centre.abs().max_element() + self.radius
    }

    pub(super) fn outline(&self) -> Surface {
        Surface::Sphere {
            centre: self.centre,
            radius: self.radius,
        }
    }

    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let extent = DVec3::splat(self.radius);
        (self.centre - extent, self.centre + extent)
    }

    pub(super) fn displacement(&self, from: &Pose, to: &Pose, about: DVec3, reach: f64) -> f64 {
        symmetry::of_point(from, to, self.centre, about, reach)
    }
}
