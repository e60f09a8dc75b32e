//! Parts of series, as elements of plotters; their points are shares of the chart's width and height.

use plotters::element::{Drawable, PointCollection};
use plotters_backend::BackendCoord;

use super::board::{Board, BoardError, spot};
use super::clip::thinned;
use super::palette::Marker;
use crate::canvas::{Canvas, Spot, Stroke};
use crate::colour::Colour;

/// Points of a line that share a column of this width (points of the page) are thinned to four.
const COLUMN: f64 = 0.5;

/// A line.
pub(super) struct Curve {
    pub(super) points: Vec<(f64, f64)>,
    pub(super) stroke: Stroke,
}

/// A filled area.
pub(super) struct Area {
    pub(super) points: Vec<(f64, f64)>,
    pub(super) colour: Colour,
    pub(super) opacity: f64,
}

/// A point.
pub(super) struct Mark {
    pub(super) at: (f64, f64),
    pub(super) marker: Marker,
    pub(super) colour: Colour,
}

/// Rectangles from corner to corner.
pub(super) struct Cells {
    /// Two for each colour.
    pub(super) corners: Vec<(f64, f64)>,
    pub(super) colours: Vec<Colour>,
}

/// Drawing of an element onto the canvas, given the places of its points.
trait Paint {
    fn paint(&self, spots: &[Spot], canvas: &mut dyn Canvas);
}

/// Makes an element known to plotters, with the places of its points.
macro_rules! element {
    ($element:ty, |$this:ident| $points:expr) => {
        impl<'a> PointCollection<'a, (f64, f64)> for &'a $element {
            type Point = &'a (f64, f64);
            type IntoIter = std::slice::Iter<'a, (f64, f64)>;

            fn point_iter(self) -> Self::IntoIter {
                let $this = self;
                $points.iter()
            }
        }

        impl Drawable<Board<'_>> for $element {
            fn draw<I: Iterator<Item = BackendCoord>>(
                &self,
                places: I,
                board: &mut Board<'_>,
                _: (u32, u32),
            ) -> Result<(), BoardError> {
                let spots: Vec<Spot> = places.map(spot).collect();
                self.paint(&spots, board.canvas);
                Ok(())
            }
        }
    };
}

element!(Curve, |curve| curve.points);
element!(Area, |area| area.points);
element!(Cells, |cells| cells.corners);
element!(Mark, |mark| std::slice::from_ref(&mark.at));

impl Paint for Curve {
    fn paint(&self, spots: &[Spot], canvas: &mut dyn Canvas) {
        canvas.polyline(&thinned(spots, COLUMN), self.stroke);
    }
}

impl Paint for Area {
    fn paint(&self, corners: &[Spot], canvas: &mut dyn Canvas) {
        if corners.len() > 2 {
            canvas.area(corners, self.colour, self.opacity);
        }
    }
}

impl Paint for Cells {
    fn paint(&self, corners: &[Spot], canvas: &mut dyn Canvas) {
        let cells: Vec<(Spot, Spot, Colour)> = (corners.chunks_exact(2).zip(&self.colours))
            .map(|(pair, colour)| {
                let ((ax, ay), (bx, by)) = (pair[0], pair[1]);
                ((ax.min(bx), ay.min(by)), (ax.max(bx), ay.max(by)), *colour)
            })
            .collect();
        canvas.cells(&cells);
    }
}

impl Paint for Mark {
    fn paint(&self, spots: &[Spot], canvas: &mut dyn Canvas) {
        for at in spots {
            mark(canvas, *at, self.marker, self.colour);
        }
    }
}

/// Draws a marker; all look equally large.
pub(super) fn mark(canvas: &mut dyn Canvas, (x, y): Spot, marker: Marker, colour: Colour) {
    let polygon = |corners: &[(f64, f64)]| -> Vec<Spot> {
        corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect()
    };
    match marker {
        Marker::Disc => canvas.disc((x, y), 2.9, colour),
        Marker::Ring => {
            canvas.disc((x, y), 3.2, colour);
            canvas.disc((x, y), 1.9, Colour::WHITE);
        }
        Marker::Square => {
            let corners = polygon(&[(-2.6, -2.6), (2.6, -2.6), (2.6, 2.6), (-2.6, 2.6)]);
            canvas.area(&corners, colour, 1.0);
        }
        Marker::Triangle => {
            let corners = polygon(&[(0.0, -3.8), (3.3, 2.1), (-3.3, 2.1)]);
            canvas.area(&corners, colour, 1.0);
        }
        Marker::Diamond => {
            let corners = polygon(&[(0.0, -3.9), (3.4, 0.0), (0.0, 3.9), (-3.4, 0.0)]);
            canvas.area(&corners, colour, 1.0);
        }
        Marker::Cross => {
            let stroke = Stroke::solid(colour, 1.4);
            canvas.polyline(&[(x - 2.6, y - 2.6), (x + 2.6, y + 2.6)], stroke);
            canvas.polyline(&[(x - 2.6, y + 2.6), (x + 2.6, y - 2.6)], stroke);
        }
    }
}
