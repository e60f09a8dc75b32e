//! The smallest box with a face on the convex hull.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Work that is spent on trying every face, as faces times corners. Constants: results do not depend on the machine.
const MOST_WORK: usize = 2_000_000;
/// Directions per edge of a cube map, of which one face each is tried on larger hulls (about 10 degrees).
const DIRECTIONS: f64 = 8.0;

/// Edges of the box of least volume among those with a face across a normal of the convex hull or across a coordinate axis.
///
/// In the plane across a normal the other edges are those of the rectangle of least area around the projected corners, which has an
/// edge on an edge of their convex hull (Freeman and Shapira 1975, doi:10.1145/360881.360919). The box of least volume of all
/// need not have a face on the hull (O'Rourke 1985, doi:10.1007/BF00991005), but seldom is much smaller. Of hulls with many faces
/// only the largest face of each of some 200 directions is tried.
pub(super) fn smallest_box((corners, triangles): &(Vec<DVec3>, Vec<[u32; 3]>)) -> [f64; 3] {
    let mut normals: Vec<DVec3> = triangles
        .iter()
        .map(|t| t.map(|index| corners[index as usize]))
        .map(|[a, b, c]| (b - a).cross(c - a))
        .filter(|double| double.length_squared() > 0.0)
        .collect();
    if normals.len() * corners.len() > MOST_WORK {
        let mut largest: BTreeMap<[i64; 3], DVec3> = BTreeMap::new();
        for normal in normals {
            let known = largest.entry(direction(normal)).or_insert(normal);
            if normal.length_squared() > known.length_squared() {
                *known = normal;
            }
        }
        normals = largest.into_values().collect();
    }
    normals.extend([DVec3::X, DVec3::Y, DVec3::Z]);
    let boxes: Vec<[f64; 3]> = normals
        .into_par_iter()
        .map(|normal| flush_box(corners, normal.normalize()))
        .collect();
    let smaller = |best: [f64; 3], other: [f64; 3]| {
        let volume = |edges: [f64; 3]| edges.iter().product::<f64>();
        if volume(other) < volume(best) {
            other
        } else {
            best
        }
    };
    boxes.into_iter().fold([f64::INFINITY; 3], smaller)
}

/// The cell of a cube map around a direction or its opposite.
fn direction(normal: DVec3) -> [i64; 3] {
    let axis = normal.abs().max_position();
    let on_cube = normal / normal[axis];
    let mut cell = (on_cube * (0.5 * DIRECTIONS)).floor().to_array();
    cell[axis] = DIRECTIONS + axis as f64;
    cell.map(|index| index as i64)
}

/// The smallest box with two faces across a unit normal.
fn flush_box(corners: &[DVec3], normal: DVec3) -> [f64; 3] {
    let (u, v) = normal.any_orthonormal_pair();
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let flat: Vec<DVec2> = corners
        .iter()
        .map(|corner| {
            let height = corner.dot(normal);
            low = low.min(height);
            high = high.max(height);
            DVec2::new(corner.dot(u), corner.dot(v))
        })
        .collect();
    let outline = outline(flat);
    let n = outline.len();
    let mut best = [f64::INFINITY; 2];
    // The three corners farthest along, against and across the edge, found by walking round with the edge.
    let (mut far, mut ahead, mut behind) = (1, 1, 1);
    for k in 0..n {
        let from = outline[k];
        let along = (outline[(k + 1) % n] - from).normalize_or_zero();
        let across = along.perp();
        let at = |index: usize| outline[index % n];
        let step = |index: &mut usize, direction: DVec2| {
            for _ in 0..n {
                if at(*index + 1).dot(direction) <= at(*index).dot(direction) {
                    break;
                }
                *index += 1;
            }
        };
        ahead = ahead.max(k + 1);
        step(&mut ahead, along);
        far = far.max(ahead);
        step(&mut far, across);
        behind = behind.max(far);
        step(&mut behind, -along);
        let edges = [
            (at(ahead) - at(behind)).dot(along),
            (at(far) - from).dot(across),
        ];
        if edges[0] * edges[1] < best[0] * best[1] {
            best = edges;
        }
    }
    [high - low, best[0], best[1]]
}

/// Convex hull in the plane, counter-clockwise (Andrew 1979, doi:10.1016/0020-0190(79)90072-3).
fn outline(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(point - b) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}
