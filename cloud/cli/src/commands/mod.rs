//! Commands, which use nothing but the API.

mod accounts;
mod projects;
mod runs;
mod submit;

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, anyhow};
use clap::Args;
use serde_json::Value;

use crate::client::Client;

pub(crate) use accounts::{Audit, Hook, Link, Session, Share, Token, User};
pub(crate) use projects::Project;
pub(crate) use runs::{Branch, Clone, Extend, Get, List, Log, One, Remove, Resume, Verify};
pub(crate) use submit::{Submit, Table};

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
    #[arg(long, global = true, value_name = "LINK")]
    link: Option<String>,
    /// Print answers as JSON
    #[arg(long, global = true)]
    json: bool,
}

impl Server {
    fn connect(&self) -> Result<Client> {
        Client::connect(self.link.as_deref())
    }

    /// Prints an answer: as JSON, or as it is in words.
    fn show(&self, answer: &Value, words: impl FnOnce(&Value) -> String) -> Result<()> {
        let text = if self.json {
            format!("{answer:#}")
        } else {
            words(answer)
        };
        // An empty list has no line.
        if text.is_empty() { Ok(()) } else { say(&text) }
    }

    /// Prints a list: as JSON, or a line for each entry.
    fn list(&self, answer: &Value, line: impl Fn(&Value) -> String) -> Result<ExitCode> {
        self.show(answer, |all| {
            let lines: Vec<String> = all.as_array().into_iter().flatten().map(line).collect();
            lines.join("\n")
        })?;
        Ok(ExitCode::SUCCESS)
    }
}

fn text_of(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
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
