//! A closed surface in its own frame, and distances to it.

use std::collections::HashMap;

use glam::{DMat3, DVec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TriMeshFlags, TrianglePointLocation};

use super::GenerateError;
use crate::alignment::eigen;
use crate::inertia::{MassProperties, surface::integrate};

/// A body in a frame of its own: origin at its centre of mass, axes along its principal axes (the longest first), unit
/// of length the radius of the ball of equal volume.
///
/// Only in such a frame do results not depend on where the mesh lies, how it is turned and in which unit it is.
pub(crate) struct Body {
    mesh: TriMesh,
    /// Unit of length in m.
    pub(crate) unit: f64,
    /// Centre of mass in m.
    centre: DVec3,
    /// Columns are the principal axes.
    axes: DMat3,
    /// 4 pi/3 but for round-off.
    pub(crate) volume: f64,
    /// Smallest and largest coordinates.
    pub(crate) bounds: (DVec3, DVec3),
    /// Mass properties of the mesh by its integrals, in the frame of the mesh.
    pub(crate) properties: MassProperties,
    /// Corners and outward unit normal of the triangles that have an area.
    pub(crate) faces: Vec<Face>,
}

/// A triangle with an area.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    pub(crate) corners: [DVec3; 3],
    /// Unit, outward.
    pub(crate) normal: DVec3,
    pub(crate) area: f64,
}

impl Face {
    /// Is a point of its plane inside the triangle?
    pub(crate) fn contains(&self, point: DVec3) -> bool {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
            .into_iter()
            .all(|(from, to)| (to - from).cross(point - from).dot(self.normal) >= 0.0)
    }
}

/// The surface as seen from a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nearest {
    /// Distance to the surface, positive inside.
    pub(crate) depth: f64,
    /// The nearest surface point.
    pub(crate) point: DVec3,
    /// Where the depth grows fastest: a unit vector.
    pub(crate) inward: DVec3,
    /// Outward normal of the triangle of the nearest point.
    pub(crate) normal: DVec3,
    /// Its number among [`Body::faces`].
    pub(crate) face: usize,
}

impl Body {
    pub(crate) fn new(surface: &TriangleMesh) -> Result<Self, GenerateError> {
        if let Some(vertex) = surface.vertices.iter().position(|v| !v.is_finite()) {
            return Err(GenerateError::NotFinite { vertex });
        }
        if surface.triangles.len() == surface.degenerate_triangles().len() {
            return Err(GenerateError::Empty);
        }
        let edges = unbalanced_edges(surface);
        if edges > 0 {
            return Err(GenerateError::Open { edges });
        }
        let integrals = integrate(surface).ok_or(GenerateError::NotOutward { volume: 0.0 })?;
        // Round-off of a flat, doubly covered sheet is no volume.
        let (low, high) = surface.bounds().ok_or(GenerateError::Empty)?;
        let extent = (high - low).max_element();
        if integrals.volume.is_nan() || integrals.volume <= 1e-12 * extent.powi(3) {
            return Err(GenerateError::NotOutward {
                volume: integrals.volume,
            });
        }
        let unit = (0.75 * integrals.volume / std::f64::consts::PI).cbrt();
        let axes = long_axes_first(surface, &integrals);
        let turned = axes.transpose();
        let vertices: Vec<DVec3> = surface
            .vertices
            .iter()
            .map(|&v| turned * (v - integrals.centre) / unit)
            .collect();
        let mut faces = Vec::with_capacity(surface.triangles.len());
        let mut triangles = Vec::with_capacity(surface.triangles.len());
        for &triangle in &surface.triangles {
            let corners = triangle.map(|index| vertices[index as usize]);
            let double = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let length = double.length();
            if length > 0.0 {
                faces.push(Face {
                    corners,
                    normal: double / length,
                    area: 0.5 * length,
                });
                triangles.push(triangle);
            }
        }
        let bounds = vertices
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), v| {
                (l.min(*v), h.max(*v))
            });
        let points = vertices.iter().map(|&v| to_parry(v)).collect();
        let mesh = TriMesh::with_flags(points, triangles, TriMeshFlags::ORIENTED)
            .map_err(|_| GenerateError::Empty)?;
        Ok(Self {
            mesh,
            unit,
            centre: integrals.centre,
            axes,
            volume: integrals.volume / unit.powi(3),
            bounds,
            properties: integrals,
            faces,
        })
    }

    /// The nearest surface point of a point; inside or outside by the angle-weighted pseudo-normal (Baerentzen and Aanaes 2005,
    /// doi:10.1109/TVCG.2005.49).
    pub(crate) fn nearest(&self, point: DVec3) -> Nearest {
        let (projection, (face, location)) = self
            .mesh
            .project_local_point_and_get_location(to_parry(point), false);
        let face = face as usize;
        let normal = self.faces[face].normal;
        let foot = from_parry(projection.point);
        let offset = point - foot;
        let distance = offset.length();
        let inside = if matches!(location, TrianglePointLocation::OnFace(..)) {
            offset.dot(normal) <= 0.0
        } else {
            projection.is_inside
        };
        let sign = if inside { 1.0 } else { -1.0 };
        Nearest {
            depth: sign * distance,
            point: foot,
            inward: if distance > 1e-14 {
                offset * (sign / distance)
            } else {
                -normal
            },
            normal,
            face,
        }
    }

    /// Winding number of the surface around a point: 1 inside, 0 outside, by the solid angles of all triangles (van Oosterom and
    /// Strackee 1983, doi:10.1109/TBME.1983.325207). Slow, and right for every closed surface.
    pub(crate) fn winding_number(&self, point: DVec3) -> f64 {
        let angle = |face: &Face| {
            let [a, b, c] = face.corners.map(|corner| corner - point);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let above = a.dot(b.cross(c));
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * above.atan2(below)
        };
        let sum: f64 = self.faces.iter().map(angle).sum();
        sum / (4.0 * std::f64::consts::PI)
    }

    /// Random points, one in each of `count` equal shares of the area, with the indices of their faces.
    pub(crate) fn surface_points(&self, count: usize, stream: &mut Stream) -> Vec<(DVec3, usize)> {
        let mut sums = Vec::with_capacity(self.faces.len());
        let mut area = 0.0;
        for face in &self.faces {
            area += face.area;
            sums.push(area);
        }
        (0..count)
            .map(|k| {
                let at = area * (k as f64 + stream.uniform()) / count as f64;
                let index = sums.partition_point(|&sum| sum <= at).min(sums.len() - 1);
                let (u, v) = (stream.uniform().sqrt(), stream.uniform());
                let [a, b, c] = self.faces[index].corners;
                (a * (1.0 - u) + b * (u * (1.0 - v)) + c * (u * v), index)
            })
            .collect()
    }

    /// A pebble in the frame of the mesh, lengths in m.
    pub(crate) fn to_mesh(&self, ball: &Pebble) -> Pebble {
        Pebble {
            position: self.centre + self.axes * ball.position * self.unit,
            radius: ball.radius * self.unit,
        }
    }

    /// A pebble in the frame of the body.
    pub(crate) fn to_body(&self, pebble: &Pebble) -> Pebble {
        Pebble {
            position: self.axes.transpose() * (pebble.position - self.centre) / self.unit,
            radius: pebble.radius / self.unit,
        }
    }
}

/// Principal axes, the longest first, right-handed, the first two pointing to where the body reaches farther.
fn long_axes_first(mesh: &TriangleMesh, properties: &MassProperties) -> DMat3 {
    let vectors = eigen::symmetric(properties.second_moment).vectors;
    let towards_far_end = |axis: DVec3| {
        let (low, high) = mesh.vertices.iter().fold((0.0f64, 0.0f64), |(l, h), v| {
            let along = (*v - properties.centre).dot(axis);
            (l.min(along), h.max(along))
        });
        // Symmetric bodies keep the axis as it comes.
        if -low > high * (1.0 + 1e-9) {
            -axis
        } else {
            axis
        }
    };
    let x = towards_far_end(vectors.z_axis);
    let y = towards_far_end(vectors.y_axis);
    DMat3::from_cols(x, y, x.cross(y))
}

/// Edges that are not walked as often in one direction as in the other.
fn unbalanced_edges(mesh: &TriangleMesh) -> usize {
    let mut balance: HashMap<(u32, u32), i64> = HashMap::with_capacity(2 * mesh.triangles.len());
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                let sign = if from < to { 1 } else { -1 };
                *balance.entry((from.min(to), from.max(to))).or_default() += sign;
            }
        }
    }
    balance.values().filter(|&&sum| sum != 0).count()
}

/// Border to the mathematics of parry, which has another version of glam.
pub(crate) fn to_parry(v: DVec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// See [`to_parry`].
pub(crate) fn from_parry(v: Vector) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}
