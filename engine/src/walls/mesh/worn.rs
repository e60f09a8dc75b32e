//! Queries of a mesh for wear: where a contact stands on its triangle, which corners move alike, and the mesh behind a face.

use std::cmp::Reverse;
use std::collections::HashMap;

use glam::DVec3;

use super::facet::Facet;
use super::near::Near;
use super::{Mesh, Scratch};

/// A point of a triangle, an edge or a corner, by the corners that hold it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base {
    /// Their numbers as in [`Mesh::corners`].
    pub corners: [u32; 3],
    /// Barycentric weights, not negative, of sum 1; 0 for what does not count.
    pub weights: [f64; 3],
    /// Mean normal of the triangles there, of any length.
    pub normal: DVec3,
}

/// Two triangles with a common edge whose normals point to opposite sides of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnedPair {
    /// Place in the file of the one with more such neighbours, where those without area are not counted.
    pub triangle: u32,
    /// Number of the other one.
    pub neighbour: u32,
    /// Number of such pairs in the mesh.
    pub pairs: usize,
    /// The middle of the edge, m.
    pub place: DVec3,
}

/// A triangle that lies opposite to another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facing {
    /// Its place in the file, where those without area are not counted.
    pub triangle: u32,
    /// How far the two are from each other, m.
    pub distance: f64,
}

impl Mesh {
    /// Triangles in the order of the file by the numbers of their corners; those without area, and what continues the mesh along periodic axes, are
    /// left out.
    #[must_use]
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let own = (0..self.facets.len()).filter(|&facet| self.is_own(facet));
        let mut all: Vec<(u32, [u32; 3])> = own
            .map(|facet| (self.file_order[facet], self.facets[facet].vertices))
            .collect();
        all.sort_unstable_by_key(|&(place, _)| place);
        all.into_iter().map(|(_, corners)| corners).collect()
    }

    /// Neighbours whose normals point to opposite sides: both run through their common edge in the same sense. Edges with more than two triangles have
    /// no two sides, and do not count.
    #[must_use]
    pub fn turned(&self) -> Option<TurnedPair> {
        let mut found = Vec::new();
        let mut counts: HashMap<u32, usize> = HashMap::new();
        for edge in 0..self.topology.edge_count() as u32 {
            let &[(one, _), (other, _)] = self.topology.triangles_at(edge) else {
                continue;
            };
            let ends = self.topology.ends(edge);
            let [a, b] = [one, other].map(|facet| self.facets[facet as usize].runs(ends));
            if a == b {
                let pair = [one, other].map(|facet| self.file_order[facet as usize]);
                found.push((pair, ends));
                for triangle in pair {
                    *counts.entry(triangle).or_default() += 1;
                }
            }
        }
        let worst = |pair: [u32; 2]| {
            let [one, other] = pair.map(|triangle| (counts[&triangle], Reverse(triangle)));
            one.max(other)
        };
        let &(pair, ends) = found.iter().max_by_key(|(pair, _)| worst(*pair))?;
        let (_, Reverse(triangle)) = worst(pair);
        let [from, to] = ends.map(|corner| self.vertices[corner as usize]);
        Some(TurnedPair {
            triangle,
            neighbour: if pair[0] == triangle {
                pair[1]
            } else {
                pair[0]
            },
            pairs: found.len(),
            place: 0.5 * (from + to),
        })
    }

    /// Corners that move alike, as they are the same up to whole periods: pairs of which the first follows the second.
    pub fn twins(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.continuation.twins()
    }

    /// How far corners may move along the axes of [`Mesh::periods`] from where they were at first, m.
    #[must_use]
    pub fn axial_room(&self) -> f64 {
        self.continuation.room()
    }

    /// Triangles whose smallest height is below this have no area, m.
    #[must_use]
    pub fn least_height(&self) -> f64 {
        self.precision.tolerance
    }

    /// Where `foot` (m), the nearest point of a feature of the file, stands on it.
    #[must_use]
    pub fn base(&self, feature: u32, foot: DVec3) -> Base {
        let (faces, edges) = (self.facets.len(), self.topology.edge_count());
        let index = feature as usize;
        if index < faces {
            let facet = &self.facets[index];
            let foot = foot + self.shift_to(feature, foot);
            let [a, b, c] = facet.corners;
            let (ab, ac) = (b - a, c - a);
            let across = ab.cross(ac);
            let from_a = across.cross(foot - a) / across.length_squared();
            // Round-off must not make a weight negative.
            let v = from_a.dot(ac).clamp(0.0, 1.0);
            let w = (-from_a.dot(ab)).clamp(0.0, 1.0 - v);
            return Base {
                corners: facet.vertices,
                weights: [1.0 - v - w, v, w],
                normal: facet.normal,
            };
        }
        let normals = |edges: &mut dyn Iterator<Item = u32>| -> DVec3 {
            let around = edges.flat_map(|edge| self.topology.triangles_at(edge));
            around
                .map(|&(facet, _)| self.facets[facet as usize].normal)
                .sum()
        };
        if index < faces + edges {
            let edge = (index - faces) as u32;
            let foot = foot + self.shift_to(feature, foot);
            let [from, to] = self.topology.ends(edge);
            let (start, end) = (self.vertices[from as usize], self.vertices[to as usize]);
            let along = end - start;
            let t = ((foot - start).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            return Base {
                corners: [from, to, from],
                weights: [1.0 - t, t, 0.0],
                normal: normals(&mut std::iter::once(edge)),
            };
        }
        let corner = (index - faces - edges) as u32;
        Base {
            corners: [corner; 3],
            weights: [1.0, 0.0, 0.0],
            normal: normals(&mut self.topology.edges_at(corner)),
        }
    }

    /// The nearest point of a feature of the file, or of its image that is nearest, m.
    #[must_use]
    pub fn foot_on(&self, feature: u32, place: DVec3) -> DVec3 {
        let shift = self.shift_to(feature, place);
        self.nearest_of(feature, place + shift) - shift
    }

    /// The whole periods that bring a place on an image of a feature onto the feature itself, m.
    fn shift_to(&self, feature: u32, place: DVec3) -> DVec3 {
        if self.periods().is_empty() {
            return DVec3::ZERO;
        }
        let away = |shift: DVec3| {
            let place = place + shift;
            self.nearest_of(feature, place).distance_squared(place)
        };
        let nearest = self
            .image_shifts()
            .min_by(|a, b| away(*a).total_cmp(&away(*b)));
        nearest.unwrap_or(DVec3::ZERO)
    }

    /// Distance of the triangle of these corners, at a corner of either, from all triangles that share no corner with it, at most
    /// `reach` (m), and the one that faces the other way and is nearer than `thin` (m). Corners that are `same` are one.
    #[must_use]
    pub fn facing(
        &self,
        corners: [u32; 3],
        [thin, reach]: [f64; 2],
        same: impl Fn(u32, u32) -> bool,
        scratch: &mut Scratch,
    ) -> (f64, Option<Facing>) {
        let own = Facet::new(&self.vertices, corners, [0; 3]);
        let [a, b, c] = own.corners;
        let middle = (a + b + c) / 3.0;
        let ways = own.corners.map(|x| x.distance(middle));
        let radius = ways.into_iter().fold(0.0, f64::max);
        let mut packs = Vec::new();
        let search = &mut scratch.search;
        // Every facet that is so near counts: a list without a skin leaves none out.
        self.list(middle, radius + reach, (0.0, 0.0), search, &mut packs);
        let near = Near {
            packs: &packs,
            slack: 0.0,
            moved: 0.0,
        };
        let (mut clear, mut nearest) = (reach, None);
        for index in near.facets() {
            let facet = &self.facets[index];
            let shares = |k: &u32| corners.iter().any(|&own| own == *k || same(own, *k));
            if facet.vertices.iter().any(shares) {
                continue;
            }
            let from_here = own
                .corners
                .into_iter()
                .filter_map(|x| facet.nearest(x, reach));
            let from_there = facet
                .corners
                .into_iter()
                .filter_map(|x| own.nearest(x, reach));
            let distances = from_here.chain(from_there).map(|nearest| nearest.distance);
            let distance = distances.fold(f64::INFINITY, f64::min);
            clear = clear.min(distance);
            let known = nearest.map_or(thin, |known: Facing| known.distance);
            if distance < known && facet.normal.dot(own.normal) <= -0.5 {
                nearest = Some(Facing {
                    triangle: self.file_order[index],
                    distance,
                });
            }
        }
        (clear, nearest)
    }
}
