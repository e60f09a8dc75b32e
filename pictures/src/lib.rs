//! Pictures of particles without any other program: shaded spheres with exact outlines, mesh walls that let light through,
//! contacts, films, and charts. PNG, APNG, GIF and SVG.
//!
//! A [`Frame`] holds plain values in SI units and depends on no solver. [`Options`] set its look; an [`Overview`] of all frames
//! of a film fixes one camera and one range of colours; a [`Painter`] draws. Every machine draws the same bytes with any number
//! of threads: no display, graphics card or installed font is used.
//!
//! The modules: `frame` and `options` are the input; `camera` decides what is seen and where it falls; `render` makes pixels of a
//! scene; `page` lays out headings, windows, legend and scale; `film` makes animations; `clump` draws three views of a body;
//! `scenery` makes walls and bodies of a run parts of a frame; `charts` draws charts, `energies` that of a run's energies.
//! `image` and `svg` are what is drawn on, a `canvas` each; `colour`, `colour_map`, `theme`, `value_range`, `font` and `scale`
//! serve them.

mod camera;
mod canvas;
pub mod charts;
mod clump;
mod colour;
mod colour_map;
mod energies;
mod error;
mod film;
mod font;
mod frame;
mod image;
mod options;
mod page;
mod render;
mod scale;
mod scenery;
mod svg;
#[cfg(test)]
mod tests;
mod theme;
mod value_range;

pub use camera::Overview;
pub use clump::{ClumpScene, draw_clump, draw_clump_svg};
pub use colour::Colour;
pub use colour_map::{ColourMap, category_colour};
pub use energies::{EnergyFlows, EnergyRow, SheetEnergies, energy_page};
pub use error::PictureError;
pub use film::{Apng, Gif, delays};
pub use frame::{Contact, Frame, Grain, Line, SHEET_OPACITY, Sphere, Surface, upwards};
pub use image::Image;
pub use options::{
    BEHIND_LINES, Background, ColourBy, ContactStyle, Framing, Options, Projection, View,
};
pub use page::Painter;
pub use scenery::{moves, wall_surfaces, worn_triangles};

/// The examples of the documentation, compiled and run as tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/how-to/make-pictures.md")]
struct HowTo;
