//! Tables of a run between two steps.

use mercury_common::frames::{ColumnSpec, Frame, Table as _};

use super::{Run, RunFailure};
use crate::output::summary::ResultValue;
use crate::output::{Due, FrameCopy, contact_table, particle_table, wall_table};
use crate::results::NamedResult;

/// Columns of one length, and what they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Names and units of the columns.
    pub specs: Vec<ColumnSpec>,
    /// Time, step and values.
    pub frame: Frame,
}

impl Run {
    /// A copy of the present state, with what was observed in its step.
    fn state(&mut self) -> Result<FrameCopy, RunFailure> {
        self.engine.complete_step()?;
        // Nothing is due, so that no sum is moved out of the engine.
        let mut state = FrameCopy::take(&mut self.engine, Due::default(), &self.at_start);
        state.observation = self.observed.clone().unwrap_or_default();
        Ok(state.in_order_of_ids(&self.plan.physics().cell))
    }

    /// The particles now, in the order of their ids: columns of `.particles.arrow`.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn particles(&mut self) -> Result<Rows, RunFailure> {
        let state = self.state()?;
        let (specs, frame) = particle_table(&self.plan, &state);
        Ok(Rows {
            specs,
            frame: frame.into_frame(),
        })
    }

    /// The contacts now: columns of `.contacts.arrow`. `None` if this step was not observed: behind a pause, or a run that was resumed and has
    /// made no step.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn contacts(&mut self) -> Result<Option<Rows>, RunFailure> {
        if self.observed.is_none() {
            return Ok(None);
        }
        let state = self.state()?;
        let (specs, frame) = contact_table(&self.plan, &self.engine.history_columns(), &state);
        Ok(Some(Rows {
            specs,
            frame: frame.into_frame(),
        }))
    }

    /// The walls now, a row each: columns of `.walls.csv`. `None` as for [`Self::contacts`].
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn walls(&mut self) -> Result<Option<Rows>, RunFailure> {
        if self.observed.is_none() {
            return Ok(None);
        }
        let state = self.state()?;
        let (specs, frame) = wall_table(&self.plan, &state);
        Ok(Some(Rows { specs, frame }))
    }

    /// Value and error of a result from the rows that were written until now. `None` if the writer has given up: [`Self::finish`] returns the
    /// reason.
    #[must_use]
    pub fn result(&self, result: &NamedResult) -> Option<ResultValue> {
        // Its answer comes when all rows are written.
        self.writer.positions()?;
        let settled = Some(self.plan.settled().time);
        Some(result.read(&self.options.folder, self.plan.outputs().prefix(), settled))
    }
}
