//! Appends frames to a file that is a complete Arrow stream at every instant.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::message::{END_OF_STREAM, encode, encode_schema, write_body};
use super::positioned::{Cursor, WriteAt};
use super::reader::FrameReader;
use super::{Frame, FrameSchema, SchemaError};
use crate::error::FormatError;
use crate::whole_file::{FileError, WholeFile};

/// Bytes collected before they go to the operating system.
const BUFFER: usize = 256 * 1024;

/// Why frames could not be written.
#[derive(Debug, thiserror::Error)]
pub enum FrameWriteError {
    /// The operating system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// A frame does not fit the schema of the file, or does not come after the frame before.
    #[error("{}: frame at step {step}: {reason}", path.display())]
    Frame {
        /// The file.
        path: PathBuf,
        /// The step of the frame that was refused.
        step: u64,
        /// Description of the mismatch.
        reason: String,
    },
    /// The columns cannot be a schema.
    #[error(transparent)]
    Schema(#[from] SchemaError),
    /// The file to be continued is no file of frames, or one of another schema.
    #[error(transparent)]
    Format(#[from] FormatError),
}

/// Writes a file of frames; others may read the file all the while.
///
/// The file always ends in Arrow's end-of-stream marker, and a frame is appended in two strokes: everything but the first 8 bytes
/// of its message, with a new marker behind it, goes *after* the old marker, where no reader looks; then the first 8 bytes
/// replace the old marker. A reader sees the old end or the whole frame, also if the writing process died between any two writes.
/// (After a loss of power the order of the two strokes on the disk is only certain for frames before the last
/// [`sync`](Self::sync).)
#[derive(Debug)]
pub struct FrameWriter {
    path: PathBuf,
    file: File,
    schema: FrameSchema,
    /// Offset of the end-of-stream marker, in bytes.
    marker: u64,
    frames: usize,
    last_step: Option<u64>,
}

impl FrameWriter {
    /// Creates a file without frames; a file of that name is replaced.
    ///
    /// The file is made under a temporary name beside `path` and renamed, so that no reader sees half a schema.
    ///
    /// # Errors
    /// [`FrameWriteError::File`] when the file cannot be made.
    pub fn create(path: impl Into<PathBuf>, schema: FrameSchema) -> Result<Self, FrameWriteError> {
        let path = path.into();
        let bytes = encode_schema(&schema.to_arrow()).ok_or_else(|| {
            let error = io::Error::other("too many columns");
            FileError::of(&path, "the file cannot be written")(error)
        })?;
        let mut file = WholeFile::create(&path)?;
        file.append(&bytes)?;
        let file = file.finish()?;
        Ok(Self {
            path,
            file,
            schema,
            marker: (bytes.len() - END_OF_STREAM.len()) as u64,
            frames: 0,
            last_step: None,
        })
    }

    /// Continues a file after a restart: the first `frames` frames stay, later ones are cut off.
    ///
    /// A checkpoint should keep [`len`](Self::len) for this, after [`sync`](Self::sync). Frames appended then give the
    /// same bytes as a run that never stopped. Damage behind the frames that stay does not matter. A reader that is amid
    /// one of the frames cut off gets an error. The title of the run and gravity may have changed: the file keeps its own.
    ///
    /// # Errors
    /// [`FrameWriteError::Format`] when the file has fewer whole frames or its schema is not `schema`;
    /// [`FrameWriteError::File`] when it cannot be written.
    pub fn resume(
        path: impl Into<PathBuf>,
        schema: FrameSchema,
        frames: usize,
    ) -> Result<Self, FrameWriteError> {
        let path = path.into();
        let reader = FrameReader::open(&path)?;
        if !reader.schema().is_alike(&schema) {
            let found = "columns or metadata of another run";
            let help = "the scene or its output was changed since the file was begun";
            return Err(FormatError::of_file(&path, found).with_help(help).into());
        }
        if reader.len() < frames {
            let found = format!("{} whole frames", reader.len());
            let help = reader.damage().map(|damage| damage.found.clone());
            return Err(FrameWriteError::Format(FormatError {
                expected: format!("the {frames} that the run had written"),
                help: help.map(String::into_boxed_str),
                ..FormatError::of_file(&path, found)
            }));
        }
        let marker = reader.end_of(frames);
        let last_step = frames.checked_sub(1).and_then(|k| reader.info(k));
        let last_step = last_step.map(|info| info.step);
        drop(reader);

        let action = "the file cannot be continued";
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .open(&path)
            .map_err(FileError::of(&path, action))?;
        // First the marker, then the cut: the file stays whole in between.
        file.write_all_at(&END_OF_STREAM, marker)
            .and_then(|()| file.set_len(marker + END_OF_STREAM.len() as u64))
            .map_err(FileError::of(&path, action))?;
        Ok(Self {
            path,
            file,
            schema,
            marker,
            frames,
            last_step,
        })
    }

    /// The schema of the file.
    pub fn schema(&self) -> &FrameSchema {
        &self.schema
    }

    /// The file, as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes up to the end of the last frame, without the marker behind it: later frames change none of them.
    pub fn bytes(&self) -> u64 {
        self.marker
    }

    /// The number of frames in the file.
    pub fn len(&self) -> usize {
        self.frames
    }

    /// Whether the file has no frame yet.
    pub fn is_empty(&self) -> bool {
        self.frames == 0
    }

    /// Appends a frame. When this fails (disk full, ...) the file still holds all frames before, and the next frame may
    /// be tried.
    ///
    /// # Errors
    /// [`FrameWriteError::Frame`] when the columns are not those of the schema or differ in length, the time is not
    /// finite, or the step is not above the one before; [`FrameWriteError::File`] when the file cannot be written.
    pub fn append(&mut self, frame: &Frame) -> Result<(), FrameWriteError> {
        let refused = |reason| FrameWriteError::Frame {
            path: self.path.clone(),
            step: frame.step,
            reason,
        };
        self.check(frame).map_err(refused)?;
        let encoded = encode(frame).map_err(refused)?;
        write_frame(&self.file, self.marker, &encoded.head, frame)
            .map_err(FileError::of(&self.path, "the file cannot be written"))?;
        self.marker += encoded.head.len() as u64 + encoded.body_length;
        self.frames += 1;
        self.last_step = Some(frame.step);
        Ok(())
    }

    /// Waits until all frames are on the disk, as before a checkpoint that counts on them.
    ///
    /// # Errors
    /// [`FrameWriteError::File`] when the system cannot promise it.
    pub fn sync(&self) -> Result<(), FrameWriteError> {
        let action = "the file cannot be synced to the disk";
        let synced = self.file.sync_data();
        Ok(synced.map_err(FileError::of(&self.path, action))?)
    }

    fn check(&self, frame: &Frame) -> Result<(), String> {
        if !frame.time.is_finite() {
            return Err(format!("the time is {}", frame.time));
        }
        if self.last_step.is_some_and(|last| frame.step <= last) {
            let last = self.last_step.unwrap_or_default();
            return Err(format!("the frame before was at step {last}"));
        }
        let specs = self.schema.columns();
        if frame.columns.len() != specs.len() {
            let found = frame.columns.len();
            return Err(format!("{found} columns, expected {}", specs.len()));
        }
        for (column, spec) in frame.columns.iter().zip(specs) {
            if column.kind() != spec.kind {
                let (name, found, expected) = (&spec.name, column.kind(), spec.kind);
                return Err(format!("column {name} is {found:?}, expected {expected:?}"));
            }
            if column.len() != frame.rows() {
                let (name, found, expected) = (&spec.name, column.len(), frame.rows());
                return Err(format!(
                    "column {name} has {found} rows, expected {expected}"
                ));
            }
        }
        Ok(())
    }
}

/// The two strokes of an append; `marker` is the offset of the old end-of-stream marker.
fn write_frame(sink: &impl WriteAt, marker: u64, head: &[u8], frame: &Frame) -> io::Result<()> {
    let (first, rest) = head.split_at(END_OF_STREAM.len());
    let offset = marker + END_OF_STREAM.len() as u64;
    let mut out = BufWriter::with_capacity(BUFFER, Cursor { sink, offset });
    out.write_all(rest)?;
    write_body(&mut out, frame)?;
    out.write_all(&END_OF_STREAM)?;
    out.flush()?;
    sink.write_all_at(first, marker)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use std::fs;

    use super::*;
    use crate::frames::{Column, ColumnKind, ColumnSpec};

    /// Remembers every write in its order.
    #[derive(Default)]
    struct Recorder(RefCell<Vec<(u64, Vec<u8>)>>);

    impl WriteAt for Recorder {
        fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
            self.0.borrow_mut().push((offset, bytes.to_vec()));
            Ok(())
        }
    }

    fn put(file: &mut Vec<u8>, bytes: &[u8], offset: u64) {
        let start = offset as usize;
        file.resize(file.len().max(start + bytes.len()), 0);
        file[start..start + bytes.len()].copy_from_slice(bytes);
    }

    fn frame(step: u64, rows: usize) -> Frame {
        let numbers = |k| step as f64 + k as f64;
        Frame {
            time: 0.5 * step as f64,
            step,
            columns: vec![
                Column::F64((0..rows).map(numbers).collect()),
                Column::OptionalU32(
                    (0..rows)
                        .map(|k| (k % 2 == 0).then_some(k as u32))
                        .collect(),
                ),
            ],
        }
    }

    /// A process may die at any byte of any write: what is left must read as the old frames, all of the new one only
    /// after the last write, and never anything in between.
    #[test]
    fn a_write_cut_at_any_byte_leaves_whole_frames() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cut.arrow");
        let columns = vec![
            ColumnSpec::new("x", ColumnKind::F64, "m"),
            ColumnSpec::new("body", ColumnKind::OptionalU32, "1"),
        ];
        let schema = FrameSchema::new("particles", columns).unwrap();
        let mut writer = FrameWriter::create(&path, schema).unwrap();
        writer.append(&frame(1, 7)).unwrap();
        let before = fs::read(&path).unwrap();

        // More rows than the buffer of the writer holds bytes for, so that the body takes several writes.
        let next = frame(2, 30_000);
        let recorder = Recorder::default();
        let encoded = encode(&next).unwrap();
        write_frame(&recorder, writer.marker, &encoded.head, &next).unwrap();
        let writes = recorder.0.into_inner();
        assert!(writes.len() >= 3, "body in parts, then the marker");

        let check = |bytes: &[u8], frames: usize| {
            fs::write(&path, bytes).unwrap();
            let reader = FrameReader::open(&path).unwrap();
            assert_eq!(reader.damage(), None);
            assert_eq!(reader.len(), frames);
            assert_eq!(reader.frame(0).unwrap(), frame(1, 7));
            if frames == 2 {
                assert_eq!(reader.frame(1).unwrap(), next);
            }
        };
        let mut state = before.clone();
        let (commit, body) = writes.split_last().unwrap();
        for (offset, bytes) in body {
            for cut in [0, 1, 7, 8, 9, bytes.len() / 2, bytes.len() - 1] {
                let mut partial = state.clone();
                put(&mut partial, &bytes[..cut.min(bytes.len())], *offset);
                check(&partial, 1);
            }
            put(&mut state, bytes, *offset);
            check(&state, 1);
        }
        assert_eq!(commit.1.len(), 8);
        assert_eq!(commit.0 % 64, 0, "within one page and one sector");
        put(&mut state, &commit.1, commit.0);
        check(&state, 2);

        // And these are the bytes that a plain append leaves.
        fs::write(&path, &before).unwrap();
        let mut writer = FrameWriter::resume(&path, writer.schema.clone(), 1).unwrap();
        writer.append(&next).unwrap();
        assert_eq!(fs::read(&path).unwrap(), state);
    }

    #[test]
    fn a_failed_append_leaves_the_file_and_can_be_repeated() {
        struct Full(File);
        impl WriteAt for Full {
            fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
                if offset > 100_000 {
                    return Err(io::ErrorKind::StorageFull.into());
                }
                self.0.write_all_at(bytes, offset)
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("full.arrow");
        let columns = vec![
            ColumnSpec::new("x", ColumnKind::F64, "m"),
            ColumnSpec::new("body", ColumnKind::OptionalU32, "1"),
        ];
        let schema = FrameSchema::new("particles", columns).unwrap();
        let mut writer = FrameWriter::create(&path, schema).unwrap();
        writer.append(&frame(1, 3)).unwrap();
        let big = frame(2, 100_000);
        let encoded = encode(&big).unwrap();
        let full = Full(OpenOptions::new().write(true).open(&path).unwrap());
        write_frame(&full, writer.marker, &encoded.head, &big).unwrap_err();
        let mut reader = FrameReader::open(&path).unwrap();
        assert_eq!((reader.len(), reader.damage()), (1, None));

        writer.append(&frame(2, 4)).unwrap();
        assert_eq!(reader.refresh(), 1);
        assert_eq!(reader.frame(1).unwrap(), frame(2, 4));
        assert_eq!(reader.damage(), None);
    }
}
