//! Limits of users: what they have, and what is reserved.

use std::collections::HashMap;
use std::sync::MutexGuard;

use cloud_api::answers::Usage;
use rusqlite::{Connection, OptionalExtension, params};

use super::{Db, Reserved, Result, has_user};

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
            "SELECT (SELECT coalesce(sum(threads), 0) FROM runs WHERE owner = ?1 AND state IN ('running', 'stopping')),
               (SELECT coalesce(sum(CASE WHEN state IN ('queued', 'running', 'stopping') THEN max(bytes, reserved) ELSE bytes END), 0)
                FROM runs WHERE owner = ?1) + (SELECT coalesce(sum(bytes), 0) FROM inputs WHERE owner = ?1),
               (SELECT coalesce(sum(core_seconds), 0) FROM runs WHERE owner = ?1), cores, disk,
               (SELECT sum(cost) FROM runs WHERE owner = ?1) FROM users WHERE id = ?1",
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

    /// Records the length of the files of a run while it runs.
    pub(crate) fn set_bytes(&self, id: &str, bytes: u64) -> Result<()> {
        let set = "UPDATE runs SET bytes=?2 WHERE id=?1";
        self.lock().execute(set, params![id, bytes as i64])?;
        Ok(())
    }
}
