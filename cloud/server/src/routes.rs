//! The API: paths, what they take and what they answer. What they do is in `runs`, `studies`, `check`, `frames` and `charts`; accounts, projects and downloads have files of their own.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{DefaultBodyLimit, FromRequest, Path, Query, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::sse::{Event as Sse, KeepAlive};
use axum::response::{IntoResponse, Response};
use axum::routing::{delete, get, post, put};
use axum::{Json, Router, middleware};
use cloud_api::answers::{
    Attempt, Chart, Checked, RunAnswer, RunList, StudyChecked, StudyList, StudySubmitted,
    StudyTable, TableInfo, Template,
};
use cloud_api::lifecycle::Event;
use cloud_api::requests::{Check, Extend, NewShare, Patch, Role, Scene, Study, Submit};
use cloud_api::{Head, RunId, RunState};
use cloud_store::{Hashing, StoreError};
use serde::Deserialize;
use serde_json::{Value, json};
use tokio_stream::StreamExt;
use tower_http::compression::CompressionLayer;

use crate::access::{Fail, LoggedIn, guard};
use crate::content::Content;
use crate::db::MOST_ROWS;
use crate::runs::{self, blocking, mine, with_life};
use crate::secrets::{self, Kind};
use crate::state::App;
use crate::{accounts, charts, check, downloads, frames, openapi, projects, studies, web};

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
        .route("/files", get(downloads::run_files))
        .route("/files/{*name}", get(downloads::run_file))
        .route("/archive", get(downloads::run_archive));
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
            get(accounts::session_get)
                .post(accounts::session_begin)
                .delete(accounts::session_end),
        )
        .route("/users", get(accounts::user_list).post(accounts::user_set))
        .route(
            "/tokens",
            get(accounts::token_list).post(accounts::token_add),
        )
        .route("/tokens/{id}", delete(accounts::token_remove))
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

pub(crate) fn days(days: u32) -> Result<f64, Fail> {
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
pub(crate) fn headed(app: &App, user: &secrets::User, id: &str) -> Result<(RunId, Head), Fail> {
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
    let sse = axum::response::Sse::new(downloads::receiver(receive))
        .keep_alive(KeepAlive::new().interval(KEEP_ALIVE));
    Ok(([("x-accel-buffering", "no")], sse).into_response())
}

/// Counts for Prometheus. No names of runs or users.
async fn metrics(State(app): Shared, LoggedIn(user): LoggedIn) -> Result<String, Fail> {
    accounts::admin(&user)?;
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
