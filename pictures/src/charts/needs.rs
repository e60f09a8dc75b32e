//! Needs of the series of a chart: the range and the ends of each axis.

use super::axis::{Axis, Scale};
use super::chart::{Chart, Shape};
use super::ruler::Need;

/// Points that have no place on a chart, by the reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Lost {
    /// Values that are not numbers, or infinite.
    no_value: usize,
    /// Zero or negative on a logarithmic axis.
    no_logarithm: usize,
    /// Outside of 0 to 1 on an axis for shares.
    no_share: usize,
}

impl Lost {
    /// All of them.
    pub(super) fn all(self) -> usize {
        self.no_value + self.no_logarithm + self.no_share
    }

    /// Why they have none, with numbers where there are several reasons.
    pub(super) fn reasons(self) -> String {
        let reasons = [
            (self.no_value, "without a value"),
            (self.no_logarithm, "at 0 or less on a log axis"),
            (self.no_share, "beyond 0 to 100 %"),
        ];
        let some = reasons.iter().filter(|(number, _)| *number > 0);
        match some.clone().count() {
            1 => some.map(|(_, reason)| (*reason).to_owned()).collect(),
            _ => {
                let numbered = some
                    .map(|(number, reason)| format!("{} {reason}", crate::scale::count(*number)));
                numbered.collect::<Vec<_>>().join(", ")
            }
        }
    }

    /// Counts a point whose coordinates are not all on their axes.
    fn add(&mut self, point: [(&Axis, f64); 2]) {
        let misses = point.iter().filter(|(axis, value)| !is_there(axis, *value));
        let number = if point.iter().all(|(_, value)| value.is_finite()) {
            match misses.map(|(axis, _)| axis.scale).next() {
                Some(Scale::Log) => &mut self.no_logarithm,
                Some(Scale::Probability | Scale::RosinRammler) => &mut self.no_share,
                _ => &mut self.no_value,
            }
        } else {
            &mut self.no_value
        };
        *number += 1;
    }
}

/// Whether a value has a place on an axis, be it infinitely far.
fn is_there(axis: &Axis, value: f64) -> bool {
    let infinite = axis.scale.is_share() && (value == 0.0 || value == 1.0);
    axis.scale.place(value).is_some() || infinite
}

/// Needs of all series for both axes.
pub(super) struct Needs {
    pub(super) x: Need,
    pub(super) y: Need,
    /// Points that have a place, and points that have none.
    pub(super) drawn: usize,
    pub(super) lost: Lost,
}

impl Needs {
    pub(super) fn of(chart: &Chart) -> Self {
        let mut needs = Self {
            x: Need {
                values: None,
                tight: true,
            },
            y: Need {
                values: None,
                tight: false,
            },
            drawn: 0,
            lost: Lost::default(),
        };
        let (mut rightwards, mut upwards, mut lines) = (true, true, false);
        for series in &chart.series {
            match &series.shape {
                Shape::Line(points) | Shape::Steps(points) => {
                    needs.points(chart, points);
                    rightwards &= points.is_sorted_by(|a, b| a.0 <= b.0);
                    upwards &= points.is_sorted_by(|a, b| a.1 <= b.1);
                    lines = true;
                }
                Shape::Band { lower, upper } => {
                    needs.points(chart, lower);
                    needs.points(chart, upper);
                    rightwards &= lower.is_sorted_by(|a, b| a.0 <= b.0);
                    upwards &= lower.is_sorted_by(|a, b| a.1 <= b.1);
                    lines = true;
                }
                Shape::MarkedLine(points) => {
                    needs.points(chart, points);
                    (rightwards, upwards) = (false, false);
                }
                Shape::Points { at, errors } => {
                    needs.points(chart, at);
                    for ((x, y), (dx, dy)) in at.iter().zip(errors) {
                        [x - dx, x + dx]
                            .iter()
                            .for_each(|x| needs.x.add(&chart.x, *x));
                        [y - dy, y + dy]
                            .iter()
                            .for_each(|y| needs.y.add(&chart.y, *y));
                    }
                    (rightwards, upwards) = (false, false);
                }
                Shape::Bars { edges, heights } => {
                    edges.iter().for_each(|x| needs.x.add(&chart.x, *x));
                    heights
                        .iter()
                        .chain([&0.0])
                        .for_each(|y| needs.y.add(&chart.y, *y));
                    let drawn = heights.iter().filter(|height| height.is_finite()).count();
                    needs.drawn += drawn;
                    needs.lost.no_value += heights.len() - drawn;
                    (rightwards, upwards) = (false, false);
                }
                Shape::Level(y) => needs.y.add(&chart.y, *y),
                Shape::Upright(x) => needs.x.add(&chart.x, *x),
                Shape::Heat(heat) => {
                    heat.x_edges.iter().for_each(|x| needs.x.add(&chart.x, *x));
                    heat.y_edges.iter().for_each(|y| needs.y.add(&chart.y, *y));
                    needs.drawn += heat.values.iter().filter(|v| v.is_finite()).count();
                    needs.y.tight = true;
                }
            }
        }
        needs.x.tight = rightwards;
        needs.y.tight |= lines && upwards && !rightwards;
        needs
    }

    fn points(&mut self, chart: &Chart, points: &[(f64, f64)]) {
        for (x, y) in points {
            if is_there(&chart.x, *x) && is_there(&chart.y, *y) {
                self.x.add(&chart.x, *x);
                self.y.add(&chart.y, *y);
                self.drawn += 1;
            } else {
                self.lost.add([(&chart.x, *x), (&chart.y, *y)]);
            }
        }
    }
}
