//! The thickness of the skin, adapted from counts.

use super::Images;

/// Time of building a list, per particle, over the time of testing one listed pair that does not touch
/// (measured; see `docs/performance.md`). Only the ratio matters, and only to speed.
const REBUILD_OVER_TEST: f64 = 50.0;

/// How far beyond contact a pair is listed, and the rule by which that follows the scene.
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
    /// For particles of these radii (m), the smallest, the mean and the largest one: starts at a tenth of the mean radius.
    #[must_use]
    pub fn new([smallest, mean, largest]: [f64; 3]) -> Self {
        Self {
            thickness: 0.1 * mean,
            least: 0.02 * smallest,
            // More than the mean radius is for levels of large ones only.
            largest: mean.max(largest),
        }
    }

    /// The skin of a run's first list, no thicker than periodic axes leave room for. Radii (m): the smallest and the largest that
    /// can occur, and the mean one; `range`: how far beyond contact forces reach, m.
    #[must_use]
    pub fn first([smallest, mean, largest]: [f64; 3], range: f64, images: &Images) -> Self {
        let mut skin = Self::new([smallest, mean, largest]);
        let mut room = f64::INFINITY;
        for axis in 0..3 {
            if images.periodic[axis] {
                room = room.min(0.5 * images.size[axis] - 2.0 * largest - range);
            }
        }
        skin.limit(0.99 * room);
        skin
    }

    /// Sets the thickness for the next list: `steps` is how long the last one lasted, `idle_pairs` how many of its pairs per
    /// particle did not touch in the end.
    pub fn adapt(&mut self, steps: u64, idle_pairs: f64) {
        if steps == 0 {
            return;
        }
        let used_per_step = self.thickness / steps as f64;
        let pairs_per_metre = (idle_pairs / self.thickness).max(0.1 / self.thickness);
        let best = (REBUILD_OVER_TEST * used_per_step / pairs_per_metre).sqrt();
        self.thickness = best
            .clamp(self.thickness / 1.5, self.thickness * 1.5)
            .clamp(self.least, self.largest);
    }

    /// Whether the thickness lies between the limits, as that of every run does.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        self.thickness >= 0.0 && self.least <= self.largest && self.thickness.is_finite()
    }

    /// Keeps the skin below the room that a periodic domain leaves (m).
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
        let mut skin = Skin::new([1e-3; 3]);
        for _ in 0..50 {
            skin.adapt(1, 1.0);
        }
        assert!(
            skin.thickness > 0.9 * skin.largest,
            "a fast scene wants a thick skin"
        );
        for _ in 0..50 {
            skin.adapt(1_000_000, 1.0);
        }
        assert!(skin.thickness < 0.1e-3, "a quiet scene wants a thin one");
        assert!(skin.thickness >= skin.least);
    }
}
