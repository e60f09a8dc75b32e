//! Workers as jobs of Slurm, by `sbatch`, `squeue` and `scancel`; accounting (`sacct`) is not needed.

use std::collections::HashMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::Deserialize;

use crate::program::call;
use crate::{Abilities, Engine, EngineError, Launch, Observed, Stop};

/// What differs from site to site: `site.toml`.
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
        }
    }
}

/// Jobs of Slurm.
pub struct Slurm {
    site: Site,
    seen: Mutex<Option<(Instant, HashMap<String, Observed>)>>,
}

/// A line of `squeue -o '%i|%j|%T|%r|%N|%M'`.
struct Line {
    id: String,
    job: String,
    observed: Option<Observed>,
}

impl Slurm {
    /// On this site.
    pub fn new(site: Site) -> Self {
        Self {
            site,
            seen: Mutex::new(None),
        }
    }

    fn squeue(&self) -> Result<Vec<Line>, EngineError> {
        let text = call(
            "squeue",
            ["--me", "-t", "all", "-h", "-o", "%i|%j|%T|%r|%N|%M"],
            None,
        )?;
        Ok(text.lines().filter_map(line).collect())
    }

    /// Ids of the jobs of this name that wait or run.
    fn ids(&self, job: &str) -> Result<Vec<String>, EngineError> {
        let lines = self.squeue()?;
        Ok(lines
            .into_iter()
            .filter(|line| line.job == job && line.observed.is_some())
            .map(|line| line.id)
            .collect())
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

impl Engine for Slurm {
    fn name(&self) -> &'static str {
        "slurm"
    }

    fn submit(&self, launch: &Launch) -> Result<(), EngineError> {
        // A submission that timed out may have gone through: look for it by name first.
        if self.observe()?.contains_key(&launch.job) {
            return Ok(());
        }
        // `exec`: Slurm's signal is for the worker, not for a shell around it.
        let words: Vec<String> = launch
            .command
            .iter()
            .map(|word| quoted(&word.to_string_lossy()))
            .collect();
        let script = format!("#!/bin/sh\nexec {}\n", words.join(" "));
        let mut arguments = vec![
            "--parsable".to_owned(),
            format!("--job-name={}", launch.job),
            // The server makes attempts, and nothing else.
            "--no-requeue".to_owned(),
            format!("--signal=B:TERM@{}", self.site.grace),
            format!("--cpus-per-task={}", launch.threads),
            format!("--output={}", launch.log.display()),
            "--open-mode=append".to_owned(),
        ];
        if self.site.memory {
            arguments.push(format!("--mem={}M", launch.memory.div_ceil(1 << 20)));
        }
        for (option, value) in [
            ("partition", &self.site.partition),
            ("account", &self.site.account),
            ("qos", &self.site.qos),
            ("time", &self.site.time),
        ] {
            arguments.extend(value.as_ref().map(|value| format!("--{option}={value}")));
        }
        let submitted = call(
            "sbatch",
            arguments.iter().map(String::as_str),
            Some(&script),
        );
        let mut seen = self
            .seen
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        match (&submitted, seen.as_mut()) {
            (Ok(_), Some((_, jobs))) => {
                jobs.insert(
                    launch.job.clone(),
                    Observed::Pending("submitted".to_owned()),
                );
            }
            // Whether it went through is not known: the next try has to look anew.
            _ => *seen = None,
        }
        submitted.map(|_| ())
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
        for id in self.ids(job)? {
            match how {
                Stop::Gently => call("scancel", ["--signal=TERM", "--batch", &id], None)?,
                Stop::Hard => call("scancel", [id.as_str()], None)?,
            };
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities {
        Abilities {
            grace: f64::from(self.site.grace),
            beat: 10.0,
            cores: None,
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
