//! p-values of fitted laws: draw from the law, fit again, and see how often the distance is as large.
//!
//! Tables of Kolmogorov or Anderson-Darling do not hold where the parameters come from the same data (Lilliefors 1967); the
//! parametric bootstrap does (Stute, Gonzalez Manteiga and Presedo Quindimil 1993, Metrika 40, 243).

use mercury_common::normal::normal_quantile;
use mercury_common::random::Stream;
use rayon::prelude::*;

use super::data::{Data, Kind};
use super::family::{Family, Law};
use super::minimise::Minimum;
use super::search_near;

/// Beyond this variance a binomial number is a rounded normal one, off by less than a hundredth of its deviation.
const NORMAL_VARIANCE: f64 = 400.0;

/// The share of drawn data that lie at least as far from their fit as the data do.
pub(super) fn p_value(
    data: &Data,
    family: Family,
    minimum: &Minimum,
    draws: usize,
    seed: u64,
) -> f64 {
    let law = Law::of(family, &minimum.at);
    let distance = data.distance(&law);
    let beyond = (0..draws)
        .into_par_iter()
        .filter(|&draw| {
            let mut stream = Stream::new(seed, "psd fit bootstrap", draw as u64);
            let drawn = data.drawn(&law, &mut stream);
            let again = search_near(&drawn, family, &minimum.at);
            drawn.distance(&Law::of(family, &again.at)) >= distance
        })
        .count();
    (beyond + 1) as f64 / (draws + 1) as f64
}

/// Data of the same kind and number from a law.
pub(super) fn drawn(data: &Data, law: &Law, stream: &mut Stream) -> Data {
    let kind = match data.kind() {
        Kind::Sizes(sizes) => {
            let mut sizes: Vec<f64> = (0..sizes.len()).map(|_| single(law, stream)).collect();
            sizes.sort_unstable_by(f64::total_cmp);
            Kind::Sizes(sizes)
        }
        Kind::Classes { edges, .. } => {
            let mut left = data.number().round();
            let mut share_left = 1.0;
            let counts = edges
                .windows(2)
                .map(|class| {
                    let share = law.share(class[0], class[1]);
                    let part = if share_left > 0.0 {
                        (share / share_left).min(1.0)
                    } else {
                        1.0
                    };
                    share_left -= share;
                    let count = binomial(left, part, stream);
                    left -= count;
                    count
                })
                .collect();
            Kind::Classes {
                edges: edges.clone(),
                counts,
            }
        }
    };
    data.with_kind(kind)
}

fn single(law: &Law, stream: &mut Stream) -> f64 {
    let mut choice = stream.uniform();
    let mut u = stream.uniform();
    // Never 0: no size is.
    u = u.max(0.5_f64.powi(54));
    for (share, part) in &law.parts {
        if choice < *share {
            return part.quantile(u);
        }
        choice -= share;
    }
    law.parts
        .last()
        .map_or(f64::NAN, |(_, part)| part.quantile(u))
}

/// Number of events among `n` of probability `p`.
fn binomial(n: f64, p: f64, stream: &mut Stream) -> f64 {
    if p > 0.5 {
        return n - binomial(n, 1.0 - p, stream);
    }
    if n < 1.0 || p <= 0.0 {
        return 0.0;
    }
    let variance = n * p * (1.0 - p);
    if variance > NORMAL_VARIANCE {
        let z = normal_quantile(stream.uniform().clamp(1e-15, 1.0 - 1e-15));
        return (n * p + variance.sqrt() * z).round().clamp(0.0, n);
    }
    // Inversion: the probabilities of 0, 1, 2, ... one after the other.
    let mut u = stream.uniform();
    let ratio = p / (1.0 - p);
    let mut probability = libm::exp(n * libm::log1p(-p));
    let mut k = 0.0;
    while u > probability && k < n {
        u -= probability;
        k += 1.0;
        probability *= ratio * (n - k + 1.0) / k;
    }
    k
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binomial_numbers_have_their_mean_and_variance() {
        let mut stream = Stream::new(1, "test", 0);
        for (n, p) in [(10.0, 0.3), (1000.0, 0.01), (1000.0, 0.97), (1e6, 0.2)] {
            let draws = 4000;
            let numbers: Vec<f64> = (0..draws).map(|_| binomial(n, p, &mut stream)).collect();
            let mean = numbers.iter().sum::<f64>() / draws as f64;
            let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / draws as f64;
            let expected: f64 = n * p * (1.0 - p);
            // Five standard errors: sqrt(variance / draws), and sqrt(2 / draws) of the variance (and its 4th moment).
            assert!(
                (mean - n * p).abs() < 5.0 * (expected / draws as f64).sqrt(),
                "{n} {p}"
            );
            assert!(
                (variance / expected - 1.0).abs() < 5.0 * (2.5 / draws as f64).sqrt(),
                "{n} {p}"
            );
        }
    }
}
