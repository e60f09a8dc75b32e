//! Limits of users: what they have, and what is reserved.

use std::collections::{BTreeMap, HashMap};
use std::sync::MutexGuard;

use cloud_api::Head;
use cloud_api::answers::Usage;
use rusqlite::{Connection, OptionalExtension, params};

use super::{Db, Reserved, Result, has_user};

fn hours(seconds: f64) -> f64 {
    seconds / 3600.0
}

impl Db {
    /// Usage of a user, and its limits.
    pub(crate) fn usage(&self, user: i64) -> Result<Usage> {
        self.usage_in(&self.lock(), user)
    }

    /// The usage of a user that is beyond the limit.
    pub(super) fn beyond(&self, connection: &Connection, user: i64) -> Result<Option<Usage>> {
        let usage = self.usage_in(connection, user)?;
        let beyond = usage.most_disk.is_some_and(|most| usage.disk > most);
        Ok(beyond.then_some(usage))
    }

    fn usage_in(&self, connection: &Connection, user: i64) -> Result<Usage> {
        let mut query = connection.prepare_cached(
            "SELECT (SELECT coalesce(sum(threads * ranks), 0) FROM runs WHERE owner = ?1 AND state IN ('running', 'stopping')),
               (SELECT coalesce(sum(CASE WHEN state IN ('queued', 'running', 'stopping') THEN max(bytes, reserved) ELSE bytes END), 0)
                FROM runs WHERE owner = ?1) + (SELECT coalesce(sum(bytes), 0) FROM inputs WHERE owner = ?1),
               (SELECT coalesce(sum(a.core_seconds), 0) FROM attempts a JOIN runs r ON r.id = a.run WHERE r.owner = ?1) + removed_core_seconds,
               cores, disk, (SELECT sum(cost) FROM runs WHERE owner = ?1), core_seconds FROM users WHERE id = ?1",
        )?;
        let whole = |number: Option<i64>| number.map(|number| number as u64);
        let usage = query.query_row([user], |row| {
            Ok(Usage {
                cores: row.get::<_, i64>(0)? as u64,
                disk: row.get::<_, i64>(1)? as u64,
                core_seconds: row.get(2)?,
                most_cores: whole(row.get(3)?),
                most_disk: whole(row.get(4)?),
                cost: row.get(5)?,
                most_core_seconds: row.get(6)?,
            })
        });
        let mut usage = usage.optional()?.unwrap_or_default();
        usage.disk += self.uploads().get(&user).copied().unwrap_or(0);
        Ok(usage)
    }

    fn uploads(&self) -> MutexGuard<'_, HashMap<i64, u64>> {
        self.uploads
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Reserves bytes for an upload that is on its way.
    pub(crate) fn reserve_upload(&self, user: i64, bytes: u64) -> Result<Reserved<()>> {
        let connection = self.lock();
        if !has_user(&connection, user)? {
            return Ok(Reserved::NoUser);
        }
        *self.uploads().entry(user).or_default() += bytes;
        let beyond = self.beyond(&connection, user);
        if !matches!(beyond, Ok(None)) {
            self.release_upload(user, bytes);
        }
        Ok(beyond?.map_or(Reserved::Done(()), Reserved::Full))
    }

    fn release_upload(&self, user: i64, bytes: u64) {
        let mut uploads = self.uploads();
        let left = uploads.remove(&user).unwrap_or(0).saturating_sub(bytes);
        if left > 0 {
            uploads.insert(user, left);
        }
    }

    /// Ends an upload for which bytes were reserved, and gives the user the content that came, if it came whole.
    pub(crate) fn end_upload(
        &self,
        user: i64,
        reserved: u64,
        input: Option<(&str, u64)>,
    ) -> Result<Reserved<()>> {
        let mut connection = self.lock();
        self.release_upload(user, reserved);
        match input {
            Some((sha256, bytes)) => self.add_input_in(&mut connection, sha256, user, bytes),
            None => Ok(Reserved::Done(())),
        }
    }

    /// Users whose runs and inputs take more than they may. What is reserved does not count.
    pub(crate) fn over_limit(&self) -> Result<Vec<i64>> {
        let connection = self.lock();
        let mut query = connection.prepare_cached(
            "SELECT id FROM users WHERE disk IS NOT NULL AND disk < (SELECT coalesce(sum(bytes), 0) FROM runs WHERE owner = users.id)
               + (SELECT coalesce(sum(bytes), 0) FROM inputs WHERE owner = users.id)",
        )?;
        let rows = query.query_map([], |row| row.get(0))?;
        rows.collect()
    }

    /// Runs on their way that have used up a limit, each with a sentence that says which: the time of a run since it was submitted, resumed
    /// or extended, or the core seconds of all runs of its user.
    pub(crate) fn out_of_time(&self) -> Result<Vec<(String, String)>> {
        let connection = self.lock();
        let mut query = connection.prepare_cached(
            "WITH over AS (SELECT id, core_seconds FROM users WHERE core_seconds IS NOT NULL AND core_seconds <= removed_core_seconds
               + (SELECT coalesce(sum(a.core_seconds), 0) FROM attempts a JOIN runs o ON o.id = a.run WHERE o.owner = users.id))
             SELECT r.id, r.time_limit, over.core_seconds FROM runs r LEFT JOIN over ON over.id = r.owner
             WHERE r.state IN ('queued', 'running') AND r.wish = 'run' AND (over.id IS NOT NULL OR (r.time_limit IS NOT NULL
               AND r.time_limit * r.threads * r.ranks <= (SELECT coalesce(sum(core_seconds), 0) FROM attempts WHERE run = r.id) - r.core_seconds_before)) ORDER BY r.number",
        )?;
        let rows = query.query_map([], |row| {
            let why = match (row.get(2)?, row.get::<_, Option<f64>>(1)?) {
                (Some(most), _) => format!("stopped: the {:.4} core hours of its user are spent. An administrator can grant more; then resume it", hours(most)),
                (None, limit) => format!("stopped: it has run for its limit of {:.4} h. Resume it to let it run as long again", hours(limit.unwrap_or_default())),
            };
            Ok((row.get(0)?, why))
        })?;
        rows.collect()
    }

    /// Bytes that a run may have by the limit of its owner: what others have not, and have not reserved.
    pub(crate) fn left_for(&self, id: &str) -> Result<Option<u64>> {
        let connection = self.lock();
        let own = "SELECT owner, max(bytes, reserved) FROM runs WHERE id = ?1";
        let (owner, own) = connection.query_row(own, [id], |row| {
            Ok((row.get(0)?, row.get::<_, i64>(1)? as u64))
        })?;
        let usage = self.usage_in(&connection, owner)?;
        let others = usage.disk.saturating_sub(own);
        Ok(usage.most_disk.map(|most| most.saturating_sub(others)))
    }

    /// Records the length of the files of a run, and the core seconds of its attempt, while it runs.
    pub(crate) fn set_progress(&self, id: &str, epoch: u64, head: &Head) -> Result<()> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let set = "UPDATE runs SET bytes=?2 WHERE id=?1";
        transaction.execute(set, params![id, head.bytes() as i64])?;
        let set = "UPDATE attempts SET core_seconds=?3 WHERE run=?1 AND epoch=?2 AND ended IS NULL";
        transaction.execute(set, params![id, epoch as i64, head.core_seconds])?;
        transaction.commit()
    }

    /// The most cores that users may have at once, of those that have a limit.
    pub(crate) fn most_cores(&self) -> Result<BTreeMap<i64, u64>> {
        let connection = self.lock();
        let mut query =
            connection.prepare_cached("SELECT id, cores FROM users WHERE cores IS NOT NULL")?;
        let rows = query.query_map([], |row| Ok((row.get(0)?, row.get::<_, i64>(1)? as u64)))?;
        rows.collect()
    }
}
