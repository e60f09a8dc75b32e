//! What the series of a chart need of its axes.

use super::axis::Axis;
use super::chart::{Chart, Shape};
use super::ruler::Need;

/// What all series need of both axes.
pub(super) struct Needs {
    pub(super) x: Need,
    pub(super) y: Need,
    /// Points that have a place, and points that have none.
    pub(super) drawn: usize,
    pub(super) lost: usize,
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
            lost: 0,
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
                    needs.lost += heights.len() - drawn;
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
            let infinite =
                |axis: &Axis, value: f64| axis.scale.is_share() && (value == 0.0 || value == 1.0);
            let there = |axis: &Axis, value: f64| {
                axis.scale.place(value).is_some() || infinite(axis, value)
            };
            if there(&chart.x, *x) && there(&chart.y, *y) {
                self.x.add(&chart.x, *x);
                self.y.add(&chart.y, *y);
                self.drawn += 1;
            } else {
                self.lost += 1;
            }
        }
    }
}
