//! A profile turned about an axis: what discs, cones, bounded cylinders and revolutions share.

use super::axis::Axis;
use super::error::WallError;
use super::pose::Pose;
use super::profile::Profile;
use super::side::Side;
use super::symmetry;
use super::touch::{Touch, Touches, Turning};
use glam::DVec3;
use mercury_common::surfaces::Surface;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Revolved {
    axis: Axis,
    profile: Profile,
}

impl Revolved {
    pub(super) fn new(
        axis: DVec3,
        origin: DVec3,
        profile: &[[f64; 2]],
        side: Side,
    ) -> Result<Self, WallError> {
        Ok(Self {
            axis: Axis::new(axis, origin)?,
            profile: Profile::new(profile, side)?,
        })
    }

    /// Largest distance of the profile's corners from the axis, m.
    pub(super) fn widest(&self) -> f64 {
        self.profile.widest()
    }

    pub(super) fn axis(&self) -> &Axis {
        &self.axis
    }

    /// Direction of length 1, along the axis.
    pub(super) fn direction(&self) -> DVec3 {
        self.axis.direction
    }

    #[inline]
    pub(super) fn touches(&self, centre: DVec3, reach: f64, out: &mut Touches) {
        let (point, outward) = self.axis.half_plane(centre);
        self.profile.near(point, reach, |near| {
            // The circle of latitude bends about the axis; only the part of its curvature that is
            // normal to the surface counts (Meusnier). At a tip on the axis it is not defined.
            let curvature = if near.foot_radius > 0.0 && near.foot_radius.is_finite() {
                near.normal.x / near.foot_radius
            } else {
                0.0
            };
            out.push(Touch {
                distance: near.distance,
                normal: outward * near.normal.x + self.axis.direction * near.normal.y,
                feature: near.feature,
                curvature: [0.0, curvature],
                turning: Turning {
                    along: self.axis.direction.cross(outward),
                    rates: [
                        if point.x > 0.0 {
                            near.normal.x / point.x
                        } else {
                            0.0
                        },
                        near.turning,
                    ],
                },
            });
        });
    }

    pub(super) fn side(&self) -> Side {
        self.profile.side()
    }

    /// Whether a place is closer than `reach` (m) to the surface.
    pub(super) fn is_near(&self, centre: DVec3, reach: f64) -> bool {
        self.profile.is_near(self.axis.half_plane(centre).0, reach)
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        [self.axis.numbers(), self.profile.numbers()].concat()
    }

    pub(super) fn with_numbers(&self, numbers: &[f64]) -> Option<Self> {
        let (axis, rest) = Axis::from_numbers(numbers)?;
        let profile = self.profile.with_numbers(rest)?;
        Some(Self { axis, profile })
    }

    /// See [`super::Shape::way_to`].
    pub(super) fn way_to(&self, other: &Self) -> Option<f64> {
        let in_profile = self.profile.way_to(&other.profile)?;
        let shift = self.axis.shift(&other.axis);
        Some(shift.map_or(f64::INFINITY, |shift| shift.length() + in_profile))
    }

    /// See [`super::Shape::scale`].
    pub(super) fn scale(&self) -> f64 {
        self.axis.origin.abs().max_element() + self.profile.scale()
    }

    pub(super) fn outline(&self) -> Surface {
        let mut corners: Vec<_> = self.profile.points().collect();
        if self.profile.is_closed() {
            corners.extend(corners.first().copied());
        }
        self.axis.outline(corners, false)
    }

    pub(super) fn adjacent(&self, a: u32, b: u32) -> bool {
        self.profile.adjacent(a, b)
    }

    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let mut min = DVec3::INFINITY;
        let mut max = DVec3::NEG_INFINITY;
        for point in self.profile.points() {
            let (low, high) = self.axis.ring_bounds(point.x, point.y);
            min = min.min(low);
            max = max.max(high);
        }
        (min, max)
    }

    pub(super) fn displacement(&self, from: &Pose, to: &Pose, about: DVec3, reach: f64) -> f64 {
        let axis = (self.axis.origin, self.axis.direction);
        symmetry::of_axis(from, to, axis, false, about, reach)
    }
}
