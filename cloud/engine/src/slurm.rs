//! Workers as jobs of Slurm, by `sbatch`, `squeue` and `scancel`; accounting (`sacct`) is not needed.
//!
//! Jobs that are submitted together and need the same go as one array. All tasks of an array have one name in Slurm, so a file in a
//! folder of the server says which job each task is; it is written before the array is submitted.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::Deserialize;

use crate::program::call;
use crate::{Abilities, Engine, EngineError, Launch, Observed, Stop};

/// Settings of a site: `site.toml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Site {
    /// `--partition`.
    pub partition: Option<String>,
    /// `--account`.
    pub account: Option<String>,
    /// `--qos`.
    pub qos: Option<String>,
    /// `--time`, as Slurm writes it: `1-00:00:00`.
    pub time: Option<String>,
    /// Seconds from SIGTERM to the end of the job.
    pub grace: u32,
    /// Least seconds between two calls of `squeue`.
    pub poll: f64,
    /// Whether `--mem` is passed; some sites refuse it.
    pub memory: bool,
    /// The most tasks of an array, at most the site's `MaxArraySize` less 1; below 2: no arrays.
    pub array: usize,
    /// Runs on several ranks of MPI; without this table each run is a single process.
    pub ranks: Option<Ranks>,
}

/// Settings of runs on several ranks of MPI.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ranks {
    /// The most ranks of a run.
    pub most: u32,
    /// Options of `srun`.
    #[serde(default = "pmix")]
    pub srun: Vec<String>,
    /// Files and folders that MPI of this site reads and writes, such as devices of its network.
    #[serde(default)]
    pub paths: Vec<PathBuf>,
}

fn pmix() -> Vec<String> {
    vec!["--mpi=pmix".to_owned()]
}

impl Default for Site {
    fn default() -> Self {
        Self {
            partition: None,
            account: None,
            qos: None,
            time: None,
            grace: 120,
            poll: 10.0,
            memory: true,
            array: 1000,
            ranks: None,
        }
    }
}

/// Begin of the names of arrays.
const ARRAY: &str = "mc-array-";

/// Age of a file of an array that is gone from Slurm, from which on it is removed.
const OLD: Duration = Duration::from_secs(24 * 3600);

/// Jobs of Slurm.
pub struct Slurm {
    site: Site,
    /// Where the files of arrays are.
    arrays: PathBuf,
    seen: Mutex<Option<(Instant, HashMap<String, Observed>)>>,
}

/// What a job needs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Needs {
    ranks: u32,
    threads: u32,
    /// Of each rank, in bytes.
    memory: u64,
}

impl Needs {
    fn of(launch: &Launch) -> Self {
        Self {
            ranks: launch.ranks,
            threads: launch.threads,
            memory: launch.memory,
        }
    }
}

/// A line of `squeue -o '%i|%j|%T|%r|%N|%M'`.
struct Line {
    id: String,
    job: String,
    observed: Option<Observed>,
}

impl Slurm {
    /// On this site. `arrays`: a folder for its files, which outlive the server.
    pub fn new(site: Site, arrays: PathBuf) -> Self {
        Self {
            site,
            arrays,
            seen: Mutex::new(None),
        }
    }

    fn squeue(&self) -> Result<Vec<Line>, EngineError> {
        let text = call(
            "squeue",
            ["--me", "-r", "-t", "all", "-h", "-o", "%i|%j|%T|%r|%N|%M"],
            None,
        )?;
        let mut tasks: HashMap<String, Vec<String>> = HashMap::new();
        let lines = text.lines().filter_map(line).filter_map(|mut line| {
            if line.job.starts_with(ARRAY) {
                let names = (tasks.entry(line.job)).or_insert_with_key(|array| self.tasks(array));
                let task: usize = line.id.rsplit_once('_')?.1.parse().ok()?;
                line.job = names.get(task)?.clone();
            }
            Some(line)
        });
        let lines = lines.collect();
        self.forget(&tasks);
        Ok(lines)
    }

    /// The jobs that the tasks of an array are.
    fn tasks(&self, array: &str) -> Vec<String> {
        let text = fs::read_to_string(self.arrays.join(array)).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }

    /// Removes the files of arrays that are gone from Slurm for long.
    fn forget(&self, known: &HashMap<String, Vec<String>>) {
        let names: HashSet<&str> = known.keys().map(String::as_str).collect();
        for entry in fs::read_dir(&self.arrays).into_iter().flatten().flatten() {
            let age = entry.metadata().and_then(|data| data.modified());
            let age = age.ok().and_then(|time| time.elapsed().ok());
            let is_known = entry
                .file_name()
                .to_str()
                .is_some_and(|name| names.contains(name));
            if !is_known && age.is_some_and(|age| age > OLD) {
                // The next look tries again.
                let _ = fs::remove_file(entry.path());
            }
        }
    }

    /// The arguments of `sbatch` for a job with these needs.
    fn arguments(&self, name: &str, needs: Needs, log: &Path) -> Vec<String> {
        let mut arguments = vec![
            "--parsable".to_owned(),
            format!("--job-name={name}"),
            // The server makes attempts, and nothing else.
            "--no-requeue".to_owned(),
            format!("--signal=B:TERM@{}", self.site.grace),
            format!("--ntasks={}", needs.ranks),
            format!("--cpus-per-task={}", needs.threads),
            format!("--output={}", log.display()),
            "--open-mode=append".to_owned(),
        ];
        if self.site.memory {
            // `--mem` is that of a node, which has as many of the ranks as there is room for.
            let (option, cores) = match needs.ranks {
                1 => ("--mem", 1),
                _ => ("--mem-per-cpu", u64::from(needs.threads)),
            };
            arguments.push(format!("{option}={}M", needs.memory.div_ceil(cores << 20)));
        }
        for (option, value) in [
            ("partition", &self.site.partition),
            ("account", &self.site.account),
            ("qos", &self.site.qos),
            ("time", &self.site.time),
        ] {
            arguments.extend(value.as_ref().map(|value| format!("--{option}={value}")));
        }
        arguments
    }

    /// Calls `sbatch`, and notes that the jobs are on their way.
    fn sbatch(
        &self,
        arguments: &[String],
        script: &str,
        jobs: &[&Launch],
    ) -> Result<(), EngineError> {
        let submitted = call("sbatch", arguments.iter().map(String::as_str), Some(script));
        let mut seen = self
            .seen
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        match (&submitted, seen.as_mut()) {
            (Ok(_), Some((_, seen))) => {
                let waits = || Observed::Pending("submitted".to_owned());
                seen.extend(jobs.iter().map(|launch| (launch.job.clone(), waits())));
            }
            // Whether it went through is not known: the next try has to look anew.
            _ => *seen = None,
        }
        submitted.map(|_| ())
    }

    /// Submits jobs with the same needs as one array.
    fn submit_array(&self, jobs: &[&Launch]) -> Result<(), EngineError> {
        let failed = |source| EngineError::Program {
            program: format!("the file of an array in {}", self.arrays.display()),
            source,
        };
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let name = format!("{ARRAY}{}", now.map_or(0, |now| now.as_nanos()));
        let names: String = jobs
            .iter()
            .map(|launch| format!("{}\n", launch.job))
            .collect();
        fs::create_dir_all(&self.arrays).map_err(failed)?;
        let mut file = fs::File::create_new(self.arrays.join(&name)).map_err(failed)?;
        file.write_all(names.as_bytes()).map_err(failed)?;
        file.sync_all().map_err(failed)?;
        let mut arguments = self.arguments(&name, Needs::of(jobs[0]), Path::new("/dev/null"));
        arguments.push(format!("--array=0-{}", jobs.len() - 1));
        self.sbatch(&arguments, &array_script(jobs), jobs)
    }
}

/// The arguments of `scancel` for a job. One that waits gets no signal, and is ended at once.
fn cancel<'a>(id: &'a str, observed: &Observed, how: Stop) -> Vec<&'a str> {
    match (how, observed) {
        (Stop::Gently, Observed::Running(_)) => vec!["--signal=TERM", "--batch", id],
        _ => vec![id],
    }
}

fn line(text: &str) -> Option<Line> {
    let mut words = text.split('|');
    let (id, job, state) = (words.next()?, words.next()?, words.next()?);
    let (reason, nodes) = (words.next()?, words.next()?);
    if !job.starts_with("mc-") {
        return None;
    }
    let observed = match state {
        "PENDING" | "CONFIGURING" | "REQUEUED" | "SUSPENDED" | "REQUEUE_HOLD" | "RESV_DEL_HOLD" => {
            Some(Observed::Pending(reason.to_owned()))
        }
        "RUNNING" | "COMPLETING" | "SIGNALING" | "STAGE_OUT" | "STOPPED" | "RESIZING" => {
            Some(Observed::Running(nodes.to_owned()))
        }
        // Ended in one way or other; how it ended is in the store, or it was lost.
        _ => None,
    };
    Some(Line {
        id: id.to_owned(),
        job: job.to_owned(),
        observed,
    })
}

/// A word for a shell, in single quotes.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// `exec` and the words of a command: Slurm's signal is for the worker, not for a shell around it.
fn exec(launch: &Launch) -> String {
    let words = launch
        .command
        .iter()
        .map(|word| quoted(&word.to_string_lossy()));
    format!("exec {}", words.collect::<Vec<_>>().join(" "))
}

/// A script in which each task of an array finds its command.
fn array_script(jobs: &[&Launch]) -> String {
    let mut script = "#!/bin/sh\ncase \"$SLURM_ARRAY_TASK_ID\" in\n".to_owned();
    for (task, launch) in jobs.iter().enumerate() {
        let log = quoted(&launch.log.to_string_lossy());
        script += &format!("{task}) {} >> {log} 2>&1 ;;\n", exec(launch));
    }
    script + "esac\n"
}

impl Engine for Slurm {
    fn name(&self) -> &'static str {
        "slurm"
    }

    fn submit(&self, launch: &Launch) -> Result<(), EngineError> {
        // A submission that timed out may have gone through: look for it by name first.
        if self.observe()?.contains_key(&launch.job) {
            return Ok(());
        }
        let arguments = self.arguments(&launch.job, Needs::of(launch), &launch.log);
        let script = format!("#!/bin/sh\n{}\n", exec(launch));
        self.sbatch(&arguments, &script, &[launch])
    }

    fn submit_all(&self, launches: &[Launch]) -> Vec<Result<(), EngineError>> {
        let there = match self.observe() {
            Ok(there) => there,
            // Each of them says why.
            Err(_) => return launches.iter().map(|launch| self.submit(launch)).collect(),
        };
        let mut alike: BTreeMap<Needs, Vec<usize>> = BTreeMap::new();
        for (number, launch) in launches.iter().enumerate() {
            if !there.contains_key(&launch.job) {
                alike.entry(Needs::of(launch)).or_default().push(number);
            }
        }
        let mut came: Vec<Result<(), EngineError>> = launches.iter().map(|_| Ok(())).collect();
        for part in alike
            .values()
            .flat_map(|all| all.chunks(self.site.array.max(1)))
        {
            let jobs: Vec<&Launch> = part.iter().map(|&number| &launches[number]).collect();
            let submitted = match jobs[..] {
                [one] => self.submit(one),
                _ => self.submit_array(&jobs),
            };
            if let Err(error) = submitted {
                for &number in part {
                    came[number] = Err(EngineError::Refused {
                        program: "sbatch".to_owned(),
                        message: error.to_string(),
                    });
                }
            }
        }
        came
    }

    fn observe(&self) -> Result<HashMap<String, Observed>, EngineError> {
        let mut seen = self
            .seen
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some((at, jobs)) = &*seen
            && at.elapsed() < Duration::from_secs_f64(self.site.poll)
        {
            return Ok(jobs.clone());
        }
        let jobs: HashMap<String, Observed> = self
            .squeue()?
            .into_iter()
            .filter_map(|line| Some((line.job, line.observed?)))
            .collect();
        *seen = Some((Instant::now(), jobs.clone()));
        Ok(jobs)
    }

    fn stop(&self, job: &str, how: Stop) -> Result<(), EngineError> {
        let lines = self.squeue()?;
        for line in lines.iter().filter(|line| line.job == job) {
            if let Some(observed) = &line.observed {
                call("scancel", cancel(&line.id, observed, how), None)?;
            }
        }
        // The next look sees what has become of it.
        *self
            .seen
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner()) = None;
        Ok(())
    }

    fn abilities(&self) -> Abilities {
        Abilities {
            grace: f64::from(self.site.grace),
            beat: 10.0,
            cores: None,
            ranks: self
                .site
                .ranks
                .as_ref()
                .map_or(1, |ranks| ranks.most.max(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_squeue_are_read() {
        let running = line("17|mc-ab-2|RUNNING|None|n1|0:21").unwrap();
        assert_eq!(
            (running.id.as_str(), running.job.as_str()),
            ("17", "mc-ab-2")
        );
        assert_eq!(running.observed, Some(Observed::Running("n1".into())));
        let pending = line("18|mc-ab-3|PENDING|Resources||0:00").unwrap();
        assert_eq!(
            pending.observed,
            Some(Observed::Pending("Resources".into()))
        );
        // `-t all` lists jobs that have ended, too.
        for state in [
            "COMPLETED",
            "FAILED",
            "NODE_FAIL",
            "PREEMPTED",
            "TIMEOUT",
            "CANCELLED",
        ] {
            assert_eq!(
                line(&format!("19|mc-ab-4|{state}|None|n1|0:02"))
                    .unwrap()
                    .observed,
                None
            );
        }
        assert!(line("20|another|RUNNING|None|n1|0:02").is_none());
        assert!(line("").is_none());
    }

    #[test]
    fn a_job_that_waits_is_cancelled_and_one_that_runs_gets_a_signal() {
        let waits = Observed::Pending("Resources".into());
        let runs = Observed::Running("n1".into());
        let signal = ["--signal=TERM", "--batch", "7"];
        assert_eq!(cancel("7", &waits, Stop::Gently), ["7"]);
        assert_eq!(cancel("7", &runs, Stop::Gently), signal);
        assert_eq!(cancel("7", &runs, Stop::Hard), ["7"]);
    }

    #[test]
    fn several_ranks_are_tasks_with_memory_by_core() {
        let site: Site = toml::from_str("[ranks]\nmost = 4").unwrap();
        let slurm = Slurm::new(site, PathBuf::new());
        assert_eq!(slurm.abilities().ranks, 4);
        let needs = |ranks| Needs {
            ranks,
            threads: 3,
            memory: 301 << 20,
        };
        let arguments = |ranks| slurm.arguments("mc-ab-1", needs(ranks), Path::new("log"));
        for word in ["--ntasks=2", "--cpus-per-task=3", "--mem-per-cpu=101M"] {
            assert!(arguments(2).iter().any(|one| one == word), "{word}");
        }
        for word in ["--ntasks=1", "--cpus-per-task=3", "--mem=301M"] {
            assert!(arguments(1).iter().any(|one| one == word), "{word}");
        }
    }

    #[test]
    fn a_site_file_offers_ranks_only_by_its_table() {
        let site: Site = toml::from_str("grace = 60").unwrap();
        assert_eq!(Slurm::new(site, PathBuf::new()).abilities().ranks, 1);
        let site: Site = toml::from_str("[ranks]\nmost = 2\nsrun = []").unwrap();
        assert!(site.ranks.unwrap().srun.is_empty());
        let wrong = toml::from_str::<Site>("[ranks]\nmost = 2\nnodes = 1").unwrap_err();
        assert!(wrong.message().contains("nodes"), "{wrong}");
    }

    #[test]
    fn each_task_of_an_array_runs_its_own_command() {
        use std::process::Command;
        let folder = tempfile::tempdir().unwrap();
        let launches: Vec<Launch> = (0..3)
            .map(|k| Launch {
                job: format!("mc-ab-{k}"),
                command: vec!["echo".into(), format!("task {k} it's").into()],
                ranks: 1,
                threads: 1,
                memory: 1,
                log: folder.path().join(format!("{k}.log")),
                barren: 0,
            })
            .collect();
        let script = array_script(&launches.iter().collect::<Vec<_>>());
        for k in 0..3 {
            let mut shell = Command::new("sh");
            shell
                .args(["-c", &script])
                .env("SLURM_ARRAY_TASK_ID", k.to_string());
            assert!(shell.status().unwrap().success());
            let said = fs::read_to_string(folder.path().join(format!("{k}.log"))).unwrap();
            assert_eq!(said, format!("task {k} it's\n"));
        }
    }

    #[test]
    fn words_survive_the_shell() {
        use std::process::Command;
        for word in ["a b", "it's", "$(reboot)", "`x`", "\\", "\n"] {
            let output = Command::new("sh")
                .args(["-c", &format!("printf %s {}", quoted(word))])
                .output()
                .unwrap();
            assert_eq!(String::from_utf8(output.stdout).unwrap(), word);
        }
    }
}
