//! The sizes that an insertion brought, kept to be compared with those that were asked for.

use mercury_common::sizes::SizeDistribution;

/// So many diameters are kept as they are, and so many classes of equal probability are counted beyond: an insertion that never
/// ends shall not fill the memory. With N sizes the largest distance of their cumulative numbers is some 0.5 / sqrt(N), so the width
/// of a class, 1.5e-5, shows in it only far beyond the 1e9 sizes that a run can bring.
const MOST: usize = 1 << 16;

/// The sizes of one ingredient that came in: all diameters, or beyond 65,536 how many lie in each of 65,536 classes of equal
/// probability.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlacedSizes {
    /// In the order in which they came, m.
    diameters: Vec<f64>,
    /// In place of the diameters, once there were too many: the class of a diameter is its cumulative number, in 65,536ths.
    classes: Vec<u32>,
}

impl PlacedSizes {
    /// Counts a diameter (m) that was drawn from `sizes`. All diameters are kept with `keeps_all`.
    pub fn count(&mut self, diameter: f64, sizes: &SizeDistribution, keeps_all: bool) {
        if self.classes.is_empty() && (self.diameters.len() < MOST || keeps_all) {
            self.diameters.push(diameter);
            return;
        }
        if self.classes.is_empty() {
            self.classes = vec![0; MOST];
            for diameter in std::mem::take(&mut self.diameters) {
                self.classify(sizes.number_cdf(diameter));
            }
        }
        self.classify(sizes.number_cdf(diameter));
    }

    fn classify(&mut self, cumulative: f64) {
        let classes = self.classes.len();
        let class = (cumulative * classes as f64) as usize;
        let count = &mut self.classes[class.min(classes - 1)];
        *count = count.saturating_add(1);
    }

    /// How many were counted.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.diameters.len() as u64
            + self
                .classes
                .iter()
                .map(|&count| u64::from(count))
                .sum::<u64>()
    }

    /// The largest distance of their cumulative numbers from those of `sizes` (Kolmogorov 1933); of sizes in classes the largest at
    /// the bounds of the classes, which lacks less than 1.6e-5.
    #[must_use]
    pub fn distance(&self, sizes: &SizeDistribution) -> f64 {
        let n = self.number() as f64;
        if self.classes.is_empty() {
            let mut diameters = self.diameters.clone();
            diameters.sort_unstable_by(f64::total_cmp);
            let distances = diameters.iter().enumerate().map(|(i, &diameter)| {
                let expected = sizes.number_cdf(diameter);
                (expected - i as f64 / n).max((i + 1) as f64 / n - expected)
            });
            return distances.fold(0.0, f64::max);
        }
        let mut below = 0;
        let distances = self.classes.iter().enumerate().map(|(class, &count)| {
            below += u64::from(count);
            let expected = (class + 1) as f64 / self.classes.len() as f64;
            (below as f64 / n - expected).abs()
        });
        distances.fold(0.0, f64::max)
    }
}

crate::state::plain!(PlacedSizes { diameters, classes });

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;

    use super::*;
    use crate::boundaries::tests::uniform;

    /// `n` diameters between 1 and 3 m, of which the cumulative numbers are the `power`-th power of uniform ones.
    fn counted(n: usize, power: f64, keeps_all: bool) -> PlacedSizes {
        let sizes = uniform(1.0, 3.0);
        let mut stream = Stream::new(1, "sizes", 0);
        let mut placed = PlacedSizes::default();
        for _ in 0..n {
            let u = stream.uniform().powf(power);
            placed.count(1.0 + 2.0 * u, &sizes, keeps_all);
        }
        placed
    }

    #[test]
    fn sizes_in_classes_lie_as_far_apart_as_all_of_them() {
        let sizes = uniform(1.0, 3.0);
        for power in [1.0, 1.01, 2.0] {
            let n = MOST + 10_000;
            let all = counted(n, power, true);
            let classes = counted(n, power, false);
            assert!(all.classes.is_empty() && classes.diameters.is_empty());
            assert_eq!((all.number(), classes.number()), (n as u64, n as u64));
            let (exact, coarse) = (all.distance(&sizes), classes.distance(&sizes));
            // Between two bounds the cumulative numbers of both grow by at most what they do from bound to bound.
            let most_in_a_class = *classes.classes.iter().max().unwrap();
            let lacks = f64::from(most_in_a_class) / n as f64 + 1.0 / MOST as f64;
            assert!(
                coarse <= exact && exact - coarse <= lacks,
                "{exact} {coarse}"
            );
            // Of squares of uniform numbers: max of sqrt(u) - u, at u = 1/4.
            if power == 2.0 {
                let noise = 1.95 / (n as f64).sqrt();
                assert!((coarse - 0.25).abs() < noise, "{coarse}");
            }
        }
    }

    #[test]
    fn the_first_that_is_too_many_loses_nobody() {
        for n in [MOST - 1, MOST, MOST + 1, MOST + 2] {
            let placed = counted(n, 1.0, false);
            assert_eq!(placed.number(), n as u64);
            assert_eq!(placed.classes.is_empty(), n <= MOST);
        }
    }
}
