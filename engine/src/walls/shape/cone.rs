//! The cone, or a part of one.

use crate::walls::error::{WallError, interval, not_negative, positive};
use crate::walls::revolved::Revolved;
use crate::walls::side::Side;
use glam::DVec3;

/// A conical shell. Features: 0 the face, 1 and 2 the rims (or the tip) at its beginning and end, 3
/// the outer face of [`Side::Both`].
#[derive(Debug, Clone, PartialEq)]
pub struct Cone(pub(super) Revolved);

impl Cone {
    /// The shell between the distances `along[0] < along[1]` (m) from `origin` along `axis` (any
    /// length), with `radii` (m) at these two places.
    ///
    /// # Errors
    /// If the axis is no direction, a number is not finite, `along` doesn't increase, a radius is
    /// negative, or both are zero.
    pub fn new(
        axis: DVec3,
        origin: DVec3,
        along: [f64; 2],
        radii: [f64; 2],
        side: Side,
    ) -> Result<Self, WallError> {
        let along = interval("along", along)?;
        for radius in radii {
            not_negative("radii", radius)?;
        }
        positive("radii", radii[0].max(radii[1]))?;
        let profile = [[radii[0], along[0]], [radii[1], along[1]]];
        Ok(Self(Revolved::new(axis, origin, &profile, side)?))
    }
}
