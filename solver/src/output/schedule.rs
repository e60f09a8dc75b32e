//! When something is written.

/// The steps at which something is written every `interval`: the first step with t >= m `interval` for each whole m > 0, with
/// 1e-6 of a step of slack for round-off. The start and the end are the caller's business.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// Steps between two events; not a whole number in general.
    stride: f64,
    /// The event to come, m.
    next: u64,
}

impl Schedule {
    /// Every `interval` (s) of a run in steps of `time_step` (s).
    #[must_use]
    pub fn new(interval: f64, time_step: f64) -> Self {
        Self {
            stride: interval / time_step,
            next: 1,
        }
    }

    /// Whether something is due at the end of this step. Steps are asked about in order, once each.
    pub fn is_due(&mut self, step: u64) -> bool {
        if self.stride <= 1e-6 {
            return true;
        }
        let passed = |next: u64| self.stride * next as f64 - 1e-6 <= step as f64;
        let due = passed(self.next);
        if due {
            // Several events within one step are one.
            let mut next = (self.next + 1).max((step as f64 / self.stride) as u64);
            while passed(next) {
                next += 1;
            }
            self.next = next;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn due(interval: f64, time_step: f64, steps: u64) -> Vec<u64> {
        let mut schedule = Schedule::new(interval, time_step);
        (1..=steps).filter(|&step| schedule.is_due(step)).collect()
    }

    #[test]
    fn the_first_step_at_or_after_each_multiple() {
        assert_eq!(
            due(0.3, 0.1, 9),
            [3, 6, 9],
            "0.3 is no multiple of 0.1 in binary"
        );
        assert_eq!(due(0.25, 0.1, 10), [3, 5, 8, 10]);
        assert_eq!(due(f64::INFINITY, 0.1, 10), [0u64; 0]);
    }

    #[test]
    fn an_interval_below_the_step_is_every_step() {
        assert_eq!(due(0.04, 0.1, 5), [1, 2, 3, 4, 5]);
        assert_eq!(due(1e-300, 0.1, 3), [1, 2, 3]);
    }

    #[test]
    fn round_off_never_delays_an_event() {
        // 10^6 steps of 1e-5 s and frames every 0.01 s: 1000 steps each, although 0.01 / 1e-5 is not exact.
        let steps = due(0.01, 1e-5, 1_000_000);
        assert_eq!(steps.len(), 1000);
        assert!(steps.iter().zip(1..).all(|(&step, m)| step == 1000 * m));
    }
}
