//! Floating point numbers as text: exact and short, or like C's `%.{P}g`.

use std::io::Write as _;

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NumberStyle {
    /// The shortest decimal number that reads back to the same bits (NaN payloads excepted).
    #[default]
    Shortest,
    /// This many significant digits (1 to 17; others are clamped), in the form of C's `%.{P}g`.
    /// `Digits(10)` is what MercuryDPM prints, with 15 digits for positions.
    Digits(u8),
}

impl NumberStyle {
    /// The style of particle positions: at least 15 digits, so that overlaps survive.
    #[must_use]
    pub fn for_positions(self) -> Self {
        match self {
            Self::Shortest => Self::Shortest,
            Self::Digits(digits) => Self::Digits(digits.max(15)),
        }
    }
}

/// Reads one number: what Rust's `f64` accepts, which includes `-0`, `nan`, `-nan`, `inf` and `1E5`.
/// `None` if it is not a number.
#[must_use]
pub fn parse_number(text: &str) -> Option<f64> {
    text.parse().ok()
}

/// Reads one number as [`parse_number`] does, or as Fortran writes it: `1.0D+00`, and `1.000000-101`, where a long exponent
/// leaves no room for its letter.
///
/// ```
/// use mercury_common::formats::number::parse_number_of_fortran;
///
/// assert_eq!(parse_number_of_fortran("-1.5D+02"), Some(-150.0));
/// assert_eq!(parse_number_of_fortran("1.5-02"), Some(0.015));
/// // Not two numbers that run together.
/// assert_eq!(parse_number_of_fortran("1.5-2.5"), None);
/// ```
#[must_use]
pub fn parse_number_of_fortran(text: &str) -> Option<f64> {
    parse_number(text).or_else(|| {
        let (significand, exponent, least_digits) = match text.find(['d', 'D']) {
            Some(letter) => (&text[..letter], &text[letter + 1..], 1),
            None => {
                let sign = text.rfind(['+', '-'])?;
                (&text[..sign], &text[sign..], 2)
            }
        };
        let digits = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
        let is_exponent = (least_digits..=3).contains(&digits.len())
            && digits.bytes().all(|byte| byte.is_ascii_digit())
            && (least_digits == 1 || significand.contains('.'));
        is_exponent
            .then(|| parse_number(&format!("{significand}e{exponent}")))
            .flatten()
    })
}

/// Appends one number.
pub fn push_number(out: &mut Vec<u8>, value: f64, style: NumberStyle) {
    if value.is_nan() {
        out.extend_from_slice(b"nan");
    } else if value.is_infinite() {
        out.extend_from_slice(if value > 0.0 { b"inf" } else { b"-inf" });
    } else {
        match style {
            NumberStyle::Shortest => push_shortest(out, value),
            NumberStyle::Digits(digits) => push_digits(out, value, digits.clamp(1, 17)),
        }
    }
}

/// Appends the numbers separated by single blanks.
pub fn push_numbers(out: &mut Vec<u8>, values: &[f64], style: NumberStyle) {
    for (index, &value) in values.iter().enumerate() {
        if index > 0 {
            out.push(b' ');
        }
        push_number(out, value, style);
    }
}

/// Appends a whole number.
pub fn push_integer(out: &mut Vec<u8>, value: i64) {
    append(out, format_args!("{value}"));
}

/// Appends one number right-aligned in a field; a longer number overflows the field like in C.
pub fn push_number_in_width(out: &mut Vec<u8>, value: f64, style: NumberStyle, width: usize) {
    let start = out.len();
    push_number(out, value, style);
    let length = out.len() - start;
    if length < width {
        let padding = width - length;
        out.resize(start + width, b' ');
        out.copy_within(start..start + length, start + padding);
        out[start..start + padding].fill(b' ');
    }
}

/// Whole numbers are frequent (zeros, indices, box corners) and need no search for digits.
/// `limit` is the smallest magnitude that is not written this way.
fn push_if_whole(out: &mut Vec<u8>, value: f64, limit: f64) -> bool {
    if value.abs() >= limit || value.trunc() != value {
        return false;
    }
    if value == 0.0 {
        out.extend_from_slice(if value.is_sign_negative() {
            b"-0"
        } else {
            b"0"
        });
    } else {
        // Exact: the magnitude is below 1e15.
        push_integer(out, value as i64);
    }
    true
}

fn push_shortest(out: &mut Vec<u8>, value: f64) {
    if push_if_whole(out, value, 1e15) {
        return;
    }
    let mut buffer = zmij::Buffer::new();
    let text = buffer.format_finite(value);
    let text = text.strip_suffix(".0").unwrap_or(text);
    let is_plain = (1e-5..1e16).contains(&value.abs());
    match text.split_once('e') {
        None if is_plain => out.extend_from_slice(text.as_bytes()),
        Some((significand, exponent)) if !is_plain => {
            out.extend_from_slice(significand.as_bytes());
            out.push(b'e');
            out.extend_from_slice(exponent.trim_start_matches('+').as_bytes());
        }
        // The library has other limits between the two forms.
        _ if is_plain => append(out, format_args!("{value}")),
        _ => append(out, format_args!("{value:e}")),
    }
}

/// C's `%.{digits}g` (ISO C 7.21.6.1): exponent form if the decimal exponent of the rounded number is
/// below -4 or not below the precision, trailing zeros removed, at least two digits of exponent.
fn push_digits(out: &mut Vec<u8>, value: f64, digits: u8) {
    if push_if_whole(out, value, 10u64.pow(u32::from(digits.min(15))) as f64) {
        return;
    }
    // Sign, digit, point, 16 digits, `e`, sign, 3 digits: 24 bytes at most.
    let mut scratch = [0u8; 32];
    let mut rest = &mut scratch[..];
    let precision = usize::from(digits) - 1;
    // Cannot fail: the text is shorter than the buffer.
    let _ = write!(rest, "{:.precision$e}", value.abs());
    let free = rest.len();
    let text = &scratch[..scratch.len() - free];

    let mark = text
        .iter()
        .position(|&byte| byte == b'e')
        .unwrap_or(text.len());
    let exponent = text.get(mark + 1..).map_or(0, parse_exponent);
    let mut significand = [0u8; 17];
    let mut count = 0;
    for &byte in text[..mark].iter().filter(|byte| byte.is_ascii_digit()) {
        significand[count] = byte;
        count += 1;
    }
    while count > 1 && significand[count - 1] == b'0' {
        count -= 1;
    }
    let significand = &significand[..count];

    if value.is_sign_negative() {
        out.push(b'-');
    }
    if exponent < -4 || exponent >= i32::from(digits) {
        out.push(significand[0]);
        if count > 1 {
            out.push(b'.');
            out.extend_from_slice(&significand[1..]);
        }
        let sign = if exponent < 0 { '-' } else { '+' };
        append(out, format_args!("e{sign}{:02}", exponent.unsigned_abs()));
    } else if exponent < 0 {
        out.extend_from_slice(b"0.");
        out.extend(std::iter::repeat_n(
            b'0',
            exponent.unsigned_abs() as usize - 1,
        ));
        out.extend_from_slice(significand);
    } else {
        let before_point = exponent.unsigned_abs() as usize + 1;
        out.extend_from_slice(&significand[..before_point.min(count)]);
        out.extend(std::iter::repeat_n(
            b'0',
            before_point.saturating_sub(count),
        ));
        if count > before_point {
            out.push(b'.');
            out.extend_from_slice(&significand[before_point..]);
        }
    }
}

fn parse_exponent(text: &[u8]) -> i32 {
    let (sign, digits) = match text.split_first() {
        Some((b'-', rest)) => (-1, rest),
        _ => (1, text),
    };
    sign * digits
        .iter()
        .fold(0, |sum, &digit| sum * 10 + i32::from(digit - b'0'))
}

fn append(out: &mut Vec<u8>, text: std::fmt::Arguments<'_>) {
    // Writing to a vector cannot fail.
    let _ = out.write_fmt(text);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn text(value: f64, style: NumberStyle) -> String {
        let mut out = Vec::new();
        push_number(&mut out, value, style);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn digits_follow_c() {
        // Printed by C's printf with the same precision.
        for (value, digits, expected) in [
            (0.0, 10, "0"),
            (-0.0, 10, "-0"),
            (1.0, 10, "1"),
            (-2.5, 10, "-2.5"),
            (0.1 + 0.2, 10, "0.3"),
            (0.1 + 0.2, 17, "0.30000000000000004"),
            (1e-4, 10, "0.0001"),
            (1e-5, 10, "1e-05"),
            (0.000012345678901, 10, "1.23456789e-05"),
            (9999999999.0, 10, "9999999999"),
            (99999999999.0, 10, "1e+11"),
            (99999999999.0, 11, "99999999999"),
            (1e10, 10, "1e+10"),
            (9999999999.5, 10, "1e+10"),
            (0.99999999999, 10, "1"),
            (0.000099999999999, 10, "0.0001"),
            (123456789.123, 10, "123456789.1"),
            (120.5, 3, "120"),
            (100.0, 1, "1e+02"),
            (2.633735405e+37, 10, "2.633735405e+37"),
            (5e-324, 10, "4.940656458e-324"),
            (f64::MAX, 17, "1.7976931348623157e+308"),
            (1e22, 15, "1e+22"),
            (f64::NAN, 10, "nan"),
            (f64::NEG_INFINITY, 10, "-inf"),
        ] {
            assert_eq!(
                text(value, NumberStyle::Digits(digits)),
                expected,
                "{value:e} {digits}"
            );
        }
    }

    #[test]
    fn shortest_looks_normal() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "-0"),
            (3.0, "3"),
            (0.1, "0.1"),
            (1e-5, "0.00001"),
            (1.5e-6, "1.5e-6"),
            (1e15, "1000000000000000"),
            (1e16, "1e16"),
            (-1e300, "-1e300"),
            (5e-324, "5e-324"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(text(value, NumberStyle::Shortest), expected);
        }
    }

    #[test]
    fn reads_the_spellings_of_c() {
        assert_eq!(
            parse_number("-0").map(f64::to_bits),
            Some((-0.0f64).to_bits())
        );
        for nan in ["nan", "-nan", "NaN"] {
            assert!(parse_number(nan).unwrap().is_nan(), "{nan}");
        }
        assert_eq!(parse_number("-inf"), Some(f64::NEG_INFINITY));
        assert_eq!(parse_number("1E+05"), Some(1e5));
        for bad in ["", ".", "1,5", "0x10", "1e", "--1", "1d5", "1 2"] {
            assert_eq!(parse_number(bad), None, "{bad}");
        }
    }

    #[test]
    fn width_pads_on_the_left_and_overflows() {
        let mut out = b"|".to_vec();
        push_number_in_width(&mut out, -1.5, NumberStyle::Digits(10), 6);
        push_number_in_width(&mut out, 1234567.0, NumberStyle::Digits(10), 6);
        assert_eq!(out, b"|  -1.51234567");
    }

    proptest! {
        #[test]
        fn shortest_reads_back_exactly(bits: u64) {
            let value = f64::from_bits(bits);
            let back = parse_number(&text(value, NumberStyle::Shortest)).unwrap();
            if value.is_nan() {
                prop_assert!(back.is_nan());
            } else {
                prop_assert_eq!(back.to_bits(), bits);
            }
        }

        /// As the standard library writes it, numbers of any bits and of the sizes that scenes have; but of two shortest numbers that are equally near
        /// it may be the other.
        #[test]
        fn shortest_is_that_of_the_standard_library(bits: u64, significand in -10.0..10.0f64, exponent in -20..20i32) {
            for value in [f64::from_bits(bits), significand * 10f64.powi(exponent), significand.round() * 10f64.powi(exponent)] {
                let plain = value == 0.0 || (1e-5..1e16).contains(&value.abs());
                let expected = if plain { format!("{value}") } else { format!("{value:e}") };
                let written = text(value, NumberStyle::Shortest);
                if value.is_nan() {
                    prop_assert_eq!(written, "nan");
                } else if written != expected {
                    prop_assert_eq!(written.len(), expected.len(), "{} {}", written, expected);
                    prop_assert_eq!(written.parse::<f64>(), expected.parse::<f64>());
                    let exact = format!("{value:.30}");
                    let digits = exact.trim_end_matches('0').len();
                    prop_assert!(digits == written.len() + 1 && exact[..digits].ends_with('5'), "{} is no tie", value);
                }
            }
        }

        #[test]
        fn digits_are_within_half_a_unit_of_the_last(
            bits in any::<u64>().prop_filter("normal", |bits| f64::from_bits(*bits).is_normal()),
            digits in 1u8..=17,
        ) {
            let value = f64::from_bits(bits);
            let written = text(value, NumberStyle::Digits(digits));
            // Independent route: the exponent form of the standard library at the same precision.
            let reference: f64 = format!("{:.*e}", usize::from(digits) - 1, value).parse().unwrap();
            let back = parse_number(&written).unwrap();
            prop_assert_eq!(back.to_bits(), reference.to_bits(), "{}", written);
            let significant = written.trim_start_matches('-').split('e').next().unwrap()
                .chars().filter(char::is_ascii_digit).collect::<String>();
            prop_assert!(significant.trim_start_matches('0').trim_end_matches('0').len() <= usize::from(digits));
        }
    }
}
