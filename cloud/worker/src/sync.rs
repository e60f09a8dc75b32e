//! Upload of the solver's files to the store: checkpoint, outputs, then the head by compare-and-swap.
//!
//! The solver writes on meanwhile. It does not have to wait: a checkpoint counts on outputs that were on the disk before
//! it got its name, so whatever is copied later holds them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::SystemTime;

use anyhow::{Context, Result};
use cloud_api::names::{Growth, growth};
use cloud_api::{Checkpoint, Segment, Whole};
use cloud_store::frames::{MARKER, whole_frames, whole_lines};
use rustix::fs::OFlags;

use crate::Attempt;
use crate::claim::{Held, Swapped};
use crate::progress::NewCheckpoint;
use crate::restore::{Workspace, resumes_at};

/// Segments of this length are not joined with later ones, in bytes: none is written more than a few times.
const LARGE: u64 = 64 << 20;

/// A file in the folder of the run.
struct Found {
    name: String,
    bytes: u64,
    changed: SystemTime,
}

/// Keeps the store up with the folder of the run.
pub(crate) struct Sync {
    /// How far each stream is known to be the same here and in the store.
    same: BTreeMap<String, u64>,
    /// First byte of what was committed of each stream behind the checkpoint.
    tail: BTreeMap<String, u64>,
    /// Length and time of change of whole files when they were sent.
    sent: BTreeMap<String, (u64, SystemTime)>,
    /// Counts whole files that were sent.
    count: u64,
    /// Keys that the head in hand does not name any more.
    replaced: Vec<String>,
    /// Keys that the head before did not name any more. They stay for one commit, since readers may have read that head.
    old: Vec<String>,
    /// Last committed state besides the files, to see whether there is anything to commit.
    committed: Option<(u64, u64)>,
}

impl Sync {
    pub(crate) fn new(held: &mut Held) -> Self {
        let head = &mut held.head;
        let checkpoint = head.checkpoint.as_ref();
        let same: BTreeMap<_, _> = head
            .streams
            .keys()
            .map(|name| (name.clone(), resumes_at(checkpoint, name)))
            .collect();
        Self {
            tail: same.clone(),
            same,
            sent: BTreeMap::new(),
            count: 0,
            replaced: Vec::new(),
            old: Vec::new(),
            committed: None,
        }
    }

    /// Leaves out what was committed behind the checkpoint: a run with another end need not make it again.
    pub(crate) fn forget_tails(
        &mut self,
        attempt: &Attempt,
        held: &mut Held,
        workspace: &Workspace,
    ) -> Result<()> {
        for (name, at) in self.same.clone() {
            self.cut(attempt, held, workspace, &name, at)?;
        }
        Ok(())
    }

    /// Commits what there is. `grows`: names of the files that the solver appends to. `last`: the solver has ended, its
    /// files are as they will stay.
    pub(crate) fn commit(
        &mut self,
        attempt: &Attempt,
        held: &mut Held,
        workspace: &Workspace,
        checkpoint: Option<&NewCheckpoint>,
        grows: &BTreeSet<String>,
        last: bool,
    ) -> Result<Swapped> {
        if let Some(checkpoint) = checkpoint {
            self.checkpoint(attempt, held, workspace, checkpoint)?;
        }
        let mut found = Vec::new();
        if workspace.output.is_dir() {
            list(&workspace.output, "", &mut found)?;
        }
        let mut changed = checkpoint.is_some() || last;
        for file in &found {
            changed |= match growth(&file.name) {
                Growth::Never | Growth::Checkpoint => false,
                Growth::Whole => self.whole(attempt, held, workspace, file)?,
                Growth::Frames | Growth::Lines if grows.contains(&file.name) => {
                    self.stream(attempt, held, workspace, file, last)?
                }
                // Means, which are written anew; or which files grow has not been said yet.
                Growth::Frames | Growth::Lines if grows.is_empty() && !last => false,
                Growth::Frames | Growth::Lines => self.whole(attempt, held, workspace, file)?,
            };
        }
        // Of kept checkpoints every other one goes when there are too many.
        let there: BTreeSet<&str> = found.iter().map(|file| file.name.as_str()).collect();
        let goes = |name: &str| !there.contains(name) && (last || name.ends_with(".restart"));
        let gone = held.head.whole.extract_if(.., |name, _| goes(name));
        let gone: Vec<String> = gone.map(|(_, whole)| whole.key).collect();
        changed |= !gone.is_empty();
        self.replaced.extend(gone);
        let steps = (held.head.step, held.head.notes.len() as u64);
        if !changed && self.committed == Some(steps) {
            return Ok(Swapped::Done);
        }
        if held.swap(attempt)? == Swapped::Superseded {
            return Ok(Swapped::Superseded);
        }
        self.committed = Some(steps);
        for key in std::mem::replace(&mut self.old, std::mem::take(&mut self.replaced)) {
            attempt.store.delete(&attempt.key(&key))?;
        }
        Ok(Swapped::Done)
    }

    /// Sends a checkpoint; the newest two are kept.
    fn checkpoint(
        &mut self,
        attempt: &Attempt,
        held: &mut Held,
        workspace: &Workspace,
        new: &NewCheckpoint,
    ) -> Result<()> {
        let mut file = open_written(&workspace.output.join(&new.name))
            .with_context(|| format!("checkpoint {}", new.name))?;
        let bytes = file.metadata()?.len();
        let key = format!("check/{}.{}.restart", attempt.epoch, held.head.commit + 1);
        let sha256 = attempt
            .store
            .put_file(&attempt.key(&key), &mut file, 0..bytes)?;
        let checkpoint = Checkpoint {
            name: new.name.clone(),
            key,
            step: new.step,
            revision: held.head.revision,
            bytes,
            sha256,
            outputs: new.outputs.clone(),
        };
        held.head.step = held.head.step.max(new.step);
        let before = held.head.checkpoint.replace(checkpoint);
        let old = std::mem::replace(&mut held.head.earlier, before);
        self.replaced.extend(old.map(|checkpoint| checkpoint.key));
        Ok(())
    }

    /// Sends a file that is written as a whole, if it has changed.
    fn whole(
        &mut self,
        attempt: &Attempt,
        held: &mut Held,
        workspace: &Workspace,
        found: &Found,
    ) -> Result<bool> {
        let state = (found.bytes, found.changed);
        if self.sent.get(&found.name) == Some(&state) {
            return Ok(false);
        }
        let Some(mut file) = open(&workspace.output.join(&found.name))? else {
            return Ok(false);
        };
        // As it is now, which may be later than when it was listed.
        let bytes = file.metadata()?.len();
        self.count += 1;
        let key = format!("whole/{}.{}", attempt.epoch, self.count);
        let sha256 = attempt
            .store
            .put_file(&attempt.key(&key), &mut file, 0..bytes)?;
        self.sent.insert(found.name.clone(), state);
        let before = held
            .head
            .whole
            .insert(found.name.clone(), Whole { bytes, sha256, key });
        self.replaced.extend(before.map(|whole| whole.key));
        Ok(true)
    }

    /// Sends what a stream has grown by. What the store has already is compared instead.
    fn stream(
        &mut self,
        attempt: &Attempt,
        held: &mut Held,
        workspace: &Workspace,
        found: &Found,
        last: bool,
    ) -> Result<bool> {
        let name = &found.name;
        let same = self.same.get(name).copied().unwrap_or(0);
        let Some(mut file) = open(&workspace.output.join(name))? else {
            return Ok(false);
        };
        let frames = growth(name) == Growth::Frames;
        let end = match (frames, last) {
            (true, _) => whole_frames(&mut file, same)?,
            (false, true) => file.metadata()?.len(),
            (false, false) => whole_lines(&mut file, same)?,
        };
        let known = held
            .head
            .streams
            .get(name)
            .map_or(0, |stream| stream.bytes());
        let mut changed = false;
        if same < known && end > same {
            let until = end.min(known);
            let tail_from = self.tail.get(name).copied().unwrap_or(0);
            let equal = compare(
                &mut file,
                same,
                until,
                &workspace.tail.join(name),
                tail_from,
            )?;
            self.same.insert(name.clone(), equal);
            if equal < until {
                held.note(
                    "not-reproduced",
                    format!("{name}: byte {equal} was made again to another value; what was seen behind it is replaced"),
                );
                self.cut(attempt, held, workspace, name, equal)?;
                changed = true;
            }
        }
        let known = held
            .head
            .streams
            .get(name)
            .map_or(0, |stream| stream.bytes());
        if end > known {
            self.push(attempt, held, &mut file, name, end)?;
            changed = true;
        }
        if last && frames {
            let length = file.metadata()?.len();
            if length != end + MARKER.len() as u64 {
                held.note(
                    "cut",
                    format!(
                        "{name}: {} bytes behind the last whole frame were left out",
                        length - end
                    ),
                );
            }
        }
        Ok(changed)
    }

    /// Adds a segment up to `end`, and joins it with the small ones before it: each byte is sent a few times at most, and
    /// there are few segments however often was committed.
    fn push(
        &mut self,
        attempt: &Attempt,
        held: &mut Held,
        file: &mut File,
        name: &str,
        end: u64,
    ) -> Result<()> {
        let segments = &mut held
            .head
            .streams
            .entry(name.to_owned())
            .or_default()
            .segments;
        let mut from = segments.last().map_or(0, |segment| segment.to);
        while let Some(before) = segments.last()
            && before.to - before.from < (2 * (end - from)).min(LARGE)
        {
            from = before.from;
            self.replaced
                .extend(segments.pop().map(|segment| segment.key));
        }
        let key = format!("data/{name}/{from}-{end}.{}", attempt.epoch);
        let sha256 = attempt
            .store
            .put_file(&attempt.key(&key), file, from..end)?;
        segments.push(Segment {
            from,
            to: end,
            sha256,
            key,
        });
        self.same.insert(name.to_owned(), end);
        Ok(())
    }

    /// Cuts a stream in the store at byte `at`, up to which it is the same as the file here.
    fn cut(
        &mut self,
        attempt: &Attempt,
        held: &mut Held,
        workspace: &Workspace,
        name: &str,
        at: u64,
    ) -> Result<()> {
        let Some(stream) = held.head.streams.get_mut(name) else {
            return Ok(());
        };
        while let Some(segment) = stream.segments.last()
            && segment.to > at
        {
            let from = segment.from;
            held.head.cuts += 1;
            self.replaced
                .extend(stream.segments.pop().map(|segment| segment.key));
            if from < at {
                let mut file = open_written(&workspace.output.join(name))?;
                let key = format!("data/{name}/{from}-{at}.{}", attempt.epoch);
                let sha256 = attempt
                    .store
                    .put_file(&attempt.key(&key), &mut file, from..at)?;
                stream.segments.push(Segment {
                    from,
                    to: at,
                    sha256,
                    key,
                });
            }
        }
        Ok(())
    }
}

/// Removes what an earlier attempt left in the store and the head does not name.
pub(crate) fn sweep(attempt: &Attempt, held: &Held) -> Result<()> {
    let head = &held.head;
    let named: BTreeSet<String> = (head.streams.values())
        .flat_map(|stream| stream.segments.iter().map(|segment| &segment.key))
        .chain(head.whole.values().map(|whole| &whole.key))
        .chain(
            [&head.checkpoint, &head.earlier]
                .into_iter()
                .flatten()
                .map(|checkpoint| &checkpoint.key),
        )
        .map(|key| attempt.key(key))
        .collect();
    for part in ["data/", "whole/", "check/"] {
        for entry in attempt.store.list(&attempt.key(part))? {
            if !named.contains(&entry.key) {
                attempt.store.delete(&entry.key)?;
            }
        }
    }
    Ok(())
}

/// How many bytes of all files are in the folder of the run.
pub(crate) fn size(output: &Path) -> Result<u64> {
    let mut found = Vec::new();
    if output.is_dir() {
        list(output, "", &mut found)?;
    }
    Ok(found.iter().map(|file| file.bytes).sum())
}

/// Opens a file that the solver has written. A link is refused: it may lead out of the folder of the run.
fn open_written(path: &Path) -> io::Result<File> {
    File::options()
        .read(true)
        .custom_flags(OFlags::NOFOLLOW.bits() as i32)
        .open(path)
}

fn open(path: &Path) -> Result<Option<File>> {
    match open_written(path) {
        Ok(file) => Ok(Some(file)),
        // Removed or renamed since it was listed.
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).with_context(|| format!("{}", path.display())),
    }
}

fn list(folder: &Path, prefix: &str, found: &mut Vec<Found>) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else {
            continue;
        };
        let name = format!("{prefix}{name}");
        // What is a link leads elsewhere; the solver makes none.
        match fs::symlink_metadata(entry.path()) {
            Ok(kind) if kind.is_dir() => list(&entry.path(), &format!("{name}/"), found)?,
            Ok(kind) if kind.is_file() => {
                found.push(Found {
                    name,
                    bytes: kind.len(),
                    changed: kind.modified()?,
                });
            }
            Ok(_) => {}
            Err(gone) if gone.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// Compares bytes `from..until` of `file` with the tail, whose first byte is number `tail_from`. Returns up to where
/// they are equal.
fn compare(file: &mut File, from: u64, until: u64, tail: &Path, tail_from: u64) -> Result<u64> {
    let mut before = File::open(tail).with_context(|| format!("{}", tail.display()))?;
    before.seek(SeekFrom::Start(from - tail_from))?;
    file.seek(SeekFrom::Start(from))?;
    let mut at = from;
    let (mut ours, mut theirs) = (vec![0; 1 << 16], vec![0; 1 << 16]);
    while at < until {
        let bytes = ((until - at) as usize).min(ours.len());
        file.read_exact(&mut ours[..bytes])?;
        before.read_exact(&mut theirs[..bytes])?;
        if let Some(differs) = (0..bytes).find(|&k| ours[k] != theirs[k]) {
            return Ok(at + differs as u64);
        }
        at += bytes as u64;
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "x").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        assert!(open_written(&file).is_ok());
        assert!(open_written(&link).is_err());
    }
}
