//! How a run is compared with a file that another program wrote.

use std::collections::BTreeMap;

/// |measured - expected| <= `relative` |expected| + `floor` times the largest magnitude of the quantity.
///
/// The floor is what round-off and the printed digits leave of numbers that nearly cancel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Fraction of the expected number.
    pub relative: f64,
    /// Fraction of the largest magnitude of the quantity in the file.
    pub floor: f64,
}

impl Tolerance {
    /// For files whose numbers have 10 significant digits, the digits of most of MercuryDPM's output: half a unit of the tenth
    /// digit is at most 5e-10 of a number.
    pub const TEN_DIGITS: Self = Self {
        relative: 1e-9,
        floor: 1e-12,
    };
    /// For files whose numbers have 6 significant digits: half a unit of the sixth is at most 5e-6 of a number.
    pub const SIX_DIGITS: Self = Self {
        relative: 5.000_001e-6,
        floor: 1e-9,
    };
}

/// A run of our engine beside a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Name of the set-up.
    pub name: &'static str,
    /// File it was compared with, and what it checks.
    pub source: &'static str,
    /// Numbers compared.
    pub numbers: usize,
    /// Largest deviation, as a fraction of the largest magnitude of its quantity.
    pub worst_deviation: f64,
    /// Largest deviation over what the tolerance allows there: the comparison holds up to 1.
    pub worst_share: f64,
    /// The quantity, expected and measured number of the largest share.
    pub worst: (String, f64, f64),
    /// Tolerance of the comparison.
    pub tolerance: Tolerance,
}

impl Comparison {
    /// Whether every number agrees.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.numbers > 0 && self.worst_share <= 1.0
    }
}

/// Pairs of numbers by quantity.
#[derive(Debug, Default)]
pub(super) struct Tally {
    quantities: BTreeMap<&'static str, Quantity>,
}

#[derive(Debug, Default)]
struct Quantity {
    scale: f64,
    pairs: Vec<(f64, f64)>,
}

impl Tally {
    /// Adds an expected and a measured number.
    pub(super) fn add(&mut self, quantity: &'static str, expected: f64, measured: f64) {
        let quantity = self.quantities.entry(quantity).or_default();
        quantity.scale = quantity.scale.max(expected.abs());
        quantity.pairs.push((expected, measured));
    }

    /// Adds the components of a vector.
    pub(super) fn vector(
        &mut self,
        quantity: &'static str,
        expected: glam::DVec3,
        measured: glam::DVec3,
    ) {
        for axis in 0..3 {
            self.add(quantity, expected[axis], measured[axis]);
        }
    }

    /// States the magnitude that a quantity has in the run, for quantities that end near zero in the file.
    pub(super) fn scale(&mut self, quantity: &'static str, scale: f64) {
        let quantity = self.quantities.entry(quantity).or_default();
        quantity.scale = quantity.scale.max(scale);
    }

    /// The comparison.
    pub(super) fn finish(
        &self,
        name: &'static str,
        source: &'static str,
        tolerance: Tolerance,
    ) -> Comparison {
        let mut comparison = Comparison {
            name,
            source,
            numbers: 0,
            worst_deviation: 0.0,
            worst_share: 0.0,
            worst: (String::new(), 0.0, 0.0),
            tolerance,
        };
        for (name, quantity) in &self.quantities {
            for &(expected, measured) in &quantity.pairs {
                comparison.numbers += 1;
                let deviation = (measured - expected).abs();
                if deviation == 0.0 {
                    continue;
                }
                let allowed =
                    tolerance.relative * expected.abs() + tolerance.floor * quantity.scale;
                // NaN, and anything where zero is allowed, must fail.
                let share = if deviation.is_finite() && allowed > 0.0 {
                    deviation / allowed
                } else {
                    f64::INFINITY
                };
                let scaled = if quantity.scale > 0.0 && deviation.is_finite() {
                    deviation / quantity.scale
                } else {
                    f64::INFINITY
                };
                comparison.worst_deviation = comparison.worst_deviation.max(scaled);
                if share > comparison.worst_share {
                    comparison.worst_share = share;
                    comparison.worst = ((*name).to_owned(), expected, measured);
                }
            }
        }
        comparison
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_are_judged_by_number_and_by_quantity() {
        let tolerance = Tolerance {
            relative: 1e-3,
            floor: 1e-6,
        };
        let mut tally = Tally::default();
        tally.add("force", 1000.0, 1000.5);
        tally.add("force", 0.0, 0.0005);
        let comparison = tally.finish("", "", tolerance);
        assert!(comparison.holds());
        assert!((comparison.worst_share - 0.5).abs() < 1e-3);
        for bad in [f64::NAN, f64::INFINITY, 0.002] {
            let mut tally = Tally::default();
            tally.add("force", 1000.0, 1000.0);
            tally.add("force", 0.0, bad);
            assert!(!tally.finish("", "", tolerance).holds(), "{bad}");
        }
        let mut tally = Tally::default();
        tally.add("angle", 0.0, 1e-300);
        assert!(!tally.finish("", "", tolerance).holds());
        assert!(!Tally::default().finish("", "", tolerance).holds());
    }
}
