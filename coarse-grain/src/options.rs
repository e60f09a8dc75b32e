//! Values of options, read from text.

use std::str::FromStr;

use mercury_common::units::{Dimension, Quantity};

use crate::evaluate::Mirrors;

/// A width: as a length, or in mean diameters of the flowing particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Width {
    /// In m.
    Metres(f64),
    /// In mean diameters.
    Diameters(f64),
}

impl Width {
    /// In m.
    #[must_use]
    pub fn metres(self, diameter: f64) -> f64 {
        match self {
            Self::Metres(width) => width,
            Self::Diameters(times) => times * diameter,
        }
    }
}

fn positive(text: &str) -> Option<f64> {
    text.trim()
        .parse()
        .ok()
        .filter(|value: &f64| *value > 0.0 && value.is_finite())
}

/// A length in m, or with a unit as scenes take it.
fn length(text: &str) -> Option<f64> {
    let with_unit = || {
        let quantity = Quantity::parse(text.trim()).ok()?;
        quantity.value(Dimension::LENGTH).ok()
    };
    let found = positive(text).or_else(with_unit);
    found.filter(|length| *length > 0.0 && length.is_finite())
}

impl FromStr for Width {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = match text.trim().strip_suffix('d') {
            Some(times) => positive(times).map(Self::Diameters),
            None => length(text).map(Self::Metres),
        };
        found.ok_or_else(|| {
            "expected a positive length in m or with its unit as in \"4 mm\", or in mean diameters as in 1.5d".to_owned()
        })
    }
}

/// Several widths at equal ratios.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scan {
    /// The smallest.
    pub from: Width,
    /// The largest.
    pub to: Width,
    /// Number of widths, ends included.
    pub count: usize,
}

impl Scan {
    /// The widths in m, rising.
    #[must_use]
    pub fn widths(&self, diameter: f64) -> Vec<f64> {
        let (from, to) = (self.from.metres(diameter), self.to.metres(diameter));
        let ratio = libm::pow(to / from, 1.0 / (self.count - 1) as f64);
        (0..self.count)
            .map(|k| from * libm::pow(ratio, k as f64))
            .collect()
    }
}

impl FromStr for Scan {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected FROM..TO/COUNT, as in 0.5d..4d/12 or 0.001..0.01/8".to_owned();
        let (range, count) = text.split_once('/').ok_or_else(wrong)?;
        let (from, to) = range.split_once("..").ok_or_else(wrong)?;
        let scan = Self {
            from: from.parse().map_err(|_| wrong())?,
            to: to.parse().map_err(|_| wrong())?,
            count: count.trim().parse().map_err(|_| wrong())?,
        };
        let rising = match (scan.from, scan.to) {
            (Width::Metres(a), Width::Metres(b)) | (Width::Diameters(a), Width::Diameters(b)) => {
                a < b
            }
            _ => return Err("both ends must be in m or both in diameters".to_owned()),
        };
        if !rising || !(2..=1000).contains(&scan.count) {
            return Err("expected a rising range and 2 to 1000 widths".to_owned());
        }
        Ok(scan)
    }
}

/// Cells along a coordinate, at most.
const MOST_CELLS: usize = 1_000_000;

/// One number for each resolved coordinate, written with x between.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cells(pub Vec<usize>);

impl FromStr for Cells {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let count = |word: &str| {
            word.trim()
                .parse()
                .ok()
                .filter(|count| (1..=MOST_CELLS).contains(count))
        };
        let cells: Option<Vec<usize>> = text.split('x').map(count).collect();
        cells
            .map(Self)
            .ok_or_else(|| {
                format!("expected numbers of cells, each from 1 to {MOST_CELLS}, with x between, as in 20x20x40")
            })
    }
}

/// One length for each resolved coordinate (rad for phi), or one for all.
#[derive(Debug, Clone, PartialEq)]
pub struct Spacing(pub Vec<f64>);

impl FromStr for Spacing {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let lengths: Option<Vec<f64>> = text.split('x').map(positive).collect();
        lengths.map(Self).ok_or_else(|| {
            "expected positive lengths with x between, as in 0.002 or 0.002x0.002x0.001".to_owned()
        })
    }
}

/// Limits of coordinates by their names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Limits(pub Vec<(String, f64, f64)>);

impl Limits {
    /// The limits of a coordinate, if they are given.
    #[must_use]
    pub fn of(&self, name: &str) -> Option<(f64, f64)> {
        self.0
            .iter()
            .find(|(other, ..)| other == name)
            .map(|&(_, min, max)| (min, max))
    }
}

impl FromStr for Limits {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected ranges as in x=0..0.1,z=0..0.05 (m; phi in rad)".to_owned();
        let mut limits: Vec<(String, f64, f64)> = Vec::new();
        for part in text.split(',') {
            let (name, range) = part.split_once('=').ok_or_else(wrong)?;
            let (low, high) = range.split_once("..").ok_or_else(wrong)?;
            let name = name.trim().to_ascii_lowercase();
            let number = |text: &str| {
                text.trim()
                    .parse::<f64>()
                    .ok()
                    .filter(|value| value.is_finite())
                    .ok_or_else(wrong)
            };
            let (low, high) = (number(low)?, number(high)?);
            if !["x", "y", "z", "r", "phi"].contains(&name.as_str()) {
                return Err(wrong());
            }
            if low >= high || !(high - low).is_finite() {
                let what = if low < high { "too long" } else { "empty" };
                return Err(format!("the range of {name} is {what}"));
            }
            if limits.iter().any(|(other, ..)| *other == name) {
                return Err(format!("{name} is given twice"));
            }
            limits.push((name, low, high));
        }
        Ok(Self(limits))
    }
}

/// Reads faces of the domain as in `-z,+x`.
///
/// # Errors
/// When a word is no face.
pub fn mirrors(text: &str) -> Result<Mirrors, String> {
    let mut mirrors = [[false; 2]; 3];
    for word in text.split(',') {
        let found = match word.trim().as_bytes() {
            [side @ (b'-' | b'+'), axis @ b'x'..=b'z'] => {
                Some((usize::from(axis - b'x'), usize::from(*side == b'+')))
            }
            _ => None,
        };
        let (axis, side) = found.ok_or_else(|| "expected faces as in -z or -x,+x".to_owned())?;
        mirrors[axis][side] = true;
    }
    Ok(mirrors)
}

/// Reads numbers of particles as in `0..99,120`; ranges are without their end.
///
/// # Errors
/// When a word is neither a number nor a range.
pub fn ids(text: &str) -> Result<Vec<(u32, u32)>, String> {
    let wrong = || "expected numbers and ranges (without their end) as in 0..100,120".to_owned();
    let number = |text: &str| text.trim().parse::<u32>().map_err(|_| wrong());
    let mut found = Vec::new();
    for word in text.split(',') {
        match word.split_once("..") {
            None => found.push((number(word)?, number(word)?)),
            Some((from, to)) => {
                let (from, to) = (number(from)?, number(to)?);
                if from >= to {
                    return Err(format!("the range {word} is empty"));
                }
                found.push((from, to - 1));
            }
        }
    }
    Ok(found)
}

/// A density for all materials, or for one by its index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Density {
    /// Density of all, kg/m^3.
    All(f64),
    /// Density of one.
    Of(u32, f64),
}

impl FromStr for Density {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "expected a positive density in kg/m^3, or INDEX=DENSITY with the index of a material (.data files have no names)".to_owned()
        };
        match text.split_once('=') {
            None => positive(text).map(Self::All).ok_or_else(wrong),
            Some((index, density)) => {
                let index = index.trim().parse().map_err(|_| wrong())?;
                Ok(Self::Of(index, positive(density).ok_or_else(wrong)?))
            }
        }
    }
}

/// Width and step of smoothing in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smoothing {
    /// Standard deviation, s.
    pub width: f64,
    /// Distance of the blocks, s.
    pub step: f64,
}

impl FromStr for Smoothing {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = text.split_once(',').and_then(|(width, step)| {
            Some(Self {
                width: positive(width)?,
                step: positive(step)?,
            })
        });
        found.ok_or_else(|| "expected WIDTH,STEP in s, as in 0.1,0.05".to_owned())
    }
}

/// Three coordinates, m.
///
/// # Errors
/// When there are not three numbers.
pub fn point(text: &str) -> Result<glam::DVec3, String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|word| {
            word.trim()
                .parse()
                .ok()
                .filter(|value: &f64| value.is_finite())
        })
        .collect();
    let numbers: Option<[f64; 3]> = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers
        .map(glam::DVec3::from_array)
        .ok_or_else(|| "expected three numbers as in 0.05,0,0.05".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_words_are_understood() {
        assert_eq!("0.004".parse(), Ok(Width::Metres(0.004)));
        assert_eq!("1.5d".parse(), Ok(Width::Diameters(1.5)));
        assert_eq!("4 mm".parse(), Ok(Width::Metres(0.004)));
        assert_eq!("0.4cm".parse(), Ok(Width::Metres(0.004)));
        let scan: Scan = "1d..4d/3".parse().unwrap();
        let widths = scan.widths(0.1);
        assert!(
            (widths[1] - 0.2).abs() < 1e-15 && (widths[2] - 0.4).abs() < 1e-15 && widths.len() == 3
        );
        assert_eq!("20x1x40".parse(), Ok(Cells(vec![20, 1, 40])));
        assert_eq!("0.1x2e-3".parse(), Ok(Spacing(vec![0.1, 2e-3])));
        let limits: Limits = "x=-1..2,phi=0..3".parse().unwrap();
        assert_eq!(
            (limits.of("x"), limits.of("phi"), limits.of("z")),
            (Some((-1.0, 2.0)), Some((0.0, 3.0)), None)
        );
        assert_eq!(
            mirrors("-z,+x"),
            Ok([[false, true], [false, false], [true, false]])
        );
        assert_eq!(ids("0..3,7"), Ok(vec![(0, 2), (7, 7)]));
        assert_eq!("2500".parse(), Ok(Density::All(2500.0)));
        assert_eq!("1=2500".parse(), Ok(Density::Of(1, 2500.0)));
        assert_eq!(
            "0.1,0.05".parse(),
            Ok(Smoothing {
                width: 0.1,
                step: 0.05
            })
        );
        assert_eq!(point("1,2,3"), Ok(glam::DVec3::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn bad_words_are_reported() {
        for bad in ["", "0", "-1", "nan", "inf", "d", "0d", "1 kg"] {
            assert!(bad.parse::<Width>().is_err(), "{bad}");
            assert!(bad.parse::<Density>().is_err(), "{bad}");
        }
        for bad in ["-4 mm", "0 mm", "4 mm2", "4 s", "mm"] {
            assert!(bad.parse::<Width>().is_err(), "{bad}");
        }
        for bad in [
            "",
            "1..2",
            "1/3",
            "2..1/5",
            "1..2/1",
            "1d..2/5",
            "1..2/x",
            "1..2/9999",
        ] {
            assert!(bad.parse::<Scan>().is_err(), "{bad}");
        }
        for bad in ["", "0x2", "2x", "axb", "1.5", "-3"] {
            assert!(bad.parse::<Cells>().is_err(), "{bad}");
        }
        for bad in [
            "",
            "x",
            "x=1",
            "x=2..1",
            "x=-1e308..1e308",
            "q=0..1",
            "x=0..1,x=0..1",
            "x=nan..1",
        ] {
            assert!(bad.parse::<Limits>().is_err(), "{bad}");
        }
        for bad in ["", "z", "-w", "-z+x", "--z"] {
            assert!(mirrors(bad).is_err(), "{bad}");
        }
        for bad in ["", "a", "3..2", "3..3", "-1", "1..", "1,,2"] {
            assert!(ids(bad).is_err(), "{bad}");
        }
        for bad in ["", "0.1", "0,1", "1,2,3"] {
            assert!(bad.parse::<Smoothing>().is_err(), "{bad}");
        }
        for bad in ["", "1,2", "1,2,x", "1,2,nan"] {
            assert!(point(bad).is_err(), "{bad}");
        }
    }
}
