//! Events of runs, and their audience.

use std::collections::BTreeSet;

use cloud_api::answers::EventRow;
use rusqlite::{Transaction, params};
use serde_json::Value;

use crate::secrets::Caller;

use super::{Db, MOST_ROWS, Result, now};

impl Db {
    /// Adds an event that is no change of state.
    pub(crate) fn event(&self, id: &str, kind: &str, data: Value) -> Result<EventRow> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let event = add_event(&transaction, id, kind, data)?;
        transaction.commit()?;
        Ok(event)
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
}

pub(super) fn add_event(
    transaction: &Transaction,
    run: &str,
    kind: &str,
    data: Value,
) -> Result<EventRow> {
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
