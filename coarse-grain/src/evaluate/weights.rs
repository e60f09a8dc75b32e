//! The weights with which something is added to the points of a row of the grid.

use std::ops::Range;

use super::lattice::Lattice;
use super::spread::Placed;
use super::window::Span;
use crate::kernel::Kernel;
use crate::kernel::exponential::exponential;
use crate::sums::Spread;

/// Gives the weights of one place, row by row.
pub(crate) trait RowWeights {
    /// Goes to another place, seen in these ranges of the three axes.
    fn begin(&mut self, placed: &Placed, ranges: &[Range<usize>; 3]);

    /// Adds the values, times its weights, to the points of the spans. `sums` begins at point `begin` of the grid.
    fn add<const F: usize>(
        &mut self,
        spans: &[Span],
        values: &[f64; F],
        begin: usize,
        sums: &mut [[f64; F]],
    );
}

/// The points of a span in a list that begins at point `begin` of the grid.
#[inline]
fn points<'a, const F: usize>(
    lattice: &Lattice,
    span: &Span,
    begin: usize,
    sums: &'a mut [[f64; F]],
) -> &'a mut [[f64; F]] {
    let [_, y, z] = &lattice.axes;
    let row = (span.i as usize * y.count + span.j as usize) * z.count;
    &mut sums[row + span.first as usize - begin..][..span.count as usize]
}

#[inline]
fn add_to<const F: usize>(point: &mut [f64; F], weight: f64, values: &[f64; F]) {
    for (sum, value) in point.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

/// Points after which the recurrence of a table starts anew: rounding errors stay below 2e-14 of the value.
const RESTART: usize = 16;

/// A Gaussian is a product of functions of x, y and z; so is its line integral at each node of a quadrature rule.
pub(crate) struct GaussianRows<'a> {
    kernel: &'a Kernel,
    lattice: &'a Lattice,
    spread: Spread,
    /// 1/w^2, and exp(-h^2/w^2) of each axis.
    inverse: f64,
    decay: [f64; 3],
    nodes: Vec<f64>,
    weights: Vec<f64>,
    /// Of each axis, node by node, the factors at the points of the range.
    tables: [Vec<f64>; 3],
    begins: [usize; 3],
    lengths: [usize; 3],
    row: Vec<f64>,
    starts: Vec<f64>,
}

impl<'a> GaussianRows<'a> {
    pub(crate) fn new(kernel: &'a Kernel, lattice: &'a Lattice, spread: Spread) -> Self {
        let w = kernel.choice().width;
        let inverse = 1.0 / (w * w);
        Self {
            kernel,
            lattice,
            spread,
            inverse,
            decay: lattice
                .axes
                .map(|axis| libm::exp(-axis.step * axis.step * inverse)),
            nodes: Vec::new(),
            weights: Vec::new(),
            tables: [const { Vec::new() }; 3],
            begins: [0; 3],
            lengths: [0; 3],
            row: Vec::new(),
            starts: Vec::new(),
        }
    }
}

impl RowWeights for GaussianRows<'_> {
    fn begin(&mut self, placed: &Placed, ranges: &[Range<usize>; 3]) {
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
        // First values and ratios of all rows of the tables, so that the exponentials are taken several at once.
        self.starts.clear();
        for (a, range) in ranges.iter().enumerate() {
            let axis = &self.lattice.axes[a];
            if axis.resolved {
                let from = axis.at(range.start) - placed.centre[a];
                for node in &self.nodes {
                    let d = from - node * placed.segment[a];
                    self.starts.push(-0.5 * d * d * self.inverse);
                    self.starts
                        .push(-(d + 0.5 * axis.step) * axis.step * self.inverse);
                }
            }
        }
        for start in &mut self.starts {
            *start = exponential(*start);
        }
        let mut starts = self.starts.chunks_exact(2);
        for (a, range) in ranges.iter().enumerate() {
            let axis = &self.lattice.axes[a];
            self.begins[a] = range.start;
            self.lengths[a] = range.len();
            let table = &mut self.tables[a];
            table.clear();
            if !axis.resolved {
                table.resize(self.nodes.len(), 1.0);
                continue;
            }
            table.resize(self.nodes.len() * range.len(), 0.0);
            let parts = table.chunks_exact_mut(range.len());
            for ((node, part), start) in self.nodes.iter().zip(parts).zip(&mut starts) {
                let (first, rest) = part.split_at_mut(part.len().min(RESTART));
                fill(first, start[0], start[1], self.decay[a]);
                let from = axis.at(range.start) - placed.centre[a] - node * placed.segment[a];
                for (block, part) in (1..).zip(rest.chunks_mut(RESTART)) {
                    let d = from + (block * RESTART) as f64 * axis.step;
                    let value = exponential(-0.5 * d * d * self.inverse);
                    let ratio = exponential(-(d + 0.5 * axis.step) * axis.step * self.inverse);
                    fill(part, value, ratio, self.decay[a]);
                }
            }
        }
    }

    fn add<const F: usize>(
        &mut self,
        spans: &[Span],
        values: &[f64; F],
        begin: usize,
        sums: &mut [[f64; F]],
    ) {
        match self.nodes.len() {
            1 => self.add_nodes::<1, F>(spans, values, begin, sums),
            2 => self.add_nodes::<2, F>(spans, values, begin, sums),
            3 => self.add_nodes::<3, F>(spans, values, begin, sums),
            4 => self.add_nodes::<4, F>(spans, values, begin, sums),
            _ => self.add_any(spans, values, begin, sums),
        }
    }
}

impl GaussianRows<'_> {
    /// With so few nodes that their factors stay in registers.
    fn add_nodes<const N: usize, const F: usize>(
        &self,
        spans: &[Span],
        values: &[f64; F],
        begin: usize,
        sums: &mut [[f64; F]],
    ) {
        let [nx, ny, nz] = self.lengths;
        let [tx, ty, tz] = &self.tables;
        let (mut last, mut across) = (u32::MAX, [0.0; N]);
        for span in spans {
            if span.i != last {
                last = span.i;
                let i = last as usize - self.begins[0];
                across = std::array::from_fn(|q| self.weights[q] * tx[q * nx + i]);
            }
            let j = span.j as usize - self.begins[1];
            let skip = span.first as usize - self.begins[2];
            let points = points(self.lattice, span, begin, sums);
            let count = points.len();
            let factors: [f64; N] = std::array::from_fn(|q| across[q] * ty[q * ny + j]);
            let rows: [&[f64]; N] = std::array::from_fn(|q| &tz[q * nz + skip..][..count]);
            for (k, point) in points.iter_mut().enumerate() {
                let mut weight = factors[0] * rows[0][k];
                for q in 1..N {
                    weight += factors[q] * rows[q][k];
                }
                add_to(point, weight, values);
            }
        }
    }

    fn add_any<const F: usize>(
        &mut self,
        spans: &[Span],
        values: &[f64; F],
        begin: usize,
        sums: &mut [[f64; F]],
    ) {
        let [nx, ny, nz] = self.lengths;
        let [tx, ty, tz] = &self.tables;
        for span in spans {
            let (i, j) = (
                span.i as usize - self.begins[0],
                span.j as usize - self.begins[1],
            );
            let skip = span.first as usize - self.begins[2];
            self.row.clear();
            self.row.resize(span.count as usize, 0.0);
            for (q, weight) in self.weights.iter().enumerate() {
                let factor = weight * tx[q * nx + i] * ty[q * ny + j];
                for (out, z) in self.row.iter_mut().zip(&tz[q * nz + skip..]) {
                    *out += factor * z;
                }
            }
            let points = points(self.lattice, span, begin, sums);
            for (point, &weight) in points.iter_mut().zip(&self.row) {
                add_to(point, weight, values);
            }
        }
    }
}

/// Values of a Gaussian at equal distances: products of a ratio that shrinks by the same factor from point to point.
#[inline]
fn fill(out: &mut [f64], mut value: f64, mut ratio: f64, decay: f64) {
    for out in out {
        *out = value;
        value *= ratio;
        ratio *= decay;
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
}

impl<'a> PolynomialRows<'a> {
    pub(crate) fn new(kernel: &'a Kernel, lattice: &'a Lattice, spread: Spread) -> Self {
        let placed = Placed {
            centre: glam::DVec3::ZERO,
            segment: glam::DVec3::ZERO,
            row: 0,
            mirrored: 0,
        };
        Self {
            kernel,
            lattice,
            spread,
            placed,
            length: 0.0,
            row: Vec::new(),
        }
    }
}

impl RowWeights for PolynomialRows<'_> {
    fn begin(&mut self, placed: &Placed, _: &[Range<usize>; 3]) {
        self.placed = *placed;
        self.length = placed.segment.length();
    }

    fn add<const F: usize>(
        &mut self,
        spans: &[Span],
        values: &[f64; F],
        begin: usize,
        sums: &mut [[f64; F]],
    ) {
        for span in spans {
            let points = points(self.lattice, span, begin, sums);
            self.row.resize(points.len(), 0.0);
            self.weigh(span);
            for (point, &weight) in points.iter_mut().zip(&self.row) {
                add_to(point, weight, values);
            }
        }
    }
}

impl PolynomialRows<'_> {
    /// The weights of a span.
    fn weigh(&mut self, span: &Span) {
        let Some(polynomial) = self.kernel.polynomial() else {
            return;
        };
        let radius = self.kernel.choice().width;
        let (axes, c) = (&self.lattice.axes, self.placed.centre);
        let (dx, dy) = (
            axes[0].at(span.i as usize) - c.x,
            axes[1].at(span.j as usize) - c.y,
        );
        let across = dx * dx + dy * dy;
        let inverse = 1.0 / radius;
        let norm = self.kernel.peak();
        let is_line =
            matches!(self.spread, Spread::Lines | Spread::Moments) && self.length > 1e-10 * radius;
        let n = if is_line {
            self.placed.segment / self.length
        } else {
            glam::DVec3::ZERO
        };
        let along = dx * n.x + dy * n.y;
        let half = 0.5 * self.length;
        for (k, out) in self.row.iter_mut().enumerate() {
            let dz = axes[2].at(span.first as usize + k) - c.z;
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
