//! Routes of what a run has written: its log, tables, charts and frames.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use cloud_api::answers::{Chart, TableInfo};
use cloud_api::{Head, RunId};
use cloud_store::StoreError;
use serde::Deserialize;
use serde_json::{Value, json};

use super::{Answer, QueryParams, Shared};
use crate::access::{Anyone, ApiError};
use crate::content::Content;
use crate::downloads::{holding, turn};
use crate::runs::{VisibleRun, blocking, visible_run};
use crate::secrets::Caller;
use crate::state::App;
use crate::{charts, check, frames};

/// The most that a request for the log gets, in bytes.
const MOST_LOG: u64 = 256 << 10;

/// A run that a user or guest may see, with its head.
pub(crate) fn headed(app: &App, caller: &Caller, id: &str) -> Result<(RunId, Head), ApiError> {
    let VisibleRun { id, .. } = visible_run(app, caller, id)?;
    let head = app.head(&id)?.ok_or_else(ApiError::not_found)?;
    Ok((id, head))
}

/// Does something with files of a run. Pieces that were joined since the head was read are looked for again.
fn with_files<T>(
    app: &App,
    caller: &Caller,
    id: &str,
    work: impl Fn(&RunId, &Head) -> Result<T, anyhow::Error>,
) -> Result<T, ApiError> {
    for _ in 0..3 {
        let (id, head) = headed(app, caller, id)?;
        match work(&id, &head) {
            Err(error)
                if error
                    .chain()
                    .any(|cause| matches!(cause.downcast_ref(), Some(StoreError::Missing(_)))) => {}
            result => return Ok(result?),
        }
    }
    Err(ApiError::new(
        StatusCode::SERVICE_UNAVAILABLE,
        "the store is busy",
        "Try again.",
    ))
}

#[derive(Deserialize)]
pub(crate) struct LogQuery {
    from: Option<u64>,
    attempt: Option<u64>,
}

/// The report of a run from byte `from` on; with `attempt` the lines of that attempt as they come. The last 256 kB at most.
#[utoipa::path(get, path = "/api/v1/runs/{run}/log", params(("run" = String, Path), ("from" = Option<u64>, Query), ("attempt" = Option<u64>, Query)),
    responses((status = 200, body = Object)))]
pub(crate) async fn run_log(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path(id): Path<String>,
    QueryParams(query): QueryParams<LogQuery>,
) -> Answer<Value> {
    blocking(move || {
        if let Some(attempt) = query.attempt {
            let run = visible_run(&app, &caller, &id)?;
            let text = app
                .store
                .get(&format!("runs/{}/log/{attempt}.txt", run.id))?;
            let text = text.unwrap_or_default();
            return Ok(Json(
                json!({"text": String::from_utf8_lossy(&text), "from": 0, "next": text.len()}),
            ));
        }
        with_files(&app, &caller, &id, |id, head| {
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
    Anyone(caller): Anyone,
    Path(id): Path<String>,
) -> Answer<Vec<TableInfo>> {
    blocking(move || {
        with_files(&app, &caller, &id, |id, head| {
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
    Anyone(caller): Anyone,
    Path(id): Path<String>,
    QueryParams(query): QueryParams<ChartQuery>,
) -> Answer<Chart> {
    blocking(move || {
        let chart = with_files(&app, &caller, &id, |id, head| {
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
        chart.map(Json).ok_or_else(ApiError::not_found)
    })
    .await
}

/// The frames of a run so far, with their times.
#[utoipa::path(get, path = "/api/v1/runs/{run}/frames", params(("run" = String, Path)), responses((status = 200, body = Object)))]
pub(crate) async fn run_frames(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path(id): Path<String>,
) -> Answer<Value> {
    blocking(move || {
        with_files(&app, &caller, &id, |id, head| {
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
    Anyone(caller): Anyone,
    Path((id, k)): Path<(String, String)>,
    QueryParams(query): QueryParams<FrameQuery>,
) -> Result<Response, ApiError> {
    let k: usize = k.parse().map_err(|_| ApiError::not_found())?;
    let columns: Vec<String> = query
        .columns
        .split(',')
        .filter(|name| !name.is_empty())
        .map(str::to_owned)
        .collect();
    if columns.len() > 8 {
        return Err(ApiError::bad_request(
            "too many columns",
            "At most 8 at once.",
        ));
    }
    let most = query.most.clamp(1, 10_000_000);
    let turn = turn(&app.frames, &caller).await?;
    let frame = blocking(move || {
        with_files(&app, &caller, &id, |id, head| {
            frames::frame(&app.cache, app.store.as_ref(), id, head, k, &columns, most)
        })
    });
    let bytes = frame.await?.ok_or_else(ApiError::not_found)?;
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
        holding(bytes, Arc::new(turn)),
    )
        .into_response())
}

/// All columns of one particle in a frame.
#[utoipa::path(get, path = "/api/v1/runs/{run}/frames/{k}/grains/{id}", params(("run" = String, Path), ("k" = u32, Path), ("id" = u32, Path)), responses((status = 200, body = Vec<Object>)))]
pub(crate) async fn run_grain(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path((id, k, grain)): Path<(String, String, String)>,
) -> Answer<Value> {
    let (Ok(k), Ok(grain)) = (k.parse(), grain.parse()) else {
        return Err(ApiError::not_found());
    };
    blocking(move || {
        let row = with_files(&app, &caller, &id, |id, head| {
            frames::row(&app.cache, app.store.as_ref(), id, head, k, grain)
        })?;
        row.map(Json).ok_or_else(ApiError::not_found)
    })
    .await
}

/// The walls at a frame: triangles, and where they are. They have 200,000 triangles at most; `triangles` is how many they have, and had.
#[utoipa::path(get, path = "/api/v1/runs/{run}/frames/{k}/walls", params(("run" = String, Path), ("k" = u32, Path)), responses((status = 200, body = Object)))]
pub(crate) async fn run_walls(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path((id, k)): Path<(String, String)>,
) -> Result<Response, ApiError> {
    let k: usize = k.parse().map_err(|_| ApiError::not_found())?;
    let held = turn(&app.frames, &caller).await?;
    let turn = app.views.take(caller.turns()).await?;
    let walls = blocking(move || {
        let _turn = turn;
        let walls = with_files(&app, &caller, &id, |id, head| {
            let folder = frames::folder(&app.cache, app.store.as_ref(), id, head)?;
            check::view(&app, &folder, Some(k))
        })?;
        walls.ok_or_else(ApiError::not_found)
    });
    let walls = holding(walls.await?, Arc::new(held));
    Ok(([(header::CONTENT_TYPE, "application/json")], walls).into_response())
}
