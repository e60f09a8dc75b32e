//! Where an axis has its numbers.

use super::axis::Scale;
use crate::font;
use crate::scale::{Ticks, short_number, superscript};

/// A place on an axis; without a label: a faint line only.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) place: f64,
    pub(super) label: String,
}

/// Free space between numbers side by side and above each other, in heights of their letters.
const APART: (f64, f64) = (0.8, 0.25);

/// The part of an axis that ticks are for: values in the unit of its numbers at both ends, and its length on the page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    pub(super) scale: Scale,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Points.
    pub(super) length: f64,
    /// Whether numbers stand side by side (along x) or above each other.
    pub(super) across: bool,
    /// Height of the letters (points).
    pub(super) lettering: f64,
}

impl Stretch {
    /// Ascending, inside the ends.
    pub(super) fn ticks(&self) -> Vec<Tick> {
        let ticks = match self.scale {
            Scale::Linear => self.even(),
            Scale::Log => self.logarithmic(),
            Scale::Probability | Scale::RosinRammler => self.shares(),
        };
        // A scale that bends needs at least two numbers; where its round ones are too far apart, evenly spaced values serve.
        if ticks.iter().filter(|tick| !tick.label.is_empty()).count() >= 2 {
            ticks
        } else {
            self.even()
        }
    }

    /// Number of labels that fit side by side.
    fn room_for(&self) -> usize {
        let each = if self.across {
            6.0 * self.lettering
        } else {
            3.2 * self.lettering
        };
        ((self.length / each) as usize).clamp(2, 10)
    }

    fn even(&self) -> Vec<Tick> {
        let percent = if self.scale.is_share() { 100.0 } else { 1.0 };
        let ticks = Ticks::new(self.low * percent, self.high * percent, self.room_for());
        let labelled = ticks.at.iter().filter_map(|value| {
            Some(Tick {
                place: self.scale.place(value / percent)?,
                label: ticks.label(*value),
            })
        });
        labelled.collect()
    }

    fn logarithmic(&self) -> Vec<Tick> {
        let (Some(low), Some(high)) = (self.scale.place(self.low), self.scale.place(self.high))
        else {
            return Vec::new();
        };
        let slack = 1e-9 * (high - low).max(1e-6);
        let (first, last) = ((low - slack).ceil() as i32, (high + slack).floor() as i32);
        let decades = high - low;
        let inside = |place: f64| place >= low - slack && place <= high + slack;
        let mut ticks = Vec::new();
        if decades >= 2.0 && last > first {
            let step = ((last - first) as usize / self.room_for()).max(1) as i32;
            // Whole numbers where they are short, powers elsewhere; never both on one axis.
            let short = first >= -3 && last <= 4;
            for exponent in first - 1..=last {
                if exponent >= first {
                    let labelled = (exponent - first) % step == 0;
                    let label = match (labelled, short) {
                        (false, _) => String::new(),
                        (true, true) => short_number(crate::scale::power_of_ten(exponent), 1),
                        (true, false) => format!("10{}", superscript(exponent)),
                    };
                    let place = f64::from(exponent);
                    ticks.push(Tick { place, label });
                }
                let between = if step == 1 { 2..10 } else { 0..0 };
                ticks.extend(
                    between
                        .map(|digit| f64::from(exponent) + libm::log10(f64::from(digit)))
                        .filter(|place| inside(*place))
                        .map(|place| Tick {
                            place,
                            label: String::new(),
                        }),
                );
            }
            return ticks;
        }
        // Less than two decades: 1, 2 and 5 if they keep apart.
        let mut wanted = Vec::new();
        for (rank, digits) in [&[1][..], &[2, 5], &[3], &[4, 6, 7, 8, 9]]
            .into_iter()
            .enumerate()
        {
            for exponent in first - 1..=last {
                for digit in digits {
                    let place = f64::from(exponent) + libm::log10(f64::from(*digit));
                    if inside(place) {
                        let value = f64::from(*digit) * crate::scale::power_of_ten(exponent);
                        let named = rank < 3 || decades < 0.5;
                        let label = if named {
                            short_number(value, 2)
                        } else {
                            String::new()
                        };
                        wanted.push(Tick { place, label });
                    }
                }
            }
        }
        self.thinned(wanted)
    }

    fn shares(&self) -> Vec<Tick> {
        // By importance: the middle, the tails that have names, what lies between.
        let mut shares: Vec<f64> = vec![0.5];
        let both = |share: f64| [share, 1.0 - share];
        for decade in 1..8 {
            shares.extend(both(crate::scale::power_of_ten(-decade)));
        }
        shares.extend(
            [0.2, 0.3, 0.05, 0.4, 0.02, 0.005]
                .into_iter()
                .flat_map(both),
        );
        let named = shares.len();
        for decade in 1..5 {
            let unit = crate::scale::power_of_ten(-decade);
            shares.extend((2..10).flat_map(|k| both(f64::from(k) * unit)));
        }
        let ticks = shares.iter().enumerate().filter_map(|(rank, share)| {
            let inside = *share >= self.low * (1.0 - 1e-9) && *share <= self.high * (1.0 + 1e-9);
            let place = self.scale.place(*share).filter(|_| inside)?;
            let label = if rank < named {
                short_number(100.0 * share, if *share > 0.5 { 9 } else { 1 })
            } else {
                String::new()
            };
            Some(Tick { place, label })
        });
        self.thinned(ticks.collect())
    }

    /// `wanted` by importance: numbers that would touch a more important one are left out, lines that repeat another too.
    fn thinned(&self, wanted: Vec<Tick>) -> Vec<Tick> {
        let (Some(low), Some(high)) = (self.scale.place(self.low), self.scale.place(self.high))
        else {
            return Vec::new();
        };
        let spot = |place: f64| (place - low) / (high - low) * self.length;
        let half = |label: &str| {
            if self.across {
                0.5 * font::width(label, self.lettering)
            } else {
                0.5 * self.lettering
            }
        };
        let apart = if self.across { APART.0 } else { APART.1 };
        let mut kept: Vec<Tick> = Vec::new();
        for mut tick in wanted {
            if kept
                .iter()
                .any(|other| (spot(other.place) - spot(tick.place)).abs() < 0.5)
            {
                continue;
            }
            let touches = kept.iter().any(|other| {
                !other.label.is_empty()
                    && (spot(other.place) - spot(tick.place)).abs()
                        < half(&other.label) + half(&tick.label) + apart * self.lettering
            });
            if touches {
                tick.label.clear();
            }
            kept.push(tick);
        }
        kept.sort_by(|a, b| f64::total_cmp(&a.place, &b.place));
        kept
    }
}
