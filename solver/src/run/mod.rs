//! A run: from the plan to the files it leaves.

mod branch;
mod budget;
pub mod checkpoint;
mod claim;
mod coupling;
mod exit_report;
mod failed_state;
mod insertions;
mod keeping;
mod long_steps;
mod looks;
mod memory;
mod open;
mod options;
mod origin;
mod pictures;
mod progress;
mod recorded;
mod report;
mod rest_criterion;
mod servos;
mod shortfall;
mod tables;
#[cfg(test)]
mod tests;
mod time_left;
mod trial;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use mercury_common::readable::duration;
use mercury_common::whole_file::write_whole;

pub(crate) use branch::copy_files;
pub use branch::{Branch, BranchError};
pub use budget::Budget;
pub use claim::{Claim, ClaimError, stated_by};
pub use coupling::{CouplingError, Saved, WallDrive};
pub use memory::{RanksHere, check_fit, memory, plan_of_ranks, plan_within};
pub use open::{OpenError, OpenRun, SceneInput};
pub use options::{Checkpoints, RunFailure, RunOptions, useful_threads};
pub use origin::Origin;
pub use progress::Progress;
pub use recorded::{Recorded, RecordedError};
pub use report::Report;
pub use tables::Rows;
pub use trial::{Trial, trial};

use checkpoint::{Checkpoint, Known};
use long_steps::{LongStep, long_steps, next_long_step};
pub use looks::is_over;
use looks::{rows_until, write_results};
use pictures::draw_pictures;
use progress::ahead_of;
use report::{Looped, log_body, log_head, report};
use rest_criterion::Rest;
use time_left::Cost;

use crate::output::chain::{EndResult, PHYSICS};
use crate::output::summary::{ResultValue, Status};
use crate::output::{
    Due, Exchanged, FrameCopy, OutputError, Positions, Schedule, ToWrite, Writer, folder,
};
use crate::plan::{Plan, Workload, checkpoint_paths};
use crate::results::{Aims, NamedResult};
use mercury_engine::forces::{Observation, Watch};
use mercury_engine::step::{Engine, RunError};
use mercury_engine::task::{OutputFile, RunEvent, Task};

/// Beginning of the warning of a run that was to come to rest and did not.
const NOT_AT_REST: &str = "not at rest";

/// Runs a plan to its end and writes its files; `observe` is called from time to time.
///
/// # Errors
/// If a particle's motion is no longer a number, threads cannot be started, or a file cannot be written. Output that was
/// written until then stays, without a `summary.json`.
pub fn run(
    plan: Plan,
    options: &RunOptions,
    observe: &mut dyn FnMut(&Progress<'_>),
) -> Result<Report, RunFailure> {
    run_from(None, plan, options, observe)
}

/// Runs a plan from a checkpoint, which must [fit](Checkpoint::fits) the plan.
///
/// # Errors
/// Also if the files of the run are missing or were changed.
pub fn run_from(
    checkpoint: Option<Checkpoint>,
    plan: Plan,
    options: &RunOptions,
    observe: &mut dyn FnMut(&Progress<'_>),
) -> Result<Report, RunFailure> {
    let begun = Run::begun(plan, options.clone(), checkpoint);
    let result = begun.and_then(|mut run| {
        match run.advance(f64::INFINITY, observe) {
            Ok(_) => run.finish(),
            Err(failure) => {
                // Everything that was passed on is written, also after a failed step.
                let _ = run.writer.finish();
                Err(failure)
            }
        }
    });
    if let Err(failure) = &result
        && !failure.is_stop()
    {
        let log = log_head(options) + &format!("failed: {failure}\n");
        // The caller must receive this failure, not that of the log.
        let _ = write_whole(&options.folder.join("run.log"), log.as_bytes());
    }
    result
}

/// Particle-steps between two checks: some tenths of a second.
const STEPS_AT_ONCE: u64 = 2_000_000;

/// Between two calls of `observe`.
const LOOK: Duration = Duration::from_millis(100);

/// How far [`Run::advance`] came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Advance {
    /// To the end of the given time; it can go on.
    Reached,
    /// Not yet there, as [`RunOptions::pause`] was set; it can go on.
    Paused,
    /// To its end: as planned, at rest, or stopped. Only [`Run::finish`] is left.
    Ended,
}

/// A run that is made in pieces: the interface for the command line, a service or another language.
///
/// [`Run::new`] starts it, [`Run::advance`] continues to a time, [`Run::finish`] writes the files of the end. The pieces do not
/// change any output.
pub struct Run {
    plan: Arc<Plan>,
    engine: Engine,
    options: RunOptions,
    writer: Writer,
    schedule: Schedule,
    rest: Option<Rest>,
    aims: Option<Aims>,
    long_steps: Vec<LongStep>,
    /// Particle-steps made by one thread although there are more.
    alone: u64,
    /// Amounts exchanged before the first step.
    at_start: Exchanged,
    /// Grains of the start.
    starting: u64,
    begun: Instant,
    /// Step from which an interrupted run went on.
    resumed_at: Option<u64>,
    /// The time of the last checkpoint, or of the start.
    last_checkpoint: Instant,
    /// Number of the file, of two, that is written next.
    next_file: usize,
    /// Their number, and the time that the steps had to wait for them.
    checkpoints_made: (u32, Duration),
    looked_for_stop_file: Instant,
    /// When the first step of this process began.
    first_step: Instant,
    /// Time since then on steps that insert many particles.
    inserting: Duration,
    /// The cost of the steps, and the planned grains: for the remaining time.
    cost: Cost,
    workload: Workload,
    /// Checkpoint from which a run that has come to its end can continue.
    at_end: Option<(ToWrite, Vec<OutputFile>)>,
    /// Sum of the last state, for the end of the chain.
    end_state: Option<String>,
    /// Time of the time loop, without output.
    stepping: Duration,
    particle_steps: u64,
    /// When `observe` was called.
    seen: Option<Instant>,
    /// Last step of the piece that is being made.
    piece_end: u64,
    /// Contacts and loads on walls of the present step, if the last piece ended with it ([`RunOptions::pieces_observed`]).
    observed: Option<Observation>,
    /// Drives of walls for the next window.
    drives: Vec<(usize, WallDrive)>,
    /// States and links passed to the writer, and positions of the files behind so many of them.
    sent: u64,
    positions: Option<(Arc<Positions>, u64)>,
    ended: Option<Ending>,
}

/// Why a run is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The run came to its end in time.
    Planned,
    /// Nothing moves any more.
    AtRest,
    /// A wall is worn to its `until_depth`.
    Worn,
    /// All results of `time.until` are known.
    Known,
    /// The run was stopped before.
    Stopped(StopReason),
}

/// Reason why a run stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// Ctrl-C, a signal, or the caller.
    Request,
    /// A file `STOP` in the folder of the run; it was removed.
    File,
    /// [`RunOptions::time_limit`].
    TimeLimit,
}

impl Ending {
    /// The word by which programs know it.
    #[must_use]
    pub fn cause(self) -> &'static str {
        match self {
            Self::Planned => "planned",
            Self::AtRest => "at_rest",
            Self::Worn => "worn",
            Self::Known => "known",
            Self::Stopped(StopReason::Request) => "request",
            Self::Stopped(StopReason::File) => "file",
            Self::Stopped(StopReason::TimeLimit) => "time_limit",
        }
    }
}

/// The warning of a run that was stopped while its pictures were drawn.
const PICTURES_LEFT_OUT: &str = "pictures of the end were left out, as the run was stopped while they were drawn: \
`mercury-export png` draws frames of the run";

/// The file that stops a run when it appears in its folder.
pub const STOP_FILE: &str = "STOP";

/// Interval at which a run looks for it.
const LOOK_FOR_STOP_FILE: Duration = Duration::from_millis(500);

impl Run {
    /// Starts a run: evaluates the first forces, makes the files, passes on the first state.
    ///
    /// # Errors
    /// If the start is not a number, threads cannot be started, or a file cannot be written.
    pub fn new(plan: Plan, options: RunOptions) -> Result<Self, RunFailure> {
        Self::begun(plan, options, None)
    }

    /// Resumes an interrupted run of this plan, which [`Checkpoint::fits`]: truncates its files to their positions at that time.
    ///
    /// # Errors
    /// Also if its files are missing or were changed.
    pub fn resume(
        plan: Plan,
        options: RunOptions,
        checkpoint: Checkpoint,
    ) -> Result<Self, RunFailure> {
        Self::begun(plan, options, Some(checkpoint))
    }

    fn begun(
        plan: Plan,
        options: RunOptions,
        from: Option<Checkpoint>,
    ) -> Result<Self, RunFailure> {
        let begun = Instant::now();
        let folder = &options.folder;
        let starting = (plan.physics().particles.len() + plan.physics().bodies.len()) as u64;
        let plan = Arc::new(plan);
        let resumed_at = from.as_ref().map(|checkpoint| checkpoint.head.step);
        let schedule = Schedule::behind(
            plan.outputs().files(),
            plan.physics().time_step,
            resumed_at.unwrap_or(0),
        );
        let start = options.start(&schedule);
        let long_steps = long_steps(&plan);
        let task_progress = &options.task_progress;
        let at_start = long_steps.first().filter(|long| long.step == 0);
        task_progress.expect(at_start.map_or(0, |long| long.expected));
        // Other ranks would go on with their start.
        task_progress.may_give_up(start.ranks.is_none());
        task_progress.begin(Task::Starting);
        // Nothing is written before the engine is there: until then a stop leaves no trace.
        let open = |engine: &Engine, from| {
            if task_progress.is_given_up() {
                return Err(RunFailure::from(RunError::GivenUp));
            }
            task_progress.may_give_up(false);
            task_progress.begin(Task::Stepping);
            if let Some(document) = &options.plan_document {
                let document = origin::of(&options)? + document;
                write_whole(&folder.join("plan.toml"), document.as_bytes())
                    .map_err(OutputError::from)?;
            }
            if let Some(text) = &options.scene_text {
                folder::copy_scene(folder, plan.outputs().prefix(), text)
                    .map_err(OutputError::from)?;
            }
            Ok(Writer::start(
                folder,
                &plan,
                (&engine.history_columns(), &engine.audit().losses),
                from,
                options.chain.clone(),
                task_progress,
            )?)
        };
        let files = checkpoint_paths(folder, plan.outputs().prefix());
        let is_first = |from: &Checkpoint| from.path == files[0];
        let next_file = usize::from(from.as_ref().is_some_and(is_first));
        let mut observed = None;
        let (engine, writer, known) = match from {
            None => {
                let mut engine = Engine::start(Arc::clone(&plan), start)?;
                observed = options.pieces_observed.then(|| engine.observation());
                let writer = open(&engine, None)?;
                let rest = (plan.physics().until_at_rest).then(|| Rest::new(&plan));
                let at_start = Exchanged::by_now(&engine);
                // If the writer has given up, `advance` notices it, and `finish` returns the reason.
                let moment = FrameCopy::take(&mut engine, schedule.everything(), &at_start);
                let _ = writer.send(moment);
                let is_worn = engine.is_worn();
                let known = Known {
                    rest,
                    is_worn,
                    at_start,
                };
                (engine, writer, known)
            }
            Some(from) => {
                let engine = Engine::resume(Arc::clone(&plan), from.snapshot, start)?;
                let at = (from.positions, engine.steps(), engine.time());
                let writer = open(&engine, Some(at))?;
                (engine, writer, from.known)
            }
        };
        let mut aims = options.until.clone();
        if let Some(aims) = &mut aims {
            let times = rows_until(&plan, engine.steps());
            aims.replay(folder, plan.outputs().prefix(), times);
            write_results(folder, plan.outputs().prefix(), aims)?;
        }
        let dt = plan.physics().time_step;
        let are_known = |aims: &Aims| aims.have_ended(engine.time(), dt);
        let ended = if engine.is_worn() {
            Some(Ending::Worn)
        } else if aims.as_ref().is_some_and(are_known) {
            Some(Ending::Known)
        } else {
            (engine.steps() >= plan.physics().steps).then_some(Ending::Planned)
        };
        let run = Self {
            engine,
            writer,
            schedule,
            rest: known.rest,
            aims,
            long_steps,
            alone: 0,
            at_start: known.at_start,
            starting,
            begun,
            resumed_at,
            last_checkpoint: begun,
            next_file,
            checkpoints_made: (0, Duration::ZERO),
            looked_for_stop_file: begun,
            first_step: Instant::now(),
            inserting: Duration::ZERO,
            cost: Cost::default(),
            workload: Workload::of(&plan),
            plan,
            at_end: None,
            end_state: None,
            stepping: Duration::ZERO,
            particle_steps: 0,
            seen: None,
            piece_end: 0,
            observed,
            drives: Vec::new(),
            sent: 0,
            positions: None,
            ended,
            options,
        };
        run.prepare_checkpoints();
        Ok(run)
    }

    /// The engine, in the middle of a step's kicks.
    #[must_use]
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// The plan of the run.
    #[must_use]
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// Whether the run has come to its end, or was stopped: only [`Self::finish`] is left.
    #[must_use]
    pub fn is_ended(&self) -> bool {
        self.ended.is_some()
    }

    /// Goes on to the first step at or after `until` (s), or to the end of the run; `observe` is called from time to time.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn advance(
        &mut self,
        until: f64,
        observe: &mut dyn FnMut(&Progress<'_>),
    ) -> Result<Advance, RunFailure> {
        let plan = Arc::clone(&self.plan);
        // With the slack of the schedule: a millionth of a step.
        let until = (until / plan.physics().time_step - 1e-6).ceil().max(0.0) as u64;
        self.piece_end = until;
        if self.ended.is_none() && self.engine.steps() < until {
            self.begin_window(until)?;
        }
        while self.ended.is_none() {
            if self.engine.steps() >= until {
                return Ok(Advance::Reached);
            }
            if self.options.pause.load(Ordering::Relaxed) {
                return Ok(Advance::Paused);
            }
            let stopping = self.stopping();
            let until = until.min(plan.physics().steps);
            let is_kept = match next_long_step(&self.long_steps, self.engine.steps()) {
                Some(long) if long.step == self.engine.steps() + 1 => {
                    self.make_long_step(long, stopping)?
                }
                Some(long) => self.advance_a_bit(until.min(long.step - 1), stopping)?,
                None => self.advance_a_bit(until, stopping)?,
            };
            if !is_kept {
                break;
            }
            if self.seen.is_none_or(|seen| seen.elapsed() >= LOOK) {
                self.seen = Some(Instant::now());
                let seconds = self.first_step.elapsed().saturating_sub(self.inserting);
                let seconds = seconds.as_secs_f64();
                self.cost.note(seconds, self.particle_steps as f64);
                let ahead = ahead_of(&self.workload, &self.engine);
                observe(&Progress {
                    engine: &self.engine,
                    particle_steps: self.particle_steps,
                    seconds,
                    left: self.cost.left(ahead.middle()),
                });
            }
        }
        Ok(Advance::Ended)
    }

    /// The source of a present request to stop, if there is one.
    fn stopping(&mut self) -> Option<StopReason> {
        if self.options.stop.load(Ordering::Relaxed) {
            return Some(StopReason::Request);
        }
        let limit = self.options.time_limit;
        if limit.is_some_and(|limit| self.begun.elapsed() >= limit) {
            return Some(StopReason::TimeLimit);
        }
        if self.looked_for_stop_file.elapsed() < LOOK_FOR_STOP_FILE {
            return None;
        }
        self.looked_for_stop_file = Instant::now();
        // The file existed if it could be removed.
        let removed = std::fs::remove_file(self.options.folder.join(STOP_FILE));
        removed.is_ok().then_some(StopReason::File)
    }

    /// Makes steps until something is due, or as many as take a short time, up to step `until`; when `stopping`, one that is the
    /// last. False if the writer has given up.
    fn advance_a_bit(
        &mut self,
        until: u64,
        stopping: Option<StopReason>,
    ) -> Result<bool, RunFailure> {
        let since = Instant::now();
        let engine = &mut self.engine;
        let step = engine.steps();
        // Steps without output are made at once, but not so many that a request to stop, or to pause, has to wait.
        let at_once = match self.options.pieces_observed {
            true => STEPS_AT_ONCE / 8,
            false => STEPS_AT_ONCE,
        };
        let most = (at_once / engine.particles.len().max(1) as u64).clamp(1, 1000);
        let mut target = (step + most)
            .min(self.schedule.next_step())
            .clamp(step + 1, until);
        let is_known = self.aims.as_ref().is_some_and(Aims::is_known);
        if stopping.is_some() || is_known {
            target = step + 1;
        } else if self.rest.is_some() {
            target = target.min((step / rest_criterion::EVERY + 1) * rest_criterion::EVERY);
        }
        let count = target - step;
        let before = step;
        let mut step = target;
        let mut due = self.schedule.due(step);
        let planned_end = step == engine.physics().steps;
        let is_rest_due = step.is_multiple_of(rest_criterion::EVERY);
        // A step that may be the last one is observed for this case.
        let perhaps_rest = is_rest_due && self.rest.as_ref().is_some_and(Rest::is_near);
        let perhaps_last = planned_end || stopping.is_some() || is_known || perhaps_rest;
        let everything = self.schedule.everything();
        let is_observed = self.options.pieces_observed && (perhaps_last || step == self.piece_end);
        let watch = (due.beyond_tracks() || perhaps_last || is_observed).then_some(Watch {
            records: is_observed
                || due.needs_records()
                || (perhaps_last && everything.needs_records()),
            audit: None,
        });
        let is_alone = self.options.steps_alone(engine);
        engine.step_alone(is_alone);
        // A worn wall ends the run with the next step, wherever this piece would have ended.
        let was_worn = engine.is_worn();
        if !was_worn && let Err(error) = engine.steps_at_once(count, watch) {
            self.show(&error);
            return Err(error.into());
        }
        let is_cut = was_worn || engine.steps() < target;
        if is_cut {
            let watch = Watch {
                records: self.options.pieces_observed || everything.needs_records(),
                audit: None,
            };
            if let Err(error) = engine.steps_at_once(1, Some(watch)) {
                self.show(&error);
                return Err(error.into());
            }
            step = engine.steps();
            due = self.schedule.due(step);
        }
        let is_worn = is_cut || planned_end && engine.is_worn();
        let count = step - before;
        let particle_steps = count * engine.particles.grains() as u64;
        self.particle_steps += particle_steps;
        if is_alone {
            self.alone += particle_steps;
        }
        if is_rest_due && self.rest.is_some() {
            engine.collect(false);
        }
        let at_rest =
            is_rest_due && (self.rest.as_mut()).is_some_and(|rest| rest.is_reached(engine));
        self.ended = if is_worn {
            Some(Ending::Worn)
        } else if at_rest {
            Some(Ending::AtRest)
        } else if is_known {
            Some(Ending::Known)
        } else if planned_end {
            Some(Ending::Planned)
        } else {
            stopping.map(Ending::Stopped)
        };
        if matches!(
            self.ended,
            Some(Ending::AtRest | Ending::Worn | Ending::Known)
        ) && let Err(error) = engine.settle_wear()
        {
            self.show(&error);
            return Err(error.into());
        }
        // Files that are written at the end only do not exist for a run that continues from here.
        let closing = match self.ended {
            None => None,
            // Nothing: only the report looks at it.
            Some(Ending::Stopped(_)) => Some(Due::default()),
            Some(_) => Some(everything.without(due)),
        };
        let is_last_look = closing.is_some_and(|closing| closing.any() || !due.any());
        let seen = is_last_look.then(|| engine.observation());
        let is_observed = is_observed || self.options.pieces_observed && is_cut;
        self.observed = is_observed.then(|| engine.observation());
        if due.any() {
            engine.complete_step()?;
        }
        self.stepping += since.elapsed();
        if due.any() {
            let moment = FrameCopy::take(&mut self.engine, due, &self.at_start);
            self.sent += 1;
            if !self.writer.send(moment) {
                return Ok(false);
            }
            if due.rows && self.ended.is_none() && !self.look_at_results() {
                return Ok(false);
            }
        }
        if !self.keep_checkpoints(step)? {
            return Ok(false);
        }
        let (Some(closing), Some(seen)) = (closing, seen) else {
            return Ok(true);
        };
        self.engine.complete_step()?;
        let moment = FrameCopy::take(&mut self.engine, closing, &self.at_start);
        self.sent += 1;
        Ok(self.writer.send(FrameCopy {
            observation: seen,
            ..moment
        }))
    }

    /// Ends the run and writes its last files: pictures, `summary.json`, `run.log`, and a checkpoint. A run that has not come to
    /// its end makes one more step and counts as stopped.
    ///
    /// # Errors
    /// If that step fails, or a file cannot be written.
    pub fn finish(mut self) -> Result<Report, RunFailure> {
        if self.ended.is_none() {
            self.advance_a_bit(self.engine.steps() + 1, Some(StopReason::Request))?;
        }
        self.options.task_progress.begin(Task::Finishing);
        let (written, chain) = self.writer.finish()?;
        let written = Arc::new(written);
        let folder = &self.options.folder;
        let plan = &self.plan;
        let is_drawn = !plan.outputs().files().pictures
            || draw_pictures(
                folder.clone(),
                Arc::clone(plan),
                Arc::clone(&written),
                &self.options.stop,
            )?;
        let looped = Looped {
            seconds: self.stepping.as_secs_f64(),
            particle_steps: self.particle_steps,
            alone: self.alone,
            ending: self.ended.unwrap_or(Ending::Planned),
            resumed_at: self.resumed_at,
        };
        let mut report = report(
            &self.plan,
            &self.engine,
            &self.options,
            self.starting,
            &looped,
            &written,
        );
        if !is_drawn {
            report.summary.warnings.push(PICTURES_LEFT_OUT.to_owned());
        }
        if let (Some(rest), Some(Ending::Planned)) = (&self.rest, self.ended) {
            let why = rest.why_not(&self.engine);
            let warning = format!("{NOT_AT_REST}: {why}, at the end of the run");
            report.summary.warnings.push(warning);
        }
        if report.summary.status == Status::Finished {
            let prefix = plan.outputs().prefix();
            let settled = Some(report.summary.settled);
            let read = |result: &NamedResult| {
                let value = result.read(folder, prefix, settled);
                (result.name.clone(), value)
            };
            report.summary.results = self.options.results.iter().map(read).collect();
            if let Some(aims) = &self.aims {
                write_results(folder, prefix, aims)?;
                let (until, warnings) = aims.summary(folder, prefix);
                report.summary.until = until;
                report.summary.warnings.extend(warnings);
            }
        }
        if let Some(mut chain) = chain {
            if let (Some(state), Some(ending)) = (self.end_state, looped.ending.word()) {
                let at = (self.engine.steps(), self.engine.time());
                chain.end(ending, at, state, end_results(&report.summary.results))?;
            }
            report.summary.physics = Some(PHYSICS);
            report.summary.link = Some(chain.last().to_owned());
        }
        let json = serde_json::to_string_pretty(&report.summary).map_err(OutputError::Json)?;
        write_whole(&folder.join("summary.json"), (json + "\n").as_bytes())
            .map_err(OutputError::from)?;
        report.total_seconds = self.begun.elapsed().as_secs_f64();
        // The log names all files, including itself and those still to come.
        report.files = folder::present(folder, plan.outputs().prefix());
        report.files.push("run.log".to_owned());
        let to_come = (self.at_end.as_ref())
            .and_then(|(checkpoint, _)| checkpoint.path.as_ref()?.file_name());
        report
            .files
            .extend(to_come.map(|name| name.to_string_lossy().into_owned()));
        report.files.sort();
        report.files.dedup();
        let mut log = log_head(&self.options) + &log_body(&report);
        let (made, held) = self.checkpoints_made;
        let held = duration(held.as_secs_f64());
        log += &format!("checkpoints: {made}, for which the steps were held for {held}\n");
        write_whole(&folder.join("run.log"), log.as_bytes()).map_err(OutputError::from)?;
        if let Some((checkpoint, outputs)) = self.at_end
            && let Some(path) = &checkpoint.path
        {
            let bytes = checkpoint.state.finish();
            write_whole(path, &bytes).map_err(OutputError::from)?;
            let name = path.file_name().unwrap_or_default();
            self.options.task_progress.report(RunEvent::Checkpoint {
                step: checkpoint.step,
                time: checkpoint.time,
                file: OutputFile {
                    name: name.to_string_lossy().into_owned(),
                    bytes: bytes.len() as u64,
                },
                outputs,
            });
        }
        Ok(report)
    }
}

impl Ending {
    /// Word of the chain for it; none of a run that was stopped.
    fn word(self) -> Option<&'static str> {
        match self {
            Self::Planned => Some("planned"),
            Self::AtRest => Some("at_rest"),
            Self::Worn => Some("worn"),
            Self::Known => Some("known"),
            Self::Stopped(_) => None,
        }
    }
}

/// Results for the end of the chain.
fn end_results(results: &[(String, ResultValue)]) -> BTreeMap<String, EndResult> {
    let of = |(name, result): &(String, ResultValue)| {
        let error = result.estimate.as_ref().and_then(|known| known.error);
        let end = EndResult {
            of: result.of.clone(),
            value: result.value,
            error,
        };
        (name.clone(), end)
    };
    results.iter().map(of).collect()
}
