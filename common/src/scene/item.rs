//! A value of the document, read as what it should be: a number in a range, a direction, a word of a
//! list, a material, a file. Each method reports what is wrong and then returns `None`.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::cursor::{Context, Fields, Files};
use super::key_path;
use super::source::{Located, Place};
use super::spelling::{listed, nearest};
use super::statement::NamedFile;
use super::tree::{Node, Value};
use super::{ClumpIndex, MaterialIndex};
use crate::within::plain;

/// A value of the document with its key path.
#[derive(Clone)]
pub(super) struct Item<'a> {
    pub(super) context: &'a Context,
    pub(super) node: &'a Node,
    pub(super) place: Place,
}

impl<'a> Item<'a> {
    pub(super) fn report(&self, message: impl Into<String>) {
        self.context.report(self.place.error(message));
    }

    pub(super) fn located<T>(&self, value: T) -> Located<T> {
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

    pub(super) fn is_table(&self) -> bool {
        matches!(self.node.value, Value::Table(_))
    }

    pub(super) fn is_list(&self) -> bool {
        matches!(self.node.value, Value::Array(_))
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
        self.context.is_one_line(&name).then_some(name)
    }

    /// A string, perhaps an empty one, that stays on its line.
    pub(super) fn line(&self) -> Option<Located<String>> {
        let line = self.text()?;
        self.context.is_one_line(&line).then_some(line)
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
            // `1e6` is a float to TOML. Up to 2^53 each whole number has a float of its own.
            Value::Float(value)
                if value.fract() == 0.0
                    && (smallest as f64..=9_007_199_254_740_992.0).contains(&value) =>
            {
                Some(self.located(value as u64))
            }
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

    /// A number in (low, high].
    pub(super) fn above(&self, low: f64, high: f64) -> Option<Located<f64>> {
        self.checked(&format!("lie in ({low}, {high}]"), |value| {
            value > low && value <= high
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
        self.noted(self.path("file", None, Path::is_file))
    }

    /// A file; `help` says how to make it where there is none.
    pub(super) fn file_or(&self, help: &str) -> Option<Located<PathBuf>> {
        self.noted(self.path("file", Some(help), Path::is_file))
    }

    /// Notes that the scene names this file.
    fn noted(&self, file: Option<Located<PathBuf>>) -> Option<Located<PathBuf>> {
        if let (Some(file), Value::String(name)) = (&file, &self.node.value) {
            self.context.named.borrow_mut().push(NamedFile {
                key: self.place.key().to_owned(),
                name: name.clone(),
                path: file.value.clone(),
            });
        }
        file
    }

    /// A folder, relative to the folder of the scene.
    pub(super) fn folder(&self) -> Option<Located<PathBuf>> {
        self.path("folder", None, Path::is_dir)
    }

    fn path(
        &self,
        what: &str,
        help: Option<&str>,
        is_right: impl Fn(&Path) -> bool,
    ) -> Option<Located<PathBuf>> {
        let name = self.name()?;
        let path = self.context.directory.join(&name.value);
        if let Files::Within(within) = &self.context.files
            && let Err(outside) = within.check(&path)
        {
            self.report(format!("{:?} {outside}", name.value));
            return None;
        }
        if self.context.files != Files::Unchecked && !is_right(&path) {
            let shown = self.shown(&path);
            if path.exists() {
                let is = match what {
                    "folder" => "is not a folder",
                    _ if path.is_dir() => "is a folder, not a file",
                    _ => "is a device or pipe, not a file",
                };
                self.report(format!("{is}: {shown}"));
            } else {
                let message = format!("the {what} does not exist: {shown}");
                let error = self.place.error(message);
                self.context.report(match help {
                    Some(help) => error.with_help(help),
                    None => error,
                });
            }
            return None;
        }
        Some(name.map(|_| path))
    }

    /// A path for messages only: from the root, as a symbolic link before a `..` would be followed when the file is opened. A
    /// caller that is confined to a folder learns nothing about the folders above it.
    fn shown(&self, path: &Path) -> String {
        let shown = match self.context.files {
            Files::Within(_) => path.to_owned(),
            Files::MustExist | Files::Unchecked => {
                plain(&std::path::absolute(path).unwrap_or_else(|_| path.to_owned()))
            }
        };
        shown.display().to_string()
    }
}
