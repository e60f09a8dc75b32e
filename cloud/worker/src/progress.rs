//! Progress of the solver: the lines of `--progress` (`docs/formats/machine.md`).

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Instant;

use cloud_api::names::{Growth, growth};
use serde_json::Value;

/// A checkpoint that is whole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NewCheckpoint {
    pub(crate) name: String,
    pub(crate) step: u64,
    pub(crate) outputs: BTreeMap<String, u64>,
}

/// The state of the run, as its lines say it.
pub(crate) struct Progress {
    path: PathBuf,
    file: Option<File>,
    read: u64,
    rest: Vec<u8>,
    /// The newest checkpoint that was not taken yet.
    pub(crate) checkpoint: Option<NewCheckpoint>,
    /// Names of the files that the solver appends to.
    pub(crate) grows: BTreeSet<String>,
    /// Activity of the solver, while it makes no steps.
    pub(crate) doing: String,
    pub(crate) step: u64,
    pub(crate) of_steps: Option<u64>,
    pub(crate) time: f64,
    pub(crate) particles: Option<u64>,
    pub(crate) rate: Option<f64>,
    pub(crate) seconds_left: Option<f64>,
    /// Cause in the last line, `end`.
    pub(crate) end_cause: Option<String>,
    /// When it was last certain that the solver works: a new step or a phase that says why there is none.
    pub(crate) alive: Instant,
}

impl Progress {
    pub(crate) fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            file: None,
            read: 0,
            rest: Vec::new(),
            checkpoint: None,
            grows: BTreeSet::new(),
            doing: String::new(),
            step: 0,
            of_steps: None,
            time: 0.0,
            particles: None,
            rate: None,
            seconds_left: None,
            end_cause: None,
            alive: Instant::now(),
        }
    }

    /// Reads the lines that have come since.
    pub(crate) fn read(&mut self) -> io::Result<()> {
        if self.file.is_none() {
            match File::open(&self.path) {
                Ok(file) => self.file = Some(file),
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
                Err(error) => return Err(error),
            }
        }
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        file.seek(SeekFrom::Start(self.read))?;
        self.read += file.read_to_end(&mut self.rest)? as u64;
        while let Some(at) = self.rest.iter().position(|&byte| byte == b'\n') {
            let line: Vec<u8> = self.rest.drain(..=at).collect();
            // A line that is no JSON is another version's; what is understood counts.
            if let Ok(line) = serde_json::from_slice(&line) {
                self.take(&line);
            }
        }
        Ok(())
    }

    fn take(&mut self, line: &Value) {
        let whole = |name: &str| line[name].as_u64();
        match line["event"].as_str().unwrap_or_default() {
            "phase" => {
                let phase = line["phase"].as_str().unwrap_or_default();
                self.doing = match (phase, whole("placed"), whole("of")) {
                    ("stepping", ..) => String::new(),
                    (phase, Some(placed), Some(of)) => format!("{phase}: {placed} of {of}"),
                    (phase, Some(placed), None) => format!("{phase}: {placed}"),
                    (phase, ..) => phase.to_owned(),
                };
                if phase != "stepping" {
                    self.alive = Instant::now();
                }
            }
            "run" => {
                self.of_steps = whole("steps");
                self.step = line["resumed"]["step"].as_u64().unwrap_or(0);
                self.time = line["resumed"]["time"].as_f64().unwrap_or(0.0);
                self.alive = Instant::now();
            }
            "step" => {
                let step = whole("step").unwrap_or(self.step);
                if step != self.step {
                    self.alive = Instant::now();
                }
                self.doing.clear();
                self.step = step;
                self.of_steps = whole("of_steps").or(self.of_steps);
                self.time = line["time"].as_f64().unwrap_or(self.time);
                self.particles = whole("particles").or(self.particles);
                self.rate = line["particle_steps_per_second"].as_f64();
                self.seconds_left = line["seconds_left"].as_f64();
            }
            "checkpoint" => {
                self.alive = Instant::now();
                self.note_growing(line);
                let outputs = line["outputs"].as_array().into_iter().flatten();
                self.checkpoint = line["file"].as_str().map(|name| NewCheckpoint {
                    name: name.to_owned(),
                    step: whole("step").unwrap_or(self.step),
                    outputs: outputs
                        .filter_map(|file| {
                            Some((file["name"].as_str()?.to_owned(), file["bytes"].as_u64()?))
                        })
                        .collect(),
                });
            }
            "frame" => {
                self.note_growing(line);
                self.alive = Instant::now();
            }
            "end" => {
                self.step = whole("step").unwrap_or(self.step);
                self.time = line["time"].as_f64().unwrap_or(self.time);
                self.end_cause = line["cause"].as_str().map(str::to_owned);
                self.seconds_left = None;
            }
            _ => {}
        }
    }

    fn note_growing(&mut self, line: &Value) {
        let names = line["outputs"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(|file| file["name"].as_str());
        let growing = names.filter(|name| matches!(growth(name), Growth::Frames | Growth::Lines));
        self.grows.extend(growing.map(str::to_owned));
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn lines_are_taken_as_they_become_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("progress");
        let mut progress = Progress::new(&path);
        progress.read().unwrap();
        let mut file = File::create(&path).unwrap();
        writeln!(
            file,
            r#"{{"event":"phase","phase":"inserting","placed":3,"of":900}}"#
        )
        .unwrap();
        write!(file, r#"{{"event":"step","step":12,"of_st"#).unwrap();
        progress.read().unwrap();
        assert_eq!(
            (progress.step, progress.doing.as_str()),
            (0, "inserting: 3 of 900")
        );
        writeln!(
            file,
            r#"eps":500,"time":0.25,"particles":900,"seconds_left":null}}"#
        )
        .unwrap();
        writeln!(file, r#"not json"#).unwrap();
        writeln!(
            file,
            r#"{{"event":"checkpoint","step":12,"file":"a.0.restart","outputs":[{{"name":"a.ene","bytes":77}}]}}"#
        )
        .unwrap();
        progress.read().unwrap();
        assert_eq!(
            (progress.step, progress.of_steps, progress.time),
            (12, Some(500), 0.25)
        );
        assert_eq!((progress.doing.as_str(), progress.seconds_left), ("", None));
        let outputs = BTreeMap::from([("a.ene".to_owned(), 77)]);
        let checkpoint = NewCheckpoint {
            name: "a.0.restart".into(),
            step: 12,
            outputs,
        };
        assert_eq!(progress.checkpoint, Some(checkpoint));
    }
}
