//! Numbers with units as people write them, `20 rpm`, `5 mm`, `2.5 g/cm3`, as numbers in SI.
//!
//! ```
//! use mercury_common::units::{Dimension, Quantity};
//!
//! let quantity = Quantity::parse("2.5 g/cm3").unwrap();
//! assert_eq!(quantity.value(Dimension::DENSITY), Ok(2500.0));
//! // Powers of ten are exact: the number is the one that is nearest to what stands there.
//! assert_eq!(Quantity::parse("0.3 um").unwrap().value(Dimension::LENGTH), Ok(0.3e-6));
//! ```

use std::f64::consts::PI;

/// Longest text that is looked at.
const LONGEST: usize = 64;
/// Largest exponent of a unit.
const HIGHEST: i32 = 9;

/// Dimension of a number: powers of length, mass, time, angle and temperature. Angles count, so that 20 Hz are not taken for 20
/// rad/s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Dimension {
    powers: [i32; 5],
    /// Whether angles are counted in degrees, not in rad.
    in_degrees: bool,
}

macro_rules! dimensions {
    ($($name:ident = [$($power:literal),*], $words:literal, $units:literal;)*) => {
        impl Dimension {
            $(#[doc = concat!("Of ", $words, ": ", $units, ".")]
            pub const $name: Self = Self { powers: [$($power),*], in_degrees: false };)*

            /// Dimensions that have a name, with it and with units of theirs, the SI unit first.
            const NAMED: &'static [(Self, &'static str, &'static str)] = &[
                $((Self::$name, $words, $units),)*
            ];
        }
    };
}

dimensions! {
    LENGTH = [1, 0, 0, 0, 0], "a length", "m, cm, mm, um, nm, km";
    AREA = [2, 0, 0, 0, 0], "an area", "m2, cm2, mm2";
    VOLUME = [3, 0, 0, 0, 0], "a volume", "m3, cm3, mm3, l, ml";
    TIME = [0, 0, 1, 0, 0], "a time", "s, ms, us, min, h, d";
    MASS = [0, 1, 0, 0, 0], "a mass", "kg, g, mg, t";
    SPEED = [1, 0, -1, 0, 0], "a speed", "m/s, mm/s, cm/s, km/h";
    ACCELERATION = [1, 0, -2, 0, 0], "an acceleration", "m/s2, mm/s2";
    ANGLE = [0, 0, 0, 1, 0], "an angle", "rad, deg, rev";
    ANGULAR_VELOCITY = [0, 0, -1, 1, 0], "an angular velocity", "rad/s, rpm, deg/s, rev/s";
    FREQUENCY = [0, 0, -1, 0, 0], "a frequency", "1/s, Hz, kHz, 1/min";
    FORCE = [1, 1, -2, 0, 0], "a force", "N, mN, kN";
    PRESSURE = [-1, 1, -2, 0, 0], "a pressure", "Pa, kPa, MPa, GPa, bar";
    DENSITY = [-3, 1, 0, 0, 0], "a density", "kg/m3, g/cm3, t/m3";
    MASS_RATE = [0, 1, -1, 0, 0], "a mass per time", "kg/s, g/s, kg/h, t/h";
    VOLUME_RATE = [3, 0, -1, 0, 0], "a volume per time", "m3/s, cm3/s, l/s, l/min";
    VOLUME_PER_ENERGY = [1, -1, 2, 0, 0], "a volume per energy", "m3/J, mm3/J";
    STIFFNESS = [0, 1, -2, 0, 0], "a force per length", "N/m, N/mm, kN/m, mN/m";
    TORQUE = [2, 1, -2, 0, 0], "a torque", "N m, mN m, N mm";
    TEMPERATURE = [0, 0, 0, 0, 1], "a temperature", "K, mK";
    VISCOSITY = [-1, 1, -1, 0, 0], "a viscosity", "Pa s, mPa s";
}

impl Dimension {
    /// Dimension of a pure number, whose only unit is per cent.
    pub const NUMBER: Self = Self {
        powers: [0; 5],
        in_degrees: false,
    };

    /// Dimension of an angle that is counted in degrees.
    pub const DEGREES: Self = Self {
        in_degrees: true,
        ..Self::ANGLE
    };

    /// The dimension of a unit, like `kg/s`; `None` of an empty one.
    #[must_use]
    pub fn of_unit(unit: &str) -> Option<Self> {
        if unit == "degrees" {
            return Some(Self::DEGREES);
        }
        let scale = parse_unit(unit.trim()).ok()?;
        (scale.powers != [0; 5]).then_some(Self {
            powers: scale.powers,
            in_degrees: false,
        })
    }

    fn named(powers: [i32; 5]) -> Option<(&'static str, &'static str)> {
        let mut named = Self::NAMED.iter();
        let found = named.find(|(dimension, ..)| dimension.powers == powers);
        found.map(|(_, words, units)| (*words, *units))
    }

    /// In words: `a length`.
    #[must_use]
    pub fn words(self) -> &'static str {
        words_of(self.powers)
    }

    /// The unit of SI, `deg` where angles are counted in degrees: `N/m`, `kg/m3`; of what has no name made of m, kg, s, rad and K.
    #[must_use]
    pub fn symbol(self) -> String {
        if self.in_degrees {
            return "deg".to_owned();
        }
        if let Some((_, units)) = Self::named(self.powers) {
            return units.split(',').next().unwrap_or_default().to_owned();
        }
        let factors = ["m", "kg", "s", "rad", "K"].iter().zip(self.powers);
        let factors = factors.filter(|(_, power)| *power != 0);
        let factors: Vec<String> = factors
            .map(|(symbol, power)| match power {
                1 => (*symbol).to_owned(),
                _ => format!("{symbol}{power}"),
            })
            .collect();
        factors.join(" ")
    }

    /// Units that it may have, as a list.
    #[must_use]
    pub fn units(self) -> &'static str {
        if self.in_degrees {
            return "deg, rad";
        }
        if self == Self::NUMBER {
            return "%";
        }
        Self::named(self.powers).map_or("those of SI", |(_, units)| units)
    }
}

/// Name of what these powers are of.
fn words_of(powers: [i32; 5]) -> &'static str {
    match powers {
        [0, 0, 0, 0, 0] => "a number without unit",
        powers => Dimension::named(powers).map_or("something else", |(words, _)| words),
    }
}

/// SI units in a unit: `num / den`, times powers of ten and of pi.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scale {
    powers: [i32; 5],
    ten: i32,
    num: f64,
    den: f64,
    pi: i32,
}

impl Scale {
    const ONE: Self = Self {
        powers: [0; 5],
        ten: 0,
        num: 1.0,
        den: 1.0,
        pi: 0,
    };

    fn of(powers: [i32; 5]) -> Self {
        Self {
            powers,
            ..Self::ONE
        }
    }

    fn times(self, other: Self) -> Self {
        let mut powers = self.powers;
        for (power, more) in powers.iter_mut().zip(other.powers) {
            *power += more;
        }
        Self {
            powers,
            ten: self.ten + other.ten,
            num: self.num * other.num,
            den: self.den * other.den,
            pi: self.pi + other.pi,
        }
    }

    fn inverse(self) -> Self {
        Self {
            powers: self.powers.map(|power| -power),
            ten: -self.ten,
            num: self.den,
            den: self.num,
            pi: -self.pi,
        }
    }

    fn power(self, exponent: i32) -> Self {
        let one = if exponent < 0 { self.inverse() } else { self };
        (0..exponent.abs()).fold(Self::ONE, |product, _| product.times(one))
    }
}

/// A number with its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// The number as it stands there.
    number: String,
    scale: Scale,
}

impl Quantity {
    /// A number, perhaps a space, a unit.
    ///
    /// # Errors
    /// The unit is unknown, or the number or the unit is missing.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text.len() > LONGEST {
            return Err("is too long for a number with a unit".to_owned());
        }
        let (number, unit) = text.split_at(number_length(text));
        if number.is_empty() {
            return Err("does not begin with a number".to_owned());
        }
        let unit = unit.trim();
        if unit.is_empty() {
            return Err("has no unit".to_owned());
        }
        Ok(Self {
            number: number.to_owned(),
            scale: parse_unit(unit)?,
        })
    }

    /// The unit as it stands there.
    #[must_use]
    pub fn unit_in(text: &str) -> &str {
        let text = text.trim();
        text[number_length(text)..].trim()
    }

    /// Whether a text begins like a number.
    #[must_use]
    pub fn is_begun_by(text: &str) -> bool {
        number_length(text.trim()) > 0
    }

    /// In SI units (degrees, if `wanted` has them), if it is of this dimension.
    ///
    /// # Errors
    /// The name of its dimension, if it is of another.
    pub fn value(&self, wanted: Dimension) -> Result<f64, &'static str> {
        if self.scale.powers != wanted.powers {
            return Err(self.words());
        }
        let mut scale = self.scale;
        if wanted.in_degrees {
            scale = scale.times(DEGREE.inverse());
        }
        Ok(self.scaled(scale))
    }

    /// In SI units, whatever it is of.
    #[must_use]
    pub fn si(&self) -> f64 {
        self.scaled(self.scale)
    }

    fn words(&self) -> &'static str {
        words_of(self.scale.powers)
    }

    fn scaled(&self, scale: Scale) -> f64 {
        // The power of ten goes into the decimal exponent: one rounding, that of the decimal number itself.
        let (digits, exponent) = match self.number.split_once(['e', 'E']) {
            Some((digits, exponent)) => (digits, exponent.parse().unwrap_or(0i32)),
            None => (self.number.as_str(), 0),
        };
        let exponent = exponent.saturating_add(scale.ten);
        let decimal: f64 = format!("{digits}e{exponent}").parse().unwrap_or(f64::NAN);
        let (num, den) = (scale.num, scale.den);
        let mut value = if num % den == 0.0 {
            decimal * (num / den)
        } else {
            decimal * num / den
        };
        for _ in 0..scale.pi.abs() {
            value = if scale.pi > 0 { value * PI } else { value / PI };
        }
        value
    }
}

/// Bytes of a number at the start of a text: sign, digits with a point, an exponent.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let sign = |at: usize| usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));
    let digits = |at: usize| {
        bytes[at.min(bytes.len())..]
            .iter()
            .take_while(|b| b.is_ascii_digit())
            .count()
    };
    let mut end = sign(0);
    let whole = digits(end);
    end += whole;
    let mut part = 0;
    if bytes.get(end) == Some(&b'.') {
        part = digits(end + 1);
        end += 1 + part;
    }
    if whole + part == 0 {
        return 0;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let from = end + 1 + sign(end + 1);
        // At most three digits, as for any float: `1e3`, not `1e`.
        if (1..=4).contains(&digits(from)) {
            end = from + digits(from);
        }
    }
    end
}

/// Factors between spaces, dots or stars; each `/` divides by the one factor behind it.
fn parse_unit(unit: &str) -> Result<Scale, String> {
    let mut scale = Scale::ONE;
    for (index, part) in unit.split('/').enumerate() {
        let mut factors = part
            .split([' ', '*', '\u{b7}', '.'])
            .filter(|factor| !factor.is_empty())
            .peekable();
        if index == 0 {
            // `1/s`, or `/s` behind the number.
            for factor in factors.filter(|factor| *factor != "1") {
                scale = scale.times(parse_factor(factor)?);
            }
            continue;
        }
        let Some(factor) = factors.next() else {
            return Err(format!("nothing follows a `/` of the unit {unit:?}"));
        };
        if factors.peek().is_some() {
            return Err(format!(
                "the unit {unit:?} can be read in two ways: write a `/` before each factor that divides"
            ));
        }
        scale = scale.times(parse_factor(factor)?.inverse());
    }
    Ok(scale)
}

/// A symbol and perhaps an exponent: `mm`, `m3`, `s^-2`, `m³`.
fn parse_factor(factor: &str) -> Result<Scale, String> {
    let is_exponent = |c: char| c.is_ascii_digit() || "+-^\u{b2}\u{b3}\u{b9}\u{207b}".contains(c);
    let at = factor.find(is_exponent).unwrap_or(factor.len());
    let (symbol, exponent) = factor.split_at(at);
    let digits: String = exponent
        .chars()
        .map(|c| match c {
            '\u{b2}' => '2',
            '\u{b3}' => '3',
            '\u{b9}' => '1',
            '\u{207b}' => '-',
            other => other,
        })
        .collect();
    let digits = digits.strip_prefix('^').unwrap_or(&digits);
    let exponent = if exponent.is_empty() {
        1
    } else {
        let number = digits.parse().ok();
        let number = number.filter(|number: &i32| (1..=HIGHEST).contains(&number.abs()));
        number.ok_or_else(|| format!("{exponent:?} is no exponent of a unit"))?
    };
    let scale = parse_symbol(symbol).ok_or_else(|| no_unit(symbol))?;
    Ok(scale.power(exponent))
}

/// Units of other systems, with what people write for them, in units that are known: exact, or to six digits.
#[rustfmt::skip]
const FOREIGN: &[(&[&str], &str)] = &[
    (&["in", "inch", "inches", "\""], "1 in = 25.4 mm"),
    (&["ft", "foot", "feet"], "1 ft = 0.3048 m"),
    (&["yd", "yard", "yards"], "1 yd = 0.9144 m"),
    (&["mi", "mile", "miles"], "1 mi = 1.609344 km"),
    (&["mil", "mils", "thou"], "1 mil = 0.0254 mm"),
    (&["A", "\u{c5}", "angstrom"], "1 angstrom = 0.1 nm"),
    (&["lb", "lbs", "lbm", "pound", "pounds"], "1 lb = 0.45359237 kg"),
    (&["oz", "ounce", "ounces"], "1 oz = 28.349523125 g"),
    (&["lbf"], "1 lbf = 4.44822 N"),
    (&["kgf", "kp"], "1 kgf = 9.80665 N"),
    (&["dyn", "dyne"], "1 dyn = 0.01 mN"),
    (&["psi"], "1 psi = 6.89476 kPa"),
    (&["ksi"], "1 ksi = 6.89476 MPa"),
    (&["psf"], "1 psf = 47.8803 Pa"),
    (&["pcf"], "1 pcf = 16.0185 kg/m3"),
    (&["atm"], "1 atm = 101.325 kPa"),
    (&["Torr", "torr", "mmHg"], "1 Torr = 133.322 Pa"),
    (&["mmH2O"], "1 mmH2O = 9.80665 Pa"),
    (&["mph"], "1 mph = 0.44704 m/s"),
    (&["fpm"], "1 fpm = 5.08 mm/s"),
    (&["g0", "gee"], "1 g0 = 9.80665 m/s2"),
    (&["erg"], "1 erg = 0.1 uJ"),
    (&["cal"], "1 cal = 4.184 J"),
    (&["P", "poise", "Poise"], "1 P = 0.1 Pa s"),
    (&["cP", "cp", "centipoise"], "1 cP = 1 mPa s"),
    (&["gal", "gallon", "gallons"], "1 gal (US) = 3.78541 l"),
    (&["cc", "ccm"], "1 cc = 1 cm3"),
    (&["gpm"], "1 gpm (US) = 3.78541 l/min"),
    (&["week", "weeks"], "1 week = 7 d"),
];

/// Other words for units that are known.
#[rustfmt::skip]
const WORDS: &[(&[&str], &str)] = &[
    (&["sec", "secs", "second", "seconds", "S"], "s"),
    (&["msec", "millisecond", "milliseconds"], "ms"),
    (&["usec", "microsecond", "microseconds"], "us"),
    (&["minute", "minutes", "mins", "Min"], "min"),
    (&["hr", "hrs", "hour", "hours", "H"], "h"),
    (&["day", "days", "D"], "d"),
    (&["meter", "meters", "metre", "metres"], "m"),
    (&["millimeter", "millimeters", "millimetre", "millimetres"], "mm"),
    (&["centimeter", "centimeters", "centimetre", "centimetres"], "cm"),
    (&["micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"], "um"),
    (&["gram", "grams", "gr"], "g"),
    (&["kilo", "kilos", "kilogram", "kilograms", "kgs"], "kg"),
    (&["ton", "tons", "tonne", "tonnes", "to"], "t"),
    (&["newton", "newtons", "Newton"], "N"),
    (&["pascal", "pascals", "Pascal"], "Pa"),
    (&["hertz", "Hertz"], "Hz"),
    (&["kelvin", "Kelvin"], "K"),
    (&["joule", "joules", "Joule"], "J"),
    (&["watt", "watts", "Watt"], "W"),
    (&["liter", "liters", "litre", "litres", "ltr"], "l"),
    (&["radian", "radians"], "rad"),
    (&["turn", "turns", "rot", "revolution", "revolutions"], "rev"),
    (&["cbm"], "m3"),
    (&["sqm"], "m2"),
    (&["percent", "pct"], "%"),
];

/// The known unit that is meant by a word for it or by one in other letters: `sec`, `kpa`, `KG`.
fn meant(symbol: &str) -> Option<&'static str> {
    let by_word = WORDS.iter().find(|(words, _)| words.contains(&symbol));
    by_word.map(|(_, unit)| *unit).or_else(|| {
        let units = Dimension::NAMED
            .iter()
            .flat_map(|(_, _, units)| units.split(", "));
        let symbols = units.flat_map(|unit| unit.split(['/', ' ']));
        let symbols = symbols.map(|symbol| symbol.trim_end_matches(|c: char| c.is_ascii_digit()));
        let mut like = symbols.filter(|known| known.eq_ignore_ascii_case(symbol));
        // `mpa` may be mPa or MPa.
        let first = like.next()?;
        like.all(|other| other == first).then_some(first)
    })
}

/// Message for a symbol that is no unit.
fn no_unit(symbol: &str) -> String {
    if let Some((_, conversion)) = FOREIGN.iter().find(|(names, _)| names.contains(&symbol)) {
        return format!("there is no unit {symbol:?}: write it in another, {conversion}");
    }
    if let Some(meant) = meant(symbol) {
        return format!("there is no unit {symbol:?}: did you mean {meant}?");
    }
    let scale = symbol
        .trim_start_matches("deg")
        .trim_start_matches('\u{b0}');
    let name = match scale {
        "C" | "Celsius" => "Celsius",
        "F" | "Fahrenheit" => "Fahrenheit",
        _ => return format!("there is no unit {symbol:?}"),
    };
    format!(
        "is in degrees {name}, which begin at another zero than kelvin: write kelvin, 293.15 K for 20 \u{b0}C"
    )
}

/// pi/180 rad.
const DEGREE: Scale = Scale {
    powers: [0, 0, 0, 1, 0],
    ten: 0,
    num: 1.0,
    den: 180.0,
    pi: 1,
};

/// Units without prefixes, and whether they may have one.
fn unit_named(symbol: &str) -> Option<(Scale, bool)> {
    let of = Scale::of;
    let time = |seconds: f64| Scale {
        num: seconds,
        ..of([0, 0, 1, 0, 0])
    };
    let turn = Scale {
        num: 2.0,
        pi: 1,
        ..of([0, 0, 0, 1, 0])
    };
    let per = |scale: Scale, time: Scale| scale.times(time.inverse());
    Some(match symbol {
        "m" => (of([1, 0, 0, 0, 0]), true),
        "g" => (
            Scale {
                ten: -3,
                ..of([0, 1, 0, 0, 0])
            },
            true,
        ),
        "t" => (
            Scale {
                ten: 3,
                ..of([0, 1, 0, 0, 0])
            },
            false,
        ),
        "s" => (time(1.0), true),
        "min" => (time(60.0), false),
        "h" => (time(3600.0), false),
        "d" => (time(86400.0), false),
        "l" | "L" => (
            Scale {
                ten: -3,
                ..of([3, 0, 0, 0, 0])
            },
            true,
        ),
        "Hz" => (of([0, 0, -1, 0, 0]), true),
        "N" => (of([1, 1, -2, 0, 0]), true),
        "Pa" => (of([-1, 1, -2, 0, 0]), true),
        "bar" => (
            Scale {
                ten: 5,
                ..of([-1, 1, -2, 0, 0])
            },
            true,
        ),
        "J" => (of([2, 1, -2, 0, 0]), true),
        "W" => (of([2, 1, -3, 0, 0]), true),
        "K" => (of([0, 0, 0, 0, 1]), true),
        "rad" => (of([0, 0, 0, 1, 0]), true),
        "deg" | "degree" | "degrees" | "\u{b0}" => (DEGREE, false),
        "rev" => (turn, false),
        "rpm" => (per(turn, time(60.0)), false),
        "rps" => (per(turn, time(1.0)), false),
        "%" => (
            Scale {
                ten: -2,
                ..Scale::ONE
            },
            false,
        ),
        _ => return None,
    })
}

fn parse_symbol(symbol: &str) -> Option<Scale> {
    if let Some((scale, _)) = unit_named(symbol) {
        return Some(scale);
    }
    let prefix = symbol.chars().next()?;
    let ten = match prefix {
        'G' => 9,
        'M' => 6,
        'k' => 3,
        'h' => 2,
        'd' => -1,
        'c' => -2,
        'm' => -3,
        'u' | '\u{b5}' | '\u{3bc}' => -6,
        'n' => -9,
        'p' => -12,
        _ => return None,
    };
    let (scale, takes_prefix) = unit_named(&symbol[prefix.len_utf8()..])?;
    takes_prefix.then_some(Scale {
        ten: scale.ten + ten,
        ..scale
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn value(text: &str, dimension: Dimension) -> Result<f64, String> {
        Quantity::parse(text)?
            .value(dimension)
            .map_err(str::to_owned)
    }

    #[test]
    fn units_of_si_read_back_as_the_same_dimension() {
        for (dimension, _, _) in Dimension::NAMED {
            assert_eq!(Dimension::of_unit(&dimension.symbol()), Some(*dimension));
        }
        let odd = Dimension::of_unit("rad m2/s/kg3").unwrap();
        assert_eq!(odd.symbol(), "m2 kg-3 s-1 rad");
        assert_eq!(Dimension::of_unit(&odd.symbol()), Some(odd));
        assert_eq!(Dimension::DEGREES.symbol(), "deg");
        assert_eq!(Quantity::unit_in(" -1.5e3 mm/s "), "mm/s");
    }

    #[test]
    fn units_are_what_they_are() {
        use Dimension as D;
        for (text, dimension, expected) in [
            ("5 mm", D::LENGTH, 5e-3),
            ("5mm", D::LENGTH, 5e-3),
            (".5 um", D::LENGTH, 0.5e-6),
            ("-3e2 \u{b5}m", D::LENGTH, -300e-6),
            ("12 cm2", D::AREA, 12e-4),
            ("1 mm^2", D::AREA, 1e-6),
            ("2 m\u{b3}", D::VOLUME, 2.0),
            ("7 ml", D::VOLUME, 7e-6),
            ("1.5 h", D::TIME, 5400.0),
            ("20 min", D::TIME, 1200.0),
            ("36 km/h", D::SPEED, 10.0),
            ("9.81 m/s2", D::ACCELERATION, 9.81),
            ("9.81 m/s/s", D::ACCELERATION, 9.81),
            ("9.81 m s^-2", D::ACCELERATION, 9.81),
            ("20 rpm", D::ANGULAR_VELOCITY, 20.0 * 2.0 * PI / 60.0),
            ("1 rev/s", D::ANGULAR_VELOCITY, 2.0 * PI),
            ("90 deg/s", D::ANGULAR_VELOCITY, 90.0 / 180.0 * PI),
            ("30 deg", D::ANGLE, 30.0 / 180.0 * PI),
            ("30 deg", D::DEGREES, 30.0),
            ("30\u{b0}", D::DEGREES, 30.0),
            ("60 1/min", D::FREQUENCY, 1.0),
            ("60/min", D::FREQUENCY, 1.0),
            ("2 kHz", D::FREQUENCY, 2000.0),
            ("10 kPa", D::PRESSURE, 1e4),
            ("70 GPa", D::PRESSURE, 7e10),
            ("0.5 mbar", D::PRESSURE, 50.0),
            ("3 N/mm2", D::PRESSURE, 3e6),
            ("2.5 g/cm3", D::DENSITY, 2500.0),
            ("1.1 t/m3", D::DENSITY, 1100.0),
            ("36 t/h", D::MASS_RATE, 10.0),
            ("6 l/min", D::VOLUME_RATE, 1e-4),
            ("3 N/mm", D::STIFFNESS, 3000.0),
            ("2 mN m", D::TORQUE, 2e-3),
            ("1 mPa s", D::VISCOSITY, 1e-3),
            ("40 %", D::NUMBER, 0.4),
            ("0.3%", D::NUMBER, 0.003),
            ("293.15 K", D::TEMPERATURE, 293.15),
            ("5 mK", D::TEMPERATURE, 5e-3),
            ("1 mPa\u{b7}s", D::VISCOSITY, 1e-3),
        ] {
            let found = value(text, dimension).unwrap_or_else(|error| panic!("{text}: {error}"));
            // Exact where it is a decimal number; two roundings where there is a factor of pi or an hour.
            let is_near = (found - expected).abs() <= 2.0 * f64::EPSILON * expected.abs();
            assert!(is_near, "{text}: {found} for {expected}");
        }
        let half_turn = value("3.141592653589793 rad", D::DEGREES).unwrap();
        assert!((half_turn - 180.0).abs() < 1e-13);
    }

    #[test]
    fn what_is_no_unit_is_reported() {
        for (text, error) in [
            ("5 ", "has no unit"),
            ("mm", "does not begin with a number"),
            ("5 mmm", "there is no unit \"mmm\""),
            ("5 kmin", "there is no unit \"kmin\""),
            ("5 kd", "there is no unit \"kd\""),
            (
                "20 \u{b0}C",
                "is in degrees Celsius, which begin at another zero than kelvin: write kelvin, 293.15 K for 20 \u{b0}C",
            ),
            (
                "68 degF",
                "is in degrees Fahrenheit, which begin at another zero than kelvin: write kelvin, 293.15 K for 20 \u{b0}C",
            ),
            ("5 m/", "nothing follows a `/` of the unit \"m/\""),
            ("5 m0", "\"0\" is no exponent of a unit"),
            ("5 m99", "\"99\" is no exponent of a unit"),
            (
                "5 J/kg K",
                "the unit \"J/kg K\" can be read in two ways: write a `/` before each factor that divides",
            ),
        ] {
            assert_eq!(Quantity::parse(text).unwrap_err(), error, "{text}");
        }
        assert_eq!(value("5 kg", Dimension::LENGTH), Err("a mass".to_owned()));
        // A frequency is no angular velocity: 2 pi lies between them.
        assert_eq!(
            value("5 Hz", Dimension::ANGULAR_VELOCITY),
            Err("a frequency".to_owned())
        );
        assert_eq!(
            value("5 m7", Dimension::LENGTH),
            Err("something else".to_owned())
        );
    }

    /// Each conversion holds: what stands on its right is a quantity that is known, and nothing on its left is a unit.
    #[test]
    fn units_of_other_systems_are_named_with_their_conversion() {
        for (names, conversion) in FOREIGN {
            let (_, known) = conversion.split_once(" = ").unwrap();
            assert!(Quantity::parse(known).is_ok(), "{conversion}");
            for name in *names {
                assert!(unit_named(name).is_none(), "{name}");
                assert!(no_unit(name).contains(conversion), "{name}");
            }
        }
        let si = |text: &str| Quantity::parse(text).unwrap().si();
        // A pound-force per square inch, from the definitions of pound, inch and standard gravity.
        let psi = 0.453_592_37 * 9.806_65 / (0.0254 * 0.0254);
        assert!((si("6.89476 kPa") - psi).abs() < 5e-7 * psi);
        assert!((si("4.44822 N") - 0.453_592_37 * 9.806_65).abs() < 5e-6);
        for (words, unit) in WORDS {
            assert!(*unit == "%" || Dimension::of_unit(unit).is_some(), "{unit}");
            for word in *words {
                let expected = format!("there is no unit {word:?}: did you mean {unit}?");
                assert_eq!(no_unit(word), expected);
                assert!(parse_symbol(word).is_none(), "{word}");
            }
        }
        for (word, unit) in [("KPa", "kPa"), ("hz", "Hz"), ("KG", "kg"), ("Bar", "bar")] {
            assert_eq!(meant(word), Some(unit));
        }
        // Milli or mega.
        assert_eq!(meant("mpa"), None);
        assert_eq!(meant("parsec"), None);
    }

    #[test]
    fn each_named_dimension_is_that_of_its_own_units() {
        for (dimension, words, units) in Dimension::NAMED {
            for (index, unit) in units.split(", ").enumerate() {
                assert_eq!(
                    Dimension::of_unit(unit),
                    Some(*dimension),
                    "{words}: {unit}"
                );
                // The first one is that of SI.
                let one = Quantity::parse(&format!("1 {unit}")).unwrap();
                assert_eq!(
                    one.si() == 1.0,
                    index == 0 || ["Hz", "1/Pa"].contains(&unit),
                    "{words}: {unit}"
                );
            }
        }
        assert_eq!(Dimension::of_unit("degrees"), Some(Dimension::DEGREES));
        assert_eq!(Dimension::of_unit(""), None);
    }

    proptest! {
        /// The nearest number to the decimal that stands there, and text and float agree.
        #[test]
        fn decimal_units_are_exact(digits in -1_000_000_000_000i64..1_000_000_000_000, point in -9i32..9) {
            for (unit, ten) in [("km", 3), ("m", 0), ("cm", -2), ("mm", -3), ("nm", -9)] {
                let wanted: f64 = format!("{digits}e{}", point + ten).parse().unwrap();
                prop_assert_eq!(value(&format!("{digits}e{point} {unit}"), Dimension::LENGTH), Ok(wanted));
            }
        }

        /// Any float written out comes back to the bit.
        #[test]
        fn floats_come_back(number in proptest::num::f64::NORMAL) {
            prop_assert_eq!(value(&format!("{number:e} m"), Dimension::LENGTH), Ok(number));
        }

        /// Any text is a quantity or an error, and nothing else.
        #[test]
        fn no_text_is_too_wild(text in "\\PC{0,80}", unit in "[-+a-zA-Z0-9/^* .]{0,20}") {
            let _ = Quantity::parse(&text);
            if let Ok(quantity) = Quantity::parse(&format!("1 {unit}")) {
                let _ = quantity.si();
            }
        }

        /// A product of units has the product of the scales.
        #[test]
        fn units_multiply(a in 0usize..5, b in 0usize..5) {
            let units = ["mm", "kg", "s", "kPa", "N"];
            let si = |unit: &str| Quantity::parse(&format!("1 {unit}")).unwrap().si();
            let (x, y) = (units[a], units[b]);
            let product = si(&format!("{x} {y}"));
            prop_assert!((product - si(x) * si(y)).abs() <= 1e-15 * product);
            let quotient = si(&format!("{x}/{y}"));
            prop_assert!((quotient - si(x) / si(y)).abs() <= 1e-15 * quotient);
        }
    }
}
