//! Checkpoints while a run goes on.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

use mercury_engine::state::Encoder;

use super::{Ending, Run, RunFailure, checkpoint};
use crate::output::{ToWrite, chain};
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
            self.writer.lend_memory(checkpoint::encode(self));
        }
    }

    /// Makes a link of the chain and writes a checkpoint, if they are due at the end of this step. False if the writer has given up.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub(super) fn keep_checkpoints(&mut self, step: u64) -> Result<bool, RunFailure> {
        let is_due = self.schedule.is_checkpoint_due(step);
        let has_chain = self.options.chain.is_some();
        let is_link = self.schedule.is_link_due(step) && has_chain;
        let is_end = !matches!(self.ended, None | Some(Ending::Stopped(_)));
        if is_link || is_end && has_chain {
            // So that the state does not depend on when other outputs are due.
            self.engine.complete_step()?;
        }
        let waited = self.last_checkpoint.elapsed();
        let is_wanted = self
            .options
            .checkpoints
            .as_ref()
            .is_some_and(|checkpoints| {
                let is_asked = checkpoints.now.swap(false, Ordering::Relaxed);
                let is_time = checkpoints.every.is_some_and(|every| waited >= every);
                match self.ended {
                    None => is_due || is_asked || is_time,
                    Some(Ending::Stopped(_)) => true,
                    Some(_) => checkpoints.at_end,
                }
            });
        if !is_end {
            if !is_wanted && !is_link {
                return Ok(true);
            }
            let (path, state) = self.encode(is_wanted);
            let checkpoint = self.to_write(path, state, is_link);
            self.sent += u64::from(is_link);
            return Ok(self.writer.write_checkpoint(checkpoint));
        }
        if is_link {
            let (_, state) = self.encode(false);
            let link = self.to_write(None, state, true);
            self.sent += 1;
            if !self.writer.write_checkpoint(link) {
                return Ok(false);
            }
        }
        if !is_wanted && !has_chain {
            return Ok(true);
        }
        let (path, mut state) = self.encode(is_wanted);
        self.end_state = has_chain.then(|| chain::sum_of(&state));
        if path.is_some() {
            // It is written last: its presence means that everything is done. The outputs have less now than they will have then.
            let Some((positions, outputs)) = self.writer.reported() else {
                return Ok(false);
            };
            state.section(POSITIONS, &positions);
            self.at_end = Some((self.to_write(path, state, false), outputs));
        }
        Ok(true)
    }

    /// Writes a checkpoint of now, whatever the schedule; a run without [`RunOptions::checkpoints`](super::RunOptions::checkpoints) writes none. False if the writer has
    /// given up: [`Self::finish`] returns the reason.
    pub fn write_checkpoint(&mut self) -> bool {
        if self.options.checkpoints.is_none() {
            return true;
        }
        let (path, state) = self.encode(true);
        self.writer
            .write_checkpoint(self.to_write(path, state, false))
    }

    /// The state of now, and the file for its checkpoint if that `is_wanted`.
    fn encode(&mut self, is_wanted: bool) -> (Option<PathBuf>, Encoder) {
        let since = Instant::now();
        self.engine.collect(true);
        let state = checkpoint::encode(self);
        if !is_wanted {
            return (None, state);
        }
        self.checkpoints_made.0 += 1;
        self.checkpoints_made.1 += since.elapsed();
        let files = checkpoint_paths(&self.options.folder, self.plan.outputs().prefix());
        let path = files.into_iter().nth(self.next_file);
        self.next_file = 1 - self.next_file;
        self.last_checkpoint = Instant::now();
        (path, state)
    }

    /// A checkpoint of now, a link, or both.
    pub(super) fn to_write(&self, path: Option<PathBuf>, state: Encoder, is_link: bool) -> ToWrite {
        ToWrite {
            path,
            is_link,
            step: self.engine.steps(),
            time: self.engine.time(),
            state,
        }
    }
}
