//! A program in a cage: it reads and writes one folder, reads the system's own files, and has neither a network nor other processes.
//!
//! A scene may name any file (`file = "/etc/passwd"`), and a solver that meets one says what is wrong with its content.
//! So it must not be able to read it. The kernel enforces this for the process and all that follow it: Landlock for files, a filter of
//! system calls (seccomp) for sockets of all kinds, signals and the memory of others, and no capabilities.

use std::collections::BTreeMap;
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

/// System calls that no program in a cage makes: sockets (also of `io_uring`, which makes them by itself), signals to others, memory and
/// files of other processes, and parts of the kernel that programs rarely need and attackers often use. A pair of sockets without a name
/// reaches nothing else: programs wake their threads with it.
const REFUSED: [libc::c_long; 22] = [
    libc::SYS_socket,
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
        command.arg("confine").arg("--folder").arg(&self.folder);
        if !self.sandbox {
            command.arg("--no-sandbox");
        }
        for (option, value) in [
            ("--memory", self.memory),
            ("--file", self.file),
            ("--cpu", self.cpu),
        ] {
            command.arg(option).arg(value.to_string());
        }
        command
            .arg("--")
            .arg(program)
            .current_dir(&self.folder)
            // Without credentials of the store, which are the worker's.
            .env_clear()
            .env("TMPDIR", &self.folder);
        command
    }

    /// Becomes `program` in this cage. Returns only if that fails.
    pub fn enter(&self, program: &Path, arguments: &[std::ffi::OsString]) -> Result<()> {
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
        let error = Command::new(program).arg0(name).args(arguments).exec();
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
            .handle_access(AccessNet::from_all(abi))?
            .scope(Scope::from_all(abi))?
            .create()?;
        let read = SYSTEM.iter().map(Path::new).chain([program]);
        let status = created
            .add_rules(path_beneath_rules(
                read.filter(|path| path.exists()),
                AccessFs::from_read(abi),
            ))?
            .add_rules(path_beneath_rules(
                [Path::new("/dev/null")],
                AccessFs::from_all(abi),
            ))?
            .add_rules(path_beneath_rules(
                [&self.folder],
                AccessFs::from_all(abi) & !NEVER,
            ))?
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
        seccompiler::apply_filter(&filter()?).context("the kernel takes no filter of system calls")
    }
}

/// The filter of system calls: those of [`REFUSED`] fail, and so does a signal to a thread of another process.
fn filter() -> Result<BpfProgram> {
    let own = u64::from(std::process::id());
    let other = SeccompCondition::new(0, SeccompCmpArgLen::Dword, SeccompCmpOp::Ne, own)?;
    let to_others = SeccompRule::new(vec![other])?;
    let mut rules = BTreeMap::new();
    for bits in [0, X32] {
        // Without a rule of arguments it matches always.
        rules.extend(REFUSED.map(|call| (call | bits, Vec::new())));
        rules.insert(libc::SYS_tgkill | bits, vec![to_others.clone()]);
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
