//! The plane: the boundary of a solid half-space.

use crate::walls::error::{WallError, direction, finite_vector};
use crate::walls::pose::Pose;
use crate::walls::symmetry;
use crate::walls::touch::{Touch, Touches, Turning};
use glam::DVec3;
use mercury_common::surfaces::Surface;

/// A half-space of wall. It pushes back however deep a centre has sunk in.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    point: DVec3,
    normal: DVec3,
}

impl Plane {
    /// The plane through `point` (m) whose `normal` (any length) points into the space of the
    /// particles.
    ///
    /// # Errors
    /// If the point is not finite or the normal is no direction.
    pub fn new(point: DVec3, normal: DVec3) -> Result<Self, WallError> {
        Ok(Self {
            point: finite_vector("point", point)?,
            normal: direction("normal", normal)?,
        })
    }

    /// A point of it, m.
    #[must_use]
    pub fn point(&self) -> DVec3 {
        self.point
    }

    /// Normal of length 1, into the space of the particles.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The place where a sphere's centre (in the wall's own frame) is within `reach` (m) of the plane.
    #[inline]
    #[must_use]
    pub fn touch(&self, centre: DVec3, reach: f64) -> Option<Touch> {
        let distance = (centre - self.point).dot(self.normal);
        (distance < reach).then_some(Touch {
            distance,
            normal: self.normal,
            feature: 0,
            curvature: [0.0; 2],
            turning: Turning::NONE,
        })
    }

    #[inline]
    pub(super) fn touches(&self, centre: DVec3, reach: f64, out: &mut Touches) {
        if let Some(touch) = self.touch(centre, reach) {
            out.push(touch);
        }
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        [self.point.to_array(), self.normal.to_array()].concat()
    }

    pub(super) fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let is_whole = numbers.len() == 6;
        is_whole.then(|| Self {
            point: DVec3::from_slice(numbers),
            normal: DVec3::from_slice(&numbers[3..]),
        })
    }

    /// See [`super::Shape::way_to`]: a plane that tilts moves without bound.
    pub(super) fn way_to(&self, other: &Self) -> f64 {
        if self.normal == other.normal {
            (other.point - self.point).dot(self.normal).abs()
        } else {
            f64::INFINITY
        }
    }

    /// See [`super::Shape::scale`].
    pub(super) fn scale(&self) -> f64 {
        self.point.abs().max_element()
    }

    pub(super) fn outline(&self) -> Surface {
        Surface::Plane {
            point: self.point,
            normal: self.normal,
        }
    }

    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let mut min = DVec3::NEG_INFINITY;
        let mut max = DVec3::INFINITY;
        for axis in 0..3 {
            if self.normal[axis].abs() == 1.0 {
                min[axis] = self.point[axis];
                max[axis] = self.point[axis];
            }
        }
        (min, max)
    }

    pub(super) fn displacement(&self, from: &Pose, to: &Pose, about: DVec3, reach: f64) -> f64 {
        symmetry::of_plane(from, to, (self.point, self.normal), about, reach)
    }
}
