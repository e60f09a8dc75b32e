//! Three views of a rigid body: its pebbles and the surface they stand for.

use std::borrow::Cow;

use glam::DVec3;

use crate::PictureError;
use crate::camera::Overview;
use crate::colour_map::category_colour;
use crate::frame::{Frame, Sphere, Surface};
use crate::image::Image;
use crate::options::{Options, View};
use crate::page::{Cell, Legend, Sheet};
use crate::render::Look;
use crate::scale::{count, quantity};
use crate::theme::Theme;

/// A body of pebbles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClumpScene<'a> {
    /// Heading: the clump's name.
    pub title: &'a str,
    /// Centres (m) and radii (m) of the pebbles, in any frame.
    pub pebbles: &'a [(DVec3, f64)],
    /// Triangles of the surface (m) in the same frame; empty: none.
    pub surface: &'a [[DVec3; 3]],
}

/// Opacity of the surface over its pebbles: both must be seen.
const OPACITY: f64 = 0.22;
/// Beyond this number pebbles have one colour: many colours show nothing.
const MOST_COLOURS: usize = 24;

/// Draws front, side and top view of a clump at one scale: pebbles as shaded spheres, the surface as a translucent skin with
/// its folds as lines. Of `options`, size, background, headings, axes and scale bar count.
///
/// # Errors
/// For options that cannot be drawn.
pub fn draw_clump(clump: &ClumpScene, options: &Options) -> Result<Image, PictureError> {
    options.check()?;
    let frame = frame(clump);
    Ok(sheet(clump, &frame, options).image(options))
}

/// SVG document of the picture.
///
/// # Errors
/// For options that cannot be drawn.
pub fn draw_clump_svg(clump: &ClumpScene, options: &Options) -> Result<String, PictureError> {
    options.check()?;
    let frame = frame(clump);
    Ok(sheet(clump, &frame, options).image_and_svg(options)?.1)
}

fn frame(clump: &ClumpScene) -> Frame {
    let spheres = clump.pebbles.iter().map(|(centre, radius)| Sphere {
        centre: *centre,
        radius: *radius,
        value: f64::NAN,
        fixed: false,
    });
    let mut surfaces = Vec::new();
    if !clump.surface.is_empty() {
        surfaces.push(Surface {
            opacity: if clump.pebbles.is_empty() {
                1.0
            } else {
                OPACITY
            },
            ..Surface::wall(clump.surface.to_vec())
        });
    }
    Frame {
        title: clump.title.into(),
        spheres: spheres.collect(),
        surfaces,
        ..Frame::default()
    }
}

fn sheet<'a>(clump: &ClumpScene, frame: &'a Frame, options: &Options) -> Sheet<'a> {
    let theme = Theme::new(options.background);
    let number = clump.pebbles.len();
    let colour = |k: usize| {
        if number > MOST_COLOURS {
            theme.plain
        } else {
            category_colour(k)
        }
    };
    let views = [
        ("front", View::FRONT),
        ("side", View::RIGHT),
        ("top", View::TOP),
    ];
    let cells = views.into_iter().map(|(name, view)| {
        let options = Options {
            view,
            ..options.clone()
        };
        Cell {
            frame,
            look: Look {
                theme,
                spheres: Cow::Borrowed(&frame.spheres),
                sphere_colours: (0..number).map(colour).collect(),
                grain_colours: Vec::new(),
                sphere_opacity: 1.0,
                contacts: Vec::new(),
                domain: false,
                unit: crate::page::unit(&options),
                frame,
            },
            overview: Overview::of(frame, &options),
            options,
            caption: Some(name.into()),
        }
    });
    Sheet {
        title: if options.headings {
            clump.title.into()
        } else {
            String::new()
        },
        numbers: if options.headings {
            numbers(clump)
        } else {
            String::new()
        },
        theme,
        legend: Legend::default(),
        cells: cells.collect(),
        axes: options.axes,
        scale_bar: options.scale_bar,
    }
}

/// `12 pebbles · largest radius 3 mm · 640 triangles`.
fn numbers(clump: &ClumpScene) -> String {
    let plural = |number: usize, what: &str| {
        let s = if number == 1 { "" } else { "s" };
        format!("{} {what}{s}", count(number))
    };
    let mut parts = vec![plural(clump.pebbles.len(), "pebble")];
    let largest = clump.pebbles.iter().map(|p| p.1).fold(0.0, f64::max);
    if largest > 0.0 {
        parts.push(format!("largest radius {}", quantity(largest, "m", 3)));
    }
    if !clump.surface.is_empty() {
        parts.push(plural(clump.surface.len(), "triangle"));
    }
    parts.join("\u{a0}\u{a0}·\u{a0}\u{a0}")
}
