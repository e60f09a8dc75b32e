//! Are several samples of one distribution, whatever it is?

use super::goodness::Statistic;
use crate::special::{ANDERSON_DARLING_VARIANCE, anderson_darling_samples_tail};

/// The Anderson-Darling statistic of several samples (each ascending), which weighs both ends as heavily as the middle.
///
/// Scholz and Stephens 1987 (J. Am. Stat. Assoc. 82, 918): equation 7, in which equal sizes count with their middle rank; the
/// p-value by the limit, the statistic moved and stretched to its mean k - 1 and variance. `None` for fewer than two samples that
/// hold something, or fewer than four sizes, for which the variance has no formula.
#[must_use]
pub fn anderson_darling_samples(samples: &[&[f64]]) -> Option<Statistic> {
    let samples: Vec<&[f64]> = (samples.iter().copied())
        .filter(|s| !s.is_empty())
        .collect();
    let k = samples.len();
    let total: usize = samples.iter().map(|s| s.len()).sum();
    if k < 2 || total < 4 {
        return None;
    }
    let value = statistic(&samples, total);
    let lengths: Vec<f64> = samples.iter().map(|s| s.len() as f64).collect();
    let degrees = (k - 1) as f64;
    let deviation = variance(&lengths, total).sqrt();
    let limit = (ANDERSON_DARLING_VARIANCE * degrees).sqrt();
    let p = anderson_darling_samples_tail(degrees + (value - degrees) / deviation * limit, k - 1);
    Some(Statistic { value, p })
}

fn statistic(samples: &[&[f64]], total: usize) -> f64 {
    let all = total as f64;
    let mut next = vec![0_usize; samples.len()];
    let mut sums = vec![0.0; samples.len()];
    let mut below = 0_usize;
    loop {
        let smallest = (samples.iter().zip(&next))
            .filter_map(|(sample, &at)| sample.get(at))
            .copied()
            .fold(f64::INFINITY, f64::min);
        if smallest == f64::INFINITY {
            break;
        }
        let before = next.clone();
        for (sample, at) in samples.iter().zip(&mut next) {
            while sample.get(*at).is_some_and(|&d| d <= smallest) {
                *at += 1;
            }
        }
        let equal = next.iter().zip(&before).map(|(a, b)| a - b).sum::<usize>() as f64;
        let rank = below as f64 + 0.5 * equal;
        below += equal as usize;
        let weight = rank * (all - rank) - 0.25 * all * equal;
        // All sizes equal: nothing differs.
        if weight <= 0.0 {
            continue;
        }
        for (i, sample) in samples.iter().enumerate() {
            let own = 0.5 * (before[i] + next[i]) as f64;
            let difference = all * own - sample.len() as f64 * rank;
            sums[i] += equal / all * difference * difference / weight;
        }
    }
    let sum: f64 = (sums.iter().zip(samples))
        .map(|(sum, sample)| sum / sample.len() as f64)
        .sum();
    (all - 1.0) / all * sum
}

/// The variance of the statistic where all samples are of one distribution: Scholz and Stephens' equation 4.
fn variance(lengths: &[f64], total: usize) -> f64 {
    let k = lengths.len() as f64;
    let n = total as f64;
    let sum_of_inverses: f64 = lengths.iter().map(|length| 1.0 / length).sum();
    let harmonic: f64 = (1..total).map(|i| 1.0 / i as f64).sum();
    // The double sum of 1 / ((n - i) j) over i < j < n, from the back.
    let mut double = 0.0;
    let mut rest = 0.0;
    for i in (1..total - 1).rev() {
        rest += 1.0 / (i + 1) as f64;
        double += rest / (total - i) as f64;
    }
    let (s, h, g) = (sum_of_inverses, harmonic, double);
    let a = (4.0 * g - 6.0) * (k - 1.0) + (10.0 - 6.0 * g) * s;
    let b = (2.0 * g - 4.0) * k * k + 8.0 * h * k + (2.0 * g - 14.0 * h - 4.0) * s - 8.0 * h
        + 4.0 * g
        - 6.0;
    let c = (6.0 * h + 2.0 * g - 2.0) * k * k
        + (4.0 * h - 4.0 * g + 6.0) * k
        + (2.0 * h - 6.0) * s
        + 4.0 * h;
    let d = (2.0 * h + 6.0) * k * k - 4.0 * h * k;
    (((a * n + b) * n + c) * n + d) / ((n - 1.0) * (n - 2.0) * (n - 3.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::uniform_p;
    use mercury_common::random::Stream;

    /// Table 4 of Scholz and Stephens: smoothness of paper measured by four laboratories; A^2 of the middle ranks is 8.3559 there.
    #[test]
    fn the_example_of_the_paper() {
        let mut laboratories = [
            [38.7, 41.5, 43.8, 44.5, 45.5, 46.0, 47.7, 58.0],
            [39.2, 39.3, 39.7, 41.4, 41.8, 42.9, 43.3, 45.8],
            [34.0, 35.0, 39.0, 40.0, 43.0, 43.0, 44.0, 45.0],
            [34.0, 34.8, 34.8, 35.4, 37.2, 37.8, 41.2, 42.8],
        ];
        for laboratory in &mut laboratories {
            laboratory.sort_by(f64::total_cmp);
        }
        let samples: Vec<&[f64]> = laboratories.iter().map(|l| &l[..]).collect();
        let found = anderson_darling_samples(&samples).expect("a statistic");
        // Printed with four digits.
        assert!((found.value - 8.3926).abs() < 1e-3, "{found:?}");
        // The paper interpolates p = 0.0023 in a table of five points.
        assert!((found.p - 0.0023).abs() < 5e-4, "{found:?}");
    }

    /// Two samples of one each: ranks 1 and 2, whichever is first. Equation 7 by hand: B = 1/2 and 3/2, weights
    /// B (2 - B) - 1/2 = 1/4 twice; differences 2 M - B = +-1/2 everywhere; A^2 = (1/2) 2 (2 (1/2) (1/4) / (1/4)) = 1.
    #[test]
    fn two_sizes_by_hand() {
        assert!((statistic(&[&[1.0], &[2.0]], 2) - 1.0).abs() < 1e-15);
        assert!(anderson_darling_samples(&[&[1.0], &[2.0]]).is_none());
        assert!(anderson_darling_samples(&[&[1.0, 2.0, 3.0, 4.0]]).is_none());
    }

    #[test]
    fn p_values_of_equal_samples_are_uniform() {
        for k in [2, 3, 5] {
            let mut p_values = Vec::new();
            for trial in 0..500 {
                let mut stream = Stream::new(trial, "samples", k as u64);
                let samples: Vec<Vec<f64>> = (0..k)
                    .map(|i| {
                        let mut sample: Vec<f64> =
                            (0..40 + 25 * i).map(|_| stream.uniform()).collect();
                        sample.sort_by(f64::total_cmp);
                        sample
                    })
                    .collect();
                let samples: Vec<&[f64]> = samples.iter().map(Vec::as_slice).collect();
                p_values.push(anderson_darling_samples(&samples).expect("a statistic").p);
            }
            assert!(uniform_p(&p_values) > 1e-3, "{k}: {}", uniform_p(&p_values));
        }
    }

    #[test]
    fn differences_in_the_tails_are_seen() {
        // Two samples with one middle, of which one is wider: Kolmogorov's distance hardly sees the difference.
        let narrow: Vec<f64> = (0..400).map(|i| 1.0 + f64::from(i) / 400.0).collect();
        let wide: Vec<f64> = narrow.iter().map(|d| 1.5 + 1.25 * (d - 1.5)).collect();
        let found = anderson_darling_samples(&[&narrow, &wide]).expect("a statistic");
        assert!(found.p < 0.01, "{found:?}");
        let same = anderson_darling_samples(&[&narrow, &narrow]).expect("a statistic");
        assert!(same.p > 0.99, "{same:?}");
    }
}
