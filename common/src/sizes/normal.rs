//! The standard normal law: cumulative distribution and its inverse.

use std::f64::consts::PI;

/// Share of the standard normal law below `x`; relative accuracy about 1e-14 in the lower tail.
///
/// Near the middle the power series 1/2 + phi(x) (x + x^3/3 + x^5/(3*5) + ...), further out the
/// continued fraction of the tail phi(x)/(x + 1/(x + 2/(x + 3/(x + ...)))); Abramowitz and Stegun
/// 1964, eqs 26.2.11 and 26.2.14.
///
/// ```
/// use mercury_common::sizes::normal_cdf;
/// assert_eq!(normal_cdf(0.0), 0.5);
/// assert!((normal_cdf(1.959963984540054) - 0.975).abs() < 1e-15);
/// ```
#[must_use]
pub fn normal_cdf(x: f64) -> f64 {
    if x.is_nan() {
        return x;
    }
    let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    if x.abs() < 2.0 {
        let mut term = x;
        let mut sum = x;
        let mut odd = 1.0;
        // For |x| < 2 the terms fall below the last digit after some 30.
        while term.abs() > 1e-17 * sum.abs() && odd < 199.0 {
            odd += 2.0;
            term *= x * x / odd;
            sum += term;
        }
        return 0.5 + density * sum;
    }
    if density == 0.0 {
        return if x > 0.0 { 1.0 } else { 0.0 };
    }
    // Evaluated from the end: 200 levels are ample for |x| >= 2.
    let far = x.abs();
    let mut fraction = far;
    for level in (1..=200).rev() {
        fraction = far + f64::from(level) / fraction;
    }
    let tail = density / fraction;
    if x > 0.0 { 1.0 - tail } else { tail }
}

/// The x below which a share `p` of the standard normal law lies; infinite at 0 and 1, NaN outside.
///
/// Algorithm AS 241, routine PPND16 (Wichura 1988, Appl. Stat. 37, 477, doi:10.2307/2347330),
/// accurate to about 1e-16.
///
/// ```
/// use mercury_common::sizes::normal_quantile;
/// assert!((normal_quantile(0.975) - 1.959963984540054).abs() < 1e-15);
/// ```
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    let centred = p - 0.5;
    if centred.abs() <= 0.425 {
        let r = 0.180_625 - centred * centred;
        return centred * horner(&MIDDLE_OVER, r) / horner(&MIDDLE_UNDER, r);
    }
    let tail = if centred < 0.0 { p } else { 1.0 - p };
    if tail == 0.0 {
        return if centred < 0.0 {
            f64::NEG_INFINITY
        } else {
            f64::INFINITY
        };
    }
    let r = (-tail.ln()).sqrt();
    let x = if r <= 5.0 {
        horner(&TAIL_OVER, r - 1.6) / horner(&TAIL_UNDER, r - 1.6)
    } else {
        horner(&FAR_OVER, r - 5.0) / horner(&FAR_UNDER, r - 5.0)
    };
    if centred < 0.0 { -x } else { x }
}

/// A polynomial with the given coefficients, lowest power first.
fn horner(coefficients: &[f64; 8], x: f64) -> f64 {
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * x + coefficient)
}

const MIDDLE_OVER: [f64; 8] = [
    3.387_132_872_796_366_5,
    1.331_416_678_917_843_8e2,
    1.971_590_950_306_551_3e3,
    1.373_169_376_550_946e4,
    4.592_195_393_154_987e4,
    6.726_577_092_700_87e4,
    3.343_057_558_358_813e4,
    2.509_080_928_730_122_7e3,
];
const MIDDLE_UNDER: [f64; 8] = [
    1.0,
    4.231_333_070_160_091e1,
    6.871_870_074_920_579e2,
    5.394_196_021_424_751e3,
    2.121_379_430_158_659_7e4,
    3.930_789_580_009_271e4,
    2.872_908_573_572_194_3e4,
    5.226_495_278_852_854e3,
];
const TAIL_OVER: [f64; 8] = [
    1.423_437_110_749_683_5,
    4.630_337_846_156_546,
    5.769_497_221_460_691,
    3.647_848_324_763_204_5,
    1.270_458_252_452_368_4,
    2.417_807_251_774_506e-1,
    2.272_384_498_926_918_4e-2,
    7.745_450_142_783_414e-4,
];
const TAIL_UNDER: [f64; 8] = [
    1.0,
    2.053_191_626_637_759,
    1.676_384_830_183_803_8,
    6.897_673_349_851e-1,
    1.481_039_764_274_800_8e-1,
    1.519_866_656_361_645_7e-2,
    5.475_938_084_995_345e-4,
    1.050_750_071_644_416_9e-9,
];
const FAR_OVER: [f64; 8] = [
    6.657_904_643_501_103,
    5.463_784_911_164_114,
    1.784_826_539_917_291_3,
    2.965_605_718_285_048_7e-1,
    2.653_218_952_657_612_4e-2,
    1.242_660_947_388_078_4e-3,
    2.711_555_568_743_487_6e-5,
    2.010_334_399_292_288_1e-7,
];
const FAR_UNDER: [f64; 8] = [
    1.0,
    5.998_322_065_558_88e-1,
    1.369_298_809_227_358e-1,
    1.487_536_129_085_061_5e-2,
    7.868_691_311_456_133e-4,
    1.846_318_317_510_054_8e-5,
    1.421_511_758_316_446e-7,
    2.044_263_103_389_939_8e-15,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the tables of Abramowitz and Stegun 1964 (26.1, 26.2) and of the tail
    /// Q(6) = 9.865876450376981e-10, which any arithmetic of 30 digits confirms.
    #[test]
    fn known_values() {
        let known = [
            (-6.0, 9.865_876_450_376_98e-10),
            (-3.0, 1.349_898_031_630_094_6e-3),
            (-1.0, 1.586_552_539_314_570_5e-1),
            (0.5, 6.914_624_612_740_131e-1),
            (2.5, 9.937_903_346_742_24e-1),
        ];
        for (x, share) in known {
            let relative = (normal_cdf(x) / share - 1.0).abs();
            assert!(relative < 2e-14, "{x}: {} {share}", normal_cdf(x));
        }
        assert_eq!(normal_cdf(f64::INFINITY), 1.0);
        assert_eq!(normal_cdf(f64::NEG_INFINITY), 0.0);
    }

    #[test]
    fn quantile_inverts_the_cdf() {
        for i in -800..=0 {
            let x = f64::from(i) * 0.01;
            let back = normal_quantile(normal_cdf(x));
            // dx = dp / density: both sides carry some 1e-14 of the share itself.
            assert!((back - x).abs() < 1e-13 * (1.0 + x.abs()), "{x} {back}");
        }
        assert_eq!(normal_quantile(0.0), f64::NEG_INFINITY);
        assert_eq!(normal_quantile(1.0), f64::INFINITY);
        assert!(normal_quantile(1.1).is_nan());
        assert!(normal_quantile(f64::NAN).is_nan());
    }
}
