//! Steps in which a great many particles are placed: a request to stop does not wait for their end.
//!
//! The state before such a step is kept. If the run is stopped during the step, the step is given up, and the run returns to that
//! state: its checkpoint is the one that a stop before the step would have left, and a resumed run ends in the same bytes.

use std::sync::Arc;
use std::time::Instant;

use super::{Ending, Run, RunFailure, StopReason};
use crate::plan::Plan;
use mercury_engine::boundaries::expected_number;
use mercury_engine::step::{Engine, RunError, Snapshot};

/// Placing fewer takes too short a time to be interrupted.
const MANY: f64 = 20_000.0;

/// A step in which an insertion begins that places many particles at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LongStep {
    pub(super) step: u64,
    /// Expected number of particles, as far as that is known; else 0.
    pub(super) expected: u64,
}

/// Long steps of a plan. An insertion at a rate places few at a time, whatever its total.
pub(super) fn long_steps(plan: &Plan) -> Vec<LongStep> {
    let physics = plan.physics();
    let densities: Vec<f64> = (physics.materials.iter())
        .map(|material| material.density)
        .collect();
    let at_once = (physics.insertions.iter()).filter(|insertion| insertion.rate.is_none());
    let mut found: Vec<LongStep> = Vec::new();
    for insertion in at_once {
        let expected = expected_number(insertion, &densities, physics.dimensions);
        if expected.is_some_and(|number| number < MANY) {
            continue;
        }
        // With the slack that the insertion itself has.
        let step = (insertion.from / physics.time_step - 1e-6).ceil().max(0.0) as u64;
        let expected = expected.unwrap_or(0.0) as u64;
        match found.iter_mut().find(|known| known.step == step) {
            Some(known) if known.expected > 0 && expected > 0 => known.expected += expected,
            Some(known) => known.expected = 0,
            None => found.push(LongStep { step, expected }),
        }
    }
    found.sort_by_key(|long| long.step);
    found
}

/// The next of them after so many steps.
pub(super) fn next_long_step(long_steps: &[LongStep], made: u64) -> Option<LongStep> {
    long_steps.iter().find(|long| long.step > made).copied()
}

impl Run {
    /// Makes the next step, which may be long: gives it up on a request to stop. False if the writer has given up.
    pub(super) fn make_long_step(
        &mut self,
        long: LongStep,
        stopping: Option<StopReason>,
    ) -> Result<bool, RunFailure> {
        use mercury_engine::task::Task;
        let task_progress = Arc::clone(&self.options.task_progress);
        if self.engine.is_divided() {
            // Other ranks would not go back.
            return self.advance_a_bit(long.step, stopping);
        }
        let since = Instant::now();
        let (before, steps) = (self.engine.snapshot(), self.engine.steps());
        task_progress.expect(long.expected);
        task_progress.may_give_up(true);
        task_progress.begin(Task::Inserting);
        let made = self.advance_a_bit(long.step, stopping);
        task_progress.may_give_up(false);
        task_progress.begin(Task::Stepping);
        self.inserting += since.elapsed();
        match made {
            Err(RunFailure::Engine(RunError::GivenUp)) => self.go_back(before, steps),
            made => made,
        }
    }

    /// Ends the run in a state of before.
    fn go_back(&mut self, before: Snapshot, steps: u64) -> Result<bool, RunFailure> {
        let options = self.options.start(&self.schedule);
        self.engine = Engine::resume(Arc::clone(&self.plan), before, options)?;
        self.ended = Some(Ending::Stopped(StopReason::Request));
        self.keep_checkpoints(steps)
    }
}
