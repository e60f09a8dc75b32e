//! Options of a run beside its plan, and reasons why it may fail.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use mercury_engine::forces::block_size;
use mercury_engine::lanes::Width;
use mercury_engine::membrane::MembranePlan;
use mercury_engine::ranks::Share;
use mercury_engine::step::{Engine, Part, RunError, StartOptions};
use mercury_engine::task::TaskProgress;

use super::CouplingError;
use super::coupling::WallLoads;
use crate::output::chain::ChainScene;
use crate::output::summary::BranchOf;
use crate::output::{OutputError, Schedule};
use crate::plan::Plan;
use crate::results::{Aims, NamedResult};

/// Fewer particles, pebbles and vertices of sheets than these are stepped by one thread: two threads took as long for 1,000 beads, and 0.7 of the time for 2,000
/// (`benches/busy.py`).
const ALONE_BELOW: usize = 1_500;

/// Options of a run beside its plan.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// The folder of the files; ready for a run ([`folder::prepare`](crate::output::folder::prepare)).
    pub folder: PathBuf,
    /// Threads that step, at most; the results do not depend on them.
    pub threads: usize,
    /// Steps of few particles are made by one of them.
    pub fewer_where_faster: bool,
    /// Contacts that are evaluated side by side; the results do not depend on it. `None`: the fastest.
    pub width: Option<Width>,
    /// How the run was called, for `run.log`.
    pub command_line: String,
    /// Content of `plan.toml`.
    pub plan_document: Option<String>,
    /// Text of the scene, in TOML or JSON, of which the run keeps a copy.
    pub scene_text: Option<String>,
    /// Folder from which the scene names its files, for `plan.toml`.
    pub scene_folder: Option<PathBuf>,
    /// The scene, for the chain; `None`: the run has none.
    pub chain: Option<Arc<ChainScene>>,
    /// The run from which this one branched off.
    pub branch_of: Option<BranchOf>,
    /// Set to end the run after the present step.
    pub stop: Arc<AtomicBool>,
    /// Set to leave [`Run::advance`](super::Run::advance) after the present step, until it is called again.
    pub pause: Arc<AtomicBool>,
    /// The last step of each piece is observed, so that contacts and loads on walls can be read between pieces.
    pub pieces_observed: bool,
    /// The loads on walls are summed up in every step, for [`Run::wall_load`](super::Run::wall_load).
    pub wall_loads: bool,
    /// The observer of long work; its flag for stops should be the one above.
    pub task_progress: Arc<TaskProgress>,
    /// The wall-clock time after which the run stops by itself.
    pub time_limit: Option<Duration>,
    /// Checkpoints; `None`: none are written.
    pub checkpoints: Option<Checkpoints>,
    /// Notes for the log.
    pub notes: Vec<String>,
    /// Numbers for the summary of a run that reaches its end.
    pub results: Vec<NamedResult>,
    /// Results that end the run when they are known.
    pub until: Option<Aims>,
    /// The share of this process, where several make the run together; taken when it begins.
    pub ranks: Arc<Mutex<Option<Share>>>,
}

/// When a run writes checkpoints; in addition it writes one when it is stopped, and where the plan requests one.
#[derive(Debug, Clone, Default)]
pub struct Checkpoints {
    /// Interval by the clock.
    pub every: Option<Duration>,
    /// At the end, for a later run that starts from there.
    pub at_end: bool,
    /// Set to write one now.
    pub now: Arc<AtomicBool>,
    /// The statement of the scene: [`Statement::entries`](mercury_common::scene::Statement::entries).
    pub scene: BTreeMap<String, String>,
}

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
pub enum RunFailure {
    /// The simulation cannot go on.
    #[error(transparent)]
    Engine(#[from] RunError),
    /// The outputs cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A request of a program that drives the run makes no sense.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
}

impl RunFailure {
    /// Whether there is none: the run was stopped before its first step, and has written nothing.
    #[must_use]
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Engine(RunError::GivenUp))
    }
}

impl RunOptions {
    /// Whether one thread makes the steps, as there are too few particles, pebbles and vertices for others to gain anything.
    pub(super) fn steps_alone(&self, engine: &Engine) -> bool {
        let vertices = engine.surfaces().iter().map(|sheet| sheet.positions.len());
        let count = engine.particles.len() + vertices.sum::<usize>();
        self.fewer_where_faster && self.threads > 1 && count < ALONE_BELOW
    }

    pub(super) fn start(&self, schedule: &Schedule) -> StartOptions {
        let mut parts: Vec<Box<dyn Part>> = Vec::new();
        if self.wall_loads {
            parts.push(Box::new(WallLoads::default()));
        }
        StartOptions::threads(self.threads)
            .parts(parts)
            .records(schedule.everything().needs_records() || self.pieces_observed)
            .width(self.width)
            .ranks(
                self.ranks
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .take(),
            )
            .task_progress(Arc::clone(&self.task_progress))
    }
}

/// The number of threads, of those of the machine, that a run of this plan can keep busy.
#[must_use]
pub fn useful_threads(plan: &Plan, available: usize) -> usize {
    if !plan.physics().insertions.is_empty() {
        return available.max(1);
    }
    let pebbles = plan.physics().bodies.iter();
    let pebbles: usize = pebbles
        .map(|body| body.clump(&plan.physics().clumps).pebbles.len())
        .sum();
    let sheets = plan.physics().plans.all::<MembranePlan>().iter();
    let vertices: usize = sheets.map(|sheet| sheet.surface.vertices.len()).sum();
    let rows = (plan.physics().particles.len() + pebbles).max(vertices);
    rows.div_ceil(block_size(rows)).clamp(1, available.max(1))
}
