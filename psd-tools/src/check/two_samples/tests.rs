//! p-values under the hypothesis, and differences that are there.

use super::*;
use crate::draw::{Method, draw};
use crate::test_support::{law, uniform_p};

fn sample(target: &mercury_common::sizes::SizeDistribution, number: usize, seed: u64) -> Sample {
    Sample::new(draw(target, number, Method::Random, seed)).expect("sizes")
}

#[test]
fn p_values_are_uniform_when_both_are_of_one_distribution() {
    let target =
        law("kind = \"lognormal\"\nmedian_diameter = 1e-3\nsigma = 0.3\nweighting = \"number\"");
    let (mut ks, mut anderson) = (Vec::new(), Vec::new());
    for seed in 0..300 {
        let (a, b) = (
            sample(&target, 211, 2 * seed),
            sample(&target, 300, 2 * seed + 1),
        );
        let result = TwoSamples::of(&a, &b, 0.05);
        ks.push(result.kolmogorov.p);
        anderson.extend(result.anderson_darling.map(|test| test.p));
        assert!(!result.ties);
    }
    assert!(uniform_p(&ks) > 1e-3);
    assert_eq!(anderson.len(), 300);
    assert!(uniform_p(&anderson) > 1e-3);
}

#[test]
fn differences_are_seen_and_measured() {
    let a =
        law("kind = \"lognormal\"\nmedian_diameter = 1.0e-3\nsigma = 0.2\nweighting = \"number\"");
    let b =
        law("kind = \"lognormal\"\nmedian_diameter = 1.1e-3\nsigma = 0.2\nweighting = \"number\"");
    let (a, b) = (sample(&a, 2000, 1), sample(&b, 3000, 2));
    let result = TwoSamples::of(&a, &b, 0.001);
    assert_eq!(result.finding(0.01), Finding::Failed);
    // All sizes 10 % larger; the six intervals of 99.9 % hold that, W1 = 10 % of the mean.
    for (weighting, name, interval) in &result.differences {
        let (Some(low), Some(high)) = (interval.low, interval.high) else {
            panic!("{weighting:?} {name} {interval:?}");
        };
        assert!(low < 0.1 && 0.1 < high, "{weighting:?} {name} {interval:?}");
        assert!(high - low < 0.15);
    }
    assert!((result.wasserstein / (0.1 * a.moment(1)) - 1.0).abs() < 0.1);
    assert_eq!(TwoSamples::of(&a, &a, 0.05).finding(0.01), Finding::Passed);
    assert!(TwoSamples::of(&a, &a, 0.05).ties);
}

#[test]
fn small_samples_by_hand() {
    // {1, 3} and {2, 4}: F - G is 1/2, 0, 1/2, 0.
    let (a, b) = (Sample::new(vec![1.0, 3.0]), Sample::new(vec![2.0, 4.0]));
    let result = TwoSamples::of(&a.expect("sizes"), &b.expect("sizes"), 0.05);
    assert_eq!(result.kolmogorov.value, 0.5);
    assert!((result.wasserstein - 1.0).abs() < 1e-15);
    // Two against two prove nothing, and no difference has an end.
    assert_eq!(result.finding(0.01), Finding::Undetermined);
    for (_, _, interval) in &result.differences {
        assert_eq!([interval.low, interval.high], [None, None]);
    }
}
