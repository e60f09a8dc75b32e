//! Planes cut at a box.

use glam::DVec3;

use crate::formats::mesh::TriangleMesh;

/// Everything in front of a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// A point of the plane, m.
    pub point: DVec3,
    /// Unit normal into the half-space.
    pub normal: DVec3,
}

/// The corners of a box, numbered by bits.
pub(super) fn corners((min, max): (DVec3, DVec3)) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        DVec3::from_array(std::array::from_fn(|axis| {
            if k >> axis & 1 == 0 {
                min[axis]
            } else {
                max[axis]
            }
        }))
    })
}

/// A flat domain, as of two-dimensional scenes, gets a hundredth of its diagonal as thickness, so that walls are seen.
pub(super) fn with_thickness((min, max): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let extra = 0.005 * (max - min).length();
    let flat = (max - min).cmple(DVec3::ZERO);
    let grown = DVec3::select(flat, DVec3::splat(extra), DVec3::ZERO);
    (min - grown, max + grown)
}

/// The part of a plane inside a box and half-spaces, as a fan of triangles that turn about the normal.
pub(super) fn plane_in_box(
    plane: &HalfSpace,
    (min, max): (DVec3, DVec3),
    cuts: &[HalfSpace],
) -> TriangleMesh {
    let size = (max - min).length();
    if !(size.is_finite() && size > 0.0 && plane.normal.is_finite() && plane.point.is_finite()) {
        return TriangleMesh::default();
    }
    // A square of the plane that is larger than the box, cut by its faces in turn. A face of the box that lies in the
    // plane must survive round-off.
    let slack = 1e-9 * size;
    let centre = 0.5 * (min + max);
    let foot = centre - plane.normal * (centre - plane.point).dot(plane.normal);
    let (u, v) = plane.normal.any_orthonormal_pair();
    let mut polygon = vec![
        foot + (u + v) * size,
        foot + (v - u) * size,
        foot - (u + v) * size,
        foot + (u - v) * size,
    ];
    for axis in DVec3::AXES {
        polygon = cut(&polygon, |x| (x - min).dot(axis) + slack);
        polygon = cut(&polygon, |x| (max - x).dot(axis) + slack);
    }
    for half in cuts {
        polygon = cut(&polygon, |x| (x - half.point).dot(half.normal) + slack);
    }
    if polygon.len() < 3 {
        return TriangleMesh::default();
    }
    let last = polygon.len() as u32 - 1;
    TriangleMesh {
        vertices: polygon,
        triangles: (1..last).map(|k| [0, k, k + 1]).collect(),
        ..TriangleMesh::default()
    }
}

/// The part of a convex polygon where `height` is not negative (I. Sutherland and G. Hodgman, 1974).
fn cut(polygon: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &to) in polygon.iter().enumerate() {
        let from = polygon[(k + polygon.len() - 1) % polygon.len()];
        let (a, b) = (height(from), height(to));
        if (a < 0.0) != (b < 0.0) {
            kept.push(from + (to - from) * (a / (a - b)));
        }
        if b >= 0.0 {
            kept.push(to);
        }
    }
    kept
}
