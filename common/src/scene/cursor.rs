//! The typed reader over the document: it knows the key path, what was asked for, and collects every
//! problem instead of stopping at the first.
//!
//! A method that reads returns `None` after it has reported; callers read everything they need and
//! only then give up, so that one run names all mistakes.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::error::SceneError;
use super::key_path;
use super::source::{Located, Place};
use super::spelling::{listed, nearest};
use super::tree::{Entry, Node, Table, Value};
use super::{ClumpIndex, MaterialIndex};

/// Up to this many allowed keys are listed when one is not known.
const SHORT_LIST: usize = 12;

/// Whether the files that a scene names must exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Files {
    /// A file that is missing is an error.
    MustExist,
    /// Files are not looked for, as in an editor or where only the text is at hand.
    Unchecked,
}

/// What all cursors of a document share.
pub(super) struct Context {
    pub(super) errors: RefCell<Vec<SceneError>>,
    pub(super) directory: PathBuf,
    pub(super) files: Files,
    pub(super) materials: Vec<String>,
    pub(super) clumps: Vec<String>,
}

impl Context {
    pub(super) fn report(&self, error: SceneError) {
        self.errors.borrow_mut().push(error);
    }

    /// Reports every `name` that stands twice in a list, whether or not its entry is right otherwise.
    pub(super) fn unique_names(&self, items: &[Item<'_>]) {
        let mut seen: Vec<Located<&str>> = Vec::new();
        for item in items {
            let Value::Table(table) = &item.node.value else {
                continue;
            };
            let Some((name, entry)) = item.node.name().zip(table.get("name")) else {
                continue;
            };
            let path = key_path::child(item.place.key(), "name");
            let place = Place::new(&entry.node.source, entry.node.span.clone(), path);
            match seen.iter().find(|other| other.value == name) {
                Some(first) => {
                    let error = place.error(format!("the name `{name}` is used twice"));
                    self.report(if first.place.is_argument() {
                        error
                    } else {
                        error.with_help(format!("first in line {}", first.place.line()))
                    });
                }
                None => seen.push(Located { value: name, place }),
            }
        }
    }
}

/// A value of the document with its key path.
#[derive(Clone)]
pub(super) struct Item<'a> {
    pub(super) context: &'a Context,
    pub(super) node: &'a Node,
    pub(super) place: Place,
}

/// A table of the document and the keys that were asked for.
pub(super) struct Fields<'a> {
    pub(super) context: &'a Context,
    table: &'a Table,
    place: Place,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Fields<'a> {
    pub(super) fn new(context: &'a Context, table: &'a Table, place: Place) -> Self {
        Self {
            context,
            table,
            place,
            asked: RefCell::new(Vec::new()),
        }
    }

    /// The place of the table.
    pub(super) fn place(&self) -> &Place {
        &self.place
    }

    /// The place of the table under the path of a key that is not there.
    pub(super) fn absent(&self, key: &str) -> Place {
        self.place.with_key(key_path::child(self.place.key(), key))
    }

    /// Whether the key is there; does not count as asking for it.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some()
    }

    /// The value of a key that may be left out.
    pub(super) fn get(&self, key: &'static str) -> Option<Item<'a>> {
        self.asked.borrow_mut().push(key);
        self.table.get(key).map(|entry| self.item(entry))
    }

    /// The value of a key that must be there.
    pub(super) fn need(&self, key: &'static str) -> Option<Item<'a>> {
        self.need_or_help(key, None)
    }

    /// The value of a key that must be there, with a hint for who left it out.
    pub(super) fn need_or_help(&self, key: &'static str, help: Option<&str>) -> Option<Item<'a>> {
        let item = self.get(key);
        if item.is_none() {
            // A misspelt key is reported once, as unknown, with the right spelling.
            let misspelt = self.table.entries.iter().any(|entry| {
                !self.asked.borrow().contains(&entry.key.as_str())
                    && nearest(&entry.key, [key]).is_some()
            });
            if !misspelt {
                let error = self.absent(key).error("is missing");
                self.context.report(SceneError {
                    help: help.map(str::to_owned),
                    ..error
                });
            }
        }
        item
    }

    /// A default, at the place where the key could stand.
    pub(super) fn default<T>(&self, key: &str, value: T) -> Located<T> {
        Located {
            value,
            place: self.absent(key),
        }
    }

    /// Every key with its value, for tables whose keys are the user's names.
    pub(super) fn entries(&self) -> impl Iterator<Item = (Located<String>, Item<'a>)> {
        self.table.entries.iter().map(|entry| {
            let path = key_path::child(self.place.key(), &entry.key);
            let place = Place::new(&entry.source, entry.span.clone(), path);
            (
                Located {
                    value: entry.key.clone(),
                    place,
                },
                self.item(entry),
            )
        })
    }

    fn item(&self, entry: &'a Entry) -> Item<'a> {
        let path = key_path::child(self.place.key(), &entry.key);
        let place = Place::new(&entry.node.source, entry.node.span.clone(), path);
        Item {
            context: self.context,
            node: &entry.node,
            place,
        }
    }

    /// Of keys that exclude each other: reports when more than one is there, or, where one is
    /// `needed`, none. True when exactly one is there.
    pub(super) fn exactly_one(&self, keys: &[&'static str], needed: bool) -> bool {
        let given: Vec<&str> = keys.iter().copied().filter(|key| self.has(key)).collect();
        match given.as_slice() {
            [] => {
                if needed {
                    // As in `need`: a misspelt key is reported once.
                    let misspelt = self.table.entries.iter().any(|entry| {
                        !self.asked.borrow().contains(&entry.key.as_str())
                            && nearest(&entry.key, keys.iter().copied()).is_some()
                    });
                    if !misspelt {
                        let keys: Vec<String> = keys.iter().map(|k| format!("`{k}`")).collect();
                        self.context
                            .report(self.place.error(format!("needs {}", keys.join(" or "))));
                    }
                }
                false
            }
            [_] => true,
            [first, second, ..] => {
                if let Some(entry) = self.table.get(second) {
                    self.context.report(self.item(entry).place.error(format!(
                        "cannot be given together with `{first}`: choose one"
                    )));
                }
                false
            }
        }
    }

    /// Reports every key that nobody asked for.
    pub(super) fn finish(&self) {
        let asked = self.asked.borrow();
        for entry in &self.table.entries {
            if asked.contains(&entry.key.as_str()) {
                continue;
            }
            let path = key_path::child(self.place.key(), &entry.key);
            let error =
                Place::new(&entry.source, entry.span.clone(), path).error("is not a known key");
            let mut allowed: Vec<&str> = Vec::new();
            for key in asked.iter() {
                if !allowed.contains(key) {
                    allowed.push(key);
                }
            }
            self.context
                .report(match nearest(&entry.key, allowed.iter().copied()) {
                    Some(near) => error.with_help(format!("did you mean `{near}`?")),
                    None if allowed.len() <= SHORT_LIST => {
                        error.with_help(format!("allowed here: {}", listed(allowed)))
                    }
                    None => error,
                });
        }
    }
}

impl<'a> Item<'a> {
    pub(super) fn report(&self, message: impl Into<String>) {
        self.context.report(self.place.error(message));
    }

    fn located<T>(&self, value: T) -> Located<T> {
        Located {
            value,
            place: self.place.clone(),
        }
    }

    fn expected<T>(&self, what: &str) -> Option<T> {
        self.report(format!(
            "expected {what}, got {}",
            self.node.value.type_name()
        ));
        None
    }

    fn got(&self) -> &str {
        self.place.text()
    }

    pub(super) fn table(&self) -> Option<Fields<'a>> {
        match &self.node.value {
            Value::Table(table) => Some(Fields::new(self.context, table, self.place.clone())),
            _ => self.expected("a table"),
        }
    }

    pub(super) fn is_text(&self) -> bool {
        matches!(self.node.value, Value::String(_))
    }

    pub(super) fn list(&self) -> Option<Vec<Item<'a>>> {
        let Value::Array(nodes) = &self.node.value else {
            return self.expected("a list");
        };
        let item = |(index, node): (usize, &'a Node)| {
            let path = key_path::item(self.place.key(), index, node.name());
            let place = Place::new(&node.source, node.span.clone(), path);
            Item {
                context: self.context,
                node,
                place,
            }
        };
        Some(nodes.iter().enumerate().map(item).collect())
    }

    pub(super) fn text(&self) -> Option<Located<String>> {
        match &self.node.value {
            Value::String(text) => Some(self.located(text.clone())),
            _ => self.expected("a string"),
        }
    }

    /// A name: a string that is not empty and stays on its line.
    pub(super) fn name(&self) -> Option<Located<String>> {
        let name = self.text()?;
        if name.trim().is_empty() {
            self.report("must not be empty");
            return None;
        }
        if name.chars().any(char::is_control) {
            self.report("must not hold line breaks or other control characters");
            return None;
        }
        Some(name)
    }

    pub(super) fn boolean(&self) -> Option<bool> {
        match self.node.value {
            Value::Boolean(value) => Some(value),
            _ => self.expected("true or false"),
        }
    }

    pub(super) fn whole(&self, smallest: u64) -> Option<Located<u64>> {
        match self.node.value {
            Value::Integer(value) => match u64::try_from(value) {
                Ok(value) if value >= smallest => Some(self.located(value)),
                _ => {
                    self.report(format!("must be >= {smallest}, got {}", self.got()));
                    None
                }
            },
            Value::Float(_) => {
                self.report(format!(
                    "expected a whole number up to {}, got {}",
                    i64::MAX,
                    self.got()
                ));
                None
            }
            _ => self.expected("a whole number"),
        }
    }

    /// A finite number.
    pub(super) fn number(&self) -> Option<Located<f64>> {
        let value = match self.node.value {
            Value::Float(value) => value,
            Value::Integer(value) => value as f64,
            _ => return self.expected("a number"),
        };
        if !value.is_finite() {
            self.report(format!("must be finite, got {}", self.got()));
            return None;
        }
        Some(self.located(value))
    }

    fn checked(&self, rule: &str, holds: impl Fn(f64) -> bool) -> Option<Located<f64>> {
        let number = self.number()?;
        if !holds(*number) {
            self.report(format!("must {rule}, got {}", self.got()));
            return None;
        }
        Some(number)
    }

    pub(super) fn positive(&self) -> Option<Located<f64>> {
        self.checked("be > 0", |value| value > 0.0)
    }

    pub(super) fn non_negative(&self) -> Option<Located<f64>> {
        self.checked("be >= 0", |value| value >= 0.0)
    }

    /// A number in [0, 1].
    pub(super) fn fraction(&self) -> Option<Located<f64>> {
        self.checked("lie in [0, 1]", |value| (0.0..=1.0).contains(&value))
    }

    /// A number in (-1, 0.5]: what thermodynamics allows for an isotropic solid.
    pub(super) fn poisson_ratio(&self) -> Option<Located<f64>> {
        self.checked("lie in (-1, 0.5]", |value| value > -1.0 && value <= 0.5)
    }

    /// A number in [low, high].
    pub(super) fn between(&self, low: f64, high: f64) -> Option<Located<f64>> {
        self.checked(&format!("lie in [{low}, {high}]"), |value| {
            (low..=high).contains(&value)
        })
    }

    /// `N` finite numbers.
    pub(super) fn numbers<const N: usize>(&self) -> Option<Located<[f64; N]>> {
        let Value::Array(_) = self.node.value else {
            return self.expected(&format!("a list of {N} numbers"));
        };
        let items = self.list()?;
        if items.len() != N {
            self.report(format!("expected {N} numbers, got {}", items.len()));
            return None;
        }
        let read: Vec<Option<Located<f64>>> = items.iter().map(Item::number).collect();
        let mut numbers = [0.0; N];
        for (number, read) in numbers.iter_mut().zip(read) {
            *number = read?.value;
        }
        Some(self.located(numbers))
    }

    pub(super) fn vector(&self) -> Option<Located<DVec3>> {
        Some(self.numbers::<3>()?.map(DVec3::from_array))
    }

    /// A vector that is not zero, scaled to length 1.
    pub(super) fn direction(&self) -> Option<Located<DVec3>> {
        let vector = self.vector()?;
        // Scaled first, so that the squares of the length neither overflow nor vanish.
        let direction = *vector / vector.abs().max_element();
        match direction.try_normalize() {
            Some(direction) => Some(vector.map(|_| direction)),
            None => {
                self.report("must not be of length 0");
                None
            }
        }
    }

    /// Two numbers, the first smaller than the second.
    pub(super) fn range(&self) -> Option<Located<[f64; 2]>> {
        let range = self.numbers::<2>()?;
        if range[0] >= range[1] {
            self.report(format!(
                "must be [low, high] with low < high, got {}",
                self.got()
            ));
            return None;
        }
        Some(range)
    }

    /// One word of a list; `what` names the kind of thing in the message.
    pub(super) fn word<T: Copy>(&self, what: &str, words: &[(&str, T)]) -> Option<T> {
        let text = self.text()?;
        if let Some((_, value)) = words.iter().find(|(word, _)| *word == text.value) {
            return Some(*value);
        }
        let all = || listed(words.iter().map(|(word, _)| *word));
        let help = match nearest(&text, words.iter().map(|(word, _)| *word)) {
            Some(near) if words.len() == 1 => format!("did you mean `{near}`?"),
            Some(near) => format!("did you mean `{near}`? There are: {}", all()),
            None => format!("there are: {}", all()),
        };
        let message = format!("there is no {what} {:?}", text.value);
        self.context
            .report(self.place.error(message).with_help(help));
        None
    }

    /// True for the one word that may stand where a number is expected; any other text is reported.
    pub(super) fn keyword(&self, word: &str) -> Option<()> {
        let text = self.text()?;
        if text.value != word {
            self.report(format!(
                "expected a number or {word:?}, got {:?}",
                text.value
            ));
            return None;
        }
        Some(())
    }

    pub(super) fn material(&self) -> Option<Located<MaterialIndex>> {
        self.reference("material", &self.context.materials)
            .map(|index| index.map(MaterialIndex))
    }

    pub(super) fn clump(&self) -> Option<Located<ClumpIndex>> {
        self.reference("clump", &self.context.clumps)
            .map(|index| index.map(ClumpIndex))
    }

    fn reference(&self, what: &str, names: &[String]) -> Option<Located<usize>> {
        let text = self.text()?;
        let position = names.iter().position(|name| *name == text.value);
        if position.is_none() {
            let error = self
                .place
                .error(format!("there is no {what} {:?}", text.value));
            let names = || names.iter().map(String::as_str);
            self.context.report(match nearest(&text, names()) {
                Some(near) => error.with_help(format!("did you mean `{near}`?")),
                None if names().next().is_none() => error.with_help(format!(
                    "a table [{what}s.{}] is needed",
                    key_path::quoted(&text)
                )),
                None => error.with_help(format!("there are: {}", listed(names()))),
            });
        }
        Some(self.located(position?))
    }

    /// A file, relative to the folder of the scene.
    pub(super) fn file(&self) -> Option<Located<PathBuf>> {
        self.path("file", "is a folder, not a file", Path::is_file)
    }

    /// A folder, relative to the folder of the scene.
    pub(super) fn folder(&self) -> Option<Located<PathBuf>> {
        self.path("folder", "is not a folder", Path::is_dir)
    }

    fn path(
        &self,
        what: &str,
        otherwise: &str,
        is_right: impl Fn(&Path) -> bool,
    ) -> Option<Located<PathBuf>> {
        let name = self.name()?;
        let path = self.context.directory.join(&name.value);
        if self.context.files == Files::MustExist && !is_right(&path) {
            let full = resolved(&path);
            if path.exists() {
                self.report(format!("{otherwise}: {}", full.display()));
            } else {
                self.report(format!("the {what} does not exist: {}", full.display()));
            }
            return None;
        }
        Some(name.map(|_| path))
    }
}

/// The path from the root, without `.` and `..`, for messages only: a symbolic link before a `..`
/// would be followed otherwise when the file is opened.
fn resolved(path: &Path) -> PathBuf {
    use std::path::Component;
    let full = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut clean = PathBuf::new();
    for part in full.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                clean.pop();
            }
            other => clean.push(other),
        }
    }
    clean
}
