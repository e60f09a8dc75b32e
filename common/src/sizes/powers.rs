//! Powers of the diameter inside a class: means, shares and their inverse, in forms without cancellation.

/// Mean of d^p over [a, b], 0 <= a <= b; for p < 0 a must be above 0.
///
/// Sums of positive terms for whole p (all p here are whole), ln(b/a)/(b-a) for p = -1.
pub(super) fn power_mean(a: f64, b: f64, p: i32) -> f64 {
    match p {
        0 => 1.0,
        1 => 0.5 * (a + b),
        2 => (a * a + a * b + b * b) / 3.0,
        3 => 0.25 * (a + b) * (a * a + b * b),
        -1 => {
            if a == b {
                1.0 / a
            } else {
                libm::log1p((b - a) / a) / (b - a)
            }
        }
        -2 => 1.0 / (a * b),
        -3 => (a + b) / (2.0 * a * a * b * b),
        p if p > 0 => products(a, b, p) / f64::from(p + 1),
        // The integral of d^p is that of d^(-p-2) in 1/d, from 1/b to 1/a, whose length is (b-a)/(ab).
        p => products(1.0 / b, 1.0 / a, -p - 2) / (f64::from(-p - 1) * a * b),
    }
}

/// (b^(n+1) - a^(n+1)) / (b - a) = the sum of a^i b^(n-i).
fn products(a: f64, b: f64, n: i32) -> f64 {
    let mut sum = 0.0;
    let mut power = 1.0;
    for _ in 0..=n {
        sum = sum * a + power;
        power *= b;
    }
    sum
}

/// x^n by products in one fixed order: the standard library promises no bits for its own.
pub(super) fn whole_power(x: f64, n: i32) -> f64 {
    let (mut square, mut left) = (x, n.unsigned_abs());
    let mut product = 1.0;
    while left > 0 {
        if left & 1 == 1 {
            product *= square;
        }
        square *= square;
        left >>= 1;
    }
    if n < 0 { 1.0 / product } else { product }
}

/// The share of the integral of d^p over [a, b] that lies below `x`.
pub(super) fn power_share(a: f64, b: f64, p: i32, x: f64) -> f64 {
    if x <= a {
        return 0.0;
    }
    if x >= b {
        return 1.0;
    }
    ((x - a) * power_mean(a, x, p) / ((b - a) * power_mean(a, b, p))).min(1.0)
}

/// The x below which a share `u` of the integral of d^p over [a, b] lies.
pub(super) fn power_quantile(a: f64, b: f64, p: i32, u: f64) -> f64 {
    let x = match p {
        0 => a + u * (b - a),
        -1 => a * libm::exp(u * libm::log(b / a)),
        -2 => a * b / (b - u * (b - a)),
        -3 => a * b / (b * b - u * (b - a) * (b + a)).sqrt(),
        p if p > 0 => {
            // x^(p+1) = a^(p+1) + u (b^(p+1) - a^(p+1)), in units of b.
            let n = p + 1;
            let low = whole_power(a / b, n);
            let root = low + u * (1.0 - low);
            b * match n {
                2 => root.sqrt(),
                3 => libm::cbrt(root),
                4 => root.sqrt().sqrt(),
                _ => libm::pow(root, 1.0 / f64::from(n)),
            }
        }
        p => {
            let n = -p - 1;
            let high = whole_power(a / b, n);
            a * libm::pow(1.0 - u * (1.0 - high), -1.0 / f64::from(n))
        }
    };
    x.clamp(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn means_of_powers_are_those_of_the_integral() {
        let (a, b) = (2.0_f64, 3.0_f64);
        for p in -8..=9 {
            let expected = if p == -1 {
                (b / a).ln()
            } else {
                (b.powi(p + 1) - a.powi(p + 1)) / f64::from(p + 1)
            };
            assert!((power_mean(a, b, p) / expected - 1.0).abs() < 1e-14, "{p}");
        }
        assert_eq!(power_mean(2.0, 2.0, -1), 0.5);
        assert!((power_mean(0.0, 2.0, 5) - 32.0 / 6.0).abs() < 1e-14);
    }

    proptest! {
        #[test]
        fn shares_and_quantiles_invert_each_other(
            a in 1e-6_f64..1.0, width in 1e-3_f64..3.0, p in -6..7_i32, u in 0.0_f64..1.0,
        ) {
            let b = a * (1.0 + width);
            let x = power_quantile(a, b, p, u);
            prop_assert!(x >= a && x <= b);
            // x is known to some 1e-15 of itself; the share changes by at most (p-th power of 4) / width of that.
            let back = power_share(a, b, p, x);
            let steepness = (x / a).max(b / x).powi(p.abs()) / width;
            prop_assert!((back - u).abs() <= 2e-14 * (1.0 + steepness), "{} {}", back, u);
        }

        #[test]
        fn narrow_classes_lose_no_digits(a in 1e-6_f64..1.0, p in -6..7_i32) {
            // Over a width of 1e-9 the mean is the power of the middle, up to p^2 1e-18.
            let b = a * (1.0 + 1e-9);
            let middle = 0.5 * (a + b);
            prop_assert!((power_mean(a, b, p) / middle.powi(p) - 1.0).abs() < 1e-13);
        }
    }
}
