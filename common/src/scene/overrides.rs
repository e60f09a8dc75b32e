//! `--set KEY=VALUE`: any key of the document, before anything is checked.

use std::sync::Arc;

use super::cursor::Files;
use super::error::SceneError;
use super::key_path::{self, Step};
use super::source::{Source, SourceSpan};
use super::spelling::{listed, nearest};
use super::tree::{Node, Table, Value, parse_value};

/// More than any key of the format has: each level is reported with all levels above it.
const MOST_LEVELS: usize = 32;

/// Sets a key of the document, in place of what was there or in addition to it.
///
/// `argument` is `KEY=VALUE`: `time.end=0.1`, `insertions[0].total.number=10`,
/// `insertions.rain.total.number=10` (an entry of a list by its `name`). The value is TOML; a bare
/// word that is no TOML value is a string.
///
/// Returns the path of the key, as messages have it.
///
/// # Errors
/// When the path leads nowhere, or the value is a list, table or string that does not parse.
pub(super) fn apply(
    document: &mut Node,
    argument: &str,
    files: &Files,
) -> Result<String, SceneError> {
    let source = Source::argument(argument, files);
    let whole = SourceSpan::new(&source, 0..argument.len(), "");
    let (steps, equals) = key_path::parse(argument).map_err(|problem| {
        whole
            .error(problem)
            .with_help("write it as KEY=VALUE, for example time.end=0.1")
    })?;
    if steps.len() > MOST_LEVELS {
        let message = format!(
            "a path of {} keys: no scene is deeper than {MOST_LEVELS}",
            steps.len()
        );
        return Err(whole.error(message));
    }
    let value = read_value(&source, argument, equals + 1)?;
    let key_span = 0..equals;

    let mut node = document;
    let mut path = String::new();
    let last = steps.len() - 1;
    for (i, step) in steps.iter().enumerate() {
        let by_number = number_of_entry(&node.value, step, &path);
        let step = by_number.as_ref().unwrap_or(step);
        let at = |path: &str| SourceSpan::new(&source, key_span.clone(), path);
        node = match (&mut node.value, step) {
            (Value::Array(items), Step::Index(index)) => {
                let count = items.len();
                let name = items
                    .get(*index)
                    .and_then(|item| item.name().map(str::to_owned));
                let here = key_path::item(&path, *index, name.as_deref());
                let item = items.get_mut(*index).ok_or_else(|| {
                    at(&path).error(format!(
                        "there is no item [{index}]: the list has {count}, counted from 0"
                    ))
                })?;
                path = here;
                item
            }
            (Value::Array(items), Step::Key(name)) => {
                let names: Vec<String> = items
                    .iter()
                    .filter_map(|item| item.name().map(str::to_owned))
                    .collect();
                let count = items.len();
                let found = items.iter_mut().find(|item| item.name() == Some(name));
                let list = path.clone();
                path = key_path::child(&path, name);
                found.ok_or_else(|| {
                    if names.is_empty() {
                        nameless(&at(&path), name, &list, count)
                    } else {
                        unknown_name(&at(&path), name, &names)
                    }
                })?
            }
            (Value::Table(table), Step::Key(key)) => {
                let is_new = table.get(key).is_none();
                // Below these two tables stand names of the user's choice: a slip there would
                // make a new, half-empty material.
                if is_new && i < last && (path == "materials" || path == "clumps") {
                    let names: Vec<String> = table
                        .entries
                        .iter()
                        .map(|entry| entry.key.clone())
                        .collect();
                    path = key_path::child(&path, key);
                    return Err(unknown_name(&at(&path), key, &names));
                }
                path = key_path::child(&path, key);
                entry(table, key, &source, &key_span)
            }
            (Value::Table(_), Step::Index(index)) => {
                return Err(at(&path).error(format!("is a table, it has no item [{index}]")));
            }
            (other, _) => {
                let kind = other.type_name();
                return Err(at(&path).error(format!("is {kind}, there are no keys below it")));
            }
        };
    }
    *node = value;
    Ok(path)
}

/// The index that `list.1` means: a number, counted from 0 as in `list[1]`, where no entry has that name. Materials and clumps are
/// numbered in the order of the file: the name that `materials.0` means.
fn number_of_entry(value: &Value, step: &Step, path: &str) -> Option<Step> {
    if let (Value::Table(table), "materials" | "clumps") = (value, path) {
        let number: usize = match step {
            Step::Index(number) => *number,
            Step::Key(name) if table.get(name).is_none() => name.parse().ok()?,
            Step::Key(_) => return None,
        };
        let entry = table.entries.get(number)?;
        return Some(Step::Key(entry.key.clone()));
    }
    let (Value::Array(items), Step::Key(name)) = (value, step) else {
        return None;
    };
    if items.iter().any(|item| item.name() == Some(name)) {
        return None;
    }
    name.parse().ok().map(Step::Index)
}

/// No entry of the list has a name.
fn nameless(place: &SourceSpan, name: &str, list: &str, count: usize) -> SceneError {
    let error = place.error(format!("there is nothing named `{name}`"));
    if count == 0 {
        return error.with_help("the list is empty");
    }
    error.with_help(format!(
        "its entries have no names: write {list}[0] (or {list}.0) for the first of {count}"
    ))
}

fn unknown_name(place: &SourceSpan, name: &str, names: &[String]) -> SceneError {
    let error = place.error(format!("there is nothing named `{name}`"));
    match nearest(name, names.iter().map(String::as_str)) {
        Some(near) => error.with_help(format!("did you mean `{near}`?")),
        None if names.is_empty() => error,
        None => error.with_help(format!(
            "there are: {}",
            listed(names.iter().map(String::as_str))
        )),
    }
}

/// The entry of a key, made as an empty table if it is not there yet.
pub(super) fn entry<'a>(
    table: &'a mut Table,
    key: &str,
    source: &Arc<Source>,
    span: &std::ops::Range<usize>,
) -> &'a mut Node {
    let position = table.entries.iter().position(|entry| entry.key == key);
    let position = position.unwrap_or_else(|| {
        table.entries.push(super::tree::Entry {
            key: key.to_owned(),
            source: Arc::clone(source),
            span: span.clone(),
            node: Node {
                value: Value::Table(Table::default()),
                source: Arc::clone(source),
                span: span.clone(),
            },
        });
        table.entries.len() - 1
    });
    &mut table.entries[position].node
}

fn read_value(source: &Arc<Source>, argument: &str, start: usize) -> Result<Node, SceneError> {
    let text = &argument[start..];
    let offset = start + (text.len() - text.trim_start().len());
    let text = text.trim();
    match parse_value(source, text, offset) {
        Ok(node) => Ok(node),
        Err(error) if text.is_empty() || text.starts_with(['"', '\'', '[', '{']) => Err(error),
        Err(_) => Ok(Node {
            value: Value::String(text.to_owned()),
            source: Arc::clone(source),
            span: offset..offset + text.len(),
        }),
    }
}
