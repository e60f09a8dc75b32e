//! The command line of `mercury-solve`, as a function: its options, and each task with its part of them.

mod check;
mod input;
mod new;
mod problems;
mod progress;
mod ranks;
mod run;
mod scene;
mod study;
mod trial;
mod verify;
mod waiting;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use clap::{Parser, Subcommand};
use mercury_common::cli::{self, Exit, Failure, Outcome, say};
use mercury_common::units::Dimension;
use mercury_common::within::Within;
use mercury_engine::forces::fix_block_size;
use mercury_engine::lanes::Width;

use crate::output::folder::Earlier;
use crate::plan::schema;
use crate::results::NamedResult;
use crate::run::checkpoint;
use crate::study::Seeds;
use input::lies_within;
use run::How;

/// More threads than any machine has: a typing error.
const MOST_THREADS: i64 = 1024;

const EXAMPLES: &str = "\
Examples:
  mercury-solve new drum                          writes drum.toml, a scene to start from; also hopper, chute, repose, press, clumps
  mercury-solve drum.toml                         run it; files in ./drum/
  python3 make.py | mercury-solve - --output 7    a scene from standard input, in TOML or JSON
  mercury-solve drum.toml --check                 what the scene means; nothing is run
  mercury-solve drum.toml --check --trial         and how long the run will take, from its first 5 s
  mercury-solve drum.toml --set time.end=0.1 --set materials.bead.tangential.friction=0.3 --output short
  mercury-solve drum.toml --force --threads 4     replace an earlier run
  mercury-solve drum.toml --quiet --json          the summary as JSON, for scripts
  mercury-solve drum.toml --result \"torque=mean(walls.drum.ty, 1..2)\"   a number of the run in its summary
  mercury-solve drum.toml --time-limit 55m        stop before a queue's limit, with a checkpoint
  mercury-solve drum.toml --resume                go on from there: the same bytes as without a stop
  mercury-solve drum.toml --resume --set time.end=4   longer than it was
  mercury-solve --from drum --at 0.7 --set gravity=[0,0,-1.62] --output moon   as drum/ up to 0.7 s, and on with other gravity
  mercury-solve verify drum                       whether its files are what its steps give; some steps are made again
  mercury-solve --inspect drum/drum.0.restart     what is in a checkpoint; --json for scripts
  mercury-solve repose.toml --sweep materials.grain.rolling.friction=0,0.1,0.2 --result \"height=max(particles.z)\"
                                                  a study: a run for each value, a table and a plot in repose-study/
  mercury-solve study.toml                        a study from a file; the same again goes on where it was stopped

Ctrl-C, SIGTERM and a file STOP in the run's folder stop a run after its step, with a checkpoint; Ctrl-C twice ends it at
once. SIGUSR1 writes a checkpoint and goes on.

Exit codes: 0 done, 1 the run failed, 2 wrong usage or input, 75 stopped and can be resumed, 130 ended at once.";

/// Answer to `--version`: a program that can make a run on several ranks says so in a line of its own.
const VERSION: &str = if cfg!(feature = "mpi") {
    concat!(env!("CARGO_PKG_VERSION"), "\nwith MPI")
} else {
    env!("CARGO_PKG_VERSION")
};

/// Runs a discrete particle simulation that a scene file describes.
#[derive(Debug, Parser)]
#[command(name = "mercury-solve", version, long_version = VERSION, after_help = EXAMPLES)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    disable_help_subcommand = true
)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,

    /// The scene file, in TOML or JSON; `-`: standard input
    #[arg(value_name = "SCENE.toml", required_unless_present_any = ["completions", "inspect", "schema", "from"])]
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

    /// Branch off from the run in this folder at the time --at: the same bytes up to there, and on with what --set changes
    #[arg(long, value_name = "RUN", requires_all = ["at", "output"], conflicts_with_all = ["scene", "resume", "sweep", "seeds", "within", "inspect"])]
    from: Option<PathBuf>,

    /// The time at which it branches off: seconds, or "20 ms"
    #[arg(long, value_name = "TIME", requires = "from", allow_negative_numbers = true, value_parser = cli::quantity(Dimension::TIME))]
    at: Option<f64>,

    /// Stop after this wall-clock time, with a checkpoint: 55m, 1h30m, 90s
    #[arg(long, value_name = "TIME", value_parser = cli::duration)]
    time_limit: Option<Duration>,

    /// Wall-clock time between checkpoints; one more is written at the end; `never`: only when the run is stopped
    #[arg(long, value_name = "TIME", default_value = "10m", value_parser = checkpoint_every)]
    checkpoint_every: Every,

    /// Print the contents of a checkpoint and exit
    #[arg(long, value_name = "FILE", conflicts_with = "scene")]
    inspect: Option<PathBuf>,

    /// Run or plan a scene even if it needs more memory than this machine has
    #[arg(long)]
    force_memory: bool,

    /// Print what the scene means (resolved parameters, time step and its reason, memory) and exit
    #[arg(long)]
    check: bool,

    /// With --check: run the first steps for this time and estimate how long the whole run takes; nothing is written
    #[arg(long, value_name = "TIME", num_args = 0..=1, default_missing_value = trial::LASTS, requires = "check", value_parser = trial::lasts)]
    trial: Option<Duration>,

    /// Threads at most: fewer where the scene is too small for them; the results are the same with any number [default: what the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,

    /// All of the --threads make every step, however slow that is: to measure the gain of threads
    #[arg(long, requires = "threads")]
    fixed_threads: bool,

    /// Contacts evaluated side by side: 1, 2 or 4; the results are the same with any number [default: what this processor does fastest]
    #[arg(long, value_name = "N", value_parser = lanes)]
    lanes: Option<Width>,

    /// Replace a key of the scene, for example time.end=0.1; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// A number of the run for its summary, or for the study's table: torque=mean(walls.drum.ty, 1..2); may be repeated
    #[arg(long, value_name = "NAME=WHAT")]
    result: Vec<String>,

    /// A study: run the scene once for each value; several keys make a grid
    #[arg(
        long,
        value_name = "KEY=A,B,C",
        help_heading = "Studies",
        conflicts_with = "inspect"
    )]
    sweep: Vec<String>,

    /// A study: each point with so many seeds, or from 8 on as many as --error needs (8..64)
    #[arg(long, value_name = "N", help_heading = "Studies", value_parser = Seeds::parse, conflicts_with = "inspect")]
    seeds: Option<Seeds>,

    /// The error of a result at which a point has enough seeds: slope=2%; may be repeated
    #[arg(
        long,
        value_name = "NAME=ERROR",
        help_heading = "Studies",
        requires = "seeds"
    )]
    error: Vec<String>,

    /// Draw a column of the study's table over its first key [default: what --result names]
    #[arg(long, value_name = "COLUMN", help_heading = "Studies")]
    plot: Vec<String>,

    /// Runs of a study at a time, each on one thread unless --threads says more [default: what the machine has]
    #[arg(long, value_name = "N", help_heading = "Studies", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    jobs: Option<u16>,

    /// Read and write no file outside of this folder, links followed: for scenes from other people
    #[arg(long, value_name = "DIR")]
    within: Option<PathBuf>,

    /// Report the run to programs: a line of JSON each second, and for each phase, frame and checkpoint
    #[arg(long, value_name = "FILE", conflicts_with_all = ["check", "inspect", "sweep", "seeds"])]
    progress: Option<PathBuf>,

    /// Rows in a block, for tests: small scenes have many blocks then
    #[arg(long, value_name = "N", hide = true, value_parser = clap::value_parser!(u16).range(1..))]
    rows_per_block: Option<u16>,

    /// Step at which the last of several ranks panics, for tests
    #[arg(long, value_name = "STEP", hide = true)]
    fail_at: Option<u64>,

    /// No progress and no report, only errors
    #[arg(long)]
    quiet: bool,

    /// Print the summary (with --check: the plan; where something is wrong: the problems) as one JSON object on standard output
    #[arg(long)]
    json: bool,

    /// Print the JSON schema of scenes, for editors, and exit
    #[arg(long, conflicts_with_all = ["scene", "inspect"])]
    schema: bool,

    /// Print completions for a shell and exit
    #[arg(long, value_name = "SHELL")]
    completions: Option<cli::Shell>,

    /// The command line as it was typed, for the log of a run
    #[arg(skip)]
    typed: String,
}

/// Command besides running a scene.
#[derive(Debug, Subcommand)]
enum Command {
    /// Write a commented scene to start from, with the files it needs; nothing is ever replaced
    New(new::New),
    /// Check a run against its chain: all its files, and a share of its steps made again; nothing in RUN is changed
    Verify(verify::Verify),
}

fn lanes(text: &str) -> Result<Width, String> {
    let all = [1, 2, 4].map(Width::of).into_iter().flatten();
    let all: Vec<String> = all.map(|width| width.lanes().to_string()).collect();
    (text.parse().ok().and_then(Width::of))
        .ok_or_else(|| format!("this processor can do {}", all.join(", ")))
}

/// Interval of checkpoints by the clock.
#[derive(Debug, Clone, Copy)]
struct Every(Option<Duration>);

fn checkpoint_every(text: &str) -> Result<Every, String> {
    match text {
        "never" => Ok(Every(None)),
        _ => cli::duration(text).map(|time| Every(Some(time))),
    }
}

impl Arguments {
    /// The numbers that are wanted by name, each once.
    fn results(&self) -> Result<Vec<NamedResult>, Failure> {
        let mut results: Vec<NamedResult> = Vec::new();
        for text in &self.result {
            let wrong = |problem| Failure::input(format!("--result {text}: {problem}"));
            let result = NamedResult::parse(text).map_err(wrong)?;
            if results.iter().any(|known| known.name == result.name) {
                return Err(wrong("this name was given before".to_owned()));
            }
            results.push(result);
        }
        Ok(results)
    }

    /// The folder outside of which nothing is read or written.
    fn within(&self) -> Result<Option<Arc<Within>>, Failure> {
        let Some(folder) = &self.within else {
            return Ok(None);
        };
        let within = Within::new(folder).map_err(|error| {
            Failure::input(format!("--within {}: {error}", folder.display()))
                .with_help("name a folder that is there")
        })?;
        Ok(Some(Arc::new(within)))
    }

    fn how(&self) -> How {
        How {
            folder: self.output.clone(),
            within: None,
            progress: None,
            results: Vec::new(),
            until: None,
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
            typed: self.typed.clone(),
            ranks: Arc::default(),
        }
    }
}

/// Executes a command line, whose first word is the name of the program. Results go to standard output and messages to standard error;
/// a run stops on SIGINT, SIGTERM and SIGUSR2.
#[must_use]
pub fn main(words: Vec<OsString>) -> Exit {
    let in_json = problems::are_requested(&words);
    let typed = words.join(std::ffi::OsStr::new(" "));
    let execute = |arguments: Arguments| {
        execute(&Arguments {
            typed: typed.to_string_lossy().into_owned(),
            ..arguments
        })
    };
    let tell = |failure: &Failure| {
        if in_json {
            problems::tell(failure);
        }
    };
    cli::main_of(words, execute, tell)
}

fn execute(arguments: &Arguments) -> Outcome {
    let is_run = arguments.command.is_none()
        && arguments.completions.is_none()
        && !arguments.schema
        && arguments.inspect.is_none();
    // Of several processes that a launcher has begun, the first one makes what several would make alike.
    if !is_run && ranks::is_another() {
        return Ok(());
    }
    match &arguments.command {
        Some(Command::New(new)) => return new::execute(new),
        Some(Command::Verify(verify)) => return verify::execute(verify),
        None => {}
    }
    if let Some(shell) = arguments.completions {
        return cli::say_completions::<Arguments>(shell);
    }
    if arguments.schema {
        return problems::say_object(&schema());
    }
    let within = arguments.within()?;
    if let Some(file) = &arguments.inspect {
        lies_within(within.as_ref(), file)?;
        let checkpoint = checkpoint::read(file).map_err(Failure::input)?;
        let contents = checkpoint.contents().map_err(Failure::input)?;
        return match arguments.json {
            true => problems::say_object(&contents.as_json()),
            false => say(&contents.to_string()),
        };
    }
    if let Some(rows) = arguments.rows_per_block {
        fix_block_size(usize::from(rows));
    }
    // The argument is required without --completions, --inspect and --schema.
    let path = arguments.scene.as_deref().unwrap_or(Path::new(""));
    scene::execute(arguments, path, within)
}
