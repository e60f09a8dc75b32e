//! Values on an axis: its ends, its unit, its ticks.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::axis::{Axis, Scale};
use super::ticks::{Stretch, Tick};
use crate::font;
use crate::scale::{Unit, decimal_exponent, power_of_ten};

/// Units that take prefixes; a quotient that begins with one of them too.
const PREFIXABLE: [&str; 7] = ["s", "m", "J", "N", "Pa", "W", "Hz"];
/// Units that are not used with kilo.
const NEVER_LARGER: [&str; 2] = ["s", "m"];
/// Free space beyond the series, as a share of the axis.
const ROOM: f64 = 0.04;
/// A logarithmic axis that finds its own ends reaches at most this many decades below its upper end: the digits of an f64.
const MOST_DECADES: f64 = 16.0;

/// Needs of the series of a chart for one axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Need {
    /// Smallest and largest value that has a place (SI).
    pub(super) values: Option<(f64, f64)>,
    /// Whether the axis ends with the values, as under lines that run from end to end.
    pub(super) tight: bool,
}

impl Need {
    /// Takes a value into account, if it has a place.
    pub(super) fn add(&mut self, axis: &Axis, value: f64) {
        if axis.scale.place(value).is_some() {
            let (low, high) = self.values.unwrap_or((value, value));
            self.values = Some((low.min(value), high.max(value)));
        }
    }
}

/// The ends of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Span {
    scale: Scale,
    unit: Unit,
    /// Values in `unit`.
    ends: (f64, f64),
    /// Their places.
    places: (f64, f64),
    name: String,
}

impl Span {
    pub(super) fn new(axis: &Axis, need: Need) -> Self {
        let scale = axis.scale;
        let empty = if scale.is_share() {
            (0.01, 0.99)
        } else {
            (0.0, 1.0)
        };
        let empty = if scale == Scale::Log {
            (1.0, 10.0)
        } else {
            empty
        };
        let (low, high) = axis.range.or(need.values).unwrap_or(empty);
        let unit = unit_of(axis, low, high);
        let ends = (low / unit.size, high / unit.size);
        let ends = match (axis.range, need.values) {
            (Some(_), _) | (None, None) => ends,
            _ if scale == Scale::Linear => widened_evenly(ends, need.tight),
            _ => widened(scale, ends, need.tight),
        };
        let place = |value| scale.place(value).unwrap_or(0.0);
        Self {
            scale,
            places: (place(ends.0), place(ends.1)),
            unit,
            ends,
            name: axis.name.clone(),
        }
    }

    /// Where a value (SI) is between the ends, 0 to 1, and beyond them outside; `None` where it has no place.
    pub(super) fn share(&self, value: f64) -> Option<f64> {
        let (low, high) = self.places;
        let share = (self.scale.place(value / self.unit.size)? - low) / (high - low);
        share.is_finite().then_some(share)
    }

    /// Share of a value as by [`Span::share`]; a value infinitely far on the axis, as zero on a logarithmic one, is beyond its
    /// end.
    pub(super) fn reach(&self, value: f64) -> Option<f64> {
        let beyond = match self.scale {
            Scale::Linear => None,
            Scale::Log => (value <= 0.0).then_some(-1.0),
            Scale::Probability | Scale::RosinRammler if value <= 0.0 => Some(-1.0),
            Scale::Probability | Scale::RosinRammler => (value >= 1.0).then_some(2.0),
        };
        self.share(value).or(beyond)
    }

    /// Length of a linear axis (SI); `None` of others.
    pub(super) fn extent(&self) -> Option<f64> {
        let extent = (self.ends.1 - self.ends.0) * self.unit.size;
        (self.scale == Scale::Linear && extent > 0.0).then_some(extent)
    }

    /// Name and unit.
    pub(super) fn title(&self) -> String {
        match (self.name.is_empty(), self.unit.name.is_empty()) {
            (_, true) => self.name.clone(),
            (true, false) => self.unit.name.clone(),
            (false, false) => format!("{} ({})", self.name, self.unit.name),
        }
    }

    /// With ticks, on a line of `length` points.
    pub(super) fn ruler(&self, length: f64, across: bool, lettering: f64) -> Ruler {
        let stretch = Stretch {
            scale: self.scale,
            low: self.ends.0,
            high: self.ends.1,
            length,
            across,
            lettering,
        };
        let (low, high) = self.places;
        let ticks = stretch.ticks().into_iter().map(|tick| Tick {
            place: ((tick.place - low) / (high - low)).clamp(0.0, 1.0),
            ..tick
        });
        Ruler {
            ticks: ticks.collect(),
        }
    }
}

fn unit_of(axis: &Axis, low: f64, high: f64) -> Unit {
    let plain = || Unit {
        size: 1.0,
        name: axis.unit.clone(),
    };
    let first = axis.unit.split('/').next().unwrap_or_default();
    let prefixable = PREFIXABLE.contains(&first);
    let largest = low.abs().max(high.abs());
    match axis.scale {
        Scale::Probability | Scale::RosinRammler => plain(),
        Scale::Log if prefixable && high / low < 1e4 => {
            Unit::not_above_plain(low.sqrt() * high.sqrt(), &axis.unit)
        }
        Scale::Log => plain(),
        Scale::Linear if NEVER_LARGER.contains(&first) => {
            Unit::not_above_plain(largest, &axis.unit)
        }
        Scale::Linear if prefixable => Unit::for_magnitude(largest, &axis.unit),
        Scale::Linear => match decimal_exponent(largest) {
            Some(exponent) if !(-3..5).contains(&exponent) => {
                let unit = Unit::for_magnitude(largest, "");
                let power = exponent.div_euclid(3) * 3;
                Unit {
                    size: unit.size,
                    name: format!("10{} {}", crate::scale::superscript(power), axis.unit)
                        .trim_end()
                        .into(),
                }
            }
            _ => plain(),
        },
    }
}

/// An even axis for these values: from 0 where that costs little, never empty, with free space at its ends.
fn widened_evenly((low, high): (f64, f64), tight: bool) -> (f64, f64) {
    let (mut low, mut high) = crate::value_range::opened(low, high);
    if tight {
        return (low, high);
    }
    let (mut below, mut above) = (ROOM, ROOM);
    if low >= 0.0 && low <= 0.3 * high {
        (low, below) = (0.0, 0.0);
    } else if high <= 0.0 && high >= 0.3 * low {
        (high, above) = (0.0, 0.0);
    }
    let size = high - low;
    below *= size;
    above *= size;
    (low - below, high + above)
}

/// Widened ends of a non-linear scale; the free space is a share of the axis as drawn.
fn widened(scale: Scale, (low, high): (f64, f64), tight: bool) -> (f64, f64) {
    if scale == Scale::Log {
        let low = low.max(high * power_of_ten(-MOST_DECADES as i32));
        let room = match (high <= low * (1.0 + 1e-9), tight) {
            (true, _) => 2.0,
            (false, true) => 1.0,
            (false, false) => libm::pow(high / low, ROOM),
        };
        return (
            (low / room).max(f64::MIN_POSITIVE),
            (high * room).min(f64::MAX),
        );
    }
    // Shares: a fifth of the way to 0 and to 1.
    let share = if tight && low < high { 0.0 } else { 0.2 };
    (low - share * low, high + share * (1.0 - high))
}

/// An axis of a chart in the form of plotters; its values are places from 0 to 1.
#[derive(Debug, Clone)]
pub(super) struct Ruler {
    ticks: Vec<Tick>,
}

impl Ruler {
    /// The widest number (points).
    pub(super) fn widest(&self, lettering: f64) -> f64 {
        let widths = self
            .ticks
            .iter()
            .map(|tick| font::width(&tick.label, lettering));
        widths.fold(0.0, f64::max)
    }

    /// Numbers and their places.
    pub(super) fn labelled(&self) -> impl Iterator<Item = &Tick> {
        self.ticks.iter().filter(|tick| !tick.label.is_empty())
    }
}

impl Ranged for Ruler {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        first + (value * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let faint = hint.weight().allow_light_points();
        (self.ticks.iter())
            .filter(|tick| tick.label.is_empty() == faint)
            .map(|tick| tick.place)
            .collect()
    }

    fn range(&self) -> std::ops::Range<f64> {
        0.0..1.0
    }
}

impl ValueFormatter<f64> for Ruler {
    fn format_ext(&self, value: &f64) -> String {
        let tick = self.ticks.iter().find(|tick| tick.place == *value);
        tick.map_or(String::new(), |tick| tick.label.clone())
    }
}
