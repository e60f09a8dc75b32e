//! Kernels that are polynomials of the distance inside a radius, with line integrals in closed form.

use std::f64::consts::PI;

use super::KernelShape;

/// `sum a_k x^k` for `x = r / radius < 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Polynomial {
    coefficients: [f64; 5],
}

impl Polynomial {
    pub(super) fn of(shape: KernelShape) -> Option<Self> {
        let coefficients = match shape {
            KernelShape::Gaussian => return None,
            KernelShape::Heaviside => [1.0, 0.0, 0.0, 0.0, 0.0],
            KernelShape::Linear => [1.0, -1.0, 0.0, 0.0, 0.0],
            KernelShape::Lucy => [1.0, 0.0, -6.0, 8.0, -3.0],
        };
        Some(Self { coefficients })
    }

    /// 1 over the integral over the ball of this radius.
    pub(super) fn norm(&self, dimensions: usize, radius: f64) -> f64 {
        let sum = |shift: f64| -> f64 {
            let terms = self.coefficients.iter().enumerate();
            terms.map(|(k, a)| a / (k as f64 + shift)).sum()
        };
        match dimensions {
            0 => 1.0,
            1 => 1.0 / (2.0 * radius * sum(1.0)),
            2 => 1.0 / (2.0 * PI * radius * radius * sum(2.0)),
            _ => 1.0 / (4.0 * PI * radius * radius * radius * sum(3.0)),
        }
    }

    /// The value at `x`, which is at most 1.
    #[inline]
    pub(crate) fn at(&self, x: f64) -> f64 {
        let [a, b, c, d, e] = self.coefficients;
        a + x * (b + x * (c + x * (d + x * e)))
    }

    /// The derivative over `x`. At the centre of the linear kernel it has no limit; its product with the distance is taken as 0.
    #[inline]
    pub(crate) fn slope_at(&self, x: f64) -> f64 {
        let [_, b, c, d, e] = self.coefficients;
        let cusp = if b != 0.0 && x > 1e-12 { b / x } else { 0.0 };
        cusp + 2.0 * c + x * (3.0 * d + x * 4.0 * e)
    }

    /// The line integral and its first moment about the middle, from `i` to `p` along the line at squared distance `t2`; all
    /// lengths in radii.
    pub(crate) fn line(&self, t2: f64, i: f64, p: f64) -> [f64; 2] {
        let length = p - i;
        if t2 >= 1.0 {
            return [0.0; 2];
        }
        let chord = (1.0 - t2).sqrt();
        let (a, b) = (i.max(-chord), p.min(chord));
        if a >= b {
            return [0.0; 2];
        }
        let [a0, a1, a2, a3, a4] = self.coefficients;
        let t4 = t2 * t2;
        let ends = [a, b].map(|u| {
            let u2 = u * u;
            let q2 = u2 + t2;
            let even = a0 * u
                + a2 * u * (u2 / 3.0 + t2)
                + a4 * u * (u2 * u2 / 5.0 + t2 * (2.0 / 3.0 * u2 + t2));
            // int u q^k du = q^(k+2) / (k + 2)
            let even_moment = q2 * (a0 / 2.0 + q2 * (a2 / 4.0 + q2 * a4 / 6.0));
            (u, u2, q2, even, even_moment)
        });
        let [
            (a, a_2, aq2, a_even, a_moment),
            (b, b_2, bq2, b_even, b_moment),
        ] = ends;
        let mut value = b_even - a_even;
        let mut moment = b_moment - a_moment;
        if a1 != 0.0 || a3 != 0.0 {
            let (aq, bq) = (aq2.sqrt(), bq2.sqrt());
            let odd =
                |u: f64, u2: f64, q: f64| u * q * (a1 / 2.0 + a3 * (2.0 * u2 + 5.0 * t2) / 8.0);
            value += odd(b, b_2, bq) - odd(a, a_2, aq);
            // asinh(b / t) - asinh(a / t), which goes with powers of t.
            if t2 > 1e-30 {
                let ratio = if a >= 0.0 {
                    (b + bq) / (a + aq)
                } else if b <= 0.0 {
                    (aq - a) / (bq - b)
                } else {
                    (b + bq) * (aq - a) / t2
                };
                value += (a1 / 2.0 * t2 + a3 * 3.0 / 8.0 * t4) * libm::log(ratio);
            }
            let odd_moment = |q2: f64, q: f64| q2 * q * (a1 / 3.0 + q2 * a3 / 5.0);
            moment += odd_moment(bq2, bq) - odd_moment(aq2, aq);
        }
        let psi = value / length;
        [psi, (moment / length - 0.5 * (i + p) * psi) / length]
    }
}
