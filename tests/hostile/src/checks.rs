//! Checks of how a reader takes a file, and their faults.

use std::fmt::Display;
use std::time::{Duration, Instant};

/// No message is longer, in bytes: fifty mistakes of two thousand each.
pub const LONGEST_MESSAGE: usize = 100_000;

/// Makes the words of an error.
///
/// # Panics
/// If they are none, or fill more than some screens.
pub fn say(error: &impl Display) {
    let text = error.to_string();
    assert!(!text.is_empty(), "an error without words");
    assert!(
        text.len() <= LONGEST_MESSAGE,
        "a message of {} bytes: {}...",
        text.len(),
        text.chars().take(200).collect::<String>()
    );
}

/// Makes the words of an error, if it is one; what was read is dropped.
pub fn said<T, E: Display>(result: Result<T, E>) -> Option<T> {
    result.map_err(|error| say(&error)).ok()
}

/// Bound of the memory that a reader may allocate at once, in bytes: `base + per_byte * size`.
#[derive(Debug, Clone, Copy)]
pub struct Bound {
    /// Bytes for any file.
    pub base: u64,
    /// Bytes for each byte of it.
    pub per_byte: u64,
}

impl Bound {
    /// The most for a file of this size.
    #[must_use]
    pub fn of(&self, size: u64) -> u64 {
        self.base + self.per_byte.saturating_mul(size)
    }
}

/// The most time that a file of this size may take at `opt-level` 1. A reader of linear time takes a hundredth of it; one of quadratic time
/// exceeds it at some hundred kilobytes.
///
/// The base is twice the most that a short scene takes: its plan compares a wall that moves through an insertion at 1,024 times with 256
/// places (`solver/src/plan/closing.rs`), which is 1 s for a mesh at 4 us each.
#[must_use]
pub fn longest(size: u64) -> Duration {
    Duration::from_millis(2000) + Duration::from_micros(6) * u32::try_from(size).unwrap_or(u32::MAX)
}

/// Time that this thread has computed, so that what else the machine does counts little; by the clock where the system does not
/// report it.
pub struct Stopwatch {
    clock: Instant,
    computed: Option<u64>,
}

impl Stopwatch {
    /// From now on.
    #[must_use]
    pub fn start() -> Self {
        Self {
            clock: Instant::now(),
            computed: computed(),
        }
    }

    /// Time since the start.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        match (self.computed, computed()) {
            (Some(begin), Some(end)) => Duration::from_nanos(end.saturating_sub(begin)),
            _ => self.clock.elapsed(),
        }
    }
}

/// ns
fn computed() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_ascii_whitespace().next()?.parse().ok()
}
