//! Forces of a sheet on its vertices: normals of the triangles, then two numbers of each edge, then three forces of each triangle, then their sums.
//!
//! What a hinge exerts on the corners of one of its triangles is along the normal of that triangle. With the moment m = factor (sin(theta/2) -
//! sin(theta0/2)) of the hinge, its edge d and the opposite corner p, the corners p, start and end of the edge get m/|d| times d.d, (p - end).d and
//! -(p - start).d along n/A ([`Fold`]). So a triangle needs one number of each of its hinges, and the sheet three forces of each triangle.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::elements::Fold;
use super::sheet::{Elasticity, Sheet};
use super::topology::{Edge, NONE};

/// Elements, and vertices, that a thread takes at a time. Sums are made within these and then over them, so they do not depend on threads.
const CHUNK: usize = 1024;

/// Memory of the passes; nothing in it outlives an evaluation but the area vectors.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Workspace {
    /// Normal times area of each triangle, m^2, as of the last evaluation.
    pub areas: Vec<DVec3>,
    /// Of each triangle; of sheets with hinges alone.
    faces: Vec<Face>,
    /// Of each edge.
    pulls: Vec<Pull>,
    /// Forces on the three corners of each triangle, N.
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

/// What an edge exerts on each of its triangles.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Pull {
    /// Tension over length, N/m: half of it where there are two triangles.
    tension: f64,
    /// Moment of the hinge over length, N.
    moment: f64,
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
        work.areas.resize(triangles, DVec3::ZERO);
        if self.law.bending.is_some() {
            work.faces.resize(triangles, Face::default());
        }
        work.pulls.resize(edges, Pull::default());
        work.slots.resize(triangles, [DVec3::ZERO; 3]);
        work.sums.clear();
        work.sums.resize(edges.div_ceil(CHUNK), Powers::default());
        let turned_over = self.faces(at, work);
        let Workspace {
            areas,
            faces,
            pulls,
            slots,
            sums,
        } = work;
        let edge_chunk = |(chunk, (pulls, sum)): (usize, (&mut [Pull], &mut Powers))| {
            *sum = self.pulls(chunk * CHUNK, at, faces, pulls);
        };
        if at.is_parallel {
            let pulls = pulls.par_chunks_mut(CHUNK).zip(sums.par_iter_mut());
            pulls.enumerate().for_each(edge_chunk);
        } else {
            let pulls = pulls.chunks_mut(CHUNK).zip(sums.iter_mut());
            pulls.enumerate().for_each(edge_chunk);
        }
        let sides = (areas.as_slice(), faces.as_slice(), pulls.as_slice());
        let triangle_chunk = |(chunk, slots): (usize, &mut [[DVec3; 3]])| {
            self.triangle_forces(chunk * CHUNK, at, sides, slots);
        };
        if at.is_parallel {
            let slots = slots.par_chunks_mut(CHUNK);
            slots.enumerate().for_each(triangle_chunk);
        } else {
            slots.chunks_mut(CHUNK).enumerate().for_each(triangle_chunk);
        }
        let slots = slots.as_flattened();
        let gather = |(chunk, forces): (usize, &mut [DVec3])| {
            for (offset, force) in forces.iter_mut().enumerate() {
                let vertex = chunk * CHUNK + offset;
                let entries =
                    self.gather_start[vertex] as usize..self.gather_start[vertex + 1] as usize;
                let mut sum = DVec3::ZERO;
                for &slot in &self.gathered[entries] {
                    sum += slots[slot as usize];
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
        let triangles = self.topology.triangles();
        // The least number is the same whatever thread finds it first.
        let turned = AtomicU32::new(NONE);
        let new_area = |index: usize, area: &mut DVec3| {
            let [a, b, c] = triangles[index].map(|k| at.positions[k as usize]);
            let now = 0.5 * (b - a).cross(c - a);
            if now.dot(*area) < 0.0 {
                turned.fetch_min(index as u32, Ordering::Relaxed);
            }
            *area = now;
            now
        };
        let new_face = |index: usize, area: &mut DVec3, face: &mut Face| {
            let now = new_area(index, area);
            let inverse = now.length().recip();
            *face = Face {
                normal: now * inverse,
                inverse,
            };
        };
        let (areas, faces) = (&mut work.areas, &mut work.faces);
        let has_hinges = self.law.bending.is_some();
        match (at.is_parallel, has_hinges) {
            (true, true) => {
                let all = areas.par_iter_mut().zip(faces).enumerate();
                let all = all.with_min_len(CHUNK);
                all.for_each(|(index, (area, face))| new_face(index, area, face));
            }
            (true, false) => {
                let all = areas.par_iter_mut().enumerate().with_min_len(CHUNK);
                all.for_each(|(index, area)| {
                    new_area(index, area);
                });
            }
            (false, true) => {
                for (index, (area, face)) in areas.iter_mut().zip(faces).enumerate() {
                    new_face(index, area, face);
                }
            }
            (false, false) => {
                for (index, area) in areas.iter_mut().enumerate() {
                    new_area(index, area);
                }
            }
        }
        Some(turned.into_inner()).filter(|&triangle| triangle != NONE)
    }

    /// What edges exert, from the edge `first` on.
    fn pulls(
        &self,
        first: usize,
        at: &Evaluation<'_>,
        faces: &[Face],
        pulls: &mut [Pull],
    ) -> Powers {
        let has_springs = self.law.elasticity == Elasticity::Springs;
        let has_dashpots = self.law.damping_ratio > 0.0;
        let damping = self.law.bending.map_or(0.0, |bending| bending.damping);
        let mut lost = Powers::default();
        let edges = &self.topology.edges()[first..];
        for (offset, (pull, edge)) in pulls.iter_mut().zip(edges).enumerate() {
            let index = first + offset;
            let [a, b] = edge.ends.map(|k| at.positions[k as usize]);
            let rest = &self.edges[index];
            let branch = b - a;
            let length = branch.length();
            let inverse = length.recip();
            let stretch = length / rest.length;
            lost.stretch([stretch, stretch]);
            let mut tension = 0.0;
            if has_springs {
                tension = rest.stiffness * (length - rest.length);
            }
            if has_dashpots {
                let [va, vb] = edge.ends.map(|k| at.velocities[k as usize]);
                let rate = (vb - va).dot(branch) * inverse;
                let dashpot = at.dashpots[index] * rate;
                tension += dashpot;
                lost.edges += dashpot * rate;
            }
            tension *= inverse;
            if edge.triangles[1] == NONE {
                *pull = Pull {
                    tension,
                    moment: 0.0,
                };
                continue;
            }
            let mut moment = 0.0;
            if let Some(hinge) = self.hinges.get(index) {
                let [one, other] = edge.triangles.map(|triangle| &faces[triangle as usize]);
                let half_sine = Fold::half_sine(one.normal, other.normal, branch);
                moment = hinge.factor * (half_sine - hinge.half_sine);
                if damping > 0.0 {
                    let rate = self.hinge_rate(edge, length, at, [one, other]);
                    let dashpot = damping * length * rate;
                    moment -= dashpot;
                    lost.hinges += dashpot * rate;
                }
            }
            *pull = Pull {
                tension: 0.5 * tension,
                moment: moment * inverse,
            };
        }
        lost
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

    fn triangle_forces(
        &self,
        first: usize,
        at: &Evaluation<'_>,
        (areas, faces, pulls): (&[DVec3], &[Face], &[Pull]),
        slots: &mut [[DVec3; 3]],
    ) {
        let stiffness = self.law.stiffness();
        let has_hinges = self.law.bending.is_some();
        for (offset, slots) in slots.iter_mut().enumerate() {
            let index = first + offset;
            let corners = self.topology.triangles()[index];
            let [a, b, c] = corners.map(|k| at.positions[k as usize]);
            let [ab, bc, ca] = [b - a, c - b, a - c];
            let [pull_ab, pull_bc, pull_ca] = self.edges_of[index].map(|edge| pulls[edge as usize]);
            let [on_a, on_b, on_c] = [
                ab * pull_ab.tension,
                bc * pull_bc.tension,
                ca * pull_ca.tension,
            ];
            let [mut force_a, mut force_b, mut force_c] = [on_a - on_c, on_b - on_a, on_c - on_b];
            if at.pressure != 0.0 {
                let pushed = areas[index] * (at.pressure / 3.0);
                force_a += pushed;
                force_b += pushed;
                force_c += pushed;
            }
            if has_hinges {
                let [at_a, at_b, at_c] = [ca.dot(ab), ab.dot(bc), bc.dot(ca)];
                let [q_ab, q_bc, q_ca] = [pull_ab.moment, pull_bc.moment, pull_ca.moment];
                let face = &faces[index];
                let over = face.normal * face.inverse;
                force_a += over * (q_bc * bc.length_squared() + q_ab * at_b + q_ca * at_c);
                force_b += over * (q_ca * ca.length_squared() + q_ab * at_a + q_bc * at_c);
                force_c += over * (q_ab * ab.length_squared() + q_bc * at_b + q_ca * at_a);
            }
            if let Elasticity::Continuum { poisson_ratio } = self.law.elasticity {
                let strained = &self.triangles[index].strained;
                let [on_b, on_c] = strained.forces(ab, -ca, stiffness, poisson_ratio);
                force_a -= on_b + on_c;
                force_b += on_b;
                force_c += on_c;
            }
            *slots = [force_a, force_b, force_c];
        }
    }
}
