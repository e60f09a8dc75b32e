//! Options and an overview, ready to draw frames.

use std::borrow::Cow;

use super::legend::{Bar, Legend};
use super::{Cell, Sheet, layout, notes};
use crate::PictureError;
use crate::camera::Overview;
use crate::colour::Colour;
use crate::colour_map::{ColourMap, category_colour};
use crate::frame::{Frame, Sphere};
use crate::image::Image;
use crate::options::{ColourBy, ContactStyle, Options};
use crate::render::Look;
use crate::theme::Theme;
use crate::value_range::{logarithmic_share, share};

/// Draws frames, all with the same camera, colours and legend.
///
/// ```
/// use glam::DVec3;
/// use mercury_pictures::{ColourBy, Frame, Options, Overview, Painter, Sphere};
///
/// let sphere = |x: f64, speed: f64| Sphere {
///     centre: DVec3::new(x, 0.0, 0.0), // m
///     radius: 0.01,                    // m
///     value: speed,                    // m/s
///     fixed: false,
/// };
/// let frame = Frame {
///     title: "Two beads".into(),
///     spheres: vec![sphere(0.0, 0.1), sphere(0.025, 0.3)],
///     ..Frame::default()
/// };
/// let options = Options {
///     width: 400,
///     height: 300,
///     colour: ColourBy::scalar("speed", "m/s"),
///     ..Options::default()
/// };
/// let painter = Painter::new(&options, Overview::of(&frame, &options))?;
/// let image = painter.image(&frame);
/// assert_eq!((image.width, image.height), (400, 300));
/// # Ok::<(), mercury_pictures::PictureError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Painter {
    options: Options,
    overview: Overview,
    theme: Theme,
    /// Ends and map of the spheres' colour bar, and whether it is logarithmic.
    bar: Option<((f64, f64), ColourMap, bool)>,
    /// Strengths of the thinnest and of the widest contact.
    strengths: (f64, f64),
}

/// Categories that are but numbers have a legend up to so many.
const MOST_NUMBERS: usize = 10;
/// Categories that a legend names; the others are counted.
const MOST_CATEGORIES: usize = 64;

impl Painter {
    /// A painter for the frames that `overview` has seen.
    ///
    /// # Errors
    /// For options that cannot be drawn.
    pub fn new(options: &Options, overview: Overview) -> Result<Self, PictureError> {
        options.check()?;
        let bar = match &options.colour {
            ColourBy::Scalar {
                range,
                map,
                logarithmic,
                ..
            } => range
                .map(|(low, high)| crate::value_range::opened(low, high))
                .or_else(|| match logarithmic {
                    true => overview.values.logarithmic_bar(),
                    false => overview.values.bar(*map),
                })
                .map(|range| (range, *map, *logarithmic)),
            _ => None,
        };
        if let (None, Some(_), ColourBy::Scalar { .. }) =
            (bar, overview.values.full(), &options.colour)
        {
            let problem = "cannot be logarithmic: no value is above 0";
            return Err(PictureError::option("colour scale", problem.to_owned()));
        }
        let strongest = overview.strengths.full().map_or(0.0, |(_, high)| high);
        let strengths = options.contacts.range.unwrap_or((0.0, strongest));
        Ok(Self {
            theme: Theme::new(options.background),
            options: options.clone(),
            overview,
            bar,
            strengths: crate::value_range::opened(strengths.0, strengths.1),
        })
    }

    /// The options it was made with.
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// A frame as pixels.
    #[must_use]
    pub fn image(&self, frame: &Frame) -> Image {
        self.sheet(&[frame]).image(&self.options)
    }

    /// A frame as an SVG document: headings, legend, axes and scale as text and shapes, the scene as a PNG inside, of the size in
    /// pixels that the options give.
    ///
    /// # Errors
    /// If the encoder refuses, which it has no reason to.
    pub fn svg(&self, frame: &Frame) -> Result<String, PictureError> {
        Ok(self.image_and_svg(frame)?.1)
    }

    /// A frame as pixels and as an SVG document, for about the time of one: the scene is painted once.
    ///
    /// # Errors
    /// If the encoder refuses, which it has no reason to.
    pub fn image_and_svg(&self, frame: &Frame) -> Result<(Image, String), PictureError> {
        self.sheet(&[frame]).image_and_svg(&self.options)
    }

    /// Several frames side by side in one picture, each under its time.
    ///
    /// # Errors
    /// If there is no frame.
    pub fn strip(&self, frames: &[Frame]) -> Result<Image, PictureError> {
        if frames.is_empty() {
            return Err(PictureError::Number {
                got: 0,
                expected: "at least 1".into(),
            });
        }
        let frames: Vec<&Frame> = frames.iter().collect();
        Ok(self.sheet(&frames).image(&self.options))
    }

    fn sheet<'a>(&self, frames: &[&'a Frame]) -> Sheet<'a> {
        let strip = frames.len() > 1;
        let options = &self.options;
        let cells = frames.iter().enumerate().map(|(number, frame)| Cell {
            frame,
            look: self.look(frame),
            overview: self.overview.clone(),
            options: options.clone(),
            caption: strip.then(|| match frame.time.filter(|time| time.is_finite()) {
                Some(time) => notes::time_label(time),
                None => format!("{}", number + 1),
            }),
        });
        let (title, numbers) = match frames.last() {
            Some(last) if options.headings => {
                let noun = &options.contacts.noun;
                (last.title.clone(), notes::numbers(last, noun, !strip))
            }
            _ => (String::new(), String::new()),
        };
        Sheet {
            title,
            numbers,
            theme: self.theme,
            legend: if options.legend {
                self.legend()
            } else {
                Legend::default()
            },
            cells: cells.collect(),
            axes: options.axes,
            scale_bar: options.scale_bar,
        }
    }

    fn look<'a>(&self, frame: &'a Frame) -> Look<'a> {
        let unit = layout::unit(&self.options);
        let contacts = frame.contacts.iter().map(|contact| {
            let place = share(contact.strength.abs(), self.strengths);
            let ContactStyle {
                thinnest, width, ..
            } = self.options.contacts;
            let colour = self.contact_map().colour(place);
            (colour, (thinnest + place * (width - thinnest)) * unit)
        });
        let spheres = match frame.droplets.is_empty() {
            true => Cow::Borrowed(&frame.spheres[..]),
            false => Cow::Owned([&frame.spheres[..], &frame.droplets].concat()),
        };
        let of_droplet = |droplet: &Sphere| match droplet.value.is_nan() {
            true => self.theme.droplet,
            false => self.colour(droplet.value, false),
        };
        Look {
            theme: self.theme,
            spheres,
            sphere_colours: (frame.spheres.iter())
                .map(|s| self.colour(s.value, s.fixed))
                .chain(frame.droplets.iter().map(of_droplet))
                .collect(),
            grain_colours: (frame.grains.iter())
                .map(|g| self.colour(g.value, g.fixed))
                .collect(),
            sphere_opacity: self.options.sphere_opacity,
            contacts: contacts.collect(),
            domain: self.options.domain,
            unit,
            frame,
        }
    }

    fn colour(&self, value: f64, fixed: bool) -> Colour {
        if fixed {
            return self.theme.fixed;
        }
        match (&self.options.colour, self.bar) {
            (ColourBy::Plain, _) => self.theme.plain,
            (_, _) if value.is_nan() => self.theme.missing,
            (ColourBy::Category { .. }, _) if value >= 0.0 => category_colour(value as usize),
            (ColourBy::Scalar { .. }, Some((range, map, true))) => {
                map.colour(logarithmic_share(value, range))
            }
            (ColourBy::Scalar { .. }, Some((range, map, false))) => map.colour(share(value, range)),
            _ => self.theme.missing,
        }
    }

    fn contact_map(&self) -> ColourMap {
        self.options.contacts.map.unwrap_or(self.theme.contacts)
    }

    fn legend(&self) -> Legend {
        let mut legend = Legend::default();
        let overview = &self.overview;
        match &self.options.colour {
            ColourBy::Plain => {}
            ColourBy::Scalar { label, unit, .. } => {
                if let Some((range, map, logarithmic)) = self.bar {
                    let (low, high) = overview.values.full().unwrap_or(range);
                    legend.bars.push(Bar {
                        label: label.clone(),
                        unit: unit.clone(),
                        range,
                        map,
                        logarithmic,
                        beyond: (low < range.0, high > range.1),
                    });
                }
            }
            // A reader cannot find one number among many, still less where colours repeat.
            ColourBy::Category { names, .. }
                if names.is_empty() && overview.categories.len() > MOST_NUMBERS => {}
            ColourBy::Category { label, names } => {
                legend.heading.clone_from(label);
                let most = MOST_CATEGORIES;
                legend.more = overview.categories.len().saturating_sub(most);
                for number in overview.categories.iter().take(most) {
                    let name = names.get(*number).cloned();
                    let name = name.unwrap_or_else(|| number.to_string());
                    legend.dots.push((name, category_colour(*number)));
                }
            }
        }
        if overview.has_fixed {
            legend.dots.push(("fixed".into(), self.theme.fixed));
        }
        if overview.has_missing && self.options.colour != ColourBy::Plain {
            legend.dots.push(("no value".into(), self.theme.missing));
        }
        if overview.has_droplets {
            legend.dots.push(("droplet".into(), self.theme.droplet));
        }
        let style = &self.options.contacts;
        if let Some((low, high)) = overview.strengths.full() {
            legend.bars.push(Bar {
                label: style.label.clone(),
                unit: style.unit.clone(),
                range: self.strengths,
                map: self.contact_map(),
                logarithmic: false,
                beyond: (low < self.strengths.0, high > self.strengths.1),
            });
        }
        legend
    }
}
