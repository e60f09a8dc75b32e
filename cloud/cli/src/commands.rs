//! Commands about runs.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail};
use clap::{Args, Subcommand};
use serde_json::{Value, json};

use crate::client::Client;

/// Wrong usage or input: exit code 2.
#[derive(Debug)]
pub(crate) struct Usage(pub(crate) String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Prints a line.
pub(crate) fn say(line: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}")?;
    Ok(out.flush()?)
}

/// Where `serve` keeps its data if nothing else is said.
pub(crate) fn data_folder() -> Result<PathBuf> {
    let home = std::env::var_os("XDG_DATA_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".local/share")));
    Ok(home
        .ok_or_else(|| {
            anyhow!(Usage(
                "neither HOME nor XDG_DATA_HOME is set; give --data".into()
            ))
        })?
        .join("mercury-cloud"))
}

#[derive(Debug, Args)]
pub(crate) struct Server {
    /// Link of the server, as `serve` prints it, or its address followed by /#token=mc_...
    #[arg(long, value_name = "LINK")]
    link: Option<String>,
}

impl Server {
    fn connect(&self) -> Result<Client> {
        Client::connect(self.link.as_deref())
    }
}

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

fn text_of(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
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
        let path = format!("/studies/{}/table.csv", encoded(&self.study));
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
            "threads": self.threads, "result": self.result,
        });
        for (member, value) in [("title", &self.title), ("label", &self.label)] {
            if let Some(value) = value {
                body[member] = json!(value);
            }
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
        say(id)?;
        if self.watch {
            watch(&client, id)
        } else {
            Ok(ExitCode::SUCCESS)
        }
    }
}

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
    /// As JSON
    #[arg(long)]
    json: bool,
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
                if self.json {
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
        if self.json {
            say(&format!("{:#}", Value::Array(all)))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// A text within a query.
fn encoded(text: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_' | b'.');
    text.bytes()
        .map(|b| {
            if plain(b) {
                (b as char).to_string()
            } else {
                format!("%{b:02X}")
            }
        })
        .collect()
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
        say(&line(
            &client.post(&format!("/runs/{id}/{what}"), &json!({}))?,
        ))?;
        Ok(ExitCode::SUCCESS)
    }

    pub(crate) fn watch(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let id = client.id(&self.run)?;
        watch(&client, &id)
    }
}

/// Prints a line whenever it has changed, until the run ends. Exit code 1 if it failed.
fn watch(client: &Client, id: &str) -> Result<ExitCode> {
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
        say(&line(&client.post(
            &format!("/runs/{id}/extend"),
            &json!({"end": self.end}),
        )?))?;
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

#[derive(Debug, Args)]
pub(crate) struct Token {
    #[command(flatten)]
    server: Server,
    /// Purpose of the token
    name: String,
    /// Days until it expires
    #[arg(long, default_value_t = 30)]
    days: u32,
    /// It may look only
    #[arg(long)]
    read_only: bool,
}

impl Token {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let body = json!({"name": self.name, "days": self.days, "read_only": self.read_only});
        let token = client.post("/tokens", &body)?;
        say(token["secret"].as_str().unwrap_or_default())?;
        Ok(ExitCode::SUCCESS)
    }
}

/// The id of a project that is given by its id or its name.
fn project_id(client: &Client, named: &str) -> Result<String> {
    let projects = client.json("/projects")?;
    let all = projects.as_array().map_or(&[][..], Vec::as_slice);
    let found: Vec<&str> = (all.iter())
        .filter(|project| text_of(&project["id"]) == named || text_of(&project["name"]) == named)
        .map(|project| text_of(&project["id"]))
        .collect();
    match found[..] {
        [id] => Ok(id.to_owned()),
        [] => bail!("you are in no project {named}; `mercury-cloud project` lists yours"),
        _ => bail!(
            "{} projects are called {named}: give the id of one of them: {}",
            found.len(),
            found.join(", ")
        ),
    }
}

#[derive(Debug, Args)]
pub(crate) struct Project {
    #[command(flatten)]
    server: Server,
    #[command(subcommand)]
    command: Option<ProjectCommand>,
}

#[derive(Debug, Subcommand)]
enum ProjectCommand {
    /// List your projects with their members
    Ls,
    /// Make a project; prints its id
    New {
        /// Name
        name: String,
    },
    /// Remove a project; its runs stay with their owners
    Rm {
        /// The project, by name or id
        project: String,
    },
    /// Add a user, or give a member another role
    Add {
        /// The project, by name or id
        project: String,
        /// Name of the user
        user: String,
        /// viewer looks and fetches; member also submits, stops, resumes and deletes; manager also chooses members
        #[arg(long, default_value = "member", value_parser = ["viewer", "member", "manager"])]
        role: String,
    },
    /// Take a member out of a project
    Remove {
        /// The project, by name or id
        project: String,
        /// Name of the user
        user: String,
    },
}

impl Project {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let member = |project: &str, user: &str| -> Result<String> {
            let id = project_id(&client, project)?;
            Ok(format!("/projects/{id}/members/{}", encoded(user)))
        };
        match self.command.unwrap_or(ProjectCommand::Ls) {
            ProjectCommand::Ls => {
                let projects = client.json("/projects")?;
                for project in projects.as_array().into_iter().flatten() {
                    let members: Vec<String> = (project["members"]
                        .as_array()
                        .into_iter()
                        .flatten())
                    .map(|one| format!("{} ({})", text_of(&one["name"]), text_of(&one["role"])))
                    .collect();
                    let (id, name) = (text_of(&project["id"]), text_of(&project["name"]));
                    say(&format!(
                        "{id}  {name}  {} runs  {}",
                        project["runs"],
                        members.join(", ")
                    ))?;
                }
            }
            ProjectCommand::New { name } => {
                say(text_of(
                    &client.post("/projects", &json!({"name": name}))?["id"],
                ))?;
            }
            ProjectCommand::Rm { project } => {
                client.delete(&format!("/projects/{}", project_id(&client, &project)?))?;
            }
            ProjectCommand::Add {
                project,
                user,
                role,
            } => {
                client.put(&member(&project, &user)?, &json!({"role": role}))?;
            }
            ProjectCommand::Remove { project, user } => client.delete(&member(&project, &user)?)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

#[derive(Debug, Args)]
pub(crate) struct User {
    #[command(flatten)]
    server: Server,
    /// Name of the user
    name: String,
    /// The user may manage others
    #[arg(long)]
    admin: bool,
    /// The most cores that the user's runs may have at once
    #[arg(long, value_name = "N")]
    cores: Option<u32>,
    /// The most that the user's runs and inputs may take, in MB
    #[arg(long, value_name = "MB")]
    disk: Option<u64>,
}

impl User {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        eprint!("password of {}: ", self.name);
        let mut password = String::new();
        io::stdin().read_line(&mut password)?;
        let password = password.trim_end_matches(['\n', '\r']);
        client.post(
            "/users",
            &json!({
                "name": self.name, "password": password, "admin": self.admin, "cores": self.cores,
                "disk": self.disk.map(|megabytes| megabytes.saturating_mul(1_000_000)),
            }),
        )?;
        Ok(ExitCode::SUCCESS)
    }
}
