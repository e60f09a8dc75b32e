//! Closing small holes.

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;

use super::LARGEST_HOLE;
use super::edges::Edges;
use super::report::plural;
use crate::inertia::surface::area;

/// Closes every hole whose patch is small, by one triangle or by a fan around the middle of its border, and reports what was
/// done.
///
/// For a flat hole any patch encloses the same volume; for others the fan is one guess among many, which is why it must be small.
pub(super) fn close_holes(mesh: &mut TriangleMesh) -> Option<String> {
    let total = area(mesh);
    let mut closed = 0;
    let mut patched = 0.0;
    for border in borders(mesh) {
        let patch = patch(mesh, &border);
        if patch.area > LARGEST_HOLE * total {
            continue;
        }
        if let Some(middle) = patch.middle {
            mesh.vertices.push(middle);
        }
        mesh.triangles.extend(patch.triangles);
        closed += 1;
        patched += patch.area;
    }
    (closed > 0).then(|| {
        format!(
            "{} closed, {:.2e} m2 of {total:.2e} m2",
            plural(closed, "hole"),
            patched
        )
    })
}

/// Loops of vertices around holes, in the direction that a patch passes them.
fn borders(mesh: &TriangleMesh) -> Vec<Vec<u32>> {
    // Against the direction of the only triangle at the edge.
    let mut steps: Vec<(u32, u32)> = Vec::new();
    Edges::new(mesh).for_each(|[low, high], uses| {
        if let [only] = uses {
            steps.push(if only.forward {
                (high, low)
            } else {
                (low, high)
            });
        }
    });
    steps.sort_unstable();
    let mut used = vec![false; steps.len()];
    let mut loops = Vec::new();
    for start in 0..steps.len() {
        if used[start] {
            continue;
        }
        let mut border = Vec::new();
        let mut at = start;
        let closed = loop {
            used[at] = true;
            let (from, to) = steps[at];
            border.push(from);
            if to == border[0] {
                break true;
            }
            let first = steps.partition_point(|step| step.0 < to);
            let next = (first..steps.len())
                .take_while(|&index| steps[index].0 == to)
                .find(|&index| !used[index]);
            match next {
                Some(next) => at = next,
                None => break false,
            }
        };
        if closed && border.len() >= 3 {
            loops.push(border);
        }
    }
    loops
}

struct Patch {
    triangles: Vec<[u32; 3]>,
    /// A vertex to add, with the next index.
    middle: Option<DVec3>,
    area: f64,
}

fn patch(mesh: &TriangleMesh, border: &[u32]) -> Patch {
    let position = |index: u32| mesh.vertices[index as usize];
    let size = |a: DVec3, b: DVec3, c: DVec3| 0.5 * (b - a).cross(c - a).length();
    if let [a, b, c] = *border {
        return Patch {
            triangles: vec![[a, b, c]],
            middle: None,
            area: size(position(a), position(b), position(c)),
        };
    }
    // The readers allow no more vertices than indices.
    let new = u32::try_from(mesh.vertices.len()).unwrap_or(u32::MAX);
    let middle = border.iter().map(|&v| position(v)).sum::<DVec3>() / border.len() as f64;
    let next = border.iter().cycle().skip(1);
    let sides: Vec<(u32, u32)> = border.iter().copied().zip(next.copied()).collect();
    Patch {
        triangles: sides.iter().map(|&(a, b)| [a, b, new]).collect(),
        middle: Some(middle),
        area: sides
            .iter()
            .map(|&(a, b)| size(position(a), position(b), middle))
            .sum(),
    }
}
