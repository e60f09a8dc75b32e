//! Regions as the engine has them.

use std::sync::Arc;

use mercury_common::scene::{Region as SceneRegion, SceneError};

use crate::plan::meshes;
use mercury_engine::boundaries::Region;

/// The engine's form of a region; none where a mesh in it is wrong.
pub(crate) fn region(
    region: &SceneRegion,
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<Region> {
    let mut all = |parts: &[SceneRegion]| -> Option<Vec<Region>> {
        let parts = parts
            .iter()
            .map(|part| self::region(part, warnings, errors));
        // All of them, so that every problem is reported.
        parts.collect::<Vec<_>>().into_iter().collect()
    };
    Some(match region {
        SceneRegion::Box { min, max } => Region::Box {
            min: **min,
            max: **max,
        },
        SceneRegion::Cylinder {
            axis,
            origin,
            radius,
            along,
        } => Region::Cylinder {
            axis: **axis,
            origin: **origin,
            radius: **radius,
            along: along
                .as_deref()
                .copied()
                .unwrap_or([f64::NEG_INFINITY, f64::INFINITY]),
        },
        SceneRegion::Sphere { origin, radius } => Region::Sphere {
            origin: **origin,
            radius: **radius,
        },
        SceneRegion::Cone {
            axis,
            origin,
            along,
            radii,
        } => Region::Cone {
            axis: **axis,
            origin: **origin,
            along: **along,
            radii: **radii,
        },
        SceneRegion::HalfSpace { point, normal } => Region::HalfSpace {
            point: **point,
            normal: **normal,
        },
        SceneRegion::Union(parts) => Region::Union(all(parts)?),
        SceneRegion::Intersection(parts) => Region::Intersection(all(parts)?),
        SceneRegion::Difference(parts) => Region::Difference(all(parts)?),
        SceneRegion::Mesh(source) => match meshes::solid(source, warnings) {
            Ok(solid) => Region::Mesh(Arc::new(solid)),
            Err(error) => {
                errors.push(error);
                return None;
            }
        },
    })
}
