//! The cylinder.

use crate::walls::axis::Axis;
use crate::walls::error::{WallError, interval, positive};
use crate::walls::pose::Pose;
use crate::walls::revolved::Revolved;
use crate::walls::side::Side;
use crate::walls::symmetry;
use crate::walls::touch::{Touch, Touches, Turning};
use glam::{DVec2, DVec3};
use mercury_common::surfaces::Surface;

/// A cylindrical shell, endless or cut off. Features of an endless one: 0 the face, 1 the outer face
/// of [`Side::Both`]; of a bounded one: 0 the face, 1 and 2 the rims at its beginning and end, 3 the
/// outer face of [`Side::Both`].
#[derive(Debug, Clone, PartialEq)]
pub struct Cylinder(Extent);

#[derive(Debug, Clone, PartialEq)]
enum Extent {
    Endless { axis: Axis, radius: f64, side: Side },
    Bounded(Revolved),
}

impl Cylinder {
    /// The shell of `radius` (m) about the line through `origin` (m) along `axis` (any length), either
    /// endless or between two distances (m) from the origin along the axis.
    ///
    /// # Errors
    /// If the axis is no direction, a number is not finite, the radius is not positive, or `along`
    /// doesn't increase.
    pub fn new(
        axis: DVec3,
        origin: DVec3,
        radius: f64,
        along: Option<[f64; 2]>,
        side: Side,
    ) -> Result<Self, WallError> {
        let radius = positive("radius", radius)?;
        Ok(Self(match along {
            None => Extent::Endless {
                axis: Axis::new(axis, origin)?,
                radius,
                side,
            },
            Some(along) => {
                let [from, to] = interval("along", along)?;
                let profile = [[radius, from], [radius, to]];
                Extent::Bounded(Revolved::new(axis, origin, &profile, side)?)
            }
        }))
    }

    /// The direction of its axis, of length 1.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        match &self.0 {
            Extent::Endless { axis, .. } => axis.direction,
            Extent::Bounded(revolved) => revolved.direction(),
        }
    }

    /// This cylinder without ends.
    #[must_use]
    pub fn endless(&self) -> Self {
        match &self.0 {
            Extent::Endless { .. } => self.clone(),
            Extent::Bounded(revolved) => Self(Extent::Endless {
                axis: revolved.axis().clone(),
                radius: revolved.widest(),
                side: revolved.side(),
            }),
        }
    }

    pub(super) fn side(&self) -> Side {
        match &self.0 {
            Extent::Endless { side, .. } => *side,
            Extent::Bounded(revolved) => revolved.side(),
        }
    }

    #[inline]
    pub(super) fn touches(&self, centre: DVec3, reach: f64, out: &mut Touches) {
        match &self.0 {
            Extent::Bounded(revolved) => revolved.touches(centre, reach, out),
            Extent::Endless { axis, radius, side } => {
                let (point, outward) = axis.half_plane(centre);
                let height = radius - point.x;
                if height.abs() >= reach {
                    return;
                }
                let (distance, sign, feature) = match side {
                    Side::Inside => (height, -1.0, 0),
                    Side::Outside => (-height, 1.0, 0),
                    Side::Both if height >= 0.0 => (height, -1.0, 0),
                    Side::Both => (-height, 1.0, 1),
                };
                out.push(Touch {
                    distance,
                    normal: outward * sign,
                    feature,
                    curvature: [0.0, sign / radius],
                    turning: Turning {
                        along: axis.direction,
                        rates: [0.0, if point.x > 0.0 { sign / point.x } else { 0.0 }],
                    },
                });
            }
        }
    }

    /// Whether a place is closer than `reach` (m) to the surface.
    pub(super) fn is_near(&self, centre: DVec3, reach: f64) -> bool {
        match &self.0 {
            Extent::Bounded(revolved) => revolved.is_near(centre, reach),
            Extent::Endless { axis, radius, .. } => {
                (radius - axis.half_plane(centre).0.x).abs() < reach
            }
        }
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        match &self.0 {
            Extent::Bounded(revolved) => revolved.numbers(),
            Extent::Endless { axis, radius, .. } => [axis.numbers(), vec![*radius]].concat(),
        }
    }

    pub(super) fn with_numbers(&self, numbers: &[f64]) -> Option<Self> {
        Some(Self(match &self.0 {
            Extent::Bounded(revolved) => Extent::Bounded(revolved.with_numbers(numbers)?),
            Extent::Endless { side, .. } => {
                let (axis, rest) = Axis::from_numbers(numbers)?;
                let (&[radius], side) = (rest, *side) else {
                    return None;
                };
                Extent::Endless { axis, radius, side }
            }
        }))
    }

    /// See [`super::Shape::way_to`].
    pub(super) fn way_to(&self, other: &Self) -> Option<f64> {
        match (&self.0, &other.0) {
            (Extent::Bounded(one), Extent::Bounded(other)) => one.way_to(other),
            (
                Extent::Endless { axis, radius, side },
                Extent::Endless {
                    axis: new_axis,
                    radius: new_radius,
                    side: new_side,
                },
            ) if side == new_side => {
                let across = axis.shift(new_axis).map_or(f64::INFINITY, |shift| shift.y);
                Some(across + (radius - new_radius).abs())
            }
            _ => None,
        }
    }

    /// See [`super::Shape::scale`].
    pub(super) fn scale(&self) -> f64 {
        match &self.0 {
            Extent::Bounded(revolved) => revolved.scale(),
            Extent::Endless { axis, radius, .. } => axis.origin.abs().max_element() + radius,
        }
    }

    pub(super) fn outline(&self) -> Surface {
        match &self.0 {
            Extent::Bounded(revolved) => revolved.outline(),
            Extent::Endless { axis, radius, .. } => {
                axis.outline(vec![DVec2::new(*radius, 0.0)], true)
            }
        }
    }

    pub(super) fn adjacent(&self, a: u32, b: u32) -> bool {
        match &self.0 {
            Extent::Bounded(revolved) => revolved.adjacent(a, b),
            Extent::Endless { .. } => false,
        }
    }

    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        match &self.0 {
            Extent::Bounded(revolved) => revolved.bounds(),
            Extent::Endless { axis, radius, .. } => {
                let (mut min, mut max) = axis.ring_bounds(*radius, 0.0);
                for i in 0..3 {
                    if axis.direction[i] != 0.0 {
                        min[i] = f64::NEG_INFINITY;
                        max[i] = f64::INFINITY;
                    }
                }
                (min, max)
            }
        }
    }

    pub(super) fn displacement(&self, from: &Pose, to: &Pose, about: DVec3, reach: f64) -> f64 {
        match &self.0 {
            Extent::Bounded(revolved) => revolved.displacement(from, to, about, reach),
            Extent::Endless { axis, .. } => {
                let line = (axis.origin, axis.direction);
                symmetry::of_axis(from, to, line, true, about, reach)
            }
        }
    }
}
