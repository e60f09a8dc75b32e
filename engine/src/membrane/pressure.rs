//! Pressure in a sheet, and the volume that it encloses.

use glam::DVec3;
use mercury_common::curve::Curve;

use super::sheet::Sheet;

/// Source of the pressure.
#[derive(Debug, Clone, PartialEq)]
pub enum Load {
    /// Pa over time.
    Given(Curve),
    /// p = gas (V0/V)^exponent - ambient.
    Gas {
        /// Absolute pressure at V0, Pa.
        gas: f64,
        /// Pressure outside, Pa.
        ambient: f64,
        /// 1: isothermal; 1.4: adiabatic air.
        exponent: f64,
    },
    /// p = fluid + bulk_modulus (V0 - V)/V0 - ambient.
    Fluid {
        /// Absolute pressure at V0, Pa.
        fluid: f64,
        /// In Pa.
        bulk_modulus: f64,
        /// Pressure outside, Pa.
        ambient: f64,
    },
}

impl Load {
    /// Whether there never is any.
    #[must_use]
    pub fn is_none(&self) -> bool {
        matches!(self, Self::Given(curve) if curve.rows().iter().all(|row| row.1 == 0.0))
    }

    /// Whether it depends on the volume.
    #[must_use]
    pub fn needs_volume(&self) -> bool {
        !matches!(self, Self::Given(_))
    }

    /// The pressure, Pa: `time` in s, `volume` and `first` (V0) in m^3.
    #[must_use]
    pub fn at(&self, time: f64, volume: f64, first: f64) -> f64 {
        match self {
            Self::Given(curve) => curve.at(time),
            Self::Gas {
                gas,
                ambient,
                exponent,
            } => gas * libm::pow(first / volume, *exponent) - ambient,
            Self::Fluid {
                fluid,
                bulk_modulus,
                ambient,
            } => fluid + bulk_modulus * (first - volume) / first - ambient,
        }
    }

    /// -dp/dV at V0, Pa/m^3.
    #[must_use]
    pub fn stiffness(&self, first: f64) -> f64 {
        self.stiffness_at(first, first)
    }

    /// -dp/dV at a volume, Pa/m^3: `volume` and `first` (V0) in m^3.
    #[must_use]
    pub fn stiffness_at(&self, volume: f64, first: f64) -> f64 {
        match self {
            Self::Given(_) => 0.0,
            Self::Gas { gas, exponent, .. } => {
                gas * exponent * libm::pow(first / volume, *exponent) / volume
            }
            Self::Fluid { bulk_modulus, .. } => bulk_modulus / first,
        }
    }
}

/// The volume that a sheet encloses, open rims closed by a fan about the mean of their vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Enclosed {
    /// m^3; positive where normals point outwards.
    pub volume: f64,
}

impl Sheet {
    /// The enclosed volume.
    #[must_use]
    pub fn enclosed(&self, positions: &[DVec3]) -> Enclosed {
        let mut sixfold = 0.0;
        self.for_each_side(positions, |[a, b, c], _| sixfold += a.dot(b.cross(c)));
        Enclosed {
            volume: sixfold / 6.0,
        }
    }

    /// Its gradient with respect to each vertex, m^2.
    #[must_use]
    pub fn volume_gradient(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let mut gradient = vec![DVec3::ZERO; positions.len()];
        self.for_each_side(positions, |[a, b, c], owners| {
            let slopes = [b.cross(c) / 6.0, c.cross(a) / 6.0, a.cross(b) / 6.0];
            for (slope, owner) in slopes.into_iter().zip(owners) {
                match owner {
                    Owner::Vertex(vertex) => gradient[*vertex as usize] += slope,
                    Owner::Mean(rim) => {
                        let share = slope / rim.len() as f64;
                        for &vertex in *rim {
                            gradient[vertex as usize] += share;
                        }
                    }
                }
            }
        });
        gradient
    }

    /// All triangles of the closed surface, corners relative to the first vertex so that sheets far from the origin lose no digits.
    fn for_each_side(&self, positions: &[DVec3], mut see: impl FnMut([DVec3; 3], &[Owner<'_>; 3])) {
        let origin = positions[0];
        let at = |vertex: u32| positions[vertex as usize] - origin;
        for corners in self.topology.triangles() {
            see(corners.map(at), &corners.map(Owner::Vertex));
        }
        for rim in self.topology.rims() {
            let sum: DVec3 = rim.iter().map(|&vertex| at(vertex)).sum();
            let mean = sum / rim.len() as f64;
            for (k, &from) in rim.iter().enumerate() {
                let to = rim[(k + 1) % rim.len()];
                let owners = [Owner::Mean(rim), Owner::Vertex(to), Owner::Vertex(from)];
                see([mean, at(to), at(from)], &owners);
            }
        }
    }
}

/// Source of the motion of a corner of the closed surface.
enum Owner<'a> {
    Vertex(u32),
    Mean(&'a [u32]),
}
