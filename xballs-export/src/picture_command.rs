//! The options of `png`, `svg`, `gif` and `apng`.

use std::str::FromStr;

use clap::{Args, ValueEnum};
use glam::DVec3;
use mercury_export::sinks::pictures::{BondStress, PictureChoice};
use mercury_pictures::{
    BEHIND_LINES, Background, ColourBy, ColourMap, ContactStyle, Framing, Options, Projection, View,
};

use crate::arguments::ClumpsName;

/// Stress that the lines of bonds show.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum StressName {
    /// The larger of both
    Stress,
    /// Tensile stress
    Tension,
    /// Shear stress
    Shear,
}

/// How a picture looks.
#[derive(Debug, Args)]
pub(crate) struct Look {
    /// auto (speed; height where nothing moves), none, speed, height, diameter, material, body, clump (its kind), depth (of worn walls), film (volume of the liquid film), liquid (film and bridges), or any column or vector of the input
    #[arg(
        long,
        visible_alias = "color",
        value_name = "WHAT",
        default_value = "auto"
    )]
    colour: String,
    /// viridis, magma, inferno, plasma, cividis, turbo, coolwarm, grey or embers
    #[arg(long, value_name = "NAME", default_value = "viridis")]
    map: ColourMap,
    /// Values at the ends of the colour bar [default: from the frames]
    #[arg(long, value_name = "LOW..HIGH", value_parser = range, allow_hyphen_values = true)]
    range: Option<(f64, f64)>,
    /// A logarithmic colour scale: equal steps of colour for equal ratios
    #[arg(long)]
    log: bool,
    /// oblique, front, back, left, right (side), top, bottom, iso, or AZIMUTH,ELEVATION in degrees
    #[arg(long, default_value = "oblique", allow_hyphen_values = true)]
    view: View,
    /// Converging rays; DEGREES is the angle that the window subtends
    #[arg(long, value_name = "DEGREES", num_args = 0..=1, default_missing_value = "35", allow_negative_numbers = true)]
    perspective: Option<f64>,
    /// Above 1: closer
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    zoom: f64,
    /// The point in the middle of the picture, in m
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    target: Option<DVec3>,
    /// Part of the scene in view: auto (the bed, and walls and domain unless it gets too small), all or particles
    #[arg(long, default_value = "auto", value_parser = framing)]
    framing: Framing,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1200x900", value_parser = size)]
    size: (u32, u32),
    /// light, dark or transparent
    #[arg(long, default_value = "light")]
    background: Background,
    /// Leave particles out, to see walls and what their colours show
    #[arg(long, conflicts_with = "opacity")]
    no_particles: bool,
    /// Opacity of the particles, 0 to 1 [default: 1, with --contacts, --bridges or --bonds 0.15]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    opacity: Option<f64>,
    /// Contacts as lines, wider and darker with the force (runs with fstat = true)
    #[arg(long)]
    contacts: bool,
    /// Liquid bridges as lines, wider and darker with the force of the bridge (wet runs with fstat = true)
    #[arg(long, conflicts_with = "contacts")]
    bridges: bool,
    /// Bonds as lines, wider and darker with the stress: the larger of both (stress), tension or shear (runs with [[bonds]])
    #[arg(long, value_name = "STRESS", num_args = 0..=1, require_equals = true, default_missing_value = "stress", conflicts_with_all = ["contacts", "bridges"])]
    bonds: Option<StressName>,
    /// Stresses (Pa) at the ends of the scale of bonds [default: from 0 to the largest of the frames]
    #[arg(long, value_name = "LOW..HIGH", value_parser = range, requires = "bonds", allow_hyphen_values = true)]
    bond_range: Option<(f64, f64)>,
    /// Droplets in flight (runs with sprays)
    #[arg(long)]
    droplets: bool,
    /// Clumps as spheres, as their own surfaces, or both
    #[arg(long, value_enum, default_value_t)]
    clumps: ClumpsName,
    /// Leave walls out
    #[arg(long)]
    no_walls: bool,
    /// Leave the box of the domain out
    #[arg(long)]
    no_domain: bool,
    /// Leave the colour bar out
    #[arg(long)]
    no_legend: bool,
    /// The scene alone: no title, legend, axes, scale bar
    #[arg(long)]
    bare: bool,
    /// Heading instead of the run's title
    #[arg(long)]
    title: Option<String>,
}

impl Look {
    pub(crate) fn choice(&self) -> PictureChoice {
        let lines = self.contacts || self.bridges || self.bonds.is_some();
        let opaque = if lines { BEHIND_LINES } else { 1.0 };
        PictureChoice {
            options: Options {
                width: self.size.0,
                height: self.size.1,
                view: self.view,
                projection: self
                    .perspective
                    .map_or(Projection::Orthographic, |degrees| {
                        Projection::Perspective {
                            field_of_view: degrees,
                        }
                    }),
                framing: self.framing,
                zoom: self.zoom,
                target: self.target,
                colour: ColourBy::Plain,
                contacts: self.style_of_lines(),
                sphere_opacity: self.opacity.unwrap_or(opaque),
                background: self.background,
                headings: !self.bare,
                legend: !self.bare && !self.no_legend,
                scale_bar: !self.bare,
                axes: !self.bare,
                domain: !self.no_domain,
            },
            quantity: self.colour.clone(),
            range: self.range,
            map: self.map,
            logarithmic: self.log,
            particles: !self.no_particles,
            contacts: self.contacts,
            bridges: self.bridges,
            bonds: self.bonds.map(|stress| match stress {
                StressName::Stress => BondStress::Larger,
                StressName::Tension => BondStress::Tension,
                StressName::Shear => BondStress::Shear,
            }),
            droplets: self.droplets,
            walls: !self.no_walls,
            clumps: self.clumps.into(),
            title: self.title.clone(),
        }
    }
}

impl Look {
    fn style_of_lines(&self) -> ContactStyle {
        let contacts = ContactStyle::default();
        let label = match self.bonds {
            None if self.bridges => {
                return ContactStyle {
                    label: "bridge force".to_owned(),
                    ..contacts
                };
            }
            None => return contacts,
            Some(StressName::Stress) => "stress in bonds",
            Some(StressName::Tension) => "tension in bonds",
            Some(StressName::Shear) => "shear in bonds",
        };
        ContactStyle {
            range: self.bond_range,
            ..ContactStyle::of_bonds(label)
        }
    }
}

fn numbers<const N: usize>(text: &str, separator: &str) -> Option<[f64; N]> {
    let numbers: Result<Vec<f64>, _> = text
        .split(separator)
        .map(|t| f64::from_str(t.trim()))
        .collect();
    let numbers: [f64; N] = numbers.ok()?.try_into().ok()?;
    numbers
        .iter()
        .all(|number| number.is_finite())
        .then_some(numbers)
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let found = numbers(text, "..").map(|[low, high]| (low, high));
    found
        .filter(|(low, high)| low <= high)
        .ok_or_else(|| "expected LOW..HIGH, as in 0..0.5".to_owned())
}

fn point(text: &str) -> Result<DVec3, String> {
    let found = numbers(text, ",").map(DVec3::from_array);
    found.ok_or_else(|| "expected X,Y,Z in m, as in 0,0.1,0.05".to_owned())
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let found = text
        .split_once('x')
        .and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
    found.ok_or_else(|| "expected WIDTHxHEIGHT in pixels, as in 1200x900".to_owned())
}

fn framing(text: &str) -> Result<Framing, String> {
    match text {
        "auto" => Ok(Framing::Auto),
        "all" => Ok(Framing::Everything),
        "particles" => Ok(Framing::Particles),
        _ => Err("expected auto, all or particles".to_owned()),
    }
}
