//! Rows of runs: new ones, single ones and lists.

use std::collections::BTreeMap;

use cloud_api::RunState;
use cloud_api::answers::{Attempt, EventRow, RunRow, Usage};
use cloud_api::lifecycle::Run;
use rusqlite::{OptionalExtension, params};
use serde_json::json;

use super::events::add_event;
use super::rows::{attempt_of, row_of, run_of, state_of, wish_word};
use super::{ALL, Db, MOST_ROWS, NAME_INPUTS, Result, has_user, now};

/// A run as the reconciler needs it.
#[derive(Clone, Debug)]
pub(crate) struct LiveRun {
    pub(crate) id: String,
    pub(crate) owner: i64,
    pub(crate) run: Run,
    pub(crate) threads: u32,
    pub(crate) ranks: u32,
    pub(crate) memory: u64,
}

impl LiveRun {
    /// Its cores.
    pub(crate) fn cores(&self) -> u64 {
        u64::from(self.threads) * u64::from(self.ranks)
    }
}

/// A run that is new.
pub(crate) struct NewRun<'a> {
    pub(crate) id: &'a str,
    pub(crate) owner: i64,
    /// Idempotency key and body of the request.
    pub(crate) key: Option<(&'a str, &'a str)>,
    pub(crate) title: &'a str,
    pub(crate) label: &'a str,
    pub(crate) spec: &'a str,
    pub(crate) threads: u32,
    pub(crate) ranks: u32,
    pub(crate) memory: u64,
    pub(crate) of_steps: Option<u64>,
    pub(crate) study: Option<&'a str>,
    pub(crate) project: Option<&'a str>,
    /// Bytes that its user has less from now on: those that it is expected to write.
    pub(crate) reserved: u64,
    /// Time by the clock after which it is stopped, in s.
    pub(crate) time_limit: Option<f64>,
}

/// Result of a change that takes disk of a user.
pub(crate) enum Reserved<T> {
    Done(T),
    /// Nothing was changed: the user would have more than the limit, with the usage that is given.
    Full(Usage),
    /// Nothing was changed: the user does not exist any more.
    NoUser,
    /// Nothing was changed: the user does not have a content that the run needs any more.
    NoInput,
}

/// A study that is new.
pub(crate) struct NewStudy<'a> {
    pub(crate) id: &'a str,
    pub(crate) owner: i64,
    /// Idempotency key and body of the request.
    pub(crate) key: Option<(&'a str, &'a str)>,
    pub(crate) title: &'a str,
    /// Keys, results and runs, as JSON.
    pub(crate) plan: &'a str,
    pub(crate) project: Option<&'a str>,
}

/// Owner or project of the runs or studies of a list.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ListScope<'a> {
    Owner(i64),
    Project(&'a str),
}

impl ListScope<'_> {
    /// The column and its value.
    pub(crate) fn column(&self) -> (&'static str, &dyn rusqlite::ToSql) {
        match self {
            Self::Owner(owner) => ("owner", owner),
            Self::Project(project) => ("project", project),
        }
    }
}

impl Db {
    /// All runs that the server has something to do about, those first that wait longest.
    pub(crate) fn live(&self) -> Result<Vec<LiveRun>> {
        let connection = self.lock();
        let mut query = connection.prepare_cached(
            // Not the specs, of which a long queue has many.
            "SELECT id, owner, threads, ranks, memory, state, wish, epoch, revision, submitted, step, barren, not_before FROM runs
             WHERE state IN ('queued', 'running', 'stopping') ORDER BY number",
        )?;
        let rows = query.query_map([], |row| {
            Ok(LiveRun {
                id: row.get("id")?,
                owner: row.get("owner")?,
                run: run_of(row)?,
                threads: row.get("threads")?,
                ranks: row.get("ranks")?,
                memory: row.get::<_, i64>("memory")? as u64,
            })
        })?;
        rows.collect()
    }

    /// Adds runs, and the study that they are of, all or none.
    pub(crate) fn insert(
        &self,
        runs: &[NewRun],
        study: Option<&NewStudy>,
    ) -> Result<Reserved<Vec<EventRow>>> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        if let Some(run) = runs.first()
            && !has_user(&transaction, run.owner)?
        {
            return Ok(Reserved::NoUser);
        }
        if let Some(study) = study {
            let (key, body) = study.key.unzip();
            transaction.execute(
                "INSERT INTO studies VALUES (?1, (SELECT coalesce(max(number), 0) + 1 FROM studies), ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
                params![study.id, study.owner, key, body, study.title, now(), study.plan, study.project],
            )?;
        }
        let mut events = Vec::new();
        for run in runs {
            let number: i64 = transaction.query_row(
                "SELECT coalesce(max(number), 0) + 1 FROM runs",
                [],
                |row| row.get(0),
            )?;
            let first = Run::new();
            transaction.execute(
                "INSERT INTO runs VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13,?14,?15,?16,?17,?18,?19,?19,?20,0,0,NULL,'',?21,NULL,0,?22,NULL,NULL,?23,?24,0,NULL,?25)",
                params![
                    run.id,
                    number,
                    run.owner,
                    run.key.map(|key| key.0),
                    run.key.map(|key| key.1),
                    run.title,
                    run.label,
                    run.spec,
                    run.threads,
                    run.memory as i64,
                    first.state.word(),
                    wish_word(first.wish),
                    first.epoch as i64,
                    first.revision,
                    first.submitted,
                    first.step as i64,
                    first.barren,
                    first.not_before,
                    now(),
                    run.of_steps.map(|steps| steps as i64),
                    run.study,
                    run.project,
                    run.reserved as i64,
                    run.time_limit,
                    run.ranks,
                ],
            )?;
            transaction.execute(&format!("{NAME_INPUTS} WHERE r.id = ?1"), [run.id])?;
            // One that has gone with another run, since this one was checked.
            let gone = "SELECT EXISTS (SELECT 1 FROM run_inputs n WHERE run = ?1
                          AND NOT EXISTS (SELECT 1 FROM inputs i WHERE i.sha256 = n.sha256 AND i.owner IN (n.owner, ?2)))";
            if transaction.query_row(gone, params![run.id, ALL], |row| row.get(0))? {
                return Ok(Reserved::NoInput);
            }
            events.push(add_event(
                &transaction,
                run.id,
                "state",
                json!({"state": first.state, "title": run.title}),
            )?);
        }
        if let Some(first) = runs.first()
            && let Some(usage) = self.beyond(&transaction, first.owner)?
        {
            return Ok(Reserved::Full(usage));
        }
        transaction.commit()?;
        Ok(Reserved::Done(events))
    }

    /// Id and request of the run or study that was submitted with an idempotency key. `table`: `runs` or `studies`.
    pub(crate) fn by_key(
        &self,
        table: &str,
        owner: i64,
        key: &str,
    ) -> Result<Option<(String, String)>> {
        self.lock()
            .query_row(
                &format!("SELECT id, body FROM {table} WHERE owner = ?1 AND key = ?2"),
                params![owner, key],
                |row| Ok((row.get(0)?, row.get(1)?)),
            )
            .optional()
    }

    /// One run with owner and spec.
    pub(crate) fn run(&self, id: &str) -> Result<Option<(i64, Run, RunRow, String)>> {
        self.lock()
            .query_row("SELECT *, (SELECT name FROM users u WHERE u.id = owner) AS owner_name FROM runs WHERE id = ?1", [id], |row| {
                Ok((
                    row.get("owner")?,
                    run_of(row)?,
                    row_of(row)?,
                    row.get("spec")?,
                ))
            })
            .optional()
    }

    /// A page of runs, newest first. `after`: the last row of the page before.
    pub(crate) fn list(
        &self,
        scope: ListScope,
        state: Option<&str>,
        label: Option<&str>,
        text: Option<&str>,
        after: Option<&str>,
    ) -> Result<Vec<RunRow>> {
        let connection = self.reader();
        let (column, value) = scope.column();
        // The rows are chosen by an index alone: with their specs they are large.
        let mut query = connection.prepare_cached(&format!(
            "SELECT *, (SELECT name FROM users u WHERE u.id = owner) AS owner_name FROM runs WHERE number IN (SELECT number FROM runs WHERE {column} = ?1 AND (?2 IS NULL OR state = ?2)
               AND (?3 IS NULL OR label = ?3) AND (?4 IS NULL OR instr(lower(title), lower(?4)) > 0 OR instr(lower(label), lower(?4)) > 0)
               AND (?5 IS NULL OR number < (SELECT number FROM runs WHERE id = ?5)) ORDER BY number DESC LIMIT ?6)
             ORDER BY number DESC",
        ))?;
        let rows = query.query_map(
            params![value, state, label, text, after, MOST_ROWS as i64 + 1],
            row_of,
        )?;
        rows.collect()
    }

    /// How many runs of a user or a project are in each state.
    pub(crate) fn states(&self, scope: ListScope) -> Result<BTreeMap<String, u64>> {
        let connection = self.reader();
        let (column, value) = scope.column();
        let mut query = connection.prepare_cached(&format!(
            "SELECT state, count(*) FROM runs WHERE {column} = ?1 GROUP BY state"
        ))?;
        let rows = query.query_map([value], |row| {
            Ok((row.get(0)?, row.get::<_, i64>(1)? as u64))
        })?;
        rows.collect()
    }

    pub(crate) fn attempts(&self, id: &str) -> Result<Vec<Attempt>> {
        let connection = self.lock();
        let mut query =
            connection.prepare_cached("SELECT * FROM attempts WHERE run = ?1 ORDER BY epoch")?;
        let rows = query.query_map([id], attempt_of)?;
        rows.collect()
    }

    /// Gives a run another title, label or project; an empty project is none.
    pub(crate) fn patch(
        &self,
        id: &str,
        title: Option<&str>,
        label: Option<&str>,
        project: Option<&str>,
    ) -> Result<()> {
        self.lock().execute(
            "UPDATE runs SET title = coalesce(?2, title), label = coalesce(?3, label), changed = ?4,
               project = nullif(coalesce(?5, project), '') WHERE id = ?1",
            params![id, title, label, now(), project],
        )?;
        Ok(())
    }

    /// Ids and states of all runs of a user.
    pub(crate) fn runs_of(&self, owner: i64) -> Result<Vec<(String, RunState)>> {
        let connection = self.lock();
        let mut query = connection.prepare("SELECT id, state FROM runs WHERE owner = ?1")?;
        let rows = query.query_map([owner], |row| Ok((row.get("id")?, state_of(row)?)))?;
        rows.collect()
    }
}
