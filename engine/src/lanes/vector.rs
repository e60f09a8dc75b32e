//! Vectors in space, in lanes.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use glam::DVec3;

use super::Real;

/// A vector, or several side by side. Sums and products are made in glam's order, so that as `Vector<f64>` it gives the
/// bits of a [`DVec3`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vector<L = f64> {
    /// x.
    pub x: L,
    /// y.
    pub y: L,
    /// z.
    pub z: L,
}

impl<L: Real> Vector<L> {
    /// No length.
    pub const ZERO: Self = Self::new(L::ZERO, L::ZERO, L::ZERO);
    /// Unit vector along x.
    pub const X: Self = Self::new(L::ONE, L::ZERO, L::ZERO);
    /// Unit vector along y.
    pub const Y: Self = Self::new(L::ZERO, L::ONE, L::ZERO);
    /// Unit vector along z.
    pub const Z: Self = Self::new(L::ZERO, L::ZERO, L::ONE);

    /// From its components.
    #[inline(always)]
    #[must_use]
    pub const fn new(x: L, y: L, z: L) -> Self {
        Self { x, y, z }
    }

    /// Scalar product.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Square of the length.
    #[inline(always)]
    #[must_use]
    pub fn length_squared(self) -> L {
        self.dot(self)
    }

    /// Length.
    #[inline(always)]
    #[must_use]
    pub fn length(self) -> L {
        self.length_squared().sqrt()
    }

    /// `then` where the mask is set, `otherwise` elsewhere.
    #[inline(always)]
    #[must_use]
    pub fn select(mask: L::Mask, then: Self, otherwise: Self) -> Self {
        Self {
            x: L::select(mask, then.x, otherwise.x),
            y: L::select(mask, then.y, otherwise.y),
            z: L::select(mask, then.z, otherwise.z),
        }
    }

    /// `vector(k)` in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn gather(vector: impl Fn(usize) -> Vector) -> Self {
        Self {
            x: L::from_lanes(|k| vector(k).x),
            y: L::from_lanes(|k| vector(k).y),
            z: L::from_lanes(|k| vector(k).z),
        }
    }

    /// One vector in every lane.
    #[inline(always)]
    #[must_use]
    pub fn splat(vector: Vector) -> Self {
        Self {
            x: L::splat(vector.x),
            y: L::splat(vector.y),
            z: L::splat(vector.z),
        }
    }

    /// The vector in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn lane(self, k: usize) -> Vector {
        Vector::new(self.x.lane(k), self.y.lane(k), self.z.lane(k))
    }

    /// The components.
    #[inline(always)]
    #[must_use]
    pub fn to_array(self) -> [L; 3] {
        [self.x, self.y, self.z]
    }

    /// From the first three of some numbers.
    #[inline(always)]
    #[must_use]
    pub fn from_slice(numbers: &[L]) -> Self {
        Self::new(numbers[0], numbers[1], numbers[2])
    }
}

impl<L: Real> Neg for Vector<L> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<L: Real> Add for Vector<L> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<L: Real> AddAssign for Vector<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<L: Real> Sub for Vector<L> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<L: Real> SubAssign for Vector<L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<L: Real> Mul<L> for Vector<L> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: L) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<L: Real> Div<L> for Vector<L> {
    type Output = Self;

    #[inline(always)]
    fn div(self, divisor: L) -> Self {
        Self::new(self.x / divisor, self.y / divisor, self.z / divisor)
    }
}

impl From<DVec3> for Vector {
    #[inline(always)]
    fn from(vector: DVec3) -> Self {
        Self::new(vector.x, vector.y, vector.z)
    }
}

impl From<Vector> for DVec3 {
    #[inline(always)]
    fn from(vector: Vector) -> Self {
        Self::new(vector.x, vector.y, vector.z)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vectors() -> impl Strategy<Value = DVec3> {
        (-1e3..1e3f64, -1e-3..1e-3f64, -1.0..1.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        /// A vector of plain numbers gives glam's bits.
        #[test]
        fn a_vector_of_numbers_is_glams(a in vectors(), b in vectors(), s in -10.0..10.0f64) {
            let (x, y) = (Vector::from(a), Vector::from(b));
            prop_assert_eq!(x.dot(y).to_bits(), a.dot(b).to_bits());
            prop_assert_eq!(x.length().to_bits(), a.length().to_bits());
            let pairs = [
                (x.cross(y), a.cross(b)),
                (x + y, a + b),
                (x - y, a - b),
                (-x, -a),
                (x * s, a * s),
                (x / s, a / s),
            ];
            for (mine, glam) in pairs {
                prop_assert_eq!(mine.to_array().map(f64::to_bits), glam.to_array().map(f64::to_bits));
            }
        }
    }
}
