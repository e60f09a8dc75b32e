//! The weights with which something is added to the points of a row of the grid.

use std::ops::Range;

use super::lattice::Lattice;
use super::spread::Placed;
use crate::kernel::Kernel;
use crate::kernel::exponential::exponential;
use crate::sums::Spread;

/// Gives the weights of one place, row by row.
pub(crate) trait RowWeights {
    /// Goes to another place, seen in these ranges of the three axes.
    fn begin(&mut self, placed: &Placed, ranges: &[Range<usize>; 3]);

    /// The weights at the points `first..first + out.len()` of the row of points `i`, `j`.
    fn row(&mut self, i: usize, j: usize, first: usize, out: &mut [f64]);
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
    factors: Vec<f64>,
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
            factors: Vec::new(),
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
            let from = axis.at(range.start) - placed.centre[a];
            table.resize(self.nodes.len() * range.len(), 0.0);
            for (node, part) in self
                .nodes
                .iter()
                .zip(table.chunks_exact_mut(range.len().max(1)))
            {
                fill_gaussian(
                    part,
                    from - node * placed.segment[a],
                    axis.step,
                    self.inverse,
                    self.decay[a],
                );
            }
        }
    }

    #[inline]
    fn row(&mut self, i: usize, j: usize, first: usize, out: &mut [f64]) {
        let [nx, ny, nz] = self.lengths;
        let (i, j) = (i - self.begins[0], j - self.begins[1]);
        let skip = first - self.begins[2];
        let [tx, ty, tz] = &self.tables;
        let factor = |q: usize| self.weights[q] * tx[q * nx + i] * ty[q * ny + j];
        let part = |q: usize| &tz[q * nz + skip..][..out.len()];
        match self.nodes.len() {
            1 => {
                let a = factor(0);
                let z = part(0);
                for (out, z) in out.iter_mut().zip(z) {
                    *out = a * z;
                }
            }
            2 => {
                let (a, b) = (factor(0), factor(1));
                let (y, z) = (part(0), part(1));
                for ((out, y), z) in out.iter_mut().zip(y).zip(z) {
                    *out = a * y + b * z;
                }
            }
            3 => {
                let (a, b, c) = (factor(0), factor(1), factor(2));
                let (x, y, z) = (part(0), part(1), part(2));
                for (((out, x), y), z) in out.iter_mut().zip(x).zip(y).zip(z) {
                    *out = a * x + b * y + c * z;
                }
            }
            nodes => {
                self.factors.clear();
                self.factors.extend((0..nodes).map(factor));
                out.fill(0.0);
                for (q, a) in self.factors.iter().enumerate() {
                    for (out, z) in out.iter_mut().zip(&tz[q * nz + skip..]) {
                        *out += a * z;
                    }
                }
            }
        }
    }
}

/// exp(-(from + k step)^2 / (2 w^2)) for all k: products of a ratio that shrinks by the same factor from point to point.
fn fill_gaussian(out: &mut [f64], from: f64, step: f64, inverse: f64, decay: f64) {
    for (block, part) in out.chunks_mut(RESTART).enumerate() {
        let d = from + (block * RESTART) as f64 * step;
        let mut value = exponential(-0.5 * d * d * inverse);
        if let [one] = part {
            *one = value;
            continue;
        }
        let mut ratio = exponential(-(d + 0.5 * step) * step * inverse);
        for out in part {
            *out = value;
            value *= ratio;
            ratio *= decay;
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
        }
    }
}

impl RowWeights for PolynomialRows<'_> {
    fn begin(&mut self, placed: &Placed, _: &[Range<usize>; 3]) {
        self.placed = *placed;
        self.length = placed.segment.length();
    }

    #[inline]
    fn row(&mut self, i: usize, j: usize, first: usize, out: &mut [f64]) {
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
            glam::DVec3::ZERO
        };
        let along = dx * n.x + dy * n.y;
        let half = 0.5 * self.length;
        for (k, out) in out.iter_mut().enumerate() {
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
