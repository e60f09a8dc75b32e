//! Routes of runs: lists, submission, state, and what can be done to a run.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use cloud_api::RunState;
use cloud_api::answers::{Attempt, RunAnswer, RunList};
use cloud_api::lifecycle::RunEvent;
use cloud_api::requests::{BranchOff, Extend, NewShare, Patch, Role, Submit};
use serde::Deserialize;
use serde_json::{Value, json};

use super::{Answer, JsonBody, QueryParams, Shared};
use crate::access::{Anyone, ApiError, LoggedIn, not_logged_in};
use crate::db::MOST_ROWS;
use crate::runs::{VisibleRun, blocking, visible_run, with_life};
use crate::secrets::{Caller, NewSecret, SecretKind};
use crate::state::App;
use crate::{branch, projects, runs, secrets};

#[derive(Deserialize)]
pub(crate) struct ListQuery {
    state: Option<String>,
    label: Option<String>,
    text: Option<String>,
    project: Option<String>,
    after: Option<String>,
}

/// A page of runs, newest first.
#[utoipa::path(get, path = "/api/v1/runs", responses((status = 200, body = RunList)),
    params(("state" = Option<String>, Query), ("label" = Option<String>, Query), ("text" = Option<String>, Query),
        ("project" = Option<String>, Query, description = "runs of a project, of all its members; without it those of this user"),
        ("after" = Option<String>, Query, description = "`after` of the page before")))]
pub(crate) async fn runs_list(
    State(app): Shared,
    Anyone(caller): Anyone,
    QueryParams(query): QueryParams<ListQuery>,
) -> Answer<RunList> {
    if let Some(state) = &query.state
        && RunState::of(state).is_none()
    {
        return Err(ApiError::bad_request(
            "unknown state",
            RunState::ALL.map(RunState::word).join(", "),
        ));
    }
    let Caller::User(user) = caller else {
        return Ok(Json(RunList {
            runs: Vec::new(),
            after: None,
            states: BTreeMap::new(),
        }));
    };
    blocking(move || {
        let [state, label, text, after] =
            [&query.state, &query.label, &query.text, &query.after].map(Option::as_deref);
        let project = query.project.as_deref();
        if let Some(project) = project {
            projects::need(&app, &user, project, Role::Viewer)?;
        }
        let of = projects::of(project, &user);
        let mut runs = app.db.list(of, state, label, text, after)?;
        let after = (runs.len() > MOST_ROWS).then(|| runs[MOST_ROWS - 1].id.clone());
        runs.truncate(MOST_ROWS);
        let runs = runs.into_iter().map(|row| with_life(&app, row)).collect();
        Ok(Json(RunList {
            runs,
            after,
            states: app.db.states(of)?,
        }))
    })
    .await
}

/// Submits a run. The same `Idempotency-Key` with the same body is the same run; with another body it is a 409.
#[utoipa::path(post, path = "/api/v1/runs", request_body = Submit,
    params(("Idempotency-Key" = Option<String>, Header)), responses((status = 201, body = RunAnswer)))]
pub(crate) async fn runs_submit(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    headers: HeaderMap,
    JsonBody(body): JsonBody<Submit>,
) -> Result<Response, ApiError> {
    let key = key_of(&headers)?;
    let id = runs::submit(&app, &user, body, key.as_deref(), None).await?;
    let answer = blocking(move || answer(&app, &Caller::User(user), &id)).await?;
    Ok((StatusCode::CREATED, Json(answer)).into_response())
}

/// The idempotency key of a request.
pub(super) fn key_of(headers: &HeaderMap) -> Result<Option<String>, ApiError> {
    let Some(key) = headers.get("idempotency-key") else {
        return Ok(None);
    };
    let refused = |why| ApiError::bad_request("invalid Idempotency-Key", why);
    let key = key.to_str().map_err(|_| refused("It is plain text."))?;
    if key.is_empty() || key.len() > 200 {
        return Err(refused("It has 1 to 200 characters."));
    }
    Ok(Some(key.to_owned()))
}

/// All of a run.
fn answer(app: &App, caller: &Caller, id: &str) -> Result<RunAnswer, ApiError> {
    let VisibleRun { id, row, spec, .. } = visible_run(app, caller, id)?;
    let writable = match caller {
        Caller::User(user) if !user.read_only => {
            runs::changeable_run(app, user, id.as_str()).is_ok()
        }
        _ => false,
    };
    let head = app.head(&id)?.unwrap_or_default();
    let scene = runs::scene(app, &spec)?.text;
    let seen = app
        .attempts
        .get(id.as_str())
        .filter(|_| row.state.has_attempt());
    let silent = seen
        .as_ref()
        .map(|seen| seen.changed.elapsed().as_secs_f64());
    let late = app.db.policy().lost_when_gone();
    let mut row = with_life(app, row);
    if matches!(caller, Caller::Guest(_)) {
        // A link shows a run, not the users of the server, nor what they pay.
        row.owner.clear();
        (row.cost, row.saved, row.project) = (None, None, None);
    }
    Ok(RunAnswer {
        row,
        spec,
        scene,
        beat: seen.and_then(|seen| seen.beat),
        notes: head.notes,
        unseen: silent.filter(|&silent| silent > late),
        writable,
    })
}

/// All of a run: state, spec, text of the scene, last sign of life, notes.
#[utoipa::path(get, path = "/api/v1/runs/{run}", params(("run" = String, Path)), responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_get(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path(id): Path<String>,
) -> Answer<RunAnswer> {
    blocking(move || Ok(Json(answer(&app, &caller, &id)?))).await
}

/// Changes title or label of a run.
#[utoipa::path(patch, path = "/api/v1/runs/{run}", params(("run" = String, Path)), request_body = Patch, responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_patch(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    JsonBody(body): JsonBody<Patch>,
) -> Answer<RunAnswer> {
    blocking(move || {
        let run = runs::changeable_run(&app, &user, &id)?;
        if let Some(project) = &body.project {
            if run.owner != user.id {
                return Err(ApiError::new(
                    StatusCode::FORBIDDEN,
                    "not allowed",
                    "The owner of a run puts it into a project, and takes it out.",
                ));
            }
            if !project.is_empty() {
                projects::need(&app, &user, project, Role::Member)?;
            }
        }
        for (what, text) in [("title", &body.title), ("label", &body.label)] {
            runs::checked_text(what, text.as_deref().unwrap_or_default())?;
        }
        app.db.patch(
            run.id.as_str(),
            body.title.as_deref(),
            body.label.as_deref(),
            body.project.as_deref(),
        )?;
        Ok(Json(answer(&app, &Caller::User(user), &id)?))
    })
    .await
}

/// Removes a run with all its files. One that is not over has to be stopped first.
#[utoipa::path(delete, path = "/api/v1/runs/{run}", params(("run" = String, Path)), responses((status = 204)))]
pub(crate) async fn run_delete(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Result<StatusCode, ApiError> {
    blocking(move || {
        runs::delete(&app, &runs::changeable_run(&app, &user, &id)?)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

async fn changed(
    app: Arc<App>,
    user: secrets::User,
    id: String,
    event: RunEvent,
) -> Answer<RunAnswer> {
    blocking(move || {
        runs::change(&app, &runs::changeable_run(&app, &user, &id)?, &event)?;
        Ok(Json(answer(&app, &Caller::User(user), &id)?))
    })
    .await
}

/// Stops a run: the solver writes a checkpoint and ends.
#[utoipa::path(post, path = "/api/v1/runs/{run}/stop", params(("run" = String, Path)), responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_stop(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<RunAnswer> {
    changed(app, user, id, RunEvent::Stop).await
}

/// Ends a run at once; what was made since the last commit is lost.
#[utoipa::path(post, path = "/api/v1/runs/{run}/kill", params(("run" = String, Path)), responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_kill(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<RunAnswer> {
    changed(app, user, id, RunEvent::Kill).await
}

#[derive(Deserialize)]
pub(crate) struct ResumeQuery {
    ranks: Option<u32>,
}

/// Goes on with a run that was stopped or has failed, from its last checkpoint; with `ranks` on another number of ranks.
#[utoipa::path(post, path = "/api/v1/runs/{run}/resume", params(("run" = String, Path), ("ranks" = Option<u32>, Query)), responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_resume(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    QueryParams(query): QueryParams<ResumeQuery>,
) -> Answer<RunAnswer> {
    blocking(move || {
        runs::resume(&app, &runs::changeable_run(&app, &user, &id)?, query.ranks)?;
        Ok(Json(answer(&app, &Caller::User(user), &id)?))
    })
    .await
}

/// Goes on with a run to a later end.
#[utoipa::path(post, path = "/api/v1/runs/{run}/extend", params(("run" = String, Path)), request_body = Extend, responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_extend(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    JsonBody(body): JsonBody<Extend>,
) -> Answer<RunAnswer> {
    runs::extend(&app, &user, &id, body.end).await?;
    blocking(move || Ok(Json(answer(&app, &Caller::User(user), &id)?))).await
}

/// Scene, files and settings for a new run like this one, to be changed and submitted.
#[utoipa::path(post, path = "/api/v1/runs/{run}/clone", params(("run" = String, Path)), responses((status = 200, body = Submit)))]
pub(crate) async fn run_clone(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<Submit> {
    blocking(move || {
        let run = visible_run(&app, &Caller::User(user.clone()), &id)?;
        Ok(Json(runs::like(&app, &user, run)?))
    })
    .await
}

/// A new run that is this one up to a time, and goes on with a changed scene.
#[utoipa::path(post, path = "/api/v1/runs/{run}/branch", params(("run" = String, Path)), request_body = BranchOff, responses((status = 201, body = RunAnswer)))]
pub(crate) async fn run_branch(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    JsonBody(body): JsonBody<BranchOff>,
) -> Result<Response, ApiError> {
    let id = branch::branch(&app, &user, &id, body).await?;
    let answer = blocking(move || answer(&app, &Caller::User(user), &id)).await?;
    Ok((StatusCode::CREATED, Json(answer)).into_response())
}

/// A link with which others look at this run, until it expires.
#[utoipa::path(post, path = "/api/v1/runs/{run}/share", params(("run" = String, Path)), request_body = NewShare, responses((status = 200, body = Object)))]
pub(crate) async fn run_share(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    JsonBody(body): JsonBody<NewShare>,
) -> Answer<Value> {
    let days = days(body.days)?;
    blocking(move || {
        let run = runs::changeable_run(&app, &user, &id)?;
        let share = NewSecret {
            kind: SecretKind::Share,
            user: run.owner,
            right: user.right(),
            root: user.root,
            name: "share",
            run: Some(run.id.as_str()),
            days,
            read_only: true,
        };
        let issued = secrets::issue(&app.db, &share)?.ok_or_else(not_logged_in)?;
        Ok(Json(
            json!({"token": issued.secret, "expires": issued.expires}),
        ))
    })
    .await
}

pub(crate) fn days(days: u32) -> Result<f64, ApiError> {
    if (1..=366).contains(&days) {
        Ok(f64::from(days))
    } else {
        Err(ApiError::bad_request(
            "invalid number of days",
            "1 to 366 days.",
        ))
    }
}

/// The attempts of a run, each with its cause.
#[utoipa::path(get, path = "/api/v1/runs/{run}/attempts", params(("run" = String, Path)), responses((status = 200, body = Vec<Attempt>)))]
pub(crate) async fn run_attempts(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path(id): Path<String>,
) -> Answer<Vec<Attempt>> {
    blocking(move || {
        visible_run(&app, &caller, &id)?;
        let mut attempts = app.db.attempts(&id)?;
        if matches!(caller, Caller::Guest(_)) {
            for attempt in &mut attempts {
                (attempt.cost, attempt.machine) = (None, String::new());
            }
        }
        Ok(Json(attempts))
    })
    .await
}

#[derive(Deserialize)]
pub(crate) struct AfterQuery {
    #[serde(default)]
    after: i64,
}

/// Events of a run behind number `after`; at most 200 events.
#[utoipa::path(get, path = "/api/v1/runs/{run}/events", params(("run" = String, Path), ("after" = Option<i64>, Query)), responses((status = 200, body = Object)))]
pub(crate) async fn run_events(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path(id): Path<String>,
    QueryParams(query): QueryParams<AfterQuery>,
) -> Answer<Value> {
    blocking(move || {
        visible_run(&app, &caller, &id)?;
        Ok(Json(
            json!({"events": app.db.events(None, Some(&id), query.after)?}),
        ))
    })
    .await
}
