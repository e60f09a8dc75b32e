//! Topology of a mesh: the triangles that meet at each edge and corner.

use glam::DVec3;
use mercury_common::turns::angle_between;

/// Edges and corners with what surrounds them.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Topology {
    /// Ends of each edge, the lower index first.
    edges: Vec<[u32; 2]>,
    /// Where the triangles of each edge begin in `around_edge`, and the end.
    edge_start: Vec<u32>,
    /// Triangles, each with its corner that is not on the edge.
    around_edge: Vec<(u32, u32)>,
    /// Where the neighbours of each corner begin in `around_corner`, and the end.
    corner_start: Vec<u32>,
    /// Corners to which an edge leads.
    around_corner: Vec<u32>,
    /// Whether a corner lies on the rim or on a seam.
    on_rim: Vec<bool>,
    /// Sums of the normals around edges and corners (there weighted by angle), for meshes that act on one side: the centre is
    /// in front of an edge or corner if it is on that side of this plane (Baerentzen and Aanaes 2005). Empty otherwise.
    edge_normals: Vec<DVec3>,
    corner_normals: Vec<DVec3>,
}

impl Topology {
    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.edges[..])
            + size_of_val(&self.edge_start[..])
            + size_of_val(&self.around_edge[..])
            + size_of_val(&self.corner_start[..])
            + size_of_val(&self.around_corner[..])
            + size_of_val(&self.on_rim[..])
            + size_of_val(&self.edge_normals[..])
            + size_of_val(&self.corner_normals[..])
    }

    /// For each triangle, where two meet at each edge and six at each corner, and both sides act.
    pub(super) const BYTES_OF_TRIANGLE: usize = {
        let of_edge = size_of::<[u32; 2]>() + 5 * size_of::<u32>();
        let of_corner = 7 * size_of::<u32>() + size_of::<bool>();
        (3 * of_edge + of_corner) / 2
    };

    /// Topology of these triangles, and the edges of each.
    pub(super) fn new(
        vertices: &[DVec3],
        triangles: &[[u32; 3]],
        normals: bool,
    ) -> (Self, Vec<[u32; 3]>) {
        let mut sides = Vec::with_capacity(3 * triangles.len());
        for (index, corners) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                sides.push((a.min(b), a.max(b), index as u32, k as u32));
            }
        }
        sides.sort_unstable();
        let mut own = vec![[0; 3]; triangles.len()];
        let mut new = Self::default();
        for &(a, b, triangle, k) in &sides {
            if new.edges.last() != Some(&[a, b]) {
                new.edges.push([a, b]);
                new.edge_start.push(new.around_edge.len() as u32);
            }
            own[triangle as usize][k as usize] = (new.edges.len() - 1) as u32;
            let opposite = triangles[triangle as usize][(k as usize + 2) % 3];
            new.around_edge.push((triangle, opposite));
        }
        new.edge_start.push(new.around_edge.len() as u32);
        new.find_corners(vertices.len());
        if normals {
            new.find_normals(vertices, triangles);
        }
        (new, own)
    }

    fn find_corners(&mut self, count: usize) {
        let mut start = vec![0u32; count + 1];
        for ends in &self.edges {
            for &end in ends {
                start[end as usize + 1] += 1;
            }
        }
        for k in 0..count {
            start[k + 1] += start[k];
        }
        let mut next = start.clone();
        self.around_corner = vec![0; 2 * self.edges.len()];
        self.on_rim = vec![false; count];
        for (edge, &[a, b]) in self.edges.iter().enumerate() {
            let rim = self.edge_start[edge + 1] - self.edge_start[edge] != 2;
            for (from, to) in [(a, b), (b, a)] {
                self.around_corner[next[from as usize] as usize] = to;
                next[from as usize] += 1;
                self.on_rim[from as usize] |= rim;
            }
        }
        self.corner_start = start;
    }

    /// Sums of normals around edges and corners.
    pub(super) fn find_normals(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]]) {
        let mut corners = vec![DVec3::ZERO; vertices.len()];
        let unit_normal = |triangle: u32| {
            let [a, b, c] = triangles[triangle as usize].map(|k| vertices[k as usize]);
            (b - a).cross(c - a).normalize()
        };
        for (index, triangle) in triangles.iter().enumerate() {
            let normal = unit_normal(index as u32);
            for k in 0..3 {
                let [at, next, last] =
                    [k, (k + 1) % 3, (k + 2) % 3].map(|k| vertices[triangle[k] as usize]);
                corners[triangle[k] as usize] += normal * angle_between(next - at, last - at);
            }
        }
        self.edge_normals = (0..self.edges.len())
            .map(|edge| {
                let around = self.triangles_at(edge as u32).iter();
                around.map(|&(triangle, _)| unit_normal(triangle)).sum()
            })
            .collect();
        self.corner_normals = corners;
    }

    /// Triangles at an edge, each with its corner that is not on the edge.
    #[inline]
    pub(super) fn triangles_at(&self, edge: u32) -> &[(u32, u32)] {
        let edge = edge as usize;
        &self.around_edge[self.edge_start[edge] as usize..self.edge_start[edge + 1] as usize]
    }

    /// The triangle on the other side of an edge; None at rims and seams.
    #[inline]
    pub(super) fn across(&self, edge: u32, from: u32) -> Option<u32> {
        match *self.triangles_at(edge) {
            [(one, _), (other, _)] => Some(if one == from { other } else { one }),
            _ => None,
        }
    }

    /// Corners to which edges lead from this one.
    #[inline]
    pub(super) fn neighbours(&self, corner: u32) -> &[u32] {
        let corner = corner as usize;
        &self.around_corner
            [self.corner_start[corner] as usize..self.corner_start[corner + 1] as usize]
    }

    /// Edges at a corner.
    pub(super) fn edges_at(&self, corner: u32) -> impl Iterator<Item = u32> + '_ {
        self.neighbours(corner).iter().filter_map(move |&other| {
            let ends = [corner.min(other), corner.max(other)];
            let found = self.edges.binary_search(&ends);
            found.ok().map(|edge| edge as u32)
        })
    }

    /// The two corners of an edge.
    #[inline]
    pub(super) fn ends(&self, edge: u32) -> [u32; 2] {
        self.edges[edge as usize]
    }

    /// Number of edges.
    #[inline]
    pub(super) fn edge_count(&self) -> usize {
        self.edges.len()
    }

    /// Whether the edge has not exactly two triangles.
    #[inline]
    pub(super) fn is_rim(&self, edge: u32) -> bool {
        self.triangles_at(edge).len() != 2
    }

    /// Whether the corner is at such an edge.
    #[inline]
    pub(super) fn is_on_rim(&self, corner: u32) -> bool {
        self.on_rim[corner as usize]
    }

    /// Mean outward direction at an edge, of any length.
    pub(super) fn edge_normal(&self, edge: u32) -> DVec3 {
        self.edge_normals[edge as usize]
    }

    /// Mean outward direction at a corner, of any length.
    pub(super) fn corner_normal(&self, corner: u32) -> DVec3 {
        self.corner_normals[corner as usize]
    }

    /// Edges with one, two and more triangles, of those that are counted.
    pub(super) fn edge_counts(&self, counted: impl Fn(u32) -> bool) -> [usize; 3] {
        let mut counts = [0; 3];
        for edge in (0..self.edges.len() as u32).filter(|&edge| counted(edge)) {
            counts[self.triangles_at(edge).len().min(3) - 1] += 1;
        }
        counts
    }
}
