//! `--check --trial`: an estimate of a run's time from its first seconds.

use std::sync::Arc;
use std::time::Duration;

use crate::plan::Plan;
use crate::run::{RunOptions, Trial, trial};
use mercury_common::cli::{self, Failure};

use super::run::{How, Requests};
use super::waiting::Waiting;

/// Default duration of a trial.
pub(crate) const LASTS: &str = "5s";

/// Duration of a trial, for `value_parser`.
pub(crate) fn lasts(text: &str) -> Result<Duration, String> {
    cli::duration(text).map_err(|problem| match text.ends_with(".toml") {
        true => {
            format!("{problem}; put the scene in front of --trial, or write --trial={LASTS} {text}")
        }
        false => problem,
    })
}

/// Makes the trial. Nothing is written, and no folder is read.
///
/// # Errors
/// If its steps fail, or it is stopped before it has a result.
pub(crate) fn execute(
    plan: Plan,
    how: &How,
    limit: Duration,
    quiet: bool,
) -> Result<Trial, Failure> {
    let requests = Requests::listen()?;
    let task_progress = requests.task_progress();
    // It has nothing to keep, so the program ends at once when it is stopped.
    let waiting = Waiting::begin(&task_progress, None, quiet)?;
    let threads = how.threads_for(&plan);
    let options = RunOptions {
        threads,
        fewer_where_faster: !how.fixed_threads,
        width: how.width,
        stop: requests.stop,
        task_progress: Arc::clone(&task_progress),
        ..RunOptions::default()
    };
    let made = trial(plan, &options, limit);
    drop(waiting);
    let made = made.map_err(|error| Failure::run(format!("the trial failed: {error}")))?;
    made.ok_or_else(|| ended("before its first step"))
}

/// The end of a trial that was stopped; nothing is left of it.
pub(crate) fn ended(when: &str) -> Failure {
    Failure::new(
        cli::Exit::AtOnce,
        format!("the trial was ended {when}; nothing was written"),
    )
}
