//! Files of runs as they are fetched: one by one, in parts, or all in one archive.

use std::io::{self, Write};
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::Response;
use cloud_api::answers::RunFile;
use cloud_api::{Head, RunId};
use tokio::sync::mpsc;
use tokio_stream::Stream;

use crate::access::{Anyone, ApiError};
use crate::content::Content;
use crate::routes::{Answer, Shared, headed};
use crate::runs::{blocking, visible_run};
use crate::secrets::Caller;
use crate::state::App;
use crate::turns::{Turn, Turns};

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
    Anyone(caller): Anyone,
    Path(id): Path<String>,
) -> Answer<Vec<RunFile>> {
    blocking(move || Ok(Json(files(&headed(&app, &caller, &id)?.1)))).await
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

/// The most downloads of a user at once, and of all links to runs of that user.
pub(crate) const EACH: usize = 16;

/// The most downloads at once, of all users together.
pub(crate) const ALL: usize = 128;

/// How long a download waits for its turn.
const TURN: Duration = Duration::from_secs(10);

/// The longest time for a piece of [`crate::content::PIECE`] bytes, which makes the slowest download 17 kB/s.
const SLOWEST: Duration = Duration::from_secs(60);

/// The most frames and walls of a user that are made and read at once, and of all links to runs of that user.
pub(crate) const EACH_FRAMES: usize = 8;

/// The most frames and walls at once, of all users together.
pub(crate) const ALL_FRAMES: usize = 32;

/// Waits for the turn of a download or a frame; not for ever.
pub(crate) async fn turn(turns: &Turns, caller: &Caller) -> Result<Turn, ApiError> {
    let turn = turns.take(caller.turns());
    match tokio::time::timeout(TURN, turn).await {
        Ok(turn) => turn,
        Err(_) => Err(ApiError::too_many(
            "too many requests at once",
            "Earlier ones have not ended. Wait until one has.",
            TURN.as_secs(),
        )),
    }
}

/// Bytes of an answer, with its turn: they hold it until the last of them is read.
struct Held {
    bytes: Vec<u8>,
    _turn: Arc<Turn>,
}

impl AsRef<[u8]> for Held {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Bytes that hold a turn until they are read.
pub(crate) fn holding(bytes: Vec<u8>, turn: Arc<Turn>) -> Bytes {
    Bytes::from_owner(Held { bytes, _turn: turn })
}

/// Sends pieces of a download to its listener.
struct Sender {
    send: mpsc::Sender<Bytes>,
    whole: Arc<AtomicBool>,
    /// Held until the last piece is read.
    turn: Arc<Turn>,
}

impl Sender {
    /// Sends a piece. `false`: the listener has gone, or reads too slowly.
    async fn send(&self, piece: Vec<u8>) -> bool {
        let piece = holding(piece, Arc::clone(&self.turn));
        let sent = tokio::time::timeout(SLOWEST, self.send.send(piece));
        matches!(sent.await, Ok(Ok(())))
    }

    /// Records that all pieces were sent.
    fn finish(self) {
        self.whole.store(true, Ordering::Release);
    }
}

/// Pieces of a download. A download that ends early ends in an error, so that the connection is cut.
struct Pieces {
    receive: mpsc::Receiver<Bytes>,
    whole: Arc<AtomicBool>,
}

impl Pieces {
    fn new(turn: Turn) -> (Sender, Self) {
        let (send, receive) = mpsc::channel(1);
        let whole = Arc::new(AtomicBool::new(false));
        let sender = Sender {
            send,
            whole: Arc::clone(&whole),
            turn: Arc::new(turn),
        };
        (sender, Self { receive, whole })
    }
}

impl Stream for Pieces {
    type Item = io::Result<Bytes>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.receive.poll_recv(context).map(|piece| match piece {
            Some(piece) => Some(Ok(piece)),
            None if self.whole.swap(true, Ordering::Acquire) => None,
            None => Some(Err(io::ErrorKind::UnexpectedEof.into())),
        })
    }
}

/// Work of a download that waits for disks. An error is in the log; the listener sees that the connection is cut.
async fn piece<T: Send + 'static>(
    work: impl FnOnce() -> anyhow::Result<T> + Send + 'static,
) -> Option<T> {
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(anyhow::Error::from)
        .flatten()
        .inspect_err(|error| eprintln!("a download ends early: {error:#}"))
        .ok()
}

/// A part of a content that is not empty.
fn read(app: &App, content: &Content, from: u64, to: u64) -> anyhow::Result<Vec<u8>> {
    let bytes = content.read(app.store.as_ref(), from..to)?;
    anyhow::ensure!(!bytes.is_empty(), "a file is shorter than it was");
    Ok(bytes)
}

/// Bytes `from..to` of a content, as they are read.
fn stream(app: Arc<App>, turn: Turn, content: Content, from: u64, to: u64) -> Pieces {
    let (sender, pieces) = Pieces::new(turn);
    let content = Arc::new(content);
    tokio::spawn(async move {
        let mut at = from;
        while at < to {
            let (app, content) = (Arc::clone(&app), Arc::clone(&content));
            let Some(bytes) = piece(move || read(&app, &content, at, to)).await else {
                return;
            };
            at += bytes.len() as u64;
            if !sender.send(bytes).await {
                return;
            }
        }
        sender.finish();
    });
    pieces
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
    Anyone(caller): Anyone,
    Path((id, name)): Path<(String, String)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let turn = turn(&app.downloads, &caller).await?;
    let shared = Arc::clone(&app);
    let file = name.clone();
    let content = blocking(move || {
        let (id, head) = headed(&shared, &caller, &id)?;
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
        .body(Body::from_stream(stream(app, turn, content, first, end)))
        .map_err(ApiError::internal)
}

/// A writer that keeps bytes until they are taken.
#[derive(Clone, Default)]
struct Packed(Arc<Mutex<Vec<u8>>>);

impl Packed {
    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<u8>> {
        self.0
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.lock())
    }
}

impl Write for Packed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.lock().extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// All files of a run as one .zip.
#[utoipa::path(get, path = "/api/v1/runs/{run}/archive", params(("run" = String, Path)), responses((status = 200, content_type = "application/zip")))]
pub(crate) async fn run_archive(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path(id): Path<String>,
) -> Result<Response, ApiError> {
    let turn = turn(&app.downloads, &caller).await?;
    let shared = Arc::clone(&app);
    let (id, head, spec) = blocking(move || {
        let run = visible_run(&shared, &caller, &id)?;
        let head = shared.head(&run.id)?.ok_or_else(ApiError::not_found)?;
        Ok((run.id, head, run.spec))
    })
    .await?;
    let prefix = spec.scene.trim_end_matches(".toml");
    let mut all: Vec<(String, Content)> = (spec.files.iter())
        .map(|(name, input)| (name.clone(), Content::of_input(input)))
        .collect();
    all.extend(files(&head).into_iter().filter_map(|file| {
        let content = Content::of(&id, &head, &file.name)?;
        Some((format!("{prefix}/{}", file.name), content))
    }));
    let name = saved_as(prefix);
    let (sender, pieces) = Pieces::new(turn);
    tokio::spawn(archive(app, all, sender));
    Response::builder()
        .header(header::CONTENT_TYPE, "application/zip")
        .header(
            header::CONTENT_DISPOSITION,
            format!("attachment; filename=\"{name}.zip\""),
        )
        .body(Body::from_stream(pieces))
        .map_err(ApiError::internal)
}

/// Sends a .zip of these files: a piece is read and packed while the listener has the one before.
async fn archive(app: Arc<App>, files: Vec<(String, Content)>, sender: Sender) {
    let held = Packed::default();
    let mut zip = zip::ZipWriter::new_stream(held.clone());
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, content) in files {
        let options = options.large_file(content.bytes() >= u64::from(u32::MAX));
        let content = Arc::new(content);
        let begun = piece(move || {
            zip.start_file(name, options)?;
            Ok(zip)
        });
        let Some(begun) = begun.await else { return };
        zip = begun;
        let mut at = 0;
        while at < content.bytes() {
            let (app, content) = (Arc::clone(&app), Arc::clone(&content));
            let packed = piece(move || {
                let bytes = read(&app, &content, at, content.bytes())?;
                zip.write_all(&bytes)?;
                Ok((zip, at + bytes.len() as u64))
            });
            let Some(packed) = packed.await else { return };
            (zip, at) = packed;
            if !sender.send(held.take()).await {
                return;
            }
        }
    }
    let finished = piece(move || Ok(zip.finish()?.flush()?)).await;
    if finished.is_some() && sender.send(held.take()).await {
        sender.finish();
    }
}

#[cfg(test)]
mod tests {
    use tokio_stream::StreamExt;

    use super::*;

    /// What is sent but not read yet holds its turn.
    #[tokio::test]
    async fn a_turn_is_held_until_the_last_byte_is_read() {
        let turns = Turns::new(1, 1);
        let is_free = || {
            let turn = turns.take((1, false));
            tokio::time::timeout(Duration::from_millis(20), turn)
        };
        let (sender, mut pieces) = Pieces::new(is_free().await.unwrap().unwrap());
        assert!(sender.send(vec![1, 2, 3]).await);
        sender.finish();
        assert!(is_free().await.is_err(), "nothing was read");
        let piece = pieces.next().await.unwrap().unwrap();
        assert!(is_free().await.is_err(), "the piece is there");
        assert_eq!(&piece[..], [1, 2, 3]);
        drop(piece);
        assert!(is_free().await.is_ok());
    }
}
