//! The distance that particles may move from their listed positions, by their size.

use super::levels::CLASSES;
use super::{ExtraSkins, Levels};
use crate::lanes::Real;

/// Half the skin of each level of sizes, without what few of a level have more: the speed of a particle over it is the part of its skin that it uses
/// up in a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSkins {
    /// Of each level the largest radius, m, and the inverse square of half the skin, 1/m^2.
    levels: [[f64; 2]; CLASSES],
    /// How many levels there are, one at least.
    count: usize,
}

impl HalfSkins {
    /// `skin`: thickness without what is extra, m.
    #[must_use]
    pub fn new(levels: &Levels, extra: &ExtraSkins, skin: f64) -> Self {
        // Without a skin every displacement is too large; the number stays finite.
        let part = |level: usize| (1.0 / (0.5 * skin + extra.of_level(level))).min(1e150);
        let mut all = [[0.0; 2]; CLASSES];
        for (level, (one, &largest)) in all.iter_mut().zip(&levels.largest).enumerate() {
            *one = [largest, part(level) * part(level)];
        }
        let count = if extra.levels.is_empty() {
            1
        } else {
            levels.largest.len().min(CLASSES)
        };
        Self { levels: all, count }
    }

    /// Whether a run can have produced it.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        (1..=CLASSES).contains(&self.count) && self.levels.iter().flatten().all(|&one| one >= 0.0)
    }

    /// Whether all sizes have the same skin.
    #[inline(always)]
    #[must_use]
    pub fn is_one(&self) -> bool {
        self.count == 1
    }

    /// The squared part of their skin, 1/s^2, that particles use up which are as large (m) and have squared speeds (m^2/s^2) as given.
    #[inline(always)]
    #[must_use]
    pub fn squared_part<L: Real>(&self, radius: L, squared_speed: L) -> L {
        let mut per_square = L::splat(self.levels[0][1]);
        for k in 1..self.count {
            let larger = L::splat(self.levels[k - 1][0]).below(radius);
            per_square = L::select(larger, L::splat(self.levels[k][1]), per_square);
        }
        squared_speed * per_square
    }
}

impl Default for HalfSkins {
    /// Before the first list: no share of anything.
    fn default() -> Self {
        Self {
            levels: [[0.0; 2]; CLASSES],
            count: 1,
        }
    }
}

crate::state::plain!(HalfSkins { levels, count });

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Lanes;

    /// Sizes below, at and above the limits of levels, of which each has another skin, in several lanes and one by one.
    #[test]
    fn each_size_uses_up_the_skin_of_its_level() {
        let levels = Levels {
            largest: vec![1.0, 3.0, 10.0],
        };
        let extra = ExtraSkins {
            levels: vec![-0.04, 0.0, 0.25],
            rows: vec![],
        };
        let skins = HalfSkins::new(&levels, &extra, 0.1);
        let sizes = [0.2, 1.0, 1.0 + 1e-9, 2.0, 3.0, 3.1, 10.0, 11.0];
        let expected = sizes.map(|radius| {
            let part: f64 = 0.5 / (0.05 + extra.of_level(levels.of(radius)));
            part * part
        });
        let close = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-15;
        for (radius, expected) in sizes.into_iter().zip(expected) {
            assert!(close(skins.squared_part(radius, 0.25), expected));
        }
        let found = skins.squared_part(Lanes(sizes), Lanes([0.25; 8]));
        assert!((0..8).all(|k| close(found.lane(k), expected[k])));
        let same = HalfSkins::new(&levels, &ExtraSkins::default(), 0.1);
        assert!(same.is_one() && close(same.squared_part(11.0, 0.25), 100.0));
        assert!(HalfSkins::new(&levels, &extra, 0.0).is_possible());
    }
}
