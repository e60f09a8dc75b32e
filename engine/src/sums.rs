//! Sums of floating-point numbers that do not depend on their order.
//!
//! Sums that decide how a run goes on have to be the same bits wherever they are made, in any order and in any parts.
//! [`Exact`] keeps such a sum without round-off, as a whole number of units of the smallest positive number: a superaccumulator
//! (Kulisch & Miranker 1986, SIAM Review 28, 1; digits of 32 bits in words of 64, with carries left for later, as in
//! Neal 2015, arXiv:1505.05571). It is rounded once, at the end.
//!
//! Adding takes some 10 ns, so what is added exactly are the sums of blocks, not single contacts.

/// Bits of a digit.
const DIGIT: usize = 32;
/// The units of the largest number have 2,098 bits, 66 digits; two more hold what 2^31 addends carry over.
const DIGITS: usize = 68;
/// Binary exponent of the unit: that of the smallest positive number.
const UNIT: i32 = -1074;
/// Bits of the fraction of a number.
const FRACTION: u32 = f64::MANTISSA_DIGITS - 1;
/// The biased exponent of infinities and of what is not a number.
const SPECIAL: usize = 0x7ff;

/// An exact sum of up to 2^31 numbers.
///
/// ```
/// use mercury_engine::sums::Exact;
///
/// let mut sum = Exact::default();
/// [1e300, 1.0, -1e300].iter().for_each(|&number| sum.add(number));
/// assert_eq!(sum.value(), 1.0);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exact {
    /// Digits in ascending order, each with a sign of its own.
    digits: [i64; DIGITS],
    /// Addends that are +infinity, -infinity, and not a number.
    specials: [u64; 3],
}

impl Default for Exact {
    fn default() -> Self {
        Self {
            digits: [0; DIGITS],
            specials: [0; 3],
        }
    }
}

impl Exact {
    /// Adds a number.
    pub fn add(&mut self, number: f64) {
        let bits = number.to_bits();
        let exponent = (bits >> FRACTION) as usize & SPECIAL;
        let fraction = bits & ((1 << FRACTION) - 1);
        if exponent == SPECIAL {
            let kind = if fraction > 0 {
                2
            } else {
                usize::from(number < 0.0)
            };
            self.specials[kind] += 1;
            return;
        }
        // Numbers without a leading one have the unit of the smallest with one.
        let (units, place) = match exponent {
            0 => (fraction, 0),
            _ => (fraction | 1 << FRACTION, exponent - 1),
        };
        let sign = if number.is_sign_negative() { -1 } else { 1 };
        let mut units = u128::from(units) << (place % DIGIT);
        for digit in &mut self.digits[place / DIGIT..][..3] {
            *digit += sign * i64::from(units as u32);
            units >>= DIGIT;
        }
    }

    /// The words of the sum: those of several sums, added one by one, are the words of their sum.
    #[must_use]
    pub fn words(&self) -> [i64; WORDS] {
        let specials = self.specials.map(|count| count as i64);
        let mut words = [0; WORDS];
        words[..DIGITS].copy_from_slice(&self.digits);
        words[DIGITS..].copy_from_slice(&specials);
        words
    }

    /// The sum with these words.
    #[must_use]
    pub fn of_words(words: &[i64; WORDS]) -> Self {
        let specials = [0, 1, 2].map(|kind| words[DIGITS + kind] as u64);
        let mut digits = [0; DIGITS];
        digits.copy_from_slice(&words[..DIGITS]);
        Self { digits, specials }
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: &Self) {
        for (own, more) in self.digits.iter_mut().zip(&other.digits) {
            *own += more;
        }
        for (own, more) in self.specials.iter_mut().zip(&other.specials) {
            *own += more;
        }
    }

    /// The sum, rounded to the nearest number, to the even one of two that are as near; 0 if it is zero.
    #[must_use]
    pub fn value(&self) -> f64 {
        match self.specials.map(|count| count > 0) {
            [false, false, false] => (),
            [true, false, false] => return f64::INFINITY,
            [false, true, false] => return f64::NEG_INFINITY,
            _ => return f64::NAN,
        }
        let (digits, carry) = self.carried(1);
        if carry < 0 {
            -magnitude(&self.carried(-1).0)
        } else {
            magnitude(&digits)
        }
    }

    /// The digits of the sum times `sign`, none of them negative; the carry is -1 if the product is negative.
    fn carried(&self, sign: i64) -> ([u32; DIGITS], i64) {
        let mut carry = 0;
        let digits = self.digits.map(|digit| {
            let sum = sign * digit + carry;
            carry = sum >> DIGIT;
            sum as u32
        });
        (digits, carry)
    }
}

/// The number nearest to so many units.
fn magnitude(digits: &[u32; DIGITS]) -> f64 {
    let Some(highest) = digits.iter().rposition(|&digit| digit > 0) else {
        return 0.0;
    };
    // The three highest digits have at least 65 bits, if there are three. What lies below them can only decide between two
    // numbers that seem equally near: one bit stands for it.
    let lowest = highest.saturating_sub(2);
    let head = digits[lowest..=highest].iter().rev();
    let head = head.fold(0u128, |head, &digit| head << DIGIT | u128::from(digit));
    let has_rest = digits[..lowest].iter().any(|&digit| digit > 0);
    let rounded = (head | u128::from(has_rest)) as f64;
    // Exact, or beyond the largest number.
    libm::scalbn(rounded, (lowest * DIGIT) as i32 + UNIT)
}

/// Words of a sum, by which sums of several processes are added.
pub const WORDS: usize = DIGITS + 3;

/// The exact sums over blocks, place by place, each rounded once.
#[must_use]
pub fn exact_sums<const N: usize>(blocks: impl IntoIterator<Item = [f64; N]>) -> [f64; N] {
    exact(blocks).map(|sum| sum.value())
}

/// The exact sums over blocks, place by place, not rounded yet.
#[must_use]
pub fn exact<const N: usize>(blocks: impl IntoIterator<Item = [f64; N]>) -> [Exact; N] {
    let mut sums: [Exact; N] = std::array::from_fn(|_| Exact::default());
    for block in blocks {
        for (sum, number) in sums.iter_mut().zip(block) {
            sum.add(number);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use xsum::{Xsum, XsumLarge};

    use super::*;

    fn sum(numbers: &[f64]) -> Exact {
        let mut sum = Exact::default();
        numbers.iter().for_each(|&number| sum.add(number));
        sum
    }

    /// Numbers of all magnitudes, of about one magnitude, and of few digits, so that sums cancel and lie between two numbers.
    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![
            prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
            -1.0..1.0f64,
            (-9i32..10, -60i32..60).prop_map(|(digit, power)| libm::scalbn(digit.into(), power)),
            (-9i32..10).prop_map(|units| f64::from(units) * f64::from_bits(1)),
        ]
    }

    proptest! {
        /// Any order and any parts give the same bits, those of another program.
        #[test]
        fn order_and_parts_change_nothing(
            numbers in prop::collection::vec(number(), 0..40),
            turned in any::<prop::sample::Index>(),
            part in 1usize..8,
        ) {
            let whole = sum(&numbers);
            let mut others = numbers.clone();
            if !others.is_empty() {
                let first = turned.index(others.len());
                others.rotate_left(first);
                others[first / 2..].reverse();
            }
            let mut merged = Exact::default();
            others.chunks(part).map(sum).for_each(|part| merged.merge(&part));
            prop_assert_eq!(merged.value().to_bits(), whole.value().to_bits());
            // That one (0.1.6) rounds negative sums wrongly, even of one number: both get the opposite numbers then.
            let sign = if whole.value() < 0.0 { -1.0 } else { 1.0 };
            let numbers: Vec<f64> = numbers.iter().map(|number| sign * number).collect();
            let mut theirs = XsumLarge::new();
            theirs.add_list(&numbers);
            prop_assert_eq!(sum(&numbers).value(), theirs.sum());
            prop_assert_eq!(sum(&numbers).value(), sign * whole.value());
        }

        /// Of two numbers the exact sum is the plain one, so scenes of two blocks keep their bits.
        #[test]
        fn two_addends_give_the_plain_sum(a in number(), b in number()) {
            prop_assert_eq!(sum(&[a, b]).value(), a + b);
        }

        /// Adding and taking away again leaves nothing, however many numbers.
        #[test]
        fn opposite_numbers_cancel(numbers in prop::collection::vec(number(), 0..40)) {
            let back = numbers.iter().rev().map(|number| -number);
            let all: Vec<f64> = numbers.iter().copied().chain(back).collect();
            prop_assert_eq!(sum(&all).value().to_bits(), 0);
        }
    }

    #[test]
    fn halves_go_to_the_even_number() {
        let half = 0.5 * f64::EPSILON;
        let tiny = f64::from_bits(1);
        for (numbers, expected) in [
            (vec![1.0, half], 1.0),
            (vec![1.0, half, tiny], 1.0 + f64::EPSILON),
            (vec![1.0, half, -tiny], 1.0),
            (vec![1.0, f64::EPSILON, half], 1.0 + 2.0 * f64::EPSILON),
            (vec![-1.0, -half, -tiny], -1.0 - f64::EPSILON),
            (vec![f64::MAX, f64::MAX, -f64::MAX], f64::MAX),
            (vec![f64::MAX, f64::MAX], f64::INFINITY),
            (vec![f64::MIN_POSITIVE, -tiny], f64::MIN_POSITIVE - tiny),
            (vec![], 0.0),
        ] {
            assert_eq!(sum(&numbers).value(), expected, "{numbers:?}");
        }
    }

    /// As plain sums do, whatever their order.
    #[test]
    fn infinities_and_missing_numbers_show() {
        let (plus, minus) = (f64::INFINITY, f64::NEG_INFINITY);
        assert_eq!(sum(&[1.0, plus, plus, f64::MIN]).value(), plus);
        assert_eq!(sum(&[minus, 1.0]).value(), minus);
        assert!(sum(&[minus, 1.0, plus]).value().is_nan());
        assert!(sum(&[f64::NAN, 1.0]).value().is_nan());
        let mut merged = sum(&[plus]);
        merged.merge(&sum(&[minus]));
        assert!(merged.value().is_nan());
    }

    #[test]
    fn many_equal_addends_carry_over() {
        let largest = [f64::MAX; 1000];
        let mut all = sum(&largest);
        all.merge(&sum(&largest.map(|number| -number)));
        all.add(3.0);
        assert_eq!(all.value(), 3.0);
        let thirds = vec![1.0 / 3.0; 1 << 20];
        assert_eq!(sum(&thirds).value(), f64::from(1 << 20) / 3.0);
    }

    #[test]
    fn sums_of_blocks_are_made_place_by_place() {
        let blocks = [[1e300, 1.0], [2.0, 1e-300], [-1e300, -1.0]];
        assert_eq!(exact_sums(blocks), [2.0, 1e-300]);
        assert_eq!(exact_sums::<3>([]), [0.0; 3]);
    }
}
