//! The edges of a mesh and the triangles that use them.

use mercury_common::formats::mesh::TriangleMesh;

/// One triangle at an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    /// The larger of the edge's two vertices.
    high: u32,
    /// The triangle.
    pub(super) triangle: u32,
    /// Whether the triangle passes the edge from its smaller to its larger vertex.
    pub(super) forward: bool,
}

/// All edges, sorted by their smaller vertex.
pub(super) struct Edges {
    /// Start of the uses of each smaller vertex, and the end of the last.
    starts: Vec<u32>,
    uses: Vec<Use>,
}

impl Edges {
    /// Edges of all triangles with three different corners.
    pub(super) fn new(mesh: &TriangleMesh) -> Self {
        let sides = |triangle: [u32; 3]| {
            let [a, b, c] = triangle;
            let sides = if is_collapsed(triangle) {
                [None; 3]
            } else {
                [Some((a, b)), Some((b, c)), Some((c, a))]
            };
            sides.into_iter().flatten()
        };
        // A counting sort by the smaller vertex: much faster than a map or a full sort.
        let mut starts = vec![0u32; mesh.vertices.len() + 1];
        for triangle in &mesh.triangles {
            for (from, to) in sides(*triangle) {
                starts[from.min(to) as usize + 1] += 1;
            }
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let mut next = starts.clone();
        let empty = Use {
            high: 0,
            triangle: 0,
            forward: false,
        };
        let mut uses = vec![empty; starts.last().copied().unwrap_or(0) as usize];
        for (triangle, index) in mesh.triangles.iter().zip(0u32..) {
            for (from, to) in sides(*triangle) {
                let slot = &mut next[from.min(to) as usize];
                uses[*slot as usize] = Use {
                    high: from.max(to),
                    triangle: index,
                    forward: from < to,
                };
                *slot += 1;
            }
        }
        for pair in starts.windows(2) {
            uses[pair[0] as usize..pair[1] as usize].sort_unstable();
        }
        Self { starts, uses }
    }

    /// Calls `visit` for each edge with its two vertices, the smaller first, and its uses in the order of triangles.
    pub(super) fn for_each(&self, mut visit: impl FnMut([u32; 2], &[Use])) {
        for (pair, low) in self.starts.windows(2).zip(0u32..) {
            let uses = &self.uses[pair[0] as usize..pair[1] as usize];
            for edge in uses.chunk_by(|a, b| a.high == b.high) {
                visit([low, edge[0].high], edge);
            }
        }
    }
}

/// Whether two corners of a triangle are the same vertex.
pub(super) fn is_collapsed([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}
