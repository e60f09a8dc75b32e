//! A point of a sheet: how it moves, how heavy it is, and how vertices share what acts there.
//!
//! The point is a mean of the three corners of its triangle with weights that are not negative and whose sum is 1. A force there is shared with the same
//! weights, so that force, torque and power on the corners are those at the point. A couple C becomes the forces (J^-1 C) x d_k, with d_k
//! from the mean of the corners and J = sum(|d_k|^2 1 - d_k d_k^T). Their sum is zero and their torque C; and their power is that of C at the
//! spin J^-1 sum d_k x v_k, the rotation that fits the velocities of the corners best (least squares).

use glam::{DMat3, DVec3};

use super::Surface;
use crate::walls::{Feature, Mesh};

/// A point of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfacePoint {
    /// The triangle that takes what acts there.
    pub triangle: u32,
    /// Weights of its corners, in their order: none is negative, and their sum is 1.
    pub weights: [f64; 3],
}

/// Load of a contact on a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceLoad {
    /// Index of the sheet.
    pub surface: u16,
    /// Number of the triangle.
    pub triangle: u32,
    /// Forces on its corners, N.
    pub shares: [DVec3; 3],
}

crate::state::plain!(SurfaceLoad {
    surface,
    triangle,
    shares
});

impl Surface {
    /// The place of `foot` (m), the nearest point of a feature of the mesh that borrows its shape.
    #[inline]
    #[must_use]
    pub fn place(&self, mesh: &Mesh, feature: u32, foot: DVec3) -> SurfacePoint {
        let triangle = self.taker_of[feature as usize];
        let corners = self.plan.triangles[triangle as usize];
        let [a, b, c] = corners.map(|k| self.positions[k as usize]);
        let weights = match mesh.feature_of(feature) {
            Feature::Face(_) => {
                let (ab, ac, way) = (b - a, c - a, foot - a);
                let normal = ab.cross(ac);
                let scale = normal.length_squared().recip();
                let of_b = way.cross(ac).dot(normal) * scale;
                let of_c = ab.cross(way).dot(normal) * scale;
                let of_b = of_b.clamp(0.0, 1.0);
                let of_c = of_c.clamp(0.0, 1.0 - of_b);
                [1.0 - (of_b + of_c), of_b, of_c]
            }
            Feature::Edge(ends) => {
                let [from, to] = ends.map(|corner| self.vertex_of[corner as usize]);
                let (start, end) = (self.positions[from as usize], self.positions[to as usize]);
                let along = end - start;
                let part = (foot - start).dot(along) / along.length_squared();
                let part = part.clamp(0.0, 1.0);
                corners.map(|corner| match corner {
                    corner if corner == from => 1.0 - part,
                    corner if corner == to => part,
                    _ => 0.0,
                })
            }
            Feature::Corner(corner) => {
                let vertex = self.vertex_of[corner as usize];
                corners.map(|corner| f64::from(u8::from(corner == vertex)))
            }
        };
        SurfacePoint { triangle, weights }
    }

    /// Velocity of a point, m/s.
    #[inline]
    #[must_use]
    pub fn velocity_at(&self, place: &SurfacePoint) -> DVec3 {
        self.mean(place, &self.velocities)
    }

    /// Velocity of a point (m/s) and angular velocity of its triangle (rad/s) `half` (s) later, by the present forces and `gravity` (m/s^2).
    #[must_use]
    pub fn moving(&self, place: &SurfacePoint, half: f64, gravity: DVec3) -> [DVec3; 2] {
        let (arms, inverse) = self.arms(place.triangle);
        let corners = self.plan.triangles[place.triangle as usize];
        let velocities =
            corners.map(|k| self.velocities[k as usize] + self.kick(k as usize, half, gravity));
        let [a, b, c] = velocities;
        let [u, v, w] = place.weights;
        [a * u + b * v + c * w, inverse * moment(arms, velocities)]
    }

    /// The mean of values at the corners, with the weights of a point.
    #[inline]
    fn mean(&self, place: &SurfacePoint, values: &[DVec3]) -> DVec3 {
        let [a, b, c] = self.plan.triangles[place.triangle as usize].map(|k| values[k as usize]);
        a * place.weights[0] + b * place.weights[1] + c * place.weights[2]
    }

    /// Over the mass with which a point answers a force, 1/kg: sum w_k^2/m_k.
    #[inline]
    #[must_use]
    pub fn inverse_mass_at(&self, place: &SurfacePoint) -> f64 {
        let corners = self.plan.triangles[place.triangle as usize].iter();
        let parts = corners.zip(place.weights);
        parts.fold(0.0, |sum, (&k, weight)| {
            sum + weight * weight * self.inverse_masses[k as usize]
        })
    }

    /// Angular velocity of a triangle, rad/s.
    #[must_use]
    pub fn spin(&self, triangle: u32) -> DVec3 {
        let (arms, inverse) = self.arms(triangle);
        let velocities =
            self.plan.triangles[triangle as usize].map(|k| self.velocities[k as usize]);
        inverse * moment(arms, velocities)
    }

    /// Forces on the corners of a triangle, N, for a force (N) at a point of it and a couple (N m).
    #[inline]
    #[must_use]
    pub fn shares(&self, place: &SurfacePoint, force: DVec3, couple: DVec3) -> [DVec3; 3] {
        let mut shares = place.weights.map(|weight| force * weight);
        if couple != DVec3::ZERO {
            let (arms, inverse) = self.arms(place.triangle);
            let turn = inverse * couple;
            for (share, arm) in shares.iter_mut().zip(arms) {
                *share += turn.cross(arm);
            }
        }
        shares
    }

    /// The corners of a triangle from their mean, m, and the inverse of J, 1/m^2.
    fn arms(&self, triangle: u32) -> ([DVec3; 3], DMat3) {
        let corners = self.plan.triangles[triangle as usize].map(|k| self.positions[k as usize]);
        let mean = (corners[0] + corners[1] + corners[2]) / 3.0;
        let arms = corners.map(|corner| corner - mean);
        let mut tensor = DMat3::ZERO;
        for arm in arms {
            let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
            tensor += DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer;
        }
        (arms, tensor.inverse())
    }
}

/// Sum of arm x vector.
fn moment(arms: [DVec3; 3], vectors: [DVec3; 3]) -> DVec3 {
    let parts = arms.into_iter().zip(vectors);
    parts.fold(DVec3::ZERO, |sum, (arm, vector)| sum + arm.cross(vector))
}
