//! How much an insertion may try while its region is full.
//!
//! Trying is thinned by what it costs, counted in looks (is this sphere inside, is that particle in the way): what is counted does
//! not depend on clocks or threads. Once `attempts` consecutive places have failed, each further failure is paid from a credit
//! that grows in every step by a hundredth of what the step costs for the particles that are there. To find out who stands about the
//! region is paid from it too, and as much may be spent on places then, in advance: so tries come in rounds, and neither costs more
//! than the other. Places that are found cost nothing, so a region that is not full is filled as fast as ever.

use crate::state::Plain;

/// The part of the cost of a step that may go into failures.
const SHARE: f64 = 0.01;
/// Looks that take as long as a step of one particle: at least 60 ns against some 4 ns.
const LOOKS_PER_PARTICLE: f64 = 15.0;
/// What a step may cost besides, in particles: small scenes are filled promptly, though a failure costs more than a hundredth of
/// their steps.
const EMPTY_STEP: f64 = 1000.0;
/// Looks that an attempt costs before it looks: random numbers.
const LOOKS_OF_DRAW: u64 = 12;
/// Looks that it costs to find a cell, which lies anywhere in the memory, and to ask a sphere in it.
const LOOKS_OF_CELL: u64 = 8;
const LOOKS_OF_SPHERE: u64 = 2;
/// Looks that a question to a wall costs.
const LOOKS_OF_WALL: u64 = 10;
/// Most credit, in looks for each of `attempts`: a region that was empty for long is tried with `attempts` at once.
const LOOKS_PER_ATTEMPT: f64 = 50.0;

/// What an attempt has looked at.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Looks {
    number: u64,
    /// Who stands about was asked, which it took so many looks to find out.
    crowd: Option<u64>,
}

impl Looks {
    /// So many questions to shapes.
    pub(super) fn add(&mut self, number: u64) {
        self.number += number;
    }

    /// So many cells were looked up.
    pub(super) fn at_cells(&mut self, cells: u64) {
        self.number += LOOKS_OF_CELL * cells;
    }

    /// A sphere was asked.
    pub(super) fn at_sphere(&mut self) {
        self.number += LOOKS_OF_SPHERE;
    }

    /// How many there were, but for finding out who stands about.
    #[cfg(test)]
    pub(super) fn number(self) -> u64 {
        self.number
    }

    /// Who stands about was asked, which it took so many looks to find out.
    pub(super) fn among_crowd(&mut self, cost: u64) {
        self.crowd = Some(cost);
    }

    /// A place was drawn.
    pub(super) fn draw(&mut self) {
        self.number += LOOKS_OF_DRAW;
    }

    /// So many walls were asked.
    pub(super) fn at_walls(&mut self, walls: usize) {
        self.number += LOOKS_OF_WALL * walls as u64;
    }
}

/// What an insertion may still spend on failures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Credit {
    /// Looks; without bound until the region was first found full.
    left: f64,
    /// What it may fall to, looks: as much may be spent on places as it cost to find out who stands about them.
    least: f64,
    /// Whether that was paid for who stands about now.
    is_crowd_paid: bool,
}

impl Default for Credit {
    fn default() -> Self {
        Self {
            left: f64::INFINITY,
            least: 0.0,
            is_crowd_paid: false,
        }
    }
}

impl Credit {
    /// A step of so many particles has been made.
    pub(super) fn step(&mut self, particles: usize, attempts: u64) {
        let most = LOOKS_PER_ATTEMPT * attempts as f64;
        if self.left <= most {
            let earned = SHARE * LOOKS_PER_PARTICLE * (particles as f64 + EMPTY_STEP);
            self.left = (self.left + earned).min(most);
        }
    }

    /// Who stands about must be found out anew.
    pub(super) fn forget_crowd(&mut self) {
        self.least = 0.0;
        self.is_crowd_paid = false;
    }

    /// A place was tried in vain.
    pub(super) fn spend(&mut self, looks: Looks) {
        if let Some(crowd) = looks.crowd.filter(|_| !self.is_crowd_paid) {
            self.is_crowd_paid = true;
            self.left -= crowd as f64;
            self.least = (self.left - crowd as f64).min(0.0);
        }
        self.left -= looks.number as f64;
        if self.left < self.least {
            // Until all is paid off.
            self.least = 0.0;
        }
    }

    /// Whether the next attempt must wait.
    pub(super) fn is_used_up(self) -> bool {
        self.left < self.least
    }

    /// The region is full.
    pub(super) fn found_full(&mut self) {
        self.left = self.left.min(0.0);
    }
}

impl Plain for Credit {
    fn put(&self, bytes: &mut Vec<u8>) {
        (self.left, (self.least, self.is_crowd_paid)).put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let (left, (least, is_crowd_paid)) = Plain::take(bytes)?;
        let credit = Self {
            left,
            least,
            is_crowd_paid,
        };
        if credit.left.is_nan() || credit.least.is_nan() || credit.least > 0.0 {
            return Err(format!(
                "no credit of an insertion: {left}, {least} at least"
            ));
        }
        Ok(credit)
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
        // 50 looks for a failure; a step of 3900 particles earns 0.01 * 15 * 4900 = 735.
        let mut failures = 0;
        for _ in 0..100 {
            credit.step(3900, 1000);
            while !credit.is_used_up() {
                credit.spend(failure());
                failures += 1;
            }
        }
        assert_eq!(failures, 100 * 735 / 50 + 1);
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

    #[test]
    fn who_stands_about_is_paid_for_once_and_as_much_may_be_spent_on_places() {
        let mut credit = Credit::default();
        credit.found_full();
        let mut failure = Looks::default();
        failure.draw();
        failure.add(38);
        failure.among_crowd(10_000);
        let until_used_up = |credit: &mut Credit| {
            let mut failures = 0;
            while !credit.is_used_up() {
                credit.spend(failure);
                failures += 1;
            }
            failures
        };
        // 50 looks for a failure.
        assert_eq!(until_used_up(&mut credit), 10_000 / 50 + 1);
        // All of the 20,050 looks are paid off, at 735 a step, before it goes on.
        let mut steps = 0;
        while credit.is_used_up() {
            credit.step(3900, 1000);
            steps += 1;
        }
        assert_eq!(steps, 20_050_u32.div_ceil(735));
        // The same crowd costs nothing more, another does.
        let left = 735 * steps - 20_050;
        assert_eq!(until_used_up(&mut credit), left / 50 + 1);
        credit.forget_crowd();
        while credit.is_used_up() {
            credit.step(3900, 1000);
        }
        assert!(until_used_up(&mut credit) > 10_000 / 50);
    }
}
