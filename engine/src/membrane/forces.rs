//! Forces of a sheet on its vertices: normals of the triangles, then two numbers of each edge, then what is along the normals of the triangles, and the
//! sums of all that at each vertex.
//!
//! What a hinge exerts on the corners of one of its triangles is along the normal of that triangle. With the moment m = factor (sin(theta/2) -
//! sin(theta0/2)) of the hinge, its edge d and the opposite corner p, the corners p, start and end of the edge get m/|d| times d.d, (p - end).d and
//! -(p - start).d along n/A ([`Fold`]). So a triangle needs one number of each of its hinges.
//!
//! Roots and divisions of edges are made batch by batch, in loops without branches that the compiler turns into instructions for several numbers.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::elements::Fold;
use super::sheet::{Elasticity, Sheet};
use super::topology::{Edge, NONE};

/// Elements, and vertices, that a thread takes at a time. Sums are made within these and then over them, so they do not depend on threads.
const CHUNK: usize = 1024;
/// Edges whose roots and divisions are made together.
const BATCH: usize = 32;

/// Memory of the passes; nothing in it outlives an evaluation but the area vectors.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Workspace {
    /// Normal times area of each triangle, m^2, as of the last evaluation.
    pub areas: Vec<DVec3>,
    /// Of each triangle; of sheets with hinges alone.
    faces: Vec<Face>,
    /// Tension of each edge over its length, N/m.
    tensions: Vec<f64>,
    /// Moment of each hinge over the length of its edge, N; of sheets with hinges alone.
    moments: Vec<f64>,
    /// Forces on the three corners of each triangle, N; of sheets in which there are others than those along edges.
    slots: Vec<[DVec3; 3]>,
    sums: Vec<Powers>,
}

/// A triangle where it is now.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Face {
    normal: DVec3,
    /// Over its area, 1/m^2.
    inverse: f64,
}

/// Results of an evaluation beside the forces: the loss of the dashpots, and the stretch of the edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Powers {
    /// Of dashpots along edges, W.
    pub edges: f64,
    /// Of dashpots of hinges, W.
    pub hinges: f64,
    /// Least and largest length of an edge over its length without force; not numbers where a vertex has no place.
    pub stretches: [f64; 2],
    /// The first triangle whose normal turned by more than a right angle since the evaluation before.
    pub turned_over: Option<u32>,
}

impl Default for Powers {
    fn default() -> Self {
        Self {
            edges: 0.0,
            hinges: 0.0,
            stretches: [f64::INFINITY, f64::NEG_INFINITY],
            turned_over: None,
        }
    }
}

impl Powers {
    fn stretch(&mut self, [least, largest]: [f64; 2]) {
        let [own_least, own_largest] = &mut self.stretches;
        // What is no number stays: comparisons with it are false.
        if least < *own_least || least.is_nan() {
            *own_least = least;
        }
        if largest > *own_largest || largest.is_nan() {
            *own_largest = largest;
        }
    }
}

/// So many slices of a chunk each; of what is not there empty ones.
fn slices<T>(all: &mut [T], count: usize) -> Vec<&mut [T]> {
    let mut slices: Vec<&mut [T]> = all.chunks_mut(CHUNK).collect();
    slices.resize_with(count, Default::default);
    slices
}

/// What a batch of edges has.
struct Batch {
    /// From the first to the second end, m: its components.
    branch: [[f64; BATCH]; 3],
    /// m
    length: [f64; BATCH],
    /// 1/m
    inverse: [f64; BATCH],
    /// Length over that without force.
    stretch: [f64; BATCH],
    /// N
    tension: [f64; BATCH],
}

impl Batch {
    const ONE: Self = Self {
        branch: [[1.0; BATCH]; 3],
        length: [1.0; BATCH],
        inverse: [1.0; BATCH],
        stretch: [1.0; BATCH],
        tension: [0.0; BATCH],
    };

    fn branch(&self, k: usize) -> DVec3 {
        let [x, y, z] = &self.branch;
        DVec3::new(x[k], y[k], z[k])
    }
}

/// Positions and velocities of the vertices, and what acts on them.
#[derive(Debug, Clone, Copy)]
pub struct Evaluation<'a> {
    /// In m.
    pub positions: &'a [DVec3],
    /// In m/s.
    pub velocities: &'a [DVec3],
    /// Of [`Sheet::dashpots`].
    pub dashpots: &'a [f64],
    /// Pressure on the back of the triangles, Pa: it pushes along the normals.
    pub pressure: f64,
    /// Whether chunks are shared among the threads of the present pool.
    pub is_parallel: bool,
}

impl Sheet {
    /// Writes the forces of stretching, bending, their dashpots and the pressure on each vertex into `forces`, N. Returns what dashpots lose.
    pub fn forces(
        &self,
        at: &Evaluation<'_>,
        work: &mut Workspace,
        forces: &mut [DVec3],
    ) -> Powers {
        let (triangles, edges) = (self.triangles.len(), self.topology.edges().len());
        let has_hinges = self.law.bending.is_some();
        let is_continuum = self.law.elasticity != Elasticity::Springs;
        let has_slots = has_hinges || is_continuum || at.pressure != 0.0;
        work.areas.resize(triangles, DVec3::ZERO);
        if has_hinges {
            work.faces.resize(triangles, Face::default());
            work.moments.resize(edges, 0.0);
        }
        if has_slots {
            work.slots.resize(triangles, [DVec3::ZERO; 3]);
        }
        work.tensions.resize(edges, 0.0);
        work.sums.clear();
        work.sums.resize(edges.div_ceil(CHUNK), Powers::default());
        let turned_over = self.faces(at, work);
        let Workspace {
            areas,
            faces,
            tensions,
            moments,
            slots,
            sums,
        } = work;
        let faces = faces.as_slice();
        let edge_chunk =
            |chunk: usize, tensions: &mut [f64], moments: &mut [f64], sum: &mut Powers| {
                *sum = self.pulls(chunk * CHUNK, at, faces, tensions, moments);
            };
        let moment_chunks = slices(moments, sums.len());
        if at.is_parallel {
            let chunks = tensions.par_chunks_mut(CHUNK).zip(moment_chunks);
            let chunks = chunks.zip(sums.par_iter_mut()).enumerate();
            chunks.for_each(|(chunk, ((tensions, moments), sum))| {
                edge_chunk(chunk, tensions, moments, sum);
            });
        } else {
            let chunks = tensions.chunks_mut(CHUNK).zip(moment_chunks);
            for (chunk, ((tensions, moments), sum)) in chunks.zip(sums.iter_mut()).enumerate() {
                edge_chunk(chunk, tensions, moments, sum);
            }
        }
        let sides = (areas.as_slice(), faces, moments.as_slice());
        let triangle_chunk = |(chunk, slots): (usize, &mut [[DVec3; 3]])| {
            self.triangle_forces(chunk * CHUNK, at, sides, slots);
        };
        if has_slots && at.is_parallel {
            let slots = slots.par_chunks_mut(CHUNK);
            slots.enumerate().for_each(triangle_chunk);
        } else if has_slots {
            slots.chunks_mut(CHUNK).enumerate().for_each(triangle_chunk);
        }
        let slots = if has_slots { slots.as_flattened() } else { &[] };
        let has_tensions = !is_continuum || self.law.damping_ratio > 0.0;
        let gather = |(chunk, forces): (usize, &mut [DVec3])| {
            for (offset, force) in forces.iter_mut().enumerate() {
                let vertex = chunk * CHUNK + offset;
                let mut sum = DVec3::ZERO;
                if has_tensions {
                    let own = at.positions[vertex];
                    for &[edge, other] in self.edges_at(vertex) {
                        sum += (at.positions[other as usize] - own) * tensions[edge as usize];
                    }
                }
                if has_slots {
                    for &slot in self.corners_at(vertex) {
                        sum += slots[slot as usize];
                    }
                }
                *force = sum;
            }
        };
        if at.is_parallel {
            forces.par_chunks_mut(CHUNK).enumerate().for_each(gather);
        } else {
            forces.chunks_mut(CHUNK).enumerate().for_each(gather);
        }
        let mut powers = Powers {
            turned_over,
            ..Powers::default()
        };
        for sum in sums {
            powers.edges += sum.edges;
            powers.hinges += sum.hinges;
            powers.stretch(sum.stretches);
        }
        powers
    }

    /// Normal times area of each triangle, m^2.
    pub fn area_vectors(&self, positions: &[DVec3], areas: &mut Vec<DVec3>) {
        let triangles = self.topology.triangles().iter();
        areas.clear();
        areas.extend(triangles.map(|corners| {
            let [a, b, c] = corners.map(|k| positions[k as usize]);
            0.5 * (b - a).cross(c - a)
        }));
    }

    /// Normals and areas of the triangles, and the first of them that turned over since the evaluation before.
    fn faces(&self, at: &Evaluation<'_>, work: &mut Workspace) -> Option<u32> {
        // The least number is the same whatever thread finds it first.
        let turned = AtomicU32::new(NONE);
        let chunk = |chunk: usize, areas: &mut [DVec3], faces: &mut [Face]| {
            let first = self.faces_from(chunk * CHUNK, at.positions, areas, faces);
            turned.fetch_min(first, Ordering::Relaxed);
        };
        let areas = &mut work.areas;
        let faces = slices(&mut work.faces, areas.len().div_ceil(CHUNK));
        if at.is_parallel {
            let chunks = areas.par_chunks_mut(CHUNK).zip(faces).enumerate();
            chunks.for_each(|(number, (areas, faces))| chunk(number, areas, faces));
        } else {
            let chunks = areas.chunks_mut(CHUNK).zip(faces).enumerate();
            chunks.for_each(|(number, (areas, faces))| chunk(number, areas, faces));
        }
        Some(turned.into_inner()).filter(|&triangle| triangle != NONE)
    }

    /// The same from the triangle `first` on; `faces`: all of them or none.
    fn faces_from(
        &self,
        first: usize,
        positions: &[DVec3],
        areas: &mut [DVec3],
        faces: &mut [Face],
    ) -> u32 {
        let mut turned = NONE;
        let mut inverses = [1.0; BATCH];
        let mut faces = faces.chunks_mut(BATCH);
        for (batch, areas) in areas.chunks_mut(BATCH).enumerate() {
            let begin = first + batch * BATCH;
            let triangles = &self.topology.triangles()[begin..begin + areas.len()];
            for (k, (area, corners)) in areas.iter_mut().zip(triangles).enumerate() {
                let [a, b, c] = corners.map(|k| positions[k as usize]);
                let now = 0.5 * (b - a).cross(c - a);
                if now.dot(*area) < 0.0 {
                    turned = turned.min((begin + k) as u32);
                }
                *area = now;
                inverses[k] = now.length_squared();
            }
            let Some(faces) = faces.next() else { continue };
            for inverse in &mut inverses {
                *inverse = 1.0 / inverse.sqrt();
            }
            for (face, (area, inverse)) in faces.iter_mut().zip(areas.iter().zip(inverses)) {
                *face = Face {
                    normal: *area * inverse,
                    inverse,
                };
            }
        }
        turned
    }

    /// Tensions over lengths and moments over lengths, from the edge `first` on.
    fn pulls(
        &self,
        first: usize,
        at: &Evaluation<'_>,
        faces: &[Face],
        tensions: &mut [f64],
        moments: &mut [f64],
    ) -> Powers {
        let mut lost = Powers::default();
        let mut batch = Batch::ONE;
        let hinges_end = self.hinges.len().saturating_sub(first).min(moments.len());
        for begin in (0..tensions.len()).step_by(BATCH) {
            let end = tensions.len().min(begin + BATCH);
            self.stretch_batch(first + begin..first + end, at, &mut batch, &mut lost);
            for (k, tension) in tensions[begin..end].iter_mut().enumerate() {
                *tension = batch.tension[k] * batch.inverse[k];
            }
            if begin < hinges_end {
                let moments = &mut moments[begin..end.min(hinges_end)];
                self.bend_batch(first + begin, at, faces, &batch, moments, &mut lost);
            }
        }
        lost
    }

    /// Lengths and tensions of some edges, at most as many as a batch has.
    #[inline]
    fn stretch_batch(
        &self,
        edges: Range<usize>,
        at: &Evaluation<'_>,
        batch: &mut Batch,
        lost: &mut Powers,
    ) {
        let count = edges.len();
        let rest = &self.rest;
        let ends = &self.ends[edges.clone()];
        for (k, ends) in ends.iter().enumerate() {
            let [a, b] = ends.map(|k| at.positions[k as usize]);
            let branch = b - a;
            batch.branch[0][k] = branch.x;
            batch.branch[1][k] = branch.y;
            batch.branch[2][k] = branch.z;
        }
        let [x, y, z] = &batch.branch;
        let squares = x.iter().zip(y).zip(z);
        let squares = squares.map(|((x, y), z)| x * x + y * y + z * z);
        for (length, square) in batch.length.iter_mut().zip(squares) {
            *length = square.sqrt();
        }
        for (inverse, length) in batch.inverse.iter_mut().zip(&batch.length) {
            *inverse = length.recip();
        }
        let over = &rest.inverse[edges.clone()];
        let (mut least, mut largest, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for (stretch, (length, over)) in batch.stretch.iter_mut().zip(batch.length.iter().zip(over))
        {
            *stretch = length * over;
        }
        for &stretch in &batch.stretch[..count] {
            least = least.min(stretch);
            largest = largest.max(stretch);
            sum += stretch;
        }
        // These leave out what is no number, the sum does not.
        if sum.is_nan() {
            (least, largest) = (f64::NAN, f64::NAN);
        }
        lost.stretch([least, largest]);
        if self.law.elasticity == Elasticity::Springs {
            let (stiffness, length) = (&rest.stiffness[edges.clone()], &rest.length[edges.clone()]);
            let lengths = batch.length.iter().zip(stiffness.iter().zip(length));
            for (tension, (now, (stiffness, length))) in batch.tension.iter_mut().zip(lengths) {
                *tension = stiffness * (now - length);
            }
        } else {
            batch.tension = [0.0; BATCH];
        }
        if self.law.damping_ratio > 0.0 {
            let dashpots = &at.dashpots[edges];
            for (k, (ends, dashpot)) in ends.iter().zip(dashpots).enumerate() {
                let [va, vb] = ends.map(|k| at.velocities[k as usize]);
                let rate = (vb - va).dot(batch.branch(k)) * batch.inverse[k];
                let pull = dashpot * rate;
                batch.tension[k] += pull;
                lost.edges += pull * rate;
            }
        }
    }

    /// Moments over lengths of some hinges.
    #[inline]
    fn bend_batch(
        &self,
        first: usize,
        at: &Evaluation<'_>,
        faces: &[Face],
        batch: &Batch,
        moments: &mut [f64],
        lost: &mut Powers,
    ) {
        let damping = self.law.bending.map_or(0.0, |bending| bending.damping);
        let hinges = &self.hinges[first..first + moments.len()];
        let edges = &self.topology.edges()[first..first + moments.len()];
        let (mut halves, mut signs) = ([0.0; BATCH], [0.0; BATCH]);
        for (k, edge) in edges.iter().enumerate() {
            let [one, other] = edge
                .triangles
                .map(|triangle| faces[triangle as usize].normal);
            halves[k] = (one - other).length_squared();
            signs[k] = one.cross(other).dot(batch.branch(k));
        }
        for (half, sign) in halves.iter_mut().zip(signs) {
            // The sine of half the angle.
            *half = (0.5 * half.sqrt()).copysign(sign);
        }
        for (k, (moment, hinge)) in moments.iter_mut().zip(hinges).enumerate() {
            *moment = hinge.factor * (halves[k] - hinge.half_sine) * batch.inverse[k];
        }
        if damping > 0.0 {
            for (k, (moment, edge)) in moments.iter_mut().zip(edges).enumerate() {
                let sides = edge.triangles.map(|triangle| &faces[triangle as usize]);
                let rate = self.hinge_rate(edge, batch.length[k], at, sides);
                let dashpot = damping * batch.length[k] * rate;
                *moment -= dashpot * batch.inverse[k];
                lost.hinges += dashpot * rate;
            }
        }
    }

    /// Sum of u . v over the corners of a hinge, 1/s: minus twice the rate of its angle.
    fn hinge_rate(&self, edge: &Edge, length: f64, at: &Evaluation<'_>, sides: [&Face; 2]) -> f64 {
        let corners = [
            edge.opposite[0],
            edge.opposite[1],
            edge.ends[0],
            edge.ends[1],
        ];
        let places = corners.map(|k| at.positions[k as usize]);
        let [one, other] = sides.map(|face| (face.normal, face.inverse));
        let u = Fold::slopes(places, length, one, other);
        let velocities = corners.map(|k| at.velocities[k as usize]);
        u.into_iter().zip(velocities).map(|(u, v)| u.dot(v)).sum()
    }

    /// What is along the normals of the triangles, and the forces of the continuum.
    fn triangle_forces(
        &self,
        first: usize,
        at: &Evaluation<'_>,
        (areas, faces, moments): (&[DVec3], &[Face], &[f64]),
        slots: &mut [[DVec3; 3]],
    ) {
        let stiffness = self.law.stiffness();
        let has_hinges = self.law.bending.is_some();
        for (offset, slots) in slots.iter_mut().enumerate() {
            let index = first + offset;
            let corners = self.topology.triangles()[index];
            let [a, b, c] = corners.map(|k| at.positions[k as usize]);
            let [ab, bc, ca] = [b - a, c - b, a - c];
            let mut forces = [areas[index] * (at.pressure / 3.0); 3];
            if has_hinges {
                let [at_a, at_b, at_c] = [ca.dot(ab), ab.dot(bc), bc.dot(ca)];
                let [of_ab, of_bc, of_ca] = self.edges_of[index].map(|edge| moments[edge as usize]);
                let face = &faces[index];
                let over = face.normal * face.inverse;
                forces[0] += over * (of_bc * bc.length_squared() + of_ab * at_b + of_ca * at_c);
                forces[1] += over * (of_ca * ca.length_squared() + of_ab * at_a + of_bc * at_c);
                forces[2] += over * (of_ab * ab.length_squared() + of_bc * at_b + of_ca * at_a);
            }
            if let Elasticity::Continuum { poisson_ratio } = self.law.elasticity {
                let strained = &self.triangles[index].strained;
                let [on_b, on_c] = strained.forces(ab, -ca, stiffness, poisson_ratio);
                forces[0] -= on_b + on_c;
                forces[1] += on_b;
                forces[2] += on_c;
            }
            *slots = forces;
        }
    }
}
