//! Films of walls: over which area each is spread at the start.

use mercury_common::scene::{Scene, Shape as SceneShape, Wall as SceneWall};

use crate::plan::wall_shapes::area;
use mercury_engine::walls::{Shape, Wall, WallFilmPlan};

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
