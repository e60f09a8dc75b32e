//! How a picture looks: size, camera, colours, what stands around it.

use std::str::FromStr;

use glam::DVec3;

use crate::PictureError;
use crate::colour_map::ColourMap;

/// How a picture looks. Every field has a sensible default.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Width of the picture (pixels).
    pub width: u32,
    /// Height of the picture (pixels).
    pub height: u32,
    /// From where the scene is seen. Two-dimensional frames are always seen straight.
    pub view: View,
    /// Parallel or converging rays.
    pub projection: Projection,
    /// Part of the scene that must be in view.
    pub framing: Framing,
    /// Above 1: closer than [`Options::framing`] sets.
    pub zoom: f64,
    /// The point (m) in the middle of the picture instead of the middle of what is framed.
    pub target: Option<DVec3>,
    /// Meaning of the colours of the spheres.
    pub colour: ColourBy,
    /// Below 1 the particles let see what lies behind them, contacts for example. Walls that are coloured by a value stay as they are.
    pub sphere_opacity: f64,
    /// How contacts are drawn, if a frame has any.
    pub contacts: ContactStyle,
    /// Background of the picture.
    pub background: Background,
    /// The title and a line of numbers above the scene.
    pub headings: bool,
    /// Colour bars and categories beside the scene.
    pub legend: bool,
    /// A round length; only where all lengths have one scale, in orthographic pictures.
    pub scale_bar: bool,
    /// The directions of the axes and of gravity.
    pub axes: bool,
    /// The box of the domain.
    pub domain: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            width: 1200,
            height: 900,
            view: View::default(),
            projection: Projection::Orthographic,
            framing: Framing::Auto,
            zoom: 1.0,
            target: None,
            colour: ColourBy::Plain,
            sphere_opacity: 1.0,
            contacts: ContactStyle::default(),
            background: Background::Light,
            headings: true,
            legend: true,
            scale_bar: true,
            axes: true,
            domain: true,
        }
    }
}

impl Options {
    /// The smallest and the largest side of a picture (pixels).
    pub const SIDES: (u32, u32) = (16, 16_384);
    /// The most pixels a picture may have: the renderer needs about 40 bytes for each.
    pub const MOST_PIXELS: u64 = 100_000_000;

    /// # Errors
    /// For a size, zoom, angle, opacity or range that cannot be drawn.
    pub(crate) fn check(&self) -> Result<(), PictureError> {
        let (low, high) = Self::SIDES;
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if !(low..=high).contains(&side) {
                return Err(PictureError::option(
                    name,
                    format!("must be {low} to {high} pixels, got {side}"),
                ));
            }
        }
        let pixels = u64::from(self.width) * u64::from(self.height);
        if pixels > Self::MOST_PIXELS {
            let most = Self::MOST_PIXELS / 1_000_000;
            return Err(PictureError::option(
                "size",
                format!(
                    "is limited to {most} million pixels, got {} x {}",
                    self.width, self.height
                ),
            ));
        }
        if !(self.zoom.is_finite() && self.zoom > 0.0) {
            return Err(PictureError::option(
                "zoom",
                format!("must be above 0, got {}", self.zoom),
            ));
        }
        if !(0.0..=1.0).contains(&self.sphere_opacity) {
            return Err(PictureError::option(
                "opacity",
                format!("must be 0 to 1, got {}", self.sphere_opacity),
            ));
        }
        if let Projection::Perspective { field_of_view } = self.projection
            && !(1.0..=120.0).contains(&field_of_view)
        {
            return Err(PictureError::option(
                "field of view",
                format!("must be 1 to 120 degrees, got {field_of_view}"),
            ));
        }
        if !(self.view.azimuth.is_finite() && self.view.elevation.is_finite()) {
            return Err(PictureError::option("view", "angles must be finite".into()));
        }
        let ranges = match &self.colour {
            ColourBy::Scalar { range, .. } => [*range, self.contacts.range],
            _ => [None, self.contacts.range],
        };
        for (low, high) in ranges.into_iter().flatten() {
            if !(low.is_finite() && high.is_finite() && low <= high) {
                return Err(PictureError::option(
                    "range",
                    format!("must go from a lower to a higher number, got {low} to {high}"),
                ));
            }
        }
        if let ColourBy::Scalar {
            logarithmic: true,
            range: Some((low, _)),
            ..
        } = self.colour
            && low <= 0.0
        {
            return Err(PictureError::option(
                "range",
                format!("must begin above 0 where colours are logarithmic, got {low}"),
            ));
        }
        Ok(())
    }
}

/// From where a scene is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Degrees by which the camera has gone round the scene. At 0 it looks along y and x points right; at 90 it looks
    /// along −x and y points right. (This is for z up; elsewhere "level" replaces x and y.)
    pub azimuth: f64,
    /// Degrees of the camera above the horizon; 90: from above.
    pub elevation: f64,
}

impl View {
    /// Along y: x right, z up.
    pub const FRONT: Self = Self::new(0.0, 0.0);
    /// Along −y.
    pub const BACK: Self = Self::new(180.0, 0.0);
    /// Along −x: y right, z up.
    pub const RIGHT: Self = Self::new(90.0, 0.0);
    /// Along x.
    pub const LEFT: Self = Self::new(-90.0, 0.0);
    /// Downwards: x right, y up.
    pub const TOP: Self = Self::new(0.0, 90.0);
    /// Upwards.
    pub const BOTTOM: Self = Self::new(0.0, -90.0);
    /// All three axes under the same angle: elevation asin(1/sqrt 3).
    pub const ISO: Self = Self::new(45.0, 35.264_389_682_754_654);
    /// The default: nearly from the front, so that x stays long, yet a box shows three of its faces.
    pub const OBLIQUE: Self = Self::new(24.0, 20.0);
    /// The names that [`View::from_str`] takes.
    pub const NAMES: [(&'static str, Self); 9] = [
        ("front", Self::FRONT),
        ("back", Self::BACK),
        ("side", Self::RIGHT),
        ("right", Self::RIGHT),
        ("left", Self::LEFT),
        ("top", Self::TOP),
        ("bottom", Self::BOTTOM),
        ("iso", Self::ISO),
        ("oblique", Self::OBLIQUE),
    ];

    /// A view from these angles (degrees).
    #[must_use]
    pub const fn new(azimuth: f64, elevation: f64) -> Self {
        Self { azimuth, elevation }
    }
}

impl Default for View {
    fn default() -> Self {
        Self::OBLIQUE
    }
}

impl FromStr for View {
    type Err = String;

    /// A name of [`View::NAMES`], or `AZIMUTH,ELEVATION` in degrees.
    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((_, view)) = Self::NAMES.iter().find(|(name, _)| *name == text) {
            return Ok(*view);
        }
        let angles = text.split_once(',').and_then(|(azimuth, elevation)| {
            Some(Self::new(
                azimuth.trim().parse().ok()?,
                elevation.trim().parse().ok()?,
            ))
        });
        angles
            .filter(|view| view.azimuth.is_finite() && view.elevation.is_finite())
            .ok_or_else(|| {
                let names: Vec<&str> = Self::NAMES.iter().map(|(name, _)| *name).collect();
                format!(
                    "expected one of {}, or AZIMUTH,ELEVATION in degrees such as 30,20",
                    names.join(", ")
                )
            })
    }
}

/// How space falls on the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Parallel rays: lengths can be measured.
    Orthographic,
    /// Rays that meet in an eye.
    Perspective {
        /// Angle (degrees) that the larger side of the scene's window subtends.
        field_of_view: f64,
    },
}

/// Part of the scene that must be in view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Framing {
    /// The bed with walls and domain, if it fills a good part of that picture; else the bed and what stands near it.
    #[default]
    Auto,
    /// Every particle, wall and the whole domain.
    Everything,
    /// The particles alone; all of them.
    Particles,
}

/// Background of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Background {
    /// White, with dark text.
    #[default]
    Light,
    /// Nearly black, with light text.
    Dark,
    /// Nothing: the picture has an alpha channel. Text is dark.
    Transparent,
}

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "light" => Ok(Self::Light),
            "dark" => Ok(Self::Dark),
            "transparent" => Ok(Self::Transparent),
            _ => Err("expected light, dark or transparent".into()),
        }
    }
}

/// Meaning of the colours of the spheres.
#[derive(Debug, Clone, PartialEq)]
pub enum ColourBy {
    /// Nothing: all have one colour.
    Plain,
    /// A number.
    Scalar {
        /// Name of the number: `speed`.
        label: String,
        /// Its SI unit, empty for none.
        unit: String,
        /// Values at the ends of the colour bar; those outside take the colours of the ends. `None`: from the frames.
        range: Option<(f64, f64)>,
        /// The colours.
        map: ColourMap,
        /// Equal steps of colour stand for equal ratios. Values that are not above 0 take the colour of the lower end.
        logarithmic: bool,
    },
    /// One of a few things: materials, bodies.
    Category {
        /// Name of the categories: `material`.
        label: String,
        /// Their names, in the order of their numbers. Numbers without a name stand for themselves.
        names: Vec<String>,
    },
}

impl ColourBy {
    /// A number with this label and unit, in viridis over the range of the frames.
    #[must_use]
    pub fn scalar(label: &str, unit: &str) -> Self {
        Self::Scalar {
            label: label.into(),
            unit: unit.into(),
            range: None,
            map: ColourMap::Viridis,
            logarithmic: false,
        }
    }
}

/// How contacts look.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactStyle {
    /// Name of their strength: `force`.
    pub label: String,
    /// Its SI unit.
    pub unit: String,
    /// One of the lines, in the heading: `contact`.
    pub noun: String,
    /// Strengths of the thinnest and of the widest line. `None`: from 0 to the strongest of the frames.
    pub range: Option<(f64, f64)>,
    /// Width of the thinnest line in pixels of a picture of 1200 x 900.
    pub thinnest: f64,
    /// Width of the widest line in pixels of a picture of 1200 x 900.
    pub width: f64,
    /// Colours by strength; `None`: a map that goes with the background.
    pub map: Option<ColourMap>,
}

/// Opacity of particles that let see the lines between them.
pub const BEHIND_LINES: f64 = 0.15;

impl ContactStyle {
    /// Style of bonds, by a stress in Pa of this name.
    #[must_use]
    pub fn of_bonds(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            unit: "Pa".to_owned(),
            noun: "bond".to_owned(),
            // Bonds without load hold, too.
            thinnest: 2.5,
            ..Self::default()
        }
    }
}

impl Default for ContactStyle {
    fn default() -> Self {
        Self {
            label: "force".into(),
            unit: "N".into(),
            noun: "contact".into(),
            range: None,
            thinnest: 0.35,
            width: 7.0,
            map: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_by_name_and_by_angles() {
        assert_eq!("iso".parse(), Ok(View::ISO));
        assert_eq!("30, -20".parse(), Ok(View::new(30.0, -20.0)));
        for wrong in ["", "isoo", "1", "nan,0", "1,2,3", "inf,0"] {
            let error = wrong.parse::<View>().unwrap_err();
            assert_eq!(
                error,
                "expected one of front, back, side, right, left, top, bottom, iso, oblique, or AZIMUTH,ELEVATION in \
                 degrees such as 30,20"
            );
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused_by_name() {
        let with = |change: fn(&mut Options)| {
            let mut options = Options::default();
            change(&mut options);
            options.check().unwrap_err().to_string()
        };
        assert_eq!(
            with(|o| o.width = 3),
            "the picture's width must be 16 to 16384 pixels, got 3"
        );
        assert_eq!(
            with(|o| (o.width, o.height) = (16_384, 16_384)),
            "the picture's size is limited to 100 million pixels, got 16384 x 16384"
        );
        assert_eq!(
            with(|o| o.zoom = f64::NAN),
            "the picture's zoom must be above 0, got NaN"
        );
        assert_eq!(
            with(|o| o.sphere_opacity = 1.5),
            "the picture's opacity must be 0 to 1, got 1.5"
        );
        assert_eq!(
            with(|o| o.contacts.range = Some((2.0, 1.0))),
            "the picture's range must go from a lower to a higher number, got 2 to 1"
        );
        assert!(Options::default().check().is_ok());
    }
}
