//! The first surface of a wall that wears: its vertices, and what surrounds them.

use std::collections::HashMap;

use glam::DVec3;

use crate::walls::Mesh;

/// Constant data of a worn mesh. Corners are those of [`Mesh::corners`]; those that move alike are one node: copies along
/// periodic axes, the two faces of a period, and corners of files that do not share them. Nodes are numbered by their first
/// appearance in the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Skin {
    /// Places of the corners, m.
    pub(super) first: Vec<DVec3>,
    /// Node of each corner.
    pub(super) node_of: Vec<u32>,
    /// Corners of the file in the order of their first appearance.
    pub(super) vertices: Vec<u32>,
    /// Number of `vertices` of each node.
    pub(super) members: Vec<u32>,
    /// Corners of the triangles, in the order of the file.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Unit normals and areas (m^2) of the triangles.
    pub(super) faces: Vec<(DVec3, f64)>,
    /// Unit normals at the nodes, weighted by area.
    pub(super) normals: Vec<DVec3>,
    around: Lists,
    beside: Lists,
    /// Axes along which the mesh goes on for ever, and how far its corners may move along them, m.
    pub(super) axes: Vec<usize>,
    pub(super) room: f64,
    /// Triangles that are lower have no area, m.
    pub(super) least_height: f64,
}

/// A list of numbers for each node.
#[derive(Debug, Clone, PartialEq, Default)]
struct Lists {
    start: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// From pairs of node and number; each number once.
    fn new(mut pairs: Vec<(u32, u32)>, nodes: usize) -> Self {
        pairs.sort_unstable();
        pairs.dedup();
        let mut start = vec![0; nodes + 1];
        for &(node, _) in &pairs {
            start[node as usize + 1] += 1;
        }
        for node in 0..nodes {
            start[node + 1] += start[node];
        }
        // Without the memory of the pairs, in which it may be made.
        let mut items: Vec<u32> = pairs.into_iter().map(|(_, item)| item).collect();
        items.shrink_to_fit();
        Self { start, items }
    }

    fn of(&self, node: u32) -> &[u32] {
        let node = node as usize;
        &self.items[self.start[node] as usize..self.start[node + 1] as usize]
    }
}

impl Skin {
    /// Memory of one with so many corners and triangles, bytes: for estimates.
    pub(super) fn bytes_of(corners: usize, triangles: usize) -> f64 {
        let index = size_of::<u32>();
        let of_corners = 2 * size_of::<DVec3>() + 5 * index;
        let of_triangles = 3 * index + size_of::<(DVec3, f64)>();
        // Three corners of each triangle; two neighbours at each edge, of which there are 3/2 for each triangle.
        (corners * of_corners + triangles * (of_triangles + 6 * index)) as f64
    }

    pub(super) fn new(mesh: &Mesh) -> Self {
        let first = mesh.corners().to_vec();
        let triangles = mesh.triangles();
        let leader = leaders(mesh, &first);
        let mut node_of_leader = vec![u32::MAX; first.len()];
        let mut seen = vec![false; first.len()];
        let (mut vertices, mut members) = (Vec::new(), Vec::new());
        for &corner in triangles.iter().flatten() {
            if std::mem::replace(&mut seen[corner as usize], true) {
                continue;
            }
            vertices.push(corner);
            let node = &mut node_of_leader[leader[corner as usize] as usize];
            if *node == u32::MAX {
                *node = members.len() as u32;
                members.push(0);
            }
            members[*node as usize] += 1;
        }
        let node_of: Vec<u32> = (leader.iter())
            .map(|&leader| node_of_leader[leader as usize])
            .collect();
        let nodes = members.len();
        let (mut around, mut beside) = (Vec::new(), Vec::new());
        let mut faces = Vec::with_capacity(triangles.len());
        let mut sums = vec![DVec3::ZERO; nodes];
        for (triangle, corners) in (0u32..).zip(&triangles) {
            let own = corners.map(|corner| node_of[corner as usize]);
            let [a, b, c] = corners.map(|corner| first[corner as usize]);
            let across = 0.5 * (b - a).cross(c - a);
            faces.push((across.normalize(), across.length()));
            for k in 0..3 {
                let (node, next) = (own[k], own[(k + 1) % 3]);
                around.push((node, triangle));
                if node != next {
                    beside.extend([(node, next), (next, node)]);
                }
                sums[node as usize] += across;
            }
        }
        Self {
            first,
            node_of,
            vertices,
            members,
            triangles,
            faces,
            normals: sums.into_iter().map(DVec3::normalize_or_zero).collect(),
            around: Lists::new(around, nodes),
            beside: Lists::new(beside, nodes),
            axes: mesh.periods().iter().map(|period| period.axis).collect(),
            room: mesh.axial_room(),
            least_height: mesh.least_height(),
        }
    }

    /// Number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.members.len()
    }

    /// Triangles at a node, ascending.
    pub(super) fn around(&self, node: u32) -> &[u32] {
        self.around.of(node)
    }

    /// Nodes to which edges lead, ascending.
    pub(super) fn beside(&self, node: u32) -> &[u32] {
        self.beside.of(node)
    }

    /// The nodes of a triangle.
    pub(super) fn nodes_of(&self, triangle: u32) -> [u32; 3] {
        self.triangles[triangle as usize].map(|corner| self.node_of[corner as usize])
    }

    /// Sides of a triangle from its first corner to the others, and from the second to the third, m, when its nodes are displaced. Coordinates
    /// and displacements are subtracted apart, so that nothing is lost far from the origin.
    pub(super) fn sides(&self, triangle: u32, displacement: &[DVec3]) -> [DVec3; 3] {
        let corners = self.triangles[triangle as usize];
        let [a, b, c] = corners.map(|corner| self.first[corner as usize]);
        let [u, v, w] = self
            .nodes_of(triangle)
            .map(|node| displacement[node as usize]);
        let (ab, ac) = ((b - a) + (v - u), (c - a) + (w - u));
        [ab, ac, (c - b) + (w - v)]
    }

    /// The signed volume that a triangle sweeps on the straight way from its first place, m^3; positive along its normal.
    ///
    /// That is the integral of (area normal).(mean displacement), a polynomial of the third degree of the way.
    pub(super) fn swept(&self, triangle: u32, displacement: &[DVec3]) -> f64 {
        let corners = self.triangles[triangle as usize];
        let [a, b, c] = corners.map(|corner| self.first[corner as usize]);
        let [u, v, w] = self
            .nodes_of(triangle)
            .map(|node| displacement[node as usize]);
        let ([e, f], [g, h]) = ([b - a, c - a], [v - u, w - u]);
        let normal = e.cross(f) + 0.5 * (e.cross(h) + g.cross(f)) + g.cross(h) / 3.0;
        0.5 * normal.dot((u + v + w) / 3.0)
    }
}

/// Leader of each corner: the one that stands for all that move like it.
fn leaders(mesh: &Mesh, places: &[DVec3]) -> Vec<u32> {
    let mut leader: Vec<u32> = (0..places.len() as u32).collect();
    fn find(leader: &mut [u32], mut corner: u32) -> u32 {
        while leader[corner as usize] != corner {
            leader[corner as usize] = leader[leader[corner as usize] as usize];
            corner = leader[corner as usize];
        }
        corner
    }
    let mut same: Vec<(u32, u32)> = mesh.twins().collect();
    let mut at: HashMap<[u64; 3], u32> = HashMap::with_capacity(places.len());
    for (corner, place) in (0u32..).zip(places) {
        // Adding 0 makes -0 the same as 0.
        let key = place.to_array().map(|x| (x + 0.0).to_bits());
        let other = *at.entry(key).or_insert(corner);
        same.push((corner, other));
    }
    for (one, other) in same {
        let (one, other) = (find(&mut leader, one), find(&mut leader, other));
        leader[one.max(other) as usize] = one.min(other);
    }
    (0..places.len() as u32)
        .map(|corner| find(&mut leader, corner))
        .collect()
}
