//! Sizes by quota: the number of each size is fixed before the first particle is placed.
//!
//! Of N particles of an ingredient, one has its size in each N-th part of its distribution by number, at the same place `v` of
//! each part: sizes q((i + v) / N), i = 0 ... N - 1, q the quantile (systematic sampling; Cochran 1977, Sampling Techniques,
//! chapter 8). So the share of the particles below any size misses the distribution by at most 1/N. The sum of volumes grows with
//! `v` from S_N(0) to S_N(1), and as q(i/N) >= q(i/(N+1)), S_(N+1)(0) <= S_N(1) + the smallest volume: the target volume is
//! either met by some N and v, or lies in a gap between two N that is not wider than the smallest particle, whose nearer end is
//! taken. Where sizes jump (single sizes, empty classes) so does S_N(v), by less than the largest volume less the smallest; then
//! half of the largest particle bounds the error: beads of two sizes allow no better bound.

use mercury_common::random::Stream;
use mercury_common::sizes::SizeDistribution;

use super::{BoundaryContext, Ingredient, InsertionPlan, Total};
use crate::state::{MaterialIndex, volume};

/// The largest number of particles of a quota: their order takes 4 bytes each, and the sizes of the placed ones 8.
pub const MOST: f64 = 1e8;

/// The target volume is met to this share of it, or after this many steps, of which the first are secants.
const CLOSE: f64 = 1e-13;
const STEPS: usize = 60;
const SECANTS: usize = 15;

/// All particles of an insertion, in the order of placement. A size follows from its place, and is stored only after placement.
#[derive(Debug, Clone, Default)]
pub(super) struct Quota {
    ingredients: Vec<Places>,
    /// Places, those of the first ingredient first, in the order of placement.
    order: Vec<u32>,
}

/// The places of an ingredient in its distribution.
#[derive(Debug, Clone, Copy)]
struct Places {
    /// The number of places of the ingredients before it.
    before: u32,
    number: u64,
    v: f64,
}

impl Quota {
    /// Quota of an insertion whose total is a number, mass or volume; the plan has refused others.
    pub(super) fn new(insertion: &InsertionPlan, setting: &BoundaryContext<'_>) -> Self {
        let dimensions = setting.dimensions;
        let mut stream = Stream::new(
            setting.seed,
            &format!("insertion {} quota", insertion.name),
            0,
        );
        let mut ingredients = Vec::new();
        let mut before = 0;
        for (part, amount) in (insertion.mixture.iter()).zip(amounts(insertion, setting)) {
            let (number, v) = match amount {
                Amount::Number(number) => {
                    // The mean volume of this many particles.
                    let mean = mean_volume(&part.sizes, dimensions);
                    let v = place(&part.sizes, number, number as f64 * mean, dimensions);
                    (number, v)
                }
                Amount::Volume(wanted) => of_volume(&part.sizes, wanted, dimensions),
            };
            ingredients.push(Places { before, number, v });
            before += number as u32;
        }
        let mut order: Vec<u32> = (0..before).collect();
        // Fisher and Yates' shuffle, so that every part of the flow has all sizes.
        for last in (1..order.len()).rev() {
            let other = (stream.uniform() * (last + 1) as f64) as usize;
            order.swap(last, other.min(last));
        }
        Self { ingredients, order }
    }

    /// The next particle of the mixture after this many: ingredient and diameter (m); `None` after the last.
    pub(super) fn next(&self, inserted: u64, mixture: &[Ingredient]) -> Option<(usize, f64)> {
        let &place = self.order.get(usize::try_from(inserted).ok()?)?;
        // The last ingredient that begins there or before it: one without places begins where the next does.
        let behind = (self.ingredients).partition_point(|places| places.before <= place);
        let index = behind.checked_sub(1)?;
        let Places { before, number, v } = self.ingredients[index];
        let i = u64::from(place - before);
        Some((index, diameter(&mixture[index].sizes, i, number, v)))
    }

    /// The total number of particles.
    pub(super) fn len(&self) -> u64 {
        self.order.len() as u64
    }
}

/// The amount of an ingredient.
enum Amount {
    Number(u64),
    /// m^3 (m^2 in 2D)
    Volume(f64),
}

fn amounts(insertion: &InsertionPlan, setting: &BoundaryContext<'_>) -> Vec<Amount> {
    let parts = || insertion.mixture.iter();
    let shares: f64 = parts().map(|part| part.share).sum();
    let volumes: Vec<f64> = parts()
        .map(|part| part.share / shares * mean_volume(&part.sizes, setting.dimensions))
        .collect();
    let wanted = match insertion.total {
        Some(Total::Number(number)) => {
            // Rounding the cumulative shares misses none of them by more than one particle.
            let mut sum = 0.0;
            let mut before = 0;
            return parts()
                .map(|part| {
                    sum += part.share / shares;
                    let up_to = ((sum * number as f64).round() as u64).clamp(before, number);
                    let own = up_to - before;
                    before = up_to;
                    Amount::Number(own)
                })
                .collect();
        }
        Some(Total::Volume(volume)) => volume / volumes.iter().sum::<f64>(),
        Some(Total::Mass(mass)) => {
            let density = |index: MaterialIndex| setting.materials[index.index()].density;
            let masses = parts().zip(&volumes);
            mass / masses
                .map(|(part, volume)| density(part.material) * volume)
                .sum::<f64>()
        }
        Some(Total::Full) | None => 0.0,
    };
    volumes
        .iter()
        .map(|volume| Amount::Volume(wanted * volume))
        .collect()
}

fn diameter(sizes: &SizeDistribution, i: u64, number: u64, v: f64) -> f64 {
    sizes.sample_diameter((i as f64 + v) / number as f64)
}

/// Mean volume (area in 2D) of a particle: the mean volume of all particles drawn by quota, averaged over all `v`.
fn mean_volume(sizes: &SizeDistribution, dimensions: u8) -> f64 {
    if dimensions == 2 {
        volume(0.5, 2) * sizes.moment(2)
    } else {
        sizes.mean_volume()
    }
}

fn sum(sizes: &SizeDistribution, number: u64, v: f64, dimensions: u8) -> f64 {
    (0..number)
        .map(|i| volume(0.5 * diameter(sizes, i, number, v), dimensions))
        .sum()
}

/// The `v` at which `number` particles have the target volume, or come nearest to it.
fn place(sizes: &SizeDistribution, number: u64, wanted: f64, dimensions: u8) -> f64 {
    let missing = |v: f64| sum(sizes, number, v, dimensions) - wanted;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut below, mut above) = (missing(low), missing(high));
    if below >= 0.0 {
        return low;
    }
    if above <= 0.0 {
        return high;
    }
    // The secant, which halves the weight of an end that stays (Illinois; Dowell and Jarratt 1971, BIT 11, 168); where sizes jump,
    // halves.
    let (mut weight_low, mut weight_high) = (1.0, 1.0);
    for step in 0..STEPS {
        let v = if step < SECANTS {
            let (below, above) = (weight_low * below, weight_high * above);
            high - above * (high - low) / (above - below)
        } else {
            0.5 * (low + high)
        };
        let there = missing(v);
        if there.abs() <= CLOSE * wanted {
            return v;
        }
        if there > 0.0 {
            (high, above) = (v, there);
            (weight_low, weight_high) = (0.5 * weight_low, 1.0);
        } else {
            (low, below) = (v, there);
            (weight_low, weight_high) = (1.0, 0.5 * weight_high);
        }
    }
    if -below < above { low } else { high }
}

/// Number and `v` that come nearest to a volume.
fn of_volume(sizes: &SizeDistribution, wanted: f64, dimensions: u8) -> (u64, f64) {
    let guess = wanted / mean_volume(sizes, dimensions);
    // S_N(0) <= N mean <= S_N(1): only these two can hold the target, or bound the gap.
    let fewer = guess.floor() as u64;
    let nearest = |number: u64| {
        let v = place(sizes, number, wanted, dimensions);
        let error = (sum(sizes, number, v, dimensions) - wanted).abs();
        ((number, v), error)
    };
    let (first, missed) = nearest(fewer);
    if missed <= CLOSE * wanted {
        return first;
    }
    let (second, missed_too) = nearest(fewer + 1);
    if missed_too < missed { second } else { first }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mercury_common::scene::parse_psd;
    use proptest::prelude::*;

    fn sizes(law: &str) -> SizeDistribution {
        let psd = parse_psd("law.toml", law, None).expect("a law");
        SizeDistribution::from_scene(&psd).expect("sizes")
    }

    fn all() -> Vec<SizeDistribution> {
        [
            "kind = \"monodisperse\"\ndiameter = 1e-3",
            "kind = \"uniform\"\nmin_diameter = 1e-3\nmax_diameter = 3e-3\nweighting = \"number\"",
            "kind = \"lognormal\"\nmedian_diameter = 3e-3\nsigma = 0.4\nweighting = \"volume\"\ncut = [0.001, 0.999]",
            "kind = \"classes\"\ndiameters = [1e-3, 2e-3, 4e-3, 8e-3]\nshares = [1, 0, 3]\nweighting = \"volume\"",
            "kind = \"mixture\"\nweighting = \"volume\"\nof = [{ share = 1, kind = \"monodisperse\", diameter = 1e-3 },\n\
             { share = 2, kind = \"monodisperse\", diameter = 2e-3 }]",
        ]
        .map(sizes)
        .into()
    }

    /// Distributions that have single sizes or empty classes.
    const JUMPS: [bool; 5] = [false, false, false, true, true];

    /// The largest distance of the cumulative numbers.
    fn distance(diameters: &[f64], sizes: &SizeDistribution) -> f64 {
        let mut sorted = diameters.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len() as f64;
        let mut largest = 0.0f64;
        for &d in &sorted {
            // Where many have one size, the step of the law is that of the sample.
            let (below, up_to) = (
                sizes.number_cdf(d * (1.0 - 1e-9)),
                sizes.number_cdf(d * (1.0 + 1e-9)),
            );
            let first = sorted.partition_point(|&x| x < d * (1.0 - 1e-9)) as f64 / n;
            let last = sorted.partition_point(|&x| x <= d * (1.0 + 1e-9)) as f64 / n;
            largest = largest.max((below - first).abs()).max((up_to - last).abs());
        }
        largest
    }

    fn listed(sizes: &SizeDistribution, number: u64, v: f64) -> Vec<f64> {
        (0..number).map(|i| diameter(sizes, i, number, v)).collect()
    }

    proptest! {
        // Each sums thousands of quantiles some dozen times.
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn volumes_are_met_within_half_of_the_smallest(law in 0..5_usize, wanted in 1.0_f64..2000.0, flat in 2..=3_u8) {
            let sizes = &all()[law];
            let wanted = wanted * mean_volume(sizes, flat);
            let (number, v) = of_volume(sizes, wanted, flat);
            let got = sum(sizes, number, v, flat);
            let bound = 0.5 * volume(0.5 * if JUMPS[law] { sizes.largest() } else { sizes.smallest() }, flat);
            prop_assert!((got - wanted).abs() <= bound * (1.0 + 1e-9) + 1e-12 * wanted, "{} {}", got, wanted);
            // One in each N-th part.
            let bound = (1.0 + 1e-6) / number as f64;
            prop_assert!(distance(&listed(sizes, number, v), sizes) <= bound);
        }

        #[test]
        fn numbers_have_their_mean_volume(law in 0..5_usize, number in 1..500_u64) {
            let sizes = &all()[law];
            let wanted = number as f64 * mean_volume(sizes, 3);
            let v = place(sizes, number, wanted, 3);
            // Where sizes jump, by half of the largest jump at most; else it is met exactly.
            let step = if JUMPS[law] { 0.5 * volume(0.5 * sizes.largest(), 3) } else { 0.0 };
            prop_assert!((sum(sizes, number, v, 3) - wanted).abs() <= step + 1e-12 * wanted);
            prop_assert!(distance(&listed(sizes, number, v), sizes) <= (1.0 + 1e-6) / number as f64);
        }
    }
}
