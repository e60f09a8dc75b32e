//! A run from the text of a scene, for programs that make it in pieces.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use mercury_common::machine;
use mercury_common::scene::{Files, Scene, SceneError, SceneErrors, read_scene_text};
use mercury_engine::task::TaskProgress;

use super::checkpoint::Checkpoint;
use super::{
    Branch, BranchError, Checkpoints, Claim, ClaimError, Run, RunFailure, RunOptions, check_fit,
    is_over, plan_within, useful_threads,
};
use crate::output::folder::Earlier;
use crate::plan::{Memory, Plan, document, read_all};
use crate::results::{NamedResult, requested};

/// The text of a scene, and changes of its keys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneInput {
    /// Its file, whose folder is that of the files it names; a text without a file has a name of its own.
    pub path: PathBuf,
    /// TOML or JSON.
    pub text: String,
    /// `KEY=VALUE`, put on top in their order.
    pub set: Vec<String>,
}

/// Why a run was not begun.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The scene is wrong.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// A requested result is not one of this run.
    #[error("{name}: {problem}")]
    Result {
        /// Name of the result.
        name: String,
        /// Description of the problem.
        problem: String,
    },
    /// The folder cannot be used.
    #[error(transparent)]
    Folder(#[from] ClaimError),
    /// The run has come to its end before.
    #[error(
        "{}: the run has come to its end at t = {time} s already\nhelp: a larger time.end makes it longer",
        folder.display()
    )]
    Over {
        /// The folder.
        folder: PathBuf,
        /// The end, s.
        time: f64,
    },
    /// It cannot branch off.
    #[error(transparent)]
    Branch(#[from] BranchError),
    /// The plan cannot be written.
    #[error("the plan cannot be written: {0}")]
    Plan(String),
    /// The run failed at its start.
    #[error(transparent)]
    Run(#[from] RunFailure),
}

impl SceneInput {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, or is not text.
    pub fn read(path: &Path) -> Result<Self, SceneErrors> {
        Ok(Self {
            path: path.to_owned(),
            text: read_scene_text(path)?,
            set: Vec::new(),
        })
    }

    /// The scene.
    ///
    /// # Errors
    /// All mistakes, also those that its plan would find.
    pub fn scene(&self) -> Result<Scene, SceneErrors> {
        read_all(&self.path, &self.text, &self.set, Files::MustExist)
    }

    /// The scene, its plan and the memory that its run takes.
    ///
    /// # Errors
    /// All mistakes, and a lack of memory.
    pub fn plan(&self) -> Result<(Scene, Plan, Memory), SceneErrors> {
        let scene = self.scene()?;
        let machine = machine::memory();
        let (plan, memory) = plan_within(&scene, machine)?;
        if let Some(machine) = machine {
            let fit = check_fit(&scene, &plan, &memory, machine);
            fit.map_err(|error: SceneError| SceneErrors(vec![error]))?;
        }
        Ok((scene, plan, memory))
    }
}

/// How a run is begun.
#[derive(Debug, Clone)]
pub struct OpenRun {
    /// The scene.
    pub input: SceneInput,
    /// The folder of its files.
    pub folder: PathBuf,
    /// Treatment of an earlier run in the folder.
    pub earlier: Earlier,
    /// Numbers for the summary, beside those of the scene; one of the same name replaces that of the scene.
    pub results: Vec<NamedResult>,
    /// Threads at most; `None`: those of the machine.
    pub threads: Option<usize>,
    /// Wall-clock time between checkpoints; `None`: none are written.
    pub checkpoint_every: Option<Duration>,
    /// Name of the caller, for `run.log`.
    pub called: String,
    /// Set to leave [`Run::advance`].
    pub pause: Arc<AtomicBool>,
    /// [`RunOptions::pieces_observed`]. Otherwise the loads on walls are summed up in every step, as also where a wall is driven from outside.
    pub pieces_observed: bool,
}

impl OpenRun {
    /// Begins the run, or goes on with it. The folder belongs to it until the claim is dropped.
    ///
    /// # Errors
    /// Every reason why it cannot begin.
    pub fn begin(self) -> Result<(Run, Claim), OpenError> {
        self.begin_with(None)
    }

    /// Makes the steps of another run up to a branch, and goes on with the scene of the branch, whose [`input`](Branch::input) this has.
    ///
    /// # Errors
    /// Every reason why it cannot begin.
    pub fn begin_branch(self, branch: &Branch) -> Result<(Run, Claim), OpenError> {
        self.begin_with(Some(branch))
    }

    fn begin_with(self, branch: Option<&Branch>) -> Result<(Run, Claim), OpenError> {
        let (scene, plan, memory) = self.input.plan()?;
        let (mut results, until) = requested(&scene, &plan)?;
        for result in &self.results {
            result.check(&plan).map_err(|problem| OpenError::Result {
                name: result.name.clone(),
                problem,
            })?;
        }
        results.retain(|result| self.results.iter().all(|other| other.name != result.name));
        results.extend(self.results);
        let folder = self.folder;
        if let Some(branch) = branch {
            branch.check_folder(&folder)?;
        }
        let SceneInput { path, text, set } = &self.input;
        let mut claim = Claim::new(&folder, &plan, path, &scene, (text, set), self.earlier)?;
        let from = claim.from.take();
        let is_over = |from: &&Checkpoint| is_over(from, &plan, &folder, until.as_ref());
        if let Some(from) = from.as_ref().filter(is_over) {
            let time = from.head.time();
            return Err(OpenError::Over {
                folder: folder.clone(),
                time,
            });
        }
        let available = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = self.threads.unwrap_or_else(available);
        let document =
            document(&plan, &memory).map_err(|error| OpenError::Plan(error.to_string()))?;
        let stop = Arc::new(AtomicBool::new(false));
        let options = RunOptions {
            folder,
            threads: useful_threads(&plan, threads),
            fewer_where_faster: true,
            command_line: self.called,
            plan_document: Some(document),
            scene_text: Some(self.input.text),
            scene_folder: Some(scene.directory().to_owned()),
            chain: Some(Arc::clone(&claim.stated)),
            branch_of: branch.map(Branch::origin).or(claim.branch_of.clone()),
            task_progress: Arc::new(TaskProgress::new(Arc::clone(&stop))),
            stop,
            pause: self.pause,
            pieces_observed: self.pieces_observed,
            wall_loads: !self.pieces_observed || plan.driven_wall().is_some(),
            checkpoints: self.checkpoint_every.map(|every| Checkpoints {
                every: Some(every),
                at_end: true,
                now: Arc::default(),
                scene: claim.stated.statement.clone(),
            }),
            notes: claim.notes.clone(),
            results,
            until,
            ..RunOptions::default()
        };
        let from = match branch {
            Some(branch) => Some(branch.make(&options, &mut |_| ())?),
            None => from,
        };
        let run = match from {
            Some(from) => Run::resume(plan, options, from)?,
            None => Run::new(plan, options)?,
        };
        Ok((run, claim))
    }
}
