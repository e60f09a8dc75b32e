//! Repairs that need little guessing: equal vertices, doubled triangles, triangles turned the wrong way, small holes.

use mercury_common::formats::mesh::TriangleMesh;

use super::edges::{Edges, is_collapsed};
use super::holes::close_holes;
use super::report::{inspect, plural};
use super::shells::Sets;
use super::{WELD_FRACTION, diagonal};

/// Mends the mesh and reports what was done.
pub(super) fn repair(mesh: &mut TriangleMesh) -> Vec<String> {
    let mut done = Vec::new();
    if !inspect(mesh).open_edges.is_empty() {
        let tolerance = WELD_FRACTION * diagonal(mesh);
        let welded = mesh.welded_within(tolerance);
        let merged = mesh.vertices.len() - welded.vertices.len();
        if merged > 0 {
            done.push(format!(
                "{} nearer than {tolerance:.1e} m to another one merged",
                plural(merged, "vertex")
            ));
            *mesh = welded;
        }
    }
    let collapsed = drop_triangles(mesh, |mesh, index| is_collapsed(mesh.triangles[index]));
    if collapsed > 0 {
        done.push(format!(
            "{} with equal corners dropped",
            plural(collapsed, "triangle")
        ));
    }
    let duplicates = inspect(mesh).duplicates;
    if !duplicates.is_empty() {
        drop_triangles(mesh, |_, index| {
            u32::try_from(index).is_ok_and(|index| duplicates.binary_search(&index).is_ok())
        });
        done.push(format!(
            "{} standing twice dropped",
            plural(duplicates.len(), "triangle")
        ));
    }
    let turned = orient(mesh);
    if turned > 0 {
        done.push(format!(
            "{} turned to agree with the neighbours",
            plural(turned, "triangle")
        ));
    }
    done.extend(close_holes(mesh));
    done
}

/// Drops the triangles for which `is_bad`; returns how many.
fn drop_triangles(mesh: &mut TriangleMesh, is_bad: impl Fn(&TriangleMesh, usize) -> bool) -> usize {
    let keep: Vec<[u32; 3]> = (0..mesh.triangles.len())
        .filter(|&index| !is_bad(mesh, index))
        .map(|index| mesh.triangles[index])
        .collect();
    let dropped = mesh.triangles.len() - keep.len();
    mesh.triangles = keep;
    dropped
}

/// Turns triangles so that neighbours agree; in each part the fewer ones are turned. Returns how many.
fn orient(mesh: &mut TriangleMesh) -> usize {
    let mut sets = Sets::new(mesh.triangles.len());
    Edges::new(mesh).for_each(|_, uses| {
        if let [a, b] = uses {
            // A one-sided surface cannot be oriented; it stays inconsistent and is refused.
            let _ = sets.join(a.triangle, b.triangle, a.forward == b.forward);
        }
    });
    let count = mesh.triangles.len();
    let (mut size, mut against) = (vec![0u32; count], vec![0u32; count]);
    let mut place = Vec::with_capacity(count);
    for index in (0..).take(count) {
        let (root, turned) = sets.root(index);
        size[root as usize] += 1;
        against[root as usize] += u32::from(turned);
        place.push((root as usize, turned));
    }
    let mut number = 0;
    for (triangle, (root, turned)) in mesh.triangles.iter_mut().zip(place) {
        let turned_are_fewer = 2 * against[root] <= size[root];
        if turned == turned_are_fewer {
            triangle.swap(1, 2);
            number += 1;
        }
    }
    number
}
