//! `[[regions]]` as the engine's plans.

use mercury_common::scene::{Dimensions, Scene, SceneError};

use super::insertions::region;
use super::particles::StartingParticles;
use mercury_engine::boundaries::{CountedRegion, volume_within};

/// Thickness of a layer in which oblique shapes of two-dimensional scenes are still as in the plane, of the domain.
const THIN: f64 = 1e-6;

/// All counted regions, in the order of the file.
pub(super) fn regions(
    scene: &Scene,
    start: &StartingParticles,
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Vec<CountedRegion> {
    let (mut min, mut max) = (*scene.domain.min, *scene.domain.max);
    let mut depth = 1.0;
    let plane = (scene.domain.dimensions == Dimensions::Two).then(|| {
        let plane = match start.particles.first() {
            Some(first) => first.position.z,
            // As discs are inserted.
            None => 0f64.clamp(min.z, max.z),
        };
        // The volume is that of a thin layer, over its thickness.
        depth = THIN * (max - min).truncate().max_element();
        (min.z, max.z) = (plane - 0.5 * depth, plane + 0.5 * depth);
        plane
    });
    let mut planned = Vec::new();
    for counted in &scene.regions {
        let Some(region) = region(&counted.region, warnings, errors) else {
            continue;
        };
        let region = plane.map_or_else(|| region.clone(), |plane| region.in_plane(plane));
        let volume = volume_within(&region, min, max) / depth;
        if volume > 0.0 {
            planned.push(CountedRegion {
                name: counted.name.value.clone(),
                region,
                volume,
            });
        } else {
            let message = format!(
                "the region \"{}\" has no volume within the domain, so that nothing can ever be counted in it",
                counted.name.value
            );
            let error = counted.region.error(message);
            errors.push(error.with_help(
                "move it into the box of domain.min and domain.max; lengths are in metres",
            ));
        }
    }
    planned
}
