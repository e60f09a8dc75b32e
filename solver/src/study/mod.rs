//! Studies: one scene at many values of its keys, a run for each, and one table of what came out.
//!
//! This module lists the runs and the values that are read from each; it starts none. A [`Study`] comes from the command line or
//! [from a file](mod@file), [`earlier`] ones left their tables; results are read from the folders of the runs, [`table`] puts
//! them together and [`plot`] draws one of its columns.

pub mod earlier;
pub mod file;
pub mod plot;
pub mod seeds;
mod sweep;
pub mod table;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use mercury_common::readable::{printable, printable_lines};
use mercury_common::scene::Scene;

use crate::results::NamedResult;
pub use seeds::Seeds;
pub use sweep::Sweep;

/// More runs than can be useful: an error in a range.
pub const MOST_RUNS: usize = 10_000;

/// Error in a study.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}{}", help.iter().map(|help| format!("\nhelp: {help}")).collect::<String>())]
pub struct StudyError {
    /// The option, or file and key.
    pub place: String,
    /// Description of the problem.
    pub problem: String,
    /// Advice on how to solve it.
    pub help: Option<String>,
}

impl StudyError {
    fn new(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self {
            place: printable(&place.into()).into_owned(),
            problem: printable_lines(&problem.into()).into_owned(),
            help: None,
        }
    }

    fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// A scene, the values at which it is run, and the requested results of each run.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The scene file.
    pub scene: PathBuf,
    /// Where all goes.
    pub folder: PathBuf,
    /// `KEY=VALUE` of all runs.
    pub set: Vec<String>,
    /// Title of the scene, once it was read.
    pub title: String,
    /// The keys that differ between the runs, in the order in which they were named.
    pub keys: Vec<String>,
    /// The SI unit of each key's numbers, once the scene was read; empty where they have none.
    pub units: Vec<String>,
    /// The runs.
    pub runs: Vec<StudyRun>,
    /// Numbers requested by name.
    pub results: Vec<NamedResult>,
    /// How often each point is run, with other random numbers; `None`: once, and `seed` is a key like any other.
    pub seeds: Option<Seeds>,
    /// Columns to draw.
    pub plots: Vec<String>,
    /// Runs at a time.
    pub jobs: Option<u16>,
    /// Threads of each run.
    pub threads: Option<u16>,
}

/// One run of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StudyRun {
    /// Its folder within that of the study.
    pub name: String,
    /// A value for each key of the study, as TOML; `None`: the value of the scene.
    pub values: Vec<Option<String>>,
    /// Values in SI, once the scene was read.
    pub settled: Vec<Option<String>>,
}

impl StudyRun {
    /// The scene without a change.
    #[must_use]
    pub fn as_it_is() -> Self {
        Self {
            name: String::new(),
            values: Vec::new(),
            settled: Vec::new(),
        }
    }
}

/// Columns of every study's table beside its keys and results, as far as they are known before a run.
const COLUMNS: [&str; 18] = [
    "run",
    "status",
    "problem",
    "steps",
    "time",
    "time_step",
    "particles",
    "contacts",
    "wall_contacts",
    "wall_seconds",
    "particle_steps_per_second",
    "threads",
    "coordination_number",
    "energy_kinetic",
    "energy_rotational",
    "inserted",
    "deleted",
    "warnings",
];

impl Study {
    /// Whether the table can hold all results: each has a name of its own.
    ///
    /// # Errors
    /// The name that another column has.
    pub fn check_names(&self) -> Result<(), StudyError> {
        let mut known: BTreeSet<&str> = COLUMNS.into_iter().collect();
        known.extend(self.keys.iter().map(String::as_str));
        match (self.results.iter()).find(|result| !known.insert(result.name.as_str())) {
            Some(twice) => {
                let name = &twice.name;
                let problem = format!("the table has another column `{name}`");
                Err(StudyError::new(format!("result `{name}`"), problem)
                    .with_help("call the result something else"))
            }
            None => Ok(()),
        }
    }

    /// Takes the units of the study's values from the scene of a run.
    pub fn settle(&mut self, run: usize, scene: &Scene) {
        self.title.clone_from(&scene.title);
        self.units.resize(self.keys.len(), String::new());
        let Some(run) = self.runs.get_mut(run) else {
            return;
        };
        for (k, key) in self.keys.iter().enumerate() {
            let Some(value) = &run.values[k] else {
                continue;
            };
            let argument = format!("{key}={value}");
            let set = scene.set.iter().find(|set| set.argument == argument);
            // A value that a later one replaces stays as typed.
            let Some(set) = set.filter(|set| !set.unit.is_empty()) else {
                continue;
            };
            self.units[k].clone_from(&set.unit);
            // Numbers in SI keep their digits.
            if value.parse::<f64>().is_err() && value.contains(char::is_alphabetic) {
                run.settled[k] = Some(set.value.clone());
            }
        }
    }

    /// The unit of a column of the table; empty where it has none.
    #[must_use]
    pub fn unit(&self, column: &str) -> String {
        if let Some(k) = self.keys.iter().position(|key| key == column) {
            return self.units.get(k).cloned().unwrap_or_default();
        }
        let is_of = |result: &&NamedResult| {
            result.name == column || table::error_column(&result.name) == column
        };
        if let Some(result) = self.results.iter().find(is_of) {
            let unit = result.unit();
            return if unit == "1" { String::new() } else { unit };
        }
        summary_unit(column).to_owned()
    }

    /// The `KEY=VALUE` of a run, in the order in which they apply.
    #[must_use]
    pub fn overrides(&self, run: &StudyRun) -> Vec<String> {
        let of_run = self.keys.iter().zip(&run.values);
        let own = of_run.filter_map(|(key, value)| Some(format!("{key}={}", value.as_ref()?)));
        self.set.iter().cloned().chain(own).collect()
    }
}

/// The units of the numbers of `summary.json`.
fn summary_unit(column: &str) -> &'static str {
    match column {
        "time" | "time_step" | "wall_seconds" => "s",
        "particle_steps_per_second" => "1/s",
        "energy_closure_error" => "",
        "liquid_bridge_count" => "",
        _ if column.starts_with("energy_") => "J",
        _ if column.starts_with("liquid_") => "m3",
        _ => "",
    }
}

/// The runs of a grid: every value of each key with every value of the others, the last key fastest.
///
/// # Errors
/// For no value, a key or a value that is given twice, and more than [`MOST_RUNS`] runs. `place`: where the sweeps are given.
pub fn grid(sweeps: &[Sweep], place: &str) -> Result<(Vec<String>, Vec<StudyRun>), StudyError> {
    let keys: Vec<String> = sweeps.iter().map(|sweep| dotted(&sweep.key)).collect();
    let count = (sweeps.iter()).fold(1usize, |n, sweep| n.saturating_mul(sweep.values.len()));
    too_many(count, place)?;
    let values = (0..count).map(|number| {
        let mut rest = number;
        let mut values: Vec<Option<String>> = (sweeps.iter().rev())
            .map(|sweep| {
                let value = sweep.values[rest % sweep.values.len()].clone();
                rest /= sweep.values.len();
                Some(value)
            })
            .collect();
        values.reverse();
        values
    });
    let runs = named(&keys, values.map(|values| (None, values)).collect(), place)?;
    Ok((keys, runs))
}

/// `velocity.2` for `velocity[2]`: in the head of a table brackets hold a unit.
fn dotted(key: &str) -> String {
    if key.contains(['"', '\'']) {
        key.to_owned()
    } else {
        key.replace('[', ".").replace(']', "")
    }
}

fn too_many(count: usize, place: &str) -> Result<(), StudyError> {
    if count <= MOST_RUNS {
        return Ok(());
    }
    let error = StudyError::new(place, format!("{count} runs, more than {MOST_RUNS}"));
    Err(error.with_help("the values of all keys multiply: name fewer of them"))
}

/// Gives each run its name, and checks that no name occurs twice.
fn named(
    keys: &[String],
    runs: Vec<(Option<String>, Vec<Option<String>>)>,
    place: &str,
) -> Result<Vec<StudyRun>, StudyError> {
    let mut known_keys = BTreeSet::new();
    if let Some(twice) = keys.iter().find(|key| !known_keys.insert(key.as_str())) {
        return Err(StudyError::new(
            place,
            format!("the key `{twice}` is given twice"),
        ));
    }
    let short = short_names(keys);
    let mut known = BTreeSet::new();
    let mut known_values = BTreeMap::new();
    let mut found: Vec<StudyRun> = Vec::with_capacity(runs.len());
    for (given, values) in runs {
        let is_named = given.is_some();
        let name = given.unwrap_or_else(|| name_of(&short, &values));
        if !known.insert(name.to_lowercase()) {
            let problem = format!("two runs would be `{name}`");
            return Err(StudyError::new(place, problem).with_help("each value stands once"));
        }
        // However they are written: 5 mm is 0.005.
        let same: Vec<Option<String>> = (keys.iter().zip(&values))
            .map(|(key, value)| {
                let text = table::plain(Some(value.as_ref()?));
                Some(table::number(key, &text).map_or(text, |number| format!("{number:?}")))
            })
            .collect();
        let before = known_values.insert(same, found.len());
        // A name on the command line is meant.
        if let Some(before) = before.filter(|_| !is_named) {
            let problem = format!(
                "the runs `{}` and `{name}` are the same",
                found[before].name
            );
            return Err(StudyError::new(place, problem).with_help("each value stands once"));
        }
        found.push(StudyRun {
            name,
            settled: values.clone(),
            values,
        });
    }
    Ok(found)
}

/// Ends of the keys, as long as they must be to distinguish the keys.
fn short_names(keys: &[String]) -> Vec<String> {
    let parts = |key: &String| -> Vec<String> {
        key.split(['.', '[', ']'])
            .map(|part| part.trim_matches(['"', '\'', ' ']).to_owned())
            .filter(|part| !part.is_empty())
            .collect()
    };
    let keys: Vec<Vec<String>> = keys.iter().map(parts).collect();
    let end = |key: &[String], length: usize| key[key.len().saturating_sub(length)..].join(".");
    (keys.iter().enumerate())
        .map(|(k, key)| {
            let is_alone = |length: usize| {
                let mut others = keys.iter().enumerate().filter(|(other, _)| *other != k);
                others.all(|(_, other)| end(other, length) != end(key, length))
            };
            let length = (1..=key.len()).find(|&length| is_alone(length));
            end(key, length.unwrap_or(key.len()))
        })
        .collect()
}

/// `friction=0.2_seed=3`, of letters that every file system takes.
fn name_of(short: &[String], values: &[Option<String>]) -> String {
    let parts = short.iter().zip(values);
    let set: Vec<String> = parts
        .filter_map(|(key, value)| Some(format!("{key}={}", value.as_ref()?)))
        .collect();
    let whole = set.join("_");
    let plain = |c: char| c.is_ascii_alphanumeric() || ".+-_=,".contains(c);
    let name: String = (whole.chars().filter(|c| !"\"' ".contains(*c)))
        .map(|c| if plain(c) { c } else { '-' })
        .collect();
    match name.as_str() {
        "" => "as-it-is".to_owned(),
        // A part that was left out, or is too long for a name, is replaced by a checksum.
        _ if name.len() > 100 => {
            format!("{}-{:08x}", &name[..80], crc32fast::hash(whole.as_bytes()))
        }
        _ => name,
    }
}
