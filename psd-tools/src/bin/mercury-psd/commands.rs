//! Subcommands: each reads its input, computes, and prints.

pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod fit;
pub(crate) mod plot;
pub(crate) mod sample;
pub(crate) mod stats;

use std::path::Path;

use mercury_common::cli::{Failure, Outcome, say};
use mercury_common::sizes::table::{Options, parse_size_unit};
use mercury_pictures::charts::ChartPage;
use mercury_psd::input::{self, Source};
use mercury_psd::parquet;
use mercury_psd::statistics::Unit;
use serde_json::Value;

fn sources(files: &[String], options: &Options) -> Result<Vec<Source>, Failure> {
    let mut sources = Vec::new();
    for file in files {
        sources.extend(input::read(file, options).map_err(Failure::input)?);
    }
    Ok(sources)
}

/// The one source of an argument.
fn source(file: &str, options: &Options) -> Result<Source, Failure> {
    let mut sources = input::read(file, options).map_err(Failure::input)?;
    if sources.len() > 1 {
        let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
        let message = format!("{file}: several kinds of particles: {}", names.join(", "));
        return Err(Failure::input(message).with_help("this command takes one kind"));
    }
    sources
        .pop()
        .ok_or_else(|| Failure::input(format!("{file}: nothing to read")))
}

fn say_json(value: &Value) -> Outcome {
    let text = serde_json::to_string_pretty(value).map_err(Failure::run)?;
    say(&text)
}

/// Notes of reading, as lines of a report.
fn notes(source: &Source) -> String {
    source
        .notes
        .iter()
        .map(|note| format!("  note: {note}\n"))
        .collect()
}

/// Prints a text to standard error where standard output is for numbers.
fn say_beside(text: &str) {
    use std::io::Write as _;
    // A closed stream is not an error here.
    let _ = write!(std::io::stderr(), "{text}");
}

fn unit(word: &str) -> Result<Unit, Failure> {
    let units = ["m", "cm", "mm", "um", "nm"];
    let name = units.into_iter().find(|name| *name == word);
    match (name, parse_size_unit(word)) {
        (Some(name), Some(per_metre)) => Ok(Unit { name, per_metre }),
        _ => Err(Failure::input(format!(
            "--to-unit {word}: expected one of {}",
            units.join(", ")
        ))),
    }
}

/// Writes a file; a table or list as Parquet if its name ends so.
fn write(path: &Path, bytes: &[u8]) -> Outcome {
    if parquet::is_named(path) {
        return parquet::write(path, &String::from_utf8_lossy(bytes)).map_err(Failure::run);
    }
    std::fs::write(path, bytes).map_err(|error| {
        Failure::run(format!(
            "{}: the file cannot be written: {error}",
            path.display()
        ))
    })
}

/// Writes NAME.svg and NAME.png and prints their names.
fn draw(page: &ChartPage, stem: &Path) -> Result<String, Failure> {
    page.write(stem).map_err(Failure::run)?;
    let stem = stem.display();
    Ok(format!("written: {stem}.svg, {stem}.png\n"))
}
