//! Merging vertices that lie at the same place.

use std::collections::HashMap;

use glam::DVec3;

use super::{Surface, TriangleMesh};

/// Merges each vertex with the first earlier one that is at most `tolerance` away (0: equal
/// coordinates, where -0 equals 0), and drops vertices that no triangle uses.
///
/// Vertices are taken in the order of their first use, so the result depends on the file only.
pub(super) fn weld(surface: &Surface, tolerance: f64) -> TriangleMesh {
    weld_and_count(surface, tolerance).0
}

/// Merges vertices and keeps the order of the file: each stands where the first of those merged into it does.
pub(super) fn weld_in_order(surface: &Surface, tolerance: f64) -> TriangleMesh {
    let (mut mesh, merged) = weld_and_count(surface, tolerance);
    let mut number = vec![u32::MAX; mesh.vertices.len()];
    let mut vertices = Vec::with_capacity(mesh.vertices.len());
    for &index in merged.iter().flatten() {
        let own = &mut number[index as usize];
        if *own == u32::MAX {
            // The readers allow no more vertices than 32-bit indices.
            *own = vertices.len() as u32;
            vertices.push(mesh.vertices[index as usize]);
        }
    }
    mesh.vertices = vertices;
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = number[*corner as usize];
    }
    mesh
}

/// The mesh, and the index in it of each vertex of the file that is used.
fn weld_and_count(surface: &Surface, tolerance: f64) -> (TriangleMesh, Vec<Option<u32>>) {
    let mut mesh = TriangleMesh {
        triangles: Vec::with_capacity(surface.triangles.len()),
        is_single_precision: surface.is_single_precision,
        warnings: surface.warnings.clone(),
        ..TriangleMesh::default()
    };
    let mut welder = Welder {
        tolerance,
        cells: HashMap::new(),
    };
    let mut merged: Vec<Option<u32>> = vec![None; surface.vertices.len()];
    for triangle in &surface.triangles {
        mesh.triangles.push(triangle.map(|index| {
            let index = index as usize;
            *merged[index].get_or_insert_with(|| {
                let before = mesh.vertices.len();
                let found = welder.find_or_add(surface.vertices[index], &mut mesh.vertices);
                mesh.welded += usize::from(mesh.vertices.len() == before);
                found
            })
        }));
    }
    (mesh, merged)
}

/// A grid of cells with edge `tolerance`: what is near lies in the same or a neighbouring cell.
struct Welder {
    tolerance: f64,
    cells: HashMap<[u64; 3], Vec<u32>>,
}

impl Welder {
    fn find_or_add(&mut self, vertex: DVec3, vertices: &mut Vec<DVec3>) -> u32 {
        let home = if self.tolerance > 0.0 {
            (vertex / self.tolerance).floor()
        } else {
            vertex
        };
        let nearest = if self.tolerance > 0.0 {
            let mut candidates: Vec<u32> = Vec::new();
            for offset in 0..27u8 {
                let offset = DVec3::new(
                    f64::from(offset % 3) - 1.0,
                    f64::from(offset / 3 % 3) - 1.0,
                    f64::from(offset / 9) - 1.0,
                );
                candidates.extend(self.cells.get(&key(home + offset)).into_iter().flatten());
            }
            candidates
                .into_iter()
                .filter(|&index| vertices[index as usize].distance(vertex) <= self.tolerance)
                .min()
        } else {
            self.cells
                .get(&key(home))
                .and_then(|indices| indices.first().copied())
        };
        nearest.unwrap_or_else(|| {
            // The readers allow no more vertices than 32-bit indices.
            let index = vertices.len() as u32;
            vertices.push(vertex);
            self.cells.entry(key(home)).or_default().push(index);
            index
        })
    }
}

/// Bits of the coordinates, with one zero only.
fn key(cell: DVec3) -> [u64; 3] {
    cell.to_array()
        .map(|coordinate| (coordinate + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(corners: &[[f64; 3]]) -> Surface {
        let mut surface = Surface::default();
        for three in corners.chunks_exact(3) {
            assert!(surface.push([three[0].into(), three[1].into(), three[2].into()]));
        }
        surface
    }

    #[test]
    fn equal_vertices_are_merged_and_the_two_zeros_are_equal() {
        let mesh = weld(
            &surface(&[
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [1.0, -0.0, 0.0],
                [1.0, 1.0, 0.0],
                [-0.0, 1.0, -0.0],
            ]),
            0.0,
        );
        assert_eq!(mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!((mesh.vertices.len(), mesh.welded), (4, 2));
    }

    #[test]
    fn nearby_vertices_need_a_tolerance_even_across_cells() {
        let gap = 1e-7;
        let corners = surface(&[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0 - gap, gap, -gap],
            [1.0, 1.0, 0.0],
            [-gap, 1.0 + gap, gap],
        ]);
        assert_eq!(weld(&corners, 0.0).welded, 0);
        // The distance is gap * sqrt(3).
        assert_eq!(weld(&corners, 1.7 * gap).welded, 0);
        let mesh = weld(&corners, 1.8 * gap);
        assert_eq!(mesh.welded, 2);
        assert_eq!(mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
    }

    #[test]
    fn unused_vertices_are_dropped() {
        let surface = Surface {
            vertices: vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::ZERO],
            triangles: vec![[3, 2, 0]],
            ..Surface::default()
        };
        let mesh = weld(&surface, 0.0);
        assert_eq!(mesh.vertices, [DVec3::ZERO, DVec3::Z, DVec3::X]);
        assert_eq!((mesh.triangles, mesh.welded), (vec![[0, 1, 2]], 0));
    }
}
