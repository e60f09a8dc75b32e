//! The region in which a kernel or a cut line integral is not zero, row by row of a grid.

use glam::DVec3;

use crate::kernel::{Kernel, LineCut};

/// A ball, or an ellipsoid or capped cylinder around a segment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    direction: DVec3,
    /// 1 - (transverse half axis / half axis along)^2: 0 for a ball, 1 for a cylinder.
    flatness: f64,
    reach_squared: f64,
    /// 1 - flatness nz^2, and its inverse.
    steepness: f64,
    inverse: f64,
    /// A cylinder ends here, measured from the middle.
    cap: Option<f64>,
    /// Half sizes of the box around it.
    pub half: DVec3,
}

impl Window {
    /// The region of a particle.
    pub(crate) fn ball(kernel: &Kernel) -> Self {
        let reach = kernel.reach();
        Self {
            direction: DVec3::ZERO,
            flatness: 0.0,
            reach_squared: reach * reach,
            steepness: 1.0,
            inverse: 1.0,
            cap: None,
            half: DVec3::splat(reach),
        }
    }

    /// The region of a segment.
    pub(crate) fn around(kernel: &Kernel, segment: DVec3) -> Self {
        let length = segment.length();
        let ball = Self::ball(kernel);
        if length <= 1e-10 * kernel.choice().width {
            return ball;
        }
        let (reach, half) = (kernel.reach(), kernel.reach() + 0.5 * length);
        let direction = segment / length;
        // Polynomials end on their own; a cylinder holds all of them.
        let cylinder =
            kernel.polynomial().is_some() || kernel.choice().line_cut == LineCut::Cylinder;
        let flatness = if cylinder {
            1.0
        } else {
            1.0 - (reach / half) * (reach / half)
        };
        let steepness = 1.0 - flatness * direction.z * direction.z;
        let bounds = if cylinder {
            DVec3::splat(reach) + 0.5 * segment.abs()
        } else {
            let along = direction * direction * (half * half - reach * reach);
            (along + DVec3::splat(reach * reach)).map(f64::sqrt)
        };
        Self {
            direction,
            flatness,
            reach_squared: reach * reach,
            steepness,
            inverse: 1.0 / steepness,
            cap: cylinder.then_some(half),
            half: bounds,
        }
    }

    /// Where the row at `dx`, `dy` from the middle lies inside, as heights above the middle.
    #[inline]
    pub(crate) fn row(&self, dx: f64, dy: f64) -> Option<(f64, f64)> {
        let across = dx * dx + dy * dy;
        if self.flatness == 0.0 {
            let rest = self.reach_squared - across;
            if rest < 0.0 {
                return None;
            }
            let height = rest.sqrt();
            return Some((-height, height));
        }
        let along = self.direction.x * dx + self.direction.y * dy;
        let rest = self.reach_squared - across + self.flatness * along * along;
        let (mut low, mut high) = if self.steepness > 1e-12 {
            let middle = self.flatness * along * self.direction.z;
            let square = middle * middle + self.steepness * rest;
            if square < 0.0 {
                return None;
            }
            let height = square.sqrt();
            (
                (middle - height) * self.inverse,
                (middle + height) * self.inverse,
            )
        } else if rest >= 0.0 {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            return None;
        };
        if let Some(cap) = self.cap {
            let z = self.direction.z;
            if z.abs() > 1e-12 {
                let (a, b) = ((-cap - along) / z, (cap - along) / z);
                low = low.max(a.min(b));
                high = high.min(a.max(b));
            } else if along.abs() > cap {
                return None;
            }
        }
        (low <= high).then_some((low, high))
    }
}
