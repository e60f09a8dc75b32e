//! Commands about projects.

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use serde_json::json;

use super::{Server, encoded, text_of};
use crate::client::Client;

/// The id of a project that is given by its id or its name.
pub(super) fn project_id(client: &Client, named: &str) -> Result<String> {
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
                return self.server.list(&client.json("/projects")?, |project| {
                    let members = project["members"].as_array().into_iter().flatten();
                    let members: Vec<String> = members
                        .map(|one| format!("{} ({})", text_of(&one["name"]), text_of(&one["role"])))
                        .collect();
                    let (id, name) = (text_of(&project["id"]), text_of(&project["name"]));
                    let (runs, members) = (&project["runs"], members.join(", "));
                    format!("{id}  {name}  {runs} runs  {members}")
                });
            }
            ProjectCommand::New { name } => {
                let made = client.post("/projects", &json!({"name": name}))?;
                self.server
                    .show(&made, |made| text_of(&made["id"]).to_owned())?;
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
