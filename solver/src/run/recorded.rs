//! A run that lies in a folder, with its scene planned again: the start of branches and of the program that verifies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mercury_common::folder_owner::is_written;
use mercury_common::scene::SceneErrors;
use mercury_common::whole_file::FileError;

use super::checkpoint::{self, Checkpoint};
use super::claim::{ClaimError, stated_by};
use super::looks::write_results;
use super::open::SceneInput;
use super::origin::Origin;
use super::{Ending, Run, RunFailure};
use crate::output::chain::{
    CHAIN, Chain, ChainError, ChainScene, Link, PHYSICS, Stated, kept_checkpoints, state_sum,
};
use crate::output::folder::earlier_prefix;
use crate::output::{OutputError, Positions};
use crate::plan::{Head, Memory, POSITIONS, Plan, checkpoint_paths, sha256};
use mercury_common::scene::Scene;
use mercury_engine::state::Plain as _;

/// Why the steps of a run cannot be made again.
#[derive(Debug, thiserror::Error)]
pub enum RecordedError {
    /// There is no run.
    #[error("{}: there is no run in this folder (it has no plan.toml)", .0.display())]
    NoRun(PathBuf),
    /// The run is being made.
    #[error("{}: this folder is being written by another run\nhelp: wait for its end or stop it", .0.display())]
    Running(PathBuf),
    /// It has no chain.
    #[error("{}: the run has no chain (there is no {prefix}.{CHAIN}), so its steps cannot be checked\nhelp: a version of the program without chains made it; make the run again", folder.display())]
    NoChain {
        /// The folder.
        folder: PathBuf,
        /// Of its files.
        prefix: String,
    },
    /// Another program made it.
    #[error("physics {there} in the run, {here} in this program: only a program with physics {there} can make its steps again", here = PHYSICS)]
    OtherPhysics {
        /// That of the run.
        there: u32,
    },
    /// The chain does not hold.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// A file that belongs to the run cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file of the scene is not the one of the run.
    #[error("{}: the file ({key}) is not the one of which the run was made: its SHA-256 is {found}, it was {expected}", path.display())]
    OtherFile {
        /// The file.
        path: PathBuf,
        /// Its key.
        key: String,
        /// SHA-256 now.
        found: String,
        /// SHA-256 then.
        expected: String,
    },
    /// The scene is not the one of the run.
    #[error("{}: the scene, as this program reads it, is not the one of the run: the sum of its keys is {found}, it was {expected}", path.display())]
    OtherScene {
        /// The file.
        path: PathBuf,
        /// Sum of the statement now.
        found: String,
        /// Sum then.
        expected: String,
    },
    /// The scene cannot be read or planned any more.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// A file of the scene cannot be read.
    #[error(transparent)]
    Claim(#[from] ClaimError),
    /// A wall is driven by another program.
    #[error(
        "wall `{0}` is driven by another program, so that the steps cannot be made again from the scene alone"
    )]
    Driven(String),
}

impl RecordedError {
    /// Whether something of the run was changed, so that it differs from what its chain says.
    #[must_use]
    pub fn is_difference(&self) -> bool {
        match self {
            Self::Chain(error) => matches!(error, ChainError::Line { .. }),
            Self::OtherFile { key, .. } => key == SCENE,
            Self::OtherScene { .. } => true,
            _ => false,
        }
    }
}

/// Key of the scene itself among the files of a chain.
pub(crate) const SCENE: &str = "scene";

/// A run in a folder.
#[derive(Debug)]
pub struct Recorded {
    /// Its folder.
    pub folder: PathBuf,
    /// Of its files.
    pub prefix: String,
    /// Its chain.
    pub chain: Chain,
    /// Its scene as text.
    pub input: SceneInput,
    /// Its scene.
    pub scene: Scene,
    /// Its plan.
    pub plan: Plan,
    /// Memory of its run.
    pub memory: Memory,
    /// As the chain states it.
    pub stated: ChainScene,
}

impl Recorded {
    /// Reads the run in a folder, in which nothing is changed.
    ///
    /// # Errors
    /// Every reason why its steps cannot be made again.
    pub fn open(folder: &Path) -> Result<Self, RecordedError> {
        let prefix = earlier_prefix(folder).ok_or_else(|| RecordedError::NoRun(folder.into()))?;
        if is_written(folder) {
            return Err(RecordedError::Running(folder.into()));
        }
        let path = folder.join(format!("{prefix}.{CHAIN}"));
        if !path.exists() {
            let folder = folder.to_owned();
            return Err(RecordedError::NoChain { folder, prefix });
        }
        let chain = Chain::read(&path)?;
        let there = chain.first().physics;
        if there != PHYSICS {
            return Err(RecordedError::OtherPhysics { there });
        }
        let (then, _) = chain.stated();
        let input = scene_of(folder, &prefix, then)?;
        let (scene, plan, memory) = input.plan()?;
        if let Some(wall) = plan.driven_wall() {
            return Err(RecordedError::Driven(wall.to_owned()));
        }
        let stated = stated_by(&scene, &plan, (&input.text, &input.set))?;
        check_files(then, &stated.stated, &scene, &plan)?;
        if stated.stated.scene != then.scene {
            return Err(RecordedError::OtherScene {
                path: scene_file(folder, &prefix),
                found: stated.stated.scene,
                expected: then.scene.clone(),
            });
        }
        Ok(Self {
            folder: folder.to_owned(),
            prefix,
            chain,
            input,
            scene,
            plan,
            memory,
            stated,
        })
    }

    /// Whole checkpoints of its present scene by their steps, those at links whose state is the link's, and a message for each other one.
    #[must_use]
    pub fn checkpoints(&self) -> (Vec<Checkpoint>, Vec<String>) {
        let kept = kept_checkpoints(&self.folder, &self.prefix).into_values();
        let alternating = checkpoint_paths(&self.folder, &self.prefix);
        let there = alternating.into_iter().filter(|path| path.exists());
        let (mut whole, mut problems) = (Vec::new(), Vec::new());
        for path in kept.chain(there) {
            match self.checkpoint(&path) {
                Ok(checkpoint) => whole.push(checkpoint),
                Err(problem) => problems.push(problem),
            }
        }
        whole.sort_by_key(|checkpoint| checkpoint.head.step);
        (whole, problems)
    }

    /// The last whole checkpoint of its present scene at a step in a range.
    #[must_use]
    pub fn last_checkpoint(&self, steps: std::ops::RangeInclusive<u64>) -> Option<Checkpoint> {
        let kept = kept_checkpoints(&self.folder, &self.prefix);
        let mut kept = kept.range(steps.clone()).rev();
        // One after the other, as they are large.
        let kept = kept.find_map(|(_, path)| self.checkpoint(path).ok());
        let alternating = checkpoint_paths(&self.folder, &self.prefix).into_iter();
        let alternating = alternating.filter_map(|path| self.checkpoint(&path).ok());
        let all = alternating.chain(kept);
        let all = all.filter(|found| steps.contains(&found.head.step));
        all.max_by_key(|found| found.head.step)
    }

    /// A checkpoint, if its run can have written it.
    ///
    /// # Errors
    /// Says in words what is wrong with it.
    pub fn checkpoint(&self, path: &Path) -> Result<Checkpoint, String> {
        let checkpoint = checkpoint::read(path).map_err(|error| error.to_string())?;
        let head = self.head_at(checkpoint.head.step);
        let wrong = |problem: String| Err(format!("{}: {problem}", path.display()));
        let step = checkpoint.head.step;
        let (_, change) = self.chain.stated();
        // Those of before were made with another scene, which is not there any more.
        if step > change && checkpoint.head != head {
            return wrong("its section `head` is not that of the run".to_owned());
        }
        let is_kept = path.parent().is_some_and(|parent| parent != self.folder);
        let Some((number, link)) = self.link_at(step) else {
            return match is_kept {
                true => wrong(format!("it is of step {step}, at which there is no link")),
                false => Ok(checkpoint),
            };
        };
        let sections = checkpoint.sections();
        let sections = sections
            .iter()
            .map(|(name, content)| (*name, [&content[..]]));
        if is_kept && state_sum(sections) != link.state {
            return wrong(format!(
                "its state is not that of link {number} (step {step})"
            ));
        }
        Ok(checkpoint)
    }

    /// Head of a checkpoint of this run at a step.
    fn head_at(&self, step: u64) -> Head {
        Head {
            program: self.chain.first().program.clone(),
            ..Head::of(&self.plan, &self.stated.statement, step)
        }
    }

    /// The link at a step, with its number from 1.
    #[must_use]
    pub fn link_at(&self, step: u64) -> Option<(usize, &Link)> {
        let mut links = self.chain.links().enumerate();
        let (index, (link, _)) = links.find(|(_, (link, _))| link.step == step)?;
        Some((index + 1, link))
    }

    /// The last step of which the chain knows.
    #[must_use]
    pub fn last_step(&self) -> u64 {
        let last = self.chain.lines.last();
        last.map_or(0, |line| line.content.step())
    }
}

/// The file with the copy of a run's scene.
fn scene_file(folder: &Path, prefix: &str) -> PathBuf {
    let json = folder.join(format!("{prefix}.scene.json"));
    match json.exists() {
        true => json,
        false => folder.join(format!("{prefix}.scene.toml")),
    }
}

/// The scene of which the run in a folder was made, which must be the one that its chain states.
fn scene_of(folder: &Path, prefix: &str, then: &Stated) -> Result<SceneInput, RecordedError> {
    let copy = scene_file(folder, prefix);
    let failed = FileError::of(&copy, "the scene of the run cannot be read");
    let bytes = std::fs::read(&copy).map_err(failed)?;
    let expected = then.files.iter().find(|file| file.key == SCENE);
    let expected = expected.map_or("", |file| &file.sha256);
    let found = sha256(&bytes);
    if found != expected {
        return Err(RecordedError::OtherFile {
            path: copy,
            key: SCENE.to_owned(),
            found,
            expected: expected.to_owned(),
        });
    }
    // By the default of `--output` a run lies beside its scene.
    let from = Origin::read(folder).scene_folder.unwrap_or("..".into());
    let ending = copy.extension().unwrap_or_default().to_string_lossy();
    Ok(SceneInput {
        path: folder.join(from).join(format!("{prefix}.{ending}")),
        // It has the sum of a text.
        text: String::from_utf8_lossy(&bytes).into_owned(),
        set: then.set.clone(),
    })
}

/// Refuses files of a scene that are not those of the run.
fn check_files(
    then: &Stated,
    now: &Stated,
    scene: &Scene,
    plan: &Plan,
) -> Result<(), RecordedError> {
    let paths = crate::plan::files(scene, plan).into_iter();
    let paths = std::iter::once(PathBuf::new()).chain(paths.map(|file| file.path));
    for ((then, now), path) in then.files.iter().zip(&now.files).zip(paths) {
        if then != now {
            return Err(RecordedError::OtherFile {
                path,
                key: now.key.clone(),
                found: now.sha256.clone(),
                expected: then.sha256.clone(),
            });
        }
    }
    Ok(())
}

impl Run {
    /// The sections of the present state, with their contents: those of a link.
    pub(crate) fn sections(&self) -> Vec<(String, Vec<u8>)> {
        let state = checkpoint::encode(self);
        let contents = state.contents().filter(|(name, _)| *name != "head");
        contents
            .map(|(name, content)| (name.to_owned(), content.concat()))
            .collect()
    }

    /// Makes the second half kick of the present step, if it is still due.
    pub(crate) fn complete_step(&mut self) -> Result<(), RunFailure> {
        Ok(self.engine.complete_step()?)
    }

    /// How far the outputs have come, once all that was passed on is written.
    pub(crate) fn output_positions(&self) -> Result<Positions, RunFailure> {
        Ok(self.writer.positions().ok_or(OutputError::Lost)?)
    }

    /// How far the outputs had come for the checkpoint of the end.
    pub(crate) fn positions_at_end(&self) -> Option<Positions> {
        let (checkpoint, _) = self.at_end.as_ref()?;
        let mut contents = checkpoint.state.contents();
        let (_, content) = contents.find(|(name, _)| *name == POSITIONS)?;
        Positions::take(&mut &content.concat()[..]).ok()
    }

    /// Sum of the last state, of a run that has come to its end.
    pub(crate) fn end_state(&self) -> Option<&String> {
        self.end_state.as_ref()
    }

    /// Closes all files, and ends the chain if the run has come to its end. No other file of the end is written.
    pub(crate) fn end_chain(self) -> Result<(), RunFailure> {
        let (_, chain) = self.writer.finish()?;
        if let Some(aims) = &self.aims {
            write_results(&self.options.folder, self.plan.outputs().prefix(), aims)?;
        }
        let ending = self.ended.and_then(Ending::word);
        if let (Some(mut chain), Some(state), Some(ending)) = (chain, self.end_state, ending) {
            let at = (self.engine.steps(), self.engine.time());
            chain.end(ending, at, state, BTreeMap::new())?;
        }
        Ok(())
    }
}
