//! A value of the document, read as what it should be: a number in a range, a direction, a word of a
//! list, a material, a file. Each method reports what is wrong and then returns `None`.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::cursor::{Context, Fields, Files, ONE_LINE};
use super::key_path;
use super::keys::{Kind, TableKeys};
use super::laws::Range;
use super::source::{Located, SourceSpan};
use super::spelling::{listed, nearest};
use super::statement::NamedFile;
use super::tree::{BACKSLASHES, Node, Value};
use super::{ClumpIndex, MaterialIndex};
use crate::within::plain;

/// A value of the document with its key path.
#[derive(Clone)]
pub(super) struct Item<'a> {
    pub(super) context: &'a Context,
    pub(super) node: &'a Node,
    pub(super) place: SourceSpan,
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

    /// A table with these keys; keys that are not known, and more than one of those that exclude each other, are reported.
    pub(super) fn open(&self, keys: &'static TableKeys) -> Option<Fields<'a>> {
        let mut fields = self.table()?;
        fields.hold_to(keys);
        Some(fields)
    }

    /// A table with the keys of a kind.
    pub(super) fn fields(&self, kind: &'static Kind) -> Option<Fields<'a>> {
        match kind.table() {
            Some(keys) => self.open(keys),
            None => self.expected("no table"),
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
            let place = SourceSpan::new(&node.source, node.span.clone(), path);
            Item {
                context: self.context,
                node,
                place,
            }
        };
        let there =
            (nodes.iter().enumerate()).filter(|(_, node)| !matches!(node.value, Value::LeftOut));
        Some(there.map(item).collect())
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

    /// A number of a range.
    pub(super) fn number_in(&self, range: Range) -> Option<Located<f64>> {
        let number = self.number()?;
        if !range.holds(*number) {
            self.report(format!("must {}, got {}", range.rule(), self.got()));
            return None;
        }
        Some(number)
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

    /// One word of a list; `what` names the kind of thing in the message.
    pub(super) fn word<T: Copy>(&self, what: &str, words: &[(&str, T)]) -> Option<T> {
        let names: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
        self.word_of(what, &names).map(|index| words[index].1)
    }

    /// The index of one word of a list.
    pub(super) fn word_of(&self, what: &str, words: &[&str]) -> Option<usize> {
        let text = self.text()?;
        if let Some(index) = words.iter().position(|word| *word == text.value) {
            return Some(index);
        }
        let all = || listed(words.iter().copied());
        let help = match nearest(&text, words.iter().copied()) {
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

    /// A file; `help` is the advice where there is none.
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
        if let Value::String(text) = &self.node.value
            && text.contains(char::is_control)
        {
            let error = self.place.error(ONE_LINE).with_help(BACKSLASHES);
            self.context.report(error);
            return None;
        }
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
                let help = match name.value.contains('\\') {
                    true => Some(BACKSLASHES),
                    false => help,
                };
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
