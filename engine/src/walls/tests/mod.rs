//! Tests of the module as a whole: the query of all shapes, their displacement bounds, and motions.

mod corners;
mod displacement;
mod images;
mod meshes;
mod motion;
mod motion_table;
mod periodic;
mod random;
mod reshape;
mod surfaces;

use super::{Shape, Touch, Touches};
use glam::DVec3;

/// All touches of a shape, as a vector.
fn touches(shape: &Shape, centre: DVec3, reach: f64) -> Vec<Touch> {
    let mut out = Touches::new();
    shape.touches(centre, reach, &mut out);
    out.iter().copied().collect()
}

/// The touch that is nearest to the surface, on either side, of all there are.
fn nearest(shape: &Shape, centre: DVec3) -> Touch {
    touches(shape, centre, 1e6)
        .into_iter()
        .min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))
        .expect("a wall is somewhere")
}
