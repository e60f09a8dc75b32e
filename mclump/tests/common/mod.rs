//! Helpers of the tests: shapes with closed forms, bodies in any pose, the reference data.
#![allow(dead_code, reason = "each test file uses a part")]

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;
pub(crate) use mercury_common::reference_data::shared;

pub(crate) fn pebble(x: f64, y: f64, z: f64, radius: f64) -> Pebble {
    Pebble {
        position: DVec3::new(x, y, z),
        radius,
    }
}

pub(crate) fn mesh(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh {
        vertices,
        triangles,
        ..TriangleMesh::default()
    }
}

/// A box with edges 2 a, 2 b, 2 c about the origin.
pub(crate) fn cuboid(half: DVec3) -> TriangleMesh {
    let vertices = (0..8)
        .map(|i| {
            let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            half * DVec3::new(sign(0), sign(1), sign(2))
        })
        .collect();
    let quads: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles = quads
        .iter()
        .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
        .collect();
    mesh(vertices, triangles)
}

pub(crate) fn tetrahedron() -> TriangleMesh {
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    mesh(
        vec![
            v(0.0, 0.0, 0.0),
            v(1.0, 0.0, 0.0),
            v(0.0, 1.0, 0.0),
            v(0.0, 0.0, 1.0),
        ],
        vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    )
}

/// The octahedron |x| + |y| + |z| <= a.
pub(crate) fn octahedron(a: f64) -> TriangleMesh {
    let vertices = [
        DVec3::X,
        -DVec3::X,
        DVec3::Y,
        -DVec3::Y,
        DVec3::Z,
        -DVec3::Z,
    ];
    mesh(
        vertices.iter().map(|v| *v * a).collect(),
        vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ],
    )
}

/// The unit sphere: an octahedron, each triangle divided `levels` times into four.
pub(crate) fn sphere(levels: u32) -> TriangleMesh {
    let mut sphere = octahedron(1.0);
    for _ in 0..levels {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut triangles = Vec::new();
        for &[a, b, c] in &sphere.triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let sum = sphere.vertices[i as usize] + sphere.vertices[j as usize];
                    sphere.vertices.push(sum.normalize());
                    sphere.vertices.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        sphere.triangles = triangles;
    }
    sphere
}

/// A torus about z with radii `big` and `small`, of n by n quads.
pub(crate) fn torus(big: f64, small: f64, n: u32) -> TriangleMesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let (u, v) = (
                TAU * f64::from(i) / f64::from(n),
                TAU * f64::from(j) / f64::from(n),
            );
            let rho = big + small * v.cos();
            vertices.push(DVec3::new(rho * u.cos(), rho * u.sin(), small * v.sin()));
            let at = |i: u32, j: u32| (i % n) * n + j % n;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh(vertices, triangles)
}

/// A cone with base radius `r` at z = 0 and its tip at z = `h`, of n sides.
pub(crate) fn cone(r: f64, h: f64, n: u32) -> TriangleMesh {
    let mut vertices: Vec<DVec3> = (0..n)
        .map(|i| {
            let u = TAU * f64::from(i) / f64::from(n);
            DVec3::new(r * u.cos(), r * u.sin(), 0.0)
        })
        .collect();
    vertices.push(DVec3::new(0.0, 0.0, h));
    vertices.push(DVec3::ZERO);
    let triangles = (0..n)
        .flat_map(|i| {
            let j = (i + 1) % n;
            [[i, j, n], [j, i, n + 1]]
        })
        .collect();
    mesh(vertices, triangles)
}

pub(crate) fn mapped(mesh: &TriangleMesh, map: impl Fn(DVec3) -> DVec3) -> TriangleMesh {
    TriangleMesh {
        vertices: mesh.vertices.iter().map(|v| map(*v)).collect(),
        ..mesh.clone()
    }
}

pub(crate) fn turned_round(mesh: &TriangleMesh) -> TriangleMesh {
    TriangleMesh {
        triangles: mesh
            .triangles
            .iter()
            .map(|[a, b, c]| [*a, *c, *b])
            .collect(),
        ..mesh.clone()
    }
}

/// Two meshes as one.
pub(crate) fn together(a: &TriangleMesh, b: &TriangleMesh) -> TriangleMesh {
    let offset = a.vertices.len() as u32;
    let mut both = a.clone();
    both.vertices.extend(&b.vertices);
    both.triangles
        .extend(b.triangles.iter().map(|t| t.map(|index| index + offset)));
    both
}

/// A pear with no symmetry: one large pebble, three smaller ones on it, none overlapping.
pub(crate) fn odd_pebbles() -> Vec<Pebble> {
    vec![
        pebble(0.0, 0.0, 0.0, 1.0),
        pebble(1.6, 0.0, 0.0, 0.5),
        pebble(-0.3, 1.4, 0.2, 0.4),
        pebble(0.2, 0.3, -1.5, 0.5),
    ]
}

/// A rotation from four numbers that are not all 0.
pub(crate) fn turn(numbers: [f64; 4]) -> DMat3 {
    DMat3::from_quat(DQuat::from_array(numbers).normalize())
}

pub(crate) fn ball_volume(r: f64) -> f64 {
    4.0 / 3.0 * PI * r.powi(3)
}

pub(crate) fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "{what}: {found} is not {expected} to {relative:e}, but to {:e}",
        (found / expected - 1.0).abs()
    );
}

pub(crate) fn assert_vectors(found: DVec3, expected: DVec3, absolute: f64, what: &str) {
    assert!(
        found.abs_diff_eq(expected, absolute),
        "{what}: {found} is not {expected} to {absolute:e}"
    );
}
