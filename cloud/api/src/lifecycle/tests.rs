//! A small world in which anything may die at any time, and what must hold in it all the same.
//!
//! The world is the store (one head, compare-and-swap), an engine that loses jobs, workers that may be frozen, killed or
//! slow, a server that may die between any two of its actions, and a user. Random sequences of these are played; then
//! all faults stop, and the run has to come to the end that was wanted.

use proptest::prelude::*;

use super::*;

/// Steps of the whole run by revision: each extension adds as many.
const STEPS: u64 = 12;

#[derive(Clone, Copy, Debug)]
enum Act {
    /// The server looks at the run and does one thing, then perhaps dies before it has recorded it.
    Server {
        dies: bool,
    },
    /// The worker of the given index makes some steps and commits.
    Work {
        worker: usize,
        steps: u64,
    },
    /// It dies without a word.
    Kill {
        worker: usize,
    },
    /// Frozen, or thawed.
    Freeze {
        worker: usize,
    },
    /// A notice: it stops and says so.
    Notice {
        worker: usize,
    },
    /// Time passes.
    Wait {
        seconds: f64,
    },
    StoreGone {
        gone: bool,
    },
    EngineMute {
        mute: bool,
    },
    User(u8),
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        8 => prop::bool::weighted(0.15).prop_map(|dies| Act::Server { dies }),
        6 => (0usize..4, 0u64..4).prop_map(|(worker, steps)| Act::Work { worker, steps }),
        1 => (0usize..4).prop_map(|worker| Act::Kill { worker }),
        1 => (0usize..4).prop_map(|worker| Act::Freeze { worker }),
        1 => (0usize..4).prop_map(|worker| Act::Notice { worker }),
        4 => (0.1f64..30.0).prop_map(|seconds| Act::Wait { seconds }),
        1 => any::<bool>().prop_map(|gone| Act::StoreGone { gone }),
        1 => any::<bool>().prop_map(|mute| Act::EngineMute { mute }),
        1 => (0u8..4).prop_map(Act::User),
    ]
}

struct Worker {
    epoch: u64,
    alive: bool,
    frozen: bool,
    /// The head that it has read, until it has taken the epoch.
    taken: bool,
    step: u64,
    revision: u32,
}

struct World {
    run: Run,
    policy: Policy,
    head: Head,
    wish: Option<(u64, Wish)>,
    workers: Vec<Worker>,
    store_gone: bool,
    mute: bool,
    now: f64,
    life: f64,
    submitted_at: f64,
    /// How often the end of each revision was committed.
    finishes: Vec<u32>,
    most_step: u64,
}

impl World {
    fn new() -> Self {
        Self {
            run: Run::new(),
            policy: Policy {
                beat: 2.0,
                budget: 5,
                first_wait: 10.0,
                longest_wait: 600.0,
                stop_grace: 60.0,
            },
            head: Head::default(),
            wish: None,
            workers: Vec::new(),
            store_gone: false,
            mute: false,
            now: 0.0,
            life: 0.0,
            submitted_at: 0.0,
            finishes: vec![0; 40],
            most_step: 0,
        }
    }

    /// Compare-and-swap by a worker: fails where the epoch is another's.
    fn commit(&mut self, epoch: u64, change: impl FnOnce(&mut Head)) -> bool {
        if self.head.epoch != epoch || self.head.phase == Phase::Ended {
            return false;
        }
        let before = (self.head.step, self.head.revision);
        change(&mut self.head);
        self.head.commit += 1;
        assert!(
            self.head.step >= before.0,
            "the committed step went back from {} to {}",
            before.0,
            self.head.step
        );
        self.life = self.now;
        true
    }

    fn record(&mut self, event: &RunEvent) {
        self.run =
            apply(&self.run, event, &self.policy, self.now).expect("what `next` wants is legal");
    }

    fn server(&mut self, dies: bool) {
        let job = self
            .workers
            .iter()
            .any(|w| w.alive && w.epoch == self.run.epoch);
        let todo = {
            let seen = Observation {
                head: (!self.store_gone).then_some(&self.head),
                job: if self.mute {
                    JobState::Unknown
                } else if job {
                    JobState::Running
                } else {
                    JobState::Absent
                },
                silent: self.now - self.life,
                since_submit: self.now - self.submitted_at,
                has_capacity: true,
                now: self.now,
            };
            next(&self.run, &seen, &self.policy)
        };
        match todo {
            Todo::Nothing => {}
            Todo::Launch => self.record(&RunEvent::Launched),
            Todo::Claim => {
                assert!(!self.store_gone);
                let (epoch, revision, commit) =
                    (self.run.epoch, self.run.revision, self.head.commit + 1);
                assert!(epoch > self.head.epoch, "an epoch is claimed once");
                self.head = Head {
                    epoch,
                    revision,
                    commit,
                    phase: Phase::Launched,
                    ending: None,
                    ..self.head.clone()
                };
            }
            Todo::Submit => {
                if self.mute {
                    return;
                }
                // An engine looks for a job of the name first.
                if !job {
                    self.workers.push(Worker {
                        epoch: self.run.epoch,
                        alive: true,
                        frozen: false,
                        taken: false,
                        step: 0,
                        revision: 0,
                    });
                }
                if dies {
                    return;
                }
                self.submitted_at = self.now;
                self.life = self.now;
                self.record(&RunEvent::Submitted);
            }
            Todo::SendWish => self.wish = Some((self.run.epoch, self.run.wish)),
            Todo::Interrupt => {
                let epoch = self.run.epoch;
                for worker in self.workers.iter_mut().filter(|w| w.epoch == epoch) {
                    worker.alive = false;
                }
            }
            Todo::Close(ending) => {
                let step = self.head.step;
                if self.head.phase == Phase::Launched && self.head.epoch == self.run.epoch {
                    self.head.phase = Phase::Ended;
                    self.head.ending = Some(ending.clone());
                    self.head.commit += 1;
                    if dies {
                        return;
                    }
                }
                self.record(&RunEvent::Ended(ending, step));
            }
        }
        if dies {
            // What a new server knows is its database; the sign of life is new to it.
            self.life = self.now;
        }
    }

    fn work(&mut self, index: usize, steps: u64, notice: bool) {
        if self.store_gone || index >= self.workers.len() {
            return;
        }
        let worker = &self.workers[index];
        let epoch = worker.epoch;
        if !worker.alive || worker.frozen {
            return;
        }
        if !worker.taken {
            let launched = self.head.phase == Phase::Launched;
            let taken = launched && self.commit(epoch, |head| head.phase = Phase::Running);
            let worker = &mut self.workers[index];
            worker.taken = taken;
            worker.alive = taken;
            worker.step = self.head.step;
            worker.revision = self.head.revision;
            return;
        }
        let wish = self
            .wish
            .filter(|w| w.0 == epoch)
            .map_or(Wish::Run, |w| w.1);
        let end = STEPS * u64::from(worker.revision);
        let step = (worker.step + steps).min(end);
        let revision = worker.revision as usize;
        let cause = if step == end {
            Some(Cause::Finished)
        } else if wish != Wish::Run {
            Some(Cause::User)
        } else if notice {
            Some(Cause::Spot)
        } else {
            None
        };
        let kept = self.commit(epoch, |head| {
            head.step = step;
            if let Some(cause) = cause {
                head.phase = Phase::Ended;
                head.ending = Some(Ending {
                    cause,
                    code: None,
                    message: String::new(),
                });
            }
        });
        self.workers[index].step = step;
        self.workers[index].alive = kept && cause.is_none();
        if kept && cause == Some(Cause::Finished) {
            self.finishes[revision] += 1;
        }
    }

    fn play(&mut self, act: Act) {
        match act {
            Act::Server { dies } => self.server(dies),
            Act::Work { worker, steps } => self.work(self.latest(worker), steps, false),
            Act::Notice { worker } => self.work(self.latest(worker), 1, true),
            Act::Kill { worker } => {
                let worker = self.latest(worker);
                if let Some(worker) = self.workers.get_mut(worker) {
                    worker.alive = false;
                }
            }
            Act::Freeze { worker } => {
                let worker = self.latest(worker);
                if let Some(worker) = self.workers.get_mut(worker) {
                    worker.frozen = !worker.frozen;
                }
            }
            Act::Wait { seconds } => self.now += seconds,
            Act::StoreGone { gone } => {
                self.store_gone = gone;
                // Without the store no silence is counted.
                self.life = self.now;
            }
            Act::EngineMute { mute } => self.mute = mute,
            Act::User(which) => {
                let event = [
                    RunEvent::Stop,
                    RunEvent::Kill,
                    RunEvent::Resume,
                    RunEvent::Extend,
                ][usize::from(which)]
                .clone();
                if let Ok(run) = apply(&self.run, &event, &self.policy, self.now) {
                    self.run = run;
                }
            }
        }
        self.check();
    }

    /// Index of the worker that is `back` from the newest one.
    fn latest(&self, back: usize) -> usize {
        self.workers.len().wrapping_sub(1 + back)
    }

    fn check(&mut self) {
        assert!(
            self.head.epoch <= self.run.epoch,
            "no attempt without the server"
        );
        assert!(
            self.head.step >= self.most_step,
            "committed steps are never lost"
        );
        self.most_step = self.head.step;
        let taken = self
            .workers
            .iter()
            .filter(|w| w.taken && w.epoch == self.head.epoch)
            .count();
        assert!(taken <= 1, "one epoch is taken by one worker");
        assert!(
            self.finishes.iter().all(|&n| n <= 1),
            "a run is finished once: {:?}",
            self.finishes
        );
        if self.run.state == RunState::Finished {
            assert_eq!(self.head.step, STEPS * u64::from(self.head.revision));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn whatever_dies_a_run_finishes_once(acts in prop::collection::vec(act(), 0..120)) {
        let mut world = World::new();
        for act in acts {
            world.play(act);
        }
        // Faults are over. What is frozen stays so: such a worker must not be waited for.
        world.store_gone = false;
        world.mute = false;
        world.life = world.now;
        if !world.run.state.is_live() && world.run.state != RunState::Finished {
            world.run = apply(&world.run, &RunEvent::Resume, &world.policy, world.now).unwrap();
        }
        for _ in 0..400 {
            world.play(Act::Server { dies: false });
            for back in 0..2 {
                world.play(Act::Work { worker: back, steps: 3 });
            }
            world.play(Act::Wait { seconds: 5.0 });
            if world.run.state == RunState::Stopped {
                world.run = apply(&world.run, &RunEvent::Resume, &world.policy, world.now).unwrap();
            }
            if !world.run.state.is_live() {
                break;
            }
        }
        prop_assert_eq!(world.run.state, RunState::Finished, "{:?} {:?}", world.run, world.head);
        prop_assert_eq!(world.finishes[world.run.revision as usize], 1);
    }

    /// Without faults one attempt is all that a run takes.
    #[test]
    fn a_run_without_faults_takes_one_attempt(steps in prop::collection::vec(0u64..4, 0..20)) {
        let mut world = World::new();
        for _ in 0..4 {
            world.play(Act::Server { dies: false });
        }
        for steps in steps {
            world.play(Act::Work { worker: 0, steps });
            world.play(Act::Server { dies: false });
            world.play(Act::Wait { seconds: 1.0 });
        }
        prop_assert_eq!(world.run.epoch, 1);
        prop_assert_eq!(world.workers.len(), 1);
    }
}

/// A run that never moves uses up its budget and fails; the waits in between double.
#[test]
fn a_run_that_never_moves_fails_after_its_budget() {
    let policy = Policy::default();
    let mut run = Run::new();
    let lost = RunEvent::Ended(
        Ending {
            cause: Cause::Lost,
            code: None,
            message: String::new(),
        },
        0,
    );
    let mut waits = Vec::new();
    while run.state == RunState::Queued {
        run = apply(&run, &RunEvent::Launched, &policy, 0.0).unwrap();
        run = apply(&run, &lost, &policy, 0.0).unwrap();
        waits.push(run.not_before);
    }
    assert_eq!(run.state, RunState::Failed);
    assert_eq!(run.epoch, 5);
    assert_eq!(waits[..4], [10.0, 20.0, 40.0, 80.0]);
}

/// Progress between two losses gives the whole budget back.
#[test]
fn progress_resets_the_budget() {
    let policy = Policy::default();
    let mut run = Run::new();
    for step in 1..50 {
        run = apply(&run, &RunEvent::Launched, &policy, 0.0).unwrap();
        let spot = Ending {
            cause: Cause::Spot,
            code: Some(75),
            message: String::new(),
        };
        run = apply(&run, &RunEvent::Ended(spot, step), &policy, 0.0).unwrap();
        assert_eq!((run.state, run.not_before), (RunState::Queued, 0.0));
    }
}

/// Every event in every state is either legal or refused; what is refused changes nothing.
#[test]
fn illegal_events_are_refused() {
    use RunState::*;
    let policy = Policy::default();
    let run = |state| Run {
        state,
        epoch: 1,
        ..Run::new()
    };
    let legal = |state, event: RunEvent| apply(&run(state), &event, &policy, 0.0).is_ok();
    for state in RunState::ALL {
        assert_eq!(
            legal(state, RunEvent::Launched),
            state == Queued,
            "{state:?}"
        );
        assert_eq!(legal(state, RunEvent::Stop), state.is_live(), "{state:?}");
        assert_eq!(
            legal(state, RunEvent::Resume),
            matches!(state, Stopped | Failed | Cancelled),
            "{state:?}"
        );
        assert_eq!(
            legal(state, RunEvent::Extend),
            !state.is_live(),
            "{state:?}"
        );
    }
}

/// Without the store nothing is declared dead, however long it lasts.
#[test]
fn a_store_out_of_reach_kills_nothing() {
    let run = Run {
        state: RunState::Running,
        epoch: 3,
        submitted: true,
        ..Run::new()
    };
    let seen = Observation {
        head: None,
        job: JobState::Absent,
        silent: 1e9,
        since_submit: 1e9,
        has_capacity: true,
        now: 1e9,
    };
    assert_eq!(next(&run, &seen, &Policy::default()), Todo::Nothing);
}
