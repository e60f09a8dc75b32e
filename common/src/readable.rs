//! Numbers for people: in reports, messages and progress lines. Numbers for programs are written by [`formats`](crate::formats).

use std::borrow::Cow;

/// A duration in everyday units: `7.25 s`, `3 min 20 s`, `2 h 5 min`.
#[must_use]
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds >= 8.64e6 {
        return "> 100 d".to_owned();
    }
    if seconds < 9.995 {
        return format!("{seconds:.2} s");
    }
    let whole = seconds.round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, min, s) => format!("{min} min {s} s"),
        (h, min, _) => format!("{h} h {min} min"),
    }
}

/// The text, or so many of its first characters and dots: messages quote files, and files hold anything.
#[must_use]
pub fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        Some((end, _)) => Cow::Owned(format!("{}...", &text[..end])),
        None => Cow::Borrowed(text),
    }
}

/// The text as a terminal may show it: control characters, by which a file could move the cursor or begin a line of its own, become
/// U+FFFD; tabs stay.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    without_controls(text, &['\t'])
}

/// Text of several lines without control characters, but for tabs and line ends.
#[must_use]
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    without_controls(text, &['\t', '\n'])
}

fn without_controls<'t>(text: &'t str, kept: &[char]) -> Cow<'t, str> {
    let is_bad = |c: char| c.is_control() && !kept.contains(&c);
    match text.contains(is_bad) {
        true => Cow::Owned(text.replace(is_bad, "\u{fffd}")),
        false => Cow::Borrowed(text),
    }
}

/// A number of bytes to two or three digits, in powers of 1000: `512 B`, `1.2 kB`, `350 MB`, `1.2 TB`.
#[must_use]
pub fn bytes(number: f64) -> String {
    const UNITS: [&str; 7] = ["B", "kB", "MB", "GB", "TB", "PB", "EB"];
    if !number.is_finite() {
        return format!("{number} B");
    }
    let (mut value, mut unit) = (number.abs().round(), 0);
    // A number that rounds to 1000 belongs to the next unit.
    while value >= 999.5 && unit + 1 < UNITS.len() {
        (value, unit) = (value / 1000.0, unit + 1);
    }
    let decimals = usize::from(unit > 0 && value < 9.95);
    let sign = if number < 0.0 { "-" } else { "" };
    format!("{sign}{value:.decimals$} {}", UNITS[unit])
}

/// A number of things: `7`, `12,500`, `1,000,000`.
#[must_use]
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number of things with their name, whose plural ends in s: `1 frame`, `12 frames`.
#[must_use]
pub fn counted(number: usize, what: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {what}{plural}", count(number as u64))
}

/// A number to so many significant digits (1 to 17), with an exponent where it is very large or small: `0.3`, `123457`,
/// `5.49451e6`.
#[must_use]
pub fn significant(number: f64, digits: usize) -> String {
    let rounded = rounded(number, digits);
    if rounded == 0.0 || !rounded.is_finite() || (1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// The number with at most so many significant digits (1 to 17) that is nearest. Twelve hide the round-off of n times a step
/// (0.19999999999999998).
#[must_use]
pub fn rounded(number: f64, digits: usize) -> f64 {
    let decimals = digits.clamp(1, 17) - 1;
    let rounded = format!("{number:.decimals$e}").parse().ok();
    // The largest numbers have no neighbour above them that is one.
    rounded.filter(|r: &f64| r.is_finite()).unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn durations() {
        for (seconds, text) in [
            (0.4, "0.40 s"),
            (9.999, "10 s"),
            (59.6, "1 min 0 s"),
            (3599.4, "59 min 59 s"),
            (7500.0, "2 h 5 min"),
            (f64::INFINITY, "> 100 d"),
            (f64::NAN, "> 100 d"),
        ] {
            assert_eq!(duration(seconds), text);
        }
    }

    #[test]
    fn bytes_have_a_fitting_unit() {
        for (number, text) in [
            (0.0, "0 B"),
            (0.4, "0 B"),
            (999.0, "999 B"),
            (1000.0, "1.0 kB"),
            (9_949.0, "9.9 kB"),
            (9_951.0, "10 kB"),
            (349.6e6, "350 MB"),
            (999.4e6, "999 MB"),
            (999.6e6, "1.0 GB"),
            (1.172e12, "1.2 TB"),
            (5e24, "5000000 EB"),
            (-2048.0, "-2.0 kB"),
            (f64::INFINITY, "inf B"),
        ] {
            assert_eq!(bytes(number), text, "{number}");
        }
    }

    #[test]
    fn counts_are_grouped() {
        for (number, text) in [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (12_345_678, "12,345,678"),
            (u64::MAX, "18,446,744,073,709,551,615"),
        ] {
            assert_eq!(count(number), text);
        }
        assert_eq!(counted(1, "frame"), "1 frame");
        assert_eq!(counted(0, "frame"), "0 frames");
        assert_eq!(counted(1500, "frame"), "1,500 frames");
    }

    #[test]
    fn numbers_are_short_and_right() {
        for (number, text) in [
            (0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (5_494_505.494_505, "5.49451e6"),
            (-1.25e-5, "-1.25e-5"),
            (123_456.7, "123457"),
            (999_999.6, "1e6"),
        ] {
            assert_eq!(significant(number, 6), text);
        }
    }

    #[test]
    fn round_off_is_not_shown() {
        for (number, text) in [
            (0.199_999_999_999_999_98, "0.2"),
            (0.1 + 0.2, "0.3"),
            (0.0, "0"),
            (1.234_567_890_125e-7, "0.000000123456789013"),
            (86_400.0, "86400"),
        ] {
            assert_eq!(rounded(number, 12).to_string(), text);
        }
    }

    proptest! {
        #[test]
        fn bytes_say_what_they_stand_for(number in 1.0..1e20_f64) {
            let text = bytes(number);
            let (value, unit) = text.split_once(' ').unwrap();
            let power = ["B", "kB", "MB", "GB", "TB", "PB", "EB"].iter().position(|u| *u == unit).unwrap();
            let value: f64 = value.parse::<f64>().unwrap() * 1000_f64.powi(power as i32);
            // One decimal of a value of at least 1: half of 0.1; below 1000 B half a byte of a value of at least 1.
            prop_assert!((value - number).abs() <= 0.5 * number / if power == 0 { 1.0 } else { 10.0 } , "{number}: {text}");
        }

        #[test]
        fn significant_digits_are_at_most_as_many_as_requested(number in proptest::num::f64::NORMAL, digits in 1..=17_usize) {
            let text = significant(number, digits);
            let value: f64 = text.parse().unwrap();
            // Half a unit of the last digit of the leading power of ten.
            let unit = 10_f64.powf(number.abs().log10().floor() + 1.0 - digits as f64);
            // The decimal is read back to the nearest double.
            let allowed = 0.5000001 * unit + f64::EPSILON * number.abs();
            prop_assert!((value - number).abs() <= allowed || number.abs() > 1e308, "{number}: {text}");
        }
    }
}
