//! The remaining time of a run, from the time of its last steps.

/// The cost of work, measured over the later part of the time spent on it: beds become denser, and the time of the first steps
/// is a poor estimate of that of the last ones.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Cost {
    /// Time (s) and work at two moments, each at least twice as late as the one before; then now.
    marks: [[f64; 2]; 2],
    now: [f64; 2],
}

impl Cost {
    /// Adds the work done and its time (s), both since the beginning.
    pub(super) fn note(&mut self, seconds: f64, work: f64) {
        self.now = [seconds, work];
        if seconds >= 2.0 * self.marks[1][0] {
            self.marks = [self.marks[1], self.now];
        }
    }

    /// Seconds per unit of work; 0 before any was seen.
    pub(super) fn per_work(&self) -> f64 {
        let [[seconds, work], _] = self.marks;
        let done = self.now[1] - work;
        if done > 0.0 {
            (self.now[0] - seconds) / done
        } else {
            0.0
        }
    }

    /// Seconds that so much more work takes.
    pub(super) fn left(&self, work: f64) -> f64 {
        work * self.per_work()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_work_takes_as_long_as_it_took() {
        let mut cost = Cost::default();
        assert_eq!(cost.left(1e9), 0.0);
        for k in 1..=40 {
            cost.note(0.5 * f64::from(k), 1000.0 * f64::from(k));
            assert_eq!(cost.per_work(), 0.5 / 1000.0, "after {k}");
        }
        assert_eq!(cost.left(3000.0), 1.5);
    }

    #[test]
    fn what_was_long_ago_counts_no_more() {
        // 10 s at 1 s each, then 30 s at 2 s each: after 40 s the last half has seen the later ones only.
        let mut cost = Cost::default();
        let (mut seconds, mut work) = (0.0, 0.0);
        for k in 0..25 {
            seconds += if k < 10 { 1.0 } else { 2.0 };
            work += 1.0;
            cost.note(seconds, work);
        }
        assert_eq!(seconds, 40.0);
        assert_eq!(cost.per_work(), 2.0);
    }
}
