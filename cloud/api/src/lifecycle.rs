//! How a run goes from state to state.
//!
//! Two pure functions: [`next`] says what the server does next about a run, given what it knows and sees; [`apply`] says
//! what an event makes of the run, or that it is not legal. The server executes what `next` says, records what happened
//! through `apply`, and looks again. Started anew after a crash it does the same, so there is no recovery apart.
//!
//! ```text
//! run:  queued → running → finished
//!          ↑        ├→ stopping → stopped ┐
//!          └────────┤   (resume, extend) ←┘
//!                   └→ failed · cancelled
//! ```

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::head::{Cause, Ending, Head, Phase};

/// State of a run, as its user sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum RunState {
    /// Waits for a free place, or for the next attempt.
    Queued,
    /// An attempt is on its way.
    Running,
    /// The attempt got the order to stop and has not ended yet.
    Stopping,
    /// Stopped by its user; can be resumed.
    Stopped,
    /// Came to its end; can be extended.
    Finished,
    /// Ended with an error, or used up its attempts; can be resumed.
    Failed,
    /// Given up by its user before it made a step.
    Cancelled,
}

impl RunState {
    /// All states.
    pub const ALL: [Self; 7] = [
        Self::Queued,
        Self::Running,
        Self::Stopping,
        Self::Stopped,
        Self::Finished,
        Self::Failed,
        Self::Cancelled,
    ];

    /// The word of it, as in answers and in the database.
    pub fn word(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Stopping => "stopping",
            Self::Stopped => "stopped",
            Self::Finished => "finished",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// The state of a word.
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.word() == word)
    }

    /// Whether the server has something to do about the run, now or later.
    pub fn is_live(self) -> bool {
        matches!(self, Self::Queued | Self::Running | Self::Stopping)
    }

    /// Whether an attempt is on its way.
    pub fn has_attempt(self) -> bool {
        matches!(self, Self::Running | Self::Stopping)
    }
}

/// Wish of the user for a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Wish {
    /// Go on to the end.
    #[default]
    Run,
    /// Stop with a checkpoint.
    Stop,
    /// End at once; what was made since the last commit is lost.
    Kill,
}

/// A run as its row in the database holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// State.
    pub state: RunState,
    /// Wish of the user.
    pub wish: Wish,
    /// Number of the attempt that was made last, 0 before the first.
    pub epoch: u64,
    /// The spec that counts.
    pub revision: u32,
    /// Whether the engine is known to have the job of this attempt.
    pub submitted: bool,
    /// Committed steps when the last attempt was closed.
    pub step: u64,
    /// Attempts in a row that did not move the committed step.
    pub barren: u32,
    /// No attempt before this instant, in s of the server's clock.
    pub not_before: f64,
}

impl Run {
    /// A run that was just submitted.
    pub fn new() -> Self {
        Self {
            state: RunState::Queued,
            wish: Wish::Run,
            epoch: 0,
            revision: 1,
            submitted: false,
            step: 0,
            barren: 0,
            not_before: 0.0,
        }
    }
}

impl Default for Run {
    fn default() -> Self {
        Self::new()
    }
}

/// State of a job, by the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobState {
    /// The engine gives no answer.
    Unknown,
    /// The engine has no such job (any more).
    Absent,
    /// It waits.
    Pending,
    /// It runs.
    Running,
}

/// A run as the server observes it.
#[derive(Clone, Copy, Debug)]
pub struct Observation<'a> {
    /// The head in the store; `None` while the store gives no answer.
    pub head: Option<&'a Head>,
    /// State of the job of the current epoch.
    pub job: JobState,
    /// For how long no sign of life has come, in s: since head, beat or the state of the job changed last, as this
    /// server saw it.
    pub silent: f64,
    /// For how long the current epoch has been submitted, in s, as this server knows.
    pub since_submit: f64,
    /// Whether the engine has capacity for another attempt.
    pub has_capacity: bool,
    /// The server's clock, in s.
    pub now: f64,
}

/// How patient the server is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Policy {
    /// Seconds between two beats of a worker.
    pub beat: f64,
    /// Attempts in a row that may fail to move the committed step.
    pub budget: u32,
    /// Wait after the first barren attempt, in s; doubled with each further one.
    pub first_wait: f64,
    /// The longest wait, in s.
    pub longest_wait: f64,
    /// How long an attempt may take from a stop to its end before the engine ends it, in s.
    pub stop_grace: f64,
}

impl Default for Policy {
    fn default() -> Self {
        Self {
            beat: 2.0,
            budget: 5,
            first_wait: 10.0,
            longest_wait: 600.0,
            stop_grace: 120.0,
        }
    }
}

impl Policy {
    /// Silent for so long, and gone by what the engine says: lost.
    pub fn lost_when_gone(&self) -> f64 {
        3.0 * self.beat
    }

    /// Silent for so long: lost, whatever the engine says.
    pub fn lost_when_silent(&self) -> f64 {
        10.0 * self.beat
    }

    /// Wait before the next attempt after `barren` ones in a row, in s.
    pub fn wait(&self, barren: u32) -> f64 {
        if barren == 0 {
            return 0.0;
        }
        (self.first_wait * f64::from(1u32 << (barren - 1).min(30))).min(self.longest_wait)
    }
}

/// Next action of the server for a run. Each may be repeated.
#[derive(Clone, Debug, PartialEq)]
pub enum Todo {
    /// Nothing at present.
    Nothing,
    /// Record [`RunEvent::Launched`]: another attempt.
    Launch,
    /// Swap the head to the run's epoch and revision, phase launched.
    Claim,
    /// Hand the job over to the engine, then record [`RunEvent::Submitted`].
    Submit,
    /// Write the wish into `control.json`.
    SendWish,
    /// Have the engine end the job, hard.
    Interrupt,
    /// Record [`RunEvent::Ended`] with this.
    Close(Ending),
}

/// Event of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum RunEvent {
    /// Another attempt was made.
    Launched,
    /// The engine has the job.
    Submitted,
    /// The attempt ended; with the committed step.
    Ended(Ending, u64),
    /// The user wants it to stop.
    Stop,
    /// The user wants it to end at once.
    Kill,
    /// The user wants it to go on.
    Resume,
    /// The user wants it to go on to a later end, by a further spec.
    Extend,
}

/// An event that does not fit to the state of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a run that is {} cannot {}", state.word(), what)]
pub struct Illegal {
    /// State of the run.
    pub state: RunState,
    /// The change that it refuses.
    pub what: &'static str,
}

/// Next action for `run`.
pub fn next(run: &Run, seen: &Observation, policy: &Policy) -> Todo {
    if !run.state.is_live() {
        return Todo::Nothing;
    }
    // The result lies in the store. Without the store nothing is declared dead, and nothing is begun.
    let Some(head) = seen.head else {
        return Todo::Nothing;
    };
    let ending = head.ending.as_ref().filter(|_| head.phase == Phase::Ended);

    if run.state == RunState::Queued {
        // A worker that was given up may have come to the end after all.
        if let Some(ending) = ending
            && ending.cause == Cause::Finished
            && head.revision == run.revision
            && head.epoch == run.epoch
            && run.epoch > 0
        {
            return Todo::Close(ending.clone());
        }
        return if seen.has_capacity && seen.now >= run.not_before {
            Todo::Launch
        } else {
            Todo::Nothing
        };
    }

    if head.epoch < run.epoch {
        if run.wish != Wish::Run {
            // Nothing was begun yet: there is nothing to stop.
            return Todo::Close(ended(
                Cause::User,
                "stopped before it was handed to the engine",
            ));
        }
        if let Some(ending) = ending
            && ending.cause == Cause::Finished
            && head.revision == run.revision
        {
            return Todo::Close(ending.clone());
        }
        return Todo::Claim;
    }
    if let Some(ending) = ending {
        return Todo::Close(ending.clone());
    }
    let gone = seen.job == JobState::Absent;
    // Of an attempt that its user wanted to end, that is the cause.
    let lost = match run.wish {
        Wish::Run => Cause::Lost,
        Wish::Stop | Wish::Kill => Cause::User,
    };
    match head.phase {
        Phase::Launched if !run.submitted && gone => {
            if run.wish != Wish::Run {
                return Todo::Close(ended(
                    Cause::User,
                    "stopped before it was handed to the engine",
                ));
            }
            Todo::Submit
        }
        // Known to the engine, but not recorded: adopted.
        Phase::Launched if !run.submitted && seen.job != JobState::Unknown => Todo::Submit,
        Phase::Launched if gone && run.wish != Wish::Run => {
            Todo::Close(ended(Cause::User, "stopped before it began to work"))
        }
        Phase::Launched if gone && seen.since_submit > policy.lost_when_gone() => {
            Todo::Close(ended(
                Cause::Engine,
                "the engine ended the job before it began to work",
            ))
        }
        Phase::Launched
            if seen.job == JobState::Running && seen.silent > policy.lost_when_silent() =>
        {
            Todo::Close(ended(
                lost,
                "the worker was started and gave no sign of life",
            ))
        }
        Phase::Launched if run.wish != Wish::Run && seen.job != JobState::Unknown => {
            Todo::Interrupt
        }
        Phase::Running if gone && seen.silent > policy.lost_when_gone() => Todo::Close(ended(
            lost,
            "no sign of life, and the engine has no such job any more",
        )),
        Phase::Running if seen.silent > policy.lost_when_silent() => {
            Todo::Close(ended(lost, "no sign of life"))
        }
        _ if run.wish != Wish::Run => Todo::SendWish,
        _ => Todo::Nothing,
    }
}

fn ended(cause: Cause, message: &str) -> Ending {
    Ending {
        cause,
        code: None,
        message: message.to_owned(),
    }
}

/// `run` after `event` at the instant `now` (s).
pub fn apply(run: &Run, event: &RunEvent, policy: &Policy, now: f64) -> Result<Run, Illegal> {
    use RunState::{Cancelled, Failed, Finished, Queued, Running, Stopped, Stopping};
    let mut after = *run;
    let illegal = |what| {
        Err(Illegal {
            state: run.state,
            what,
        })
    };
    match event {
        RunEvent::Launched => {
            if run.state != Queued {
                return illegal("begin another attempt");
            }
            after.state = Running;
            after.epoch += 1;
            after.submitted = false;
        }
        RunEvent::Submitted => {
            if !run.state.has_attempt() {
                return illegal("be handed to the engine");
            }
            after.submitted = true;
        }
        RunEvent::Ended(ending, step) => {
            if !run.state.is_live() {
                return illegal("end");
            }
            let moved = *step > run.step;
            after.step = run.step.max(*step);
            after.barren = if moved { 0 } else { run.barren + 1 };
            after.state = match ending.cause {
                Cause::Finished => Finished,
                // A wish to stop is fulfilled by any end that leaves something to resume.
                _ if run.wish != Wish::Run
                    && (ending.cause == Cause::User || ending.cause.tries_again()) =>
                {
                    Stopped
                }
                Cause::User => Stopped,
                cause if cause.tries_again() && after.barren < policy.budget => {
                    after.not_before = now + policy.wait(after.barren);
                    Queued
                }
                _ => Failed,
            };
            if after.state != Queued {
                after.wish = Wish::Run;
            }
        }
        RunEvent::Stop | RunEvent::Kill => {
            let wish = if *event == RunEvent::Kill {
                Wish::Kill
            } else {
                Wish::Stop
            };
            match run.state {
                Queued if run.epoch == 0 => after.state = Cancelled,
                Queued => after.state = Stopped,
                Running => {
                    after.state = Stopping;
                    after.wish = wish;
                }
                // A stop does not soften a kill.
                Stopping if run.wish != Wish::Kill => after.wish = wish,
                Stopping => {}
                _ => return illegal("be stopped"),
            }
        }
        RunEvent::Resume => {
            if !matches!(run.state, Stopped | Failed | Cancelled) {
                return illegal("be resumed");
            }
            after.state = Queued;
            after.barren = 0;
            after.not_before = now;
        }
        RunEvent::Extend => {
            if !matches!(run.state, Stopped | Finished | Failed | Cancelled) {
                return illegal("be extended before it has ended");
            }
            after.state = Queued;
            after.revision += 1;
            after.barren = 0;
            after.not_before = now;
        }
    }
    Ok(after)
}

#[cfg(test)]
mod tests;
