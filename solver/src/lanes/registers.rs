//! Two lanes in a register of SSE2, four in one of AVX2.
//!
//! What is `unsafe` here: instructions that a processor may not have. Every x86-64 has SSE2. A [`Four`] is made and used only inside of
//! [`Width::run`](super::Width::run), which asks the processor first.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::{MOST_LANES, Mask, Quad, Real, Vector};

/// One instruction, or some.
macro_rules! instructions {
    ($($what:tt)*) => {{
        // SAFETY: the processor has them, as the head of this file says; what is read or written are whole values behind references.
        #[allow(unused_unsafe)]
        unsafe { $($what)* }
    }};
}

/// Numbers in a register, and a mask in one: all bits of a number, or none.
macro_rules! register {
    (
        $(#[$text:meta])* $name:ident, $mask:ident: $register:ident of $lanes:literal,
        [$add:ident, $sub:ident, $mul:ident, $div:ident, $sqrt:ident, $min:ident, $max:ident],
        [$xor:ident, $and:ident, $andnot:ident, $or:ident, $bits:ident],
        [$below:ident, $at_most:ident, $equals:ident, $select:ident],
        $splat:ident, $all_bits:expr, $from_lanes:expr,
        { $($own:tt)* }
    ) => {
        $(#[$text])*
        #[derive(Debug, Clone, Copy)]
        pub(super) struct $name($register);

        /// Yes or no for each of its lanes.
        #[derive(Debug, Clone, Copy)]
        pub(super) struct $mask($register);

        register!(operation $name: Add, add, $add);
        register!(operation $name: Sub, sub, $sub);
        register!(operation $name: Mul, mul, $mul);
        register!(operation $name: Div, div, $div);

        impl Default for $name {
            #[inline(always)]
            fn default() -> Self {
                Self::ZERO
            }
        }

        impl PartialEq for $name {
            #[inline(always)]
            fn eq(&self, other: &Self) -> bool {
                self.equals(*other).all()
            }
        }

        impl Neg for $name {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self(instructions!($xor(self.0, $splat(-0.0))))
            }
        }

        impl Real for $name {
            type Mask = $mask;
            const LANES: usize = $lanes;
            const ZERO: Self = Self::from_array([0.0; $lanes]);
            const ONE: Self = Self::from_array([1.0; $lanes]);

            #[inline(always)]
            fn splat(number: f64) -> Self {
                Self(instructions!($splat(number)))
            }

            #[inline(always)]
            fn lane(self, k: usize) -> f64 {
                // SAFETY: any bits of the one are a value of the other.
                let numbers: [f64; $lanes] = unsafe { std::mem::transmute(self.0) };
                numbers[k]
            }

            #[inline(always)]
            fn from_lanes(mut number: impl FnMut(usize) -> f64) -> Self {
                let from_lanes: fn([f64; $lanes]) -> $register = $from_lanes;
                Self(from_lanes(std::array::from_fn(&mut number)))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(instructions!($sqrt(self.0)))
            }

            #[inline(always)]
            fn abs(self) -> Self {
                Self(instructions!($andnot($splat(-0.0), self.0)))
            }

            // The instruction gives its second operand where one is no number or both are zeros.
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(instructions!($min(other.0, self.0)))
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(instructions!($max(other.0, self.0)))
            }

            #[inline(always)]
            fn below(self, other: Self) -> $mask {
                $mask(instructions!($below(self.0, other.0)))
            }

            #[inline(always)]
            fn at_most(self, other: Self) -> $mask {
                $mask(instructions!($at_most(self.0, other.0)))
            }

            #[inline(always)]
            fn equals(self, other: Self) -> $mask {
                $mask(instructions!($equals(self.0, other.0)))
            }

            #[inline(always)]
            fn select(mask: $mask, then: Self, otherwise: Self) -> Self {
                Self(instructions!($select(otherwise.0, then.0, mask.0)))
            }

            $($own)*
        }

        impl $name {
            const fn from_array(numbers: [f64; $lanes]) -> Self {
                // SAFETY: any bits of the one are a value of the other.
                Self(unsafe { std::mem::transmute::<[f64; $lanes], $register>(numbers) })
            }
        }

        impl Mask for $mask {
            #[inline(always)]
            fn any(self) -> bool {
                self.bits() != 0
            }

            #[inline(always)]
            fn all(self) -> bool {
                self.bits() == (1 << $lanes) - 1
            }

            #[inline(always)]
            fn bits(self) -> u32 {
                instructions!($bits(self.0)) as u32
            }
        }

        impl Not for $mask {
            type Output = Self;

            #[inline(always)]
            fn not(self) -> Self {
                Self(instructions!($xor(self.0, $all_bits)))
            }
        }

        impl BitAnd for $mask {
            type Output = Self;

            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                Self(instructions!($and(self.0, other.0)))
            }
        }

        impl BitOr for $mask {
            type Output = Self;

            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                Self(instructions!($or(self.0, other.0)))
            }
        }
    };

    // Between lanes, and with one number for all lanes.
    (operation $name:ident: $operation:ident, $function:ident, $instruction:ident) => {
        impl $operation for $name {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(instructions!($instruction(self.0, other.0)))
            }
        }

        impl $operation<f64> for $name {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                self.$function(Self::splat(other))
            }
        }
    };
}

register! {
    /// Two numbers side by side.
    Two, TwoMask: __m128d of 2,
    [_mm_add_pd, _mm_sub_pd, _mm_mul_pd, _mm_div_pd, _mm_sqrt_pd, _mm_min_pd, _mm_max_pd],
    [_mm_xor_pd, _mm_and_pd, _mm_andnot_pd, _mm_or_pd, _mm_movemask_pd],
    [_mm_cmplt_pd, _mm_cmple_pd, _mm_cmpeq_pd, chosen],
    _mm_set1_pd, _mm_castsi128_pd(_mm_set1_epi64x(-1)),
    |[a, b]| instructions!(_mm_set_pd(b, a)),
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
        fn differences<'a>(
            a: impl Fn(usize) -> &'a Quad,
            b: impl Fn(usize) -> &'a Quad,
        ) -> [Self; 4] {
            let [ax, ay, az, aw] = Self::columns(a);
            let [bx, by, bz, bw] = Self::columns(b);
            [ax - bx, ay - by, az - bz, aw + bw]
        }

        #[inline(always)]
        fn columns<'a>(quad: impl Fn(usize) -> &'a Quad) -> [Self; 4] {
            let half = |k: usize, first: usize| {
                let numbers: &[f64; 2] = self::first(&quad(k).0[first..]);
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

register! {
    /// Four numbers side by side.
    Four, FourMask: __m256d of 4,
    [_mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd, _mm256_sqrt_pd, _mm256_min_pd, _mm256_max_pd],
    [_mm256_xor_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_or_pd, _mm256_movemask_pd],
    [below, at_most, equal, _mm256_blendv_pd],
    _mm256_set1_pd, _mm256_castsi256_pd(_mm256_set1_epi64x(-1)),
    |[a, b, c, d]| instructions!(_mm256_set_pd(d, c, b, a)),
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
        let of = |k| {
            let (a, b) = (read(a(k)), read(b(k)));
            instructions!(_mm256_blend_pd::<8>(
                _mm256_sub_pd(a, b),
                _mm256_add_pd(a, b)
            ))
        };
        turned(of(0), of(1), of(2), of(3))
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

/// Which halves of numbers stand in front when some lanes are packed, by the bits of these.
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
fn first<T, const N: usize>(values: &[T]) -> &[T; N] {
    match values.first_chunk() {
        Some(first) => first,
        None => too_few(),
    }
}

#[inline(always)]
fn first_mut<T, const N: usize>(values: &mut [T]) -> &mut [T; N] {
    match values.first_chunk_mut() {
        Some(first) => first,
        None => too_few(),
    }
}

#[cold]
fn too_few() -> ! {
    panic!("fewer numbers than lanes")
}
