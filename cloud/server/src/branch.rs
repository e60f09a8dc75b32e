//! Runs that branch off from another one. The solver says before whether it can.

use std::sync::Arc;

use axum::http::StatusCode;
use cloud_api::requests::BranchOff;
use cloud_api::{Branch, RunState};
use serde_json::Value;

use crate::access::ApiError;
use crate::check::{PATIENCE, solve};
use crate::runs::{VisibleRun, blocking, like, plan, submit, visible_run};
use crate::secrets::{Caller, User};
use crate::state::App;
use crate::verify::{RUN, lay_out_run};

/// Submits a run that branches off from another one.
pub(crate) async fn branch(
    app: &Arc<App>,
    user: &User,
    id: &str,
    body: BranchOff,
) -> Result<String, ApiError> {
    let BranchOff { at, set, title } = body;
    let (run, mut new, planned) = {
        let _turn = app.checks.take((user.id, false)).await?;
        let (app, user, id, set) = (Arc::clone(app), user.clone(), id.to_owned(), set.clone());
        blocking(move || {
            let run = visible_run(&app, &Caller::User(user.clone()), &id)?;
            if !matches!(run.row.state, RunState::Finished | RunState::Stopped) {
                let detail = "Stop the run first, or wait for its end.";
                let title = "not in this state";
                return Err(ApiError::new(StatusCode::CONFLICT, title, detail));
            }
            if !at.is_finite() || at <= 0.0 || at > run.row.time {
                let detail = format!("The run was made from 0 to {} s.", run.row.time);
                return Err(ApiError::bad_request("invalid time", detail));
            }
            let planned = planned(&app, &run, at, &set)?;
            Ok((run.id.clone(), like(&app, &user, run)?, planned))
        })
        .await?
    };
    new.scene.set.extend(set.iter().cloned());
    let alone = plan(app, user, &new.scene).await?;
    let step = |plan: &Value| plan["time"]["step"].as_f64();
    let (Some(step_of_run), Some(own)) = (step(&planned), step(&alone)) else {
        return Err(too_large());
    };
    let mut set = set;
    // A branch keeps the step of its run.
    if step_of_run.to_bits() != own.to_bits() {
        let step = format!("time.step={step_of_run:?}");
        new.scene.set.push(step.clone());
        set.push(step);
    }
    if title.is_some() {
        new.title = title;
    }
    // It begins in one process.
    new.ranks = 1;
    submit(app, user, new, None, Some(Branch { run, at, set })).await
}

fn too_large() -> ApiError {
    let detail = "A scene that is too large for a check cannot branch off here.";
    ApiError::bad_request("too large", detail)
}

/// Whether a file of a run states its scene or its chain: a branch is planned from these alone.
fn states_the_run(name: &str) -> bool {
    ["plan.toml", "summary.json"].contains(&name)
        || [".scene.toml", ".scene.json", ".chain.jsonl"]
            .iter()
            .any(|end| name.ends_with(end))
}

/// The plan of a branch, or the problems because of which there is none.
fn planned(app: &App, run: &VisibleRun, at: f64, set: &[String]) -> Result<Value, ApiError> {
    let head = app.head(&run.id)?.unwrap_or_default();
    let folder = lay_out_run(app, run, &head, states_the_run)?;
    let mut arguments = ["--from", RUN, "--output", ".branch", "--check", "--json"]
        .map(str::to_owned)
        .to_vec();
    arguments.push(format!("--at={at}"));
    arguments.extend(set.iter().map(|set| format!("--set={set}")));
    let said = solve(app, &folder, &arguments, PATIENCE)?;
    if said.code.is_none() {
        return Err(too_large());
    }
    let (answer, mut problems) = said.parts();
    for problem in &mut problems {
        let message = problem.message.replace(&format!("{RUN}/"), "");
        problem.message = message
            .trim_start_matches("--from: ")
            .trim_start_matches(&format!("{RUN}: "))
            .to_owned();
    }
    match answer {
        Some(plan) if problems.is_empty() => Ok(plan),
        _ => Err(ApiError::unrunnable(problems)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_branch_is_planned_without_the_large_files() {
        for name in ["plan.toml", "drum.scene.toml", "drum.chain.jsonl"] {
            assert!(states_the_run(name), "{name}");
        }
        for name in ["drum.particles.arrow", "drum.0.restart", "drum.data"] {
            assert!(!states_the_run(name), "{name}");
        }
    }
}
