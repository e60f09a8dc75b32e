//! Where attempts run. An engine starts workers and reports their state; it never tries again by itself.

#[cfg(feature = "aws")]
mod aws;
mod local;
mod program;
mod slurm;

use std::collections::HashMap;
use std::ffi::OsString;
use std::path::PathBuf;

#[cfg(feature = "aws")]
pub use aws::{Account, Batch};
pub use local::{Local, record};
pub use slurm::{Ranks, Site, Slurm};

/// An attempt to be run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launch {
    /// Name of the job, from [`job_name`]: the same attempt always has the same one.
    pub job: String,
    /// Program and arguments of the worker; `--job JOB` is among them.
    pub command: Vec<OsString>,
    /// Ranks of MPI; 1: a single process.
    pub ranks: u32,
    /// Threads of each rank that compute.
    pub threads: u32,
    /// The most memory of each rank, in bytes.
    pub memory: u64,
    /// Where the worker's own messages go, on engines that can see this folder.
    pub log: PathBuf,
    /// Attempts in a row before this one that made no progress.
    pub barren: u32,
}

/// Paths in an image: programs and scratch.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(default)]
pub struct ImageLayout {
    /// `mercury-cloud`.
    pub program: PathBuf,
    /// `mercury-solve`.
    pub solver: PathBuf,
    /// A folder in which workers make theirs.
    pub scratch: PathBuf,
    /// Whether the solver is confined there, too. A container holds one run and nothing else.
    pub sandbox: bool,
}

impl Default for ImageLayout {
    fn default() -> Self {
        Self {
            program: "/usr/local/bin/mercury-cloud".into(),
            solver: "/usr/local/bin/mercury-solve".into(),
            scratch: "/scratch".into(),
            sandbox: true,
        }
    }
}

/// Name of the job of an attempt.
pub fn job_name(run: &str, epoch: u64) -> String {
    format!("mc-{run}-{epoch}")
}

/// State of a job that has not ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Observed {
    /// It waits, for this reason.
    Pending(String),
    /// It runs, on this machine.
    Running(String),
}

/// How a job is ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// SIGTERM to the worker, which then commits.
    Gently,
    /// At once.
    Hard,
}

/// Abilities of an engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Abilities {
    /// Seconds from SIGTERM to SIGKILL.
    pub grace: f64,
    /// Seconds between two beats of a worker.
    pub beat: f64,
    /// Cores for runs; `None`: the engine has a queue of its own.
    pub cores: Option<u32>,
    /// The most ranks of a run.
    pub ranks: u32,
}

/// An error of an engine.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// A program could not be started.
    #[error("{program}: {source}")]
    Program {
        /// Name of the program.
        program: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// A program of the engine says no.
    #[error("{program}: {message}")]
    Refused {
        /// Name of the program.
        program: String,
        /// Its message.
        message: String,
    },
    /// Records of workers cannot be read.
    #[error("{}: {source}", folder.display())]
    Records {
        /// Folder of the records.
        folder: PathBuf,
        /// Why.
        #[source]
        source: std::io::Error,
    },
}

/// An engine that runs attempts. All calls may be repeated.
pub trait Engine: Send + Sync {
    /// Name of the engine: `local`, `slurm` or `aws`.
    fn name(&self) -> &'static str;

    /// Where an attempt goes that follows so many without progress: the queue, on engines that have several of different prices.
    fn queue(&self, barren: u32) -> &str {
        let _ = barren;
        self.name()
    }

    /// Starts the job, unless there is one of this name.
    fn submit(&self, launch: &Launch) -> Result<(), EngineError>;

    /// Starts several jobs as [`Engine::submit`] does; what came of each, in their order.
    fn submit_all(&self, launches: &[Launch]) -> Vec<Result<(), EngineError>> {
        launches.iter().map(|launch| self.submit(launch)).collect()
    }

    /// All jobs that wait or run, by name. One query, however many there are.
    fn observe(&self) -> Result<HashMap<String, Observed>, EngineError>;

    /// Ends a job. One that is gone is no error.
    fn stop(&self, job: &str, how: Stop) -> Result<(), EngineError>;

    /// Its abilities.
    fn abilities(&self) -> Abilities;

    /// Paths for its workers, where they run in an image.
    fn image(&self) -> Option<&ImageLayout> {
        None
    }
}
