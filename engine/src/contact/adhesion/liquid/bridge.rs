//! Memory of a contact of its liquid bridge.

use super::super::dry;
use super::{Fit, NO_LIQUID};
use crate::contact::{History, HistoryNumber, LawEvents};
use crate::lanes::{MOST_LANES, Real};

/// Numbers that describe the force of any bridge over its gap ([`Form`](super::Form)).
pub const CURVE: usize = 14;

/// Those of the forms with a formula: all but [`Form::Exact`](super::Form).
pub const SHORT: usize = 5;

/// A liquid bridge, or several in lanes. The default is no bridge.
///
/// The volume changes by the rules of migration only. All that follows from it and the radii is kept beside it, so that no step
/// computes it again. Contacts of laws with short formulas keep the first [`SHORT`] numbers of the curve alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridge<L = f64, const N: usize = CURVE> {
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
    /// The force over the gap; the first number is the pull at the touch, N.
    pub curve: [L; N],
}

impl<L: Real, const N: usize> Default for Bridge<L, N> {
    fn default() -> Self {
        Self {
            volume: L::ZERO,
            wet: L::ZERO,
            end: L::ZERO,
            gap: L::ZERO,
            force: L::ZERO,
            curve: [L::ZERO; N],
        }
    }
}

impl<L: Real, const N: usize> Bridge<L, N> {
    /// Bridges `one(k)` in lane `k` but for their curves.
    #[inline(always)]
    fn with_curve<'a>(curve: [L; N], one: impl Fn(usize) -> &'a Bridge<f64, N>) -> Self {
        Self {
            volume: L::from_lanes(|k| one(k).volume),
            wet: L::from_lanes(|k| one(k).wet),
            end: L::from_lanes(|k| one(k).end),
            gap: L::from_lanes(|k| one(k).gap),
            force: L::from_lanes(|k| one(k).force),
            curve,
        }
    }

    /// This bridge with room for `M` numbers of its curve: filled up with 0, or without the last ones.
    #[inline(always)]
    #[must_use]
    pub fn resized<const M: usize>(&self) -> Bridge<L, M> {
        let Self {
            volume,
            wet,
            end,
            gap,
            force,
            curve,
        } = *self;
        let mut resized = [L::ZERO; M];
        for (to, from) in resized.iter_mut().zip(curve) {
            *to = from;
        }
        Bridge {
            volume,
            wet,
            end,
            gap,
            force,
            curve: resized,
        }
    }

    /// From its numbers in the order in which they are written.
    #[inline(always)]
    fn of_numbers(number: impl Fn(usize) -> L) -> Self {
        Self {
            volume: number(0),
            wet: number(1),
            end: number(2),
            gap: number(3),
            force: number(4),
            curve: std::array::from_fn(|k| number(FIRST + k)),
        }
    }
}

/// Numbers before those of the curve.
const FIRST: usize = 5;

/// How many numbers at the end of the saved history of each contact are those of its bridge, in a run whose pairs of materials have
/// laws of these names ([`names_of_pairs`](crate::contact::registry::LawTable::names_of_pairs)). One law that needs the long curve, or one
/// of dry cohesion, gives room for it to the contacts of all.
#[must_use]
pub fn saved_numbers<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    let mut has_dry = false;
    let of_law = |law: &str| match law {
        NO_LIQUID => FIRST + SHORT,
        law => match Fit::named(law) {
            Some(Fit::YoungLaplace) => FIRST + CURVE,
            Some(_) => FIRST + SHORT,
            None => 0,
        },
    };
    let of_pair = |name: &'a str| {
        let law = name.rsplit(", ").next().unwrap_or_default();
        has_dry |= dry::KEYS.iter().any(|keys| keys.name == law);
        of_law(law)
    };
    match names.map(of_pair).max() {
        None | Some(0) => 0,
        Some(_) if has_dry => FIRST + CURVE,
        Some(most) => most,
    }
}

/// Volume of the bridge in a saved history, whose last `numbers` are those of the bridge, m^3; 0 where there is none.
#[must_use]
pub fn saved_volume(history: &[f64], numbers: usize) -> f64 {
    let first = history.len().checked_sub(numbers.max(1));
    let volume = first.and_then(|first| history.get(first));
    let is_volume = |volume: &&f64| **volume > 0.0 && volume.is_finite();
    volume.filter(is_volume).copied().unwrap_or(0.0)
}

impl<L: Real, const N: usize> History<L> for Bridge<L, N> {
    type One = Bridge<f64, N>;
    const LENGTH: usize = FIRST + N;

    /// Outputs show bridges in columns of their own.
    fn columns() -> Vec<HistoryNumber> {
        Vec::new()
    }

    fn swapped(self) -> Self {
        self
    }

    fn write(&self, numbers: &mut Vec<L>) {
        let Self {
            volume,
            wet,
            end,
            gap,
            force,
            curve,
        } = *self;
        numbers.extend([volume, wet, end, gap, force]);
        numbers.extend(curve);
    }

    fn show(&self, _: &mut Vec<L>) {}

    fn read(numbers: &[L]) -> Self {
        Self::of_numbers(|k| numbers[k])
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> Bridge<f64, N>) -> Self {
        let mut all = [Bridge::default(); MOST_LANES];
        for (k, bridge) in all[..L::LANES].iter_mut().enumerate() {
            *bridge = one(k);
        }
        Self::gather_from(|k| &all[k])
    }

    #[inline(always)]
    fn gather_from<'a>(one: impl Fn(usize) -> &'a Bridge<f64, N>) -> Self {
        // A plain loop: what `array::from_fn` calls is not always inlined, and then copies a whole history for each number.
        let mut curve = [L::ZERO; N];
        for (n, number) in curve.iter_mut().enumerate() {
            *number = L::from_lanes(|k| one(k).curve[n]);
        }
        Self::with_curve(curve, one)
    }

    /// Of the force over the gap only the force at contact is needed.
    #[inline(always)]
    fn gather_touching<'a>(one: impl Fn(usize) -> &'a Bridge<f64, N>) -> Self {
        let mut curve = [L::ZERO; N];
        curve[0] = L::from_lanes(|k| one(k).curve[0]);
        Self::with_curve(curve, one)
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> Bridge<f64, N> {
        Bridge {
            volume: self.volume.lane(k),
            wet: self.wet.lane(k),
            end: self.end.lane(k),
            gap: self.gap.lane(k),
            force: self.force.lane(k),
            curve: std::array::from_fn(|n| self.curve[n].lane(k)),
        }
    }

    /// Writes the gap and the force: all that depends on the volume changes by the rules of migration alone.
    #[inline(always)]
    fn put(&self, k: usize, one: &mut Bridge<f64, N>) {
        (one.gap, one.force) = (self.gap.lane(k), self.force.lane(k));
    }
}

/// Event of a contact that can have a liquid bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BridgeEvent {
    /// Its two sides touch, or their films meet, and nothing is remembered yet.
    Touch,
    /// The bridge ends: the gap is too wide, or the contact has no slot any more.
    End,
}

/// Events of liquid bridges; parts of the step read and replace whole bridges.
#[derive(Debug)]
pub struct BridgeEvents;

impl<const N: usize> LawEvents<Bridge<f64, N>> for BridgeEvents {
    type Event = BridgeEvent;
    type Memory = Bridge;
    const HAPPEN: bool = true;

    fn event(bridge: &Bridge<f64, N>) -> BridgeEvent {
        if bridge.wet == 0.0 {
            BridgeEvent::Touch
        } else {
            BridgeEvent::End
        }
    }

    #[inline(always)]
    fn end(bridge: &Bridge<f64, N>) -> Option<BridgeEvent> {
        (bridge.volume > 0.0).then_some(BridgeEvent::End)
    }

    fn memory(bridge: &Bridge<f64, N>) -> Bridge {
        bridge.resized()
    }

    fn replace(bridge: &mut Bridge<f64, N>, with: &Bridge) {
        *bridge = with.resized();
    }
}
