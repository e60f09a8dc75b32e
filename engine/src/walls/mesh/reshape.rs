//! A mesh whose corners move: the same triangles in other places.
//!
//! Triangles, edges and corners keep their numbers, so what contacts remember goes on. The tree keeps its branches, and its boxes
//! follow; so it stays right, and good as long as neighbours stay neighbours.

use glam::DVec3;
use rayon::prelude::*;

use super::super::error::{WallError, finite_vector};
use super::facet::Facet;
use super::{Extent, LANES, Leaf, Mesh, find_patches, has_area, short_sides_first, steady_normals};

/// From so many triangles on a mesh is fitted by all threads of the pool in which it is called, if any.
const LARGE: usize = 4096;
/// Triangles that a thread takes at a time, at least.
const CHUNK: usize = 1024;

/// New places that a mesh can take.
struct Placed {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Places of the corners, m: those that [`Mesh::outline`] numbers.
    #[must_use]
    pub fn corners(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Puts the corners to new places (m), one for each of [`Mesh::corners`]. What continues the mesh along periodic axes follows:
    /// the places given for its copies are not read. Returns how far the farthest corner has moved, m: no point of the surface
    /// has moved farther. The result depends on the places alone, not on the way there.
    ///
    /// # Errors
    /// Leaves the mesh as it is if a place is missing or not finite, if a triangle loses its area or turns by more than a right angle
    /// at once, or if a mesh that goes on for ever would no longer be the same at the two faces of its period.
    pub fn reshape(&mut self, places: &[DVec3]) -> Result<f64, WallError> {
        let new = self.checked(places)?;
        for (k, (old, &corners)) in self.facets.iter().zip(&new.triangles).enumerate() {
            let [a, b, c] = corners.map(|k| new.vertices[k as usize]);
            if (b - a).cross(c - a).dot(old.normal) <= 0.0 {
                let triangle = self.file_order[k];
                return Err(WallError::TurnedOver { triangle });
            }
        }
        Ok(self.take(new))
    }

    /// The same in one go from any earlier shape: triangles may have turned in many steps.
    pub(in super::super) fn place(&mut self, places: &[DVec3]) -> Result<(), WallError> {
        let new = self.checked(places)?;
        self.take(new);
        Ok(())
    }

    /// The places of all corners, and the triangles with their corners in the order in which their normals are most exact.
    fn checked(&self, places: &[DVec3]) -> Result<Placed, WallError> {
        if places.len() != self.vertices.len() {
            return Err(WallError::Corners {
                corners: self.vertices.len(),
                given: places.len(),
            });
        }
        let vertices = self.continuation.followed(places)?;
        for &place in &vertices {
            finite_vector("corners", place)?;
        }
        let tolerance = self.tolerance;
        let placed = |facet: &Facet| {
            let new = short_sides_first(lowest_first(facet.vertices), &vertices);
            let [a, b, c] = new.map(|k| vertices[k as usize]);
            has_area([a, b, c], tolerance).then_some(new)
        };
        let all: Vec<Option<[u32; 3]>> = if self.is_shared() {
            let facets = self.facets.par_iter().with_min_len(CHUNK);
            facets.map(placed).collect()
        } else {
            self.facets.iter().map(placed).collect()
        };
        let mut triangles = Vec::with_capacity(all.len());
        for (new, &triangle) in all.into_iter().zip(&self.file_order) {
            triangles.push(new.ok_or(WallError::LostArea { triangle })?);
        }
        Ok(Placed {
            vertices,
            triangles,
        })
    }

    /// Takes new places. Returns how far the farthest corner has moved, m.
    fn take(&mut self, new: Placed) -> f64 {
        let ways = self.vertices.iter().zip(&new.vertices);
        let moved = ways.fold(0.0f64, |most, (old, new)| most.max(old.distance(*new)));
        self.vertices = new.vertices;
        self.refit(&new.triangles);
        self.travelled += moved;
        moved
    }

    /// Whether threads share the triangles.
    fn is_shared(&self) -> bool {
        self.facets.len() >= LARGE && rayon::current_thread_index().is_some()
    }

    /// Makes anew what follows from the places of the corners; `corners`: those of the triangles.
    fn refit(&mut self, corners: &[[u32; 3]]) {
        let is_shared = self.is_shared();
        let vertices = &self.vertices;
        let fit = |(facet, &corners): (&mut Facet, &[u32; 3])| {
            let first = facet.vertices.iter().position(|&k| k == corners[0]);
            let mut edges = facet.edges;
            edges.rotate_left(first.unwrap_or(0));
            *facet = Facet::new(vertices, corners, edges);
        };
        if is_shared {
            let facets = self.facets.par_iter_mut().zip(corners);
            facets.with_min_len(CHUNK).for_each(fit);
        } else {
            self.facets.iter_mut().zip(corners).for_each(fit);
        }
        if self.front_only {
            self.topology.find_normals(&self.vertices, corners);
        }
        steady_normals(&mut self.facets, &self.topology, self.tolerance);
        if !self.keeps_all {
            find_patches(&mut self.facets, &self.topology, self.vertices.len());
        }
        if is_shared {
            let leaves = (self.leaves.par_iter_mut()).zip(self.facets.par_chunks(LANES));
            let leaves = leaves.with_min_len(CHUNK / LANES);
            leaves.for_each(|(leaf, facets)| *leaf = Leaf::new(facets));
        } else {
            for (leaf, facets) in self.leaves.iter_mut().zip(self.facets.chunks(LANES)) {
                *leaf = Leaf::new(facets);
            }
        }
        self.tree.refit(&self.facets);
        let area = self.facets.iter().map(Facet::area).sum::<f64>();
        self.mean_area = area / self.facets.len() as f64;
        self.extent = Extent::of(&self.vertices, |corner| !self.continuation.is_copy(corner));
        self.round_off = Extent::of(&self.vertices, |_| true).round_off();
    }

    /// How far corners have moved in all changes together, at most, m.
    pub(super) fn travelled(&self) -> f64 {
        self.travelled
    }
}

/// The corners in the same sense of rotation, the lowest number first: an order that does not depend on earlier places.
fn lowest_first(mut corners: [u32; 3]) -> [u32; 3] {
    let least = corners
        .iter()
        .min()
        .and_then(|least| corners.iter().position(|k| k == least));
    corners.rotate_left(least.unwrap_or(0));
    corners
}

#[cfg(test)]
impl Mesh {
    /// A mesh made anew of the triangles where they are now.
    pub(crate) fn made_anew(&self) -> Self {
        let numbered = self.file_order.iter().zip(&self.facets);
        let mut kept: Vec<(u32, [u32; 3])> = numbered
            .map(|(&place, facet)| {
                (
                    place,
                    short_sides_first(lowest_first(facet.vertices), &self.vertices),
                )
            })
            .collect();
        kept.sort_unstable();
        Self::assembled(
            self.vertices.clone(),
            &mut kept,
            self.tolerance,
            self.front_only,
            self.dropped,
        )
        .0
    }

    /// The places of the corners that a feature joins, in an order of their own.
    pub(crate) fn places_of(&self, feature: u32) -> Vec<DVec3> {
        let (faces, edges) = (self.facets.len() as u32, self.topology.edge_count() as u32);
        let corners = match feature.checked_sub(faces) {
            None => self.facets[feature as usize].vertices.to_vec(),
            Some(edge) if edge < edges => self.topology.ends(edge).to_vec(),
            Some(corner) => vec![corner - edges],
        };
        let mut places: Vec<DVec3> = corners.iter().map(|&k| self.vertices[k as usize]).collect();
        places.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
        places
    }
}
