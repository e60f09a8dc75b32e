//! exp for tables of Gaussians: as good as the library's, and several at a time.

use std::f64::consts::LOG2_E;

/// ln 2 in two parts, of which the first has so few digits that its multiples are exact (Cody & Waite 1980).
const LN_2_HIGH: f64 = 6.931_471_803_691_238_16e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_70e-10;
/// Added to a number it rounds it to a whole one, which then stands in the last bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// exp(x) to 1e-15 relative, for x from -700 to 700; beyond, as at these ends.
///
/// exp(x) = 2^k exp(r) with |r| <= ln 2 / 2, and Taylor's polynomial of degree 13 for exp(r). No branch and no table, so that the processor
/// works on several of them at once.
#[inline(always)]
pub(crate) fn exponential(x: f64) -> f64 {
    let x = x.clamp(-700.0, 700.0);
    let rounded = x * LOG2_E + ROUND;
    let k = rounded - ROUND;
    let r = (x - k * LN_2_HIGH) - k * LN_2_LOW;
    let r2 = r * r;
    let r4 = r2 * r2;
    let r8 = r4 * r4;
    // Estrin's scheme: pairs, then pairs of pairs.
    let a = (1.0 + r) + r2 * (1.0 / 2.0 + r * (1.0 / 6.0));
    let b = (1.0 / 24.0 + r * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + r * (1.0 / 5_040.0));
    let c = (1.0 / 40_320.0 + r * (1.0 / 362_880.0))
        + r2 * (1.0 / 3_628_800.0 + r * (1.0 / 39_916_800.0));
    let d = 1.0 / 479_001_600.0 + r * (1.0 / 6_227_020_800.0);
    let value = (a + r4 * b) + r8 * (c + r4 * d);
    // The last bits of `rounded` are k; moved up they are the exponent of 2^k.
    let power = f64::from_bits((rounded.to_bits().wrapping_add(1023)) << 52);
    value * power
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::exponential;

    #[test]
    fn whole_numbers_and_ends() {
        assert_eq!(exponential(0.0), 1.0);
        assert!((exponential(1.0) / std::f64::consts::E - 1.0).abs() < 3e-16);
        assert_eq!(exponential(-1e9), exponential(-700.0));
        assert!(exponential(-700.0) < 1e-300 && exponential(f64::INFINITY).is_finite());
    }

    proptest! {
        #[test]
        fn it_is_the_exponential(x in -690.0..690.0f64) {
            prop_assert!((exponential(x) / libm::exp(x) - 1.0).abs() < 1e-15, "{x}");
        }

        #[test]
        fn near_zero_too(x in -1.0..1.0f64) {
            prop_assert!((exponential(x) / libm::exp(x) - 1.0).abs() < 6e-16, "{x}");
        }
    }
}
