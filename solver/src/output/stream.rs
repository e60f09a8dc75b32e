//! Files that grow frame by frame.

use std::fs::File;
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use mercury_cg::CgError;
use mercury_common::formats::vtu::VtuError;
use mercury_common::frames::{FrameWriteError, FrameWriter, Table, TableWriter};
use mercury_common::whole_file::FileError;
use mercury_pictures::PictureError;

use super::FrameCopy;
use super::chain::ChainError;
use super::particle_frames::frames_header;
use crate::plan::Plan;
use mercury_engine::audit::Losses;
use mercury_engine::contact::HistoryNumber;
use mercury_engine::task::OutputFile;

/// Why the outputs of a run could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The operating system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file of native frames could not be written.
    #[error(transparent)]
    Frames(#[from] FrameWriteError),
    /// A file for ParaView could not be written.
    #[error(transparent)]
    Vtk(#[from] VtuError),
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// Fields could not be computed.
    #[error("fields: {0}")]
    Fields(Box<CgError>),
    /// The summary is no JSON.
    #[error("the summary cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The plan cannot be written as TOML.
    #[error("the plan cannot be written: {0}")]
    Plan(String),
    /// A file that a run was writing was changed.
    #[error(
        "{}: the file has {found} bytes, the run had written {expected}\nhelp: it was changed since; begin anew with --force",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// Bytes that it has.
        found: u64,
        /// Bytes that it should have at least.
        expected: u64,
    },
    /// The chain of a run that goes on does not hold.
    #[error("{0}\nhelp: it was changed since; begin anew with --force")]
    Chain(#[from] Box<ChainError>),
    /// The writer thread ended unexpectedly.
    #[error("the writer thread ended unexpectedly; this is a defect of the program")]
    Lost,
}

/// Where a stream begins: at the start of a new file, or at the position that an interrupted run had reported.
pub(crate) type Begin = Option<u64>;

impl From<CgError> for OutputError {
    fn from(error: CgError) -> Self {
        Self::Fields(Box::new(error))
    }
}

/// One file of a run.
pub(crate) trait Stream: Send {
    /// Writes what is due of this state.
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError>;

    /// Where its bytes go.
    fn sink(&self) -> Sink<'_>;

    /// Files that were completed since the last call.
    fn made(&mut self) -> Vec<PathBuf> {
        Vec::new()
    }

    /// The state that it needs beside its file to continue; `None` for streams that need none.
    fn memory(&self) -> Option<Vec<u64>> {
        None
    }

    /// Nothing more will come.
    fn close(&mut self) -> Result<(), OutputError> {
        Ok(())
    }
}

/// Kind of a stream: makes the stream of a run. It lies in the file of the stream, and has a line in the list of
/// [`STREAMS`](super::STREAMS).
pub(crate) trait StreamKind: Stream + Sized + 'static {
    /// Ending of its file behind the prefix, or the folder of its files. By this name checkpoints store how far it has come.
    const NAME: &'static str;

    /// Whether the run of this plan has it.
    fn is_wanted(plan: &Plan) -> bool;

    /// Makes its file, or continues it from the position of an interrupted run.
    ///
    /// # Errors
    /// If the file cannot be made or continued.
    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError>;
}

/// A kind of stream as a line of a list.
pub(crate) struct StreamEntry {
    pub(crate) name: &'static str,
    pub(crate) is_wanted: fn(&Plan) -> bool,
    pub(crate) begin: fn(&Beginning<'_>) -> Result<Box<dyn Stream>, OutputError>,
}

/// The line of a kind of stream.
pub(crate) const fn entry<S: StreamKind>() -> StreamEntry {
    StreamEntry {
        name: S::NAME,
        is_wanted: S::is_wanted,
        begin: |run| Ok(Box::new(S::begin(run)?)),
    }
}

/// State of a run from which a stream begins.
pub(crate) struct Beginning<'a> {
    /// Of the run.
    pub(crate) folder: &'a Path,
    pub(crate) plan: &'a Plan,
    /// Numbers in the memory of contacts.
    pub(crate) history: &'a [HistoryNumber],
    /// Sinks of energy.
    pub(crate) losses: &'a Losses,
    /// Where it begins.
    pub(crate) at: Begin,
}

impl Beginning<'_> {
    /// The text file with this ending, which begins with `head`.
    pub(crate) fn text(&self, ending: &str, head: &[u8]) -> Result<TextFile, OutputError> {
        TextFile::begin(self.folder, &self.name(ending), head, self.at)
    }

    /// The file of frames with this ending.
    pub(crate) fn frames<T: Table<Layout: Clone>>(
        &self,
        ending: &str,
        layout: &T::Layout,
    ) -> Result<TableWriter<T>, OutputError> {
        let path = self.folder.join(self.name(ending));
        let header = frames_header(self.plan);
        Ok(match self.at {
            None => TableWriter::create(path, &header, layout)?,
            Some(frames) => TableWriter::resume(path, &header, layout, frames as usize)?,
        })
    }

    /// The name of the file with this ending.
    pub(crate) fn name(&self, ending: &str) -> String {
        format!("{}.{ending}", self.plan.outputs().prefix())
    }
}

/// Where the bytes of a stream go.
pub(crate) enum Sink<'a> {
    /// A text file that grows.
    Text(&'a TextFile),
    /// A file of frames that grows.
    Frames(&'a FrameWriter),
    /// Files that are written as a whole, and the number of frames up to now; each was synced to the disk under its name.
    Whole(u64),
}

impl Sink<'_> {
    /// How far it has come: bytes of a text file, frames of any other.
    pub(crate) fn position(&self) -> u64 {
        match self {
            Self::Text(file) => file.position(),
            Self::Frames(frames) => frames.len() as u64,
            Self::Whole(frames) => *frames,
        }
    }

    /// Waits until everything is on the disk, where a checkpoint counts on it.
    pub(crate) fn sync(&self) -> Result<(), OutputError> {
        match self {
            Self::Text(file) => file.sync(),
            Self::Frames(frames) => Ok(frames.sync()?),
            Self::Whole(_) => Ok(()),
        }
    }

    /// The file that grows, up to the end of its last frame.
    pub(crate) fn file(&self) -> Option<OutputFile> {
        let (path, bytes) = match self {
            Self::Text(file) => (file.path.as_path(), file.position()),
            Self::Frames(frames) => (frames.path(), frames.bytes()),
            Self::Whole(_) => return None,
        };
        let name = path.file_name().unwrap_or_default();
        Some(OutputFile {
            name: name.to_string_lossy().into_owned(),
            bytes,
        })
    }
}

/// A text file to which whole frames are appended.
#[derive(Debug)]
pub(crate) struct TextFile {
    path: PathBuf,
    file: File,
    /// Bytes in the file.
    length: u64,
    /// The buffer of the present frame; kept, so that its memory is used again.
    pub(crate) buffer: Vec<u8>,
}

impl TextFile {
    /// Makes the file, with `head` at its front; or opens it and cuts off all bytes behind a position.
    pub(crate) fn begin(
        folder: &Path,
        name: &str,
        head: &[u8],
        begin: Begin,
    ) -> Result<Self, OutputError> {
        let path = folder.join(name);
        let (file, length) = match begin {
            None => {
                let file = File::create(&path);
                (
                    file.map_err(FileError::of(&path, "the file cannot be made"))?,
                    0,
                )
            }
            Some(position) => (Self::behind(&path, position)?, position),
        };
        let mut text = Self {
            path,
            file,
            length,
            buffer: Vec::new(),
        };
        if begin.is_none() {
            text.buffer.extend_from_slice(head);
            text.flush()?;
        }
        Ok(text)
    }

    /// The file, truncated to its first `position` bytes.
    fn behind(path: &Path, position: u64) -> Result<File, OutputError> {
        let failed = FileError::of(path, "the file cannot be continued");
        let mut file = File::options().write(true).open(path).map_err(&failed)?;
        let found = file.metadata().map_err(&failed)?.len();
        if found < position {
            return Err(OutputError::Changed {
                path: path.to_owned(),
                found,
                expected: position,
            });
        }
        file.set_len(position)
            .and_then(|()| file.seek(SeekFrom::Start(position)))
            .map_err(failed)?;
        Ok(file)
    }

    /// Appends the buffer to the file in one call, and empties it.
    pub(crate) fn flush(&mut self) -> Result<(), OutputError> {
        let written = self.file.write_all(&self.buffer);
        if written.is_ok() {
            self.length += self.buffer.len() as u64;
        }
        self.buffer.clear();
        let failed = FileError::of(&self.path, "the file cannot be written");
        Ok(written.map_err(failed)?)
    }
}

impl TextFile {
    /// Bytes in the file.
    pub(crate) fn position(&self) -> u64 {
        self.length
    }

    /// Waits until all bytes are on the disk.
    pub(crate) fn sync(&self) -> Result<(), OutputError> {
        let synced = self.file.sync_data();
        let failed = FileError::of(&self.path, "the file cannot be synced to the disk");
        Ok(synced.map_err(failed)?)
    }
}
