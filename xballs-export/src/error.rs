//! Why an export failed.

use std::path::PathBuf;

use mercury_common::error::FormatError;
use mercury_common::formats::vtu::VtuError;
use mercury_common::whole_file::FileError;
use mercury_pictures::PictureError;
use mercury_tables::WriteError;
use mercury_tables::query::QueryError;

/// Why nothing, or not all, was exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The input cannot be read.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The input or a choice makes no sense.
    #[error("{0}")]
    Input(String),
    /// A file of an earlier export is in the way.
    #[error("{}: this file is there already\nhelp: --force replaces it, -o DIR writes elsewhere", .0.display())]
    Exists(PathBuf),
    /// A file for ParaView could not be written.
    #[error(transparent)]
    Vtu(#[from] VtuError),
    /// A table could not be written.
    #[error(transparent)]
    Table(#[from] WriteError),
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A query has no answer.
    #[error(transparent)]
    Query(#[from] QueryError),
    /// The operating system refused.
    #[error(transparent)]
    File(#[from] FileError),
}

impl ExportError {
    /// Whether the input or the usage is to blame, rather than the machine.
    #[must_use]
    pub fn is_input(&self) -> bool {
        matches!(
            self,
            Self::Format(_)
                | Self::Input(_)
                | Self::Exists(_)
                | Self::Picture(PictureError::Option { .. })
                | Self::Table(WriteError::Columns { .. })
                | Self::Query(QueryError::Sql(_) | QueryError::Table(_))
        )
    }
}
