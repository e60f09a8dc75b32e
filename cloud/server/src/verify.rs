//! Verification of finished runs by `mercury-solve verify`, in a cage: files against the chain, and a share of the steps made again.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path as FilePath;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::{Context, Result};
use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use cloud_api::answers::{Verdict, Verification};
use cloud_api::{Head, RunState};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::access::{Anyone, ApiError, LoggedIn};
use crate::check::{Folder, LARGEST_ANSWER, MEMORY, SolverAnswer, confined};
use crate::content::Content;
use crate::downloads::files;
use crate::routes::{Answer, Shared};
use crate::runs::{VisibleRun, blocking, visible_run};
use crate::secrets::{self, Caller};
use crate::state::App;

/// How long a verification may take.
const PATIENCE: Duration = Duration::from_secs(600);

/// The most bytes of the files and inputs of a run that is verified here. While it is verified they are on the disk twice.
const LARGEST_RUN: u64 = 4 << 30;

/// Folder of the run in that of the verification, as of workers. No input begins with a dot.
pub(crate) const RUN: &str = ".run";

/// Runs that are being verified, and whose request that was.
#[derive(Default)]
pub(crate) struct Verifying {
    runs: Mutex<BTreeMap<String, i64>>,
    /// Held by the one verification that computes.
    turn: Mutex<()>,
}

impl Verifying {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, i64>> {
        self.runs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Says that a verification is over, however it ends.
struct Over(Arc<App>, String);

impl Drop for Over {
    fn drop(&mut self) {
        self.0.verifying.lock().remove(&self.1);
    }
}

/// `runs/R/verified.json`.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    /// Revision of the spec and number of the head that were verified: a run that goes on is another one.
    revision: u32,
    commit: u64,
    verification: Verification,
}

fn key(run: &VisibleRun) -> String {
    format!("runs/{}/verified.json", run.id)
}

/// The last verification of a run.
fn known(app: &App, run: &VisibleRun) -> Result<Verification, ApiError> {
    if app.verifying.lock().contains_key(run.id.as_str()) {
        return Ok(Verification {
            verdict: Verdict::Running,
            ..Verification::default()
        });
    }
    let text = app.store.get(&key(run))?;
    let kept: Option<Kept> = text.and_then(|text| serde_json::from_slice(&text).ok());
    let head = app.head(&run.id)?.unwrap_or_default();
    let now = (run.spec.revision, head.commit);
    Ok(kept
        .filter(|kept| (kept.revision, kept.commit) == now)
        .map(|kept| kept.verification)
        .unwrap_or_default())
}

/// The last verification of a run.
#[utoipa::path(get, path = "/api/v1/runs/{run}/verification", params(("run" = String, Path)), responses((status = 200, body = Verification)))]
pub(crate) async fn verification_get(
    State(app): Shared,
    Anyone(caller): Anyone,
    Path(id): Path<String>,
) -> Answer<Verification> {
    blocking(move || Ok(Json(known(&app, &visible_run(&app, &caller, &id)?)?))).await
}

/// Begins to verify a finished run: all its files against its chain, and one step of a hundred made again.
#[utoipa::path(post, path = "/api/v1/runs/{run}/verification", params(("run" = String, Path)), responses((status = 200, body = Verification)))]
pub(crate) async fn verification_begin(
    State(app): Shared,
    LoggedIn(user): LoggedIn,
    Path(id): Path<String>,
) -> Answer<Verification> {
    blocking(move || {
        let owner = user.id;
        let run = visible_run(&app, &Caller::User(user), &id)?;
        if run.row.state != RunState::Finished {
            let detail = "A run is verified when it has come to its end.";
            let title = "not in this state";
            return Err(ApiError::new(StatusCode::CONFLICT, title, detail));
        }
        let head = app.head(&run.id)?.unwrap_or_default();
        let inputs: u64 = run.spec.files.values().map(|file| file.bytes).sum();
        if head.bytes() + inputs > LARGEST_RUN {
            let detail = format!(
                "Its files have {} MB; {} MB are verified here. Fetch its scene and files, and verify them by mercury-solve verify.",
                (head.bytes() + inputs) >> 20,
                LARGEST_RUN >> 20
            );
            return Err(ApiError::bad_request("too large", detail));
        }
        {
            let mut all = app.verifying.lock();
            if !all.contains_key(run.id.as_str()) {
                if all.values().any(|user| *user == owner) {
                    let detail = "Another run of yours is being verified. Try again.";
                    return Err(ApiError::too_many("too many verifications", detail, 5));
                }
                all.insert(run.id.to_string(), owner);
                let over = Over(Arc::clone(&app), run.id.to_string());
                let app = Arc::clone(&app);
                // Not one of the threads whose end a server that stops waits for.
                std::thread::spawn(move || {
                    let _over = over;
                    if let Err(error) = work(&app, &run, &head) {
                        eprintln!("verification of run {}: {error:#}", run.id);
                    }
                });
            }
        }
        Ok(Json(Verification {
            verdict: Verdict::Running,
            ..Verification::default()
        }))
    })
    .await
}

/// Verifies a run, and keeps the result.
fn work(app: &App, run: &VisibleRun, head: &Head) -> Result<()> {
    let _turn = app.verifying.turn.lock();
    let verification = verified(app, run, head).unwrap_or_else(|error| Verification {
        verdict: Verdict::Unverifiable,
        message: format!("{error:#}"),
        ..Verification::default()
    });
    let at = std::time::SystemTime::UNIX_EPOCH.elapsed()?.as_secs();
    let kept = Kept {
        revision: run.spec.revision,
        commit: head.commit,
        verification: Verification {
            at: Some(at as i64),
            ..verification
        },
    };
    app.store.put(&key(run), &serde_json::to_vec(&kept)?)?;
    if app.db.run(run.id.as_str())?.is_none() {
        // Removed meanwhile.
        app.store.delete(&key(run))?;
    }
    Ok(())
}

/// Lays out the inputs of a run, and those of its files that are wanted in [`RUN`], in a folder of its own.
pub(crate) fn lay_out_run(
    app: &App,
    run: &VisibleRun,
    head: &Head,
    wanted: impl Fn(&str) -> bool,
) -> Result<Folder> {
    let folder = Folder(app.options.data.join("checks").join(secrets::random()?));
    fs::create_dir(&folder.0)?;
    let inputs = run.spec.files.iter();
    let inputs = inputs.map(|(name, input)| (name.clone(), Content::of_input(input)));
    let outputs = files(head).into_iter();
    let outputs = outputs
        .filter(|file| wanted(&file.name))
        .filter_map(|file| {
            let content = Content::of(&run.id, head, &file.name)?;
            Some((format!("{RUN}/{}", file.name), content))
        });
    for (name, content) in inputs.chain(outputs) {
        lay_out(app, &folder.0.join(&name), &content)
            .with_context(|| format!("{name} cannot be read"))?;
    }
    Ok(folder)
}

fn verified(app: &App, run: &VisibleRun, head: &Head) -> Result<Verification> {
    let folder = lay_out_run(app, run, head, |_| true)?;
    let arguments = ["verify", RUN, "--json", "--steps=1%", "--threads=1"].map(str::to_owned);
    let solver = &app.options.solver;
    let said = confined(
        app,
        solver,
        &folder.0,
        &arguments,
        PATIENCE,
        LARGEST_ANSWER,
        LARGEST_RUN,
    )?;
    Ok(verdict(&said))
}

/// Copies a file from the store.
fn lay_out(app: &App, path: &FilePath, content: &Content) -> Result<()> {
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent)?;
    }
    let mut file = File::create_new(path)?;
    let mut at = 0;
    while at < content.bytes() {
        let piece = content.read(app.store.as_ref(), at..content.bytes())?;
        file.write_all(&piece)?;
        at += piece.len() as u64;
    }
    Ok(())
}

/// Meaning of an answer of the solver.
fn verdict(said: &SolverAnswer) -> Verification {
    let unverifiable = |message: String| Verification {
        verdict: Verdict::Unverifiable,
        message,
        ..Verification::default()
    };
    if said.code.is_none() {
        let (minutes, memory) = (PATIENCE.as_secs() / 60, MEMORY >> 30);
        return unverifiable(format!(
            "it takes more than {minutes} minutes or {memory} GB of memory: fetch scene and files, and verify them by mercury-solve verify"
        ));
    }
    let plain = |message: &str| {
        let message = message.trim().replace(&format!("{RUN}/"), "");
        let message = message.replace(&format!("{RUN}: "), "");
        message.trim_start_matches("verify: ").to_owned()
    };
    let answer: Value = serde_json::from_str(&said.answer).unwrap_or_default();
    let Some(right) = answer["right"].as_bool() else {
        let (_, problems) = said.parts();
        let first = problems.first();
        return unverifiable(plain(
            first.map_or(&said.messages, |problem| &problem.message),
        ));
    };
    Verification {
        verdict: match right {
            true => Verdict::Verified,
            false => Verdict::Differs,
        },
        at: None,
        share: answer["share"].as_f64(),
        link: answer["link"].as_str().map(str::to_owned),
        message: plain(answer["first_difference"].as_str().unwrap_or_default()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(code: Option<i32>, answer: &str, messages: &str) -> Verification {
        verdict(&SolverAnswer {
            code,
            answer: answer.to_owned(),
            messages: messages.to_owned(),
        })
    }

    #[test]
    fn answers_of_the_solver_are_understood() {
        let right = r#"{"right": true, "first_difference": null, "share": 0.05, "link": "ab"}"#;
        let found = of(Some(0), right, "");
        assert_eq!(found.verdict, Verdict::Verified);
        assert_eq!(
            (found.share, found.link.as_deref()),
            (Some(0.05), Some("ab"))
        );
        let wrong = r#"{"right": false, "first_difference": ".run/drum.ene: its first 7 bytes are not those of link 2", "share": 0, "link": "ab"}"#;
        let found = of(Some(1), wrong, "verify: .run/drum.ene");
        assert_eq!(found.verdict, Verdict::Differs);
        assert_eq!(
            found.message,
            "drum.ene: its first 7 bytes are not those of link 2"
        );
        for (code, answer) in [
            (
                Some(2),
                r#"{"problems": [{"message": "verify: .run: the run has no chain"}]}"#,
            ),
            (Some(2), ""),
            (None, right),
        ] {
            let found = of(code, answer, "verify: .run: the run has no chain");
            assert_eq!(found.verdict, Verdict::Unverifiable);
            assert!(!found.message.is_empty() && !found.message.contains(RUN));
        }
    }
}
