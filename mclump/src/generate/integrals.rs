//! Volume, centre and principal axes of a surface.

use glam::{DMat3, DVec3};
use mercury_common::formats::mesh::TriangleMesh;

/// Integrals over a body.
pub(crate) struct Integrals {
    /// m3
    pub(crate) volume: f64,
    /// m
    pub(crate) centre: DVec3,
    /// The integral of x xᵀ about the centre, m5.
    pub(crate) second: DMat3,
}

/// Signed tetrahedra over the triangles.
pub(crate) fn of_surface(mesh: &TriangleMesh) -> Integrals {
    let origin = mesh.bounds().map_or(DVec3::ZERO, |(l, h)| 0.5 * (l + h));
    let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for triangle in &mesh.triangles {
        let corners = triangle.map(|index| mesh.vertices[index as usize] - origin);
        let [p, q, s] = corners;
        let v = p.dot(q.cross(s)) / 6.0;
        let sum = p + q + s;
        volume += v;
        first += 0.25 * v * sum;
        for x in [p, q, s, sum] {
            second += DMat3::from_cols(x * x.x, x * x.y, x * x.z) * (v / 20.0);
        }
    }
    let offset = first / volume;
    let shift = DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z);
    Integrals {
        volume,
        centre: origin + offset,
        second: second - shift * volume,
    }
}

/// Principal axes, the longest first, right-handed, each pointing to where the body reaches farther.
pub(crate) fn long_axes_first(mesh: &TriangleMesh, integrals: &Integrals) -> DMat3 {
    let s = integrals.second;
    let matrix = nalgebra::Matrix3::from_fn(|i, j| s.col(j)[i]);
    let eigen = matrix.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axis = |k: usize| {
        let column = eigen.eigenvectors.column(order[k]);
        let axis = DVec3::new(column[0], column[1], column[2]).normalize();
        let (low, high) = mesh.vertices.iter().fold((0.0f64, 0.0f64), |(l, h), v| {
            let along = (*v - integrals.centre).dot(axis);
            (l.min(along), h.max(along))
        });
        if -low > high * (1.0 + 1e-9) {
            -axis
        } else {
            axis
        }
    };
    let (x, y) = (axis(0), axis(1));
    DMat3::from_cols(x, y, x.cross(y))
}
