//! Workers as processes of this machine.
//!
//! A worker is a session of its own and outlives the server. It is found by its command line in `/proc`, so there is no
//! list of processes that could be wrong: a server that was killed between starting a worker and recording it finds the
//! worker all the same, and a number that was given to another process does not mislead.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs::{self, OpenOptions};
use std::io;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::MetadataExt;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;

use rustix::process::{Pid, Signal, kill_process, kill_process_group};

use crate::{Abilities, Engine, EngineError, Launch, Observed, Stop};

/// Processes of this machine.
pub struct Local {
    cores: u32,
    /// The store's URL as it stands in the workers' command lines: other servers' workers are not ours.
    store: OsString,
    /// Workers that this server started: their ends have to be collected, or they stay as zombies.
    children: Mutex<Vec<Child>>,
}

impl Local {
    /// With so many cores for runs, for the workers of this store.
    pub fn new(cores: u32, store: impl Into<OsString>) -> Self {
        Self {
            cores,
            store: store.into(),
            children: Mutex::new(Vec::new()),
        }
    }

    fn collect(&self) {
        let mut children = self
            .children
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        children.retain_mut(|child| matches!(child.try_wait(), Ok(None)));
    }

    /// The workers that live, by the name of their job.
    fn workers(&self) -> Result<HashMap<String, Pid>, EngineError> {
        self.collect();
        let mut workers = HashMap::new();
        for entry in fs::read_dir("/proc").map_err(EngineError::Proc)? {
            let Ok(entry) = entry else { continue };
            let Some(pid) = entry
                .file_name()
                .to_str()
                .and_then(|name| name.parse::<i32>().ok())
            else {
                continue;
            };
            // A process of another user is not ours, whatever it calls itself.
            let own = rustix::process::geteuid().as_raw();
            if !entry.metadata().is_ok_and(|process| process.uid() == own) {
                continue;
            }
            // Gone since.
            let Ok(line) = fs::read(entry.path().join("cmdline")) else {
                continue;
            };
            if let (Some(job), Some(pid)) = (self.job_of(&line), Pid::from_raw(pid)) {
                workers.insert(job, pid);
            }
        }
        Ok(workers)
    }

    /// The job in the command line of a worker of ours: `PROGRAM worker ... --store STORE ... --job JOB`.
    fn job_of(&self, line: &[u8]) -> Option<String> {
        let words: Vec<&[u8]> = line.split(|&byte| byte == 0).collect();
        if words.get(1) != Some(&b"worker".as_slice()) {
            return None;
        }
        let value = |option: &[u8]| {
            words
                .iter()
                .position(|word| *word == option)
                .and_then(|at| words.get(at + 1))
        };
        if *value(b"--store")? != self.store.as_bytes() {
            return None;
        }
        let job = OsString::from_vec(value(b"--job")?.to_vec());
        job.into_string().ok()
    }
}

impl Engine for Local {
    fn name(&self) -> &'static str {
        "local"
    }

    fn submit(&self, launch: &Launch) -> Result<(), EngineError> {
        if self.workers()?.contains_key(&launch.job) {
            return Ok(());
        }
        let failed = |source: io::Error| EngineError::Program {
            program: launch
                .command
                .first()
                .map(|word| word.to_string_lossy().into_owned())
                .unwrap_or_default(),
            source,
        };
        let (program, arguments) = launch
            .command
            .split_first()
            .ok_or_else(|| failed(io::ErrorKind::NotFound.into()))?;
        let log = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&launch.log)
            .map_err(failed)?;
        let child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log)
            .spawn()
            .map_err(failed)?;
        self.children
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
            .push(child);
        Ok(())
    }

    fn observe(&self) -> Result<HashMap<String, Observed>, EngineError> {
        let host = rustix::system::uname()
            .nodename()
            .to_string_lossy()
            .into_owned();
        Ok(self
            .workers()?
            .into_keys()
            .map(|job| (job, Observed::Running(host.clone())))
            .collect())
    }

    fn stop(&self, job: &str, how: Stop) -> Result<(), EngineError> {
        if let Some(&pid) = self.workers()?.get(job) {
            // The process may have ended meanwhile, which is what is wanted.
            let _ = match how {
                Stop::Gently => kill_process(pid, Signal::TERM),
                // The worker leads a session; its solver is in it.
                Stop::Hard => kill_process_group(pid, Signal::KILL)
                    .or_else(|_| kill_process(pid, Signal::KILL)),
            };
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities {
        Abilities {
            grace: 60.0,
            beat: 2.0,
            cores: Some(self.cores),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_workers_of_this_store_are_ours() {
        let engine = Local::new(1, "/data/store");
        let line = |words: &[&str]| {
            words
                .iter()
                .flat_map(|word| [word.as_bytes(), b"\0"].concat())
                .collect::<Vec<u8>>()
        };
        let ours = line(&[
            "mercury-cloud",
            "worker",
            "--store",
            "/data/store",
            "--job",
            "mc-a-1",
        ]);
        assert_eq!(engine.job_of(&ours).as_deref(), Some("mc-a-1"));
        for other in [
            &[
                "mercury-cloud",
                "worker",
                "--store",
                "/data/other",
                "--job",
                "mc-a-1",
            ][..],
            &[
                "mercury-cloud",
                "serve",
                "--store",
                "/data/store",
                "--job",
                "mc-a-1",
            ],
            &["grep", "--job", "mc-a-1"],
            &["mercury-cloud", "worker", "--job"],
            &[],
        ] {
            assert_eq!(engine.job_of(&line(other)), None, "{other:?}");
        }
    }

    /// A job is started once however often it is submitted, is found by a second engine (a server started anew), and is
    /// gone after its end. The job is a shell that is called like a worker.
    #[test]
    fn a_job_is_started_once_and_adopted() {
        let folder = tempfile::tempdir().unwrap();
        let script = folder.path().join("worker.sh");
        fs::write(&script, "echo x >> \"$0.count\"; read line < \"$0.fifo\"").unwrap();
        let store = folder.path().join("store").into_os_string();
        // `sh worker ...` reads the script `worker` in its folder; so the command line is that of a worker.
        let program = folder.path().join("worker");
        fs::rename(&script, &program).unwrap();
        let fifo = folder.path().join("worker.fifo");
        assert!(
            Command::new("mkfifo")
                .arg(&fifo)
                .status()
                .unwrap()
                .success()
        );
        let command: Vec<OsString> = ["sh", "-c", "cd \"$0\" && exec sh worker \"$@\""]
            .into_iter()
            .map(OsString::from)
            .chain([
                folder.path().into(),
                "--store".into(),
                store.clone(),
                "--job".into(),
                "mc-test-1".into(),
            ])
            .collect();
        let launch = Launch {
            job: "mc-test-1".into(),
            command,
            threads: 1,
            memory: 0,
            log: folder.path().join("log"),
            barren: 0,
        };
        let engine = Local::new(1, &store);
        engine.submit(&launch).unwrap();
        let alive = |engine: &Local| {
            for _ in 0..500 {
                if engine.observe().unwrap().contains_key("mc-test-1") {
                    return true;
                }
                std::thread::sleep(std::time::Duration::from_millis(10));
            }
            false
        };
        assert!(alive(&engine));
        engine.submit(&launch).unwrap();
        let second = Local::new(1, &store);
        assert!(alive(&second));
        second.submit(&launch).unwrap();
        second.stop("mc-test-1", Stop::Hard).unwrap();
        for _ in 0..500 {
            if engine.observe().unwrap().is_empty() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        assert!(engine.observe().unwrap().is_empty());
        assert_eq!(
            fs::read_to_string(folder.path().join("worker.count")).unwrap(),
            "x\n"
        );
    }
}
