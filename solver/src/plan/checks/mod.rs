//! Whether the scene makes sense as a whole: positions, overlaps, periodic axes, two dimensions.

mod crowds;
mod domain;
mod overlaps;

use glam::DVec3;
use mercury_common::scene::{Scene, SourceSpan};

use super::particles::{StartingParticles, Typed};
use mercury_engine::contact::parameter::short;

pub(super) use domain::{far_from_the_origin, flat, inside_the_domain, periodic_axes};
pub(super) use overlaps::{overlaps, through_sheets};

/// The name of a particle or body in messages: its id, or its number among the bodies, and the place where it was typed.
pub(super) fn name(scene: &Scene, start: &StartingParticles, grain: usize) -> String {
    let Typed { entry, line } = start.typed(grain);
    let key = scene.particles[entry].place.key();
    match (grain.checked_sub(start.particles.len()), line) {
        (Some(body), _) => format!("body {body} ({key})"),
        (None, Some(line)) => format!("particle {grain} ({key}, line {line} of its file)"),
        (None, None) => format!("particle {grain} ({key})"),
    }
}

/// Where a grain was typed.
pub(super) fn place<'a>(
    scene: &'a Scene,
    start: &StartingParticles,
    grain: usize,
) -> &'a SourceSpan {
    &scene.particles[start.typed(grain).entry].place
}

fn point(position: DVec3) -> String {
    let [x, y, z] = position.to_array().map(short);
    format!("[{x}, {y}, {z}]")
}
