//! The weights with which something is added to the points that a window holds.

use std::ops::Range;

use glam::DVec3;

use super::lattice::Lattice;
use super::spread::Placed;
use super::window::{Bounds, Window};
use crate::kernel::Kernel;
use crate::kernel::exponential::exponential;
use crate::sums::Spread;

/// Gives the weights of one place, row by row.
pub(crate) trait RowWeights {
    /// Goes to another place, seen in these ranges of the three axes.
    fn begin(&mut self, placed: &Placed, ranges: &[Range<usize>; 3]);

    /// Adds the values, times its weights, to all points that are seen.
    fn add<const F: usize>(&mut self, seen: &mut Seen<'_, F>, values: &[f64; F]);
}

/// The points that one place sees in a part of the grid.
pub(crate) struct Seen<'a, const F: usize> {
    pub lattice: &'a Lattice,
    pub window: &'a Window,
    /// The middle of the window.
    pub centre: DVec3,
    /// Box around it, in the part.
    pub own: [Range<usize>; 3],
    /// Rows of the part, counted through all planes.
    pub lines: Range<usize>,
    /// The first point of the part.
    pub begin: usize,
    /// Sums at the points of the part.
    pub sums: &'a mut [[f64; F]],
}

impl<const F: usize> Seen<'_, F> {
    /// All planes, and in each all rows that have points: where they are along the second axis, the first of the points, and the points.
    #[inline(always)]
    fn each_row<P>(
        &mut self,
        bounds: &mut Bounds,
        plane: impl Fn(usize) -> P,
        mut row: impl FnMut(&P, usize, usize, &mut [[f64; F]]),
    ) {
        let [_, y, z] = &self.lattice.axes;
        let mut own = self.own.clone();
        for i in self.own[0].clone() {
            // The first and the last plane of a part may be cut.
            let rows = &self.own[1];
            let line = i * y.count;
            own[1].start = rows.start.max(self.lines.start.saturating_sub(line));
            own[1].end = rows.end.min(self.lines.end.saturating_sub(line));
            if own[1].is_empty() {
                continue;
            }
            self.window
                .plane(&self.lattice.axes, self.centre, i, &own, bounds);
            let of_plane = plane(i);
            let first_row = line * z.count;
            for (j, (first, end)) in own[1].clone().zip(bounds.iter()) {
                if first < end {
                    let at = first_row + j * z.count + first as usize - self.begin;
                    let points = &mut self.sums[at..][..(end - first) as usize];
                    row(&of_plane, j, first as usize, points);
                }
            }
        }
    }
}

#[inline(always)]
fn add_to<const F: usize>(point: &mut [f64; F], weight: f64, values: &[f64; F]) {
    for (sum, value) in point.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

/// Points after which the recurrence of a table starts anew: rounding errors stay below 2e-14 of the value.
const RESTART: usize = 16;

/// Most nodes that are spread at once; those of longer segments follow in further rounds.
const MOST_NODES: usize = 12;

/// A Gaussian is a product of functions of x, y and z; so is its line integral at each node of a quadrature rule.
pub(crate) struct GaussianRows<'a> {
    kernel: &'a Kernel,
    spread: Spread,
    /// 1/w^2, and exp(-h^2/w^2) of each axis.
    inverse: f64,
    decay: [f64; 3],
    placed: Placed,
    ranges: [Range<usize>; 3],
    nodes: Vec<f64>,
    weights: Vec<f64>,
    /// Factors of the nodes, of each axis, point by point of the range.
    tables: [Vec<f64>; 3],
    bounds: Bounds,
}

impl<'a> GaussianRows<'a> {
    pub(crate) fn new(kernel: &'a Kernel, lattice: &Lattice, spread: Spread) -> Self {
        let w = kernel.choice().width;
        let inverse = 1.0 / (w * w);
        Self {
            kernel,
            spread,
            inverse,
            decay: lattice
                .axes
                .map(|axis| libm::exp(-axis.step * axis.step * inverse)),
            placed: Placed::NOWHERE,
            ranges: [0..0, 0..0, 0..0],
            nodes: Vec::new(),
            weights: Vec::new(),
            tables: [const { Vec::new() }; 3],
            bounds: Bounds::default(),
        }
    }

    /// Makes the tables of N nodes from `from` on.
    #[inline(always)]
    fn fill<const N: usize>(&mut self, lattice: &Lattice, from: usize) {
        let inverse = self.inverse;
        let nodes: [f64; N] = std::array::from_fn(|q| self.nodes[from + q]);
        // First values and ratios of all tables, so that the exponentials are taken several at once.
        let start = |a: usize, k: usize| -> [[f64; N]; 2] {
            let axis = &lattice.axes[a];
            let d = axis.at(k) - self.placed.centre[a];
            let l = self.placed.segment[a];
            [
                nodes.map(|node| -0.5 * (d - node * l) * (d - node * l) * inverse),
                nodes.map(|node| -(d - node * l + 0.5 * axis.step) * axis.step * inverse),
            ]
        };
        let mut starts: [[[f64; N]; 2]; 3] =
            std::array::from_fn(|a| start(a, self.ranges[a].start));
        for exponent in starts.as_flattened_mut().as_flattened_mut() {
            *exponent = exponential(*exponent);
        }
        for (a, [mut values, mut ratios]) in starts.into_iter().enumerate() {
            let (range, decay) = (self.ranges[a].clone(), self.decay[a]);
            let table = &mut self.tables[a];
            if table.len() < N * range.len() {
                table.resize(N * range.len(), 0.0);
            }
            let table = table.as_chunks_mut::<N>().0;
            for (k, (at, factors)) in range.zip(table).enumerate() {
                if k % RESTART == 0 && k > 0 {
                    [values, ratios] = start(a, at);
                    for exponent in values.iter_mut().chain(&mut ratios) {
                        *exponent = exponential(*exponent);
                    }
                }
                *factors = values;
                for q in 0..N {
                    values[q] *= ratios[q];
                    ratios[q] *= decay;
                }
            }
        }
    }

    /// Adds what N nodes from `from` on give.
    #[inline(always)]
    fn add_nodes<const N: usize, const F: usize>(
        &mut self,
        from: usize,
        seen: &mut Seen<'_, F>,
        values: &[f64; F],
    ) {
        self.fill::<N>(seen.lattice, from);
        let [tx, ty, tz] = &self.tables;
        let [tx, ty, tz] = [tx, ty, tz].map(|table| table.as_chunks::<N>().0);
        let begins = [0, 1, 2].map(|a| self.ranges[a].start);
        // A copy, of which the compiler knows that nothing is written to it: it stays in registers.
        let values = *values;
        let weights = &self.weights[from..from + N];
        let plane =
            |i: usize| -> [f64; N] { std::array::from_fn(|q| weights[q] * tx[i - begins[0]][q]) };
        seen.each_row(&mut self.bounds, plane, |across, j, first, points| {
            let y = &ty[j - begins[1]];
            let factors: [f64; N] = std::array::from_fn(|q| across[q] * y[q]);
            let row = &tz[first - begins[2]..][..points.len()];
            for (point, z) in points.iter_mut().zip(row) {
                let mut weight = factors[0] * z[0];
                for q in 1..N {
                    weight += factors[q] * z[q];
                }
                add_to(point, weight, &values);
            }
        });
    }
}

impl RowWeights for GaussianRows<'_> {
    #[inline(always)]
    fn begin(&mut self, placed: &Placed, ranges: &[Range<usize>; 3]) {
        self.placed = *placed;
        self.ranges = ranges.clone();
        let w = self.kernel.choice().width;
        let length = placed.segment.length();
        let is_line = matches!(self.spread, Spread::Lines | Spread::Moments) && length > 1e-10 * w;
        if is_line {
            self.kernel
                .rules()
                .fill(length / w, &mut self.nodes, &mut self.weights);
            let factor = self.kernel.uncut_norm() * self.kernel.line_factor(length);
            let moments = self.spread == Spread::Moments;
            for (weight, node) in self.weights.iter_mut().zip(&self.nodes) {
                *weight *= if moments { factor * node } else { factor };
            }
        } else {
            self.nodes.clear();
            self.nodes.push(0.0);
            self.weights.clear();
            self.weights.push(match self.spread {
                Spread::Gradients => -self.kernel.peak() * self.inverse,
                Spread::Moments => 0.0,
                _ => self.kernel.peak(),
            });
        }
        // Nodes without weight fill up the groups in which they are spread.
        let count = self.nodes.len();
        let filled = match count {
            0..=4 => count,
            5..=8 => 8,
            _ => count.next_multiple_of(MOST_NODES),
        };
        self.nodes.resize(filled, 0.0);
        self.weights.resize(filled, 0.0);
    }

    #[inline(always)]
    fn add<const F: usize>(&mut self, seen: &mut Seen<'_, F>, values: &[f64; F]) {
        match self.nodes.len() {
            1 => self.add_nodes::<1, F>(0, seen, values),
            2 => self.add_nodes::<2, F>(0, seen, values),
            3 => self.add_nodes::<3, F>(0, seen, values),
            4 => self.add_nodes::<4, F>(0, seen, values),
            8 => self.add_nodes::<8, F>(0, seen, values),
            many => {
                for from in (0..many).step_by(MOST_NODES) {
                    self.add_nodes::<MOST_NODES, F>(from, seen, values);
                }
            }
        }
    }
}

/// Polynomials of the distance: evaluated at each point.
pub(crate) struct PolynomialRows<'a> {
    kernel: &'a Kernel,
    lattice: &'a Lattice,
    spread: Spread,
    placed: Placed,
    length: f64,
    row: Vec<f64>,
    bounds: Bounds,
}

impl<'a> PolynomialRows<'a> {
    pub(crate) fn new(kernel: &'a Kernel, lattice: &'a Lattice, spread: Spread) -> Self {
        Self {
            kernel,
            lattice,
            spread,
            placed: Placed::NOWHERE,
            length: 0.0,
            row: Vec::new(),
            bounds: Bounds::default(),
        }
    }
}

impl RowWeights for PolynomialRows<'_> {
    #[inline(always)]
    fn begin(&mut self, placed: &Placed, _: &[Range<usize>; 3]) {
        self.placed = *placed;
        self.length = placed.segment.length();
    }

    #[inline(always)]
    fn add<const F: usize>(&mut self, seen: &mut Seen<'_, F>, values: &[f64; F]) {
        let (mut bounds, mut row) = (
            std::mem::take(&mut self.bounds),
            std::mem::take(&mut self.row),
        );
        seen.each_row(
            &mut bounds,
            |i| i,
            |&i, j, first, points| {
                row.resize(points.len(), 0.0);
                self.weigh(i, j, first, &mut row);
                for (point, &weight) in points.iter_mut().zip(&row) {
                    add_to(point, weight, values);
                }
            },
        );
        (self.bounds, self.row) = (bounds, row);
    }
}

impl PolynomialRows<'_> {
    /// The weights of the points of a row from `first` on.
    #[inline(always)]
    fn weigh(&self, i: usize, j: usize, first: usize, row: &mut [f64]) {
        let Some(polynomial) = self.kernel.polynomial() else {
            return;
        };
        let radius = self.kernel.choice().width;
        let (axes, c) = (&self.lattice.axes, self.placed.centre);
        let (dx, dy) = (axes[0].at(i) - c.x, axes[1].at(j) - c.y);
        let across = dx * dx + dy * dy;
        let inverse = 1.0 / radius;
        let norm = self.kernel.peak();
        let is_line =
            matches!(self.spread, Spread::Lines | Spread::Moments) && self.length > 1e-10 * radius;
        let n = if is_line {
            self.placed.segment / self.length
        } else {
            DVec3::ZERO
        };
        let along = dx * n.x + dy * n.y;
        let half = 0.5 * self.length;
        for (k, out) in row.iter_mut().enumerate() {
            let dz = axes[2].at(first + k) - c.z;
            let distance = across + dz * dz;
            *out = if is_line {
                let u = along + dz * n.z;
                let t2 = ((distance - u * u) * inverse * inverse).max(0.0);
                let [psi, moment] =
                    polynomial.line(t2, (-u - half) * inverse, (half - u) * inverse);
                norm * if self.spread == Spread::Lines {
                    psi
                } else {
                    moment
                }
            } else {
                let x = distance.sqrt() * inverse;
                match self.spread {
                    _ if x > 1.0 => 0.0,
                    Spread::Gradients => norm * inverse * inverse * polynomial.slope_at(x),
                    Spread::Moments => 0.0,
                    _ => norm * polynomial.at(x),
                }
            };
        }
    }
}
