//! Motions given as a table of time, and the CSV file that holds one.

#![allow(
    clippy::result_large_err,
    reason = "a file is read once; the error type is shared by all readers"
)]

use glam::DVec3;
use mercury_common::error::FormatError;
use std::path::Path;

/// The columns, in the order in which [`Row`] takes them; the last three may be missing together.
const COLUMNS: [&str; 7] = ["t", "x", "y", "z", "angle_x", "angle_y", "angle_z"];
const REQUIRED: usize = 4;
const EXPECTED_HEADER: &str = "the columns t,x,y,z or t,x,y,z,angle_x,angle_y,angle_z";

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
    /// Reads a CSV file: a header with the columns `t,x,y,z` (s, m) and, if the wall turns,
    /// `angle_x,angle_y,angle_z` (rad), in any order; then one row per time. Empty lines and lines that
    /// begin with `#` are skipped.
    ///
    /// # Errors
    /// If the file cannot be read, a column is missing, unknown or doubled, a row has too few or too
    /// many fields, a field is no finite number, the times do not increase, or there is no row.
    pub fn read(path: &Path) -> Result<Self, FormatError> {
        let bytes = std::fs::read(path)
            .map_err(|e| FormatError::of_file(path, format!("the file cannot be read: {e}")))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let line = 1 + e.as_bytes()[..e.utf8_error().valid_up_to()]
                .iter()
                .filter(|&&b| b == b'\n')
                .count();
            FormatError::at(
                path,
                line,
                None,
                "bytes that are no UTF-8 text",
                "a CSV file",
            )
        })?;
        Self::parse(path, &text)
    }

    /// As [`MotionTable::read`], from the content of a file; `path` is for the error messages.
    ///
    /// # Errors
    /// As for [`MotionTable::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, FormatError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(i, line)| (i + 1, line))
            .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
        let Some((number, header)) = lines.next() else {
            return Err(FormatError {
                expected: EXPECTED_HEADER.into(),
                ..FormatError::of_file(path, "no header")
            });
        };
        let columns = read_header(path, number, header)?;

        let mut rows: Vec<Row> = Vec::new();
        for (number, line) in lines {
            let (row, time_column) = read_row(path, number, line, &columns)?;
            if let Some(before) = rows.last()
                && row.time <= before.time
            {
                return Err(FormatError::at(
                    path,
                    number,
                    Some(time_column),
                    format!("t = {}", row.time),
                    format!("a time after that of the row before, {}", before.time),
                ));
            }
            rows.push(row);
        }
        if rows.is_empty() {
            return Err(FormatError {
                expected: "at least one row below the header".into(),
                ..FormatError::of_file(path, "no rows")
            });
        }
        Ok(Self { rows })
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

/// The fields of a line with the columns (characters from 1) in which they begin.
fn fields(line: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut column = 1;
    line.split(',').map(move |raw| {
        let text = raw.trim();
        let blank = raw.len() - raw.trim_start().len();
        let begin = column + raw[..blank].chars().count();
        column += raw.chars().count() + 1;
        (begin, text)
    })
}

/// For each field of a row, which of [`COLUMNS`] it is.
fn read_header(path: &Path, number: usize, header: &str) -> Result<Vec<usize>, FormatError> {
    let mut columns = Vec::new();
    for (begin, name) in fields(header) {
        let wrong =
            |found: String| FormatError::at(path, number, Some(begin), found, EXPECTED_HEADER);
        let Some(column) = COLUMNS.iter().position(|&known| known == name) else {
            return Err(wrong(format!("the column \"{name}\"")));
        };
        if columns.contains(&column) {
            return Err(wrong(format!("the column \"{name}\" a second time")));
        }
        columns.push(column);
    }
    let turns = columns.iter().any(|&column| column >= REQUIRED);
    let needed = if turns { COLUMNS.len() } else { REQUIRED };
    for (column, name) in COLUMNS.iter().enumerate().take(needed) {
        if !columns.contains(&column) {
            let found = format!("no column \"{name}\"");
            return Err(FormatError::at(path, number, None, found, EXPECTED_HEADER));
        }
    }
    Ok(columns)
}

/// The row of a line, and where its time stands.
fn read_row(
    path: &Path,
    number: usize,
    line: &str,
    columns: &[usize],
) -> Result<(Row, usize), FormatError> {
    let mut values = [0.0; COLUMNS.len()];
    let mut time_column = 1;
    let mut count = 0;
    for (begin, text) in fields(line) {
        let Some(&column) = columns.get(count) else {
            let expected = format!("{} fields, as in the header", columns.len());
            let found = format!("one more field, \"{text}\"");
            return Err(FormatError::at(path, number, Some(begin), found, expected));
        };
        let value = text.parse().ok().filter(|value: &f64| value.is_finite());
        let Some(value) = value else {
            let found = format!("\"{text}\" in column {}", COLUMNS[column]);
            return Err(FormatError::at(
                path,
                number,
                Some(begin),
                found,
                "a finite number",
            ));
        };
        if column == 0 {
            time_column = begin;
        }
        values[column] = value;
        count += 1;
    }
    if count < columns.len() {
        let found = format!("{count} fields");
        let expected = format!("{}, as in the header", columns.len());
        return Err(FormatError::at(path, number, None, found, expected));
    }
    let row = Row {
        time: values[0],
        displacement: DVec3::new(values[1], values[2], values[3]),
        rotation_vector: DVec3::new(values[4], values[5], values[6]),
    };
    Ok((row, time_column))
}
