//! Where the series of a chart are between its axes: as lines, areas and points in shares of width and height.

use super::axis::Axis;
use super::board::units;
use super::chart::{Chart, Series, Shape};
use super::clip::{self, Shares};
use super::ruler::Span;

/// Half the width of the end of an error bar (points).
const CAP: f64 = 2.2;

/// A chart's series on axes with known ends.
pub(super) struct Outline<'a> {
    pub(super) chart: &'a Chart,
    pub(super) x: Span,
    pub(super) y: Span,
}

impl Outline<'_> {
    /// Places (shares) that a legend should leave free.
    pub(super) fn ink(&self) -> Vec<(f64, f64)> {
        const APART: f64 = 0.015;
        let mut ink = Vec::new();
        let mut along = |from: (f64, f64), to: (f64, f64)| {
            let length = (to.0 - from.0).abs().max((to.1 - from.1).abs());
            let steps = (length / APART).ceil().max(1.0);
            for step in 0..=steps as usize {
                let t = step as f64 / steps;
                ink.push((from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)));
            }
        };
        for series in &self.chart.series {
            for line in self.lines(series) {
                line.windows(2).for_each(|pair| along(pair[0], pair[1]));
            }
            for area in self.areas(series) {
                // From each corner through the area to its opposite: dense enough for bands and bars.
                let number = area.len();
                (0..number / 2).for_each(|k| along(area[k], area[number - 1 - k]));
            }
            if let Shape::Points { at, .. } | Shape::MarkedLine(at) = &series.shape {
                let spots = at.iter().filter_map(|point| self.inside(*point));
                spots.for_each(|spot| along(spot, spot));
            }
            if matches!(series.shape, Shape::Heat(_)) {
                (0..64).for_each(|k| along((0.0, f64::from(k) / 63.0), (1.0, f64::from(k) / 63.0)));
            }
        }
        ink
    }

    fn share(&self, (x, y): (f64, f64)) -> Shares {
        Some((self.x.share(x)?, self.y.share(y)?))
    }

    /// The place of a point, beyond the ends if it is infinitely far.
    fn reach(&self, (x, y): (f64, f64)) -> Shares {
        Some((self.x.reach(x)?, self.y.reach(y)?))
    }

    /// The place of a point of a line. On axes of shares it leaves the chart towards 0 and 1; where a value has no logarithm it ends.
    fn on_line(&self, (x, y): (f64, f64)) -> Shares {
        let place = |axis: &Axis, span: &Span, value| {
            if axis.scale.is_share() {
                span.reach(value)
            } else {
                span.share(value)
            }
        };
        Some((
            place(&self.chart.x, &self.x, x)?,
            place(&self.chart.y, &self.y, y)?,
        ))
    }

    pub(super) fn inside(&self, point: (f64, f64)) -> Shares {
        let at = self.share(point)?;
        let within = |share: f64| (-1e-9..=1.0 + 1e-9).contains(&share);
        (within(at.0) && within(at.1)).then_some(at)
    }

    /// The lines of a series inside the chart.
    pub(super) fn lines(&self, series: &Series) -> Vec<Vec<(f64, f64)>> {
        match &series.shape {
            Shape::Line(points) | Shape::MarkedLine(points) => {
                let line = clip::line(points.iter().map(|point| self.on_line(*point)));
                // A line of one point is a dot.
                match points.as_slice() {
                    [only] => self
                        .inside(*only)
                        .map(|at| vec![at, at])
                        .into_iter()
                        .collect(),
                    _ => line,
                }
            }
            Shape::Steps(points) => {
                let mut corners: Vec<Shares> = Vec::with_capacity(2 * points.len());
                for point in points {
                    let at = self.on_line(*point);
                    if let (Some(Some((_, before))), Some((x, _))) = (corners.last(), at) {
                        corners.push(Some((x, *before)));
                    }
                    corners.push(at);
                }
                clip::line(corners.into_iter())
            }
            Shape::Level(y) => {
                let share = self.y.share(*y);
                clip::line([0.0, 1.0].map(|x| share.map(|y| (x, y))).into_iter())
            }
            Shape::Upright(x) => {
                let share = self.x.share(*x);
                clip::line([0.0, 1.0].map(|y| share.map(|x| (x, y))).into_iter())
            }
            Shape::Points { .. } | Shape::Band { .. } | Shape::Bars { .. } | Shape::Heat(_) => {
                Vec::new()
            }
        }
    }

    /// The areas of a series inside the chart.
    pub(super) fn areas(&self, series: &Series) -> Vec<Vec<(f64, f64)>> {
        match &series.shape {
            Shape::Band { lower, upper } => {
                let pairs: Vec<(Shares, Shares)> = (lower.iter().zip(upper))
                    .map(|(low, high)| (self.reach(*low), self.reach(*high)))
                    .collect();
                let whole = |pair: &(Shares, Shares)| pair.0.is_some() && pair.1.is_some();
                pairs
                    .chunk_by(|a, b| whole(a) && whole(b))
                    .filter(|run| run.len() > 1)
                    .map(|run| {
                        let there = run.iter().filter_map(|pair| pair.0);
                        let back = run.iter().rev().filter_map(|pair| pair.1);
                        clip::area(there.chain(back).collect())
                    })
                    .collect()
            }
            Shape::Bars { edges, heights } => (edges.windows(2).zip(heights))
                .filter_map(|(edge, height)| {
                    let (left, top) = self.share((edge[0], *height))?;
                    let right = self.x.share(edge[1])?;
                    let foot = self.y.reach(0.0)?;
                    let bar = [(left, foot), (left, top), (right, top), (right, foot)];
                    Some(clip::area(bar.to_vec()))
                })
                .collect(),
            _ => Vec::new(),
        }
    }

    /// The lines of a point's error bars with their ends.
    pub(super) fn error_bars(
        &self,
        (x, y): (f64, f64),
        (dx, dy): (f64, f64),
        (width, height): (u32, u32),
    ) -> Vec<Vec<(f64, f64)>> {
        let cap = (
            f64::from(units(CAP)) / f64::from(width),
            f64::from(units(CAP)) / f64::from(height),
        );
        let mut lines: Vec<Vec<Shares>> = Vec::new();
        let mut bar = |ends: [Shares; 2], (cx, cy): (f64, f64)| {
            lines.push(ends.to_vec());
            for (a, b) in ends.into_iter().flatten() {
                lines.push(vec![Some((a - cx, b - cy)), Some((a + cx, b + cy))]);
            }
        };
        if dx > 0.0
            && let Some(y) = self.y.share(y)
        {
            bar(
                [x - dx, x + dx].map(|x| Some((self.x.reach(x)?, y))),
                (0.0, cap.1),
            );
        }
        if dy > 0.0
            && let Some(x) = self.x.share(x)
        {
            bar(
                [y - dy, y + dy].map(|y| Some((x, self.y.reach(y)?))),
                (cap.0, 0.0),
            );
        }
        lines
            .into_iter()
            .flat_map(|line| clip::line(line.into_iter()))
            .collect()
    }
}
