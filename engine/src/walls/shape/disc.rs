//! The disc: a thin round plate.

use crate::walls::error::{WallError, positive};
use crate::walls::revolved::Revolved;
use crate::walls::side::Side;
use glam::DVec3;

/// A thin round plate that pushes away on both sides. Features: 0 the face towards `axis`, 2 the rim,
/// 3 the other face.
#[derive(Debug, Clone, PartialEq)]
pub struct Disc(pub(super) Revolved);

impl Disc {
    /// The disc of `radius` (m) about `origin` (m), normal to `axis` (any length).
    ///
    /// # Errors
    /// If the axis is no direction, the origin not finite, or the radius not finite and positive.
    pub fn new(axis: DVec3, origin: DVec3, radius: f64) -> Result<Self, WallError> {
        let radius = positive("radius", radius)?;
        let profile = [[0.0, 0.0], [radius, 0.0]];
        Ok(Self(Revolved::new(axis, origin, &profile, Side::Both)?))
    }

    /// m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.0.widest()
    }

    /// The direction that it is normal to, of length 1.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        self.0.direction()
    }
}
