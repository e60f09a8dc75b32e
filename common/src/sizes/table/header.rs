//! Meaning of the columns of a table: `diameter [mm]`, `cumulative volume [%]`.

use crate::scene::Weighting;
use crate::sizes::ClassModel;

/// Meaning of the first column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeKind {
    /// Diameters.
    Diameter,
    /// Radii.
    Radius,
    /// Openings of sieves: diameters, in any order.
    Sieve,
}

/// Meaning of the second column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueKind {
    /// The share finer than the size of the row.
    Cumulative,
    /// The share between the size of the row before and that of the row.
    Fraction,
    /// Share that stays on the sieve of the row: between it and the next larger one.
    Retained,
    /// Share that stays on the sieve of the row and on all larger ones: one minus what passes.
    CumulativeRetained,
}

impl ValueKind {
    /// Whether the values are those of a sieving, so that the sizes are openings, in any order.
    #[must_use]
    pub fn is_of_sieves(self) -> bool {
        matches!(self, Self::Retained | Self::CumulativeRetained)
    }
}

/// The unit of the second column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueUnit {
    /// 1 is all.
    Fraction,
    /// 100 is all.
    Percent,
    /// Any amount, such as g; all is their sum.
    Amount,
    /// Numbers of particles; all is their sum.
    Count,
}

/// Meaning of the columns of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Columns {
    /// Meaning of the sizes.
    pub size: SizeKind,
    /// Number of its units in a metre.
    pub per_metre: f64,
    /// Meaning of the values; none for a list of sizes.
    pub values: Option<(ValueKind, Weighting)>,
    /// The unit of the values; none: 1 or 100 is all, as the table ends.
    pub unit: Option<ValueUnit>,
    /// Distribution inside a class.
    pub model: ClassModel,
    /// Repair like MercuryDPM.
    pub mercury: bool,
}

/// Units of length with how many make a metre.
const LENGTHS: [(&str, f64); 9] = [
    ("m", 1.0),
    ("cm", 1e2),
    ("mm", 1e3),
    ("um", 1e6),
    ("\u{b5}m", 1e6),
    ("\u{3bc}m", 1e6),
    ("micron", 1e6),
    ("microns", 1e6),
    ("nm", 1e9),
];

/// Number of a unit's lengths in a metre.
#[must_use]
pub fn parse_size_unit(word: &str) -> Option<f64> {
    let word = word.trim();
    LENGTHS
        .iter()
        .find(|(name, _)| *name == word)
        .map(|(_, per_metre)| *per_metre)
}

/// A cell of a header: the words, and what stands in brackets.
pub(super) struct Head<'a> {
    pub(super) words: Vec<String>,
    pub(super) unit: Option<&'a str>,
}

impl<'a> Head<'a> {
    pub(super) fn of(cell: &'a str) -> Self {
        let cell = cell.trim().trim_matches('"');
        let open = cell.find(['[', '(']);
        let (name, unit) = match open {
            Some(open) => {
                let inside = cell[open + 1..].trim_end();
                let inside = inside.strip_suffix([']', ')']).unwrap_or(inside);
                (&cell[..open], Some(inside.trim()))
            }
            None => (cell, None),
        };
        let words = name
            .split(|c: char| c.is_whitespace() || c == '_' || c == '-')
            .filter(|word| !word.is_empty())
            .map(|word| match word {
                // Q3 is the cumulative share by volume, q3 its density (ISO 9276-1).
                "Q0" | "Q1" | "Q2" | "Q3" => word.to_owned(),
                word => word.to_lowercase(),
            })
            .collect();
        Self { words, unit }
    }

    /// Meaning of the sizes of the column; nothing for a column without such a word.
    ///
    /// # Errors
    /// If two of its words contradict each other.
    pub(super) fn size(&self) -> Result<Option<SizeKind>, Contradiction> {
        let has = |name: &str| self.words.iter().any(|word| word == name);
        let sieve = ["sieve", "mesh"].into_iter().find(|name| has(name));
        // The diameter of a sieve is the width of its openings.
        let width = sieve.or_else(|| has("diameter").then_some("diameter"));
        match (width, has("radius")) {
            (Some(width), true) => Err(Contradiction::new(width, "radius")),
            (Some(_), false) if sieve.is_some() => Ok(Some(SizeKind::Sieve)),
            (Some(_), false) => Ok(Some(SizeKind::Diameter)),
            (None, true) => Ok(Some(SizeKind::Radius)),
            (None, false) => Ok(None),
        }
    }

    /// Kind and weighting of a column of values; the weighting may be missing.
    ///
    /// # Errors
    /// If two of its words contradict each other.
    pub(super) fn values(&self) -> Result<Option<(ValueKind, Option<Weighting>)>, Contradiction> {
        values(self.words.iter().map(String::as_str))
    }

    /// The unit of a column of values: what stands in brackets, or a word such as `%`.
    ///
    /// # Errors
    /// The unit, if it is none that is known, or is not that of the word.
    pub(super) fn value_unit(&self) -> Result<Option<ValueUnit>, String> {
        let is_percent = self.words.iter().any(|word| is_percent(word));
        let of_word = is_percent.then_some(ValueUnit::Percent);
        let Some(unit) = self.unit.filter(|unit| !unit.is_empty()) else {
            return Ok(of_word);
        };
        let known = match unit.to_lowercase().as_str() {
            "%" | "percent" => Some(ValueUnit::Percent),
            "-" | "1" | "fraction" => Some(ValueUnit::Fraction),
            "g" | "kg" | "mg" | "t" | "m3" | "m^3" | "mm3" | "mm^3" | "ml" | "amount" => {
                Some(ValueUnit::Amount)
            }
            "count" | "counts" | "particles" => Some(ValueUnit::Count),
            _ => None,
        };
        match known {
            Some(known) if of_word.is_none_or(|word| word == known) => Ok(Some(known)),
            _ => Err(unit.to_owned()),
        }
    }
}

/// Two words of a header that exclude each other: `passing` and `retained`, `number` and `volume`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Contradiction {
    words: [String; 2],
}

impl Contradiction {
    fn new(a: &str, b: &str) -> Self {
        Self {
            words: [a.to_owned(), b.to_owned()],
        }
    }
}

impl std::fmt::Display for Contradiction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the words \"{}\" and \"{}\", which contradict each other",
            self.words[0], self.words[1]
        )
    }
}

fn is_percent(word: &str) -> bool {
    matches!(word, "%" | "percent" | "percentage")
}

/// Words of one group, all of which must mean the same.
struct Group<'a, T> {
    first: Option<(&'a str, T)>,
    /// A later word that means something else.
    other: Option<&'a str>,
}

impl<'a, T: PartialEq + Copy> Group<'a, T> {
    const EMPTY: Self = Self {
        first: None,
        other: None,
    };

    fn add(&mut self, word: &'a str, meaning: T) {
        match self.first {
            Some((_, known)) if known != meaning => self.other = self.other.or(Some(word)),
            Some(_) => {}
            None => self.first = Some((word, meaning)),
        }
    }

    fn meaning(&self) -> Result<Option<T>, Contradiction> {
        match (self.first, self.other) {
            (Some((first, _)), Some(other)) => Err(Contradiction::new(first, other)),
            (first, _) => Ok(first.map(|(_, meaning)| meaning)),
        }
    }
}

/// The side of a size on which a share is counted.
#[derive(Clone, Copy, PartialEq)]
enum SieveSide {
    /// All that is finer.
    Finer,
    /// All that is coarser.
    Coarser,
    /// On the sieve; with the word `cumulative` on all larger ones as well.
    OnSieve,
}

/// Kind and weighting of words; `None` if a word is not known or the kind is missing.
fn values<'a>(
    words: impl Iterator<Item = &'a str>,
) -> Result<Option<(ValueKind, Option<Weighting>)>, Contradiction> {
    let (mut is_cumulative, mut is_share) = (false, false);
    let mut side = Group::EMPTY;
    let mut quantity = Group::EMPTY;
    for word in words {
        match word {
            "cumulative" | "cum" | "cum." => is_cumulative = true,
            // Nouns for any kind of share. Alone they are the share of one class.
            "fraction" | "probability" | "share" => is_share = true,
            "passing" | "finer" | "undersize" => side.add(word, SieveSide::Finer),
            "coarser" | "oversize" => side.add(word, SieveSide::Coarser),
            "retained" => side.add(word, SieveSide::OnSieve),
            "number" | "count" | "counts" => quantity.add(word, Weighting::Number),
            "length" => quantity.add(word, Weighting::Length),
            "area" | "surface" => quantity.add(word, Weighting::Area),
            "volume" | "mass" | "weight" => quantity.add(word, Weighting::Volume),
            "Q0" | "Q1" | "Q2" | "Q3" => {
                side.add(word, SieveSide::Finer);
                quantity.add(
                    word,
                    match word {
                        "Q0" => Weighting::Number,
                        "Q1" => Weighting::Length,
                        "Q2" => Weighting::Area,
                        _ => Weighting::Volume,
                    },
                );
            }
            "distribution" | "of" | "by" | "than" => {}
            word if is_percent(word) => {}
            _ => return Ok(None),
        }
    }
    if side.first.is_none() && !is_cumulative && !is_share {
        return Ok(None);
    }
    let kind = match side.meaning()? {
        Some(SieveSide::Finer) => ValueKind::Cumulative,
        Some(SieveSide::Coarser) => ValueKind::CumulativeRetained,
        Some(SieveSide::OnSieve) if is_cumulative => ValueKind::CumulativeRetained,
        Some(SieveSide::OnSieve) => ValueKind::Retained,
        None if is_cumulative => ValueKind::Cumulative,
        None => ValueKind::Fraction,
    };
    Ok(Some((kind, quantity.meaning()?)))
}

/// The word of a command line for what the values are: `cumulative-number`, `fraction-volume`, `retained-mass`,
/// `cumulative-retained-mass`, ...
///
/// # Errors
/// A message if a word is missing or not known, or two contradict each other.
pub fn parse_type(word: &str) -> Result<(ValueKind, Weighting), String> {
    match values(word.split(['-', ' '])) {
        Ok(Some((kind, Some(weighting)))) => Ok((kind, weighting)),
        Ok(_) => Err(
            "expected for example cumulative-number, fraction-volume, retained-mass or cumulative-retained-mass"
                .to_owned(),
        ),
        Err(contradiction) => Err(contradiction.to_string()),
    }
}
