//! Files that grow frame by frame.

use std::fs::File;
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use mercury_common::formats::vtu::VtuError;
use mercury_common::frames::FrameWriteError;
use mercury_common::whole_file::FileError;
use mercury_pictures::PictureError;

use super::State;

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
    /// The summary is no JSON.
    #[error("the summary cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The thread that writes ended without a word.
    #[error("the thread that writes the outputs has failed; this is a defect of the program")]
    Lost,
}

/// One file of a run.
pub(super) trait Stream: Send {
    /// Writes what is due of this state.
    fn write(&mut self, state: &State) -> Result<(), OutputError>;

    /// How far it has come: bytes of a text file, frames of any other.
    fn position(&self) -> u64;

    /// Goes back to a position that it had before, as if nothing had been written since.
    fn cut_back(&mut self, position: u64) -> Result<(), OutputError>;
}

/// A text file to which whole frames are appended.
#[derive(Debug)]
pub(super) struct TextFile {
    path: PathBuf,
    file: File,
    /// Bytes in the file.
    length: u64,
    /// The frame in the making; kept, so that its memory is.
    pub(super) buffer: Vec<u8>,
}

impl TextFile {
    /// Makes the file, empty.
    pub(super) fn create(folder: &Path, name: &str) -> Result<Self, OutputError> {
        let path = folder.join(name);
        let file = File::create(&path);
        Ok(Self {
            file: file.map_err(FileError::of(&path, "the file cannot be made"))?,
            path,
            length: 0,
            buffer: Vec::new(),
        })
    }

    /// Appends the buffer to the file in one call, and empties it.
    pub(super) fn flush(&mut self) -> Result<(), OutputError> {
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
    pub(super) fn position(&self) -> u64 {
        self.length
    }

    /// Cuts off all bytes behind the first `position`.
    pub(super) fn cut_back(&mut self, position: u64) -> Result<(), OutputError> {
        let cut = self.file.set_len(position);
        let cut = cut.and_then(|()| self.file.seek(SeekFrom::Start(position)));
        cut.map_err(FileError::of(&self.path, "the file cannot be cut back"))?;
        self.length = position;
        Ok(())
    }
}

/// Appends a name as a field of a CSV file.
pub(super) fn push_csv_name(out: &mut Vec<u8>, name: &str) {
    if name.contains([',', '"', '\n', '\r']) {
        out.push(b'"');
        out.extend_from_slice(name.replace('"', "\"\"").as_bytes());
        out.push(b'"');
    } else {
        out.extend_from_slice(name.as_bytes());
    }
}
