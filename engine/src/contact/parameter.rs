//! A resolved number and where it came from.

use std::fmt;

use mercury_common::readable::significant;

/// Where a resolved parameter came from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// Typed at a material, which alone decides: the pair is one material, or the other one has no such key.
    Material(String),
    /// Mixed from both materials.
    Mixed,
    /// Replaced by an entry of `[[contacts]]`, counted from 0.
    Contact(usize),
    /// The default of the format.
    Default,
    /// Follows from other parameters of the pair by the rule in the text.
    Derived(&'static str),
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Material(name) => write!(f, "materials.{name}"),
            Self::Mixed => f.write_str("mixed"),
            Self::Contact(index) => write!(f, "contacts[{index}]"),
            Self::Default => f.write_str("default"),
            Self::Derived(how) => f.write_str(how),
        }
    }
}

/// A number, or a word where a choice is no number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// In the unit of the parameter.
    Number(f64),
    /// The name of a choice.
    Word(&'static str),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Number(number) => f.write_str(&short(number)),
            Self::Word(word) => f.write_str(word),
        }
    }
}

/// One resolved parameter of a pair of materials.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Key of the scene format with the part it belongs to: `normal.restitution`.
    pub name: String,
    /// Value of the parameter.
    pub value: Value,
    /// SI unit; empty for pure numbers.
    pub unit: &'static str,
    /// Where it came from.
    pub origin: Origin,
}

/// A number for human eyes: six significant digits, an exponent where the number is very large or small.
#[must_use]
pub fn short(number: f64) -> String {
    significant(number, 6)
}
