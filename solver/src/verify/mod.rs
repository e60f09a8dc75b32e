//! Verification of a run: its files against its chain, and segments of it made again.

mod again;
mod files;

use std::collections::BTreeMap;
use std::fmt;
use std::hash::{BuildHasher as _, Hasher as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use mercury_common::whole_file::FileError;
use serde_json::{Value, json};

use crate::output::chain::PHYSICS;
use crate::run::checkpoint::Checkpoint;
use crate::run::{Recorded, RecordedError, RunFailure};
use again::made_again;
use files::first_difference;

/// How much of a run is made again.
#[derive(Debug, Clone)]
pub struct Options {
    /// Share of its steps, at least; above 0, and 1 for all of them.
    pub share: f64,
    /// For drawing segments; `None`: a number of the system.
    pub seed: Option<u64>,
    /// Segments at a time.
    pub jobs: usize,
    /// Threads of all of them.
    pub threads: usize,
    /// Set to stop.
    pub stop: Arc<AtomicBool>,
}

/// Why a run cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// Its steps cannot be made again.
    #[error(transparent)]
    Recorded(#[from] RecordedError),
    /// All of it was made with another scene, and no checkpoint is left behind the change.
    #[error(
        "the scene was changed at step {change} ({time} s), and no checkpoint stayed behind that: no step can be made again\nhelp: output.keep_checkpoints keeps some"
    )]
    NoStart {
        /// Step behind which the present scene holds.
        change: u64,
        /// Its time, s.
        time: f64,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The steps failed.
    #[error("the steps cannot be made again: {0}")]
    Run(#[from] RunFailure),
    /// A request stopped it.
    #[error("stopped before the end: the run is neither verified nor refuted")]
    Stopped,
}

impl VerifyError {
    /// Whether the system failed, or a request stopped it; otherwise the run cannot be verified.
    #[must_use]
    pub fn is_failure(&self) -> bool {
        matches!(self, Self::File(_) | Self::Stopped)
    }
}

/// Result of a verification.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// Whether nothing differs.
    pub right: bool,
    /// The first difference.
    pub first_difference: Option<String>,
    /// Share of the steps that were made again.
    pub share: f64,
    /// Segments that were made again: first and last step.
    pub segments: Vec<(u64, u64)>,
    /// Segments of the run.
    pub segments_of: usize,
    /// Steps of the run.
    pub steps: u64,
    /// Links of its chain.
    pub links: usize,
    /// The last link.
    pub link: String,
}

/// A part of a run between two states from which it can be begun.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    /// Where it begins; `None`: at the start of the run.
    pub(crate) from: Option<Checkpoint>,
    /// Its last step.
    pub(crate) to: u64,
}

impl Segment {
    fn ends(&self) -> (u64, u64) {
        let from = self.from.as_ref().map_or(0, |from| from.head.step);
        (from, self.to)
    }

    fn steps(&self) -> u64 {
        let (from, to) = self.ends();
        to - from
    }
}

/// Verifies the run in a folder, in which nothing is changed: recomputes all links and the sums of all files up to them, then makes segments of the run again
/// in folders for temporary files. The beginning up to the first link is always made again.
///
/// # Errors
/// If the run cannot be verified: no chain, another physics, files of the scene that are gone.
pub fn verify(folder: &Path, options: &Options) -> Result<Verification, VerifyError> {
    let recorded = match Recorded::open(folder) {
        Ok(recorded) => recorded,
        Err(error) if error.is_difference() => return Ok(differs(None, error.to_string())),
        Err(error) => return Err(error.into()),
    };
    let (checkpoints, problems) = recorded.checkpoints();
    let found = match first_difference(&recorded, &checkpoints)? {
        None => problems.into_iter().next(),
        found => found,
    };
    if let Some(found) = found {
        return Ok(differs(Some(&recorded), found));
    }
    let all = segments(&recorded, &checkpoints)?;
    let drawn = drawn(&recorded, &all, options);
    let mut result = Verification {
        segments_of: all.len(),
        segments: drawn.iter().map(Segment::ends).collect(),
        share: drawn.iter().map(Segment::steps).sum::<u64>() as f64
            / recorded.last_step().max(1) as f64,
        ..differs(Some(&recorded), String::new())
    };
    let jobs = options.jobs.clamp(1, drawn.len().max(1));
    let next = AtomicUsize::new(0);
    // By the numbers of their segments, so that the first in time is named, whichever is found first.
    let differences: Mutex<BTreeMap<usize, String>> = Mutex::default();
    let failure: Mutex<Option<VerifyError>> = Mutex::default();
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(segment) = drawn.get(number) else {
                        break;
                    };
                    let threads = (options.threads / jobs).max(1);
                    match made_again(&recorded, segment, &checkpoints, threads, &options.stop) {
                        Ok(None) => continue,
                        Ok(Some(difference)) => {
                            let differences = differences.lock();
                            let mut differences =
                                differences.unwrap_or_else(PoisonError::into_inner);
                            differences.insert(number, difference);
                        }
                        Err(error) => {
                            let mut failure =
                                failure.lock().unwrap_or_else(PoisonError::into_inner);
                            failure.get_or_insert(error);
                            next.store(drawn.len(), Ordering::Relaxed);
                        }
                    }
                }
            });
        }
    });
    if let Some(error) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let differences = differences
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    result.first_difference = differences.into_values().next();
    result.right = result.first_difference.is_none();
    Ok(result)
}

/// A run that differs.
fn differs(recorded: Option<&Recorded>, difference: String) -> Verification {
    Verification {
        right: false,
        first_difference: Some(difference),
        share: 0.0,
        segments: Vec::new(),
        segments_of: 0,
        steps: recorded.map_or(0, Recorded::last_step),
        links: recorded.map_or(0, |run| run.chain.links().count()),
        link: recorded.map_or("", |run| run.chain.last()).to_owned(),
    }
}

/// The segments of a run between its start, the checkpoints at its links, and its end.
fn segments(recorded: &Recorded, checkpoints: &[Checkpoint]) -> Result<Vec<Segment>, VerifyError> {
    let (_, change) = recorded.chain.stated();
    let is_start = |found: &&Checkpoint| {
        found.head.step >= change.max(1) && recorded.link_at(found.head.step).is_some()
    };
    let mut starts: Vec<Option<Checkpoint>> = Vec::new();
    if change == 0 {
        starts.push(None);
    }
    let mut last = 0;
    for found in checkpoints.iter().filter(is_start) {
        if found.head.step > last && found.head.step < recorded.last_step() {
            starts.push(Some(found.clone()));
            last = found.head.step;
        }
    }
    if starts.is_empty() {
        return Err(VerifyError::NoStart {
            change,
            time: change as f64 * recorded.plan.physics().time_step,
        });
    }
    let step = |start: &Option<Checkpoint>| start.as_ref().map(|start| start.head.step);
    let ends: Vec<u64> = starts.iter().skip(1).filter_map(step).collect();
    let ends = ends.into_iter().chain([recorded.last_step()]);
    let both = starts.into_iter().zip(ends);
    Ok(both.map(|(from, to)| Segment { from, to }).collect())
}

/// The segments that are made again, in the order of time.
fn drawn(recorded: &Recorded, all: &[Segment], options: &Options) -> Vec<Segment> {
    if options.share >= 1.0 {
        return all.to_vec();
    }
    let mut chosen = vec![false; all.len()];
    let wanted = options.share * recorded.last_step() as f64;
    let mut steps = 0;
    // Without checkpoints that stayed the only segment is all of the run; of a branch it is what lies behind the first one.
    if all.len() > 1 || all.iter().any(|segment| segment.from.is_some()) {
        let seed = options
            .seed
            .unwrap_or_else(|| std::hash::RandomState::new().build_hasher().finish());
        let mut random = Random(seed);
        let mut left: Vec<usize> = (0..all.len()).collect();
        while (steps as f64) < wanted && !left.is_empty() {
            let index = left.swap_remove(random.below(left.len()));
            chosen[index] = true;
            steps += all[index].steps();
        }
    }
    let mut drawn: Vec<Segment> = Vec::new();
    if let Some(first) = all
        .first()
        .filter(|first| first.from.is_none() && !chosen[0])
    {
        let to = recorded.chain.links().next();
        let to = to.map_or(first.to, |(link, _)| link.step);
        drawn.push(Segment { from: None, to });
    }
    let taken = all.iter().zip(chosen).filter(|(_, chosen)| *chosen);
    drawn.extend(taken.map(|(segment, _)| segment.clone()));
    drawn
}

/// Numbers for drawing (Steele, Lea & Flood 2014, SplitMix).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        // The bias is limit / 2^64.
        ((u128::from(bits) * limit as u128) >> 64) as usize
    }
}

/// Version of the program, and the machine.
fn program() -> String {
    format!(
        "mercury-solve {}, physics {PHYSICS}, {} {}",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::ARCH,
        std::env::consts::OS
    )
}

impl Verification {
    /// For programs.
    #[must_use]
    pub fn as_json(&self) -> Value {
        json!({
            "right": self.right,
            "first_difference": self.first_difference,
            "share": self.share,
            "segments": self.segments,
            "segments_of": self.segments_of,
            "steps": self.steps,
            "links": self.links,
            "link": self.link,
            "physics": PHYSICS,
            "program": env!("CARGO_PKG_VERSION"),
            "machine": format!("{} {}", std::env::consts::ARCH, std::env::consts::OS),
        })
    }
}

impl fmt::Display for Verification {
    /// For people.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.first_difference {
            None => writeln!(f, "verified")?,
            Some(difference) => writeln!(f, "differs: {difference}")?,
        }
        writeln!(f, "  links       {}, the last is {}", self.links, self.link)?;
        let segments = self.segments.iter();
        let segments: Vec<String> = segments.map(|(a, b)| format!("{a} to {b}")).collect();
        let made: u64 = self.segments.iter().map(|(a, b)| b - a).sum();
        writeln!(
            f,
            "  made again  {made} of {} steps ({:.1} %): {}",
            self.steps,
            100.0 * self.share,
            match segments.is_empty() {
                true => "none".to_owned(),
                false => segments.join(", "),
            }
        )?;
        write!(f, "  by          {}", program())
    }
}
