//! One scene from the command line: its meaning, or its run with all messages.

use std::io::IsTerminal as _;
use std::path::Path;
use std::sync::Arc;

use mercury_common::cli::{self, Failure, Outcome, say};
use mercury_common::machine;
use mercury_common::readable::rounded;
use mercury_common::scene::SceneErrors;
use mercury_common::whole_file::write_whole;
use mercury_common::within::Within;
use mercury_engine::task::TaskProgress;
use mercury_solver::output::summary::Status;
use mercury_solver::results::{Aims, NamedResult, requested};
use mercury_solver::run::{Branch, Progress, Report, check_fit, plan_within};
use serde_json::Value;

use super::input::{Input, refused};
use super::progress::ProgressFile;
use super::run::{How, Ran, Requests, Stated, not_branched, run_plan};
use super::waiting::{BeforeEnd, Waiting};
use super::{check, problems, study};
use crate::Arguments;

/// Executes the command line: a scene is checked or run, and so is a study.
pub(crate) fn execute(arguments: &Arguments, path: &Path, within: Option<Arc<Within>>) -> Outcome {
    // From the very beginning of a run, so that no request comes too early; a command that only prints may be ended at any time.
    let requests = match arguments.check {
        true => None,
        false => Some(Requests::listen()?),
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
) -> Result<Option<Report>, Failure> {
    let quiet = arguments.quiet || (arguments.check && arguments.json);
    let stop = (requests.as_ref()).map(|requests| (&requests.stop, before_end(progress.clone())));
    let waiting = Waiting::begin(task_progress, stop, quiet)?;
    let branch = match (&arguments.from, arguments.at) {
        (Some(run), Some(at)) => {
            Some(Branch::plan(run, at, &arguments.set).map_err(|error| not_branched(&error))?)
        }
        _ => None,
    };
    let set = (branch.as_ref()).map_or(&arguments.set, |branch| &branch.input.set);
    let input = match (&branch, path == Path::new("-")) {
        (Some(branch), _) => Input::of_run(&branch.input),
        (None, true) => {
            if std::io::stdin().is_terminal() && !arguments.quiet {
                eprintln!("reading the scene from standard input");
            }
            Input::of_standard_input(within.as_ref())?
        }
        (None, false) => Input::read(path, within.as_ref())?,
    };
    if branch.is_none()
        && let Some(requested) = study::requested(&input, arguments, within.as_ref())?
    {
        study::execute(&requested, arguments, requests, task_progress, waiting)?;
        return Ok(None);
    }
    let scene = input.scene(set)?;
    let machine = machine::memory();
    let limit = machine.filter(|_| !arguments.force_memory);
    let (plan, memory) = plan_within(&scene, limit).map_err(|errors| refused(&errors))?;
    let (mut results, until) = requested(&scene, &plan).map_err(|errors| refused(&errors))?;
    let more = arguments.results()?;
    study::check_results(&more, &plan)?;
    // One of the command line replaces that of the scene.
    results.retain(|result| more.iter().all(|other| other.name != result.name));
    results.extend(more);
    let Some(requests) = requests else {
        drop(waiting);
        let ends = until.as_ref().map(Aims::lines);
        let named = lines_of(&results, ends.unwrap_or_default());
        check::execute(arguments, &input, &scene, plan, &memory, machine, &named)?;
        return Ok(None);
    };
    if let Some(limit) = limit {
        let fit = check_fit(&scene, &plan, &memory, limit);
        fit.map_err(|error| refused(&SceneErrors(vec![error])))?;
    }
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
        ..arguments.how()
    };
    let prefix = plan.outputs().prefix().to_owned();
    let stated = Stated {
        input: &input,
        set,
        scene: &scene,
        branch: branch.as_ref(),
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

/// The section of the results in the report of a plan; empty where there are none.
fn lines_of(results: &[NamedResult], ends: Vec<[String; 2]>) -> String {
    let of = |result: &NamedResult| {
        let unit = match result.unit().as_str() {
            "1" => String::new(),
            unit => format!(", {unit}"),
        };
        [result.name.clone(), format!("{}{unit}", result.text())]
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
