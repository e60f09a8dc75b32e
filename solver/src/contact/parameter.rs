//! A resolved number and where it came from.

use std::fmt;

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
    /// Follows from other parameters of the pair, as the text says.
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
    /// What it is.
    pub value: Value,
    /// SI unit; empty for pure numbers.
    pub unit: &'static str,
    /// Where it came from.
    pub origin: Origin,
}

/// A number for human eyes: six significant digits, an exponent where the number is very large or small.
#[must_use]
pub(crate) fn short(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return format!("{number}");
    }
    let rounded: f64 = format!("{number:.5e}").parse().unwrap_or(number);
    if (1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short_and_right() {
        assert_eq!(short(0.0), "0");
        assert_eq!(short(0.1 + 0.2), "0.3");
        assert_eq!(short(5_494_505.494_505), "5.49451e6");
        assert_eq!(short(-1.25e-5), "-1.25e-5");
        assert_eq!(short(123_456.7), "123457");
    }
}
