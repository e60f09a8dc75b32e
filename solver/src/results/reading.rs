//! The value of a result, read from the files of a run, with its error where one run has it.

use std::fs;
use std::io;
use std::path::Path;

use mercury_common::run_tables::Role;

use super::NamedResult;
use super::estimate::{Course, Measured};
use super::grammar::{Function, Source};
use super::until::slack;
use super::values::{self, Row, energies, gravity, particles, rows, slope, slope_note, turning};
use crate::output::summary::ResultValue;

/// Why a file of a finished run cannot be read, and what to do.
pub(crate) fn lost(path: &Path, error: &io::Error) -> String {
    let help = match error.kind() {
        io::ErrorKind::NotFound => {
            "; if the scene writes it, remove the folder of the run and give the command again: the run is made anew"
        }
        _ => "",
    };
    format!("{} cannot be read: {error}{help}", path.display())
}

impl NamedResult {
    /// Rows of one of its sources.
    fn rows(&self, source: &Source, folder: &Path, prefix: &str) -> Result<Vec<Row>, String> {
        match source {
            Source::Rows {
                table,
                name,
                material,
                column,
            } => {
                let path = folder.join(format!("{prefix}.{}", table.file));
                let text = fs::read_to_string(&path).map_err(|error| lost(&path, &error))?;
                let rows = rows(&text, name, material.as_deref(), column);
                rows.map_err(|problem| format!("{}: {problem}", path.display()))
            }
            Source::Energy { column } => energies(folder, prefix, column),
            Source::Particles { .. } => Ok(Vec::new()),
        }
    }

    /// Whether one run gives its error, or why not.
    pub(super) fn has_error(&self) -> Result<(), &'static str> {
        match (self.function, &self.source) {
            (Function::Slope, _) | (_, Source::Particles { .. }) => Err("it is of one state"),
            (
                Function::Min | Function::Max | Function::First | Function::Last | Function::Sum,
                _,
            ) => Err("it is one value of the window"),
            _ => Ok(()),
        }
    }

    /// Time from which its rows count, s, in a scene that schedules nothing behind `settled` (s).
    pub(super) fn begin(&self, settled: f64) -> f64 {
        match self.window.is_steady {
            true => settled,
            false => self.window.times.0,
        }
    }

    /// Whether its values are amounts that came since the row before.
    pub(super) fn is_amount(&self) -> bool {
        let Source::Rows { table, column, .. } = &self.source else {
            return false;
        };
        table.column(column).map(|column| column.role) == Some(Role::Amount)
    }

    /// Its value and error in the run whose files lie in `folder` and begin with `prefix`. `settled`: the time behind which the scene schedules
    /// nothing (s), for `steady` windows. Rows behind `until` (s) do not count.
    pub(super) fn measured(
        &self,
        folder: &Path,
        prefix: &str,
        settled: Result<f64, String>,
        until: f64,
    ) -> Result<Measured, String> {
        if self.function == Function::Slope {
            return slope(folder, prefix).map(Measured::of_one_state);
        }
        if let Source::Particles { column } = &self.source {
            let values = particles(folder, prefix, column)?;
            return self.value(&values).map(Measured::of_one_state);
        }
        let (_, to) = self.window.times;
        let from = match self.window.is_steady {
            true => self.begin(settled?),
            false => self.begin(0.0),
        };
        let to = to.min(until + slack(until));
        let from = from
            - if self.window.is_steady {
                slack(from)
            } else {
                0.0
            };
        let all = self.rows(&self.source, folder, prefix)?;
        let inside = |row: &&Row| (from..=to).contains(&row.time);
        let values: Vec<f64> = all.iter().filter(inside).map(|row| row.value).collect();
        let course = match self.function {
            Function::Mean => Course::mean(all.iter().filter(inside)),
            Function::Std => Course::deviation(all.iter().filter(inside)),
            Function::Rate => {
                let flows = self.flows(&all, (from, to));
                let flows: Vec<Row> = flows.map(|(_, flow)| flow).collect();
                Course::mean(flows.iter())
            }
            Function::Ratio => {
                let below = self.over.as_ref().unwrap_or(&self.source);
                let below = self.rows(below, folder, prefix)?;
                let below: Vec<Row> = below.iter().filter(inside).copied().collect();
                Course::ratio(all.iter().filter(inside), &below)
            }
            Function::Tilt => {
                let turned = turning(folder, prefix, self.wall(), gravity(folder, prefix)?)?;
                Course::angle(turned.iter().filter(|(row, _)| inside(&row)))
            }
            _ => {
                let why = "it is one value of the window: no error follows from one run";
                return Ok(Measured::without_error(self.value(&values)?, why));
            }
        };
        let measured = course.measured(self.window.is_steady);
        if self.window.is_steady || matches!(self.function, Function::Ratio | Function::Tilt) {
            return measured.ok_or_else(|| self.no_rows((from, to)));
        }
        // Windows given in numbers: the function of all of their rows.
        let value = match self.function {
            Function::Rate => self.rate(&all, self.is_amount())?,
            _ => self.value(&values)?,
        };
        Ok(match measured {
            Some(measured) => measured.with_value(value),
            None => Measured::without_error(value, "it has one row"),
        })
    }

    /// The name of the wall of its source.
    fn wall(&self) -> &str {
        match &self.source {
            Source::Rows { name, .. } => name,
            _ => "",
        }
    }

    /// Its value in the run whose files are in `folder` and begin with `prefix`, or the reason why it has none. `settled` is the time behind which
    /// its scene schedules nothing, s; left out, it is read from the summary of the run.
    #[must_use]
    pub fn read(&self, folder: &Path, prefix: &str, settled: Option<f64>) -> ResultValue {
        let settled = match settled {
            Some(time) => Ok(time),
            None if self.window.is_steady => values::settled(folder),
            None => Ok(0.0),
        };
        let unit = self.unit();
        let read = self.measured(folder, prefix, settled, f64::INFINITY);
        let is_finite = |measured: &Measured| measured.value.is_finite();
        let problem = match &read {
            Err(problem) => Some(problem.clone()),
            Ok(measured) if !is_finite(measured) => Some(format!("is {}", measured.value)),
            Ok(_) => None,
        };
        let read = read.ok().filter(is_finite);
        let note = read.as_ref().and_then(|measured| {
            let notes = [self.note(folder, prefix), measured.note.clone()];
            let notes: Vec<String> = notes.into_iter().flatten().collect();
            (!notes.is_empty()).then(|| notes.join("; "))
        });
        ResultValue {
            of: self.text.clone(),
            value: read.as_ref().map(|measured| measured.value),
            unit,
            problem,
            note,
            estimate: read.map(|measured| measured.estimate),
        }
    }

    /// Remark on its value in a run.
    fn note(&self, folder: &Path, prefix: &str) -> Option<String> {
        match self.function {
            Function::Slope => slope_note(folder, prefix),
            _ => None,
        }
    }

    /// The intervals between rows that lie in a window as a whole, and the change per time in each.
    fn flows<'a>(
        &self,
        rows: &'a [Row],
        (from, to): (f64, f64),
    ) -> impl Iterator<Item = ([Row; 2], Row)> + 'a {
        let is_amount = self.is_amount();
        let pairs = rows.windows(2).map(|pair| [pair[0], pair[1]]);
        let inside = move |[before, row]: &[Row; 2]| {
            // Times are multiples of the step but for round-off.
            let slack = 1e-6 * (row.time - before.time);
            before.time >= from - slack && row.time <= to + slack
        };
        pairs.filter(inside).map(move |[before, row]| {
            let change = row.value - if is_amount { 0.0 } else { before.value };
            let flow = Row {
                time: row.time,
                value: change / (row.time - before.time),
            };
            ([before, row], flow)
        })
    }

    /// Change per time: of `amounts` the sum over the time in which they came, of rows whose time lies in the window as a whole; else the
    /// difference of the last and the first.
    fn rate(&self, rows: &[Row], amounts: bool) -> Result<f64, String> {
        let (from, to) = self.window.times;
        let inside = self.flows(rows, (from, to)).map(|(rows, _)| rows);
        let inside: Vec<[Row; 2]> = inside.collect();
        let (Some([first, _]), Some([_, last])) = (inside.first(), inside.last()) else {
            return Err(format!("a rate needs two rows between {from} and {to} s"));
        };
        let change = match amounts {
            true => inside.iter().map(|[_, row]| row.value).sum(),
            false => last.value - first.value,
        };
        Ok(change / (last.time - first.time))
    }

    /// The message that no row lies in a window.
    fn no_rows(&self, (from, to): (f64, f64)) -> String {
        match from.is_finite() || to.is_finite() {
            true => format!("no rows between {from} and {to} s"),
            false => "there are no values".to_owned(),
        }
    }

    fn value(&self, values: &[f64]) -> Result<f64, String> {
        let (Some(first), Some(last)) = (values.first(), values.last()) else {
            return Err(self.no_rows(self.window.times));
        };
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        Ok(match self.function {
            Function::Mean
            | Function::Rate
            | Function::Ratio
            | Function::Tilt
            | Function::Slope => mean,
            Function::Std if values.len() < 2 => f64::NAN,
            Function::Std => {
                (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (count - 1.0)).sqrt()
            }
            Function::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
            Function::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Function::First => *first,
            Function::Last => *last,
            Function::Sum => values.iter().sum(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_values() {
        let value = |function: &str, values: &[f64]| {
            NamedResult::new("x", &format!("{function}(walls.drum.ty)"))
                .unwrap()
                .value(values)
        };
        let values = [1.0, 2.0, 6.0];
        for (function, expected) in [
            ("mean", 3.0),
            // Deviations -2, -1, 3: 14 over 2.
            ("std", 7f64.sqrt()),
            ("min", 1.0),
            ("max", 6.0),
            ("first", 1.0),
            ("last", 6.0),
            ("sum", 9.0),
        ] {
            assert_eq!(value(function, &values), Ok(expected), "{function}");
        }
        assert!(value("mean", &[]).is_err());
        assert!(value("std", &[1.0]).unwrap().is_nan());
    }

    #[test]
    fn rates_are_amounts_over_the_time_in_which_they_came() {
        // An amount that came since the row before; the last interval is shorter, as at the end of a run.
        let rows: Vec<Row> = [(0.0, 0.0), (0.5, 1.0), (1.0, 2.0), (1.5, 6.0), (1.75, 4.0)]
            .map(|(time, value)| Row { time, value })
            .to_vec();
        let rate = |window: &str, amounts: bool| {
            let text = format!("rate(flux.out.mass, {window})");
            NamedResult::new("x", &text).unwrap().rate(&rows, amounts)
        };
        // 13 in 1.75 s, 12 in the 1.25 s from 0.5 on, 6 in the one interval that lies between 0.9 and 1.6.
        assert_eq!(rate("..", true), Ok(13.0 / 1.75));
        assert_eq!(rate("0.5..", true), Ok(12.0 / 1.25));
        assert_eq!(rate("0.9..1.6", true), Ok(6.0 / 0.5));
        // Of what is there at each time, the difference.
        assert_eq!(rate("0.5..1.5", false), Ok(5.0 / 1.0));
        assert!(rate("1.1..1.4", true).is_err());
        assert!(rate("2..", true).is_err());
    }
}
