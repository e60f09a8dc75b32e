//! The state in which a run failed.

use super::Run;
use crate::output::{Due, FrameCopy};
use mercury_engine::forces::Watch;
use mercury_engine::step::RunError;

impl Run {
    /// Writes the state in which a run failed, for inspection; a checkpoint too, where the run can go on with another limit.
    pub(super) fn show(&mut self, error: &RunError) {
        let everything = self.schedule.everything();
        let watch = Watch {
            records: everything.needs_records(),
            audit: None,
        };
        let due = match error {
            // The other ranks are at the end of the run already.
            _ if self.engine.is_divided() => return,
            RunError::Guarded { .. } | RunError::Droplets { .. }
                if self.engine.step_to_look_at(watch).is_ok() =>
            {
                everything
            }
            // Contacts of a particle that is not finite cannot be found.
            RunError::Guarded { .. } | RunError::Droplets { .. } | RunError::NotFinite { .. } => {
                Due {
                    frame: true,
                    ..Due::default()
                }
            }
            _ => return,
        };
        // If the writer has given up, the caller learns the reason from the error itself.
        let _ = self
            .writer
            .send(FrameCopy::take(&mut self.engine, due, &self.at_start));
        if matches!(error, RunError::Droplets { .. }) {
            let _ = self.write_checkpoint();
        }
    }
}
