//! Values of options.

use std::time::Duration;

use crate::units::{Dimension, Quantity};

/// A number above 0, for `value_parser`. Use it with `allow_negative_numbers`, so that the message for -1 gives the reason.
///
/// # Errors
/// The text is not a finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        Ok(value) if value <= 0.0 => Err("must be above 0".to_owned()),
        _ => Err("expected a number above 0".to_owned()),
    }
}

/// A quantity above 0 in SI units, a number alone or one with a unit such as `0.2 mm`, for `value_parser`.
///
/// ```
/// use mercury_common::cli::quantity;
/// use mercury_common::units::Dimension;
///
/// let length = quantity(Dimension::LENGTH);
/// assert_eq!(length("0.25 mm"), Ok(2.5e-4));
/// assert_eq!(length("2.5e-4"), Ok(2.5e-4));
/// assert_eq!(
///     length("2 kg").unwrap_err(),
///     "is a mass, expected a length (m, cm, mm, um, nm, km), or a number in m"
/// );
/// ```
pub fn quantity(wanted: Dimension) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    move |text: &str| {
        let text = text.trim();
        if text.parse::<f64>().is_ok() || !Quantity::is_begun_by(text) {
            return positive(text);
        }
        let value = Quantity::parse(text)?.value(wanted).map_err(|what| {
            let (words, units, symbol) = (wanted.words(), wanted.units(), wanted.symbol());
            format!("is {what}, expected {words} ({units}), or a number in {symbol}")
        })?;
        match value > 0.0 && value.is_finite() {
            true => Ok(value),
            false => Err("must be above 0".to_owned()),
        }
    }
}

/// A time by the clock, for `value_parser`: `90s`, `10m`, `1h30m`, `2d`; a number alone is seconds.
///
/// # Errors
/// The text is not a time such as `90s` or `1h30m`.
pub fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || "expected a time like 90s, 10m, 1h30m or 2d".to_owned();
    let mut seconds = 0.0;
    let mut rest = text.trim();
    while !rest.is_empty() {
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.');
        let (number, behind) = rest.split_at(end.unwrap_or(rest.len()));
        let number: f64 = number.parse().map_err(|_| wrong())?;
        let unit = behind.chars().next();
        seconds += number
            * match unit {
                Some('s') => 1.0,
                Some('m') => 60.0,
                Some('h') => 3600.0,
                Some('d') => 86400.0,
                // Alone, not behind hours.
                None if seconds == 0.0 => 1.0,
                _ => return Err(wrong()),
            };
        rest = behind.get(1..).unwrap_or_default();
    }
    let time = Duration::try_from_secs_f64(seconds).map_err(|_| "is too long".to_owned())?;
    if time.is_zero() {
        return Err("must be above 0".to_owned());
    }
    Ok(time)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::{duration, positive};

    #[test]
    fn times_are_sums_of_their_parts() {
        for (text, seconds) in [
            ("90s", 90.0),
            ("90", 90.0),
            ("10m", 600.0),
            ("1h30m", 5400.0),
            ("1.5h", 5400.0),
            ("2d", 172_800.0),
            ("0.25s", 0.25),
        ] {
            assert_eq!(
                duration(text),
                Ok(Duration::from_secs_f64(seconds)),
                "{text}"
            );
        }
        let wrong = Err("expected a time like 90s, 10m, 1h30m or 2d".to_owned());
        for text in ["ten", "10x", "m", "1h30", "-5s", "1..5s", "10 m", "5é"] {
            assert_eq!(duration(text), wrong, "{text}");
        }
        for text in ["", "0", "0s", "0h0m"] {
            assert_eq!(duration(text), Err("must be above 0".to_owned()), "{text}");
        }
        assert!(duration("99999999999999999999d").is_err());
    }

    #[test]
    fn only_numbers_above_0_are_taken() {
        assert_eq!(positive("2.5e-3"), Ok(2.5e-3));
        for text in ["0", "-1", "-inf"] {
            assert_eq!(positive(text), Err("must be above 0".to_owned()), "{text}");
        }
        for text in ["", "one", "1,5", "inf", "nan"] {
            assert_eq!(
                positive(text),
                Err("expected a number above 0".to_owned()),
                "{text}"
            );
        }
    }
}
