//! `mercury-solve study.toml` and `--sweep`: many runs of one scene, several at a time, and the table of their results.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::output::folder::{self, Earlier};
use crate::output::summary::Status;
use crate::plan::{Disk, Plan, sha256};
use crate::results::{self, NamedResult};
use crate::run::{self, RanksHere, check_fit, plan_of_ranks};
use crate::study::seeds::{DIFFERENCES, MEANS};
use crate::study::table::{FILE, State, StudyTable};
use crate::study::{Seeds, Study, StudyRun, Sweep, earlier, file, grid, plot};
use mercury_common::cli::{self, Exit, Failure, Outcome, say};
use mercury_common::machine;
use mercury_common::problem::Problem;
use mercury_common::readable::counted;
use mercury_common::scene::{Scene, stem};
use mercury_common::whole_file::write_whole;
use mercury_common::within::Within;
use mercury_engine::task::{Task, TaskProgress};
use serde_json::{Value, json};

use super::Arguments;
use super::input::{Input, lies_within, refused};
use super::problems::say_object;
use super::ranks::{self, Leader};
use super::run::{How, Ran, Requests, Stated, run_plan, unusable};
use super::waiting::Waiting;

/// Number of refused runs that a report lists.
const MOST_TOLD: usize = 3;

/// A study and its scene.
#[derive(Debug)]
pub(crate) struct Asked {
    study: Study,
    scene: Input,
    within: Option<Arc<Within>>,
    /// The ranks that make each run.
    ranks: RanksHere,
    /// Also runs that need more memory than there is.
    any_memory: bool,
}

impl Asked {
    /// By what ranks see that they make the same study; the scene of each run is compared when it begins.
    pub(crate) fn digest(&self) -> String {
        sha256(format!("{:?}", self.study).as_bytes())
    }

    /// Whether several of its runs are to be made at a time.
    pub(crate) fn has_jobs(&self) -> bool {
        self.study.jobs.is_some_and(|jobs| jobs > 1)
    }

    /// A run by its number, and its scene.
    ///
    /// # Errors
    /// If it cannot be planned.
    pub(crate) fn planned(&self, run: usize) -> Result<(Plan, Scene), Failure> {
        let (plan, _, scene) = planned(self, &self.study.runs[run], 1, self.any_memory)?;
        Ok((plan, scene))
    }
}

/// The study that the command line names, if it names one.
pub(crate) fn requested(
    input: &Input,
    arguments: &Arguments,
    within: Option<&Arc<Within>>,
    ranks: RanksHere,
) -> Result<Option<Asked>, Failure> {
    let path = &input.path;
    let is_file = file::is_study(&input.text);
    let has_values = !arguments.sweep.is_empty() || (arguments.seeds.is_some() && !is_file);
    let mut study = match (!has_values, is_file) {
        (true, false) => {
            for (option, given) in [
                ("--plot", !arguments.plot.is_empty()),
                ("--jobs", arguments.jobs.is_some()),
            ] {
                if given {
                    let failure =
                        Failure::input(format!("{option} is for studies, and this is one run"));
                    return Err(failure.with_help("--sweep KEY=A,B,C makes a study of it"));
                }
            }
            return Ok(None);
        }
        (false, true) => {
            let failure = Failure::input(format!(
                "{}: --sweep is for scenes, and this is a study",
                path.display()
            ));
            return Err(failure.with_help("its values are in its table [study.sweep]"));
        }
        (true, true) => file::parse(path, &input.text).map_err(Failure::input)?,
        (false, false) => swept(path, &arguments.sweep)?,
    };
    if arguments.progress.is_some() {
        let failure = Failure::input("--progress is for one run, and this is a study");
        return Err(failure.with_help("--check --json lists its runs: each can be run by itself"));
    }
    if arguments.trial.is_some() {
        let runs = counted(study.runs.len(), "run");
        let failure = Failure::input(format!(
            "--trial is for one run, and this is a study of {runs}"
        ));
        return Err(failure.with_help(format!(
            "try its scene with the values of one: mercury-solve {} --check --trial --set KEY=VALUE",
            study.scene.display()
        )));
    }
    if let Some(folder) = &arguments.output {
        study.folder.clone_from(folder);
    }
    study.set.extend(arguments.set.iter().cloned());
    study.jobs = arguments.jobs.or(study.jobs);
    study.threads = arguments.threads.or(study.threads);
    study.results.extend(arguments.results()?);
    study.plots.extend(arguments.plot.iter().cloned());
    if let Some(seeds) = &arguments.seeds {
        repeat(&mut study, seeds.clone(), &arguments.error)?;
    }
    study.check_names().map_err(Failure::input)?;
    lies_within(within, &study.folder)?;
    let scene = match is_file {
        true => scene_of(path, &study, within)?,
        false => input.clone(),
    };
    Ok(Some(Asked {
        study,
        scene,
        within: within.cloned(),
        ranks,
        any_memory: arguments.force_memory,
    }))
}

/// The scene that the study in a file runs.
fn scene_of(file: &Path, study: &Study, within: Option<&Arc<Within>>) -> Result<Input, Failure> {
    let scene = Input::read(&study.scene, within)?;
    if !file::is_study(&scene.text) {
        return Ok(scene);
    }
    let named = study.scene.display();
    let failure = Failure::input(format!(
        "{}: study.scene: {named} is a study, not a scene",
        file.display()
    ));
    Err(
        failure.with_help(match file::parse(&study.scene, &scene.text) {
            // A study that names itself.
            Ok(inner) if inner.scene != study.scene => format!(
                "name the scene of that study, {}, and add the values here",
                inner.scene.display()
            ),
            _ => "name a scene, with [time], [domain] and [materials]".to_owned(),
        }),
    )
}

/// Gives each point of the study the seeds of the command line.
fn repeat(study: &mut Study, mut seeds: Seeds, errors: &[String]) -> Outcome {
    if study.seeds.is_some() {
        let failure = Failure::input("--seeds: the study says itself how many seeds a point has");
        return Err(failure.with_help("change `seeds` in its file"));
    }
    for text in errors {
        let (name, error) = text.split_once('=').ok_or_else(|| {
            Failure::input(format!(
                "--error {text}: expected NAME=ERROR, for example slope=2%"
            ))
        })?;
        let until = seeds.until(name.trim(), error, &study.results);
        until.map_err(|problem| Failure::input(format!("--error {text}: {problem}")))?;
    }
    if seeds.least != seeds.most && errors.is_empty() {
        let failure = Failure::input(format!(
            "--seeds {}..{}: needs --error, from which the number of seeds follows",
            seeds.least, seeds.most
        ));
        return Err(failure.with_help(
            "--error NAME=2%, with the name of a --result; or a fixed number, --seeds 8",
        ));
    }
    study.repeat(seeds, "--seeds").map_err(Failure::input)
}

fn swept(scene: &Path, arguments: &[String]) -> Result<Study, Failure> {
    let mut sweeps = Vec::new();
    for text in arguments {
        let sweep = Sweep::parse(text);
        sweeps.push(sweep.map_err(|problem| {
            Failure::input(format!("--sweep {text}: {problem}"))
                .with_help("for example --sweep materials.glass.tangential.friction=0.1,0.3,0.5")
        })?);
    }
    let (keys, runs) = match sweeps.is_empty() {
        true => (Vec::new(), vec![StudyRun::as_it_is()]),
        false => grid(&sweeps, "--sweep").map_err(Failure::input)?,
    };
    let stem = stem(scene);
    Ok(Study {
        scene: scene.to_owned(),
        folder: PathBuf::from(format!("{stem}-study")),
        set: Vec::new(),
        title: String::new(),
        units: vec![String::new(); keys.len()],
        keys,
        runs,
        results: Vec::new(),
        seeds: None,
        plots: Vec::new(),
        jobs: None,
        threads: None,
    })
}

/// Runs what is not finished yet, and writes table and plots.
///
/// `waiting`: shows the tasks of this `stage`, and ends the program as long as no run has begun. `leader`: of the ranks that make each run together,
/// where there are several.
pub(crate) fn execute(
    asked: &Asked,
    arguments: &Arguments,
    requests: Option<Requests>,
    task_progress: &TaskProgress,
    waiting: Waiting,
    leader: Option<Leader>,
) -> Outcome {
    let mut study = asked.study.clone();
    let jobs = match leader {
        Some(_) => 1,
        None => jobs(&study),
    };
    let (prefix, needs) = check(asked, &mut study, jobs)?;
    let study = &study;
    if !arguments.force {
        earlier_rows(study, &prefix)?;
    }
    // From here on runs may have something to keep.
    task_progress.begin(Task::Stepping);
    drop(waiting);
    let Some(requests) = requests else {
        if arguments.json {
            return say_object(&as_json(study, &needs));
        }
        let (of_point, certain) = (study.runs_of_point(), study.certain_runs_of_point());
        let points = study.runs.len() / of_point;
        let most = match certain < of_point {
            true => format!(", {} at most", points * of_point),
            false => String::new(),
        };
        let mut text = format!(
            "{}{most} in {}:",
            counted(points * certain, "run"),
            study.folder.display()
        );
        for (number, run) in study.runs.iter().enumerate() {
            if number % of_point < certain {
                text += &format!("\n  {}", run.name);
            }
        }
        return say(&format!(
            "{text}\nall can be run, {jobs} at a time; nothing was run"
        ));
    };
    folder::make(&study.folder).map_err(unusable)?;
    // Two tables in one file would be neither's.
    let lock_file = cli::Temporary::new(&study.folder.join(folder::LOCK));
    let lock = folder::take(&study.folder).map_err(Failure::input)?;
    // Again, now that no other process can write it.
    let earlier = if arguments.force {
        earlier::remove(&study.folder).map_err(Failure::run)?;
        earlier::Rows::new()
    } else {
        earlier_rows(study, &prefix)?
    };
    earlier::write_record(study, &prefix).map_err(Failure::run)?;
    let work = Work {
        asked,
        study,
        arguments,
        prefix: &prefix,
        earlier: &earlier,
        requests,
        leader,
        begun: Instant::now(),
        board: Mutex::new(Board {
            states: (0..study.runs.len())
                .map(
                    |run| match run % study.runs_of_point() < study.certain_runs_of_point() {
                        true => State::Waiting,
                        false => State::Spare,
                    },
                )
                .collect(),
            begun: vec![false; study.runs.len()],
            shares: vec![0.0; study.runs.len()],
            taken_up: vec![None; study.runs.len()],
            found: 0,
            line: cli::Progress::in_logs_too(arguments.quiet),
        }),
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| work.take_runs());
        }
    });
    let requests = work.requests;
    let mut board = work
        .board
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    board.line.clear();
    let outcome = conclude(study, &prefix, &earlier, &board, arguments, &requests);
    drop(lock);
    drop(lock_file);
    outcome
}

/// The runs, their costs, and the requested results.
fn as_json(study: &Study, needs: &[Needs]) -> Value {
    let runs: Vec<Value> = (study.runs.iter().zip(needs))
        .map(|(run, needs)| {
            json!({
                "name": run.name,
                "set": study.overrides(run),
                "steps": needs.steps,
                "memory": needs.memory,
                "disk": needs.disk,
            })
        })
        .collect();
    let results: serde_json::Map<String, Value> = (study.results.iter())
        .map(|result| (result.name.clone(), result.text().into()))
        .collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "study": {
            "scene": study.scene.display().to_string(),
            "title": study.title,
            "folder": study.folder.display().to_string(),
            "keys": study.keys,
            "set": study.set,
            "runs": runs,
            "results": results,
            "plots": study.plots,
        },
    })
}

/// Runs at a time: as many as the machine has processors for, and as there are runs.
fn jobs(study: &Study) -> usize {
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = study.threads.map_or(1, usize::from);
    let jobs = study.jobs.map_or((available / threads).max(1), usize::from);
    jobs.min(study.runs.len())
}

/// The cost of a run.
#[derive(Debug, Clone)]
struct Needs {
    steps: u64,
    /// Largest memory, bytes.
    memory: f64,
    /// Size of all files, bytes.
    disk: f64,
}

/// Checks that every run can be planned, and fits into the memory beside the others; the scene gives the units of the study's
/// values. Returns the prefix of the names of the runs' files, and the cost of each run.
fn check(asked: &Asked, study: &mut Study, jobs: usize) -> Result<(String, Vec<Needs>), Failure> {
    let (mut reported, mut problems) = (String::new(), Vec::new());
    let mut needs: Vec<Needs> = Vec::new();
    let (mut refused, mut prefix) = (0, String::new());
    let of_point = asked.study.runs_of_point();
    for (number, run) in asked.study.runs.iter().enumerate() {
        // The seeds of a point cost the same.
        if number % of_point > 0 && needs.len() == number {
            needs.push(needs[number - 1].clone());
            for k in 0..study.keys.len() - 1 {
                let settled = study.runs[number - 1].settled[k].clone();
                study.runs[number].settled[k] = settled;
            }
            continue;
        }
        if number % of_point > 0 {
            continue;
        }
        match planned(asked, run, jobs, asked.any_memory) {
            Ok((plan, memory, scene)) => {
                needs.push(Needs {
                    steps: plan.physics().steps,
                    memory: memory.most.round(),
                    disk: Disk::of(&plan).bytes.round(),
                });
                study.settle(number, &scene);
                plan.outputs().prefix().clone_into(&mut prefix);
                check_results(&study.results, &plan)?;
            }
            Err(why) => {
                refused += 1;
                if refused <= MOST_TOLD {
                    reported += &format!("run `{}`:\n{}\n", run.name, why.message.trim_end());
                }
                // An error of the scene itself occurs in every run.
                let found = why.problems().unwrap_or_default();
                problems.extend(
                    found
                        .into_iter()
                        .filter(|one| !problems.contains(one))
                        .collect::<Vec<_>>(),
                );
            }
        }
    }
    if refused == 0 {
        return Ok((prefix, needs));
    }
    if refused > MOST_TOLD {
        reported += &format!("and {} more\n", refused - MOST_TOLD);
    }
    let runs = counted(study.runs.len(), "run");
    Err(Failure::input(format!(
        "{reported}{refused} of {runs} cannot be run; no run of the study was begun"
    ))
    .with_problems(problems))
}

/// A plan, its memory and its scene.
type Planned = (Plan, crate::plan::Memory, Scene);

fn planned(
    asked: &Asked,
    run: &StudyRun,
    jobs: usize,
    any_memory: bool,
) -> Result<Planned, Failure> {
    let scene = asked.scene.scene(&asked.study.overrides(run))?;
    let mut limit = machine::memory_for(asked.ranks.here).filter(|_| !any_memory);
    if let Some(limit) = &mut limit {
        limit.total /= jobs as f64;
    }
    let planned = plan_of_ranks(&scene, limit, asked.ranks);
    let (plan, memory) = planned.map_err(|errors| refused(&errors))?;
    results::requested(&scene, &plan).map_err(|errors| refused(&errors))?;
    if let Some(limit) = limit {
        check_fit(&scene, &plan, &memory, limit).map_err(|error| {
            let text = format!(
                "{error}\n{jobs} runs at a time share the memory: --jobs 1 leaves all of it to one"
            );
            Failure::input(text).with_problems(vec![Problem::from(&error)])
        })?;
    }
    Ok((plan, memory, scene))
}

/// Refuses results that a run of this plan will not have.
pub(crate) fn check_results(results: &[NamedResult], plan: &Plan) -> Outcome {
    for result in results {
        let checked = result.check(plan);
        checked
            .map_err(|problem| Failure::input(format!("result `{}`: {problem}", result.name)))?;
    }
    Ok(())
}

/// How far all runs are.
struct Board {
    states: Vec<State>,
    /// Whether each run was begun here.
    begun: Vec<bool>,
    /// Share of each run that is done, from 0 to 1.
    shares: Vec<f64>,
    /// The finished share of each run when this process first read it.
    taken_up: Vec<Option<f64>>,
    /// Runs that were finished before.
    found: usize,
    line: cli::Progress,
}

/// Data that the running threads share.
struct Work<'a> {
    asked: &'a Asked,
    study: &'a Study,
    arguments: &'a Arguments,
    prefix: &'a str,
    /// Rows of the table that was there.
    earlier: &'a earlier::Rows,
    requests: Requests,
    leader: Option<Leader>,
    begun: Instant,
    board: Mutex<Board>,
}

impl Work<'_> {
    /// Takes one run after the other until there is none left, or the study is stopped.
    fn take_runs(&self) {
        loop {
            if self.requests.stop.load(Ordering::Relaxed)
                || self.time_left() == Some(Duration::ZERO)
            {
                return;
            }
            let Some(number) = self.next_run() else {
                return;
            };
            let run = &self.study.runs[number];
            let (state, was_there) = match self.run(number, run) {
                Ok(None) => (State::Finished, true),
                Ok(Some(Status::Finished)) => (State::Finished, false),
                Ok(Some(Status::Stopped)) => (State::Stopped, false),
                Err(failure) if failure.exit == Exit::Resumable => (State::Stopped, false),
                Err(failure) => (State::Failed(failure.message), false),
            };
            let mut board = self.board();
            board.states[number] = state;
            board.shares[number] = 1.0;
            board.taken_up[number].get_or_insert(if was_there { 1.0 } else { 0.0 });
            board.found += usize::from(was_there);
            // The table can be read while the other runs go on; if it cannot be written, this is reported at the end.
            if !was_there {
                let _ = write_table(self.study, &board.states, self.prefix, self.earlier);
            }
        }
    }

    /// Begins the next run that is needed.
    fn next_run(&self) -> Option<usize> {
        let mut board = self.board();
        let table = || StudyTable::of(self.study, &board.states, self.prefix, self.earlier);
        let next = self.study.next_run(&board.begun, table)?;
        board.begun[next] = true;
        if board.states[next] == State::Spare {
            board.states[next] = State::Waiting;
        }
        Some(next)
    }

    fn board(&self) -> std::sync::MutexGuard<'_, Board> {
        self.board
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn time_left(&self) -> Option<Duration> {
        let limit = self.arguments.time_limit?;
        Some(limit.saturating_sub(self.begun.elapsed()))
    }

    /// Runs it, resumes it, or finds that it has ended.
    fn run(&self, number: usize, studied: &StudyRun) -> Result<Option<Status>, Failure> {
        let (plan, _, scene) = planned(self.asked, studied, 1, true)?;
        // The files of a run do not depend on the number of ranks.
        let memory = run::memory(&plan);
        let (results, until) =
            results::requested(&scene, &plan).map_err(|errors| refused(&errors))?;
        let share = (self.leader.as_ref())
            .map(|leader| leader.share(number, ranks::digest(&scene.statement)))
            .transpose()?;
        let threads = self.leader.as_ref().map_or(1, Leader::threads);
        let how = How {
            ranks: Arc::new(Mutex::new(share)),
            folder: Some(self.study.folder.join(&studied.name)),
            within: self.asked.within.clone(),
            progress: None,
            results,
            until,
            earlier: match self.arguments.force {
                true => Earlier::Replace,
                false => Earlier::Continue,
            },
            threads: self.study.threads.or(u16::try_from(threads).ok()),
            fixed_threads: self.arguments.fixed_threads,
            width: self.arguments.lanes,
            time_limit: self.time_left(),
            // The end of each run is read from its checkpoint.
            checkpoint_every: Some(
                self.arguments
                    .checkpoint_every
                    .0
                    .unwrap_or(Duration::from_secs(600)),
            ),
            quiet: true,
            typed: self.arguments.typed.clone(),
        };
        let mut seen = Instant::now();
        let mut tell = |progress: &crate::run::Progress<'_>| {
            if seen.elapsed() > Duration::from_millis(200) {
                seen = Instant::now();
                self.tell(number, progress.share());
            }
        };
        let ran = run_plan(
            &how,
            plan,
            &memory,
            Stated {
                input: &self.asked.scene,
                set: &self.study.overrides(studied),
                scene: &scene,
                branch: None,
            },
            self.requests.clone(),
            &self.requests.task_progress(),
            &mut tell,
        )?;
        Ok(match ran {
            Ran::Now(report) => Some(report.summary.status),
            Ran::Before { .. } => None,
        })
    }

    fn tell(&self, number: usize, share: f64) {
        let mut board = self.board();
        board.shares[number] = share;
        board.taken_up[number].get_or_insert(share);
        let is_needed = |state: &&State| **state != State::Spare;
        let needed = board.states.iter().filter(is_needed).count();
        let all = board.shares.iter().sum::<f64>() / needed as f64;
        let done = (board.states.iter())
            .filter(|state| !matches!(state, State::Waiting | State::Spare))
            .count();
        let text = format!(
            "{done} of {} done, `{}` at {:.0} %",
            counted(needed, "run"),
            self.study.runs[number].name,
            100.0 * share
        );
        let ahead = needed as f64 - board.shares.iter().sum::<f64>();
        let left = left(self.begun.elapsed(), &board.shares, &board.taken_up, ahead);
        board.line.share_left(all, left, || text);
    }
}

/// Estimate of the remaining seconds, at the speed of the work done in this process; runs that were finished, or half done,
/// before do not count. `ahead`: runs that are left.
fn left(since: Duration, shares: &[f64], taken_up: &[Option<f64>], ahead: f64) -> f64 {
    let done = shares.iter().zip(taken_up);
    let done: f64 = done
        .map(|(share, first)| share - first.unwrap_or(*share))
        .sum();
    since.as_secs_f64() * ahead / done.max(1e-9)
}

/// The finished rows of the table that is there, which must be this study's.
fn earlier_rows(study: &Study, prefix: &str) -> Result<earlier::Rows, Failure> {
    earlier::rows(study, prefix).map_err(|problem| {
        Failure::input(problem).with_help(
            "--output OTHER writes this study elsewhere; --force removes that table and its plots, and runs all anew",
        )
    })
}

fn write_table(
    study: &Study,
    states: &[State],
    prefix: &str,
    earlier: &earlier::Rows,
) -> Result<StudyTable, Failure> {
    let table = StudyTable::of(study, states, prefix, earlier);
    write_whole(&study.folder.join(FILE), table.csv().as_bytes()).map_err(Failure::run)?;
    Ok(table)
}

/// Writes table and plots, reports how all runs ended, and returns the exit code.
fn conclude(
    study: &Study,
    prefix: &str,
    earlier: &earlier::Rows,
    board: &Board,
    arguments: &Arguments,
    requests: &Requests,
) -> Outcome {
    let table = write_table(study, &board.states, prefix, earlier)?;
    let count =
        |wanted: &dyn Fn(&State) -> bool| board.states.iter().filter(|state| wanted(state)).count();
    let finished = count(&|state| *state == State::Finished);
    let waiting = count(&|state| matches!(state, State::Stopped | State::Waiting));
    let spare = count(&|state| *state == State::Spare);
    let mut files = vec![FILE.to_owned()];
    let mut problems = table.problems.clone();
    let means = study.means(&table);
    for (name, points) in [
        (MEANS, means.as_ref()),
        (DIFFERENCES, study.differences(&table).as_ref()),
    ] {
        if let Some(points) = points {
            write_whole(&study.folder.join(name), points.csv().as_bytes()).map_err(Failure::run)?;
            problems.extend(points.problems.iter().cloned());
            files.push(name.to_owned());
        }
    }
    let counted_rows = study.counted_rows(&table);
    let columns = match study.plots.is_empty() {
        true => study
            .results
            .iter()
            .map(|result| result.name.clone())
            .collect(),
        false => study.plots.clone(),
    };
    // Without a finished run there are no columns to draw; the report of the runs shows it.
    let drawn = if table.has_finished() {
        columns
    } else {
        Vec::new()
    };
    for column in drawn {
        match plot::page(study, &counted_rows, &column) {
            Ok(page) => {
                let stem = format!("study.{column}");
                page.write(&study.folder.join(&stem))
                    .map_err(Failure::run)?;
                files.extend([format!("{stem}.svg"), format!("{stem}.png")]);
            }
            Err(problem) => problems.push(format!("plot of `{column}`: {problem}")),
        }
    }
    if arguments.json {
        let mut answer = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "folder": study.folder.display().to_string(),
            "files": files,
            "units": table.units(),
            "rows": table.objects(),
        });
        if let Some(means) = &means {
            answer["means"] = means.objects().into();
        }
        say_object(&answer)?;
    } else if !arguments.quiet {
        let before = match board.found {
            0 => String::new(),
            found => format!(" ({found} before)"),
        };
        let runs = counted(board.states.len() - spare, "run");
        say(&format!(
            "{finished} of {runs} finished{before}\n  files      {}: {}",
            study.folder.display(),
            files.join(" ")
        ))?;
    }
    for problem in &problems {
        eprintln!("warning: {problem}");
    }
    let mut reported = String::new();
    let failed = study.runs.iter().zip(&board.states);
    let failed = failed.filter_map(|(run, state)| match state {
        State::Failed(why) => Some((run, why)),
        _ => None,
    });
    let failed: Vec<_> = failed.collect();
    for (run, why) in failed.iter().take(MOST_TOLD) {
        reported += &format!("run `{}`:\n{}\n", run.name, why.trim_end());
    }
    if failed.len() > MOST_TOLD {
        reported += &format!("and {} more, see {FILE}\n", failed.len() - MOST_TOLD);
    }
    if waiting > 0 {
        use Ordering::Relaxed;
        let by = if requests.stop.load(Relaxed) {
            "stopped"
        } else {
            "stopped by the time limit"
        };
        let what = format!(
            "{reported}{by}: {waiting} of {} to go on with\nhelp: the same command goes on where it was stopped",
            counted(board.states.len() - spare, "run")
        );
        return Err(ended(Failure::new(Exit::Resumable, what), arguments));
    }
    if failed.is_empty() {
        return Ok(());
    }
    let all = counted(board.states.len() - spare, "run");
    let what = format!(
        "{reported}{} of {all} failed\nhelp: the same command tries them again; --force runs all anew",
        failed.len()
    );
    Err(ended(Failure::run(what), arguments))
}

/// The end of a study whose table was already reported, if it was.
fn ended(failure: Failure, arguments: &Arguments) -> Failure {
    match arguments.json {
        true => failure.answered(),
        false => failure,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_of_a_study_is_that_of_what_was_done_here() {
        // Of four runs one was there, one is taken up at half and now at three quarters, one at a quarter, one waits: half a run in 10 s, two to go.
        let shares = [1.0, 0.75, 0.25, 0.0];
        let taken_up = [Some(1.0), Some(0.5), Some(0.0), None];
        assert_eq!(left(Duration::from_secs(10), &shares, &taken_up, 2.0), 40.0);
    }
}
