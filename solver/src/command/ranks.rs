//! The ranks of a job: several processes, begun by a launcher, that make one run.

// Without MPI a job is never joined.
#![cfg_attr(not(feature = "mpi"), allow(dead_code))]

#[cfg(feature = "mpi")]
mod mpi;

use std::sync::Arc;

use crate::plan::{Memory, Plan, sha256};
use crate::run::RanksHere;
use mercury_common::cli::Failure;
use mercury_common::readable;
use mercury_common::scene::Statement;
use mercury_engine::forces::block_size;
use mercury_engine::ranks::{Ranks as _, Share, of_team};
use mercury_engine::state::Plain;
use mercury_engine::step::{Core, Engine, Part, RunError, StartOptions};

/// Names of the variables in which launchers say how many processes there are, and which this one is: of Open MPI, of PMI (MPICH, Intel MPI), of
/// Slurm, whose variables are there for single programs too.
const LAUNCHERS: [[&str; 3]; 3] = [
    ["OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK", ""],
    ["PMI_SIZE", "PMI_RANK", ""],
    ["SLURM_STEP_NUM_TASKS", "SLURM_PROCID", "PMIX_RANK"],
];

/// This process among those that a launcher has begun.
pub(crate) enum Job {
    /// There are no others.
    Alone,
    /// One of several ranks.
    Rank(Box<Team>),
    /// One of several processes whose first one reports why they cannot work together.
    #[cfg_attr(feature = "mpi", expect(dead_code))]
    Silent,
}

/// The ranks of the job.
pub(crate) struct Team {
    ranks: mercury_engine::ranks::Team,
    /// Ranks on this machine.
    pub(crate) here: RanksHere,
}

/// Number of processes of the job and number of this one, if a launcher has begun several.
fn launched() -> Option<(usize, usize)> {
    let number = |name: &str| std::env::var(name).ok()?.parse::<usize>().ok();
    let of = |[size, rank, also]: [&str; 3]| {
        let is_there = also.is_empty() || std::env::var_os(also).is_some();
        (number(size).filter(|_| is_there)?, number(rank)?).into()
    };
    LAUNCHERS
        .into_iter()
        .find_map(of)
        .filter(|&(size, _): &(usize, usize)| size > 1)
}

/// Whether a launcher has begun several processes, and this is not the first one.
pub(crate) fn is_another() -> bool {
    launched().is_some_and(|(_, rank)| rank > 0)
}

impl Job {
    /// Joins the job that a launcher has begun, if it has.
    ///
    /// # Errors
    /// On the first process: if this program cannot work with others.
    pub(crate) fn join() -> Result<Self, Failure> {
        match launched() {
            None => Ok(Self::Alone),
            Some((count, rank)) => join(count, rank),
        }
    }
}

#[cfg(not(feature = "mpi"))]
fn join(count: usize, rank: usize) -> Result<Job, Failure> {
    if rank > 0 {
        return Ok(Job::Silent);
    }
    Err(Failure::input(format!(
        "a launcher has begun {count} processes of this program, which was built without MPI: each would make the same run"
    ))
    .with_help("start it without mpirun or srun, or build it with `cargo build --release --features mpi`"))
}

#[cfg(feature = "mpi")]
fn join(count: usize, rank: usize) -> Result<Job, Failure> {
    use self::mpi::Mpi;
    let mpi = Mpi::join().map_err(Failure::run)?;
    // A rank that ends in disorder would leave the others waiting for ever.
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        report(panic);
        eprintln!("rank {rank} of {count} failed, and all others end with it");
        Mpi::abort(101);
    }));
    let (here, with_first) = mpi.on_this_machine();
    let here = RanksHere {
        all: count,
        here,
        with_first,
    };
    Ok(Job::Rank(Box::new(Team {
        ranks: Arc::new(std::sync::Mutex::new(mpi)),
        here,
    })))
}

impl Team {
    /// Whether this is the first rank.
    pub(crate) fn is_first(&self) -> bool {
        self.ranks.place().0 == 0
    }

    /// The share of this rank in the next run. Where the first rank drops it without a run, the others go on as after one.
    pub(crate) fn share(&self) -> Share {
        Share::new(Box::new(Arc::clone(&self.ranks)))
    }

    /// Threads of this rank where none are requested: the cores that it may use, shared with the other ranks of the machine where these may use
    /// the same ones.
    pub(crate) fn threads(&self) -> usize {
        let usable = std::thread::available_parallelism().map_or(1, usize::from);
        match usable < cores_of_machine() {
            true => usable,
            false => (usable / self.here.here.max(1)).max(1),
        }
    }

    /// Compares what the ranks are about to run. Each calls it, also one that has found a reason against the run: the others get that reason.
    ///
    /// # Errors
    /// If another rank cannot run this, or would run something else.
    pub(crate) fn agree(&self, own: Result<String, String>) -> Result<(), Failure> {
        let mut bytes = Vec::new();
        let (is_ready, text) = match &own {
            Ok(digest) => (true, digest),
            Err(reason) => (false, reason),
        };
        (is_ready, text.clone()).put(&mut bytes);
        let all = of_team(&self.ranks).all(bytes);
        let mut first = None;
        for (rank, bytes) in all.iter().enumerate() {
            let (is_ready, text) = <(bool, String)>::take(&mut &bytes[..]).map_err(Failure::run)?;
            if !is_ready {
                return Err(Failure::run(format!("rank {rank}: {text}")));
            }
            if *first.get_or_insert_with(|| text.clone()) != text {
                return Err(Failure::input(format!(
                    "rank {rank} has another scene, another of its files, or another version of this program than rank 0"
                ))
                .with_help("all ranks need the same files and the same program, as on a shared file system"));
            }
        }
        Ok(())
    }

    /// A note where there are more ranks than blocks of rows.
    pub(crate) fn idle(&self, memory: &Memory) -> Option<String> {
        let (rows, ranks) = (memory.spheres as usize, self.here.all);
        let blocks = rows.div_ceil(block_size(rows)).max(1);
        (blocks < ranks).then(|| {
            format!(
                "{ranks} ranks, of which {blocks} will have something to compute: {} are divided into {}",
                readable::counted(rows, "sphere"),
                readable::counted(blocks, "block")
            )
        })
    }

    /// On the last rank: a part that panics at a step, so that a test sees what becomes of the others.
    pub(crate) fn failing(&self, step: u64) -> Option<Box<dyn Part>> {
        let (rank, count) = self.ranks.place();
        (rank + 1 == count).then(|| Box::new(Failing(step)) as _)
    }

    /// Makes the run of the first rank with it, on another one.
    pub(crate) fn follow(&self, plan: Plan, options: StartOptions) {
        // The first rank reports every error.
        let _ = Engine::follow(Arc::new(plan), options.ranks(Some(self.share())));
    }

    /// The number of the next run of a study, on a rank that is not the first; `None` behind the last one.
    pub(crate) fn next_run(&self) -> Option<usize> {
        let bytes = of_team(&self.ranks).broadcast(Vec::new());
        <Option<u64> as Plain>::take(&mut &bytes[..])
            .ok()
            .flatten()
            .map(|run| run as usize)
    }

    fn tell_run(&self, run: Option<usize>) {
        let mut bytes = Vec::new();
        run.map(|run| run as u64).put(&mut bytes);
        of_team(&self.ranks).broadcast(bytes);
    }
}

/// Panics at the end of a step.
struct Failing(u64);

impl Part for Failing {
    fn name(&self) -> &str {
        "failing"
    }

    fn works_on_ranks(&self) -> bool {
        true
    }

    fn end_step(&mut self, core: &mut Core) -> Result<(), RunError> {
        assert!(core.steps() < self.0, "step {} fails, as it should", self.0);
        Ok(())
    }
}

/// On the first rank: leads the others through the runs of a study, until it is dropped.
pub(crate) struct Leader(pub(crate) Box<Team>);

impl Leader {
    /// Begins a run, by its number, on all ranks.
    ///
    /// # Errors
    /// If another rank cannot make this run, or would make another one.
    pub(crate) fn share(
        &self,
        run: usize,
        digest: Result<String, String>,
    ) -> Result<Share, Failure> {
        self.0.tell_run(Some(run));
        self.0.agree(digest)?;
        Ok(self.0.share())
    }

    /// [`Team::threads`].
    pub(crate) fn threads(&self) -> usize {
        self.0.threads()
    }
}

impl Drop for Leader {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.0.tell_run(None);
        }
    }
}

/// The section of a plan on ranks.
pub(crate) fn planned(ranks: RanksHere, memory: &Memory) -> String {
    let count = ranks.all;
    let each = memory.spheres / count as f64;
    // A part of a packing amid others: docs/theory/distribution.md.
    let beside = (4.0 * libm::cbrt(each * each)).min(memory.spheres - each);
    let [each, beside] = [each, beside].map(|spheres| readable::count(spheres.round() as u64));
    format!(
        "\nRanks\n  {count:<23} about {each} spheres each, and up to {beside} beside them whose motion or loads go over in each step\n  on this machine         {}, whose memory is estimated above",
        ranks.here
    )
}

/// A digest of a scene with its files, and of the version of the program.
///
/// # Errors
/// If a file cannot be read.
pub(crate) fn digest(statement: &Statement) -> Result<String, String> {
    let entries = statement.entries();
    let entries = entries.map_err(|(path, error)| format!("{}: {error}", path.display()))?;
    let text = format!("{} {entries:?}", env!("CARGO_PKG_VERSION"));
    Ok(sha256(text.as_bytes()))
}

/// Cores of this machine, also those that this process may not use; 1 where the system does not say.
fn cores_of_machine() -> usize {
    let online = std::fs::read_to_string("/sys/devices/system/cpu/online").unwrap_or_default();
    let runs = online.trim().split(',').filter_map(|run| {
        let (first, last) = run.split_once('-').unwrap_or((run, run));
        let ends: (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
        Some(ends.1.saturating_sub(ends.0) + 1)
    });
    runs.sum::<usize>().max(1)
}
