//! The directions of a camera.

use glam::DVec3;

use crate::frame::Frame;
use crate::options::View;

/// Right, up and ahead (away from the eye), of unit length and at right angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axes {
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) ahead: DVec3,
}

impl Axes {
    pub(crate) fn new(frame: &Frame, view: View) -> Self {
        if frame.flat {
            return Self {
                right: DVec3::X,
                up: DVec3::Y,
                ahead: -DVec3::Z,
            };
        }
        let zenith = frame.up();
        // Level axes: x where it can be, so that the reader finds it pointing right.
        let level = |axis: DVec3| (axis - axis.dot(zenith) * zenith).try_normalize();
        let east = if zenith.x.abs() < 0.99 {
            level(DVec3::X)
        } else {
            level(DVec3::Y)
        }
        .unwrap_or(DVec3::X);
        let north = zenith.cross(east);
        let (turn_sin, turn_cos) = sin_cos(view.azimuth);
        let (tilt_sin, tilt_cos) = sin_cos(view.elevation);
        let level_ahead = turn_cos * north - turn_sin * east;
        let right = turn_cos * east + turn_sin * north;
        let ahead = tilt_cos * level_ahead - tilt_sin * zenith;
        Self {
            right,
            up: right.cross(ahead),
            ahead,
        }
    }

    /// Coordinates along right, up and ahead.
    pub(crate) fn coordinates(&self, point: DVec3) -> DVec3 {
        DVec3::new(
            point.dot(self.right),
            point.dot(self.up),
            point.dot(self.ahead),
        )
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90: a named view shows axes as points, not slivers.
fn sin_cos(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn named_views_look_where_they_say() {
        let frame = Frame::default();
        for (view, right, up) in [
            (View::FRONT, DVec3::X, DVec3::Z),
            (View::RIGHT, DVec3::Y, DVec3::Z),
            (View::BACK, -DVec3::X, DVec3::Z),
            (View::LEFT, -DVec3::Y, DVec3::Z),
            (View::TOP, DVec3::X, DVec3::Y),
            (View::BOTTOM, DVec3::X, -DVec3::Y),
        ] {
            let axes = Axes::new(&frame, view);
            assert_eq!((axes.right, axes.up), (right, up), "{view:?}");
        }
        let axes = Axes::new(&frame, View::ISO);
        for axis in DVec3::AXES {
            // All three axes are shortened by sqrt(2/3).
            let seen = axes.coordinates(axis).truncate().length();
            assert!((seen - (2.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        }
    }

    proptest! {
        #[test]
        fn axes_are_orthonormal(azimuth in -400.0..400.0f64, elevation in -90.0..90.0f64, gravity in any::<[f64; 3]>()) {
            let frame = Frame { gravity: DVec3::from_array(gravity), ..Frame::default() };
            let Axes { right, up, ahead } = Axes::new(&frame, View::new(azimuth, elevation));
            for (a, b, expected) in [(right, right, 1.0), (up, up, 1.0), (ahead, ahead, 1.0), (right, up, 0.0), (up, ahead, 0.0)] {
                prop_assert!((a.dot(b) - expected).abs() < 1e-9);
            }
        }
    }
}
