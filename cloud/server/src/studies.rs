//! Studies: one scene at many values of its keys.
//!
//! Runs of a study, their names and their problems come from the solver (`--check --json` of
//! `--sweep`, or of a study file), so a grid means the same here as at the command line.

use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;
use std::time::Duration;

use axum::http::StatusCode;
use cloud_api::answers::{
    ResultColumn, StudyChecked, StudyList, StudyRow, StudyRun, StudySubmitted, StudyTable,
};
use cloud_api::problem::SceneProblem;
use cloud_api::requests::{Role, Study};
use cloud_api::{RunId, RunState};
use mercury_common::formats::delimited::push_line;
use mercury_common::formats::table_head;
use rusqlite::{OptionalExtension, params};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::access::ApiError;
use crate::check::{LARGEST_SCENE, inspect, lay_out, solve};
use crate::content::Content;
use crate::db::{ListScope, MOST_ROWS, NewRun, NewStudy};
use crate::runs::{
    PreparedRun, blocking, by_idempotency_key, cores, expected_bytes, granted, label, may_compute,
    prepare, title, undo, within_quota, write,
};
use crate::secrets::{self, User};
use crate::state::App;
use crate::{earlier, means, projects};

/// The most keys of a grid.
const MOST_SWEEPS: usize = 20;

/// How long the check of all runs of a study may take.
const PATIENCE: Duration = Duration::from_secs(30);

/// Threads that write the runs of a study.
const WRITERS: usize = 8;

/// Name of a study file beside its scene.
const FILE: &str = "study.toml";

/// Keys, results and runs of a study: read from the solver's `--check --json`, kept in the database.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Plan {
    keys: Vec<String>,
    /// Name and definition.
    results: Vec<(String, String)>,
    plots: Vec<String>,
    runs: Vec<PlannedRun>,
    /// Title of the scene.
    #[serde(default, skip_serializing)]
    title: String,
}

/// A run of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct PlannedRun {
    id: String,
    name: String,
    values: Vec<Option<String>>,
    /// All `--set` of the run.
    #[serde(skip_serializing)]
    set: Vec<String>,
    #[serde(skip_serializing)]
    steps: Value,
    /// Most memory, in bytes.
    #[serde(skip_serializing)]
    memory: Value,
    /// Size of all files, in bytes.
    #[serde(skip_serializing)]
    disk: Value,
}

impl PlannedRun {
    /// Steps, memory and disk as the plan of a single run has them.
    fn needs(&self) -> Value {
        json!({
            "time": {"steps": self.steps},
            "memory": {"at_most": self.memory},
            "disk": {"bytes": self.disk},
        })
    }

    /// The value of a key: that of the last `--set`.
    fn value(&self, key: &str) -> Option<String> {
        let value = |set: &String| Some(set.strip_prefix(key)?.strip_prefix('=')?.to_owned());
        self.set.iter().rev().find_map(value)
    }
}

impl Plan {
    /// The plan in an answer of the solver.
    fn read(answer: &Value) -> Option<Self> {
        let mut study = answer.get("study")?.clone();
        let results = study["results"].as_object().into_iter().flatten();
        study["results"] = results.map(|(name, what)| json!([name, what])).collect();
        let mut plan: Self = serde_json::from_value(study).ok()?;
        for run in &mut plan.runs {
            run.values = plan.keys.iter().map(|key| run.value(key)).collect();
        }
        Some(plan)
    }
}

/// A problem found by the server itself.
fn wrong(message: String, help: &str) -> SceneProblem {
    SceneProblem {
        message,
        help: Some(help.to_owned()),
        ..SceneProblem::default()
    }
}

/// Whether a text has the table `study`. The solver reports other errors.
fn is_study(text: &str) -> bool {
    match text.parse::<toml::Table>() {
        Ok(document) => document.contains_key("study"),
        Err(_) => text.contains("study"),
    }
}

/// The plan of a study, or its problems.
fn expand(app: &App, owner: i64, study: &Study) -> Result<(Plan, Vec<SceneProblem>), ApiError> {
    let scene = &study.base.scene;
    let files = inspect(app, owner, scene)?;
    let nothing = |problem| Ok((Plan::default(), vec![problem]));
    if study.file.is_some() != study.sweep.is_empty() {
        return Err(ApiError::bad_request(
            "invalid study",
            "Expected either `sweep` or `file`.",
        ));
    }
    if study.sweep.len() > MOST_SWEEPS || study.base.result.len() > MOST_ROWS {
        return Err(ApiError::bad_request(
            "invalid study",
            format!("At most {MOST_SWEEPS} keys and {MOST_ROWS} results."),
        ));
    }
    let options = study.sweep.iter().chain(&study.base.result);
    if options
        .clone()
        .any(|text| text.contains('\0') || text.len() > 100_000)
    {
        return Err(ApiError::bad_request(
            "invalid study",
            "A sweep or a result is too long, or contains a zero byte.",
        ));
    }
    let folder = lay_out(app, scene, &files)?;
    let mut arguments = Vec::new();
    match &study.file {
        Some(text) => {
            if text.len() > LARGEST_SCENE {
                let detail = "A study has at most 1 MB.";
                return Err(ApiError::new(
                    StatusCode::PAYLOAD_TOO_LARGE,
                    "the study is too long",
                    detail,
                ));
            }
            if !is_study(text) {
                return nothing(wrong(
                    format!("{FILE} is no study"),
                    "a study has the table [study] with `scene` and [study.sweep]",
                ));
            }
            if scene.name == FILE || scene.files.contains_key(FILE) {
                return nothing(wrong(
                    format!("another file is called {FILE}"),
                    "call the other file something else",
                ));
            }
            fs::write(folder.0.join(FILE), text)?;
            arguments.push(FILE.to_owned());
        }
        None => {
            arguments.push(scene.name.clone());
            arguments.extend(study.sweep.iter().map(|sweep| format!("--sweep={sweep}")));
        }
    }
    arguments.extend(["--check", "--json", "--within", "."].map(str::to_owned));
    arguments.extend(
        study
            .base
            .result
            .iter()
            .map(|result| format!("--result={result}")),
    );
    arguments.extend(scene.set.iter().map(|set| format!("--set={set}")));
    let said = solve(app, &folder, &arguments, PATIENCE)?;
    let (answer, problems) = said.parts();
    let Some(answer) = answer.filter(|_| problems.is_empty()) else {
        return Ok((Plan::default(), problems));
    };
    let Some(plan) = Plan::read(&answer) else {
        return nothing(wrong(
            "the study has one run".to_owned(),
            "give a key several values",
        ));
    };
    let named = answer["study"]["scene"].as_str().unwrap_or_default();
    if study.file.is_some() && named != scene.name {
        return nothing(wrong(
            format!(
                "study.scene: the scene beside this study is called {}, not {named}",
                scene.name
            ),
            "use the name of the scene, without folders",
        ));
    }
    Ok((plan, Vec::new()))
}

/// Keys, runs and results of a study, and its problems.
pub(crate) async fn check(
    app: &Arc<App>,
    user: &User,
    mut study: Study,
) -> Result<StudyChecked, ApiError> {
    let _turn = app.checks.take((user.id, false)).await?;
    let (app, owner) = (Arc::clone(app), user.id);
    blocking(move || {
        earlier::pin(&app, owner, &mut study.base.scene)?;
        let (plan, problems) = expand(&app, owner, &study)?;
        Ok(StudyChecked {
            problems,
            keys: plan.keys,
            runs: plan.runs.into_iter().map(|run| run.name).collect(),
            results: plan.results.into_iter().map(|(name, _)| name).collect(),
        })
    })
    .await
}

/// Submits the runs of a study, all or none. The same key with the same body is the same study.
pub(crate) async fn submit(
    app: &Arc<App>,
    user: &User,
    mut study: Study,
    key: Option<String>,
) -> Result<StudySubmitted, ApiError> {
    let body = serde_json::to_string(&study).map_err(ApiError::internal)?;
    if let Some(before) = submitted(app, user, key.as_deref(), &body)? {
        return Ok(before);
    }
    let _turn = app.checks.take((user.id, false)).await?;
    let (app, user) = (Arc::clone(app), user.clone());
    blocking(move || {
        earlier::pin(&app, user.id, &mut study.base.scene)?;
        let (mut plan, problems) = expand(&app, user.id, &study)?;
        if !problems.is_empty() {
            return Err(ApiError::unrunnable(problems));
        }
        let base = &study.base;
        if let Some(project) = &base.project {
            projects::need(&app, &user, project, Role::Member)?;
        }
        let bytes: u64 = plan
            .runs
            .iter()
            .map(|run| expected_bytes(&run.needs()))
            .sum();
        may_compute(&app, user.id)?;
        within_quota(&app, user.id, cores(base.threads, base.ranks), bytes)?;
        let id = secrets::run_id()?.to_string();
        let mut called = None;
        let scene = json!({"title": plan.title});
        let mut runs: Vec<PreparedRun> = Vec::new();
        for run in &mut plan.runs {
            let mut one = base.clone();
            one.scene.set.clone_from(&run.set);
            one.result = plan
                .results
                .iter()
                .map(|(name, what)| format!("{name}={what}"))
                .collect();
            let called = called.get_or_insert(title(base.title.as_deref(), &scene, &base.scene)?);
            let named = shortened(called, &run.name);
            let made = prepare(&app, &user, &one, &run.needs(), named)?;
            run.id = made.id.to_string();
            runs.push(made);
        }
        let called = called.unwrap_or_default();
        let label = label(base.label.as_deref().or(Some(&called)))?.to_owned();
        write_all(&app, &runs)?;
        let ids: Vec<String> = runs.iter().map(|run| run.id.to_string()).collect();
        let new: Vec<NewRun> = (runs.iter().zip(&ids).zip(&plan.runs))
            .map(|((run, name), planned)| NewRun {
                reserved: expected_bytes(&planned.needs()),
                id: name,
                owner: user.id,
                key: None,
                title: &run.title,
                label: &label,
                spec: &run.spec_text,
                threads: run.spec.threads,
                ranks: base.ranks,
                memory: run.spec.memory,
                of_steps: run.steps,
                study: Some(&id),
                project: base.project.as_deref(),
                time_limit: base.time_limit,
            })
            .collect();
        let plan = serde_json::to_string(&plan).map_err(ApiError::internal)?;
        let row = NewStudy {
            id: &id,
            owner: user.id,
            key: key.as_deref().map(|key| (key, body.as_str())),
            title: &called,
            plan: &plan,
            project: base.project.as_deref(),
        };
        match (app.db.insert(&new, Some(&row))).map(|new| granted(new, bytes)) {
            Ok(Ok(events)) => app.publish(events),
            Ok(Err(refused)) => {
                undo(&app, &user, &runs)?;
                return Err(refused);
            }
            // Two requests with one key at once: the other one was faster.
            Err(error) => {
                undo(&app, &user, &runs)?;
                return submitted(&app, &user, key.as_deref(), &body)?
                    .ok_or_else(|| ApiError::internal(error));
            }
        }
        app.wake_reconciler();
        Ok(StudySubmitted { id, runs: ids })
    })
    .await
}

/// Writes what the store has to have, several runs at a time: each waits for a disk or a network.
fn write_all(app: &App, runs: &[PreparedRun]) -> Result<(), ApiError> {
    let share = runs.len().div_ceil(WRITERS).max(1);
    std::thread::scope(|scope| {
        let parts: Vec<_> = (runs.chunks(share))
            .map(|part| scope.spawn(move || part.iter().try_for_each(|run| write(app, run))))
            .collect();
        parts.into_iter().try_for_each(|part| {
            part.join()
                .map_err(|_| ApiError::internal("a writer thread ended unexpectedly"))?
        })
    })
}

/// The title of a run of a study.
fn shortened(study: &str, run: &str) -> String {
    let title = format!("{study}: {run}");
    if title.len() <= 200 {
        return title;
    }
    let end = (0..=196)
        .rev()
        .find(|&end| title.is_char_boundary(end))
        .unwrap_or(0);
    format!("{} …", &title[..end])
}

/// Id and runs of the study that was submitted with this key.
fn submitted(
    app: &App,
    user: &User,
    key: Option<&str>,
    body: &str,
) -> Result<Option<StudySubmitted>, ApiError> {
    let Some(id) = by_idempotency_key(app, "studies", user, key, body)? else {
        return Ok(None);
    };
    let query = "SELECT plan FROM studies WHERE id = ?1";
    let plan: String = (app.db.lock()).query_row(query, [&id], |row| row.get(0))?;
    let plan: Plan = serde_json::from_str(&plan).map_err(ApiError::internal)?;
    let runs = plan.runs.into_iter().map(|run| run.id).collect();
    Ok(Some(StudySubmitted { id, runs }))
}

/// A page of studies, newest first.
pub(crate) fn list(
    app: &App,
    scope: ListScope,
    after: Option<&str>,
) -> Result<StudyList, ApiError> {
    let connection = app.db.lock();
    let (column, value) = scope.column();
    let mut query = connection.prepare_cached(&format!(
        "SELECT id, title, created FROM studies WHERE {column} = ?1
         AND (?2 IS NULL OR number < (SELECT number FROM studies WHERE id = ?2)) ORDER BY number DESC LIMIT ?3",
    ))?;
    let rows = query.query_map(params![value, after, MOST_ROWS as i64 + 1], |row| {
        Ok(StudyRow {
            id: row.get(0)?,
            title: row.get(1)?,
            created: row.get(2)?,
            states: BTreeMap::new(),
        })
    })?;
    let mut studies = rows.collect::<Result<Vec<_>, _>>()?;
    let after = (studies.len() > MOST_ROWS).then(|| studies[MOST_ROWS - 1].id.clone());
    studies.truncate(MOST_ROWS);
    let mut count = connection
        .prepare_cached("SELECT state, count(*) FROM runs WHERE study = ?1 GROUP BY state")?;
    for study in &mut studies {
        let states = count.query_map([&study.id], |row| {
            Ok((row.get(0)?, row.get::<_, i64>(1)? as u64))
        })?;
        study.states = states.collect::<Result<_, _>>()?;
    }
    Ok(StudyList { studies, after })
}

/// A run of the table as the database has it.
struct Row {
    id: String,
    state: RunState,
    message: String,
    step: u64,
    core_seconds: f64,
    results: Option<String>,
}

/// The table of a study: values of its keys, and results of its runs.
pub(crate) fn table(app: &App, user: &User, id: &str) -> Result<StudyTable, ApiError> {
    let found = app
        .db
        .lock()
        .query_row(
            "SELECT title, created, plan FROM studies WHERE id = ?1
               AND (owner = ?2 OR project IN (SELECT project FROM members WHERE user = ?2))",
            params![id, user.id],
            |row| {
                Ok((
                    row.get::<_, String>(0)?,
                    row.get::<_, f64>(1)?,
                    row.get::<_, String>(2)?,
                ))
            },
        )
        .optional()?;
    let (title, created, plan) = found.ok_or_else(ApiError::not_found)?;
    let plan: Plan = serde_json::from_str(&plan).map_err(ApiError::internal)?;
    let rows = rows(app, id)?;
    let mut states: BTreeMap<String, u64> = BTreeMap::new();
    let mut columns: Vec<ResultColumn> = (plan.results.iter())
        .map(|(name, what)| ResultColumn {
            name: name.clone(),
            what: what.clone(),
            unit: String::new(),
        })
        .collect();
    let mut table = Vec::new();
    for run in &plan.runs {
        // Runs that were deleted are gone from the table.
        let Some(row) = rows.get(&run.id) else {
            continue;
        };
        *states.entry(row.state.word().to_owned()).or_default() += 1;
        let found = match &row.results {
            Some(text) => serde_json::from_str(text).unwrap_or(Value::Null),
            None if row.state == RunState::Finished => results(app, &row.id)?,
            None => Value::Null,
        };
        for column in &mut columns {
            if let Some(unit) = found[&column.name]["unit"].as_str() {
                unit.clone_into(&mut column.unit);
            }
        }
        table.push(StudyRun {
            id: run.id.clone(),
            name: run.name.clone(),
            state: row.state,
            problem: if row.state == RunState::Failed {
                row.message.clone()
            } else {
                String::new()
            },
            step: row.step,
            core_seconds: row.core_seconds,
            values: run.values.clone(),
            results: of_each(&columns, &found, |result| result["value"].as_f64()),
            errors: of_each(&columns, &found, |result| result["error"].as_f64()),
            remarks: of_each(&columns, &found, remark),
        });
    }
    Ok(StudyTable {
        means: means::points(&plan.keys, columns.len(), &table),
        row: StudyRow {
            id: id.to_owned(),
            title,
            created,
            states,
        },
        keys: plan.keys,
        results: columns,
        plots: plan.plots,
        rows: table,
    })
}

/// A property of each result of a run.
fn of_each<T>(
    columns: &[ResultColumn],
    found: &Value,
    property: impl Fn(&Value) -> Option<T>,
) -> Vec<Option<T>> {
    let columns = columns.iter();
    columns
        .map(|column| property(&found[&column.name]))
        .collect()
}

/// Remark of the solver on a result.
fn remark(result: &Value) -> Option<String> {
    ["problem", "note", "why_no_error"]
        .iter()
        .find_map(|kind| result[kind].as_str())
        .map(str::to_owned)
}

fn rows(app: &App, study: &str) -> Result<BTreeMap<String, Row>, ApiError> {
    let connection = app.db.lock();
    let mut query = connection.prepare_cached(
        "SELECT id, state, message, step, core_seconds, results FROM runs WHERE study = ?1",
    )?;
    let rows = query.query_map([study], |row| {
        let id: String = row.get(0)?;
        let state: String = row.get(1)?;
        let row = Row {
            id: id.clone(),
            state: RunState::of(&state).unwrap_or(RunState::Failed),
            message: row.get(2)?,
            step: row.get::<_, i64>(3)? as u64,
            core_seconds: row.get(4)?,
            results: row.get(5)?,
        };
        Ok((id, row))
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}

/// Results of `--result`, from the summary of a finished run; kept in the database from then on.
fn results(app: &App, id: &str) -> Result<Value, ApiError> {
    let run: RunId = id.parse().map_err(|_| ApiError::not_found())?;
    let Some(head) = app.head(&run)? else {
        return Ok(Value::Null);
    };
    let Some(content) = Content::of(&run, &head, "summary.json") else {
        return Ok(Value::Null);
    };
    let text = content.read(app.store.as_ref(), 0..content.bytes())?;
    let found = serde_json::from_slice::<Value>(&text)
        .map_or(Value::Null, |summary| summary["results"].clone());
    app.db.lock().execute(
        "UPDATE runs SET results = ?2 WHERE id = ?1 AND state = 'finished'",
        params![id, found.to_string()],
    )?;
    Ok(found)
}

/// The table as comma-separated values, with units in the head, as in the solver's `study.csv`.
pub(crate) fn csv(table: &StudyTable) -> String {
    let own = ["run", "id", "status", "problem", "steps"].map(|name| (name, ""));
    let keys = table.keys.iter().map(|key| (key.as_str(), ""));
    // As in the solver's table, a result that has an error in some run has a column for it.
    let has_error =
        |k: usize| (table.rows.iter()).any(|row| row.errors.get(k).is_some_and(Option::is_some));
    let with_error: Vec<bool> = (0..table.results.len()).map(has_error).collect();
    let names: Vec<(String, &str)> = (table.results.iter())
        .zip(&with_error)
        .flat_map(|(column, &with_error)| {
            let error = format!("{}_error", column.name);
            let unit = column.unit.as_str();
            [
                Some((column.name.clone(), unit)),
                with_error.then_some((error, unit)),
            ]
        })
        .flatten()
        .collect();
    let results = names.iter().map(|(name, unit)| (name.as_str(), *unit));
    let head = (own.into_iter())
        .chain([("core_seconds", "s")])
        .chain(keys)
        .chain(results);
    let mut text = table_head::line(head).into_bytes();
    for row in &table.rows {
        let mut cells = vec![
            row.name.clone(),
            row.id.clone(),
            row.state.word().to_owned(),
            row.problem.clone(),
            row.step.to_string(),
            row.core_seconds.to_string(),
        ];
        cells.extend(
            row.values
                .iter()
                .map(|value| value.clone().unwrap_or_default()),
        );
        let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        for (k, value) in row.results.iter().enumerate() {
            cells.push(number(*value));
            if with_error[k] {
                cells.push(number(row.errors[k]));
            }
        }
        push_line(&mut text, cells);
    }
    String::from_utf8_lossy(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_are_read() {
        let answer = json!({"study": {"scene": "a.toml", "keys": ["time.end", "walls.\"a=b\".x"], "plots": ["v"],
            "results": {"v": "max(particles.vx)"},
            "runs": [{"name": "one", "set": ["time.end=9", "time.end=2", "walls.\"a=b\".x=3"]}, {"name": "two", "set": []}]}});
        let plan = Plan::read(&answer).unwrap();
        assert_eq!(
            plan.runs[0].values,
            [Some("2".to_owned()), Some("3".to_owned())]
        );
        assert_eq!(plan.runs[1].values, [None, None]);
        assert_eq!(
            plan.results,
            [("v".to_owned(), "max(particles.vx)".to_owned())]
        );
        assert!(Plan::read(&json!({"time": {}})).is_none());
    }

    #[test]
    fn tables_survive_commas_and_quotes() {
        let mut table = StudyTable {
            row: StudyRow {
                id: "s".into(),
                title: "t".into(),
                created: 0.0,
                states: BTreeMap::new(),
            },
            keys: vec!["gravity".into()],
            results: vec![ResultColumn {
                name: "v".into(),
                what: "x".into(),
                unit: "m/s".into(),
            }],
            plots: Vec::new(),
            means: Vec::new(),
            rows: vec![StudyRun {
                id: "r".into(),
                name: "one".into(),
                state: RunState::Failed,
                problem: "a \"b\",\nc".into(),
                step: 3,
                core_seconds: 0.5,
                values: vec![Some("[0, 1]".into())],
                results: vec![Some(0.25)],
                errors: vec![None],
                remarks: vec![None],
            }],
        };
        assert_eq!(
            csv(&table),
            "run,id,status,problem,steps,core_seconds [s],gravity,v [m/s]\n\
             one,r,failed,\"a \"\"b\"\",\nc\",3,0.5,\"[0, 1]\",0.25\n"
        );
        table.rows[0].errors = vec![Some(0.5)];
        assert!(csv(&table).starts_with(
            "run,id,status,problem,steps,core_seconds [s],gravity,v [m/s],v_error [m/s]\n"
        ));
        assert!(csv(&table).ends_with(",0.25,0.5\n"));
    }

    #[test]
    fn results_have_errors_and_remarks() {
        let column = |name: &str| ResultColumn {
            name: name.into(),
            what: String::new(),
            unit: String::new(),
        };
        let columns = ["torque", "top", "tilt", "none"].map(column);
        let found = json!({"torque": {"value": 1.0, "error": 0.5}, "top": {"value": 2.0, "error": null, "why_no_error": "one state"},
            "tilt": {"value": null, "problem": "is NaN"}});
        let errors = of_each(&columns, &found, |result| result["error"].as_f64());
        assert_eq!(errors, [Some(0.5), None, None, None]);
        let remarks = of_each(&columns, &found, remark);
        let said = [None, Some("one state"), Some("is NaN"), None];
        assert_eq!(remarks, said.map(|text| text.map(str::to_owned)));
    }

    #[test]
    fn titles_have_room() {
        assert_eq!(shortened("heap", "friction=1"), "heap: friction=1");
        assert!(shortened(&"ü".repeat(150), "x").len() <= 200);
    }
}
