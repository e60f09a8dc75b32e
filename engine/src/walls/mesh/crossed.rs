//! Whether a way leads through a mesh.

use glam::DVec3;

use super::leaf::LANES;
use super::{Mesh, Scratch};

impl Mesh {
    /// Whether the straight way between two places (m, in the wall's frame) leads through a triangle. A way through an edge or corner does.
    #[must_use]
    pub fn is_crossed(&self, from: DVec3, to: DVec3, scratch: &mut Scratch) -> bool {
        let search = &mut scratch.search;
        let (middle, reach) = (0.5 * (from + to), 0.5 * from.distance(to));
        let (layers, leaves) = (&mut search.layers, &mut search.leaves);
        self.tree
            .leaves(middle, reach + self.late(), layers, leaves);
        leaves.iter().any(|&leaf| {
            let first = leaf as usize * LANES;
            let end = self.facets.len().min(first + LANES);
            self.facets[first..end].iter().any(|facet| {
                let corners = facet.vertices.map(|k| self.vertices[k as usize]);
                leads_through(corners, from, to)
            })
        })
    }
}

/// Whether the way leads through the triangle: its ends are on either side, and its line passes the three edges in one sense. Seen from the two triangles of
/// an edge the sense differs in its sign alone, so that nothing slips through between them.
fn leads_through(corners: [DVec3; 3], from: DVec3, to: DVec3) -> bool {
    let [a, b, c] = corners.map(|corner| corner - from);
    let way = to - from;
    // Of most triangles nearby both ends are on one side.
    let normal = (b - a).cross(c - a);
    if a.dot(normal) * (a - way).dot(normal) > 0.0 {
        return false;
    }
    let sense = |one: DVec3, other: DVec3| way.dot(one.cross(other));
    let senses = [sense(a, b), sense(b, c), sense(c, a)];
    let is_inside =
        senses.iter().all(|&sense| sense >= 0.0) || senses.iter().all(|&sense| sense <= 0.0);
    // All are zero where the line lies in the plane of the triangle.
    is_inside && senses != [0.0; 3]
}

#[cfg(test)]
mod tests {
    use glam::dvec3;
    use mercury_common::formats::mesh::TriangleMesh;
    use mercury_common::random::Stream;

    use super::*;

    /// A square of 8 by 8 cells, each of two triangles, whose corners are anywhere near z = 0.
    fn sheet(stream: &mut Stream) -> Mesh {
        let place = |i: u32, j: u32, z: f64| dvec3(f64::from(i), f64::from(j), z) / 8.0;
        let heights: Vec<f64> = (0..81).map(|_| 0.2 * stream.uniform()).collect();
        let at = |i: u32, j: u32| place(i, j, heights[(9 * j + i) as usize]);
        let cells = (0..8).flat_map(|j| (0..8).map(move |i| (i, j)));
        let triangles: Vec<[DVec3; 3]> = cells
            .flat_map(|(i, j)| {
                let [a, b] = [at(i, j), at(i + 1, j)];
                let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let mesh = TriangleMesh::from_corners(&triangles);
        Mesh::new(&mesh, |x| x, false).unwrap().keeping_all()
    }

    /// Each way from below to above leads through the sheet, also where it passes an edge or a corner, unless it is beside it; a way on one side does not.
    #[test]
    fn what_comes_from_one_side_to_the_other_crosses() {
        let mut stream = Stream::new(4, "ways", 0);
        let mesh = sheet(&mut stream);
        let mut scratch = Scratch::default();
        let corners = mesh.corners().to_vec();
        for k in 0..2000 {
            let mut any = |low: f64, high: f64| stream.uniform_in(low, high);
            let foot = match k % 3 {
                // Through a corner, through a side of a cell, anywhere.
                0 => corners[any(0.0, corners.len() as f64) as usize],
                1 => dvec3((8.0 * any(0.0, 1.0)).round() / 8.0, any(0.0, 1.0), 0.0),
                _ => dvec3(any(0.0, 1.0), any(0.0, 1.0), 0.0),
            };
            let (low, high) = (any(-0.3, -0.01), any(0.03, 0.3));
            let [from, to] = [low, high].map(|z| dvec3(foot.x, foot.y, z));
            // On a rim round-off decides.
            let is_within =
                (1e-9..1.0 - 1e-9).contains(&foot.x) && (1e-9..1.0 - 1e-9).contains(&foot.y);
            if is_within {
                assert!(mesh.is_crossed(from, to, &mut scratch), "{from} to {to}");
                assert!(mesh.is_crossed(to, from, &mut scratch), "{to} to {from}");
            }
            let aside = dvec3(any(1.01, 1.5), 0.0, 0.0);
            assert!(!mesh.is_crossed(from + aside, to + aside, &mut scratch));
            let up = DVec3::Z * (0.03 - low);
            assert!(!mesh.is_crossed(from + up, to + up, &mut scratch), "above");
        }
        // In its plane.
        let corners = [
            dvec3(0.0, 0.0, 0.0),
            dvec3(1.0, 0.0, 0.0),
            dvec3(0.0, 1.0, 0.0),
        ];
        assert!(!leads_through(
            corners,
            dvec3(2.0, 2.0, 0.0),
            dvec3(3.0, 2.0, 0.0)
        ));
    }
}
