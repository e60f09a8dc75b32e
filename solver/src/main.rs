//! `mercury-solve`: the command line, nothing else.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use mercury_common::cli::{self, Failure, Outcome, say};
use mercury_common::readable::rounded;
use mercury_common::scene::SceneErrors;
use mercury_solver::output::folder;
use mercury_solver::output::summary::Status;
use mercury_solver::plan::{Plan, document, plan, read_scene, refusal, report};
use mercury_solver::run::{Progress, Report, RunOptions, memory, run, useful_threads};

/// More threads than any machine has: a slip of the keyboard.
const MOST_THREADS: i64 = 1024;

const EXAMPLES: &str = "\
Examples:
  mercury-solve drum.toml                         run it; files in ./drum/
  mercury-solve drum.toml --check                 what the scene means; nothing is run
  mercury-solve drum.toml --set time.end=0.1 --set materials.glass.friction=0.3 --output short
  mercury-solve drum.toml --force --threads 4     replace an earlier run
  mercury-solve drum.toml --quiet --json          the summary as JSON, for scripts

Exit codes: 0 done, 1 the run failed or was stopped, 2 wrong usage or input.";

/// Runs a discrete particle simulation that a scene file describes.
#[derive(Debug, Parser)]
#[command(name = "mercury-solve", version, after_help = EXAMPLES)]
struct Arguments {
    /// The scene file
    #[arg(value_name = "SCENE.toml", required_unless_present = "completions")]
    scene: Option<PathBuf>,

    /// Folder for the files of the run [default: ./SCENE/]
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Replace the files of an earlier run in that folder
    #[arg(long)]
    force: bool,

    /// Print what the scene means (resolved parameters, time step and its reason) and stop
    #[arg(long)]
    check: bool,

    /// Threads; the results are the same with any number [default: what the machine has and the scene can use]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,

    /// Replace a key of the scene, for example time.end=0.1; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// No progress and no report, only errors
    #[arg(long)]
    quiet: bool,

    /// Print the summary (with --check: the plan) as one JSON object on standard output
    #[arg(long)]
    json: bool,

    /// Print completions for a shell and stop
    #[arg(long, value_name = "SHELL")]
    completions: Option<cli::Shell>,
}

fn main() -> ExitCode {
    cli::main(|arguments: Arguments| execute(&arguments))
}

fn execute(arguments: &Arguments) -> Outcome {
    if let Some(shell) = arguments.completions {
        return cli::say_completions::<Arguments>(shell);
    }
    // The argument is required without --completions.
    let path = arguments.scene.as_deref().unwrap_or(Path::new(""));
    let plan = planned(path, &arguments.set).map_err(|errors| Failure::input(refusal(&errors)))?;
    if arguments.check {
        return say(&if arguments.json {
            plan_as_json(&plan)?
        } else {
            report(&plan, &memory(&plan))
        });
    }
    let report = run_plan(arguments, plan)?;
    if arguments.json {
        let json = serde_json::to_string_pretty(&report.summary).map_err(Failure::run)?;
        say(&json)?;
    } else if !arguments.quiet {
        say(&report.to_string())?;
    }
    match report.summary.status {
        Status::Finished => Ok(()),
        Status::Stopped => Err(Failure::run(format!(
            "stopped at t = {} s; everything until then is written. This version cannot resume a run.",
            rounded(report.summary.time, 12)
        ))),
    }
}

fn planned(path: &Path, overrides: &[String]) -> Result<Plan, SceneErrors> {
    plan(&read_scene(path, overrides)?)
}

/// The content of `plan.toml`.
fn plan_as_toml(plan: &Plan) -> Result<String, Failure> {
    document(plan, &memory(plan))
        .map_err(|error| Failure::run(format!("the plan cannot be written: {error}")))
}

/// The content of `plan.toml` as JSON.
fn plan_as_json(plan: &Plan) -> Result<String, Failure> {
    let failed = |error: String| Failure::run(format!("the plan cannot be written: {error}"));
    let value: toml::Value =
        toml::from_str(&plan_as_toml(plan)?).map_err(|error| failed(error.to_string()))?;
    serde_json::to_string_pretty(&value).map_err(|error| failed(error.to_string()))
}

fn run_plan(arguments: &Arguments, plan: Plan) -> Result<Report, Failure> {
    let folder =
        (arguments.output.clone()).unwrap_or_else(|| PathBuf::from(plan.outputs().prefix()));
    // The folder is this run's until the end of the function.
    let _lock = folder::prepare(&folder, plan.outputs().prefix(), arguments.force)
        .map_err(Failure::input)?;
    let threads = arguments.threads.map_or_else(
        || {
            let available = std::thread::available_parallelism();
            useful_threads(&plan, available.map_or(1, Into::into))
        },
        usize::from,
    );
    let options = RunOptions {
        folder,
        threads,
        command_line: std::env::args().collect::<Vec<_>>().join(" "),
        plan_document: Some(plan_as_toml(&plan)?),
        stop: cli::stop_on_request()?,
    };
    let mut line = cli::Progress::in_logs_too(arguments.quiet);
    let result = run(plan, &options, &mut |progress| {
        line.share(progress.share(), |seconds| told(progress, seconds));
    });
    line.clear();
    result.map_err(|failure| Failure::run(format!("the run failed: {failure}")))
}

/// What the progress line says of a run after `seconds`.
fn told(progress: &Progress<'_>, seconds: f64) -> String {
    format!(
        "t = {:.4e} s  {} particles  {:.2e} particle-steps/s  Ekin {:.2e} J",
        progress.engine.time(),
        progress.engine.particles.len(),
        progress.particle_steps as f64 / seconds.max(1e-9),
        progress.kinetic_energy(),
    )
}
