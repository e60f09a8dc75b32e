//! Statistics that integrate the squared distance: Anderson-Darling and Cramer-von Mises.

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

/// What a finite n adds to the limit `p` of the cumulative probability.
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

/// The probability that W^2 of a sample of `n` from a continuous, fully known law exceeds `x`.
///
/// The limit and its first correction, V + psi / n (Csorgo and Faraway 1996, J. R. Stat. Soc. B 58, 221, equations 1.8 to 1.10; Gotze
/// 1979). Near the least value, 1/(12 n), exactly: numbers within 1/(2 n) of the middles of their n-th parts are in order
/// whichever way they lie, and fill a ball of n dimensions. It is within 0.012 for 2 numbers, 0.008 for 3, 0.004 for 5 and 0.002
/// from 7 on. Far out, where the correction is of the size of the tail itself, it goes on as in large deviations.
#[must_use]
pub fn cramer_von_mises_tail(x: f64, n: usize) -> f64 {
    if x.is_nan() || n == 0 {
        return f64::NAN;
    }
    let n = n as f64;
    let squared = x - 1.0 / (12.0 * n);
    if squared <= 0.0 {
        return 1.0;
    }
    if x >= n / 3.0 {
        // All numbers at one end.
        return 0.0;
    }
    if squared < 1.0 / (4.0 * n * n) {
        let ln =
            libm::lgamma(n + 1.0) - libm::lgamma(0.5 * n + 1.0) + 0.5 * n * libm::log(PI * squared);
        return (1.0 - libm::exp(ln)).clamp(0.0, 1.0);
    }
    let tail = cramer_von_mises_limit_tail(x);
    let relative = |x: f64, tail: f64| cramer_von_mises_correction(x) / (n * tail);
    let relative = if x > CRAMER_FAR {
        // P(W^2 > n y) falls as exp(-n I(y)), I(y) = pi^2 y / 2 + c y^2 + ...
        let border = relative(CRAMER_FAR, cramer_von_mises_limit_tail(CRAMER_FAR));
        border * (x / CRAMER_FAR) * (x / CRAMER_FAR)
    } else {
        relative(x, tail)
    };
    let factor = if relative < 0.5 {
        1.0 - relative
    } else {
        0.5 * libm::exp(1.0 - 2.0 * relative)
    };
    (tail * factor).clamp(0.0, 1.0)
}

/// Beyond this only the largest eigenvalue counts.
const CRAMER_FAR: f64 = 2.5;

/// What 1/n adds to the cumulative probability of W^2: psi_1 of Csorgo and Faraway 1996, equation 1.10.
fn cramer_von_mises_correction(x: f64) -> f64 {
    if x < LEAST_LIMIT {
        return 0.0;
    }
    let root = x.sqrt();
    let quarter = root.sqrt();
    // Their functions, Ed2 and Ed3 times sqrt(pi).
    let argument = |odd: f64| {
        let half = 0.25 * odd / root;
        (half, half * half)
    };
    let second = |odd: f64| {
        let (half, z) = argument(odd);
        let sum = scaled_bessel(0.25, z) + scaled_bessel(0.75, z);
        half * half.sqrt() * sum * libm::exp(-2.0 * z)
    };
    let third = |odd: f64| {
        let (half, z) = argument(odd);
        let sum =
            2.0 * scaled_bessel(0.25, z) + 3.0 * scaled_bessel(0.75, z) - scaled_bessel(1.25, z);
        half * half * half.sqrt() * sum * libm::exp(-2.0 * z)
    };
    let mut sum = 0.0;
    // Gamma(k + 1/2) / (Gamma(1/2) k!)
    let mut binomial = 1.0;
    for k in 0..40 {
        let k = f64::from(k);
        let m = 2.0 * k + 1.0;
        let odds = [4.0 * k + 1.0, 4.0 * k + 3.0, 4.0 * k + 5.0];
        let of_second =
            m * second(odds[1]) / 9.0 + 7.0 / 144.0 * m * (second(odds[0]) + second(odds[2]));
        let of_third = third(odds[0]) / 72.0 + (m + 2.0) * (k + 0.5) * third(odds[2]) / 6.0;
        let term = binomial * (of_second / (root * quarter) + of_third / (x * quarter));
        sum += term;
        if term.abs() < 1e-17 * sum.abs() {
            break;
        }
        binomial *= (k + 0.5) / (k + 1.0);
    }
    (1.0 - cramer_von_mises_limit_tail(x)) / 12.0 - sum / PI
}

/// The tail of the limit of W^2 = sum of Z_j^2 / (pi j)^2.
///
/// Anderson and Darling 1952 (Ann. Math. Stat. 23, 193), a series in the Bessel function K of order 1/4; far out the leading
/// term, the largest eigenvalue alone: 2 / (pi sqrt(pi x)) exp(-pi^2 x / 2).
#[must_use]
pub fn cramer_von_mises_limit_tail(x: f64) -> f64 {
    if x.is_nan() {
        return f64::NAN;
    }
    if x < LEAST_LIMIT {
        return 1.0;
    }
    if x > CRAMER_FAR {
        return 2.0 / (PI * (PI * x).sqrt()) * libm::exp(-0.5 * PI * PI * x);
    }
    let mut sum = 0.0;
    // Gamma(j + 1/2) / (Gamma(1/2) j!)
    let mut binomial = 1.0;
    for j in 0..40 {
        let odd = f64::from(4 * j + 1);
        let y = odd * odd / (16.0 * x);
        let term = binomial * odd.sqrt() * scaled_bessel(0.25, y) * libm::exp(-2.0 * y);
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
        binomial *= (f64::from(j) + 0.5) / f64::from(j + 1);
    }
    (1.0 - sum / (PI * x.sqrt())).clamp(0.0, 1.0)
}

/// Below this the limit's cumulative probability is less than 1e-10.
const LEAST_LIMIT: f64 = 0.01;

/// exp(y) K_order(y), the integral of exp(y (1 - cosh t)) cosh(order t) over t > 0 by the trapezoidal rule, which is exact to
/// round-off for such integrands.
fn scaled_bessel(order: f64, y: f64) -> f64 {
    let step = 0.05;
    let mut sum = 0.5;
    for i in 1..400 {
        let t = step * f64::from(i);
        let value = libm::exp(y * (1.0 - libm::cosh(t))) * libm::cosh(order * t);
        sum += value;
        if value < 1e-18 * sum {
            break;
        }
    }
    sum * step
}

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;

    use super::*;

    #[test]
    fn tabulated_points() {
        // 10, 5, 1 % points of A^2 (Marsaglia and Marsaglia 2004) and of W^2 (Anderson and Darling 1952).
        for (x, p) in [(1.932_957_8, 0.1), (2.492_367_2, 0.05), (3.878_125, 0.01)] {
            let got = anderson_darling_tail(x, 1_000_000);
            assert!((got - p).abs() < 2e-3 * p.max(0.05), "{x}: {got}");
        }
        for (x, p) in [(0.347_30, 0.1), (0.461_36, 0.05), (0.743_46, 0.01)] {
            let got = cramer_von_mises_limit_tail(x);
            assert!((got - p).abs() < 2e-5, "{x}: {got}");
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
        // What the leading term leaves out falls as the second eigenvalue: exp(-3 x) against exp(-x), exp(-2 pi^2 x)
        // against exp(-pi^2 x / 2); the relative error of the prefactor is that of its asymptotic form, some 1/x.
        let (below, above) = (
            anderson_darling_tail(FAR - 1e-3, 1 << 40),
            anderson_darling_tail(FAR + 1e-3, 1 << 40),
        );
        // The third term, some 1/x^2, and 2e-6 of 1e-3.
        assert!((below / above - 1.0).abs() < 0.03, "{below} {above}");
        let (below, above) = (
            cramer_von_mises_limit_tail(2.499),
            cramer_von_mises_limit_tail(2.501),
        );
        assert!((below / above - 1.0).abs() < 0.1, "{below} {above}");
        let mut last = 1.0;
        for i in 1..400 {
            let x = 0.01 * f64::from(i);
            let p = cramer_von_mises_limit_tail(x);
            assert!(p <= last + 1e-12, "{x}");
            last = p;
        }
    }

    #[test]
    fn p_values_of_few_numbers_are_uniform() {
        const TRIALS: usize = 200_000;
        const POINTS: usize = 400;
        for (n, stated) in [(2, 0.012), (3, 0.008), (5, 0.004), (7, 0.002), (10, 0.002)] {
            let mut stream = Stream::new(7, "numbers", n as u64);
            let mut squares: Vec<f64> = (0..TRIALS)
                .map(|_| {
                    let mut u: Vec<f64> = (0..n).map(|_| stream.uniform()).collect();
                    u.sort_by(f64::total_cmp);
                    let middle = |i: usize| (2 * i + 1) as f64 / (2 * n) as f64;
                    let squares = u.iter().enumerate().map(|(i, u)| (u - middle(i)).powi(2));
                    1.0 / (12 * n) as f64 + squares.sum::<f64>()
                })
                .collect();
            squares.sort_by(f64::total_cmp);
            let largest = (1..POINTS)
                .map(|point| {
                    let index = point * TRIALS / POINTS;
                    let larger = 1.0 - index as f64 / TRIALS as f64;
                    (cramer_von_mises_tail(squares[index], n) - larger).abs()
                })
                .fold(0.0, f64::max);
            // What is stated, and the bound of Dvoretzky, Kiefer and Wolfowitz at 1e-6.
            let noise = (f64::ln(2e6) / (2.0 * TRIALS as f64)).sqrt();
            assert!(largest < stated + noise, "{n}: {largest}");
        }
    }

    /// W^2 of n numbers has the mean 1/6 for all n and the variance 1/45 - 1/(60 n): by parts, psi and 2 x psi have the integrals 0 and 1/60.
    #[test]
    fn the_correction_for_few_numbers_has_the_exact_moments() {
        let step = 0.005;
        let (mut mean, mut variance) = (0.0, 0.0);
        // At 4 psi is below 1e-8.
        for i in 0..800 {
            let x = step * (f64::from(i) + 0.5);
            let psi = cramer_von_mises_correction(x);
            mean += step * psi;
            variance += step * 2.0 * x * psi;
        }
        // The midpoint rule: step^2 / 24 of the change of the slopes, which is 0 from end to end; the next order is step^4 of third
        // derivatives, at most 1e5 near 0.03.
        assert!(mean.abs() < 1e-6, "{mean}");
        assert!((variance - 1.0 / 60.0).abs() < 1e-6, "{variance}");
    }

    #[test]
    fn the_tail_of_few_numbers_falls_from_one_to_nothing() {
        for n in [1, 2, 5, 8, 20, 1000] {
            let [least, most] = [1.0 / (12.0 * n as f64), n as f64 / 3.0];
            assert_eq!(cramer_von_mises_tail(least, n), 1.0);
            assert_eq!(cramer_von_mises_tail(most, n), 0.0);
            let mut last = 1.0;
            for i in 1..300 {
                let x = least + 0.01 * f64::from(i);
                if x >= most {
                    break;
                }
                let p = cramer_von_mises_tail(x, n);
                // Where the exact beginning ends, it may rise by its error.
                assert!(p > 0.0 && p <= last + 2e-4, "{n} {x}: {p}");
                last = p;
            }
        }
        // At 8 numbers, the fewest that are judged at 1 %, the series alone would go below 0.
        assert!(cramer_von_mises_tail(2.6, 8) > 0.0);
    }

    #[test]
    fn one_number_has_closed_forms() {
        // n = 1: W^2 = 1/12 + (u - 1/2)^2: P(W^2 > 1/12 + t^2) = 1 - 2 t.
        for t in [0.2, 0.3, 0.4_f64] {
            let got = cramer_von_mises_tail(1.0 / 12.0 + t * t, 1);
            assert!((got - (1.0 - 2.0 * t)).abs() < 1e-14, "{t}: {got}");
        }
    }
}
