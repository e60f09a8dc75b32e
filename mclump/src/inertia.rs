//! Mass, centre of mass and inertia by every route.
//!
//! | route | of | accuracy |
//! |---|---|---|
//! | [`surface`] | a closed surface | exact for the polyhedron |
//! | [`union`] | the space that the pebbles cover | to a tolerance, by default 1e-6 |
//! | [`voxels`] | the same | erratic, about 1e-3 at 100 voxels |
//! | [`pebbles`] | every pebble for itself | exact; counts overlaps several times |
//!
//! Everything here is for unit density: a mass is a volume in m3, a moment of inertia is in m5. The density is put in when
//! the clump file is made.

pub mod comparison;
pub mod pebbles;
pub mod surface;
pub mod union;
pub mod voxels;

use glam::{DMat3, DVec3};

use crate::alignment::eigen;

/// Volume, centre and second moments of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Volume in m3.
    pub volume: f64,
    /// Centre of mass in m, in the frame of the input.
    pub centre: DVec3,
    /// The integral of x xᵀ over the body in m5, x counted from the centre.
    pub second_moment: DMat3,
}

impl MassProperties {
    /// The inertia tensor about the centre per unit density, in m5: `tr(J) E - J` of the second moment `J`.
    #[must_use]
    pub fn inertia(&self) -> DMat3 {
        let j = self.second_moment;
        DMat3::from_diagonal(DVec3::splat(j.x_axis.x + j.y_axis.y + j.z_axis.z)) - j
    }

    /// The principal moments per unit density in m5, ascending.
    #[must_use]
    pub fn principal_moments(&self) -> DVec3 {
        eigen::symmetric(self.inertia()).values
    }
}

/// Properties found numerically, and how far they may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The properties.
    pub properties: MassProperties,
    /// Estimated error of volume and moments, relative to the volume and to the trace of the inertia.
    pub relative_error: f64,
}

/// Integrals of 1, x and x xᵀ about a fixed origin, to be summed over the parts of a body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct RawMoments {
    pub(crate) volume: f64,
    pub(crate) first: DVec3,
    pub(crate) second: DMat3Sum,
}

/// Upper triangle of a symmetric matrix: xx, yy, zz and xy, xz, yz.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct DMat3Sum {
    pub(crate) diagonal: DVec3,
    /// xy, xz, yz.
    pub(crate) mixed: DVec3,
}

impl RawMoments {
    pub(crate) fn add(&mut self, other: &Self) {
        self.volume += other.volume;
        self.first += other.first;
        self.second.diagonal += other.second.diagonal;
        self.second.mixed += other.second.mixed;
    }

    /// The ten numbers in one array.
    pub(crate) fn to_array(self) -> [f64; 10] {
        let (f, d, m) = (self.first, self.second.diagonal, self.second.mixed);
        [self.volume, f.x, f.y, f.z, d.x, d.y, d.z, m.x, m.y, m.z]
    }

    pub(crate) fn from_array(a: [f64; 10]) -> Self {
        Self {
            volume: a[0],
            first: DVec3::new(a[1], a[2], a[3]),
            second: DMat3Sum {
                diagonal: DVec3::new(a[4], a[5], a[6]),
                mixed: DVec3::new(a[7], a[8], a[9]),
            },
        }
    }

    /// Moves to the centre of mass; `origin` is where the integrals were taken about.
    pub(crate) fn central(&self, origin: DVec3) -> MassProperties {
        let offset = self.first / self.volume;
        let DMat3Sum { diagonal, mixed } = self.second;
        let about_origin = DMat3::from_cols(
            DVec3::new(diagonal.x, mixed.x, mixed.y),
            DVec3::new(mixed.x, diagonal.y, mixed.z),
            DVec3::new(mixed.y, mixed.z, diagonal.z),
        );
        MassProperties {
            volume: self.volume,
            centre: origin + offset,
            second_moment: about_origin - outer(offset, offset) * self.volume,
        }
    }
}

/// The matrix a bᵀ.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The sum of the parts in pairs of pairs: its error grows with the logarithm of their number, and its order is fixed.
pub(crate) fn pairwise_sum(parts: &[RawMoments]) -> RawMoments {
    match parts {
        [] => RawMoments::default(),
        [one] => *one,
        _ => {
            let (left, right) = parts.split_at(parts.len() / 2);
            let mut sum = pairwise_sum(left);
            sum.add(&pairwise_sum(right));
            sum
        }
    }
}
