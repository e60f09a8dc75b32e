//! A mesh whose corners move: the same triangles in other places.
//!
//! Triangles, edges and corners keep their numbers, so what contacts remember goes on. The tree keeps its branches, and its boxes
//! follow; so it stays right, and good as long as neighbours stay neighbours.
//!
//! Of a mesh that changes in each step, as sheets do, a change moves the corners alone. Facets that a particle is near are made of them when they
//! are needed; leaves and tree are fitted now and then, and their bounds hold to within the way of the corners since.

use std::borrow::Cow;

use glam::DVec3;
use rayon::prelude::*;

use super::super::error::{WallError, finite_vector};
use super::facet::Facet;
use super::{Extent, LANES, Leaf, Mesh, find_patches, has_area, short_sides_first, steady_normals};

/// From so many triangles on a mesh is fitted by all threads of the pool in which it is called, if any.
const LARGE: usize = 4096;
/// Triangles that a thread takes at a time, at least.
const CHUNK: usize = 1024;
/// A mesh that may be fitted late is so when its corners have moved by more than this part of the size of a triangle.
const LATE: f64 = 0.05;

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

    /// Puts the corners to new places (m), one for each of [`Mesh::corners`]. Continuations along periodic axes follow:
    /// the places given for its copies are not read. Returns how far the farthest corner has moved, m: no point of the surface
    /// has moved farther. The result depends on the places alone, not on the way there.
    ///
    /// # Errors
    /// Leaves the mesh as it is if a place is missing or not finite, if a triangle loses its area or turns by more than a right angle
    /// at once, or if a mesh that goes on for ever would no longer be the same at the two faces of its period.
    pub fn reshape(&mut self, places: &[DVec3]) -> Result<f64, WallError> {
        if self.is_fitted_late() {
            return self.move_corners(places);
        }
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

    /// Reshapes the mesh in one go from any earlier shape: triangles may have turned in many steps.
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
        let tolerance = self.precision.tolerance;
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

    /// Whether facets, leaves and tree may be behind the corners.
    fn is_fitted_late(&self) -> bool {
        self.keeps_all && !self.front_only && self.periods().is_empty()
    }

    /// How far corners may have moved since facets, leaves and tree were fitted to them, m.
    #[inline]
    pub(in super::super) fn late(&self) -> f64 {
        self.travelled - self.fitted
    }

    /// A facet where its corners are now.
    #[inline]
    pub(super) fn facet(&self, index: usize) -> Cow<'_, Facet> {
        let facet = &self.facets[index];
        if self.late() == 0.0 {
            return Cow::Borrowed(facet);
        }
        let corners = short_sides_first(lowest_first(facet.vertices), &self.vertices);
        Cow::Owned(moved(facet, corners, &self.vertices))
    }

    /// [`Mesh::reshape`] of the corners alone.
    fn move_corners(&mut self, places: &[DVec3]) -> Result<f64, WallError> {
        if places.len() != self.vertices.len() {
            return Err(WallError::Corners {
                corners: self.vertices.len(),
                given: places.len(),
            });
        }
        if let Some(&place) = places.iter().find(|place| !place.is_finite()) {
            finite_vector("corners", place)?;
        }
        let (before, tolerance) = (&self.vertices, self.precision.tolerance);
        let fault = |(facet, &triangle): (&Facet, &u32)| {
            let corners = facet.vertices.map(|k| places[k as usize]);
            let across = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
            if !has_area(corners, tolerance) {
                return Some(WallError::LostArea { triangle });
            }
            let old = facet.vertices.map(|k| before[k as usize]);
            let is_turned = across(corners).dot(across(old)) <= 0.0;
            is_turned.then_some(WallError::TurnedOver { triangle })
        };
        let fault = if self.is_shared() {
            let facets = self.facets.par_iter().zip(&self.file_order);
            facets.with_min_len(CHUNK).find_map_first(fault)
        } else {
            self.facets.iter().zip(&self.file_order).find_map(fault)
        };
        if let Some(fault) = fault {
            return Err(fault);
        }
        let way = farthest(&self.vertices, places);
        self.vertices.copy_from_slice(places);
        self.travelled += way;
        self.find_extent();
        if self.late() > LATE * self.mean_area.sqrt() {
            self.fit();
        }
        Ok(way)
    }

    /// Facets, leaves and tree of the corners as they are.
    pub(in super::super) fn fit(&mut self) {
        let vertices = &self.vertices;
        let ordered = |facet: &Facet| short_sides_first(lowest_first(facet.vertices), vertices);
        let corners: Vec<[u32; 3]> = self.facets.iter().map(ordered).collect();
        self.refit(&corners);
    }

    /// Takes new places. Returns how far the farthest corner has moved, m.
    fn take(&mut self, new: Placed) -> f64 {
        let moved = farthest(&self.vertices, &new.vertices);
        self.vertices = new.vertices;
        self.travelled += moved;
        self.refit(&new.triangles);
        self.find_extent();
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
            *facet = moved(facet, corners, vertices);
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
        // The corners of a sheet are no numbers of a file, so the normals of its slivers are exact.
        if !self.keeps_all {
            steady_normals(&mut self.facets, &self.topology, self.precision.tolerance);
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
        self.fitted = self.travelled;
    }

    fn find_extent(&mut self) {
        self.extent = Extent::of(&self.vertices, |corner| !self.continuation.is_copy(corner));
        let all = if self.periods().is_empty() {
            self.extent
        } else {
            Extent::of(&self.vertices, |_| true)
        };
        self.round_off = all.round_off(self.precision.largest + self.travelled);
    }

    /// How far corners have moved in all changes together, at most, m.
    pub(super) fn travelled(&self) -> f64 {
        self.travelled
    }
}

/// How far the farthest place is from where it was, m.
fn farthest(old: &[DVec3], new: &[DVec3]) -> f64 {
    let ways = old.iter().zip(new);
    let square = ways.fold(0.0f64, |most, (old, new)| {
        most.max(old.distance_squared(*new))
    });
    square.sqrt()
}

/// A facet with its corners, in this order, where they are now.
fn moved(facet: &Facet, corners: [u32; 3], vertices: &[DVec3]) -> Facet {
    let first = facet.vertices.iter().position(|&k| k == corners[0]);
    let mut edges = facet.edges;
    edges.rotate_left(first.unwrap_or(0));
    Facet::new(vertices, corners, edges)
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
            self.precision,
            self.front_only,
            self.left_out,
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
