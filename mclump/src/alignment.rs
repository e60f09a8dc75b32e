//! Principal axes and the frame of a clump.
//!
//! The frame has its origin in the centre of mass. Its axes are the principal axes in the order of ascending moments, always
//! right-handed: a body is turned, never mirrored. Choices that the inertia leaves open follow these rules, so that a body gets
//! the same pebbles whatever its pose in the input:
//!
//! - **Signs**: the third central moment along an axis is made positive, on the first two axes where it is significant, first of the
//!   body, then of its pebbles. A body that is symmetric there keeps its axes as near the input's as possible.
//! - **Two equal moments** (within their accuracy): the third axis decides; the input's axes are turned with it by the
//!   smallest rotation.
//! - **Three equal moments**: the input's axes stay. A cube is not turned.

pub mod eigen;

use glam::{DMat3, DQuat, DVec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;

use crate::inertia::{MassProperties, pebbles, surface};

/// Moments that differ by less than this fraction of their sum are equal, or by less than the error of their route.
pub const EQUAL: f64 = 1e-9;
/// A third moment is significant above this fraction of volume times radius of gyration cubed: above the noise of
/// single-precision surfaces, about 1e-7, and far below the skewness that an eye sees, about 1e-2.
pub const SIGNIFICANT: f64 = 1e-6;

/// The frame of a clump in the frame of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Origin: the centre of mass in m.
    pub centre: DVec3,
    /// The principal axes as columns; determinant +1.
    pub rotation: DMat3,
}

impl Frame {
    /// A point of the input in the clump's frame: `rotationᵀ (x - centre)`.
    #[must_use]
    pub fn to_body(&self, point: DVec3) -> DVec3 {
        self.rotation.transpose() * (point - self.centre)
    }

    /// Pebbles of the input in the clump's frame.
    #[must_use]
    pub fn align_pebbles(&self, pebbles: &[Pebble]) -> Vec<Pebble> {
        let aligned = |pebble: &Pebble| Pebble {
            position: self.to_body(pebble.position),
            radius: pebble.radius,
        };
        pebbles.iter().map(aligned).collect()
    }

    /// A surface of the input in the clump's frame.
    #[must_use]
    pub fn align_mesh(&self, mesh: &TriangleMesh) -> TriangleMesh {
        TriangleMesh {
            vertices: mesh.vertices.iter().map(|v| self.to_body(*v)).collect(),
            ..mesh.clone()
        }
    }
}

/// Principal moments that are equal within their accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Equal {
    /// All differ.
    None,
    /// The two smaller ones: the third axis stands out.
    FirstTwo,
    /// The two larger ones: the first axis stands out.
    LastTwo,
    /// All three.
    All,
}

/// A frame, and how it came about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alignment {
    /// The frame.
    pub frame: Frame,
    /// Principal moments per unit density in m5, ascending; equal ones are set to their mean.
    pub moments: DVec3,
    /// Moments that are equal.
    pub equal: Equal,
    /// Axes whose direction follows from a third moment; the others follow from the input's axes, or from being right-handed.
    pub skewed: [bool; 3],
}

/// Finds the frame of a body. `relative_error` is that of its properties relative to the trace of the inertia (0 for a closed
/// form). `mesh` is the surface if the properties are the surface's; `pebbles` decide where it is symmetric.
#[must_use]
pub fn align(
    properties: &MassProperties,
    relative_error: f64,
    mesh: Option<&TriangleMesh>,
    pebbles: &[Pebble],
) -> Alignment {
    let decomposition = eigen::symmetric(properties.inertia());
    let [a, b, c] = decomposition.values.to_array();
    let tolerance = relative_error.max(EQUAL) * (a + b + c);
    let (first_two, last_two) = (b - a <= tolerance, c - b <= tolerance);
    let skewness = Skewness::new(properties, mesh, pebbles);
    let axes = decomposition.vectors;
    let (equal, moments, rotation, skewed) = match (first_two, last_two) {
        (true, true) => {
            let mean = DVec3::splat((a + b + c) / 3.0);
            (Equal::All, mean, DMat3::IDENTITY, [false; 3])
        }
        (true, false) => {
            let (rotation, skewed) = about_unique(2, axes.z_axis, &skewness);
            let mean = 0.5 * (a + b);
            (Equal::FirstTwo, DVec3::new(mean, mean, c), rotation, skewed)
        }
        (false, true) => {
            let (rotation, skewed) = about_unique(0, axes.x_axis, &skewness);
            let mean = 0.5 * (b + c);
            (Equal::LastTwo, DVec3::new(a, mean, mean), rotation, skewed)
        }
        (false, false) => {
            let (rotation, skewed) = signed(axes, &skewness);
            (Equal::None, decomposition.values, rotation, skewed)
        }
    };
    Alignment {
        frame: Frame {
            centre: properties.centre,
            rotation,
        },
        moments,
        equal,
        skewed,
    }
}

/// Third central moments of the body and of its pebbles.
struct Skewness<'a> {
    mesh: Option<(&'a TriangleMesh, DVec3, f64)>,
    pebbles: Option<(&'a [Pebble], DVec3, f64)>,
}

impl<'a> Skewness<'a> {
    fn new(
        properties: &MassProperties,
        mesh: Option<&'a TriangleMesh>,
        pebbles: &'a [Pebble],
    ) -> Self {
        // About the pebbles' own centre, which is exact, whatever route the body's centre comes from.
        let own = pebbles::integrate(pebbles);
        Self {
            mesh: mesh.map(|mesh| (mesh, properties.centre, scale(properties))),
            pebbles: own.map(|own| (pebbles, own.centre, scale(&own))),
        }
    }

    /// -1 or 1 where the third moment along the direction is significant, by the authorities in their order.
    fn sign(&self, authority: usize, direction: DVec3) -> Option<f64> {
        let relative = match authority {
            0 => {
                let (mesh, centre, scale) = self.mesh?;
                surface::third_moment(mesh, centre, direction) / scale
            }
            _ => {
                let (pebbles, centre, scale) = self.pebbles?;
                pebbles::third_moment(pebbles, centre, direction) / scale
            }
        };
        (relative.abs() > SIGNIFICANT).then(|| relative.signum())
    }
}

/// Volume times the radius of gyration cubed.
fn scale(properties: &MassProperties) -> f64 {
    let j = properties.second_moment;
    let square = (j.x_axis.x + j.y_axis.y + j.z_axis.z) / properties.volume;
    properties.volume * square.powf(1.5)
}

/// Body, then pebbles.
const AUTHORITIES: [usize; 2] = [0, 1];

/// The smallest rotation that brings the input's axis `index` on the direction that stands out.
fn about_unique(index: usize, direction: DVec3, skewness: &Skewness<'_>) -> (DMat3, [bool; 3]) {
    let mut skewed = [false; 3];
    let decided = AUTHORITIES
        .iter()
        .find_map(|&authority| skewness.sign(authority, direction));
    let axis = match decided {
        Some(sign) => {
            skewed[index] = true;
            sign * direction
        }
        None => direction * nearer(direction, index),
    };
    let start = DVec3::AXES[index];
    let cosine = start.dot(axis);
    let rotation = if cosine > -1.0 + 1e-12 {
        DMat3::from_quat(DQuat::from_rotation_arc(start, axis))
    } else {
        // Half a turn about the next axis: every perpendicular one would do.
        DMat3::from_quat(DQuat::from_axis_angle(
            DVec3::AXES[(index + 1) % 3],
            std::f64::consts::PI,
        ))
    };
    (with_axis(rotation, index, axis), skewed)
}

/// The rotation with one column set exactly and the others made perpendicular to it.
fn with_axis(rotation: DMat3, index: usize, axis: DVec3) -> DMat3 {
    let next = rotation.col((index + 1) % 3);
    let next = (next - axis * axis.dot(next)).normalize();
    let mut columns = [DVec3::ZERO; 3];
    columns[index] = axis;
    columns[(index + 1) % 3] = next;
    columns[(index + 2) % 3] = axis.cross(next);
    DMat3::from_cols(columns[0], columns[1], columns[2])
}

/// The sign that turns a direction towards the input's axis `index`; where it is perpendicular to it, the one that
/// makes its first significant component positive.
fn nearer(direction: DVec3, index: usize) -> f64 {
    let component = |k: usize| {
        let x = direction[k];
        (x.abs() > 1e-9).then(|| x.signum())
    };
    component(index)
        .or_else(|| component(0))
        .or_else(|| component(1))
        .or_else(|| component(2))
        .unwrap_or(1.0)
}

/// Right-handed principal axes with their signs.
fn signed(axes: DMat3, skewness: &Skewness<'_>) -> (DMat3, [bool; 3]) {
    let mut wanted: [Option<f64>; 3] = [None; 3];
    for authority in AUTHORITIES {
        for (k, wanted_k) in wanted.clone().iter().enumerate() {
            // Two signs decide, the third follows from being right-handed.
            let decided = wanted.iter().flatten().count();
            if decided < 2 && wanted_k.is_none() {
                wanted[k] = skewness.sign(authority, axes.col(k));
            }
        }
    }
    let mut best: Option<(f64, DMat3)> = None;
    for signs in [
        [1.0, 1.0, 1.0],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ] {
        let fits = signs
            .iter()
            .zip(wanted)
            .all(|(sign, wanted)| wanted.is_none_or(|wanted| wanted == *sign));
        if !fits {
            continue;
        }
        let candidate = DMat3::from_cols(
            axes.x_axis * signs[0],
            axes.y_axis * signs[1],
            axes.z_axis * signs[2],
        );
        // How near the input's axes; of equally near ones the entries decide, in their order.
        let trace = candidate.x_axis.x + candidate.y_axis.y + candidate.z_axis.z;
        let better = best.is_none_or(|(most, rotation)| {
            trace > most + 1e-9 || (trace > most - 1e-9 && earlier(&candidate, &rotation))
        });
        if better {
            best = Some((trace, candidate));
        }
    }
    let rotation = best.map_or(axes, |(_, rotation)| rotation);
    (rotation, wanted.map(|sign| sign.is_some()))
}

/// Whether the first entry in which two matrices differ is larger in the first.
fn earlier(a: &DMat3, b: &DMat3) -> bool {
    let (a, b) = (a.to_cols_array(), b.to_cols_array());
    let first = a.iter().zip(b).find(|(a, b)| (*a - b).abs() > 1e-9);
    first.is_some_and(|(a, b)| *a > b)
}
