//! Surfaces for tests.

use glam::{DQuat, DVec3};
use mercury_common::formats::mesh::TriangleMesh;

/// A mesh of given corners and triangles.
pub(crate) fn mesh(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh {
        vertices,
        triangles,
        ..TriangleMesh::default()
    }
}

/// The box from `low` to `high`.
pub(crate) fn cuboid(low: DVec3, high: DVec3) -> TriangleMesh {
    let vertices = (0..8u32)
        .map(|k| {
            let pick = |bit: u32, axis: usize| {
                if k >> bit & 1 == 1 {
                    high[axis]
                } else {
                    low[axis]
                }
            };
            DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        })
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    mesh(vertices, triangles)
}

/// The octahedron with corners at distance 1 from the origin; inradius 1/sqrt(3).
pub(crate) fn octahedron() -> TriangleMesh {
    let vertices = vec![
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ];
    let triangles = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    mesh(vertices, triangles)
}

/// An ellipsoid of revolution about x: rings of corners on the exact surface.
pub(crate) fn spheroid(a: f64, b: f64, rings: u32, around: u32) -> TriangleMesh {
    let mut vertices = vec![DVec3::X * a];
    for i in 1..rings {
        let (sin, cos) = (std::f64::consts::PI * f64::from(i) / f64::from(rings)).sin_cos();
        for j in 0..around {
            let (s, c) = (std::f64::consts::TAU * f64::from(j) / f64::from(around)).sin_cos();
            vertices.push(DVec3::new(a * cos, b * sin * c, b * sin * s));
        }
    }
    let last = vertices.len() as u32;
    vertices.push(-DVec3::X * a);
    let at = |i: u32, j: u32| 1 + (i - 1) * around + j % around;
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([0, at(1, j), at(1, j + 1)]);
        triangles.push([last, at(rings - 1, j + 1), at(rings - 1, j)]);
        for i in 1..rings - 1 {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh(vertices, triangles)
}

/// A torus about z.
pub(crate) fn torus(major: f64, minor: f64, along: u32, around: u32) -> TriangleMesh {
    let mut vertices = Vec::new();
    for i in 0..along {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(along)).sin_cos();
        for j in 0..around {
            let (t, d) = (std::f64::consts::TAU * f64::from(j) / f64::from(around)).sin_cos();
            let r = major + minor * d;
            vertices.push(DVec3::new(r * c, r * s, minor * t));
        }
    }
    let at = |i: u32, j: u32| (i % along) * around + j % around;
    let mut triangles = Vec::new();
    for i in 0..along {
        for j in 0..around {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh(vertices, triangles)
}

/// Two meshes in one; the second turned inside out on request.
pub(crate) fn join(mut first: TriangleMesh, second: &TriangleMesh, inverted: bool) -> TriangleMesh {
    let shift = first.vertices.len() as u32;
    first.vertices.extend(&second.vertices);
    first
        .triangles
        .extend(second.triangles.iter().map(|&[a, b, c]| {
            let [b, c] = if inverted { [c, b] } else { [b, c] };
            [a + shift, b + shift, c + shift]
        }));
    first
}

/// A turned, scaled and moved mesh.
pub(crate) fn moved(mesh: &TriangleMesh, turn: DQuat, scale: f64, shift: DVec3) -> TriangleMesh {
    TriangleMesh {
        vertices: mesh
            .vertices
            .iter()
            .map(|&v| turn * v * scale + shift)
            .collect(),
        ..mesh.clone()
    }
}
