//! Messages and stops while a run makes no steps.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mercury_common::cli::{self, Exit, Failure};
use mercury_common::readable::{count, duration};
use mercury_engine::task::{Task, TaskProgress};

/// The interval between two checks; a request to stop waits no longer than this.
const LOOK: Duration = Duration::from_millis(50);

/// The end of a run that was stopped before anything was written.
pub(crate) fn stopped_early() -> Failure {
    Failure::new(
        Exit::Resumable,
        "stopped before the first step; no file was written or changed",
    )
    .with_help("the same command begins again")
}

/// The function that is called with the failure of a run that is stopped before its first step.
pub(crate) type BeforeEnd = Box<dyn Fn(&Failure) + Send>;

/// A thread that shows the task of a run between its steps. Until the first step it ends the program on a request to stop, as
/// there is nothing to keep yet. It ends when this is dropped.
#[derive(Debug)]
pub(crate) struct Waiting {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Waiting {
    /// Starts the thread. `stop`: the flag that stops the run, and the function to call before the program ends for it.
    pub(crate) fn begin(
        task_progress: &Arc<TaskProgress>,
        stop: Option<(&Arc<AtomicBool>, BeforeEnd)>,
        quiet: bool,
    ) -> Result<Self, Failure> {
        let (end, ended) = channel::<()>();
        let task_progress = Arc::clone(task_progress);
        let stop = stop.map(|(stop, before_end)| (Arc::clone(stop), before_end));
        let thread = std::thread::Builder::new()
            .name("waiting".to_owned())
            .spawn(move || {
                let mut line = cli::Progress::in_logs_too(quiet);
                let (mut task, mut since) = (task_progress.task(), Instant::now());
                while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                    if let Some((stop, before_end)) = &stop
                        && stop.load(Ordering::Relaxed)
                    {
                        task_progress.before_steps(|| {
                            line.clear();
                            let failure = stopped_early();
                            before_end(&failure);
                            eprintln!("{}", failure.message);
                            cli::end_at_once(Exit::Resumable as i32)
                        });
                    }
                    let now = task_progress.task();
                    if now != task {
                        (task, since) = (now, Instant::now());
                        line.clear();
                    }
                    if let Some(what) = reported(&task_progress, now) {
                        line.busy(|_| {
                            format!("{what}  {}", duration(since.elapsed().as_secs_f64()))
                        });
                    }
                }
            })
            .map_err(|error| Failure::run(format!("the threads cannot be started: {error}")))?;
        Ok(Self {
            end: Some(end),
            thread: Some(thread),
        })
    }
}

impl Drop for Waiting {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A text for the present task; `None` while steps are made, which have other messages.
fn reported(task_progress: &TaskProgress, task: Task) -> Option<String> {
    Some(match (task, task_progress.placed()) {
        (Task::Planning, _) => "reading and planning the scene".to_owned(),
        (Task::Starting, (0, _)) => "first lists and forces".to_owned(),
        (Task::Starting | Task::Inserting, (placed, Some(of))) if placed < of => {
            format!("inserted {} of {}", count(placed), count(of))
        }
        (Task::Starting, (placed, _)) => {
            format!("inserted {}, first lists and forces", count(placed))
        }
        (Task::Inserting, (placed, _)) => format!("inserted {}", count(placed)),
        (Task::Finishing, _) => "writing the end".to_owned(),
        (Task::Stepping, _) => return None,
    })
}
