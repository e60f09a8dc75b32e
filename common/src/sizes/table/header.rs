//! What the columns of a table mean: `diameter [mm]`, `cumulative volume [%]`.

use crate::scene::Weighting;
use crate::sizes::ClassModel;

/// What the first column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeKind {
    /// Diameters.
    Diameter,
    /// Radii.
    Radius,
    /// Openings of sieves: diameters, in any order.
    Sieve,
}

/// What the second column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueKind {
    /// The share finer than the size of the row.
    Cumulative,
    /// The share between the size of the row before and that of the row.
    Fraction,
    /// What stays on the sieve of the row: between it and the next larger one.
    Retained,
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

/// What the columns of a table mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Columns {
    /// What the sizes are.
    pub size: SizeKind,
    /// How many of its units make a metre.
    pub per_metre: f64,
    /// What the values are; none for a list of sizes.
    pub values: Option<(ValueKind, Weighting)>,
    /// The unit of the values; none: 1 or 100 is all, as the table ends.
    pub unit: Option<ValueUnit>,
    /// What is assumed inside a class.
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

/// How many of a unit make a metre.
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

    pub(super) fn size(&self) -> Option<SizeKind> {
        let known = |word: &String| match word.as_str() {
            "diameter" => Some(SizeKind::Diameter),
            "radius" => Some(SizeKind::Radius),
            "sieve" | "mesh" => Some(SizeKind::Sieve),
            _ => None,
        };
        self.words.iter().find_map(known)
    }

    /// Kind and weighting of a column of values; the weighting may be missing.
    pub(super) fn values(&self) -> Option<(ValueKind, Option<Weighting>)> {
        values(self.words.iter().map(String::as_str))
    }

    pub(super) fn value_unit(&self) -> Result<Option<ValueUnit>, String> {
        let Some(unit) = self.unit else {
            return Ok(None);
        };
        match unit.to_lowercase().as_str() {
            "" => Ok(None),
            "%" | "percent" => Ok(Some(ValueUnit::Percent)),
            "-" | "1" | "fraction" => Ok(Some(ValueUnit::Fraction)),
            "g" | "kg" | "mg" | "t" | "m3" | "m^3" | "mm3" | "mm^3" | "ml" | "amount" => {
                Ok(Some(ValueUnit::Amount))
            }
            "count" | "counts" | "particles" => Ok(Some(ValueUnit::Count)),
            _ => Err(unit.to_owned()),
        }
    }
}

/// Kind and weighting of words; `None` if a word is not known or the kind is missing.
fn values<'a>(words: impl Iterator<Item = &'a str>) -> Option<(ValueKind, Option<Weighting>)> {
    let (mut kind, mut weighting) = (None, None);
    for word in words {
        match word {
            "cumulative" | "passing" | "finer" | "undersize" => kind = Some(ValueKind::Cumulative),
            "fraction" | "probability" | "share" => kind = Some(ValueKind::Fraction),
            "retained" => kind = Some(ValueKind::Retained),
            "number" | "count" | "counts" => weighting = Some(Weighting::Number),
            "length" => weighting = Some(Weighting::Length),
            "area" | "surface" => weighting = Some(Weighting::Area),
            "volume" | "mass" | "weight" => weighting = Some(Weighting::Volume),
            "Q0" => (kind, weighting) = (Some(ValueKind::Cumulative), Some(Weighting::Number)),
            "Q1" => (kind, weighting) = (Some(ValueKind::Cumulative), Some(Weighting::Length)),
            "Q2" => (kind, weighting) = (Some(ValueKind::Cumulative), Some(Weighting::Area)),
            "Q3" => (kind, weighting) = (Some(ValueKind::Cumulative), Some(Weighting::Volume)),
            "distribution" | "of" | "by" | "than" => {}
            _ => return None,
        }
    }
    Some((kind?, weighting))
}

/// The word of a command line for what the values are: `cumulative-number`, `fraction-volume`, `retained-mass`, ...
#[must_use]
pub fn parse_type(word: &str) -> Option<(ValueKind, Weighting)> {
    let (kind, weighting) = values(word.split(['-', ' ']))?;
    Some((kind, weighting?))
}
