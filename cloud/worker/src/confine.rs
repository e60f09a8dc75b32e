//! A program in a cage: it reads and writes one folder, reads the system's own files, and has no network.
//!
//! A scene may name any file (`file = "/etc/passwd"`), and a solver that meets one says what is wrong with its content.
//! So it must not be able to read it. Landlock is enforced by the kernel for this process and all that follow it.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use landlock::{
    ABI, Access, AccessFs, AccessNet, BitFlags, CompatLevel, Compatible, Ruleset, RulesetAttr,
    RulesetCreatedAttr, RulesetStatus, Scope, make_bitflags, path_beneath_rules,
};
use rustix::process::{Resource, Rlimit, Signal, setrlimit};

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

/// Paths that a program of the system needs to start: its libraries, and the files that describe the machine.
const SYSTEM: [&str; 7] = [
    "/usr",
    "/lib",
    "/lib64",
    "/bin",
    "/etc/ld.so.cache",
    "/proc",
    "/sys",
];

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
            .env_clear();
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
        Ok(())
    }
}

/// Whether the kernel of this machine enforces what [`Cage`] needs.
pub fn landlock_is_there() -> bool {
    Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_all(ABI::V2))
        .and_then(|ruleset| ruleset.create())
        .is_ok()
}
