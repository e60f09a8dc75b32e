//! `[results]` and `time.until`: numbers of the run by name, and the error at which it ends.

use super::cursor::Fields;
use super::item::Item;
use super::keys::{Kind, TableKeys, key, non_negative};
use super::source::{Located, SourceSpan};
use super::tree::Value;

/// An entry of `[results]`; the solver knows the functions and sources.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultRequest {
    /// Its name.
    pub name: Located<String>,
    /// Definition of the result, such as `mean(walls.drum.ty, steady..)`.
    pub text: Located<String>,
}

/// An entry of `time.until`: the run ends when all of them hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Until {
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Name of a result.
    pub result: Located<String>,
    /// Error at which it is known: a share of the value, `"2 %"`, or a number in the unit of the result, `"0.1 N m"`.
    pub error: Located<String>,
    /// Shortest time behind the last event, s; none: by the plan.
    pub at_least: Option<Located<f64>>,
}

/// `time.until`
#[rustfmt::skip]
pub(super) static UNTIL: TableKeys = TableKeys::new(&[&[
    key("result", Kind::Name, "\"torque\"", "name of an entry of `[results]`"),
    key("error", Kind::Name, "\"2 %\"", "one standard error at which the result is known: of the magnitude of its value, or with its unit, `\"0.1 N m\"`"),
    key("at_least", non_negative("s"), "6.3", "the run does not end sooner behind the last event of the scene").or_open("three periods of each wall that turns or swings, 20 falls through the domain"),
]]);

/// The entries of `[results]`.
pub(super) fn read(fields: &Fields<'_>) -> Vec<ResultRequest> {
    let entries = fields.entries().filter_map(|(name, item)| {
        let text = item.line()?;
        Some(ResultRequest { name, text })
    });
    entries.collect()
}

/// One table, or a list of them.
pub(super) fn read_until(item: &Item<'_>) -> Vec<Until> {
    let items = match &item.node.value {
        Value::Array(_) => item.list().unwrap_or_default(),
        _ => return read_one(item).into_iter().collect(),
    };
    items.iter().filter_map(read_one).collect()
}

fn read_one(item: &Item<'_>) -> Option<Until> {
    let fields = item.open(&UNTIL)?;
    Some(Until {
        place: item.place.clone(),
        result: fields.read("result"),
        error: fields.read("error"),
        at_least: fields.read("at_least"),
    })
}
