//! The keys of the scene's sections as data: what may stand at a key, its unit, its default, an example and its meaning.
//!
//! The table of a section stands above its reader. Reading (`cursor::Fields`), units, messages, the users' page and
//! the JSON schema follow from it. Contact laws have tables of their own (`laws`).

use super::laws::{LawPart, Range};
use super::source::SourceSpan;
use super::tree::{Node, Table, Value};

/// The keys of a table of the scene.
#[derive(Debug, Clone, Copy)]
pub struct TableKeys {
    /// Keys that may always stand there, in groups that tables share.
    pub keys: &'static [&'static [SceneKey]],
    /// Further keys, which depend on the others.
    pub variants: Variants,
    /// Keys that exclude each other.
    pub choices: &'static [Choice],
}

/// On what further keys of a table depend.
#[derive(Debug, Clone, Copy)]
pub enum Variants {
    /// There are none.
    None,
    /// On the word at a key.
    Word {
        /// The key.
        key: &'static str,
        /// Noun for the choice, for messages.
        what: &'static str,
        /// An example of the key's value.
        example: &'static str,
        /// Meaning of the key.
        text: &'static str,
        /// Variant that holds where the key is left out and that of the variant's name is there; none: the key must be given.
        absent: Option<&'static Variant>,
        /// Variants by their words.
        of: &'static [Variant],
    },
    /// On the first of these keys that is there.
    Key {
        /// Variants by their first keys.
        of: &'static [Variant],
        /// Whether exactly one of them must be there.
        alone: bool,
    },
}

/// Further keys of a table.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// The word, or the key, by which it is known.
    pub name: &'static str,
    /// The keys, in groups that tables share.
    pub keys: &'static [&'static [SceneKey]],
    /// Meaning of the variant.
    pub text: &'static str,
}

/// Keys of which at most one is given.
#[derive(Debug, Clone, Copy)]
pub struct Choice {
    /// The keys.
    pub keys: &'static [&'static str],
    /// Whether one has to be given.
    pub needed: bool,
}

/// A key of a table.
#[derive(Debug, Clone, Copy)]
pub struct SceneKey {
    /// The key.
    pub name: &'static str,
    /// Permitted values.
    pub kind: Kind,
    /// Value where the key is left out.
    pub absent: Absent,
    /// A value to copy, perhaps with a comment.
    pub example: &'static str,
    /// Meaning of the key.
    pub text: &'static str,
}

/// Kind of value that is permitted at a key.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A number with its SI unit (empty for pure numbers) and range.
    Number(&'static str, Range),
    /// A whole number between these, both included.
    Whole(u64, u64),
    /// True or false.
    Flag,
    /// One of these words; the first text is the noun for them.
    Word(&'static str, fn() -> Vec<&'static str>),
    /// This word beside what else may stand there.
    Keyword(&'static str),
    /// A number of mean diameters, as in `"1.5d"`.
    Diameters,
    /// A fixed count of numbers of a unit and range.
    Numbers(&'static str, usize, Range),
    /// Numbers with a unit each.
    Row(&'static [&'static str]),
    /// Three numbers of a unit, or `"free"` in the place of any.
    Components(&'static str),
    /// `[low, high]` with low < high, and its unit.
    Interval(&'static str),
    /// A vector that is not zero.
    Direction,
    /// A string that is not empty and stays on its line.
    Name,
    /// A string that stays on its line.
    Line,
    /// Any string.
    Text,
    /// A file; the text describes how to make it.
    File(&'static str),
    /// A folder.
    Folder,
    /// The name of a material.
    Material,
    /// The name of a clump.
    Clump,
    /// A list; the text names its entries, of which it needs one, and is empty where the list may be.
    List(&'static str, &'static Kind),
    /// A table.
    Table(&'static TableKeys),
    /// Tables with names that the user chooses.
    Named(&'static TableKeys),
    /// Strings with names that the user chooses.
    Texts,
    /// A contact law, whole or with some of its keys.
    Law(LawPart, bool),
    /// One of these, which differ in their types.
    OneOf(&'static [Kind]),
}

/// Value where a key is left out.
#[derive(Debug, Clone, Copy)]
pub enum Absent {
    /// The key must be given.
    Needed,
    /// This number.
    Number(f64),
    /// True or false.
    Flag(bool),
    /// This word.
    Word(&'static str),
    /// The zero vector.
    Zero,
    /// The empty list.
    EmptyList,
    /// A table without keys: the defaults of all.
    EmptyTable,
    /// Description in words; empty where there is nothing to describe.
    Open(&'static str),
    /// The key must be given in the case that the text states, and means nothing in others.
    When(&'static str),
}

/// A word of the scene.
pub(super) trait Word: Copy + 'static {
    /// Noun for the words, for messages.
    const WHAT: &'static str;
    /// The words and what they stand for.
    const WORDS: &'static [(&'static str, Self)];

    /// The words.
    fn names() -> Vec<&'static str> {
        Self::WORDS.iter().map(|(word, _)| *word).collect()
    }
}

/// A key that must be given.
pub(crate) const fn key(
    name: &'static str,
    kind: Kind,
    example: &'static str,
    text: &'static str,
) -> SceneKey {
    SceneKey {
        name,
        kind,
        absent: Absent::Needed,
        example,
        text,
    }
}

/// The words of a type.
pub(super) const fn word<T: Word>() -> Kind {
    Kind::Word(T::WHAT, T::names)
}

/// A number of a unit above 0.
pub(super) const fn positive(unit: &'static str) -> Kind {
    Kind::Number(unit, Range::Positive)
}

/// A number of a unit that is not below 0.
pub(super) const fn non_negative(unit: &'static str) -> Kind {
    Kind::Number(unit, Range::NonNegative)
}

/// Any finite number of a unit.
pub(super) const fn number(unit: &'static str) -> Kind {
    Kind::Number(unit, Range::Any)
}

/// Three numbers of a unit.
pub(super) const fn vector(unit: &'static str) -> Kind {
    Kind::Numbers(unit, 3, Range::Any)
}

/// A variant of a table.
pub(super) const fn variant(
    name: &'static str,
    keys: &'static [&'static [SceneKey]],
    text: &'static str,
) -> Variant {
    Variant { name, keys, text }
}

impl TableKeys {
    /// A table of these keys.
    pub(super) const fn new(keys: &'static [&'static [SceneKey]]) -> Self {
        Self {
            keys,
            variants: Variants::None,
            choices: &[],
        }
    }

    /// With keys that exclude each other.
    pub(super) const fn with_choices(self, choices: &'static [Choice]) -> Self {
        Self { choices, ..self }
    }

    /// With further keys.
    pub(super) const fn with_variants(self, variants: Variants) -> Self {
        Self { variants, ..self }
    }

    /// The keys that hold for a variant.
    pub fn of(&self, variant: Option<&'static Variant>) -> impl Iterator<Item = &'static SceneKey> {
        let more = variant.map_or(&[][..], |variant| variant.keys);
        self.keys.iter().chain(more).copied().flatten()
    }

    /// All variants.
    pub fn variants(&self) -> impl Iterator<Item = &'static Variant> {
        let (absent, all) = match &self.variants {
            Variants::None => (None, &[][..]),
            Variants::Word { absent, of, .. } => (*absent, *of),
            Variants::Key { of, .. } => (None, *of),
        };
        absent.into_iter().chain(all)
    }

    /// The key that names the variant.
    #[must_use]
    pub fn tag(&self) -> Option<&'static str> {
        match &self.variants {
            Variants::Word { key, .. } => Some(key),
            Variants::None | Variants::Key { .. } => None,
        }
    }

    /// The variant that a table of the document is; nothing is reported.
    pub(super) fn variant_of(&self, table: &Table) -> Option<&'static Variant> {
        match &self.variants {
            Variants::None => None,
            Variants::Word {
                key, absent, of, ..
            } => match table.get(key).map(|entry| &entry.node.value) {
                Some(Value::String(word)) => of.iter().find(|variant| variant.name == word),
                Some(_) => None,
                None => absent.filter(|absent| table.get(absent.name).is_some()),
            },
            Variants::Key { of, .. } => of.iter().find(|variant| table.get(variant.name).is_some()),
        }
    }

    /// Kind of value that is permitted at a key of a table of the document.
    pub(super) fn kind_in(&self, table: &Table, name: &str) -> Option<&'static Kind> {
        let is = |key: &&SceneKey| key.name == name;
        let found = self.of(self.variant_of(table)).find(is);
        // Where the variant is wrong, the key may be that of any.
        let any = || {
            self.variants()
                .flat_map(|variant| self.of(Some(variant)))
                .find(is)
        };
        found.or_else(any).map(|key| &key.kind)
    }
}

impl SceneKey {
    /// With a number for the default.
    pub(super) const fn or(self, number: f64) -> Self {
        self.absent(Absent::Number(number))
    }

    /// With a flag for the default.
    pub(crate) const fn or_flag(self, flag: bool) -> Self {
        self.absent(Absent::Flag(flag))
    }

    /// With a word for the default.
    pub(super) const fn or_word(self, word: &'static str) -> Self {
        self.absent(Absent::Word(word))
    }

    /// Makes the key optional; `then` describes the value where it is left out.
    pub(super) const fn or_open(self, then: &'static str) -> Self {
        self.absent(Absent::Open(then))
    }

    /// Makes the key needed in a case, as "with ..." or "without ...".
    pub(super) const fn needed(self, case: &'static str) -> Self {
        self.absent(Absent::When(case))
    }

    /// With a default.
    pub(crate) const fn absent(self, absent: Absent) -> Self {
        Self { absent, ..self }
    }

    /// The line to copy where the key is missing, for messages.
    pub(super) fn line(&self) -> String {
        let (name, example) = (self.name, self.example);
        match self.kind.unit() {
            Some(unit) if !unit.is_empty() && !example.contains('#') => {
                format!("for example: {name} = {example}   # {unit}")
            }
            _ => format!("for example: {name} = {example}"),
        }
    }
}

/// A text of a key without its links and marks of code, for where no page shows them.
#[must_use]
pub fn readable(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some(begin) = rest.find("](") {
        let end = rest[begin..]
            .find(')')
            .map_or(rest.len(), |end| begin + end + 1);
        let before = &rest[..begin];
        // The words of the link stand behind its bracket.
        let open = before.rfind('[').unwrap_or(0);
        plain += &before[..open];
        plain += before[open..].trim_start_matches('[');
        rest = &rest[end..];
    }
    plain += rest;
    plain.replace('`', "")
}

impl Absent {
    /// In words, for the users' page; empty where the key must be given, or there is nothing to describe.
    #[must_use]
    pub fn text(self) -> String {
        match self {
            Self::Needed | Self::EmptyTable => String::new(),
            Self::Number(number) if number == 1.0 / 3.0 => "1/3".to_owned(),
            Self::Number(number) if number >= 1e4 => format!("{number:e}"),
            Self::Number(number) => format!("{number}"),
            Self::Flag(flag) => flag.to_string(),
            Self::Word(word) => format!("`\"{word}\"`"),
            Self::Zero => "`[0, 0, 0]`".to_owned(),
            Self::EmptyList => "`[]`".to_owned(),
            Self::Open(then) => then.to_owned(),
            Self::When(case) => format!("needed {case}"),
        }
    }

    /// The default as a value of a document at a place.
    pub(super) fn node(self, place: &SourceSpan) -> Option<Node> {
        let value = match self {
            Self::Needed | Self::Open(_) | Self::When(_) => return None,
            Self::Number(number) => Value::Float(number),
            Self::Flag(flag) => Value::Boolean(flag),
            Self::Word(word) => Value::String(word.to_owned()),
            Self::Zero => Value::Array(vec![place.node(Value::Float(0.0)); 3]),
            Self::EmptyList => Value::Array(Vec::new()),
            Self::EmptyTable => Value::Table(Table::default()),
        };
        Some(place.node(value))
    }
}

impl Kind {
    /// The SI unit of its numbers; `None` where it has no numbers, or they have several.
    #[must_use]
    pub fn unit(&self) -> Option<&'static str> {
        match self {
            Self::Number(unit, _)
            | Self::Numbers(unit, ..)
            | Self::Components(unit)
            | Self::Interval(unit) => Some(unit),
            Self::List(_, of) => of.unit(),
            Self::OneOf(all) => all.iter().find_map(Self::unit),
            _ => None,
        }
    }

    /// The keys of a table.
    #[must_use]
    pub fn table(&self) -> Option<&'static TableKeys> {
        match self {
            Self::Table(keys) => Some(keys),
            Self::OneOf(all) => all.iter().find_map(Self::table),
            _ => None,
        }
    }

    /// Kind of the entries of a list at the key; none where it is not a list.
    pub(super) fn list(&'static self) -> Option<&'static Self> {
        match self {
            Self::OneOf(all) => all.iter().find_map(Self::list),
            Self::List(..)
            | Self::Numbers(..)
            | Self::Row(_)
            | Self::Components(_)
            | Self::Interval(_) => Some(self),
            _ => None,
        }
    }

    /// The alternative that a value of the document is meant for.
    pub(super) fn pick(&'static self, node: &Node) -> &'static Self {
        let Self::OneOf(all) = self else {
            return self;
        };
        let fits = |kind: &&'static Kind| match (kind, &node.value) {
            (Self::Number(..) | Self::Whole(..), Value::Float(_) | Value::Integer(_)) => true,
            (Self::Table(_), Value::Table(_)) => true,
            (Self::List(..) | Self::Numbers(..) | Self::Row(_), Value::Array(_)) => true,
            (Self::Word(..) | Self::Keyword(_), Value::String(text)) => {
                kind.words().contains(&text.as_str())
            }
            (Self::Diameters, Value::String(text)) => text.trim_end().ends_with('d'),
            _ => false,
        };
        all.iter().find(fits).unwrap_or(&all[0])
    }

    /// The words that may stand there.
    #[must_use]
    pub fn words(&self) -> Vec<&'static str> {
        match self {
            Self::Word(_, words) => words(),
            Self::Keyword(word) => vec![word],
            _ => Vec::new(),
        }
    }
}
