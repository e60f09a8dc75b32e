//! The largest distance between cumulative shares.

use nalgebra::DMatrix;

/// The probability that the largest distance between a sample of `n` and its continuous law exceeds `d`, two-sided.
///
/// Few numbers: exact, by the matrix of Durbin as Marsaglia, Tsang and Wang compute it (2003, J. Stat. Softw. 8, 18). Small
/// probabilities: twice the exact one-sided one (Birnbaum and Tingey 1951), whose error is the chance that both sides exceed.
/// Else the expansion of Pelz and Good (1976, J. R. Stat. Soc. B 38, 152) in 1/sqrt(n), good to 1e-5 from n = 140 on
/// (Simard and L'Ecuyer 2011, J. Stat. Softw. 39, 11, whose division of the plane this is in the main).
#[must_use]
pub fn kolmogorov_tail(d: f64, n: usize) -> f64 {
    if d.is_nan() || n == 0 {
        return f64::NAN;
    }
    let count = n as f64;
    if d >= 1.0 {
        return 0.0;
    }
    if d <= 0.5 / count {
        return 1.0;
    }
    let square = count * d * d;
    if square > 4.0 || (n > 140 && square > 2.2) {
        return (2.0 * one_sided(d, n)).min(1.0);
    }
    if n <= 140 {
        (1.0 - durbin(d, n)).clamp(0.0, 1.0)
    } else {
        (1.0 - pelz_good(d, count)).clamp(0.0, 1.0)
    }
}

/// The probability that the largest distance between two samples of one continuous law exceeds `d`.
///
/// Exact by counting paths for small samples, else the limit with Stephens' correction (1970) of the effective number.
#[must_use]
pub fn two_sample_kolmogorov_tail(d: f64, n: usize, m: usize) -> f64 {
    if d.is_nan() || n == 0 || m == 0 {
        return f64::NAN;
    }
    if n.saturating_mul(m) <= 250_000 {
        return path_counting(d, n, m);
    }
    let (n, m) = (n as f64, m as f64);
    let root = (n * m / (n + m)).sqrt();
    limit_tail((root + 0.12 + 0.11 / root) * d)
}

/// 2 sum (-1)^(k-1) exp(-2 k^2 x^2), by Jacobi's other series for small x.
fn limit_tail(x: f64) -> f64 {
    use std::f64::consts::PI;
    if x <= 0.0 {
        return 1.0;
    }
    if x < 1.0 {
        let sum: f64 = (1..=20)
            .map(|k| {
                let odd = f64::from(2 * k - 1);
                libm::exp(-odd * odd * PI * PI / (8.0 * x * x))
            })
            .sum();
        return (1.0 - (2.0 * PI).sqrt() / x * sum).clamp(0.0, 1.0);
    }
    let sum: f64 = (1..=20)
        .map(|k| {
            let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
            let k = f64::from(k);
            sign * libm::exp(-2.0 * k * k * x * x)
        })
        .sum();
    (2.0 * sum).clamp(0.0, 1.0)
}

/// P(D_n < d): the middle entry of the n-th power of a matrix of size 2k - 1, k = ceil(n d).
fn durbin(d: f64, n: usize) -> f64 {
    let count = n as f64;
    let k = (count * d).floor() as usize + 1;
    let size = 2 * k - 1;
    let h = k as f64 - count * d;
    let mut matrix = DMatrix::<f64>::zeros(size, size);
    for i in 0..size {
        for j in 0..size.min(i + 2) {
            matrix[(i, j)] = 1.0;
        }
    }
    for i in 0..size {
        matrix[(i, 0)] -= h.powi(i as i32 + 1);
        matrix[(size - 1, i)] -= h.powi((size - i) as i32);
    }
    if 2.0 * h - 1.0 > 0.0 {
        matrix[(size - 1, 0)] += (2.0 * h - 1.0).powi(size as i32);
    }
    for i in 0..size {
        for j in 0..size.min(i + 2) {
            if i + 1 > j {
                for g in 1..=(i + 1 - j) {
                    matrix[(i, j)] /= g as f64;
                }
            }
        }
    }
    // Powers by squaring; a decimal exponent keeps them in range.
    let (mut power, mut exponent) = (DMatrix::<f64>::identity(size, size), 0_i32);
    let (mut base, mut base_exponent) = (matrix, 0_i32);
    let mut left = n;
    let shrink = |matrix: &mut DMatrix<f64>, exponent: &mut i32| {
        if matrix[(k - 1, k - 1)] > 1e140 {
            *matrix *= 1e-140;
            *exponent += 140;
        }
    };
    while left > 0 {
        if left % 2 == 1 {
            power = &power * &base;
            exponent += base_exponent;
            shrink(&mut power, &mut exponent);
        }
        base = &base * &base;
        base_exponent *= 2;
        shrink(&mut base, &mut base_exponent);
        left /= 2;
    }
    let mut result = power[(k - 1, k - 1)];
    for i in 1..=n {
        result *= i as f64 / count;
        if result < 1e-140 {
            result *= 1e140;
            exponent -= 140;
        }
    }
    result * 10.0_f64.powi(exponent)
}

/// The probability that the sample lies above its law by more than d somewhere: a sum of positive terms.
fn one_sided(d: f64, n: usize) -> f64 {
    let count = n as f64;
    let ln_all = libm::lgamma(count + 1.0);
    let last = (count * (1.0 - d)).floor() as usize;
    let mut sum = 0.0;
    for j in 0..=last.min(n) {
        let at = j as f64;
        let low = d + at / count;
        let high = 1.0 - low;
        if high <= 0.0 {
            continue;
        }
        let ln_choose = ln_all - libm::lgamma(at + 1.0) - libm::lgamma(count - at + 1.0);
        sum += libm::exp(ln_choose + (at - 1.0) * libm::log(low) + (count - at) * libm::log(high));
    }
    (d * sum).min(1.0)
}

/// P(D_n < d) to order n^(-3/2).
fn pelz_good(d: f64, n: f64) -> f64 {
    use std::f64::consts::PI;
    let root = n.sqrt();
    let x = root * d;
    let (x2, x4, x6) = (x * x, x.powi(4), x.powi(6));
    let (pi2, pi4, pi6) = (PI * PI, PI.powi(4), PI.powi(6));
    let half = (0.5 * PI).sqrt();
    let [mut k0, mut k1, mut k2, mut k3] = [0.0; 4];
    for k in 0..20 {
        let odd = f64::from(k) + 0.5;
        let square = odd * odd;
        let e = libm::exp(-pi2 * square / (2.0 * x2));
        k0 += e;
        k1 += (pi2 * square - x2) * e;
        k2 += ((6.0 * x6 + 2.0 * x4)
            + pi2 * (2.0 * x4 - 5.0 * x2) * square
            + pi4 * (1.0 - 2.0 * x2) * square * square)
            * e;
        k3 += (-30.0 * x6 - 90.0 * x2 * x6
            + pi2 * (135.0 * x4 - 96.0 * x6) * square
            + pi4 * (212.0 * x4 - 60.0 * x2) * square * square
            + pi6 * square * square * square * (5.0 - 30.0 * x2))
            * e;
    }
    let (mut k2_whole, mut k3_whole) = (0.0, 0.0);
    for k in 1..20 {
        let square = f64::from(k * k);
        let e = libm::exp(-pi2 * square / (2.0 * x2));
        k2_whole += square * e;
        k3_whole += (3.0 * pi2 * square * x2 - pi4 * square * square) * e;
    }
    let k0 = k0 * (2.0 * PI).sqrt() / x;
    let k1 = k1 * half / (3.0 * x4);
    let k2 = k2 * half / (36.0 * x.powi(7)) - k2_whole * pi2 * half / (18.0 * x.powi(3));
    let k3 = k3 * half / (3240.0 * x.powi(10)) + k3_whole * half / (108.0 * x6);
    k0 + k1 / root + k2 / n + k3 / (n * root)
}

/// Exact: the share of lattice paths from (0, 0) to (n, m) that leave the strip of half width d.
fn path_counting(d: f64, n: usize, m: usize) -> f64 {
    let (rows, columns) = (n as f64, m as f64);
    // Distances are whole multiples of 1/(n m); half of one decides what counts as reaching d.
    let limit = d - 0.5 / (rows * columns);
    let inside = |i: usize, j: usize| (i as f64 / rows - j as f64 / columns).abs() < limit;
    // Probability that a random path passes through (i, j) and has stayed inside: from the left with j/(i+j), ...
    let mut line = vec![0.0; m + 1];
    for i in 0..=n {
        for j in 0..=m {
            let value = if !inside(i, j) {
                0.0
            } else if i == 0 && j == 0 {
                1.0
            } else {
                // A path at (i, j) came from (i-1, j) with i/(i+j) and from (i, j-1) with j/(i+j), as all orders are alike.
                let steps = (i + j) as f64;
                let from_above = if i > 0 {
                    line[j] * i as f64 / steps
                } else {
                    0.0
                };
                let from_left = if j > 0 {
                    line[j - 1] * j as f64 / steps
                } else {
                    0.0
                };
                from_above + from_left
            };
            line[j] = value;
        }
    }
    (1.0 - line[m]).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_number_and_two_have_their_closed_forms() {
        // n = 1: D = max(u, 1 - u), P(D > d) = 2 - 2 d for d > 1/2.
        for d in [0.5, 0.6, 0.75, 0.99] {
            assert!(
                (kolmogorov_tail(d, 1) - (2.0 - 2.0 * d)).abs() < 1e-12,
                "{d}"
            );
        }
        // n = 2, 1/4 < d < 1/2: P(D < d) = 2 (2 d - 1/2)^2; above 1/2: 1 - 2 (1 - d)^2.
        assert!((kolmogorov_tail(0.4, 2) - (1.0 - 2.0 * 0.3 * 0.3)).abs() < 1e-12);
        assert!((kolmogorov_tail(0.7, 2) - 2.0 * 0.09).abs() < 1e-12);
    }

    #[test]
    fn the_ways_agree_where_they_meet() {
        // Marsaglia, Tsang and Wang print P(D_10 < 0.274) = 0.6284796154565043.
        assert!((kolmogorov_tail(0.274, 10) - (1.0 - 0.628_479_615_456_504_3)).abs() < 1e-12);
        for n in [141, 200, 1000] {
            for x in [0.6, 0.8, 1.0, 1.2, 1.4] {
                let d = x / f64::sqrt(n as f64);
                let exact = 1.0 - durbin(d, n);
                let series = 1.0 - pelz_good(d, n as f64);
                assert!((exact - series).abs() < 1e-5, "{n} {x}: {exact} {series}");
            }
            // Where the tail takes over, at n d^2 = 2.2 (p = 0.02), both sides exceed with about 2 exp(-8 n d^2) = 5e-8.
            let d = (2.2 / n as f64).sqrt();
            let exact = 1.0 - durbin(d, n);
            assert!((2.0 * one_sided(d, n) - exact).abs() < 1e-6, "{n}: {exact}");
        }
    }

    #[test]
    fn large_samples_have_the_limit() {
        // The 5 % point of the limit is 1.3581.
        let n = 1_000_000;
        assert!((kolmogorov_tail(1.358_1 / 1e3, n) - 0.05).abs() < 1e-4);
        // Stephens' correction moves x by 0.12 / sqrt(5e4), and p by -4 x^2 times that share: 2e-4.
        assert!(
            (two_sample_kolmogorov_tail(1.358_1 * (2.0 / 1e5_f64).sqrt(), 100_000, 100_000) - 0.05)
                .abs()
                < 3e-4
        );
        assert!(kolmogorov_tail(0.2096, 5763) < 1e-200);
        assert_eq!(kolmogorov_tail(0.0, 10), 1.0);
        assert_eq!(kolmogorov_tail(1.0, 10), 0.0);
    }

    #[test]
    fn few_numbers_in_two_samples_are_counted() {
        // n = m = 2: 6 orders; D = 1 in 2 of them (aabb, bbaa), else 1/2.
        assert!((two_sample_kolmogorov_tail(1.0, 2, 2) - 2.0 / 6.0).abs() < 1e-15);
        assert!((two_sample_kolmogorov_tail(0.5, 2, 2) - 1.0).abs() < 1e-15);
        // Exact against the limit at 300 and 400.
        let d = 0.09;
        let exact = path_counting(d, 300, 400);
        let root = (300.0 * 400.0 / 700.0_f64).sqrt();
        assert!((exact - limit_tail((root + 0.12 + 0.11 / root) * d)).abs() < 0.01);
    }
}
