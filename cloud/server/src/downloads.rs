//! Files of runs as they are fetched: one by one, in parts, or all in one archive.

use std::io;
use std::ops::Range;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
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
use crate::archive::{self, Member};
use crate::content::{Content, tag_of};
use crate::routes::{Answer, Shared, headed};
use crate::runs::{blocking, visible_run};
use crate::secrets::Caller;
use crate::state::App;
use crate::turns::{Turn, Turns};

/// The files that a head names.
pub(crate) fn files(head: &Head) -> Vec<RunFile> {
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

/// Bytes `first..=last` that a `Range` header asks for; `None`: all. A range of other bytes than those with `tag` is all of these.
fn range(headers: &HeaderMap, tag: &str, bytes: u64) -> Result<Option<(u64, u64)>, ApiError> {
    if (headers.get(header::IF_RANGE)).is_some_and(|wanted| wanted.as_bytes() != tag.as_bytes()) {
        return Ok(None);
    }
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

    /// Sends what of a piece at byte `at` lies in `range`. `false`: the listener has gone, or reads too slowly.
    async fn send_part(&self, piece: Vec<u8>, at: u64, range: &Range<u64>) -> bool {
        let piece = part(piece, at, range);
        if piece.is_empty() {
            return !self.send.is_closed();
        }
        self.send(piece).await
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

/// A download, or the part of it that a `Range` header names: with its length, and a tag by which a part is known to be of the same bytes.
fn answer(
    headers: &HeaderMap,
    kind: &str,
    disposition: String,
    tag: &str,
    bytes: u64,
    stream: impl FnOnce(u64, u64) -> Pieces,
) -> Result<Response, ApiError> {
    let range = range(headers, tag, bytes)?;
    let (first, end) = range.map_or((0, bytes), |(first, last)| (first, last + 1));
    let mut answer = Response::builder()
        .header(header::CONTENT_TYPE, kind)
        .header(header::CONTENT_LENGTH, end - first)
        .header(header::ACCEPT_RANGES, "bytes")
        .header(header::ETAG, tag)
        .header(header::CONTENT_DISPOSITION, disposition);
    if let Some((first, last)) = range {
        let part = format!("bytes {first}-{last}/{bytes}");
        answer = answer
            .status(StatusCode::PARTIAL_CONTENT)
            .header(header::CONTENT_RANGE, part);
    }
    answer
        .body(Body::from_stream(stream(first, end)))
        .map_err(ApiError::internal)
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
    // Pictures are shown within the page; all else is saved, whatever it claims to be.
    let picture = name.ends_with(".png");
    let kind = if picture {
        "image/png"
    } else {
        "application/octet-stream"
    };
    let how = if picture { "inline" } else { "attachment" };
    let disposition = format!("{how}; filename=\"{}\"", saved_as(&name));
    let (tag, bytes) = (content.tag(), content.bytes());
    answer(&headers, kind, disposition, &tag, bytes, |first, end| {
        stream(app, turn, content, first, end)
    })
}

/// All files of a run as one .zip, or the part of it that a `Range` header names.
#[utoipa::path(get, path = "/api/v1/runs/{run}/archive", params(("run" = String, Path)),
    responses((status = 200, content_type = "application/zip"), (status = 206, content_type = "application/zip")))]
pub(crate) async fn run_archive(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path(id): Path<String>,
    headers: HeaderMap,
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
    let (members, contents): (Vec<Member>, Vec<Content>) = all
        .into_iter()
        .map(|(name, content)| {
            let bytes = content.bytes();
            (
                Member {
                    name,
                    bytes,
                    crc: 0,
                },
                content,
            )
        })
        .unzip();
    let tags = members.iter().zip(&contents);
    let tags: Vec<String> = tags
        .map(|(member, content)| format!("{} {}", member.name, content.tag()))
        .collect();
    let tag = tag_of(&tags.join("\n"));
    let disposition = format!("attachment; filename=\"{}.zip\"", saved_as(prefix));
    let bytes = archive::length(&members);
    answer(
        &headers,
        "application/zip",
        disposition,
        &tag,
        bytes,
        |first, end| {
            let (sender, pieces) = Pieces::new(turn);
            tokio::spawn(send_archive(app, members, contents, first..end, sender));
            pieces
        },
    )
}

/// The part of `bytes`, which begin at byte `at`, that lies in `range`.
fn part(bytes: Vec<u8>, at: u64, range: &Range<u64>) -> Vec<u8> {
    let end = at + bytes.len() as u64;
    let (from, to) = (range.start.clamp(at, end), range.end.clamp(at, end));
    bytes[(from - at) as usize..(to - at) as usize].to_vec()
}

/// Sends bytes `range` of an archive. What lies before it is read for the checksums behind files, unless an earlier reader has done that.
async fn send_archive(
    app: Arc<App>,
    mut members: Vec<Member>,
    contents: Vec<Content>,
    range: Range<u64>,
    sender: Sender,
) {
    let mut at = 0;
    for (member, content) in members.iter_mut().zip(contents) {
        let head = member.head();
        let begin = at + head.len() as u64;
        if !sender.send_part(head, at, &range).await {
            return;
        }
        let content = Arc::new(content);
        let tag = content.tag();
        let mut sum = app.sums.of(&tag);
        let mut read_to = sum.bytes.min(range.start.saturating_sub(begin));
        while read_to < content.bytes() && begin + read_to < range.end {
            let (app, content, tag) = (Arc::clone(&app), Arc::clone(&content), tag.clone());
            let done = piece(move || {
                let bytes = read(&app, &content, read_to, content.bytes())?;
                sum.add(read_to, &bytes);
                app.sums.keep(&tag, &sum);
                Ok((bytes, sum))
            });
            let Some((bytes, so_far)) = done.await else {
                return;
            };
            sum = so_far;
            let from = begin + read_to;
            read_to += bytes.len() as u64;
            if !sender.send_part(bytes, from, &range).await {
                return;
            }
        }
        member.crc = sum.crc();
        at = begin + content.bytes();
        let tail = member.tail();
        let end = at + tail.len() as u64;
        if !sender.send_part(tail, at, &range).await {
            return;
        }
        at = end;
        if at >= range.end {
            return sender.finish();
        }
    }
    if sender
        .send_part(archive::directory(&members), at, &range)
        .await
    {
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
