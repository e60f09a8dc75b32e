//! Share of the line integral of a Gaussian that a cut-off takes away, tabulated over the length of the segment.

use std::f64::consts::{PI, SQRT_2};

use rayon::prelude::*;

use super::LineCut;
use super::quadrature::Rule;

/// Intervals of the table.
const INTERVALS: usize = 128;
/// Most pieces of the integration over a segment; longer ones are straight in the middle.
const MOST_PIECES: usize = 24;
/// A cut-off, in widths, from which on nothing is missing in double precision.
const NOTHING_MISSING: f64 = 8.7;

/// 1 over the integral of the cut line integral, as a function of the length of the segment.
///
/// Tabulated over `L / (L + c)`, which maps all lengths to [0, 1), and interpolated by cubics through four nodes.
#[derive(Debug, Clone)]
pub(super) struct LineNorm {
    reach: f64,
    table: Option<Vec<f64>>,
}

impl LineNorm {
    /// Always 1.
    pub(super) fn none() -> Self {
        Self {
            reach: 1.0,
            table: None,
        }
    }

    /// For a Gaussian of width `w` cut at `reach`.
    pub(super) fn new(dimensions: usize, w: f64, reach: f64, cut: LineCut) -> Self {
        if dimensions == 0 || reach > NOTHING_MISSING * w {
            return Self::none();
        }
        let rule = Rule::gauss_legendre(8);
        let rules: Vec<Rule> = (1..=MOST_PIECES).map(|k| rule.in_pieces(k)).collect();
        let node = |k: usize| {
            let x = k as f64 / INTERVALS as f64;
            // The last node stands for a segment without end, of which the ends' share vanishes.
            let length = reach * x / (1.0 - x).max(1e-9);
            // Eight nodes for each 1.5 widths of the half that is integrated over.
            let pieces = ((reach + 0.5 * length) / (1.5 * w)).ceil() as usize;
            let rule = &rules[pieces.min(MOST_PIECES) - 1];
            1.0 / inside(dimensions, w, reach, length, cut, rule)
        };
        Self {
            reach,
            table: Some((0..=INTERVALS).into_par_iter().map(node).collect()),
        }
    }

    pub(super) fn factor(&self, length: f64) -> f64 {
        let Some(table) = &self.table else {
            return 1.0;
        };
        let x = length / (length + self.reach) * INTERVALS as f64;
        let k = (x as usize).clamp(1, INTERVALS - 2);
        let u = x - k as f64;
        let [a, b, c, d] = [table[k - 1], table[k], table[k + 1], table[k + 2]];
        // Lagrange's cubic through -1, 0, 1, 2.
        -u * (u - 1.0) * (u - 2.0) / 6.0 * a + (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0 * b
            - (u + 1.0) * u * (u - 2.0) / 2.0 * c
            + (u + 1.0) * u * (u - 1.0) / 6.0 * d
    }
}

/// The integral of the uncut line integral over the region that the cut leaves.
fn inside(dimensions: usize, w: f64, reach: f64, length: f64, cut: LineCut, rule: &Rule) -> f64 {
    let half = reach + 0.5 * length;
    // The line integral, integrated over the directions across the segment.
    let along = |u: f64| {
        if length < 1e-3 * w {
            let gauss = libm::exp(-0.5 * (u / w) * (u / w)) / ((2.0 * PI).sqrt() * w);
            let second = (u / w) * (u / w) - 1.0;
            return gauss * (1.0 + length * length / (24.0 * w * w) * second);
        }
        let (a, b) = (
            (u - 0.5 * length) / (SQRT_2 * w),
            (u + 0.5 * length) / (SQRT_2 * w),
        );
        (libm::erf(b) - libm::erf(a)) / (2.0 * length)
    };
    let across = |radius: f64| match dimensions {
        1 => 1.0,
        2 => libm::erf(radius / (SQRT_2 * w)),
        _ => -libm::expm1(-0.5 * (radius / w) * (radius / w)),
    };
    // u = half sin(angle): smooth where the ellipsoid ends. Both halves are equal.
    let mut sum = 0.0;
    for (node, weight) in rule.nodes.iter().zip(&rule.weights) {
        let angle = (node + 0.5) * 0.5 * PI;
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let radius = match cut {
            LineCut::Ellipsoid => reach * cos,
            LineCut::Cylinder => reach,
        };
        sum += weight * along(half * sin) * across(radius) * cos;
    }
    sum * PI * half
}
