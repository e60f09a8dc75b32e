//! Reads frames: all heads at once, the columns of a frame on request.

use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::message::{
    Batch, CONTINUATION, END_OF_STREAM, body_length, parse_batch, parse_schema, read_column,
};
use super::positioned::read_exact_at;
use super::schema::{TIME, VERSION_KEY};
use super::{Column, ColumnKind, FRAMES_VERSION, Frame, FrameSchema};
use crate::error::FormatError;

/// Facts about a frame that are known without its columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameInfo {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made; in a file without it, the number of the frame.
    pub step: u64,
    /// Number of rows (particles, contacts).
    pub rows: usize,
}

/// Where a message lies in the file, in bytes.
#[derive(Debug, Clone, Copy)]
struct MessageSpan {
    /// Offset of the flatbuffer, behind continuation word and length.
    metadata: u64,
    /// Offset of the body.
    body: u64,
    /// Offset of the next message.
    end: u64,
}

/// Content at an offset where a message may begin.
enum Next {
    End,
    Message {
        flatbuffer: Vec<u8>,
        place: MessageSpan,
    },
}

/// A file of frames, open for reading.
///
/// Opening walks the heads of all messages, not their bodies, so that any frame is found at once. A file that is being written
/// shows the frames that it had then, [`refresh`](Self::refresh) finds those added since. A damaged file gives its whole frames;
/// [`damage`](Self::damage) describes what is wrong behind them, and [`frames`](Self::frames) gives it as its last item.
#[derive(Debug)]
pub struct FrameReader {
    path: PathBuf,
    file: File,
    schema: FrameSchema,
    /// Kinds of all columns of the file, and which of them is the time.
    kinds: Vec<ColumnKind>,
    time_field: usize,
    /// Offset of the first frame, in bytes.
    start: u64,
    frames: Vec<(FrameInfo, MessageSpan)>,
    damage: Option<FormatError>,
}

impl FrameReader {
    /// Opens a file and finds its frames.
    ///
    /// # Errors
    /// When the file cannot be opened, is no Arrow IPC stream, or has columns of types that Mercury does not use.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self, FormatError> {
        let path = path.into();
        let file = File::open(&path)
            .map_err(|e| FormatError::of_file(&path, format!("the file cannot be opened: {e}")))?;
        let mut magic = [0; 6];
        if read_exact_at(&file, &mut magic, 0).is_ok() && &magic == b"ARROW1" {
            let help = "pyarrow.ipc.open_file reads it, pyarrow.ipc.new_stream writes a stream";
            return Err(FormatError {
                expected: "an Arrow IPC stream".to_owned(),
                ..FormatError::of_file(&path, "an Arrow IPC file (Feather)").with_help(help)
            });
        }
        let wrong = |found: String, expected: &str| FormatError {
            expected: expected.to_owned(),
            ..FormatError::of_file(&path, found)
        };
        let expected = "an Arrow IPC stream that begins with its schema";
        let (flatbuffer, place) = match next_message(&file, 0) {
            Ok(Next::Message { flatbuffer, place }) => (flatbuffer, place),
            Ok(Next::End) => return Err(wrong("an empty stream".to_owned(), expected)),
            Err(found) => return Err(wrong(found, expected)),
        };
        let schema = parse_schema(&flatbuffer).map_err(|found| wrong(found, expected))?;
        if let Some(version) = schema.metadata().get(VERSION_KEY)
            && version != FRAMES_VERSION
        {
            let found = format!("frames of version {version}");
            let help = "the file was written by another version of Mercury";
            let expected = format!("version {FRAMES_VERSION}");
            return Err(wrong(found, &expected).with_help(help));
        }
        let (schema, kinds, time_field) =
            FrameSchema::of_arrow(&schema).map_err(|[found, expected]| wrong(found, &expected))?;
        let mut reader = Self {
            path,
            file,
            schema,
            kinds,
            time_field,
            start: place.body,
            frames: Vec::new(),
            damage: None,
        };
        reader.refresh();
        Ok(reader)
    }

    /// Columns and metadata of the file.
    pub fn schema(&self) -> &FrameSchema {
        &self.schema
    }

    /// The file, as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The number of whole frames found.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether no frame was found.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Time, step and number of rows of frame `k`, counted from 0.
    pub fn info(&self, k: usize) -> Option<FrameInfo> {
        self.frames.get(k).map(|(info, _)| *info)
    }

    /// Time, step and number of rows of all frames.
    pub fn infos(&self) -> impl Iterator<Item = FrameInfo> + '_ {
        self.frames.iter().map(|(info, _)| *info)
    }

    /// Problem behind the last whole frame, if there is one.
    pub fn damage(&self) -> Option<&FormatError> {
        self.damage.as_ref()
    }

    /// The offset behind the first `count` frames, in bytes.
    pub(super) fn end_of(&self, count: usize) -> u64 {
        match count.checked_sub(1).and_then(|k| self.frames.get(k)) {
            Some((_, place)) => place.end,
            None => self.start,
        }
    }

    /// Looks for frames that were added since; returns how many there are.
    pub fn refresh(&mut self) -> usize {
        let known = self.len();
        self.damage = None;
        loop {
            match self.next_frame() {
                Ok(Some(frame)) => self.frames.push(frame),
                Ok(None) => break,
                Err(found) => {
                    let plural = if self.len() == 1 { "" } else { "s" };
                    let found = format!("{found} behind {} whole frame{plural}", self.len());
                    let help = if self.is_empty() {
                        "the file was cut or changed after it was written"
                    } else {
                        "the frames before it can be used; the file was cut or changed after it was written"
                    };
                    self.damage = Some(FormatError::of_file(&self.path, found).with_help(help));
                    break;
                }
            }
        }
        self.len() - known
    }

    /// The head of the frame behind those known, `None` at the end of the stream.
    fn next_frame(&mut self) -> Result<Option<(FrameInfo, MessageSpan)>, String> {
        let offset = self.end_of(self.len());
        let (flatbuffer, place) = match next_message(&self.file, offset)? {
            Next::Message { flatbuffer, place } => (flatbuffer, place),
            Next::End => {
                // Arrow lets a stream end without the marker. Our own files never do, so it was lost with what followed.
                let length = self.file.metadata().map_err(|e| e.to_string())?.len();
                if length == offset && self.schema.metadata().contains_key(VERSION_KEY) {
                    return Err("the end of the file without the end-of-stream marker".to_owned());
                }
                return Ok(None);
            }
        };
        let batch = parse_batch(&flatbuffer, &self.kinds)?;
        let time = match batch.time {
            Some(time) => time,
            None => self.time_in_rows(&batch, place)?,
        };
        let info = FrameInfo {
            time,
            step: batch.step.unwrap_or(self.len() as u64),
            rows: batch.rows,
        };
        Ok(Some((info, place)))
    }

    /// The time of a frame of another program, which stands in the rows only.
    fn time_in_rows(&self, batch: &Batch, place: MessageSpan) -> Result<f64, String> {
        match self.column(batch, place, self.time_field, 0..batch.rows)? {
            Column::F64(times) => match times.first() {
                Some(time) if time.is_finite() => Ok(*time),
                Some(time) => Err(format!("the time {time}")),
                None => Err("a frame without rows that does not say its time".to_owned()),
            },
            other => Err(format!("a column `{TIME}` of kind {:?}", other.kind())),
        }
    }

    fn column(
        &self,
        batch: &Batch,
        place: MessageSpan,
        field: usize,
        rows: Range<usize>,
    ) -> Result<Column, String> {
        let read = |bytes: &mut [u8], offset: u64| {
            read_exact_at(&self.file, bytes, place.body + offset)
                .map_err(|e| format!("the file cannot be read: {e}"))
        };
        read_column(batch, &self.kinds, field, rows, &read)
    }

    fn batch(&self, k: usize) -> Result<(FrameInfo, Batch, MessageSpan), FormatError> {
        let Some((info, place)) = self.frames.get(k).copied() else {
            let found = format!("no frame {k}: the file has {}", self.len());
            let lost = self.damage.clone();
            return Err(lost.unwrap_or_else(|| FormatError::of_file(&self.path, found)));
        };
        let mut flatbuffer = vec![0; (place.body - place.metadata) as usize];
        let batch = read_exact_at(&self.file, &mut flatbuffer, place.metadata)
            .map_err(|e| format!("the file cannot be read: {e}"))
            .and_then(|()| parse_batch(&flatbuffer, &self.kinds))
            .map_err(|found| FormatError::of_file(&self.path, format!("frame {k}: {found}")))?;
        Ok((info, batch, place))
    }

    /// Columns of a frame by their places in the schema; some of the rows, or all.
    fn read_columns(
        &self,
        k: usize,
        places: impl Iterator<Item = usize>,
        rows: Option<Range<usize>>,
    ) -> Result<(FrameInfo, Vec<Column>), FormatError> {
        let (info, batch, place) = self.batch(k)?;
        let rows = rows.unwrap_or(0..batch.rows);
        if rows.end > batch.rows || rows.start > rows.end {
            let found = format!("no rows {rows:?} in frame {k}, which has {}", batch.rows);
            return Err(FormatError::of_file(&self.path, found));
        }
        let columns = places.map(|column| {
            // The schema leaves the time out, the file has it.
            let field = column + usize::from(column >= self.time_field);
            self.column(&batch, place, field, rows.clone())
                .map_err(|found| {
                    let name = &self.schema.columns()[column].name;
                    let found = format!("frame {k}, column {name}: {found}");
                    FormatError::of_file(&self.path, found)
                })
        });
        Ok((info, columns.collect::<Result<_, _>>()?))
    }

    /// Frame `k`, counted from 0.
    ///
    /// # Errors
    /// When there is no such frame or its bytes are damaged.
    pub fn frame(&self, k: usize) -> Result<Frame, FormatError> {
        let (info, columns) = self.read_columns(k, 0..self.schema.columns().len(), None)?;
        Ok(Frame {
            time: info.time,
            step: info.step,
            columns,
        })
    }

    /// Some columns of frame `k` in the order of `names`; the others are not read from the disk.
    ///
    /// # Errors
    /// When there is no such frame or column, or the bytes are damaged.
    pub fn columns(&self, k: usize, names: &[&str]) -> Result<Vec<Column>, FormatError> {
        let mut places = Vec::with_capacity(names.len());
        for name in names {
            let place = self.schema.index_of(name);
            let missing = || FormatError::of_file(&self.path, format!("no column `{name}`"));
            places.push(place.ok_or_else(missing)?);
        }
        Ok(self.read_columns(k, places.into_iter(), None)?.1)
    }

    /// Some rows of a column of frame `k`, counted from 0; nothing else is read from the disk, but for the head of the frame.
    ///
    /// # Errors
    /// When there is no such frame or column, the frame has fewer rows, or the bytes are damaged.
    pub fn rows(&self, k: usize, name: &str, rows: Range<usize>) -> Result<Column, FormatError> {
        let place = self.schema.index_of(name);
        let missing = || FormatError::of_file(&self.path, format!("no column `{name}`"));
        let (_, mut columns) = self.read_columns(k, place.into_iter(), Some(rows))?;
        columns.pop().ok_or_else(missing)
    }

    /// All frames, one in memory at a time; if the file is damaged, what is wrong comes last, once.
    pub fn frames(&self) -> impl Iterator<Item = Result<Frame, FormatError>> + '_ {
        let damage = self.damage.iter().cloned().map(Err);
        (0..self.len()).map(|k| self.frame(k)).chain(damage)
    }
}

/// Reads the head of the message at an offset and makes sure that its body is in the file.
fn next_message(file: &File, offset: u64) -> Result<Next, String> {
    let length_now = || match file.metadata() {
        Ok(metadata) => Ok(metadata.len()),
        Err(e) => Err(format!("the file cannot be read: {e}")),
    };
    if length_now()? <= offset {
        return Ok(Next::End);
    }
    let cut = |what: &str| format!("a {what} that goes beyond the end of the file");
    let mut prefix = [0; 8];
    read_exact_at(file, &mut prefix, offset).map_err(|_| cut("message"))?;
    if prefix == END_OF_STREAM {
        return Ok(Next::End);
    }
    // Only now: a writer makes the file longer first and shows the message then, so the length is new enough for what
    // the prefix promises.
    let file_length = length_now()?;
    let [a, b, c, d, length @ ..] = prefix;
    if [a, b, c, d] != CONTINUATION {
        return Err(format!("no Arrow message at byte {offset}"));
    }
    let length = u64::try_from(i32::from_le_bytes(length))
        .map_err(|_| format!("a message of negative length at byte {offset}"))?;
    let metadata = offset + 8;
    let body = metadata + length;
    if body > file_length {
        return Err(cut("message"));
    }
    let mut flatbuffer = vec![0; length as usize];
    read_exact_at(file, &mut flatbuffer, metadata).map_err(|e| format!("no message: {e}"))?;
    let end = body_length(&flatbuffer)
        .ok_or_else(|| format!("no Arrow message at byte {offset}"))?
        .checked_add(body)
        .filter(|&end| end <= file_length)
        .ok_or_else(|| cut("frame"))?;
    let place = MessageSpan {
        metadata,
        body,
        end,
    };
    Ok(Next::Message { flatbuffer, place })
}
