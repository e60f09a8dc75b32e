//! The thickness of the skin, adapted from counts.

use crate::cell::Cell;

/// Time of building a list, per particle, over the time of testing one listed pair that does not touch
/// (measured; see `docs/lab/performance.md`), where contacts remember something, which lies beside each listed pair and is carried over to the next list, and where they
/// do not. It matters to speed, and to when rows are sorted, which is the order of sums; not to which contacts are found.
const REBUILD_OVER_TEST: [f64; 2] = [200.0, 100.0];

/// Largest thickness over the mean radius. Only where particles are sparse and fast does the cost of lists
/// need so much; beyond it a list holds pairs by the volume around a particle, and gains nothing.
const WIDEST: f64 = 3.0;

/// The distance beyond contact at which a pair is listed, and the rule by which it adapts to the scene.
///
/// A thick skin lists pairs that never touch, a thin one is used up quickly. With v the skin used per step and g the listed
/// pairs that do not touch per particle and metre of skin, a step costs g s + c v / s per particle, c the cost of a rebuild:
/// least at s = sqrt(c v / g). Both v and g are counts and lengths that the state determines, so the skin is the same for every
/// number of threads and every machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skin {
    /// Present thickness, m.
    pub thickness: f64,
    /// Least thickness, m.
    pub least: f64,
    /// Largest thickness, m.
    pub largest: f64,
}

impl Skin {
    /// Largest thickness (m) for particles of the mean radius `mean` (m).
    #[must_use]
    pub const fn widest(mean: f64) -> f64 {
        WIDEST * mean
    }

    /// For particles of these radii (m), the smallest and the mean one: starts at a tenth of the mean radius.
    #[must_use]
    pub fn new([smallest, mean]: [f64; 2]) -> Self {
        Self {
            thickness: 0.1 * mean,
            least: 0.02 * smallest,
            largest: Self::widest(mean),
        }
    }

    /// The skin of a run's first list, limited by the periodic axes. Radii (m): the smallest and the largest that can occur, and
    /// the mean one; `range`: how far beyond contact forces reach, m.
    #[must_use]
    pub fn first([smallest, mean, largest]: [f64; 3], range: f64, domain: &Cell) -> Self {
        let mut skin = Self::new([smallest, mean]);
        let mut room = f64::INFINITY;
        for axis in 0..3 {
            if domain.is_periodic(axis) {
                room = room.min(0.5 * domain.size()[axis] - 2.0 * largest - range);
            }
        }
        skin.limit(0.99 * room);
        skin
    }

    /// Sets the thickness for the next list: `steps` is how long the last one lasted, `idle_pairs` how many of its pairs per
    /// particle did not touch in the end; `remembers`: whether contacts have histories.
    pub fn adapt(&mut self, steps: u64, idle_pairs: f64, remembers: bool) {
        if steps == 0 {
            return;
        }
        let used_per_step = self.thickness / steps as f64;
        let pairs_per_metre = (idle_pairs / self.thickness).max(0.1 / self.thickness);
        let [with_history, without] = REBUILD_OVER_TEST;
        let rebuild_over_test = if remembers { with_history } else { without };
        let best = (rebuild_over_test * used_per_step / pairs_per_metre).sqrt();
        self.thickness = best
            .clamp(self.thickness / 1.5, self.thickness * 1.5)
            .clamp(self.least, self.largest);
    }

    /// Whether the thickness lies between the limits, as that of every run does.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        self.thickness >= 0.0 && self.least <= self.largest && self.thickness.is_finite()
    }

    /// Keeps the skin below what a periodic domain permits (m).
    fn limit(&mut self, largest: f64) {
        self.largest = self.largest.min(largest);
        self.least = self.least.min(self.largest);
        self.thickness = self.thickness.min(self.largest);
    }
}

crate::state::plain!(Skin {
    thickness,
    least,
    largest
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_motion_within_its_limits() {
        for remembers in [false, true] {
            let mut skin = Skin::new([1e-3; 2]);
            for _ in 0..50 {
                skin.adapt(1, 1.0, remembers);
            }
            assert!(
                skin.thickness > 0.9 * skin.largest,
                "a fast scene wants a thick skin"
            );
            for _ in 0..50 {
                skin.adapt(1_000_000, 1.0, remembers);
            }
            assert!(skin.thickness < 0.1e-3, "a quiet scene wants a thin one");
            assert!(skin.thickness >= skin.least);
        }
    }

    /// Particles use up the skin at a steady rate v, and one pair per particle and tenth of a millimetre g is listed and does not touch: the
    /// skin goes to sqrt(c v / g), but for lists that last whole steps.
    #[test]
    fn goes_to_the_least_cost() {
        let (way_per_step, pairs_per_metre) = (1e-7, 1e4);
        for (remembers, cost) in [(true, 200.0), (false, 100.0)] {
            let mut skin = Skin::new([1e-3; 2]);
            for _ in 0..50 {
                let steps = (skin.thickness / way_per_step) as u64;
                skin.adapt(steps, pairs_per_metre * skin.thickness, remembers);
            }
            let best = f64::sqrt(cost * way_per_step / pairs_per_metre);
            assert!((skin.thickness / best - 1.0).abs() < 0.01);
        }
    }
}
