//! The frame of an axisymmetric wall.

use super::error::{WallError, direction, finite_vector};
use glam::{DVec2, DVec3};
use mercury_common::surfaces::Surface;

/// An axis with two directions normal to it, so that a point near the axis still gets a radial
/// direction that is exactly normal to the axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    across: [DVec3; 2],
}

impl Axis {
    pub(super) fn new(axis: DVec3, origin: DVec3) -> Result<Self, WallError> {
        let direction = direction("axis", axis)?;
        let (u, v) = direction.any_orthonormal_pair();
        Ok(Self {
            origin: finite_vector("origin", origin)?,
            direction,
            across: [u, v],
        })
    }

    /// Its numbers, for [`Axis::from_numbers`].
    pub(super) fn numbers(&self) -> Vec<f64> {
        let [u, v] = self.across;
        let vectors = [self.origin, self.direction, u, v];
        vectors.into_iter().flat_map(|x| x.to_array()).collect()
    }

    /// From its numbers, to the bit; `None` if there are too few.
    pub(super) fn from_numbers(numbers: &[f64]) -> Option<(Self, &[f64])> {
        let (own, rest) = numbers.split_at_checked(12)?;
        let vector = |k: usize| DVec3::from_slice(&own[3 * k..]);
        let axis = Self {
            origin: vector(0),
            direction: vector(1),
            across: [vector(2), vector(3)],
        };
        Some((axis, rest))
    }

    /// How far the origin is from that of an axis of the same direction, along it and across it, m; `None` if the direction is another.
    pub(super) fn shift(&self, other: &Self) -> Option<DVec2> {
        let way = other.origin - self.origin;
        let along = way.dot(self.direction);
        let across = (way - self.direction * along).length();
        (self.direction == other.direction).then_some(DVec2::new(along.abs(), across))
    }

    /// Position `(r, z)` of a point in its half-plane, and the unit vector away from the axis (any,
    /// for a point on the axis).
    #[inline]
    pub(super) fn half_plane(&self, point: DVec3) -> (DVec2, DVec3) {
        let offset = point - self.origin;
        let x = offset.dot(self.across[0]);
        let y = offset.dot(self.across[1]);
        let r = (x * x + y * y).sqrt();
        let outward = if r > 0.0 {
            self.across[0] * (x / r) + self.across[1] * (y / r)
        } else {
            self.across[0]
        };
        (DVec2::new(r, offset.dot(self.direction)), outward)
    }

    /// The outline of a profile turned about the axis.
    pub(super) fn outline(&self, profile: Vec<DVec2>, endless: bool) -> Surface {
        Surface::Turned {
            origin: self.origin,
            direction: self.direction,
            across: self.across,
            profile,
            endless,
        }
    }

    /// Smallest box around the circle of radius `r` about the axis at height `z`.
    pub(super) fn ring_bounds(&self, r: f64, z: f64) -> (DVec3, DVec3) {
        let centre = self.origin + self.direction * z;
        let a = self.direction;
        let extent = DVec3::new(
            (a.y * a.y + a.z * a.z).sqrt(),
            (a.x * a.x + a.z * a.z).sqrt(),
            (a.x * a.x + a.y * a.y).sqrt(),
        ) * r;
        (centre - extent, centre + extent)
    }
}
