//! The surface of revolution.

use crate::walls::error::WallError;
use crate::walls::revolved::Revolved;
use crate::walls::side::Side;
use glam::DVec3;

/// A polygon in the half-plane `(r, z)` turned about an axis: vessels, hoppers, rings.
///
/// Features of `n` pieces and `c` corners: the pieces `0..n` in the order of the profile, its corners
/// `n..n + c`, and for [`Side::Both`] the other faces of the pieces `n + c..2 n + c`.
#[derive(Debug, Clone, PartialEq)]
pub struct Revolution(pub(super) Revolved);

impl Revolution {
    /// The surface that `profile`, points `(r, z)` in m with `r >= 0` and `z` along `axis` from
    /// `origin`, draws when it turns about the axis. The profile is closed if its last point is its
    /// first.
    ///
    /// The inside is what lies between the profile and the axis (within the polygon, for a closed
    /// one), in whichever direction the points are listed; so it is above the floor and within the
    /// mantle of a vessel. A profile that encloses nothing with the axis (a flat annulus) has its
    /// inside to the left of its direction, with `r` to the right and `z` up: listed outwards, it is
    /// the side towards `axis`.
    ///
    /// # Errors
    /// If the axis is no direction, a number is not finite, or the profile has fewer than two points,
    /// a negative radius, a repeated point, a piece on the axis, or touches itself.
    pub fn new(
        axis: DVec3,
        origin: DVec3,
        profile: &[[f64; 2]],
        side: Side,
    ) -> Result<Self, WallError> {
        Ok(Self(Revolved::new(axis, origin, profile, side)?))
    }
}
