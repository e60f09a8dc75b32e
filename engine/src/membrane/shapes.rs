//! Meshes that are built in, of triangles as equilateral as the shape allows.

use glam::DVec3;

use mercury_common::formats::mesh::TriangleMesh;

/// Height of an equilateral triangle over its edge.
const HEIGHT: f64 = 0.866_025_403_784_438_6;

fn whole(parts: f64, least: u32) -> u32 {
    // Saturates: too many triangles are refused before.
    (parts.round() as u32).max(least)
}

/// Largest number of triangles of the shape, before it is built.
#[must_use]
pub fn about_triangles(area: f64, edge: f64) -> f64 {
    area / (0.5 * HEIGHT * edge * edge)
}

/// A rectangle from a corner along two vectors at right angles, m: rows parallel to `along`, half triangles at their ends. The normal is that of
/// `along` x `across`.
#[must_use]
pub fn rectangle(corner: DVec3, along: DVec3, across: DVec3, edge: f64) -> TriangleMesh {
    let columns = whole(along.length() / edge, 1);
    let rows = whole(across.length() / (HEIGHT * edge), 1);
    let mut mesh = TriangleMesh::default();
    let mut row_start = Vec::new();
    for row in 0..=rows {
        row_start.push(mesh.vertices.len() as u32);
        let up = corner + across * (f64::from(row) / f64::from(rows));
        let at = |place: f64| up + along * (place / f64::from(columns));
        if row % 2 == 0 {
            mesh.vertices
                .extend((0..=columns).map(|k| at(f64::from(k))));
        } else {
            mesh.vertices.push(at(0.0));
            mesh.vertices
                .extend((0..columns).map(|k| at(f64::from(k) + 0.5)));
            mesh.vertices.push(at(f64::from(columns)));
        }
    }
    for row in 0..rows {
        let (low, high) = (row_start[row as usize], row_start[row as usize + 1]);
        if row % 2 == 0 {
            for k in 0..columns {
                mesh.triangles.push([low + k, low + k + 1, high + k + 1]);
            }
            for k in 0..=columns {
                mesh.triangles.push([low + k, high + k + 1, high + k]);
            }
        } else {
            for k in 0..=columns {
                mesh.triangles.push([low + k, low + k + 1, high + k]);
            }
            for k in 0..columns {
                mesh.triangles.push([high + k, low + k + 1, high + k + 1]);
            }
        }
    }
    mesh
}

/// A disc: rings of 6, 12, 18 ... vertices about its centre. `axis`: unit vector, the normal.
#[must_use]
pub fn disc(axis: DVec3, origin: DVec3, radius: f64, edge: f64) -> TriangleMesh {
    let rings = whole(radius / edge, 1);
    let (one, other) = axis.any_orthonormal_pair();
    let mut mesh = TriangleMesh::default();
    mesh.vertices.push(origin);
    let first_of = |ring: u32| {
        if ring == 0 {
            0
        } else {
            1 + 3 * ring * (ring - 1)
        }
    };
    for ring in 1..=rings {
        let count = 6 * ring;
        let distance = radius * (f64::from(ring) / f64::from(rings));
        for k in 0..count {
            let angle = std::f64::consts::TAU * (f64::from(k) / f64::from(count));
            let (sin, cos) = libm::sincos(angle);
            mesh.vertices
                .push(origin + distance * (cos * one + sin * other));
        }
        let at = |ring: u32, sector: u32, k: u32| {
            if ring == 0 {
                return 0;
            }
            first_of(ring) + (sector * ring + k) % (6 * ring)
        };
        for sector in 0..6 {
            for k in 0..ring {
                let outer = [at(ring, sector, k), at(ring, sector, k + 1)];
                let inner = at(ring - 1, sector, k);
                mesh.triangles.push([inner, outer[0], outer[1]]);
                if k + 1 < ring {
                    mesh.triangles
                        .push([inner, outer[1], at(ring - 1, sector, k + 1)]);
                }
            }
        }
    }
    mesh
}

/// A cylinder without ends: rows around the axis, normals outwards. `axis`: unit vector; `along`: from and to, m from the origin.
#[must_use]
pub fn cylinder(
    axis: DVec3,
    origin: DVec3,
    radius: f64,
    along: [f64; 2],
    edge: f64,
) -> TriangleMesh {
    let around = whole(std::f64::consts::TAU * radius / edge, 3);
    let height = along[1] - along[0];
    let rows = whole(height / (HEIGHT * edge), 1);
    let (one, other) = axis.any_orthonormal_pair();
    let mut mesh = TriangleMesh::default();
    for row in 0..=rows {
        let centre = origin + axis * (along[0] + height * (f64::from(row) / f64::from(rows)));
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        for k in 0..around {
            let part = (f64::from(k) + shift) / f64::from(around);
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * part);
            mesh.vertices
                .push(centre + radius * (cos * one + sin * other));
        }
    }
    for row in 0..rows {
        let low = |k: u32| row * around + k % around;
        let high = |k: u32| (row + 1) * around + k % around;
        for k in 0..around {
            if row % 2 == 0 {
                mesh.triangles.push([low(k), low(k + 1), high(k)]);
                mesh.triangles.push([low(k + 1), high(k + 1), high(k)]);
            } else {
                mesh.triangles.push([low(k), low(k + 1), high(k + 1)]);
                mesh.triangles.push([low(k), high(k + 1), high(k)]);
            }
        }
    }
    mesh
}

/// A sphere: a subdivided icosahedron, normals outwards.
#[must_use]
pub fn sphere(origin: DVec3, radius: f64, edge: f64) -> TriangleMesh {
    // 20 n^2 triangles of the mean area of equilateral ones with this edge.
    let mean_area = 0.5 * HEIGHT * edge * edge;
    let area = 2.0 * std::f64::consts::TAU * radius * radius;
    let parts = whole((area / (20.0 * mean_area)).sqrt(), 1);
    let (corners, faces) = icosahedron();
    let mut mesh = TriangleMesh::default();
    mesh.vertices.extend(&corners);
    // Vertices on each edge of the icosahedron, from its lower corner.
    let mut on_edge = std::collections::BTreeMap::new();
    for &[a, b, c] in &faces {
        let mut grid = Vec::new();
        for row in 0..=parts {
            for k in 0..=row {
                // Barycentric: a at row 0, b at the start of the last row, c at its end.
                let weights = [parts - row, row - k, k];
                grid.push(vertex(
                    &mut mesh,
                    &mut on_edge,
                    [a, b, c],
                    weights,
                    &corners,
                ));
            }
        }
        let at = |row: u32, k: u32| grid[(row * (row + 1) / 2 + k) as usize];
        for row in 0..parts {
            for k in 0..=row {
                mesh.triangles
                    .push([at(row, k), at(row + 1, k), at(row + 1, k + 1)]);
                if k < row {
                    mesh.triangles
                        .push([at(row, k), at(row + 1, k + 1), at(row, k + 1)]);
                }
            }
        }
    }
    for vertex in &mut mesh.vertices {
        *vertex = origin + radius * vertex.normalize();
    }
    mesh
}

fn vertex(
    mesh: &mut TriangleMesh,
    on_edge: &mut std::collections::BTreeMap<(u32, u32, u32), u32>,
    face: [u32; 3],
    weights: [u32; 3],
    corners: &[DVec3],
) -> u32 {
    let inside: Vec<usize> = (0..3).filter(|&k| weights[k] > 0).collect();
    let place = |mesh: &mut TriangleMesh| {
        let sum: DVec3 = (0..3)
            .map(|k| f64::from(weights[k]) * corners[face[k] as usize])
            .sum();
        mesh.vertices.push(sum);
        (mesh.vertices.len() - 1) as u32
    };
    match inside[..] {
        [k] => face[k],
        [i, j] => {
            let (low, high) = if face[i] < face[j] { (i, j) } else { (j, i) };
            let key = (face[low], face[high], weights[high]);
            *on_edge.entry(key).or_insert_with(|| place(mesh))
        }
        _ => place(mesh),
    }
}

fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for (one, other) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        corners.push(DVec3::new(0.0, one, other));
        corners.push(DVec3::new(one, other, 0.0));
        corners.push(DVec3::new(other, 0.0, one));
    }
    // Neighbours are 2 apart; each triple of neighbours is a face, turned outwards.
    let near = |i: usize, j: usize| (corners[i] - corners[j]).length_squared() < 4.5;
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let outwards = corners[i].dot(corners[j].cross(corners[k])) > 0.0;
                    let (i, j, k) = (i as u32, j as u32, k as u32);
                    faces.push(if outwards { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    (corners, faces)
}
