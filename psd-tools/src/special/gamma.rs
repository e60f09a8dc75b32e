//! The incomplete gamma function.

/// The probability that chi-square with `degrees` degrees of freedom exceeds `x`.
///
/// Q(a, y), a = degrees/2, y = x/2: by its power series below y = a + 1, by Lentz's continued fraction above (Abramowitz and
/// Stegun 1964, eqs 6.5.29 and 6.5.31).
///
/// ```
/// use mercury_psd::special::chi_square_tail;
/// // Two degrees of freedom: exp(-x/2).
/// assert!((chi_square_tail(3.0, 2.0) - (-1.5_f64).exp()).abs() < 1e-15);
/// ```
#[must_use]
pub fn chi_square_tail(x: f64, degrees: f64) -> f64 {
    if x.is_nan() || degrees <= 0.0 {
        return f64::NAN;
    }
    if x <= 0.0 {
        return 1.0;
    }
    if x == f64::INFINITY {
        return 0.0;
    }
    let (a, y) = (0.5 * degrees, 0.5 * x);
    let front = libm::exp(a * libm::log(y) - y - libm::lgamma(a));
    if y < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        let mut n = a;
        while term > 1e-17 * sum {
            n += 1.0;
            term *= y / n;
            sum += term;
        }
        return (1.0 - front * sum).max(0.0);
    }
    const TINY: f64 = 1e-300;
    let mut b = y + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for i in 1..10_000 {
        let i = f64::from(i);
        let numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / avoid_zero(numerator * d + b, TINY);
        c = avoid_zero(b + numerator / c, TINY);
        let change = c * d;
        fraction *= change;
        if (change - 1.0).abs() < 1e-16 {
            break;
        }
    }
    front * fraction
}

fn avoid_zero(x: f64, tiny: f64) -> f64 {
    if x.abs() < tiny { tiny } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_degrees_are_poisson_sums() {
        // Q(n, y) = exp(-y) sum over i < n of y^i / i!
        for n in [1, 2, 5, 23] {
            for y in [0.1, 1.0, 4.0, 20.0, 60.0] {
                let (mut term, mut sum) = (1.0, 1.0);
                for i in 1..n {
                    term *= y / f64::from(i);
                    sum += term;
                }
                let expected = (-y).exp() * sum;
                let got = chi_square_tail(2.0 * y, f64::from(2 * n));
                // Near 1 the series is subtracted from 1.
                assert!((got - expected).abs() < 1e-13, "{n} {y}: {got} {expected}");
                assert!((got / expected - 1.0).abs() < 1e-11 || expected > 0.5);
            }
        }
    }

    #[test]
    fn one_degree_is_the_normal_law() {
        // P(Z^2 > 1.959964^2) = 0.05.
        let z = mercury_common::normal::normal_quantile(0.975);
        assert!((chi_square_tail(z * z, 1.0) - 0.05).abs() < 1e-14);
        assert_eq!(chi_square_tail(0.0, 3.0), 1.0);
        assert_eq!(chi_square_tail(f64::INFINITY, 3.0), 0.0);
    }
}
