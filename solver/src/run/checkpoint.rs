//! Checkpoints: files from which a run continues exactly.
//!
//! `<prefix>.0.restart` and `<prefix>.1.restart` alternate, so that one is whole while the other is written. Each holds the
//! statement of the scene, the state of the run beside the engine, the engine's state ([`Snapshot`]), and the positions of the
//! outputs.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use mercury_common::readable::{bytes, printable, rounded};
use mercury_common::scene::differences;
use mercury_common::whole_file::FileError;
use serde_json::{Value, json};

use super::Run;
use super::rest_criterion::Rest;
use crate::output::{Exchanged, Positions};
use crate::plan::{Head, POSITIONS, Plan, checkpoint_paths};
use mercury_engine::forces::{SavedSlots, SlotState};
use mercury_engine::state::{DecodeError, Decoder, Encoder, Plain as _};
use mercury_engine::step::Snapshot;

/// Keys of a scene that may change before its run goes on: they decide when a run ends and when it writes, not the physics.
pub const MAY_CHANGE: [&str; 15] = [
    "title",
    "time.end",
    "time.until.*",
    "time.until[*",
    "results*",
    "sprays[].max_droplets",
    "output.interval",
    "output.rows_interval",
    "output.fstat_interval",
    "output.vtk_interval",
    "output.track_interval",
    "output.restart_interval",
    "output.link_interval",
    "output.keep_checkpoints",
    "output.pictures",
];

/// The keys that may change, in words.
fn may_change() -> String {
    let mut keys: Vec<&str> = (MAY_CHANGE.iter())
        .map(|key| match key.strip_suffix('*') {
            Some(beginning) => beginning.trim_end_matches(['.', '[']),
            None => key,
        })
        .collect();
    keys.dedup();
    keys.join(", ")
}

/// Why a run cannot go on from a checkpoint.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The operating system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// The bytes are no whole checkpoint.
    #[error("{}: {error}", path.display())]
    Bytes {
        /// The file.
        path: PathBuf,
        /// Error of the decoder.
        error: DecodeError,
    },
    /// There are checkpoints, and none of them is whole.
    #[error("no checkpoint can be used:\n  {}\nhelp: begin anew with --force", .0.join("\n  "))]
    AllDamaged(Vec<String>),
    /// The checkpoint is of another scene.
    #[error(
        "{}: the checkpoint is of another scene:\n  {}\nhelp: only {} may change before a run goes on; begin anew with --force, or write elsewhere with --output DIR; another scene starts from a state of this run with [[particles]] run = \"FOLDER\", at = TIME",
        path.display(), lines.join("\n  "), may_change()
    )]
    OtherScene {
        /// The file.
        path: PathBuf,
        /// Differences, a line each.
        lines: Vec<String>,
    },
    /// The checkpoint is behind the end of the run.
    #[error(
        "{}: the checkpoint is at t = {} s, behind time.end = {} s\nhelp: raise time.end, or begin anew with --force; another run starts from a state in between with [[particles]] run = \"FOLDER\", at = TIME",
        path.display(), rounded(*time, 12), rounded(*end, 12)
    )]
    BehindEnd {
        /// The file.
        path: PathBuf,
        /// Time of the checkpoint, s.
        time: f64,
        /// End of the plan, s.
        end: f64,
    },
}

/// State of a run beside the engine.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Known {
    pub(super) rest: Option<Rest>,
    /// A wall is worn to the depth at which the run ends.
    pub(super) is_worn: bool,
    /// Amounts exchanged before the first step.
    pub(super) at_start: Exchanged,
}

mercury_engine::state::plain!(Known {
    rest,
    is_worn,
    at_start
});

/// A checkpoint that was read.
#[derive(Debug, Clone)]
pub struct Checkpoint {
    /// The file.
    pub path: PathBuf,
    /// Identity of its run.
    pub head: Head,
    pub(super) known: Known,
    /// The state of the engine.
    pub snapshot: Snapshot,
    /// How far the outputs had come.
    pub positions: Positions,
    /// Bytes of the file.
    pub size: usize,
}

/// All but the positions of the outputs, which the writer adds.
pub(super) fn encode(run: &Run) -> Encoder {
    let (chain, checkpoints) = (&run.options.chain, &run.options.checkpoints);
    let none = BTreeMap::new();
    let scene = chain.as_ref().map(|scene| &scene.statement);
    let scene = scene.or(checkpoints.as_ref().map(|checkpoints| &checkpoints.scene));
    let head = Head::of(&run.plan, scene.unwrap_or(&none), run.engine.steps());
    encode_as(run, &head)
}

/// Encodes all but the positions of the outputs with another identity.
pub(super) fn encode_as(run: &Run, head: &Head) -> Encoder {
    let known = Known {
        rest: run.rest.clone(),
        is_worn: run.engine.is_worn(),
        at_start: run.at_start,
    };
    let mut encoder = Encoder::reusing(run.writer.spent_memory());
    encoder.section("head", head);
    encoder.section("run", &known);
    run.engine.add_state_to(&mut encoder);
    encoder
}

/// Reads a checkpoint as a whole, all checksums compared. The values of the engine's state are decoded, and checked, when a run
/// goes on from it.
///
/// # Errors
/// If the file cannot be read, or is no whole checkpoint of this version of the program.
pub fn read(path: &Path) -> Result<Checkpoint, CheckpointError> {
    let failed = FileError::of(path, "the checkpoint cannot be read");
    let bytes = std::fs::read(path).map_err(failed)?;
    let decode = || {
        let mut decoder = Decoder::new(&bytes)?;
        let head: Head = decoder.section("head")?;
        let checkpoint = Checkpoint {
            path: path.to_owned(),
            head,
            known: decoder.section("run")?,
            snapshot: Snapshot::take_from(&mut decoder, POSITIONS)?,
            positions: decoder.section(POSITIONS)?,
            size: bytes.len(),
        };
        decoder.finish()?;
        if checkpoint.head.step != checkpoint.snapshot.steps()? {
            return Err(DecodeError::Wrong {
                section: "clock".to_owned(),
                reason: "another number of steps than in the head".to_owned(),
            });
        }
        Ok(checkpoint)
    };
    decode().map_err(|error| CheckpointError::Bytes {
        path: path.to_owned(),
        error,
    })
}

/// The newest whole checkpoint of a run, and a message for each that is not whole; `None` if there is none at all.
///
/// # Errors
/// If there are checkpoints, and none is whole.
pub fn newest(
    folder: &Path,
    prefix: &str,
) -> Result<Option<(Checkpoint, Vec<String>)>, CheckpointError> {
    let mut newest: Option<Checkpoint> = None;
    let mut damaged = Vec::new();
    for path in checkpoint_paths(folder, prefix) {
        if path.symlink_metadata().is_err() {
            continue;
        }
        match read(&path) {
            Ok(found) => {
                let is_newer = |known: &Checkpoint| found.head.step > known.head.step;
                if newest.as_ref().is_none_or(is_newer) {
                    newest = Some(found);
                }
            }
            Err(error) => damaged.push(error.to_string()),
        }
    }
    match newest {
        Some(checkpoint) => Ok(Some((checkpoint, damaged))),
        None if damaged.is_empty() => Ok(None),
        None => Err(CheckpointError::AllDamaged(damaged)),
    }
}

impl Checkpoint {
    /// Whether a run of this plan can go on from here. `scene` is the statement of its scene.
    ///
    /// # Errors
    /// The scene or the program differs from that of the checkpoint.
    pub fn fits(
        &self,
        plan: &Plan,
        scene: &BTreeMap<String, String>,
    ) -> Result<(), CheckpointError> {
        let mut lines = differences(&self.head.scene, scene, &MAY_CHANGE);
        let program = env!("CARGO_PKG_VERSION");
        if self.head.program != program {
            let then = &self.head.program;
            lines.push(format!("mercury-solve: {then} then, {program} now"));
        }
        // Also by way of a shorter interval.
        let (then, now) = (self.head.time_step, plan.physics().time_step);
        if then.to_bits() != now.to_bits() {
            lines.push(format!("the time step: {then} s then, {now} s now"));
        }
        if !lines.is_empty() {
            return Err(CheckpointError::OtherScene {
                path: self.path.clone(),
                lines,
            });
        }
        if self.head.step > plan.physics().steps {
            return Err(CheckpointError::BehindEnd {
                path: self.path.clone(),
                time: self.head.time(),
                end: plan.physics().steps as f64 * now,
            });
        }
        Ok(())
    }

    /// The sections of its state, with their contents: those of a link.
    #[must_use]
    pub fn sections(&self) -> Vec<(&str, Vec<u8>)> {
        let mut known = Vec::new();
        self.known.put(&mut known);
        let state = self.snapshot.sections().iter();
        let state = state.map(|(name, content)| (name, content.to_vec()));
        std::iter::once(("run", known)).chain(state).collect()
    }

    /// Whether a run of this plan has reached its end.
    #[must_use]
    pub fn is_at_end(&self, plan: &Plan) -> bool {
        let at_rest = self.known.rest.as_ref().is_some_and(Rest::is_over);
        at_rest || self.known.is_worn || self.head.step >= plan.physics().steps
    }
}

/// The number of slots with a contact, and of all slots of a list.
fn touching(slots: &SavedSlots) -> (usize, usize) {
    let held = slots.iter().filter(|slot| slot.state != SlotState::Near);
    (held.count(), slots.len())
}

/// The statement of a scene as a value: all of it is TOML except what was added for files.
fn typed(text: &str) -> Value {
    let parsed = format!("v = {text}").parse::<toml::Table>().ok();
    let value = parsed.and_then(|mut table| table.remove("v"));
    value.map_or_else(|| text.into(), |value| json!(value))
}

/// Content of a checkpoint, decoded.
#[derive(Debug)]
pub struct Contents<'a> {
    of: &'a Checkpoint,
    grains: usize,
    rows: usize,
    bodies: usize,
    /// Pairs, and particles near walls: how many touch, and how many are listed.
    pairs: (usize, usize),
    walls: (usize, usize),
    lists_built: u64,
}

impl Checkpoint {
    /// Content of the checkpoint.
    ///
    /// # Errors
    /// If a section holds no such values.
    pub fn contents(&self) -> Result<Contents<'_>, CheckpointError> {
        let decode = || {
            let particles = self.snapshot.particles()?;
            Ok(Contents {
                of: self,
                grains: particles.grains(),
                rows: particles.len(),
                bodies: particles.bodies().len(),
                pairs: touching(&self.snapshot.pairs()?),
                walls: touching(&self.snapshot.near_walls()?),
                lists_built: self.snapshot.lists()?.rebuilds,
            })
        };
        decode().map_err(|error| CheckpointError::Bytes {
            path: self.path.clone(),
            error,
        })
    }
}

impl Contents<'_> {
    /// For programs.
    #[must_use]
    pub fn as_json(&self) -> Value {
        let Self { of, .. } = self;
        let head = &of.head;
        let scene: serde_json::Map<String, Value> = (head.scene.iter())
            .map(|(key, value)| (key.clone(), typed(value)))
            .collect();
        json!({
            "file": of.path.display().to_string(),
            "bytes": of.size,
            "version": head.program,
            "title": head.title,
            "step": head.step,
            "time": head.time(),
            "time_step": head.time_step,
            "particles": self.grains,
            "rows": self.rows,
            "bodies": self.bodies,
            "contacts": self.pairs.0,
            "listed_pairs": self.pairs.1,
            "wall_contacts": self.walls.0,
            "listed_wall_pairs": self.walls.1,
            "lists_built": self.lists_built,
            "frames": of.positions.frames(),
            "scene": scene,
        })
    }
}

impl fmt::Display for Contents<'_> {
    /// For people.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { of, .. } = self;
        let head = &of.head;
        writeln!(
            f,
            "{}: a checkpoint of `{}`",
            of.path.display(),
            printable(&head.title)
        )?;
        writeln!(
            f,
            "  written by    mercury-solve {}, {}, all checksums right",
            printable(&head.program),
            bytes(of.size as f64)
        )?;
        writeln!(
            f,
            "  time          {} s, step {} of {:?} s",
            rounded(head.time(), 12),
            head.step,
            head.time_step
        )?;
        writeln!(
            f,
            "  particles     {} in {} rows, {} rigid bodies",
            self.grains, self.rows, self.bodies
        )?;
        let (pairs, walls) = (self.pairs, self.walls);
        writeln!(
            f,
            "  contacts      {} of {} listed pairs, {} of {} with walls",
            pairs.0, pairs.1, walls.0, walls.1
        )?;
        writeln!(f, "  lists built   {} times", self.lists_built)?;
        writeln!(
            f,
            "  outputs       {} frames written",
            of.positions.frames()
        )?;
        write!(f, "  scene")?;
        for (key, value) in &head.scene {
            write!(f, "\n    {} = {}", printable(key), printable(value))?;
        }
        Ok(())
    }
}
