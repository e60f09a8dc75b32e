//! The body inside a closed surface, by signed tetrahedra: exact for the polyhedron.

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use rayon::prelude::*;

use super::{DMat3Sum, MassProperties, RawMoments, pairwise_sum};

/// Triangles that one task sums; a constant, so that the result is the same at any number of threads.
const CHUNK: usize = 2048;

/// Volume, centre and second moments of the body inside a closed surface whose corners run counter-clockwise seen from
/// outside; a surface turned inward has negative volume and moments. `None` for a mesh without vertices or with
/// volume 0.
///
/// Each triangle (p, q, s) spans a tetrahedron with an origin near the body, of signed volume `V = p·(q × s)/6`. With
/// corners a_1..a_4 (one is the origin) and S their sum, the integral of x is `V S/4` and that of x xᵀ is
/// `V/20 (sum a_i a_iᵀ + S Sᵀ)`: moments of a simplex (for instance Lien and Kajiya 1984, doi:10.1109/MCG.1984.6429334).
/// It is only right for a surface without holes, see [`crate::surface::inspect`].
#[must_use]
pub fn integrate(mesh: &TriangleMesh) -> Option<MassProperties> {
    let (low, high) = mesh.bounds()?;
    let origin = low + 0.5 * (high - low);
    let parts: Vec<RawMoments> = mesh
        .triangles
        .par_chunks(CHUNK)
        .map(|triangles| {
            let mut sum = RawMoments::default();
            for triangle in triangles {
                sum.add(&tetrahedron(
                    triangle.map(|index| mesh.vertices[index as usize] - origin),
                ));
            }
            sum
        })
        .collect();
    let sum = pairwise_sum(&parts);
    (sum.volume != 0.0).then(|| sum.central(origin))
}

/// The third central moment of the body along a direction in m6: the integral of s³, s counted from `centre` along the
/// unit vector `direction`.
///
/// Third moment of a tetrahedron with s_1..s_4 at its corners: V/20 times the sum of all products s_i s_j s_k with i <= j <= k
/// (the complete homogeneous polynomial of degree 3).
#[must_use]
pub fn third_moment(mesh: &TriangleMesh, centre: DVec3, direction: DVec3) -> f64 {
    let parts: Vec<f64> = mesh
        .triangles
        .par_chunks(CHUNK)
        .map(|triangles| {
            let mut sum = 0.0;
            for triangle in triangles {
                let [p, q, s] = triangle.map(|index| mesh.vertices[index as usize] - centre);
                let volume = p.dot(q.cross(s)) / 6.0;
                let [a, b, c] = [p, q, s].map(|corner| corner.dot(direction));
                // The fourth corner is the centre, where s = 0.
                let h3 = a * a * a
                    + b * b * b
                    + c * c * c
                    + a * a * (b + c)
                    + b * b * (a + c)
                    + c * c * (a + b)
                    + a * b * c;
                sum += volume / 20.0 * h3;
            }
            sum
        })
        .collect();
    parts.iter().sum()
}

/// Area of the surface in m2.
#[must_use]
pub fn area(mesh: &TriangleMesh) -> f64 {
    let parts: Vec<f64> = mesh
        .triangles
        .par_chunks(CHUNK)
        .map(|triangles| {
            let mut sum = 0.0;
            for triangle in triangles {
                let [a, b, c] = triangle.map(|index| mesh.vertices[index as usize]);
                sum += 0.5 * (b - a).cross(c - a).length();
            }
            sum
        })
        .collect();
    parts.iter().sum()
}

/// The tetrahedron of a triangle and the origin.
fn tetrahedron([p, q, s]: [DVec3; 3]) -> RawMoments {
    let volume = p.dot(q.cross(s)) / 6.0;
    let sum = p + q + s;
    let share = volume / 20.0;
    let mixed = |a: DVec3| DVec3::new(a.x * a.y, a.x * a.z, a.y * a.z);
    RawMoments {
        volume,
        first: volume / 4.0 * sum,
        second: DMat3Sum {
            diagonal: share * (p * p + q * q + s * s + sum * sum),
            mixed: share * (mixed(p) + mixed(q) + mixed(s) + mixed(sum)),
        },
    }
}
