//! Earlier study in a folder: its table, and a record of the study.
//!
//! A table alone does not contain what was the same in all its runs, nor the definition of its results. So a study leaves
//! [`RECORD`] beside it, and the next one is compared with that.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

use mercury_common::formats::delimited;
use mercury_common::scene::listed;
use mercury_common::whole_file::write_whole;
use toml::{Table, Value};

use super::Study;
use super::seeds::{DIFFERENCES, MEANS};
use super::table::{FILE, number};

/// Name of the file that describes the table beside it.
pub const RECORD: &str = "study.plan.toml";

/// The finished rows of an earlier table of the same study: for each run its cells by column.
pub type Rows = Vec<(String, Vec<(String, String)>)>;

/// The finished rows of the study's table in its folder, if there is one.
///
/// # Errors
/// Differences, if the table is that of another study and has finished rows. `prefix` is that of the runs' files.
pub fn rows(study: &Study, prefix: &str) -> Result<Rows, String> {
    let path = study.folder.join(FILE);
    let unreadable = |error: io::Error| format!("{} cannot be read: {error}", path.display());
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Rows::new()),
        Err(error) => return Err(unreadable(error)),
    };
    let lines = delimited::Rows::new(&text);
    let header = lines.names.clone();
    let Some(status) = (lines.place("status")).filter(|_| header[0] == "run") else {
        return Err(format!("{} is no table of a study", path.display()));
    };
    let finished = lines.filter(|row| row[status] == "finished");
    let finished: Rows = finished
        .map(|row| {
            let cells = header.iter().zip(row);
            let cells =
                cells.map(|(name, cell)| (name.clone(), in_si(study, name, cell.into_owned())));
            let cells: Vec<(String, String)> = cells.collect();
            (cells[0].1.clone(), cells)
        })
        .collect();
    if finished.is_empty() {
        // Nothing is lost with it, whatever it is of.
        return Ok(finished);
    }
    let mut differences = Vec::new();
    if header[1..status] != study.keys {
        differences.push(format!(
            "its runs differ in {}, those of this one in {}",
            all(&header[1..status]),
            all(&study.keys)
        ));
    }
    match fs::read_to_string(study.folder.join(RECORD)) {
        Ok(record) => differences.extend(other_than(study, prefix, &record)),
        // A table without a record can be compared by its keys only.
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(unreadable(error)),
    }
    if !differences.is_empty() {
        return Err(format!(
            "{}: this folder holds the table of another study ({FILE}):\n  {}",
            study.folder.display(),
            differences.join("\n  ")
        ));
    }
    Ok(finished)
}

/// A cell of a table, which may be of a version that kept the values of keys as they were typed.
fn in_si(study: &Study, column: &str, cell: String) -> String {
    let is_key = study.keys.iter().any(|key| key == column);
    let has_unit = is_key && !study.unit(column).is_empty() && cell.parse::<f64>().is_err();
    match number(column, &cell).filter(|_| has_unit) {
        Some(number) => format!("{number:?}"),
        None => cell,
    }
}

/// Names in quotes, or that there are none.
fn all(names: &[String]) -> String {
    match names {
        [] => "nothing".to_owned(),
        _ => listed(names.iter().map(String::as_str)),
    }
}

/// Says beside the table what it is of.
///
/// # Errors
/// If the file cannot be written.
pub fn write_record(study: &Study, prefix: &str) -> Result<(), String> {
    let texts = |texts: &[String]| Value::Array(texts.iter().cloned().map(Value::from).collect());
    let results = study.results.iter();
    let results: Table = results
        .map(|result| (result.name.clone(), Value::from(result.text())))
        .collect();
    let mut record = Table::new();
    record.insert("scene".to_owned(), Value::from(prefix));
    record.insert("keys".to_owned(), texts(&study.keys));
    record.insert("set".to_owned(), texts(&study.set));
    record.insert("results".to_owned(), Value::Table(results));
    write_whole(&study.folder.join(RECORD), record.to_string().as_bytes())
        .map_err(|error| error.to_string())
}

/// The differences of the recorded study from this one. New results are no difference: they cost no run.
fn other_than(study: &Study, prefix: &str, record: &str) -> Vec<String> {
    let Ok(record) = record.parse::<Table>() else {
        return vec![format!("{RECORD} cannot be understood")];
    };
    let mut differences = Vec::new();
    let scene = record.get("scene").and_then(Value::as_str);
    if let Some(scene) = scene.filter(|scene| *scene != prefix) {
        differences.push(format!(
            "it is of the scene `{scene}`, and this one of `{prefix}`"
        ));
    }
    let set = record.get("set").and_then(Value::as_array);
    let set: Vec<&str> = (set.into_iter().flatten())
        .filter_map(Value::as_str)
        .collect();
    for text in &set {
        if !study.set.iter().any(|here| here == text) {
            differences.push(format!("--set {text} is missing here"));
        }
    }
    for text in &study.set {
        if !set.contains(&text.as_str()) {
            differences.push(format!("--set {text} was not given there"));
        }
    }
    let here: BTreeMap<&str, &str> = (study.results.iter())
        .map(|result| (result.name.as_str(), result.text()))
        .collect();
    let results = record.get("results").and_then(Value::as_table);
    for (name, text) in results.into_iter().flatten() {
        let text = text.as_str().unwrap_or_default();
        match here.get(name.as_str()) {
            Some(here) if *here == text => {}
            Some(here) => {
                differences.push(format!(
                    "its result `{name}` is {text}, that of this one {here}"
                ));
            }
            None => differences.push(format!("its result {name}={text} is not requested here")),
        }
    }
    differences
}

/// Removes the existing table, its record and its plots; not the runs.
///
/// # Errors
/// The file that cannot be removed, and why.
pub fn remove(folder: &Path) -> Result<(), String> {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_plot =
            name.starts_with("study.") && (name.ends_with(".svg") || name.ends_with(".png"));
        if is_plot || [FILE, RECORD, MEANS, DIFFERENCES].contains(&name.as_str()) {
            let path = entry.path();
            fs::remove_file(&path)
                .map_err(|error| format!("{} cannot be removed: {error}", path.display()))?;
        }
    }
    Ok(())
}
