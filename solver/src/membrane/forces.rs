//! Forces of a sheet on its vertices, in one pass over its elements and one over its vertices.

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
    /// Inverse of each area, 1/m^2; of sheets with hinges alone.
    inverses: Vec<f64>,
    slots: Vec<DVec3>,
    sums: Vec<Powers>,
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
        let turned_over = self.areas(at, &mut work.areas);
        let inverse = |area: &DVec3| area.length().recip();
        work.inverses.clear();
        if self.stride == 4 {
            work.inverses.extend(work.areas.iter().map(inverse));
        }
        let edges = self.topology.edges();
        let first_of_triangles = self.stride * edges.len();
        let chunks = edges.len().div_ceil(CHUNK);
        // Slots that are never written belong to no vertex.
        let slots = first_of_triangles + 3 * self.triangles.len();
        work.slots.resize(slots, DVec3::ZERO);
        work.sums.clear();
        work.sums.resize(chunks, Powers::default());
        let (of_edges, of_triangles) = work.slots.split_at_mut(first_of_triangles);
        let areas = &work.areas;
        let sides = (areas.as_slice(), work.inverses.as_slice());
        let edge_chunk = |(chunk, (slots, sum)): (usize, (&mut [DVec3], &mut Powers))| {
            *sum = self.edge_forces(chunk * CHUNK, at, sides, slots);
        };
        let triangle_chunk = |(chunk, slots): (usize, &mut [DVec3])| {
            self.triangle_forces(chunk * CHUNK, at, areas, slots);
        };
        let slots_of_edges = CHUNK * self.stride;
        if at.is_parallel {
            let slots = of_edges.par_chunks_mut(slots_of_edges);
            let sums = work.sums.par_iter_mut();
            slots.zip(sums).enumerate().for_each(edge_chunk);
            let slots = of_triangles.par_chunks_mut(3 * CHUNK);
            slots.enumerate().for_each(triangle_chunk);
        } else {
            let slots = of_edges.chunks_mut(slots_of_edges);
            slots.zip(&mut work.sums).enumerate().for_each(edge_chunk);
            let slots = of_triangles.chunks_mut(3 * CHUNK);
            slots.enumerate().for_each(triangle_chunk);
        }
        let slots = &work.slots;
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
        for sum in &work.sums {
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

    /// Normal times area of each triangle, and the first of them that turned over since the evaluation before.
    fn areas(&self, at: &Evaluation<'_>, areas: &mut Vec<DVec3>) -> Option<u32> {
        let triangles = self.topology.triangles();
        areas.resize(triangles.len(), DVec3::ZERO);
        // The least number is the same whatever thread finds it first.
        let turned = AtomicU32::new(NONE);
        let one = |(index, (area, corners)): (usize, (&mut DVec3, &[u32; 3]))| {
            let [a, b, c] = corners.map(|k| at.positions[k as usize]);
            let now = 0.5 * (b - a).cross(c - a);
            if now.dot(*area) < 0.0 {
                turned.fetch_min(index as u32, Ordering::Relaxed);
            }
            *area = now;
        };
        if at.is_parallel {
            let all = areas.par_iter_mut().zip(triangles).enumerate();
            all.with_min_len(CHUNK).for_each(one);
        } else {
            areas.iter_mut().zip(triangles).enumerate().for_each(one);
        }
        Some(turned.into_inner()).filter(|&triangle| triangle != NONE)
    }

    fn edge_forces(
        &self,
        first: usize,
        at: &Evaluation<'_>,
        sides: (&[DVec3], &[f64]),
        slots: &mut [DVec3],
    ) -> Powers {
        let has_springs = self.law.elasticity == Elasticity::Springs;
        let has_dashpots = self.law.damping_ratio > 0.0;
        let mut lost = Powers::default();
        for (offset, slots) in slots.chunks_exact_mut(self.stride).enumerate() {
            let index = first + offset;
            let edge = &self.topology.edges()[index];
            let [a, b] = edge.ends.map(|k| at.positions[k as usize]);
            let rest = &self.edges[index];
            let branch = b - a;
            let length = branch.length();
            let stretch = length / rest.length;
            lost.stretch([stretch, stretch]);
            let mut tension = 0.0;
            if has_springs {
                tension = rest.stiffness * (length - rest.length);
            }
            if has_dashpots {
                let [va, vb] = edge.ends.map(|k| at.velocities[k as usize]);
                let rate = (vb - va).dot(branch) / length;
                let dashpot = at.dashpots[index] * rate;
                tension += dashpot;
                lost.edges += dashpot * rate;
            }
            let force = branch * (tension / length);
            slots[0] = force;
            slots[1] = -force;
            if edge.triangles[1] != NONE && self.stride == 4 {
                lost.hinges += self.hinge_forces((index, length), edge, at, sides, slots);
            }
        }
        lost
    }

    /// Adds the forces of a hinge: on the ends of the edge, then on the corners beside it. Returns what its dashpot loses, W.
    #[inline]
    fn hinge_forces(
        &self,
        (index, length): (usize, f64),
        edge: &Edge,
        at: &Evaluation<'_>,
        (areas, inverses): (&[DVec3], &[f64]),
        slots: &mut [DVec3],
    ) -> f64 {
        let corners = [
            edge.opposite[0],
            edge.opposite[1],
            edge.ends[0],
            edge.ends[1],
        ];
        let [side1, side2] = edge.triangles.map(|triangle| {
            let triangle = triangle as usize;
            (areas[triangle], inverses[triangle])
        });
        let places = corners.map(|k| at.positions[k as usize]);
        let fold = Fold::of_sides(places, length, side1, side2);
        let rest = &self.hinges[index];
        let mut factor = rest.factor * (fold.half_sine - rest.half_sine);
        let damping = self.law.bending.map_or(0.0, |bending| bending.damping);
        let mut lost = 0.0;
        if damping > 0.0 {
            let rate: f64 = (0..4)
                .map(|k| fold.u[k].dot(at.velocities[corners[k] as usize]))
                .sum();
            let dashpot = damping * fold.length * rate;
            factor -= dashpot;
            lost = dashpot * rate;
        }
        slots[0] += factor * fold.u[2];
        slots[1] += factor * fold.u[3];
        slots[2] = factor * fold.u[0];
        slots[3] = factor * fold.u[1];
        lost
    }

    fn triangle_forces(
        &self,
        first: usize,
        at: &Evaluation<'_>,
        areas: &[DVec3],
        slots: &mut [DVec3],
    ) {
        let stiffness = self.law.stiffness();
        for (offset, slots) in slots.chunks_exact_mut(3).enumerate() {
            let index = first + offset;
            let pushed = areas[index] * (at.pressure / 3.0);
            slots.fill(pushed);
            if let Elasticity::Continuum { poisson_ratio } = self.law.elasticity {
                let corners = self.topology.triangles()[index];
                let [a, b, c] = corners.map(|k| at.positions[k as usize]);
                let strained = &self.triangles[index].strained;
                let [on_b, on_c] = strained.forces(b - a, c - a, stiffness, poisson_ratio);
                slots[0] -= on_b + on_c;
                slots[1] += on_b;
                slots[2] += on_c;
            }
        }
    }
}
