//! Rows of the database as types.

use cloud_api::answers::{Attempt, RunRow};
use cloud_api::head::Cause;
use cloud_api::lifecycle::Run;
use cloud_api::{RunState, Wish};
use rusqlite::Row;
use serde_json::Value;

use super::Result;

pub(super) fn wish_word(wish: Wish) -> &'static str {
    match wish {
        Wish::Run => "run",
        Wish::Stop => "stop",
        Wish::Kill => "kill",
    }
}

pub(crate) fn unknown(column: &str, word: String) -> rusqlite::Error {
    rusqlite::Error::InvalidColumnType(0, format!("{column} {word:?}"), rusqlite::types::Type::Text)
}

pub(super) fn state_of(row: &Row) -> Result<RunState> {
    let word: String = row.get("state")?;
    RunState::of(&word).ok_or_else(|| unknown("state", word))
}

fn cause_of(row: &Row) -> Result<Option<Cause>> {
    let word: Option<String> = row.get("cause")?;
    word.map(|word| {
        serde_json::from_value(Value::String(word.clone())).map_err(|_| unknown("cause", word))
    })
    .transpose()
}

pub(super) fn run_of(row: &Row) -> Result<Run> {
    let wish: String = row.get("wish")?;
    Ok(Run {
        state: state_of(row)?,
        wish: match wish.as_str() {
            "stop" => Wish::Stop,
            "kill" => Wish::Kill,
            _ => Wish::Run,
        },
        epoch: row.get::<_, i64>("epoch")? as u64,
        revision: row.get("revision")?,
        submitted: row.get("submitted")?,
        step: row.get::<_, i64>("step")? as u64,
        barren: row.get("barren")?,
        not_before: row.get("not_before")?,
    })
}

pub(super) fn row_of(row: &Row) -> Result<RunRow> {
    let spec: String = row.get("spec")?;
    let spec: Value = serde_json::from_str(&spec).unwrap_or(Value::Null);
    let set = spec["set"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|set| set.as_str().map(str::to_owned));
    Ok(RunRow {
        id: row.get("id")?,
        title: row.get("title")?,
        label: row.get("label")?,
        study: row.get("study")?,
        project: row.get("project")?,
        owner: row
            .get::<_, Option<String>>("owner_name")?
            .unwrap_or_default(),
        state: state_of(row)?,
        created: row.get("created")?,
        changed: row.get("changed")?,
        epoch: row.get::<_, i64>("epoch")? as u64,
        step: row.get::<_, i64>("step")? as u64,
        of_steps: row
            .get::<_, Option<i64>>("of_steps")?
            .map(|steps| steps as u64),
        time: row.get("time")?,
        ranks: row.get("ranks")?,
        core_seconds: row.get("core_seconds")?,
        time_limit: row.get("time_limit")?,
        cost: row.get("cost")?,
        saved: row.get("saved")?,
        cause: cause_of(row)?,
        message: row.get("message")?,
        seconds_left: None,
        waits: None,
        particles: None,
        set: set.collect(),
    })
}

pub(super) fn attempt_of(row: &Row) -> Result<Attempt> {
    Ok(Attempt {
        epoch: row.get::<_, i64>("epoch")? as u64,
        engine: row.get("engine")?,
        started: row.get("started")?,
        ended: row.get("ended")?,
        cause: cause_of(row)?,
        code: row.get("code")?,
        message: row.get("message")?,
        machine: row.get("machine")?,
        step: row.get::<_, Option<i64>>("step")?.map(|step| step as u64),
        cost: row.get("cost")?,
    })
}
