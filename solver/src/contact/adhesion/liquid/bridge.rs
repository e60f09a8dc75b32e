//! What a contact remembers of its liquid bridge.

use crate::contact::{History, HistoryNumber};
use crate::lanes::Real;

/// Numbers that describe the force of a bridge over its gap ([`Form`](super::Form)).
pub const CURVE: usize = 5;

/// A liquid bridge, or several in lanes. The default is no bridge.
///
/// The volume changes by the rules of migration only. All that follows from it and the radii is kept beside it, so that no step
/// computes it again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridge<L = f64> {
    /// Volume, m^3; 0 for a pair that touched without liquid.
    pub volume: L,
    /// 1 from the touch at which a bridge could form until the pair is dry again, else 0.
    pub wet: L,
    /// Gap at which the bridge breaks, m.
    pub end: L,
    /// Gap at the last force evaluation, m; negative for an overlap.
    pub gap: L,
    /// Capillary force at the last force evaluation, N; negative pulls.
    pub force: L,
    /// The force over the gap.
    pub curve: [L; CURVE],
}

impl<L: Real> Default for Bridge<L> {
    fn default() -> Self {
        Self {
            volume: L::ZERO,
            wet: L::ZERO,
            end: L::ZERO,
            gap: L::ZERO,
            force: L::ZERO,
            curve: [L::ZERO; CURVE],
        }
    }
}

impl<L: Real> Bridge<L> {
    /// Its numbers in the order in which they are written.
    fn numbers(&self) -> [L; 5 + CURVE] {
        let Self {
            volume,
            wet,
            end,
            gap,
            force,
            curve,
        } = *self;
        let [a, b, c, d, e] = curve;
        [volume, wet, end, gap, force, a, b, c, d, e]
    }

    fn of_numbers(numbers: impl Fn(usize) -> L) -> Self {
        Self {
            volume: numbers(0),
            wet: numbers(1),
            end: numbers(2),
            gap: numbers(3),
            force: numbers(4),
            curve: std::array::from_fn(|k| numbers(5 + k)),
        }
    }
}

impl<L: Real> History<L> for Bridge<L> {
    type One = Bridge;
    const LENGTH: usize = 5 + CURVE;

    /// Outputs show bridges in columns of their own.
    fn columns() -> Vec<HistoryNumber> {
        Vec::new()
    }

    fn swapped(self) -> Self {
        self
    }

    fn write(&self, numbers: &mut Vec<L>) {
        numbers.extend(self.numbers());
    }

    fn show(&self, _: &mut Vec<L>) {}

    fn read(numbers: &[L]) -> Self {
        Self::of_numbers(|k| numbers[k])
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> Bridge) -> Self {
        Self::of_numbers(|number| L::from_lanes(|k| one(k).numbers()[number]))
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> Bridge {
        let numbers = self.numbers();
        Bridge::of_numbers(|number| numbers[number].lane(k))
    }

    #[inline(always)]
    fn bridge(&self) -> Self {
        *self
    }

    fn set_bridge(&mut self, bridge: Self) {
        *self = bridge;
    }
}
