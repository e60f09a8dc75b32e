//! Forces of a sheet on its vertices: areas of the triangles, then two numbers of each edge, then one of each corner of a triangle, and the sums of
//! all that at each vertex.
//!
//! All that is inside a sheet is a tension along each edge and, at the corners of each triangle, a force along its normal. The law of the continuum
//! is no exception: three forces in a plane without sum and torque are tensions along the three sides ([`Strained::tensions`]).
//!
//! Forces of a hinge on the corners of one of its triangles are along the normal of that triangle. With the moment m = factor
//! (sin(theta/2) - sin(theta0/2)) of the hinge, its edge d and the opposite corner p, the corners p, start and end of the edge
//! get m/|d| times d.d, (p - end).d and -(p - start).d along n/A. So a triangle needs one number of each of its hinges. The rate
//! of the angle has the same three factors ([`Sides`]).
//!
//! The passes over edges and triangles are made in lanes. Chunks are shared among threads. Neither changes a bit. No closure here computes in lanes:
//! one that is not inlined would be compiled for a processor without them, and be several times as slow.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;

use super::elements::{Sides, Strained};
use super::sheet::{Elasticity, RestTriangle, Sheet};
use super::topology::NONE;
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Task, Vector, Width};
use crate::parallel::each_part;

/// Elements, and vertices, that a thread takes at a time. Sums are made within these and then over them, so they do not depend on threads.
const CHUNK: usize = 1024;

/// Memory of the passes; nothing in it outlives an evaluation but the areas.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Workspace {
    /// Normal times area of each triangle, m^2, as of the last evaluation, and behind it, of sheets with hinges, the inverse of
    /// the area, 1/m^2.
    faces: Vec<Quad>,
    /// Positions of the vertices, m.
    places: Vec<Quad>,
    /// Their velocities, m/s; of sheets with dashpots alone.
    speeds: Vec<Quad>,
    /// Tensions of the sides of each triangle over their lengths, N/m, and zeros behind the last one; of the continuum alone.
    sides: Vec<Quad>,
    /// Contributions of the velocities of each triangle's corners to the rates of its three hinges, times the lengths of their
    /// edges, m/s; of sheets with damped hinges alone.
    rates: Vec<Quad>,
    /// Tension of each edge over its length, N/m.
    tensions: Vec<f64>,
    /// Moment of each hinge over the length of its edge, N; of sheets with hinges alone.
    moments: Vec<f64>,
    /// Forces on the three corners of each triangle over normal times area, N/m^2; of sheets with hinges or pressure alone.
    along: Vec<Quad>,
    sums: Vec<Powers>,
}

impl Workspace {
    /// Memory of that of a sheet, bytes: for estimates.
    pub(super) fn bytes_of(sheet: &Sheet, has_pressure: bool) -> f64 {
        let (triangles, vertices) = (sheet.triangles.len(), sheet.masses().len());
        let edges = sheet.topology.edges().len();
        let has_hinges = sheet.law.bending.is_some();
        let [has_dashpots, has_damped_hinges] = sheet.has_dashpots();
        let is_continuum = sheet.law.elasticity != Elasticity::Springs;
        let times = |is_there: bool, count: usize| count * usize::from(is_there);
        let of_triangles = [is_continuum, has_damped_hinges, has_hinges || has_pressure];
        let quads = of_triangles.map(|is_there| times(is_there, triangles));
        let quads = triangles
            + vertices
            + times(has_dashpots || has_damped_hinges, vertices)
            + quads.iter().sum::<usize>();
        let numbers = edges + times(has_hinges, edges);
        (quads * size_of::<Quad>() + numbers * size_of::<f64>()) as f64
    }

    /// Normal times area of the triangles from `first` on, m^2, as of the last evaluation.
    pub fn areas(&self, first: usize) -> impl Iterator<Item = DVec3> + '_ {
        self.faces[first..].iter().map(|&face| face.into())
    }
}

/// Results of an evaluation beside the forces: the loss of the dashpots, and the stretch of the edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Powers {
    /// Power of dashpots along edges, W.
    pub edges: f64,
    /// Power of dashpots of hinges, W.
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
        // A value that is not a number stays: comparisons with it are false.
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
    /// Coefficients of [`Sheet::dashpots`].
    pub dashpots: &'a [f64],
    /// Pressure on the back of the triangles, Pa: it pushes along the normals.
    pub pressure: f64,
    /// Whether chunks are shared among the threads of the present pool.
    pub is_parallel: bool,
    /// Lanes in which edges and triangles are taken.
    pub width: Width,
}

/// Slices of a chunk each, and behind them empty ones without end: of numbers that a sheet does not have.
fn slices<T>(all: &mut [T]) -> impl Iterator<Item = &mut [T]> {
    let none = std::iter::repeat_with(Default::default);
    all.chunks_mut(CHUNK).chain(none)
}

/// Something to do for each of some elements, several of them at a time.
trait InLanes {
    /// For the elements from `at` on, as many as there are lanes.
    fn group<L: Real>(&mut self, at: usize);
}

/// All elements below `count`: in lanes, and what is left one by one.
#[inline(always)]
fn all_groups<L: Real>(work: &mut impl InLanes, count: usize) {
    let whole = count - count % L::LANES;
    for at in (0..whole).step_by(L::LANES) {
        work.group::<L>(at);
    }
    for at in whole..count {
        work.group::<f64>(at);
    }
}

/// Numbers of many elements in four columns, so that what becomes of them does not depend on the number of lanes.
#[derive(Debug, Clone, Copy)]
struct Columns([f64; MOST_LANES]);

impl Columns {
    const fn all(number: f64) -> Self {
        Self([number; MOST_LANES])
    }

    /// The columns of the elements from `at` on.
    #[inline(always)]
    fn of(&mut self, at: usize) -> &mut [f64] {
        &mut self.0[at % MOST_LANES..]
    }

    #[inline(always)]
    fn add<L: Real>(&mut self, at: usize, other: L) {
        let own = self.of(at);
        (L::load(own) + other).store(own);
    }

    /// The least, or the largest, so far.
    #[inline(always)]
    fn least<L: Real>(&mut self, at: usize, other: L) {
        let own = self.of(at);
        L::load(own).min(other).store(own);
    }

    #[inline(always)]
    fn largest<L: Real>(&mut self, at: usize, other: L) {
        let own = self.of(at);
        L::load(own).max(other).store(own);
    }

    fn sum(self) -> f64 {
        let [a, b, c, d] = self.0;
        (a + b) + (c + d)
    }
}

/// Differences of two vertices in lanes.
#[inline(always)]
fn between<'a, L: Real>(
    from: impl Fn(usize) -> &'a Quad,
    to: impl Fn(usize) -> &'a Quad,
) -> Vector<L> {
    let [x, y, z, _] = L::differences(to, from);
    Vector::new(x, y, z)
}

/// `number(k)` in lane `k`.
#[inline(always)]
pub(super) fn in_lanes<L: Real>(number: impl Fn(usize) -> f64) -> L {
    let mut numbers = [0.0; MOST_LANES];
    for (k, lane) in numbers[..L::LANES].iter_mut().enumerate() {
        *lane = number(k);
    }
    L::load(&numbers)
}

/// The numbers of both sides of each edge, in lanes: their sum. Among the numbers of all triangles, in rows of four, that of a side has the
/// index of four times the triangle, plus its own.
#[inline(always)]
fn of_sides<L: Real>(numbers: &[Quad], sides_of: &[[u32; 2]]) -> L {
    let numbers: &[f64] = bytemuck::must_cast_slice(numbers);
    in_lanes::<L>(|k| {
        let [one, other] = sides_of[k];
        numbers[one as usize] + numbers[other as usize]
    })
}

/// Unit normals of one triangle of each hinge, in lanes.
#[inline(always)]
fn normals<L: Real>(faces: &[Quad], sides_of: &[[u32; 2]], which: usize) -> Vector<L> {
    let [x, y, z, inverse] = L::columns(|k| &faces[(sides_of[k][which] >> 2) as usize]);
    Vector::new(x, y, z) * inverse
}

impl Sheet {
    /// Writes the forces of stretching, bending, their dashpots and the pressure on each vertex, and those of `loads`, into `forces`, N. Where
    /// there are no loads, these are empty. Returns what dashpots lose.
    pub fn forces(
        &self,
        at: &Evaluation<'_>,
        work: &mut Workspace,
        loads: &[DVec3],
        forces: &mut [DVec3],
    ) -> Powers {
        self.resize(at, work);
        self.copy_vertices(at, work);
        let turned_over = self.areas(at, work);
        let mut powers = self.pulls(at, work);
        powers.turned_over = turned_over;
        let (faces, places, tensions) = (&work.faces, &work.places, &work.tensions);
        let moments = &work.moments;
        let along = work.along.chunks_mut(CHUNK).enumerate();
        each_part(at.is_parallel, along, |(chunk, along)| {
            let range = chunk * CHUNK..chunk * CHUNK + along.len();
            at.width.run(Along {
                triangles: &self.topology.triangles()[range.clone()],
                edges_of: &self.edges_of[range.clone()],
                faces: &faces[range],
                places,
                moments,
                third: at.pressure / 3.0,
                along,
            });
        });
        let along = &work.along;
        let forces = forces.chunks_mut(CHUNK).enumerate();
        each_part(at.is_parallel, forces, |(chunk, forces)| {
            at.width.run(Gather {
                sheet: self,
                first: chunk * CHUNK,
                places,
                tensions,
                faces,
                along,
                loads,
                forces,
            });
        });
        powers
    }

    /// Normals and areas of the last evaluation as if it had been for these positions.
    pub(super) fn evaluated_at(&self, positions: &[DVec3], work: &mut Workspace) {
        let at = Evaluation {
            positions,
            velocities: &[],
            dashpots: &[],
            pressure: 0.0,
            is_parallel: false,
            width: Width::ONE,
        };
        self.resize(&at, work);
        self.copy_vertices(&at, work);
        self.areas(&at, work);
    }

    /// Whether edges and hinges have dashpots, which need velocities.
    fn has_dashpots(&self) -> [bool; 2] {
        let hinges = self
            .law
            .bending
            .is_some_and(|bending| bending.damping > 0.0);
        [self.law.damping_ratio > 0.0, hinges]
    }

    /// Resizes what this sheet needs, and empties what it does not.
    fn resize(&self, at: &Evaluation<'_>, work: &mut Workspace) {
        let (triangles, vertices) = (self.triangles.len(), self.masses().len());
        let edges = self.topology.edges().len();
        let has_hinges = self.law.bending.is_some();
        let [has_dashpots, has_damped_hinges] = self.has_dashpots();
        let is_continuum = self.law.elasticity != Elasticity::Springs;
        let numbers = |is_there: bool, count: usize| if is_there { count } else { 0 };
        let quads = |quads: &mut Vec<Quad>, count: usize| quads.resize(count, Quad::default());
        quads(&mut work.faces, triangles);
        quads(&mut work.places, vertices);
        let has_speeds = (has_dashpots || has_damped_hinges) && !at.velocities.is_empty();
        quads(&mut work.speeds, numbers(has_speeds, vertices));
        quads(&mut work.sides, numbers(is_continuum, triangles + 1));
        quads(
            &mut work.rates,
            numbers(has_damped_hinges && has_speeds, triangles),
        );
        quads(
            &mut work.along,
            numbers(has_hinges || at.pressure != 0.0, triangles),
        );
        work.tensions.resize(edges, 0.0);
        work.moments.resize(numbers(has_hinges, edges), 0.0);
        work.sums.clear();
        work.sums.resize(edges.div_ceil(CHUNK), Powers::default());
    }

    /// Positions and velocities padded to four numbers, which a processor reads at once.
    fn copy_vertices(&self, at: &Evaluation<'_>, work: &mut Workspace) {
        let copy = |(to, from): (&mut [Quad], &[DVec3])| {
            for (to, from) in to.iter_mut().zip(from) {
                *to = Quad([from.x, from.y, from.z, 0.0]);
            }
        };
        let places = work
            .places
            .chunks_mut(CHUNK)
            .zip(at.positions.chunks(CHUNK));
        each_part(at.is_parallel, places, copy);
        let speeds = work
            .speeds
            .chunks_mut(CHUNK)
            .zip(at.velocities.chunks(CHUNK));
        each_part(at.is_parallel, speeds, copy);
    }

    /// Areas of the triangles, and what else follows from their corners. Returns the first of them that turned over since the evaluation before.
    fn areas(&self, at: &Evaluation<'_>, work: &mut Workspace) -> Option<u32> {
        // The least number is the same whatever thread finds it first.
        let turned = AtomicU32::new(NONE);
        let (places, speeds) = (&work.places, &work.speeds);
        let faces = work.faces.chunks_mut(CHUNK).enumerate();
        let pieces = faces.zip(slices(&mut work.sides).zip(slices(&mut work.rates)));
        each_part(
            at.is_parallel,
            pieces,
            |((chunk, faces), (sides, rates))| {
                let first = chunk * CHUNK;
                let found = at.width.run(Areas {
                    triangles: &self.topology.triangles()[first..first + faces.len()],
                    rest: &self.triangles[first..first + faces.len()],
                    elasticity: self.law.elasticity,
                    stiffness: self.law.stiffness(),
                    has_hinges: self.law.bending.is_some(),
                    places,
                    speeds,
                    faces,
                    sides,
                    rates,
                    turned: NONE,
                });
                if found != NONE {
                    turned.fetch_min(first as u32 + found, Ordering::Relaxed);
                }
            },
        );
        Some(turned.into_inner()).filter(|&triangle| triangle != NONE)
    }

    /// Tensions over lengths and moments over lengths.
    fn pulls(&self, at: &Evaluation<'_>, work: &mut Workspace) -> Powers {
        let damping = self.law.bending.map_or(0.0, |bending| bending.damping);
        let has_dashpots = self.law.damping_ratio > 0.0;
        let (places, speeds) = (&work.places, &work.speeds);
        let (faces, sides, rates) = (&work.faces, &work.sides, &work.rates);
        let tensions = work.tensions.chunks_mut(CHUNK).enumerate();
        let pieces = tensions.zip(slices(&mut work.moments).zip(&mut work.sums));
        each_part(at.is_parallel, pieces, |(tensions, (moments, sum))| {
            let (chunk, tensions) = tensions;
            let range = chunk * CHUNK..chunk * CHUNK + tensions.len();
            // Hinges are the first of the edges.
            let hinges =
                range.start.min(self.bends.factor.len())..range.end.min(self.bends.factor.len());
            *sum = at.width.run(Pulls {
                ends: &self.ends[range.clone()],
                sides_of: &self.sides_of[range.clone()],
                pull: &self.rest.pull[range.clone()],
                inverse: &self.rest.inverse[range.clone()],
                factor: &self.bends.factor[hinges.clone()],
                half_sine: &self.bends.half_sine[hinges],
                is_continuum: self.law.elasticity != Elasticity::Springs,
                dashpots: if has_dashpots {
                    &at.dashpots[range]
                } else {
                    &[]
                },
                damping,
                places,
                speeds,
                faces,
                sides,
                rates,
                tensions,
                moments,
                begin: 0,
                lost: [Columns::all(0.0); 2],
                least: Columns::all(f64::INFINITY),
                largest: Columns::all(f64::NEG_INFINITY),
                stretch: Columns::all(0.0),
            });
        });
        let mut powers = Powers::default();
        for sum in &work.sums {
            powers.edges += sum.edges;
            powers.hinges += sum.hinges;
            powers.stretch(sum.stretches);
        }
        powers
    }
}

/// Areas of a chunk of triangles, tensions of the sides of the continuum, and rates of hinges.
struct Areas<'a> {
    triangles: &'a [[u32; 3]],
    rest: &'a [RestTriangle],
    elasticity: Elasticity,
    /// E t, N/m.
    stiffness: f64,
    has_hinges: bool,
    places: &'a [Quad],
    speeds: &'a [Quad],
    faces: &'a mut [Quad],
    sides: &'a mut [Quad],
    rates: &'a mut [Quad],
    /// The first of the chunk that turned over.
    turned: u32,
}

impl Task for Areas<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Real>(mut self) -> u32 {
        let count = self.triangles.len();
        all_groups::<L>(&mut self, count);
        self.turned
    }
}

impl InLanes for Areas<'_> {
    #[inline(always)]
    fn group<L: Real>(&mut self, at: usize) {
        let triangles = &self.triangles[at..at + L::LANES];
        let (places, speeds) = (self.places, self.speeds);
        let place = |k: usize, corner: usize| &places[triangles[k][corner] as usize];
        let ab = between::<L>(|k| place(k, 0), |k| place(k, 1));
        let ac = between::<L>(|k| place(k, 0), |k| place(k, 2));
        let area = ab.cross(ac) * L::splat(0.5);
        let faces = &mut self.faces[at..at + L::LANES];
        let before = L::vectors(|k| &faces[k]);
        let turned = area.dot(before).below(L::ZERO);
        if turned.any() {
            self.turned = self.turned.min(at as u32 + turned.bits().trailing_zeros());
        }
        let inverse = if self.has_hinges {
            L::ONE / area.length()
        } else {
            L::ZERO
        };
        faces.copy_from_slice(&L::rows(area, inverse)[..L::LANES]);
        if let Elasticity::Continuum { poisson_ratio } = self.elasticity {
            let strained = Strained::gather(|k| &self.rest[at + k].strained);
            let tensions = strained.tensions([ab, ac], self.stiffness, poisson_ratio);
            let rows = L::rows(Vector::from_slice(&tensions), L::ZERO);
            self.sides[at..at + L::LANES].copy_from_slice(&rows[..L::LANES]);
        }
        if !self.rates.is_empty() {
            let over = area * (inverse * inverse);
            let speed = |k: usize, corner: usize| &speeds[triangles[k][corner] as usize];
            let of_a = over.dot(L::vectors(|k| speed(k, 0)));
            let of_b = over.dot(L::vectors(|k| speed(k, 1)));
            let of_c = over.dot(L::vectors(|k| speed(k, 2)));
            let rates = Sides::new(ab, ac).shared([of_a, of_b, of_c]);
            let rows = L::rows(Vector::from_slice(&rates), L::ZERO);
            self.rates[at..at + L::LANES].copy_from_slice(&rows[..L::LANES]);
        }
    }
}

/// Tensions and moments of a chunk of edges, over their lengths.
struct Pulls<'a> {
    ends: &'a [[u32; 2]],
    /// Their indices among the sides of the triangles, as [`of_sides`] has them.
    sides_of: &'a [[u32; 2]],
    /// Stiffness of springs times length without force, N.
    pull: &'a [f64],
    /// Over the length without force, 1/m.
    inverse: &'a [f64],
    /// Factors of the hinges, which are the first of the edges: Ke e0^2/(A1 + A2), N m.
    factor: &'a [f64],
    half_sine: &'a [f64],
    is_continuum: bool,
    dashpots: &'a [f64],
    /// Kd, N s.
    damping: f64,
    places: &'a [Quad],
    speeds: &'a [Quad],
    faces: &'a [Quad],
    sides: &'a [Quad],
    rates: &'a [Quad],
    tensions: &'a mut [f64],
    moments: &'a mut [f64],
    /// The first edge of those that are done now.
    begin: usize,
    /// Lost power by edges and by hinges, W.
    lost: [Columns; 2],
    least: Columns,
    largest: Columns,
    /// Sum of the stretches, which is no number if one of them is not.
    stretch: Columns,
}

impl Task for Pulls<'_> {
    type Output = Powers;

    #[inline(always)]
    fn run<L: Real>(mut self) -> Powers {
        let (hinges, all) = (self.factor.len(), self.ends.len());
        all_groups::<L>(&mut Hinges(&mut self), hinges);
        self.begin = hinges;
        all_groups::<L>(&mut Edges(&mut self), all - hinges);
        let [edges, hinges] = self.lost.map(Columns::sum);
        let stretches = if self.stretch.sum().is_nan() {
            [f64::NAN; 2]
        } else {
            let least = self.least.0.into_iter().fold(f64::INFINITY, f64::min);
            let largest = self.largest.0.into_iter().fold(f64::NEG_INFINITY, f64::max);
            [least, largest]
        };
        Powers {
            edges,
            hinges,
            stretches,
            turned_over: None,
        }
    }
}

/// Edges without a hinge.
struct Edges<'p, 'a>(&'p mut Pulls<'a>);

impl InLanes for Edges<'_, '_> {
    #[inline(always)]
    fn group<L: Real>(&mut self, at: usize) {
        self.0.stretch::<L>(at);
    }
}

/// Edges with a hinge.
struct Hinges<'p, 'a>(&'p mut Pulls<'a>);

impl InLanes for Hinges<'_, '_> {
    #[inline(always)]
    fn group<L: Real>(&mut self, at: usize) {
        let (branch, length, inverse) = self.0.stretch::<L>(at);
        self.0.bend(at, branch, length, inverse);
    }
}

impl Pulls<'_> {
    /// Tensions of the edges from `at` on behind the first of these. Returns their branches, lengths and the inverse of these.
    #[inline(always)]
    fn stretch<L: Real>(&mut self, at: usize) -> (Vector<L>, L, L) {
        let range = self.begin + at..self.begin + at + L::LANES;
        let ends = &self.ends[range.clone()];
        let (places, speeds) = (self.places, self.speeds);
        let place = |k: usize, end: usize| &places[ends[k][end] as usize];
        let branch = between::<L>(|k| place(k, 0), |k| place(k, 1));
        let length = branch.length();
        let inverse = L::ONE / length;
        let rest = L::load(&self.inverse[range.clone()]);
        let stretch = length * rest;
        self.least.least(at, stretch);
        self.largest.largest(at, stretch);
        self.stretch.add(at, stretch);
        let mut tension = if self.is_continuum {
            let sides_of = &self.sides_of[range.clone()];
            of_sides::<L>(self.sides, sides_of)
        } else {
            // Stiffness times (length - length without force), over the length.
            L::load(&self.pull[range.clone()]) * (rest - inverse)
        };
        if !self.dashpots.is_empty() {
            let speed = |k: usize, end: usize| &speeds[ends[k][end] as usize];
            let apart = between::<L>(|k| speed(k, 0), |k| speed(k, 1));
            let rate = apart.dot(branch) * inverse;
            let pull = L::load(&self.dashpots[range.clone()]) * rate;
            tension = tension + pull * inverse;
            self.lost[0].add(at, pull * rate);
        }
        tension.store(&mut self.tensions[range]);
        (branch, length, inverse)
    }

    /// Moments of the hinges from `at` on.
    #[inline(always)]
    fn bend<L: Real>(&mut self, at: usize, branch: Vector<L>, length: L, inverse: L) {
        let sides_of = &self.sides_of[at..at + L::LANES];
        let one = normals::<L>(self.faces, sides_of, 0);
        let other = normals::<L>(self.faces, sides_of, 1);
        // The sine of half the angle.
        let half = (one - other).length() * 0.5;
        let sign = one.cross(other).dot(branch);
        let half = L::select(sign.below(L::ZERO), -half, half);
        let rest = L::load(&self.half_sine[at..]);
        let mut moment = L::load(&self.factor[at..]) * (half - rest) * inverse;
        if self.damping > 0.0 {
            let rate = of_sides::<L>(self.rates, sides_of) * inverse;
            let dashpot = rate * self.damping;
            moment = moment - dashpot;
            self.lost[1].add(at, dashpot * length * rate);
        }
        moment.store(&mut self.moments[at..]);
    }
}

/// Forces along the normals of a chunk of triangles: of hinges and of the pressure.
struct Along<'a> {
    triangles: &'a [[u32; 3]],
    edges_of: &'a [[u32; 3]],
    faces: &'a [Quad],
    places: &'a [Quad],
    moments: &'a [f64],
    /// A third of the pressure, Pa.
    third: f64,
    along: &'a mut [Quad],
}

impl Task for Along<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Real>(mut self) {
        if self.moments.is_empty() {
            let third = self.third;
            self.along.fill(Quad([third, third, third, 0.0]));
            return;
        }
        let count = self.triangles.len();
        all_groups::<L>(&mut self, count);
    }
}

impl InLanes for Along<'_> {
    #[inline(always)]
    fn group<L: Real>(&mut self, at: usize) {
        let triangles = &self.triangles[at..at + L::LANES];
        let edges_of = &self.edges_of[at..at + L::LANES];
        let (places, moments) = (self.places, self.moments);
        let place = |k: usize, corner: usize| &places[triangles[k][corner] as usize];
        let ab = between::<L>(|k| place(k, 0), |k| place(k, 1));
        let ac = between::<L>(|k| place(k, 0), |k| place(k, 2));
        let moment = |k: usize, side: usize| moments[edges_of[k][side] as usize];
        let of_ab = in_lanes::<L>(|k| moment(k, 0));
        let of_bc = in_lanes::<L>(|k| moment(k, 1));
        let of_ca = in_lanes::<L>(|k| moment(k, 2));
        let inverse = in_lanes::<L>(|k| self.faces[at + k].0[3]);
        let over = inverse * inverse;
        let [a, b, c] = Sides::new(ab, ac).returned([of_ab, of_bc, of_ca]);
        let third = self.third;
        let shares = [a * over + third, b * over + third, c * over + third];
        let rows = L::rows(Vector::from_slice(&shares), L::ZERO);
        self.along[at..at + L::LANES].copy_from_slice(&rows[..L::LANES]);
    }
}

/// Sums of a chunk of vertices.
struct Gather<'a> {
    sheet: &'a Sheet,
    first: usize,
    places: &'a [Quad],
    tensions: &'a [f64],
    faces: &'a [Quad],
    along: &'a [Quad],
    loads: &'a [DVec3],
    forces: &'a mut [DVec3],
}

impl Task for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Real>(self) {
        let along: &[f64] = bytemuck::must_cast_slice(self.along);
        for (offset, force) in self.forces.iter_mut().enumerate() {
            let vertex = self.first + offset;
            let own = self.places[vertex];
            let mut sum = Quad::default();
            for &[edge, other] in self.sheet.edges_at(vertex) {
                sum += (self.places[other as usize] - own) * self.tensions[edge as usize];
            }
            if !along.is_empty() {
                for &corner in self.sheet.corners_at(vertex) {
                    sum += self.faces[(corner >> 2) as usize] * along[corner as usize];
                }
            }
            let inner = DVec3::from(sum);
            *force = self.loads.get(vertex).map_or(inner, |load| *load + inner);
        }
    }
}
