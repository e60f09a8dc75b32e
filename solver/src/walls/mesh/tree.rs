//! A tree of boxes around triangles.

use std::ops::Range;

use glam::{DVec3, Vec3};

/// Most triangles in a leaf.
const LEAF: usize = 4;
/// Boxes smaller than this part of the reach are taken for what they hold, where that may be.
const SMALL: f64 = 0.5;

/// A bounding volume hierarchy: each node halves its triangles at the median of their middles along the longest edge of the box
/// around these. It lives in the mesh's own frame, so motion costs nothing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tree {
    nodes: Vec<Node>,
}

#[derive(Debug, Clone, PartialEq)]
struct Node {
    /// Corners of the box, rounded outwards: nodes are what a search waits for, and half as large so.
    low: Vec3,
    high: Vec3,
    /// First triangle of a leaf; second child of a branch, whose first child follows it.
    next: u32,
    /// Number of triangles of a leaf; 0 for a branch.
    count: u32,
}

impl Node {
    /// Square of the distance from the box, m^2.
    #[inline]
    fn square_distance(&self, x: DVec3) -> f64 {
        (self.low.as_dvec3() - x)
            .max(x - self.high.as_dvec3())
            .max(DVec3::ZERO)
            .length_squared()
    }
}

/// Triangles are cut off by exact distances later, so boxes may be a little generous.
fn square_of(reach: f64) -> f64 {
    reach * reach * (1.0 + 1e-9)
}

/// In single precision, and not nearer.
fn outwards(x: DVec3, next: fn(f32) -> f32) -> Vec3 {
    Vec3::from_array(x.as_vec3().to_array().map(next))
}

impl Tree {
    /// Sorts the triangles so that those of a leaf lie together, and builds the tree over them.
    pub(super) fn build(vertices: &[DVec3], triangles: &mut [(u32, [u32; 3])]) -> Self {
        let mut tree = Self { nodes: Vec::new() };
        // The middles are the sort keys; they move with the triangles.
        let mut keyed: Vec<(DVec3, (u32, [u32; 3]))> = triangles
            .iter()
            .map(|&triangle| {
                let sum: DVec3 = triangle.1.iter().map(|&k| vertices[k as usize]).sum();
                (sum / 3.0, triangle)
            })
            .collect();
        tree.split(vertices, &mut keyed, 0);
        for (triangle, (_, sorted)) in triangles.iter_mut().zip(keyed) {
            *triangle = sorted;
        }
        tree
    }

    fn split(
        &mut self,
        vertices: &[DVec3],
        triangles: &mut [(DVec3, (u32, [u32; 3]))],
        first: usize,
    ) {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        let (mut least, mut largest) = (low, high);
        for (middle, (_, corners)) in triangles.iter() {
            least = least.min(*middle);
            largest = largest.max(*middle);
            for &k in corners {
                low = low.min(vertices[k as usize]);
                high = high.max(vertices[k as usize]);
            }
        }
        let index = self.nodes.len();
        let leaf = triangles.len() <= LEAF;
        self.nodes.push(Node {
            low: outwards(low, f32::next_down),
            high: outwards(high, f32::next_up),
            next: first as u32,
            count: if leaf { triangles.len() as u32 } else { 0 },
        });
        if leaf {
            return;
        }
        let axis = (largest - least).max_position();
        let half = triangles.len() / 2;
        triangles.select_nth_unstable_by(half, |a, b| {
            a.0[axis].total_cmp(&b.0[axis]).then(a.1.0.cmp(&b.1.0))
        });
        let (left, right) = triangles.split_at_mut(half);
        self.split(vertices, left, first);
        self.nodes[index].next = self.nodes.len() as u32;
        self.split(vertices, right, first + half);
    }

    /// Replaces `leaves` by the triangles of every leaf whose box is closer than `reach` (m) to `centre`. `layers`: memory.
    ///
    /// Goes down level by level and without branches on what it finds, so that a processor waits for the memory of all nodes of a
    /// level at once: large trees are not in the cache.
    pub(super) fn leaves(
        &self,
        centre: DVec3,
        reach: f64,
        layers: &mut [Vec<u32>; 2],
        leaves: &mut Vec<Range<u32>>,
    ) {
        let square = square_of(reach);
        let [layer, next] = layers;
        layer.clear();
        layer.push(0);
        leaves.clear();
        while !layer.is_empty() {
            let (mut branches, mut found) = (0, leaves.len());
            next.resize(2 * layer.len(), 0);
            leaves.resize(found + layer.len(), 0..0);
            for &index in &*layer {
                let node = &self.nodes[index as usize];
                let near = node.square_distance(centre) <= square;
                let leaf = node.count > 0;
                next[branches] = index + 1;
                next[branches + 1] = node.next;
                branches += 2 * usize::from(near & !leaf);
                leaves[found] = node.next..node.next + node.count;
                found += usize::from(near & leaf);
            }
            next.truncate(branches);
            leaves.truncate(found);
            std::mem::swap(layer, next);
        }
    }

    /// Whether `near` is true of the triangles of a leaf whose box is closer than `reach` (m) to `centre`. It is not asked if the
    /// box is small against the reach.
    pub(super) fn has_near(
        &self,
        centre: DVec3,
        reach: f64,
        stack: &mut Vec<u32>,
        mut near: impl FnMut(Range<usize>) -> bool,
    ) -> bool {
        stack.clear();
        stack.push(0);
        let square = square_of(reach);
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if node.square_distance(centre) > square {
                continue;
            }
            if node.count > 0 {
                let size = f64::from(node.low.distance_squared(node.high));
                let small = size < SMALL * SMALL * square;
                let first = node.next as usize;
                if small || near(first..first + node.count as usize) {
                    return true;
                }
            } else {
                stack.push(node.next);
                stack.push(index + 1);
            }
        }
        false
    }
}
