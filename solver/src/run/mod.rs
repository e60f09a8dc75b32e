//! A run: from the plan to the files it leaves.

mod budget;
mod insertions;
mod memory;
mod report;
mod rest;
mod shortfall;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use mercury_common::whole_file::write_whole;
use mercury_pictures::energy_page;

pub use budget::Budget;
pub use memory::memory;
pub use report::Report;

use budget::{energy_summary, exchanged};
use rest::Rest;
use shortfall::shortfalls;

use crate::boundaries::Tally;
use crate::forces::{Watch, block_size};
use crate::output::summary::{Status, Summary};
use crate::output::{Moment, OutputError, Schedule, Writer, Written, draw_final, folder};
use crate::plan::Plan;
use crate::state::{FIXED, PEBBLE, inverse_inertia_factor};
use crate::step::{Engine, RunError, StartOptions};

/// What a run needs beside its plan.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// Where the files go; ready for a run ([`folder::prepare`]).
    pub folder: PathBuf,
    /// Threads that step; the results do not depend on them.
    pub threads: usize,
    /// How the run was called, for `run.log`.
    pub command_line: String,
    /// Content of `plan.toml`.
    pub plan_document: Option<String>,
    /// Set by anyone who wants the run to end after the step it is in.
    pub stop: Arc<AtomicBool>,
}

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
pub enum RunFailure {
    /// The simulation cannot go on.
    #[error(transparent)]
    Engine(#[from] RunError),
    /// The outputs cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Where a run is.
pub struct Progress<'a> {
    /// The engine, in the middle of a step's kicks.
    pub engine: &'a Engine,
    /// Particles times steps made so far.
    pub particle_steps: u64,
}

impl Progress<'_> {
    /// The share of the planned steps that is made.
    #[must_use]
    pub fn share(&self) -> f64 {
        let steps = self.engine.plan().physics().steps().max(1);
        self.engine.steps() as f64 / steps as f64
    }

    /// Translational kinetic energy of the particles and bodies that are not fixed, J.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        let particles = &self.engine.particles;
        let is_counted = |&row: &usize| particles.records[row].flags & (FIXED | PEBBLE) == 0;
        let rows = (0..particles.len()).filter(is_counted);
        let of_particles: f64 = rows
            .map(|row| {
                0.5 * particles.masses[row] * particles.records[row].velocity.length_squared()
            })
            .sum();
        let bodies = particles.bodies().iter().filter(|body| !body.is_fixed());
        let of_bodies = bodies.map(|body| 0.5 * body.mass * body.velocity.length_squared());
        of_particles + of_bodies.sum::<f64>()
    }
}

/// Threads that a run of this plan can keep busy, of those that the machine has.
#[must_use]
pub fn useful_threads(plan: &Plan, available: usize) -> usize {
    if !plan.physics().insertions().is_empty() {
        return available.max(1);
    }
    let pebbles = plan.physics().bodies().iter();
    let pebbles: usize = pebbles
        .map(|body| body.clump(plan.physics().clumps()).pebbles.len())
        .sum();
    let particles = plan.physics().particles().len() + pebbles;
    particles
        .div_ceil(block_size(particles))
        .clamp(1, available.max(1))
}

/// Runs a plan to its end and writes its files; `observe` is called now and then.
///
/// # Errors
/// If a particle's motion is no longer a number, threads cannot be started, or a file cannot be written. What was
/// written until then stays, without a `summary.json`.
pub fn run(
    plan: Plan,
    options: &RunOptions,
    observe: &mut dyn FnMut(&Progress<'_>),
) -> Result<Report, RunFailure> {
    let result = Run::new(plan, options.clone()).and_then(|mut run| {
        match run.advance(f64::INFINITY, observe) {
            Ok(_) => run.finish(),
            Err(failure) => {
                // Also after a failed step everything that was handed over is written.
                let _ = run.writer.finish();
                Err(failure)
            }
        }
    });
    if let Err(failure) = &result {
        let log = log_head(options) + &format!("failed: {failure}\n");
        // The failure is what the caller must hear of, not that it cannot be logged.
        let _ = write_whole(&options.folder.join("run.log"), log.as_bytes());
    }
    result
}

/// Particle-steps that are made without looking up: some tenths of a second.
const STEPS_AT_ONCE: u64 = 2_000_000;

/// How far [`Run::advance`] came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Advance {
    /// To the time that was asked for; it can go on.
    Reached,
    /// To its end: as planned, at rest, or stopped. Only [`Run::finish`] is left.
    Ended,
}

/// A run that is made in pieces: what the command line, a service or another language calls.
///
/// [`Run::new`] starts it, [`Run::advance`] goes on to a time, [`Run::finish`] writes what a run leaves at its end. The pieces in
/// which it is made change no output.
pub struct Run {
    engine: Engine,
    options: RunOptions,
    writer: Writer,
    schedule: Schedule,
    rest: Option<Rest>,
    /// What had come and gone before the first step.
    at_start: (Tally, Tally),
    /// Grains of the start.
    starting: u64,
    begun: Instant,
    /// Of the time loop, without output.
    stepping: Duration,
    particle_steps: u64,
    /// Particle-steps at which `observe` is called next.
    next_look: u64,
    ended: Option<Ending>,
}

/// Why a run is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    Planned,
    AtRest,
    Stopped,
}

impl Run {
    /// Starts a run: evaluates the first forces, makes the files, hands over the first state.
    ///
    /// # Errors
    /// If the start is not a number, threads cannot be started, or a file cannot be written.
    pub fn new(plan: Plan, options: RunOptions) -> Result<Self, RunFailure> {
        let begun = Instant::now();
        let folder = &options.folder;
        if let Some(document) = &options.plan_document {
            write_whole(&folder.join("plan.toml"), document.as_bytes())
                .map_err(OutputError::from)?;
        }
        let starting = (plan.physics().particles().len() + plan.physics().bodies().len()) as u64;
        let plan = Arc::new(plan);
        let schedule = Schedule::new(plan.outputs().files(), plan.physics().time_step());
        let records = schedule.everything().needs_records();
        let mut engine = Engine::start(
            Arc::clone(&plan),
            StartOptions::threads(options.threads).records(records),
        )?;
        let writer = Writer::start(folder, &plan, &engine.history_columns())?;
        let at_start = exchanged(&engine);
        let rest = plan.physics().until_at_rest().then(|| {
            let factor = inverse_inertia_factor(plan.physics().dimensions());
            Rest::new(plan.physics().gravity().length(), factor)
        });
        // Should the writer have given up, `advance` finds it so, and `finish` says why.
        let _ = writer.send(Moment::take(&mut engine, schedule.everything()));
        Ok(Self {
            engine,
            writer,
            schedule,
            rest,
            at_start,
            starting,
            begun,
            stepping: Duration::ZERO,
            particle_steps: 0,
            next_look: 0,
            ended: (plan.physics().steps() == 0).then_some(Ending::Planned),
            options,
        })
    }

    /// The engine, in the middle of a step's kicks.
    #[must_use]
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Goes on to the first step at or after `until` (s), or to the end of the run; `observe` is called now and then.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn advance(
        &mut self,
        until: f64,
        observe: &mut dyn FnMut(&Progress<'_>),
    ) -> Result<Advance, RunFailure> {
        let plan = Arc::clone(self.engine.plan());
        // With the slack of the schedule: a millionth of a step.
        let until = (until / plan.physics().time_step() - 1e-6).ceil().max(0.0) as u64;
        while self.ended.is_none() {
            if self.engine.steps() >= until {
                return Ok(Advance::Reached);
            }
            let stopping = self.options.stop.load(Ordering::Relaxed);
            if !self.advance_a_bit(until.min(plan.physics().steps()), stopping)? {
                break;
            }
            // Seldom enough that looking at the clock costs nothing.
            if self.particle_steps + self.engine.steps() >= self.next_look {
                self.next_look = self.particle_steps + self.engine.steps() + STEPS_AT_ONCE;
                observe(&Progress {
                    engine: &self.engine,
                    particle_steps: self.particle_steps,
                });
            }
        }
        Ok(Advance::Ended)
    }

    /// Makes steps until something is due, or as many as nobody has to wait for, up to step `until`; when `stopping`, one that is
    /// the last. False if the writer has given up.
    fn advance_a_bit(&mut self, until: u64, stopping: bool) -> Result<bool, RunFailure> {
        let since = Instant::now();
        let engine = &mut self.engine;
        let step = engine.steps();
        // Steps that nobody looks at are made at once, but not so many that a request to stop has to wait.
        let most = (STEPS_AT_ONCE / engine.particles.len().max(1) as u64).clamp(1, 1000);
        let target = if stopping || self.rest.is_some() {
            step + 1
        } else {
            (step + most)
                .min(self.schedule.next_step())
                .clamp(step + 1, until)
        };
        let count = target - step;
        let step = target;
        let mut due = self.schedule.due(step);
        let planned_end = step == engine.plan().physics().steps();
        // A step that may be the last one is watched in case it is.
        let perhaps_last = planned_end || stopping || self.rest.as_ref().is_some_and(Rest::is_near);
        let everything = self.schedule.everything();
        let watch = (due.any() || perhaps_last).then_some(Watch {
            records: due.needs_records() || (perhaps_last && everything.needs_records()),
            audit: None,
        });
        engine.steps_at_once(count, watch)?;
        self.particle_steps += count * engine.particles.grains() as u64;
        let at_rest = self.rest.as_mut().is_some_and(|rest| {
            rest.is_reached(&engine.particles, engine.boundaries().expects_more())
        });
        self.ended = if at_rest {
            Some(Ending::AtRest)
        } else if planned_end {
            Some(Ending::Planned)
        } else {
            stopping.then_some(Ending::Stopped)
        };
        if self.ended.is_some() {
            due = due.or(everything);
        }
        if due.any() {
            engine.complete_step()?;
        }
        self.stepping += since.elapsed();
        Ok(!due.any() || self.writer.send(Moment::take(engine, due)))
    }

    /// Ends the run and writes what it leaves: pictures, `summary.json`, `run.log`. A run that has not come to its end makes one
    /// more step and counts as stopped.
    ///
    /// # Errors
    /// If that step fails, or a file cannot be written.
    pub fn finish(mut self) -> Result<Report, RunFailure> {
        if self.ended.is_none() {
            self.advance_a_bit(self.engine.steps() + 1, true)?;
        }
        let written = self.writer.finish()?;
        let folder = &self.options.folder;
        let plan = self.engine.plan();
        if plan.outputs().files().pictures {
            draw_pictures(folder, plan, &written)?;
        }
        let looped = Looped {
            seconds: self.stepping.as_secs_f64(),
            particle_steps: self.particle_steps,
            stopped: self.ended == Some(Ending::Stopped),
        };
        let mut report = report(
            &self.engine,
            &self.options,
            &self.at_start,
            self.starting,
            &looped,
            &written,
        );
        let json = serde_json::to_string_pretty(&report.summary).map_err(OutputError::Json)?;
        write_whole(&folder.join("summary.json"), (json + "\n").as_bytes())
            .map_err(OutputError::from)?;
        report.total_seconds = self.begun.elapsed().as_secs_f64();
        // The log names all files, itself too.
        report.files = folder::present(folder, plan.outputs().prefix());
        report.files.push("run.log".to_owned());
        let log = log_head(&self.options) + &log_body(&report);
        write_whole(&folder.join("run.log"), log.as_bytes()).map_err(OutputError::from)?;
        Ok(report)
    }
}

/// What the time loop tells of itself.
#[derive(Debug)]
struct Looped {
    /// Seconds without output.
    seconds: f64,
    particle_steps: u64,
    stopped: bool,
}

fn report(
    engine: &Engine,
    options: &RunOptions,
    at_start: &(Tally, Tally),
    starting: u64,
    looped: &Looped,
    written: &Written,
) -> Report {
    let plan = engine.plan();
    let particles = engine.particles.grains();
    let observation = written.last.as_ref().map(|state| &state.observation);
    let contacts = observation.map_or(0, |observation| observation.particle_contacts);
    let created = engine.particles.grains_created();
    let mut warnings = plan.notes().warnings().to_vec();
    let boundaries = engine.boundaries().state();
    warnings.extend(shortfalls(plan, &boundaries, engine.time()));
    if written.deep_frames > 0 {
        warnings.push(format!(
            "overlaps above 10 % of a radius at {} of {} output times (the largest {:.0} %): the contacts are too soft, or particles were placed inside one another",
            written.deep_frames,
            written.energies.len(),
            100.0 * written.deepest
        ));
    }
    let (rebuilds, listed) = engine.list_statistics();
    Report {
        summary: Summary {
            title: plan.outputs().title().to_owned(),
            steps: engine.steps(),
            time: engine.time(),
            time_step: plan.physics().time_step(),
            particles,
            contacts,
            wall_contacts: observation.map_or(0, |observation| observation.wall_contacts),
            wall_seconds: looped.seconds,
            particle_steps_per_second: if looped.seconds > 0.0 {
                looped.particle_steps as f64 / looped.seconds
            } else {
                0.0
            },
            threads: options.threads.max(1),
            coordination_number: 2.0 * contacts as f64 / particles.max(1) as f64,
            energy: energy_summary(engine, at_start, &written.energies),
            inserted: created - starting,
            deleted: created - particles as u64,
            warnings,
            status: if looped.stopped {
                Status::Stopped
            } else {
                Status::Finished
            },
        },
        budget: Budget::new(engine, written),
        files: Vec::new(),
        folder: options.folder.display().to_string(),
        insertions: insertions::told(plan, engine.boundaries()),
        rebuilds,
        listed,
        laws: engine.law_names().to_owned(),
        total_seconds: 0.0,
    }
}

/// The final state and the energies as pictures.
fn draw_pictures(folder: &Path, plan: &Plan, written: &Written) -> Result<(), OutputError> {
    if let Some(last) = &written.last {
        draw_final(folder, plan, last)?;
    }
    let stem = folder.join(format!("{}.energy", plan.outputs().prefix()));
    energy_page(plan.outputs().title(), &written.energies).write(&stem)?;
    Ok(())
}

fn log_head(options: &RunOptions) -> String {
    let mut log = format!("mercury-solve {}\n", env!("CARGO_PKG_VERSION"));
    if !options.command_line.is_empty() {
        log += &format!("command: {}\n", options.command_line);
    }
    log
}

fn log_body(report: &Report) -> String {
    let steps = report.summary.steps;
    format!(
        "{report}\nlaws: {}\nneighbour list: built {} times, every {:.1} steps, {} pairs listed at the end\nwarnings: {}\n",
        report.laws,
        report.rebuilds,
        steps as f64 / report.rebuilds.max(1) as f64,
        report.listed,
        report.summary.warnings.len()
    )
}
