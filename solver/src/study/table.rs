//! The table of a study: a row for each run, with the values of its keys, how it ended, the numbers of its summary and those
//! requested by name.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use mercury_common::formats::delimited::push_line;
use mercury_common::formats::table_head;
use mercury_common::units::{Dimension, Quantity};

use super::Study;
use super::earlier::Rows;
use crate::results::lost;

/// Name of the file in the study's folder.
pub const FILE: &str = "study.csv";

/// The column with the standard error of a result, where one run has one.
#[must_use]
pub(super) fn error_column(result: &str) -> String {
    format!("{result}_error")
}

/// How far a run has come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum State {
    /// The run has not begun.
    Waiting,
    /// The run ended as planned.
    Finished,
    /// Stopped on request; it continues when the study does.
    Stopped,
    /// The run failed, for this reason.
    Failed(String),
    /// A seed that is not needed so far.
    Spare,
}

impl State {
    fn word(&self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Finished => "finished",
            Self::Stopped => "stopped",
            Self::Failed(_) => "failed",
            Self::Spare => "spare",
        }
    }
}

/// Columns of text; unknown values are empty.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StudyTable {
    /// Their names.
    pub columns: Vec<String>,
    /// Their units, of SI; empty where a column has none.
    pub units: Vec<String>,
    /// A row for each run.
    pub rows: Vec<Vec<String>>,
    /// Errors on reading finished runs, with the run.
    pub problems: Vec<String>,
}

impl StudyTable {
    /// From the folders of the runs that are finished. `prefix` is that of the runs' files. The rows of an `earlier` table are
    /// kept where the run has not ended again, and where it is not part of this study.
    #[must_use]
    pub fn of(study: &Study, states: &[State], prefix: &str, earlier: &Rows) -> Self {
        let mut table = Self::default();
        let mut places = HashMap::new();
        let mut cells = Vec::new();
        let mut problems = Vec::new();
        for (run, state) in study.runs.iter().zip(states) {
            let before = earlier.iter().find(|(name, _)| *name == run.name);
            if *state == State::Spare && before.is_none() {
                continue;
            }
            let mut row = vec![("run".to_owned(), run.name.clone())];
            let values = study.keys.iter().zip(&run.settled);
            row.extend(values.map(|(key, value)| (key.clone(), plain(value.as_deref()))));
            row.push(("status".to_owned(), state.word().to_owned()));
            let why = match state {
                State::Failed(why) => why.lines().next().unwrap_or_default(),
                _ => "",
            };
            row.push(("problem".to_owned(), why.to_owned()));
            if let (State::Waiting | State::Spare | State::Failed(_), Some((_, cells))) =
                (state, before)
            {
                row.clone_from(cells);
                for (_, cell) in row.iter_mut().filter(|(name, _)| name == "problem") {
                    why.clone_into(cell);
                }
            }
            if *state == State::Finished {
                let folder = study.folder.join(&run.name);
                match summary(&folder) {
                    Ok((numbers, warnings)) => {
                        say(&mut row, &warnings);
                        row.extend(numbers);
                    }
                    Err(problem) => problems.push(format!("{}: {problem}", run.name)),
                }
                for result in &study.results {
                    if row.iter().any(|(name, _)| *name == result.name) {
                        let name = &result.name;
                        problems.push(format!("{}: the table has another column `{name}`: call the result something else", run.name));
                        continue;
                    }
                    let read = result.read(&folder, prefix, None);
                    if let Some(problem) = &read.problem {
                        problems.push(format!("{}: {}: {problem}", run.name, result.name));
                    }
                    let number = |value: Option<f64>| {
                        value.map_or_else(String::new, |value| format!("{value:?}"))
                    };
                    row.push((result.name.clone(), number(read.value)));
                    if let Some(error) = read.estimate.and_then(|known| known.error) {
                        row.push((error_column(&result.name), number(Some(error))));
                    }
                    let note = read.note.map(|note| format!("{}: {note}", result.name));
                    say(&mut row, note.as_slice());
                }
            }
            cells.push(row);
        }
        let is_other = |name: &str| study.runs.iter().all(|run| run.name != name);
        let others = earlier.iter().filter(|(name, _)| is_other(name));
        cells.extend(others.map(|(_, row)| row.clone()));
        for row in &cells {
            for (name, _) in row {
                let next = places.len();
                places.entry(name.clone()).or_insert_with(|| {
                    table.columns.push(name.clone());
                    next
                });
            }
        }
        table.units = table.columns.iter().map(|name| study.unit(name)).collect();
        table.rows = cells
            .into_iter()
            .map(|row| {
                let mut cells = vec![String::new(); table.columns.len()];
                for (name, text) in row {
                    cells[places[&name]] = text;
                }
                cells
            })
            .collect();
        table.problems = problems;
        table
    }

    /// Whether any of its runs has come to its end.
    #[must_use]
    pub fn has_finished(&self) -> bool {
        let status = self.columns.iter().position(|name| name == "status");
        let is_finished =
            |row: &Vec<String>| status.is_some_and(|k| row[k] == State::Finished.word());
        self.rows.iter().any(is_finished)
    }

    /// Table as text: commas, the names in the first line with their units in brackets.
    #[must_use]
    pub fn csv(&self) -> String {
        let header = self.columns.iter().zip(&self.units);
        let mut out = table_head::line(header).into_bytes();
        for row in &self.rows {
            push_line(&mut out, row);
        }
        String::from_utf8_lossy(&out).into_owned()
    }

    /// The units of the columns that have one.
    #[must_use]
    pub fn units(&self) -> serde_json::Map<String, serde_json::Value> {
        let units = self.columns.iter().zip(&self.units);
        let units = units.filter(|(_, unit)| !unit.is_empty());
        units
            .map(|(name, unit)| (name.clone(), unit.as_str().into()))
            .collect()
    }

    /// The rows for programs: numbers as numbers, null for unknown values.
    #[must_use]
    pub fn objects(&self) -> Vec<serde_json::Map<String, serde_json::Value>> {
        let value = |column: &str, cell: &str| -> serde_json::Value {
            if cell.is_empty() {
                return serde_json::Value::Null;
            }
            // A run may be called `1`.
            let is_text = ["run", "status", "problem"].contains(&column);
            match (is_text, cell.parse::<i64>(), cell.parse::<f64>()) {
                (false, Ok(whole), _) => whole.into(),
                (false, _, Ok(number)) => number.into(),
                _ => cell.into(),
            }
        };
        let object = |row: &Vec<String>| {
            let cells = self.columns.iter().zip(row);
            cells
                .map(|(column, cell)| (column.clone(), value(column, cell)))
                .collect()
        };
        self.rows.iter().map(object).collect()
    }

    /// The numbers of a column by row, those with units in SI.
    #[must_use]
    pub fn numbers(&self, name: &str) -> Option<Vec<Option<f64>>> {
        let place = self.columns.iter().position(|column| column == name)?;
        Some(
            self.rows
                .iter()
                .map(|row| number(name, &row[place]))
                .collect(),
        )
    }
}

/// The number in a cell of this column, in SI (degrees where the key has degrees).
pub(super) fn number(column: &str, cell: &str) -> Option<f64> {
    if let Ok(number) = cell.parse() {
        return Some(number);
    }
    let quantity = Quantity::parse(cell).ok()?;
    match column.ends_with("degrees") {
        true => quantity.value(Dimension::DEGREES).ok(),
        false => Some(quantity.si()),
    }
}

/// A value of a scene as a table shows it: a string without its quotes.
pub(super) fn plain(value: Option<&str>) -> String {
    let value = value.unwrap_or_default();
    let inner = value
        .strip_prefix('"')
        .and_then(|value| value.strip_suffix('"'));
    inner.unwrap_or(value).to_owned()
}

/// Adds to what is wrong with a run.
fn say(row: &mut [(String, String)], more: &[String]) {
    let problem = row.iter_mut().find(|(name, _)| name == "problem");
    if let Some((_, problem)) = problem {
        for text in more {
            if !problem.is_empty() {
                *problem += "; ";
            }
            *problem += text;
        }
    }
}

/// Numbers by name, and warnings.
type Summary = (Vec<(String, String)>, Vec<String>);

/// The numbers of `summary.json`, `energy_kinetic` for those inside others, and its warnings.
fn summary(folder: &Path) -> Result<Summary, String> {
    let path = folder.join("summary.json");
    let failed = |error: String| format!("{}: {error}", path.display());
    let text = fs::read_to_string(&path).map_err(|error| lost(&path, &error))?;
    let value: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| failed(error.to_string()))?;
    let mut numbers = Vec::new();
    collect(&value, "", &mut numbers);
    let warnings = value["warnings"].as_array().into_iter().flatten();
    let warnings: Vec<String> = warnings
        .filter_map(|warning| warning.as_str().map(str::to_owned))
        .collect();
    numbers.push(("warnings".to_owned(), warnings.len().to_string()));
    Ok((numbers, warnings))
}

fn collect(value: &serde_json::Value, path: &str, numbers: &mut Vec<(String, String)>) {
    match value {
        serde_json::Value::Object(entries) => {
            for (key, value) in entries {
                let path = if path.is_empty() {
                    key.clone()
                } else {
                    format!("{path}_{key}")
                };
                collect(value, &path, numbers);
            }
        }
        serde_json::Value::Number(number) => numbers.push((path.to_owned(), number.to_string())),
        _ => {}
    }
}
