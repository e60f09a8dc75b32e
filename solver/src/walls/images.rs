//! By which periodic images of a particle a wall is met.

use glam::DVec3;

use super::{Shape, Wall, WallState};
use crate::neighbours::{Images, NO_SHIFT};

/// Codes of the images by which a wall is met: by all that the domain has, but not along axes of which it spans a period.
#[must_use]
pub fn images_met(wall: &Wall, images: &Images) -> Vec<u32> {
    let (low, high) = wall.shape.bounds();
    let spans = |axis: usize| {
        let continued = match &wall.shape {
            Shape::Mesh(mesh) => mesh.periods().iter().any(|period| period.axis == axis),
            _ => false,
        };
        continued || high[axis] - low[axis] >= images.size[axis] * (1.0 - 1e-9)
    };
    let met = |code: &u32| {
        let shift = images.shift(*code);
        (0..3).all(|axis| shift[axis] == 0.0 || !spans(axis))
    };
    std::iter::once(NO_SHIFT)
        .chain(images.neighbours().filter(met))
        .collect()
}

/// The image of a particle at `position` (m) that is between the faces of a mesh that goes on for ever, of those that differ from
/// the image `code` along its axes only; of other walls `code` itself.
#[must_use]
pub fn image_between_faces(
    wall: &Wall,
    state: &WallState,
    images: &Images,
    position: DVec3,
    code: u32,
) -> u32 {
    let Shape::Mesh(mesh) = &wall.shape else {
        return code;
    };
    if mesh.periods().is_empty() {
        return code;
    }
    // Motion leaves these axes where they are.
    let place = state.into_wall(position + images.shift(code));
    mesh.periods().iter().fold(code, |code, period| {
        Images::moved(code, period.axis, period.into_base(place[period.axis]))
    })
}
