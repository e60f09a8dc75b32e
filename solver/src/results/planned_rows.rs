//! How many rows a plan writes in the window of a result.

use mercury_common::readable::{rounded, significant};
use mercury_common::statistics::FIRST_LOOK;

use super::NamedResult;
use super::grammar::Source;
use crate::plan::Plan;

/// Rows behind which an error is as good as it gets.
const ENOUGH: u64 = 256;

/// Rows in the window of a result with an error, as planned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedRows {
    count: u64,
    /// Time between two of them, s, and its key.
    interval: f64,
    key: &'static str,
    /// First and last time of the window, s.
    window: [f64; 2],
    /// Of the run, s.
    time_step: f64,
}

impl PlannedRows {
    /// Those of a result in the run of a plan; `None` where one run gives no error.
    #[must_use]
    pub fn of(result: &NamedResult, plan: &Plan) -> Option<Self> {
        result.has_error().ok()?;
        let files = plan.outputs().files();
        let (interval, key) = match &result.source {
            Source::Rows { table, .. } if table.name() == "track" => {
                (files.track_interval, "output.track_interval")
            }
            _ => (files.rows_interval, "output.rows_interval"),
        };
        let time_step = plan.physics().time_step;
        let end = plan.physics().steps as f64 * time_step;
        let from = result.begin(plan.settled().time).max(0.0);
        let to = result.window.times.1.min(end);
        // Rows stand at multiples of the interval, with the slack of the schedule.
        let interval = interval.max(time_step);
        let before = |time: f64, slack: f64| ((time + slack * time_step) / interval).floor();
        let count = match from <= to {
            true => before(to, 1e-6) - before(from, -1e-6),
            false => 0.0,
        };
        Some(Self {
            count: count as u64,
            interval,
            key,
            window: [from, to],
            time_step,
        })
    }

    /// Time between two rows, s.
    #[must_use]
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// The warning that they are few.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        (self.count < ENOUGH).then(|| {
            let good = format!("an error is good from {ENOUGH} on");
            format!("{}: {}", self.found(&good), self.help())
        })
    }

    /// Why they can never end a run, and the help behind it.
    #[must_use]
    pub(super) fn too_few(&self) -> Option<(String, String)> {
        (self.count < FIRST_LOOK).then(|| {
            let needed = format!("an error that ends the run needs {FIRST_LOOK}");
            (self.found(&needed), self.help())
        })
    }

    fn found(&self, needed: &str) -> String {
        let [from, to] = self.window.map(|time| rounded(time, 6));
        format!("{} rows lie in {from}..{to} s, {needed}", self.count)
    }

    fn help(&self) -> String {
        // One digit of it is at most a third too long.
        let interval = (self.window[1] - self.window[0]) / (1.4 * ENOUGH as f64);
        match interval > self.time_step {
            true => format!("{} = {}", self.key, significant(interval, 1)),
            false => "let the window be longer".to_owned(),
        }
    }
}
