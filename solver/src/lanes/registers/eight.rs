//! Eight lanes: AVX-512, of which the parts F and DQ are used.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::{first, first_mut, instructions, register};
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Vector};

register! {
    // No closures here: they would not be compiled for the processor that has these instructions.
    /// Eight numbers side by side.
    Eight: __m512d of 8,
    [_mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd, _mm512_sqrt_pd, _mm512_min_pd, _mm512_max_pd],
    [_mm512_xor_pd, _mm512_andnot_pd, _mm512_set1_pd, from_lanes],
    EightMask: __mmask8,
    [below, at_most, equal, chosen],
    [inverted, both, either, bits],
    {
    #[inline(always)]
    fn load(numbers: &[f64]) -> Self {
        let numbers: &[f64; 8] = first(numbers);
        Self(instructions!(_mm512_loadu_pd(numbers.as_ptr())))
    }

    #[inline(always)]
    fn store(self, numbers: &mut [f64]) {
        let numbers: &mut [f64; 8] = first_mut(numbers);
        instructions!(_mm512_storeu_pd(numbers.as_mut_ptr(), self.0));
    }

    #[inline(always)]
    fn packed(self, bits: u32) -> Self {
        Self(instructions!(_mm512_maskz_compress_pd(bits as u8, self.0)))
    }

    #[inline(always)]
    fn differences<'a>(a: impl Fn(usize) -> &'a Quad, b: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
        columns(
            difference(read(a(0), a(4)), read(b(0), b(4))),
            difference(read(a(1), a(5)), read(b(1), b(5))),
            difference(read(a(2), a(6)), read(b(2), b(6))),
            difference(read(a(3), a(7)), read(b(3), b(7))),
        )
    }

    #[inline(always)]
    fn columns<'a>(quad: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
        columns(
            read(quad(0), quad(4)),
            read(quad(1), quad(5)),
            read(quad(2), quad(6)),
            read(quad(3), quad(7)),
        )
    }

    #[inline(always)]
    fn rows(vector: Vector<Self>, behind: Self) -> [Quad; MOST_LANES] {
        let turned = rows(vector.x.0, vector.y.0, vector.z.0, behind.0);
        let mut rows = [Quad::default(); MOST_LANES];
        for (k, pair) in turned.into_iter().enumerate() {
            instructions!({
                _mm256_store_pd(rows[k].0.as_mut_ptr(), _mm512_castpd512_pd256(pair));
                _mm256_store_pd(rows[k + 4].0.as_mut_ptr(), _mm512_extractf64x4_pd::<1>(pair));
            });
        }
        rows
    }
    }
}

/// The last number of both quads in a register.
const FOURTH: __mmask8 = 0b1000_1000;

#[inline(always)]
fn from_lanes(numbers: [f64; 8]) -> __m512d {
    let [a, b, c, d, e, f, g, h] = numbers;
    instructions!(_mm512_set_pd(h, g, f, e, d, c, b, a))
}

#[inline(always)]
fn below(a: __m512d, b: __m512d) -> __mmask8 {
    instructions!(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b))
}

#[inline(always)]
fn at_most(a: __m512d, b: __m512d) -> __mmask8 {
    instructions!(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b))
}

#[inline(always)]
fn equal(a: __m512d, b: __m512d) -> __mmask8 {
    instructions!(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(a, b))
}

/// `then` where the mask is set.
#[inline(always)]
fn chosen(otherwise: __m512d, then: __m512d, mask: __mmask8) -> __m512d {
    instructions!(_mm512_mask_blend_pd(mask, otherwise, then))
}

#[inline(always)]
fn inverted(mask: __mmask8) -> __mmask8 {
    !mask
}

#[inline(always)]
fn both(a: __mmask8, b: __mmask8) -> __mmask8 {
    a & b
}

#[inline(always)]
fn either(a: __mmask8, b: __mmask8) -> __mmask8 {
    a | b
}

#[inline(always)]
fn bits(mask: __mmask8) -> i32 {
    i32::from(mask)
}

/// Two quads side by side.
#[inline(always)]
fn read(low: &Quad, high: &Quad) -> __m512d {
    instructions!({
        let low = _mm512_castpd256_pd512(_mm256_load_pd(low.0.as_ptr()));
        _mm512_insertf64x4::<1>(low, _mm256_load_pd(high.0.as_ptr()))
    })
}

/// Of both quads: the difference of the first three numbers, the sum of the fourth ones.
#[inline(always)]
fn difference(a: __m512d, b: __m512d) -> __m512d {
    instructions!(_mm512_mask_add_pd(_mm512_sub_pd(a, b), FOURTH, a, b))
}

/// The first halves of the quads in `a` with those in `b`, and the second ones.
#[inline(always)]
fn halves(a: __m512d, b: __m512d) -> [__m512d; 2] {
    instructions!({
        let first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let second = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        [
            _mm512_permutex2var_pd(a, first, b),
            _mm512_permutex2var_pd(a, second, b),
        ]
    })
}

#[inline(always)]
fn even(a: __m512d, b: __m512d) -> __m512d {
    instructions!(_mm512_unpacklo_pd(a, b))
}

#[inline(always)]
fn odd(a: __m512d, b: __m512d) -> __m512d {
    instructions!(_mm512_unpackhi_pd(a, b))
}

/// Rows 0 and 4, 1 and 5, 2 and 6, 3 and 7 to columns.
#[inline(always)]
fn columns(a: __m512d, b: __m512d, c: __m512d, d: __m512d) -> [Eight; 4] {
    let [x, z] = halves(even(a, b), even(c, d));
    let [y, w] = halves(odd(a, b), odd(c, d));
    [Eight(x), Eight(y), Eight(z), Eight(w)]
}

/// Columns to rows 0 and 4, 1 and 5, 2 and 6, 3 and 7.
#[inline(always)]
fn rows(x: __m512d, y: __m512d, z: __m512d, w: __m512d) -> [__m512d; 4] {
    let [first, third] = halves(even(x, y), even(z, w));
    let [second, fourth] = halves(odd(x, y), odd(z, w));
    [first, second, third, fourth]
}
