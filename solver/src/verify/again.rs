//! A segment of a run, made again in a folder of its own.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use mercury_common::frames::FrameWriteError;
use mercury_common::whole_file::FileError;
use mercury_engine::step::RunError;
use mercury_engine::task::TaskProgress;

use super::{Segment, VerifyError};
use crate::output::OutputError;
use crate::output::chain::{CHAIN, Chain, Content, Link, state_sum};
use crate::results::requested;
use crate::run::checkpoint::Checkpoint;
use crate::run::{
    Advance, Checkpoints, Recorded, RecordedError, Run, RunFailure, RunOptions, copy_files,
};

/// Makes a segment again: the first difference in words, if there is any.
pub(super) fn made_again(
    recorded: &Recorded,
    segment: &Segment,
    checkpoints: &[Checkpoint],
    threads: usize,
    stop: &Arc<AtomicBool>,
) -> Result<Option<String>, VerifyError> {
    let temporary = std::env::temp_dir();
    let place = tempfile::tempdir().map_err(FileError::of(
        &temporary,
        "no folder for temporary files can be made",
    ))?;
    let (from, to) = segment.ends();
    if let Some(from) = &segment.from {
        copy_files(recorded, from, place.path())?;
    }
    let (_, until) = requested(&recorded.scene, &recorded.plan).map_err(RecordedError::from)?;
    let options = RunOptions {
        folder: place.path().to_owned(),
        threads,
        fewer_where_faster: true,
        stop: Arc::clone(stop),
        task_progress: Arc::new(TaskProgress::new(Arc::clone(stop))),
        chain: Some(Arc::new(recorded.stated.clone())),
        checkpoints: Some(Checkpoints {
            at_end: true,
            scene: recorded.stated.statement.clone(),
            ..Checkpoints::default()
        }),
        until,
        ..RunOptions::default()
    };
    let is_end = recorded.chain.end().is_some() && to == recorded.last_step();
    let mut points: Vec<&Checkpoint> = checkpoints.iter().collect();
    points.retain(|point| point.head.step > from && point.head.step <= to);
    let plan = recorded.plan.clone();
    let begun = match segment.from.clone() {
        Some(from) => Run::resume(plan, options, from),
        None => Run::new(plan, options),
    };
    // A state that was changed may be none: what can be decoded is no state of this plan.
    let mut run = match (begun, &segment.from) {
        (Err(error), Some(from)) if !is_of_system(&error) => {
            return Ok(Some(format!(
                "{}: no run goes on from there: {error}",
                from.path.display()
            )));
        }
        (begun, _) => begun?,
    };
    let dt = recorded.plan.physics().time_step;
    for point in points {
        let step = point.head.step;
        if let Some(found) = failing(run.advance(step as f64 * dt, &mut |_| ()), from)? {
            return Ok(Some(found));
        }
        stopped(stop)?;
        if run.engine().steps() != step {
            return Ok(Some(format!(
                "the run ends at step {}, and goes on in the chain",
                run.engine().steps()
            )));
        }
        // The state of links, so that the first one that differs is named.
        let part = first_part(point, &mut run)?;
        if let Some(found) = differing_link(recorded, place.path(), (from, step), part.as_deref())?
        {
            return Ok(Some(found));
        }
        if let Some(part) = part {
            return Ok(Some(format!(
                "{}: {part} is not that of step {step}",
                point.path.display()
            )));
        }
    }
    let until = if is_end {
        f64::INFINITY
    } else {
        to as f64 * dt
    };
    if let Some(found) = failing(run.advance(until, &mut |_| ()), from)? {
        return Ok(Some(found));
    }
    stopped(stop)?;
    run.end_chain()?;
    if let Some(found) = differing_link(recorded, place.path(), (from, to), None)? {
        return Ok(Some(found));
    }
    if is_end {
        return differing_end(recorded, place.path());
    }
    Ok(None)
}

/// A step that cannot be made, which is a difference, as the run made it.
fn failing(ran: Result<Advance, RunFailure>, from: u64) -> Result<Option<String>, RunFailure> {
    match ran {
        Err(RunFailure::Engine(error)) => Ok(Some(format!(
            "behind step {from} the steps cannot be made again: {error}"
        ))),
        ran => ran.map(|_| None),
    }
}

/// Whether the system refused, so that nothing follows about the run.
fn is_of_system(error: &RunFailure) -> bool {
    matches!(
        error,
        RunFailure::Output(OutputError::File(_) | OutputError::Frames(FrameWriteError::File(_)))
            | RunFailure::Engine(RunError::GivenUp)
    )
}

fn stopped(stop: &AtomicBool) -> Result<(), VerifyError> {
    match stop.load(Ordering::Relaxed) {
        true => Err(VerifyError::Stopped),
        false => Ok(()),
    }
}

/// Chain of the steps that were made again.
fn chain_in(recorded: &Recorded, folder: &Path) -> Result<Chain, VerifyError> {
    let chain = Chain::read(&folder.join(format!("{}.{CHAIN}", recorded.prefix)));
    Ok(chain.map_err(RecordedError::from)?)
}

/// The first part of a checkpoint that is not that of the run now, in words.
fn first_part(point: &Checkpoint, run: &mut Run) -> Result<Option<String>, VerifyError> {
    let there = point.sections();
    // So that its links are written.
    let positions = run.output_positions()?;
    if run.is_ended() {
        // The last frames took sums out of the state.
        let sections = there.iter().map(|(name, content)| (*name, [&content[..]]));
        let is_same = run.end_state() == Some(&state_sum(sections));
        let positions = run.positions_at_end();
        let is_as_long = positions.is_some_and(|end| end.is_alike(&point.positions));
        return Ok(match (is_same, is_as_long) {
            (true, true) => None,
            (true, false) => Some("section `outputs`".to_owned()),
            (false, _) => Some("its state".to_owned()),
        });
    }
    let first = |here: &[(String, Vec<u8>)]| {
        let mut pairs = there.iter().zip(here);
        let differing = pairs.find(|(a, b)| a.0 != b.0 || a.1 != b.1);
        let is_longer = there.len() != here.len();
        differing
            .map(|(section, _)| section.0)
            .or(is_longer.then_some("end"))
            .map(str::to_owned)
    };
    let mut section = first(&run.sections());
    if section.is_some() {
        // A program that drives a run may have completed this step before the checkpoint.
        run.complete_step()?;
        section = first(&run.sections());
    }
    let is_same = positions.is_alike(&point.positions);
    let section = section.or_else(|| (!is_same).then(|| "outputs".to_owned()));
    Ok(section.map(|section| format!("section `{section}`")))
}

/// The first difference between two links, in words.
fn difference(then: &Link, now: &Link, part: Option<&str>) -> Option<String> {
    if then.state != now.state {
        return Some(match part {
            Some(part) => format!("first in {part}"),
            None => "in its state".to_owned(),
        });
    }
    if then.time.to_bits() != now.time.to_bits() {
        return Some("in its time".to_owned());
    }
    let names = then.outputs.keys().chain(now.outputs.keys());
    let mut differing = names.filter(|name| then.outputs.get(*name) != now.outputs.get(*name));
    differing.next().map(|name| format!("in {name}"))
}

/// The first link behind a step, up to another one, that came out differently. `part` is the first one of the state at that step that differs.
fn differing_link(
    recorded: &Recorded,
    folder: &Path,
    (from, to): (u64, u64),
    part: Option<&str>,
) -> Result<Option<String>, VerifyError> {
    let made = chain_in(recorded, folder)?;
    let is_in = |link: &Link| link.step > from && link.step <= to;
    let then = recorded.chain.links().enumerate();
    let mut then = then.filter(|(_, (link, _))| is_in(link));
    let mut now = made.links().filter(|(link, _)| is_in(link));
    loop {
        let (number, then, now) = match (then.next(), now.next()) {
            (None, None) => return Ok(None),
            (Some((number, (then, _))), now) => (number + 1, Some(then), now.map(|(now, _)| now)),
            (None, Some((now, _))) => (0, None, Some(now)),
        };
        let (Some(then), Some(now)) = (then, now) else {
            let step = then.or(now).map_or(to, |link| link.step);
            return Ok(Some(match now {
                None => format!(
                    "link {number} (step {step}) does not come when the steps are made again"
                ),
                Some(_) => format!("a link at step {step} is missing"),
            }));
        };
        if then.step != now.step {
            return Ok(Some(format!(
                "link {number} is at step {}, and comes at step {}",
                then.step, now.step
            )));
        }
        let part = part.filter(|_| then.step == to);
        if let Some(what) = difference(then, now, part) {
            let agree = match number {
                1 => String::new(),
                2 => "; link 1 agrees".to_owned(),
                _ if from == 0 => format!("; links 1 to {} agree", number - 1),
                _ => format!("; it was made again from step {from}"),
            };
            let step = then.step;
            return Ok(Some(format!(
                "link {number} (step {step}) differs, {what}{agree}"
            )));
        }
    }
}

/// Whether the end came out differently.
fn differing_end(recorded: &Recorded, folder: &Path) -> Result<Option<String>, VerifyError> {
    let made = chain_in(recorded, folder)?;
    let Some(then) = recorded.chain.end() else {
        return Ok(None);
    };
    let Some(Content::End(now)) = made.lines.last().map(|line| &line.content) else {
        return Ok(Some(
            "the run has an end, and goes on when it is made again".to_owned(),
        ));
    };
    if (&then.end, then.link.step) != (&now.end, now.link.step) {
        return Ok(Some(format!(
            "the end is `{}` at step {}, and comes out as `{}` at step {}",
            then.end, then.link.step, now.end, now.link.step
        )));
    }
    Ok(difference(&then.link, &now.link, None).map(|what| format!("the end differs, {what}")))
}
