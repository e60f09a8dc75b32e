//! Signs of life of attempts: heads, beats, and since when they are silent, by this server's clock.

use std::collections::HashMap;
use std::sync::Mutex;
use std::time::Instant;

use cloud_api::Beat;
use cloud_api::lifecycle::JobState;

/// Signs of life of one run's attempt.
#[derive(Clone, Debug)]
pub(crate) struct SignsOfLife {
    /// The last sign of life.
    pub(crate) beat: Option<Beat>,
    /// When head, beat or the state of the job changed last.
    pub(crate) changed: Instant,
    /// When the job was handed to the engine, as far as this server knows.
    pub(crate) submitted: Instant,
    /// Number of the head's last change.
    pub(crate) commit: u64,
    /// Attempt and its job.
    pub(crate) epoch: u64,
    pub(crate) job: JobState,
    /// Reason for which the job waits, as the engine says it.
    pub(crate) waits: Option<String>,
    /// Notes of the head that listeners know.
    pub(crate) notes: usize,
    /// Time of the request to the engine to end the job.
    pub(crate) interrupted: Option<Instant>,
    /// When the user's wish was passed on.
    pub(crate) wished: Option<Instant>,
    /// Whether the attempt was ended because its owner has more than the limit.
    pub(crate) over_limit: bool,
}

impl SignsOfLife {
    fn new(epoch: u64) -> Self {
        let now = Instant::now();
        Self {
            beat: None,
            changed: now,
            submitted: now,
            commit: 0,
            epoch,
            job: JobState::Unknown,
            waits: None,
            notes: 0,
            interrupted: None,
            wished: None,
            over_limit: false,
        }
    }
}

/// Signs of life of all runs that have an attempt.
#[derive(Default)]
pub(crate) struct Attempts(Mutex<HashMap<String, SignsOfLife>>);

impl Attempts {
    /// Changes the signs of life of a run; a new attempt begins without a history.
    pub(crate) fn with<T>(
        &self,
        run: &str,
        epoch: u64,
        change: impl FnOnce(&mut SignsOfLife) -> T,
    ) -> T {
        let mut all = self
            .0
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        let seen = all
            .entry(run.to_owned())
            .or_insert_with(|| SignsOfLife::new(epoch));
        if seen.epoch != epoch {
            let notes = seen.notes;
            *seen = SignsOfLife {
                notes,
                ..SignsOfLife::new(epoch)
            };
        }
        change(seen)
    }

    pub(crate) fn get(&self, run: &str) -> Option<SignsOfLife> {
        self.0
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
            .get(run)
            .cloned()
    }

    pub(crate) fn forget(&self, run: &str) {
        self.0
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
            .remove(run);
    }
}
