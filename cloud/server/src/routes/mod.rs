//! The API: its paths, and by subject their requests and answers. The work is done in `runs`, `studies`, `check`, `frames` and `charts`;
//! accounts, projects and downloads have files of their own.

mod live;
mod results;
mod runs;
mod scenes;
mod studies;

use std::sync::Arc;
use std::time::Duration;

use axum::extract::{DefaultBodyLimit, FromRequest, Query, Request, State};
use axum::http::{Extensions, HeaderMap, StatusCode, Version, header};
use axum::routing::{delete, get, post, put};
use axum::{Json, Router, middleware};
use tower_http::compression::{CompressionLayer, DefaultPredicate, Predicate};

use crate::access::{ApiError, guard};
use crate::state::App;
use crate::{accounts, audit, downloads, hooks, openapi, projects, verify, web};

pub(crate) use live::*;
pub(crate) use results::*;
pub(crate) use runs::*;
pub(crate) use scenes::*;
pub(crate) use studies::*;

/// The largest body that is taken as JSON, in bytes: a scene of 1 MB, with its escapes.
const LARGEST_BODY: usize = 4 << 20;

/// The most bytes of a body that logs in, or that makes a user, a token or a link.
const SMALL_BODY: usize = 16 << 10;

/// How long a body of JSON may take.
const BODY: Duration = Duration::from_secs(60);

pub(crate) type Shared = State<Arc<App>>;
pub(crate) type Answer<T> = Result<Json<T>, ApiError>;

/// A body of JSON; an error in it becomes a [`cloud_api::Problem`].
pub(crate) struct JsonBody<T>(pub(crate) T);

impl<T: serde::de::DeserializeOwned, S: Send + Sync> FromRequest<S> for JsonBody<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        let body = tokio::time::timeout(BODY, Json::<T>::from_request(request, state));
        match body.await {
            Err(_) => Err(ApiError::new(
                StatusCode::REQUEST_TIMEOUT,
                "the body is too slow",
                format!("A body of JSON comes within {} s.", BODY.as_secs()),
            )),
            Ok(Ok(Json(body))) => Ok(Self(body)),
            Ok(Err(rejected)) => {
                // Unprocessable is what a scene is that cannot run; a body that is not understood is a bad request.
                let status = match rejected.status() {
                    StatusCode::UNPROCESSABLE_ENTITY => StatusCode::BAD_REQUEST,
                    status => status,
                };
                Err(ApiError::new(status, "invalid body", rejected.body_text()))
            }
        }
    }
}

/// Parameters of a query; an error in them becomes a [`cloud_api::Problem`].
pub(crate) struct QueryParams<T>(pub(crate) T);

impl<T: serde::de::DeserializeOwned, S: Send + Sync> axum::extract::FromRequestParts<S>
    for QueryParams<T>
{
    type Rejection = ApiError;

    async fn from_request_parts(
        parts: &mut axum::http::request::Parts,
        state: &S,
    ) -> Result<Self, ApiError> {
        match Query::<T>::from_request_parts(parts, state).await {
            Ok(Query(query)) => Ok(Self(query)),
            Err(rejected) => Err(ApiError::bad_request("invalid query", rejected.body_text())),
        }
    }
}

/// Whether an answer may be compressed: a download has a length and can be resumed, which what is compressed on its way cannot.
fn is_no_download(_: StatusCode, _: Version, headers: &HeaderMap, _: &Extensions) -> bool {
    !headers.contains_key(header::ACCEPT_RANGES)
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
        .route("/branch", post(run_branch))
        .route(
            "/verification",
            get(verify::verification_get).post(verify::verification_begin),
        )
        .route("/share", post(run_share))
        .route("/shares", get(accounts::run_shares))
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
    // Their bodies are small, and one of them comes before the login.
    let secrets = Router::new()
        .route(
            "/session",
            get(accounts::session_get)
                .post(accounts::session_begin)
                .delete(accounts::session_end),
        )
        .route("/users", get(accounts::user_list).post(accounts::user_set))
        .route("/links", post(accounts::link_add))
        .route(
            "/tokens",
            get(accounts::token_list).post(accounts::token_add),
        )
        .route(
            "/hook",
            get(hooks::hook_get)
                .put(hooks::hook_set)
                .delete(hooks::hook_remove),
        )
        .layer(DefaultBodyLimit::max(SMALL_BODY));
    let api = Router::new()
        .route("/check", post(check_scene))
        .route("/preview", post(preview_scene))
        .route("/runs", get(runs_list).post(runs_submit))
        .nest("/runs/{run}", run)
        .route("/studies", get(study_list).post(study_submit))
        .route("/studies/check", post(study_check))
        .route("/studies/{study}", get(study_table))
        .route("/studies/{study}/table.csv", get(study_csv))
        .route("/studies/{study}/means.csv", get(study_means))
        .route("/studies/{study}/differences.csv", get(study_differences))
        .route(
            "/projects",
            get(projects::project_list).post(projects::project_add),
        )
        .route("/projects/{project}", delete(projects::project_remove))
        .route(
            "/projects/{project}/members/{name}",
            put(projects::member_set).delete(projects::member_remove),
        )
        .route("/inputs", get(input_list))
        .route("/templates", get(template_list))
        .route("/schema", get(scene_schema))
        .route("/events", get(events))
        .route("/users/{name}", delete(accounts::user_remove))
        .route(
            "/sessions",
            get(accounts::session_list).delete(accounts::session_remove_all),
        )
        .route("/sessions/{id}", delete(accounts::session_remove))
        .route("/shares", get(accounts::share_list))
        .route("/shares/{id}", delete(accounts::share_remove))
        .route("/tokens/{id}", delete(accounts::token_remove))
        .route("/hook/test", post(hooks::hook_test))
        .route("/audit", get(audit::audit_list))
        .route("/openapi.json", get(|| async { Json(openapi::document()) }))
        .layer(DefaultBodyLimit::max(LARGEST_BODY))
        .merge(secrets)
        // Streams its body to the disk and counts what comes, whatever the header says.
        .route(
            "/inputs/{sha256}",
            put(input_put)
                .layer(DefaultBodyLimit::disable())
                .delete(input_remove),
        )
        .fallback(|| async { ApiError::not_found() })
        .layer(
            CompressionLayer::new()
                .gzip(true)
                .compress_when(DefaultPredicate::new().and(is_no_download)),
        );
    Router::new()
        .nest("/api/v1", api)
        .route("/healthz", get(|| async { "ok\n" }))
        .route("/metrics", get(live::metrics))
        .fallback(web::page)
        .layer(middleware::from_fn_with_state(app.clone(), audit::record))
        .layer(middleware::from_fn_with_state(app.clone(), guard))
        .with_state(app)
}
