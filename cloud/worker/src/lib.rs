//! One attempt: restore what is committed, run the solver on it, commit what it makes, say how it ended.
//!
//! A worker needs the store and nothing else. It holds the run by the epoch in `head.json`: each commit is a
//! compare-and-swap, and a worker that finds another epoch there kills its solver and ends without a trace.

mod claim;
pub mod confine;
mod notice;
mod progress;
mod ranks;
mod restore;
mod solver;
mod supervise;
mod sync;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result};
use cloud_api::RunId;
use cloud_store::Store;

pub use ranks::Ranks;
pub use supervise::work;

/// Settings of an attempt.
pub struct Attempt<'a> {
    /// The store.
    pub store: &'a dyn Store,
    /// The run.
    pub run: RunId,
    /// Number of the attempt.
    pub epoch: u64,
    /// Folder of this machine in which the attempt may make one of its own.
    pub scratch: PathBuf,
    /// The solver.
    pub solver: PathBuf,
    /// Whether the solver is confined to the folder of the attempt.
    pub sandbox: bool,
    /// Time between two beats.
    pub beat: Duration,
    /// Time between two commits without a checkpoint.
    pub commit: Duration,
    /// The clock's time between two checkpoints, as `--checkpoint-every` takes it.
    pub checkpoint: String,
    /// When the solver stops by itself, as `--time-limit` takes it.
    pub limit: Option<String>,
    /// The most bytes that the outputs may take by the limit of their owner, where there is one.
    pub disk: Option<u64>,
    /// Several ranks, where Slurm has a job for them.
    pub ranks: Option<Ranks>,
    /// How long the solver may be without a sign of life.
    pub patience: Duration,
}

impl Attempt<'_> {
    /// A key of this run.
    fn key(&self, rest: &str) -> String {
        format!("runs/{}/{rest}", self.run)
    }
}

/// Outcome of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Its end is in the store.
    Committed,
    /// The run belongs to another attempt; this one has left no trace.
    Superseded,
}

/// Name of this machine.
fn machine() -> String {
    rustix::system::uname()
        .nodename()
        .to_string_lossy()
        .into_owned()
}

/// A folder, made anew and empty.
fn empty_folder(path: PathBuf) -> Result<PathBuf> {
    let made = match std::fs::remove_dir_all(&path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => std::fs::create_dir_all(&path),
    };
    made.with_context(|| format!("{}: cannot be made empty", path.display()))?;
    Ok(path)
}
