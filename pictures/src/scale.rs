//! Numbers for people: SI prefixes, round ticks, short decimals.

/// A unit with its prefix, and what a value in the plain unit is divided by to be read in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unit {
    /// Value in the plain SI unit of one of this unit.
    pub(crate) size: f64,
    /// Name as printed: `mJ`, `µm`, `10⁻³³ J`.
    pub(crate) name: String,
}

/// The prefixes of the SI in steps of a thousand, from 10⁻³⁰ to 10³⁰ (BIPM, SI Brochure, 9th edition, table 7).
const PREFIXES: [&str; 21] = [
    "q", "r", "y", "z", "a", "f", "p", "n", "µ", "m", "", "k", "M", "G", "T", "P", "E", "Z", "Y",
    "R", "Q",
];

impl Unit {
    /// The unit in which the magnitude `largest` reads as a number from 1 to below 1000.
    pub(crate) fn for_magnitude(largest: f64, plain: &str) -> Self {
        // 3 * floor(e / 3): 0.5 becomes 500 m, 1500 becomes 1.5 k.
        let exponent = decimal_exponent(largest).unwrap_or(0).div_euclid(3) * 3;
        let prefix = usize::try_from(exponent / 3 + 10)
            .ok()
            .and_then(|place| PREFIXES.get(place));
        match prefix {
            Some(prefix) => Self {
                size: power_of_ten(exponent),
                name: format!("{prefix}{plain}"),
            },
            None => Self::power(exponent, plain),
        }
    }

    /// Like [`Unit::for_magnitude`] without kilo and beyond, because kiloseconds are not in use: the plain unit up to 10⁶, then
    /// powers of ten.
    pub(crate) fn not_above_plain(largest: f64, plain: &str) -> Self {
        match decimal_exponent(largest).unwrap_or(0) {
            0..6 => Self {
                size: 1.0,
                name: plain.into(),
            },
            exponent @ 6.. => Self::power(exponent.div_euclid(3) * 3, plain),
            _ => Self::for_magnitude(largest, plain),
        }
    }

    fn power(exponent: i32, plain: &str) -> Self {
        Self {
            size: power_of_ten(exponent),
            name: format!("10{} {plain}", superscript(exponent)),
        }
    }
}

/// `floor(log10(|value|))`, exact at powers of ten; `None` for zero and what is not finite.
pub(crate) fn decimal_exponent(value: f64) -> Option<i32> {
    if value == 0.0 || !value.is_finite() {
        return None;
    }
    // The shortest exact decimal carries the exponent; log10 would round 999.999… up.
    format!("{:e}", value.abs()).split_once('e')?.1.parse().ok()
}

/// 10^exponent as the nearest f64, where `powi` would lose it near the ends of the range.
pub(crate) fn power_of_ten(exponent: i32) -> f64 {
    format!("1e{exponent}")
        .parse()
        .unwrap_or(f64::MAX)
        .clamp(f64::MIN_POSITIVE, f64::MAX)
}

/// `10⁻³` is `"10"` and this.
pub(crate) fn superscript(number: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    number
        .to_string()
        .chars()
        .map(|c| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]))
        .collect()
}

/// The largest of 1, 2, 5 times a power of ten that is not above `value` (which is positive and finite).
pub(crate) fn round_down(value: f64) -> f64 {
    let power = power_of_ten(decimal_exponent(value).unwrap_or(0));
    let step = [5.0, 2.0]
        .into_iter()
        .find(|step| step * power <= value)
        .unwrap_or(1.0);
    step * power
}

/// Round places on an axis, and the decimals that tell them apart.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ticks {
    /// Positions, ascending, inside the requested range.
    pub(crate) at: Vec<f64>,
    decimals: usize,
}

impl Ticks {
    /// At most about `count` ticks in `low..=high`. An empty or not finite range has one tick, at `low`.
    pub(crate) fn new(low: f64, high: f64, count: usize) -> Self {
        let span = high - low;
        // Below this share of the values neighbouring ticks would be the same number.
        if !span.is_finite() || span <= 1e-12 * low.abs().max(high.abs()) || count == 0 {
            let decimals = decimal_exponent(low).map_or(0, |e| (2 - e).clamp(0, 12) as usize);
            return Self {
                at: vec![low],
                decimals,
            };
        }
        let raw = span / count as f64;
        let below = round_down(raw);
        // Round *up* to 1, 2, 5 so that there are never more than requested.
        let power = power_of_ten(decimal_exponent(below).unwrap_or(0));
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|step| step * power)
            .find(|step| *step >= raw * (1.0 - 1e-9))
            .unwrap_or(10.0 * power);
        let slack = 1e-9 * span;
        let ends = |step: f64| {
            (
                ((low - slack) / step).ceil(),
                ((high + slack) / step).floor(),
            )
        };
        // One tick is no scale: some more ticks than requested are better.
        let step = if ends(step).1 - ends(step).0 < 1.0 {
            below
        } else {
            step
        };
        let (first, last) = ends(step);
        let number = (last - first).clamp(0.0, 4.0 * count as f64) as usize;
        let at = (0..=number).map(|i| (first + i as f64) * step).collect();
        let decimals =
            decimal_exponent(step * (1.0 + 1e-9)).map_or(0, |e| (-e).clamp(0, 15) as usize);
        Self { at, decimals }
    }

    /// The label of a tick.
    pub(crate) fn label(&self, value: f64) -> String {
        let text = format!("{:.*}", self.decimals, value);
        let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
        // A rounded −0 reads as a fault.
        let text = if is_zero { text.replace('-', "") } else { text };
        typeset(&text)
    }
}

/// A number to `digits` significant digits, without trailing zeros: `12.5`, `0.003`, `1.2×10⁹`.
pub(crate) fn short_number(value: f64, digits: usize) -> String {
    let Some(exponent) = decimal_exponent(value) else {
        return if value == 0.0 {
            "0".into()
        } else {
            value.to_string()
        };
    };
    let digits = digits.max(1) as i32;
    if !(-4..6).contains(&exponent) {
        let text = format!("{:.*e}", digits as usize - 1, value);
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let exponent = superscript(exponent.parse().unwrap_or(0));
        return format!("{}×10{exponent}", typeset(without_trailing_zeros(mantissa)));
    }
    let decimals = (digits - 1 - exponent).max(0) as usize;
    typeset(without_trailing_zeros(&format!("{value:.decimals$}")))
}

/// A value with its unit and a fitting prefix, to `digits` significant digits: `12.5 mm/s`.
pub(crate) fn quantity(value: f64, plain: &str, digits: usize) -> String {
    if decimal_exponent(value).is_some_and(|exponent| exponent >= 0) {
        return format!("{} {plain}", short_number(value, digits));
    }
    let unit = Unit::not_above_plain(value, plain);
    format!("{} {}", short_number(value / unit.size, digits), unit.name)
}

/// A count with its thousands apart, from five digits on.
pub(crate) fn count(number: usize) -> String {
    let digits = number.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A round length in the unit people use for it: µm, mm, cm, m, km.
pub(crate) fn length_label(length: f64) -> String {
    // Centimetres from 1 cm to 50 cm; the SI's steps of a thousand elsewhere.
    if (0.00999..0.999).contains(&length) {
        return format!("{} cm", short_number(length * 100.0, 3));
    }
    let unit = Unit::for_magnitude(length * (1.0 + 1e-9), "m");
    format!("{} {}", short_number(length / unit.size, 3), unit.name)
}

fn without_trailing_zeros(text: &str) -> &str {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        text
    }
}

fn typeset(text: &str) -> String {
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn prefixes_and_what_lies_beyond() {
        for (value, name) in [
            (0.0, "J"),
            (1.0, "J"),
            (999.999_999_999, "J"),
            (1000.0, "kJ"),
            (0.5, "mJ"),
            (-2e-6, "µJ"),
            (3e-30, "qJ"),
            (3e-31, "10⁻³³ J"),
            (5e33, "10³³ J"),
            (f64::MAX, "10³⁰⁶ J"),
        ] {
            assert_eq!(Unit::for_magnitude(value, "J").name, name, "{value}");
        }
        for (value, name) in [(2e-3, "ms"), (5e4, "s"), (2e7, "10⁶ s")] {
            assert_eq!(Unit::not_above_plain(value, "s").name, name, "{value}");
        }
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!(short_number(12.5, 4), "12.5");
        assert_eq!(short_number(-0.003, 3), "−0.003");
        assert_eq!(short_number(1.2e9, 3), "1.2×10⁹");
        assert_eq!(short_number(100.0, 2), "100");
        assert_eq!(short_number(0.0, 2), "0");
        assert_eq!(quantity(0.0125, "s", 4), "12.5 ms");
        assert_eq!(quantity(2e7, "s", 4), "2×10⁷ s");
        assert_eq!(count(1234), "1234");
        assert_eq!(count(100_000), "100\u{202f}000");
        assert_eq!(round_down(0.9), 0.5);
        assert_eq!(round_down(2.0), 2.0);
    }

    #[test]
    fn ticks_are_round_and_told_apart() {
        let ticks = Ticks::new(0.0, 1.0, 5);
        let labels: Vec<String> = ticks.at.iter().map(|v| ticks.label(*v)).collect();
        assert_eq!(labels, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(Ticks::new(3.0, 3.0, 5).at, [3.0]);
        // 5000 would be the step for two ticks, but no multiple of it lies inside.
        assert_eq!(Ticks::new(203.0, 4958.0, 2).at, [2000.0, 4000.0]);
    }

    #[test]
    fn lengths_in_the_units_of_the_lab() {
        for (length, label) in [
            (5e-6, "5 µm"),
            (0.002, "2 mm"),
            (0.01, "1 cm"),
            (0.5, "50 cm"),
            (1.0, "1 m"),
            (2e4, "20 km"),
        ] {
            assert_eq!(length_label(length), label);
        }
    }

    proptest! {
        #[test]
        fn ticks_never_leave_the_range_nor_crowd(low in -1e3..1e3f64, span in 1e-3..1e4f64, n in 2usize..9) {
            let ticks = Ticks::new(low, low + span, n);
            prop_assert!(ticks.at.len() >= 2);
            prop_assert!(n < 5 || ticks.at.len() <= n + 1);
            let slack = 2e-9 * span;
            prop_assert!(ticks.at.iter().all(|t| *t >= low - slack && *t <= low + span + slack));
            let labels: std::collections::BTreeSet<String> = ticks.at.iter().map(|v| ticks.label(*v)).collect();
            prop_assert_eq!(labels.len(), ticks.at.len());
        }

        #[test]
        fn no_finite_number_panics(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            let _ = short_number(value, 3);
            let _ = Ticks::new(value, value + 1.0, 5);
            let unit = Unit::for_magnitude(value, "J");
            if value.is_normal() {
                let read = (value / unit.size).abs();
                prop_assert!((0.999..1000.001).contains(&read) || unit.size <= f64::MIN_POSITIVE, "{read} {unit:?}");
            }
        }
    }
}
