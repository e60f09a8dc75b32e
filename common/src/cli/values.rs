//! Values of options.

/// A number above 0, for `value_parser`; with `allow_negative_numbers`, so that -1 is told why it is refused.
///
/// # Errors
/// What is wrong with the text.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        Ok(value) if value <= 0.0 => Err("must be above 0".to_owned()),
        _ => Err("expected a number above 0".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::positive;

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
