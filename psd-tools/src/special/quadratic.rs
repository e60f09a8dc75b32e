//! Anderson-Darling's statistic, which integrates the squared distance.

use std::f64::consts::PI;

/// The probability that A^2 of a sample of `n` from a continuous, fully known law exceeds `x`.
///
/// Marsaglia and Marsaglia 2004 (J. Stat. Softw. 9, 2): their approximation of the limit, good to 2e-6, and their correction
/// for finite n. Far out the largest of the eigenvalues 1/(j (j+1)) decides: sqrt(3 / (pi x)) exp(-x) (1 - 7 / (36 x) + ...),
/// where 7/36 is 1/2 of the integration less 11/36 of the other eigenvalues, half the sum of 1/((j-1) (j+2)).
#[must_use]
pub fn anderson_darling_tail(x: f64, n: usize) -> f64 {
    if x.is_nan() || n == 0 {
        return f64::NAN;
    }
    if x <= 0.0 {
        return 1.0;
    }
    if x > FAR {
        return (3.0 / (PI * x)).sqrt() * libm::exp(-x) * (1.0 - 7.0 / (36.0 * x));
    }
    let limit = if x < 2.0 {
        let series = 2.00012
            + (0.247_105
                - (0.064_982_1 - (0.034_796_2 - (0.011_672_0 - 0.001_686_91 * x) * x) * x) * x)
                * x;
        libm::exp(-1.233_714_1 / x) / x.sqrt() * series
    } else {
        let series = 1.0776
            - (2.30695 - (0.434_24 - (0.082_433 - (0.008_056 - 0.000_314_6 * x) * x) * x) * x) * x;
        libm::exp(-libm::exp(series))
    };
    (1.0 - limit - correction(limit, n as f64)).clamp(0.0, 1.0)
}

/// Beyond this the approximation, whose error is absolute, is worse than the first terms of the tail.
const FAR: f64 = 6.0;

/// The variance of the limit of A^2 for one degree of freedom, 2 times the sum of 1/(j (j+1))^2.
pub const ANDERSON_DARLING_VARIANCE: f64 = 2.0 * (PI * PI / 3.0 - 3.0);

/// The probability that the limit of A^2 of `degrees` + 1 samples of one distribution, the sum of a chi-square variable of so
/// many degrees of freedom over j (j+1) for all j, exceeds `x`.
///
/// One degree: the limit of one sample. Else the characteristic function is turned back as Imhof does (1961, Biometrika 48,
/// 419, equation 3.2); far out the leading term of the largest eigenvalue, 1/2.
#[must_use]
pub fn anderson_darling_samples_tail(x: f64, degrees: usize) -> f64 {
    if x.is_nan() || degrees == 0 {
        return f64::NAN;
    }
    if x <= 0.0 {
        return 1.0;
    }
    let m = degrees as f64;
    if degrees == 1 {
        return anderson_darling_tail(x, usize::MAX);
    }
    if x > 25.0 + 2.0 * m {
        let ln =
            0.5 * m * 3.0_f64.ln() - libm::lgamma(0.5 * m) + (0.5 * m - 1.0) * libm::log(x) - x;
        return libm::exp(ln).min(1.0);
    }
    let mut sum = 0.0;
    // Trapezoidal rule: steps that resolve the fastest oscillation, x u / 2, until the modulus has died away.
    let step = 0.1 / (1.0 + x);
    let mut u = 0.5 * step;
    loop {
        let (mut phase, mut ln_modulus) = (-0.5 * x * u, 0.0);
        for j in 1..=EIGENVALUES {
            let eigenvalue = 1.0 / f64::from(j * (j + 1));
            let v = eigenvalue * u;
            phase += 0.5 * m * libm::atan(v);
            ln_modulus += 0.25 * m * libm::log1p(v * v);
        }
        // The rest of the eigenvalues is as good as its mean, their sum.
        phase += 0.5 * m * u / f64::from(EIGENVALUES + 1);
        let modulus = libm::exp(ln_modulus);
        sum += libm::sin(phase) / (u * modulus);
        if u * modulus > 1e9 {
            break;
        }
        u += step;
    }
    (0.5 + sum * step / PI).clamp(0.0, 1.0)
}

/// Eigenvalues that are taken one by one; what their rest varies is 2 m / (3 J^3), 2e-5 of the whole variance.
const EIGENVALUES: i32 = 40;

/// The term that a finite n adds to the limit `p` of the cumulative probability.
fn correction(p: f64, n: f64) -> f64 {
    if p > 0.8 {
        let series = -130.2137
            + (745.2337 - (1705.091 - (1950.646 - (1116.360 - 255.7844 * p) * p) * p) * p) * p;
        return series / n;
    }
    let corner = 0.01265 + 0.1757 / n;
    if p < corner {
        let t = p / corner;
        let t = t.sqrt() * (1.0 - t) * (49.0 * t - 102.0);
        return t * (0.0037 / (n * n) + 0.000_78 / n + 0.000_06) / n;
    }
    let t = (p - corner) / (0.8 - corner);
    let series =
        -0.000_226_33 + (6.54034 - (14.6538 - (14.458 - (8.259 - 1.91864 * t) * t) * t) * t) * t;
    series * (0.04213 + 0.01365 / n) / n
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_points() {
        // 10, 5, 1 % points of A^2 (Marsaglia and Marsaglia 2004).
        for (x, p) in [(1.932_957_8, 0.1), (2.492_367_2, 0.05), (3.878_125, 0.01)] {
            let got = anderson_darling_tail(x, 1_000_000);
            assert!((got - p).abs() < 2e-3 * p.max(0.05), "{x}: {got}");
        }
    }

    /// Scholz and Stephens 1987, table 2: the points of (A^2 - m) / sigma are b0 + b1 / sqrt(m) + b2 / m, up to some 0.01 sigma.
    #[test]
    fn tabulated_points_of_many_samples() {
        for (p, [b0, b1, b2]) in [
            (0.25, [0.675, -0.245, -0.105]),
            (0.1, [1.281, 0.25, -0.305]),
            (0.05, [1.645, 0.678, -0.362]),
            (0.025, [1.96, 1.149, -0.391]),
            (0.01, [2.326, 1.822, -0.396]),
        ] {
            for m in [1_usize, 2, 3, 4, 6, 8, 10] {
                let degrees = m as f64;
                let point = b0 + b1 / degrees.sqrt() + b2 / degrees;
                let deviation = (degrees * ANDERSON_DARLING_VARIANCE).sqrt();
                let got = anderson_darling_samples_tail(degrees + point * deviation, m);
                // The tail falls by less than 1.4 of itself per sigma here.
                assert!((got / p - 1.0).abs() < 0.03, "{m} {p}: {got}");
            }
        }
        // Beyond the border the leading term goes on.
        for m in [2, 3, 6] {
            let border = 25.0 + 2.0 * m as f64;
            let outside = anderson_darling_samples_tail(border + 1e-6, m);
            assert!(outside < 1e-9, "{m}: {outside}");
        }
    }

    #[test]
    fn the_tails_join() {
        // The rest beyond the leading term falls as the second eigenvalue: exp(-3 x) against exp(-x), exp(-2 pi^2 x) against
        // exp(-pi^2 x / 2); the relative error of the prefactor is that of its asymptotic form, some 1/x.
        let (below, above) = (
            anderson_darling_tail(FAR - 1e-3, 1 << 40),
            anderson_darling_tail(FAR + 1e-3, 1 << 40),
        );
        // The third term, some 1/x^2, and 2e-6 of 1e-3.
        assert!((below / above - 1.0).abs() < 0.03, "{below} {above}");
    }
}
