//! Files of runs as they are fetched: one by one, in parts, or all in one archive.

use std::io::{self, Write};
use std::sync::Arc;

use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::Response;
use cloud_api::answers::RunFile;
use cloud_api::{Head, RunId};
use tokio_stream::Stream;
use tokio_stream::wrappers::ReceiverStream;

use crate::access::{ApiError, LoggedIn};
use crate::content::{Content, PIECE};
use crate::routes::{Answer, Shared, headed};
use crate::runs::{blocking, visible_run};
use crate::state::App;

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
fn range(headers: &HeaderMap, bytes: u64) -> Result<Option<(u64, u64)>, ApiError> {
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
        ApiError::new(
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
    ReceiverStream::new(receive)
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
) -> Result<Response, ApiError> {
    let shared = Arc::clone(&app);
    let file = name.clone();
    let content = blocking(move || {
        let (id, head) = headed(&shared, &user, &id)?;
        Content::of(&id, &head, &file).ok_or_else(ApiError::not_found)
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
        .map_err(ApiError::internal)
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
) -> Result<Response, ApiError> {
    let shared = Arc::clone(&app);
    let (id, head, spec) = blocking(move || {
        let (id, _, _, _, spec) = visible_run(&shared, &user, &id)?;
        let head = shared.head(&id)?.ok_or_else(ApiError::not_found)?;
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
        .body(Body::from_stream(ReceiverStream::new(receive)))
        .map_err(ApiError::internal)
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
