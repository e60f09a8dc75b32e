//! A run from the command line: its folder, what is in it already, and how it ends.

use super::input::{Input, lies_within, refused};
use super::progress::ProgressFile;
use super::waiting::stopped_early;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::output::folder::{self, Earlier, FolderError};
use crate::plan::{Disk, Memory, Plan, document};
use crate::results::{Aims, NamedResult};
use crate::run::checkpoint::Checkpoint;
use crate::run::{
    Branch, BranchError, Checkpoints, Claim, Progress, Report, RunFailure, RunOptions, is_over,
    run_from, useful_threads,
};
use mercury_common::cli::{self, Failure};
use mercury_common::machine;
use mercury_common::readable::bytes;
use mercury_common::scene::Scene;
use mercury_common::within::Within;
use mercury_engine::lanes::Width;
use mercury_engine::ranks::Share;
use mercury_engine::task::{RunEvent, TaskProgress};

/// Requests of signals to a run.
#[derive(Debug, Clone)]
pub(crate) struct Requests {
    /// To stop after its step.
    pub(crate) stop: Arc<AtomicBool>,
    /// To write a checkpoint and go on.
    pub(crate) checkpoint: Arc<AtomicBool>,
}

impl Requests {
    /// The progress of the run that these requests reach.
    pub(crate) fn task_progress(&self) -> Arc<TaskProgress> {
        Arc::new(TaskProgress::new(Arc::clone(&self.stop)))
    }

    /// Progress of a run that reports its events.
    pub(crate) fn observed_progress(&self, events: Sender<RunEvent>) -> Arc<TaskProgress> {
        Arc::new(TaskProgress::reporting(Arc::clone(&self.stop), events))
    }
}

impl Requests {
    /// From now on.
    pub(crate) fn listen() -> Result<Self, Failure> {
        Ok(Self {
            stop: cli::stop_on_request()?,
            checkpoint: cli::note_on_request()?,
        })
    }
}

/// The options of the command line on how a scene is run.
#[derive(Debug, Clone)]
pub(crate) struct How {
    /// Where to; by the scene's name by default.
    pub(crate) folder: Option<PathBuf>,
    /// Outside of it nothing is read or written.
    pub(crate) within: Option<Arc<Within>>,
    /// Where programs read how far it is.
    pub(crate) progress: Option<Arc<ProgressFile>>,
    /// Numbers for the summary.
    pub(crate) results: Vec<NamedResult>,
    /// Results that end the run when they are known.
    pub(crate) until: Option<Aims>,
    /// Treatment of an earlier run in the folder.
    pub(crate) earlier: Earlier,
    /// Threads at most; `None`: those of the machine.
    pub(crate) threads: Option<u16>,
    /// All of them make every step.
    pub(crate) fixed_threads: bool,
    /// Contacts evaluated side by side; `None`: the fastest for the processor.
    pub(crate) width: Option<Width>,
    /// Stop after so long.
    pub(crate) time_limit: Option<Duration>,
    /// Wall-clock time between checkpoints; `None`: only when the run is stopped.
    pub(crate) checkpoint_every: Option<Duration>,
    /// Only errors are printed.
    pub(crate) quiet: bool,
    /// The command line as it was typed.
    pub(crate) typed: String,
    /// The share of this process, where several make the run.
    pub(crate) ranks: Arc<Mutex<Option<Share>>>,
}

impl How {
    /// Threads for the run of a plan.
    pub(crate) fn threads_for(&self, plan: &Plan) -> usize {
        let available = || std::thread::available_parallelism().map_or(1, usize::from);
        let most = self.threads.map_or_else(available, usize::from);
        match self.fixed_threads {
            true => most,
            false => useful_threads(plan, most),
        }
    }
}

/// The content of `plan.toml`.
pub(crate) fn plan_as_toml(plan: &Plan, memory: &Memory) -> Result<String, Failure> {
    document(plan, memory)
        .map_err(|error| Failure::run(format!("the plan cannot be written: {error}")))
}

/// A scene as it was read, and what it states with the values of the command line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stated<'a> {
    /// Its text.
    pub(crate) input: &'a Input,
    /// Values put on top of it.
    pub(crate) set: &'a [String],
    /// All keys and files.
    pub(crate) scene: &'a Scene,
    /// Where it branches off from another run.
    pub(crate) branch: Option<&'a Branch>,
}

/// The outcome of a run.
#[derive(Debug)]
pub(crate) enum Ran {
    /// The run was made, at least until it was stopped.
    Now(Box<Report>),
    /// The run was to be resumed, but had already reached its end.
    Before {
        /// Where it lies.
        folder: PathBuf,
        /// Its end, s.
        time: f64,
    },
}

/// Runs it.
///
/// # Errors
/// Every reason that ends a run early, with advice.
pub(crate) fn run_plan(
    how: &How,
    plan: Plan,
    memory: &Memory,
    stated: Stated<'_>,
    requests: Requests,
    task_progress: &Arc<TaskProgress>,
    tell: &mut dyn FnMut(&Progress<'_>),
) -> Result<Ran, Failure> {
    let folder = (how.folder.clone()).unwrap_or_else(|| PathBuf::from(plan.outputs().prefix()));
    if let Some(wall) = plan.driven_wall() {
        return Err(Failure::input(format!(
            "wall `{wall}` is driven by another program: motion = \"external\""
        ))
        .with_help(
            "run the scene from that program, by mercury.h or mercury_dem; --check prints its plan",
        ));
    }
    keeps_within(how.within.as_ref(), &folder)?;
    if let Some(branch) = stated.branch {
        branch.check_folder(&folder).map_err(Failure::input)?;
    }
    // The folder is this run's until the end of the function; one that was made for it is not left empty.
    let is_new = !folder.exists();
    let made = is_new.then(|| cli::Temporary::new(&folder));
    let lock_file = cli::Temporary::new(&folder.join(folder::LOCK));
    let scene_file = &stated.input.path;
    let text = (stated.input.text.as_str(), stated.set);
    let mut claim = Claim::new(&folder, &plan, scene_file, stated.scene, text, how.earlier)
        .map_err(|error| match error.is_of_system() {
            true => Failure::run(error),
            false => Failure::input(error),
        })?;
    let from = claim.from.take();
    let mut notes = std::mem::take(&mut claim.notes);
    let is_over = |from: &&Checkpoint| is_over(from, &plan, &folder, how.until.as_ref());
    if let Some(checkpoint) = from.as_ref().filter(is_over) {
        let time = checkpoint.head.time();
        return Ok(Ran::Before { folder, time });
    }
    // Output that is written already needs no more space.
    let done = (from.as_ref()).map_or(0.0, |from| from.head.time() / end_of(&plan));
    let of_disk = disk_warning(&folder, (1.0 - done).max(0.0) * Disk::of(&plan).bytes);
    notes.extend(of_disk.map(|warning| format!("warning: {warning}")));
    if !how.quiet {
        let remarks = plan.notes().remarks().iter();
        let remarks = remarks.map(|remark| format!("note: {remark}"));
        // Now, not only at the end: a run may take a night.
        let warnings = plan.notes().warnings().iter();
        let warnings = warnings.map(|warning| format!("warning: {warning}"));
        for line in notes.iter().cloned().chain(remarks).chain(warnings) {
            // A closed standard error is not an error here.
            let _ = writeln!(std::io::stderr(), "{line}");
        }
    }
    let threads = how.threads_for(&plan);
    if let Some(progress) = &how.progress {
        progress.run(&folder, &plan, threads, from.as_ref());
    }
    let options = RunOptions {
        folder: folder.clone(),
        threads,
        fewer_where_faster: !how.fixed_threads,
        width: how.width,
        command_line: how.typed.clone(),
        plan_document: Some(plan_as_toml(&plan, memory)?),
        scene_text: Some(stated.input.text.clone()),
        scene_folder: Some(stated.scene.directory().to_owned()),
        chain: Some(Arc::clone(&claim.stated)),
        branch_of: stated
            .branch
            .map(Branch::origin)
            .or(claim.branch_of.clone()),
        stop: requests.stop,
        task_progress: Arc::clone(task_progress),
        time_limit: how.time_limit,
        checkpoints: Some(Checkpoints {
            every: how.checkpoint_every,
            at_end: how.checkpoint_every.is_some(),
            now: requests.checkpoint,
            scene: claim.stated.statement.clone(),
        }),
        notes,
        results: how.results.clone(),
        until: how.until.clone(),
        ranks: Arc::clone(&how.ranks),
        ..RunOptions::default()
    };
    let from = match stated.branch {
        Some(branch) => Some(
            branch
                .make(&options, tell)
                .map_err(|error| not_branched(&error))?,
        ),
        None => from,
    };
    let result = run_from(from, plan, &options, tell);
    drop(claim);
    drop(lock_file);
    if let (Some(_), Err(failure)) = (made, &result)
        && failure.is_stop()
    {
        // Only if nothing is in it.
        let _ = std::fs::remove_dir(&folder);
    }
    let report = result.map_err(|failure| match failure.is_stop() {
        true => stopped_early(),
        false => failed(&failure),
    })?;
    Ok(Ran::Now(Box::new(report)))
}

/// A branch that cannot be made.
pub(crate) fn not_branched(error: &BranchError) -> Failure {
    match error.mistakes() {
        Some(mistakes) => refused(mistakes),
        None if error.is_failure() => Failure::run(error),
        None => Failure::input(error),
    }
}

/// The planned end of a run, s.
fn end_of(plan: &Plan) -> f64 {
    plan.physics().steps as f64 * plan.physics().time_step
}

/// A warning where the disk that holds a folder, or will hold it, has less free space than these bytes of output.
pub(crate) fn disk_warning(folder: &Path, output: f64) -> Option<String> {
    let free = machine::free_disk(folder)?;
    (output > free).then(|| {
        format!(
            "output: about {} are to be written, and the disk of {} has {} free; write elsewhere with --output DIR, or less with a larger output.interval",
            bytes(output),
            folder.display(),
            bytes(free)
        )
    })
}

/// A run that could not go on, with what to do.
fn failed(failure: &RunFailure) -> Failure {
    let error = Failure::run(format!("the run failed: {failure}"));
    if machine::is_full_disk(failure) {
        error.with_help(
            "the disk is full: free some space on it and go on from the last checkpoint with --resume",
        )
    } else {
        error
    }
}

/// Refuses a folder that lies outside of the one that --within names, or in which a link leads there.
pub(crate) fn keeps_within(within: Option<&Arc<Within>>, folder: &Path) -> Result<(), Failure> {
    lies_within(within, folder)?;
    if within.is_none() {
        return Ok(());
    }
    // In it, in vtk/ and in the folder of checkpoints.
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries(folder) {
        let inside = entries(&entry.path());
        for entry in std::iter::once(entry).chain(inside) {
            if entry.file_type().is_ok_and(|kind| kind.is_symlink()) {
                lies_within(within, &entry.path())?;
            }
        }
    }
    Ok(())
}

/// A folder in use is an error of the command line; one that the system does not give is a failure of the run.
pub(crate) fn unusable(error: FolderError) -> Failure {
    match error {
        FolderError::System { .. } => Failure::run(error),
        _ => Failure::input(error),
    }
}
