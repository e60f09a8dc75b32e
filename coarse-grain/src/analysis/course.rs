//! Frames as they come: sums that are still open, and blocks as soon as they are complete.

mod memory;

use std::collections::{HashMap, VecDeque};

use glam::DVec3;
use mercury_common::statistics::{BATCH_BINS, Batches, Record};

use super::{Analysis, Block, Part, Reference, TIME_CUTOFF, TimeMode};
use crate::CgError;
use crate::evaluate::Scratch;
use crate::state::{Space, State};
use crate::sums::Sums;

/// Memory of an [`Analysis`] from frame to frame. A copy goes on as the original would have.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Course {
    frames: usize,
    dimensions: Option<u8>,
    /// Where particles were in the frame before, and how far they had come since the frame that displacements are counted from.
    before: Option<HashMap<u32, Way>>,
    open: VecDeque<Open>,
    /// The first output time of smoothed fields (s), and the number of the next one.
    next_time: Option<(f64, usize)>,
    /// Time of the frame before, where fields are smoothed, s.
    last_time: Option<f64>,
    /// Of each value of the fields, for the errors of means.
    records: Vec<Record>,
    kept: Kept,
}

/// Where a particle was, and how far it had come, m.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Way {
    at: DVec3,
    come: DVec3,
}

/// Memory that is used again: no part of what a course is.
#[derive(Debug, Default)]
struct Kept(Scratch);

impl Clone for Kept {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Kept {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Sums of a time that is not complete yet.
#[derive(Debug, Clone, PartialEq)]
struct Open {
    time: f64,
    weight: f64,
    frames: usize,
    span: (f64, f64),
    space: Space,
    parts: Vec<Sums>,
}

impl Open {
    fn new(analysis: &Analysis, state: &State, time: f64) -> Self {
        let layout = analysis.layout();
        let zeros = || Sums::zeros(layout.clone(), analysis.evaluator.place.len());
        Self {
            time,
            weight: 0.0,
            frames: 0,
            span: (state.time, state.time),
            space: state.space,
            parts: analysis.parts.iter().map(|_| zeros()).collect(),
        }
    }

    fn add(&mut self, state: &State, parts: &[Sums], weight: f64) {
        for (mine, theirs) in self.parts.iter_mut().zip(parts) {
            mine.add(theirs, weight);
        }
        self.weight += weight;
        self.frames += 1;
        self.span.1 = state.time;
        self.space = state.space;
    }

    /// The block of what was added; nothing of nothing.
    fn block(mut self, analysis: &Analysis, errors: Option<Vec<f64>>) -> Option<Block> {
        if self.weight == 0.0 {
            return None;
        }
        for part in &mut self.parts {
            part.scale(1.0 / self.weight);
        }
        let Self {
            time, span, frames, ..
        } = self;
        Some(analysis.block(time, span, frames, self.space, self.parts, errors))
    }
}

impl Course {
    /// The number of frames so far.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Takes a frame, and gives the blocks that it completes to `write`.
    ///
    /// # Errors
    /// Errors of `write`, and a frame that has other dimensions than those before it.
    pub fn add(
        &mut self,
        analysis: &Analysis,
        mut state: State,
        mut write: impl FnMut(Block) -> Result<(), CgError>,
    ) -> Result<(), CgError> {
        let found = state.space.dimensions;
        let first = *self.dimensions.get_or_insert(found);
        if first != found {
            return Err(CgError::Input(format!(
                "the frame at t = {} has {found} dimensions, those before {first}",
                state.time
            )));
        }
        if analysis
            .fields
            .iter()
            .any(|field| field.needs_displacement())
        {
            let displacement = displacement(&state, self.before.as_ref());
            let particles = state.particles.id.iter().zip(&state.particles.position);
            let is_first = self.before.is_none();
            let ways = particles
                .zip(&displacement)
                .filter_map(|((&id, &at), way)| {
                    let come = match analysis.reference {
                        Reference::Previous => DVec3::ZERO,
                        // A particle that is not in the first frame has no displacement since then.
                        Reference::First if is_first => DVec3::ZERO,
                        Reference::First => way.is_finite().then_some(*way)?,
                    };
                    Some((id, Way { at, come }))
                });
            self.before = Some(ways.collect());
            state.displacement = Some(displacement);
        }
        let layout = analysis.layout();
        let (evaluator, scratch) = (&analysis.evaluator, &mut self.kept.0);
        let sums = |part: &Part| evaluator.sums_with(&state, &layout, part.material, scratch);
        let parts: Vec<Sums> = analysis.parts.iter().map(sums).collect();
        self.frames += 1;
        match analysis.time {
            TimeMode::Frames => {
                let span = (state.time, state.time);
                write(analysis.block(state.time, span, 1, state.space, parts, None))
            }
            TimeMode::Average => {
                if analysis.errors {
                    let values = analysis.values(&parts, state.space.dimensions);
                    let record = || Record::of_bins(BATCH_BINS);
                    self.records.resize_with(values.len(), record);
                    for (record, value) in self.records.iter_mut().zip(values) {
                        record.add(value);
                    }
                }
                if self.open.is_empty() {
                    self.open.push_back(Open::new(analysis, &state, 0.0));
                }
                for sums in &mut self.open {
                    sums.add(&state, &parts, 1.0);
                    sums.time = state.time;
                }
                parts
                    .into_iter()
                    .for_each(|sums| self.kept.0.take_back(sums));
                if analysis.running {
                    self.mean(analysis).map_or(Ok(()), write)
                } else {
                    Ok(())
                }
            }
            TimeMode::Smooth { width, step } => {
                let reach = TIME_CUTOFF * width;
                let last = self.last_time.replace(state.time);
                // Output times whose weight has ended are complete.
                while self
                    .open
                    .front()
                    .is_some_and(|sums| sums.time + reach < state.time)
                {
                    if let Some(block) = self.open.pop_front().and_then(|o| o.block(analysis, None))
                    {
                        write(block)?;
                    }
                }
                let (first, next) = self.next_time.get_or_insert((state.time, 0));
                loop {
                    // Not step by step, which would add up round-off.
                    let time = *first + *next as f64 * step;
                    if time - reach > state.time {
                        break;
                    }
                    if time + reach < state.time {
                        let last = last.unwrap_or(state.time);
                        return Err(CgError::Input(format!(
                            "--smooth: no frame within {TIME_CUTOFF} widths of {width} s of t = {time}: there are frames at {last} and {} s\nhelp: a larger width",
                            state.time
                        )));
                    } else {
                        self.open.push_back(Open::new(analysis, &state, time));
                    }
                    *next += 1;
                }
                for sums in &mut self.open {
                    let distance = (state.time - sums.time) / width;
                    sums.add(&state, &parts, libm::exp(-0.5 * distance * distance));
                }
                parts
                    .into_iter()
                    .for_each(|sums| self.kept.0.take_back(sums));
                Ok(())
            }
        }
    }

    /// The mean over the frames so far, with its errors; `None` before the first frame, and if means were not requested.
    #[must_use]
    pub fn mean(&self, analysis: &Analysis) -> Option<Block> {
        if analysis.time != TimeMode::Average {
            return None;
        }
        let open = self.open.front()?.clone();
        open.block(analysis, self.errors())
    }

    /// The standard error of the mean of each value; `None` of fewer than [`FEWEST_BATCHES`](mercury_common::statistics::FEWEST_BATCHES) frames.
    fn errors(&self) -> Option<Vec<f64>> {
        let errors = self.records.iter().map(|record| {
            let batches = Batches::of(record.bins())?;
            Some(batches.error())
        });
        errors
            .collect::<Option<Vec<f64>>>()
            .filter(|all| !all.is_empty())
    }

    /// Gives the blocks that no further frame completes to `write`.
    ///
    /// # Errors
    /// Errors of `write`.
    pub fn finish(
        self,
        analysis: &Analysis,
        mut write: impl FnMut(Block) -> Result<(), CgError>,
    ) -> Result<(), CgError> {
        if analysis.time == TimeMode::Average {
            let last = self.mean(analysis).filter(|_| !analysis.running);
            return last.map_or(Ok(()), write);
        }
        // Output times behind the last frame would be made of one side only.
        let last = self
            .open
            .iter()
            .map(|sums| sums.span.1)
            .fold(f64::NEG_INFINITY, f64::max);
        let complete = self.open.into_iter().filter(|sums| sums.time <= last);
        for block in complete.filter_map(|sums| sums.block(analysis, None)) {
            write(block)?;
        }
        Ok(())
    }
}

/// How far each particle has come, from frame to frame by the shortest way; NaN for those that were not there.
fn displacement(state: &State, before: Option<&HashMap<u32, Way>>) -> Vec<DVec3> {
    let particles = &state.particles;
    let way = |(id, x): (&u32, &DVec3)| match before.and_then(|before| before.get(id)) {
        Some(way) => way.come + state.space.nearest(*x - way.at),
        None => DVec3::NAN,
    };
    particles
        .id
        .iter()
        .zip(&particles.position)
        .map(way)
        .collect()
}
