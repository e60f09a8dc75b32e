//! Branches: runs that go as another run up to a time, and on with a changed scene.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mercury_common::readable::rounded;
use mercury_common::scene::{Scene, SceneErrors};
use mercury_common::whole_file::FileError;

use super::checkpoint::{self, Checkpoint, CheckpointError, MAY_CHANGE};
use super::claim::{ClaimError, stated_by};
use super::open::SceneInput;
use super::recorded::{Recorded, RecordedError};
use super::{Progress, Run, RunFailure, RunOptions};
use crate::output::chain::{CHAIN, Chain, ChainScene, Content, kept_checkpoints, kept_folder};
use crate::output::folder::VTK;
use crate::output::summary::BranchOf;
use crate::plan::{Head, Memory, Plan, checkpoint_paths};
use mercury_engine::step::{Engine, RunError, StartOptions};

/// Part of a length by which a wall may stand elsewhere by round-off.
const ROUND_OFF: f64 = 1e-9;

/// Why a run cannot branch off.
#[derive(Debug, thiserror::Error)]
pub enum BranchError {
    /// The other run cannot be used.
    #[error("--from: {0}")]
    Parent(#[from] RecordedError),
    /// The time is none of the other run.
    #[error("--at {at}: the run was made from {} to {} s\nhelp: name a time between them; {}", rounded(*first, 12), rounded(*last, 12), help)]
    Time {
        /// The time, s.
        at: f64,
        /// Beginning of the time that can be used, s.
        first: f64,
        /// Its end, s.
        last: f64,
        /// Remedy.
        help: &'static str,
    },
    /// The new scene ends before the branch.
    #[error("--at {at}: time.end is {} s\nhelp: a branch has to end behind it: --set time.end=TIME", rounded(*end, 12))]
    End {
        /// The time, s.
        at: f64,
        /// End of the new scene, s.
        end: f64,
    },
    /// A request stopped it before its first own step.
    #[error("stopped before the branch at t = {} s was reached\nhelp: the same command with --force begins again", rounded(*.0, 12))]
    Stopped(f64),
    /// The folder of the other run.
    #[error("{}: this is the folder of the run itself\nhelp: name another one with --output DIR", .0.display())]
    SameFolder(PathBuf),
    /// The new scene is wrong.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// A file of the new scene cannot be read.
    #[error(transparent)]
    Claim(#[from] ClaimError),
    /// Keys differ that may not.
    #[error("--from: these keys may not differ from those of the run:\n  {}\nhelp: in a branch numbers of laws, gravity, motions of walls, rates, velocities and times of insertions, times of outputs and time.end may differ; another scene starts from a state of the run with [[particles]] run = \"FOLDER\", at = TIME", .0.join("\n  "))]
    Keys(Vec<String>),
    /// The time step differs.
    #[error(
        "--from: time.step is {there} s in the run and {here} s here: a branch keeps the step of its run"
    )]
    Step {
        /// Step of the run, s.
        there: f64,
        /// Step of the new scene, s.
        here: f64,
    },
    /// A wall would jump.
    #[error("--from: {key}: wall `{wall}` would stand elsewhere at t = {} s, or come or go there\nhelp: let its old motion end there (until) and the new one begin (from)", rounded(*time, 12))]
    WallJumps {
        /// Key of its motion.
        key: String,
        /// Its name.
        wall: String,
        /// Time of the branch, s.
        time: f64,
    },
    /// An insertion would have to make up for another rate.
    #[error("--from: {key}: by t = {} s it would have inserted {here}, the run {there}\nhelp: give the rate as a table that agrees with the run up to there", rounded(*time, 12))]
    Rate {
        /// Key of the rate.
        key: String,
        /// Amount by the new rate.
        here: f64,
        /// Amount by the old one.
        there: f64,
        /// Time of the branch, s.
        time: f64,
    },
    /// The state does not fit the new scene.
    #[error("--from: the state of the run does not fit the new scene: {0}")]
    Unfit(RunError),
    /// The steps came out differently.
    #[error("{}: {what}, when the steps of the run were made again: its files were changed, or this machine computes differently\nhelp: `mercury-solve verify` says more", folder.display())]
    Differs {
        /// Folder of the run.
        folder: PathBuf,
        /// The difference.
        what: String,
    },
    /// A file of the other run cannot be copied.
    #[error(transparent)]
    File(#[from] FileError),
    /// The state cannot be written or read back.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The steps up to the branch failed.
    #[error(transparent)]
    Run(#[from] RunFailure),
}

impl BranchError {
    /// Whether the run failed; otherwise the input is wrong.
    #[must_use]
    pub fn is_failure(&self) -> bool {
        matches!(self, Self::File(_) | Self::Run(_) | Self::Stopped(_))
    }

    /// The mistakes of the new scene, if it has any.
    #[must_use]
    pub fn mistakes(&self) -> Option<&SceneErrors> {
        match self {
            Self::Scene(errors) | Self::Parent(RecordedError::Scene(errors)) => Some(errors),
            _ => None,
        }
    }
}

/// A branch that is planned.
#[derive(Debug)]
pub struct Branch {
    parent: Recorded,
    /// The new scene as text: that of the run, with the changes on top.
    pub input: SceneInput,
    /// The new scene.
    pub scene: Scene,
    /// Its plan.
    pub plan: Plan,
    /// Memory of its run.
    pub memory: Memory,
    /// Step from which on the new scene holds.
    pub step: u64,
    stated: ChainScene,
}

/// Whether a key may differ in a branch. What the new value may be is checked by its meaning: walls that would jump, rates.
fn may_differ(line: &str) -> bool {
    let (key, values) = line.split_once(": ").unwrap_or((line, ""));
    let kind: String = key.chars().filter(|c| !c.is_ascii_digit()).collect();
    let matches = |pattern: &&str| match pattern.strip_suffix('*') {
        Some(begin) => kind.starts_with(begin),
        None => kind == **pattern,
    };
    const FREE: [&str; 10] = [
        "gravity*",
        "guard.overlap",
        "guard.way",
        "liquid.evaporation",
        "walls[].motion*",
        "walls[].from",
        "walls[].until",
        "insertions[].rate*",
        "insertions[].velocity*",
        "insertions[].until",
    ];
    if MAY_CHANGE.iter().chain(&FREE).any(matches) {
        return true;
    }
    // Files are compared by the keys that name them.
    if key.starts_with("content of file ") {
        return true;
    }
    let is_number = |value: &str| value.parse::<f64>().is_ok();
    let then_and_now = values.strip_suffix(" now");
    let both = then_and_now.and_then(|values| values.split_once(" then, "));
    let of_law = [
        ".normal.",
        ".tangential.",
        ".rolling.",
        ".torsion.",
        ".adhesion.",
        ".liquid.",
    ];
    let is_of_law = (kind.starts_with("materials.") || kind.starts_with("contacts[]."))
        && of_law.iter().any(|law| kind.contains(law));
    let is_load = kind.starts_with("membranes[].pressure");
    (is_of_law || is_load) && both.is_some_and(|(then, now)| is_number(then) && is_number(now))
}

impl Branch {
    /// Plans a branch of the run in a folder at a time (s), with `KEY=VALUE` on top of its scene.
    ///
    /// # Errors
    /// Every reason why it cannot branch off there, or not so.
    pub fn plan(run: &Path, at: f64, set: &[String]) -> Result<Self, BranchError> {
        let parent = Recorded::open(run)?;
        let dt = parent.plan.physics().time_step;
        // With the slack of the schedule: a millionth of a step.
        let step = (at / dt - 1e-6).ceil().max(0.0) as u64;
        let (_, change) = parent.chain.stated();
        let last = parent.last_step();
        if !at.is_finite() || step == 0 || step < change || step > last {
            let help = match change {
                0 => "a run that is to go on is resumed with --resume",
                _ => "what was before was made with another scene",
            };
            return Err(BranchError::Time {
                at,
                first: change as f64 * dt,
                last: last as f64 * dt,
                help,
            });
        }
        let mut input = parent.input.clone();
        input.set.extend_from_slice(set);
        let (mut scene, mut plan, mut memory) = input.plan()?;
        let here = plan.physics().time_step;
        if here.to_bits() != dt.to_bits() {
            if set
                .iter()
                .any(|set| set.trim_start().starts_with("time.step"))
            {
                return Err(BranchError::Step { there: dt, here });
            }
            input.set.push(format!("time.step={dt:?}"));
            (scene, plan, memory) = input.plan()?;
        }
        let steps = plan.physics().steps;
        if steps <= step {
            let end = steps as f64 * dt;
            return Err(BranchError::End { at, end });
        }
        let stated = stated_by(&scene, &plan, (&input.text, &input.set))?;
        let (then, now) = (&parent.stated.statement, &stated.statement);
        let mut lines = mercury_common::scene::differences(then, now, &["time.step"]);
        lines.retain(|line| !may_differ(line));
        let [then, now] = [&parent.plan, &plan].map(|plan| plan.physics().laws.names_of_pairs());
        let pairs = then.iter().zip(&now).filter(|(then, now)| then != now);
        lines.extend(pairs.map(|(then, now)| format!("laws of a pair: {then} then, {now} now")));
        if !lines.is_empty() {
            return Err(BranchError::Keys(lines));
        }
        let branch = Self {
            parent,
            input,
            scene,
            plan,
            memory,
            step,
            stated,
        };
        branch.check_rates()?;
        Ok(branch)
    }

    /// Time of the branch, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.step as f64 * self.plan.physics().time_step
    }

    /// For the summary of its run.
    #[must_use]
    pub fn origin(&self) -> BranchOf {
        let links = self.parent.chain.links();
        let mut links = links.filter(|(link, _)| link.step <= self.step);
        BranchOf {
            run: self.parent.folder.display().to_string(),
            step: self.step,
            time: self.time(),
            link: links.next_back().map(|(_, link)| link.to_owned()),
        }
    }

    /// Refuses the folder of the other run.
    ///
    /// # Errors
    /// If it is the folder.
    pub fn check_folder(&self, folder: &Path) -> Result<(), BranchError> {
        let [there, here] = [&self.parent.folder, folder].map(std::fs::canonicalize);
        match there.is_ok_and(|there| here.is_ok_and(|here| there == here)) {
            true => Err(BranchError::SameFolder(folder.to_owned())),
            false => Ok(()),
        }
    }

    /// Refuses rates by which other amounts would have come.
    fn check_rates(&self) -> Result<(), BranchError> {
        let [then, now] = [&self.parent.plan, &self.plan].map(|plan| &plan.physics().insertions);
        let time = self.time();
        for (index, (then, now)) in then.iter().zip(now).enumerate() {
            let [(of_then, there), (of_now, here)] = [then, now].map(|insertion| {
                let rate = insertion.rate.as_ref();
                let allowed = rate.map(|rate| rate.allowed(insertion.from, time));
                allowed.map_or((None, 0.0), |(of, amount)| (Some(of), amount))
            });
            if of_then != of_now || (there - here).abs() > ROUND_OFF * there.abs() {
                return Err(BranchError::Rate {
                    key: format!("insertions[{index}].rate"),
                    here,
                    there,
                    time,
                });
            }
        }
        Ok(())
    }

    /// Makes the steps up to the branch in a folder that is ready for a run: copies what the other run had written by its last checkpoint before, makes its
    /// steps again from there, which must give its links, and leaves the state from which the new scene goes on. `observe` gets the progress of
    /// these steps.
    ///
    /// # Errors
    /// If the steps come out differently, the state does not fit the new scene, or a file cannot be copied.
    pub fn make(
        &self,
        options: &RunOptions,
        observe: &mut dyn FnMut(&Progress<'_>),
    ) -> Result<Checkpoint, BranchError> {
        let Self { parent, step, .. } = self;
        let (_, change) = parent.chain.stated();
        let from = parent.last_checkpoint(change.max(1)..=*step);
        let at = from.as_ref().map_or(0, |from| from.head.step);
        let is_end = parent.chain.end().is_some() && *step == parent.last_step();
        if at < change.max(1) && change > 0 || is_end && at < *step {
            let help = match is_end {
                true => "its end left no checkpoint",
                false => {
                    "it has no checkpoint between that beginning and this time, and what was before was made with another scene"
                }
            };
            let dt = parent.plan.physics().time_step;
            return Err(BranchError::Time {
                at: self.time(),
                first: change as f64 * dt,
                last: parent.last_step() as f64 * dt,
                help,
            });
        }
        if let Some(from) = &from {
            copy_files(parent, from, &options.folder)?;
            let kept = kept_checkpoints(&parent.folder, &parent.prefix).into_iter();
            let to = kept_folder(&options.folder, &parent.prefix);
            for (_, path) in kept.filter(|(step, _)| *step <= from.head.step) {
                std::fs::create_dir_all(&to)
                    .map_err(FileError::of(&to, "the folder cannot be made"))?;
                copy(&path, &to.join(path.file_name().unwrap_or_default()))?;
            }
        }
        let again = RunOptions {
            branch_of: Some(self.origin()),
            chain: Some(Arc::new(parent.stated.clone())),
            checkpoints: None,
            until: None,
            // By the first rank alone: the others wait for what comes behind.
            ranks: Arc::default(),
            ..options.clone()
        };
        let mut run = match from {
            Some(from) => Run::resume(parent.plan.clone(), again, from)?,
            None => Run::new(parent.plan.clone(), again)?,
        };
        run.advance(self.time(), observe)?;
        if run.engine.steps() < *step {
            return Err(BranchError::Stopped(self.time()));
        }
        let path = checkpoint_paths(&options.folder, &parent.prefix)[0].clone();
        self.check_links(&options.folder)?;
        self.check_state(&mut run)?;
        run.leave(&self.plan, &self.stated.statement, &path)?;
        Ok(checkpoint::read(&path)?)
    }

    /// Refuses steps that came out differently.
    fn check_links(&self, folder: &Path) -> Result<(), BranchError> {
        let parent = &self.parent;
        let chain = Chain::read(&folder.join(format!("{}.{CHAIN}", parent.prefix)));
        let chain = chain.map_err(RecordedError::from)?;
        let lines = chain.lines.iter().zip(&parent.chain.lines).skip(1);
        for (number, (found, expected)) in lines.enumerate() {
            if let Content::Link(_) = found.content
                && found.content != expected.content
            {
                let step = found.content.step();
                return Err(BranchError::Differs {
                    folder: parent.folder.clone(),
                    what: format!("link {} (step {step}) came out differently", number + 1),
                });
            }
        }
        Ok(())
    }

    /// Refuses a new scene that the state does not fit.
    fn check_state(&self, run: &mut Run) -> Result<(), BranchError> {
        run.engine.complete_step().map_err(RunFailure::from)?;
        let options = StartOptions::threads(1);
        let engine = Engine::resume(Arc::new(self.plan.clone()), run.engine.snapshot(), options);
        let engine = engine.map_err(BranchError::Unfit)?;
        let (low, high) = self.plan.physics().cell.corners();
        let near = ROUND_OFF * (high - low).length();
        let walls = run.engine.walls().iter().zip(engine.walls());
        for (index, (then, now)) in walls.enumerate() {
            let (then, now) = (&then.state, &now.state);
            let turn = then
                .pose
                .rotation
                .to_array()
                .into_iter()
                .zip(now.pose.rotation.to_array());
            let turned = turn.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let moved = (then.reference - now.reference).length();
            if then.present != now.present || moved > near || turned > ROUND_OFF {
                return Err(BranchError::WallJumps {
                    key: format!("walls[{index}].motion"),
                    wall: self.plan.physics().walls[index].name.clone(),
                    time: self.time(),
                });
            }
        }
        Ok(())
    }
}

impl Run {
    /// Leaves the files and the state of now, from which a run of another plan goes on, and no file of the end.
    fn leave(
        mut self,
        plan: &Plan,
        statement: &std::collections::BTreeMap<String, String>,
        path: &Path,
    ) -> Result<(), RunFailure> {
        self.engine.complete_step()?;
        let head = Head::of(plan, statement, self.engine.steps());
        let state = checkpoint::encode_as(&self, &head);
        let checkpoint = self.to_write(Some(path.to_owned()), state, false);
        // If the writer has given up, `finish` returns the reason.
        let _ = self.writer.write_checkpoint(checkpoint);
        self.writer.finish()?;
        Ok(())
    }
}

/// Copies the files of a run that a checkpoint counts on, so that it goes on in another folder.
pub(crate) fn copy_files(
    run: &Recorded,
    from: &Checkpoint,
    folder: &Path,
) -> Result<(), FileError> {
    for name in from.positions.streams().keys() {
        let name = match name.as_str() {
            VTK => continue,
            name => format!("{}.{name}", run.prefix),
        };
        copy(&run.folder.join(&name), &folder.join(&name))?;
    }
    if from.positions.streams().contains_key(VTK) {
        let to = folder.join(VTK);
        std::fs::create_dir_all(&to).map_err(FileError::of(&to, "the folder cannot be made"))?;
        let own = format!("{}.", run.prefix);
        let entries = std::fs::read_dir(run.folder.join(VTK))
            .into_iter()
            .flatten();
        for entry in entries.flatten() {
            if entry.file_name().to_string_lossy().starts_with(&own) {
                copy(&entry.path(), &to.join(entry.file_name()))?;
            }
        }
    }
    Ok(())
}

/// Copies the content of a file, without its rights: the run may be read-only.
fn copy(from: &Path, to: &Path) -> Result<(), FileError> {
    let copied = || -> io::Result<()> {
        let mut source = std::fs::File::open(from)?;
        let mut target = std::fs::File::create(to)?;
        io::copy(&mut source, &mut target).map(drop)
    };
    copied().map_err(FileError::of(from, "the file cannot be copied"))
}
