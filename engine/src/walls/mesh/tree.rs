//! A tree of boxes around triangles.

use glam::{DVec3, Vec3};

use super::facet::Facet;
use super::leaf::LANES;
use crate::memory::prefetch;

/// Children of a node.
const WIDE: usize = 8;

/// Boxes smaller than this part of the reach are taken for what they hold, where that may be.
const SMALL: f64 = 0.5;

/// Largest error of single precision: of a place, over its largest coordinate; of a distance, over itself.
const PLACE: f64 = 2e-7;
const DISTANCE: f64 = 1e-6;

/// Marks a child that is a leaf.
const LEAF: u32 = 1 << 31;

/// A bounding volume hierarchy: triangles are halved at the median of their middles along the longest edge of the box around these,
/// and each node holds what three such cuts give. It lives in the mesh's own frame, so motion costs nothing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tree {
    nodes: Vec<Node>,
}

/// The boxes of a node's children, side by side: a search waits for memory above all, and looks at all of them at once.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
struct Node {
    /// Corners of the boxes, rounded outwards, m; turned inside out where there is no child.
    low: [[f32; WIDE]; 3],
    high: [[f32; WIDE]; 3],
    /// Index of a node, or [`LEAF`] and that of a leaf.
    next: [u32; WIDE],
}

/// A ball that is searched for boxes, in single precision and no smaller than it is.
#[derive(Clone, Copy)]
struct Ball {
    centre: [f32; 3],
    /// m^2.
    square: f32,
}

impl Ball {
    fn new(centre: DVec3, reach: f64) -> Self {
        let reach = reach * (1.0 + DISTANCE) + PLACE * centre.abs().max_element();
        Self {
            centre: centre.as_vec3().to_array(),
            square: (reach * reach) as f32,
        }
    }
}

impl Node {
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; WIDE]; 3],
        high: [[f32::NEG_INFINITY; WIDE]; 3],
        next: [LEAF; WIDE],
    };

    fn set_box(&mut self, child: usize, low: [f32; 3], high: [f32; 3]) {
        for axis in 0..3 {
            self.low[axis][child] = low[axis];
            self.high[axis][child] = high[axis];
        }
    }

    fn has_child(&self, child: usize) -> bool {
        self.low[0][child] <= self.high[0][child]
    }

    /// The box around those of all children.
    fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let least = |lanes: [f32; WIDE]| lanes.into_iter().fold(f32::INFINITY, f32::min);
        let most = |lanes: [f32; WIDE]| lanes.into_iter().fold(f32::NEG_INFINITY, f32::max);
        (self.low.map(least), self.high.map(most))
    }

    /// Children whose boxes a ball reaches.
    #[inline]
    fn near(&self, ball: &Ball) -> [bool; WIDE] {
        let mut squares = [0.0f32; WIDE];
        for (axis, x) in ball.centre.into_iter().enumerate() {
            for (k, square) in squares.iter_mut().enumerate() {
                let (below, above) = (self.low[axis][k] - x, x - self.high[axis][k]);
                let beyond = if below > above { below } else { above };
                let beyond = if beyond > 0.0 { beyond } else { 0.0 };
                *square += beyond * beyond;
            }
        }
        squares.map(|square| square <= ball.square)
    }

    /// Whether the box of a child is small against the reach.
    fn is_small(&self, child: usize, ball: &Ball) -> bool {
        let edges = [0, 1, 2].map(|axis| self.high[axis][child] - self.low[axis][child]);
        let size = f64::from(Vec3::from_array(edges).length_squared());
        size < SMALL * SMALL * f64::from(ball.square)
    }
}

/// The box around some places, in single precision.
fn around(places: impl Iterator<Item = DVec3>) -> ([f32; 3], [f32; 3]) {
    let (low, high) = places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    (outwards(low, f32::next_down), outwards(high, f32::next_up))
}

/// In single precision, and not nearer.
fn outwards(x: DVec3, next: fn(f32) -> f32) -> [f32; 3] {
    x.as_vec3().to_array().map(next)
}

/// A triangle on its way into the tree: its middle is the key by which it is sorted.
type Keyed = (DVec3, (u32, [u32; 3]));

impl Tree {
    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
    }

    /// For each leaf, if all nodes have all their children.
    pub(super) const BYTES_OF_LEAF: usize = size_of::<Node>() / (WIDE - 1);

    /// Sorts the triangles so that those of a leaf lie together, [`LANES`] of them but for the last leaf, and builds the tree over them.
    pub(super) fn build(vertices: &[DVec3], triangles: &mut [(u32, [u32; 3])]) -> Self {
        let mut tree = Self { nodes: Vec::new() };
        let mut keyed: Vec<Keyed> = triangles
            .iter()
            .map(|&triangle| {
                let sum: DVec3 = triangle.1.iter().map(|&k| vertices[k as usize]).sum();
                (sum / 3.0, triangle)
            })
            .collect();
        tree.branch(vertices, &mut keyed, 0);
        for (triangle, (_, sorted)) in triangles.iter_mut().zip(keyed) {
            *triangle = sorted;
        }
        tree
    }

    /// Adds the node over `triangles`, whose first one is number `first` of all. Returns its index.
    fn branch(&mut self, vertices: &[DVec3], triangles: &mut [Keyed], first: usize) -> u32 {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let mut parts = vec![triangles];
        while parts.len() < WIDE && parts.iter().any(|part| part.len() > LANES) {
            parts = parts.into_iter().flat_map(halves).collect();
        }
        let mut begin = first;
        for (child, part) in parts.into_iter().enumerate() {
            let node = &mut self.nodes[index];
            let corners = part.iter().flat_map(|(_, (_, corners))| corners);
            let (low, high) = around(corners.map(|&k| vertices[k as usize]));
            node.set_box(child, low, high);
            let count = part.len();
            let next = if count <= LANES {
                LEAF | (begin / LANES) as u32
            } else {
                self.branch(vertices, part, begin)
            };
            self.nodes[index].next[child] = next;
            begin += count;
        }
        index as u32
    }

    /// The boxes around the same triangles in other places; `facets`: in the order of the leaves.
    pub(super) fn refit(&mut self, facets: &[Facet]) {
        // Children come behind their parents.
        for index in (0..self.nodes.len()).rev() {
            for child in 0..WIDE {
                let node = &self.nodes[index];
                if !node.has_child(child) {
                    continue;
                }
                let to = node.next[child];
                let (low, high) = if to & LEAF == 0 {
                    self.nodes[to as usize].bounds()
                } else {
                    let begin = (to & !LEAF) as usize * LANES;
                    let end = facets.len().min(begin + LANES);
                    around(facets[begin..end].iter().flat_map(|facet| facet.corners))
                };
                self.nodes[index].set_box(child, low, high);
            }
        }
    }

    /// Replaces `leaves` by the leaves whose boxes are closer than `reach` (m) to `centre`, and some that are hardly farther.
    /// `layers`: memory.
    ///
    /// Goes down level by level and without branches on what it finds, so that a processor waits for the memory of all nodes of a
    /// level at once: large trees are not in the cache.
    pub(super) fn leaves(
        &self,
        centre: DVec3,
        reach: f64,
        layers: &mut [Vec<u32>; 2],
        leaves: &mut Vec<u32>,
    ) {
        let ball = Ball::new(centre, reach);
        let [layer, next] = layers;
        layer.clear();
        layer.push(0);
        leaves.clear();
        while !layer.is_empty() {
            let (mut branches, mut found) = (0, leaves.len());
            next.resize(WIDE * layer.len(), 0);
            leaves.resize(found + WIDE * layer.len(), 0);
            for &index in &*layer {
                let node = &self.nodes[index as usize];
                for (to, near) in node.next.into_iter().zip(node.near(&ball)) {
                    let leaf = to & LEAF != 0;
                    next[branches] = to;
                    branches += usize::from(near & !leaf);
                    leaves[found] = to & !LEAF;
                    found += usize::from(near & leaf);
                }
            }
            next.truncate(branches);
            leaves.truncate(found);
            for &index in &*next {
                prefetch(&self.nodes[index as usize]);
            }
            std::mem::swap(layer, next);
        }
    }

    /// Whether `near` is true of a leaf whose box is closer than `reach` (m) to `centre`. It is not evaluated if the box is small
    /// against the reach.
    pub(super) fn has_near(
        &self,
        centre: DVec3,
        reach: f64,
        stack: &mut Vec<u32>,
        mut near: impl FnMut(u32) -> bool,
    ) -> bool {
        let ball = Ball::new(centre, reach);
        stack.clear();
        stack.push(0);
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            for (child, reached) in node.near(&ball).into_iter().enumerate() {
                if !reached {
                    continue;
                }
                let to = node.next[child];
                if to & LEAF == 0 {
                    stack.push(to);
                } else if node.is_small(child, &ball) || near(to & !LEAF) {
                    return true;
                }
            }
        }
        false
    }
}

/// Cuts triangles in two, the first part a multiple of [`LANES`], unless they fit a leaf.
fn halves(triangles: &mut [Keyed]) -> impl Iterator<Item = &mut [Keyed]> {
    let half = if triangles.len() <= LANES {
        triangles.len()
    } else {
        triangles.len().div_ceil(LANES) / 2 * LANES
    };
    if half < triangles.len() {
        let low = triangles.iter().fold(DVec3::INFINITY, |x, t| x.min(t.0));
        let high = triangles
            .iter()
            .fold(DVec3::NEG_INFINITY, |x, t| x.max(t.0));
        let axis = (high - low).max_position();
        triangles.select_nth_unstable_by(half, |a, b| {
            a.0[axis].total_cmp(&b.0[axis]).then(a.1.0.cmp(&b.1.0))
        });
    }
    let (left, right) = triangles.split_at_mut(half);
    [left, right].into_iter().filter(|part| !part.is_empty())
}
