//! Database of the server: runs, attempts, events, users. SQLite, one writer.
//!
//! Every change of a run's state is one transaction that writes the row and an event, through [`Db::apply`].

mod changes;
mod contents;
mod events;
mod hooks;
mod quota;
mod rows;
mod runs;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Mutex, MutexGuard};
use std::time::{SystemTime, UNIX_EPOCH};

use cloud_api::lifecycle::Policy;
use rusqlite::{Connection, Transaction};

use crate::prices::Prices;

pub(crate) use changes::{Applied, Deleted, Extension};
pub(crate) use contents::{Forgotten, forget_inputs};
pub(crate) use hooks::{Due, Tried};
pub(crate) use rows::unknown;
pub(crate) use runs::{ListScope, LiveRun, NewRun, NewStudy, Reserved};

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
CREATE TABLE IF NOT EXISTS hooks(user INTEGER PRIMARY KEY, url TEXT NOT NULL, secret TEXT NOT NULL, began REAL NOT NULL DEFAULT 0);
CREATE TABLE IF NOT EXISTS deliveries(id INTEGER PRIMARY KEY AUTOINCREMENT, user INTEGER NOT NULL, run TEXT, state TEXT NOT NULL,
  body TEXT NOT NULL, created REAL NOT NULL, tries INTEGER NOT NULL, next REAL, status INTEGER, message TEXT NOT NULL);
CREATE INDEX IF NOT EXISTS deliveries_user ON deliveries(user, next);
CREATE INDEX IF NOT EXISTS deliveries_next ON deliveries(next) WHERE next IS NOT NULL;
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
    ("users", "core_seconds", "REAL"),
    ("users", "removed_core_seconds", "REAL NOT NULL DEFAULT 0"),
    ("runs", "time_limit", "REAL"),
    ("runs", "core_seconds_before", "REAL NOT NULL DEFAULT 0"),
    ("runs", "stopped_by", "TEXT"),
    ("runs", "ranks", "INTEGER NOT NULL DEFAULT 1"),
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
