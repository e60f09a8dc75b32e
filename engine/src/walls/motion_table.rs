//! Motions given as a table of time, and the CSV file that holds one.

#![allow(
    clippy::result_large_err,
    reason = "a file is read once; the error type is shared by all readers"
)]

use glam::DVec3;
use mercury_common::curve::Curve;
use mercury_common::error::FormatError;
use mercury_common::formats::time_table::{TimeRow, TimeTable};
use std::path::Path;

/// The columns, in the order in which `MotionTable::of` takes them; the last three may be missing together.
const COLUMNS: TimeTable<'_, 7> = TimeTable {
    names: ["t", "x", "y", "z", "angle_x", "angle_y", "angle_z"],
    required: 4,
    equal_times: false,
};

/// A displacement and a rotation vector that change linearly between the rows and keep the values of
/// the first and the last row outside them.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionTable {
    /// In m, from where the scene puts the wall.
    displacement: Curve<DVec3>,
    /// Axis times angle of the turn from where the scene puts the wall, in rad.
    rotation_vector: Curve<DVec3>,
}

/// Limits that a table reaches until some time.
pub(super) struct Limits {
    pub(super) speed: f64,
    pub(super) angular_speed: f64,
    pub(super) displacement: f64,
    pub(super) turns: bool,
}

impl MotionTable {
    /// Reads a [table](TimeTable) with the columns `t,x,y,z` (s, m) and, if the wall turns, `angle_x,angle_y,angle_z` (rad).
    ///
    /// # Errors
    /// If it cannot be read or is no such table.
    pub fn read(path: &Path) -> Result<Self, FormatError> {
        Ok(Self::of(&COLUMNS.read(path)?))
    }

    /// As [`MotionTable::read`], from the content of a file; `path` is for the error messages.
    ///
    /// # Errors
    /// As for [`MotionTable::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, FormatError> {
        Ok(Self::of(&COLUMNS.parse(path, text)?))
    }

    fn of(rows: &[TimeRow<7>]) -> Self {
        Self {
            displacement: Curve::of_table(rows, |v| DVec3::new(v[1], v[2], v[3])),
            rotation_vector: Curve::of_table(rows, |v| DVec3::new(v[4], v[5], v[6])),
        }
    }

    /// Displacement (m) from where the scene puts the wall.
    #[must_use]
    pub fn displacement(&self) -> &Curve<DVec3> {
        &self.displacement
    }

    /// Axis times angle of the turn (rad) from where the scene puts the wall.
    #[must_use]
    pub fn rotation_vector(&self) -> &Curve<DVec3> {
        &self.rotation_vector
    }

    /// Whether the table never moves anything.
    pub(super) fn is_zero(&self) -> bool {
        let curves = [&self.displacement, &self.rotation_vector];
        let mut rows = curves.into_iter().flat_map(Curve::rows);
        rows.all(|row| row.1 == DVec3::ZERO)
    }

    /// Velocity of the point about which the table turns, and angular velocity.
    ///
    /// A rotation vector `p` that changes at the rate `p'` means the angular velocity
    /// `p' + (1 - cos a)/a^2 p x p' + (a - sin a)/a^3 p x (p x p')` with `a = |p|`, the left Jacobian
    /// of the rotation group applied to `p'`; it is `p'` only while the axis keeps its direction.
    pub(super) fn velocity(&self, time: f64) -> (DVec3, DVec3) {
        let slopes = (
            self.displacement.slope(time),
            self.rotation_vector.slope(time),
        );
        let (Some(velocity), Some(rate)) = slopes else {
            return (DVec3::ZERO, DVec3::ZERO);
        };
        let p = self.rotation_vector.at(time);
        let (first, second) = left_jacobian(p.length());
        let once = p.cross(rate);
        (velocity, rate + once * first + p.cross(once) * second)
    }

    /// Limits that the motion reaches until `end`.
    pub(super) fn limits(&self, end: f64) -> Limits {
        // The row after `end` bounds what the linear motion towards it reaches.
        let rows = self.displacement.rows();
        let count = (rows.partition_point(|row| row.0 < end) + 1).min(rows.len());
        let [shifts, turns] =
            [&self.displacement, &self.rotation_vector].map(|curve| &curve.rows()[..count]);
        // No singular value of the left Jacobian exceeds 1.
        Limits {
            speed: largest_slope(shifts),
            angular_speed: largest_slope(turns),
            displacement: shifts.iter().map(|row| row.1.length()).fold(0.0, f64::max),
            turns: turns.iter().any(|row| row.1 != DVec3::ZERO),
        }
    }
}

/// Largest magnitude of the slope between the rows.
fn largest_slope(rows: &[(f64, DVec3)]) -> f64 {
    let slopes = rows
        .windows(2)
        .map(|pair| (pair[1].1 - pair[0].1).length() / (pair[1].0 - pair[0].0));
    slopes.fold(0.0, f64::max)
}

/// `(1 - cos a)/a^2` and `(a - sin a)/a^3`.
fn left_jacobian(angle: f64) -> (f64, f64) {
    let a2 = angle * angle;
    let half_sine = libm::sin(0.5 * angle);
    // Below 0.1 the difference a - sin(a) loses digits; the series is then exact to round-off, its next
    // term being a^8/11! of the first.
    let first = if angle > 1e-4 {
        2.0 * half_sine * half_sine / a2
    } else {
        0.5 - a2 / 24.0
    };
    let second = if angle > 0.1 {
        (angle - libm::sin(angle)) / (a2 * angle)
    } else {
        1.0 / 6.0 - a2 * (1.0 / 120.0 - a2 * (1.0 / 5040.0 - a2 / 362_880.0))
    };
    (first, second)
}
