//! A command at the end of each run, which sends mail or calls a web hook.
//!
//! It gets what it needs in its environment, so that titles, which users choose, are no part of its text. A run whose end a server that was
//! killed has not seen has no command: there is at most one.

use std::process::{Command, Stdio};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use cloud_api::RunState;
use cloud_api::answers::EventRow;

use crate::state::App;

/// How long a command may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// How often a command is looked at.
const LOOK: Duration = Duration::from_millis(50);

/// Starts the thread that runs the commands, one after the other. Returns where the ids of runs go.
pub(crate) fn begin(app: &Arc<App>, command: String) -> Result<mpsc::Sender<String>> {
    let (send, receive) = mpsc::channel::<String>();
    let app = Arc::clone(app);
    thread::Builder::new()
        .name("at-end".into())
        .spawn(move || {
            for id in receive {
                if let Err(error) = run(&app, &command, &id) {
                    eprintln!("run {id}: the command at its end: {error:#}");
                }
            }
        })?;
    Ok(send)
}

/// The run that has ended, if an event says that.
pub(crate) fn ended(event: &EventRow) -> Option<String> {
    let state = RunState::of(event.data["state"].as_str()?)?;
    (event.kind == "state" && !state.is_live()).then(|| event.run.clone())
}

fn run(app: &App, command: &str, id: &str) -> Result<()> {
    // A run that was removed meanwhile has no name.
    let Some((_, _, row, _)) = app.db.run(id)? else {
        return Ok(());
    };
    let plain = |text: &str| text.replace('\0', " ");
    let mut child = Command::new("sh")
        .args(["-c", command])
        .env("MERCURY_RUN", id)
        .env("MERCURY_TITLE", plain(&row.title))
        .env("MERCURY_LABEL", plain(&row.label))
        .env("MERCURY_OWNER", plain(&row.owner))
        .env("MERCURY_STATE", row.state.word())
        .env("MERCURY_MESSAGE", plain(&row.message))
        .env("MERCURY_LINK", format!("{}runs/{id}", app.address()))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .context("sh cannot be started")?;
    let begin = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            ensure!(status.success(), "{status}");
            return Ok(());
        }
        if begin.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            anyhow::bail!("not done within {} s", PATIENCE.as_secs());
        }
        thread::sleep(LOOK);
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn runs_end_in_states_that_are_not_live() {
        let event = |kind: &str, state: &str| EventRow {
            id: 1,
            run: "r".into(),
            time: 0.0,
            kind: kind.into(),
            data: json!({"state": state}),
        };
        for state in ["finished", "failed", "stopped", "cancelled"] {
            assert_eq!(ended(&event("state", state)), Some("r".into()));
        }
        for state in ["queued", "running", "stopping", "?"] {
            assert_eq!(ended(&event("state", state)), None);
        }
        assert_eq!(ended(&event("note", "finished")), None);
    }
}
