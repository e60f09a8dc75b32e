//! Numbers in lanes: one source for laws that act on one contact, or on several side by side.
//!
//! A law is written once, over a [`Real`]. As an `f64` it is a plain number and a [`Mask`] a `bool`: `any` and `all` are then
//! the condition itself, and the compiler leaves the branches that a law for single contacts would have. As [`Lanes`] it is
//! several numbers, and each lane gets the very bits that it would get alone.
//!
//! How to write a rare case, so that it costs nothing where it does not occur and is right if only some lanes are in it:
//!
//! ```
//! use mercury_engine::lanes::{Lanes, Mask, Real};
//!
//! /// sqrt(x), and 0 below zero.
//! fn root<L: Real>(x: L) -> L {
//!     let below = x.below(L::ZERO);
//!     if below.all() {
//!         return L::ZERO; // no lane needs the root
//!     }
//!     let root = x.sqrt();
//!     if below.any() { L::select(below, L::ZERO, root) } else { root }
//! }
//! assert_eq!(root(4.0), 2.0);
//! assert_eq!(root(-4.0), 0.0);
//! assert_eq!(root(Lanes([4.0, -4.0])), Lanes([2.0, 0.0]));
//! ```
//!
//! Rules that make the bits independent of the number of lanes: operations of IEEE 754 alone (+, -, *, /, root, comparisons), no
//! fused multiply-add, and never a sum across lanes.
//!
//! How many lanes there are is chosen when the program runs, by what the processor has ([`Width`]); a [`Task`] is the code that is
//! compiled once for each.

mod array;
mod quad;
#[cfg(any(target_arch = "aarch64", target_arch = "x86_64"))]
mod registers;
#[cfg(test)]
mod tests;
mod vector;
mod width;

pub use array::{LaneMask, Lanes};
pub use quad::Quad;
pub use vector::Vector;
pub use width::{Task, Width};

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// A number, or several side by side.
pub trait Real:
    Copy
    + Default
    + PartialEq
    + Debug
    + Send
    + Sync
    + 'static
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// Result of a comparison.
    type Mask: Mask;
    /// How many numbers it holds.
    const LANES: usize;
    /// 0 in every lane.
    const ZERO: Self;
    /// 1 in every lane.
    const ONE: Self;

    /// One number in every lane.
    #[must_use]
    fn splat(number: f64) -> Self;
    /// The number in lane `k` < [`Real::LANES`].
    #[must_use]
    fn lane(self, k: usize) -> f64;
    /// `number(k)` in lane `k`.
    #[must_use]
    fn from_lanes(number: impl FnMut(usize) -> f64) -> Self;

    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;
    /// `other` where it is smaller, else `self`: also where one of them is no number, or both are zeros.
    #[must_use]
    fn min(self, other: Self) -> Self;
    /// `other` where it is larger, else `self`: also where one of them is no number, or both are zeros.
    #[must_use]
    fn max(self, other: Self) -> Self;

    /// Where self < other.
    #[must_use]
    fn below(self, other: Self) -> Self::Mask;
    /// Where self <= other.
    #[must_use]
    fn at_most(self, other: Self) -> Self::Mask;
    /// Where self == other.
    #[must_use]
    fn equals(self, other: Self) -> Self::Mask;
    /// `then` where the mask is set, `otherwise` elsewhere.
    #[must_use]
    fn select(mask: Self::Mask, then: Self, otherwise: Self) -> Self;

    /// The first [`Real::LANES`] of some numbers.
    ///
    /// # Panics
    /// If there are fewer.
    #[inline(always)]
    #[must_use]
    fn load(numbers: &[f64]) -> Self {
        Self::from_lanes(|k| numbers[k])
    }

    /// Writes lane `k` to `numbers[k]`.
    ///
    /// # Panics
    /// If there are fewer than [`Real::LANES`].
    #[inline(always)]
    fn store(self, numbers: &mut [f64]) {
        for (k, number) in numbers[..Self::LANES].iter_mut().enumerate() {
            *number = self.lane(k);
        }
    }

    /// The lanes whose bits are set, moved to the front; the content of the others is not specified.
    #[inline(always)]
    #[must_use]
    fn packed(self, bits: u32) -> Self {
        let mut front = [0; MOST_LANES];
        let mut count = 0;
        for k in 0..Self::LANES {
            front[count] = k;
            count += (bits >> k & 1) as usize;
        }
        Self::from_lanes(|k| self.lane(front[k]))
    }

    /// Lane `k` of each: the difference of the first three numbers of `a(k)` and `b(k)`, and the sum of the fourth ones.
    #[inline(always)]
    #[must_use]
    fn differences<'a>(a: impl Fn(usize) -> &'a Quad, b: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
        let [ax, ay, az, aw] = Self::columns(a);
        let [bx, by, bz, bw] = Self::columns(b);
        [ax - bx, ay - by, az - bz, aw + bw]
    }

    /// Lane `k`: the numbers of `quad(k)`.
    #[inline(always)]
    #[must_use]
    fn columns<'a>(quad: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
        [
            Self::from_lanes(|k| quad(k).0[0]),
            Self::from_lanes(|k| quad(k).0[1]),
            Self::from_lanes(|k| quad(k).0[2]),
            Self::from_lanes(|k| quad(k).0[3]),
        ]
    }

    /// Lane `k`: the first three numbers of `quad(k)`.
    #[inline(always)]
    #[must_use]
    fn vectors<'a>(quad: impl Fn(usize) -> &'a Quad) -> Vector<Self> {
        let [x, y, z, _] = Self::columns(quad);
        Vector::new(x, y, z)
    }

    /// The reverse: lane `k` of a vector, and of the number that follows it, as number `k`; what follows behind [`Real::LANES`]
    /// is not specified.
    #[inline(always)]
    #[must_use]
    fn rows(vector: Vector<Self>, behind: Self) -> [Quad; MOST_LANES] {
        let mut rows = [Quad::default(); MOST_LANES];
        let [x, y, z] = vector.to_array();
        for (k, row) in rows[..Self::LANES].iter_mut().enumerate() {
            // `map` over the array is not always inlined.
            *row = Quad([x.lane(k), y.lane(k), z.lane(k), behind.lane(k)]);
        }
        rows
    }
}

/// No [`Real`] has more lanes.
pub const MOST_LANES: usize = 4;

/// Yes or no for each lane.
pub trait Mask:
    Copy + Debug + Not<Output = Self> + BitAnd<Output = Self> + BitOr<Output = Self>
{
    /// Whether it is set for any lane.
    #[must_use]
    fn any(self) -> bool;
    /// Whether it is set for all lanes.
    #[must_use]
    fn all(self) -> bool;
    /// Bit `k` is that of lane `k`.
    #[must_use]
    fn bits(self) -> u32;
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }

    #[inline(always)]
    fn all(self) -> bool {
        self
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}

impl Real for f64 {
    type Mask = bool;
    const LANES: usize = 1;
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline(always)]
    fn splat(number: f64) -> Self {
        number
    }

    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn from_lanes(mut number: impl FnMut(usize) -> f64) -> Self {
        number(0)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    // Not `f64::min` and `f64::max`, which do not specify which of two zeros they return.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    #[inline(always)]
    fn below(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn equals(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn select(mask: bool, then: Self, otherwise: Self) -> Self {
        if mask { then } else { otherwise }
    }
}
