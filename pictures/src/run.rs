//! The picture that a run leaves behind without being asked: its final state.
//!
//! It is drawn once and written twice, as PNG (1200 x 900 pixels) and as SVG.
//!
//! The rooms: `framing` and `camera` decide what is seen and where, `shade` which sphere each pixel shows,
//! `colouring` what colours mean; `final_state` (with `annotation` and `svg_spheres`) lays a
//! page out; `raster` is the page of pixels.

mod annotation;
mod camera;
mod colouring;
mod final_state;
mod framing;
mod raster;
mod shade;
mod svg_spheres;
#[cfg(test)]
mod tests;

use crate::PictureError;
use final_state::FinalState;
use glam::DVec3;
use mercury_common::whole_file::write_whole;
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
    write_whole(png, &page.png()?)?;
    Ok(write_whole(svg, picture.svg().as_bytes())?)
}
