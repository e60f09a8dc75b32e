//! Why a requested distribution cannot be drawn from.

use crate::error::FormatError;
use crate::scene::{SceneError, SceneErrors};

/// Why a requested distribution cannot be drawn from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SizeError {
    /// The file of a measured distribution is wrong.
    #[error(transparent)]
    File(FormatError),
    /// The file of a law is wrong.
    #[error(transparent)]
    Law(SceneErrors),
    /// The law as stated has no number of particles.
    #[error(transparent)]
    Improper(SceneError),
}
