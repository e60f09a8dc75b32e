//! Folder of an attempt, made from the committed files, in which the solver can go on.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use cloud_api::names::{Growth, check_input, growth};
use cloud_api::{Checkpoint, Head, RunId, Spec, Stream};
use cloud_store::frames::MARKER;

use crate::claim::Held;
use crate::solver::OUTPUT;
use crate::{Attempt, empty_folder};

/// Name of the folder with what was committed behind the checkpoint, and will be made again.
const TAIL: &str = ".tail";

/// The folder of an attempt.
pub(crate) struct Workspace {
    /// Inputs, and the run's folder.
    pub(crate) folder: PathBuf,
    /// The run's folder.
    pub(crate) output: PathBuf,
    /// Committed bytes behind the checkpoint.
    pub(crate) tail: PathBuf,
}

impl Drop for Workspace {
    fn drop(&mut self) {
        // What matters is in the store; what cannot be removed costs disk, nothing else.
        if let Err(error) = fs::remove_dir_all(&self.folder) {
            eprintln!("{}: {error}; it can be removed", self.folder.display());
        }
    }
}

/// Where the making of a stream goes on, in bytes; what is behind it is compared.
pub(crate) fn resumes_at(checkpoint: Option<&Checkpoint>, name: &str) -> u64 {
    checkpoint
        .and_then(|checkpoint| checkpoint.outputs.get(name))
        .copied()
        .unwrap_or(0)
}

/// Makes the folder of the attempt, with all that is committed. What is damaged is noted, and made again.
pub(crate) fn restore(attempt: &Attempt, held: &mut Held, spec: &Spec) -> Result<Workspace> {
    let folder = attempt
        .scratch
        .join(format!("{}.{}", attempt.run, attempt.epoch));
    // Absolute, since the solver is started in it.
    let folder = std::path::absolute(empty_folder(folder)?)?;
    let workspace = Workspace {
        output: folder.join(OUTPUT),
        tail: folder.join(TAIL),
        folder,
    };
    fs::create_dir_all(&workspace.tail)?;
    inputs(attempt, spec, &workspace)?;
    let candidates = [held.head.checkpoint.take(), held.head.earlier.take()];
    for (nth, checkpoint) in candidates.into_iter().flatten().enumerate() {
        match data(attempt, held, &workspace, &checkpoint) {
            Ok(()) => {
                if nth > 0 {
                    held.note(
                        "restored",
                        format!(
                            "went on from the older checkpoint, step {}",
                            checkpoint.step
                        ),
                    );
                }
                held.head.checkpoint = Some(checkpoint);
                return Ok(workspace);
            }
            Err(error) if error.chain().any(|cause| cause.is::<Damaged>()) => {
                held.note("damaged", format!("{error:#}"));
            }
            Err(error) => return Err(error),
        }
    }
    // From the beginning. What was seen of it already is compared with what is made again.
    empty_folder(workspace.output.clone())?;
    fs::remove_dir(&workspace.output)?;
    empty_folder(workspace.tail.clone())?;
    held.head.whole.clear();
    let streams = std::mem::take(&mut held.head.streams);
    for (name, stream) in streams {
        match fetch(attempt, &attempt.run, &stream, &workspace.tail.join(&name)) {
            Ok(()) => drop(held.head.streams.insert(name, stream)),
            Err(error) if error.chain().any(|cause| cause.is::<Damaged>()) => {
                held.note("damaged", format!("{error:#}"))
            }
            Err(error) => return Err(error),
        }
    }
    if let Some(branch) = &spec.branch {
        other_run(attempt, &branch.run, &workspace)?;
    }
    Ok(workspace)
}

/// Lays out the run from which this one branches off, in a folder with its id.
fn other_run(attempt: &Attempt, run: &RunId, workspace: &Workspace) -> Result<()> {
    let text = attempt.store.get(&format!("runs/{run}/head.json"))?;
    let text =
        text.with_context(|| format!("the run {run}, from which this one branches off, is gone"))?;
    let head: Head = serde_json::from_slice(&text)?;
    let folder = workspace.folder.join(run.as_str());
    for (name, stream) in &head.streams {
        let path = folder.join(name);
        fetch(attempt, run, stream, &path)?;
        if growth(name) == Growth::Frames {
            let mut file = OpenOptions::new().append(true).open(&path)?;
            file.write_all(&MARKER)?;
        }
    }
    let whole = head.whole.iter();
    let whole = whole.map(|(name, whole)| (name, &whole.key, &whole.sha256));
    let checkpoints = [&head.earlier, &head.checkpoint].into_iter().flatten();
    let checkpoints = checkpoints.map(|found| (&found.name, &found.key, &found.sha256));
    for (name, key, sha256) in whole.chain(checkpoints) {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        checked(attempt, run, key, sha256, &mut File::create(path)?)?;
    }
    Ok(())
}

fn inputs(attempt: &Attempt, spec: &Spec, workspace: &Workspace) -> Result<()> {
    for (name, input) in &spec.files {
        check_input(name).with_context(|| format!("input {name:?}"))?;
        let path = workspace.folder.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        let mut file = File::create_new(path)?;
        let key = format!("inputs/{}", input.sha256);
        let got = attempt.store.get_into(&key, &mut file)?;
        ensure!(
            got == input.sha256,
            "input {name}: its content in the store is damaged; submit it again"
        );
    }
    Ok(())
}

/// Something in the store is not what the head says.
#[derive(Debug)]
struct Damaged(String);

impl std::fmt::Display for Damaged {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} in the store is damaged or missing", self.0)
    }
}

impl std::error::Error for Damaged {}

/// Fetches a content, and compares it with what the head says of it.
fn checked(attempt: &Attempt, run: &RunId, key: &str, sha256: &str, file: &mut File) -> Result<()> {
    match attempt.store.get_into(&format!("runs/{run}/{key}"), file) {
        Ok(got) if got == sha256 => Ok(()),
        Ok(_) | Err(cloud_store::StoreError::Missing(_)) => bail!(Damaged(key.to_owned())),
        Err(error) => Err(error.into()),
    }
}

fn fetch(attempt: &Attempt, run: &RunId, stream: &Stream, path: &Path) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut file = File::create(path)?;
    for segment in &stream.segments {
        checked(attempt, run, &segment.key, &segment.sha256, &mut file)?;
    }
    Ok(())
}

/// Fetches a checkpoint and all files as they were then; what grew since goes into the tail.
fn data(
    attempt: &Attempt,
    held: &mut Held,
    workspace: &Workspace,
    checkpoint: &Checkpoint,
) -> Result<()> {
    empty_folder(workspace.output.clone())?;
    empty_folder(workspace.tail.clone())?;
    let mut file = File::create(workspace.output.join(&checkpoint.name))?;
    checked(
        attempt,
        &attempt.run,
        &checkpoint.key,
        &checkpoint.sha256,
        &mut file,
    )?;
    for (name, stream) in &held.head.streams {
        let path = workspace.output.join(name);
        fetch(attempt, &attempt.run, stream, &path)?;
        let at = resumes_at(Some(checkpoint), name);
        ensure!(at <= stream.bytes(), Damaged(name.clone()));
        let mut file = OpenOptions::new().read(true).write(true).open(&path)?;
        if at < stream.bytes() {
            file.seek(SeekFrom::Start(at))?;
            let tail = workspace.tail.join(name);
            if let Some(folder) = tail.parent() {
                fs::create_dir_all(folder)?;
            }
            io::copy(&mut file, &mut File::create(tail)?)?;
            file.set_len(at)?;
        }
        if growth(name) == Growth::Frames {
            file.seek(SeekFrom::End(0))?;
            file.write_all(&MARKER)?;
        }
    }
    for (name, whole) in &held.head.whole {
        let path = workspace.output.join(name);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        checked(
            attempt,
            &attempt.run,
            &whole.key,
            &whole.sha256,
            &mut File::create(path)?,
        )?;
    }
    Ok(())
}
