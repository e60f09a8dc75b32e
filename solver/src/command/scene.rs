//! One scene from the command line: its meaning, or its run with all messages.

use std::io::IsTerminal as _;
use std::path::Path;
use std::sync::{Arc, Mutex};

use crate::output::summary::Status;
use crate::plan::{Memory, Plan};
use crate::results::{Aims, NamedResult, PlannedRows, requested};
use crate::run::{self, Branch, Progress, RanksHere, Report, check_fit, plan_of_ranks};
use mercury_common::cli::{self, Failure, Outcome, say};
use mercury_common::machine;
use mercury_common::readable::rounded;
use mercury_common::scene::{Scene, SceneErrors};
use mercury_common::whole_file::write_whole;
use mercury_common::within::Within;
use mercury_engine::step::StartOptions;
use mercury_engine::task::TaskProgress;
use serde_json::Value;

use super::Arguments;
use super::input::{Input, refused};
use super::progress::ProgressFile;
use super::ranks::{self, Job, Leader, Team};
use super::run::{How, Ran, Requests, Stated, not_branched, run_plan};
use super::waiting::{BeforeEnd, Waiting};
use super::{check, problems, study};

/// Executes the command line: a scene is checked or run, and so is a study.
pub(crate) fn execute(arguments: &Arguments, path: &Path, within: Option<Arc<Within>>) -> Outcome {
    // From the very beginning of a run, so that no request comes too early; a command that only prints may be ended at any time.
    let requests = match arguments.check {
        true => None,
        false => Some(Requests::listen()?),
    };
    let mut checked = None;
    let team = match (&requests, Job::join()?) {
        (_, Job::Alone) => None,
        (_, Job::Silent) => return Ok(()),
        // A command that only prints needs one process.
        (None, Job::Rank(team)) if !team.is_first() => return Ok(()),
        (None, Job::Rank(team)) => {
            checked = Some(team.here);
            None
        }
        (Some(_), Job::Rank(team)) if team.is_first() => Some(team),
        (Some(_), Job::Rank(team)) => return follow(arguments, path, within, &team),
    };
    let progress = ProgressFile::requested(arguments.progress.as_deref(), path)?;
    let task_progress = match (&requests, &progress) {
        (Some(requests), Some((progress, _))) => requests.observed_progress(progress.events()),
        (Some(requests), None) => requests.task_progress(),
        (None, _) => Arc::default(),
    };
    let progress = match progress {
        Some((progress, events)) => {
            progress.watch(&task_progress, events)?;
            Some(Arc::new(progress))
        }
        None => None,
    };
    let outcome = plan_and_run(
        arguments,
        path,
        within,
        requests,
        &task_progress,
        progress.clone(),
        (team, checked),
    );
    if let Some(progress) = progress {
        progress.end(outcome.as_ref().map(Option::as_ref));
    }
    let Some(report) = outcome? else {
        return Ok(());
    };
    match report.summary.status {
        Status::Finished => Ok(()),
        Status::Stopped => {
            let time = rounded(report.summary.time, 12);
            let what = format!("stopped at t = {time} s, with a checkpoint");
            let failure = Failure::new(cli::Exit::Resumable, what);
            Err(failure.with_help("--resume goes on from there").answered())
        }
    }
}

/// The result of a run; `None` if there was none.
fn plan_and_run(
    arguments: &Arguments,
    path: &Path,
    within: Option<Arc<Within>>,
    requests: Option<Requests>,
    task_progress: &Arc<TaskProgress>,
    progress: Option<Arc<ProgressFile>>,
    (team, checked): (Option<Box<Team>>, Option<RanksHere>),
) -> Result<Option<Report>, Failure> {
    let quiet = arguments.quiet || (arguments.check && arguments.json);
    let stop = (requests.as_ref()).map(|requests| (&requests.stop, before_end(progress.clone())));
    let waiting = Waiting::begin(task_progress, stop, quiet)?;
    let ranks = team.as_ref().map(|team| team.here);
    let here = checked.or(ranks).unwrap_or(RanksHere::ALONE);
    let prepared = prepared(arguments, path, within.as_ref(), (ranks.is_some(), here));
    if let Some(team) = &team {
        // Its own reason is the better one.
        team.agree(digest_of(&prepared))
            .or_else(|failure| match prepared.is_err() {
                true => Ok(()),
                false => Err(failure),
            })?;
    }
    let (input, scene, plan, memory, branch) = match prepared? {
        Prepared::Study(requested) => {
            let leader = team.map(Leader);
            study::execute(
                &requested,
                arguments,
                requests,
                task_progress,
                waiting,
                leader,
            )?;
            return Ok(None);
        }
        Prepared::Scene {
            input,
            scene,
            plan,
            memory,
            branch,
        } => (*input, *scene, *plan, memory, branch),
    };
    // Where a reason against the run is found from here on, the other ranks end with it.
    let share = team.as_ref().map(|team| team.share());
    if let Some(note) = team.as_ref().and_then(|team| team.idle(&memory))
        && !arguments.quiet
    {
        eprintln!("note: {note}");
    }
    let branch = branch.as_deref();
    let set = branch.map_or(&arguments.set, |branch| &branch.input.set);
    let machine = machine::memory_for(here.here);
    let (mut results, until) = requested(&scene, &plan).map_err(|errors| refused(&errors))?;
    let more = arguments.results()?;
    study::check_results(&more, &plan)?;
    // One of the command line replaces that of the scene.
    results.retain(|result| more.iter().all(|other| other.name != result.name));
    results.extend(more);
    let Some(requests) = requests else {
        drop(waiting);
        let ends = until.as_ref().map(Aims::lines);
        let mut named = lines_of(&results, &plan, ends.unwrap_or_default());
        named += &checked.map_or_else(String::new, |here| ranks::planned(here, &memory));
        let few = few_rows(&results, &plan);
        let said = (named.as_str(), few);
        check::execute(arguments, &input, &scene, plan, &memory, machine, said)?;
        return Ok(None);
    };
    let threads = team.as_ref().map(|team| team.threads());
    let mut line = cli::Progress::in_logs_too(arguments.quiet);
    let mut tell = |now: &Progress<'_>| {
        if let Some(progress) = &progress {
            progress.note(now);
        }
        line.share_left(now.share(), now.left, || reported(now));
    };
    let how = How {
        within,
        progress: progress.clone(),
        results,
        until,
        ranks: Arc::new(Mutex::new(share)),
        ..arguments.how()
    };
    let how = match threads {
        Some(threads) if how.threads.is_none() => How {
            threads: u16::try_from(threads).ok(),
            ..how
        },
        _ => how,
    };
    let prefix = plan.outputs().prefix().to_owned();
    let stated = Stated {
        input: &input,
        set,
        scene: &scene,
        branch,
    };
    let result = run_plan(
        &how,
        plan,
        &memory,
        stated,
        requests,
        task_progress,
        &mut tell,
    );
    line.clear();
    drop(waiting);
    match result? {
        Ran::Now(report) => {
            if arguments.json {
                say(&serde_json::to_string_pretty(&report.summary).map_err(Failure::run)?)?;
            } else if !arguments.quiet {
                say(&report.to_string())?;
            }
            Ok(Some(*report))
        }
        Ran::Before { folder, time } => {
            let summary = kept_summary(&folder, &prefix, &how.results);
            if arguments.json {
                say(&summary?)?;
            } else if !arguments.quiet {
                say(&format!(
                    "{}: the run has come to its end at t = {} s already; a larger time.end makes it longer",
                    folder.display(),
                    rounded(time, 12)
                ))?;
            }
            Ok(None)
        }
    }
}

/// A scene or a study that was read.
enum Prepared {
    Scene {
        input: Box<Input>,
        scene: Box<Scene>,
        plan: Box<Plan>,
        memory: Memory,
        /// The branch that it is, if it is one.
        branch: Option<Box<Branch>>,
    },
    Study(Box<study::Asked>),
}

/// Reads the scene and makes its plan.
fn prepared(
    arguments: &Arguments,
    path: &Path,
    within: Option<&Arc<Within>>,
    (is_divided, here): (bool, RanksHere),
) -> Result<Prepared, Failure> {
    let branch = match (&arguments.from, arguments.at) {
        (Some(run), Some(at)) => {
            Some(Branch::plan(run, at, &arguments.set).map_err(|error| not_branched(&error))?)
        }
        _ => None,
    };
    let set = (branch.as_ref()).map_or(&arguments.set, |branch| &branch.input.set);
    let input = match (&branch, path == Path::new("-")) {
        (Some(branch), _) => Input::of_run(&branch.input),
        (None, true) if is_divided => {
            return Err(
                Failure::input("several ranks cannot read the scene from standard input")
                    .with_help("put it into a file that all of them can read"),
            );
        }
        (None, true) => {
            if std::io::stdin().is_terminal() && !arguments.quiet {
                eprintln!("reading the scene from standard input");
            }
            Input::of_standard_input(within)?
        }
        (None, false) => Input::read(path, within)?,
    };
    if branch.is_none()
        && let Some(requested) = study::requested(&input, arguments, within, here)?
    {
        if is_divided && requested.has_jobs() {
            return Err(Failure::input(
                "several ranks make each run of a study together, so one run is made at a time",
            )
            .with_help("leave out --jobs or `jobs`, or start the study without mpirun or srun"));
        }
        return Ok(Prepared::Study(Box::new(requested)));
    }
    let scene = input.scene(set)?;
    let limit = machine::memory_for(here.here).filter(|_| !arguments.force_memory);
    let planned = plan_of_ranks(&scene, limit, here);
    let (plan, mut memory) = planned.map_err(|errors| refused(&errors))?;
    // The report of a plan that does not fit is printed before the error.
    if let Some(limit) = limit.filter(|_| !arguments.check) {
        let fit = check_fit(&scene, &plan, &memory, limit);
        fit.map_err(|error| refused(&SceneErrors(vec![error])))?;
    }
    if is_divided {
        // The files of a run do not depend on the number of ranks.
        memory = run::memory(&plan);
    }
    Ok(Prepared::Scene {
        input: Box::new(input),
        scene: Box::new(scene),
        plan: Box::new(plan),
        memory,
        branch: branch.map(Box::new),
    })
}

/// By what the ranks see that they run the same, or the reason why this one cannot.
fn digest_of(prepared: &Result<Prepared, Failure>) -> Result<String, String> {
    match prepared {
        Ok(Prepared::Scene { scene, .. }) => ranks::digest(&scene.statement),
        Ok(Prepared::Study(requested)) => Ok(requested.digest()),
        Err(failure) => Err(failure.message.clone()),
    }
}

/// On a rank that is not the first: makes the run with it. The first rank reports, and its exit code counts.
fn follow(arguments: &Arguments, path: &Path, within: Option<Arc<Within>>, team: &Team) -> Outcome {
    let prepared = prepared(arguments, path, within.as_ref(), (true, team.here));
    let agreed = team.agree(digest_of(&prepared));
    let how = arguments.how();
    let threads = how.threads.map_or_else(|| team.threads(), usize::from);
    let options = || {
        let parts = arguments.fail_at.map(|step| team.failing(step));
        StartOptions::threads(threads)
            .width(how.width)
            .parts(parts.into_iter().flatten().collect())
    };
    match (agreed, prepared) {
        (Ok(()), Ok(Prepared::Scene { plan, .. })) => team.follow(*plan, options()),
        (Ok(()), Ok(Prepared::Study(requested))) => {
            while let Some(run) = team.next_run() {
                let planned = requested.planned(run);
                let digest = match &planned {
                    Ok((_, scene)) => ranks::digest(&scene.statement),
                    Err(failure) => Err(failure.message.clone()),
                };
                if let (Ok(()), Ok((plan, _))) = (team.agree(digest), planned) {
                    team.follow(plan, options());
                }
            }
        }
        _ => {}
    }
    Ok(())
}

/// The section of the results in the report of a plan; empty where there are none.
fn lines_of(results: &[NamedResult], plan: &Plan, ends: Vec<[String; 2]>) -> String {
    let of = |result: &NamedResult| {
        let unit = match result.unit().as_str() {
            "1" => String::new(),
            unit => format!(", {unit}"),
        };
        let every = PlannedRows::of(result, plan).map_or_else(String::new, |rows| {
            format!(", a row every {} s", rounded(rows.interval(), 6))
        });
        [
            result.name.clone(),
            format!("{}{unit}{every}", result.text()),
        ]
    };
    let lines: Vec<[String; 2]> = results.iter().map(of).chain(ends).collect();
    let lines: String = (lines.iter())
        .map(|[name, text]| format!("\n  {name:<23} {text}"))
        .collect();
    match lines.is_empty() {
        true => lines,
        false => format!("\nResults{lines}"),
    }
}

/// Warnings of results whose windows have few rows.
fn few_rows(results: &[NamedResult], plan: &Plan) -> Vec<String> {
    let warning = |result: &NamedResult| {
        let warning = PlannedRows::of(result, plan)?.warning()?;
        Some(format!("results.{}: {warning}", result.name))
    };
    results.iter().filter_map(warning).collect()
}

/// The summary that a finished run left in its folder, with results that are requested now.
fn kept_summary(folder: &Path, prefix: &str, results: &[NamedResult]) -> Result<String, Failure> {
    let path = folder.join("summary.json");
    let failed = |error: String| Failure::run(format!("{}: {error}", path.display()));
    let text = std::fs::read_to_string(&path)
        .map_err(|error| failed(format!("the file cannot be read: {error}")))?;
    if results.is_empty() {
        return Ok(text);
    }
    let mut summary: Value =
        serde_json::from_str(&text).map_err(|error| failed(error.to_string()))?;
    for result in results {
        let value =
            serde_json::to_value(result.read(folder, prefix, None)).map_err(Failure::run)?;
        summary["results"][&result.name] = value;
    }
    let text = serde_json::to_string_pretty(&summary).map_err(Failure::run)? + "\n";
    write_whole(&path, text.as_bytes()).map_err(Failure::run)?;
    Ok(text)
}

/// A run that is stopped before its first step is reported to programs, too.
fn before_end(progress: Option<Arc<ProgressFile>>) -> BeforeEnd {
    Box::new(move |failure| {
        problems::tell(failure);
        if let Some(progress) = &progress {
            progress.end(Err(failure));
        }
    })
}

/// Progress line of a run.
fn reported(progress: &Progress<'_>) -> String {
    format!(
        "t = {:.4e} s  {} particles  {:.2e} particle-steps/s  Ekin {:.2e} J",
        progress.engine.time(),
        progress.engine.particles.grains(),
        progress.particle_steps as f64 / progress.seconds.max(1e-9),
        progress.kinetic_energy(),
    )
}
