//! Legend of a chart: the names of its series.

use super::chart::{Chart, Legend, Shape};
use super::elements::mark;
use super::look::Look;
use super::panel::{BAND, BARS};
use crate::canvas::{Anchor, Canvas, HALF_CAPITAL, Lettering, Spot, Stroke, frame};
use crate::colour::Colour;
use crate::font;

/// Length of a sample and space behind it.
const SAMPLE: f64 = 26.0;
const GAP: f64 = 8.0;
/// Space around the entries.
const AROUND: f64 = 7.0;
/// Distance of the legend from the corner of the chart, or from its right edge.
pub(super) const APART: f64 = 8.0;
/// Height of an entry and of its second line, in heights of the letters.
const LINE: f64 = 1.45;
const SECOND: f64 = 1.15;
/// Height of the second line's letters over that of the first's.
const SMALLER: f64 = 0.88;

/// The size of the legend of a chart (points); none: it has no entries.
pub(super) fn size(chart: &Chart, lettering: f64) -> Option<Spot> {
    let named = || chart.series.iter().filter(|series| !series.name.is_empty());
    if chart.legend == Legend::None || named().next().is_none() {
        return None;
    }
    let widths = named().map(|series| {
        font::width(&series.name, lettering).max(font::width(&series.about, SMALLER * lettering))
    });
    let heights = named().map(|series| {
        let second = if series.about.is_empty() { 0.0 } else { SECOND };
        (LINE + second) * lettering
    });
    Some((
        SAMPLE + GAP + widths.fold(0.0, f64::max) + 2.0 * AROUND,
        heights.sum::<f64>() + 2.0 * AROUND - (LINE - 1.2) * lettering,
    ))
}

/// Draws the legend; its upper left corner is given. On the chart it has paper of its own.
pub(super) fn draw(
    canvas: &mut dyn Canvas,
    chart: &Chart,
    looks: &[Look],
    (left, top): Spot,
    lettering: f64,
    on_chart: bool,
) {
    let Some((width, height)) = size(chart, lettering) else {
        return;
    };
    if on_chart {
        let (right, bottom) = (left + width, top + height);
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        canvas.area(&corners, Colour::WHITE, 0.85);
        frame(
            canvas,
            (left, top),
            (right, bottom),
            Stroke::solid(Colour::GRID, 0.8),
        );
    }
    let x = left + AROUND;
    let mut y = top + AROUND + 0.6 * lettering;
    for (series, look) in chart.series.iter().zip(looks) {
        if series.name.is_empty() {
            continue;
        }
        sample(canvas, &series.shape, look, (x, y), lettering);
        let text = x + SAMPLE + GAP;
        let style = Lettering::new(lettering, Colour::INK, Anchor::Start);
        canvas.text(&series.name, (text, y + HALF_CAPITAL * lettering), style);
        if !series.about.is_empty() {
            y += SECOND * lettering;
            let size = SMALLER * lettering;
            let style = Lettering::new(size, Colour::SOFT_INK, Anchor::Start);
            canvas.text(&series.about, (text, y + HALF_CAPITAL * size), style);
        }
        y += LINE * lettering;
    }
}

/// The entries of a chart side by side, from line to line of this width: their places in a box, and its height.
fn row(chart: &Chart, width: f64, lettering: f64) -> (Vec<(usize, Spot)>, f64) {
    let line = 1.6 * lettering;
    let (mut x, mut y) = (0.0, 0.0);
    let mut places = Vec::new();
    for (number, series) in chart.series.iter().enumerate() {
        if series.name.is_empty() {
            continue;
        }
        let entry = SAMPLE + GAP + font::width(&series.name, lettering);
        if x > 0.0 && x + entry > width {
            (x, y) = (0.0, y + line);
        }
        places.push((number, (x, y)));
        x += entry + 2.5 * GAP;
    }
    let height = if places.is_empty() { 0.0 } else { y + line };
    (places, height)
}

/// Height of the legend as rows.
pub(super) fn row_height(chart: &Chart, width: f64, lettering: f64) -> f64 {
    row(chart, width, lettering).1
}

/// Draws the legend as rows from an upper left corner on.
pub(super) fn draw_row(
    canvas: &mut dyn Canvas,
    chart: &Chart,
    looks: &[Look],
    (left, top): Spot,
    width: f64,
    lettering: f64,
) {
    for (number, (x, y)) in row(chart, width, lettering).0 {
        let at = (left + x, top + y + 0.8 * lettering);
        sample(
            canvas,
            &chart.series[number].shape,
            &looks[number],
            at,
            lettering,
        );
        let text = (at.0 + SAMPLE + GAP, at.1 + HALF_CAPITAL * lettering);
        let style = Lettering::new(lettering, Colour::INK, Anchor::Start);
        canvas.text(&chart.series[number].name, text, style);
    }
}

/// Sample of the series in the legend, from `x` on and around the height `y`.
fn sample(canvas: &mut dyn Canvas, shape: &Shape, look: &Look, (x, y): Spot, lettering: f64) {
    let half = 0.42 * lettering;
    let corners = [
        (x, y - half),
        (x + SAMPLE, y - half),
        (x + SAMPLE, y + half),
        (x, y + half),
    ];
    let middle = (x + 0.5 * SAMPLE, y);
    match shape {
        Shape::Line(_) | Shape::Steps(_) | Shape::Level(_) | Shape::Upright(_) => {
            canvas.polyline(&[(x, y), (x + SAMPLE, y)], look.stroke);
        }
        Shape::MarkedLine(_) => {
            canvas.polyline(&[(x, y), (x + SAMPLE, y)], look.stroke);
            mark(canvas, middle, look.marker, look.stroke.colour);
        }
        Shape::Points { .. } => mark(canvas, middle, look.marker, look.stroke.colour),
        Shape::Band { .. } => canvas.area(&corners, look.stroke.colour, BAND),
        Shape::Bars { .. } => {
            canvas.area(&corners, look.stroke.colour, BARS);
            let stroke = Stroke::solid(look.stroke.colour, 0.8);
            frame(canvas, corners[0], corners[2], stroke);
        }
        Shape::Heat(_) => {}
    }
}
