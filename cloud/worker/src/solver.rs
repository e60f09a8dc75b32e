//! The solver as a process.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::os::fd::OwnedFd;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use cloud_api::{Branch, Cause, Ending, Spec, memory_of_rank};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open, pidfd_send_signal};

use crate::Attempt;
use crate::confine::Cage;
use crate::ranks::NOT_STARTED;

/// Name of the run's folder within that of the attempt. No input begins with a dot, so it collides with none.
pub(crate) const OUTPUT: &str = ".run";

/// Room for code, stacks and what an allocator keeps, on top of the memory that a run may have, in bytes.
const OVERHEAD: u64 = 1 << 30;

/// How much of the solver's messages an ending keeps, in bytes.
const LAST_WORDS: u64 = 2000;

/// How long `srun` may take to end its ranks.
const RANKS_END: Duration = Duration::from_secs(20);

/// A solver that runs.
pub(crate) struct Solver {
    /// The solver, or `srun`.
    child: Child,
    over: bool,
    messages: PathBuf,
    /// Of several ranks: the cores that they have.
    cores: Option<u32>,
    began: Instant,
    ended: Option<Instant>,
}

/// Message of a run that was stopped because of its length.
const TOO_LARGE: &str = "stopped with a checkpoint, because its files, or all files of its owner, take more disk than they may; \
                         make room, then resume it";

/// The exit code, or the signal that has ended it. Of several ranks `srun` gives the highest one, and a signal as 128 and its number.
fn ended_by(status: ExitStatus, is_srun: bool) -> (Option<i32>, Option<i32>) {
    match status.code() {
        Some(code @ 129..=192) if is_srun => (None, Some(code - 128)),
        code => (code, status.signal()),
    }
}

/// A solver that may have ended.
pub(crate) struct Handle(Option<OwnedFd>, Option<Pid>, Signal);

impl Handle {
    /// Stops it as [`Solver::stop`] does, if it has not ended. Kernels before 5.3 know processes by their numbers only.
    pub(crate) fn stop(&self) {
        let _ = match (&self.0, self.1) {
            (Some(process), _) => pidfd_send_signal(process, self.2),
            (None, Some(pid)) => kill_process(pid, self.2),
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
        // A branch begins in one process.
        let ranks = (attempt.ranks.as_ref()).filter(|_| branch.is_none());
        let memory = ranks.map_or(spec.memory, |ranks| {
            memory_of_rank(spec.memory, ranks.count)
        });
        let cage = Cage {
            folder: folder.to_owned(),
            sandbox: attempt.sandbox,
            memory: memory + OVERHEAD + threads * (64 << 20),
            file: spec.disk,
            ..Cage::default()
        };
        let messages = folder.join(".messages");
        let mut command = match ranks {
            Some(ranks) => ranks.command(&cage, &attempt.solver, spec.threads)?,
            None => cage.command(&attempt.solver),
        };
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
            cores: ranks.map(|ranks| ranks.count * spec.threads),
            began: Instant::now(),
            ended: None,
        })
    }

    /// Its end, if it has ended.
    pub(crate) fn ended(&mut self) -> Result<Option<ExitStatus>> {
        let status = self
            .child
            .try_wait()
            .context("the solver cannot be waited for")?;
        if status.is_some() {
            self.over = true;
            self.ended.get_or_insert_with(Instant::now);
        }
        Ok(status)
    }

    /// It writes a checkpoint and ends.
    pub(crate) fn stop(&self) {
        self.signal(self.soft_stop());
    }

    /// SIGTERM; at SIGTERM `srun` would end its ranks at once, but it hands SIGUSR2 on to them.
    fn soft_stop(&self) -> Signal {
        match self.cores {
            Some(_) => Signal::USR2,
            None => Signal::TERM,
        }
    }

    /// SIGUSR1: it writes a checkpoint and goes on.
    pub(crate) fn checkpoint(&self) {
        self.signal(Signal::USR1);
    }

    /// Ends it at once, and waits for its end.
    pub(crate) fn kill(&mut self) {
        // A killed `srun` leaves its ranks to themselves.
        if self.cores.is_some() {
            self.signal(Signal::TERM);
            let begin = Instant::now();
            while begin.elapsed() < RANKS_END && matches!(self.child.try_wait(), Ok(None)) {
                std::thread::sleep(Duration::from_millis(50));
            }
        }
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
            self.soft_stop(),
        )
    }

    fn signal(&self, signal: Signal) {
        if let Some(pid) = Pid::from_raw(self.child.id() as i32) {
            let _ = kill_process(pid, signal);
        }
    }

    /// Processor time so far, in core seconds; of several ranks, which are not children of this process, the time of their cores by the clock.
    pub(crate) fn core_seconds(&self) -> Option<f64> {
        if let Some(cores) = self.cores {
            let time = self.ended.unwrap_or_else(Instant::now) - self.began;
            return Some(f64::from(cores) * time.as_secs_f64());
        }
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
        let (code, signal) = ended_by(status, self.cores.is_some());
        let (cause, message) = match (code, signal) {
            (Some(NOT_STARTED), _) if self.cores.is_some() => (
                wanted.unwrap_or(Cause::Engine),
                format!("srun did not start the ranks. {words}"),
            ),
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
            code,
            message,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_to_a_rank_is_one_to_the_solver() {
        let exit = |code: i32| ExitStatus::from_raw(code << 8);
        for code in [0, 1, 2, 75, NOT_STARTED] {
            assert_eq!(ended_by(exit(code), true), (Some(code), None));
        }
        assert_eq!(ended_by(exit(137), true), (None, Some(9)));
        assert_eq!(ended_by(exit(137), false), (Some(137), None));
        assert_eq!(ended_by(ExitStatus::from_raw(9), false), (None, Some(9)));
    }
}
