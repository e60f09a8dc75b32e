//! Puts a scene with mistakes right, so that the plan can check what remains in the same round: a particle outside of the domain
//! is reported beside a friction below zero.
//!
//! Candidates are tried at the key of each mistake until the reader accepts one: other numbers, other laws, the key left out, the
//! item of a list left out. Their meaning is of no account: a mistake that does not depend on them shows with any of them, which
//! the caller finds by mending with two scales.

use super::error::SceneError;
use super::key_path::{self, Step};
use super::overrides::entry;
use super::source::Source;
use super::tree::{Node, Value};
use super::{Draft, Scene};
use crate::units::Quantity;

/// The text of the source of all numbers that are put in.
const MENDED: &str = "put right";

/// The largest number of mistakes that are put right: each is tried with a dozen candidates.
const MOST: usize = 32;

/// A scene whose mistakes were put right in some way, to find what is wrong beside them.
#[derive(Debug)]
pub struct Mended {
    /// The scene; nothing depends on it but the errors of its other keys.
    pub scene: Scene,
    /// The keys at which something was put in or left out.
    changed: Vec<String>,
    /// The names of what was left out.
    left_out: Vec<String>,
}

impl Mended {
    /// Whether an error may come from what was put right.
    #[must_use]
    pub fn has_caused(&self, error: &SceneError) -> bool {
        let key = error.place.key();
        let is_below = |changed: &String| {
            key.strip_prefix(changed.as_str())
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        let names = |text: &str| {
            self.left_out
                .iter()
                .any(|name| text.contains(name.as_str()))
        };
        error.place.argument() == Some(MENDED)
            || self.changed.iter().any(is_below)
            || names(&error.message)
            || error.help.as_deref().is_some_and(names)
    }
}

/// Candidates for a key.
enum Candidate {
    Put(Value),
    LeaveOut,
}

/// Mends a document; see [`mend_scene_with`](super::mend_scene_with).
pub(super) fn mend(draft: &Draft<'_>, scale: f64) -> Option<Mended> {
    let mut document = draft.document.clone();
    let (mut changed, mut left_out) = (Vec::new(), Vec::new());
    loop {
        let errors = match draft.read(document.clone(), Vec::new()) {
            Ok(scene) => {
                return Some(Mended {
                    scene,
                    changed,
                    left_out,
                });
            }
            Err(errors) => errors,
        };
        if errors.len() > MOST {
            return None;
        }
        let key = errors.first()?.place.key().to_owned();
        let (steps, _) = key_path::parse(&format!("{key}=")).ok()?;
        let tried = candidates(draft, &document, &steps, scale);
        let mended = tried.into_iter().find_map(|(depth, candidate)| {
            let mut document = document.clone();
            let name = put(&mut document, &steps[..depth], candidate)?;
            is_better(
                &errors,
                &key,
                draft.read(document.clone(), Vec::new()).err(),
            )
            .then_some((document, name))
        });
        let (better, name) = mended?;
        document = better;
        if steps.last() == Some(&Step::Key("law".to_owned())) {
            // Another law has other pairs.
            changed.extend(["materials", "contacts"].map(str::to_owned));
        }
        changed.push(key);
        left_out.extend(name);
    }
}

/// Whether a document has fewer mistakes than another, none of them at `key`, and no new ones.
fn is_better(before: &[SceneError], key: &str, after: Option<Vec<SceneError>>) -> bool {
    let Some(after) = after else {
        return true;
    };
    let is_known = |error: &SceneError| {
        before
            .iter()
            .any(|known| (known.path(), &known.message) == (error.path(), &error.message))
    };
    after.len() < before.len()
        && after
            .iter()
            .all(|error| error.path() != key && is_known(error))
}

/// Candidates for the value at a path, and at how many of its steps.
fn candidates(
    draft: &Draft<'_>,
    document: &Node,
    steps: &[Step],
    scale: f64,
) -> Vec<(usize, Candidate)> {
    let node = find(document, steps);
    let mut values: Vec<Value> = Vec::new();
    let size = node.map_or(0.0, size_of);
    let near = [size, 1.0, 0.25, 2.0 / scale].map(|number| number * scale);
    let near = near
        .into_iter()
        .filter(|number| *number > 0.0 && number.is_finite());
    match node.map(|node| &node.value) {
        Some(Value::Array(items)) => {
            let first = near.clone().next().unwrap_or(1.0);
            for length in [items.len(), 3, 2] {
                let numbers = (1..=length).map(|index| Value::Float(first * index as f64));
                values.push(Value::Array(numbers.map(of_no_file).collect()));
            }
        }
        Some(Value::Boolean(value)) => values.push(Value::Boolean(!value)),
        Some(Value::Table(_)) => {}
        _ => values.extend(near.map(Value::Float)),
    }
    if matches!(steps.last(), Some(Step::Key(key)) if key == "law") {
        let laws = draft.laws.iter().flatten();
        values.extend(laws.map(|law| Value::String(law.name.to_owned())));
    }
    let values = values
        .into_iter()
        .map(|value| (steps.len(), Candidate::Put(value)));
    let fewer = (1..=steps.len()).rev();
    values
        .chain(fewer.map(|depth| (depth, Candidate::LeaveOut)))
        .collect()
}

/// The largest number of a value, without its sign and its unit; 0 if there is none.
fn size_of(node: &Node) -> f64 {
    match &node.value {
        Value::Integer(number) => (*number as f64).abs(),
        Value::Float(number) => number.abs(),
        Value::String(text) => {
            let unit = Quantity::unit_in(text).len();
            let number = text.trim().get(..text.trim().len() - unit);
            number
                .and_then(|number| number.trim().parse().ok())
                .map_or(0.0, f64::abs)
        }
        Value::Array(items) => items.iter().map(size_of).fold(0.0, f64::max),
        _ => 0.0,
    }
}

fn of_no_file(value: Value) -> Node {
    let source = Source::argument(MENDED, &super::Files::Unchecked);
    let span = 0..MENDED.len();
    Node {
        value,
        source,
        span,
    }
}

/// The item of a list that a step means.
fn index_of(items: &[Node], step: &Step) -> Option<usize> {
    match step {
        Step::Index(index) => Some(*index).filter(|index| *index < items.len()),
        Step::Key(name) => items.iter().position(|item| item.name() == Some(name)),
    }
}

fn find<'n>(node: &'n Node, steps: &[Step]) -> Option<&'n Node> {
    steps
        .iter()
        .try_fold(node, |node, step| match (&node.value, step) {
            (Value::Table(table), Step::Key(key)) => table.get(key).map(|entry| &entry.node),
            (Value::Array(items), step) => Some(&items[index_of(items, step)?]),
            _ => None,
        })
}

/// Puts a candidate at a path. Returns the name of what was left out, `None` inside where it has none, nothing where the path leads
/// nowhere.
fn put(node: &mut Node, steps: &[Step], candidate: Candidate) -> Option<Option<String>> {
    let (step, rest) = steps.split_first()?;
    match (&mut node.value, step) {
        (Value::Array(items), step) => {
            let index = index_of(items, step)?;
            let item = &mut items[index];
            if !rest.is_empty() {
                return put(item, rest, candidate);
            }
            let name = item.name().map(str::to_owned);
            match candidate {
                Candidate::Put(value) => *item = of_no_file(value),
                // The others keep their numbers.
                Candidate::LeaveOut => item.value = Value::LeftOut,
            }
            Some(name)
        }
        (Value::Table(table), Step::Key(key)) => match (rest, candidate) {
            ([], Candidate::LeaveOut) => {
                let at = table.entries.iter().position(|entry| entry.key == *key)?;
                table.entries.remove(at);
                Some(None)
            }
            ([], Candidate::Put(value)) => {
                let new = of_no_file(value);
                *entry(table, key, &new.source, &new.span) = new.clone();
                Some(None)
            }
            (rest, candidate) => {
                let at = table.entries.iter().position(|entry| entry.key == *key)?;
                put(&mut table.entries[at].node, rest, candidate)
            }
        },
        _ => None,
    }
}
