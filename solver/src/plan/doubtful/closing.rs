//! Walls that act on both sides and move through the region of an insertion: particles may be placed behind them.

use super::Finding;
use crate::plan::Plan;
use mercury_engine::walls::Shape;

/// A warning for each insertion and wall.
pub(super) fn walls_that_close_over_insertions(plan: &Plan) -> Vec<Finding> {
    let physics = plan.physics();
    let insertions = physics.insertions.iter();
    let pairs = insertions.flat_map(|insertion| {
        let walls = insertion.closing.iter();
        walls.map(move |&wall| (insertion, &physics.walls[wall]))
    });
    pairs
        .map(|(insertion, wall)| {
            let way_out = match wall.shape {
                Shape::Mesh(_) => "give it side = \"front\", the side to which the normals of its triangles point, so that nothing is placed behind it; or use a plane",
                _ => "use a plane, behind which nothing is placed",
            };
            Finding::Warning(format!(
                "walls.{}: it acts on both sides and moves through the region of \"{}\" while that inserts, so that particles are placed behind it too; {way_out}; or end the insertion before (`until`)",
                wall.name, insertion.name
            ))
        })
        .collect()
}
