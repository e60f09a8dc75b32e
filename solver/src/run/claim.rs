//! The folder of a run: taken for it alone, with the checkpoint from which it goes on.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use mercury_common::readable::rounded;
use mercury_common::scene::Statement;

use super::checkpoint::{self, Checkpoint, CheckpointError};
use crate::output::folder::{self, Earlier, FolderError, FolderLock, Found};
use crate::plan::Plan;

/// Why a run cannot use a folder.
#[derive(Debug, thiserror::Error)]
pub enum ClaimError {
    /// A file that the scene names cannot be read.
    #[error("{}: the file cannot be read: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        error: io::Error,
    },
    /// The scene starts from the run in the folder.
    #[error("{}: the run would start from what is in its own folder, and replace it\nhelp: write elsewhere with --output DIR", .0.display())]
    StartsFromItself(PathBuf),
    /// The scene is a file of the run in the folder.
    #[error("{}: this scene is a file of the run in {}, which would be replaced\nhelp: write elsewhere with --output DIR, or copy the scene", scene.display(), folder.display())]
    SceneOfRun {
        /// The scene.
        scene: PathBuf,
        /// The folder.
        folder: PathBuf,
    },
    /// It is taken, or no folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The run in it cannot go on.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The run in it is over and left no checkpoint.
    #[error("{}: there is a whole run in this folder, and no checkpoint of it\nhelp: --force replaces it", .0.display())]
    NoCheckpoint(PathBuf),
}

impl ClaimError {
    /// Whether the system failed; otherwise the input is wrong.
    #[must_use]
    pub fn is_of_system(&self) -> bool {
        matches!(self, Self::Folder(FolderError::System { .. }))
    }
}

/// A folder that belongs to a run until this is dropped.
#[derive(Debug)]
pub struct Claim {
    _lock: FolderLock,
    /// Keys and values of the scene, for checkpoints.
    pub statement: BTreeMap<String, String>,
    /// The checkpoint to go on from.
    pub from: Option<Checkpoint>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl Claim {
    /// Takes a folder for the run of a plan. `scene` is the file of the scene, and `statement` its keys.
    ///
    /// # Errors
    /// Every reason why the run must not write there, or cannot go on from what is there.
    pub fn new(
        folder: &Path,
        plan: &Plan,
        scene: &Path,
        statement: &Statement,
        earlier: Earlier,
    ) -> Result<Self, ClaimError> {
        let entries = statement.entries();
        let mut statement = entries.map_err(|(path, error)| ClaimError::File { path, error })?;
        for from in plan.notes().started_from() {
            let (key, state) = &from.statement;
            statement.insert(key.clone(), state.clone());
            let [there, here] = [&from.folder, folder].map(std::fs::canonicalize);
            if there.is_ok_and(|there| here.is_ok_and(|here| there == here)) {
                return Err(ClaimError::StartsFromItself(folder.to_owned()));
            }
        }
        if folder::is_of_earlier_run(folder, scene) {
            return Err(ClaimError::SceneOfRun {
                scene: scene.to_owned(),
                folder: folder.to_owned(),
            });
        }
        let (lock, found) = folder::prepare(folder, plan.outputs().prefix(), earlier)?;
        let mut claim = Self {
            _lock: lock,
            statement,
            from: None,
            notes: Vec::new(),
        };
        if found == Found::Run {
            claim.resume(folder, plan)?;
        }
        Ok(claim)
    }

    /// Finds the checkpoint to go on from; where there is none, the folder is emptied.
    fn resume(&mut self, folder: &Path, plan: &Plan) -> Result<(), ClaimError> {
        let Some((checkpoint, damaged)) = checkpoint::newest(folder, plan.outputs().prefix())?
        else {
            if folder.join("summary.json").exists() {
                return Err(ClaimError::NoCheckpoint(folder.to_owned()));
            }
            self.notes
                .push("no checkpoint yet: from the beginning".to_owned());
            folder::clear(folder, plan.outputs().prefix())?;
            return Ok(());
        };
        checkpoint.fits(plan, &self.statement)?;
        let notes = damaged.iter().map(|what| format!("not used: {what}"));
        self.notes.extend(notes);
        self.notes.push(format!(
            "resumed from {} at t = {} s",
            checkpoint.path.display(),
            rounded(checkpoint.head.time(), 12)
        ));
        self.from = Some(checkpoint);
        Ok(())
    }
}
