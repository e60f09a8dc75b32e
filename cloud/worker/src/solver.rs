//! The solver as a process.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::os::fd::OwnedFd;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus, Stdio};

use anyhow::{Context, Result};
use cloud_api::{Branch, Cause, Ending, Spec};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open, pidfd_send_signal};

use crate::Attempt;
use crate::confine::Cage;

/// Name of the run's folder within that of the attempt. No input begins with a dot, so it collides with none.
pub(crate) const OUTPUT: &str = ".run";

/// Room for code, stacks and what an allocator keeps, on top of the memory that a run may have, in bytes.
const OVERHEAD: u64 = 1 << 30;

/// How much of the solver's messages an ending keeps, in bytes.
const LAST_WORDS: u64 = 2000;

/// A solver that runs.
pub(crate) struct Solver {
    child: Child,
    over: bool,
    messages: PathBuf,
}

/// Message of a run that was stopped because of its length.
const TOO_LARGE: &str = "stopped with a checkpoint, because its files, or all files of its owner, take more disk than they may; \
                         make room, then resume it";

/// A solver that may have ended.
pub(crate) struct Handle(Option<OwnedFd>, Option<Pid>);

impl Handle {
    /// SIGTERM, if it has not ended. Kernels before 5.3 know processes by their numbers only.
    pub(crate) fn stop(&self) {
        let _ = match (&self.0, self.1) {
            (Some(process), _) => pidfd_send_signal(process, Signal::TERM),
            (None, Some(pid)) => kill_process(pid, Signal::TERM),
            (None, None) => Ok(()),
        };
    }
}

impl Solver {
    pub(crate) fn start(
        attempt: &Attempt,
        spec: &Spec,
        branch: Option<&Branch>,
        folder: &Path,
        progress: &Path,
    ) -> Result<Self> {
        let threads = u64::from(spec.threads);
        let cage = Cage {
            folder: folder.to_owned(),
            sandbox: attempt.sandbox,
            memory: spec.memory + OVERHEAD + threads * (64 << 20),
            file: spec.disk,
            cpu: 0,
        };
        let messages = folder.join(".messages");
        let mut command = cage.command(&attempt.solver);
        let set = match branch {
            None => {
                command.arg(&spec.scene).args(["--resume", "--within", "."]);
                &spec.set
            }
            Some(branch) => {
                command.arg("--from").arg(branch.run.as_str());
                command.arg(format!("--at={}", branch.at));
                &branch.set
            }
        };
        command
            .arg("--json")
            .arg("--output")
            .arg(OUTPUT)
            .arg("--progress")
            .arg(progress);
        command
            .arg("--threads")
            .arg(spec.threads.to_string())
            .args(["--checkpoint-every", &attempt.checkpoint]);
        for set in set {
            command.arg(format!("--set={set}"));
        }
        for result in &spec.result {
            command.arg(format!("--result={result}"));
        }
        if let Some(limit) = &attempt.limit {
            command.args(["--time-limit", limit]);
        }
        let written = File::create(&messages).with_context(|| format!("{}", messages.display()))?;
        let answer = File::create(folder.join(".answer"))
            .context("the folder of the attempt cannot be written")?;
        let child = command
            .stdin(Stdio::null())
            .stdout(answer)
            .stderr(written)
            .spawn()
            .with_context(|| format!("{} cannot be started", attempt.solver.display()))?;
        Ok(Self {
            child,
            over: false,
            messages,
        })
    }

    /// Its end, if it has ended.
    pub(crate) fn ended(&mut self) -> Result<Option<ExitStatus>> {
        let status = self
            .child
            .try_wait()
            .context("the solver cannot be waited for")?;
        self.over |= status.is_some();
        Ok(status)
    }

    /// SIGTERM: it writes a checkpoint and ends.
    pub(crate) fn stop(&self) {
        self.signal(Signal::TERM);
    }

    /// SIGUSR1: it writes a checkpoint and goes on.
    pub(crate) fn checkpoint(&self) {
        self.signal(Signal::USR1);
    }

    /// SIGKILL, and waits for its end.
    pub(crate) fn kill(&mut self) {
        // One that has ended already cannot be killed, which is what is wanted.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// A way to stop it from another thread, which never hits another process.
    pub(crate) fn handle(&self) -> Handle {
        let pid = Pid::from_raw(self.child.id() as i32);
        Handle(
            pid.and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok()),
            pid,
        )
    }

    fn signal(&self, signal: Signal) {
        if let Some(pid) = Pid::from_raw(self.child.id() as i32) {
            let _ = kill_process(pid, signal);
        }
    }

    /// Processor time so far, in core seconds.
    pub(crate) fn core_seconds(&self) -> Option<f64> {
        // Behind the name in brackets: state is field 3, user and system time are 14 and 15, those of children that have
        // ended 16 and 17 (proc(5)). This process has no other child.
        let (process, first) = if self.over {
            ("self".to_owned(), 13)
        } else {
            (self.child.id().to_string(), 11)
        };
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
        let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        let ticks: f64 =
            fields.get(first)?.parse::<f64>().ok()? + fields.get(first + 1)?.parse::<f64>().ok()?;
        Some(ticks / rustix::param::clock_ticks_per_second() as f64)
    }

    /// Length of its messages, and the last bytes of them, so many at most.
    pub(crate) fn messages(&self, most: u64) -> std::io::Result<(u64, String)> {
        let mut file = File::open(&self.messages)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(most)))?;
        let mut bytes = Vec::new();
        file.take(most).read_to_end(&mut bytes)?;
        Ok((length, String::from_utf8_lossy(&bytes).into_owned()))
    }

    /// Its last messages.
    fn last_words(&self) -> String {
        let (_, words) = self.messages(LAST_WORDS).unwrap_or_default();
        words.trim().to_owned()
    }

    /// Meaning of its exit status. `wanted`: the cause for which this worker has stopped it, if it has.
    pub(crate) fn ending(
        &self,
        status: ExitStatus,
        wanted: Option<Cause>,
        end_cause: Option<&str>,
    ) -> Ending {
        let words = self.last_words();
        let (cause, message) = match (status.code(), status.signal()) {
            (Some(0), _) => (Cause::Finished, String::new()),
            (Some(75), _) => match (wanted, end_cause) {
                (Some(Cause::Disk), _) => (Cause::Disk, TOO_LARGE.to_owned()),
                (Some(cause), _) => (cause, String::new()),
                (None, Some("time_limit")) => (Cause::Time, String::new()),
                (None, _) => (Cause::Preempted, String::new()),
            },
            (Some(1), _) => (Cause::Failed, words),
            (Some(2), _) => (Cause::Input, words),
            (Some(code), _) => (
                wanted.unwrap_or(Cause::Failed),
                format!("exit code {code}. {words}"),
            ),
            (None, signal) => {
                let signal = signal.unwrap_or(0);
                let memory = words.contains("memory allocation of");
                let cause = wanted.unwrap_or(if memory { Cause::Memory } else { Cause::Lost });
                (
                    cause,
                    format!("the solver was ended by signal {signal}. {words}"),
                )
            }
        };
        Ending {
            cause,
            code: status.code(),
            message,
        }
    }
}
