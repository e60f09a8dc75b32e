//! What series are made of, as elements of plotters; their points are shares of the chart's width and height.

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

macro_rules! points_of {
    ($element:ty, $field:ident) => {
        impl<'a> PointCollection<'a, (f64, f64)> for &'a $element {
            type Point = &'a (f64, f64);
            type IntoIter = std::slice::Iter<'a, (f64, f64)>;

            fn point_iter(self) -> Self::IntoIter {
                self.$field.iter()
            }
        }
    };
}

points_of!(Curve, points);
points_of!(Area, points);
points_of!(Cells, corners);

impl<'a> PointCollection<'a, (f64, f64)> for &'a Mark {
    type Point = &'a (f64, f64);
    type IntoIter = std::iter::Once<&'a (f64, f64)>;

    fn point_iter(self) -> Self::IntoIter {
        std::iter::once(&self.at)
    }
}

impl Drawable<Board<'_>> for Curve {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        places: I,
        board: &mut Board<'_>,
        _: (u32, u32),
    ) -> Result<(), BoardError> {
        let spots: Vec<Spot> = places.map(spot).collect();
        board.canvas.polyline(&thinned(&spots, COLUMN), self.stroke);
        Ok(())
    }
}

impl Drawable<Board<'_>> for Area {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        places: I,
        board: &mut Board<'_>,
        _: (u32, u32),
    ) -> Result<(), BoardError> {
        let corners: Vec<Spot> = places.map(spot).collect();
        if corners.len() > 2 {
            board.canvas.area(&corners, self.colour, self.opacity);
        }
        Ok(())
    }
}

impl Drawable<Board<'_>> for Mark {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        places: I,
        board: &mut Board<'_>,
        _: (u32, u32),
    ) -> Result<(), BoardError> {
        for at in places {
            mark(board.canvas, spot(at), self.marker, self.colour);
        }
        Ok(())
    }
}

impl Drawable<Board<'_>> for Cells {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        places: I,
        board: &mut Board<'_>,
        _: (u32, u32),
    ) -> Result<(), BoardError> {
        let corners: Vec<Spot> = places.map(spot).collect();
        let cells: Vec<(Spot, Spot, Colour)> = (corners.chunks_exact(2).zip(&self.colours))
            .map(|(pair, colour)| {
                let ((ax, ay), (bx, by)) = (pair[0], pair[1]);
                ((ax.min(bx), ay.min(by)), (ax.max(bx), ay.max(by)), *colour)
            })
            .collect();
        board.canvas.cells(&cells);
        Ok(())
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
