//! Commands about runs.

use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};
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
pub(crate) struct Link {
    #[command(flatten)]
    server: Server,
    /// Make the secrets of this machine anew: earlier links and sessions of its user end
    #[arg(long)]
    rotate: bool,
}

impl Link {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let made = client.post("/links", &json!({"rotate": self.rotate}))?;
        say(&client.link(text_of(&made["secret"])))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Time of the clock from now to a Unix time, in days.
fn days_to(unix: &Value) -> String {
    let now = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0.0, |time| time.as_secs_f64());
    format!(
        "{:.1} d",
        (unix.as_f64().unwrap_or(0.0) - now).max(0.0) / 86_400.0
    )
}

/// Prints secrets in a list: number, time to the end, rights, and a word.
fn list_secrets(client: &Client, path: &str, word: impl Fn(&Value) -> String) -> Result<ExitCode> {
    for row in client.json(path)?.as_array().into_iter().flatten() {
        let rights = match row["read_only"].as_bool() {
            Some(true) => "reads",
            _ => "changes",
        };
        let (id, ends) = (&row["id"], days_to(&row["expires"]));
        say(&format!(
            "{id:>6}  ends in {ends:>8}  {rights:7}  {}",
            word(row)
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

#[derive(Debug, Args)]
pub(crate) struct Session {
    #[command(flatten)]
    server: Server,
    #[command(subcommand)]
    command: Option<SessionCommand>,
}

#[derive(Debug, Subcommand)]
enum SessionCommand {
    /// List your sessions
    Ls,
    /// End a session
    Rm {
        /// Its number, or `all`
        session: String,
    },
}

impl Session {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        match self.command.unwrap_or(SessionCommand::Ls) {
            SessionCommand::Ls => {
                list_secrets(&client, "/sessions", |row| match row["token"].as_str() {
                    Some(token) => format!("by token {token}"),
                    None => "by password or link".to_owned(),
                })
            }
            SessionCommand::Rm { session } => {
                let path = match session.as_str() {
                    "all" => "/sessions".to_owned(),
                    one => format!("/sessions/{}", encoded(one)),
                };
                client.delete(&path)?;
                Ok(ExitCode::SUCCESS)
            }
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Share {
    #[command(flatten)]
    server: Server,
    #[command(subcommand)]
    command: Option<ShareCommand>,
}

#[derive(Debug, Subcommand)]
enum ShareCommand {
    /// List links to your runs
    Ls,
    /// Make a link with which others look at a run; prints it once
    New {
        /// The run
        run: String,
        /// Days until it expires
        #[arg(long, default_value_t = 30)]
        days: u32,
    },
    /// Take a link back, with the sessions that it has begun
    Rm {
        /// Its number
        share: String,
    },
}

impl Share {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        match self.command.unwrap_or(ShareCommand::Ls) {
            ShareCommand::Ls => {
                return list_secrets(&client, "/shares", |row| {
                    format!("run {}", text_of(&row["run"]))
                });
            }
            ShareCommand::New { run, days } => {
                let id = client.id(&run)?;
                let made = client.post(&format!("/runs/{id}/share"), &json!({"days": days}))?;
                let link = client.link(text_of(&made["token"]));
                say(&link.replace("/#token=", &format!("/runs/{id}#token=")))?;
            }
            ShareCommand::Rm { share } => client.delete(&format!("/shares/{}", encoded(&share)))?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

#[derive(Debug, Args)]
pub(crate) struct Token {
    #[command(flatten)]
    server: Server,
    #[command(subcommand)]
    command: Option<TokenCommand>,
    /// Purpose of a new token
    name: Option<String>,
    /// Days until it expires
    #[arg(long, default_value_t = 30)]
    days: u32,
    /// It may look only
    #[arg(long)]
    read_only: bool,
}

#[derive(Debug, Subcommand)]
enum TokenCommand {
    /// List your tokens
    Ls,
    /// Take a token back, with the sessions that it has begun
    Rm {
        /// Its number
        token: String,
    },
}

impl Token {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        match (self.command, self.name) {
            (Some(TokenCommand::Rm { token }), _) => {
                client.delete(&format!("/tokens/{}", encoded(&token)))?;
            }
            (Some(TokenCommand::Ls), _) | (None, None) => {
                return list_secrets(&client, "/tokens", |row| text_of(&row["name"]).to_owned());
            }
            (None, Some(name)) => {
                let body = json!({"name": name, "days": self.days, "read_only": self.read_only});
                let token = client.post("/tokens", &body)?;
                say(text_of(&token["secret"]))?;
            }
        }
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
    #[command(subcommand)]
    command: Option<UserCommand>,
    /// Name of a user who is added or changed; without it users are listed
    name: Option<String>,
    /// Read a password, also of a user who has one; without a limit or a right to change this is the default
    #[arg(long)]
    password: bool,
    /// Whether the user may manage others
    #[arg(long, num_args = 0..=1, default_missing_value = "true", value_name = "BOOL")]
    admin: Option<bool>,
    /// The most cores that the user's runs may have at once, or `none`
    #[arg(long, value_name = "N", value_parser = limit)]
    cores: Option<Limit>,
    /// The most that the user's runs and inputs may take, in MB, or `none`
    #[arg(long, value_name = "MB", value_parser = limit)]
    disk: Option<Limit>,
}

#[derive(Debug, Subcommand)]
enum UserCommand {
    /// List users, with what they take
    Ls,
    /// Remove a user with all secrets, runs and inputs
    Rm {
        /// Name of the user
        name: String,
    },
}

/// A limit, or none.
#[derive(Clone, Copy, Debug)]
struct Limit(Option<u64>);

fn limit(text: &str) -> Result<Limit, String> {
    match text {
        "none" => Ok(Limit(None)),
        number => match number.parse() {
            Ok(number) => Ok(Limit(Some(number))),
            Err(_) => Err("expected a whole number, or none".to_owned()),
        },
    }
}

/// Reads a password: from a terminal, which does not show it, or a line of standard input.
fn read_password(name: &str) -> Result<String> {
    if io::stdin().is_terminal() {
        return Ok(rpassword::prompt_password(format!("password of {name}: "))?);
    }
    let mut password = String::new();
    io::stdin().read_line(&mut password)?;
    Ok(password.trim_end_matches(['\n', '\r']).to_owned())
}

impl User {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let name = match (self.command, self.name) {
            (Some(UserCommand::Rm { name }), _) => {
                client.delete(&format!("/users/{}", encoded(&name)))?;
                return Ok(ExitCode::SUCCESS);
            }
            (Some(UserCommand::Ls), _) | (None, None) => {
                for user in client.json("/users")?.as_array().into_iter().flatten() {
                    let usage = &user["usage"];
                    let most = |key: &str, unit: u64| match usage[key].as_u64() {
                        Some(most) => format!("of {}", most / unit),
                        None => "without limit".to_owned(),
                    };
                    let role = if user["admin"] == true {
                        "admin"
                    } else {
                        "user"
                    };
                    say(&format!(
                        "{:20} {role:5}  {} cores {}, {} MB {}",
                        text_of(&user["name"]),
                        usage["cores"],
                        most("most_cores", 1),
                        usage["disk"].as_u64().unwrap_or(0) / 1_000_000,
                        most("most_disk", 1_000_000),
                    ))?;
                }
                return Ok(ExitCode::SUCCESS);
            }
            (None, Some(name)) => name,
        };
        let users = client.json("/users")?;
        let known = (users.as_array().into_iter().flatten()).any(|user| user["name"] == *name);
        let changes = self.admin.is_some() || self.cores.is_some() || self.disk.is_some();
        let mut body = json!({"name": name});
        if self.password || !known || !changes {
            body["password"] = json!(read_password(&name)?);
        }
        if let Some(admin) = self.admin {
            body["admin"] = json!(admin);
        }
        if let Some(Limit(cores)) = self.cores {
            body["cores"] = json!(cores);
        }
        if let Some(Limit(disk)) = self.disk {
            body["disk"] = json!(disk.map(|megabytes| megabytes.saturating_mul(1_000_000)));
        }
        client.post("/users", &body)?;
        Ok(ExitCode::SUCCESS)
    }
}
