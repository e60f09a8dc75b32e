//! The smallest box with a face on the convex hull.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Faces that are tried, the largest first. A constant: results do not depend on the machine.
const MOST_FACES: usize = 4_000;

/// Edges of the box of least volume among those with a face in the plane of one of the hull's (the 4000 largest) faces.
///
/// In that plane the other edges are those of the rectangle of least area around the projected corners, which has an edge on an
/// edge of their convex hull (Freeman and Shapira 1975, doi:10.1145/360881.360919). The box of least volume of all need not have
/// a face on the hull (O'Rourke 1985, doi:10.1007/BF00991005), but seldom is much smaller.
pub(super) fn smallest_box((corners, triangles): &(Vec<DVec3>, Vec<[u32; 3]>)) -> [f64; 3] {
    let mut normals: Vec<DVec3> = triangles
        .iter()
        .map(|t| t.map(|index| corners[index as usize]))
        .map(|[a, b, c]| (b - a).cross(c - a))
        .filter(|double| double.length_squared() > 0.0)
        .collect();
    normals.sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
    normals.truncate(MOST_FACES);
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
