//! `[[regions]]` as the engine's plans.

use glam::DVec3;
use mercury_common::scene::{Dimensions, Scene, SceneError};

use super::insertions::region;
use crate::plan::particles::StartingParticles;
use mercury_engine::boundaries::{CountedRegion, Region, volume_within};

/// Thickness of a layer in which oblique shapes of two-dimensional scenes are still as in the plane, of the domain.
const THIN: f64 = 1e-6;

/// The domain, of which regions have a part; in two dimensions the plane of the discs.
pub(crate) struct DomainBox {
    min: DVec3,
    max: DVec3,
    /// z of the plane, m.
    plane: Option<f64>,
    /// Thickness of the layer that stands for the plane, m; 1 in three dimensions.
    depth: f64,
}

impl DomainBox {
    /// Box of a scene with these particles at the start.
    pub(crate) fn of(scene: &Scene, start: &StartingParticles) -> Self {
        let (min, max) = (*scene.domain.min, *scene.domain.max);
        let mut room = Self {
            min,
            max,
            plane: None,
            depth: 1.0,
        };
        if scene.domain.dimensions == Dimensions::Two {
            let plane = match start.particles.first() {
                Some(first) => first.position.z,
                // As discs are inserted.
                None => 0f64.clamp(min.z, max.z),
            };
            // The volume is that of a thin layer, over its thickness.
            let depth = THIN * (max - min).truncate().max_element();
            (room.min.z, room.max.z) = (plane - 0.5 * depth, plane + 0.5 * depth);
            (room.plane, room.depth) = (Some(plane), depth);
        }
        room
    }

    /// The region as far as it is in the plane.
    fn part_of(&self, region: Region) -> Region {
        match self.plane {
            Some(plane) => region.in_plane(plane),
            None => region,
        }
    }

    /// Volume of a region within the domain, m^3; its area in the plane, m^2.
    pub(crate) fn volume_of(&self, region: Region) -> f64 {
        volume_within(&self.part_of(region), self.min, self.max) / self.depth
    }
}

/// All counted regions, in the order of the file.
pub(crate) fn regions(
    scene: &Scene,
    room: &DomainBox,
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Vec<CountedRegion> {
    let mut planned = Vec::new();
    for counted in &scene.regions {
        let Some(region) = region(&counted.region, warnings, errors) else {
            continue;
        };
        let volume = room.volume_of(region.clone());
        if volume > 0.0 {
            planned.push(CountedRegion {
                name: counted.name.value.clone(),
                region: room.part_of(region),
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
