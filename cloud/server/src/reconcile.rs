//! One loop that looks at every live run and does the next thing about it.
//!
//! The next action is decided by `cloud_api::lifecycle::next`, from the row in the database, the head in the store and what
//! the engine says. A server that was killed looks anew and goes on; there is no recovery apart.

use std::collections::HashMap;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use cloud_api::lifecycle::{JobState, Observation, RunEvent, Todo, next};
use cloud_api::{Beat, Control, Head, Phase, RunState, Wish, memory_of_rank};
use cloud_engine::{Launch, Observed, Site, Stop, job_name};
use serde_json::json;

use crate::EngineChoice;
use crate::db::{Applied, LiveRun, now};
use crate::state::{App, Message};

/// How often the loop looks at least, if nothing wakes it.
const LOOK: Duration = Duration::from_millis(500);

/// How often it looks while runs wait for capacity on this machine, which short runs leave soon.
const LOOK_FOR_PLACE: Duration = Duration::from_millis(150);

/// Looks between two beats: more would see nothing new.
const LOOKS_PER_BEAT: f64 = 4.0;

/// Seconds between two commits without a checkpoint, and as many beats at least.
const COMMIT: (f64, f64) = (5.0, 2.0);

/// The most things that are done about one run before the others have their turn.
const IN_A_ROW: usize = 6;

/// Starts the loop in a thread of its own.
pub(crate) fn begin(app: Arc<App>) -> Result<()> {
    let woken = app
        .woken
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner())
        .take();
    let woken = woken.context("the loop runs already")?;
    thread::Builder::new()
        .name("reconciler".into())
        .spawn(move || {
            loop {
                let begin = Instant::now();
                let wait = reconcile_all(&app).unwrap_or_else(|error| {
                    eprintln!("{error:#}");
                    LOOK
                });
                app.cache.tidy();
                // A wake-up is heard at once, but the loop does not take more than half of a processor.
                thread::sleep(begin.elapsed().min(LOOK));
                let _ = woken.recv_timeout(wait);
            }
        })?;
    Ok(())
}

/// Reconciles all runs; returns the time until the next pass, if nothing wakes the loop before.
fn reconcile_all(app: &App) -> Result<Duration> {
    let every = Duration::from_secs_f64(app.db.policy().beat / LOOKS_PER_BEAT).max(LOOK);
    for (id, why) in app.db.out_of_time()? {
        match app.db.stop_for(&id, &why, app.engine.as_ref())? {
            Applied::Done(_, events) => app.publish(events),
            Applied::Missing => {}
            Applied::Illegal(error) => eprintln!("run {id}: {error}"),
        }
    }
    let most = app.engine.abilities().ranks;
    let mut runs = app.db.live()?;
    // The site file may have offered more when they were submitted.
    runs.iter_mut()
        .for_each(|live| live.ranks = live.ranks.min(most));
    if runs.is_empty() {
        return Ok(every);
    }
    let mut waiting = false;
    let jobs = if runs.iter().any(|live| live.run.state.has_attempt()) {
        match app.engine.observe() {
            Ok(jobs) => Some(jobs),
            Err(error) => {
                eprintln!("the engine does not respond: {error}");
                None
            }
        }
    } else {
        Some(HashMap::new())
    };
    let busy = |wanted: &dyn Fn(&LiveRun) -> u64| -> u64 {
        runs.iter()
            .filter(|live| live.run.state.has_attempt())
            .map(wanted)
            .sum()
    };
    let mut capacity = FreeCapacity {
        cores: app
            .engine
            .abilities()
            .cores
            .map(|cores| i64::from(cores) - busy(&LiveRun::cores) as i64),
        memory: app.options.memory.saturating_sub(busy(&|live| live.memory)),
        empty: busy(&|_| 1) == 0,
        limits: app.db.most_cores()?,
        taken: HashMap::new(),
    };
    for live in runs.iter().filter(|live| live.run.state.has_attempt()) {
        *capacity.taken.entry(live.owner).or_default() += live.cores();
    }
    let over = app.db.over_limit()?;
    let mut to_submit = Vec::new();
    for live in runs {
        let has_capacity = capacity.fits(&live);
        // Most of a long queue waits for its turn: nothing has to be read for that.
        if live.run.state == RunState::Queued && !has_capacity && live.run.epoch == 0 {
            waiting = true;
            continue;
        }
        if over.contains(&live.owner)
            && let Err(error) = end_for_disk(app, &live)
        {
            eprintln!("run {}: {error:#}", live.id);
        }
        let began = !live.run.state.has_attempt();
        match reconcile_run(app, live.clone(), jobs.as_ref(), has_capacity) {
            Ok(after) => {
                if began && after.has_attempt() {
                    capacity.reserve(&live);
                }
                if let Reconciled::Submit(ready) = after {
                    to_submit.push(*ready);
                }
            }
            Err(error) => eprintln!("run {}: {error:#}", live.id),
        }
    }
    submit(app, to_submit);
    let local = app.engine.abilities().cores.is_some();
    Ok(if waiting && local {
        LOOK_FOR_PLACE.min(every)
    } else {
        every
    })
}

/// Lets a run write nothing more, once: its owner has more than the limit. It stops with a checkpoint and says why.
fn end_for_disk(app: &App, live: &LiveRun) -> Result<()> {
    let epoch = live.run.epoch;
    if live.run.state != RunState::Running || live.run.wish != Wish::Run {
        return Ok(());
    }
    if app.attempts.with(&live.id, epoch, |seen| seen.over_limit) {
        return Ok(());
    }
    let control = serde_json::to_vec(&Control {
        epoch,
        wish: Wish::Run,
        disk: Some(0),
    })?;
    app.store
        .put(&format!("runs/{}/control.json", live.id), &control)?;
    app.attempts
        .with(&live.id, epoch, |seen| seen.over_limit = true);
    Ok(())
}

/// Free cores and memory of this machine, and limits of users.
struct FreeCapacity {
    /// `None`: the engine has a queue of its own.
    cores: Option<i64>,
    memory: u64,
    empty: bool,
    /// The most cores of users that have a limit.
    limits: std::collections::BTreeMap<i64, u64>,
    /// Cores that users have.
    taken: HashMap<i64, u64>,
}

impl FreeCapacity {
    /// A run that is larger than the machine runs alone: it was let in by the check, or the machine was larger then.
    fn fits(&self, live: &LiveRun) -> bool {
        let taken = self.taken.get(&live.owner).copied().unwrap_or(0);
        if (self.limits.get(&live.owner)).is_some_and(|&most| taken + live.cores() > most) {
            return false;
        }
        self.cores.is_none_or(|cores| {
            self.empty || (live.cores() as i64 <= cores && live.memory <= self.memory)
        })
    }

    fn reserve(&mut self, live: &LiveRun) {
        self.cores = self.cores.map(|cores| cores - live.cores() as i64);
        self.memory = self.memory.saturating_sub(live.memory);
        self.empty = false;
        *self.taken.entry(live.owner).or_default() += live.cores();
    }
}

/// Result of reconciling a run.
enum Reconciled {
    /// Without an attempt, or with one that needs nothing.
    Attempt(bool),
    /// With an attempt that the engine is to start, together with those of other runs.
    Submit(Box<(LiveRun, Launch)>),
}

impl Reconciled {
    fn has_attempt(&self) -> bool {
        match self {
            Self::Attempt(has_attempt) => *has_attempt,
            Self::Submit(_) => true,
        }
    }
}

/// Starts attempts, and records those that the engine took.
fn submit(app: &App, ready: Vec<(LiveRun, Launch)>) {
    let (runs, launches): (Vec<LiveRun>, Vec<Launch>) = ready.into_iter().unzip();
    if launches.is_empty() {
        return;
    }
    for (live, came) in runs.iter().zip(app.engine.submit_all(&launches)) {
        if let Err(error) = came {
            eprintln!("run {}: {error:#}", live.id);
            continue;
        }
        (app.options.after_submit)();
        app.attempts.with(&live.id, live.run.epoch, |seen| {
            seen.submitted = Instant::now();
            seen.changed = Instant::now();
        });
        let recorded = head_of(app, live).and_then(|head| {
            let engine = app.engine.as_ref();
            Ok(app
                .db
                .apply(&live.id, &RunEvent::Submitted, Some(&head), engine)?)
        });
        match recorded {
            Ok(Applied::Done(_, events)) => app.publish(events),
            Ok(Applied::Missing) => {}
            Ok(Applied::Illegal(error)) => eprintln!("run {}: {error}", live.id),
            // The next look finds the job by its name.
            Err(error) => eprintln!("run {}: {error:#}", live.id),
        }
    }
}

/// Executes the actions that are due for a run.
fn reconcile_run(
    app: &App,
    mut live: LiveRun,
    jobs: Option<&HashMap<String, Observed>>,
    has_capacity: bool,
) -> Result<Reconciled> {
    for _ in 0..IN_A_ROW {
        let head_key = format!("runs/{}/head.json", live.id);
        let versioned = match app.store.get_versioned(&head_key) {
            Ok(versioned) => versioned,
            Err(error) => {
                eprintln!("{error}");
                // Silence of the store is not silence of the run.
                app.attempts.with(&live.id, live.run.epoch, |seen| {
                    seen.changed = Instant::now()
                });
                return Ok(Reconciled::Attempt(live.run.state.has_attempt()));
            }
        };
        let (head, version) = match versioned {
            Some((text, version)) => {
                let head: Head = serde_json::from_slice(&text)
                    .with_context(|| format!("{head_key} cannot be read"))?;
                (head, Some(version))
            }
            None => (Head::default(), None),
        };
        let (job, waits) = match jobs {
            None => (JobState::Unknown, None),
            Some(jobs) => match jobs.get(&job_name(&live.id, live.run.epoch)) {
                None => (JobState::Absent, None),
                Some(Observed::Pending(reason)) => (JobState::Pending, Some(reason.clone())),
                Some(Observed::Running(_)) => (JobState::Running, None),
            },
        };
        let beat = if live.run.state.has_attempt() && head.phase == Phase::Running {
            let text = app
                .store
                .get(&format!("runs/{}/beat/{}.json", live.id, live.run.epoch))
                .ok()
                .flatten();
            text.and_then(|text| serde_json::from_slice::<Beat>(&text).ok())
        } else {
            None
        };
        record_signs(app, &live, &head, beat, (job, waits));
        let (changed, submitted) = app.attempts.with(&live.id, live.run.epoch, |seen| {
            (seen.changed, seen.submitted)
        });
        let seen = Observation {
            head: Some(&head),
            job,
            silent: changed.elapsed().as_secs_f64(),
            since_submit: submitted.elapsed().as_secs_f64(),
            has_capacity,
            now: now(),
        };
        let event = match next(&live.run, &seen, app.db.policy()) {
            Todo::Nothing => break,
            Todo::Launch => RunEvent::Launched,
            Todo::Claim => {
                let claimed = Head {
                    epoch: live.run.epoch,
                    revision: live.run.revision,
                    commit: head.commit + 1,
                    phase: Phase::Launched,
                    ending: None,
                    ..head
                };
                // Where another was faster (a worker that was given up), the next look sees what it did.
                app.store.swap(
                    &head_key,
                    version.as_ref(),
                    &serde_json::to_vec_pretty(&claimed)?,
                )?;
                continue;
            }
            Todo::Submit => {
                let launch = launch(app, &live)?;
                return Ok(Reconciled::Submit(Box::new((live, launch))));
            }
            Todo::SendWish => {
                let (epoch, wish) = (live.run.epoch, live.run.wish);
                let wished = app.attempts.with(&live.id, epoch, |seen| {
                    *seen.wished.get_or_insert_with(Instant::now)
                });
                let control = serde_json::to_vec(&Control {
                    epoch,
                    wish,
                    disk: None,
                })?;
                app.store
                    .put(&format!("runs/{}/control.json", live.id), &control)?;
                if wished.elapsed().as_secs_f64() > app.db.policy().stop_grace
                    || wish == Wish::Kill && wished.elapsed() > LOOK * 20
                {
                    app.engine.stop(&job_name(&live.id, epoch), Stop::Hard)?;
                }
                break;
            }
            Todo::Interrupt => {
                let epoch = live.run.epoch;
                // First the gentle way, once; a job that does not go is ended.
                let since = app.attempts.with(&live.id, epoch, |seen| seen.interrupted);
                let grace = app.engine.abilities().grace;
                let how = match since {
                    None => Stop::Gently,
                    Some(since) if since.elapsed().as_secs_f64() > grace => Stop::Hard,
                    Some(_) => break,
                };
                app.engine.stop(&job_name(&live.id, epoch), how)?;
                app.attempts.with(&live.id, epoch, |seen| {
                    seen.interrupted.get_or_insert_with(Instant::now);
                });
                break;
            }
            Todo::Close(ending) => {
                let step = head.step;
                // A worker that begins late finds its attempt ended.
                if head.phase == Phase::Launched && head.epoch == live.run.epoch {
                    let over = serde_json::to_vec_pretty(&Head {
                        commit: head.commit + 1,
                        phase: Phase::Ended,
                        ending: Some(ending.clone()),
                        ..head
                    })?;
                    let swapped = app.store.swap(&head_key, version.as_ref(), &over)?;
                    if swapped.is_none() {
                        continue;
                    }
                }
                RunEvent::Ended(ending, step)
            }
        };
        let closed = matches!(event, RunEvent::Ended(..));
        match app.db.apply(
            &live.id,
            &event,
            Some(&head_of(app, &live)?),
            app.engine.as_ref(),
        )? {
            Applied::Done(run, events) => {
                live.run = run;
                app.publish(events);
            }
            Applied::Missing => return Ok(Reconciled::Attempt(false)),
            Applied::Illegal(error) => eprintln!("run {}: {error}", live.id),
        }
        if closed {
            if !live.run.state.is_live() {
                app.attempts.forget(&live.id);
            }
            break;
        }
    }
    Ok(Reconciled::Attempt(live.run.state.has_attempt()))
}

fn head_of(app: &App, live: &LiveRun) -> Result<Head> {
    let id = live.id.parse()?;
    Ok(app.head(&id)?.unwrap_or_default())
}

/// Sends a message about a run that is not kept.
fn announce(app: &App, run: &str, kind: &str, data: serde_json::Value) {
    let message = Message {
        audience: app.db.audience(run).unwrap_or_default(),
        id: None,
        run: run.to_owned(),
        text: json!({"run": run, "kind": kind, "time": now(), "data": data}).to_string(),
    };
    // Without listeners there is no error.
    let _ = app.news.send(Arc::new(message));
}

/// Records signs of life, and publishes them.
fn record_signs(
    app: &App,
    live: &LiveRun,
    head: &Head,
    beat: Option<Beat>,
    (job, waits): (JobState, Option<String>),
) {
    let mut committed = false;
    let mut waits_otherwise = false;
    let (news, notes) = app.attempts.with(&live.id, live.run.epoch, |seen| {
        let beats =
            beat.as_ref().map(|beat| beat.count) != seen.beat.as_ref().map(|beat| beat.count);
        let changed = beats || head.commit != seen.commit || job != seen.job;
        if changed {
            seen.changed = Instant::now();
        }
        committed = head.commit != seen.commit && head.epoch == live.run.epoch;
        seen.commit = head.commit;
        seen.job = job;
        waits_otherwise = seen.waits != waits;
        seen.waits.clone_from(&waits);
        let first = seen.notes.min(head.notes.len());
        seen.notes = head.notes.len();
        let news = beats.then(|| beat.clone()).flatten();
        if beat.is_some() {
            seen.beat = beat;
        }
        (news, head.notes[first..].to_vec())
    });
    if committed && let Err(error) = app.db.set_progress(&live.id, live.run.epoch, head) {
        eprintln!("run {}: {error}", live.id);
    }
    if waits_otherwise {
        announce(app, &live.id, "waits", json!(waits));
    }
    if let Some(beat) = news {
        announce(app, &live.id, "progress", json!(beat));
    }
    for note in notes {
        // A server that was started anew would say old ones again.
        let known = app.db.events(None, Some(&live.id), 0).unwrap_or_default();
        let data = json!(note);
        if !known
            .iter()
            .any(|event| event.kind == "note" && event.data == data)
            && let Ok(event) = app.db.event(&live.id, "note", data)
        {
            app.publish(vec![event]);
        }
    }
}

fn launch(app: &App, live: &LiveRun) -> Result<Launch> {
    let job = job_name(&live.id, live.run.epoch);
    let options = &app.options;
    let (program, solver, scratch) = match (app.engine.image(), &options.engine) {
        (Some(image), _) => (
            image.program.clone(),
            image.solver.clone(),
            image.scratch.clone(),
        ),
        // By a name that is the program that runs now, also when its file has been replaced by a newer one.
        (None, EngineChoice::Local) => (
            "/proc/self/exe".into(),
            options.solver.clone(),
            app.scratch(),
        ),
        (None, _) => {
            // As it was at the start: a program that was replaced since has another path in /proc.
            (app.program.clone(), options.solver.clone(), app.scratch())
        }
    };
    let mut command: Vec<std::ffi::OsString> = vec![program.into(), "worker".into()];
    let mut add = |option: &str, value: std::ffi::OsString| command.extend([option.into(), value]);
    add("--store", (&app.store_url).into());
    add("--job", (&job).into());
    add("--run", (&live.id).into());
    add("--epoch", live.run.epoch.to_string().into());
    add("--scratch", scratch.into());
    add("--solver", solver.into());
    let beat = app.db.policy().beat;
    add("--beat", beat.to_string().into());
    add("--commit", COMMIT.0.max(COMMIT.1 * beat).to_string().into());
    add("--checkpoint-every", (&options.checkpoint_every).into());
    if let Some(disk) = app.db.left_for(&live.id)? {
        add("--disk", disk.to_string().into());
    }
    if live.ranks > 1
        && let EngineChoice::Slurm(Site {
            ranks: Some(ranks), ..
        }) = &options.engine
    {
        add("--ranks", live.ranks.to_string().into());
        ranks
            .srun
            .iter()
            .for_each(|option| add("--srun", option.into()));
        ranks
            .paths
            .iter()
            .for_each(|path| add("--mpi-path", path.into()));
    }
    if !app
        .engine
        .image()
        .map_or(options.sandbox, |image| image.sandbox)
    {
        command.push("--no-sandbox".into());
    }
    let log = options.data.join("log").join(format!("{job}.log"));
    Ok(Launch {
        job,
        command,
        ranks: live.ranks,
        threads: live.threads,
        memory: memory_of_rank(live.memory, live.ranks),
        log,
        barren: live.run.barren,
    })
}
