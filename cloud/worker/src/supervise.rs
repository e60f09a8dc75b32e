//! The loop of an attempt: watch, beat, commit, and stop where something says so.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use cloud_api::{Beat, Cause, Control, Ending, Phase, Spec, Wish};

use crate::claim::{Held, Swapped};
use crate::notice::{Notice, Notices};
use crate::progress::Progress;
use crate::restore::{Workspace, restore};
use crate::solver::{Handle, OUTPUT, Solver};
use crate::sync::{Sync, size, sweep};
use crate::{Attempt, Outcome};

/// How often the loop looks at the solver.
const LOOK: Duration = Duration::from_millis(100);

/// How often it looks whether the server wants something.
const LISTEN: Duration = Duration::from_secs(1);

/// How often it adds up what the outputs take.
const MEASURE: Duration = Duration::from_secs(10);

/// How long a solver may take from SIGTERM to its end where it has shown no sign of life.
const HUNG_GRACE: Duration = Duration::from_secs(60);

/// How much of the solver's messages the store has, in bytes: the end of them.
const LOG: u64 = 256 << 10;

/// Something that is due every so often.
struct Every {
    period: Duration,
    last: Option<Instant>,
}

impl Every {
    fn new(period: Duration) -> Self {
        Self { period, last: None }
    }

    fn due(&mut self) -> bool {
        let due = self.last.is_none_or(|last| last.elapsed() >= self.period);
        if due {
            self.last = Some(Instant::now());
        }
        due
    }
}

/// Progress of the solver, in the folder of the attempt.
const PROGRESS: &str = ".progress";

/// State that the threads of an attempt share: requests to the store may take long, and neither a signal nor a sign of life
/// waits for them.
#[derive(Default)]
struct Shared {
    /// Why the solver got the signal to stop, where the reason came from outside.
    cause: Mutex<Option<Cause>>,
    /// The newest sign of life, without its number.
    beat: Mutex<Option<Beat>>,
    over: AtomicBool,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl Shared {
    /// Stops the solver as soon as a signal or a notice says so.
    fn guard(&self, solver: &Handle, notices: &Notices, terminated: &AtomicBool) {
        while !self.over.load(Ordering::Relaxed) {
            let cause = match notices.newest() {
                Some(Notice::Spot) => Some(Cause::Spot),
                _ if terminated.load(Ordering::Relaxed) => Some(Cause::Preempted),
                _ => None,
            };
            if cause.is_some() {
                *locked(&self.cause) = cause;
                solver.stop();
                return;
            }
            thread::sleep(LOOK);
        }
    }

    /// Sends signs of life.
    fn pulse(&self, attempt: &Attempt) {
        let key = attempt.key(&format!("beat/{}.json", attempt.epoch));
        let mut every = Every::new(attempt.beat);
        let mut count = 0;
        while !self.over.load(Ordering::Relaxed) {
            let beat = locked(&self.beat).clone();
            if let Some(mut beat) = beat
                && every.due()
            {
                count += 1;
                beat.count = count;
                let put = serde_json::to_vec(&beat).map(|text| attempt.store.put(&key, &text));
                if let Ok(Err(error)) = put {
                    eprintln!("no beat: {error}");
                }
            }
            thread::sleep(LOOK);
        }
    }
}

/// Says that the attempt is over, also where it ends by an error.
struct Over<'a>(&'a Shared);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.over.store(true, Ordering::Relaxed);
    }
}

/// Does an attempt from its claim to its end.
pub fn work(attempt: &Attempt) -> Result<Outcome> {
    let Some(mut held) = Held::take(attempt)? else {
        return Ok(Outcome::Superseded);
    };
    match run(attempt, &mut held) {
        Ok(outcome) => Ok(outcome),
        // What the worker cannot do says so in the store: an attempt that ends in silence is a riddle.
        Err(error) => {
            let ending = Ending {
                cause: Cause::Engine,
                code: None,
                message: format!("{error:#}"),
            };
            end(attempt, &mut held, ending, None)?;
            Err(error)
        }
    }
}

fn run(attempt: &Attempt, held: &mut Held) -> Result<Outcome> {
    let terminated = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT] {
        signal_hook::flag::register(signal, Arc::clone(&terminated))
            .context("signals cannot be caught")?;
    }
    let notices = Notices::begin();
    let key = attempt.key(&format!("spec.{}.json", held.head.revision));
    let text = attempt
        .store
        .get(&key)?
        .with_context(|| format!("the store has no {key}"))?;
    let spec: Spec =
        serde_json::from_slice(&text).with_context(|| format!("{key} cannot be read"))?;
    sweep(attempt, held)?;
    let workspace = restore(attempt, held, &spec)?;
    let mut sync = Sync::new(held);
    if held
        .head
        .checkpoint
        .as_ref()
        .is_some_and(|checkpoint| checkpoint.revision != held.head.revision)
    {
        sync.forget_tails(attempt, held, &workspace)?;
    }
    let progress = workspace.folder.join(PROGRESS);
    // With a checkpoint of its own it is a run like others.
    let branch = (spec.branch.as_ref()).filter(|_| held.head.checkpoint.is_none());
    let progress_file = Path::new(PROGRESS);
    let solver = Solver::start(attempt, &spec, branch, &workspace.folder, progress_file)?;
    let mut progress = Progress::new(&progress);
    progress.grows = held.head.streams.keys().cloned().collect();
    let mut watch = Watch {
        attempt,
        spec,
        workspace,
        progress,
        solver,
        wanted: None,
        killed_at: None,
        logged: 0,
    };
    let handle = watch.solver.handle();
    let shared = Shared::default();
    thread::scope(|scope| {
        let _over = Over(&shared);
        scope.spawn(|| shared.guard(&handle, &notices, &terminated));
        scope.spawn(|| shared.pulse(attempt));
        watch.until_it_ends(held, &mut sync, &notices, &shared)
    })
}

struct Watch<'a> {
    attempt: &'a Attempt<'a>,
    spec: Spec,
    workspace: Workspace,
    progress: Progress,
    solver: Solver,
    /// Why the solver got the signal to stop.
    wanted: Option<Cause>,
    /// When it is killed, if it has not ended by then.
    killed_at: Option<Instant>,
    /// Length of the solver's messages when they were sent.
    logged: u64,
}

impl Watch<'_> {
    /// Sends the solver's messages, if there are new ones.
    fn log(&mut self) -> Result<()> {
        let (length, text) = self.solver.messages(LOG)?;
        if length != self.logged {
            let key = self.attempt.key(&format!("log/{}.txt", self.attempt.epoch));
            let text = self.without_paths(&text);
            self.attempt.store.put(&key, text.as_bytes())?;
            self.logged = length;
        }
        Ok(())
    }

    /// A text without the paths of this machine.
    fn without_paths(&self, text: &str) -> String {
        let folder = self.workspace.folder.display().to_string();
        let text = text
            .replace(&format!("{folder}/"), "")
            .replace(&folder, ".");
        text.replace(&format!("{OUTPUT}/"), "")
    }

    fn until_it_ends(
        &mut self,
        held: &mut Held,
        sync: &mut Sync,
        notices: &Notices,
        shared: &Shared,
    ) -> Result<Outcome> {
        let attempt = self.attempt;
        let mut commit = Every::new(attempt.commit);
        let mut listen = Every::new(LISTEN.max(attempt.beat / 4));
        let mut measure = Every::new(MEASURE);
        let mut rebalanced = false;
        let mut disk = (self.spec.disk).min(attempt.disk.unwrap_or(u64::MAX));
        let status = loop {
            self.progress.read().context("progress of the solver")?;
            if let Some(status) = self.solver.ended()? {
                break status;
            }
            // The guard has sent the signal already.
            self.wanted = self.wanted.or(*locked(&shared.cause));
            if notices.newest() == Some(Notice::Rebalance) && !rebalanced {
                rebalanced = true;
                self.solver.checkpoint();
            }
            if listen.due() {
                let control = self.control();
                if control.disk.is_some_and(|most| most < disk) {
                    disk = control.disk.unwrap_or(disk);
                    measure = Every::new(MEASURE);
                }
                match control.wish {
                    Wish::Run => {}
                    Wish::Stop => self.stop(Cause::User),
                    Wish::Kill => {
                        self.wanted = Some(Cause::User);
                        self.solver.kill();
                        continue;
                    }
                }
            }
            if self.progress.alive.elapsed() > attempt.patience && self.wanted.is_none() {
                self.stop(Cause::Hung);
                self.killed_at = Some(Instant::now() + HUNG_GRACE);
            }
            if measure.due() && size(&self.workspace.output)? > disk {
                self.stop(Cause::Disk);
            }
            if self.killed_at.is_some_and(|at| Instant::now() >= at) {
                self.solver.kill();
                continue;
            }
            *locked(&shared.beat) = Some(self.beat(held));
            if commit.due() || self.progress.checkpoint.is_some() {
                match self.commit(held, sync, false) {
                    Ok(Swapped::Done) => {}
                    Ok(Swapped::Superseded) => return Ok(self.give_up()),
                    // The store may come back; the solver has lost nothing.
                    Err(error) => eprintln!("not committed: {error:#}"),
                }
            }
            thread::sleep(LOOK);
        };
        // Of a solver that was ended from outside, the wish is the cause.
        self.wanted = self.wanted.or(*locked(&shared.cause));
        self.progress.read().context("progress of the solver")?;
        let ending = self
            .solver
            .ending(status, self.wanted, self.progress.end_cause.as_deref());
        self.closing(held, sync, ending)
    }

    /// Data first, then the head: an end without its data does not exist.
    fn closing(&mut self, held: &mut Held, sync: &mut Sync, ending: Ending) -> Result<Outcome> {
        let mut wait = Duration::from_millis(500);
        loop {
            match self.commit(held, sync, true) {
                Ok(Swapped::Done) => break,
                Ok(Swapped::Superseded) => return Ok(self.give_up()),
                Err(error) => eprintln!(
                    "not committed: {error:#}; again in {} s",
                    wait.as_secs_f64()
                ),
            }
            thread::sleep(wait);
            wait = (wait * 2).min(Duration::from_secs(15));
        }
        if ending.cause == Cause::Finished {
            held.head.step = held.head.step.max(self.progress.step);
        }
        end(self.attempt, held, ending, Some(self))
    }

    fn commit(&mut self, held: &mut Held, sync: &mut Sync, last: bool) -> Result<Swapped> {
        // The run does not depend on it.
        if let Err(error) = self.log() {
            eprintln!("the messages of the solver are not sent: {error:#}");
        }
        held.head.of_steps = self.progress.of_steps.or(held.head.of_steps);
        held.head.time = self.progress.time.max(held.head.time);
        if let Some(seconds) = self.solver.core_seconds() {
            held.head.core_seconds = seconds;
        }
        // The newest counts; it is taken only once it is committed.
        let checkpoint = self.progress.checkpoint.clone();
        let swapped = sync.commit(
            self.attempt,
            held,
            &self.workspace,
            checkpoint.as_ref(),
            &self.progress.grows,
            last,
        )?;
        if self.progress.checkpoint == checkpoint {
            self.progress.checkpoint = None;
        }
        Ok(swapped)
    }

    fn stop(&mut self, cause: Cause) {
        if self.wanted.is_none() {
            self.wanted = Some(cause);
            self.solver.stop();
        }
    }

    /// Wish and limit of the server for this attempt; [`Wish::Run`] if the store gives no answer.
    fn control(&self) -> Control {
        let text = self.attempt.store.get(&self.attempt.key("control.json"));
        let control = text
            .ok()
            .flatten()
            .and_then(|text| serde_json::from_slice::<Control>(&text).ok());
        control
            .filter(|control| control.epoch == self.attempt.epoch)
            .unwrap_or(Control {
                epoch: self.attempt.epoch,
                wish: Wish::Run,
                disk: None,
            })
    }

    /// A sign of life.
    fn beat(&self, held: &Held) -> Beat {
        let progress = &self.progress;
        Beat {
            count: 0,
            interval: self.attempt.beat.as_secs_f64(),
            doing: progress.doing.clone(),
            step: progress.step,
            of_steps: progress.of_steps.or(held.head.of_steps),
            time: progress.time,
            rate: progress.rate,
            seconds_left: progress.seconds_left,
            particles: progress.particles,
        }
    }

    /// The run belongs to another attempt: this one must not go on.
    fn give_up(&mut self) -> Outcome {
        self.solver.kill();
        Outcome::Superseded
    }
}

/// Writes the end into the head.
fn end(
    attempt: &Attempt,
    held: &mut Held,
    ending: Ending,
    watch: Option<&Watch>,
) -> Result<Outcome> {
    held.head.phase = Phase::Ended;
    // Paths of this machine stay on it.
    let mut ending = ending;
    ending.message = match watch {
        Some(watch) => watch.without_paths(&ending.message),
        None => ending.message.replace(&format!("{OUTPUT}/"), ""),
    };
    held.head.ending = Some(ending);
    let mut wait = Duration::from_millis(500);
    loop {
        match held.swap(attempt) {
            Ok(Swapped::Done) => return Ok(Outcome::Committed),
            Ok(Swapped::Superseded) => return Ok(Outcome::Superseded),
            Err(error) if !Held::is_ours(attempt).unwrap_or(true) => return Err(error),
            Err(error) => eprintln!(
                "the end is not committed: {error:#}; again in {} s",
                wait.as_secs_f64()
            ),
        }
        thread::sleep(wait);
        wait = (wait * 2).min(Duration::from_secs(15));
    }
}
