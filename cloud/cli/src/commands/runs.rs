//! Commands about runs.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::{Value, json};

use super::projects::project_id;
use super::{Server, encoded, say, text_of};
use crate::client::Client;

#[derive(Debug, Args)]
pub(crate) struct List {
    #[command(flatten)]
    server: Server,
    /// Runs in this state only
    #[arg(long)]
    state: Option<String>,
    /// Runs with this label only
    #[arg(long)]
    label: Option<String>,
    /// Runs of a project, by name or id; without it your own
    #[arg(long)]
    project: Option<String>,
}

impl List {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let mut query = String::from("/runs?");
        for (name, value) in [("state", &self.state), ("label", &self.label)] {
            if let Some(value) = value {
                query += &format!("{name}={}&", encoded(value));
            }
        }
        if let Some(project) = &self.project {
            query += &format!("project={}&", project_id(&client, project)?);
        }
        let mut after = String::new();
        let mut all = Vec::new();
        loop {
            let page = client.json(&format!("{query}{after}"))?;
            for run in page["runs"].as_array().into_iter().flatten() {
                if self.server.json {
                    all.push(run.clone());
                } else {
                    say(&line(run))?;
                }
            }
            match page["after"].as_str() {
                Some(next) => after = format!("after={next}"),
                None => break,
            }
        }
        if self.server.json {
            say(&format!("{:#}", Value::Array(all)))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// A run as one line.
fn line(run: &Value) -> String {
    let text = |name: &str| run[name].as_str().unwrap_or_default().to_owned();
    let step = run["step"].as_f64().unwrap_or(0.0);
    let share = run["of_steps"]
        .as_f64()
        .filter(|&of| of > 0.0)
        .map(|of| format!("{:3.0} %", 100.0 * step / of));
    let (share, cause) = (share.unwrap_or_else(|| "     ".into()), text("cause"));
    let cause = if cause.is_empty() || cause == text("state") {
        String::new()
    } else {
        format!(" ({cause})")
    };
    format!(
        "{}  {:9}  {share}  {}{cause}",
        &text("id")[..12.min(text("id").len())],
        text("state"),
        text("title")
    )
}

#[derive(Debug, Args)]
pub(crate) struct One {
    #[command(flatten)]
    server: Server,
    /// The run
    run: String,
}

impl One {
    pub(crate) fn change(self, what: &str) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let id = client.id(&self.run)?;
        let run = client.post(&format!("/runs/{id}/{what}"), &json!({}))?;
        self.server.show(&run, line)?;
        Ok(ExitCode::SUCCESS)
    }

    pub(crate) fn watch(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let id = client.id(&self.run)?;
        watch(&client, &id)
    }
}

/// Prints a line whenever it has changed, until the run ends. Exit code 1 if it failed.
pub(super) fn watch(client: &Client, id: &str) -> Result<ExitCode> {
    let mut before = String::new();
    loop {
        let run = client.json(&format!("/runs/{id}"))?;
        let now = line(&run);
        if now != before {
            say(&now)?;
        }
        before = now;
        match run["state"].as_str().unwrap_or_default() {
            "queued" | "running" | "stopping" => thread::sleep(Duration::from_secs(1)),
            "failed" => {
                eprintln!("{}", run["message"].as_str().unwrap_or_default());
                return Ok(ExitCode::FAILURE);
            }
            _ => return Ok(ExitCode::SUCCESS),
        }
    }
}

/// A verification in words, and its exit code: as those of `mercury-solve verify`.
fn outcome(found: &Value) -> (String, u8) {
    let message = text_of(&found["message"]);
    let share = 100.0 * found["share"].as_f64().unwrap_or(0.0);
    let link = text_of(&found["link"]);
    match text_of(&found["verdict"]) {
        "verified" => (
            format!("verified: {share:.1} % of the steps made again, the last link is {link}"),
            0,
        ),
        "differs" => (format!("differs: {message}"), 1),
        _ => (format!("cannot be verified: {message}"), 2),
    }
}

#[derive(Debug, Args)]
pub(crate) struct Verify {
    #[command(flatten)]
    server: Server,
    /// The run
    run: String,
}

impl Verify {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let path = format!("/runs/{}/verification", client.id(&self.run)?);
        let mut found = client.post(&path, &json!({}))?;
        while found["verdict"] == "running" {
            thread::sleep(Duration::from_millis(500));
            found = client.json(&path)?;
        }
        let (_, code) = outcome(&found);
        self.server.show(&found, |found| outcome(found).0)?;
        Ok(ExitCode::from(code))
    }
}

#[derive(Debug, Args)]
pub(crate) struct Resume {
    #[command(flatten)]
    server: Server,
    /// The run
    run: String,
    /// Ranks of MPI from now on [default: as before]
    #[arg(long)]
    ranks: Option<u32>,
}

impl Resume {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let query = (self.ranks).map_or(String::new(), |ranks| format!("?ranks={ranks}"));
        let path = format!("/runs/{}/resume{query}", client.id(&self.run)?);
        self.server.show(&client.post(&path, &json!({}))?, line)?;
        Ok(ExitCode::SUCCESS)
    }
}

#[derive(Debug, Args)]
pub(crate) struct Extend {
    #[command(flatten)]
    server: Server,
    /// The run
    run: String,
    /// The new end, in s of simulated time
    #[arg(long, value_name = "S")]
    end: f64,
}

impl Extend {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let id = client.id(&self.run)?;
        let run = client.post(&format!("/runs/{id}/extend"), &json!({"end": self.end}))?;
        self.server.show(&run, line)?;
        Ok(ExitCode::SUCCESS)
    }
}

#[derive(Debug, Args)]
pub(crate) struct Branch {
    #[command(flatten)]
    server: Server,
    /// The run
    run: String,
    /// Simulated time up to which the new run is that one, in s
    #[arg(long, value_name = "S")]
    at: f64,
    /// Replace a value of the scene from there on; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Title in lists [default: that of the run]
    #[arg(long)]
    title: Option<String>,
    /// Show progress until the new run ends
    #[arg(long)]
    watch: bool,
}

impl Branch {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let id = client.id(&self.run)?;
        let body = json!({"at": self.at, "set": self.set, "title": self.title});
        let run = client.post(&format!("/runs/{id}/branch"), &body)?;
        let id = text_of(&run["id"]);
        self.server.show(&run, |_| id.to_owned())?;
        if self.watch {
            watch(&client, id)
        } else {
            Ok(ExitCode::SUCCESS)
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Clone {
    #[command(flatten)]
    server: Server,
    /// The run
    run: String,
    /// Replace a value of the scene; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Title in lists [default: that of the run]
    #[arg(long)]
    title: Option<String>,
    /// Threads that compute [default: those of the run]
    #[arg(long)]
    threads: Option<u32>,
    /// Ranks of MPI [default: those of the run]
    #[arg(long)]
    ranks: Option<u32>,
    /// Show progress until the new run ends
    #[arg(long)]
    watch: bool,
}

impl Clone {
    /// Submits the scene of a run anew, with its files and `--set`; those of this command come behind them, and so win.
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let id = client.id(&self.run)?;
        let mut body = client.post(&format!("/runs/{id}/clone"), &json!({}))?;
        if let Some(set) = body["scene"]["set"].as_array_mut() {
            set.extend(self.set.iter().map(|set| json!(set)));
        }
        if let Some(title) = &self.title {
            body["title"] = json!(title);
        }
        for (member, count) in [("threads", self.threads), ("ranks", self.ranks)] {
            if let Some(count) = count {
                body[member] = json!(count);
            }
        }
        let run = client.submit(&body, None)?;
        let id = text_of(&run["id"]);
        self.server.show(&run, |_| id.to_owned())?;
        if self.watch {
            watch(&client, id)
        } else {
            Ok(ExitCode::SUCCESS)
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Log {
    #[command(flatten)]
    server: Server,
    /// The run
    run: String,
    /// The lines of an attempt as they came, by its number, instead of the report of the run
    #[arg(long, value_name = "N")]
    attempt: Option<u64>,
    /// Lines that contain this text only
    #[arg(long, value_name = "TEXT")]
    search: Option<String>,
}

impl Log {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let id = client.id(&self.run)?;
        let attempt = self
            .attempt
            .map_or(String::new(), |attempt| format!("?attempt={attempt}"));
        let log = client.json(&format!("/runs/{id}/log{attempt}"))?;
        self.server.show(&log, |log| {
            let lines = text_of(&log["text"]).lines();
            let wanted = |line: &&str| {
                (self.search.as_ref()).is_none_or(|text| line.contains(text.as_str()))
            };
            lines.filter(wanted).collect::<Vec<_>>().join("\n")
        })?;
        Ok(ExitCode::SUCCESS)
    }
}

#[derive(Debug, Args)]
pub(crate) struct Get {
    #[command(flatten)]
    server: Server,
    /// The run
    run: String,
    /// Folder, which is made
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// These files only
    files: Vec<String>,
}

impl Get {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let id = client.id(&self.run)?;
        let all = client.json(&format!("/runs/{id}/files"))?;
        let names = all
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(|file| file["name"].as_str());
        let names: Vec<&str> = names
            .filter(|name| self.files.is_empty() || self.files.iter().any(|f| f == name))
            .collect();
        if names.is_empty() {
            bail!("the run has no such files");
        }
        for name in names {
            // A server that is not ours must not write elsewhere.
            let parts = Path::new(name).components();
            if !parts
                .clone()
                .all(|part| matches!(part, std::path::Component::Normal(_)))
            {
                bail!("{name:?} is no name of a file within a folder");
            }
            let path = self.output.join(name);
            std::fs::create_dir_all(path.parent().unwrap_or(&self.output))?;
            let mut answer = client.get(&format!("/runs/{id}/files/{name}"))?;
            let part = path.with_file_name(format!(
                "{}.part",
                path.file_name().unwrap_or_default().to_string_lossy()
            ));
            let mut file =
                std::fs::File::create(&part).with_context(|| format!("{}", part.display()))?;
            io::copy(&mut answer.body_mut().as_reader(), &mut file)
                .with_context(|| format!("{name} was cut off"))?;
            std::fs::rename(&part, &path)?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

#[derive(Debug, Args)]
pub(crate) struct Remove {
    #[command(flatten)]
    server: Server,
    /// The runs
    #[arg(required = true)]
    runs: Vec<String>,
}

impl Remove {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        for run in &self.runs {
            client.delete(&format!("/runs/{}", client.id(run)?))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
