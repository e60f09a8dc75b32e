//! `mercury-solve`: the command line, nothing else.

mod command;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use clap::{Parser, Subcommand};
use command::run::{How, Requests, plan_as_toml, run_plan};
use command::waiting::Waiting;
use mercury_common::cli::{self, Failure, Outcome, say};
use mercury_common::machine::{self, MachineMemory};
use mercury_common::readable::{self, rounded};
use mercury_common::scene::{Scene, SceneErrors};
use mercury_solver::lanes::Width;
use mercury_solver::output::folder::Earlier;
use mercury_solver::output::summary::Status;
use mercury_solver::plan::{Disk, Memory, Plan, read_scene, refusal, report};
use mercury_solver::run::{Progress, check_fit, checkpoint, plan_within};

/// More threads than any machine has: a slip of the keyboard.
const MOST_THREADS: i64 = 1024;

const EXAMPLES: &str = "\
Examples:
  mercury-solve new drum                          writes drum.toml, a scene to start from; also hopper, chute, repose, press, clumps
  mercury-solve drum.toml                         run it; files in ./drum/
  mercury-solve drum.toml --check                 what the scene means; nothing is run
  mercury-solve drum.toml --check --trial         and how long the run will take, from its first 5 s
  mercury-solve drum.toml --set time.end=0.1 --set materials.bead.tangential.friction=0.3 --output short
  mercury-solve drum.toml --force --threads 4     replace an earlier run
  mercury-solve drum.toml --quiet --json          the summary as JSON, for scripts
  mercury-solve drum.toml --time-limit 55m        stop before a queue's limit, with a checkpoint
  mercury-solve drum.toml --resume                go on from there: the same bytes as without a stop
  mercury-solve drum.toml --resume --set time.end=4   longer than it was
  mercury-solve --inspect drum/drum.0.restart     what is in a checkpoint
  mercury-solve repose.toml --sweep materials.grain.rolling.friction=0,0.1,0.2 --result \"height=max(particles.z)\"
                                                  a study: a run for each value, a table and a plot in repose-study/
  mercury-solve study.toml                        a study from a file; the same again goes on where it was stopped

Ctrl-C, SIGTERM and a file STOP in the run's folder stop a run after its step, with a checkpoint; Ctrl-C twice ends it at
once. SIGUSR1 writes a checkpoint and goes on.

Exit codes: 0 done, 1 the run failed, 2 wrong usage or input, 75 stopped and can be resumed, 130 ended at once.";

/// Runs a discrete particle simulation that a scene file describes.
#[derive(Debug, Parser)]
#[command(name = "mercury-solve", version, after_help = EXAMPLES)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    disable_help_subcommand = true
)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,

    /// The scene file
    #[arg(value_name = "SCENE.toml", required_unless_present_any = ["completions", "inspect"])]
    scene: Option<PathBuf>,

    /// Folder for the files of the run [default: ./SCENE/]
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Replace the files of an earlier run in that folder
    #[arg(long)]
    force: bool,

    /// Go on from the newest checkpoint in that folder; from the beginning where there is none
    #[arg(long, conflicts_with_all = ["force", "check"])]
    resume: bool,

    /// Stop after so long by the clock, with a checkpoint: 55m, 1h30m, 90s
    #[arg(long, value_name = "TIME", value_parser = cli::duration)]
    time_limit: Option<Duration>,

    /// Write a checkpoint every so often by the clock, and at the end; `never`: only when the run is stopped
    #[arg(long, value_name = "TIME", default_value = "10m", value_parser = checkpoint_every)]
    checkpoint_every: Every,

    /// Say what is in a checkpoint and stop
    #[arg(long, value_name = "FILE", conflicts_with = "scene")]
    inspect: Option<PathBuf>,

    /// Run, or plan, what is expected to need more memory than this machine has
    #[arg(long)]
    force_memory: bool,

    /// Print what the scene means (resolved parameters, time step and its reason, memory) and stop
    #[arg(long)]
    check: bool,

    /// With --check: make the first steps for so long and say how long the run will take; nothing is written
    #[arg(long, value_name = "TIME", num_args = 0..=1, default_missing_value = command::trial::LASTS, requires = "check", value_parser = command::trial::lasts)]
    trial: Option<Duration>,

    /// Threads at most: as many as the scene can use, and one alone while that is faster; the results are the same with any number [default: what the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,

    /// All of the --threads make every step, however slow that is: to measure what threads are worth
    #[arg(long, requires = "threads")]
    fixed_threads: bool,

    /// Contacts evaluated side by side: 1, 2, 4 or 8; the results are the same with any number [default: what this processor does fastest]
    #[arg(long, value_name = "N", value_parser = lanes)]
    lanes: Option<Width>,

    /// Replace a key of the scene, for example time.end=0.1; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// A study: run the scene once for each value; several keys make a grid
    #[arg(long, value_name = "KEY=A,B,C", help_heading = "Studies", conflicts_with_all = ["json", "inspect"])]
    sweep: Vec<String>,

    /// A number for the study's table, for example torque=mean(walls.drum.ty, 1..2)
    #[arg(long, value_name = "NAME=WHAT", help_heading = "Studies")]
    result: Vec<String>,

    /// Draw a column of the study's table over its first key [default: what --result names]
    #[arg(long, value_name = "COLUMN", help_heading = "Studies")]
    plot: Vec<String>,

    /// Runs of a study at a time, each on one thread unless --threads says more [default: what the machine has]
    #[arg(long, value_name = "N", help_heading = "Studies", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    jobs: Option<u16>,

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

/// What it does besides running a scene.
#[derive(Debug, Subcommand)]
enum Command {
    /// Write a commented scene to start from, with the files it needs; nothing is ever replaced
    New(command::new::New),
}

fn lanes(text: &str) -> Result<Width, String> {
    let all: Vec<String> = Width::all()
        .iter()
        .map(|width| width.lanes().to_string())
        .collect();
    (text.parse().ok().and_then(Width::of))
        .ok_or_else(|| format!("this processor can do {}", all.join(", ")))
}

/// How often checkpoints are written by the clock.
#[derive(Debug, Clone, Copy)]
struct Every(Option<Duration>);

fn checkpoint_every(text: &str) -> Result<Every, String> {
    match text {
        "never" => Ok(Every(None)),
        _ => cli::duration(text).map(|time| Every(Some(time))),
    }
}

impl Arguments {
    fn how(&self) -> How {
        How {
            folder: self.output.clone(),
            earlier: match (self.force, self.resume) {
                (true, _) => Earlier::Replace,
                (_, true) => Earlier::Continue,
                _ => Earlier::Refuse,
            },
            threads: self.threads,
            fixed_threads: self.fixed_threads,
            width: self.lanes,
            time_limit: self.time_limit,
            checkpoint_every: self.checkpoint_every.0,
            quiet: self.quiet,
        }
    }
}

fn main() -> ExitCode {
    cli::main(|arguments: Arguments| execute(&arguments))
}

fn execute(arguments: &Arguments) -> Outcome {
    match &arguments.command {
        Some(Command::New(new)) => return command::new::execute(new),
        None => {}
    }
    if let Some(shell) = arguments.completions {
        return cli::say_completions::<Arguments>(shell);
    }
    if let Some(file) = &arguments.inspect {
        let checkpoint = checkpoint::read(file).map_err(Failure::input)?;
        return say(&checkpoint.to_string());
    }
    // From the first instant of a run on, so that no request comes too early; what only looks may be ended at any time.
    let requests = match arguments.check {
        true => None,
        false => Some(Requests::listen()?),
    };
    // The argument is required without --completions and --inspect.
    let path = arguments.scene.as_deref().unwrap_or(Path::new(""));
    let stage = requests.as_ref().map_or_else(Arc::default, Requests::stage);
    let stop = requests.as_ref().map(|requests| &requests.stop);
    let quiet = arguments.quiet || (arguments.check && arguments.json);
    let waiting = Waiting::begin(&stage, stop, quiet)?;
    if let Some(study) = command::study::asked_for(path, arguments)? {
        return command::study::execute(&study, arguments, requests, &stage, waiting);
    }
    let refused = |errors: SceneErrors| Failure::input(refusal(&errors));
    let scene = read_scene(path, &arguments.set).map_err(refused)?;
    let machine = machine::memory();
    let limit = machine.filter(|_| !arguments.force_memory);
    let (plan, memory) = plan_within(&scene, limit).map_err(refused)?;
    if arguments.check {
        drop(waiting);
        return checked(arguments, &scene, plan, &memory, machine);
    }
    if let Some(limit) = limit {
        let fit = check_fit(&scene, &plan, &memory, limit);
        fit.map_err(|error| refused(SceneErrors(vec![error])))?;
    }
    let Some(requests) = requests else {
        return Ok(());
    };
    let mut line = cli::Progress::in_logs_too(arguments.quiet);
    let mut tell = |progress: &Progress<'_>| {
        line.share_left(progress.share(), progress.left, || told(progress));
    };
    let how = arguments.how();
    let result = run_plan(
        &how,
        plan,
        &memory,
        &scene.statement,
        requests,
        &stage,
        &mut tell,
    );
    line.clear();
    drop(waiting);
    let Some(report) = result? else {
        return Ok(());
    };
    if arguments.json {
        let json = serde_json::to_string_pretty(&report.summary).map_err(Failure::run)?;
        say(&json)?;
    } else if !arguments.quiet {
        say(&report.to_string())?;
    }
    match report.summary.status {
        Status::Finished => Ok(()),
        Status::Stopped => Err(Failure::new(
            cli::Exit::Resumable,
            format!(
                "stopped at t = {} s, with a checkpoint\nhelp: --resume goes on from there",
                rounded(report.summary.time, 12)
            ),
        )),
    }
}

/// Says what a scene means, whether its run fits into the machine, and how long it will take if that was asked for.
fn checked(
    arguments: &Arguments,
    scene: &Scene,
    plan: Plan,
    memory: &Memory,
    machine: Option<MachineMemory>,
) -> Outcome {
    let fits = match machine.filter(|_| !arguments.force_memory) {
        Some(limit) => check_fit(scene, &plan, memory, limit)
            .map_err(|error| Failure::input(refusal(&SceneErrors(vec![error])))),
        None => Ok(()),
    };
    let Some(limit) = arguments.trial.filter(|_| fits.is_ok()) else {
        say(&match arguments.json {
            true => as_json(plan_as_table(&plan, memory)?)?,
            false => report(&plan, memory, machine),
        })?;
        return fits;
    };
    // As text the plan comes first: whoever waits for the trial has something to read.
    let table = arguments.json.then(|| plan_as_table(&plan, memory));
    if !arguments.json {
        say(&report(&plan, memory, machine))?;
    }
    let bytes = Disk::of(&plan).bytes;
    let quiet = arguments.quiet || arguments.json;
    let trial = command::trial::execute(plan, &arguments.how(), limit, quiet)?;
    match table {
        Some(table) => {
            let mut table = table?;
            let of_trial = toml::Value::try_from(&trial).map_err(Failure::run)?;
            table.insert("trial".to_owned(), of_trial);
            say(&as_json(table)?)?;
        }
        None => say(&format!(
            "\n{trial}  {:<24}about {}",
            "on the disk",
            readable::bytes(bytes)
        ))?,
    }
    match trial.is_cut_short {
        true => Err(command::trial::ended("before its time")),
        false => Ok(()),
    }
}

/// The content of `plan.toml`.
fn plan_as_table(plan: &Plan, memory: &Memory) -> Result<toml::Table, Failure> {
    toml::from_str(&plan_as_toml(plan, memory)?)
        .map_err(|error| Failure::run(format!("the plan cannot be written: {error}")))
}

fn as_json(table: toml::Table) -> Result<String, Failure> {
    serde_json::to_string_pretty(&table)
        .map_err(|error| Failure::run(format!("the plan cannot be written: {error}")))
}

/// What the progress line says of a run.
fn told(progress: &Progress<'_>) -> String {
    let asleep = match progress.engine.sleepers() {
        Some((asleep, _)) => format!(" ({asleep} asleep)"),
        None => String::new(),
    };
    format!(
        "t = {:.4e} s  {} particles{asleep}  {:.2e} particle-steps/s  Ekin {:.2e} J",
        progress.engine.time(),
        progress.engine.particles.grains(),
        progress.particle_steps as f64 / progress.seconds.max(1e-9),
        progress.kinetic_energy(),
    )
}
