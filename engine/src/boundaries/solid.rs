//! The body inside a closed mesh, as a region.
//!
//! The nearest point of the surface is found through a tree of boxes; the side of a position follows from the angle-weighted
//! pseudo-normal of the corner, edge or face that the point lies on (Baerentzen and Aanaes 2005, IEEE Trans. Vis. Comput. Graph.
//! 11, 243).

use std::collections::BTreeMap;

use glam::DVec3;

/// Triangles in a leaf of the tree.
const LEAF: usize = 4;

/// Why a mesh does not bound a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SolidError {
    /// Edges that are not used exactly once in either direction.
    #[error(
        "{open} of its {edges} edges do not have one triangle to either side, all turned alike: the mesh is not closed"
    )]
    Open {
        /// Such edges.
        open: usize,
        /// All edges.
        edges: usize,
    },
    /// The volume inside is not positive.
    #[error("there is no volume inside it")]
    Flat,
}

/// The body inside a closed mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    volume: f64,
}

/// Corners, and the pseudo-normals of face, edges (from corner k to the next) and corners, of any length.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Triangle {
    corners: [DVec3; 3],
    face: DVec3,
    edges: [DVec3; 3],
    vertices: [DVec3; 3],
}

/// A box around triangles: its own if it is a leaf, else those of the next node and of another.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// First triangle and how many; for inner nodes the index of the second child and 0.
    first: u32,
    count: u32,
}

impl Solid {
    /// Solid of corners (m) and triangles, three indices each.
    ///
    /// # Errors
    /// If the surface is not closed, or nothing is inside.
    pub fn new(corners: &[DVec3], indices: &[[u32; 3]]) -> Result<Self, SolidError> {
        let mut indices: Vec<[u32; 3]> = (indices.iter().copied())
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        check_closed(&indices)?;
        let place = |index: u32| corners[index as usize];
        let volume = |indices: &[[u32; 3]]| {
            let about = indices.first().map_or(DVec3::ZERO, |first| place(first[0]));
            let parts = indices.iter().map(|&[a, b, c]| {
                (place(a) - about).dot((place(b) - about).cross(place(c) - about)) / 6.0
            });
            parts.sum::<f64>()
        };
        let mut inside = volume(&indices);
        if inside < 0.0 {
            // The surface is turned inside out.
            indices.iter_mut().for_each(|triangle| triangle.swap(1, 2));
            inside = -inside;
        }
        let extent = indices.iter().flatten().map(|&index| place(index));
        let (low, high) = bounds_of(extent);
        let width = (high - low).max_element();
        // Round-off of a sheet that is folded onto itself.
        if indices.is_empty() || inside.is_nan() || inside <= 1e-12 * (width * width * width) {
            return Err(SolidError::Flat);
        }
        let mut triangles = with_normals(corners, &indices);
        let mut nodes = Vec::new();
        let count = triangles.len();
        grow(&mut triangles, 0, count, &mut nodes);
        Ok(Self {
            triangles,
            nodes,
            volume: inside,
        })
    }

    /// Distance to the surface, m; negative inside.
    pub(super) fn signed_distance(&self, point: DVec3) -> f64 {
        let (mut least, mut side) = (f64::INFINITY, 1.0);
        let mut waiting = vec![0_usize];
        while let Some(index) = waiting.pop() {
            let node = &self.nodes[index];
            if node.squared_distance(point) >= least {
                continue;
            }
            if node.count == 0 {
                let children = [index + 1, node.first as usize];
                let squares = children.map(|child| self.nodes[child].squared_distance(point));
                let nearer = usize::from(squares[1] < squares[0]);
                waiting.extend([children[1 - nearer], children[nearer]]);
                continue;
            }
            let first = node.first as usize;
            for triangle in &self.triangles[first..first + node.count as usize] {
                let (nearest, normal) = triangle.nearest(point);
                let away = point - nearest;
                if away.length_squared() < least {
                    least = away.length_squared();
                    side = away.dot(normal);
                }
            }
        }
        if side < 0.0 {
            -least.sqrt()
        } else {
            least.sqrt()
        }
    }

    /// m^3
    pub(super) fn volume(&self) -> f64 {
        self.volume
    }

    /// Lowest and highest corner of a box around it, m.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        (self.nodes[0].low, self.nodes[0].high)
    }
}

/// Whether every edge is passed once in one direction and once in the other.
fn check_closed(indices: &[[u32; 3]]) -> Result<(), SolidError> {
    // Times passed from the lower to the higher corner, and back.
    let mut passed: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
    for triangle in indices {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            passed.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
        }
    }
    let open = passed.values().filter(|times| **times != [1, 1]).count();
    if open > 0 {
        let edges = passed.len();
        return Err(SolidError::Open { open, edges });
    }
    Ok(())
}

fn with_normals(corners: &[DVec3], indices: &[[u32; 3]]) -> Vec<Triangle> {
    let mut of_edge: BTreeMap<[u32; 2], DVec3> = BTreeMap::new();
    let mut of_corner = vec![DVec3::ZERO; corners.len()];
    let places = |triangle: &[u32; 3]| triangle.map(|index| corners[index as usize]);
    let faces: Vec<DVec3> = (indices.iter().map(places))
        .map(|[a, b, c]| (b - a).cross(c - a).normalize_or_zero())
        .collect();
    for (triangle, &face) in indices.iter().zip(&faces) {
        let at = places(triangle);
        for k in 0..3 {
            let (next, last) = ((k + 1) % 3, (k + 2) % 3);
            let (a, b) = (triangle[k], triangle[next]);
            *of_edge.entry([a.min(b), a.max(b)]).or_default() += face;
            let (to_next, to_last) = (at[next] - at[k], at[last] - at[k]);
            let angle = libm::atan2(to_next.cross(to_last).length(), to_next.dot(to_last));
            of_corner[a as usize] += angle * face;
        }
    }
    let triangle = |(triangle, &face): (&[u32; 3], &DVec3)| Triangle {
        corners: places(triangle),
        face,
        edges: [0, 1, 2].map(|k| {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            of_edge[&[a.min(b), a.max(b)]]
        }),
        vertices: triangle.map(|index| of_corner[index as usize]),
    };
    indices.iter().zip(&faces).map(triangle).collect()
}

impl Triangle {
    /// Its nearest point (m), and the pseudo-normal there (Ericson 2005, Real-Time Collision Detection, 5.1.5).
    fn nearest(&self, point: DVec3) -> (DVec3, DVec3) {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let from_a = point - a;
        let (d1, d2) = (ab.dot(from_a), ac.dot(from_a));
        if d1 <= 0.0 && d2 <= 0.0 {
            return (a, self.vertices[0]);
        }
        let from_b = point - b;
        let (d3, d4) = (ab.dot(from_b), ac.dot(from_b));
        if d3 >= 0.0 && d4 <= d3 {
            return (b, self.vertices[1]);
        }
        let beside_c = d1 * d4 - d3 * d2;
        if beside_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return (a + ab * (d1 / (d1 - d3)), self.edges[0]);
        }
        let from_c = point - c;
        let (d5, d6) = (ab.dot(from_c), ac.dot(from_c));
        if d6 >= 0.0 && d5 <= d6 {
            return (c, self.vertices[2]);
        }
        let beside_b = d5 * d2 - d1 * d6;
        if beside_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return (a + ac * (d2 / (d2 - d6)), self.edges[2]);
        }
        let beside_a = d3 * d6 - d5 * d4;
        if beside_a <= 0.0 && d4 >= d3 && d5 >= d6 {
            let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return (b + (c - b) * share, self.edges[1]);
        }
        let all = beside_a + beside_b + beside_c;
        (a + ab * (beside_b / all) + ac * (beside_c / all), self.face)
    }
}

impl Node {
    fn squared_distance(&self, point: DVec3) -> f64 {
        let beyond = (self.low - point).max(point - self.high);
        beyond.max(DVec3::ZERO).length_squared()
    }
}

fn bounds_of(places: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    places.fold(nothing, |(low, high), place| {
        (low.min(place), high.max(place))
    })
}

/// Appends the nodes for a range of triangles, which are halved along their longest extent.
fn grow(triangles: &mut [Triangle], first: usize, count: usize, nodes: &mut Vec<Node>) {
    let own = &mut triangles[first..first + count];
    let (low, high) = bounds_of(own.iter().flat_map(|triangle| triangle.corners));
    let index = nodes.len();
    nodes.push(Node {
        low,
        high,
        first: first as u32,
        count: count as u32,
    });
    if count <= LEAF {
        return;
    }
    let extent = high - low;
    let axis = (0..3).fold(0, |most, axis| {
        if extent[axis] > extent[most] {
            axis
        } else {
            most
        }
    });
    let middle = |triangle: &Triangle| triangle.corners.iter().map(|c| c[axis]).sum::<f64>();
    own.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    let half = count / 2;
    grow(triangles, first, half, nodes);
    let second = nodes.len() as u32;
    grow(triangles, first + half, count - half, nodes);
    (nodes[index].first, nodes[index].count) = (second, 0);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::boundaries::Region;

    /// A cuboid from two corners, its faces turned outwards.
    fn cuboid(low: DVec3, high: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corners = (0..8).map(|k| {
            let pick = |axis: usize| {
                if k >> axis & 1 == 1 {
                    high[axis]
                } else {
                    low[axis]
                }
            };
            DVec3::new(pick(0), pick(1), pick(2))
        });
        let triangles = vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        (corners.collect(), triangles)
    }

    proptest! {
        #[test]
        fn a_cuboid_is_the_box(x in -1.0..2.0f64, y in -1.0..2.0f64, z in -1.0..3.0f64, turned in any::<bool>()) {
            let (low, high) = (DVec3::ZERO, DVec3::new(1.0, 1.0, 2.0));
            let (corners, mut triangles) = cuboid(low, high);
            if turned {
                triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
            }
            let solid = Solid::new(&corners, &triangles).unwrap();
            let point = DVec3::new(x, y, z);
            let exact = Region::Box { min: low, max: high }.signed_distance(point);
            // Products of coordinates of order 1.
            prop_assert!((solid.signed_distance(point) - exact).abs() < 1e-13);
            prop_assert!((solid.volume() - 2.0).abs() < 1e-14);
            prop_assert_eq!(solid.bounds(), (low, high));
        }
    }

    #[test]
    fn what_is_not_closed_bounds_nothing() {
        let (corners, triangles) = cuboid(DVec3::ZERO, DVec3::ONE);
        let open = Solid::new(&corners, &triangles[1..]);
        assert_eq!(open, Err(SolidError::Open { open: 3, edges: 18 }));
        let mut turned = triangles.clone();
        turned[3].swap(0, 1);
        assert_eq!(
            Solid::new(&corners, &turned),
            Err(SolidError::Open { open: 3, edges: 18 })
        );
        let flat = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
        let folded = [[0, 1, 2], [1, 3, 2], [1, 0, 2], [3, 1, 2]];
        assert!(Solid::new(&flat, &folded).is_err());
        assert_eq!(Solid::new(&flat, &[]), Err(SolidError::Flat));
    }
}
