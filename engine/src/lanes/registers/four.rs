//! Four lanes: AVX2.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::{first, first_mut, instructions, register};
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Vector};

register! {
    /// Four numbers side by side.
    Four: __m256d of 4 [0, 1, 2, 3],
    [_mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd, _mm256_sqrt_pd, _mm256_min_pd, _mm256_max_pd],
    [_mm256_xor_pd, _mm256_andnot_pd, _mm256_set1_pd, |[a, b, c, d]| instructions!(_mm256_set_pd(d, c, b, a))],
    FourMask: __m256d,
    [below, at_most, equal, _mm256_blendv_pd],
    [inverted, _mm256_and_pd, _mm256_or_pd, _mm256_movemask_pd],
    {
    #[inline(always)]
    fn load(numbers: &[f64]) -> Self {
        let numbers: &[f64; 4] = first(numbers);
        Self(instructions!(_mm256_loadu_pd(numbers.as_ptr())))
    }

    #[inline(always)]
    fn store(self, numbers: &mut [f64]) {
        let numbers: &mut [f64; 4] = first_mut(numbers);
        instructions!(_mm256_storeu_pd(numbers.as_mut_ptr(), self.0));
    }

    #[inline(always)]
    fn packed(self, bits: u32) -> Self {
        let places = &FRONT[bits as usize & 15];
        Self(instructions!({
            let places = _mm256_loadu_si256(places.as_ptr().cast());
            _mm256_castps_pd(_mm256_permutevar8x32_ps(_mm256_castpd_ps(self.0), places))
        }))
    }

    #[inline(always)]
    fn differences<'a>(a: impl Fn(usize) -> &'a Quad, b: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
        turned(
            apart(a(0), b(0)),
            apart(a(1), b(1)),
            apart(a(2), b(2)),
            apart(a(3), b(3)),
        )
    }

    #[inline(always)]
    fn columns<'a>(quad: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
        turned(read(quad(0)), read(quad(1)), read(quad(2)), read(quad(3)))
    }

    #[inline(always)]
    fn rows(vector: Vector<Self>, behind: Self) -> [Quad; MOST_LANES] {
        let turned = turned(vector.x.0, vector.y.0, vector.z.0, behind.0);
        let mut rows = [Quad::default(); MOST_LANES];
        for (row, lane) in rows.iter_mut().zip(turned) {
            instructions!(_mm256_store_pd(row.0.as_mut_ptr(), lane.0));
        }
        rows
    }
    }
}

#[inline(always)]
fn below(a: __m256d, b: __m256d) -> __m256d {
    instructions!(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b))
}

#[inline(always)]
fn at_most(a: __m256d, b: __m256d) -> __m256d {
    instructions!(_mm256_cmp_pd::<_CMP_LE_OQ>(a, b))
}

#[inline(always)]
fn equal(a: __m256d, b: __m256d) -> __m256d {
    instructions!(_mm256_cmp_pd::<_CMP_EQ_OQ>(a, b))
}

/// The halves of numbers that come first when some lanes are packed, by the bits of these.
const FRONT: [[u32; 8]; 16] = {
    let mut front = [[0; 8]; 16];
    let mut bits = 0;
    while bits < 16 {
        let (mut lane, mut count) = (0, 0);
        while lane < 4 {
            if bits >> lane & 1 == 1 {
                front[bits][2 * count] = 2 * lane;
                front[bits][2 * count + 1] = 2 * lane + 1;
                count += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    front
};

#[inline(always)]
fn read(quad: &Quad) -> __m256d {
    instructions!(_mm256_load_pd(quad.0.as_ptr()))
}

/// The difference of the first three numbers, and the sum of the fourth ones. No closure: one that is not inlined is compiled for any processor.
#[inline(always)]
fn apart(a: &Quad, b: &Quad) -> __m256d {
    let (a, b) = (read(a), read(b));
    instructions!(_mm256_blend_pd::<8>(
        _mm256_sub_pd(a, b),
        _mm256_add_pd(a, b)
    ))
}

/// Rows to columns.
#[inline(always)]
fn turned(a: __m256d, b: __m256d, c: __m256d, d: __m256d) -> [Four; 4] {
    instructions!({
        let (ac_low, ac_high) = (
            _mm256_permute2f128_pd::<0x20>(a, c),
            _mm256_permute2f128_pd::<0x31>(a, c),
        );
        let (bd_low, bd_high) = (
            _mm256_permute2f128_pd::<0x20>(b, d),
            _mm256_permute2f128_pd::<0x31>(b, d),
        );
        [
            Four(_mm256_unpacklo_pd(ac_low, bd_low)),
            Four(_mm256_unpackhi_pd(ac_low, bd_low)),
            Four(_mm256_unpacklo_pd(ac_high, bd_high)),
            Four(_mm256_unpackhi_pd(ac_high, bd_high)),
        ]
    })
}

#[inline(always)]
fn inverted(mask: __m256d) -> __m256d {
    instructions!(_mm256_xor_pd(
        mask,
        _mm256_castsi256_pd(_mm256_set1_epi64x(-1))
    ))
}
