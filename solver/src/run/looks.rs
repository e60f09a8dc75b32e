//! Looks at the results that end a run.

use std::path::Path;

use mercury_common::run_tables::RESULTS;
use mercury_common::whole_file::write_whole;
use mercury_engine::task::RunEvent;

use super::Run;
use super::checkpoint::Checkpoint;
use crate::output::{OutputError, Schedule};
use crate::plan::Plan;
use crate::results::Aims;

/// Writes the table of looks as a whole: a run that goes on has made its looks again.
pub(super) fn write_results(folder: &Path, prefix: &str, aims: &Aims) -> Result<(), OutputError> {
    let path = folder.join(format!("{prefix}.{}", RESULTS.file));
    write_whole(&path, &aims.table()).map_err(OutputError::from)
}

/// Times (s) of the rows that a run has written by a step, the start included.
pub(super) fn rows_until(plan: &Plan, step: u64) -> impl Iterator<Item = f64> {
    let dt = plan.physics().time_step;
    let mut past = Schedule::behind(plan.outputs().files(), dt, 0);
    let mut last = 0;
    let steps = std::iter::from_fn(move || {
        loop {
            last = past.next_step().max(last + 1);
            if last > step {
                return None;
            }
            if past.due(last).rows {
                return Some(last);
            }
            let _ = (past.is_checkpoint_due(last), past.is_link_due(last));
        }
    });
    std::iter::once(0)
        .chain(steps)
        .map(move |step| step as f64 * dt)
}

/// Whether the run of a checkpoint has come to its end: as planned, or with the results that end it.
#[must_use]
pub fn is_over(from: &Checkpoint, plan: &Plan, folder: &Path, until: Option<&Aims>) -> bool {
    let is_known = |until: &Aims| {
        let mut aims = until.clone();
        let times = rows_until(plan, from.head.step);
        aims.replay(folder, plan.outputs().prefix(), times);
        aims.have_ended(from.head.time(), plan.physics().time_step)
    };
    from.is_at_end(plan) || until.is_some_and(is_known)
}

impl Run {
    /// Looks at the results that end the run, if they are due at the row of now: where they are known, the next step is the last. False if
    /// the writer has given up.
    pub(super) fn look_at_results(&mut self) -> bool {
        let time = self.engine.time();
        let Some(aims) = &mut self.aims else {
            return true;
        };
        if !aims.count_row(time) {
            return true;
        }
        // Its answer comes when all rows are written.
        if self.writer.positions().is_none() {
            return false;
        }
        let (folder, prefix) = (&self.options.folder, self.plan.outputs().prefix());
        for found in aims.look(folder, prefix, time) {
            let event = RunEvent::Result(found.clone());
            self.options.task_progress.report(event);
        }
        // It is written again at the end, and an error reported.
        let _ = write_results(folder, prefix, aims);
        true
    }
}
