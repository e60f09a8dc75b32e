//! A program in a cage: it reads and writes one folder, reads the system's own files, and has neither a network nor other processes.
//!
//! A scene may name any file (`file = "/etc/passwd"`), and a solver that meets one says what is wrong with its content.
//! So it must not be able to read it. The kernel enforces this for the process and all that follow it: Landlock for files, a filter of
//! system calls (seccomp) for sockets of all kinds, signals and the memory of others, and no capabilities.
//!
//! Ranks of MPI have to reach each other: theirs is a cage with a network, shared memory and the folder of the launcher. Unix sockets, by which
//! programs of the machine are reached (such as `munge`, which speaks for its user to Slurm), stay refused.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use landlock::{
    ABI, Access, AccessFs, AccessNet, BitFlags, CompatLevel, Compatible, Ruleset, RulesetAttr,
    RulesetCreatedAttr, RulesetStatus, Scope, make_bitflags, path_beneath_rules,
};
use rustix::process::{Resource, Rlimit, Signal, setrlimit};
use rustix::thread::{CapabilitySet, remove_capability_from_bounding_set};
use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
    SeccompRule,
};

/// Limits of a program.
#[derive(Clone, Debug, Default)]
pub struct Cage {
    /// The one folder in which it reads and writes.
    pub folder: PathBuf,
    /// Whether the kernel enforces this.
    pub sandbox: bool,
    /// The most bytes of address space; 0: no limit.
    pub memory: u64,
    /// The most bytes of one file; 0: no limit.
    pub file: u64,
    /// The most seconds of processor time; 0: no limit.
    pub cpu: u64,
    /// Of a rank of MPI: files and folders that its network needs, beside shared memory and the folder of the launcher.
    pub mpi: Option<Vec<PathBuf>>,
}

/// Paths that a program of the system needs to start: its libraries, and the files that describe the machine and the process itself.
const SYSTEM: [&str; 10] = [
    "/usr",
    "/lib",
    "/lib64",
    "/bin",
    "/etc/ld.so.cache",
    "/proc/cpuinfo",
    "/proc/meminfo",
    "/proc/self",
    "/proc/sys/kernel",
    "/sys",
];

/// Files that MPI reads: its settings, and names of other machines.
const MPI_READS: [&str; 8] = [
    "/etc/openmpi",
    "/etc/openmpi-mca-params.conf",
    "/etc/pmix",
    "/etc/ucx",
    "/etc/hosts",
    "/etc/host.conf",
    "/etc/nsswitch.conf",
    "/etc/resolv.conf",
];

/// Folders that the ranks of a machine share: memory, and those that Slurm has made for this step, in its own folder and in that of temporary
/// files. A site with another one than `/tmp` (`TmpFS`) names it among its paths.
fn shared_by_ranks() -> Vec<PathBuf> {
    let mut folders = vec![PathBuf::from("/dev/shm")];
    let variable = |name| std::env::var(name).ok();
    let Some(of_server) = variable("PMIX_SERVER_TMPDIR").map(PathBuf::from) else {
        return folders;
    };
    let places = [of_server.parent().map(Path::to_owned), Some("/tmp".into())];
    if let (Some(job), Some(step)) = (variable("SLURM_JOB_ID"), variable("SLURM_STEP_ID")) {
        let user = rustix::process::getuid().as_raw();
        let of_ranks = format!("spmix_appdir_{user}_{job}.{step}");
        folders.extend(
            places
                .into_iter()
                .flatten()
                .map(|place| place.join(&of_ranks)),
        );
    }
    folders.push(of_server);
    folders
}

/// System calls that no program in a cage makes, beside `socket`: sockets of `io_uring`, which makes them by itself, signals to others, memory and
/// files of other processes, and parts of the kernel that programs rarely need and attackers often use. A pair of sockets without a name
/// reaches nothing else: programs wake their threads with it.
const REFUSED: [libc::c_long; 21] = [
    libc::SYS_io_uring_setup,
    libc::SYS_kill,
    libc::SYS_tkill,
    libc::SYS_pidfd_send_signal,
    libc::SYS_rt_sigqueueinfo,
    libc::SYS_rt_tgsigqueueinfo,
    libc::SYS_ptrace,
    libc::SYS_process_vm_readv,
    libc::SYS_process_vm_writev,
    libc::SYS_pidfd_getfd,
    libc::SYS_kcmp,
    libc::SYS_unshare,
    libc::SYS_setns,
    libc::SYS_mount,
    libc::SYS_bpf,
    libc::SYS_perf_event_open,
    libc::SYS_userfaultfd,
    libc::SYS_add_key,
    libc::SYS_request_key,
    libc::SYS_keyctl,
    libc::SYS_open_by_handle_at,
];

/// The same system calls of x32, whose numbers have this bit, on x86-64 kernels that have them.
const X32: libc::c_long = if cfg!(target_arch = "x86_64") {
    0x4000_0000
} else {
    0
};

/// Rights that no program has in its folder: to make symbolic links, sockets and the like, and to execute what it wrote.
const NEVER: BitFlags<AccessFs> = make_bitflags!(AccessFs::{
    Execute | MakeChar | MakeSock | MakeFifo | MakeBlock | MakeSym
});

impl Cage {
    /// The command that runs `program` in this cage: this very program with `confine`.
    pub fn command(&self, program: &Path) -> Command {
        // By this name it is the program that runs now, also when its file has been replaced by a newer one.
        let mut command = Command::new("/proc/self/exe");
        command
            .args(self.words(program))
            .current_dir(&self.folder)
            // Without credentials of the store, which are the worker's.
            .env_clear()
            .env("TMPDIR", &self.folder);
        command
    }

    /// The arguments of this program with which it becomes `program` in this cage.
    pub(crate) fn words(&self, program: &Path) -> Vec<OsString> {
        let mut words: Vec<OsString> = vec!["confine".into(), "--folder".into()];
        words.push(self.folder.clone().into());
        if !self.sandbox {
            words.push("--no-sandbox".into());
        }
        if let Some(paths) = &self.mpi {
            words.push("--mpi".into());
            words.extend(
                paths
                    .iter()
                    .flat_map(|path| ["--mpi-path".into(), path.clone().into()]),
            );
        }
        for (option, value) in [
            ("--memory", self.memory),
            ("--file", self.file),
            ("--cpu", self.cpu),
        ] {
            words.extend([option.into(), value.to_string().into()]);
        }
        words.extend(["--".into(), program.into()]);
        words
    }

    /// Becomes `program` in this cage. Returns only if that fails.
    pub fn enter(&self, program: &Path, arguments: &[OsString]) -> Result<()> {
        // Ends with the worker, however that ends.
        let parent = rustix::process::getppid();
        rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
        if rustix::process::getppid() != parent {
            bail!("the worker ended before the solver began");
        }
        for (resource, value) in [
            (Resource::As, self.memory),
            (Resource::Fsize, self.file),
            (Resource::Cpu, self.cpu),
        ] {
            if value > 0 {
                setrlimit(
                    resource,
                    Rlimit {
                        current: Some(value),
                        maximum: Some(value),
                    },
                )?;
            }
        }
        setrlimit(
            Resource::Core,
            Rlimit {
                current: Some(0),
                maximum: Some(0),
            },
        )?;
        if self.sandbox {
            self.restrict(program)?;
        }
        // Programs write their command line to logs, which users read: without the path of this machine.
        let name = program.file_name().unwrap_or(program.as_os_str());
        let mut command = Command::new(program);
        if self.mpi.is_some() {
            // Open MPI 4 would read the memory of other ranks directly, which the cage refuses.
            command.env("OMPI_MCA_btl_vader_single_copy_mechanism", "none");
        }
        let error = command.arg0(name).args(arguments).exec();
        Err(error).with_context(|| format!("{} cannot be started", program.display()))
    }

    fn restrict(&self, program: &Path) -> Result<()> {
        // The second version of Landlock is the least that keeps files where they are; later ones add the rest.
        let abi = ABI::V6;
        let created = Ruleset::default()
            .set_compatibility(CompatLevel::HardRequirement)
            .handle_access(AccessFs::from_all(ABI::V2))?
            .set_compatibility(CompatLevel::BestEffort)
            .handle_access(AccessFs::from_all(abi))?
            .scope(Scope::from_all(abi))?;
        let created = match &self.mpi {
            Some(_) => created,
            None => created.handle_access(AccessNet::from_all(abi))?,
        };
        let created = created.create()?;
        let mut read: Vec<&Path> = SYSTEM.iter().map(Path::new).chain([program]).collect();
        let mut write = vec![self.folder.clone()];
        if let Some(paths) = &self.mpi {
            read.extend(MPI_READS.map(Path::new));
            let own = shared_by_ranks().into_iter().chain(paths.iter().cloned());
            write.extend(own.filter(|path| path.exists()));
        }
        let status = created
            .add_rules(path_beneath_rules(
                read.into_iter().filter(|path| path.exists()),
                AccessFs::from_read(abi),
            ))?
            .add_rules(path_beneath_rules(
                [Path::new("/dev/null")],
                AccessFs::from_all(abi),
            ))?
            .add_rules(path_beneath_rules(write, AccessFs::from_all(abi) & !NEVER))?
            .restrict_self()?;
        if status.ruleset == RulesetStatus::NotEnforced {
            bail!("the kernel does not enforce Landlock");
        }
        // Of a program of root all capabilities are those of this set; one of another user has none.
        for capability in (0..u64::BITS).map(|bit| CapabilitySet::from_bits_retain(1 << bit)) {
            match remove_capability_from_bounding_set(capability) {
                Ok(()) => {}
                Err(rustix::io::Errno::PERM | rustix::io::Errno::INVAL) => break,
                Err(error) => return Err(error).context("capabilities cannot be dropped"),
            }
        }
        seccompiler::apply_filter(&filter(self.mpi.is_some())?)
            .context("the kernel takes no filter of system calls")
    }
}

/// The filter of system calls: those of [`REFUSED`] fail, and so does a signal to a thread of another process, and a socket; with `network`
/// sockets other than those of IP and of the kernel's own answers about its network.
fn filter(network: bool) -> Result<BpfProgram> {
    let own = u64::from(std::process::id());
    let other = SeccompCondition::new(0, SeccompCmpArgLen::Dword, SeccompCmpOp::Ne, own)?;
    let to_others = SeccompRule::new(vec![other])?;
    let sockets = match network {
        false => Vec::new(),
        true => {
            let of_network = [libc::AF_INET, libc::AF_INET6, libc::AF_NETLINK];
            let conditions = of_network.map(|family| {
                let (size, differs) = (SeccompCmpArgLen::Dword, SeccompCmpOp::Ne);
                SeccompCondition::new(0, size, differs, family as u64)
            });
            vec![SeccompRule::new(
                conditions.into_iter().collect::<Result<_, _>>()?,
            )?]
        }
    };
    let mut rules = BTreeMap::new();
    for bits in [0, X32] {
        // Without a rule of arguments it matches always.
        rules.extend(REFUSED.map(|call| (call | bits, Vec::new())));
        rules.insert(libc::SYS_tgkill | bits, vec![to_others.clone()]);
        rules.insert(libc::SYS_socket | bits, sockets.clone());
    }
    let filter = SeccompFilter::new(
        rules,
        SeccompAction::Allow,
        SeccompAction::Errno(libc::EPERM as u32),
        std::env::consts::ARCH.try_into()?,
    )?;
    Ok(filter.try_into()?)
}

/// Whether the kernel of this machine enforces what [`Cage`] needs.
pub fn is_there() -> bool {
    let landlock = Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_all(ABI::V2))
        .and_then(|ruleset| ruleset.create());
    landlock.is_ok() && Path::new("/proc/sys/kernel/seccomp/actions_avail").exists()
}
