//! A trial: the first seconds of a run, without any file, and an estimate of the time of the whole run at this speed.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use mercury_common::readable::{count, counted, duration, rounded};
use serde::Serialize;

use super::long_steps::{LongStep, long_steps, next_long_step};
use super::time_left::Cost;
use super::{RunOptions, ahead_of};
use crate::output::{Exchanged, FrameCopy, Schedule};
use crate::plan::{Ahead, Plan, Workload};
use mercury_engine::forces::Watch;
use mercury_engine::spray::{Droplet, SprayPlan};
use mercury_engine::step::{Engine, RunError};
use mercury_engine::task::Task;

/// Particle-steps that are made without looking at the clock: some hundredths of a second.
const AT_ONCE: u64 = 200_000;

/// Pairs that touch per grain above which a bed is as dense as it gets, nearly: dense beds have 2.1 to 2.4. Of the instructions of a
/// particle-step in `bench/dense-2k.toml`, `settle.toml` has 0.27 while its beads fall.
const DENSE: f64 = 1.5;

/// Part of a wet particle-step that a droplet's step takes: 0.14 to 0.44 of the instructions, the more where drag acts and grains are near
/// (`docs/lab/performance.md`, *Droplets*).
const DROPLET: f64 = 0.3;

/// Findings of a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// The wall-clock time of the run, lower and upper bound as far as the plan determines the insertions, s.
    pub seconds: [f64; 2],
    /// From the beginning of the trial to its first step: the first insertion, lists and forces, s.
    pub starting: f64,
    /// Its steps, s.
    pub stepping: f64,
    /// Steps made.
    pub steps: u64,
    /// Steps of the whole run.
    pub of_steps: u64,
    /// Particle-steps made.
    pub particle_steps: u64,
    /// Seconds per particle-step, of the later ones.
    pub seconds_per_particle_step: f64,
    /// Grains after the last of them.
    pub particles: usize,
    /// Pairs of grains that touched then, per grain.
    pub contacts_per_particle: f64,
    /// Droplets in flight then.
    pub droplets: usize,
    /// Droplets that are in flight at once later on, about.
    pub droplets_at_most: f64,
    /// Steps of droplets that remained then, about.
    pub droplet_steps_ahead: f64,
    /// Particle-steps that remained then, lower and upper bound.
    pub particle_steps_ahead: [f64; 2],
    /// Grains at the end, at least and at most.
    pub particles_at_end: [f64; 2],
    /// Threads.
    pub threads: usize,
    /// The run may end before its time, at rest.
    pub until_at_rest: bool,
    /// Whether the trial was ended before its time.
    pub is_cut_short: bool,
}

/// The seconds of a run whose start took `starting`, and its steps so far `stepping`, where a particle-step takes `cost`; lower
/// and upper bound.
fn seconds(starting: f64, stepping: f64, cost: f64, ahead: &Ahead, droplet_steps: f64) -> [f64; 2] {
    let seconds = |work: f64| starting + stepping + cost * (work + DROPLET * droplet_steps);
    ahead.particle_steps.map(seconds)
}

/// Droplets in flight at once, and their steps from now on, about: of each nozzle, while it sprays, as many as cross the domain with their
/// first speed, or as there are now.
fn droplets_ahead(plan: &Plan, engine: &Engine) -> [f64; 2] {
    let physics = plan.physics();
    let across = physics.cell.diagonal();
    let end = physics.steps as f64 * physics.time_step;
    let droplets = (engine.sprays()).map_or(&[][..], |sprays| &sprays.state.droplets);
    let (mut at_once, mut steps) = (0.0, 0.0);
    let nozzles = physics
        .plans
        .all::<SprayPlan>()
        .iter()
        .flat_map(|plan| &plan.nozzles);
    for (index, nozzle) in nozzles.enumerate() {
        let own = |droplet: &&Droplet| droplet.nozzle as usize == index;
        let now = droplets.iter().filter(own).count() as f64;
        let flying = nozzle.in_flight(across).max(now);
        let time = nozzle.until.min(end) - nozzle.from.max(engine.time());
        at_once += flying;
        steps += flying * (time / physics.time_step).max(0.0);
    }
    [at_once, steps]
}

/// Makes the first steps of a run, for a given time by the clock from the first step on, or to its end. Nothing is written.
/// `None` if it was stopped before its first step.
///
/// Of `options` only those on the way in which steps are made, and on stopping, count.
///
/// # Errors
/// As a run whose steps fail.
pub fn trial(plan: Plan, options: &RunOptions, limit: Duration) -> Result<Option<Trial>, RunError> {
    let begun = Instant::now();
    let plan = Arc::new(plan);
    let (physics, files) = (plan.physics(), plan.outputs().files());
    let mut schedule = Schedule::behind(files, physics.time_step, 0);
    let long_steps = long_steps(&plan);
    let task_progress = &options.task_progress;
    task_progress.expect(expected_at(&long_steps, 0));
    // A trial that is given up leaves nothing behind, at any time.
    task_progress.may_give_up(true);
    task_progress.begin(Task::Starting);
    let given_up = |error| match error {
        RunError::GivenUp => Ok(None),
        error => Err(error),
    };
    let mut engine = match Engine::start(Arc::clone(&plan), options.start(&schedule)) {
        Ok(engine) => engine,
        Err(error) => return given_up(error),
    };
    task_progress.begin(Task::Stepping);
    let starting = begun.elapsed();
    let (mut stepping, mut inserting) = (Duration::ZERO, Duration::ZERO);
    let (mut particle_steps, mut droplet_steps, mut cost) = (0, 0, Cost::default());
    let is_stopped = || options.stop.load(Ordering::Relaxed);
    // Long insertions are no part of the cost, but of the time.
    while stepping < limit && engine.steps() < physics.steps && !is_stopped() {
        let step = engine.steps();
        let most = (AT_ONCE / engine.particles.len().max(1) as u64).clamp(1, 1000);
        let long = next_long_step(&long_steps, step);
        let is_long = long.is_some_and(|long| long.step == step + 1);
        let before_long = long.map_or(u64::MAX, |long| long.step - 1);
        let until = match is_long {
            true => step + 1,
            false => before_long.min(physics.steps),
        };
        let target = (step + most)
            .min(schedule.next_step())
            .clamp(step + 1, until);
        let due = schedule.due(target);
        let is_last = target == physics.steps;
        let watch = (due.any() || is_last).then_some(Watch {
            records: due.needs_records(),
            audit: None,
        });
        if is_long {
            task_progress.expect(expected_at(&long_steps, target));
            task_progress.begin(Task::Inserting);
        }
        engine.step_alone(options.steps_alone(&engine));
        let since = Instant::now();
        match engine.steps_at_once(target - step, watch) {
            Err(RunError::GivenUp) if particle_steps > 0 => break,
            Err(error) => return given_up(error),
            Ok(()) => {}
        }
        if due.any() {
            engine.complete_step()?;
            // As a run would hand it over.
            drop(FrameCopy::take(&mut engine, due, &Exchanged::default()));
        }
        task_progress.begin(Task::Stepping);
        let took = since.elapsed();
        if is_long {
            inserting += took;
            continue;
        }
        stepping += took;
        let made = (target - step) * engine.particles.grains() as u64;
        particle_steps += made;
        droplet_steps += (target - step) * flying(&engine) as u64;
        let work = particle_steps as f64 + DROPLET * droplet_steps as f64;
        cost.note(stepping.as_secs_f64(), work);
    }
    if engine.steps() == 0 {
        return Ok(None);
    }
    let ahead = ahead_of(&Workload::of(&plan), &engine);
    let [droplets_at_most, droplet_steps_ahead] = droplets_ahead(&plan, &engine);
    let particles = engine.particles.grains();
    let spent = (stepping + inserting).as_secs_f64();
    Ok(Some(Trial {
        seconds: seconds(
            starting.as_secs_f64(),
            spent,
            cost.per_work(),
            &ahead,
            droplet_steps_ahead,
        ),
        starting: starting.as_secs_f64(),
        stepping: spent,
        steps: engine.steps(),
        of_steps: physics.steps,
        particle_steps,
        seconds_per_particle_step: cost.per_work(),
        particles,
        contacts_per_particle: touching(&mut engine) as f64 / particles.max(1) as f64,
        droplets: flying(&engine),
        droplets_at_most,
        droplet_steps_ahead,
        particle_steps_ahead: ahead.particle_steps,
        particles_at_end: ahead.grains,
        threads: options.threads.max(1),
        until_at_rest: physics.until_at_rest,
        is_cut_short: is_stopped(),
    }))
}

/// Droplets in flight.
fn flying(engine: &Engine) -> usize {
    let sprays = engine.sprays();
    sprays.map_or(0, |sprays| sprays.state.droplets.len())
}

/// The expected number in a step that inserts many.
fn expected_at(long_steps: &[LongStep], step: u64) -> u64 {
    let long = long_steps.iter().find(|long| long.step == step);
    long.map_or(0, |long| long.expected)
}

/// Pairs of particles that touch, after one more observed step; 0 if it cannot be made.
fn touching(engine: &mut Engine) -> u64 {
    let watch = Watch {
        records: false,
        audit: None,
    };
    match engine.step(Some(watch)) {
        Ok(()) => engine.observation().particle_contacts,
        Err(_) => 0,
    }
}

/// One number, or the range.
fn range([least, most]: [f64; 2], reported: impl Fn(f64) -> String) -> String {
    match (reported(least), reported(most)) {
        (least, most) if least == most => least,
        (least, most) => format!("{least} to {most}"),
    }
}

impl fmt::Display for Trial {
    /// A section of what `--check` prints.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |grains: f64| count(grains.round() as u64);
        let threads = counted(self.threads, "thread");
        writeln!(f, "Run time, estimated from a trial")?;
        let mut line = |name: &str, text: &str| writeln!(f, "  {name:<24}{text}");
        if self.steps >= self.of_steps {
            let took = duration(self.starting + self.stepping);
            return line(
                "all of it",
                &format!("{took} on {threads}: the trial came to the end"),
            );
        }
        let about = range(self.seconds, duration);
        let or_less = if self.until_at_rest {
            ", less if it comes to rest before its end"
        } else {
            ""
        };
        line("all of it", &format!("about {about} on {threads}{or_less}"))?;
        let mut from = format!(
            "{} of {} steps in {}, at {} ns per particle-step",
            count(self.steps),
            count(self.of_steps),
            duration(self.stepping),
            rounded(1e9 * self.seconds_per_particle_step, 3)
        );
        if self.is_cut_short {
            from += "; it was ended before its time";
        }
        line("from", &from)?;
        line("until the first step", &duration(self.starting))?;
        let [least, most] = self.particles_at_end.map(f64::round);
        let now = self.particles as f64;
        let mut particles = format!("{} in the trial", number(now));
        if [least, most] != [now; 2] {
            let at_end = range([least, most], number);
            particles += &format!(", {at_end} at the end, which is counted in");
        }
        if least < most {
            particles += ": the least if no space is left for more, the most if there is at once";
        }
        line("particles", &particles)?;
        if self.droplets_at_most > 0.0 {
            let work = DROPLET * self.droplet_steps_ahead;
            let all = work + 0.5 * self.particle_steps_ahead.iter().sum::<f64>();
            line(
                "droplets",
                &format!(
                    "{} in the trial, about {} at once while nozzles spray: each takes {DROPLET} of a particle-step, {} % of the time to come, which is counted in",
                    number(self.droplets as f64),
                    number(self.droplets_at_most),
                    rounded(100.0 * work / all.max(1.0), 2)
                ),
            )?;
        }
        if self.contacts_per_particle < DENSE && most > 1.0 {
            let contacts = rounded(self.contacts_per_particle, 2);
            line(
                "contacts",
                &format!(
                    "{contacts} per particle in the trial: a dense bed has 2.1 to 2.4, and a particle-step takes up to four times as long there"
                ),
            )?;
        }
        line(
            "not counted in",
            "particles that leave, and waiting for the disk",
        )
    }
}

#[cfg(test)]
mod tests;
