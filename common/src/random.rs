//! Frozen counter-based random numbers.
//!
//! *Frozen*: the numbers of a stream never change, between versions, machines or thread counts, so a
//! scene with a seed is the same packing for ever. *Counter-based*: a number is a function of the seed, the purpose, the
//! index and the position, so any stream can be resumed or split without stored state beside a position.
//!
//! The generator is Philox4x32-10 (Salmon, Moraes, Dror and Shaw 2011, *Parallel random numbers: as easy as 1, 2, 3*,
//! SC'11, section 3.3). Elementary functions are those of the crate libm, not of the machine, for the same
//! reason.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use crate::normal::normal_quantile;

mod philox;
#[cfg(test)]
mod tests;

pub use philox::philox4x32;

/// 2^-53, the distance of neighbouring values of [`Stream::uniform`].
const UNIT_53: f64 = 1.0 / 9_007_199_254_740_992.0;
/// 2^-52.
const UNIT_52: f64 = 1.0 / 4_503_599_627_370_496.0;

/// A sequence of random numbers for one purpose.
///
/// Streams that differ in seed, purpose or index are independent. Every draw moves the position on by a
/// fixed number of 64-bit words, given at each function.
///
/// ```
/// use mercury_common::random::Stream;
/// let mut stream = Stream::new(7, "insertion", 0);
/// stream.uniform();
/// let saved = stream.position();
/// let next = stream.uniform();
/// assert_eq!(Stream::new(7, "insertion", 0).at(saved).uniform(), next);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stream {
    key: [u32; 2],
    index: u64,
    position: u64,
    /// The second half of the block of the last even position: a function of the other members.
    second_half: u64,
}

impl Stream {
    /// The stream of a purpose (its name is part of the frozen definition) and an index, for example
    /// that of an insertion region or a particle.
    ///
    /// The key is the seed xor the hash of the purpose; the 128-bit counter is the index (upper half) and
    /// the number of the block (lower half). So streams of one purpose that differ in their index never overlap.
    #[must_use]
    pub fn new(seed: u64, purpose: &str, index: u64) -> Self {
        let key = seed ^ fnv1a_64(purpose.as_bytes());
        Self {
            key: [key as u32, (key >> 32) as u32],
            index,
            position: 0,
            second_half: 0,
        }
    }

    /// Number of 64-bit words that have been drawn: all that must be stored to go on later.
    #[must_use]
    pub fn position(&self) -> u64 {
        self.position
    }

    /// This stream at a position that [`position`](Self::position) gave.
    #[must_use]
    pub fn at(mut self, position: u64) -> Self {
        self.position = position;
        if !position.is_multiple_of(2) {
            self.second_half = self.block(position / 2)[1];
        }
        self
    }

    fn block(&self, number: u64) -> [u64; 2] {
        let counter = [
            number as u32,
            (number >> 32) as u32,
            self.index as u32,
            (self.index >> 32) as u32,
        ];
        let [a, b, c, d] = philox4x32(counter, self.key);
        [
            u64::from(a) | u64::from(b) << 32,
            u64::from(c) | u64::from(d) << 32,
        ]
    }

    /// 64 random bits. One word.
    pub fn next_u64(&mut self) -> u64 {
        let word = if self.position.is_multiple_of(2) {
            let [first, second] = self.block(self.position / 2);
            self.second_half = second;
            first
        } else {
            self.second_half
        };
        // 2^64 words take centuries to draw.
        self.position = self.position.wrapping_add(1);
        word
    }

    /// Uniform in `[0, 1)`, a multiple of 2^-53. One word.
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * UNIT_53
    }

    /// Uniform between `low` and `high`; rounding can give `high` itself. One word.
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Normal with mean 0 and standard deviation 1, by inversion, in about +-8.2. One word.
    pub fn standard_normal(&mut self) -> f64 {
        // The middles of 2^52 equal intervals: exact, symmetric, never 0 or 1.
        normal_quantile(((self.next_u64() >> 12) as f64 + 0.5) * UNIT_52)
    }

    /// Uniform on the unit sphere (Archimedes: the height is uniform). Two words.
    pub fn unit_vector(&mut self) -> DVec3 {
        let height = 2.0 * self.uniform() - 1.0;
        let (sin, cos) = libm::sincos(TAU * self.uniform());
        let radius = ((1.0 - height) * (1.0 + height)).sqrt();
        DVec3::new(radius * cos, radius * sin, height)
    }

    /// A rotation uniform on SO(3) (Shoemake 1992, *Uniform random rotations*, Graphics Gems III). Three words.
    pub fn unit_quaternion(&mut self) -> DQuat {
        let share = self.uniform();
        let (sin_1, cos_1) = libm::sincos(TAU * self.uniform());
        let (sin_2, cos_2) = libm::sincos(TAU * self.uniform());
        let (r_1, r_2) = ((1.0 - share).sqrt(), share.sqrt());
        DQuat::from_xyzw(r_1 * sin_1, r_1 * cos_1, r_2 * sin_2, r_2 * cos_2)
    }
}

/// The hash FNV-1a of 64 bits (Fowler, Noll and Vo): frozen, unlike the standard library's.
#[must_use]
pub fn fnv1a_64(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
