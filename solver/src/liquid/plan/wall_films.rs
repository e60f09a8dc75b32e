//! Films of walls: over which area each is spread at the start.

use std::f64::consts::PI;

use glam::DVec3;
use mercury_common::scene::{Domain, Scene, Shape as SceneShape, Wall as SceneWall};

use mercury_engine::walls::{SectionBox, Shape, Wall, WallFilmPlan, plane_section};

/// The films of all walls, in their order; empty where none has one.
pub(crate) fn wall_films(scene: &Scene, walls: &[Wall]) -> Vec<Option<WallFilmPlan>> {
    if scene.walls.iter().all(|wall| wall.film.is_none()) {
        return Vec::new();
    }
    let of_wall = |wall: &Wall| {
        let is_of = |scene: &&SceneWall| match scene.shape {
            // Faces are walls of their own.
            SceneShape::Box { .. } => (wall.name.strip_prefix(&*scene.name.value))
                .is_some_and(|face| face.starts_with('.')),
            _ => wall.name == scene.name.value,
        };
        let typed = scene.walls.iter().find(is_of)?;
        let film = typed.film.as_ref()?;
        let areas = match &wall.shape {
            Shape::Mesh(mesh) => mesh.areas(),
            shape => vec![area(shape, &typed.shape, &scene.domain)],
        };
        let volumes = areas.iter().map(|area| area * *film.thickness).collect();
        Some(WallFilmPlan {
            areas,
            volumes,
            keeps: *film.keeps,
        })
    };
    walls.iter().map(of_wall).collect()
}

/// Area of a shape that is no mesh, m^2; of one without an end the part within the domain.
fn area(shape: &Shape, typed: &SceneShape, domain: &Domain) -> f64 {
    let (min, max) = (*domain.min, *domain.max);
    match typed {
        SceneShape::Box { .. } | SceneShape::Plane { .. } => match shape {
            Shape::Plane(plane) => {
                let room = SectionBox::new(min, max, 3);
                plane_section(plane.point(), plane.normal(), &room)
            }
            _ => 0.0,
        },
        SceneShape::Disc { radius, .. } => PI * **radius * **radius,
        SceneShape::Cylinder {
            axis,
            origin,
            radius,
            along,
            ..
        } => {
            let length = along.as_deref().map_or_else(
                || length_within(**origin, axis.normalize(), min, max),
                |[from, to]| to - from,
            );
            2.0 * PI * **radius * length
        }
        SceneShape::Cone { along, radii, .. } => {
            frustum([[radii[0], along[0]], [radii[1], along[1]]])
        }
        SceneShape::Sphere { radius, .. } => 4.0 * PI * **radius * **radius,
        SceneShape::Revolution { profile, .. } => profile
            .windows(2)
            .map(|two| frustum([two[0], two[1]]))
            .sum(),
        SceneShape::Mesh { .. } => 0.0,
    }
}

/// Lateral area of a frustum between two points (r, z), m^2.
fn frustum([[r0, z0], [r1, z1]]: [[f64; 2]; 2]) -> f64 {
    PI * (r0 + r1) * libm::hypot(r1 - r0, z1 - z0)
}

/// The length of a line within a box, m.
fn length_within(point: DVec3, direction: DVec3, min: DVec3, max: DVec3) -> f64 {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        if direction[axis] == 0.0 {
            continue;
        }
        let ends = [min, max].map(|corner| (corner[axis] - point[axis]) / direction[axis]);
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    (to - from).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_in_a_box_and_frusta() {
        let (min, max) = (DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
        let close = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        };
        close(length_within(DVec3::splat(0.5), DVec3::Y, min, max), 2.0);
        close(
            length_within(DVec3::ZERO, max.normalize(), min, max),
            max.length(),
        );
        close(frustum([[1.0, 0.0], [1.0, 2.0]]), 4.0 * PI);
        close(frustum([[0.0, 0.0], [3.0, 4.0]]), 15.0 * PI);
    }
}
