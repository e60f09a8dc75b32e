//! The wait of an insertion before its next round of attempts while its region is full.
//!
//! A round of tries ends when `attempts` consecutive places have failed. While rounds fail as a whole, the waits between them double,
//! up to [`LONGEST`] steps; from then on a scene of few particles makes shorter rounds ([`Wait::tries`]), so that a full region costs
//! little. A success ends that: the next waits are short and the rounds whole again. Waits are counted in steps, which do not
//! depend on clocks or threads.

use crate::state::Plain;

/// Longest wait, steps.
const LONGEST: u32 = 64;

/// Tries per particle of the scene in a round after the longest wait. A try costs about as much as 1.6 particle-steps, so that one
/// round in [`LONGEST`] steps costs 7 to 9 % of them (`benches/insertion.py`).
const TRIES_PER_PARTICLE: u64 = 3;

/// Particles that the rest of a step costs as much as; they count as well.
const OVERHEAD: u64 = 10;

/// Pebbles of a clump that make its try as costly as another one of a sphere.
const PEBBLES_PER_TRY: u64 = 4;

/// The time of the next round of attempts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wait {
    /// Steps until the next round.
    left: u32,
    /// The wait after the next failed round, steps.
    next: u32,
}

impl Default for Wait {
    fn default() -> Self {
        Self { left: 0, next: 1 }
    }
}

impl Wait {
    /// A step has been made; returns whether a round is due in it.
    pub(super) fn step(&mut self) -> bool {
        self.left = self.left.saturating_sub(1);
        self.left == 0
    }

    /// The failed tries in a row that end a round, in a scene of so many particles: `attempts`, or fewer where the rounds before have
    /// shown that the region stays full. `pebbles`: those of the clump that waits, 1 for a sphere.
    pub(super) fn tries(&self, attempts: u64, particles: usize, pebbles: usize) -> u64 {
        if self.next < LONGEST {
            return attempts;
        }
        let particles = (particles as u64).saturating_add(OVERHEAD);
        let affordable = TRIES_PER_PARTICLE.saturating_mul(particles);
        attempts.min(affordable.div_ceil(1 + pebbles as u64 / PEBBLES_PER_TRY))
    }

    /// A particle was placed.
    pub(super) fn succeeded(&mut self) {
        *self = Self::default();
    }

    /// The round ended with failures. A wait of one step means that the next step makes a round.
    pub(super) fn failed(&mut self) {
        self.left = self.next;
        self.next = (2 * self.next).min(LONGEST);
    }
}

impl Plain for Wait {
    fn put(&self, bytes: &mut Vec<u8>) {
        (self.left, self.next).put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let (left, next) = Plain::take(bytes)?;
        if left > LONGEST || !(1..=LONGEST).contains(&next) {
            return Err(format!(
                "invalid wait of an insertion: {left} steps, then {next}; the longest is {LONGEST}"
            ));
        }
        Ok(Self { left, next })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The steps, among the first `steps`, in which a round is due, if all rounds fail.
    fn rounds(wait: &mut Wait, steps: u32) -> Vec<u32> {
        let due = (0..steps).filter(|_| {
            let is_due = wait.step();
            if is_due {
                wait.failed();
            }
            is_due
        });
        due.collect()
    }

    #[test]
    fn waits_double_up_to_the_longest_until_a_place_is_found() {
        let mut wait = Wait::default();
        let expected = [0, 1, 3, 7, 15, 31, 63, 127, 191, 255];
        assert_eq!(rounds(&mut wait, 300), expected);
        wait.succeeded();
        assert_eq!(wait, Wait::default());
        assert_eq!(rounds(&mut wait, 9), [0, 1, 3, 7]);
    }

    #[test]
    fn a_round_is_short_only_after_the_longest_wait_and_among_few_particles() {
        let mut wait = Wait::default();
        for _ in 0..6 {
            assert_eq!(wait.tries(1000, 0, 1), 1000);
            wait.failed();
        }
        assert_eq!(wait.tries(1000, 0, 1), 30);
        assert_eq!(wait.tries(1000, 106, 1), 348);
        assert_eq!(wait.tries(1000, 324, 1), 1000);
        assert_eq!(wait.tries(1000, 106, 50), 27);
        assert_eq!(wait.tries(7, 106, 1), 7);
        assert_eq!(wait.tries(u64::MAX, usize::MAX, 1), u64::MAX);
        wait.succeeded();
        assert_eq!(wait.tries(1000, 0, 1), 1000);
    }

    #[test]
    fn only_waits_that_can_be_come_back_from_bytes() {
        let mut wait = Wait::default();
        for _ in 0..200 {
            if wait.step() {
                wait.failed();
            }
            let mut bytes = Vec::new();
            wait.put(&mut bytes);
            assert_eq!(Wait::take(&mut &bytes[..]), Ok(wait));
        }
        for (left, next) in [(65_u32, 1_u32), (0, 0), (0, 65), (u32::MAX, 1)] {
            let mut bytes = Vec::new();
            (left, next).put(&mut bytes);
            let error = Wait::take(&mut &bytes[..]).unwrap_err();
            assert!(error.contains("wait of an insertion"), "{error}");
        }
    }
}
