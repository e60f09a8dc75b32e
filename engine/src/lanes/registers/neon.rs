//! Two lanes: NEON.

use std::arch::aarch64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::{first, first_mut, instructions, register};
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Vector};

register! {
    /// Two numbers side by side.
    Two: float64x2_t of 2 [0, 1],
    [vaddq_f64, vsubq_f64, vmulq_f64, vdivq_f64, vsqrtq_f64, smaller, larger],
    [xor, andnot, vdupq_n_f64, |numbers| Two::from_array(numbers).0],
    TwoMask: uint64x2_t,
    [vcltq_f64, vcleq_f64, vceqq_f64, chosen],
    [inverted, vandq_u64, vorrq_u64, bits],
    {
        #[inline(always)]
        fn load(numbers: &[f64]) -> Self {
            let numbers: &[f64; 2] = first(numbers);
            Self(instructions!(vld1q_f64(numbers.as_ptr())))
        }

        #[inline(always)]
        fn store(self, numbers: &mut [f64]) {
            let numbers: &mut [f64; 2] = first_mut(numbers);
            instructions!(vst1q_f64(numbers.as_mut_ptr(), self.0));
        }

        #[inline(always)]
        fn packed(self, bits: u32) -> Self {
            let second = Self(instructions!(vdupq_laneq_f64::<1>(self.0)));
            if bits == 2 { second } else { self }
        }

        #[inline(always)]
        fn columns<'a>(quad: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
            let half = |k: usize, first: usize| Self::load(&quad(k).0[first..]);
            let [x, y] = turned(half(0, 0), half(1, 0));
            let [z, w] = turned(half(0, 2), half(1, 2));
            [x, y, z, w]
        }

        #[inline(always)]
        fn rows(vector: Vector<Self>, behind: Self) -> [Quad; MOST_LANES] {
            let mut rows = [Quad::default(); MOST_LANES];
            let halves = [turned(vector.x, vector.y), turned(vector.z, behind)];
            for (k, row) in rows[..Self::LANES].iter_mut().enumerate() {
                halves[0][k].store(&mut row.0[..2]);
                halves[1][k].store(&mut row.0[2..]);
            }
            rows
        }
    }
}

/// `a` where it is smaller, else `b`: NEON's own instruction returns NaN where one is NaN, and distinguishes the zeros.
#[inline(always)]
fn smaller(a: float64x2_t, b: float64x2_t) -> float64x2_t {
    instructions!(vbslq_f64(vcltq_f64(a, b), a, b))
}

/// `a` where it is larger, else `b`.
#[inline(always)]
fn larger(a: float64x2_t, b: float64x2_t) -> float64x2_t {
    instructions!(vbslq_f64(vcgtq_f64(a, b), a, b))
}

#[inline(always)]
fn xor(a: float64x2_t, b: float64x2_t) -> float64x2_t {
    instructions!({
        let (a, b) = (vreinterpretq_u64_f64(a), vreinterpretq_u64_f64(b));
        vreinterpretq_f64_u64(veorq_u64(a, b))
    })
}

/// The bits of `b` that `a` has not.
#[inline(always)]
fn andnot(a: float64x2_t, b: float64x2_t) -> float64x2_t {
    instructions!({
        let (a, b) = (vreinterpretq_u64_f64(a), vreinterpretq_u64_f64(b));
        vreinterpretq_f64_u64(vbicq_u64(b, a))
    })
}

/// `then` where the mask is set.
#[inline(always)]
fn chosen(otherwise: float64x2_t, then: float64x2_t, mask: uint64x2_t) -> float64x2_t {
    instructions!(vbslq_f64(mask, then, otherwise))
}

#[inline(always)]
fn inverted(mask: uint64x2_t) -> uint64x2_t {
    instructions!(veorq_u64(mask, vdupq_n_u64(u64::MAX)))
}

#[inline(always)]
fn bits(mask: uint64x2_t) -> u64 {
    let of_lanes = [1, 2];
    instructions!(vaddvq_u64(vandq_u64(mask, vld1q_u64(of_lanes.as_ptr()))))
}

/// Rows to columns, and back.
#[inline(always)]
fn turned(a: Two, b: Two) -> [Two; 2] {
    instructions!([Two(vzip1q_f64(a.0, b.0)), Two(vzip2q_f64(a.0, b.0))])
}
