//! Routes of scenes: checks, previews, files that scenes name, and scenes to start from.

use std::io::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::Json;
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use cloud_api::answers::{Checked, InputRow, Template};
use cloud_api::requests::Check;
use cloud_store::Hashing;
use tokio_stream::StreamExt;

use super::{Answer, JsonBody, Shared};
use crate::access::{Anyone, ApiError, LoggedIn, not_logged_in};
use crate::db::{Forgotten, Reserved};
use crate::runs::{blocking, full};
use crate::state::App;
use crate::{check, inputs};

/// The largest input, in bytes.
const LARGEST_INPUT: u64 = 2 << 30;

/// How long an upload may pause.
const SILENCE: Duration = Duration::from_secs(30);

/// The slowest upload after that time, in bytes per second.
const SLOWEST: f64 = 17e3;

fn too_slow() -> ApiError {
    ApiError::new(
        StatusCode::REQUEST_TIMEOUT,
        "the body is too slow",
        "An upload has at least 17 kB/s.",
    )
}

/// Problems of a scene, or its needs: memory, disk, steps, and with `trial` time.
#[utoipa::path(post, path = "/api/v1/check", request_body = Check, responses((status = 200, body = Checked)))]
pub(crate) async fn check_scene(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    JsonBody(body): JsonBody<Check>,
) -> Answer<Checked> {
    Ok(Json(
        check::check(&app, user.id, body.scene, body.trial).await?,
    ))
}

/// Walls and first particles of a scene. Walls have 200,000 triangles at most; `triangles` is how many they have, and had.
#[utoipa::path(post, path = "/api/v1/preview", request_body = Check, responses((status = 200, body = Object)))]
pub(crate) async fn preview_scene(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    JsonBody(body): JsonBody<Check>,
) -> Result<Response, ApiError> {
    let seen = check::preview(&app, user.id, body.scene).await?;
    Ok(([(header::CONTENT_TYPE, "application/json")], seen).into_response())
}

/// How much is reserved at a time for an upload of unknown length, in bytes.
const STEP: u64 = 1 << 20;

/// Disk of a user that is reserved for an upload, until it ends.
struct Reservation {
    app: Arc<App>,
    user: i64,
    bytes: u64,
}

impl Reservation {
    /// Reserves what is known of the length, or a step, or, near the limit, what has come.
    fn grow(mut self, came: u64, length: Option<u64>) -> Result<Self, ApiError> {
        let wanted = length.unwrap_or(came + STEP).max(came);
        for whole in [wanted, came] {
            let more = whole - self.bytes;
            match self.app.db.reserve_upload(self.user, more)? {
                Reserved::Done(()) => {
                    self.bytes = whole;
                    return Ok(self);
                }
                Reserved::Full(usage) if whole == came || length.is_some() => {
                    return Err(full(&usage, more));
                }
                Reserved::Full(_) => {}
                Reserved::NoUser | Reserved::NoInput => return Err(not_logged_in()),
            }
        }
        Ok(self)
    }

    /// The content has come whole.
    fn keep(mut self, sha256: &str, bytes: u64) -> rusqlite::Result<Reserved<()>> {
        let reserved = std::mem::take(&mut self.bytes);
        let input = Some((sha256, bytes));
        self.app.db.end_upload(self.user, reserved, input)
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        if self.bytes > 0
            && let Err(error) = self.app.db.end_upload(self.user, self.bytes, None)
        {
            eprintln!("{error}");
        }
    }
}

/// Sends a content that scenes can name by its SHA-256; at most 2 GB.
#[utoipa::path(put, path = "/api/v1/inputs/{sha256}", params(("sha256" = String, Path)), request_body(content_type = "application/octet-stream"), responses((status = 201)))]
pub(crate) async fn input_put(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(sha256): Path<String>,
    headers: HeaderMap,
    body: Body,
) -> Result<StatusCode, ApiError> {
    let digits = sha256.len() == 64
        && sha256
            .bytes()
            .all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b));
    if !digits {
        return Err(ApiError::bad_request(
            "invalid path",
            "SHA256 has 64 hexadecimal digits in lower case.",
        ));
    }
    let mut reservation = Reservation {
        app: Arc::clone(&app),
        user: user.id,
        bytes: 0,
    };
    // What comes is counted, whatever the header says.
    let length = headers.get(header::CONTENT_LENGTH);
    let length = length.and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    let length = length.map(|length| length.min(LARGEST_INPUT));
    let file = tempfile::tempfile_in(app.options.data.join("checks"))?;
    let mut hashing = Hashing::new(file);
    let mut bytes = 0;
    let mut pieces = body.into_data_stream();
    let begin = Instant::now();
    loop {
        let Ok(piece) = tokio::time::timeout(SILENCE, pieces.next()).await else {
            return Err(too_slow());
        };
        let Some(piece) = piece else { break };
        let piece = piece
            .map_err(|error| ApiError::bad_request("the body was cut off", error.to_string()))?;
        bytes += piece.len() as u64;
        if begin.elapsed() > SILENCE && (bytes as f64) < SLOWEST * begin.elapsed().as_secs_f64() {
            return Err(too_slow());
        }
        if bytes > LARGEST_INPUT {
            return Err(ApiError::new(
                StatusCode::PAYLOAD_TOO_LARGE,
                "the file is too large",
                "A file has at most 2 GB.",
            ));
        }
        if bytes > reservation.bytes {
            reservation = blocking(move || reservation.grow(bytes, length)).await?;
        }
        hashing.write_all(&piece)?;
    }
    let (got, mut file) = hashing.finish();
    if got != sha256 {
        return Err(ApiError::bad_request(
            "the content is another",
            format!("Its SHA-256 is {got}."),
        ));
    }
    blocking(move || {
        let put = || {
            let key = inputs::key(&sha256);
            app.store.put_file(&key, &mut file, 0..bytes)?;
            Ok(())
        };
        let record = || reservation.keep(&sha256, bytes);
        inputs::keep(&app, &sha256, bytes, put, record)?;
        Ok(StatusCode::CREATED)
    })
    .await
}

/// Contents that this user has sent, the largest first; at most 200. They go with the last run that names them.
#[utoipa::path(get, path = "/api/v1/inputs", responses((status = 200, body = Vec<InputRow>)))]
pub(crate) async fn input_list(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
) -> Answer<Vec<InputRow>> {
    blocking(move || Ok(Json(app.db.inputs(user.id)?))).await
}

/// Removes a content that this user has sent, and that no run names.
#[utoipa::path(delete, path = "/api/v1/inputs/{sha256}", params(("sha256" = String, Path)), responses((status = 204)))]
pub(crate) async fn input_remove(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(sha256): Path<String>,
) -> Result<StatusCode, ApiError> {
    blocking(move || match inputs::take(&app, user.id, &sha256)? {
        Forgotten::Missing => Err(ApiError::not_found()),
        Forgotten::Named => Err(ApiError::new(
            StatusCode::CONFLICT,
            "the input is in use",
            "A run names it. It goes with the last of them.",
        )),
        Forgotten::Done => Ok(StatusCode::NO_CONTENT),
    })
    .await
}

/// Scenes to start from.
#[utoipa::path(get, path = "/api/v1/templates", responses((status = 200, body = Vec<Template>)))]
pub(crate) async fn template_list(State(app): Shared, Anyone(_): Anyone) -> Answer<Vec<Template>> {
    Ok(Json(app.templates.clone()))
}

/// The JSON schema of scenes.
#[utoipa::path(get, path = "/api/v1/schema", responses((status = 200, body = Object)))]
pub(crate) async fn scene_schema(State(app): Shared, Anyone(_): Anyone) -> impl IntoResponse {
    let kind = (header::CONTENT_TYPE, "application/json");
    ([kind], app.schema.clone())
}
