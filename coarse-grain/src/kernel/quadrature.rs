//! Gauss-Legendre rules on the unit segment, and how many nodes the line integral of a Gaussian needs.

use std::f64::consts::PI;

/// Nodes on [-1/2, 1/2] and their weights, which sum to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Positions, ascending.
    pub nodes: Vec<f64>,
    /// Weights.
    pub weights: Vec<f64>,
}

impl Rule {
    /// The Gauss-Legendre rule of `n` nodes, exact for polynomials of degree 2n - 1.
    ///
    /// Roots by Newton's method from Tricomi's estimate (Abramowitz & Stegun 22.16.6, 25.4.29).
    #[must_use]
    pub fn gauss_legendre(n: usize) -> Self {
        let mut nodes = vec![0.0; n];
        let mut weights = vec![0.0; n];
        for k in 0..n.div_ceil(2) {
            let mut x = libm::cos(PI * (k as f64 + 0.75) / (n as f64 + 0.5));
            let mut slope = 1.0;
            for _ in 0..100 {
                let (value, derivative) = legendre(n, x);
                slope = derivative;
                let change = value / derivative;
                x -= change;
                if change.abs() <= 1e-16 {
                    break;
                }
            }
            if 2 * k + 1 == n {
                x = 0.0;
                slope = legendre(n, x).1;
            }
            // 2 / ((1 - x^2) P'^2) on [-1, 1], half of it on the unit segment.
            let weight = 1.0 / ((1.0 - x * x) * slope * slope);
            nodes[k] = -0.5 * x;
            nodes[n - 1 - k] = 0.5 * x;
            weights[k] = weight;
            weights[n - 1 - k] = weight;
        }
        Self { nodes, weights }
    }

    /// The rule applied to `pieces` equal parts of the segment.
    #[must_use]
    pub fn in_pieces(&self, pieces: usize) -> Self {
        let part = 1.0 / pieces as f64;
        let all = |of: &dyn Fn(usize, usize) -> f64| {
            (0..pieces)
                .flat_map(|piece| (0..self.nodes.len()).map(move |k| (piece, k)))
                .map(|(piece, k)| of(piece, k))
                .collect()
        };
        Self {
            nodes: all(&|piece, k| (piece as f64 + 0.5 + self.nodes[k]) * part - 0.5),
            weights: all(&|_, k| self.weights[k] * part),
        }
    }
}

/// Legendre polynomial and its derivative by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        let next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k;
        before = value;
        value = next;
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

/// Most nodes of a rule on one piece.
const MOST: usize = 12;

/// Rules for line integrals of a Gaussian over segments of any length, to a tolerance.
///
/// The error of `n` nodes over a segment of `L = x w` is at most `x^2n (n!)^3 / ((2n + 1) ((2n)!)^2 2^n)` of the largest
/// value: the remainder of Gauss-Legendre quadrature (Abramowitz & Stegun 25.4.30) with the largest even derivative
/// of a Gaussian, `(2n)! / (n! 2^n w^2n)`, which it has at its centre.
#[derive(Debug, Clone)]
pub struct LineRules {
    rules: Vec<Rule>,
    /// Longest segment of each rule, in widths.
    longest: Vec<f64>,
}

impl LineRules {
    /// Rules whose error is at most `tolerance` of the largest value of the line integral.
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        let tolerance = tolerance.max(1e-17);
        let longest = |n: usize| {
            let factorial = |n: usize| (1..=n).fold(1.0, |product, k| product * k as f64);
            let (half, whole) = (factorial(n), factorial(2 * n));
            let powers = (1u64 << n) as f64;
            let bound =
                tolerance * (2 * n + 1) as f64 * whole / half * (whole / half) * powers / half;
            libm::pow(bound, 1.0 / (2 * n) as f64)
        };
        Self {
            rules: (1..=MOST).map(Rule::gauss_legendre).collect(),
            longest: (1..=MOST).map(longest).collect(),
        }
    }

    /// The number of nodes on each piece and of pieces for a segment of this many widths.
    #[must_use]
    pub fn choose(&self, ratio: f64) -> (usize, usize) {
        match self.longest.iter().position(|&longest| ratio <= longest) {
            Some(k) => (k + 1, 1),
            None => (MOST, (ratio / self.longest[MOST - 1]).ceil() as usize),
        }
    }

    /// The rule for a segment of this many widths, nodes and weights appended to the lists, which are emptied first.
    pub fn fill(&self, ratio: f64, nodes: &mut Vec<f64>, weights: &mut Vec<f64>) {
        nodes.clear();
        weights.clear();
        let (count, pieces) = self.choose(ratio);
        let rule = &self.rules[count - 1];
        let part = 1.0 / pieces as f64;
        for piece in 0..pieces {
            let middle = (piece as f64 + 0.5) * part - 0.5;
            nodes.extend(rule.nodes.iter().map(|node| middle + node * part));
            weights.extend(rule.weights.iter().map(|weight| weight * part));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_powers_exactly() {
        for n in 1..=20 {
            let rule = Rule::gauss_legendre(n);
            for power in 0..2 * n {
                let sum: f64 = rule
                    .nodes
                    .iter()
                    .zip(&rule.weights)
                    .map(|(x, w)| w * libm::pow(*x, power as f64))
                    .sum();
                // int_{-1/2}^{1/2} x^p dx
                let exact = if power % 2 == 1 {
                    0.0
                } else {
                    libm::pow(0.5, power as f64) / (power + 1) as f64
                };
                assert!((sum - exact).abs() < 2e-15, "{n} {power}: {sum} {exact}");
            }
            let pieces = rule.in_pieces(3);
            let sum: f64 = pieces
                .nodes
                .iter()
                .zip(&pieces.weights)
                .map(|(x, w)| w * x * x)
                .sum();
            let exact = if n == 1 {
                (2.0 / 9.0) / 3.0
            } else {
                1.0 / 12.0
            };
            assert!((sum - exact).abs() < 2e-15, "{n}: {sum} {exact}");
        }
    }

    #[test]
    fn the_bound_is_that_of_the_reference_table() {
        // Error of n nodes at L/w: the reference's measured largest errors lie at or below the bound.
        for (ratio, n, measured) in [
            (1.0, 2, 6.9e-4),
            (1.0, 3, 7.3e-6),
            (1.0, 4, 5.8e-8),
            (2.0, 5, 3.6e-7),
            (4.0, 6, 2.3e-5),
            (6.0, 8, 3e-5),
        ] {
            let rules = LineRules::new(measured * 1.2);
            assert!(rules.choose(ratio).0 >= n, "{ratio} {n}");
            let exact = {
                let s = ratio / (2.0 * 2f64.sqrt());
                libm::erf(s) * 2.0 * s.recip() * PI.sqrt() / 4.0
            };
            let (mut nodes, mut weights) = (Vec::new(), Vec::new());
            for tolerance in [1e-3, 1e-6, 1e-12] {
                LineRules::new(tolerance).fill(ratio, &mut nodes, &mut weights);
                let sum: f64 = nodes
                    .iter()
                    .zip(&weights)
                    .map(|(s, w)| w * libm::exp(-0.5 * (s * ratio) * (s * ratio)))
                    .sum();
                assert!(
                    (sum - exact).abs() <= tolerance + 1e-15,
                    "{ratio} {tolerance}: {sum} {exact}"
                );
            }
        }
    }
}
