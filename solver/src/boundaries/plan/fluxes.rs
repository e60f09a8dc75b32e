//! `[[fluxes]]` as the engine's plans.

use glam::DVec3;
use mercury_common::scene::{Dimensions, Flux, FluxPart as Part, Scene, SceneError};

use mercury_engine::boundaries::{FluxPart, FluxPlan};

/// All flux planes, in the order of the file.
pub(crate) fn fluxes(scene: &Scene, errors: &mut Vec<SceneError>) -> Vec<FluxPlan> {
    for flux in &scene.fluxes {
        errors.extend(wrong(scene, flux));
    }
    let planned = scene.fluxes.iter().map(|flux| FluxPlan {
        name: flux.name.value.clone(),
        point: *flux.point,
        normal: *flux.normal,
        part: match &flux.part {
            Part::All => FluxPart::All,
            Part::Disc(radius) => FluxPart::Disc(**radius),
            Part::Rectangle(sides) => FluxPart::Rectangle(sides.each_ref().map(|side| **side)),
        },
    });
    planned.collect()
}

/// Why nothing can ever cross a plane.
fn wrong(scene: &Scene, flux: &Flux) -> Option<SceneError> {
    let (min, max) = (*scene.domain.min, *scene.domain.max);
    let (point, normal) = (*flux.point, *flux.normal);
    if scene.domain.dimensions == Dimensions::Two && normal.x == 0.0 && normal.y == 0.0 {
        let message = "two dimensions: nothing moves along z, so that nothing can ever cross it";
        return Some(flux.normal.error(message));
    }
    // A box reaches so far along a direction.
    let reach = (0.5 * (max - min)).dot(normal.abs());
    let off = (0.5 * (min + max) - point).dot(normal).abs();
    let mut away = point - point.clamp(min, max.max(min));
    for axis in 0..3 {
        if scene.domain.periodic[axis] && normal[axis] == 0.0 {
            away[axis] = 0.0;
        }
    }
    let beyond = match &flux.part {
        Part::All => false,
        Part::Disc(radius) => away.length() > **radius,
        Part::Rectangle([along, across]) => {
            let half: DVec3 = 0.5 * (along.abs() + across.abs());
            away.abs().cmpgt(half).any()
        }
    };
    // Round-off of a plane in a face.
    (off > reach * (1.0 + 1e-12) || beyond).then(|| {
        let message = format!(
            "the plane \"{}\" does not pass through the domain, so that nothing can ever cross it",
            flux.name.value
        );
        flux.point
            .error(message)
            .with_help("move it into the box of domain.min and domain.max; lengths are in metres")
    })
}
