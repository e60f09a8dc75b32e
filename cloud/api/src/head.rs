//! Records of a run in the store: head, beat and control. The layout of the store is in `cloud/README.md`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::lifecycle::Wish;

/// `runs/R/head.json`: the one file that says what of a run is certain. Changed by compare-and-swap only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Head {
    /// The attempt that may change this file.
    pub epoch: u64,
    /// The spec that this attempt follows.
    pub revision: u32,
    /// Counts the changes, so that no two versions of the file are equal.
    pub commit: u64,
    /// How far the attempt is.
    pub phase: Phase,
    /// How the attempt ended.
    pub ending: Option<Ending>,
    /// Where a next attempt begins.
    pub checkpoint: Option<Checkpoint>,
    /// The one before, should the newest be damaged.
    pub earlier: Option<Checkpoint>,
    /// Files that grow, by name.
    #[serde(default)]
    pub streams: BTreeMap<String, Stream>,
    /// Counts how often bytes of streams were taken back: what was read before may be of another past then.
    #[serde(default)]
    pub cuts: u64,
    /// Files that are written as a whole, by name.
    #[serde(default)]
    pub whole: BTreeMap<String, Whole>,
    /// Steps that are certain: those of the checkpoint, at the end of the run all.
    pub step: u64,
    /// Steps of the whole run, where it is known.
    pub of_steps: Option<u64>,
    /// Simulated time in s, up to the last commit.
    pub time: f64,
    /// Machine of the attempt.
    pub machine: String,
    /// Processor time of this attempt, in core seconds.
    pub core_seconds: f64,
    /// Notes of attempts, oldest first; at most [`MOST_NOTES`].
    #[serde(default)]
    pub notes: Vec<Note>,
}

impl Head {
    /// Length of all files that it names, in bytes.
    pub fn bytes(&self) -> u64 {
        let checkpoints = [&self.checkpoint, &self.earlier].into_iter().flatten();
        self.streams.values().map(Stream::bytes).sum::<u64>()
            + self.whole.values().map(|whole| whole.bytes).sum::<u64>()
            + checkpoints.map(|checkpoint| checkpoint.bytes).sum::<u64>()
    }
}

/// The most notes that a head keeps.
pub const MOST_NOTES: usize = 100;

/// How far an attempt is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// No attempt has been made.
    #[default]
    Idle,
    /// The server has made the attempt; no worker has taken it yet.
    Launched,
    /// A worker has taken it.
    Running,
    /// It is over, and its data is in the store.
    Ended,
}

/// How an attempt ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Ending {
    /// Why.
    pub cause: Cause,
    /// Exit code of the solver, where it has one.
    pub code: Option<i32>,
    /// Message about it: the last lines of the solver, a reason.
    #[serde(default)]
    pub message: String,
}

/// Why an attempt ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Cause {
    /// The run reached its end.
    Finished,
    /// The provider takes the machine away.
    Spot,
    /// The user stopped it.
    User,
    /// The engine's limit of time.
    Time,
    /// The engine sent SIGTERM.
    Preempted,
    /// No sign of life.
    Lost,
    /// The solver made no steps.
    Hung,
    /// The outputs are larger than allowed.
    Disk,
    /// The solver needs more memory than allowed.
    Memory,
    /// The solver says that the run failed (exit code 1).
    Failed,
    /// The solver does not take the input (exit code 2).
    Input,
    /// The engine could not run it.
    Engine,
}

impl Cause {
    /// Whether the server makes another attempt by itself.
    pub fn tries_again(self) -> bool {
        matches!(
            self,
            Self::Spot | Self::Time | Self::Preempted | Self::Lost | Self::Engine
        )
    }
}

/// A checkpoint in the store: `runs/R/check/<epoch>.<commit>.restart`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Checkpoint {
    /// Its name in the folder of the run.
    pub name: String,
    /// Its key in the store, below `runs/R/`.
    pub key: String,
    /// Steps made when it was written.
    pub step: u64,
    /// The spec that it was made by.
    pub revision: u32,
    /// Length in bytes.
    pub bytes: u64,
    /// SHA-256 of the content.
    pub sha256: String,
    /// How long each growing file was then, where the solver says so. Bytes beyond are made again by the next attempt.
    #[serde(default)]
    pub outputs: BTreeMap<String, u64>,
}

/// A file that grows, in segments that follow each other without gap.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Stream {
    /// The pieces, from byte 0 on.
    pub segments: Vec<Segment>,
}

impl Stream {
    /// Length of all segments together, in bytes.
    pub fn bytes(&self) -> u64 {
        self.segments.last().map_or(0, |segment| segment.to)
    }
}

/// A piece of a file that grows.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Segment {
    /// First byte.
    pub from: u64,
    /// One behind the last byte.
    pub to: u64,
    /// SHA-256 of the content.
    pub sha256: String,
    /// Its key in the store, below `runs/R/`: `data/<name>/<from>-<to>.<epoch>`.
    pub key: String,
}

/// A file that is written as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Whole {
    /// Length in bytes.
    pub bytes: u64,
    /// SHA-256 of the content.
    pub sha256: String,
    /// Its key in the store, below `runs/R/`: `whole/<epoch>.<number>`.
    pub key: String,
}

/// Something that an attempt had to say.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Note {
    /// The attempt.
    pub epoch: u64,
    /// Kind of the note, one word: `not-reproduced`, `damaged-checkpoint`, `restored`.
    pub kind: String,
    /// In words.
    pub text: String,
}

/// `runs/R/beat/<epoch>.json`: a sign of life.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Beat {
    /// Counts the beats of this attempt.
    pub count: u64,
    /// Seconds between two beats.
    pub interval: f64,
    /// Activity of the run, where it makes no steps.
    #[serde(default)]
    pub doing: String,
    /// Steps made.
    pub step: u64,
    /// Steps of the whole run.
    pub of_steps: Option<u64>,
    /// Simulated time in s.
    pub time: f64,
    /// Steps in a second.
    pub rate: Option<f64>,
    /// Seconds left, as the solver expects.
    pub seconds_left: Option<f64>,
    /// Particles at present.
    pub particles: Option<u64>,
}

/// `runs/R/control.json`: what the server wants of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Control {
    /// The attempt.
    pub epoch: u64,
    /// Wish for the attempt.
    pub wish: Wish,
    /// The most bytes that the outputs may take from now on, where that is less than before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disk: Option<u64>,
}
