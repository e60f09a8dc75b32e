//! Commands about users and their secrets.

use std::io::{self, IsTerminal};
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Subcommand};
use serde_json::{Value, json};

use super::{Server, encoded, text_of};
use crate::client::Client;

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
        (self.server).show(&made, |made| client.link(text_of(&made["secret"])))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Time of the clock from now to a Unix time, in days.
fn days_from_now(unix: f64) -> f64 {
    let now = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0.0, |time| time.as_secs_f64());
    (unix - now) / 86_400.0
}

/// As [`days_from_now`], in words.
fn days_to(unix: &Value) -> String {
    let days = days_from_now(unix.as_f64().unwrap_or(0.0));
    format!("{:.1} d", days.max(0.0))
}

/// Prints secrets in a list: number, time to the end, rights, and a word.
fn list_secrets(
    server: &Server,
    client: &Client,
    path: &str,
    word: impl Fn(&Value) -> String,
) -> Result<ExitCode> {
    server.list(&client.json(path)?, |row| {
        let rights = match row["read_only"].as_bool() {
            Some(true) => "reads",
            _ => "changes",
        };
        let (id, ends) = (&row["id"], days_to(&row["expires"]));
        format!("{id:>6}  ends in {ends:>8}  {rights:7}  {}", word(row))
    })
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
                list_secrets(
                    &self.server,
                    &client,
                    "/sessions",
                    |row| match row["token"].as_str() {
                        Some(token) => format!("by token {token}"),
                        None => "by password or link".to_owned(),
                    },
                )
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
                return list_secrets(&self.server, &client, "/shares", |row| {
                    format!("run {}", text_of(&row["run"]))
                });
            }
            ShareCommand::New { run, days } => {
                let id = client.id(&run)?;
                let made = client.post(&format!("/runs/{id}/share"), &json!({"days": days}))?;
                self.server.show(&made, |made| {
                    let link = client.link(text_of(&made["token"]));
                    link.replace("/#token=", &format!("/runs/{id}#token="))
                })?;
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
                return list_secrets(&self.server, &client, "/tokens", |row| {
                    text_of(&row["name"]).to_owned()
                });
            }
            (None, Some(name)) => {
                let body = json!({"name": name, "days": self.days, "read_only": self.read_only});
                let token = client.post("/tokens", &body)?;
                (self.server).show(&token, |token| text_of(&token["secret"]).to_owned())?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

#[derive(Debug, Args)]
pub(crate) struct Hook {
    #[command(flatten)]
    server: Server,
    #[command(subcommand)]
    command: Option<HookCommand>,
}

#[derive(Debug, Subcommand)]
enum HookCommand {
    /// Show the URL and the last messages
    Ls,
    /// Have each end of a run sent to a URL; prints the secret of the signatures once
    Set {
        /// https://..., or http:// to a host that the administrator allows
        url: String,
    },
    /// Send a test
    Test,
    /// Send nothing any more
    Rm,
}

impl Hook {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        match self.command.unwrap_or(HookCommand::Ls) {
            HookCommand::Ls => {
                let hook = client.json("/hook")?;
                self.server.show(&hook, hook_in_words)?;
            }
            HookCommand::Set { url } => {
                let made = client.put("/hook", &json!({"url": url}))?;
                self.server
                    .show(&made, |made| text_of(&made["secret"]).to_owned())?;
            }
            HookCommand::Test => {
                client.post("/hook/test", &json!({}))?;
            }
            HookCommand::Rm => client.delete("/hook")?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// The URL of a hook, and a line for each message.
fn hook_in_words(hook: &Value) -> String {
    let url = match text_of(&hook["url"]) {
        "" => "no web hook; `mercury-cloud hook set URL` sets one",
        url => url,
    };
    let mut lines = vec![url.to_owned()];
    for row in hook["deliveries"].as_array().into_iter().flatten() {
        let ago = -row["created"].as_f64().map_or(0.0, days_from_now);
        let (id, state) = (&row["id"], text_of(&row["state"]));
        let run = row["run"].as_str().unwrap_or("-");
        let outcome = match (text_of(&row["message"]), row["next"].as_f64()) {
            ("", None) => "delivered".to_owned(),
            ("", Some(_)) => "waits".to_owned(),
            (why, None) => format!("not delivered: {why}"),
            (why, Some(next)) => {
                let wait = (86_400.0 * days_from_now(next)).max(0.0);
                format!("sent again in {wait:.0} s: {why}")
            }
        };
        lines.push(format!(
            "{id:>6}  {ago:8.2} d ago  {run:32}  {state:9}  {outcome}"
        ));
    }
    lines.join("\n")
}

#[derive(Debug, Args)]
pub(crate) struct User {
    #[command(flatten)]
    server: Server,
    #[command(subcommand)]
    command: Option<UserCommand>,
    /// Name of the user to add or change; without it users are listed
    name: Option<String>,
    /// Read a password, also where the user has one; without a limit or a right to change this is the default
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
    /// The most core hours that all runs of the user may spend, or `none`
    #[arg(long, value_name = "H", value_parser = limit)]
    core_hours: Option<Limit>,
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

#[derive(Debug, Args)]
pub(crate) struct Audit {
    #[command(flatten)]
    server: Server,
    /// The newest ones, so many at most
    #[arg(long, default_value_t = 50, value_name = "N")]
    most: usize,
}

impl Audit {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let client = self.server.connect()?;
        let mut rows: Vec<Value> = Vec::new();
        while rows.len() < self.most {
            let before = rows
                .last()
                .map_or(String::new(), |row| format!("?before={}", row["id"]));
            let page = client.json(&format!("/audit{before}"))?;
            let page = page.as_array().cloned().unwrap_or_default();
            if page.is_empty() {
                break;
            }
            rows.extend(page);
        }
        rows.truncate(self.most);
        self.server.list(&Value::Array(rows), |row| {
            let user = match text_of(&row["user"]) {
                "" => "-",
                user => user,
            };
            let (method, path) = (text_of(&row["method"]), text_of(&row["path"]));
            let (address, status) = (text_of(&row["address"]), &row["status"]);
            let ago = -row["time"].as_f64().map_or(0.0, days_from_now);
            format!("{ago:8.2} d ago  {user:20} {address:15}  {status}  {method} {path}")
        })
    }
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
                return self.server.list(&client.json("/users")?, |user| {
                    let usage = &user["usage"];
                    let most = |key: &str, unit: f64| match usage[key].as_f64() {
                        Some(most) => format!("of {}", most / unit),
                        None => "without limit".to_owned(),
                    };
                    let role = if user["admin"] == true {
                        "admin"
                    } else {
                        "user"
                    };
                    format!(
                        "{:20} {role:5}  {} cores {}, {} MB {}, {:.1} core hours {}",
                        text_of(&user["name"]),
                        usage["cores"],
                        most("most_cores", 1.0),
                        usage["disk"].as_u64().unwrap_or(0) / 1_000_000,
                        most("most_disk", 1e6),
                        usage["core_seconds"].as_f64().unwrap_or(0.0) / 3600.0,
                        most("most_core_seconds", 3600.0),
                    )
                });
            }
            (None, Some(name)) => name,
        };
        let users = client.json("/users")?;
        let known = (users.as_array().into_iter().flatten()).any(|user| user["name"] == *name);
        let changes = self.admin.is_some()
            || self.cores.is_some()
            || self.disk.is_some()
            || self.core_hours.is_some();
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
        if let Some(Limit(hours)) = self.core_hours {
            body["core_seconds"] = json!(hours.map(|hours| hours as f64 * 3600.0));
        }
        client.post("/users", &body)?;
        Ok(ExitCode::SUCCESS)
    }
}
