//! A picture laid out: headings, one or more windows on scenes, legend, scale and axes.
//!
//! `sheet` holds the content, `layout` the places, `legend` and `notes` write what one needs to read it; they
//! draw on a canvas and so come out as pixels and as SVG, in which the scene itself is a picture in pixels.

mod layout;
mod legend;
mod notes;
mod painter;
mod sheet;

pub(crate) use layout::unit;
pub(crate) use legend::Legend;
pub use painter::Painter;
pub(crate) use sheet::{Cell, Sheet};

/// The smallest text (pixels) that can be read.
const SMALLEST_TEXT: f64 = 9.0;

/// A length of the 1200 x 900 page for text in a picture whose unit is `unit`.
fn text_size(size: f64, unit: f64) -> f64 {
    (size * unit).max(SMALLEST_TEXT)
}
