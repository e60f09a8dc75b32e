//! The table of the reference data, and closed forms.

use super::*;
use crate::sample::Sample;
use crate::test_support::{apapm, lactose, law};

fn assert_digits(got: f64, expected: f64, digits: i32, what: &str) {
    let tolerance = 0.51 * 10.0_f64.powi(1 - digits);
    assert!(
        (got / expected - 1.0).abs() < tolerance,
        "{what}: {got} {expected}"
    );
}

/// index.md: quantiles that are linear on the converted curve, as MercuryDPM has them, of all four weightings.
#[test]
fn mercury_quantiles_of_the_reference_data() {
    let (Some(apapm), Some(lactose)) = (apapm(), lactose()) else {
        return;
    };
    let apapm = Statistics::of(&Sizes::Distribution(apapm, None), Quantiles::Mercury);
    let lactose = Statistics::of(&Sizes::Distribution(lactose, None), Quantiles::Mercury);
    for (statistics, rows) in [
        (
            &apapm,
            [
                [1.016_179_91e-3, 1.822_554_37e-3, 2.953_337_52e-3, 1.062_881],
                [1.142_596_76e-3, 2.177_713_31e-3, 3.307_872_41e-3, 0.994_289],
                [1.396_261_48e-3, 2.471_059_79e-3, 3.633_200_72e-3, 0.905_255],
                [1.771_810_55e-3, 2.738_423_39e-3, 3.931_538_39e-3, 0.788_676],
            ],
        ),
        (
            &lactose,
            [
                [1.083_907_28e-5, 2.561_977_59e-5, 9.599_086_62e-5, 3.323_674],
                [1.806_895_04e-5, 6.931_019_99e-5, 1.566_713_46e-4, 1.999_740],
                [4.441_452_60e-5, 1.093_447_13e-4, 2.178_390_28e-4, 1.586_035],
                [7.426_692_58e-5, 1.494_331_29e-4, 2.861_555_68e-4, 1.417_950],
            ],
        ),
    ] {
        for (row, [d10, d50, d90, span]) in statistics.rows.iter().zip(rows) {
            let what = row.weighting.word();
            assert_digits(row.d10, d10, 9, what);
            assert_digits(row.d50, d50, 9, what);
            assert_digits(row.d90, d90, 9, what);
            assert_digits(row.span(), span, 6, what);
        }
    }
    let mean = |statistics: &Statistics, p, q| {
        let found = statistics
            .means
            .iter()
            .find(|mean| (mean.0, mean.1) == (p, q));
        found.expect("a mean").2
    };
    assert_digits(mean(&apapm, 3, 2), 2.521_314_55e-3, 9, "D[3,2]");
    assert_digits(mean(&apapm, 4, 3), 2.800_886_48e-3, 9, "D[4,3]");
    assert_digits(mean(&apapm, 3, 0), 2.199_814_58e-3, 9, "D[3,0]");
    assert_digits(mean(&lactose, 3, 2), 1.243_103_16e-4, 9, "D[3,2]");
    assert_digits(mean(&lactose, 4, 3), 1.785_345_16e-4, 9, "D[4,3]");
    assert_digits(apapm.specific_surface, 6.0 / 2.521_314_55e-3, 9, "surface");
}

#[test]
fn exact_quantiles_of_a_lognormal_law() {
    // Hatch and Choate: the median by d^k is larger by exp(k s^2); D[p,q] = median exp((p + q) s^2 / 2).
    let s = 0.25_f64;
    let sizes =
        law("kind = \"lognormal\"\nmedian_diameter = 2e-3\nsigma = 0.25\nweighting = \"number\"");
    let statistics = Statistics::of(&Sizes::Distribution(sizes, None), Quantiles::Exact);
    for (k, row) in statistics.rows.iter().enumerate() {
        let median = 2e-3 * (k as f64 * s * s).exp();
        // The open ends leave out 1e-9 at 6 sigma; by volume that is at 6 - 3 s sigma.
        assert!((row.d50 / median - 1.0).abs() < 1e-6, "{k}");
    }
    for (p, q, d) in &statistics.means {
        let expected = 2e-3 * (f64::from(p + q) * s * s / 2.0).exp();
        assert!((d / expected - 1.0).abs() < 1e-5, "{p} {q}");
    }
}

#[test]
fn coefficients_of_a_uniform_law_and_a_sample() {
    // d = 1 + u: d10 = 1.1, d30 = 1.3, d60 = 1.6, d90 = 1.9; skewness 0, deviation 1/sqrt(12).
    let sizes =
        law("kind = \"uniform\"\nmin_diameter = 1.0\nmax_diameter = 2.0\nweighting = \"number\"");
    let row = Statistics::of(&Sizes::Distribution(sizes, None), Quantiles::Exact).rows[0];
    assert!((row.span() - 0.8 / 1.5).abs() < 1e-14);
    assert!((row.uniformity() - 1.6 / 1.1).abs() < 1e-14);
    assert!((row.curvature() - 1.69 / (1.1 * 1.6)).abs() < 1e-14);
    assert!((row.deviation - 1.0 / 12.0_f64.sqrt()).abs() < 1e-14);
    assert!(row.skewness.abs() < 1e-12);
    let sample = Sizes::Sample(Sample::new(vec![1.0; 3]).expect("sizes"));
    let row = Statistics::of(&sample, Quantiles::Exact).rows[3];
    assert_eq!(
        (row.d10, row.d90, row.deviation, row.skewness),
        (1.0, 1.0, 0.0, 0.0)
    );
}

#[test]
fn numbers_for_people() {
    for (number, text) in [
        (0.0, "0"),
        (1.0, "1"),
        (1234.5678, "1234.57"),
        (0.000_123_456_78, "0.000123457"),
        (1.5e-9, "1.5e-9"),
        (123_456_789.0, "1.23457e8"),
        (-2.5, "-2.5"),
        (f64::INFINITY, "inf"),
    ] {
        assert_eq!(significant(number, 6), text);
    }
    assert_eq!(Unit::for_length(2.5e-3).show(2.5e-3), "2.5");
    assert_eq!(Unit::for_length(2.5e-5).name, "um");
    assert_eq!(Unit::for_length(1e-12).name, "nm");
}
