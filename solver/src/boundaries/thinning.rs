//! How much an insertion may try while its region is full.
//!
//! Trying is thinned by what it costs, counted in looks (is this sphere inside, is that particle in the way): what is counted does
//! not depend on clocks or threads. Once `attempts` consecutive places have failed, each further failure is paid from a credit
//! that grows in every step by a hundredth of what the step costs for the particles that are there. Places that are found cost
//! nothing, so a region that is not full is filled as fast as ever.

use crate::state::Plain;

/// The part of the cost of a step that may go into failures.
const SHARE: f64 = 0.01;
/// Looks that take as long as a step of one particle: some 100 ns against some 4 ns.
const LOOKS_PER_PARTICLE: f64 = 25.0;
/// What a step costs with no particle, in particles.
const EMPTY_STEP: f64 = 100.0;
/// Looks that an attempt costs before it looks: random numbers.
const LOOKS_OF_DRAW: u64 = 12;
/// Looks that a question to a wall costs.
const LOOKS_OF_WALL: u64 = 10;
/// Most credit, in looks for each of `attempts`: a region that was empty for long is tried with `attempts` at once.
const LOOKS_PER_ATTEMPT: f64 = 50.0;

/// What an attempt has looked at.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Looks(u64);

impl Looks {
    /// So many looks at spheres or cells.
    pub(super) fn add(&mut self, number: u64) {
        self.0 += number;
    }

    /// A place was drawn.
    pub(super) fn draw(&mut self) {
        self.0 += LOOKS_OF_DRAW;
    }

    /// So many walls were asked.
    pub(super) fn at_walls(&mut self, walls: usize) {
        self.0 += LOOKS_OF_WALL * walls as u64;
    }
}

/// Looks that an insertion may still spend on failures; without bound until it first found its region full.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Credit(f64);

impl Default for Credit {
    fn default() -> Self {
        Self(f64::INFINITY)
    }
}

impl Credit {
    /// A step of so many particles has been made.
    pub(super) fn step(&mut self, particles: usize, attempts: u64) {
        let most = LOOKS_PER_ATTEMPT * attempts as f64;
        if self.0 <= most {
            let earned = SHARE * LOOKS_PER_PARTICLE * (particles as f64 + EMPTY_STEP);
            self.0 = (self.0 + earned).min(most);
        }
    }

    /// A place was tried in vain.
    pub(super) fn spend(&mut self, looks: Looks) {
        self.0 -= looks.0 as f64;
    }

    /// Whether the next attempt must wait.
    pub(super) fn is_used_up(self) -> bool {
        self.0 < 0.0
    }

    /// The region is full.
    pub(super) fn found_full(&mut self) {
        self.0 = self.0.min(0.0);
    }
}

impl Plain for Credit {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.0.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        f64::take(bytes).map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_cost_a_hundredth_of_the_steps() {
        let mut credit = Credit::default();
        let failure = || {
            let mut looks = Looks::default();
            looks.draw();
            looks.add(38);
            looks
        };
        // Without bound at first.
        for _ in 0..10_000 {
            assert!(!credit.is_used_up());
            credit.spend(failure());
        }
        credit.found_full();
        // 50 looks for a failure; a step of 3900 particles and its own cost earns 0.01 * 25 * 4000 = 1000.
        let mut failures = 0;
        for _ in 0..100 {
            credit.step(3900, 1000);
            while !credit.is_used_up() {
                credit.spend(failure());
                failures += 1;
            }
        }
        assert_eq!(failures, 100 * 1000 / 50 + 1);
        // A long pause earns a whole round of attempts, not more.
        for _ in 0..10_000 {
            credit.step(3900, 1000);
        }
        let mut failures = 0;
        while !credit.is_used_up() {
            credit.spend(failure());
            failures += 1;
        }
        assert_eq!(failures, 1001);
    }
}
