//! Events that are still to come in a run.

use std::fmt;

use mercury_common::readable::rounded;

use super::Physics;
use crate::walls::Wall;

/// Something that a scene begins or ends at a given time.
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduledChange {
    /// When, s.
    pub time: f64,
    /// The wall that appears, disappears, or begins or ceases to move.
    pub wall: String,
}

impl fmt::Display for ScheduledChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (wall, time) = (&self.wall, rounded(self.time, 12));
        write!(f, "what wall `{wall}` does at t = {time} s")
    }
}

impl Physics {
    /// The last time at which a wall appears, disappears, or begins or ceases to move; `None` if nothing of that kind happens
    /// after the start.
    #[must_use]
    pub fn last_event(&self) -> Option<ScheduledChange> {
        let events = self.walls.iter().map(|wall| ScheduledChange {
            time: last_event(wall),
            wall: wall.name.clone(),
        });
        events
            .filter(|event| event.time > 0.0)
            .max_by(|a, b| a.time.total_cmp(&b.time))
    }
}

/// The last time at which a wall changes its behaviour, s; 0 if never.
fn last_event(wall: &Wall) -> f64 {
    let times = wall.motion.events().chain([wall.from, wall.until]);
    times.filter(|time| time.is_finite()).fold(0.0, f64::max)
}
