//! By which periodic images of a particle a wall is met.

use glam::DVec3;

use super::{Shape, WallState};
use crate::neighbours::{Images, NO_SHIFT};

/// Codes of the images by which a surface is met: by all that the domain has, but not along axes of which it spans a period.
pub(super) fn images_met(shape: &Shape, images: &Images) -> Vec<u32> {
    let (low, high) = shape.bounds();
    let spans = |axis: usize| {
        let continued = match shape {
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

/// The codes of the images between which [`image_between_faces`] chooses.
pub(super) fn periods_along(
    shape: &Shape,
    images: &Images,
    code: u32,
) -> impl Iterator<Item = u32> {
    let continued = |axis: usize| match shape {
        Shape::Mesh(mesh) => mesh.periods().iter().any(|period| period.axis == axis),
        _ => false,
    };
    let goes_on = [0, 1, 2].map(continued);
    let shift = images.shift(code);
    // The code itself goes along no axis along which the mesh goes on.
    let all = images.neighbours().filter(move |&other| {
        let way = images.shift(other);
        goes_on.contains(&true) && (0..3).all(|axis| goes_on[axis] || way[axis] == shift[axis])
    });
    std::iter::once(code).chain(all)
}

/// The image of a particle at `position` (m) that is between the faces of a mesh that goes on for ever, of those that differ from
/// the image `code` along its axes only; of other walls `code` itself.
#[inline]
pub(super) fn image_between_faces(
    shape: &Shape,
    state: &WallState,
    images: &Images,
    position: DVec3,
    code: u32,
) -> u32 {
    let Shape::Mesh(mesh) = shape else {
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
