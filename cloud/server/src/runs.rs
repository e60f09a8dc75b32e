//! Requests of users about runs: submit, extend, clone, delete.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::http::StatusCode;
use cloud_api::answers::{RunRow, Usage};
use cloud_api::lifecycle::RunEvent;
use cloud_api::names::check_text;
use cloud_api::requests::{Role, Scene, Submit};
use cloud_api::{Branch, Head, InputFile, RunId, Spec};
use cloud_store::sha256;
use serde_json::Value;

use crate::access::{ApiError, not_logged_in};
use crate::check::{check, inspect};
use crate::db::{Applied, Deleted, Extension, NewRun, Reserved};
use crate::secrets::{self, Caller, User};
use crate::state::App;
use crate::{earlier, inputs, projects};

/// Largest error of a memory forecast plus the memory of the solver itself, in bytes.
const MEMORY_MARGIN: u64 = 256 << 20;

/// The least disk that a run may have, in bytes.
const LEAST_DISK: u64 = 1 << 30;

/// Forecasts of a plan.
struct Forecast {
    memory: u64,
    disk: u64,
    steps: Option<u64>,
}

/// Cores of a run.
pub(crate) fn cores(threads: u32, ranks: u32) -> u32 {
    threads.saturating_mul(ranks)
}

/// Forecasts of a plan. Without one (null: the scene was not checked) the run gets all memory that there is for runs.
fn forecast(app: &App, plan: &Value, cores: u32) -> Result<Forecast, ApiError> {
    let number = |group: &str, name: &str| plan[group][name].as_f64().unwrap_or(0.0);
    let memory = if plan.is_null() {
        app.options.memory
    } else {
        (number("memory", "at_most") * 1.25) as u64 + MEMORY_MARGIN
    };
    let disk = number("disk", "bytes");
    if app.engine.abilities().cores.is_some_and(|all| cores > all) {
        return Err(ApiError::bad_request(
            "too many cores",
            format!("This server has {} cores for runs.", app.options.cores),
        ));
    }
    if memory > app.options.memory {
        let (needs, has) = (memory >> 20, app.options.memory >> 20);
        return Err(ApiError::bad_request(
            "too large",
            format!("The run may need {needs} MB of memory; there are {has} MB."),
        ));
    }
    if disk > app.options.disk as f64 {
        let (needs, has) = (disk / 1e6, app.options.disk / 1_000_000);
        return Err(ApiError::bad_request(
            "too large",
            format!("The run will write {needs:.0} MB; a run may have {has} MB."),
        ));
    }
    Ok(Forecast {
        memory,
        disk: app.options.disk.max(LEAST_DISK),
        steps: plan["time"]["steps"].as_u64(),
    })
}

/// Refuses a number of ranks that this server does not offer.
pub(crate) fn check_ranks(app: &App, ranks: u32) -> Result<(), ApiError> {
    let most = app.engine.abilities().ranks;
    if (1..=most).contains(&ranks) {
        return Ok(());
    }
    let detail = match most {
        1 => "Runs of this server are single processes: 1 rank. A site file of Slurm with a table [ranks] offers more.".to_owned(),
        most => format!("A run of this server has 1 to {most} ranks."),
    };
    Err(ApiError::bad_request("invalid number of ranks", detail))
}

/// Refuses to compute for a user whose core hours are spent.
pub(crate) fn may_compute(app: &App, user: i64) -> Result<(), ApiError> {
    let usage = app.db.usage(user)?;
    match usage.most_core_seconds {
        Some(most) if usage.core_seconds >= most => Err(ApiError::new(
            StatusCode::FORBIDDEN,
            "no core hours are left",
            format!(
                "Your runs have spent the {:.4} core hours that they may. An administrator can grant more.",
                most / 3600.0
            ),
        )),
        _ => Ok(()),
    }
}

/// Refuses what a user may not have: so many cores at once, so many bytes on top of what there is.
pub(crate) fn within_quota(app: &App, user: i64, cores: u32, bytes: u64) -> Result<(), ApiError> {
    let usage = app.db.usage(user)?;
    if let Some(most) = usage.most_cores
        && u64::from(cores) > most
    {
        return Err(ApiError::new(
            StatusCode::FORBIDDEN,
            "too many cores",
            format!("Your runs may have {most} cores at once."),
        ));
    }
    match usage.most_disk {
        Some(most) if usage.disk.saturating_add(bytes) > most => Err(full(&usage, bytes)),
        _ => Ok(()),
    }
}

/// An answer that a user has too little disk for so many more bytes.
pub(crate) fn full(usage: &Usage, bytes: u64) -> ApiError {
    let megabytes = |bytes: u64| format!("{:.1} MB", bytes as f64 / 1e6);
    let (needs, has) = (megabytes(bytes), megabytes(usage.disk));
    let may = megabytes(usage.most_disk.unwrap_or(u64::MAX));
    ApiError::new(
        StatusCode::FORBIDDEN,
        "too little disk is left",
        format!(
            "This needs {needs}; your runs and inputs take {has}, with what live runs are expected to write, and may take {may}. \
             Delete runs, or inputs that no run names (on the page Account), or wait until live runs end."
        ),
    )
}

/// Result of a change that takes so many bytes of a user, or the answer why it was not made.
pub(crate) fn granted<T>(change: Reserved<T>, bytes: u64) -> Result<T, ApiError> {
    match change {
        Reserved::Done(done) => Ok(done),
        // Other requests of this user have taken the rest since.
        Reserved::Full(usage) => Err(full(&usage, bytes)),
        Reserved::NoUser => Err(not_logged_in()),
        Reserved::NoInput => Err(ApiError::new(
            StatusCode::CONFLICT,
            "a file is missing",
            "A file of this scene was removed meanwhile, with the last run that named it. Send the files and the request again.",
        )),
    }
}

/// Bytes that a plan expects of its run; 0 without a plan. The limits of users hold while runs run, too.
pub(crate) fn expected_bytes(plan: &Value) -> u64 {
    plan["disk"]["bytes"].as_f64().unwrap_or(0.0) as u64
}

/// Refuses a title, label or name with control characters, and one that is too long.
pub(crate) fn checked_text(what: &str, text: &str) -> Result<(), ApiError> {
    check_text(text)
        .map_err(|why| ApiError::bad_request(format!("invalid {what}"), format!("{text:?}: {why}")))
}

/// A word for a title: what the user says, what the scene says, what the file is called.
pub(crate) fn title(given: Option<&str>, plan: &Value, scene: &Scene) -> Result<String, ApiError> {
    let own = plan["title"].as_str().filter(|title| !title.is_empty());
    let title = given
        .filter(|title| !title.trim().is_empty())
        .or(own)
        .unwrap_or(&scene.name);
    checked_text("title", title)?;
    Ok(title.to_owned())
}

pub(crate) fn label(given: Option<&str>) -> Result<&str, ApiError> {
    let label = given.unwrap_or_default();
    checked_text("label", label)?;
    Ok(label)
}

/// The plan of a scene that can run; null where it is too large for a check.
pub(crate) async fn plan(app: &Arc<App>, user: &User, scene: &Scene) -> Result<Value, ApiError> {
    let checked = check(app, user.id, scene.clone(), false).await?;
    match checked.plan {
        _ if checked.unchecked.is_some() => Ok(Value::Null),
        Some(plan) if checked.problems.is_empty() => Ok(plan),
        _ => Err(ApiError::unrunnable(checked.problems)),
    }
}

/// A run before it is written.
pub(crate) struct PreparedRun {
    pub(crate) id: RunId,
    pub(crate) title: String,
    pub(crate) spec: Spec,
    pub(crate) spec_text: String,
    /// SHA-256 of the text of the scene, if its user did not have it.
    pub(crate) new_text: Option<String>,
    pub(crate) steps: Option<u64>,
}

pub(crate) fn prepare(
    app: &App,
    user: &User,
    submit: &Submit,
    plan: &Value,
    title: String,
) -> Result<PreparedRun, ApiError> {
    if !(1..=1024).contains(&submit.threads) {
        return Err(ApiError::bad_request(
            "invalid number of threads",
            "A run has 1 to 1024 threads.",
        ));
    }
    if submit
        .time_limit
        .is_some_and(|limit| !limit.is_finite() || limit < 1.0)
    {
        return Err(ApiError::bad_request(
            "invalid limit of time",
            "It is a time in s, 1 s at least.",
        ));
    }
    check_ranks(app, submit.ranks)?;
    let forecast = forecast(app, plan, cores(submit.threads, submit.ranks))?;
    let mut files: BTreeMap<String, InputFile> = inspect(app, user.id, &submit.scene)?
        .into_iter()
        .map(|(name, sha256, bytes)| (name, InputFile { sha256, bytes }))
        .collect();
    let text = submit.scene.text.as_bytes();
    let digits = sha256(text);
    let is_new = inputs::add(app, user.id, &digits, text.len() as u64, || {
        Ok(app.store.put(&inputs::key(&digits), text)?)
    })?;
    let new_text = is_new.then(|| digits.clone());
    files.insert(
        submit.scene.name.clone(),
        InputFile {
            sha256: digits,
            bytes: text.len() as u64,
        },
    );
    let spec = Spec {
        revision: 1,
        title: title.clone(),
        scene: submit.scene.name.clone(),
        files,
        set: submit.scene.set.clone(),
        result: submit.result.clone(),
        threads: submit.threads,
        disk: forecast.disk,
        memory: forecast.memory,
        solver: app.version.clone(),
        branch: None,
    };
    let spec_text = serde_json::to_string(&spec).map_err(ApiError::internal)?;
    Ok(PreparedRun {
        id: secrets::run_id()?,
        title,
        spec,
        spec_text,
        new_text,
        steps: forecast.steps,
    })
}

/// Removes what runs that were refused have in the store.
pub(crate) fn undo(app: &App, user: &User, runs: &[PreparedRun]) -> Result<(), ApiError> {
    for run in runs {
        app.store.delete_all(&format!("runs/{}/", run.id))?;
        if let Some(text) = &run.new_text {
            inputs::take(app, user.id, text)?;
        }
    }
    Ok(())
}

/// Writes the files of a run into the store, before the database knows of the run: a run without its files is never seen.
pub(crate) fn write(app: &App, run: &PreparedRun) -> Result<(), ApiError> {
    let id = &run.id;
    app.store.put(
        &format!("runs/{id}/spec.{}.json", run.spec.revision),
        run.spec_text.as_bytes(),
    )?;
    let head = serde_json::to_vec_pretty(&Head::default()).map_err(ApiError::internal)?;
    app.store
        .swap(&format!("runs/{id}/head.json"), None, &head)?;
    Ok(())
}

/// Submits a run. The same key with the same body is the same run.
pub(crate) async fn submit(
    app: &Arc<App>,
    user: &User,
    mut submit: Submit,
    key: Option<&str>,
    branch: Option<Branch>,
) -> Result<String, ApiError> {
    let body = serde_json::to_string(&submit).map_err(ApiError::internal)?;
    if let Some(id) = by_idempotency_key(app, "runs", user, key, &body)? {
        return Ok(id);
    }
    let (shared, owner) = (Arc::clone(app), user.id);
    let submit = blocking(move || {
        earlier::pin(&shared, owner, &mut submit.scene)?;
        Ok(submit)
    })
    .await?;
    let plan = plan(app, user, &submit.scene).await?;
    let label = label(submit.label.as_deref())?.to_owned();
    let title = title(submit.title.as_deref(), &plan, &submit.scene)?;
    let (user, key, app) = (user.clone(), key.map(str::to_owned), Arc::clone(app));
    blocking(move || {
        if let Some(project) = &submit.project {
            projects::need(&app, &user, project, Role::Member)?;
        }
        let reserved = expected_bytes(&plan);
        may_compute(&app, user.id)?;
        within_quota(&app, user.id, cores(submit.threads, submit.ranks), reserved)?;
        let mut run = prepare(&app, &user, &submit, &plan, title)?;
        run.spec.branch = branch;
        run.spec_text = serde_json::to_string(&run.spec).map_err(ApiError::internal)?;
        write(&app, &run)?;
        let id = run.id.to_string();
        let new = NewRun {
            id: &id,
            owner: user.id,
            key: key.as_deref().map(|key| (key, body.as_str())),
            title: &run.title,
            label: &label,
            spec: &run.spec_text,
            threads: run.spec.threads,
            ranks: submit.ranks,
            memory: run.spec.memory,
            of_steps: run.steps,
            study: None,
            project: submit.project.as_deref(),
            reserved,
            time_limit: submit.time_limit,
        };
        match app
            .db
            .insert(&[new], None)
            .map(|new| granted(new, reserved))
        {
            Ok(Ok(events)) => app.publish(events),
            Ok(Err(refused)) => {
                undo(&app, &user, &[run])?;
                return Err(refused);
            }
            // Two requests with one key at once: the other one was faster.
            Err(error) => {
                undo(&app, &user, &[run])?;
                return by_idempotency_key(&app, "runs", &user, key.as_deref(), &body)?
                    .ok_or_else(|| ApiError::internal(error));
            }
        }
        app.wake_reconciler();
        Ok(id)
    })
    .await
}

/// Id of the run or study that was submitted with this key. `table`: `runs` or `studies`.
pub(crate) fn by_idempotency_key(
    app: &App,
    table: &str,
    user: &User,
    key: Option<&str>,
    body: &str,
) -> Result<Option<String>, ApiError> {
    let Some(key) = key else { return Ok(None) };
    match app.db.by_key(table, user.id, key)? {
        Some((id, before)) if before == body => Ok(Some(id)),
        Some(_) => Err(ApiError::new(
            StatusCode::CONFLICT,
            "the key is in use",
            "This Idempotency-Key was sent with another body before.",
        )),
        None => Ok(None),
    }
}

/// A run that a user or guest may see.
pub(crate) struct VisibleRun {
    pub(crate) id: RunId,
    pub(crate) owner: i64,
    pub(crate) state: cloud_api::lifecycle::Run,
    pub(crate) row: RunRow,
    pub(crate) spec: Spec,
}

/// A run that a user may change: the owner, or a member of its project. Functions that change a run take one.
pub(crate) struct ChangeableRun(VisibleRun);

impl std::ops::Deref for ChangeableRun {
    type Target = VisibleRun;

    fn deref(&self) -> &VisibleRun {
        &self.0
    }
}

/// A run, if the user or guest may see it.
pub(crate) fn visible_run(app: &App, caller: &Caller, id: &str) -> Result<VisibleRun, ApiError> {
    let id: RunId = id.parse().map_err(|_| ApiError::not_found())?;
    let (owner, state, row, spec) = app.db.run(id.as_str())?.ok_or_else(ApiError::not_found)?;
    let is_visible = match (caller, &row.project) {
        (Caller::Guest(guest), _) => guest.run == id.as_str(),
        (Caller::User(user), _) if owner == user.id => true,
        (Caller::User(user), Some(project)) => projects::role(app, user, project)?.is_some(),
        (Caller::User(_), None) => false,
    };
    if !is_visible {
        return Err(ApiError::not_found());
    }
    Ok(VisibleRun {
        id,
        owner,
        state,
        row,
        spec: serde_json::from_str(&spec).map_err(ApiError::internal)?,
    })
}

/// A run, if the user may change it.
pub(crate) fn changeable_run(app: &App, user: &User, id: &str) -> Result<ChangeableRun, ApiError> {
    let run = visible_run(app, &Caller::User(user.clone()), id)?;
    if let Some(project) = &run.row.project
        && run.owner != user.id
    {
        projects::need(app, user, project, Role::Member)?;
    }
    Ok(ChangeableRun(run))
}

/// Goes on with a run, on another number of ranks if that is given.
pub(crate) fn resume(app: &App, run: &ChangeableRun, ranks: Option<u32>) -> Result<(), ApiError> {
    if let Some(ranks) = ranks {
        check_ranks(app, ranks)?;
    }
    may_compute(app, run.owner)?;
    let more = ranks.map_or(0, |ranks| cores(run.spec.threads, ranks));
    within_quota(app, run.owner, more, 0)?;
    let applied = app.db.resume(run.id.as_str(), ranks, app.engine.as_ref())?;
    after(app, applied)
}

/// Records an event that the user wants.
pub(crate) fn change(app: &App, run: &ChangeableRun, event: &RunEvent) -> Result<(), ApiError> {
    let applied = (app.db).apply(run.id.as_str(), event, None, app.engine.as_ref())?;
    after(app, applied)
}

/// Publishes what was changed, or says why it was not.
fn after(app: &App, applied: Applied) -> Result<(), ApiError> {
    match applied {
        Applied::Done(_, events) => app.publish(events),
        Applied::Missing => return Err(ApiError::not_found()),
        Applied::Illegal(illegal) => {
            return Err(ApiError::new(
                StatusCode::CONFLICT,
                "not in this state",
                illegal.to_string(),
            ));
        }
    }
    app.wake_reconciler();
    Ok(())
}

/// The scene of a run as it was submitted, to be cloned.
pub(crate) fn scene(app: &App, spec: &Spec) -> Result<Scene, ApiError> {
    let text = spec
        .files
        .get(&spec.scene)
        .ok_or_else(ApiError::not_found)?;
    let text = app
        .store
        .get(&format!("inputs/{}", text.sha256))?
        .ok_or_else(ApiError::not_found)?;
    let others = spec.files.iter().filter(|(name, _)| **name != spec.scene);
    Ok(Scene {
        name: spec.scene.clone(),
        text: String::from_utf8_lossy(&text).into_owned(),
        files: others
            .map(|(name, file)| (name.clone(), file.sha256.clone()))
            .collect(),
        set: spec.set.clone(),
    })
}

/// Scene, files and settings for a new run like another one.
pub(crate) fn like(app: &App, user: &User, run: VisibleRun) -> Result<Submit, ApiError> {
    let VisibleRun { row, spec, .. } = run;
    let scene = scene(app, &spec)?;
    // Files of a run that one may see are files that one may use.
    for file in spec.files.values() {
        // A content that this run named, until now.
        let gone = || Err(ApiError::not_found());
        inputs::add(app, user.id, &file.sha256, file.bytes, gone)?;
    }
    let label = (!row.label.is_empty()).then_some(row.label);
    Ok(Submit {
        scene,
        title: Some(row.title),
        label,
        threads: spec.threads,
        // This server may offer fewer than when that run was submitted.
        ranks: row.ranks.min(app.engine.abilities().ranks),
        time_limit: row.time_limit,
        result: spec.result,
        project: row
            .project
            .filter(|project| projects::need(app, user, project, Role::Member).is_ok()),
    })
}

/// Gives a run a later end: a further revision of its spec, on the same data.
pub(crate) async fn extend(
    app: &Arc<App>,
    user: &User,
    id: &str,
    end: f64,
) -> Result<(), ApiError> {
    if !end.is_finite() || end <= 0.0 {
        return Err(ApiError::bad_request(
            "invalid end",
            "It is a time in s, larger than 0.",
        ));
    }
    let ChangeableRun(VisibleRun {
        id,
        owner,
        state: run,
        row,
        mut spec,
    }) = changeable_run(app, user, id)?;
    if end <= row.time {
        let detail = format!(
            "The run has come to {} s already; its new end is later than that.",
            row.time
        );
        return Err(ApiError::bad_request("invalid end", detail));
    }
    let mut scene = scene(app, &spec)?;
    scene
        .set
        .retain(|set| !set.trim_start().starts_with("time.end="));
    scene.set.push(format!("time.end={end}"));
    let owner_user = User {
        id: owner,
        ..user.clone()
    };
    let plan = plan(app, &owner_user, &scene).await?;
    let cores = cores(spec.threads, row.ranks);
    let forecast = forecast(app, &plan, cores)?;
    let reserved = expected_bytes(&plan);
    spec.revision = run.revision + 1;
    spec.set = scene.set;
    let text = serde_json::to_string(&spec).map_err(ApiError::internal)?;
    let app = Arc::clone(app);
    blocking(move || {
        may_compute(&app, owner)?;
        within_quota(&app, owner, cores, 0)?;
        // One extension at a time: the spec in the store is that of the one that is accepted.
        let _turn = app
            .extensions
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        let other = || {
            let detail = "Another extension of this run was accepted meanwhile.";
            ApiError::new(StatusCode::CONFLICT, "the run was changed", detail)
        };
        let (_, now, ..) = app.db.run(id.as_str())?.ok_or_else(ApiError::not_found)?;
        if now.revision != run.revision {
            return Err(other());
        }
        app.store.put(
            &format!("runs/{id}/spec.{}.json", spec.revision),
            text.as_bytes(),
        )?;
        let extension = Extension {
            after: run.revision,
            spec: &text,
            of_steps: forecast.steps,
            reserved,
        };
        let extended = (app.db).extend(id.as_str(), &extension, app.engine.as_ref())?;
        after(&app, granted(extended, reserved)?.ok_or_else(other)?)
    })
    .await
}

/// Removes a run with all its files. One that has an attempt has to be stopped first.
pub(crate) fn delete(app: &App, run: &ChangeableRun) -> Result<(), ApiError> {
    forget(app, run.id.as_str())
}

/// Removes a run that is not live, with all its files.
pub(crate) fn forget(app: &App, id: &str) -> Result<(), ApiError> {
    let inputs = match app.db.delete(id)? {
        Deleted::Done(inputs) => inputs,
        // Another request has removed it.
        Deleted::Missing => return Ok(()),
        Deleted::Live => {
            let detail = "Stop the run first.";
            return Err(ApiError::new(
                StatusCode::CONFLICT,
                "the run is not over",
                detail,
            ));
        }
    };
    app.attempts.forget(id);
    app.cache.forget(id);
    // The head last but one glance: a worker that was given up finds it gone, and ends.
    app.store.delete_all(&format!("runs/{id}/"))?;
    inputs::remove(app, &inputs)
}

/// Work that waits for disks, on a thread that may.
pub(crate) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, ApiError> + Send + 'static,
) -> Result<T, ApiError> {
    tokio::task::spawn_blocking(work)
        .await
        .map_err(ApiError::internal)?
}

/// Adds to a row what was seen of the run lately.
pub(crate) fn with_life(app: &App, mut row: RunRow) -> RunRow {
    if row.state.has_attempt()
        && let Some(seen) = app.attempts.get(&row.id)
    {
        row.waits = seen.waits;
        if let Some(beat) = seen.beat {
            row.step = row.step.max(beat.step);
            row.of_steps = beat.of_steps.or(row.of_steps);
            row.time = row.time.max(beat.time);
            row.seconds_left = beat.seconds_left;
            row.particles = beat.particles;
        }
    }
    row
}
