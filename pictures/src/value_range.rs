//! Range of values of a colour bar.

use crate::colour_map::ColourMap;

/// The values of one or more frames.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ValueRange {
    /// Smallest and largest.
    full: Option<(f64, f64)>,
    /// Without the few that lie far outside.
    usual: Option<(f64, f64)>,
    /// The least of those above 0, without the few that lie far below the others.
    positive: Option<f64>,
}

/// Fewer values than this have no outliers.
const FEW: usize = 100;
/// Distance of an outlier from the middle 98 %, in units of its width.
const FAR: f64 = 2.0;

impl ValueRange {
    /// Takes the finite ones among `values` into account.
    pub(crate) fn add(&mut self, values: impl Iterator<Item = f64>) {
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        if values.is_empty() {
            return;
        }
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut usual = (low, high);
        if values.len() >= FEW {
            let last = values.len() - 1;
            let hundredth = *values.select_nth_unstable_by(last / 100, f64::total_cmp).1;
            let upper = last - last / 100;
            let ninety_ninth = *values.select_nth_unstable_by(upper, f64::total_cmp).1;
            let reach = FAR * (ninety_ninth - hundredth);
            // Where nearly all values are one, the others are what there is to see.
            if reach > 0.0 && high > ninety_ninth + reach {
                usual.1 = ninety_ninth;
            }
            if reach > 0.0 && low < hundredth - reach {
                usual.0 = hundredth;
            }
        }
        let mut positive: Vec<f64> = values
            .iter()
            .copied()
            .filter(|value| *value > 0.0)
            .collect();
        if !positive.is_empty() {
            let hundredth = (positive.len() - 1) / 100;
            let least = *positive.select_nth_unstable_by(hundredth, f64::total_cmp).1;
            self.positive = Some(self.positive.map_or(least, |old| old.min(least)));
        }
        let join = |old: Option<(f64, f64)>, (low, high): (f64, f64)| {
            let (a, b) = old.unwrap_or((low, high));
            Some((a.min(low), b.max(high)))
        };
        self.full = join(self.full, (low, high));
        self.usual = join(self.usual, usual);
    }

    /// Smallest and largest, if there is any value.
    pub(crate) fn full(&self) -> Option<(f64, f64)> {
        self.full
    }

    /// The ends of a colour bar: from 0 where that costs little, symmetric for a map with a middle, never empty.
    pub(crate) fn bar(&self, map: ColourMap) -> Option<(f64, f64)> {
        let (mut low, mut high) = self.usual?;
        if low > 0.0 && low <= 0.3 * high {
            low = 0.0;
        }
        if high < 0.0 && high >= 0.3 * low {
            high = 0.0;
        }
        if map == ColourMap::CoolWarm && low < 0.0 && high > 0.0 {
            high = high.max(-low);
            low = -high;
        }
        Some(opened(low, high))
    }

    /// The ends of a logarithmic colour bar, never empty; none if no value is above 0.
    pub(crate) fn logarithmic_bar(&self) -> Option<(f64, f64)> {
        let (low, (_, high)) = (self.positive?, self.usual?);
        Some(if high > low * (1.0 + 1e-9) {
            (low, high)
        } else {
            // Finite and above 0 for any value.
            (
                (0.1 * low).max(f64::MIN_POSITIVE),
                (10.0 * low).min(f64::MAX),
            )
        })
    }

    /// The ends of a colour bar whose middle is 0, never empty.
    pub(crate) fn centred(&self) -> Option<(f64, f64)> {
        let (low, high) = self.usual?;
        let end = high.abs().max(low.abs());
        Some(if end > 0.0 { (-end, end) } else { (-1.0, 1.0) })
    }
}

/// `low..high`, opened where it is too narrow for a bar.
pub(crate) fn opened(low: f64, high: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if high - low > 1e-9 * size {
        return (low, high);
    }
    if size == 0.0 {
        return (0.0, 1.0);
    }
    // Limited to finite numbers: a margin above the largest numbers would be infinite.
    let (low, high) = (low - 0.1 * size, high + 0.1 * size);
    (low.max(f64::MIN), high.min(f64::MAX))
}

/// The place of a value between the ends of a bar, 0 to 1.
pub(crate) fn share(value: f64, (low, high): (f64, f64)) -> f64 {
    // Halves, because the whole range may not be a number.
    let share = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
    // The smallest range has no halves.
    if share.is_nan() {
        0.0
    } else {
        share.clamp(0.0, 1.0)
    }
}

/// The place of a value between the ends of a logarithmic bar (above 0), 0 to 1; values that are not above 0 stand at its lower end.
pub(crate) fn logarithmic_share(value: f64, (low, high): (f64, f64)) -> f64 {
    if value <= low {
        return 0.0;
    }
    // Differences of logarithms: ratios of the largest and the smallest numbers are none.
    let share = (libm::log(value) - libm::log(low)) / (libm::log(high) - libm::log(low));
    if share.is_nan() {
        0.0
    } else {
        share.clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bar(values: &[f64], map: ColourMap) -> Option<(f64, f64)> {
        let mut range = ValueRange::default();
        range.add(values.iter().copied());
        range.bar(map)
    }

    #[test]
    fn bars_start_at_zero_where_that_costs_little() {
        assert_eq!(bar(&[1.0, 9.0], ColourMap::Viridis), Some((0.0, 9.0)));
        assert_eq!(bar(&[8.0, 9.0], ColourMap::Viridis), Some((8.0, 9.0)));
        assert_eq!(bar(&[-1.0, 3.0], ColourMap::CoolWarm), Some((-3.0, 3.0)));
        assert_eq!(bar(&[0.0, 0.0], ColourMap::Viridis), Some((0.0, 1.0)));
        assert_eq!(bar(&[f64::NAN], ColourMap::Viridis), None);
    }

    #[test]
    fn the_middle_of_a_centred_bar_is_zero() {
        for (values, expected) in [
            (&[-3.0, -1.0][..], Some((-3.0, 3.0))),
            (&[2.0, 5.0], Some((-5.0, 5.0))),
            (&[0.0, 0.0], Some((-1.0, 1.0))),
            (&[f64::NAN], None),
        ] {
            let mut range = ValueRange::default();
            range.add(values.iter().copied());
            assert_eq!(range.centred(), expected);
        }
    }

    #[test]
    fn one_that_flies_does_not_flatten_the_others() {
        let mut values: Vec<f64> = (0..200).map(|i| 0.001 * f64::from(i)).collect();
        values.push(50.0);
        let (low, high) = bar(&values, ColourMap::Viridis).unwrap();
        assert!(low == 0.0 && high < 0.2, "{low} {high}");
    }

    #[test]
    fn equal_ratios_are_equal_steps_of_a_logarithmic_bar() {
        let mut range = ValueRange::default();
        range.add([0.0, -1.0, 1e-3, 1.0].into_iter());
        range.add([10.0].into_iter());
        let bar = range.logarithmic_bar().unwrap();
        assert_eq!(bar, (1e-3, 10.0));
        for (value, share) in [
            (1e-3, 0.0),
            (1e-2, 0.25),
            (0.1, 0.5),
            (10.0, 1.0),
            (0.0, 0.0),
        ] {
            assert!(
                (logarithmic_share(value, bar) - share).abs() < 1e-15,
                "{value}"
            );
        }
        let mut one = ValueRange::default();
        one.add([2.0].into_iter());
        assert_eq!(one.logarithmic_bar(), Some((0.2, 20.0)));
        one = ValueRange::default();
        one.add([0.0, -1.0].into_iter());
        assert_eq!(one.logarithmic_bar(), None);
    }

    proptest! {
        #[test]
        fn a_bar_is_never_empty(bits in prop::collection::vec(any::<u64>(), 1..300)) {
            let values: Vec<f64> = bits.iter().map(|b| f64::from_bits(*b)).collect();
            if let Some((low, high)) = bar(&values, ColourMap::CoolWarm) {
                prop_assert!(low < high && low.is_finite() && high.is_finite());
                for value in values.iter().filter(|v| !v.is_nan()) {
                    prop_assert!((0.0..=1.0).contains(&share(*value, (low, high))));
                }
            }
            let mut range = ValueRange::default();
            range.add(values.iter().copied());
            if let Some((low, high)) = range.logarithmic_bar() {
                prop_assert!(0.0 < low && low < high && high.is_finite());
                for value in values.iter().filter(|v| !v.is_nan()) {
                    prop_assert!((0.0..=1.0).contains(&logarithmic_share(*value, (low, high))));
                }
            }
        }
    }
}
