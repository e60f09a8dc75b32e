//! Boxes along the camera's axes.

use glam::DVec3;

/// A box along the camera's axes (m); empty until something is added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extent {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
}

impl Extent {
    pub(crate) const EMPTY: Self = Self {
        low: DVec3::MAX,
        high: DVec3::MIN,
    };

    pub(crate) fn add(&mut self, point: DVec3, radius: f64) {
        self.low = self.low.min(point - radius);
        self.high = self.high.max(point + radius);
    }

    pub(crate) fn union(mut self, other: Self) -> Self {
        if !other.is_empty() {
            self.low = self.low.min(other.low);
            self.high = self.high.max(other.high);
        }
        self
    }

    /// The part of it in another.
    pub(crate) fn within(&self, other: &Self) -> Self {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        // Boxes that pass each other along one axis share nothing.
        if low.cmple(high).all() {
            Self { low, high }
        } else {
            Self::EMPTY
        }
    }

    /// With so much more on each side.
    pub(crate) fn widened(&self, by: f64) -> Self {
        Self {
            low: self.low - by,
            high: self.high + by,
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.low.x > self.high.x
    }

    /// Zero if empty.
    pub(crate) fn size(&self) -> DVec3 {
        if self.is_empty() {
            DVec3::ZERO
        } else {
            self.high - self.low
        }
    }

    pub(crate) fn middle(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// The corners from the middle.
    pub(crate) fn corners(&self) -> [DVec3; 8] {
        let half = 0.5 * self.size();
        std::array::from_fn(|k| {
            let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
            half * DVec3::new(sign(0), sign(1), sign(2))
        })
    }

    /// The extent of spheres (centre along the camera's axes, radius) without the few that have left the bed by several
    /// times its size: they would shrink it to a dot.
    pub(crate) fn of_bed(spheres: &[(DVec3, f64)]) -> Self {
        let mut full = Self::EMPTY;
        for (centre, radius) in spheres {
            full.add(*centre, *radius);
        }
        if spheres.len() < 50 {
            return full;
        }
        // The middle 98 % along each axis, widened by its own size, holds any bed without stragglers.
        let largest = spheres.iter().map(|s| s.1).fold(0.0, f64::max);
        let mut values = vec![0.0; spheres.len()];
        let mut bed = full;
        for axis in 0..3 {
            for (value, (centre, _)) in values.iter_mut().zip(spheres) {
                *value = centre[axis];
            }
            let last = values.len() - 1;
            let low = *values.select_nth_unstable_by(last / 100, f64::total_cmp).1;
            let upper = last - last / 100;
            let high = *values.select_nth_unstable_by(upper, f64::total_cmp).1;
            let reach = (high - low) + 2.0 * largest;
            bed.low[axis] = bed.low[axis].max(low - reach);
            bed.high[axis] = bed.high[axis].min(high + reach);
        }
        bed
    }
}
