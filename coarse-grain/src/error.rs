//! Why fields were not computed.

use std::io;
use std::path::PathBuf;

use mercury_common::error::FormatError;
use mercury_common::formats::vtu::VtuError;
use mercury_common::whole_file::FileError;
use mercury_pictures::PictureError;

/// Why nothing, or not all, was written.
#[derive(Debug, thiserror::Error)]
pub enum CgError {
    /// The input cannot be read.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The input or a choice makes no sense.
    #[error("{0}")]
    Input(String),
    /// A file is in the way.
    #[error("{}: this file is there already\nhelp: --force replaces it, -o FILE writes elsewhere", .0.display())]
    Exists(PathBuf),
    /// A list of files for ParaView could not be written.
    #[error(transparent)]
    Vtu(#[from] VtuError),
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A table of a format that the library does not have could not be written.
    #[error(transparent)]
    Table(Box<dyn std::error::Error + Send + Sync>),
    /// The operating system refused.
    #[error("{}: {action}: {source}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// Failed action, as `the file cannot be ...`.
        action: &'static str,
        /// Error of the system.
        source: io::Error,
    },
}

impl From<FileError> for CgError {
    fn from(error: FileError) -> Self {
        Self::File {
            path: error.path,
            action: error.action,
            source: error.source,
        }
    }
}

impl CgError {
    /// Whether the input or the usage is to blame, rather than the machine.
    #[must_use]
    pub fn is_input(&self) -> bool {
        matches!(self, Self::Format(_) | Self::Input(_) | Self::Exists(_))
    }
}
