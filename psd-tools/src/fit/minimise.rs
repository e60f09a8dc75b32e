//! Minima of smooth functions of a few parameters, and the curvature there.

use nalgebra::{DMatrix, DVector};

/// Steps of the numerical derivatives: the first where round-off (1e-16/h) and the cut of the series (h^2) balance, the second
/// likewise with 1e-16/h^2.
const FIRST: f64 = 1e-5;
const SECOND: f64 = 1e-4;
/// Steps of the simplex for each parameter.
const SIMPLEX_STEPS: usize = 250;
const NEWTON_STEPS: usize = 30;

/// Where a function is smallest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Minimum {
    pub(super) at: Vec<f64>,
    pub(super) value: f64,
}

impl Minimum {
    /// The standard error of each parameter, from the inverse of the second derivatives; none where those have no inverse.
    pub(super) fn errors(&self, f: impl Fn(&[f64]) -> f64) -> Vec<Option<f64>> {
        let curvature = second_derivatives(&f, &self.at);
        match curvature.cholesky() {
            Some(root) => {
                let inverse = root.inverse();
                let variance = |i: usize| Some(inverse[(i, i)]).filter(|v| v.is_finite());
                (0..self.at.len())
                    .map(|i| variance(i).map(f64::sqrt))
                    .collect()
            }
            None => vec![None; self.at.len()],
        }
    }
}

/// Newton's steps where the curvature is positive, else a simplex first (Nelder and Mead 1965, Computer J. 7, 308).
pub(super) fn minimise(f: impl Fn(&[f64]) -> f64, start: &[f64]) -> Minimum {
    let quick = newton(&f, start);
    if let Some(minimum) = quick {
        return minimum;
    }
    let rough = simplex(&f, start);
    newton(&f, &rough.at).unwrap_or(rough)
}

/// Steps until they no longer matter; none if they lead nowhere.
fn newton(f: &impl Fn(&[f64]) -> f64, start: &[f64]) -> Option<Minimum> {
    let mut at = start.to_vec();
    let mut value = f(&at);
    for _ in 0..NEWTON_STEPS {
        let slope = first_derivatives(f, &at);
        let step = second_derivatives(f, &at).cholesky()?.solve(&slope);
        // Gain that the step promises.
        let promise = 0.5 * slope.dot(&step);
        if !promise.is_finite() {
            return None;
        }
        if promise < 1e-9 {
            return Some(Minimum { at, value });
        }
        let mut length = 1.0;
        loop {
            let next: Vec<f64> = at
                .iter()
                .zip(step.iter())
                .map(|(x, s)| x - length * s)
                .collect();
            let there = f(&next);
            if there < value {
                (at, value) = (next, there);
                break;
            }
            length *= 0.5;
            if length < 1e-4 {
                // A gain below the round-off of the function cannot be seen any more.
                return (promise < 1e-4).then_some(Minimum { at, value });
            }
        }
    }
    None
}

fn moved(at: &[f64], steps: &[(usize, f64)]) -> Vec<f64> {
    let mut moved = at.to_vec();
    for (index, step) in steps {
        moved[*index] += step;
    }
    moved
}

fn first_derivatives(f: &impl Fn(&[f64]) -> f64, at: &[f64]) -> DVector<f64> {
    DVector::from_fn(at.len(), |i, _| {
        (f(&moved(at, &[(i, FIRST)])) - f(&moved(at, &[(i, -FIRST)]))) / (2.0 * FIRST)
    })
}

fn second_derivatives(f: &impl Fn(&[f64]) -> f64, at: &[f64]) -> DMatrix<f64> {
    let n = at.len();
    let h = SECOND;
    let middle = f(at);
    let mut matrix = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let value = if i == j {
                (f(&moved(at, &[(i, h)])) - 2.0 * middle + f(&moved(at, &[(i, -h)]))) / (h * h)
            } else {
                let corner = |a: f64, b: f64| f(&moved(at, &[(i, a), (j, b)]));
                (corner(h, h) - corner(h, -h) - corner(-h, h) + corner(-h, -h)) / (4.0 * h * h)
            };
            matrix[(i, j)] = value;
            matrix[(j, i)] = value;
        }
    }
    matrix
}

fn simplex(f: &impl Fn(&[f64]) -> f64, start: &[f64]) -> Minimum {
    let n = start.len();
    let evaluate = |at: Vec<f64>| {
        let value = f(&at);
        Minimum {
            at,
            value: if value.is_nan() { f64::INFINITY } else { value },
        }
    };
    let mut corners: Vec<Minimum> = (0..=n)
        .map(|i| match i {
            0 => evaluate(start.to_vec()),
            i => evaluate(moved(start, &[(i - 1, 0.2)])),
        })
        .collect();
    for _ in 0..SIMPLEX_STEPS * n {
        corners.sort_by(|a, b| a.value.total_cmp(&b.value));
        if corners[n].value - corners[0].value < 1e-10 * (1.0 + corners[0].value.abs()) {
            // Corners on both sides of a valley have equal values too: only small simplices are done.
            let best = &corners[0].at;
            let width = |corner: &Minimum| {
                let distances = corner.at.iter().zip(best).map(|(x, b)| (x - b).abs());
                distances.fold(0.0, f64::max)
            };
            if corners.iter().map(width).fold(0.0, f64::max) < 1e-5 {
                break;
            }
            shrink(&mut corners, evaluate);
            continue;
        }
        let centre: Vec<f64> = (0..n)
            .map(|i| corners[..n].iter().map(|c| c.at[i]).sum::<f64>() / n as f64)
            .collect();
        let along = |t: f64| {
            let worst = &corners[n].at;
            centre
                .iter()
                .zip(worst)
                .map(|(c, w)| c + t * (w - c))
                .collect::<Vec<f64>>()
        };
        let reflected = evaluate(along(-1.0));
        if reflected.value < corners[0].value {
            let expanded = evaluate(along(-2.0));
            corners[n] = if expanded.value < reflected.value {
                expanded
            } else {
                reflected
            };
        } else if reflected.value < corners[n - 1].value {
            corners[n] = reflected;
        } else {
            let t = if reflected.value < corners[n].value {
                -0.5
            } else {
                0.5
            };
            let contracted = evaluate(along(t));
            if contracted.value < corners[n].value.min(reflected.value) {
                corners[n] = contracted;
            } else {
                shrink(&mut corners, evaluate);
            }
        }
    }
    corners.sort_by(|a, b| a.value.total_cmp(&b.value));
    corners.swap_remove(0)
}

/// All corners half as far from the first, the best.
fn shrink(corners: &mut [Minimum], evaluate: impl Fn(Vec<f64>) -> Minimum) {
    let best = corners[0].at.clone();
    for corner in &mut corners[1..] {
        let middle = best.iter().zip(&corner.at).map(|(b, c)| 0.5 * (b + c));
        *corner = evaluate(middle.collect());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_valley_is_followed_to_its_end() {
        // Rosenbrock's: minimum 0 at (1, 1); second derivatives there [[802, -400], [-400, 200]], inverse [[0.5, 1], [1, 2.005]].
        let f = |x: &[f64]| (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2);
        let minimum = minimise(f, &[-1.2, 1.0]);
        assert!((minimum.at[0] - 1.0).abs() < 1e-4 && (minimum.at[1] - 1.0).abs() < 1e-4);
        let errors = minimum.errors(f);
        assert!((errors[0].unwrap() - 0.5_f64.sqrt()).abs() < 1e-3);
        assert!((errors[1].unwrap() - 2.005_f64.sqrt()).abs() < 1e-3);
    }

    #[test]
    fn flat_directions_have_no_error() {
        let f = |x: &[f64]| x[0] * x[0];
        let minimum = minimise(f, &[1.0, 0.0]);
        assert!(minimum.at[0].abs() < 1e-4);
        assert_eq!(minimum.errors(f), [None, None]);
    }
}
