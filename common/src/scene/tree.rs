//! The document as a tree in which every key and value has its place.

use std::collections::HashSet;
use std::ops::Range;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeFloat, DeInteger, DeTable, DeValue};

use super::error::{SceneError, SceneErrors};
use super::json::{self, is_json};
use super::source::{Source, SourceSpan};
use super::spelling::{self, with_comma};

/// A value and its span.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) source: Arc<Source>,
    pub(super) span: Range<usize>,
}

/// Value of TOML.
#[derive(Debug, Clone)]
pub(super) enum Value {
    String(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Datetime,
    Array(Vec<Node>),
    Table(Table),
    /// An item of a list that counts and is not read ([`mend`](super::mend)).
    LeftOut,
}

impl Value {
    /// The type in words, with its article.
    pub(super) fn type_name(&self) -> &'static str {
        match self {
            Value::String(_) => "a string",
            Value::Integer(_) | Value::Float(_) => "a number",
            Value::Boolean(_) => "true or false",
            Value::Datetime => "a date or time",
            Value::Array(_) => "a list",
            Value::Table(_) => "a table",
            Value::LeftOut => "nothing",
        }
    }
}

/// A table in the order of the file.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    pub(super) entries: Vec<Entry>,
}

/// A key with its value.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) source: Arc<Source>,
    pub(super) span: Range<usize>,
    pub(super) node: Node,
}

impl Table {
    /// The entry of a key.
    pub(super) fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }
}

impl Node {
    /// The `name` of a table, where it has one.
    pub(super) fn name(&self) -> Option<&str> {
        let Value::Table(table) = &self.value else {
            return None;
        };
        match &table.get("name")?.node.value {
            Value::String(name) if !name.is_empty() => Some(name),
            _ => None,
        }
    }
}

const NOT_TOML: &str = "not valid TOML: ";
/// Advice on paths as Windows writes them.
pub(super) const BACKSLASHES: &str = "write `/` between folders, also on Windows; a `\\` begins an escape in double quotes, such as `\\t` for a tab, and none in single quotes";

/// Help for a mistake of TOML that a path of Windows in double quotes makes, by the parser's message.
#[must_use]
pub fn help_with_backslashes(message: &str) -> Option<&'static str> {
    // A path may go on as two to eight digits of an escape do: C:\Users, D:\xyz.
    let of_escapes = ["missing escaped value", "too few unicode value digits"];
    let is_one = of_escapes.iter().any(|start| message.starts_with(start));
    is_one.then_some(BACKSLASHES)
}

/// Parses a document, in TOML or JSON. Syntax errors are reported at once, at most one per line.
pub(super) fn parse_document(source: &Arc<Source>, text: &str) -> Result<Node, SceneErrors> {
    if is_json(source.name(), text) {
        return json::parse_document(source, text);
    }
    let (table, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Ok(Node {
            value: Value::Table(convert_table(table.get_ref(), source, 0)),
            source: Arc::clone(source),
            span: 0..0,
        });
    }
    let errors = errors
        .iter()
        .map(|error| syntax_error(error, source, text, 0));
    Err(SceneErrors(independent(errors.collect(), source, text)))
}

/// The largest number of syntax errors that are looked at one by one. Each look parses the text three times.
const MOST_SYNTAX_ERRORS: usize = 50;

/// Lines with syntax errors above which the text is taken for something else than a scene, and all are reported: looks take time for each of them.
const MOST_BAD_LINES: usize = 200;

/// Syntax errors that do not follow from another, at most one per line: a quote or a bracket that is not closed turns what
/// follows into errors. An error follows from another if it is gone once the line of that one, or the line before it, is blank.
fn independent(mut errors: Vec<SceneError>, source: &Arc<Source>, text: &str) -> Vec<SceneError> {
    errors.sort_by_key(|error| error.place.order());
    let mut lines = HashSet::new();
    errors.retain(|error| lines.insert(error.place.line()));
    if errors.len() > MOST_BAD_LINES {
        return errors;
    }
    let mut text = text.to_owned();
    let mut found = Vec::new();
    while !errors.is_empty() && found.len() < MOST_SYNTAX_ERRORS {
        let first = errors.remove(0);
        let line = first.place.line();
        let remaining = [(line, line), (line - 1, line - 1), (line - 1, line)]
            .into_iter()
            .filter(|(low, _)| *low > 0)
            .map(|(low, high)| {
                let blank = without_lines(&text, low, high);
                let (_, now) = DeTable::parse_recoverable(&blank);
                let now: HashSet<usize> = (now.iter())
                    .map(|error| syntax_error(error, source, &blank, 0).place.line())
                    .collect();
                let left = errors
                    .iter()
                    .filter(|error| now.contains(&error.place.line()));
                (left.cloned().collect::<Vec<_>>(), blank)
            })
            .min_by_key(|(left, _)| left.len());
        found.push(first);
        if let Some(remaining) = remaining {
            (errors, text) = remaining;
        }
    }
    found.extend(errors);
    found
}

/// The text with spaces in the place of the characters of these lines, counted from 1.
fn without_lines(text: &str, low: usize, high: usize) -> String {
    let lines = text.split_inclusive('\n').enumerate();
    let blank = |line: &str| -> String {
        let end = line.trim_end_matches(['\n', '\r']).len();
        " ".repeat(end) + &line[end..]
    };
    lines
        .map(|(index, line)| match (low..=high).contains(&(index + 1)) {
            true => blank(line),
            false => line.to_owned(),
        })
        .collect()
}

/// Parses one value that starts at byte `offset` of its source.
pub(super) fn parse_value(
    source: &Arc<Source>,
    text: &str,
    offset: usize,
) -> Result<Node, SceneError> {
    match DeValue::parse(text) {
        Ok(value) => Ok(convert(&value, source, offset)),
        Err(error) => Err(syntax_error(&error, source, text, offset)),
    }
}

fn syntax_error(
    error: &toml::de::Error,
    source: &Arc<Source>,
    text: &str,
    offset: usize,
) -> SceneError {
    let span = error.span().unwrap_or(0..0);
    let found = text.get(span.clone()).unwrap_or_default();
    let place = SourceSpan::new(source, span.start + offset..span.end + offset, "");
    if let Some(number) = decimal_comma(text, &span) {
        let (message, help) = with_comma(number);
        return place.error(message).with_help(help);
    }
    // The parser's own words, except where they mislead.
    match error.message() {
        "duplicate key" => place.error(format!("`{found}` is given twice")),
        message if message.starts_with("string values must be quoted") => {
            if found.trim().is_empty() {
                place.error("a value is missing here")
            } else {
                place
                    .error("this is not a TOML value")
                    .with_help("text goes in double quotes")
            }
        }
        message if message.starts_with("missing comma") => place
            .error(format!("{NOT_TOML}{message}"))
            .with_help("is a list or table before this line not closed?"),
        message => {
            let error = place.error(format!("{NOT_TOML}{message}"));
            match help_with_backslashes(message) {
                Some(help) => error.with_help(help),
                None => error,
            }
        }
    }
}

/// The number with a comma between its digits that stands behind the `=` of the line of a mistake, if it is what the parser stopped at.
fn decimal_comma<'t>(text: &'t str, at: &Range<usize>) -> Option<&'t str> {
    // No more than a key and a number take: there may be as many mistakes as bytes in a line without end.
    let near = |at: usize| {
        (0..=at.min(text.len()))
            .rev()
            .find(|&at| text.is_char_boundary(at))
    };
    let (first, last) = (near(at.start.saturating_sub(100))?, near(at.start + 100)?);
    let before = text.get(first..at.start)?;
    let begin = match before.rfind('\n') {
        Some(end) => first + end + 1,
        None if first == 0 => 0,
        None => return None,
    };
    let line = text.get(begin..last)?.lines().next()?;
    let equals = line.find('=')?;
    let number = line[equals + 1..].split('#').next()?.trim();
    let number = spelling::decimal_comma(number)?;
    // With a unit it is no number of TOML either way.
    let is_alone = |c: char| c.is_ascii_digit() || "+-,eE".contains(c);
    number.chars().all(is_alone).then_some(number)
}

fn convert(value: &Spanned<DeValue<'_>>, source: &Arc<Source>, offset: usize) -> Node {
    let span = value.span();
    Node {
        value: match value.get_ref() {
            DeValue::String(text) => Value::String(text.clone().into_owned()),
            DeValue::Integer(number) => integer(number),
            DeValue::Float(number) => Value::Float(float(number)),
            DeValue::Boolean(value) => Value::Boolean(*value),
            DeValue::Datetime(_) => Value::Datetime,
            DeValue::Array(items) => Value::Array(
                items
                    .iter()
                    .map(|item| convert(item, source, offset))
                    .collect(),
            ),
            DeValue::Table(table) => Value::Table(convert_table(table, source, offset)),
        },
        source: Arc::clone(source),
        span: span.start + offset..span.end + offset,
    }
}

fn convert_table(table: &DeTable<'_>, source: &Arc<Source>, offset: usize) -> Table {
    let entries = table
        .iter()
        .map(|(key, value)| {
            let span = key.span();
            Entry {
                key: key.get_ref().clone().into_owned(),
                source: Arc::clone(source),
                span: span.start + offset..span.end + offset,
                node: convert(value, source, offset),
            }
        })
        .collect();
    Table { entries }
}

/// A whole number; as a float where it is beyond 64 bits, so that the reader can name its limits.
fn integer(number: &DeInteger<'_>) -> Value {
    let digits = number.as_str();
    match i64::from_str_radix(digits, number.radix()) {
        Ok(value) => Value::Integer(value),
        Err(_) => {
            let radix = f64::from(number.radix());
            let magnitude = digits
                .chars()
                .filter_map(|c| c.to_digit(number.radix()))
                .fold(0.0, |sum, digit| sum * radix + f64::from(digit));
            Value::Float(if digits.starts_with('-') {
                -magnitude
            } else {
                magnitude
            })
        }
    }
}

/// A float; one that is too large is infinite, which the reader refuses where it is read.
fn float(number: &DeFloat<'_>) -> f64 {
    number.as_str().parse().unwrap_or(f64::NAN)
}
