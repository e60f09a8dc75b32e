//! Confidence bands of a sample's curves and quantiles.

use mercury_common::normal::normal_quantile;
use mercury_common::random::Stream;
use mercury_common::sizes::Weighting;

use crate::sample::Sample;

/// Pieces into which the particles are gathered for the band of the volume, and random curves drawn for it.
const PIECES: usize = 512;
const CURVES: usize = 2000;

/// A value with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The value.
    pub value: f64,
    /// Lower end; none where the sample is too small to have one.
    pub low: Option<f64>,
    /// Upper end; likewise.
    pub high: Option<f64>,
}

/// The fewest particles that determine anything of the distribution at this level: with fewer, not even the median has an
/// interval. All of n independent sizes lie on one side of it with the probability 2/2^n.
///
/// ```
/// use mercury_psd::check::fewest;
/// assert_eq!([fewest(0.05), fewest(0.01)], [6, 8]);
/// ```
#[must_use]
pub fn fewest(level: f64) -> usize {
    (1.0 - libm::log2(level)).ceil().max(1.0) as usize
}

/// Half width of the band that holds the whole cumulative number curve with probability 1 - `level`: sqrt(ln(2/level)/(2 n))
/// (Dvoretzky, Kiefer and Wolfowitz 1956, with the constant of Massart 1990, Ann. Probab. 18, 1269).
///
/// ```
/// use mercury_psd::check::number_band;
/// assert!((number_band(7312, 0.05) - 0.01588).abs() < 1e-5);
/// ```
#[must_use]
pub fn number_band(number: usize, level: f64) -> f64 {
    (libm::log(2.0 / level) / (2.0 * number as f64))
        .sqrt()
        .min(1.0)
}

/// The band of the cumulative volume curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeBand {
    /// Half width: random curves stay within it with probability 1 - level. 1, which is all there is, where so few particles hold the
    /// volume that nothing is known.
    pub half_width: f64,
    /// The share of random curves that deviate at least as much as the sample does; none for as few.
    pub p: Option<f64>,
    /// Number of equal particles that would determine the volume as well.
    pub effective_number: f64,
}

impl VolumeBand {
    /// Draws random curves: the deviation of the volume shares is a sum over particles of v_i (1(d_i <= d) - F(d)) / V, and each
    /// of them is multiplied by a normal number (the multiplier bootstrap, van der Vaart and Wellner 1996, chapter 2.9).
    /// Particles are gathered in pieces of equal volume, in which the sum of normal numbers is one normal number.
    pub(super) fn of(sample: &Sample, deviation: f64, level: f64, seed: u64) -> Self {
        let effective_number = sample.effective_number_by_volume();
        if effective_number < fewest(level) as f64 {
            return Self {
                half_width: 1.0,
                p: None,
                effective_number,
            };
        }
        let pieces = pieces(sample);
        let total: f64 = sample.volume_share(sample.len());
        let mut stream = Stream::new(seed, "psd volume band", 0);
        let mut deviations: Vec<f64> = (0..CURVES)
            .map(|_| {
                let mut sum = 0.0;
                let sums: Vec<f64> = pieces
                    .iter()
                    .map(|piece| {
                        sum += piece.root_square * stream.standard_normal();
                        sum
                    })
                    .collect();
                let distance = |(piece, at): (&Piece, &f64)| (at - piece.share * sum).abs();
                pieces.iter().zip(&sums).map(distance).fold(0.0, f64::max) / total
            })
            .collect();
        deviations.sort_by(f64::total_cmp);
        let at = ((1.0 - level) * CURVES as f64).ceil() as usize;
        let beyond = CURVES - deviations.partition_point(|&d| d < deviation);
        Self {
            half_width: deviations[at.clamp(1, CURVES) - 1],
            p: Some((beyond + 1) as f64 / (CURVES + 1) as f64),
            effective_number,
        }
    }
}

/// Particles that follow each other in size.
struct Piece {
    /// Root of the sum of squares of their shares of the volume.
    root_square: f64,
    /// Share of the volume up to and with them.
    share: f64,
}

fn pieces(sample: &Sample) -> Vec<Piece> {
    let n = sample.len();
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut square, mut last) = (0.0, 0.0);
    for i in 0..n {
        let share = sample.volume_share(i + 1);
        let own = share - sample.volume_share(i);
        square += own * own;
        if share - last >= 1.0 / PIECES as f64 || i + 1 == n {
            pieces.push(Piece {
                root_square: square.sqrt(),
                share,
            });
            (square, last) = (0.0, share);
        }
    }
    pieces
}

/// The diameter (m) at the number quantile `u` with its interval, from the order statistics: the binomial law of how many are
/// smaller (David and Nagaraja 2003, Order Statistics, section 7.1).
#[must_use]
pub fn number_interval(sample: &Sample, u: f64, level: f64) -> Interval {
    let n = sample.len();
    let at = |rank: usize| sample.diameters()[rank - 1];
    Interval {
        value: sample.quantile(Weighting::Number, u),
        low: rank_below(n, u, 0.5 * level).map(at),
        // The upper bound is the lower one, counted from the other end.
        high: rank_below(n, 1.0 - u, 0.5 * level).map(|rank| at(n + 1 - rank)),
    }
}

/// The largest rank (from 1) whose particle of `n` is larger than the quantile `u` with a probability of at most `tail`; none if already
/// the first one is.
fn rank_below(n: usize, u: f64, tail: f64) -> Option<usize> {
    let number = n as f64;
    let spread = (number * u * (1.0 - u)).sqrt();
    // Terms of lower ranks add nothing.
    let from = (number * u - 40.0 * spread - 100.0).max(0.0) as usize;
    let mut sum = 0.0;
    for smaller in from..n {
        let k = smaller as f64;
        let ln_choose =
            libm::lgamma(number + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(number - k + 1.0);
        sum += libm::exp(ln_choose + k * libm::log(u) + (number - k) * libm::log1p(-u));
        if sum > tail {
            return (smaller > 0).then_some(smaller);
        }
    }
    (n > 0).then_some(n)
}

/// The diameter (m) at the volume quantile `u` with its interval: where the share of volume, with its standard error, could be
/// `u` (Woodruff 1952, J. Am. Stat. Assoc. 47, 635). An end is there only if as many equal particles as determine the volume as
/// well would have one (Korn and Graubard 1998, Survey Methodology 24, 193, who put that number into the binomial law).
#[must_use]
pub fn volume_interval(sample: &Sample, u: f64, level: f64) -> Interval {
    // Var of F(d) = sum of v^2 (1(d_i <= d) - F)^2 / V^2.
    let own = |i: usize| sample.volume_share(i + 1) - sample.volume_share(i);
    let value = sample.quantile(Weighting::Volume, u);
    let (mut below, mut above) = (0.0, 0.0);
    for i in 0..sample.len() {
        let square = own(i) * own(i);
        // The particle that holds the quantile counts on both sides: were it counted on one, a large one would leave no error.
        let part = ((u - sample.volume_share(i)) / own(i)).clamp(0.0, 1.0);
        below += part * square;
        above += (1.0 - part) * square;
    }
    let error = (below * (1.0 - u) * (1.0 - u) + above * u * u).sqrt();
    let spread = normal_quantile(1.0 - 0.5 * level) * error;
    let number = sample.effective_number_by_volume();
    let all_on_one_side = |share: f64| libm::exp(number * libm::log(share));
    let end = |at: f64, outside: f64| {
        let is_known = all_on_one_side(outside) <= 0.5 * level && at > 0.0 && at < 1.0;
        // Within the particle that holds the quantile nothing is known.
        (is_known && sample.volume_index(at) != sample.volume_index(u))
            .then(|| sample.quantile(Weighting::Volume, at))
    };
    Interval {
        value,
        low: end(u - spread, 1.0 - u),
        high: end(u + spread, u),
    }
}
