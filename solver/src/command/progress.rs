//! `--progress FILE`: the events of a run, line by line, for programs that observe it.
//!
//! A separate thread writes a line for each event that the run reports, and one each second: the time of the run while it makes
//! steps, its task while it makes none. None of this changes a result.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::plan::Plan;
use crate::run::checkpoint::Checkpoint;
use crate::run::{Ending, Progress, Report};
use mercury_common::cli::{Exit, Failure};
use mercury_engine::task::{OutputFile, RunEvent, Task, TaskProgress};
use serde_json::{Value, json};

use super::problems;

/// Between lines that come by the clock.
const EVERY: Duration = Duration::from_secs(1);

/// How old the numbers of such a line may be: computing energies takes time.
const FRESH: Duration = Duration::from_millis(500);

/// A file of lines that grows while a run goes on.
#[derive(Debug)]
pub(crate) struct ProgressFile {
    shared: Arc<Shared>,
    /// The sender through which the run reports its events.
    events: Sender<RunEvent>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

#[derive(Debug)]
struct Shared {
    /// The file; none once it could not be written.
    file: Mutex<Option<(File, String)>>,
    /// Where the run is.
    latest: Mutex<Option<(Instant, Value)>>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Appends a line in one stroke. If this fails, the run must not be affected.
    fn line(&self, event: &str, members: Value) {
        let clock = SystemTime::now().duration_since(UNIX_EPOCH);
        let clock = clock.map_or(0.0, |since| since.as_millis() as f64 / 1000.0);
        let mut line = json!({ "event": event, "clock": clock });
        if let (Some(line), Value::Object(members)) = (line.as_object_mut(), members) {
            line.extend(members);
        }
        let text = format!("{line}\n");
        let mut file = locked(&self.file);
        if let Some((open, name)) = file.as_mut()
            && let Err(error) = open.write_all(text.as_bytes())
        {
            let _ = writeln!(
                std::io::stderr(),
                "warning: --progress {name}: the file cannot be written any more: {error}"
            );
            *file = None;
        }
    }
}

impl ProgressFile {
    /// Creates the file if one is requested, and returns the receiver of the run's events.
    ///
    /// # Errors
    /// If the file cannot be made.
    pub(crate) fn requested(
        path: Option<&Path>,
        scene: &Path,
    ) -> Result<Option<(Self, Receiver<RunEvent>)>, Failure> {
        let Some(path) = path else {
            return Ok(None);
        };
        let name = path.display().to_string();
        let file = File::create(path).map_err(|error| {
            Failure::input(format!(
                "--progress {name}: the file cannot be made: {error}"
            ))
        })?;
        let shared = Arc::new(Shared {
            file: Mutex::new(Some((file, name))),
            latest: Mutex::new(None),
        });
        let members = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "process": std::process::id(),
            "scene": scene.display().to_string(),
        });
        shared.line("begin", members);
        let (events, receiver) = channel();
        let progress = Self {
            shared,
            events,
            thread: Mutex::new(None),
        };
        Ok(Some((progress, receiver)))
    }

    /// Receiver of the events of a run.
    pub(crate) fn events(&self) -> Sender<RunEvent> {
        self.events.clone()
    }

    /// Watches the run from now on.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub(crate) fn watch(
        &self,
        task_progress: &Arc<TaskProgress>,
        events: Receiver<RunEvent>,
    ) -> Result<(), Failure> {
        let (shared, task_progress) = (Arc::clone(&self.shared), Arc::clone(task_progress));
        shared.line("phase", phase(&task_progress, task_progress.task(), 0.0));
        let thread = std::thread::Builder::new()
            .name("progress".to_owned())
            .spawn(move || write_lines(&shared, &task_progress, &events))
            .map_err(|error| Failure::run(format!("the threads cannot be started: {error}")))?;
        *locked(&self.thread) = Some(thread);
        Ok(())
    }

    /// Notes where the run is, for the next line that comes by the clock.
    pub(crate) fn note(&self, progress: &Progress<'_>) {
        let mut latest = locked(&self.shared.latest);
        if latest
            .as_ref()
            .is_some_and(|(since, _)| since.elapsed() < FRESH)
        {
            return;
        }
        let engine = progress.engine;
        let physics = engine.physics();
        let members = json!({
            "step": engine.steps(),
            "of_steps": physics.steps,
            "time": engine.time(),
            "end": physics.steps as f64 * physics.time_step,
            "particles": engine.particles.grains(),
            "kinetic_energy": progress.kinetic_energy(),
            "particle_steps_per_second": progress.particle_steps as f64 / progress.seconds.max(1e-9),
            "seconds_left": progress.left,
        });
        *latest = Some((Instant::now(), members));
    }

    /// The folder is locked, and nothing of the run is written yet.
    pub(crate) fn run(
        &self,
        folder: &Path,
        plan: &Plan,
        threads: usize,
        from: Option<&Checkpoint>,
    ) {
        let physics = plan.physics();
        let resumed = from.map(|from| {
            let name = from.path.file_name().unwrap_or_default();
            json!({
                "file": name.to_string_lossy(),
                "step": from.head.step,
                "time": from.head.time(),
            })
        });
        let members = json!({
            "folder": folder.display().to_string(),
            "prefix": plan.outputs().prefix(),
            "steps": physics.steps,
            "time_step": physics.time_step,
            "end": physics.steps as f64 * physics.time_step,
            "threads": threads,
            "resumed": resumed,
        });
        self.shared.line("run", members);
    }

    /// The last line; pending events are written before it.
    pub(crate) fn end(&self, outcome: Result<Option<&Report>, &Failure>) {
        if let Some(thread) = locked(&self.thread).take() {
            let _ = self.events.send(RunEvent::Over);
            let _ = thread.join();
        }
        self.shared.line("end", ended(outcome));
    }
}

/// The lines of a run that goes on.
fn write_lines(shared: &Shared, task_progress: &TaskProgress, events: &Receiver<RunEvent>) {
    let (mut phase_since, mut next) = (Instant::now(), Instant::now() + EVERY);
    loop {
        if Instant::now() >= next {
            next += EVERY;
            let task = task_progress.task();
            let latest = locked(&shared.latest).clone();
            match latest.filter(|_| task == Task::Stepping) {
                Some((_, members)) => shared.line("step", members),
                None => {
                    let seconds = phase_since.elapsed().as_secs_f64();
                    shared.line("phase", phase(task_progress, task, seconds));
                }
            }
        }
        let wait = next.saturating_duration_since(Instant::now());
        match events.recv_timeout(wait) {
            Ok(RunEvent::Task(task)) => {
                phase_since = Instant::now();
                shared.line("phase", phase(task_progress, task, 0.0));
            }
            Ok(RunEvent::Written {
                step,
                time,
                outputs,
            }) => shared.line(
                "frame",
                json!({ "step": step, "time": time, "outputs": listed(&outputs) }),
            ),
            Ok(RunEvent::Checkpoint {
                step,
                time,
                file,
                outputs,
            }) => shared.line(
                "checkpoint",
                json!({
                    "step": step, "time": time, "file": file.name, "bytes": file.bytes,
                    "outputs": listed(&outputs),
                }),
            ),
            Ok(RunEvent::Result(found)) => shared.line(
                "result",
                json!({
                    "name": found.name, "time": found.time, "value": found.value, "unit": found.unit,
                    "error": found.error, "interval": found.interval, "batches": found.batches,
                    "window": found.window, "steady": found.is_steady,
                    "wanted": found.wanted, "more": found.more,
                }),
            ),
            Ok(RunEvent::Over) | Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

fn phase(task_progress: &TaskProgress, task: Task, seconds: f64) -> Value {
    let word = match task {
        Task::Planning => "planning",
        Task::Starting => "starting",
        Task::Stepping => "stepping",
        Task::Inserting => "inserting",
        Task::Finishing => "finishing",
    };
    let mut members = json!({ "phase": word, "seconds": (1000.0 * seconds).round() / 1000.0 });
    if matches!(task, Task::Starting | Task::Inserting) {
        let (placed, of) = task_progress.placed();
        members["placed"] = placed.into();
        members["of"] = of.into();
    }
    members
}

fn listed(outputs: &[OutputFile]) -> Value {
    let one = |file: &OutputFile| json!({ "name": file.name, "bytes": file.bytes });
    outputs.iter().map(one).collect()
}

/// How a run ended.
fn ended(outcome: Result<Option<&Report>, &Failure>) -> Value {
    let report = outcome.as_ref().ok().copied().flatten();
    let (code, status, cause) = match (outcome, report.map(|report| report.ending)) {
        (Err(failure), _) => match failure.exit {
            Exit::Input => (Exit::Input, "refused", None),
            Exit::Resumable => (Exit::Resumable, "stopped", Some("request")),
            exit => (exit, "failed", None),
        },
        (Ok(_), None) => (Exit::Done, "finished", None),
        (Ok(_), Some(ending @ Ending::Stopped(_))) => {
            (Exit::Resumable, "stopped", Some(ending.cause()))
        }
        (Ok(_), Some(ending)) => (Exit::Done, "finished", Some(ending.cause())),
    };
    let summary = report.map(|report| &report.summary);
    let files = report.map(|report| {
        let folder = Path::new(&report.folder);
        let one = |name: &String| {
            let bytes = std::fs::metadata(folder.join(name)).ok()?.len();
            Some(json!({ "name": name, "bytes": bytes }))
        };
        report.files.iter().filter_map(one).collect::<Value>()
    });
    let problems = outcome.err().and_then(Failure::problems);
    json!({
        "code": code as u8,
        "status": status,
        "cause": cause,
        "step": summary.map(|summary| summary.steps),
        "time": summary.map(|summary| summary.time),
        "files": files,
        "problems": problems.map(|problems| problems::list(&problems)),
    })
}
