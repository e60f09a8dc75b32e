//! Heat maps and their colour bars.

use super::axis::Axis;
use super::chart::HeatMap;
use super::elements::Cells;
use super::ruler::{Need, Ruler, Span};
use crate::canvas::{Anchor, Canvas, HALF_CAPITAL, Lettering, Spot, Stroke, frame};
use crate::colour::Colour;
use crate::colour_map::ColourMap;
use crate::value_range::{ValueRange, share};

/// Space before the bar, its width, the length of its ticks, space around its title.
const GAP: f64 = 12.0;
const WIDTH: f64 = 13.0;
const TICK: f64 = 4.0;
const AROUND: f64 = 7.0;
/// Steps of colour in a bar.
const STEPS: usize = 128;

/// Colour scale of a heat map.
pub(super) struct Bar {
    map: ColourMap,
    range: (f64, f64),
    span: Span,
    /// Whether values lie beyond its lower and its upper end.
    beyond: (bool, bool),
}

impl Bar {
    /// None, if there is no value.
    pub(super) fn new(heat: &HeatMap) -> Option<Self> {
        let mut values = ValueRange::default();
        values.add(heat.values.iter().copied());
        let (lowest, highest) = values.full()?;
        let range = match heat.range {
            Some((low, high)) => crate::value_range::opened(low, high),
            None if heat.centred => values.centred()?,
            None => values.bar(heat.map)?,
        };
        let axis = Axis::linear(&heat.name, &heat.unit).within(range.0, range.1);
        let nothing = Need {
            values: None,
            tight: true,
        };
        Some(Self {
            map: heat.map,
            range,
            span: Span::new(&axis, nothing),
            beyond: (lowest < range.0, highest > range.1),
        })
    }

    /// The cells of a map; empty ones are left out.
    pub(super) fn cells(&self, heat: &HeatMap, x: &Span, y: &Span) -> Cells {
        let place = |span: &Span, edge: f64| span.share(edge).map(|at| at.clamp(0.0, 1.0));
        let across: Vec<Option<f64>> = heat.x_edges.iter().map(|edge| place(x, *edge)).collect();
        let up: Vec<Option<f64>> = heat.y_edges.iter().map(|edge| place(y, *edge)).collect();
        let mut cells = Cells {
            corners: Vec::new(),
            colours: Vec::new(),
        };
        let colour = |value: f64| {
            value
                .is_finite()
                .then(|| self.map.colour(share(value, self.range)))
        };
        for (row, line) in heat.values.chunks_exact(across.len() - 1).enumerate() {
            let (Some(low), Some(high)) = (up[row], up[row + 1]) else {
                continue;
            };
            // Neighbours of one colour are one rectangle: small files.
            let mut column = 0;
            for run in line.chunk_by(|a, b| colour(*a) == colour(*b)) {
                let ends = (across[column], across[column + run.len()]);
                column += run.len();
                if let ((Some(left), Some(right)), Some(colour)) = (ends, colour(run[0]))
                    && left < right
                    && low < high
                {
                    cells.corners.extend([(left, low), (right, high)]);
                    cells.colours.push(colour);
                }
            }
        }
        cells
    }

    fn ruler(&self, length: f64, lettering: f64) -> Ruler {
        self.span.ruler(length, false, lettering)
    }

    /// The space it needs beside a chart of this height (points).
    pub(super) fn room(&self, height: f64, lettering: f64) -> f64 {
        let numbers = self.ruler(height, lettering).widest(lettering);
        GAP + WIDTH + 2.0 * TICK + numbers + AROUND + 1.1 * lettering
    }

    /// Draws it to the right of a chart whose right edge is given.
    pub(super) fn draw(&self, canvas: &mut dyn Canvas, right: f64, (top, bottom): Spot, size: f64) {
        let (x0, x1) = (right + GAP, right + GAP + WIDTH);
        let height = bottom - top;
        let step = height / STEPS as f64;
        let cells: Vec<(Spot, Spot, Colour)> = (0..STEPS)
            .map(|k| {
                let y = top + step * k as f64;
                let share = 1.0 - (k as f64 + 0.5) / STEPS as f64;
                ((x0, y), (x1, y + step), self.map.colour(share))
            })
            .collect();
        canvas.cells(&cells);
        let thin = Stroke::solid(Colour::SOFT_INK, 0.8);
        frame(canvas, (x0, top), (x1, bottom), thin);
        let ruler = self.ruler(height, size);
        for tick in ruler.labelled() {
            let y = bottom - tick.place * height;
            canvas.polyline(&[(x1, y), (x1 + TICK, y)], thin);
            let at = (x1 + 2.0 * TICK, y + HALF_CAPITAL * size);
            canvas.text(
                &tick.label,
                at,
                Lettering::new(size, Colour::INK, Anchor::Start),
            );
        }
        // A small arrow where values lie beyond the end.
        for (beyond, y, tip) in [
            (self.beyond.1, top - 3.0, top - 9.0),
            (self.beyond.0, bottom + 3.0, bottom + 9.0),
        ] {
            if beyond {
                let corners = [(x0 + 2.0, y), (x1 - 2.0, y), (0.5 * (x0 + x1), tip)];
                canvas.area(&corners, Colour::SOFT_INK, 1.0);
            }
        }
        let x = x1 + 2.0 * TICK + ruler.widest(size) + AROUND + 0.8 * size;
        let style = Lettering {
            upright: true,
            ..Lettering::new(size, Colour::INK, Anchor::Middle)
        };
        canvas.text(&self.span.title(), (x, 0.5 * (top + bottom)), style);
    }
}
