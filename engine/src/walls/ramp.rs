//! Target of a servo: a force or a pressure, constant or by a table of time.

use std::path::Path;

use mercury_common::error::FormatError;
use mercury_common::formats::time_table::TimeTable;

use super::error::{WallError, finite};

/// A number that is constant, or changes linearly between the rows of a table and keeps the values of the first and the last row outside them.
#[derive(Debug, Clone, PartialEq)]
pub struct Ramp {
    /// Times (s), strictly increasing, and values; never empty, all finite.
    rows: Vec<[f64; 2]>,
}

impl Ramp {
    /// Always `value`.
    ///
    /// # Errors
    /// If it is not finite.
    pub fn constant(value: f64) -> Result<Self, WallError> {
        Self::new(vec![[0.0, value]])
    }

    /// Through rows of time (s) and value.
    ///
    /// # Errors
    /// If there is none, a number is not finite, or the times do not increase.
    pub fn new(rows: Vec<[f64; 2]>) -> Result<Self, WallError> {
        for row in &rows {
            finite("t", row[0])?;
            finite("value", row[1])?;
        }
        if rows.is_empty() {
            return Err(WallError::NoRows);
        }
        match rows.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
            Some(pair) => Err(WallError::NotIncreasing {
                key: "t",
                from: pair[0][0],
                to: pair[1][0],
            }),
            None => Ok(Self { rows }),
        }
    }

    /// Reads a [table](TimeTable) with the columns `t` (s) and `value`.
    ///
    /// # Errors
    /// If it cannot be read or is no such table.
    #[allow(
        clippy::result_large_err,
        reason = "a file is read once; the error type is shared by all readers"
    )]
    pub fn read(path: &Path, value: &str) -> Result<Self, FormatError> {
        let rows = TimeTable::new(["t", value]).read(path)?;
        let rows = rows.into_iter().map(|row| row.values).collect();
        Ok(Self { rows })
    }

    /// The value at `time` (s).
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let after = self.rows.partition_point(|row| row[0] <= time);
        match (after.checked_sub(1), self.rows.get(after)) {
            (None, Some(row)) => row[1],
            (Some(before), None) => self.rows[before][1],
            (Some(before), Some([t, value])) => {
                let [from, start] = self.rows[before];
                start + (value - start) * ((time - from) / (t - from))
            }
            // There is always a row.
            (None, None) => 0.0,
        }
    }

    /// Times (s) and values.
    #[must_use]
    pub fn rows(&self) -> &[[f64; 2]] {
        &self.rows
    }
}

/// Over which area a pressure acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Area {
    /// This one, m^2.
    Given(f64),
    /// Area of the wall, of planes the part within the domain that no other plane cuts off (`walls/section.rs`).
    OfWall,
}

/// Target of a servo.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// Force of the wall on the particles along the axis, N.
    Force(Ramp),
    /// Force of the wall over an area, Pa: positive where the wall presses along the axis.
    Pressure(Ramp, Area),
}

impl Target {
    /// How force or pressure change in time.
    #[must_use]
    pub fn ramp(&self) -> &Ramp {
        match self {
            Self::Force(ramp) | Self::Pressure(ramp, _) => ramp,
        }
    }

    /// The unit of the ramp.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Force(_) => "N",
            Self::Pressure(..) => "Pa",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_linear_between_its_rows_and_held_outside() {
        let ramp = Ramp::new(vec![[1.0, 10.0], [2.0, 30.0], [4.0, 0.0]]).unwrap();
        for (time, value) in [
            (0.0, 10.0),
            (1.0, 10.0),
            (1.5, 20.0),
            (2.0, 30.0),
            (3.0, 15.0),
            (9.0, 0.0),
        ] {
            assert_eq!(ramp.at(time), value, "{time}");
        }
        assert_eq!(Ramp::constant(-3.0).unwrap().at(7.0), -3.0);
    }

    #[test]
    fn its_rows_are_times_and_values_in_whatever_order_the_columns_have() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("force.csv");
        for text in ["t,force\n0,5\n2,7\n", "force, t\n5, 0\n7, 2\n"] {
            std::fs::write(&path, text).unwrap();
            let ramp = Ramp::read(&path, "force").unwrap();
            assert_eq!(ramp.rows(), [[0.0, 5.0], [2.0, 7.0]], "{text}");
        }
        std::fs::write(&path, "t,pressure\n0,5\n").unwrap();
        let error = Ramp::read(&path, "force").unwrap_err().to_string();
        assert!(error.contains("force"), "{error}");
    }

    #[test]
    fn what_is_no_course_is_refused() {
        assert_eq!(Ramp::new(Vec::new()), Err(WallError::NoRows));
        assert!(Ramp::new(vec![[0.0, f64::NAN]]).is_err());
        assert!(Ramp::new(vec![[1.0, 0.0], [1.0, 2.0]]).is_err());
    }
}
