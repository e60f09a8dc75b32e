//! Workers as processes of this machine.
//!
//! A worker is a session of its own and outlives the server. A server knows its children. Workers of a server before it are known by
//! records, which they write when they start: number and start time of the process. A record is believed if a process of this user has
//! both and the command line of the job, so that neither a number that was given again nor another program misleads.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs::{self, OpenOptions};
use std::io;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard};

use rustix::process::{Pid, Signal, kill_process, kill_process_group};

use crate::{Abilities, Engine, EngineError, Launch, Observed, Stop};

/// Variable with the path of the record that a worker writes.
const RECORD: &str = "MERCURY_CLOUD_RECORD";

/// Writes the record of this process, where an engine of this machine has started it.
pub fn record() -> io::Result<()> {
    match std::env::var_os(RECORD) {
        Some(path) => fs::write(path, fs::read("/proc/self/stat")?),
        None => Ok(()),
    }
}

/// Number and start time (clock ticks since boot) of a process, in a text as `/proc/PID/stat` has it: fields 1 and 22 (proc(5)).
fn process_of(stat: &str) -> Option<(i32, u64)> {
    let pid = stat.split_once(' ')?.0.parse().ok()?;
    // Behind the name in brackets, which may have blanks, field 3 is the first.
    let start = stat.rsplit_once(')')?.1.split_whitespace().nth(19)?;
    Some((pid, start.parse().ok()?))
}

/// Whether a process of this user has this number and start time.
fn lives(pid: i32, start: u64) -> bool {
    let folder = PathBuf::from(format!("/proc/{pid}"));
    let own = rustix::process::geteuid().as_raw();
    let stat = fs::read_to_string(folder.join("stat")).unwrap_or_default();
    fs::metadata(&folder).is_ok_and(|process| process.uid() == own)
        && process_of(&stat) == Some((pid, start))
}

/// Processes of this machine.
pub struct Local {
    cores: u32,
    /// The store's URL as it stands in the workers' command lines: other servers' workers are not ours.
    store: OsString,
    /// Folder of the records, which solvers cannot write.
    records: PathBuf,
    /// Workers that this server started, with their jobs: their ends have to be collected, or they stay as zombies.
    children: Mutex<Vec<(String, Child)>>,
}

impl Local {
    /// With so many cores for runs, for the workers of this store; `records` is a folder for this engine alone.
    pub fn new(cores: u32, store: impl Into<OsString>, records: impl Into<PathBuf>) -> Self {
        Self {
            cores,
            store: store.into(),
            records: records.into(),
            children: Mutex::new(Vec::new()),
        }
    }

    fn children(&self) -> MutexGuard<'_, Vec<(String, Child)>> {
        self.children
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// The workers that live, by the name of their job.
    fn workers(&self) -> Result<HashMap<String, Pid>, EngineError> {
        let mut workers = HashMap::new();
        self.children().retain_mut(|(job, child)| {
            let lives = matches!(child.try_wait(), Ok(None));
            if let Some(pid) = Pid::from_raw(child.id() as i32).filter(|_| lives) {
                workers.insert(job.clone(), pid);
            }
            lives
        });
        let failed = |source| EngineError::Records {
            folder: self.records.clone(),
            source,
        };
        fs::create_dir_all(&self.records).map_err(failed)?;
        for entry in fs::read_dir(&self.records).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let Some(job) = path.file_name().and_then(|name| name.to_str()) else {
                continue;
            };
            // Not written yet, or not whole.
            let stat = fs::read_to_string(&path).unwrap_or_default();
            let Some((pid, start)) = process_of(&stat) else {
                continue;
            };
            let line = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
            if self.job_of(&line).as_deref() == Some(job) && lives(pid, start) {
                workers.extend(Pid::from_raw(pid).map(|pid| (job.to_owned(), pid)));
            } else if let Err(error) = fs::remove_file(&path)
                && error.kind() != io::ErrorKind::NotFound
            {
                return Err(failed(error));
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
            .env(RECORD, self.records.join(&launch.job))
            .spawn()
            .map_err(failed)?;
        self.children().push((launch.job.clone(), child));
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
            ranks: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_workers_of_this_store_are_ours() {
        let engine = Local::new(1, "/data/store", "/data/workers");
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
        let text = format!(
            "cat /proc/$$/stat > \"${RECORD}\"; echo x >> \"$0.count\"; read line < \"$0.fifo\""
        );
        fs::write(&script, text).unwrap();
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
            ranks: 1,
            threads: 1,
            memory: 0,
            log: folder.path().join("log"),
            barren: 0,
        };
        let records = folder.path().join("records");
        let engine = Local::new(1, &store, &records);
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
        let record = records.join("mc-test-1");
        let of_worker = || process_of(&fs::read_to_string(&record).unwrap_or_default());
        let count = folder.path().join("worker.count");
        for _ in 0..500 {
            if of_worker().is_some() && count.exists() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        let stat = fs::read_to_string(&record).unwrap();
        let second = Local::new(1, &store, &records);
        assert!(alive(&second));
        // A process that has the number, and began at another time, is another one.
        let (pid, start) = process_of(&stat).unwrap();
        let other = stat.replace(&format!(" {start} "), &format!(" {} ", start - 1));
        fs::write(&record, other).unwrap();
        assert!(second.observe().unwrap().is_empty());
        assert!(!record.exists());
        assert!(
            engine.observe().unwrap().contains_key("mc-test-1"),
            "a child needs no record"
        );
        // So is one with another command line, also if it is of this user.
        let own = fs::read_to_string("/proc/self/stat").unwrap();
        fs::write(&record, own).unwrap();
        assert!(second.observe().unwrap().is_empty());
        fs::write(&record, &stat).unwrap();
        assert_eq!(
            second.workers().unwrap()["mc-test-1"],
            Pid::from_raw(pid).unwrap()
        );
        second.submit(&launch).unwrap();
        second.stop("mc-test-1", Stop::Hard).unwrap();
        for _ in 0..500 {
            if engine.observe().unwrap().is_empty() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        assert!(engine.observe().unwrap().is_empty());
        assert_eq!(fs::read_to_string(count).unwrap(), "x\n");
    }
}
