//! Motions given as a table of time, and the CSV file that holds one.

#![allow(
    clippy::result_large_err,
    reason = "a file is read once; the error type is shared by all readers"
)]

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::formats::time_table::{TimeRow, TimeTable};
use std::path::Path;

/// The columns, in the order in which [`Row`] takes them; the last three may be missing together.
const COLUMNS: TimeTable<'_, 7> = TimeTable {
    names: ["t", "x", "y", "z", "angle_x", "angle_y", "angle_z"],
    required: 4,
    equal_times: false,
};

/// Where the wall is at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// In s.
    pub time: f64,
    /// In m, from where the scene puts the wall.
    pub displacement: DVec3,
    /// Axis times angle of the turn from where the scene puts the wall, in rad.
    pub rotation_vector: DVec3,
}

/// A displacement and a rotation vector that change linearly between the rows and keep the values of
/// the first and the last row outside them.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionTable {
    /// Never empty; times strictly increasing; all numbers finite.
    rows: Vec<Row>,
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
        Ok(Self::of(COLUMNS.read(path)?))
    }

    /// As [`MotionTable::read`], from the content of a file; `path` is for the error messages.
    ///
    /// # Errors
    /// As for [`MotionTable::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, FormatError> {
        Ok(Self::of(COLUMNS.parse(path, text)?))
    }

    fn of(rows: Vec<TimeRow<7>>) -> Self {
        let row = |TimeRow { values: v, .. }: TimeRow<7>| Row {
            time: v[0],
            displacement: DVec3::new(v[1], v[2], v[3]),
            rotation_vector: DVec3::new(v[4], v[5], v[6]),
        };
        Self {
            rows: rows.into_iter().map(row).collect(),
        }
    }

    /// The rows, in the order of time.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Whether the table never moves anything.
    pub(super) fn is_zero(&self) -> bool {
        self.rows
            .iter()
            .all(|r| r.displacement == DVec3::ZERO && r.rotation_vector == DVec3::ZERO)
    }

    /// The rotation vectors of the rows, rad.
    pub(super) fn turns(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.rows.iter().map(|row| row.rotation_vector)
    }

    /// Displacement and rotation vector at `time`.
    pub(super) fn at(&self, time: f64) -> (DVec3, DVec3) {
        match self.piece(time) {
            Piece::Held(row) => (row.displacement, row.rotation_vector),
            Piece::Between(a, b) => {
                let s = (time - a.time) / (b.time - a.time);
                (
                    a.displacement + (b.displacement - a.displacement) * s,
                    a.rotation_vector + (b.rotation_vector - a.rotation_vector) * s,
                )
            }
        }
    }

    /// Velocity of the point about which the table turns, and angular velocity.
    ///
    /// A rotation vector `p` that changes at the rate `p'` means the angular velocity
    /// `p' + (1 - cos a)/a^2 p x p' + (a - sin a)/a^3 p x (p x p')` with `a = |p|`, the left Jacobian
    /// of the rotation group applied to `p'`; it is `p'` only while the axis keeps its direction.
    pub(super) fn velocity(&self, time: f64) -> (DVec3, DVec3) {
        match self.piece(time) {
            Piece::Held(_) => (DVec3::ZERO, DVec3::ZERO),
            Piece::Between(a, b) => {
                let duration = b.time - a.time;
                let rate = (b.rotation_vector - a.rotation_vector) / duration;
                let (_, p) = self.at(time);
                let (first, second) = left_jacobian(p.length());
                let once = p.cross(rate);
                (
                    (b.displacement - a.displacement) / duration,
                    rate + once * first + p.cross(once) * second,
                )
            }
        }
    }

    /// Limits that the motion reaches until `end`.
    pub(super) fn limits(&self, end: f64) -> Limits {
        let mut limits = Limits {
            speed: 0.0,
            angular_speed: 0.0,
            displacement: 0.0,
            turns: false,
        };
        let mut rows_until = 0;
        for (i, row) in self.rows.iter().enumerate() {
            // The row after `end` bounds what the linear motion towards it reaches.
            if i > 0 && self.rows[i - 1].time >= end {
                break;
            }
            rows_until = i + 1;
            limits.displacement = limits.displacement.max(row.displacement.length());
            limits.turns |= row.rotation_vector != DVec3::ZERO;
        }
        for pair in self.rows[..rows_until].windows(2) {
            let duration = pair[1].time - pair[0].time;
            let step = pair[1].displacement - pair[0].displacement;
            limits.speed = limits.speed.max(step.length() / duration);
            // No singular value of the left Jacobian exceeds 1.
            let turn = pair[1].rotation_vector - pair[0].rotation_vector;
            limits.angular_speed = limits.angular_speed.max(turn.length() / duration);
        }
        limits
    }

    fn piece(&self, time: f64) -> Piece<'_> {
        let after = self.rows.partition_point(|row| row.time <= time);
        if after == 0 {
            Piece::Held(&self.rows[0])
        } else if after == self.rows.len() {
            Piece::Held(&self.rows[after - 1])
        } else {
            Piece::Between(&self.rows[after - 1], &self.rows[after])
        }
    }
}

enum Piece<'a> {
    Held(&'a Row),
    Between(&'a Row, &'a Row),
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
