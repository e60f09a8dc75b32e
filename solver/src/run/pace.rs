//! Whether steps are faster with all threads or with one.
//!
//! On a busy machine, a thread that has to wait for another one in every step waits for its next time slice: a step of some
//! hundred particles can take twenty times as long with two threads as with one. The results do not depend on the threads, so the
//! run uses the faster way, and finds it by trying the other one from time to time.

use std::time::Duration;

/// The duration of a trial, s: several time slices of a shared machine.
const TRIAL: f64 = 0.02;
/// The next trial follows after this many times the duration of the last one: soon after a change, since scenes change most at
/// their beginning, and each time twice as late while the same way stays the better one.
const APART: [f64; 2] = [5.0, 50.0];
/// The other way must take less than this share of the time: a needless change costs cache misses.
const BETTER: f64 = 0.95;
/// Particle-steps made at once at the beginning of a trial; then, in one piece, as many as should take the rest of it: switching
/// to the threads and back takes as long as a step or two of a small scene.
const AT_ONCE: u64 = 10_000;

/// Alone, or with all threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    Together,
    Alone,
}

impl Way {
    fn other(self) -> Self {
        match self {
            Self::Together => Self::Alone,
            Self::Alone => Self::Together,
        }
    }
}

/// Measures both ways and returns the better one.
#[derive(Debug, Clone)]
pub(super) struct Pace {
    /// The better one so far.
    better: Way,
    /// The present way: the better one, or the other on trial.
    now: Way,
    /// Time (s) and particle-steps since it is.
    spent: [f64; 2],
    /// How long it is taken, s.
    budget: f64,
    /// The next trial follows after this many times the duration of the last one.
    apart: f64,
    /// s per particle-step of the better way when it was measured last.
    rate: f64,
    /// Particle-steps made alone.
    alone: u64,
}

impl Pace {
    /// Begins with all threads.
    pub(super) fn new() -> Self {
        Self {
            better: Way::Together,
            now: Way::Together,
            spent: [0.0; 2],
            budget: TRIAL,
            apart: APART[0],
            rate: f64::INFINITY,
            alone: 0,
        }
    }

    /// How the next steps are made.
    pub(super) fn way(&self) -> Way {
        self.now
    }

    /// The most particle-steps that are made so before the next check.
    pub(super) fn at_once(&self) -> u64 {
        if self.budget > TRIAL {
            return u64::MAX;
        }
        let [time, steps] = self.spent;
        let rest = (self.budget - time) * steps / time;
        if rest.is_finite() {
            AT_ONCE.max(rest as u64)
        } else {
            AT_ONCE
        }
    }

    /// Particle-steps made alone.
    pub(super) fn alone(&self) -> u64 {
        self.alone
    }

    /// Adds the time of steps that were made as [`Pace::way`] says.
    pub(super) fn note(&mut self, time: Duration, particle_steps: u64) {
        if self.now == Way::Alone {
            self.alone += particle_steps;
        }
        self.spent[0] += time.as_secs_f64();
        self.spent[1] += particle_steps as f64;
        let [time, steps] = self.spent;
        if time < self.budget || steps == 0.0 {
            return;
        }
        let rate = time / steps;
        if self.now == self.better {
            self.rate = rate;
            self.take(self.better.other(), TRIAL);
            return;
        }
        if rate < BETTER * self.rate {
            self.better = self.now;
            self.apart = APART[0];
        }
        self.take(self.better, self.apart * time);
        self.apart = (2.0 * self.apart).min(APART[1]);
    }

    fn take(&mut self, way: Way, budget: f64) {
        self.now = way;
        self.spent = [0.0; 2];
        self.budget = budget;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run in which a step of 100 particles takes `together` or `alone` (s), for a minute. Returns the share of the time in which it went alone.
    fn share_alone(pace: &mut Pace, together: f64, alone: f64) -> f64 {
        let (mut time, mut of_alone) = (0.0, 0.0);
        while time < 60.0 {
            let step = match pace.way() {
                Way::Together => together,
                Way::Alone => alone,
            };
            let count = (pace.at_once() / 100).min(1000);
            let took = step * count as f64;
            if pace.way() == Way::Alone {
                of_alone += took;
            }
            time += took;
            pace.note(Duration::from_secs_f64(took), 100 * count);
        }
        of_alone / time
    }

    /// The slower way gets a fiftieth of the time in the end, and what its first trials take: 100 steps of 1.5 ms are 0.15 s. They come again after 5,
    /// 10, 20, 40 and then 50 times that, 7.5 s.
    #[test]
    fn the_faster_way_is_taken_and_the_other_tried() {
        let mut pace = Pace::new();
        let share = share_alone(&mut pace, 1.5e-3, 5e-5);
        assert!(share > 0.94, "{share}");
        // The machine has nothing else to do any more: soon all threads step again.
        let share = share_alone(&mut pace, 3e-5, 5e-5);
        assert!(share < 7.6 / 60.0 + 0.04, "{share}");
        let share = share_alone(&mut pace, 3e-5, 5e-5);
        assert!((0.001..0.04).contains(&share), "{share}");
    }

    /// Particles are poured in, 4,000 a second for one second: alone they take 0.1 us each, together half of that and 50 us for the threads to meet,
    /// which is less from 1,000 particles on, after 0.225 s. Trials at 0.02, 0.14 and 0.36 s: the last one sees it.
    #[test]
    fn what_becomes_faster_is_soon_seen() {
        let mut pace = Pace::new();
        let (mut time, mut of_alone) = (0.0, 0.0);
        while time < 2.0 {
            let particles = 100.0 + 4000.0 * f64::min(time, 1.0);
            let way = pace.way();
            let step = match way {
                Way::Together => 5e-5 + 0.5e-7 * particles,
                Way::Alone => 1e-7 * particles,
            };
            pace.note(Duration::from_secs_f64(step), particles as u64);
            time += step;
            if way == Way::Alone && time > 0.5 {
                of_alone += step;
            }
        }
        assert!(of_alone < 0.1 * 1.5, "{of_alone} s");
    }

    /// A trial is made of a few steps and then of the rest, not of a few each time.
    #[test]
    fn a_trial_is_made_in_few_goes() {
        let mut pace = Pace::new();
        assert_eq!(pace.at_once(), AT_ONCE);
        pace.note(Duration::from_secs_f64(TRIAL / 100.0), AT_ONCE);
        assert!(pace.at_once().abs_diff(99 * AT_ONCE) <= 1);
        pace.note(Duration::from_secs_f64(TRIAL), pace.at_once());
        assert_eq!((pace.way(), pace.at_once()), (Way::Alone, AT_ONCE));
    }

    /// Of ways that take the same time the first stays.
    #[test]
    fn nothing_is_changed_for_nothing() {
        let mut pace = Pace::new();
        let share = share_alone(&mut pace, 5e-5, 4.9e-5);
        assert!(share < 0.04, "{share}");
    }
}
