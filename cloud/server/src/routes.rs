//! The API: paths, what they take and what they answer. What they do is in `runs`, `check`, `frames` and `charts`.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::io::{self, Write};
use std::sync::Arc;
use std::time::Duration;

use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, FromRequest, Path, Query, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::sse::{Event as Sse, KeepAlive};
use axum::response::{IntoResponse, Response};
use axum::routing::{delete, get, post, put};
use axum::{Json, Router, middleware};
use cloud_api::answers::{
    Attempt, Chart, Checked, Price, RunAnswer, RunFile, RunList, Session, StudyChecked, StudyList,
    StudySubmitted, StudyTable, TableInfo, Template, TokenRow, UserRow,
};
use cloud_api::lifecycle::Event;
use cloud_api::requests::{
    Check, Extend, LogIn, NewShare, NewToken, NewUser, Patch, Role, Scene, Study, Submit,
};
use cloud_api::{Head, RunId, RunState};
use cloud_store::{Hashing, StoreError};
use rusqlite::params;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio_stream::{Stream, StreamExt};
use tower_http::compression::CompressionLayer;

use crate::access::{Fail, LoggedIn, cookie, cookie_name, guard};
use crate::content::{Content, PIECE};
use crate::db::MOST_ROWS;
use crate::runs::{self, blocking, mine, with_life};
use crate::secrets::{self, Kind};
use crate::state::App;
use crate::{charts, check, frames, openapi, projects, studies, web};

/// The largest body that is taken as JSON, in bytes: a scene of 1 MB, with its escapes.
const LARGEST_BODY: usize = 4 << 20;

/// The largest input, in bytes.
const LARGEST_INPUT: u64 = 2 << 30;

/// The most that a request for the log gets, in bytes.
const MOST_LOG: u64 = 256 << 10;

/// How often a stream of events without any says that it lives.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

pub(crate) type Shared = State<Arc<App>>;
pub(crate) type Answer<T> = Result<Json<T>, Fail>;

/// A body of JSON; what is wrong with it is said as a problem.
pub(crate) struct Of<T>(pub(crate) T);

impl<T: serde::de::DeserializeOwned, S: Send + Sync> FromRequest<S> for Of<T> {
    type Rejection = Fail;

    async fn from_request(request: Request, state: &S) -> Result<Self, Fail> {
        match Json::<T>::from_request(request, state).await {
            Ok(Json(body)) => Ok(Self(body)),
            Err(rejected) => {
                // Unprocessable is what a scene is that cannot run; a body that is not understood is a bad request.
                let status = match rejected.status() {
                    StatusCode::UNPROCESSABLE_ENTITY => StatusCode::BAD_REQUEST,
                    status => status,
                };
                Err(Fail::new(
                    status,
                    "the body is not taken",
                    rejected.body_text(),
                ))
            }
        }
    }
}

/// Parameters of a query; what is wrong with them is said as a problem.
pub(crate) struct Asked<T>(T);

impl<T: serde::de::DeserializeOwned, S: Send + Sync> axum::extract::FromRequestParts<S>
    for Asked<T>
{
    type Rejection = Fail;

    async fn from_request_parts(
        parts: &mut axum::http::request::Parts,
        state: &S,
    ) -> Result<Self, Fail> {
        match Query::<T>::from_request_parts(parts, state).await {
            Ok(Query(query)) => Ok(Self(query)),
            Err(rejected) => Err(Fail::bad("the query is not taken", rejected.body_text())),
        }
    }
}

/// All paths.
pub(crate) fn router(app: Arc<App>) -> Router {
    let run = Router::new()
        .route("/", get(run_get).patch(run_patch).delete(run_delete))
        .route("/stop", post(run_stop))
        .route("/kill", post(run_kill))
        .route("/resume", post(run_resume))
        .route("/extend", post(run_extend))
        .route("/clone", post(run_clone))
        .route("/share", post(run_share))
        .route("/attempts", get(run_attempts))
        .route("/events", get(run_events))
        .route("/log", get(run_log))
        .route("/tables", get(run_tables))
        .route("/charts", get(run_charts))
        .route("/frames", get(run_frames))
        .route("/frames/{k}", get(run_frame))
        .route("/frames/{k}/grains/{id}", get(run_grain))
        .route("/frames/{k}/walls", get(run_walls))
        .route("/files", get(run_files))
        .route("/files/{*name}", get(run_file))
        .route("/archive", get(run_archive));
    let api = Router::new()
        .route("/check", post(check_scene))
        .route("/preview", post(preview_scene))
        .route("/runs", get(runs_list).post(runs_submit))
        .nest("/runs/{run}", run)
        .route("/studies", get(study_list).post(study_submit))
        .route("/studies/check", post(study_check))
        .route("/studies/{study}", get(study_table))
        .route("/studies/{study}/table.csv", get(study_csv))
        .route(
            "/projects",
            get(projects::project_list).post(projects::project_add),
        )
        .route("/projects/{project}", delete(projects::project_remove))
        .route(
            "/projects/{project}/members/{name}",
            put(projects::member_set).delete(projects::member_remove),
        )
        .route("/templates", get(template_list))
        .route("/events", get(events))
        .route(
            "/session",
            get(session_get).post(session_begin).delete(session_end),
        )
        .route("/users", get(user_list).post(user_set))
        .route("/tokens", get(token_list).post(token_add))
        .route("/tokens/{id}", delete(token_remove))
        .route("/openapi.json", get(|| async { Json(openapi::document()) }))
        .layer(DefaultBodyLimit::max(LARGEST_BODY))
        // Streams its body to the disk and counts what comes, whatever the header says.
        .route(
            "/inputs/{sha256}",
            put(input_put).layer(DefaultBodyLimit::disable()),
        )
        .fallback(|| async { Fail::missing() })
        .layer(CompressionLayer::new().gzip(true));
    Router::new()
        .nest("/api/v1", api)
        .route("/healthz", get(|| async { "ok\n" }))
        .route("/metrics", get(metrics))
        .fallback(web::page)
        .layer(middleware::from_fn_with_state(app.clone(), guard))
        .with_state(app)
}

/// What is wrong with a scene, or what it will take: memory, disk, steps, and with `trial` time.
#[utoipa::path(post, path = "/api/v1/check", request_body = Check, responses((status = 200, body = Checked)))]
pub(crate) async fn check_scene(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Of(body): Of<Check>,
) -> Answer<Checked> {
    Ok(Json(
        check::check(&app, user.id, body.scene, body.trial).await?,
    ))
}

/// Walls and first particles of a scene.
#[utoipa::path(post, path = "/api/v1/preview", request_body = Check, responses((status = 200, body = Object)))]
pub(crate) async fn preview_scene(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Of(body): Of<Check>,
) -> Answer<Value> {
    Ok(Json(check::preview(&app, user.id, body.scene).await?))
}

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
    LoggedIn(user): LoggedIn,
    Asked(query): Asked<ListQuery>,
) -> Answer<RunList> {
    if let Some(state) = &query.state
        && RunState::of(state).is_none()
    {
        return Err(Fail::bad(
            "there is no such state",
            RunState::ALL.map(RunState::word).join(", "),
        ));
    }
    if user.share.is_some() {
        return Ok(Json(RunList {
            runs: Vec::new(),
            after: None,
            states: BTreeMap::new(),
        }));
    }
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
    Of(body): Of<Submit>,
) -> Result<Response, Fail> {
    let key = key_of(&headers)?;
    let id = runs::submit(&app, &user, body, key.as_deref()).await?;
    let answer = blocking(move || answer(&app, &user, &id)).await?;
    Ok((StatusCode::CREATED, Json(answer)).into_response())
}

/// The idempotency key of a request.
fn key_of(headers: &HeaderMap) -> Result<Option<String>, Fail> {
    let Some(key) = headers.get("idempotency-key") else {
        return Ok(None);
    };
    let refused = |why| Fail::bad("Idempotency-Key is not taken", why);
    let key = key.to_str().map_err(|_| refused("It is plain text."))?;
    if key.is_empty() || key.len() > 200 {
        return Err(refused("It has 1 to 200 characters."));
    }
    Ok(Some(key.to_owned()))
}

/// Which runs a study would have, or what is wrong with it.
#[utoipa::path(post, path = "/api/v1/studies/check", request_body = Study, responses((status = 200, body = StudyChecked)))]
pub(crate) async fn study_check(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Of(body): Of<Study>,
) -> Answer<StudyChecked> {
    Ok(Json(studies::check(&app, &user, body).await?))
}

/// Submits a study: all of its runs, or none.
#[utoipa::path(post, path = "/api/v1/studies", request_body = Study,
    params(("Idempotency-Key" = Option<String>, Header)), responses((status = 201, body = StudySubmitted)))]
pub(crate) async fn study_submit(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    headers: HeaderMap,
    Of(body): Of<Study>,
) -> Result<Response, Fail> {
    let submitted = studies::submit(&app, &user, body, key_of(&headers)?).await?;
    Ok((StatusCode::CREATED, Json(submitted)).into_response())
}

#[derive(Deserialize)]
pub(crate) struct StudiesQuery {
    project: Option<String>,
    after: Option<String>,
}

/// A page of studies, newest first.
#[utoipa::path(get, path = "/api/v1/studies", params(("project" = Option<String>, Query), ("after" = Option<String>, Query)),
    responses((status = 200, body = StudyList)))]
pub(crate) async fn study_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Asked(query): Asked<StudiesQuery>,
) -> Answer<StudyList> {
    if user.share.is_some() {
        return Ok(Json(StudyList {
            studies: Vec::new(),
            after: None,
        }));
    }
    blocking(move || {
        let project = query.project.as_deref();
        if let Some(project) = project {
            projects::need(&app, &user, project, Role::Viewer)?;
        }
        let of = projects::of(project, &user);
        Ok(Json(studies::list(&app, of, query.after.as_deref())?))
    })
    .await
}

/// The table of a study: what differs between its runs, and what came out.
#[utoipa::path(get, path = "/api/v1/studies/{study}", params(("study" = String, Path)), responses((status = 200, body = StudyTable)))]
pub(crate) async fn study_table(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(study): Path<String>,
) -> Answer<StudyTable> {
    blocking(move || Ok(Json(studies::table(&app, &user, &study)?))).await
}

/// The same as comma-separated values.
#[utoipa::path(get, path = "/api/v1/studies/{study}/table.csv", params(("study" = String, Path)), responses((status = 200, content_type = "text/csv")))]
pub(crate) async fn study_csv(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(study): Path<String>,
) -> Result<Response, Fail> {
    let table = blocking(move || studies::table(&app, &user, &study)).await?;
    let name = "attachment; filename=\"study.csv\"";
    let head = [
        (header::CONTENT_TYPE, "text/csv; charset=utf-8"),
        (header::CONTENT_DISPOSITION, name),
    ];
    Ok((head, studies::csv(&table)).into_response())
}

/// All of a run.
fn answer(app: &App, user: &secrets::User, id: &str) -> Result<RunAnswer, Fail> {
    let (id, owner, _, row, spec) = mine(app, user, id)?;
    let writable = !user.read_only && runs::may_change(app, user, owner, &row).is_ok();
    let head = app.head(&id)?.unwrap_or_default();
    let scene = runs::scene(app, &spec)?.text;
    let seen = app
        .lives
        .get(id.as_str())
        .filter(|_| row.state.has_attempt());
    let silent = seen
        .as_ref()
        .map(|seen| seen.changed.elapsed().as_secs_f64());
    let late = app.db.policy().lost_when_gone();
    let mut row = with_life(app, row);
    if user.share.is_some() {
        // A link shows a run, not the users of the server.
        row.owner.clear();
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
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<RunAnswer> {
    blocking(move || Ok(Json(answer(&app, &user, &id)?))).await
}

/// Changes title or label of a run.
#[utoipa::path(patch, path = "/api/v1/runs/{run}", params(("run" = String, Path)), request_body = Patch, responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_patch(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    Of(body): Of<Patch>,
) -> Answer<RunAnswer> {
    blocking(move || {
        let (_, owner, _, row, _) = mine(&app, &user, &id)?;
        runs::may_change(&app, &user, owner, &row)?;
        if let Some(project) = &body.project {
            if owner != user.id {
                return Err(Fail::new(
                    StatusCode::FORBIDDEN,
                    "not allowed",
                    "The owner of a run puts it into a project, and takes it out.",
                ));
            }
            if !project.is_empty() {
                projects::need(&app, &user, project, Role::Member)?;
            }
        }
        if [&body.title, &body.label]
            .into_iter()
            .flatten()
            .any(|text| text.len() > 200)
        {
            return Err(Fail::bad(
                "too long",
                "Titles and labels have at most 200 bytes.",
            ));
        }
        app.db.patch(
            &id,
            body.title.as_deref(),
            body.label.as_deref(),
            body.project.as_deref(),
        )?;
        Ok(Json(answer(&app, &user, &id)?))
    })
    .await
}

/// Removes a run with all its files. One that is not over has to be stopped first.
#[utoipa::path(delete, path = "/api/v1/runs/{run}", params(("run" = String, Path)), responses((status = 204)))]
pub(crate) async fn run_delete(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Result<StatusCode, Fail> {
    blocking(move || runs::delete(&app, &user, &id).map(|()| StatusCode::NO_CONTENT)).await
}

async fn changed(
    app: Arc<App>,
    user: secrets::User,
    id: String,
    event: Event,
) -> Answer<RunAnswer> {
    blocking(move || {
        runs::change(&app, &user, &id, &event)?;
        Ok(Json(answer(&app, &user, &id)?))
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
    changed(app, user, id, Event::Stop).await
}

/// Ends a run at once; what was made since the last commit is lost.
#[utoipa::path(post, path = "/api/v1/runs/{run}/kill", params(("run" = String, Path)), responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_kill(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<RunAnswer> {
    changed(app, user, id, Event::Kill).await
}

/// Goes on with a run that was stopped or has failed, from its last checkpoint.
#[utoipa::path(post, path = "/api/v1/runs/{run}/resume", params(("run" = String, Path)), responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_resume(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<RunAnswer> {
    changed(app, user, id, Event::Resume).await
}

/// Goes on with a run to a later end.
#[utoipa::path(post, path = "/api/v1/runs/{run}/extend", params(("run" = String, Path)), request_body = Extend, responses((status = 200, body = RunAnswer)))]
pub(crate) async fn run_extend(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    Of(body): Of<Extend>,
) -> Answer<RunAnswer> {
    runs::extend(&app, &user, &id, body.end).await?;
    blocking(move || Ok(Json(answer(&app, &user, &id)?))).await
}

/// What a new run is made of, to be changed and submitted.
#[utoipa::path(post, path = "/api/v1/runs/{run}/clone", params(("run" = String, Path)), responses((status = 200, body = Submit)))]
pub(crate) async fn run_clone(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<Submit> {
    blocking(move || {
        let (_, _, _, row, spec) = mine(&app, &user, &id)?;
        let scene: Scene = runs::scene(&app, &spec)?;
        // Files of a run that one may see are files that one may use.
        for file in spec.files.values() {
            app.db.add_input(&file.sha256, user.id, file.bytes)?;
        }
        let label = (!row.label.is_empty()).then_some(row.label);
        Ok(Json(Submit {
            scene,
            title: Some(row.title),
            label,
            threads: spec.threads,
            result: spec.result,
            project: row
                .project
                .filter(|project| projects::need(&app, &user, project, Role::Member).is_ok()),
        }))
    })
    .await
}

/// A link with which others look at this run, until it expires.
#[utoipa::path(post, path = "/api/v1/runs/{run}/share", params(("run" = String, Path)), request_body = NewShare, responses((status = 200, body = Object)))]
pub(crate) async fn run_share(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    Of(body): Of<NewShare>,
) -> Answer<Value> {
    let days = days(body.days)?;
    blocking(move || {
        let (id, owner, _, row, _) = mine(&app, &user, &id)?;
        runs::may_change(&app, &user, owner, &row)?;
        let (_, secret, expires) = secrets::issue(
            &app.db,
            Kind::Share,
            owner,
            "share",
            Some(id.as_str()),
            days,
            true,
        )?;
        Ok(Json(json!({"token": secret, "expires": expires})))
    })
    .await
}

fn days(days: u32) -> Result<f64, Fail> {
    if (1..=366).contains(&days) {
        Ok(f64::from(days))
    } else {
        Err(Fail::bad("days are not taken", "1 to 366 days."))
    }
}

/// The attempts of a run, each with its cause.
#[utoipa::path(get, path = "/api/v1/runs/{run}/attempts", params(("run" = String, Path)), responses((status = 200, body = Vec<Attempt>)))]
pub(crate) async fn run_attempts(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<Vec<Attempt>> {
    blocking(move || {
        mine(&app, &user, &id)?;
        Ok(Json(app.db.attempts(&id)?))
    })
    .await
}

#[derive(Deserialize)]
pub(crate) struct AfterQuery {
    #[serde(default)]
    after: i64,
}

/// What happened to a run, behind number `after`; at most 200 events.
#[utoipa::path(get, path = "/api/v1/runs/{run}/events", params(("run" = String, Path), ("after" = Option<i64>, Query)), responses((status = 200, body = Object)))]
pub(crate) async fn run_events(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    Asked(query): Asked<AfterQuery>,
) -> Answer<Value> {
    blocking(move || {
        mine(&app, &user, &id)?;
        Ok(Json(
            json!({"events": app.db.events(None, Some(&id), query.after)?}),
        ))
    })
    .await
}

/// A run that the user may see, with its head.
fn headed(app: &App, user: &secrets::User, id: &str) -> Result<(RunId, Head), Fail> {
    let (id, ..) = mine(app, user, id)?;
    let head = app.head(&id)?.ok_or_else(Fail::missing)?;
    Ok((id, head))
}

/// Does something with files of a run. Pieces that were joined since the head was read are looked for again.
fn with_files<T>(
    app: &App,
    user: &secrets::User,
    id: &str,
    work: impl Fn(&RunId, &Head) -> Result<T, anyhow::Error>,
) -> Result<T, Fail> {
    for _ in 0..3 {
        let (id, head) = headed(app, user, id)?;
        match work(&id, &head) {
            Err(error)
                if error
                    .chain()
                    .any(|cause| matches!(cause.downcast_ref(), Some(StoreError::Missing(_)))) => {}
            result => return Ok(result?),
        }
    }
    Err(Fail::new(
        StatusCode::SERVICE_UNAVAILABLE,
        "the store is busy",
        "Try again.",
    ))
}

#[derive(Deserialize)]
pub(crate) struct LogQuery {
    from: Option<u64>,
}

/// The log of the solver from byte `from` on, the last 256 kB at most.
#[utoipa::path(get, path = "/api/v1/runs/{run}/log", params(("run" = String, Path), ("from" = Option<u64>, Query)), responses((status = 200, body = Object)))]
pub(crate) async fn run_log(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    Asked(query): Asked<LogQuery>,
) -> Answer<Value> {
    blocking(move || {
        with_files(&app, &user, &id, |id, head| {
            let Some(content) = Content::of(id, head, "run.log") else {
                return Ok(Json(json!({"text": "", "from": 0, "next": 0})));
            };
            // The log is written anew as a whole; a place in it that is behind its end is of an earlier one.
            let end = content.bytes();
            let from = query
                .from
                .filter(|&from| from <= end)
                .unwrap_or(0)
                .max(end.saturating_sub(MOST_LOG));
            let mut bytes = Vec::new();
            while from + (bytes.len() as u64) < end {
                bytes.extend(content.read(app.store.as_ref(), from + bytes.len() as u64..end)?);
            }
            Ok(Json(
                json!({"text": String::from_utf8_lossy(&bytes), "from": from, "next": end}),
            ))
        })
    })
    .await
}

/// The tables of a run, with the columns that charts can be made of.
#[utoipa::path(get, path = "/api/v1/runs/{run}/tables", params(("run" = String, Path)), responses((status = 200, body = Vec<TableInfo>)))]
pub(crate) async fn run_tables(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<Vec<TableInfo>> {
    blocking(move || {
        with_files(&app, &user, &id, |id, head| {
            let mut tables = Vec::new();
            for name in head
                .streams
                .keys()
                .chain(head.whole.keys())
                .filter(|name| charts::is_table(name))
            {
                if let Some(content) = Content::of(id, head, name) {
                    tables.extend(charts::describe(app.store.as_ref(), &content, name)?);
                }
            }
            Ok(Json(tables))
        })
    })
    .await
}

#[derive(Deserialize)]
pub(crate) struct ChartQuery {
    file: String,
    column: String,
    name: Option<String>,
}

/// A column of a table over time, reduced to its extremes in 2,000 bins.
#[utoipa::path(get, path = "/api/v1/runs/{run}/charts", responses((status = 200, body = Chart)),
    params(("run" = String, Path), ("file" = String, Query), ("column" = String, Query), ("name" = Option<String>, Query)))]
pub(crate) async fn run_charts(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
    Asked(query): Asked<ChartQuery>,
) -> Answer<Chart> {
    blocking(move || {
        let chart = with_files(&app, &user, &id, |id, head| {
            let Some(content) = Content::of(id, head, &query.file) else {
                return Ok(None);
            };
            Ok(charts::chart(
                app.store.as_ref(),
                &content,
                &query.file,
                &query.column,
                query.name.as_deref(),
            )?)
        })?;
        chart.map(Json).ok_or_else(Fail::missing)
    })
    .await
}

/// The frames of a run so far, with their times.
#[utoipa::path(get, path = "/api/v1/runs/{run}/frames", params(("run" = String, Path)), responses((status = 200, body = Object)))]
pub(crate) async fn run_frames(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<Value> {
    blocking(move || {
        with_files(&app, &user, &id, |id, head| {
            Ok(Json(frames::list(
                &app.cache,
                app.store.as_ref(),
                id,
                head,
            )?))
        })
    })
    .await
}

#[derive(Deserialize)]
pub(crate) struct FrameQuery {
    #[serde(default)]
    columns: String,
    #[serde(default = "most")]
    most: usize,
    /// Only there to tell cached frames of another past apart.
    #[serde(rename = "v")]
    version: Option<String>,
}

fn most() -> usize {
    100_000
}

/// The particles of a frame: a length, a head in JSON, then columns. `most` particles at most, the same ones in all frames.
#[utoipa::path(get, path = "/api/v1/runs/{run}/frames/{k}", responses((status = 200, description = "A frame", content_type = "application/octet-stream")),
    params(("run" = String, Path), ("k" = u32, Path), ("columns" = Option<String>, Query), ("most" = Option<u32>, Query), ("v" = Option<String>, Query)))]
pub(crate) async fn run_frame(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path((id, k)): Path<(String, String)>,
    Asked(query): Asked<FrameQuery>,
) -> Result<Response, Fail> {
    let k: usize = k.parse().map_err(|_| Fail::missing())?;
    let columns: Vec<String> = query
        .columns
        .split(',')
        .filter(|name| !name.is_empty())
        .map(str::to_owned)
        .collect();
    if columns.len() > 8 {
        return Err(Fail::bad("too many columns", "At most 8 at once."));
    }
    let most = query.most.clamp(1, 10_000_000);
    let frame = blocking(move || {
        with_files(&app, &user, &id, |id, head| {
            frames::frame(&app.cache, app.store.as_ref(), id, head, k, &columns, most)
        })
    });
    let bytes = frame.await?.ok_or_else(Fail::missing)?;
    // A frame never changes within one past.
    let kept = if query.version.is_some() {
        "private, max-age=31536000, immutable"
    } else {
        "no-store"
    };
    Ok((
        [
            (header::CONTENT_TYPE, "application/octet-stream"),
            (header::CACHE_CONTROL, kept),
        ],
        bytes,
    )
        .into_response())
}

/// All columns of one particle in a frame.
#[utoipa::path(get, path = "/api/v1/runs/{run}/frames/{k}/grains/{id}", params(("run" = String, Path), ("k" = u32, Path), ("id" = u32, Path)), responses((status = 200, body = Vec<Object>)))]
pub(crate) async fn run_grain(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path((id, k, grain)): Path<(String, String, String)>,
) -> Answer<Value> {
    let (Ok(k), Ok(grain)) = (k.parse(), grain.parse()) else {
        return Err(Fail::missing());
    };
    blocking(move || {
        let row = with_files(&app, &user, &id, |id, head| {
            frames::row(&app.cache, app.store.as_ref(), id, head, k, grain)
        })?;
        row.map(Json).ok_or_else(Fail::missing)
    })
    .await
}

/// The walls at a frame: triangles, and where they are.
#[utoipa::path(get, path = "/api/v1/runs/{run}/frames/{k}/walls", params(("run" = String, Path), ("k" = u32, Path)), responses((status = 200, body = Object)))]
pub(crate) async fn run_walls(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path((id, k)): Path<(String, String)>,
) -> Answer<Value> {
    let k: usize = k.parse().map_err(|_| Fail::missing())?;
    blocking(move || {
        let walls = with_files(&app, &user, &id, |id, head| {
            frames::walls(&app.cache, app.store.as_ref(), id, head, k)
        })?;
        walls.map(Json).ok_or_else(Fail::missing)
    })
    .await
}

fn files(head: &Head) -> Vec<RunFile> {
    let grows = head.phase != cloud_api::Phase::Ended;
    let id = RunId::of([0; 16]);
    let mut names: Vec<&String> = head.streams.keys().chain(head.whole.keys()).collect();
    names.extend(
        [&head.checkpoint, &head.earlier]
            .into_iter()
            .flatten()
            .map(|checkpoint| &checkpoint.name),
    );
    let file = |name: &String| {
        let bytes = Content::of(&id, head, name).map_or(0, |content| content.bytes());
        RunFile {
            name: name.clone(),
            bytes,
            grows: grows && head.streams.contains_key(name),
        }
    };
    let mut files: Vec<RunFile> = names.into_iter().map(file).collect();
    files.sort_by(|a, b| a.name.cmp(&b.name));
    files.dedup_by(|a, b| a.name == b.name);
    files
}

/// The files of a run.
#[utoipa::path(get, path = "/api/v1/runs/{run}/files", params(("run" = String, Path)), responses((status = 200, body = Vec<RunFile>)))]
pub(crate) async fn run_files(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<Vec<RunFile>> {
    blocking(move || Ok(Json(files(&headed(&app, &user, &id)?.1)))).await
}

/// Bytes `first..=last` that a `Range` header asks for; `None`: all.
fn range(headers: &HeaderMap, bytes: u64) -> Result<Option<(u64, u64)>, Fail> {
    let Some(text) = headers
        .get(header::RANGE)
        .and_then(|value| value.to_str().ok())
    else {
        return Ok(None);
    };
    // Several ranges, or other units: the whole file is a right answer (RFC 9110, 14.2).
    let Some((first, last)) = text
        .strip_prefix("bytes=")
        .filter(|text| !text.contains(','))
        .and_then(|t| t.split_once('-'))
    else {
        return Ok(None);
    };
    let unsatisfiable = || {
        Fail::new(
            StatusCode::RANGE_NOT_SATISFIABLE,
            "no such bytes",
            format!("The file has {bytes} bytes."),
        )
    };
    let (first, last) = match (first.parse::<u64>(), last.parse::<u64>()) {
        (Ok(first), Ok(last)) => (first, last.min(bytes.saturating_sub(1))),
        (Ok(first), Err(_)) => (first, bytes.saturating_sub(1)),
        (Err(_), Ok(length)) => (bytes.saturating_sub(length), bytes.saturating_sub(1)),
        _ => return Ok(None),
    };
    if first > last || first >= bytes {
        Err(unsatisfiable())
    } else {
        Ok(Some((first, last)))
    }
}

/// Bytes of a content, as they are read.
fn stream(
    app: Arc<App>,
    content: Content,
    from: u64,
    to: u64,
) -> impl Stream<Item = io::Result<Bytes>> {
    let (send, receive) = tokio::sync::mpsc::channel(2);
    tokio::task::spawn_blocking(move || {
        let mut at = from;
        while at < to {
            let piece = content
                .read(app.store.as_ref(), at..to)
                .map_err(io::Error::other);
            let bytes = piece.as_ref().map_or(0, |piece| piece.len() as u64);
            // The listener has gone, or nothing more can be read.
            if send.blocking_send(piece.map(Bytes::from)).is_err() || bytes == 0 {
                return;
            }
            at += bytes;
        }
    });
    receiver(receive)
}

fn receiver<T>(mut receive: tokio::sync::mpsc::Receiver<T>) -> impl Stream<Item = T> {
    Polled(move |context: &mut std::task::Context<'_>| receive.poll_recv(context))
}

/// A stream from a function that is polled.
struct Polled<F>(F);

impl<T, F: FnMut(&mut std::task::Context<'_>) -> std::task::Poll<Option<T>> + Unpin> Stream
    for Polled<F>
{
    type Item = T;

    fn poll_next(
        mut self: std::pin::Pin<&mut Self>,
        context: &mut std::task::Context<'_>,
    ) -> std::task::Poll<Option<T>> {
        (self.0)(context)
    }
}

/// The last part of a path as a name to save a file under; anything but plain characters is left out.
fn saved_as(name: &str) -> String {
    let last = name.rsplit('/').next().unwrap_or(name);
    last.chars()
        .filter(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-'))
        .collect()
}

/// A file, or the part of it that a `Range` header names.
#[utoipa::path(get, path = "/api/v1/runs/{run}/files/{name}", params(("run" = String, Path), ("name" = String, Path)),
    responses((status = 200, content_type = "application/octet-stream"), (status = 206, content_type = "application/octet-stream")))]
pub(crate) async fn run_file(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path((id, name)): Path<(String, String)>,
    headers: HeaderMap,
) -> Result<Response, Fail> {
    let shared = Arc::clone(&app);
    let file = name.clone();
    let content = blocking(move || {
        let (id, head) = headed(&shared, &user, &id)?;
        Content::of(&id, &head, &file).ok_or_else(Fail::missing)
    });
    let content = content.await?;
    let bytes = content.bytes();
    let range = range(&headers, bytes)?;
    let (first, end) = range.map_or((0, bytes), |(first, last)| (first, last + 1));
    // Pictures are shown within the page; all else is saved, whatever it claims to be.
    let picture = name.ends_with(".png");
    let kind = if picture {
        "image/png"
    } else {
        "application/octet-stream"
    };
    let how = if picture { "inline" } else { "attachment" };
    let mut answer = Response::builder()
        .status(if range.is_some() {
            StatusCode::PARTIAL_CONTENT
        } else {
            StatusCode::OK
        })
        .header(header::CONTENT_TYPE, kind)
        .header(header::CONTENT_LENGTH, end - first)
        .header(header::ACCEPT_RANGES, "bytes")
        .header(
            header::CONTENT_DISPOSITION,
            format!("{how}; filename=\"{}\"", saved_as(&name)),
        );
    if let Some((first, last)) = range {
        answer = answer.header(
            header::CONTENT_RANGE,
            format!("bytes {first}-{last}/{bytes}"),
        );
    }
    answer
        .body(Body::from_stream(stream(app, content, first, end)))
        .map_err(Fail::inner)
}

/// A writer whose bytes go to a listener.
struct Sender {
    send: tokio::sync::mpsc::Sender<io::Result<Bytes>>,
    held: Vec<u8>,
}

impl Write for Sender {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.held.extend(bytes);
        if self.held.len() as u64 >= PIECE {
            self.flush()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let bytes = Bytes::from(std::mem::take(&mut self.held));
        self.send
            .blocking_send(Ok(bytes))
            .map_err(|_| io::ErrorKind::BrokenPipe.into())
    }
}

/// All files of a run as one .zip.
#[utoipa::path(get, path = "/api/v1/runs/{run}/archive", params(("run" = String, Path)), responses((status = 200, content_type = "application/zip")))]
pub(crate) async fn run_archive(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Result<Response, Fail> {
    let shared = Arc::clone(&app);
    let (id, head, spec) = blocking(move || {
        let (id, _, _, _, spec) = mine(&shared, &user, &id)?;
        let head = shared.head(&id)?.ok_or_else(Fail::missing)?;
        Ok((id, head, spec))
    })
    .await?;
    let name = saved_as(spec.scene.trim_end_matches(".toml"));
    let (send, receive) = tokio::sync::mpsc::channel(2);
    tokio::task::spawn_blocking(move || {
        let sender = Sender {
            send: send.clone(),
            held: Vec::new(),
        };
        if let Err(error) = archive(&app, &id, &head, &spec, sender) {
            // The listener sees an archive that ends too early, and the connection says so.
            let _ = send.blocking_send(Err(io::Error::other(error.to_string())));
        }
    });
    Response::builder()
        .header(header::CONTENT_TYPE, "application/zip")
        .header(
            header::CONTENT_DISPOSITION,
            format!("attachment; filename=\"{name}.zip\""),
        )
        .body(Body::from_stream(receiver(receive)))
        .map_err(Fail::inner)
}

fn archive(
    app: &App,
    id: &RunId,
    head: &Head,
    spec: &cloud_api::Spec,
    sender: Sender,
) -> anyhow::Result<()> {
    let mut zip = zip::ZipWriter::new_stream(sender);
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let prefix = spec.scene.trim_end_matches(".toml");
    for (name, input) in &spec.files {
        zip.start_file(name.as_str(), options)?;
        zip.write_all(
            &app.store
                .get(&format!("inputs/{}", input.sha256))?
                .unwrap_or_default(),
        )?;
    }
    for file in files(head) {
        let Some(content) = Content::of(id, head, &file.name) else {
            continue;
        };
        zip.start_file(
            format!("{prefix}/{}", file.name),
            options.large_file(file.bytes >= u64::from(u32::MAX)),
        )?;
        let mut at = 0;
        while at < content.bytes() {
            let piece = content.read(app.store.as_ref(), at..content.bytes())?;
            at += piece.len() as u64;
            zip.write_all(&piece)?;
        }
    }
    zip.finish()?.flush()?;
    Ok(())
}

/// Sends a content that scenes can name by its SHA-256; at most 2 GB.
#[utoipa::path(put, path = "/api/v1/inputs/{sha256}", params(("sha256" = String, Path)), request_body(content_type = "application/octet-stream"), responses((status = 201)))]
pub(crate) async fn input_put(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(sha256): Path<String>,
    body: Body,
) -> Result<StatusCode, Fail> {
    let digits = sha256.len() == 64
        && sha256
            .bytes()
            .all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b));
    if !digits {
        return Err(Fail::bad(
            "the path is not taken",
            "SHA256 has 64 hexadecimal digits in lower case.",
        ));
    }
    let left = {
        let (app, user) = (Arc::clone(&app), user.clone());
        let usage = blocking(move || Ok(app.db.usage(user.id)?)).await?;
        usage
            .most_disk
            .map_or(u64::MAX, |most| most.saturating_sub(usage.disk))
    };
    let file = tempfile::tempfile_in(app.options.data.join("checks"))?;
    let mut hashing = Hashing::new(file);
    let mut bytes = 0;
    let mut pieces = body.into_data_stream();
    while let Some(piece) = pieces.next().await {
        let piece = piece.map_err(|error| Fail::bad("the body was cut off", error.to_string()))?;
        bytes += piece.len() as u64;
        if bytes > LARGEST_INPUT {
            return Err(Fail::new(
                StatusCode::PAYLOAD_TOO_LARGE,
                "the file is too large",
                "A file has at most 2 GB.",
            ));
        }
        if bytes > left {
            return Err(Fail::new(
                StatusCode::FORBIDDEN,
                "too little disk is left",
                "Your runs and inputs take what they may already. Delete runs.",
            ));
        }
        hashing.write_all(&piece)?;
    }
    let (got, mut file) = hashing.finish();
    if got != sha256 {
        return Err(Fail::bad(
            "the content is another",
            format!("Its SHA-256 is {got}."),
        ));
    }
    blocking(move || {
        let key = format!("inputs/{sha256}");
        if app.store.bytes(&key)?.is_none() {
            app.store.put_file(&key, &mut file, 0..bytes)?;
        }
        app.db.add_input(&sha256, user.id, bytes)?;
        Ok(StatusCode::CREATED)
    })
    .await
}

/// Scenes to start from.
#[utoipa::path(get, path = "/api/v1/templates", responses((status = 200, body = Vec<Template>)))]
pub(crate) async fn template_list(
    State(app): Shared,
    LoggedIn(_): LoggedIn,
) -> Answer<Vec<Template>> {
    Ok(Json(app.templates.clone()))
}

#[derive(Deserialize)]
pub(crate) struct EventsQuery {
    #[serde(default)]
    runs: String,
    after: Option<i64>,
}

/// Live events: first what happened since `Last-Event-ID`, then what happens.
#[utoipa::path(get, path = "/api/v1/events", params(("runs" = Option<String>, Query), ("after" = Option<i64>, Query), ("Last-Event-ID" = Option<String>, Header)),
    responses((status = 200, content_type = "text/event-stream")))]
pub(crate) async fn events(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Asked(query): Asked<EventsQuery>,
    headers: HeaderMap,
) -> Result<Response, Fail> {
    let mut wanted: Vec<String> = query
        .runs
        .split(',')
        .filter(|run| !run.is_empty())
        .map(str::to_owned)
        .collect();
    if wanted.len() > MOST_ROWS {
        return Err(Fail::bad(
            "too many runs",
            "At most 200 at once; none: all of yours.",
        ));
    }
    for run in &wanted {
        mine(&app, &user, run)?;
    }
    if wanted.is_empty() {
        wanted.extend(user.share.clone());
    }
    // Heard from now on, so that nothing falls between the replay and the news.
    let mut news = app.news.subscribe();
    let last = headers
        .get("last-event-id")
        .and_then(|id| id.to_str().ok()?.parse::<i64>().ok())
        .or(query.after);
    let newest = app.db.newest_event()?;
    let (send, receive) = tokio::sync::mpsc::channel::<Result<Sse, Infallible>>(64);
    let mut closing = app.closing();
    tokio::spawn(async move {
        let hears = |run: &String| wanted.is_empty() || wanted.contains(run);
        // So that a listener that comes back later knows from where on.
        let mut at = last.unwrap_or(newest).min(newest);
        let hello = Sse::default().event("hello").id(at.to_string()).data("{}");
        if send.send(Ok(hello)).await.is_err() {
            return;
        }
        loop {
            let rows = match app
                .db
                .events(wanted.is_empty().then_some(user.id), None, at)
            {
                Ok(rows) => rows,
                Err(error) => return eprintln!("{error}"),
            };
            let Some(end) = rows.last().map(|row| row.id) else {
                break;
            };
            for row in rows.iter().filter(|row| hears(&row.run)) {
                let text = serde_json::to_string(row).unwrap_or_default();
                if send
                    .send(Ok(Sse::default().id(row.id.to_string()).data(text)))
                    .await
                    .is_err()
                {
                    return;
                }
            }
            at = end;
        }
        loop {
            let message = tokio::select! {
                message = news.recv() => message,
                () = send.closed() => return,
                _ = closing.changed() => return,
            };
            let event = match message {
                Ok(message) if !wanted.is_empty() && !wanted.contains(&message.run) => continue,
                Ok(message) if wanted.is_empty() && !message.audience.contains(&user.id) => {
                    continue;
                }
                Ok(message) => match message.id {
                    // Part of the replay already.
                    Some(id) if id <= at => continue,
                    Some(id) => Sse::default().id(id.to_string()).data(&message.text),
                    None => Sse::default().data(&message.text),
                },
                Err(tokio::sync::broadcast::error::RecvError::Lagged(_)) => {
                    Sse::default().event("lagged").data("{}")
                }
                Err(tokio::sync::broadcast::error::RecvError::Closed) => return,
            };
            // A listener that does not read is not waited for: it misses some, and hears so.
            match send.try_send(Ok(event)) {
                Ok(()) => {}
                Err(tokio::sync::mpsc::error::TrySendError::Closed(_)) => return,
                Err(tokio::sync::mpsc::error::TrySendError::Full(_)) => {
                    let lagged = Sse::default().event("lagged").data("{}");
                    tokio::select! {
                        sent = send.send(Ok(lagged)) => if sent.is_err() { return },
                        _ = closing.changed() => return,
                    }
                }
            }
        }
    });
    let sse = axum::response::Sse::new(receiver(receive))
        .keep_alive(KeepAlive::new().interval(KEEP_ALIVE));
    Ok(([("x-accel-buffering", "no")], sse).into_response())
}

fn session_of(app: &App, user: &secrets::User) -> Session {
    let cores = app.options.cores;
    let busy: u32 = app.db.live().map_or(0, |runs| {
        runs.iter()
            .filter(|live| live.run.state.has_attempt())
            .map(|live| live.threads)
            .sum()
    });
    Session {
        user: user.name.clone(),
        admin: user.admin && user.share.is_none(),
        read_only: user.read_only,
        cores: [cores.saturating_sub(busy), cores],
        solver: app.version.clone(),
        usage: app.db.usage(user.id).unwrap_or_default(),
        price: app.db.prices().and_then(|prices| {
            Some(Price {
                currency: prices.currency.clone(),
                core_hour: prices.core_hour(app.engine.queue(0))?,
            })
        }),
    }
}

/// Which user this is, and what is free.
#[utoipa::path(get, path = "/api/v1/session", responses((status = 200, body = Session)))]
pub(crate) async fn session_get(State(app): Shared, LoggedIn(user): LoggedIn) -> Answer<Session> {
    Ok(Json(session_of(&app, &user)))
}

/// Logs in, by the token of a link or by name and password. Sets a cookie.
#[utoipa::path(post, path = "/api/v1/session", request_body = LogIn, responses((status = 200, body = Session)))]
pub(crate) async fn session_begin(
    State(app): Shared,
    Of(body): Of<LogIn>,
) -> Result<Response, Fail> {
    let shared = Arc::clone(&app);
    let (user, secret) = blocking(move || {
        let user = match (&body.token, &body.name, &body.password) {
            (Some(token), ..) => [Kind::Link, Kind::Share, Kind::Token]
                .into_iter()
                .find_map(|kind| secrets::recognise(&shared.db, kind, token).transpose())
                .transpose()?,
            (None, Some(name), Some(password)) => {
                if !shared.tries.allowed(name) {
                    let detail = "Five tries a minute. Wait a minute.";
                    return Err(Fail::new(
                        StatusCode::TOO_MANY_REQUESTS,
                        "too many tries",
                        detail,
                    ));
                }
                secrets::log_in(&shared.db, name, password)?
            }
            _ => {
                return Err(Fail::bad(
                    "the body is not taken",
                    "It has `token`, or `name` and `password`.",
                ));
            }
        };
        let Some(user) = user else {
            return Err(Fail::new(
                StatusCode::UNAUTHORIZED,
                "not known",
                "The link or the password is wrong or has expired.",
            ));
        };
        let run = user.share.as_deref();
        let (_, secret, _) = secrets::issue(
            &shared.db,
            Kind::Session,
            user.id,
            "",
            run,
            30.0,
            user.read_only,
        )?;
        Ok((user, secret))
    })
    .await?;
    let secure = if app.options.behind_proxy {
        "; Secure"
    } else {
        ""
    };
    let set = format!(
        "{}={secret}; Path=/; HttpOnly; SameSite=Lax; Max-Age=2592000{secure}",
        cookie_name(&app)
    );
    Ok(([(header::SET_COOKIE, set)], Json(session_of(&app, &user))).into_response())
}

/// Logs out.
#[utoipa::path(delete, path = "/api/v1/session", responses((status = 204)))]
pub(crate) async fn session_end(
    State(app): Shared,
    LoggedIn(_): LoggedIn,
    headers: HeaderMap,
) -> Result<Response, Fail> {
    if let Some(secret) = cookie(&app, &headers) {
        secrets::revoke(&app.db, Kind::Session, secret)?;
    }
    let gone = format!("{}=; Path=/; HttpOnly; Max-Age=0", cookie_name(&app));
    Ok((StatusCode::NO_CONTENT, [(header::SET_COOKIE, gone)]).into_response())
}

fn admin(user: &secrets::User) -> Result<(), Fail> {
    if user.admin && user.share.is_none() {
        Ok(())
    } else {
        Err(Fail::new(
            StatusCode::FORBIDDEN,
            "not allowed",
            "Administrators manage users.",
        ))
    }
}

/// The users and what they take; for administrators.
#[utoipa::path(get, path = "/api/v1/users", responses((status = 200, body = Vec<UserRow>)))]
pub(crate) async fn user_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Answer<Vec<UserRow>> {
    admin(&user)?;
    blocking(move || {
        let users = {
            let connection = app.db.lock();
            let mut query =
                connection.prepare("SELECT id, name, admin FROM users ORDER BY name LIMIT 200")?;
            let rows = query.query_map([], |row| {
                Ok((
                    row.get::<_, i64>(0)?,
                    row.get::<_, String>(1)?,
                    row.get::<_, bool>(2)?,
                ))
            })?;
            rows.collect::<Result<Vec<_>, _>>()?
        };
        let row = |(id, name, admin)| {
            let usage = app.db.usage(id)?;
            Ok(UserRow { name, admin, usage })
        };
        Ok(Json(
            users.into_iter().map(row).collect::<Result<_, Fail>>()?,
        ))
    })
    .await
}

/// Adds a user, or changes password and limits; for administrators.
#[utoipa::path(post, path = "/api/v1/users", request_body = NewUser, responses((status = 204)))]
pub(crate) async fn user_set(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Of(body): Of<NewUser>,
) -> Result<StatusCode, Fail> {
    admin(&user)?;
    cloud_api::names::check_name(&body.name)
        .map_err(|why| Fail::bad("the name is not taken", why.to_string()))?;
    if body.cores == Some(0) || body.disk.is_some_and(|bytes| bytes > i64::MAX as u64) {
        return Err(Fail::bad(
            "the limits are not taken",
            "At least 1 core, and a length in bytes.",
        ));
    }
    if body.password.chars().count() < 10 || body.password.len() > 1000 {
        return Err(Fail::bad(
            "the password is not taken",
            "A password has at least 10 characters.",
        ));
    }
    blocking(move || {
        secrets::set_user(&app.db, &body)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

/// The API tokens of this user, without their secrets.
#[utoipa::path(get, path = "/api/v1/tokens", responses((status = 200, body = Vec<TokenRow>)))]
pub(crate) async fn token_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Answer<Vec<TokenRow>> {
    if user.share.is_some() {
        return Err(Fail::missing());
    }
    let connection = app.db.lock();
    let mut query = connection
        .prepare("SELECT id, name, expires, read_only FROM secrets WHERE user = ?1 AND kind = 'token' ORDER BY id LIMIT 200")?;
    let rows = query.query_map([user.id], |row| {
        Ok(TokenRow {
            id: row.get(0)?,
            name: row.get(1)?,
            expires: row.get(2)?,
            read_only: row.get(3)?,
            secret: None,
        })
    })?;
    Ok(Json(rows.collect::<Result<Vec<_>, _>>()?))
}

/// Makes an API token; its secret is in this answer alone.
#[utoipa::path(post, path = "/api/v1/tokens", request_body = NewToken, responses((status = 201, body = TokenRow)))]
pub(crate) async fn token_add(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Of(body): Of<NewToken>,
) -> Result<Response, Fail> {
    let days = days(body.days)?;
    if body.name.len() > 200 {
        return Err(Fail::bad("the name is too long", "At most 200 bytes."));
    }
    let (id, secret, expires) = secrets::issue(
        &app.db,
        Kind::Token,
        user.id,
        &body.name,
        None,
        days,
        body.read_only,
    )?;
    let row = TokenRow {
        id,
        name: body.name,
        expires,
        read_only: body.read_only,
        secret: Some(secret),
    };
    Ok((StatusCode::CREATED, Json(row)).into_response())
}

/// Takes an API token back.
#[utoipa::path(delete, path = "/api/v1/tokens/{id}", params(("id" = i64, Path)), responses((status = 204)))]
pub(crate) async fn token_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Result<StatusCode, Fail> {
    let id: i64 = id.parse().map_err(|_| Fail::missing())?;
    let removed = app.db.lock().execute(
        "DELETE FROM secrets WHERE id = ?1 AND user = ?2 AND kind = 'token'",
        params![id, user.id],
    )?;
    if removed == 1 {
        Ok(StatusCode::NO_CONTENT)
    } else {
        Err(Fail::missing())
    }
}

/// Counts for Prometheus. No names of runs or users.
async fn metrics(State(app): Shared, LoggedIn(user): LoggedIn) -> Result<String, Fail> {
    admin(&user)?;
    let connection = app.db.lock();
    let mut query = connection.prepare("SELECT state, count(*) FROM runs GROUP BY state")?;
    let rows = query.query_map([], |row| {
        Ok((row.get::<_, String>(0)?, row.get::<_, i64>(1)?))
    })?;
    let mut text = String::from("# TYPE mercury_runs gauge\n");
    for row in rows {
        let (state, count) = row?;
        text += &format!("mercury_runs{{state=\"{state}\"}} {count}\n");
    }
    text += &format!(
        "# TYPE mercury_listeners gauge\nmercury_listeners {}\n",
        app.news.receiver_count()
    );
    Ok(text)
}
