//! The folder of a run: taken for it alone, with the checkpoint from which it goes on.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mercury_common::readable::rounded;
use mercury_common::scene::Scene;

use super::checkpoint::{self, Checkpoint, CheckpointError};
use super::origin::Origin;
use crate::output::chain::{ChainScene, stated};
use crate::output::folder::{self, Earlier, FolderError, FolderLock, Found};
use crate::output::summary::BranchOf;
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

/// The scene as its run is made from it. `text` is that of the scene, and `set` was put on top.
///
/// # Errors
/// If a file that it names cannot be read.
pub fn stated_by(
    scene: &Scene,
    plan: &Plan,
    text: (&str, &[String]),
) -> Result<ChainScene, ClaimError> {
    let unread = |(path, error)| ClaimError::File { path, error };
    let mut statement = scene.statement.entries().map_err(unread)?;
    let started_from = plan.notes().started_from().iter();
    statement.extend(started_from.map(|from| from.statement.clone()));
    stated(scene, plan, statement, text).map_err(unread)
}

/// A folder that belongs to a run until this is dropped.
#[derive(Debug)]
pub struct Claim {
    _lock: FolderLock,
    /// The scene, for checkpoints and the chain.
    pub stated: Arc<ChainScene>,
    /// The run from which the run in the folder branched off.
    pub branch_of: Option<BranchOf>,
    /// The checkpoint to go on from.
    pub from: Option<Checkpoint>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl Claim {
    /// Takes a folder for the run of a plan. `file` is that of the scene, `text` its content and the `KEY=VALUE` put on top.
    ///
    /// # Errors
    /// Every reason why the run must not write there, or cannot go on from what is there.
    pub fn new(
        folder: &Path,
        plan: &Plan,
        file: &Path,
        scene: &Scene,
        text: (&str, &[String]),
        earlier: Earlier,
    ) -> Result<Self, ClaimError> {
        let stated = stated_by(scene, plan, text)?;
        for from in plan.notes().started_from() {
            let [there, here] = [&from.folder, folder].map(std::fs::canonicalize);
            if there.is_ok_and(|there| here.is_ok_and(|here| there == here)) {
                return Err(ClaimError::StartsFromItself(folder.to_owned()));
            }
        }
        if folder::is_of_earlier_run(folder, file) {
            return Err(ClaimError::SceneOfRun {
                scene: file.to_owned(),
                folder: folder.to_owned(),
            });
        }
        let (lock, found) = folder::prepare(folder, plan.outputs().prefix(), earlier)?;
        let mut claim = Self {
            _lock: lock,
            stated: Arc::new(stated),
            branch_of: None,
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
        checkpoint.fits(plan, &self.stated.statement)?;
        self.branch_of = Origin::read(folder).branch_of;
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
