//! A study from a file: a document in TOML, or JSON, with the table `[study]`.

use std::path::{Path, PathBuf};

use mercury_common::scene::{
    STANDARD_INPUT, help_with_backslashes, is_json, listed, nearest, stem,
};
use toml::{Table, Value};

use super::{MOST_RUNS, Seeds, Study, StudyError, StudyRun, Sweep, dotted, grid, named, too_many};
use crate::results::NamedResult;

const KEYS: [&str; 11] = [
    "scene", "folder", "set", "sweep", "runs", "seeds", "error", "results", "plots", "jobs",
    "threads",
];

/// Whether a text is that of a study: it has a table `study`, which no scene has.
#[must_use]
pub fn is_study(text: &str) -> bool {
    if !text.contains("study") {
        return false;
    }
    if let Ok(document) = document("", text) {
        return document.contains_key("study");
    }
    // A text with mistakes: errors are reported for a study if it looks like one.
    let line = |line: &str| {
        let line = line.trim_start();
        line.starts_with("[study") || line.starts_with("study.") || line.contains("\"study\":")
    };
    text.lines().any(line)
}

/// Reads a study from its text. File names are relative to `path`, the study's file.
///
/// # Errors
/// A key or a value is wrong; the error names the key.
pub fn parse(path: &Path, text: &str) -> Result<Study, StudyError> {
    let reader = Reader { path };
    let name = path.display().to_string();
    let document = document(&name, text)?;
    if let Some(key) = document.keys().find(|key| *key != "study") {
        let error = reader.error(key, "is not known beside [study]");
        return Err(error.with_help(
            "all keys of a study belong below [study]; those of its scene in the scene's file",
        ));
    }
    let Some(Value::Table(study)) = document.get("study") else {
        return Err(reader.error("study", "must be a table"));
    };
    if let Some(key) = study.keys().find(|key| !KEYS.contains(&key.as_str())) {
        let error = reader.error(&format!("study.{key}"), "this key is not known");
        return Err(error.with_help(match nearest(key, KEYS) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are: {}", listed(KEYS)),
        }));
    }
    reader.study(study)
}

/// The document, in TOML or JSON.
fn document(name: &str, text: &str) -> Result<Table, StudyError> {
    if !is_json(name, text) {
        let wrong = |error: toml::de::Error| {
            let shown = error.to_string();
            let shown = shown.trim_end();
            StudyError::new(
                name,
                match help_with_backslashes(error.message()) {
                    Some(help) => format!("{shown}\nhelp: {help}"),
                    None => shown.to_owned(),
                },
            )
        };
        return text.parse().map_err(wrong);
    }
    serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        let words = error.to_string();
        let words = words.split(" at line ").next().unwrap_or_default();
        StudyError::new(
            format!("{name}:{line}:{column}"),
            format!("not valid JSON: {words}"),
        )
    })
}

struct Reader<'a> {
    path: &'a Path,
}

impl Reader<'_> {
    fn error(&self, key: &str, problem: &str) -> StudyError {
        StudyError::new(format!("{}: {key}", self.path.display()), problem)
    }

    fn study(&self, study: &Table) -> Result<Study, StudyError> {
        let beside = self.path.parent().unwrap_or(Path::new(""));
        let Some(scene) = self.text(study, "scene")? else {
            let error = self.error("study.scene", "is missing");
            return Err(error.with_help("scene = \"drum.toml\", the scene that is run"));
        };
        let folder = match self.text(study, "folder")? {
            Some(folder) => beside.join(folder),
            // Like the folder of a run: here, by the file's name.
            None if self.path == Path::new(STANDARD_INPUT) => PathBuf::from("study"),
            None => PathBuf::from(stem(self.path)),
        };
        let (keys, runs) = self.runs(study)?;
        let mut results = Vec::new();
        for (name, what) in self.table(study, "results")?.into_iter().flatten() {
            let key = format!("study.results.{name}");
            let what = what
                .as_str()
                .ok_or_else(|| self.error(&key, "must be a string"))?;
            let result = NamedResult::new(name, what);
            results.push(result.map_err(|problem| self.error(&key, &problem))?);
        }
        let mut plots = Vec::new();
        for plot in self.list(study, "plots")?.into_iter().flatten() {
            let name = plot.as_str();
            plots.push(
                name.ok_or_else(|| self.error("study.plots", "must be a list of strings"))?
                    .to_owned(),
            );
        }
        let set = self.table(study, "set")?.into_iter().flatten();
        let seeds = self.seeds(study, &results)?;
        let mut found = Study {
            scene: beside.join(scene),
            folder,
            set: set.map(|(key, value)| format!("{key}={value}")).collect(),
            title: String::new(),
            units: vec![String::new(); keys.len()],
            keys,
            runs,
            results,
            seeds: None,
            plots,
            jobs: self.count(study, "jobs")?,
            threads: self.count(study, "threads")?,
        };
        if let Some(seeds) = seeds {
            found.repeat(seeds, &format!("{}: study.seeds", self.path.display()))?;
        }
        Ok(found)
    }

    /// `seeds = 8`, or `{ least = 8, most = 64 }` with the errors of `[study.error]`.
    fn seeds(&self, study: &Table, results: &[NamedResult]) -> Result<Option<Seeds>, StudyError> {
        let errors = self.table(study, "error")?;
        let place = "study.seeds";
        let wrong = |problem: &str| self.error(place, problem);
        let expected = "must be a number, 8, or { least = 8, most = 64 }";
        let whole = |value: Option<&Value>| {
            let count = value.and_then(Value::as_integer);
            count
                .and_then(|count| u32::try_from(count).ok())
                .ok_or_else(|| wrong(expected))
        };
        let seeds = match study.get("seeds") {
            None if errors.is_some() => {
                let error = self.error("study.error", "needs `seeds`");
                return Err(error.with_help("seeds = { least = 8, most = 64 }, of each point"));
            }
            None => return Ok(None),
            Some(Value::Table(table)) => {
                if let Some(key) = table
                    .keys()
                    .find(|key| !["least", "most"].contains(&key.as_str()))
                {
                    return Err(self.error(&format!("{place}.{key}"), "this key is not known"));
                }
                Seeds::new(whole(table.get("least"))?, whole(table.get("most"))?)
            }
            value => {
                let count = whole(value)?;
                Seeds::new(count, count)
            }
        };
        let mut seeds = seeds.map_err(|problem| wrong(&problem))?;
        for (name, error) in errors.into_iter().flatten() {
            let key = format!("study.error.{name}");
            let text = error
                .as_str()
                .ok_or_else(|| self.error(&key, "must be a string, \"2 %\""))?;
            let set = seeds.until(name, text, results);
            set.map_err(|problem| self.error(&key, &problem))?;
        }
        if seeds.least != seeds.most && errors.is_none_or(Table::is_empty) {
            let error = wrong("needs [study.error], from which the number of seeds follows");
            return Err(
                error.with_help("[study.error] with slope = \"2 %\", or a fixed number: seeds = 8")
            );
        }
        Ok(Some(seeds))
    }

    fn runs(&self, study: &Table) -> Result<(Vec<String>, Vec<StudyRun>), StudyError> {
        match (self.table(study, "sweep")?, self.list(study, "runs")?) {
            (Some(_), Some(_)) => {
                let error = self.error("study.runs", "cannot be used together with study.sweep");
                Err(error.with_help("a grid (sweep) or a list (runs): two studies make both"))
            }
            // One point.
            (None, None) if study.contains_key("seeds") => {
                Ok((Vec::new(), vec![StudyRun::as_it_is()]))
            }
            (None, None) => {
                let error = self.error("study", "says nothing of values");
                Err(error.with_help("[study.sweep] with KEY = [A, B, C] makes a grid, [[study.runs]] with KEY = A a list"))
            }
            (Some(sweep), None) => {
                let mut sweeps = Vec::new();
                for (key, values) in sweep {
                    let place = format!("study.sweep.{key}");
                    // A key written without quotes is a table in TOML.
                    if values.is_table() {
                        let error = self.error(&place, "is a table");
                        return Err(error.with_help(
                            "write the path of a key in quotes: \"time.end\" = [1, 2]",
                        ));
                    }
                    let values: Vec<String> = match values {
                        Value::Array(values) => values.iter().map(Value::to_string).collect(),
                        // As on the command line: "0..0.5/6".
                        Value::String(text) => {
                            let sweep = Sweep::parse(&format!("x={text}"));
                            sweep
                                .map_err(|problem| self.error(&place, &problem))?
                                .values
                        }
                        _ => {
                            let error = self.error(&place, "must be a list of values");
                            return Err(
                                error.with_help("for example [0.1, 0.2, 0.3], or \"0.1..0.3/3\"")
                            );
                        }
                    };
                    if values.is_empty() {
                        return Err(self.error(&place, "has no values"));
                    }
                    sweeps.push(Sweep {
                        key: key.clone(),
                        values,
                    });
                }
                if sweeps.is_empty() {
                    return Err(self.error("study.sweep", "names no key"));
                }
                grid(&sweeps, &format!("{}: study.sweep", self.path.display()))
            }
            (None, Some(list)) => self.list_of_runs(list),
        }
    }

    fn list_of_runs(&self, list: &[Value]) -> Result<(Vec<String>, Vec<StudyRun>), StudyError> {
        let place = format!("{}: study.runs", self.path.display());
        too_many(list.len(), &place)?;
        debug_assert!(list.len() <= MOST_RUNS);
        let mut keys: Vec<String> = Vec::new();
        let mut runs = Vec::new();
        for (number, run) in list.iter().enumerate() {
            let at = format!("study.runs[{number}]");
            let table = run
                .as_table()
                .ok_or_else(|| self.error(&at, "must be a table"))?;
            let name = match table.get("name") {
                None => None,
                Some(Value::String(name)) if is_file_name(name) => Some(name.clone()),
                Some(_) => {
                    let error = self.error(&format!("{at}.name"), "must be a name for a folder");
                    return Err(error.with_help("letters, digits, . + - _ = and commas"));
                }
            };
            let mut values = vec![None; keys.len()];
            for (key, value) in table.iter().filter(|(key, _)| *key != "name") {
                if value.is_table() {
                    let error = self.error(&format!("{at}.{key}"), "is a table");
                    return Err(
                        error.with_help("write the path of a key in quotes: \"time.end\" = 1")
                    );
                }
                let key = dotted(key);
                let place = keys.iter().position(|known| *known == key);
                let place = place.unwrap_or_else(|| {
                    keys.push(key);
                    values.push(None);
                    keys.len() - 1
                });
                values[place] = Some(value.to_string());
            }
            runs.push((name, values));
        }
        for (_, values) in &mut runs {
            values.resize(keys.len(), None);
        }
        if runs.is_empty() {
            return Err(self.error("study.runs", "has no runs"));
        }
        let runs = named(&keys, runs, &place)?;
        Ok((keys, runs))
    }

    fn text<'t>(&self, table: &'t Table, key: &str) -> Result<Option<&'t str>, StudyError> {
        match table.get(key) {
            None => Ok(None),
            Some(Value::String(text)) if !text.is_empty() => Ok(Some(text)),
            Some(_) => Err(self.error(&format!("study.{key}"), "must be a string")),
        }
    }

    fn table<'t>(&self, table: &'t Table, key: &str) -> Result<Option<&'t Table>, StudyError> {
        match table.get(key) {
            None => Ok(None),
            Some(Value::Table(table)) => Ok(Some(table)),
            Some(_) => Err(self.error(&format!("study.{key}"), "must be a table")),
        }
    }

    fn list<'t>(&self, table: &'t Table, key: &str) -> Result<Option<&'t [Value]>, StudyError> {
        match table.get(key) {
            None => Ok(None),
            Some(Value::Array(list)) => Ok(Some(list)),
            Some(_) => Err(self.error(&format!("study.{key}"), "must be a list")),
        }
    }

    fn count(&self, table: &Table, key: &str) -> Result<Option<u16>, StudyError> {
        match table.get(key) {
            None => Ok(None),
            Some(Value::Integer(count @ 1..=1024)) => Ok(u16::try_from(*count).ok()),
            Some(_) => Err(self.error(&format!("study.{key}"), "must be a number from 1 to 1024")),
        }
    }
}

fn is_file_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || ".+-_=,".contains(c);
    !name.is_empty() && !name.starts_with('.') && name.len() <= 100 && name.chars().all(plain)
}
