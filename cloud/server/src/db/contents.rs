//! Contents of inputs: their users, and the runs that name them.

use cloud_api::answers::InputRow;
use rusqlite::{Connection, OptionalExtension, Transaction, params};

use super::{ALL, Db, MOST_ROWS, Reserved, Result, has_user};

/// The inputs of a user, with the number of runs that name each.
pub(super) const INPUTS: &str = "SELECT sha256, bytes, (SELECT count(*) FROM run_inputs n WHERE n.sha256 = i.sha256 AND n.owner = ?1) FROM inputs i
  WHERE owner = ?1 ORDER BY bytes DESC, sha256 LIMIT ?2";

impl Db {
    /// Inputs of a user, the largest first: SHA-256, length, and how many runs of the user name it.
    pub(crate) fn inputs(&self, owner: i64) -> Result<Vec<InputRow>> {
        let connection = self.reader();
        let mut query = connection.prepare_cached(INPUTS)?;
        let rows = query.query_map(params![owner, MOST_ROWS as i64], |row| {
            Ok(InputRow {
                sha256: row.get(0)?,
                bytes: row.get::<_, i64>(1)? as u64,
                runs: row.get::<_, i64>(2)? as u64,
            })
        })?;
        rows.collect()
    }

    /// Forgets an input of a user, unless a run of the user names it.
    pub(crate) fn remove_input(&self, sha256: &str, owner: i64) -> Result<Forgotten> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let forgotten = forget_input(&transaction, sha256, owner)?;
        transaction.commit()?;
        Ok(forgotten)
    }

    /// Whether a user, a template or a run has this content.
    pub(crate) fn is_needed(&self, sha256: &str) -> Result<bool> {
        let needed = "SELECT EXISTS (SELECT 1 FROM inputs WHERE sha256 = ?1) OR EXISTS (SELECT 1 FROM run_inputs WHERE sha256 = ?1)";
        self.lock().query_row(needed, [sha256], |row| row.get(0))
    }

    /// Gives a user (or all, [`ALL`]) a content, within the limit of the user.
    pub(crate) fn add_input(&self, sha256: &str, owner: i64, bytes: u64) -> Result<Reserved<()>> {
        self.add_input_in(&mut self.lock(), sha256, owner, bytes)
    }

    pub(super) fn add_input_in(
        &self,
        connection: &mut Connection,
        sha256: &str,
        owner: i64,
        bytes: u64,
    ) -> Result<Reserved<()>> {
        let transaction = connection.transaction()?;
        if owner != ALL && !has_user(&transaction, owner)? {
            return Ok(Reserved::NoUser);
        }
        let added = transaction.execute(
            "INSERT OR IGNORE INTO inputs VALUES (?1, ?2, ?3)",
            params![sha256, owner, bytes as i64],
        )?;
        if added > 0
            && let Some(usage) = self.beyond(&transaction, owner)?
        {
            return Ok(Reserved::Full(usage));
        }
        transaction.commit()?;
        Ok(Reserved::Done(()))
    }

    /// Length of a content that this user (or a template) has sent.
    pub(crate) fn input(&self, sha256: &str, owner: i64) -> Result<Option<u64>> {
        self.lock()
            .query_row(
                "SELECT bytes FROM inputs WHERE sha256 = ?1 AND owner IN (?2, ?3)",
                params![sha256, owner, ALL],
                |row| row.get::<_, i64>(0),
            )
            .optional()
            .map(|bytes| bytes.map(|bytes| bytes as u64))
    }
}

/// Result of forgetting an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Forgotten {
    /// The user has no such input.
    Missing,
    /// A run of the user names it.
    Named,
    Done,
}

pub(super) fn forget_input(
    transaction: &Transaction,
    sha256: &str,
    owner: i64,
) -> Result<Forgotten> {
    let named = "SELECT EXISTS (SELECT 1 FROM run_inputs WHERE sha256 = ?1 AND owner = ?2)";
    if transaction.query_row(named, params![sha256, owner], |row| row.get(0))? {
        return Ok(Forgotten::Named);
    }
    let remove = "DELETE FROM inputs WHERE sha256 = ?1 AND owner = ?2";
    Ok(match transaction.execute(remove, params![sha256, owner])? {
        0 => Forgotten::Missing,
        _ => Forgotten::Done,
    })
}

/// Forgets all inputs of a user without runs, and returns them.
pub(crate) fn forget_inputs(transaction: &Transaction, owner: i64) -> Result<Vec<String>> {
    let mut query = transaction.prepare("DELETE FROM inputs WHERE owner = ?1 RETURNING sha256")?;
    let rows = query.query_map([owner], |row| row.get(0))?;
    rows.collect()
}
