//! The standard normal law: cumulative distribution and its inverse, shared by all code that samples or tests it.
//!
//! Elementary functions are libm's: what is drawn through them is the same on every system.
#![expect(
    clippy::excessive_precision,
    reason = "the coefficients are printed as in the paper"
)]

use std::f64::consts::PI;

/// Share of the standard normal law below `x`; relative accuracy about 1e-14 in the lower tail.
///
/// Near the middle the power series 1/2 + phi(x) (x + x^3/3 + x^5/(3*5) + ...), further out the
/// continued fraction of the tail phi(x)/(x + 1/(x + 2/(x + 3/(x + ...)))); Abramowitz and Stegun
/// 1964, eqs 26.2.11 and 26.2.14.
///
/// ```
/// use mercury_common::normal::normal_cdf;
/// assert_eq!(normal_cdf(0.0), 0.5);
/// assert!((normal_cdf(1.959963984540054) - 0.975).abs() < 1e-15);
/// ```
#[must_use]
pub fn normal_cdf(x: f64) -> f64 {
    if x.is_nan() {
        return x;
    }
    let density = libm::exp(-0.5 * x * x) / (2.0 * PI).sqrt();
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

/// The number that a standard normal variable stays below with probability `p`.
///
/// Algorithm AS 241, routine PPND16 (Wichura 1988, *The percentage points of the normal distribution*, Applied
/// Statistics 37, 477-484): relative accuracy about 1e-16. -infinity at 0, infinity at 1, NaN outside `[0, 1]`.
///
/// ```
/// use mercury_common::normal::normal_quantile;
/// assert!((normal_quantile(0.975) - 1.959963984540054).abs() < 1e-15);
/// ```
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180_625 - q * q;
        return q * polynomial(&CENTRE_NUMERATOR, r) / polynomial(&CENTRE_DENOMINATOR, r);
    }
    let tail = if q < 0.0 { p } else { 1.0 - p };
    let magnitude = if tail > 0.0 {
        let r = (-libm::log(tail)).sqrt();
        if r <= 5.0 {
            let r = r - 1.6;
            polynomial(&MIDDLE_NUMERATOR, r) / polynomial(&MIDDLE_DENOMINATOR, r)
        } else {
            let r = r - 5.0;
            polynomial(&FAR_NUMERATOR, r) / polynomial(&FAR_DENOMINATOR, r)
        }
    } else if tail == 0.0 {
        f64::INFINITY
    } else {
        f64::NAN
    };
    if q < 0.0 { -magnitude } else { magnitude }
}

/// Coefficients from the constant up, by Horner's rule.
fn polynomial(coefficients: &[f64; 8], x: f64) -> f64 {
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * x + coefficient)
}

const CENTRE_NUMERATOR: [f64; 8] = [
    3.387_132_872_796_366_608,
    1.331_416_678_917_843_774_5e2,
    1.971_590_950_306_551_442_7e3,
    1.373_169_376_550_946_112_5e4,
    4.592_195_393_154_987_145_7e4,
    6.726_577_092_700_870_085_3e4,
    3.343_057_558_358_812_810_5e4,
    2.509_080_928_730_122_672_7e3,
];
const CENTRE_DENOMINATOR: [f64; 8] = [
    1.0,
    4.231_333_070_160_091_125_2e1,
    6.871_870_074_920_579_083e2,
    5.394_196_021_424_751_107_7e3,
    2.121_379_430_158_659_586_7e4,
    3.930_789_580_009_271_061e4,
    2.872_908_573_572_194_267_4e4,
    5.226_495_278_852_854_561e3,
];
const MIDDLE_NUMERATOR: [f64; 8] = [
    1.423_437_110_749_683_577_34,
    4.630_337_846_156_545_295_9,
    5.769_497_221_460_691_405_5,
    3.647_848_324_763_204_605_04,
    1.270_458_252_452_368_382_58,
    2.417_807_251_774_506_117_7e-1,
    2.272_384_498_926_918_458_33e-2,
    7.745_450_142_783_414_076_4e-4,
];
const MIDDLE_DENOMINATOR: [f64; 8] = [
    1.0,
    2.053_191_626_637_758_821_87,
    1.676_384_830_183_803_849_4,
    6.897_673_349_851_000_045_5e-1,
    1.481_039_764_274_800_745_9e-1,
    1.519_866_656_361_645_719_66e-2,
    5.475_938_084_995_344_946e-4,
    1.050_750_071_644_416_843_24e-9,
];
const FAR_NUMERATOR: [f64; 8] = [
    6.657_904_643_501_103_777_2,
    5.463_784_911_164_114_369_9,
    1.784_826_539_917_291_335_8,
    2.965_605_718_285_048_912_3e-1,
    2.653_218_952_657_612_309_3e-2,
    1.242_660_947_388_078_438_6e-3,
    2.711_555_568_743_487_578_15e-5,
    2.010_334_399_292_288_132_65e-7,
];
const FAR_DENOMINATOR: [f64; 8] = [
    1.0,
    5.998_322_065_558_879_376_9e-1,
    1.369_298_809_227_358_053_1e-1,
    1.487_536_129_085_061_485_25e-2,
    7.868_691_311_456_132_591e-4,
    1.846_318_317_510_054_681_8e-5,
    1.421_511_758_316_445_888_7e-7,
    2.044_263_103_389_939_785_64e-15,
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

    #[test]
    fn quantiles_of_the_normal_distribution() {
        // Solved from the error function with 60 digits, for the exact value of each binary p.
        for (p, expected) in [
            (0.4, -0.2533471031357997),
            (0.25, -0.6744897501960817),
            (0.0751, -1.43882539275254),
            (0.0749, -1.4402382675279637),
            (0.025, -1.9599639845400543),
            (0.001, -3.0902323061678136),
            (1e-5, -4.264890793922825),
            (1.4e-11, -6.656723091518184),
            (1e-12, -7.034483825301132),
            (1e-20, -9.262340089798407),
            (1e-100, -21.273453560965326),
            (1e-300, -37.0470962993612),
        ] {
            let found = normal_quantile(p);
            assert!(
                (found / expected - 1.0).abs() < 1e-15,
                "{p}: {found} {expected}"
            );
        }
        assert_eq!(normal_quantile(0.5), 0.0);
        assert_eq!(normal_quantile(0.75), -normal_quantile(0.25));
        assert_eq!(normal_quantile(0.0), f64::NEG_INFINITY);
        assert_eq!(normal_quantile(1.0), f64::INFINITY);
        for outside in [-0.1, 1.1, f64::NAN] {
            assert!(normal_quantile(outside).is_nan());
        }
    }
}
