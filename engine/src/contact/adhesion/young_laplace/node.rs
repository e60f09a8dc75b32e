//! A node of the table: one exact bridge, fitted over its gap.

use std::f64::consts::PI;

use super::bound::COEFFICIENTS;
use super::exact::{Branch, Failure};
use super::meridian::Bridge;

/// Smallest x at which a bridge is fitted ([`super::Bound`]). The curve behind, in the last hundredths of the gap, follows by
/// extrapolation: where asymmetric shapes set in just before the end, the force bends too sharply there to be fitted.
const FITTED_FROM: f64 = 0.045;

/// End over the cube root of the volume; coefficients of the force; those of the lateral area over the square of that root.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Node {
    pub(super) end: f64,
    pub(super) force: [f64; COEFFICIENTS],
    pub(super) area: [f64; COEFFICIENTS],
}

impl Node {
    /// For a contact angle (rad), the logarithm of a volume in R_D^3, and the ratio of radii.
    pub(super) fn solved(theta: f64, log_volume: f64, ratio: f64) -> Result<Self, Failure> {
        let volume = libm::exp(log_volume);
        let branch = Branch::new(theta, volume, ratio)?;
        let (m, root) = (stretch(log_volume), libm::cbrt(volume));
        let mut points = [0.0; COEFFICIENTS];
        let (mut force, mut area) = (points, points);
        for k in 0..COEFFICIENTS {
            // Chebyshev's points
            let angle = PI * (k as f64 + 0.5) / COEFFICIENTS as f64;
            let x = FITTED_FROM + (1.0 - FITTED_FROM) * 0.5 * (1.0 + libm::cos(angle));
            // x = t/(1 + m (1 - t))
            let t = x * (1.0 + m) / (1.0 + m * x);
            let bridge = solved_at(
                &branch,
                (theta, volume, ratio),
                branch.end() * (1.0 - t * t),
            )?;
            let d = 1.0 / (1.0 + m * (1.0 - t));
            points[k] = x;
            force[k] = bridge.force / (d * d * d);
            area[k] = bridge.area / (root * root);
        }
        Ok(Self {
            end: branch.end() / root,
            force: polynomial(&points, force),
            area: polynomial(&points, area),
        })
    }

    /// Adds a share of another node.
    pub(super) fn add(&mut self, weight: f64, other: &Self) {
        self.end += weight * other.end;
        for k in 0..COEFFICIENTS {
            self.force[k] += weight * other.force[k];
            self.area[k] += weight * other.area[k];
        }
    }
}

/// m of [`super::Bound`], by the logarithm of the volume: the smaller the volume over the length of the bridge, the more steeply the
/// force falls from the touch on. Chosen by trial, for the smallest error of the fit.
pub(super) fn stretch(log_volume: f64) -> f64 {
    f64::max(0.6 - 0.25 * log_volume, 0.0)
}

/// The bridge of a branch at a gap; contact angle, volume and ratio for the message.
pub(super) fn solved_at(
    branch: &Branch,
    (theta, volume, ratio): (f64, f64, f64),
    gap: f64,
) -> Result<Bridge, Failure> {
    branch.at(gap).ok_or(Failure::NotFound {
        theta,
        volume,
        ratio,
    })
}

/// Coefficients of the polynomial through the values at some points: Newton's form, multiplied out.
fn polynomial(
    points: &[f64; COEFFICIENTS],
    mut values: [f64; COEFFICIENTS],
) -> [f64; COEFFICIENTS] {
    for order in 1..COEFFICIENTS {
        for k in (order..COEFFICIENTS).rev() {
            values[k] = (values[k] - values[k - 1]) / (points[k] - points[k - order]);
        }
    }
    let mut coefficients = [0.0; COEFFICIENTS];
    for k in (0..COEFFICIENTS).rev() {
        for power in (1..COEFFICIENTS).rev() {
            coefficients[power] = coefficients[power - 1] - points[k] * coefficients[power];
        }
        coefficients[0] = values[k] - points[k] * coefficients[0];
    }
    coefficients
}
