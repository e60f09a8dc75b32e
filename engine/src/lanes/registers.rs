//! Lanes in registers: two in one of SSE2 or NEON, four of AVX2.
//!
//! Use of `unsafe`: instructions that a processor may not have. Every x86-64 has SSE2, and every aarch64 has NEON. A `Four` is
//! made and used only inside of [`Width::run`](super::Width::run), which first checks the processor.

#[cfg(target_arch = "x86_64")]
mod four;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(target_arch = "x86_64")]
mod two;

#[cfg(target_arch = "aarch64")]
pub(super) use neon::Two;
#[cfg(target_arch = "x86_64")]
pub(super) use {four::Four, two::Two};

/// One instruction, or some.
macro_rules! instructions {
    ($($what:tt)*) => {{
        // SAFETY: the processor has them, see the documentation of this module; what is read or written are whole values
        // behind references.
        #[allow(unused_unsafe)]
        unsafe { $($what)* }
    }};
}

use instructions;

/// Numbers in a register, and the mask that a comparison of two gives.
macro_rules! register {
    (
        $(#[$text:meta])* $name:ident: $register:ident of $lanes:literal [$($lane:literal),*],
        [$add:ident, $sub:ident, $mul:ident, $div:ident, $sqrt:ident, $min:ident, $max:ident],
        [$xor:ident, $andnot:ident, $splat:ident, $from_lanes:expr],
        $mask:ident: $bits_of_mask:ident,
        [$below:ident, $at_most:ident, $equals:ident, $select:ident],
        [$not:ident, $and:ident, $or:ident, $bits:ident],
        { $($own:tt)* }
    ) => {
        $(#[$text])*
        #[derive(Debug, Clone, Copy)]
        pub(in crate::lanes) struct $name($register);

        /// Yes or no for each of its lanes.
        #[derive(Debug, Clone, Copy)]
        pub(in crate::lanes) struct $mask($bits_of_mask);

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
                // Not `array::from_fn`, which would be a tenth of the crate's code before it is optimised.
                Self(from_lanes([$(number($lane)),*]))
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
                Self(instructions!($not(self.0)))
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

use register;

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
