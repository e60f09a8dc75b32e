//! Submission of scenes and studies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use serde_json::json;

use super::projects::project_id;
use super::runs::watch;
use super::{Server, Usage, encoded, say, text_of};

#[derive(Debug, Args)]
pub(crate) struct Submit {
    #[command(flatten)]
    server: Server,
    /// The scene, or a study file that names it
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Replace a value of the scene; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// A further file; those that the scene names are found by themselves
    #[arg(long, value_name = "FILE")]
    file: Vec<PathBuf>,
    /// Title in lists
    #[arg(long)]
    title: Option<String>,
    /// A word that groups runs
    #[arg(long)]
    label: Option<String>,
    /// Threads that compute
    #[arg(long, default_value_t = 1)]
    threads: u32,
    /// Ranks of MPI, each with so many threads, where the server offers them
    #[arg(long, default_value_t = 1)]
    ranks: u32,
    /// Stop each run after this time by the clock, with a checkpoint: 90s, 10m, 1h30m
    #[arg(long, value_name = "TIME", value_parser = mercury_common::cli::duration)]
    time_limit: Option<Duration>,
    /// A study, as `mercury-solve --sweep` makes it; may be repeated
    #[arg(long, value_name = "KEY=A,B,C")]
    sweep: Vec<String>,
    /// A result of the finished run, as `mercury-solve --result` takes it; may be repeated
    #[arg(long, value_name = "NAME=WHAT")]
    result: Vec<String>,
    /// The project whose members see the run, by name or id
    #[arg(long)]
    project: Option<String>,
    /// Idempotency key: with it a scene that is submitted again is one run
    #[arg(long, value_name = "KEY", conflicts_with = "sweep")]
    key: Option<String>,
    /// Show progress until the run ends
    #[arg(long, conflicts_with = "sweep")]
    watch: bool,
}

/// Files that stand beside a scene and that its text names.
fn named_files(scene: &Path, text: &str) -> Result<Vec<PathBuf>> {
    let folder = scene.parent().unwrap_or(Path::new("")).to_owned();
    let folder = if folder.as_os_str().is_empty() {
        PathBuf::from(".")
    } else {
        folder
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(&folder).with_context(|| format!("{}", folder.display()))? {
        let path = entry?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            continue;
        };
        if path.is_file()
            && text.contains(&format!("\"{name}\""))
            && Some(path.file_name()) != Some(scene.file_name())
        {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// If a text is that of a study: its scene, and the text with the scene's name without folders, as the server has it.
fn study_of(path: &Path, text: &str) -> Result<Option<(PathBuf, String)>> {
    let Ok(mut document) = text.parse::<toml::Table>() else {
        // What is wrong with it is said by the solver, with its place.
        return Ok(None);
    };
    let Some(study) = document
        .get_mut("study")
        .and_then(toml::Value::as_table_mut)
    else {
        return Ok(None);
    };
    let wrong = |what: &str| anyhow!(Usage(format!("{}: study.scene {what}", path.display())));
    let named = study.get("scene").ok_or_else(|| wrong("is missing"))?;
    let named = named.as_str().ok_or_else(|| wrong("must be a string"))?;
    let scene = path.parent().unwrap_or(Path::new("")).join(named);
    let flat = scene.file_name().and_then(|name| name.to_str());
    let flat = flat.ok_or_else(|| wrong("names no file"))?.to_owned();
    if flat == named {
        return Ok(Some((scene, text.to_owned())));
    }
    study.insert("scene".to_owned(), toml::Value::String(flat));
    Ok(Some((scene, document.to_string())))
}

#[derive(Debug, Args)]
pub(crate) struct Table {
    #[command(flatten)]
    server: Server,
    /// The study, by its id
    study: String,
}

impl Table {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let path = format!("/studies/{}", encoded(&self.study));
        if self.server.json {
            say(&format!("{:#}", client.json(&path)?))?;
            return Ok(ExitCode::SUCCESS);
        }
        let path = format!("{path}/table.csv");
        let text = client
            .get(&path)?
            .body_mut()
            .with_config()
            .limit(256 << 20)
            .read_to_string()?;
        say(text.trim_end())?;
        Ok(ExitCode::SUCCESS)
    }
}

impl Submit {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let text = std::fs::read_to_string(&self.scene)
            .map_err(|error| anyhow!(Usage(format!("{}: {error}", self.scene.display()))))?;
        let study = study_of(&self.scene, &text)?;
        if study.is_some() && !self.sweep.is_empty() {
            let help = "its values stand in its table [study.sweep]";
            bail!(Usage(format!(
                "--sweep is for scenes, and this is a study: {help}"
            )));
        }
        if study.is_some() && (self.key.is_some() || self.watch) {
            bail!(Usage(
                "--key and --watch are for one run, and this is a study".into()
            ));
        }
        let (scene, text, study) = match study {
            Some((scene, study)) => {
                let text = std::fs::read_to_string(&scene)
                    .map_err(|error| anyhow!(Usage(format!("{}: {error}", scene.display()))))?;
                (scene, text, Some(study))
            }
            None => (self.scene.clone(), text, None),
        };
        let client = self.server.connect()?;
        // Files that a scene names, and files that those name in turn (clump files name surfaces).
        let mut files = self.file.clone();
        let mut texts = vec![text.clone()];
        while let Some(text) = texts.pop() {
            for path in named_files(&scene, &text)? {
                if !files.contains(&path) {
                    if path
                        .extension()
                        .is_some_and(|extension| extension == "toml")
                    {
                        texts.push(std::fs::read_to_string(&path)?);
                    }
                    files.push(path);
                }
            }
        }
        let name = |path: &Path| {
            path.file_name()
                .map(|name| name.to_string_lossy().into_owned())
                .unwrap_or_default()
        };
        let mut contents = BTreeMap::new();
        for path in &files {
            let mut file = std::fs::File::open(path)
                .map_err(|error| anyhow!(Usage(format!("{}: {error}", path.display()))))?;
            let bytes = file.metadata()?.len();
            let sha256 = cloud_store::sha256_of_file(&mut file, 0..bytes)?;
            client.upload(path, &sha256)?;
            contents.insert(name(path), sha256);
        }
        let mut body = json!({
            "scene": {"name": name(&scene), "text": text, "files": contents, "set": self.set},
            "threads": self.threads, "ranks": self.ranks, "result": self.result,
        });
        for (member, value) in [("title", &self.title), ("label", &self.label)] {
            if let Some(value) = value {
                body[member] = json!(value);
            }
        }
        if let Some(limit) = self.time_limit {
            body["time_limit"] = json!(limit.as_secs_f64());
        }
        if let Some(project) = &self.project {
            body["project"] = json!(project_id(&client, project)?);
        }
        if study.is_some() || !self.sweep.is_empty() {
            let mut of_study = json!({"base": body, "sweep": self.sweep});
            if let Some(study) = study {
                of_study["file"] = json!(study);
            }
            let made = client.post("/studies", &of_study)?;
            let runs = made["runs"].as_array().cloned().unwrap_or_default();
            if self.server.json {
                say(&format!("{made:#}"))?;
                return Ok(ExitCode::SUCCESS);
            }
            eprintln!(
                "study {} of {} runs; its table: mercury-cloud table {}",
                text_of(&made["id"]),
                runs.len(),
                &text_of(&made["id"])
            );
            for id in runs {
                say(text_of(&id))?;
            }
            return Ok(ExitCode::SUCCESS);
        }
        let run = client.submit(&body, self.key.as_deref())?;
        let id = run["id"]
            .as_str()
            .context("the server's answer has no id")?;
        self.server.show(&run, |_| id.to_owned())?;
        if self.watch {
            watch(&client, id)
        } else {
            Ok(ExitCode::SUCCESS)
        }
    }
}
