//! Values over time: constant, or linear between the rows of a table.

use std::ops::{Add, Div, Mul, Sub};

use glam::DVec3;
use thiserror::Error;

use crate::formats::time_table::TimeRow;

/// A value that a [`Curve`] can have.
pub trait CurveValue:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> + Div<f64, Output = Self>
{
    /// Whether all of its numbers are finite.
    fn is_finite(self) -> bool;
}

impl CurveValue for f64 {
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
}

impl CurveValue for DVec3 {
    fn is_finite(self) -> bool {
        DVec3::is_finite(self)
    }
}

/// A value that changes linearly between rows of time and value, and keeps the values of the first and the last row outside them.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve<V = f64> {
    /// Times (s), strictly increasing, and values; never empty, all finite.
    rows: Vec<(f64, V)>,
}

/// Rows that are no [`Curve`].
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CurveError {
    /// No rows.
    #[error("needs at least one row")]
    NoRows,
    /// A time or a value that is not finite.
    #[error("row {row}: time and value must be finite")]
    NotFinite {
        /// Counted from 1.
        row: usize,
    },
    /// Times that do not increase.
    #[error("t: must increase, got {from} .. {to}")]
    NotIncreasing {
        /// Time of a row, s.
        from: f64,
        /// Time of the next one, s.
        to: f64,
    },
}

/// Part of a curve at a time.
enum Piece<V> {
    /// Outside the rows, or at the last one.
    Held(V),
    /// Between two rows.
    Line([(f64, V); 2]),
}

impl<V: CurveValue> Curve<V> {
    /// Always `value`.
    ///
    /// # Errors
    /// If it is not finite.
    pub fn constant(value: V) -> Result<Self, CurveError> {
        Self::new(vec![(0.0, value)])
    }

    /// Through rows of time (s) and value.
    ///
    /// # Errors
    /// If there is none, a number is not finite, or the times do not increase.
    pub fn new(rows: Vec<(f64, V)>) -> Result<Self, CurveError> {
        if rows.is_empty() {
            return Err(CurveError::NoRows);
        }
        let is_finite = |&(time, value): &(f64, V)| f64::is_finite(time) && value.is_finite();
        if let Some(row) = rows.iter().position(|row| !is_finite(row)) {
            return Err(CurveError::NotFinite { row: row + 1 });
        }
        match rows.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
            Some(pair) => Err(CurveError::NotIncreasing {
                from: pair[0].0,
                to: pair[1].0,
            }),
            None => Ok(Self { rows }),
        }
    }

    /// Through the rows that a [table](crate::formats::time_table::TimeTable) without equal times has read; `value` takes the value of a row.
    #[must_use]
    pub fn of_table<const N: usize>(rows: &[TimeRow<N>], value: impl Fn(&[f64; N]) -> V) -> Self {
        let row = |row: &TimeRow<N>| (row.values[0], value(&row.values));
        let rows: Vec<_> = rows.iter().map(row).collect();
        debug_assert!(
            Self::new(rows.clone()).is_ok(),
            "the table has checked them"
        );
        Self { rows }
    }

    /// Times (s) and values.
    #[must_use]
    pub fn rows(&self) -> &[(f64, V)] {
        &self.rows
    }

    /// Times of the first and the last row, s.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        [self.rows[0].0, self.rows[self.rows.len() - 1].0]
    }

    /// Value at `time` (s).
    #[must_use]
    pub fn at(&self, time: f64) -> V {
        match self.piece(time) {
            Piece::Held(value) => value,
            Piece::Line(rows) => on_line(rows, time),
        }
    }

    /// Rate of change at `time` (s), where it jumps that of what follows; `None` outside the rows, where the value is held.
    #[must_use]
    pub fn slope(&self, time: f64) -> Option<V> {
        match self.piece(time) {
            Piece::Held(_) => None,
            Piece::Line([(from, start), (to, end)]) => Some((end - start) / (to - from)),
        }
    }

    fn piece(&self, time: f64) -> Piece<V> {
        let after = self.rows.partition_point(|row| row.0 <= time);
        let before = after.saturating_sub(1);
        match self.rows.get(after) {
            Some(&next) if after > 0 => Piece::Line([self.rows[before], next]),
            _ => Piece::Held(self.rows[before].1),
        }
    }
}

/// 0 always.
impl Default for Curve {
    fn default() -> Self {
        Self {
            rows: vec![(0.0, 0.0)],
        }
    }
}

impl Curve {
    /// Value at `time` (s) of a cumulative amount: 0 before the first row, and after the last row on the line through the last two.
    #[must_use]
    pub fn cumulative(&self, time: f64) -> f64 {
        match self.rows[..] {
            [(first, _), ..] if time < first => 0.0,
            [.., before, last] if time >= last.0 => on_line([before, last], time),
            _ => self.at(time),
        }
    }
}

/// Value at `time` (s) on the line through two rows.
fn on_line<V: CurveValue>([(from, start), (to, end)]: [(f64, V); 2], time: f64) -> V {
    start + (end - start) * ((time - from) / (to - from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_linear_between_its_rows_and_held_outside() {
        let curve = Curve::new(vec![(1.0, 10.0), (2.0, 30.0), (4.0, 0.0)]).unwrap();
        for (time, value, slope) in [
            (0.0, 10.0, None),
            (1.0, 10.0, Some(20.0)),
            (1.5, 20.0, Some(20.0)),
            (2.0, 30.0, Some(-15.0)),
            (3.0, 15.0, Some(-15.0)),
            (4.0, 0.0, None),
            (9.0, 0.0, None),
        ] {
            assert_eq!(
                (curve.at(time), curve.slope(time)),
                (value, slope),
                "{time}"
            );
        }
        assert_eq!(curve.ends(), [1.0, 4.0]);
        let still = Curve::constant(DVec3::X).unwrap();
        assert_eq!(Curve::default(), Curve::constant(0.0).unwrap());
        assert_eq!((still.at(7.0), still.slope(7.0)), (DVec3::X, None));
    }

    #[test]
    fn cumulative_amounts_begin_at_0_and_go_on_at_the_last_slope() {
        let curve = Curve::new(vec![(1.0, 2.0), (2.0, 10.0), (4.0, 14.0)]).unwrap();
        for (time, expected) in [
            (0.5, 0.0),
            (1.0, 2.0),
            (1.5, 6.0),
            (2.0, 10.0),
            (3.0, 12.0),
            (4.0, 14.0),
            (6.0, 18.0),
        ] {
            assert_eq!(curve.cumulative(time), expected, "at {time} s");
        }
        let stopped = Curve::new(vec![(0.0, 0.0), (1.0, 5.0), (2.0, 5.0)]).unwrap();
        assert_eq!(stopped.cumulative(9.0), 5.0);
        let at_once = Curve::new(vec![(1.0, 3.0)]).unwrap();
        assert_eq!([0.5, 7.0].map(|time| at_once.cumulative(time)), [0.0, 3.0]);
    }

    #[test]
    fn rows_that_are_no_curve_are_refused() {
        assert_eq!(Curve::<f64>::new(Vec::new()), Err(CurveError::NoRows));
        for row in [(0.0, f64::NAN), (f64::INFINITY, 0.0)] {
            let refused = Curve::new(vec![(-1.0, 0.0), row]);
            assert_eq!(refused, Err(CurveError::NotFinite { row: 2 }));
        }
        let (from, to) = (1.0, 1.0);
        let refused = Curve::new(vec![(from, 0.0), (to, 2.0)]);
        assert_eq!(refused, Err(CurveError::NotIncreasing { from, to }));
    }
}
