//! The sizes that an insertion placed, kept for the comparison with the given distribution.

use mercury_common::sizes::SizeDistribution;

use crate::state::Plain;

/// This many diameters are kept as they are, and this many classes of equal probability are counted beyond: an insertion without
/// end must not fill the memory. With N sizes the largest distance of
/// their cumulative numbers is 0.87 / sqrt(N) on the mean (Kolmogorov 1933), so the width of a class, 1.5e-5, is a twentieth of
/// it at 1e7 sizes, and half of it at 1e9.
const MOST: usize = 1 << 16;

/// The sizes of the placed particles of one ingredient: all diameters, or beyond 65,536 the numbers in 65,536 classes of equal
/// probability.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlacedSizes {
    /// In the order of placement, m.
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

    /// Number of counted sizes.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.diameters.len() as u64
            + self
                .classes
                .iter()
                .map(|&count| u64::from(count))
                .sum::<u64>()
    }

    /// The diameter (m) below which this share of them lies; of sizes in classes that of the distribution `sizes` at the class.
    #[must_use]
    pub fn quantile(&self, share: f64, sizes: &SizeDistribution) -> f64 {
        let n = self.number();
        // The first diameter with at least this share at or below it.
        let rank = ((share * n as f64).ceil() as u64).clamp(1, n.max(1)) - 1;
        if self.classes.is_empty() {
            let mut diameters = self.diameters.clone();
            diameters.sort_unstable_by(f64::total_cmp);
            return diameters.get(rank as usize).copied().unwrap_or(0.0);
        }
        let mut below = 0;
        let class = self.classes.iter().position(|&count| {
            below += u64::from(count);
            below > rank
        });
        let classes = self.classes.len() as f64;
        sizes.sample_diameter((class.unwrap_or(0) as f64 + 0.5) / classes)
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

impl Plain for PlacedSizes {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.diameters.put(bytes);
        self.classes.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let (diameters, classes) = (Vec::take(bytes)?, Vec::take(bytes)?);
        let sizes = Self { diameters, classes };
        match (sizes.diameters.is_empty(), sizes.classes.len()) {
            (_, 0) | (true, MOST) => Ok(sizes),
            (_, classes) => Err(format!(
                "{} sizes beside {classes} classes of sizes",
                sizes.diameters.len()
            )),
        }
    }
}

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
            // Between two bounds the sizes' numbers are at most those of the upper one and the law's at least those of the lower one, or the other
            // way round: what the bounds do not show is what the law grows by between them.
            let lacks = 1.0 / MOST as f64 + 4.0 * f64::EPSILON;
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
    fn what_cannot_have_been_kept_is_refused() {
        let kept = |diameters: usize, classes: usize| {
            let mut bytes = Vec::new();
            vec![1.0; diameters].put(&mut bytes);
            vec![1u32; classes].put(&mut bytes);
            PlacedSizes::take(&mut &bytes[..])
        };
        assert!(kept(0, 0).is_ok() && kept(9, 0).is_ok() && kept(0, MOST).is_ok());
        assert!(kept(0, 9).is_err() && kept(9, MOST).is_err());
    }

    #[test]
    fn the_first_that_is_too_many_loses_no_size() {
        for n in [MOST - 1, MOST, MOST + 1, MOST + 2] {
            let placed = counted(n, 1.0, false);
            assert_eq!(placed.number(), n as u64);
            assert_eq!(placed.classes.is_empty(), n <= MOST);
        }
    }
}
