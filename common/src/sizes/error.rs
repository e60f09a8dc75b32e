//! Why a requested distribution cannot be drawn from.

use std::path::PathBuf;

use crate::scene::{Located, SceneError};

/// Why a requested distribution cannot be drawn from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SizeError {
    /// A measured distribution: its table has to be read first.
    #[error("the distribution is a table: {}", .0.value.display())]
    File(Located<PathBuf>),
    /// The law as stated has no number of particles.
    #[error(transparent)]
    Improper(SceneError),
}
