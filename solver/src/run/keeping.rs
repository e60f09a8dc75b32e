//! Checkpoints while a run goes on.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

use mercury_engine::state::Encoder;

use super::{Ending, Run, checkpoint};
use crate::output::ToWrite;
use crate::plan::{POSITIONS, checkpoint_paths};

/// From so many on a checkpoint takes tens of megabytes.
const MANY_ROWS: usize = 100_000;

impl Run {
    /// Allocates the memory of checkpoints before the first step, where there is so much of it that the system takes longer to
    /// provide it than it takes to fill it, and the steps would have to wait.
    pub(super) fn prepare_checkpoints(&self) {
        let many = self.engine.particles.len() > MANY_ROWS;
        if let Some(checkpoints) = self.options.checkpoints.as_ref().filter(|_| many)
            && checkpoints.every.is_some()
        {
            self.writer
                .lend_memory(checkpoint::encode(self, &checkpoints.scene));
        }
    }

    /// Writes a checkpoint if one is due at the end of this step. False if the writer has given up.
    pub(super) fn keep_checkpoints(&mut self, step: u64) -> bool {
        let is_due = self.schedule.is_checkpoint_due(step);
        let Some(checkpoints) = &self.options.checkpoints else {
            return true;
        };
        let is_asked = checkpoints.now.swap(false, Ordering::Relaxed);
        let waited = self.last_checkpoint.elapsed();
        let is_time = checkpoints.every.is_some_and(|every| waited >= every);
        let is_wanted = match self.ended {
            None => is_due || is_asked || is_time,
            Some(Ending::Stopped(_)) => true,
            Some(_) => checkpoints.at_end,
        };
        if !is_wanted {
            return true;
        }
        let Some((path, state)) = self.next_checkpoint() else {
            return true;
        };
        if matches!(
            self.ended,
            Some(Ending::Planned | Ending::AtRest | Ending::Worn | Ending::Known)
        ) {
            // It is written last: its presence means that everything is done. The outputs have less now than they will have then.
            let mut state = state;
            let Some((positions, outputs)) = self.writer.reported() else {
                return false;
            };
            state.section(POSITIONS, &positions);
            self.at_end = Some((self.to_write(path, state), outputs));
            return true;
        }
        self.writer.write_checkpoint(self.to_write(path, state))
    }

    /// Writes a checkpoint of now, whatever the schedule; a run without [`RunOptions::checkpoints`](super::RunOptions::checkpoints) writes none. False if the writer has
    /// given up: [`Self::finish`] returns the reason.
    pub fn write_checkpoint(&mut self) -> bool {
        let Some((path, state)) = self.next_checkpoint() else {
            return true;
        };
        self.writer.write_checkpoint(self.to_write(path, state))
    }

    /// The state of now, and the file for it; `None` for a run without checkpoints.
    pub(super) fn next_checkpoint(&mut self) -> Option<(PathBuf, Encoder)> {
        let since = Instant::now();
        self.engine.collect(true);
        let state = checkpoint::encode(self, &self.options.checkpoints.as_ref()?.scene);
        self.checkpoints_made.0 += 1;
        self.checkpoints_made.1 += since.elapsed();
        let files = checkpoint_paths(&self.options.folder, self.plan.outputs().prefix());
        let path = files.into_iter().nth(self.next_file)?;
        self.next_file = 1 - self.next_file;
        self.last_checkpoint = Instant::now();
        Some((path, state))
    }

    /// A checkpoint of now.
    pub(super) fn to_write(&self, path: PathBuf, state: Encoder) -> ToWrite {
        ToWrite {
            path,
            step: self.engine.steps(),
            time: self.engine.time(),
            state,
        }
    }
}
