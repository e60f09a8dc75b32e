//! From a frame to pixels.
//!
//! The window is drawn at [`SAMPLES`] times its size along each axis and averaged. First every opaque thing is cast into
//! one buffer of depth and owner (`opaque`); then each sample gets its colour (`light`), and what lets light through is
//! laid over it, the farthest first, sample by sample (`layers`). Tiles are drawn side by side; each sample sees the same
//! things in the same order whatever the number of threads, so the bytes are the same.

mod bins;
mod compose;
mod facets;
mod layers;
mod light;
mod opaque;
mod relief;
mod spheres;
mod strokes;

pub(crate) use compose::paint;
#[cfg(test)]
pub(crate) use light::shaded;

use std::borrow::Cow;

use crate::camera::Lens;
use crate::colour::Colour;
use crate::frame::{Grain, Sphere};
use crate::theme::Theme;

/// Samples per pixel along each axis.
pub(crate) const SAMPLES: usize = 2;
/// Samples along the side of a tile.
pub(crate) const TILE: usize = 64;

/// Values of a frame as they are drawn.
#[derive(Debug)]
pub(crate) struct Look<'a> {
    pub(crate) theme: Theme,
    /// Spheres of the frame, then its droplets.
    pub(crate) spheres: Cow<'a, [Sphere]>,
    /// One colour for each of them.
    pub(crate) sphere_colours: Vec<Colour>,
    /// One colour for each grain of the frame.
    pub(crate) grain_colours: Vec<Colour>,
    /// Opacity of spheres and grains that are no walls.
    pub(crate) sphere_opacity: f64,
    /// Colour and width (pixels) of each contact of the frame.
    pub(crate) contacts: Vec<(Colour, f64)>,
    /// Whether the box of the domain is drawn.
    pub(crate) domain: bool,
    /// Pixels per unit of the widths that frames give.
    pub(crate) unit: f64,
    pub(crate) frame: &'a crate::frame::Frame,
}

impl Look<'_> {
    /// Opacity of a grain: walls that are coloured by a value hide what lies behind them.
    pub(crate) fn opacity_of(&self, grain: &Grain) -> f64 {
        match grain.of_wall {
            true => 1.0,
            false => self.sphere_opacity.clamp(0.0, 1.0),
        }
    }

    /// Whether the box of the domain is drawn: it is left out where a part of it would lie outside of the window, which has this size in pixels of
    /// the lens.
    pub(crate) fn shows_domain(&self, lens: &Lens, size: (usize, usize)) -> bool {
        self.domain && lens.holds(&self.frame.domain_corners(), size)
    }
}
