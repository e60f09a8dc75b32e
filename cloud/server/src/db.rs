//! Database of the server: runs, attempts, events, users. SQLite, one writer.
//!
//! Every change of a run's state is one transaction that writes the row and an event, through [`Db::apply`].

mod contents;
mod quota;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::sync::{Mutex, MutexGuard};
use std::time::{SystemTime, UNIX_EPOCH};

use cloud_api::answers::{Attempt, EventRow, RunRow, Usage};
use cloud_api::head::Cause;
use cloud_api::lifecycle::{self, Illegal, Policy, Run, RunEvent};
use cloud_api::{Head, RunState, Wish};
use cloud_engine::Engine;
use rusqlite::{Connection, OptionalExtension, Row, Transaction, params};
use serde_json::{Value, json};

use crate::prices::{Cost, Prices};
use crate::secrets::Caller;

use contents::forget_input;
pub(crate) use contents::{Forgotten, forget_inputs};

const SCHEMA: &str = "
CREATE TABLE IF NOT EXISTS users(id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, hash TEXT, admin INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS secrets(id INTEGER PRIMARY KEY, hash TEXT NOT NULL UNIQUE, kind TEXT NOT NULL, user INTEGER NOT NULL,
  name TEXT NOT NULL, run TEXT, expires REAL NOT NULL, read_only INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS runs(id TEXT PRIMARY KEY, number INTEGER NOT NULL UNIQUE, owner INTEGER NOT NULL, key TEXT, body TEXT,
  title TEXT NOT NULL, label TEXT NOT NULL, spec TEXT NOT NULL, threads INTEGER NOT NULL, memory INTEGER NOT NULL,
  state TEXT NOT NULL, wish TEXT NOT NULL, epoch INTEGER NOT NULL, revision INTEGER NOT NULL, submitted INTEGER NOT NULL,
  step INTEGER NOT NULL, barren INTEGER NOT NULL, not_before REAL NOT NULL, created REAL NOT NULL, changed REAL NOT NULL,
  of_steps INTEGER, time REAL NOT NULL, core_seconds REAL NOT NULL, cause TEXT, message TEXT NOT NULL, UNIQUE(owner, key));
CREATE INDEX IF NOT EXISTS runs_state ON runs(state);
DROP INDEX IF EXISTS runs_owner;
DROP INDEX IF EXISTS runs_label;
CREATE INDEX IF NOT EXISTS runs_list ON runs(owner, number, state, label, title);
CREATE INDEX IF NOT EXISTS runs_count ON runs(owner, state);
CREATE TABLE IF NOT EXISTS studies(id TEXT PRIMARY KEY, number INTEGER NOT NULL UNIQUE, owner INTEGER NOT NULL, key TEXT, body TEXT,
  title TEXT NOT NULL, created REAL NOT NULL, plan TEXT NOT NULL, UNIQUE(owner, key));
CREATE INDEX IF NOT EXISTS studies_owner ON studies(owner, number);
CREATE TABLE IF NOT EXISTS attempts(run TEXT NOT NULL, epoch INTEGER NOT NULL, engine TEXT NOT NULL, started REAL NOT NULL, ended REAL,
  cause TEXT, code INTEGER, message TEXT NOT NULL, machine TEXT NOT NULL, step INTEGER, core_seconds REAL NOT NULL,
  PRIMARY KEY(run, epoch));
CREATE TABLE IF NOT EXISTS events(id INTEGER PRIMARY KEY AUTOINCREMENT, run TEXT NOT NULL, time REAL NOT NULL, kind TEXT NOT NULL,
  data TEXT NOT NULL);
CREATE INDEX IF NOT EXISTS events_run ON events(run, id);
CREATE TABLE IF NOT EXISTS projects(id TEXT PRIMARY KEY, name TEXT NOT NULL, created REAL NOT NULL);
CREATE TABLE IF NOT EXISTS members(project TEXT NOT NULL, user INTEGER NOT NULL, role TEXT NOT NULL, PRIMARY KEY(project, user));
CREATE INDEX IF NOT EXISTS members_user ON members(user);
CREATE TABLE IF NOT EXISTS audit(id INTEGER PRIMARY KEY AUTOINCREMENT, time REAL NOT NULL, user TEXT NOT NULL, address TEXT NOT NULL,
  method TEXT NOT NULL, path TEXT NOT NULL, status INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS counters(name TEXT PRIMARY KEY, last INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS inputs(sha256 TEXT NOT NULL, owner INTEGER NOT NULL, bytes INTEGER NOT NULL, PRIMARY KEY(sha256, owner));
CREATE TABLE IF NOT EXISTS run_inputs(run TEXT NOT NULL, sha256 TEXT NOT NULL, owner INTEGER NOT NULL, PRIMARY KEY(run, sha256));
CREATE INDEX IF NOT EXISTS run_inputs_content ON run_inputs(sha256, owner);
";

/// Columns that databases of earlier versions do not have.
const LATER: &[(&str, &str, &str)] = &[
    ("runs", "study", "TEXT"),
    ("runs", "results", "TEXT"),
    ("runs", "bytes", "INTEGER NOT NULL DEFAULT 0"),
    ("users", "cores", "INTEGER"),
    ("users", "disk", "INTEGER"),
    ("runs", "project", "TEXT"),
    ("studies", "project", "TEXT"),
    ("attempts", "queue", "TEXT NOT NULL DEFAULT ''"),
    ("attempts", "cost", "REAL"),
    ("attempts", "saved", "REAL"),
    ("runs", "cost", "REAL"),
    ("runs", "saved", "REAL"),
    ("secrets", "parent", "INTEGER"),
    ("secrets", "created", "REAL NOT NULL DEFAULT 0"),
    ("runs", "reserved", "INTEGER NOT NULL DEFAULT 0"),
];

/// Records the contents that the specs of runs name.
const NAME_INPUTS: &str =
    "INSERT OR IGNORE INTO run_inputs SELECT r.id, json_extract(f.value, '$.sha256'), r.owner
  FROM runs r, json_each(r.spec, '$.files') f";

/// Owner of what belongs to all: the files of templates.
pub(crate) const ALL: i64 = 0;

/// The most rows of a list.
pub(crate) const MOST_ROWS: usize = 200;

/// Result of a query.
pub(crate) type Result<T> = rusqlite::Result<T>;

/// The database.
pub(crate) struct Db {
    connection: Mutex<Connection>,
    /// For lists: it does not wait while a change is brought to the disk.
    reader: Mutex<Connection>,
    /// Bytes of uploads that are on their way, by user. Locked only while the connection is.
    uploads: Mutex<HashMap<i64, u64>>,
    policy: Policy,
    prices: Option<Prices>,
}

/// A run as the reconciler needs it.
#[derive(Clone, Debug)]
pub(crate) struct LiveRun {
    pub(crate) id: String,
    pub(crate) owner: i64,
    pub(crate) run: Run,
    pub(crate) threads: u32,
    pub(crate) memory: u64,
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
    pub(crate) memory: u64,
    pub(crate) of_steps: Option<u64>,
    pub(crate) study: Option<&'a str>,
    pub(crate) project: Option<&'a str>,
    /// Bytes that its user has less from now on: those that it is expected to write.
    pub(crate) reserved: u64,
}

/// A further revision of a run, on the same data.
pub(crate) struct Extension<'a> {
    /// The revision that it follows.
    pub(crate) after: u32,
    pub(crate) spec: &'a str,
    pub(crate) of_steps: Option<u64>,
    /// As that of a new run.
    pub(crate) reserved: u64,
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

/// Result of [`Db::apply`] and [`Db::extend`].
pub(crate) enum Applied {
    Done(Run, Vec<EventRow>),
    Missing,
    Illegal(Illegal),
}

/// Unix time, in s.
pub(crate) fn now() -> f64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0.0, |time| time.as_secs_f64())
}

impl Db {
    pub(crate) fn open(path: &Path, policy: Policy, prices: Option<Prices>) -> Result<Self> {
        let connection = Connection::open(path)?;
        connection.pragma_update(None, "journal_mode", "WAL")?;
        connection.pragma_update(None, "synchronous", "FULL")?;
        let new = "SELECT NOT EXISTS (SELECT 1 FROM sqlite_master WHERE name = 'run_inputs')";
        let new: bool = connection.query_row(new, [], |row| row.get(0))?;
        connection.execute_batch(SCHEMA)?;
        for (table, column, kind) in LATER {
            let known = "SELECT count(*) FROM pragma_table_info(?1) WHERE name = ?2";
            let count = connection.query_row(known, [table, column], |row| row.get::<_, i64>(0))?;
            if count == 0 {
                connection
                    .execute_batch(&format!("ALTER TABLE {table} ADD COLUMN {column} {kind}"))?;
            }
        }
        connection.execute_batch(
            "CREATE INDEX IF NOT EXISTS runs_study ON runs(study, number);
             CREATE INDEX IF NOT EXISTS runs_project ON runs(project, number, state, label, title);
             CREATE INDEX IF NOT EXISTS studies_project ON studies(project, number);
             CREATE INDEX IF NOT EXISTS secrets_expires ON secrets(expires);
             CREATE INDEX IF NOT EXISTS secrets_parent ON secrets(parent);",
        )?;
        // Of earlier versions: it is not known which of them a token has begun, so they could outlive it.
        let earlier = "DELETE FROM secrets WHERE kind = 'session' AND created = 0";
        connection.execute(earlier, [])?;
        if new {
            connection.execute(NAME_INPUTS, [])?;
        }
        let reader = Connection::open(path)?;
        reader.pragma_update(None, "query_only", true)?;
        Ok(Self {
            connection: Mutex::new(connection),
            reader: Mutex::new(reader),
            uploads: Mutex::default(),
            policy,
            prices,
        })
    }

    pub(crate) fn prices(&self) -> Option<&Prices> {
        self.prices.as_ref()
    }

    pub(crate) fn policy(&self) -> &Policy {
        &self.policy
    }

    fn reader(&self) -> MutexGuard<'_, Connection> {
        self.reader
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, Connection> {
        self.connection
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// All runs that the server has something to do about, those first that wait longest.
    pub(crate) fn live(&self) -> Result<Vec<LiveRun>> {
        let connection = self.lock();
        let mut query = connection.prepare_cached(
            // Not the specs, of which a long queue has many.
            "SELECT id, owner, threads, memory, state, wish, epoch, revision, submitted, step, barren, not_before FROM runs
             WHERE state IN ('queued', 'running', 'stopping') ORDER BY number",
        )?;
        let rows = query.query_map([], |row| {
            Ok(LiveRun {
                id: row.get("id")?,
                owner: row.get("owner")?,
                run: run_of(row)?,
                threads: row.get("threads")?,
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
                "INSERT INTO runs VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13,?14,?15,?16,?17,?18,?19,?19,?20,0,0,NULL,'',?21,NULL,0,?22,NULL,NULL,?23)",
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

    /// Records what happened to a run: the row and an event, in one transaction.
    pub(crate) fn apply(
        &self,
        id: &str,
        event: &RunEvent,
        head: Option<&Head>,
        engine: &dyn Engine,
    ) -> Result<Applied> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let applied = self.apply_in(&transaction, id, event, head, engine)?;
        if matches!(applied, Applied::Done(..)) {
            transaction.commit()?;
        }
        Ok(applied)
    }

    /// Records [`RunEvent::Extend`] with a further spec, if the run has the revision that this one follows. `None`: it has another.
    pub(crate) fn extend(
        &self,
        id: &str,
        extension: &Extension,
        engine: &dyn Engine,
    ) -> Result<Reserved<Option<Applied>>> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let applied = self.apply_in(&transaction, id, &RunEvent::Extend, None, engine)?;
        let Applied::Done(after, _) = &applied else {
            return Ok(Reserved::Done(Some(applied)));
        };
        if after.revision != extension.after + 1 {
            return Ok(Reserved::Done(None));
        }
        transaction.execute(
            "UPDATE runs SET spec=?2, of_steps=?3, reserved=?4 WHERE id=?1",
            params![
                id,
                extension.spec,
                extension.of_steps.map(|steps| steps as i64),
                extension.reserved as i64
            ],
        )?;
        let owner =
            transaction.query_row("SELECT owner FROM runs WHERE id=?1", [id], |row| row.get(0))?;
        if let Some(usage) = self.beyond(&transaction, owner)? {
            return Ok(Reserved::Full(usage));
        }
        transaction.commit()?;
        Ok(Reserved::Done(Some(applied)))
    }

    fn apply_in(
        &self,
        transaction: &Transaction,
        id: &str,
        event: &RunEvent,
        head: Option<&Head>,
        engine: &dyn Engine,
    ) -> Result<Applied> {
        let Some(before) = transaction
            .query_row("SELECT * FROM runs WHERE id = ?1", [id], run_of)
            .optional()?
        else {
            return Ok(Applied::Missing);
        };
        let after = match lifecycle::apply(&before, event, &self.policy, now()) {
            Ok(after) => after,
            Err(illegal) => return Ok(Applied::Illegal(illegal)),
        };
        transaction.execute(
            "UPDATE runs SET state=?2, wish=?3, epoch=?4, revision=?5, submitted=?6, step=?7, barren=?8, not_before=?9, changed=?10
             WHERE id=?1",
            params![
                id,
                after.state.word(),
                wish_word(after.wish),
                after.epoch as i64,
                after.revision,
                after.submitted,
                after.step as i64,
                after.barren,
                after.not_before,
                now(),
            ],
        )?;
        let mut events = Vec::new();
        match event {
            RunEvent::Launched => {
                transaction.execute(
                    "INSERT INTO attempts VALUES (?1, ?2, ?3, ?4, NULL, NULL, NULL, '', '', NULL, 0, ?5, NULL, NULL)",
                    params![id, after.epoch as i64, engine.name(), now(), engine.queue(before.barren)],
                )?;
                events.push(add_event(
                    transaction,
                    id,
                    "attempt",
                    json!({"epoch": after.epoch, "began": true}),
                )?);
            }
            RunEvent::Ended(ending, step) => {
                let cause = serde_json::to_value(ending.cause).ok();
                let cause = cause.as_ref().and_then(Value::as_str);
                let machine = head.map_or("", |head| head.machine.as_str());
                let seconds = head
                    .filter(|head| head.epoch == before.epoch)
                    .map_or(0.0, |head| head.core_seconds);
                // By the price of today: a later one changes no cost of the past.
                let cost = (self.prices.as_ref()).map_or(Cost::default(), |prices| {
                    prices.cost(engine.queue(before.barren), seconds)
                });
                transaction.execute(
                    "UPDATE attempts SET ended=?3, cause=?4, code=?5, message=?6, machine=?7, step=?8, core_seconds=?9, cost=?10, saved=?11
                     WHERE run=?1 AND epoch=?2",
                    params![id, before.epoch as i64, now(), cause, ending.code, ending.message, machine, *step as i64, seconds, cost.spent, cost.saved],
                )?;
                transaction.execute(
                    "UPDATE runs SET cause=?2, message=?3,
                       core_seconds=(SELECT coalesce(sum(core_seconds), 0) FROM attempts WHERE run=?1),
                       cost=(SELECT sum(cost) FROM attempts WHERE run=?1), saved=(SELECT sum(saved) FROM attempts WHERE run=?1)
                     WHERE id=?1",
                    params![id, cause, ending.message],
                )?;
                let data = json!({"epoch": before.epoch, "cause": cause, "code": ending.code, "message": ending.message});
                events.push(add_event(transaction, id, "attempt", data)?);
            }
            RunEvent::Resume | RunEvent::Extend => {
                transaction.execute(
                    "UPDATE runs SET cause=NULL, message='', results=NULL WHERE id=?1",
                    [id],
                )?;
            }
            _ => {}
        }
        if let Some(head) = head {
            transaction.execute(
                "UPDATE runs SET of_steps=coalesce(?2, of_steps), time=?3, bytes=?4 WHERE id=?1",
                params![
                    id,
                    head.of_steps.map(|steps| steps as i64),
                    head.time,
                    head.bytes() as i64
                ],
            )?;
        }
        if after.state != before.state {
            events.push(add_event(
                transaction,
                id,
                "state",
                json!({"state": after.state}),
            )?);
        }
        Ok(Applied::Done(after, events))
    }

    /// The most cores that users may have at once, of those that have a limit.
    pub(crate) fn most_cores(&self) -> Result<BTreeMap<i64, u64>> {
        let connection = self.lock();
        let mut query =
            connection.prepare_cached("SELECT id, cores FROM users WHERE cores IS NOT NULL")?;
        let rows = query.query_map([], |row| Ok((row.get(0)?, row.get::<_, i64>(1)? as u64)))?;
        rows.collect()
    }

    /// Adds an event that is no change of state.
    pub(crate) fn event(&self, id: &str, kind: &str, data: Value) -> Result<EventRow> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let event = add_event(&transaction, id, kind, data)?;
        transaction.commit()?;
        Ok(event)
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
        let rows = query.query_map([id], |row| {
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
        })?;
        rows.collect()
    }

    /// Events of one run, or of all that a user may see, behind number `after`; at most [`MOST_ROWS`].
    pub(crate) fn events(
        &self,
        user: Option<i64>,
        run: Option<&str>,
        after: i64,
    ) -> Result<Vec<EventRow>> {
        let connection = self.lock();
        let mut query = connection.prepare_cached(
            "SELECT e.* FROM events e JOIN runs r ON r.id = e.run WHERE e.id > ?1 AND (?2 IS NULL OR e.run = ?2)
             AND (?3 IS NULL OR r.owner = ?3 OR r.project IN (SELECT project FROM members WHERE user = ?3)) ORDER BY e.id LIMIT ?4",
        )?;
        let rows = query.query_map(params![after, run, user, MOST_ROWS as i64], |row| {
            let data: String = row.get("data")?;
            Ok(EventRow {
                id: row.get("id")?,
                run: row.get("run")?,
                time: row.get("time")?,
                kind: row.get("kind")?,
                data: serde_json::from_str(&data).unwrap_or(Value::Null),
            })
        })?;
        rows.collect()
    }

    /// Whether a user or guest may see all of these runs, and the secret of the request is still good.
    pub(crate) fn may_see(&self, caller: &Caller, runs: &BTreeSet<String>) -> Result<bool> {
        let (user, run) = match caller {
            Caller::User(user) => (Some(user.id), None),
            Caller::Guest(guest) => (None, Some(&guest.run)),
        };
        let ids = serde_json::to_string(runs).unwrap_or_default();
        let connection = self.reader();
        let mut query = connection.prepare_cached(
            "SELECT (?1 IS NULL OR EXISTS (SELECT 1 FROM secrets WHERE id = ?1 AND expires > ?2))
               AND (SELECT count(*) FROM json_each(?3) w JOIN runs r ON r.id = w.value
                    WHERE r.id = ?4 OR r.owner = ?5 OR r.project IN (SELECT project FROM members WHERE user = ?5)) = ?6",
        )?;
        query.query_row(
            params![caller.secret(), now(), ids, run, user, runs.len() as i64],
            |row| row.get(0),
        )
    }

    /// The users who may see a run: its owner and the members of its project.
    pub(crate) fn audience(&self, run: &str) -> Result<Vec<i64>> {
        let connection = self.lock();
        let mut query = connection.prepare_cached(
            "SELECT owner FROM runs WHERE id = ?1
             UNION SELECT m.user FROM members m JOIN runs r ON r.project = m.project WHERE r.id = ?1",
        )?;
        let rows = query.query_map([run], |row| row.get(0))?;
        rows.collect()
    }

    /// Number of the newest event.
    pub(crate) fn newest_event(&self) -> Result<i64> {
        self.lock()
            .query_row("SELECT coalesce(max(id), 0) FROM events", [], |row| {
                row.get(0)
            })
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

    /// Forgets a run that is not live with all that belongs to it, also the inputs of its owner that no other run of the owner names.
    pub(crate) fn delete(&self, id: &str) -> Result<Deleted> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let run = "SELECT owner, state FROM runs WHERE id = ?1";
        let run: Option<(i64, RunState)> = transaction
            .query_row(run, [id], |row| Ok((row.get(0)?, state_of(row)?)))
            .optional()?;
        let owner = match run {
            None => return Ok(Deleted::Missing),
            // Also one that was resumed since the user looked at it.
            Some((_, state)) if state.is_live() => return Ok(Deleted::Live),
            Some((owner, _)) => owner,
        };
        let named = {
            let mut query = transaction.prepare("SELECT sha256 FROM run_inputs WHERE run = ?1")?;
            let rows = query.query_map([id], |row| row.get(0))?;
            rows.collect::<Result<Vec<String>>>()?
        };
        for (table, column) in [
            ("runs", "id"),
            ("attempts", "run"),
            ("events", "run"),
            ("secrets", "run"),
            ("run_inputs", "run"),
        ] {
            let remove = format!("DELETE FROM {table} WHERE {column} = ?1");
            transaction.execute(&remove, [id])?;
        }
        let mut forgotten = Vec::new();
        for sha256 in named {
            if forget_input(&transaction, &sha256, owner)? == Forgotten::Done {
                forgotten.push(sha256);
            }
        }
        transaction.commit()?;
        Ok(Deleted::Done(forgotten))
    }
}

/// Result of [`Db::delete`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Deleted {
    /// With the inputs that the owner does not have any more.
    Done(Vec<String>),
    Missing,
    /// Nothing was changed: the run is queued, or has an attempt.
    Live,
}

fn has_user(connection: &Connection, user: i64) -> Result<bool> {
    let known = "SELECT EXISTS (SELECT 1 FROM users WHERE id = ?1)";
    connection.query_row(known, [user], |row| row.get(0))
}

/// A number that no row of a table has or had. `table`: `users` or `secrets`.
pub(crate) fn next_id(transaction: &Transaction, table: &str) -> Result<i64> {
    let most = format!("(SELECT coalesce(max(id), 0) FROM {table})");
    transaction.query_row(
        &format!(
            "INSERT INTO counters VALUES (?1, {most} + 1)
             ON CONFLICT(name) DO UPDATE SET last = max(last, {most}) + 1 RETURNING last"
        ),
        [table],
        |row| row.get(0),
    )
}

fn add_event(transaction: &Transaction, run: &str, kind: &str, data: Value) -> Result<EventRow> {
    let time = now();
    transaction.execute(
        "INSERT INTO events(run, time, kind, data) VALUES (?1, ?2, ?3, ?4)",
        params![run, time, kind, data.to_string()],
    )?;
    Ok(EventRow {
        id: transaction.last_insert_rowid(),
        run: run.to_owned(),
        time,
        kind: kind.to_owned(),
        data,
    })
}

fn wish_word(wish: Wish) -> &'static str {
    match wish {
        Wish::Run => "run",
        Wish::Stop => "stop",
        Wish::Kill => "kill",
    }
}

pub(crate) fn unknown(column: &str, word: String) -> rusqlite::Error {
    rusqlite::Error::InvalidColumnType(0, format!("{column} {word:?}"), rusqlite::types::Type::Text)
}

fn state_of(row: &Row) -> Result<RunState> {
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

fn run_of(row: &Row) -> Result<Run> {
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

fn row_of(row: &Row) -> Result<RunRow> {
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
        core_seconds: row.get("core_seconds")?,
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
