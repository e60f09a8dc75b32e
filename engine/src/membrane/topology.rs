//! Topology of a sheet: the triangles that meet at each edge, and its rims.

use glam::DVec3;
use thiserror::Error;

/// Stands for "no triangle" and "no vertex" at an edge of a rim.
pub const NONE: u32 = u32::MAX;

/// An edge of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Its vertices, in the direction in which the first triangle runs through them.
    pub ends: [u32; 2],
    /// Its triangles; the second is [`NONE`] on a rim.
    pub triangles: [u32; 2],
    /// The corner of each triangle that is not on the edge.
    pub opposite: [u32; 2],
}

/// Triangles, edges and rims of a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Topology {
    vertices: usize,
    triangles: Vec<[u32; 3]>,
    /// Edges with two triangles first.
    edges: Vec<Edge>,
    inner: usize,
    rims: Vec<Vec<u32>>,
}

/// Why triangles are no sheet. Triangles and vertices count from 0, as in files of a run.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TopologyError {
    /// Nothing there.
    #[error("there are no triangles")]
    Empty,
    /// A corner that is not there, or one that appears twice.
    #[error(
        "triangle {triangle} has the corners {corners:?}: three different vertices below {vertices} are needed"
    )]
    Corners {
        /// Its number.
        triangle: usize,
        /// Corners as given.
        corners: [u32; 3],
        /// Number of vertices.
        vertices: usize,
    },
    /// More than two triangles at an edge.
    #[error("triangle {triangle} is the third at the edge between the vertices {} and {}, after the triangles {} and {}: a sheet has two at most", .ends[0], .ends[1], .others[0], .others[1])]
    ThirdTriangle {
        /// Its number.
        triangle: usize,
        /// The edge.
        ends: [u32; 2],
        /// Triangles before it.
        others: [usize; 2],
    },
    /// Two neighbours with opposite normals.
    #[error("triangle {triangle} is turned the other way than its neighbour, triangle {neighbour}: both run through their common edge from vertex {} to vertex {}", .ends[0], .ends[1])]
    Turned {
        /// Its number.
        triangle: usize,
        /// The one that it touches.
        neighbour: usize,
        /// The edge.
        ends: [u32; 2],
    },
    /// A triangle whose corners lie on a line.
    #[error("triangle {triangle} has no area")]
    NoArea {
        /// Its number.
        triangle: usize,
    },
    /// A vertex without mass.
    #[error("vertex {vertex} belongs to no triangle: it would have no mass")]
    Lonely {
        /// Its number.
        vertex: usize,
    },
}

/// A triangle whose area is below this part of the square of its longest edge has none.
const LEAST_AREA: f64 = 1e-9;

impl Topology {
    /// Memory that it takes, bytes.
    pub(super) fn bytes(&self) -> usize {
        let rims = self.rims.iter().map(|rim| size_of_val(&rim[..]));
        size_of_val(&self.triangles[..]) + size_of_val(&self.edges[..]) + rims.sum::<usize>()
    }

    /// Edges and rims of these triangles.
    ///
    /// # Errors
    /// If an edge has more than two triangles, if neighbours have opposite normals, or if a triangle or a vertex is not what a sheet needs.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Result<Self, TopologyError> {
        if triangles.is_empty() {
            return Err(TopologyError::Empty);
        }
        let mut is_used = vec![false; vertices];
        let mut sides = Vec::with_capacity(3 * triangles.len());
        for (triangle, &corners) in triangles.iter().enumerate() {
            let [a, b, c] = corners;
            if a == b || b == c || c == a || corners.iter().any(|&k| k as usize >= vertices) {
                return Err(TopologyError::Corners {
                    triangle,
                    corners,
                    vertices,
                });
            }
            for k in 0..3 {
                let (from, to) = (corners[k], corners[(k + 1) % 3]);
                let opposite = corners[(k + 2) % 3];
                sides.push((from.min(to), from.max(to), triangle as u32, from, opposite));
                is_used[from as usize] = true;
            }
        }
        if let Some(vertex) = is_used.iter().position(|&used| !used) {
            return Err(TopologyError::Lonely { vertex });
        }
        sides.sort_unstable();
        let (mut inner, mut rim) = (Vec::new(), Vec::new());
        let same = |one: &(u32, u32, u32, u32, u32), other: &(u32, u32, u32, u32, u32)| {
            (one.0, one.1) == (other.0, other.1)
        };
        for group in sides.chunk_by(same) {
            let (low, high, first, from, opposite) = group[0];
            let ends = if from == low {
                [low, high]
            } else {
                [high, low]
            };
            match group {
                [_] => rim.push(Edge {
                    ends,
                    triangles: [first, NONE],
                    opposite: [opposite, NONE],
                }),
                [_, second] => {
                    if second.3 == from {
                        return Err(TopologyError::Turned {
                            triangle: second.2 as usize,
                            neighbour: first as usize,
                            ends,
                        });
                    }
                    inner.push(Edge {
                        ends,
                        triangles: [first, second.2],
                        opposite: [opposite, second.4],
                    });
                }
                more => {
                    return Err(TopologyError::ThirdTriangle {
                        triangle: more[2].2 as usize,
                        ends: [low, high],
                        others: [first as usize, more[1].2 as usize],
                    });
                }
            }
        }
        let mut new = Self {
            vertices,
            triangles: triangles.to_vec(),
            inner: inner.len(),
            edges: inner,
            rims: Vec::new(),
        };
        new.rims = new.find_rims(&rim);
        new.edges.append(&mut rim);
        new.edges.shrink_to_fit();
        Ok(new)
    }

    /// Checks that each triangle has an area.
    ///
    /// # Errors
    /// With the number of the first triangle that has none.
    pub fn check_areas(triangles: &[[DVec3; 3]]) -> Result<(), TopologyError> {
        for (triangle, &[a, b, c]) in triangles.iter().enumerate() {
            let longest = (b - a)
                .length_squared()
                .max((c - b).length_squared())
                .max((a - c).length_squared());
            let area = 0.5 * (b - a).cross(c - a).length();
            // Also where a coordinate is not a number.
            let has_area = area > LEAST_AREA * longest;
            if !has_area {
                return Err(TopologyError::NoArea { triangle });
            }
        }
        Ok(())
    }

    /// Closed walks along the rim. At a vertex where two rims meet, a walk goes on along the triangles that it came with.
    fn find_rims(&self, rim: &[Edge]) -> Vec<Vec<u32>> {
        let mut rims = Vec::new();
        if rim.is_empty() {
            return rims;
        }
        // The triangle and its corner number at each directed inner edge, to turn about a vertex.
        let mut directed: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * self.triangles.len());
        for (triangle, corners) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                directed.push(([corners[k], corners[(k + 1) % 3]], triangle as u32));
            }
        }
        directed.sort_unstable();
        let triangle_at = |ends: [u32; 2]| {
            let found = directed.binary_search_by_key(&ends, |entry| entry.0);
            found.ok().map(|place| directed[place].1)
        };
        let mut starts: Vec<[u32; 2]> = rim.iter().map(|edge| edge.ends).collect();
        starts.sort_unstable();
        let mut is_done = vec![false; starts.len()];
        for first in 0..starts.len() {
            if is_done[first] {
                continue;
            }
            let mut walk = Vec::new();
            let mut place = first;
            while !is_done[place] {
                is_done[place] = true;
                let [from, at] = starts[place];
                walk.push(from);
                // Turns about `at` from triangle to triangle until an edge that leaves it has no neighbour.
                let mut came_from = from;
                let next = loop {
                    let Some(triangle) = triangle_at([came_from, at]) else {
                        break None;
                    };
                    let corners = self.triangles[triangle as usize];
                    let k = corners.iter().position(|&corner| corner == at);
                    let to = corners[(k.unwrap_or(0) + 1) % 3];
                    if let Ok(next) = starts.binary_search(&[at, to]) {
                        break Some(next);
                    }
                    came_from = to;
                };
                let Some(next) = next else { break };
                place = next;
            }
            rims.push(walk);
        }
        rims
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Corners of each triangle, in the order of the file.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// All edges; those with two triangles first.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Edges with two triangles: the hinges.
    #[must_use]
    pub fn hinges(&self) -> &[Edge] {
        &self.edges[..self.inner]
    }

    /// Vertices of each rim, in the direction in which the triangles run along it.
    #[must_use]
    pub fn rims(&self) -> &[Vec<u32>] {
        &self.rims
    }

    /// Whether each vertex is on a rim.
    #[must_use]
    pub fn is_on_rim(&self) -> Vec<bool> {
        let mut is_on_rim = vec![false; self.vertices];
        for &vertex in self.rims.iter().flatten() {
            is_on_rim[vertex as usize] = true;
        }
        is_on_rim
    }
}
