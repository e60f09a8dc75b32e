//! `--json` after an error: the problems as one object on standard output.

use std::ffi::OsString;

use mercury_common::cli::{Failure, say};
use mercury_common::problem::{Problem, Spot};
use mercury_common::readable::shortened;
use serde_json::{Value, json};

/// More than an editor can show.
const MOST: usize = 1000;

/// Characters of a message: it quotes the file, which may hold anything.
const LONGEST: usize = 1000;

/// Whether the command line has `--json`, also if the rest of it is wrong.
pub(crate) fn are_requested(words: &[OsString]) -> bool {
    let mut options = words.iter().skip(1).take_while(|word| *word != "--");
    options.any(|word| word == "--json")
}

/// Prints the error as an object, if nothing was printed before.
pub(crate) fn tell(failure: &Failure) {
    if let Some(problems) = failure.problems() {
        // A closed standard output is not an error here: the exit code carries the result.
        let _ = say_object(&of(&problems));
    }
}

/// The object of these problems.
pub(crate) fn of(problems: &[Problem]) -> Value {
    json!({
        "problems": list(problems),
        "more": problems.len().saturating_sub(MOST),
    })
}

/// The first of them, each an object.
pub(crate) fn list(problems: &[Problem]) -> Value {
    problems.iter().take(MOST).map(one).collect()
}

fn one(problem: &Problem) -> Value {
    let line = |spot: Option<Spot>| spot.map(|spot| spot.line);
    let column = |spot: Option<Spot>| spot.map(|spot| spot.column);
    let short = |text: &str| shortened(text, LONGEST).into_owned();
    let mut object = json!({
        "file": problem.file,
        "line": line(problem.start),
        "column": column(problem.start),
        "end_line": line(problem.end),
        "end_column": column(problem.end),
        "key": problem.key.as_deref().map(short),
        "message": short(&problem.message),
        "help": problem.help.as_deref().map(short),
    });
    if let Some(set) = &problem.set {
        object["set"] = json!(short(set));
    }
    object
}

/// Says an object.
pub(crate) fn say_object(object: &Value) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(object).map_err(Failure::run)?;
    say(&text)
}
