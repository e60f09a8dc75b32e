//! `<prefix>.chain.jsonl`: links at simulated times, each a sum over the link before, the state, and the outputs up to there.
//!
//! Equal chains are equal runs, and a program that recomputes a link has made the same steps ([format](../../../../docs/formats/chain.md)).

mod lines;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use mercury_common::run_tables::RESULTS;
use mercury_common::scene::Scene;
use mercury_common::whole_file::FileError;
use mercury_engine::state::Encoder;
use mercury_engine::task::OutputFile;
use sha2::{Digest as _, Sha256};

pub use lines::{
    Begin, Chain, ChainError, ChainScene, Change, Content, End, EndResult, FileState, Line, Link,
    PHYSICS, Stated, StatedFile,
};
use lines::{first, line_of};

use super::stream::{OutputError, TextFile};
use crate::plan::{FileSum, Plan, files, hex, sha256, summed};

/// Ending of its file.
pub const CHAIN: &str = "chain.jsonl";

/// Section of a state with the loads on walls of a run that another program drives.
pub(crate) const WALL_LOADS: &str = "wall loads";

/// Sections of a checkpoint that are no part of a state: identity of the run, sums for the program that drives it.
const BESIDE_THE_STATE: [&str; 2] = ["head", WALL_LOADS];

/// SHA-256 of a state: of the name, the length (8 bytes, little-endian) and the content of each section, in their order.
pub fn state_sum<'a, C: AsRef<[&'a [u8]]>>(sections: impl Iterator<Item = (&'a str, C)>) -> String {
    let mut sum = Sha256::new();
    for (name, content) in sections {
        if BESIDE_THE_STATE.contains(&name) {
            continue;
        }
        let content = content.as_ref();
        let length: usize = content.iter().map(|piece| piece.len()).sum();
        sum.update(name.as_bytes());
        sum.update((length as u64).to_le_bytes());
        content.iter().for_each(|piece| sum.update(piece));
    }
    hex(&sum.finalize())
}

/// [`state_sum`] of a state that is to be written.
pub(crate) fn sum_of(state: &Encoder) -> String {
    state_sum(state.contents())
}

/// The scene of a run for its chain, with sums over the files that were read for it. `text` is that of the scene, and `set` was put on top.
///
/// # Errors
/// If a file cannot be read.
pub fn stated(
    scene: &Scene,
    plan: &Plan,
    statement: BTreeMap<String, String>,
    (text, set): (&str, &[String]),
) -> Result<ChainScene, (PathBuf, io::Error)> {
    let mut all = vec![StatedFile {
        key: "scene".to_owned(),
        bytes: text.len() as u64,
        sha256: sha256(text.as_bytes()),
    }];
    for file in files(scene, plan) {
        let (bytes, sha256) = summed(&file.path).map_err(|error| (file.path.clone(), error))?;
        all.push(StatedFile {
            key: file.key,
            bytes,
            sha256,
        });
    }
    Ok(ChainScene::new(statement, set.to_vec(), all))
}

/// Folder of the checkpoints that stay.
#[must_use]
pub fn kept_folder(folder: &Path, prefix: &str) -> PathBuf {
    folder.join(format!("{prefix}.checkpoints"))
}

/// The checkpoints that stayed, by their steps.
#[must_use]
pub fn kept_checkpoints(folder: &Path, prefix: &str) -> BTreeMap<u64, PathBuf> {
    let entries = std::fs::read_dir(kept_folder(folder, prefix));
    let paths = entries.into_iter().flatten().flatten();
    paths
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let step = name.strip_suffix(".restart")?;
            let is_plain = step.bytes().all(|byte| byte.is_ascii_digit());
            Some((step.parse().ok().filter(|_| is_plain)?, entry.path()))
        })
        .collect()
}

/// Of so many links, how many there are from one that stays to the next, so that at most `most` stay: the smallest power of 2.
fn spacing(links: usize, most: u64) -> usize {
    let mut spacing = 1;
    while (links / spacing) as u64 > most {
        spacing *= 2;
    }
    spacing
}

/// The chain of a run that is being written.
#[derive(Debug)]
pub struct ChainFile {
    folder: PathBuf,
    prefix: String,
    text: TextFile,
    last: String,
    /// Steps of the links.
    links: Vec<u64>,
    /// Files that grow, by their names.
    sums: BTreeMap<String, FileSum>,
    most_kept: u64,
}

impl ChainFile {
    /// Begins the chain of a run, or goes on with it behind so many bytes, at a step and a time (s).
    pub(super) fn begin(
        folder: &Path,
        plan: &Plan,
        scene: &Stated,
        from: Option<(u64, u64, f64)>,
    ) -> Result<Self, OutputError> {
        let prefix = plan.outputs().prefix().to_owned();
        let name = format!("{prefix}.{CHAIN}");
        let text = TextFile::begin(folder, &name, b"", from.map(|(position, ..)| position))?;
        let mut chain = Self {
            folder: folder.to_owned(),
            prefix,
            text,
            last: String::new(),
            links: Vec::new(),
            sums: BTreeMap::new(),
            most_kept: plan.outputs().files().keep_checkpoints,
        };
        let Some((_, step, time)) = from else {
            chain.append(&first(scene.clone()))?;
            return Ok(chain);
        };
        let read = Chain::read(&folder.join(name)).map_err(Box::new)?;
        chain.last = read.last().to_owned();
        chain.links = read.links().map(|(link, _)| link.step).collect();
        if read.stated().0 != scene {
            chain.append(&Content::Change(Change {
                change: step,
                time,
                stated: scene.clone(),
            }))?;
        }
        // They were made behind the state from which the run goes on.
        for (kept, path) in kept_checkpoints(folder, &chain.prefix) {
            if kept > step {
                let failed = FileError::of(&path, "the file cannot be removed");
                std::fs::remove_file(&path).map_err(failed)?;
            }
        }
        // The run may have been interrupted before.
        if chain.most_kept > 0 {
            chain.thin_out()?;
        }
        Ok(chain)
    }

    /// Appends a line in one stroke.
    fn append(&mut self, content: &Content) -> Result<(), OutputError> {
        let (line, link) = line_of(&self.last, content)?;
        self.text.buffer.extend_from_slice(line.as_bytes());
        self.text.flush()?;
        self.last = link;
        Ok(())
    }

    /// The file, as far as it is written.
    pub(super) fn file(&self) -> &TextFile {
        &self.text
    }

    /// The last link.
    #[must_use]
    pub fn last(&self) -> &str {
        &self.last
    }

    /// Takes in the bytes of the growing files up to here.
    fn take_in(&mut self, growing: &[OutputFile]) -> Result<(), FileError> {
        for file in growing {
            let path = self.folder.join(&file.name);
            let sum = self.sums.entry(file.name.clone()).or_default();
            sum.go_on(&path, Some(file.bytes))
                .map_err(FileError::of(&path, "the file cannot be read again"))?;
        }
        Ok(())
    }

    /// States of the files as they were taken in.
    fn outputs(&self) -> BTreeMap<String, FileState> {
        let sums = self.sums.iter();
        sums.map(|(name, sum)| (name.clone(), (sum.bytes, sum.hex())))
            .collect()
    }

    /// Appends the link of a state, whose sum this is, and of the growing files.
    pub(super) fn link(
        &mut self,
        step: u64,
        time: f64,
        state: String,
        growing: &[OutputFile],
    ) -> Result<(), OutputError> {
        self.take_in(growing)?;
        self.links.push(step);
        self.append(&Content::Link(Link {
            step,
            time,
            state,
            outputs: self.outputs(),
        }))
    }

    /// File for the checkpoint at the last link, if it is to stay.
    pub(super) fn to_keep(&self) -> Result<Option<PathBuf>, FileError> {
        let count = self.links.len();
        let Some(step) = self.links.last().filter(|_| self.most_kept > 0) else {
            return Ok(None);
        };
        if !count.is_multiple_of(spacing(count, self.most_kept)) {
            return Ok(None);
        }
        let folder = kept_folder(&self.folder, &self.prefix);
        std::fs::create_dir_all(&folder)
            .map_err(FileError::of(&folder, "the folder cannot be made"))?;
        Ok(Some(folder.join(format!("{step}.restart"))))
    }

    /// Removes the checkpoints that do not stay as there are enough others.
    pub(super) fn thin_out(&self) -> Result<(), FileError> {
        let spacing = spacing(self.links.len(), self.most_kept);
        let links = self.links.iter().skip(spacing - 1).step_by(spacing);
        let staying: Vec<u64> = links.copied().collect();
        for (step, path) in kept_checkpoints(&self.folder, &self.prefix) {
            if !staying.contains(&step) {
                let failed = FileError::of(&path, "the file cannot be removed");
                std::fs::remove_file(&path).map_err(failed)?;
            }
        }
        Ok(())
    }

    /// Notes which files grow, for [`ChainFile::end`].
    pub(super) fn note(&mut self, growing: &[OutputFile]) {
        for file in growing {
            self.sums.entry(file.name.clone()).or_default();
        }
    }

    /// Appends the end, when all files are closed.
    ///
    /// # Errors
    /// If a file cannot be read, or the line not written.
    pub fn end(
        &mut self,
        end: &str,
        (step, time): (u64, f64),
        state: String,
        results: BTreeMap<String, EndResult>,
    ) -> Result<(), OutputError> {
        let looks = format!("{}.{}", self.prefix, RESULTS.file);
        if self.folder.join(&looks).exists() {
            self.sums.insert(looks, FileSum::default());
        }
        for (name, sum) in &mut self.sums {
            let path = self.folder.join(name);
            sum.go_on(&path, None)
                .map_err(FileError::of(&path, "the file cannot be read again"))?;
        }
        let outputs = self.outputs();
        self.append(&Content::End(End {
            end: end.to_owned(),
            link: Link {
                step,
                time,
                state,
                outputs,
            },
            results,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_most_so_many_stay_and_they_are_evenly_spaced() {
        for most in [1, 2, 5, 16] {
            for links in 1..200 {
                let spacing = spacing(links, most);
                let stay = links / spacing;
                assert!(stay as u64 <= most);
                // Half of the most at least, once there are as many links.
                assert!(
                    stay as u64 >= most.div_ceil(2) || spacing == 1,
                    "{links} {most}"
                );
            }
        }
    }
}
