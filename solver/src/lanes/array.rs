//! Lanes as a plain array: right on every processor, as fast as the compiler makes it.

use std::array::from_fn;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::{Mask, Real};

/// `N` numbers side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lanes<const N: usize>(pub [f64; N]);

/// Yes or no for each of `N` lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LaneMask<const N: usize>(pub [bool; N]);

impl<const N: usize> Default for Lanes<N> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    fn compare(self, other: Self, holds: impl Fn(f64, f64) -> bool) -> LaneMask<N> {
        LaneMask(from_fn(|k| holds(self.0[k], other.0[k])))
    }
}

/// One of the four operations, between lanes and with one number for all lanes.
macro_rules! operation {
    ($operation:ident, $name:ident) => {
        impl<const N: usize> $operation for Lanes<N> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(from_fn(|k| self.0[k].$name(other.0[k])))
            }
        }

        impl<const N: usize> $operation<f64> for Lanes<N> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                Self(self.0.map(|number| number.$name(other)))
            }
        }
    };
}
operation!(Add, add);
operation!(Sub, sub);
operation!(Mul, mul);
operation!(Div, div);

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(f64::neg))
    }
}

impl<const N: usize> Real for Lanes<N> {
    type Mask = LaneMask<N>;
    const LANES: usize = N;
    const ZERO: Self = Self([0.0; N]);
    const ONE: Self = Self([1.0; N]);

    #[inline(always)]
    fn splat(number: f64) -> Self {
        Self([number; N])
    }

    #[inline(always)]
    fn lane(self, k: usize) -> f64 {
        self.0[k]
    }

    #[inline(always)]
    fn from_lanes(number: impl FnMut(usize) -> f64) -> Self {
        Self(from_fn(number))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.below(self), other, self)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.below(other), other, self)
    }

    #[inline(always)]
    fn below(self, other: Self) -> LaneMask<N> {
        self.compare(other, |a, b| a < b)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> LaneMask<N> {
        self.compare(other, |a, b| a <= b)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> LaneMask<N> {
        self.compare(other, |a, b| a == b)
    }

    #[inline(always)]
    fn select(mask: LaneMask<N>, then: Self, otherwise: Self) -> Self {
        let chosen = |k| {
            if mask.0[k] { then.0[k] } else { otherwise.0[k] }
        };
        Self(from_fn(chosen))
    }
}

impl<const N: usize> Mask for LaneMask<N> {
    #[inline(always)]
    fn any(self) -> bool {
        self.0.contains(&true)
    }

    #[inline(always)]
    fn all(self) -> bool {
        !self.0.contains(&false)
    }
}

impl<const N: usize> Not for LaneMask<N> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(bool::not))
    }
}

impl<const N: usize> BitAnd for LaneMask<N> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] & other.0[k]))
    }
}

impl<const N: usize> BitOr for LaneMask<N> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] | other.0[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of every kind: both zeros, the smallest, the infinities, no number.
    const KINDS: [f64; 12] = [
        0.0,
        -0.0,
        1.0,
        -1.5,
        3.0e-310,
        -3.0e-310,
        1e300,
        -1e300,
        f64::MIN_POSITIVE,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ];

    /// Bits that may be compared: which of the many "no number" it is, nobody promises.
    fn bits(number: f64) -> u64 {
        if number.is_nan() {
            u64::MAX
        } else {
            number.to_bits()
        }
    }

    /// Every operation on every pair of kinds gives in each lane the bits that it gives alone.
    #[test]
    fn every_lane_gets_the_bits_of_a_number_alone() {
        for a in KINDS {
            for b in KINDS {
                let (x, y) = (Lanes([a, 2.0, b, 0.5]), Lanes([b, 4.0, a, -2.0]));
                let (one, two) = ([a, 2.0, b, 0.5], [b, 4.0, a, -2.0]);
                let check = |lanes: Lanes<4>, alone: fn(f64, f64) -> f64| {
                    for k in 0..4 {
                        assert_eq!(bits(lanes.lane(k)), bits(alone(one[k], two[k])));
                    }
                };
                check(x + y, |a, b| a + b);
                check(x - y, |a, b| a - b);
                check(x * y, |a, b| a * b);
                check(x / y, |a, b| a / b);
                check(-x, |a, _| -a);
                check(x + 2.5, |a, _| a + 2.5);
                check(x - 2.5, |a, _| a - 2.5);
                check(x * 2.5, |a, _| a * 2.5);
                check(x / 2.5, |a, _| a / 2.5);
                check(x.sqrt(), |a, _| Real::sqrt(a));
                check(x.abs(), |a, _| Real::abs(a));
                check(x.min(y), Real::min);
                check(x.max(y), Real::max);
                let masks = [x.below(y), x.at_most(y), x.equals(y), !x.below(y)];
                let alone: [fn(f64, f64) -> bool; 4] = [
                    |a, b| a < b,
                    |a, b| a <= b,
                    |a, b| a == b,
                    |a, b| !a.below(b),
                ];
                for (mask, alone) in masks.into_iter().zip(alone) {
                    assert_eq!(mask.0, from_fn(|k| alone(one[k], two[k])));
                    let chosen = Lanes::select(mask, x, y);
                    let expected: [f64; 4] = from_fn(|k| f64::select(mask.0[k], one[k], two[k]));
                    assert_eq!(chosen.0.map(bits), expected.map(bits));
                }
            }
        }
    }

    #[test]
    fn masks_know_any_and_all() {
        let mask = |bits| LaneMask::<2>(bits);
        let (none, one, all) = (
            mask([false, false]),
            mask([true, false]),
            mask([true, true]),
        );
        assert!(!none.any() && one.any() && all.any());
        assert!(!none.all() && !one.all() && all.all());
        assert_eq!(one & all, one);
        assert_eq!(one | none, one);
        assert_eq!(!one, mask([false, true]));
    }
}
