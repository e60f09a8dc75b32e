//! How many lanes, chosen when the program runs.

use super::Real;
#[cfg(target_arch = "x86_64")]
use super::registers::Four;
#[cfg(any(target_arch = "aarch64", target_arch = "x86_64"))]
use super::registers::Two;

/// Two numbers, where registers hold them without a feature check.
#[cfg(not(any(target_arch = "aarch64", target_arch = "x86_64")))]
type Two = super::Lanes<2>;

/// Work that can be done in lanes of any number.
pub trait Task {
    /// Result of the task.
    type Output;

    /// Performs the task. To be marked `inline(always)`, as all functions that its inner loops call: only what is inlined here is
    /// compiled for the processor that was found.
    fn run<L: Real>(self) -> Self::Output;
}

/// A number of lanes that this processor can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Width(LaneKind);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LaneKind {
    One,
    Two,
    #[cfg(target_arch = "x86_64")]
    Four,
    /// With the 32 registers of AVX-512 in place of 16.
    #[cfg(target_arch = "x86_64")]
    FourOf32,
}

impl Width {
    /// One number at a time: every processor can.
    pub const ONE: Self = Self(LaneKind::One);

    /// All widths of this processor, the narrowest first. Four lanes are there twice where the processor has AVX-512: with its 32 registers, and
    /// with 16 as elsewhere.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let all = [1, 2].into_iter().filter_map(Self::of);
        #[cfg(target_arch = "x86_64")]
        let all = {
            let of_16 = has_avx2().then_some(Self(LaneKind::Four));
            let of_32 = has_avx512().then_some(Self(LaneKind::FourOf32));
            all.chain(of_16).chain(of_32)
        };
        all.collect()
    }

    /// Width of so many lanes, if this processor can.
    #[must_use]
    pub fn of(lanes: usize) -> Option<Self> {
        match lanes {
            1 => Some(Self(LaneKind::One)),
            2 => Some(Self(LaneKind::Two)),
            #[cfg(target_arch = "x86_64")]
            4 if has_avx512() => Some(Self(LaneKind::FourOf32)),
            #[cfg(target_arch = "x86_64")]
            4 if has_avx2() => Some(Self(LaneKind::Four)),
            _ => None,
        }
    }

    /// The widest of this processor that is in registers, which was the fastest wherever it was measured but for two lanes on x86-64, that are no slower
    /// than one (`docs/performance.md`): where none is, one. NEON's two were chosen by their count of instructions alone.
    #[must_use]
    pub fn fastest() -> Self {
        let two_in_registers = cfg!(any(target_arch = "aarch64", target_arch = "x86_64"));
        let always = if two_in_registers { 2 } else { 1 };
        let widest = Self::of(4).or(Self::of(always));
        widest.unwrap_or(Self::ONE)
    }

    /// Its number of lanes.
    #[must_use]
    pub fn lanes(self) -> usize {
        match self.0 {
            LaneKind::One => 1,
            LaneKind::Two => 2,
            #[cfg(target_arch = "x86_64")]
            LaneKind::Four | LaneKind::FourOf32 => 4,
        }
    }

    /// Does a task in so many lanes.
    #[inline]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self.0 {
            LaneKind::One => task.run::<f64>(),
            LaneKind::Two => task.run::<Two>(),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: only `of` and `all` make a `Width` of this kind, and they have checked that the processor has the features.
            LaneKind::Four => unsafe { with_avx2(task) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            LaneKind::FourOf32 => unsafe { with_avx512(task) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("popcnt")
}

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    has_avx2()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
}

// Not with fused multiply-add, which would change the bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
fn with_avx2<T: Task>(task: T) -> T::Output {
    task.run::<Four>()
}

// Same operations, in twice as many registers.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,avx512f,avx512vl,avx512dq,bmi1,bmi2,popcnt")]
fn with_avx512<T: Task>(task: T) -> T::Output {
    task.run::<Four>()
}
