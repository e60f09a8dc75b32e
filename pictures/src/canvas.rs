//! Canvas that a picture is drawn on. A layout is written once against [`Canvas`] and comes out as pixels and as SVG.
//!
//! Coordinates are in points, x to the right, y down.

use super::colour::Colour;

/// A place on the page.
pub(crate) type Spot = (f64, f64);

/// How a line looks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke {
    pub(crate) colour: Colour,
    /// Width in points.
    pub(crate) width: f64,
    /// Lengths in points of dash, gap, dash, gap, ...; empty: a solid line.
    pub(crate) dashes: &'static [f64],
}

impl Stroke {
    pub(crate) const fn solid(colour: Colour, width: f64) -> Self {
        Self {
            colour,
            width,
            dashes: &[],
        }
    }
}

/// Part of a text that stands at its spot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text looks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lettering {
    /// Height of the em in points.
    pub(crate) size: f64,
    pub(crate) colour: Colour,
    pub(crate) anchor: Anchor,
    /// Read from below to above.
    pub(crate) upright: bool,
}

impl Lettering {
    pub(crate) const fn new(size: f64, colour: Colour, anchor: Anchor) -> Self {
        Self {
            size,
            colour,
            anchor,
            upright: false,
        }
    }
}

/// Half the height of a capital letter, in em: added to y, it centres a text on y.
pub(crate) const HALF_CAPITAL: f64 = 0.365;

/// Something to draw on.
pub(crate) trait Canvas {
    /// A line through `points`; fewer than two draw nothing.
    fn polyline(&mut self, points: &[Spot], stroke: Stroke);
    /// A filled rectangle between two corners.
    fn rectangle(&mut self, upper_left: Spot, lower_right: Spot, fill: Colour);
    /// A filled disc.
    fn disc(&mut self, centre: Spot, radius: f64, fill: Colour);
    /// A filled polygon that lets light through unless `opacity` is 1.
    fn area(&mut self, corners: &[Spot], fill: Colour, opacity: f64);
    /// Rectangles from corner to corner that meet without a seam.
    fn cells(&mut self, cells: &[(Spot, Spot, Colour)]);
    /// One line of text whose base line starts, is centred or ends at `at`.
    fn text(&mut self, text: &str, at: Spot, lettering: Lettering);
}

/// The rectangle between two corners as a closed line.
pub(crate) fn frame(canvas: &mut dyn Canvas, (x0, y0): Spot, (x1, y1): Spot, stroke: Stroke) {
    canvas.polyline(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], stroke);
}

/// A line with a head at its end, for directions.
pub(crate) fn arrow(canvas: &mut dyn Canvas, from: Spot, to: Spot, stroke: Stroke) {
    canvas.polyline(&[from, to], stroke);
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx.hypot(dy);
    let head = (3.4 * stroke.width).min(0.45 * length);
    if length > 0.0 {
        let (ux, uy) = (dx / length, dy / length);
        let wing = |side: f64| {
            (
                to.0 - head * ux - side * 0.55 * head * uy,
                to.1 - head * uy + side * 0.55 * head * ux,
            )
        };
        canvas.polyline(&[wing(1.0), to, wing(-1.0)], stroke);
    }
}
