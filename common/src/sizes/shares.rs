//! Shares of which one may have been forgotten.

use crate::readable::rounded;
use crate::scene::{Psd, SizeLaw};

/// Shares that sum to the whole but for this part of it were rounded.
const ROUNDED: f64 = 0.01;
/// A sum that is so near to 100 is that of percentages: what is like 3 to 1 is written in small numbers.
const LIKE_PERCENTAGES: std::ops::RangeInclusive<f64> = 80.0..=120.0;

/// Warning of shares that are scaled to their sum: parts of 1, or percentages, that do not sum to the whole. Nothing of what is
/// like 3 to 1, which is meant as it is. `whose` is what has them.
#[must_use]
pub fn warning_of_shares(whose: &str, shares: &[f64]) -> Option<String> {
    let sum: f64 = shares.iter().sum();
    let whole = if shares.iter().all(|&share| share < 1.0) {
        1.0
    } else if LIKE_PERCENTAGES.contains(&sum) {
        100.0
    } else {
        return None;
    };
    if (sum / whole - 1.0).abs() <= ROUNDED {
        return None;
    }
    let scaled = shares.iter().map(|share| rounded(share / sum * whole, 6));
    let scaled: Vec<String> = scaled.map(|share| share.to_string()).collect();
    Some(format!(
        "the shares of {whose} sum to {}, not to {whole}; they are scaled to {}",
        rounded(sum, 6),
        scaled.join(", ")
    ))
}

impl Psd {
    /// [`warning_of_shares`] of the parts of a mixture, and of parts that are mixtures. Classes have amounts rather than shares: grams on
    /// sieves sum to anything, and only what is all below 1 is taken for parts of it.
    #[must_use]
    pub fn warning_of_shares(&self) -> Option<String> {
        match &self.law {
            SizeLaw::Mixture { of } => {
                let shares: Vec<f64> = of.iter().map(|part| part.share).collect();
                warning_of_shares("the mixture of distributions", &shares).or_else(|| {
                    of.iter()
                        .find_map(|part| part.psd.value.warning_of_shares())
                })
            }
            SizeLaw::Classes { shares, .. } if shares.iter().all(|&share| share < 1.0) => {
                warning_of_shares("the classes", shares)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse_psd;

    #[test]
    fn parts_of_the_whole_sum_to_it_and_ratios_to_anything() {
        let warning = |shares: &[f64]| warning_of_shares("it", shares);
        assert_eq!(
            warning(&[0.5, 0.4]).as_deref(),
            Some("the shares of it sum to 0.9, not to 1; they are scaled to 0.555556, 0.444444")
        );
        assert_eq!(
            warning(&[60.0, 30.0]).as_deref(),
            Some("the shares of it sum to 90, not to 100; they are scaled to 66.6667, 33.3333")
        );
        for meant in [
            &[3.0, 1.0][..],
            &[0.25, 0.75],
            &[0.333, 0.666],
            &[33.3, 66.6],
            &[70.0, 30.0],
            &[1.0],
            &[7.0, 2.0, 1.0],
            &[20.0, 1.0],
            &[250.0, 750.0],
        ] {
            assert_eq!(warning(meant), None, "{meant:?}");
        }
    }

    #[test]
    fn distributions_are_read_part_by_part() {
        let warning = |text: &str| {
            let text = format!("weighting = \"volume\"\n{text}");
            let psd = parse_psd("law.toml", &text, None).expect("a law");
            psd.value.warning_of_shares()
        };
        let bead =
            |share: f64| format!("{{ share = {share}, kind = \"monodisperse\", diameter = 1.0 }}");
        let two = |a: f64, b: f64| format!("kind = \"mixture\"\nof = [{}, {}]", bead(a), bead(b));
        assert!(warning(&two(60.0, 30.0)).is_some_and(|text| {
            text.starts_with("the shares of the mixture of distributions sum to 90, not to 100")
        }));
        assert!(warning(&two(0.6, 0.3)).is_some());
        assert_eq!(warning(&two(3.0, 1.0)), None);
        let inner = two(0.6, 0.3).replace('\n', ", ");
        let nested = format!("kind = \"mixture\"\nof = [{{ share = 1, {inner} }}]");
        assert!(warning(&nested).is_some());
        let classes = |shares: &str| {
            warning(&format!(
                "kind = \"classes\"\ndiameters = [1, 2, 3]\nshares = {shares}"
            ))
        };
        assert!(classes("[0.5, 0.4]").is_some());
        assert_eq!(classes("[0.5, 0.5]"), None);
        // Grams.
        assert_eq!(classes("[60, 30]"), None);
    }
}
