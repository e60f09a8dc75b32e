//! The pictures that a run leaves behind without being asked: its final state and its energies.
//!
//! Each is drawn once and written twice, as PNG (1200 x 900 pixels) and as SVG.
//!
//! The rooms: `framing` and `camera` decide what is seen and where, `shade` which sphere each pixel shows,
//! `colouring` what colours mean; `final_state` (with `annotation` and `svg_spheres`) and `energies` lay a
//! page out; `raster` is the page of pixels.

mod annotation;
mod camera;
mod colouring;
mod curve;
mod energies;
mod final_state;
mod framing;
mod raster;
mod shade;
mod svg_spheres;
#[cfg(test)]
mod tests;

use crate::PictureError;
use crate::file;
use crate::svg::Svg;
use final_state::FinalState;
use glam::DVec3;
use raster::Raster;
use std::path::Path;

/// One sphere (a disc in two dimensions) as the picture shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureSphere {
    /// Centre (m).
    pub centre: DVec3,
    /// Radius (m).
    pub radius: f64,
    /// Magnitude of the velocity (m/s).
    pub speed: f64,
    /// Fixed or driven particles are drawn grey.
    pub fixed: bool,
}

/// A wall as lines in space; the caller knows its shape.
#[derive(Debug, Clone, PartialEq)]
pub enum PictureWall {
    /// A line through these points (m).
    Polyline(Vec<DVec3>),
}

/// Everything the picture of the final state shows.
#[derive(Debug, Clone, Copy)]
pub struct PictureScene<'a> {
    /// Heading; one line, shortened if it does not fit.
    pub title: &'a str,
    /// Simulated time (s).
    pub time: f64,
    /// The particles. Those whose position or radius is not finite or whose radius is not positive are left out
    /// and counted in the heading.
    pub spheres: &'a [PictureSphere],
    /// Lower corner of the domain (m); a domain that is not finite is not drawn.
    pub domain_min: DVec3,
    /// Upper corner of the domain (m).
    pub domain_max: DVec3,
    /// Gravity (m/s²); the picture's "up" is against it (z without gravity). In two dimensions y is up.
    pub gravity: DVec3,
    /// 2: the x-y plane seen straight; anything else: space seen from the side and above.
    pub dimensions: u8,
    /// Outlines of walls.
    pub walls: &'a [PictureWall],
}

/// The energies of the system at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyRow {
    /// Time (s).
    pub time: f64,
    /// Kinetic energy of translation (J).
    pub kinetic: f64,
    /// Kinetic energy of rotation (J).
    pub rotational: f64,
    /// Potential energy in gravity (J), from any level.
    pub gravitational: f64,
    /// Elastic energy stored in contacts (J).
    pub elastic: f64,
    /// Energy dissipated since the start (J), where the run keeps account of it.
    pub dissipated: Option<f64>,
}

impl EnergyRow {
    /// Whether every number in the row is finite; other rows are not drawn.
    fn is_finite(&self) -> bool {
        [
            self.time,
            self.kinetic,
            self.rotational,
            self.gravitational,
            self.elastic,
            self.dissipated.unwrap_or(0.0),
        ]
        .iter()
        .all(|value| value.is_finite())
    }
}

/// Draws the final state of a run to the files `png` and `svg`.
///
/// Colours show speed, or height where everything is at rest. Above 5000 spheres the SVG holds only those in
/// sight, at most 20 000.
///
/// # Errors
/// If a file cannot be written; each file is then either the old or the new one, never a part.
pub fn draw_final(png: &Path, svg: &Path, scene: &PictureScene) -> Result<(), PictureError> {
    let picture = FinalState::new(scene);
    let mut page = Raster::new();
    picture
        .buffer
        .paint(&mut page, &picture.spheres, &picture.colours());
    picture.annotate(&mut page);
    file::write_whole(png, &page.png()?)?;
    file::write_whole(svg, picture.svg().as_bytes())
}

/// Draws the energies of a run over time to the files `png` and `svg`: every kind that the run has on linear axes,
/// gravitational energy counted from its minimum in the run, and below the whole kinetic energy on a logarithmic
/// axis. `rows` are in the order of time.
///
/// # Errors
/// If a file cannot be written; each file is then either the old or the new one, never a part.
pub fn draw_energies(
    png: &Path,
    svg: &Path,
    title: &str,
    rows: &[EnergyRow],
) -> Result<(), PictureError> {
    let mut page = Raster::new();
    energies::draw(&mut page, title, rows);
    file::write_whole(png, &page.png()?)?;
    let mut document = Svg::new(title, "Energies over time");
    energies::draw(&mut document, title, rows);
    file::write_whole(svg, document.finish().as_bytes())
}
