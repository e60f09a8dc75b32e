//! `mercury-cloud`: server, worker and command line in one program.

mod client;
mod commands;
mod diff;
mod user;

use std::ffi::OsString;
use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail};
use clap::{Args, Parser, Subcommand};
use cloud_server::EngineChoice;
use cloud_worker::confine::Cage;
use cloud_worker::{Attempt, Outcome, Ranks};

const EXAMPLES: &str = "\
Examples:
  mercury-cloud serve                              a page on this machine; prints its link
  mercury-cloud submit drum.toml                   submits a scene with the files that it names; prints the run's id
  mercury-cloud submit drum.toml --ranks 4         on several ranks of MPI, where the server offers them (Slurm)
  mercury-cloud submit study.toml                  a study; so does --sweep KEY=A,B,C with a scene
  mercury-cloud watch RUN                          progress until it ends
  mercury-cloud stop RUN; mercury-cloud resume RUN
  mercury-cloud extend RUN --end 4                 a finished run to a later end
  mercury-cloud verify RUN                         its files against its chain, some steps made again
  mercury-cloud branch RUN --at 0.7 --set 'gravity=[0, 0, -1.62]'
  mercury-cloud clone RUN --set seed=2             its scene anew, with changes
  mercury-cloud log RUN --attempt 1                the lines of an attempt; without, the report of the run
  mercury-cloud get RUN -o drum                    its files
  mercury-cloud diff drum drum-again               whether two runs have the same bytes
  mercury-cloud share new RUN                      a link with which others look at a run
  mercury-cloud session rm all                     logs you out everywhere
  mercury-cloud hook set https://example.org/x     has each end of a run sent to a URL
  mercury-cloud project new Sieves; mercury-cloud project add Sieves ada
  mercury-cloud submit drum.toml --project Sieves  a run that ada sees, too

Runs are named by their id, or by as many of its first digits as are needed.
With --json they print the answers of the server.
The commands talk to the server whose link is in --link, in MERCURY_CLOUD_LINK, or in the data folder of `serve`.

Exit codes: 0 done, 1 failed, 2 wrong usage or input.";

/// Submits, watches, stops, resumes and fetches simulations.
#[derive(Debug, Parser)]
#[command(name = "mercury-cloud", version, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Serve page and API, and run what is submitted
    Serve(Serve),
    /// Submit a scene
    Submit(commands::Submit),
    /// List runs
    Ls(commands::List),
    /// Show progress until a run ends
    Watch(commands::One),
    /// Stop a run with a checkpoint
    Stop(commands::One),
    /// End a run at once
    Kill(commands::One),
    /// Go on with a run that was stopped or has failed
    Resume(commands::Resume),
    /// Go on with a run to a later end
    Extend(commands::Extend),
    /// Submit a run that is another one up to a time, and goes on with a changed scene
    Branch(commands::Branch),
    /// Verify a finished run: all its files, and 1 % of its steps made again
    Verify(commands::Verify),
    /// Submit the scene of a run anew, with changes
    Clone(commands::Clone),
    /// Print the report of a run, or the lines of an attempt
    Log(commands::Log),
    /// Print the table of a study as comma-separated values
    Table(commands::Table),
    /// Fetch the files of a run
    Get(commands::Get),
    /// Compare the files of two folders of runs
    Diff(diff::Diff),
    /// Remove runs with all their files
    Rm(commands::Remove),
    /// Print a link that logs in the user of this machine, once, within a day
    Link(commands::Link),
    /// List sessions, end one, end all
    Session(commands::Session),
    /// List links to runs, make one, take one back
    Share(commands::Share),
    /// Make a token for the API and print it once; list tokens, take one back
    Token(commands::Token),
    /// Show where ends of your runs are sent, and the last messages; set and remove that, send a test
    Hook(commands::Hook),
    /// List projects, make one, remove one, add and remove members
    Project(commands::Project),
    /// Add or change a user; list users, remove one
    User(commands::User),
    /// List requests that have changed something, newest first; for administrators
    Audit(commands::Audit),
    /// Print the description of the API
    Openapi,
    /// One attempt of a run (started by the server)
    #[command(hide = true)]
    Worker(Worker),
    /// Walls and particles of the run in this folder (started by the server, in a cage)
    #[command(hide = true)]
    View {
        #[arg(long)]
        frame: Option<usize>,
    },
    /// A program in a cage (started by the worker)
    #[command(hide = true)]
    Confine(Confine),
}

#[derive(Debug, Args)]
struct Serve {
    /// Folder of all data [default: ~/.local/share/mercury-cloud]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Port
    #[arg(long, default_value_t = 8080)]
    port: u16,
    /// Address to listen on
    #[arg(long, default_value = "127.0.0.1")]
    address: std::net::IpAddr,
    /// Name by which browsers reach this server; may be repeated
    #[arg(long, value_name = "NAME")]
    host: Vec<String>,
    /// A proxy in front does TLS
    #[arg(long)]
    behind_proxy: bool,
    /// The store: a folder that workers see, too, or s3://BUCKET/PREFIX [default: DIR/store]
    #[arg(long, value_name = "STORE")]
    store: Option<String>,
    /// Folder in which workers make theirs [default: DIR/scratch]
    #[arg(long, value_name = "DIR")]
    scratch: Option<PathBuf>,
    /// The solver [default: mercury-solve beside this program, or on the path]
    #[arg(long, value_name = "FILE")]
    solver: Option<PathBuf>,
    /// Cores for runs [default: all]
    #[arg(long, value_name = "N")]
    cores: Option<u32>,
    /// Memory for runs in MB [default: three quarters of the machine's]
    #[arg(long, value_name = "MB")]
    memory: Option<u64>,
    /// The most that one run may write, in MB
    #[arg(long, value_name = "MB", default_value_t = 100_000)]
    disk: u64,
    /// Run on Slurm, with the settings of this file (docs/how-to/cloud-slurm.md)
    #[arg(long, value_name = "SITE.toml", group = "engine")]
    slurm: Option<PathBuf>,
    /// Run on AWS Batch, with the settings of this file (docs/how-to/cloud-aws.md)
    #[cfg(feature = "aws")]
    #[arg(long, value_name = "BATCH.toml", group = "engine", requires = "store")]
    aws: Option<PathBuf>,
    /// An option of earlier versions: refused with a message
    #[arg(long, hide = true, num_args = 0..=1)]
    kubernetes: Option<Option<PathBuf>>,
    /// Command for `sh -c` at the end of each run, such as one that sends mail; it has MERCURY_RUN, _TITLE, _LABEL, _OWNER, _STATE, _MESSAGE and _LINK
    #[arg(long, value_name = "COMMAND")]
    at_end: Option<String>,
    /// Host that web hooks of users reach also by http, and where its address is not public; may be repeated
    #[arg(long, value_name = "HOST")]
    hooks_to: Vec<String>,
    /// Time by the clock between two checkpoints
    #[arg(long, value_name = "TIME", default_value = "5m")]
    checkpoint_every: String,
    /// Seconds between two signs of life of a run [default: 2, on Slurm 10, with s3:// 15]
    #[arg(long, value_name = "S", value_parser = beat)]
    beat: Option<f64>,
    /// Wait after a first attempt without progress, in s; doubled with each further one
    #[arg(long, value_name = "S", default_value_t = 10.0)]
    retry_wait: f64,
    /// Prices of cores, so that runs show money beside core hours (example: cloud/deploy/prices.toml)
    #[arg(long, value_name = "PRICES.toml")]
    prices: Option<PathBuf>,
    /// User that the server and all solvers run as, where root starts it; `root` serves as root all the same
    #[arg(long, value_name = "NAME")]
    user: Option<String>,
    /// Do not confine the solver: a scene can then read any file that this user can
    #[arg(long)]
    no_sandbox: bool,
    /// No link and no log-in; on loopback only
    #[arg(long)]
    no_auth: bool,
}

#[derive(Debug, Args)]
struct Worker {
    #[arg(long)]
    store: String,
    #[arg(long)]
    job: String,
    #[arg(long)]
    run: String,
    #[arg(long)]
    epoch: u64,
    #[arg(long)]
    scratch: PathBuf,
    #[arg(long)]
    solver: PathBuf,
    #[arg(long, default_value_t = 2.0)]
    beat: f64,
    #[arg(long, default_value_t = 5.0)]
    commit: f64,
    #[arg(long, default_value = "5m")]
    checkpoint_every: String,
    #[arg(long)]
    time_limit: Option<String>,
    #[arg(long)]
    disk: Option<u64>,
    /// Seconds without a new step until the solver counts as hung
    #[arg(long, default_value_t = 600.0)]
    patience: f64,
    /// Ranks of MPI, within a job of Slurm that has room for them
    #[arg(long, default_value_t = 1)]
    ranks: u32,
    /// Options of srun for several ranks
    #[arg(long, allow_hyphen_values = true)]
    srun: Vec<String>,
    /// Files and folders that MPI reads and writes
    #[arg(long)]
    mpi_path: Vec<PathBuf>,
    #[arg(long)]
    no_sandbox: bool,
}

#[derive(Debug, Args)]
struct Confine {
    #[arg(long)]
    folder: PathBuf,
    #[arg(long)]
    no_sandbox: bool,
    #[arg(long, default_value_t = 0)]
    memory: u64,
    #[arg(long, default_value_t = 0)]
    file: u64,
    #[arg(long, default_value_t = 0)]
    cpu: u64,
    /// A rank of MPI: with a network, and without Unix sockets
    #[arg(long)]
    mpi: bool,
    #[arg(long, requires = "mpi")]
    mpi_path: Vec<PathBuf>,
    #[arg(last = true, required = true)]
    program: Vec<OsString>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(arguments.command) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(if error.is::<commands::Usage>() { 2 } else { 1 })
        }
    }
}

fn run(command: Command) -> Result<ExitCode> {
    match command {
        Command::Serve(serve) => self::serve(serve).map(|()| ExitCode::SUCCESS),
        Command::Worker(worker) => self::worker(worker).map(|()| ExitCode::SUCCESS),
        Command::Confine(confine) => {
            let cage = Cage {
                folder: confine.folder,
                sandbox: !confine.no_sandbox,
                memory: confine.memory,
                file: confine.file,
                cpu: confine.cpu,
                mpi: confine.mpi.then_some(confine.mpi_path),
            };
            let (program, arguments) = confine.program.split_first().context("a program")?;
            cage.enter(program.as_ref(), arguments)?;
            Ok(ExitCode::FAILURE)
        }
        Command::View { frame } => {
            cloud_server::view(Path::new("."), frame, std::io::stdout().lock())?;
            Ok(ExitCode::SUCCESS)
        }
        Command::Submit(submit) => submit.run(),
        Command::Ls(list) => list.run(),
        Command::Watch(one) => one.watch(),
        Command::Stop(one) => one.change("stop"),
        Command::Kill(one) => one.change("kill"),
        Command::Resume(resume) => resume.run(),
        Command::Extend(extend) => extend.run(),
        Command::Verify(verify) => verify.run(),
        Command::Branch(branch) => branch.run(),
        Command::Clone(clone) => clone.run(),
        Command::Log(log) => log.run(),
        Command::Table(table) => table.run(),
        Command::Get(get) => get.run(),
        Command::Diff(diff) => diff.run(),
        Command::Rm(remove) => remove.run(),
        Command::Link(link) => link.run(),
        Command::Session(session) => session.run(),
        Command::Share(share) => share.run(),
        Command::Token(token) => token.run(),
        Command::Hook(hook) => hook.run(),
        Command::Project(project) => project.run(),
        Command::User(user) => user.run(),
        Command::Audit(audit) => audit.run(),
        Command::Openapi => {
            commands::say(&format!("{:#}", cloud_server::openapi()))?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// Seconds between two signs of life.
fn beat(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.1..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err("expected 0.1 to 3600 seconds".to_owned()),
    }
}

/// The solver: what the user says, beside this program, or on the path.
fn solver(named: Option<PathBuf>) -> Result<PathBuf> {
    let name = "mercury-solve";
    let beside = std::env::current_exe()
        .ok()
        .and_then(|this| Some(this.parent()?.join(name)));
    let on_path = std::env::var_os("PATH").unwrap_or_default();
    let mut places = named
        .is_none()
        .then_some(())
        .into_iter()
        .flat_map(|()| beside.clone())
        .collect::<Vec<_>>();
    places.extend(
        std::env::split_paths(&on_path)
            .map(|folder| folder.join(name))
            .filter(|_| named.is_none()),
    );
    places.extend(named);
    match places.iter().find(|place| place.is_file()) {
        Some(place) => Ok(place.canonicalize()?),
        None => bail!("no {name} beside this program, on the path or at the path of --solver"),
    }
}

/// Memory of this machine in bytes, from `/proc/meminfo`.
fn memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemTotal:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? << 10)
}

/// The settings in a file.
fn settings<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T> {
    let wrong = |error: &dyn std::fmt::Display| {
        anyhow!(commands::Usage(format!("{}: {error}", path.display())))
    };
    let text = std::fs::read_to_string(path).map_err(|error| wrong(&error))?;
    toml::from_str(&text).map_err(|error| wrong(&error))
}

/// Where attempts are to run.
fn engine(serve: &Serve) -> Result<EngineChoice> {
    if serve.kubernetes.is_some() {
        bail!(commands::Usage(
            "--kubernetes: Kubernetes is not supported; use --slurm SITE.toml, or --aws BATCH.toml (docs/how-to/cloud-aws.md)"
                .into()
        ));
    }
    #[cfg(feature = "aws")]
    if let Some(path) = &serve.aws {
        if !serve.store.as_deref().is_some_and(cloud_store::is_remote) {
            bail!(commands::Usage(
                "--aws needs --store s3://BUCKET/PREFIX: workers see nothing else".into()
            ));
        }
        return Ok(EngineChoice::Aws(settings(path)?));
    }
    match &serve.slurm {
        Some(path) => Ok(EngineChoice::Slurm(settings(path)?)),
        None => Ok(EngineChoice::Local),
    }
}

/// Makes all files that this process and its children write readable by their owner alone.
fn keep_private() {
    rustix::process::umask(rustix::fs::Mode::from_raw_mode(0o077));
}

fn serve(serve: Serve) -> Result<()> {
    keep_private();
    user::become_user(serve.user.as_deref(), serve.data.as_deref())?;
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get() as u32);
    let engine = engine(&serve)?;
    let prices: Option<cloud_server::Prices> = (serve.prices.as_ref())
        .map(|path| settings(path))
        .transpose()?;
    if let (Some(prices), Some(path)) = (&prices, &serve.prices)
        && let Err(wrong) = prices.check()
    {
        bail!(commands::Usage(format!("{}: {wrong}", path.display())));
    }
    let options = cloud_server::Options {
        data: serve.data.map_or_else(commands::data_folder, Ok)?,
        listen: SocketAddr::new(serve.address, serve.port),
        store: serve.store,
        solver: solver(serve.solver)?,
        cores: serve.cores.unwrap_or(cores),
        memory: serve
            .memory
            .map_or_else(|| memory().unwrap_or(4 << 30) / 4 * 3, |mb| mb << 20),
        disk: serve.disk * 1_000_000,
        engine,
        scratch: serve.scratch,
        hosts: serve.host,
        behind_proxy: serve.behind_proxy,
        sandbox: !serve.no_sandbox,
        no_auth: serve.no_auth,
        checkpoint_every: serve.checkpoint_every,
        beat: serve.beat,
        first_wait: serve.retry_wait,
        prices,
        at_end: serve.at_end,
        hooks_to: serve.hooks_to,
        after_submit,
    };
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .worker_threads(2)
        .build()?;
    runtime.block_on(cloud_server::serve(options, |links| {
        // A secret is for a terminal, not for the log of a service. Standard output may be closed, which is no reason not to serve.
        if std::io::stdout().is_terminal() {
            let _ = commands::say(&links.once);
        } else {
            let _ = commands::say(&links.address);
            eprintln!("`mercury-cloud link` prints a link that logs in");
        }
    }))
}

/// For tests: killed between the engine's yes and its record.
fn after_submit() {
    if std::env::var_os("MERCURY_CLOUD_FAIL").is_some_and(|point| point == "after-submit") {
        std::process::exit(137);
    }
}

fn worker(worker: Worker) -> Result<()> {
    keep_private();
    // Outlives the server and its terminal. It fails where this process leads a group already, which is as good.
    let _ = rustix::process::setsid();
    cloud_engine::record().context("the record of this worker cannot be written")?;
    let store = cloud_store::open(&worker.store)?;
    let attempt = Attempt {
        store: store.as_ref(),
        run: worker.run.parse()?,
        epoch: worker.epoch,
        scratch: worker.scratch,
        solver: worker.solver,
        sandbox: !worker.no_sandbox,
        beat: Duration::from_secs_f64(worker.beat),
        commit: Duration::from_secs_f64(worker.commit),
        checkpoint: worker.checkpoint_every,
        limit: worker.time_limit,
        disk: worker.disk,
        patience: Duration::from_secs_f64(worker.patience),
        ranks: (worker.ranks > 1).then_some(Ranks {
            count: worker.ranks,
            srun: worker.srun,
            paths: worker.mpi_path,
        }),
    };
    std::fs::create_dir_all(&attempt.scratch)?;
    // An end that stands in the store is a success, whatever the end was: the server makes the next attempt.
    if cloud_worker::work(&attempt)? == Outcome::Superseded {
        eprintln!("{}: the run belongs to another attempt", worker.job);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kubernetes_is_refused_with_the_other_engines() {
        let typed = ["mercury-cloud", "serve", "--kubernetes", "kubernetes.toml"];
        let Command::Serve(serve) = Arguments::parse_from(typed).command else {
            panic!("another command");
        };
        let error = engine(&serve).unwrap_err();
        assert!(error.is::<commands::Usage>());
        for other in ["not supported", "--slurm", "--aws"] {
            assert!(error.to_string().contains(other), "{error}");
        }
    }
}
