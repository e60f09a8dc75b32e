//! The keys of a contact law as data, and a law as typed.
//!
//! The list of laws is not part of this crate: each law's table of keys, [`LawKeys`], stands beside its formula in the solver,
//! and the caller that reads a scene passes the tables to the reader ([`read_scene_with`](super::read_scene_with)). Reader,
//! overrides, mixing and the users' pages follow from them.

use super::source::{Located, SourceSpan};

/// The part of a contact that a law is for, and the key of its table at a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LawPart {
    /// `normal`: the force along the normal.
    Normal,
    /// `tangential`: the force of sliding.
    Tangential,
    /// `rolling`: the couple against rolling.
    Rolling,
    /// `torsion`: the couple against twisting about the normal.
    Torsion,
    /// `liquid`: liquid bridges.
    Liquid,
    /// `adhesion`: dry cohesion.
    Adhesion,
}

impl LawPart {
    /// All of them, in the order of the format.
    pub const ALL: [Self; 6] = [
        Self::Normal,
        Self::Tangential,
        Self::Rolling,
        Self::Torsion,
        Self::Liquid,
        Self::Adhesion,
    ];

    /// The key of the table.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Tangential => "tangential",
            Self::Rolling => "rolling",
            Self::Torsion => "torsion",
            Self::Liquid => "liquid",
            Self::Adhesion => "adhesion",
        }
    }
}

/// Keys of a scene that name a law and give its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawKeys {
    /// The tables in which it may stand.
    pub parts: &'static [LawPart],
    /// The word after `law`.
    pub name: &'static str,
    /// Meaning of the law, in a line.
    pub text: &'static str,
    /// Its keys, in the order of the users' page.
    pub keys: &'static [Key],
    /// Groups of keys of which one way has to be chosen; each way is a list of keys that go together and are known by the first.
    pub choices: &'static [&'static [&'static [&'static str]]],
}

impl LawKeys {
    /// Keys of no law.
    pub const NONE: Self = Self {
        parts: &[],
        name: "none",
        text: "",
        keys: &[],
        choices: &[],
    };

    /// The key with this name.
    #[must_use]
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// Whether the key is one of those that exclude others.
    #[must_use]
    pub fn is_choice(&self, name: &str) -> bool {
        let mut all = self.choices.iter().copied().flatten().copied().flatten();
        all.any(|key| *key == name)
    }
}

/// One key of a law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Key {
    /// The key.
    pub name: &'static str,
    /// SI unit; empty for pure numbers and words.
    pub unit: &'static str,
    /// Permitted values.
    pub range: Range,
    /// Value where the key is left out.
    pub default: KeyDefault,
    /// Rule for the value between two materials.
    pub mixing: Mixing,
    /// Meaning of the key.
    pub text: &'static str,
}

impl Key {
    /// A number that has to be given and mixes by the harmonic mean.
    #[must_use]
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        range: Range,
        text: &'static str,
    ) -> Self {
        Self {
            name,
            unit,
            range,
            default: KeyDefault::Needed,
            mixing: Mixing::HarmonicMean,
            text,
        }
    }

    /// With a default.
    #[must_use]
    pub const fn or(self, number: f64) -> Self {
        Self {
            default: KeyDefault::Number(number),
            ..self
        }
    }

    /// Makes the key optional; `then` describes the value where it is left out.
    #[must_use]
    pub const fn or_open(self, then: &'static str) -> Self {
        Self {
            default: KeyDefault::Open(then),
            ..self
        }
    }

    /// `word` may stand there, and holds where the key is left out; `meaning` describes it.
    #[must_use]
    pub const fn or_word(self, word: &'static str, meaning: &'static str) -> Self {
        Self {
            default: KeyDefault::Word(word, meaning),
            ..self
        }
    }

    /// With another rule for two materials.
    #[must_use]
    pub const fn mixes(self, mixing: Mixing) -> Self {
        Self { mixing, ..self }
    }
}

/// Permitted values of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// A finite number.
    Any,
    /// A number above 0.
    Positive,
    /// A number that is not below 0.
    NonNegative,
    /// A number in [0, 1].
    Fraction,
    /// A number in (-1, 0.5]: what thermodynamics allows for an isotropic solid.
    PoissonRatio,
    /// A number between these, both included.
    Between(f64, f64),
    /// A number above the first, up to the second.
    Above(f64, f64),
    /// A number from the first, below the second.
    Below(f64, f64),
    /// A number between these, both excluded.
    Inside(f64, f64),
    /// A number above this one.
    Over(f64),
    /// A number above 0 that is not below that of another key of the law.
    NotBelow(&'static str),
    /// One of these words.
    Words(&'static [&'static str]),
}

impl Range {
    /// Whether a number lies in it; other keys are not looked at.
    #[must_use]
    pub fn holds(self, number: f64) -> bool {
        match self {
            Self::Any => true,
            Self::Positive | Self::NotBelow(_) | Self::Words(_) => number > 0.0,
            Self::NonNegative => number >= 0.0,
            Self::Fraction => (0.0..=1.0).contains(&number),
            Self::PoissonRatio => number > -1.0 && number <= 0.5,
            Self::Between(low, high) => (low..=high).contains(&number),
            Self::Above(low, high) => number > low && number <= high,
            Self::Below(low, high) => (low..high).contains(&number),
            Self::Inside(low, high) => number > low && number < high,
            Self::Over(low) => number > low,
        }
    }

    /// Rule for a number, as a message states it after `must`.
    #[must_use]
    pub fn rule(self) -> String {
        let text = match self {
            Self::NotBelow(_) | Self::Words(_) => Self::Positive.text(),
            _ => self.text(),
        };
        match text.starts_with('>') {
            true => format!("be {text}"),
            false => format!("lie in {text}"),
        }
    }

    /// In words, for the users' page.
    #[must_use]
    pub fn text(self) -> String {
        match self {
            Self::Any => String::new(),
            Self::Above(low, high) => format!("({low}, {high}]"),
            Self::Below(low, high) => format!("[{low}, {high})"),
            Self::Inside(low, high) => format!("({low}, {high})"),
            Self::Over(low) => format!("> {low}"),
            Self::Positive => "> 0".to_owned(),
            Self::NonNegative => ">= 0".to_owned(),
            Self::Fraction => "[0, 1]".to_owned(),
            Self::PoissonRatio => "(-1, 0.5]".to_owned(),
            Self::Between(low, high) => format!("[{low}, {high}]"),
            Self::NotBelow(key) => format!(">= `{key}`"),
            Self::Words(words) => {
                let words: Vec<String> = words.iter().map(|word| format!("`\"{word}\"`")).collect();
                words.join(", ")
            }
        }
    }
}

/// Value where a key is left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KeyDefault {
    /// The key must be given, or is one of a choice.
    Needed,
    /// This number.
    Number(f64),
    /// Description in words.
    Open(&'static str),
    /// The word, which may also be given; the text describes it.
    Word(&'static str, &'static str),
}

/// Rule for the value between two materials, where `[[contacts]]` gives none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mixing {
    /// 2/(1/a + 1/b); 0 if either is 0; that of the only one that gives it.
    HarmonicMean,
    /// Both must have one value.
    Same,
    /// Value by the law's own function, which the text describes.
    Derived(&'static str),
}

impl Mixing {
    /// In words, for the users' page.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::HarmonicMean => "harmonic mean",
            Self::Same => "must be the same",
            Self::Derived(how) => how,
        }
    }
}

/// Value at a key of a law, as it was typed.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// A number, SI.
    Number(f64),
    /// A word.
    Word(String),
}

/// The keys of a law that were typed (or have a number as their default), with their places.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LawValues(Vec<(String, Located<Given>)>);

impl LawValues {
    pub(super) fn push(&mut self, key: &str, value: Located<Given>) {
        self.0.push((key.to_owned(), value));
    }

    /// Value at a key; none where it is left out.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&Located<Given>> {
        let found = self.0.iter().find(|(name, _)| name == key);
        found.map(|(_, value)| value)
    }

    /// The number at a key, if it is one.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.get(key)?.value {
            Given::Number(number) => Some(number),
            Given::Word(_) => None,
        }
    }

    /// The word at a key, if it is one.
    #[must_use]
    pub fn word(&self, key: &str) -> Option<&str> {
        match &self.get(key)?.value {
            Given::Number(_) => None,
            Given::Word(word) => Some(word),
        }
    }
}

/// A law of a material as typed.
#[derive(Debug, Clone, PartialEq)]
pub struct Law {
    /// Its name.
    pub name: Located<String>,
    /// Its parameters.
    pub values: LawValues,
    /// Where the table stands.
    pub place: SourceSpan,
}

/// Keys of a law in `[[contacts]]`; those left out are mixed.
#[derive(Debug, Clone, PartialEq)]
pub struct LawOverride {
    /// The law; none: that of the two materials.
    pub name: Option<Located<String>>,
    /// Values that are replaced.
    pub values: LawValues,
    /// Where the table stands.
    pub place: SourceSpan,
}
