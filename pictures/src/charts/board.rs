//! The plotters backend that draws on this crate's canvas: exact places, our font, the same SVG as the pictures.

use std::convert::Infallible;

use plotters::style::RGBAColor;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontTransform,
};

use crate::canvas::{Anchor, Canvas, HALF_CAPITAL, Lettering, Spot, Stroke};
use crate::colour::Colour;
use crate::font;

/// Whole coordinates of plotters in a point of the page: fine enough that a curve is smooth at any size of print.
const UNITS: f64 = 50.0;
/// Height of a letter above its line and depth below it, in em.
const ABOVE: f64 = 0.76;
const BELOW: f64 = 0.24;

/// Points as plotters counts them.
pub(super) fn units(points: f64) -> i32 {
    (points * UNITS).round() as i32
}

/// A width as plotters counts it; never zero.
pub(super) fn width_units(points: f64) -> u32 {
    (points * UNITS).round().max(1.0) as u32
}

/// A place of plotters on the page.
pub(super) fn spot((x, y): BackendCoord) -> Spot {
    (f64::from(x) / UNITS, f64::from(y) / UNITS)
}

/// A colour of ours for plotters.
pub(super) fn ink(Colour(r, g, b): Colour, opacity: f64) -> RGBAColor {
    RGBAColor(r, g, b, opacity)
}

fn colour(colour: BackendColor) -> Colour {
    Colour(colour.rgb.0, colour.rgb.1, colour.rgb.2)
}

pub(super) type BoardError = DrawingErrorKind<Infallible>;

/// A canvas under plotters.
pub(super) struct Board<'a> {
    pub(super) canvas: &'a mut dyn Canvas,
    /// Points.
    size: Spot,
}

impl<'a> Board<'a> {
    pub(super) fn new(canvas: &'a mut dyn Canvas, size: Spot) -> Self {
        Self { canvas, size }
    }

    fn stroke<S: BackendStyle>(style: &S) -> Stroke {
        let width = f64::from(style.stroke_width()) / UNITS;
        Stroke::solid(colour(style.color()), width)
    }
}

impl DrawingBackend for Board<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (width_units(self.size.0), width_units(self.size.1))
    }

    fn ensure_prepared(&mut self) -> Result<(), BoardError> {
        Ok(())
    }

    fn present(&mut self) -> Result<(), BoardError> {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, ink: BackendColor) -> Result<(), BoardError> {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(spot);
        self.canvas.area(&corners, colour(ink), ink.alpha);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Result<(), BoardError> {
        (self.canvas).polyline(&[spot(from), spot(to)], Self::stroke(style));
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Result<(), BoardError> {
        let points: Vec<Spot> = path.into_iter().map(spot).collect();
        self.canvas.polyline(&points, Self::stroke(style));
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (x0, y0): BackendCoord,
        (x1, y1): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Result<(), BoardError> {
        let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)];
        if fill {
            self.fill_polygon(corners[..4].iter().copied(), style)
        } else {
            self.draw_path(corners, style)
        }
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        _fill: bool,
    ) -> Result<(), BoardError> {
        let radius = f64::from(radius) / UNITS;
        self.canvas
            .disc(spot(centre), radius, colour(style.color()));
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Result<(), BoardError> {
        let corners: Vec<Spot> = corners.into_iter().map(spot).collect();
        let ink = style.color();
        self.canvas.area(&corners, colour(ink), ink.alpha);
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        at: BackendCoord,
    ) -> Result<(), BoardError> {
        let size = style.size() / UNITS;
        let anchor = style.anchor();
        let down = size
            * match anchor.v_pos {
                VPos::Top => ABOVE,
                VPos::Center => HALF_CAPITAL,
                VPos::Bottom => -BELOW,
            };
        let upright = matches!(style.transform(), FontTransform::Rotate270);
        let (x, y) = spot(at);
        let lettering = Lettering {
            size,
            colour: colour(style.color()),
            anchor: match anchor.h_pos {
                HPos::Left => Anchor::Start,
                HPos::Center => Anchor::Middle,
                HPos::Right => Anchor::End,
            },
            upright,
        };
        let at = if upright {
            (x + down, y)
        } else {
            (x, y + down)
        };
        self.canvas.text(text, at, lettering);
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), BoardError> {
        let size = style.size() / UNITS;
        Ok((width_units(font::width(text, size)), width_units(size)))
    }
}
