//! The typed reader over the document. It keeps the key path, records the keys that were read, and collects every problem instead
//! of stopping at the first.
//!
//! A method that reads returns `None` after it has reported; callers read everything they need and
//! only then give up, so that one run names all mistakes.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::error::SceneError;
use super::examples::example;
use super::from_item::FromKey;
use super::item::Item;
use super::key_path;
use super::keys::{Absent, Kind, SceneKey, TableKeys, Variant, Variants};
use super::laws::LawKeys;
use super::source::{Located, SourceSpan};
use super::spelling::{listed, nearest};
use super::statement::NamedFile;
use super::tree::{Entry, Table, Value};
use crate::readable::printable;
use crate::units::{Dimension, Quantity};
use crate::within::Within;

/// Up to this many allowed keys are listed when one is not known.
const SHORT_LIST: usize = 12;

/// Files that a scene may name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Files {
    /// A file that is missing is an error.
    MustExist,
    /// Likewise, and so is one outside of a folder, which is not looked at.
    Within(Arc<Within>),
    /// Files are not looked for, as in an editor or where only the text is at hand.
    Unchecked,
}

/// Data that all cursors of a document share.
pub(super) struct Context {
    pub(super) errors: RefCell<Vec<SceneError>>,
    pub(super) directory: PathBuf,
    pub(super) files: Files,
    pub(super) materials: Vec<String>,
    pub(super) clumps: Vec<String>,
    /// The contact laws that are known; `None`: the caller does not know the contact laws.
    pub(super) laws: Option<Vec<&'static LawKeys>>,
    /// The files that were named so far.
    pub(super) named: RefCell<Vec<NamedFile>>,
}

/// Name of an entry of a list that has none, where it needs one: `wall-3` for `walls[2]`.
fn default_name(path: &str) -> Option<String> {
    let (list, index) = path.strip_suffix(']')?.rsplit_once('[')?;
    let one = match list.rsplit('.').next()? {
        "walls" => "wall",
        "insertions" => "insertion",
        "regions" => "region",
        "deletions" => "deletion",
        "fluxes" => "flux",
        "membranes" => "membrane",
        "holds" => "hold",
        "bonds" => "bond",
        _ => return None,
    };
    let index: usize = index.parse().ok()?;
    Some(format!("{one}-{}", index + 1))
}

/// Message for a text that [is not one line](Context::is_one_line).
pub(super) const ONE_LINE: &str = "must not hold line breaks or other control characters";

impl Context {
    pub(super) fn report(&self, error: SceneError) {
        self.errors.borrow_mut().push(error);
    }

    /// Reports a text that would move a terminal's cursor or begin a line of its own in reports and logs.
    pub(super) fn is_one_line(&self, text: &Located<String>) -> bool {
        let is_one = !text.chars().any(char::is_control);
        if !is_one {
            self.report(text.error(ONE_LINE));
        }
        is_one
    }

    /// Reports every `name` that stands twice in a list, whether or not its entry is right otherwise.
    pub(super) fn unique_names(&self, items: &[Item<'_>]) {
        let mut seen: HashMap<String, SourceSpan> = HashMap::new();
        for item in items {
            let Value::Table(table) = &item.node.value else {
                continue;
            };
            let given = item.node.name().zip(table.get("name"));
            let named = given.map(|(name, entry)| {
                let path = key_path::child(item.place.key(), "name");
                let place = SourceSpan::new(&entry.node.source, entry.node.span.clone(), path);
                (name.to_owned(), place)
            });
            let numbered = || Some((default_name(item.place.key())?, item.place.clone()));
            let Some((name, place)) = named.or_else(numbered) else {
                continue;
            };
            match seen.get(&name) {
                Some(first) => {
                    let error =
                        place.error(format!("the name `{}` is used twice", printable(&name)));
                    self.report(if first.is_argument() {
                        error
                    } else {
                        error.with_help(format!("first in line {}", first.line()))
                    });
                }
                None => {
                    seen.insert(name, place);
                }
            }
        }
    }
}

/// A table of the document and the keys that were read from it.
pub(super) struct Fields<'a> {
    pub(super) context: &'a Context,
    table: &'a Table,
    place: SourceSpan,
    asked: RefCell<Vec<&'static str>>,
    /// Problems that [`finish`](Self::finish) reports better: keys that are missing while a misspelt one is there. A caller that
    /// stops at a missing key never calls `finish`.
    left_to_finish: RefCell<Vec<SceneError>>,
    /// The keys that may stand there, where a table lists them.
    keys: Option<&'static TableKeys>,
    variant: Option<&'static Variant>,
    /// Whether keys that are not known have been reported.
    is_judged: bool,
}

impl Drop for Fields<'_> {
    fn drop(&mut self) {
        for error in self.left_to_finish.take() {
            self.context.report(error);
        }
    }
}

impl<'a> Fields<'a> {
    pub(super) fn new(context: &'a Context, table: &'a Table, place: SourceSpan) -> Self {
        Self {
            context,
            table,
            place,
            asked: RefCell::new(Vec::new()),
            left_to_finish: RefCell::new(Vec::new()),
            keys: None,
            variant: None,
            is_judged: false,
        }
    }

    /// Holds the table to these keys: reports those that are not known, and more than one of those that exclude each other. Where the
    /// word that decides on further keys is wrong, keys are not checked.
    pub(super) fn hold_to(&mut self, keys: &'static TableKeys) {
        self.keys = Some(keys);
        self.variant = keys.variant_of(self.table);
        if let Variants::Word {
            key,
            what,
            example,
            of,
            ..
        } = &keys.variants
        {
            let words: Vec<&str> = of.iter().map(|variant| variant.name).collect();
            match self.get(key) {
                Some(item) => {
                    item.word_of(what, &words);
                }
                None if self.variant.is_none() => {
                    self.miss(key, Some(format!("for example: {key} = {example}")));
                }
                None => {}
            }
        }
        let known = keys.of(self.variant).map(|key| key.name);
        let chosen = keys
            .choices
            .iter()
            .flat_map(|choice| choice.keys.iter().copied());
        self.asked.borrow_mut().extend(known.chain(chosen));
        self.is_judged = self.variant.is_some() || matches!(keys.variants, Variants::None);
        if let Variants::Key { of, alone: true } = &keys.variants {
            let names: Vec<&'static str> = of.iter().map(|variant| variant.name).collect();
            self.is_judged &= self.exactly_one(&names, true);
        }
        if self.is_judged {
            self.finish();
        }
        for choice in keys.choices {
            self.exactly_one(choice.keys, choice.needed);
        }
    }

    /// The variant that the table is, by its name; none where it is wrong.
    pub(super) fn variant(&self) -> Option<&'static str> {
        let variant = self.variant.filter(|_| self.is_judged);
        variant.map(|variant| variant.name)
    }

    /// The one key that is given, of those that exclude each other; none if there are more.
    pub(super) fn chosen(&self, choice: usize) -> Option<&'static str> {
        let mut given = self.keys?.choices[choice]
            .keys
            .iter()
            .filter(|key| self.has(key));
        given.next().filter(|_| given.next().is_none()).copied()
    }

    fn key(&self, name: &str) -> Option<&'static SceneKey> {
        self.keys?.of(self.variant).find(|key| key.name == name)
    }

    /// The value of a key by its entry in the table of keys, or its default.
    pub(super) fn read<T: FromKey>(&self, name: &'static str) -> T {
        self.read_or_miss(name, false)
    }

    /// The value of a key that must be given here, whatever its default.
    pub(super) fn require<T: FromKey>(&self, name: &'static str) -> T {
        self.read_or_miss(name, true)
    }

    fn read_or_miss<T: FromKey>(&self, name: &'static str, needed: bool) -> T {
        let Some(key) = self.key(name) else {
            debug_assert!(false, "no table of keys has `{name}`");
            let error = self.absent(name).error("is in no table of keys");
            self.context
                .report(error.with_help("this is a defect of Mercury"));
            return T::placeholder(&self.place);
        };
        if let Some(item) = self.get(name) {
            return T::from_item(&item, &key.kind).unwrap_or_else(|| T::placeholder(&item.place));
        }
        let place = self.absent(name);
        let default = key.absent.node(&place).filter(|_| !needed);
        let read = match (&default, key.absent) {
            (Some(node), _) => {
                let place = place.clone();
                let context = self.context;
                let item = Item {
                    context,
                    node,
                    place,
                };
                T::from_item(&item, &key.kind)
            }
            (None, Absent::Open(_) | Absent::When(_)) if !needed => T::absent(),
            _ => {
                self.miss(name, Some(key.line()));
                None
            }
        };
        read.unwrap_or_else(|| T::placeholder(&place))
    }

    /// A table below this one; one without keys where it is left out and may be.
    pub(super) fn section(&self, name: &'static str) -> Option<Fields<'a>> {
        static EMPTY: Table = Table {
            entries: Vec::new(),
        };
        let key = self.key(name)?;
        let Kind::Table(keys) = key.kind else {
            return None;
        };
        if let Some(item) = self.get(name) {
            return item.open(keys);
        }
        match key.absent {
            Absent::EmptyTable => {
                let mut fields = Fields::new(self.context, &EMPTY, self.absent(name));
                fields.hold_to(keys);
                Some(fields)
            }
            _ => {
                self.miss(name, Some(key.line()));
                None
            }
        }
    }

    /// The place of the table.
    pub(super) fn place(&self) -> &SourceSpan {
        &self.place
    }

    /// The place of the table under the path of a key that is not there.
    pub(super) fn absent(&self, key: &str) -> SourceSpan {
        self.place.with_key(key_path::child(self.place.key(), key))
    }

    /// Whether the key is there; does not count as reading it.
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
        let item = self.get(key);
        if item.is_none() {
            self.miss(key, example(key));
        }
        item
    }

    /// Reports that a key is missing. A misspelt key is reported once, as unknown, with the right spelling.
    fn miss(&self, key: &'static str, help: Option<String>) {
        let misspelt = self.table.entries.iter().find(|entry| {
            !self.asked.borrow().contains(&entry.key.as_str())
                && (nearest(&entry.key, [key]).is_some()
                    || (key == "radius" && entry.key == "diameter"))
        });
        let error = self.absent(key).error("is missing");
        match misspelt {
            Some(_) if self.is_judged => {}
            Some(entry) => {
                let error = error.with_help(format!("is it meant by `{}`?", entry.key));
                self.left_to_finish.borrow_mut().push(error);
            }
            None => self.context.report(SceneError { help, ..error }),
        }
    }

    /// A default, at the place where the key could stand.
    pub(super) fn default<T>(&self, key: &str, value: T) -> Located<T> {
        Located {
            value,
            place: self.absent(key),
        }
    }

    /// The name of an entry of a list; where none is given `wall-3` for the third of `[[walls]]`, and so on.
    pub(super) fn name_or_number(&self) -> Located<String> {
        let given: Option<Located<String>> = self.read("name");
        given.unwrap_or_else(|| {
            self.default("name", default_name(self.place.key()).unwrap_or_default())
        })
    }

    /// Every key with its value, for tables whose keys are the user's names.
    pub(super) fn entries(&self) -> impl Iterator<Item = (Located<String>, Item<'a>)> {
        self.table.entries.iter().map(|entry| {
            let path = key_path::child(self.place.key(), &entry.key);
            let place = SourceSpan::new(&entry.source, entry.span.clone(), path);
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
        let place = SourceSpan::new(&entry.node.source, entry.node.span.clone(), path);
        Item {
            context: self.context,
            node: &entry.node,
            place,
        }
    }

    /// The keys of the table that were not read.
    pub(super) fn unasked(&self) -> impl Iterator<Item = &'a str> {
        let asked = self.asked.borrow().clone();
        let keys = self.table.entries.iter().map(|entry| entry.key.as_str());
        keys.filter(move |key| !asked.contains(key))
    }

    /// Reports a key that must not stand beside `other`, if it is there.
    pub(super) fn excluded(&self, key: &str, other: &str) {
        if let Some(entry) = self.table.get(key) {
            self.context.report(self.item(entry).place.error(format!(
                "cannot be given together with `{other}`: choose one"
            )));
        }
    }

    /// Check of keys that exclude each other: reports when more than one is there, or, where one is `needed`, none. True when
    /// exactly one is there.
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
                    let keys: Vec<String> = keys.iter().map(|k| format!("`{k}`")).collect();
                    let error = self.place.error(format!("needs {}", keys.join(" or ")));
                    if misspelt && self.is_judged {
                        // Reported as unknown.
                    } else if misspelt {
                        self.left_to_finish.borrow_mut().push(error);
                    } else {
                        self.context.report(error);
                    }
                }
                false
            }
            [_] => true,
            [first, second, ..] => {
                self.excluded(second, first);
                false
            }
        }
    }

    /// Reports every key that was not read.
    pub(super) fn finish(&self) {
        self.left_to_finish.take();
        let asked = self.asked.borrow();
        for entry in &self.table.entries {
            if asked.contains(&entry.key.as_str()) {
                continue;
            }
            let path = key_path::child(self.place.key(), &entry.key);
            let error = SourceSpan::new(&entry.source, entry.span.clone(), path)
                .error("is not a known key");
            let mut allowed: Vec<&str> = Vec::new();
            for key in asked.iter() {
                if !allowed.contains(key) {
                    allowed.push(key);
                }
            }
            if entry.key == "diameter" && allowed.contains(&"radius") {
                let diameter = match &entry.node.value {
                    Value::Float(diameter) => Some(*diameter),
                    Value::Integer(diameter) => Some(*diameter as f64),
                    Value::String(text) => (Quantity::parse(text).ok())
                        .and_then(|quantity| quantity.value(Dimension::LENGTH).ok()),
                    _ => None,
                };
                let radius = diameter.map(|diameter| format!(": radius = {}", 0.5 * diameter));
                let help = format!("half of it is the radius{}", radius.unwrap_or_default());
                self.context.report(error.with_help(help));
                continue;
            }
            if entry.key == "sleeping" && self.place.key().is_empty() {
                let help = "particles no longer sleep, the changelog says why: leave it out";
                self.context.report(error.with_help(help));
                continue;
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
