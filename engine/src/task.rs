//! The task of a run while it makes no steps, for observers and for requests to stop.
//!
//! Inserting a million particles takes a minute. Observers see the progress ([`TaskProgress::placed`]), and a request to stop takes
//! effect at once: the work is given up where nothing is lost by it (`TaskProgress::may_give_up`), as the run declares.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Current activity of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Task {
    /// The scene and its files are read and planned.
    #[default]
    Planning,
    /// Lists and forces of the start are made.
    Starting,
    /// Steps.
    Stepping,
    /// Particles are placed.
    Inserting,
    /// The final output of a run is written.
    Finishing,
}

/// A file of a run, by its name in the run's folder, and the number of its valid bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputFile {
    /// The name, that of a folder in front of it.
    pub name: String,
    /// Bytes, up to the end of the last whole frame.
    pub bytes: u64,
}

/// The events that a run reports.
#[derive(Debug, Clone, PartialEq)]
pub enum RunEvent {
    /// Something else is done from now on.
    Task(Task),
    /// A state is written.
    Written {
        /// Steps made.
        step: u64,
        /// s
        time: f64,
        /// The files that have grown or were made.
        outputs: Vec<OutputFile>,
    },
    /// A checkpoint is whole and has its name.
    Checkpoint {
        /// Steps made.
        step: u64,
        /// s
        time: f64,
        /// The checkpoint itself.
        file: OutputFile,
        /// All growing files, with their valid bytes.
        outputs: Vec<OutputFile>,
    },
    /// A result that ends the run was looked at.
    Result(ResultLook),
    /// No more events follow.
    Over,
}

/// Finding of a look at a result of `time.until`; numbers without another unit are in `unit`.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultLook {
    /// Name of the result.
    pub name: String,
    /// Its unit; `1` of a plain number.
    pub unit: String,
    /// Time of the last row, s.
    pub time: f64,
    /// Its value.
    pub value: f64,
    /// One standard error.
    pub error: f64,
    /// The 95 % interval.
    pub interval: [f64; 2],
    /// The error at which it is known.
    pub wanted: f64,
    /// Independent batches.
    pub batches: f64,
    /// Times of the first and the last row that count, s.
    pub window: [f64; 2],
    /// Whether the rows are steady behind the start-up.
    pub is_steady: bool,
    /// Estimate of how much longer the run goes on, s; 0: the result is known.
    pub more: f64,
}

/// The present task of a run. Shared by the run and its observers; changes no result.
#[derive(Debug, Default)]
pub struct TaskProgress {
    task: Mutex<Task>,
    placed: AtomicU64,
    expected: AtomicU64,
    stop: Arc<AtomicBool>,
    may_give_up: AtomicBool,
    events: Option<Sender<RunEvent>>,
}

impl TaskProgress {
    /// Progress of a run that this flag stops.
    #[must_use]
    pub fn new(stop: Arc<AtomicBool>) -> Self {
        Self {
            stop,
            ..Self::default()
        }
    }

    /// Progress of a run that reports its events.
    #[must_use]
    pub fn reporting(stop: Arc<AtomicBool>, events: Sender<RunEvent>) -> Self {
        Self {
            events: Some(events),
            ..Self::new(stop)
        }
    }

    /// Whether there is a receiver.
    pub fn has_receiver(&self) -> bool {
        self.events.is_some()
    }

    /// Reports an event.
    pub fn report(&self, event: RunEvent) {
        if let Some(events) = &self.events {
            // The receiver may be gone.
            let _ = events.send(event);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Task> {
        self.task.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Current activity.
    #[must_use]
    pub fn task(&self) -> Task {
        *self.lock()
    }

    /// Something else is done from now on.
    pub fn begin(&self, task: Task) {
        *self.lock() = task;
        self.report(RunEvent::Task(task));
    }

    /// Calls `act` if nothing of the run is written yet, and prevents writing meanwhile.
    pub fn before_steps<T>(&self, act: impl FnOnce() -> T) -> Option<T> {
        let task = self.lock();
        matches!(*task, Task::Planning | Task::Starting).then(act)
    }

    /// The number to be placed from now on, as far as it is known; 0 if it is not.
    pub fn expect(&self, number: u64) {
        self.placed.store(0, Ordering::Relaxed);
        self.expected.store(number, Ordering::Relaxed);
    }

    /// One more was placed.
    pub(crate) fn note_placed(&self) {
        self.placed.fetch_add(1, Ordering::Relaxed);
    }

    /// The number placed in this go, and the total if it is known.
    #[must_use]
    pub fn placed(&self) -> (u64, Option<u64>) {
        let expected = self.expected.load(Ordering::Relaxed);
        let placed = self.placed.load(Ordering::Relaxed);
        (
            placed,
            (expected >= placed)
                .then_some(expected)
                .filter(|number| *number > 0),
        )
    }

    /// Whether the present step (or start) may be given up: the state before it is kept, or there is none.
    pub fn may_give_up(&self, may: bool) {
        self.may_give_up.store(may, Ordering::Relaxed);
    }

    /// Whether the present step (or start) is to be given up.
    #[must_use]
    pub fn is_given_up(&self) -> bool {
        self.may_give_up.load(Ordering::Relaxed) && self.stop.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_given_up_only_where_it_may_be() {
        let stop = Arc::new(AtomicBool::new(true));
        let task_progress = TaskProgress::new(Arc::clone(&stop));
        assert!(!task_progress.is_given_up());
        task_progress.may_give_up(true);
        assert!(task_progress.is_given_up());
        stop.store(false, Ordering::Relaxed);
        assert!(!task_progress.is_given_up());
    }

    #[test]
    fn nothing_is_done_before_the_steps_once_they_have_begun() {
        let task_progress = TaskProgress::default();
        assert_eq!(task_progress.before_steps(|| 1), Some(1));
        task_progress.begin(Task::Stepping);
        assert_eq!(task_progress.before_steps(|| 1), None);
    }

    #[test]
    fn how_far_an_insertion_is() {
        let task_progress = TaskProgress::default();
        task_progress.note_placed();
        assert_eq!(task_progress.placed(), (1, None));
        task_progress.expect(2);
        task_progress.note_placed();
        assert_eq!(task_progress.placed(), (1, Some(2)));
    }
}
