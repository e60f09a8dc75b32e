//! Sheets: surfaces of triangles whose vertices have mass and move by forces.
//!
//! A [`Surface`] owns the state of its vertices. The engine lets a mesh wall borrow its shape, so that lists, candidates, patches,
//! histories and periodic images are those of mesh walls. The load of contacts on a triangle arrives at its vertices.
//!
//! In a step the contacts are evaluated first; [`Surface::loads`] and [`Surface::forces`] are then what they do to each vertex. Further forces
//! are added to [`Surface::forces`]. In the next step they kick the vertices, and the mesh follows.

mod place;
mod plan;
mod saved;
#[cfg(test)]
pub(crate) mod tests;

use std::sync::Arc;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use rayon::prelude::*;

pub use place::{SurfaceLoad, SurfacePoint};
pub use plan::{Faces, SurfacePlan};
pub use saved::SavedSurface;

use crate::walls::{LeftOut, Mesh, Motion, Shape, Wall, WallError};

/// From so many vertices on threads share them, if there are several.
pub const LARGE: usize = 2048;
/// Vertices that a thread takes at a time.
pub const CHUNK: usize = 1024;

/// A sheet as it is now.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Positions of the vertices, m, in the order of the file.
    pub positions: Vec<DVec3>,
    /// Their velocities, m/s, as those of particles: while forces are evaluated those of half a step before the positions, after
    /// `Engine::complete_step` those of the same time.
    pub velocities: Vec<DVec3>,
    /// Over their masses, 1/kg; 0 of those that are held, which move with their velocity whatever acts on them.
    pub inverse_masses: Vec<f64>,
    /// Forces of particles and walls on them in the present step, N.
    pub loads: Vec<DVec3>,
    /// Forces of particles on each triangle in the present step, N. A contact with an edge or corner counts for the triangle of
    /// the lowest number there.
    pub triangle_loads: Vec<DVec3>,
    /// Whether anything acts on it in the present step: else the loads are zeros.
    pub is_loaded: bool,
    /// All forces on the vertices but gravity in the present step, N.
    pub forces: Vec<DVec3>,
    /// Largest v^2 of a vertex when they were last kicked, m^2/s^2.
    pub squared_speed: f64,
    /// Distance beyond that of particles that it may go before the candidate list is built anew, m: nothing is near.
    pub room: f64,
    plan: Arc<SurfacePlan>,
    /// Positions when the candidate list was built, m.
    listed: Vec<DVec3>,
    /// The vertex at each corner of the mesh.
    vertex_of: Vec<u32>,
    /// The triangle that takes what acts on each feature of the mesh.
    taker_of: Vec<u32>,
}

impl Surface {
    /// At rest as planned, and the wall that borrows its shape.
    ///
    /// # Errors
    /// If a triangle has no area, or names a vertex that is not there.
    pub fn new(plan: &Arc<SurfacePlan>) -> Result<(Self, Wall), WallError> {
        let count = plan.vertices.len();
        let is_vertex = |&k: &u32| (k as usize) < count;
        if !plan.triangles.iter().flatten().all(is_vertex) || plan.masses.len() != count {
            return Err(WallError::OtherShape);
        }
        let triangles = TriangleMesh {
            vertices: plan.vertices.clone(),
            triangles: plan.triangles.clone(),
            ..TriangleMesh::default()
        };
        let mesh = Mesh::new(&triangles, |x| x, plan.faces == Faces::Front)?.keeping_all();
        let left_out = mesh.left_out();
        if left_out != LeftOut::default() {
            return Err(WallError::NoTriangle {
                count: left_out.thin + left_out.far,
                precision: mesh.precision(),
            });
        }
        let zeros = vec![DVec3::ZERO; count];
        let surface = Self {
            positions: plan.vertices.clone(),
            velocities: zeros.clone(),
            inverse_masses: plan.masses.iter().map(|mass| mass.recip()).collect(),
            loads: zeros.clone(),
            triangle_loads: vec![DVec3::ZERO; plan.triangles.len()],
            is_loaded: false,
            forces: zeros,
            squared_speed: 0.0,
            room: 0.0,
            plan: Arc::clone(plan),
            listed: plan.vertices.clone(),
            vertex_of: mesh.vertex_numbers(&plan.vertices, &plan.triangles),
            taker_of: mesh.lowest_triangles(),
        };
        let wall = Wall {
            name: plan.name.clone(),
            material: plan.material,
            shape: Shape::Mesh(Arc::new(mesh)),
            motion: Motion::default(),
            from: f64::NEG_INFINITY,
            until: f64::INFINITY,
            reference: DVec3::ZERO,
        };
        Ok((surface, wall))
    }

    /// Memory of a sheet of a plan, its plan and the mesh that borrows its shape, bytes: for estimates.
    #[must_use]
    pub fn bytes_of(plan: &SurfacePlan) -> f64 {
        let (vertices, triangles) = (plan.vertices.len(), plan.triangles.len());
        // Of the plan a place and a mass; positions, velocities, loads, forces, positions when listed, inverse mass, number.
        let of_vertices =
            vertices * (6 * size_of::<DVec3>() + 2 * size_of::<f64>() + size_of::<u32>());
        // Corners; loads, and the takers of its feature, of half as many corners and 3/2 as many edges.
        let of_triangles =
            triangles * (size_of::<[u32; 3]>() + size_of::<DVec3>() + 3 * size_of::<u32>());
        (of_vertices + of_triangles) as f64 + Mesh::bytes_of(triangles)
    }

    /// Its plan.
    #[must_use]
    pub fn plan(&self) -> &SurfacePlan {
        &self.plan
    }

    /// Vertices of each triangle, in the order of the file.
    #[inline]
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.plan.triangles
    }

    /// Change of the velocity of a vertex by the present forces and `gravity` (m/s^2) in `time` (s), m/s.
    #[inline]
    #[must_use]
    pub fn kick(&self, vertex: usize, time: f64, gravity: DVec3) -> DVec3 {
        let inverse_mass = self.inverse_masses[vertex];
        if inverse_mass == 0.0 {
            return DVec3::ZERO;
        }
        (self.forces[vertex] * inverse_mass + gravity) * time
    }

    /// The vertex at a corner of the mesh.
    #[inline]
    #[must_use]
    pub fn vertex_at(&self, corner: u32) -> usize {
        self.vertex_of[corner as usize] as usize
    }

    /// Positions of the corners of the mesh, m.
    #[must_use]
    pub fn corners(&self) -> Vec<DVec3> {
        let vertices = self.vertex_of.iter();
        vertices.map(|&k| self.positions[k as usize]).collect()
    }

    /// How far a point of it is at most from where it was when the candidate list was built, m.
    #[must_use]
    pub fn way_since_listed(&self) -> f64 {
        let most = |(now, then): (&[DVec3], &[DVec3])| {
            let ways = now.iter().zip(then);
            ways.fold(0.0f64, |most, (now, then)| {
                most.max(now.distance_squared(*then))
            })
        };
        // The largest is the same whatever threads find.
        let square = if self.positions.len() >= LARGE && rayon::current_thread_index().is_some() {
            let chunks = self.positions.par_chunks(CHUNK);
            let ways = chunks.zip(self.listed.par_chunks(CHUNK)).map(most);
            ways.reduce(|| 0.0, f64::max)
        } else {
            most((&self.positions, &self.listed))
        };
        square.sqrt()
    }

    /// The candidate list is built with the sheet as it is now.
    pub fn note_listed(&mut self) {
        self.listed.clone_from(&self.positions);
    }

    /// Forgets what acted in the step before.
    pub fn clear_loads(&mut self) {
        if self.is_loaded {
            self.loads.fill(DVec3::ZERO);
            self.triangle_loads.fill(DVec3::ZERO);
            self.is_loaded = false;
        }
    }

    /// Adds what walls do to the vertices, in their order, N.
    pub fn add_vertex_loads(&mut self, loads: impl Iterator<Item = DVec3>) {
        for (sum, load) in self.loads.iter_mut().zip(loads) {
            *sum += load;
            self.is_loaded = true;
        }
    }

    /// Adds what a contact does.
    pub fn add_load(&mut self, load: &SurfaceLoad) {
        self.is_loaded = true;
        for (&corner, share) in self.plan.triangles[load.triangle as usize]
            .iter()
            .zip(load.shares)
        {
            self.loads[corner as usize] += share;
            self.triangle_loads[load.triangle as usize] += share;
        }
    }
}
