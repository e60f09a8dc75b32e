//! Moments against closed forms, samples against the law, and what cannot be drawn.

use super::*;
use crate::sizes::SizeDistribution;
use proptest::prelude::*;

/// A law with what is drawn from it.
#[derive(Debug)]
struct Drawn {
    law: Law,
    power: i32,
    bounds: [f64; 2],
    sizes: SizeDistribution,
}

impl std::ops::Deref for Drawn {
    type Target = SizeDistribution;

    fn deref(&self) -> &SizeDistribution {
        &self.sizes
    }
}

fn drawn(law: Law, power: i32, cut: Option<[f64; 2]>) -> Result<Drawn, String> {
    let cut = CutLaw::new(law, power, cut)?;
    let stated = Weighting::ALL[power as usize];
    Ok(Drawn {
        law,
        power,
        bounds: cut.bounds,
        sizes: SizeDistribution::of_law(cut, stated),
    })
}

fn distribution(law: Law, power: i32, cut: Option<[f64; 2]>) -> Drawn {
    drawn(law, power, cut).expect("a proper law")
}

/// One of each family, in each weighting, with and without cut.
fn all() -> Vec<Drawn> {
    let laws = [
        Law::Monodisperse(2e-3),
        Law::Uniform {
            min: 1e-3,
            max: 3e-3,
        },
        Law::Normal {
            mean: 2e-3,
            deviation: 2e-4,
        },
        Law::Lognormal {
            median: 3e-3,
            sigma: 0.2,
        },
        Law::RosinRammler {
            d63: 1e-3,
            exponent: 3.7,
        },
        Law::Power {
            max: 1e-3,
            exponent: 3.2,
        },
    ];
    let mut all = Vec::new();
    for law in laws {
        for power in 0..=3 {
            for cut in [None, Some([0.01, 0.95])] {
                all.push(distribution(law, power, cut));
            }
        }
    }
    all
}

/// The mean of d^j by number from the stated law alone: integral of d^(j-k) over its quantiles divided
/// by that of d^-k, midpoint rule of n points.
fn moment_by_quantiles(sizes: &Drawn, j: i32) -> f64 {
    let n = 200_000;
    let mut sums = [0.0; 2];
    for i in 0..n {
        let d = sizes.quantile((f64::from(i) + 0.5) / f64::from(n));
        sums[0] += d.powi(j - sizes.power);
        sums[1] += d.powi(-sizes.power);
    }
    sums[0] / sums[1]
}

#[test]
fn moments_follow_from_the_stated_law() {
    for sizes in all() {
        for j in [1, 3] {
            // The midpoint rule misses about 1/n of the open ends, more where d^-3 grows there: for the
            // power laws (d^-3 ~ q^(-3/3.2)) its error falls only as n^(-1 + 3/3.2).
            let is_rough = sizes.bounds[0] < 0.01
                && matches!(sizes.law, Law::Power { .. } | Law::RosinRammler { .. });
            if is_rough {
                continue;
            }
            let expected = moment_by_quantiles(&sizes, j);
            let relative = (sizes.moment(j) / expected - 1.0).abs();
            assert!(relative < 2e-5, "{sizes:?} {j}: {relative}");
        }
    }
}

#[test]
fn lognormal_moments_are_those_of_hatch_and_choate() {
    let (median, sigma) = (3e-3_f64, 0.2_f64);
    for power in 0..=3 {
        let sizes = distribution(Law::Lognormal { median, sigma }, power, None);
        let number_median = median * (-f64::from(power) * sigma * sigma).exp();
        let mean = number_median * (0.5 * sigma * sigma).exp();
        let cube = number_median.powi(3) * (4.5 * sigma * sigma).exp();
        // Share of the open ends: 1e-9 at +-6 sigma of the stated law, which is at 6 - 3 * 0.2 = 5.4 sigma of the others, 3e-8,
        // times d / mean <= exp(6 * 3 * 0.2).
        assert!((sizes.mean_diameter() / mean - 1.0).abs() < 3e-7);
        assert!((sizes.mean_volume() / (PI / 6.0 * cube) - 1.0).abs() < 2e-6);
        assert!((sizes.quantile(0.5) / median - 1.0).abs() < 1e-14);
        assert!((sizes.sample_diameter(0.5) / number_median - 1.0).abs() < 1e-7);
    }
}

#[test]
fn rosin_rammler_by_volume_has_the_moments_of_the_gamma_function() {
    // By volume with exponent 6: <d^-3>_3 = Gamma(1 - 3/6) / d63^3 = sqrt(pi) / d63^3, and the mean of
    // d^3 by number is its inverse. Open ends: t^(-1/2) below 1e-9 holds 2 sqrt(1e-9) of sqrt(pi).
    let sizes = distribution(
        Law::RosinRammler {
            d63: 2.0,
            exponent: 6.0,
        },
        3,
        None,
    );
    let left_out = 2.0 * 1e-9_f64.sqrt() / PI.sqrt();
    let expected = 8.0 / PI.sqrt() * (1.0 + left_out);
    assert!(
        (sizes.moment(3) / expected - 1.0).abs() < 1e-8,
        "{} {expected}",
        sizes.moment(3)
    );
    // By number with exponent 1: the exponential law, mean d63, mean cube 6 d63^3; cut at t = 20.7,
    // where t^3 exp(-t) leaves out (t^3 + 3 t^2 + 6 t + 6) 1e-9 of 6.
    let sizes = distribution(
        Law::RosinRammler {
            d63: 2.0,
            exponent: 1.0,
        },
        0,
        None,
    );
    assert!((sizes.moment(1) / 2.0 - 1.0).abs() < 3e-8);
    assert!((sizes.moment(3) / 48.0 - 1.0).abs() < 2e-6);
}

#[test]
fn power_law_moments() {
    // By volume with exponent 4: q_0 ~ d^3 / d^3 = constant on [a, b], a = 0.01^(1/4).
    let sizes = distribution(
        Law::Power {
            max: 1.0,
            exponent: 4.0,
        },
        3,
        Some([0.01, 1.0]),
    );
    let a = 0.01_f64.powf(0.25);
    assert!((sizes.mean_diameter() - 0.5 * (a + 1.0)).abs() < 1e-14);
    assert!((sizes.moment(3) - 0.25 * (a + 1.0) * (a * a + 1.0)).abs() < 1e-14);
    // With exponent 3: q_0 ~ 1/d, mean (b - a) / ln(b/a).
    let sizes = distribution(
        Law::Power {
            max: 1.0,
            exponent: 3.0,
        },
        3,
        Some([0.01, 1.0]),
    );
    let a = 0.01_f64.powf(1.0 / 3.0);
    assert!((sizes.mean_diameter() - (1.0 - a) / (1.0 / a).ln()).abs() < 1e-14);
}

#[test]
fn samples_invert_the_number_cdf() {
    for sizes in all() {
        if matches!(sizes.law, Law::Monodisperse(_)) {
            assert_eq!(sizes.sample_diameter(0.3), 2e-3);
            continue;
        }
        let mut last = 0.0;
        for i in 0..=400 {
            let u = f64::from(i) / 400.0;
            let d = sizes.sample_diameter(u);
            assert!(d > last, "{sizes:?}: not increasing at {u}");
            last = d;
            let back = sizes.number_cdf(d);
            // ln d is known to round-off (d is about exp(-7), so 1e-15 absolute in ln d), and the
            // share changes by at most some 40 per unit of ln d for the narrowest law here.
            assert!((back - u).abs() < 1e-12, "{sizes:?}: {u} {back}");
        }
        assert_eq!(sizes.sample_diameter(0.0), sizes.smallest());
        assert_eq!(sizes.sample_diameter(1.0), sizes.largest());
    }
}

/// The multiples of the golden ratio have a discrepancy of at most (3 + 3.53 ln N) / N (Kuipers and
/// Niederreiter 1974, theorem 3.4 of chapter 2, all partial quotients 1); what is drawn with them has
/// the same Kolmogorov distance from its law. A law of the wrong weighting is off by several times that.
#[test]
fn drawn_samples_keep_the_kolmogorov_bound() {
    let n: u32 = 2000;
    let bound = (3.0 + 3.53 * f64::from(n).ln()) / f64::from(n);
    for sizes in all() {
        if matches!(sizes.law, Law::Monodisperse(_)) {
            continue;
        }
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let mut drawn: Vec<f64> = (1..=n)
            .map(|i| sizes.sample_diameter((f64::from(i) * golden).fract()))
            .collect();
        drawn.sort_by(f64::total_cmp);
        // The share by number below d, from the stated law: integral of d^-k over its quantiles.
        let m = 20_000;
        let diameters: Vec<f64> = (0..m)
            .map(|i| sizes.quantile((f64::from(i) + 0.5) / f64::from(m)))
            .collect();
        if sizes.bounds[0] < 0.01 && sizes.power > 1 {
            continue;
        }
        let total: f64 = diameters.iter().map(|d| d.powi(-sizes.power)).sum();
        let mut below = 0.0;
        for d in diameters {
            below += d.powi(-sizes.power);
            let rank = drawn.partition_point(|&drawn| drawn <= d) as f64 / f64::from(n);
            // 1e-3: each quantile stands for a step of the sum, of at most 20 / m for these laws.
            assert!((rank - below / total).abs() < bound + 1e-3, "{sizes:?} {d}");
        }
    }
}

#[test]
fn uniform_by_volume_has_the_closed_quantiles() {
    // q_0 ~ 1/d^3 on [1, 2]: F = (1 - 1/d^2) / (3/4).
    let sizes = distribution(Law::Uniform { min: 1.0, max: 2.0 }, 3, None);
    for u in [0.0, 0.1, 0.5, 0.9, 1.0] {
        let d = 1.0 / f64::sqrt(1.0 - 0.75 * u);
        assert!((sizes.sample_diameter(u) - d).abs() < 1e-15 * 4.0);
    }
    // <d> = integral of 1/d^2 over integral of 1/d^3 = (1/2) / (3/8).
    assert!((sizes.mean_diameter() - 4.0 / 3.0).abs() < 1e-15 * 4.0);
}

#[test]
fn normal_moments_by_number() {
    let (mean, s) = (2e-3, 2e-4);
    let sizes = distribution(Law::Normal { mean, deviation: s }, 0, None);
    assert!((sizes.mean_diameter() / mean - 1.0).abs() < 1e-12);
    // <d^3> = mean^3 + 3 mean s^2; the ends leave out 2e-9 at 6 s, 2 * 36 * 3 * (s/mean)^2 of it.
    let cube = mean * mean * mean + 3.0 * mean * s * s;
    assert!((sizes.moment(3) / cube - 1.0).abs() < 2e-8);
}

#[test]
fn laws_with_infinitely_many_particles_are_refused() {
    for (law, power) in [
        (
            Law::RosinRammler {
                d63: 1.0,
                exponent: 1.5,
            },
            3,
        ),
        (
            Law::Power {
                max: 1.0,
                exponent: 3.0,
            },
            3,
        ),
        (
            Law::Normal {
                mean: 1.0,
                deviation: 0.3,
            },
            0,
        ),
    ] {
        assert!(drawn(law, power, None).is_err(), "{law:?}");
        let cut = distribution(law, power, Some([0.01, 1.0]));
        assert!(cut.smallest() > 0.0 && cut.largest().is_finite());
    }
}

proptest! {
    /// Whatever the parameters, a law that is accepted draws finite diameters inside its bounds.
    #[test]
    fn draws_stay_inside(
        kind in 0..5,
        power in 0..4,
        scale in 1e-6_f64..1.0,
        shape in 0.01_f64..8.0,
        low in 0.0_f64..0.4,
        high in 0.5_f64..1.0,
        u in 0.0_f64..1.0,
    ) {
        let law = match kind {
            0 => Law::Uniform { min: scale, max: scale * (1.0 + shape) },
            1 => Law::Normal { mean: scale, deviation: scale * shape / 8.0 },
            2 => Law::Lognormal { median: scale, sigma: shape / 4.0 },
            3 => Law::RosinRammler { d63: scale, exponent: shape },
            _ => Law::Power { max: scale, exponent: shape },
        };
        if let Ok(sizes) = drawn(law, power, Some([low, high])) {
            let d = sizes.sample_diameter(u);
            prop_assert!(d >= sizes.smallest() && d <= sizes.largest(), "{d} {sizes:?}");
            let mean = sizes.mean_diameter();
            prop_assert!(mean >= sizes.smallest() * (1.0 - 1e-9));
            prop_assert!(mean <= sizes.largest() * (1.0 + 1e-9));
            prop_assert!((sizes.number_cdf(d) - u).abs() < 1e-9, "{} {u} {sizes:?}", sizes.number_cdf(d));
        }
    }
}
