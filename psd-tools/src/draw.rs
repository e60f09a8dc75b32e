//! Samples drawn from a distribution.

use mercury_common::random::Stream;
use mercury_common::sizes::SizeDistribution;

/// How diameters follow the distribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Independently.
    Random,
    /// One in each of N classes of equal number, at random inside, in random order: the cumulative share is never off by more than
    /// 1/N.
    Quota,
}

/// `number` diameters, m, in random order. The same seed gives the same list, on every machine.
#[must_use]
pub fn draw(sizes: &SizeDistribution, number: usize, method: Method, seed: u64) -> Vec<f64> {
    let mut stream = Stream::new(seed, "psd sample", 0);
    let mut diameters: Vec<f64> = (0..number)
        .map(|i| {
            let u = stream.uniform();
            sizes.sample_diameter(match method {
                Method::Random => u,
                Method::Quota => (i as f64 + u) / number as f64,
            })
        })
        .collect();
    if method == Method::Quota {
        // Fisher and Yates: every order is as likely.
        let mut order = Stream::new(seed, "psd sample order", 0);
        for i in (1..number).rev() {
            let j = (order.uniform() * (i + 1) as f64) as usize;
            diameters.swap(i, j.min(i));
        }
    }
    diameters
}

#[cfg(test)]
mod tests {
    use super::*;
    use mercury_common::sizes::{ClassModel, Classes, Weighting};

    #[test]
    fn quotas_keep_their_bound() {
        let classes = Classes::new(
            &[1.0, 2.0, 5.0],
            &[0.3, 0.7],
            Weighting::Volume,
            ClassModel::default(),
        );
        let sizes = SizeDistribution::from_classes(classes.unwrap(), Weighting::Volume);
        let number = 997;
        let mut drawn = draw(&sizes, number, Method::Quota, 3);
        assert_ne!(drawn, draw(&sizes, number, Method::Quota, 4));
        assert_eq!(drawn, draw(&sizes, number, Method::Quota, 3));
        // In random order: neighbours are not sorted.
        assert!(drawn.windows(2).any(|pair| pair[0] > pair[1]));
        drawn.sort_by(f64::total_cmp);
        for (i, d) in drawn.iter().enumerate() {
            let u = sizes.number_cdf(*d) * number as f64;
            assert!(u > i as f64 - 1e-9 && u < (i + 1) as f64 + 1e-9);
        }
    }
}
