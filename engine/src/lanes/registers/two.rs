//! Two lanes: SSE2.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::{first, first_mut, instructions, register};
use crate::lanes::{Mask, Quad, Real};

register! {
    /// Two numbers side by side.
    Two: __m128d of 2 [0, 1],
    [_mm_add_pd, _mm_sub_pd, _mm_mul_pd, _mm_div_pd, _mm_sqrt_pd, _mm_min_pd, _mm_max_pd],
    [_mm_xor_pd, _mm_andnot_pd, _mm_set1_pd, |[a, b]| instructions!(_mm_set_pd(b, a))],
    TwoMask: __m128d,
    [_mm_cmplt_pd, _mm_cmple_pd, _mm_cmpeq_pd, chosen],
    [inverted, _mm_and_pd, _mm_or_pd, _mm_movemask_pd],
    {
        #[inline(always)]
        fn load(numbers: &[f64]) -> Self {
            let numbers: &[f64; 2] = first(numbers);
            Self(instructions!(_mm_loadu_pd(numbers.as_ptr())))
        }

        #[inline(always)]
        fn store(self, numbers: &mut [f64]) {
            let numbers: &mut [f64; 2] = first_mut(numbers);
            instructions!(_mm_storeu_pd(numbers.as_mut_ptr(), self.0));
        }

        #[inline(always)]
        fn packed(self, bits: u32) -> Self {
            let second = Self(instructions!(_mm_unpackhi_pd(self.0, self.0)));
            if bits == 2 { second } else { self }
        }

        #[inline(always)]
        fn columns<'a>(quad: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
            let half = |k: usize, first: usize| {
                let numbers: &[f64; 2] = super::first(&quad(k).0[first..]);
                instructions!(_mm_loadu_pd(numbers.as_ptr()))
            };
            let turned = |first| {
                let (a, b) = (half(0, first), half(1, first));
                instructions!((Self(_mm_unpacklo_pd(a, b)), Self(_mm_unpackhi_pd(a, b))))
            };
            let ((x, y), (z, w)) = (turned(0), turned(2));
            [x, y, z, w]
        }
    }
}

/// `then` where the mask is set: SSE2 has no instruction for it.
#[inline(always)]
fn chosen(otherwise: __m128d, then: __m128d, mask: __m128d) -> __m128d {
    instructions!(_mm_or_pd(
        _mm_and_pd(mask, then),
        _mm_andnot_pd(mask, otherwise)
    ))
}

#[inline(always)]
fn inverted(mask: __m128d) -> __m128d {
    instructions!(_mm_xor_pd(mask, _mm_castsi128_pd(_mm_set1_epi64x(-1))))
}
