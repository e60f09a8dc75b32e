//! Lanes as a plain array: correct on every processor, and as fast as the compiler makes it.

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
                Self(from_fn(|k| self.0[k].$name(other)))
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
        Self(from_fn(|k| -self.0[k]))
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
        Self(from_fn(|k| self.0[k].sqrt()))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(from_fn(|k| self.0[k].abs()))
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

    #[inline(always)]
    fn bits(self) -> u32 {
        let mut bits = 0;
        for (k, set) in self.0.iter().enumerate() {
            bits |= u32::from(*set) << k;
        }
        bits
    }
}

impl<const N: usize> Not for LaneMask<N> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(from_fn(|k| !self.0[k]))
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
