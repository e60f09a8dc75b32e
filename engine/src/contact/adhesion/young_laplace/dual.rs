//! Numbers with their derivatives by three variables (automatic differentiation, forward).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its derivatives by three variables.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dual {
    pub(super) value: f64,
    pub(super) by: [f64; 3],
}

impl Dual {
    pub(super) fn constant(value: f64) -> Self {
        Self {
            value,
            by: [0.0; 3],
        }
    }

    /// The variable `k` itself.
    pub(super) fn variable(value: f64, k: usize) -> Self {
        let mut dual = Self::constant(value);
        dual.by[k] = 1.0;
        dual
    }

    /// A function of it, whose value and derivative here are given.
    fn chain(self, value: f64, derivative: f64) -> Self {
        Self {
            value,
            by: self.by.map(|d| d * derivative),
        }
    }

    /// A function of two of them, whose value and two derivatives here are given.
    fn of_two(value: f64, (a, by_a): (Self, f64), (b, by_b): (Self, f64)) -> Self {
        Self {
            value,
            by: [0, 1, 2].map(|k| by_a * a.by[k] + by_b * b.by[k]),
        }
    }

    /// Square root.
    pub(super) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    /// Sine and cosine.
    pub(super) fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = libm::sincos(self.value);
        (self.chain(sine, cosine), self.chain(cosine, -sine))
    }

    /// sin(z)/z and cos z.
    pub(super) fn sinc_cos(self) -> (Self, Self) {
        let z = self.value;
        let (sine, cosine) = libm::sincos(z);
        let square = z * z;
        let (sinc, slope) = if square < 1e-2 {
            // series; the first term left out is below 1e-17
            let sinc = 1.0
                - square / 6.0
                    * (1.0
                        - square / 20.0
                            * (1.0
                                - square / 42.0 * (1.0 - square / 72.0 * (1.0 - square / 110.0))));
            let slope = -z / 3.0
                * (1.0
                    - square / 10.0
                        * (1.0 - square / 28.0 * (1.0 - square / 54.0 * (1.0 - square / 88.0))));
            (sinc, slope)
        } else {
            (sine / z, (cosine - sine / z) / z)
        };
        (self.chain(sinc, slope), self.chain(cosine, -sine))
    }
}

impl Add for Dual {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::of_two(self.value + other.value, (self, 1.0), (other, 1.0))
    }
}

impl Sub for Dual {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Dual {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul for Dual {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = self.value * other.value;
        Self::of_two(product, (self, other.value), (other, self.value))
    }
}

impl Mul<f64> for Dual {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self.chain(self.value * factor, factor)
    }
}

impl Add<f64> for Dual {
    type Output = Self;

    fn add(self, term: f64) -> Self {
        self.chain(self.value + term, 1.0)
    }
}

impl Div for Dual {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let (by_self, by_other) = (1.0 / other.value, -value / other.value);
        Self::of_two(value, (self, by_self), (other, by_other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sinc_is_smooth_where_its_series_ends() {
        for z in [0.0, 1e-4, 0.0999, 0.1001, -0.1001, 2.0] {
            let (sinc, _) = Dual::variable(z, 1).sinc_cos();
            let exact = |z: f64| if z == 0.0 { 1.0 } else { libm::sin(z) / z };
            assert!((sinc.value - exact(z)).abs() < 1e-15, "{z}");
            // central difference of fourth order
            let (h, at) = (1e-3, |k: f64| exact(z + k * 1e-3));
            let slope = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h);
            assert!((sinc.by[1] - slope).abs() < 1e-12, "{z}: {slope}");
            assert_eq!((sinc.by[0], sinc.by[2]), (0.0, 0.0));
        }
    }
}
