//! Minima of the distance that are contacts of their own, on surfaces that bend around particles.
//!
//! Each triangle that faces a sphere may have a minimum of its own. On a path over the surface from one minimum to a nearer one the distance rises to a
//! saddle; the lowest saddle of all paths lies on an edge. A minimum counts as far as it is below its saddle: where the surface is flat
//! it is not, and there is one contact; where it bends sharply the saddle is out of reach, and there are two. The sum of what springs
//! store at the minima, less what they would store at the saddles, changes continuously with all positions. (The saddles are those of the merge
//! tree of the distance over the surface: Edelsbrunner & Harer 2010, chapter VII.)

use glam::DVec3;

use super::near::Near;
use super::{Mesh, Scratch, Touches};

/// Minima that count for less than this are none.
const LEAST: f64 = 1e-6;

/// Where a minimum joins a nearer one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saddle {
    /// Feature of the minimum.
    pub of: u32,
    /// Feature of the nearer minimum that it joins.
    pub joins: u32,
    /// The edge.
    pub feature: u32,
    /// From the centre, m.
    pub distance: f64,
    /// From there to the centre.
    pub normal: DVec3,
    /// Share by which the minimum counts: 1 - (depth of the saddle / depth of the minimum)^2.
    pub part: f64,
}

/// Memory of [`Mesh::join`].
#[derive(Debug, Clone, Default)]
pub(super) struct Tree {
    /// Facet, distance (m) and feature of its nearest point.
    nodes: Vec<(u32, f64, u32)>,
    /// Distance (m), edge, and the nodes beside it.
    edges: Vec<(f64, u32, [u32; 2])>,
    /// Parent of each node; the root of a component is its nearest node.
    parents: Vec<u32>,
}

impl Tree {
    fn root(&mut self, mut node: u32) -> u32 {
        while self.parents[node as usize] != node {
            let parent = self.parents[node as usize];
            self.parents[node as usize] = self.parents[parent as usize];
            node = parent;
        }
        node
    }
}

impl Mesh {
    /// Leaves those touches that count, of a sphere that reaches as far as `reach` (m), and notes their saddles.
    pub(super) fn join(
        &self,
        near: Near<'_>,
        (centre, reach): (DVec3, f64),
        scratch: &mut Scratch,
        out: &mut Touches,
    ) {
        scratch.saddles.clear();
        if !self.keeps_all || out.len() < 2 || out.iter().any(|touch| touch.distance < 0.0) {
            return;
        }
        let Scratch { saddles, joins, .. } = scratch;
        self.find_nodes(near, centre, reach, joins);
        self.find_edges(centre, reach, joins);
        let faces = self.facets.len() as u32;
        for k in 0..joins.edges.len() {
            let (distance, edge, ends) = joins.edges[k];
            let [a, b] = ends.map(|node| joins.root(node));
            if a == b {
                continue;
            }
            let order = |node: u32| {
                let (_, distance, feature) = joins.nodes[node as usize];
                (distance, feature)
            };
            let (elder, younger) = if order(a) <= order(b) { (a, b) } else { (b, a) };
            joins.parents[younger as usize] = elder;
            let (_, nearest, of) = joins.nodes[younger as usize];
            let depth = (reach - distance) / (reach - nearest);
            let part = 1.0 - depth * depth;
            if part > LEAST {
                let feature = faces + edge;
                saddles.push(Saddle {
                    of,
                    joins: joins.nodes[elder as usize].2,
                    feature,
                    distance,
                    normal: (centre - self.nearest_of(feature, centre)) / distance,
                    part,
                });
            }
        }
        let all = std::mem::take(out);
        let is_root = |feature: u32, joins: &Tree| {
            let mut nodes = (0u32..).zip(&joins.nodes);
            nodes.any(|(k, node)| node.2 == feature && joins.parents[k as usize] == k)
        };
        for (place, touch) in all.iter().enumerate() {
            let joined = saddles.iter().any(|saddle| saddle.of == touch.feature);
            if place == 0 || joined || is_root(touch.feature, joins) {
                out.push(*touch);
            }
        }
    }

    /// The facets within reach, ascending.
    fn find_nodes(&self, near: Near<'_>, centre: DVec3, reach: f64, tree: &mut Tree) {
        tree.nodes.clear();
        for index in near.facets() {
            if let Some(nearest) = self.facet(index).nearest(centre, reach) {
                let feature = self.feature(index as u32, nearest.part);
                tree.nodes.push((index as u32, nearest.distance, feature));
            }
        }
        tree.nodes.sort_unstable_by_key(|node| node.0);
        tree.nodes.dedup_by_key(|node| node.0);
        tree.parents.clear();
        tree.parents.extend(0..tree.nodes.len() as u32);
    }

    /// The edges within reach between them, the nearest first.
    fn find_edges(&self, centre: DVec3, reach: f64, tree: &mut Tree) {
        tree.edges.clear();
        let faces = self.facets.len() as u32;
        for (k, &(index, ..)) in tree.nodes.iter().enumerate() {
            for edge in self.facets[index as usize].edges {
                let Some(other) = self.topology.across(edge, index) else {
                    continue;
                };
                let found = tree.nodes.binary_search_by_key(&other, |node| node.0);
                let (true, Ok(place)) = (other > index, found) else {
                    continue;
                };
                let distance = self.nearest_of(faces + edge, centre).distance(centre);
                if distance < reach {
                    tree.edges.push((distance, edge, [k as u32, place as u32]));
                }
            }
        }
        (tree.edges).sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
}
