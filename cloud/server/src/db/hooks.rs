//! Web hooks of users, and their deliveries: those that wait, and a log of the last ones.

use cloud_api::answers::DeliveryRow;
use rusqlite::{OptionalExtension, Row, Transaction, params};
use serde_json::json;

use super::{Db, Result, now};

/// The most deliveries of a user that wait. Further ones are logged as not sent.
const MOST_WAITING: i64 = 10_000;

/// How many deliveries of a user that are over are kept.
const KEPT: i64 = 100;

/// A delivery whose time has come.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Due {
    pub(crate) id: i64,
    pub(crate) user: i64,
    pub(crate) url: String,
    pub(crate) secret: String,
    /// JSON.
    pub(crate) body: String,
    /// How often it was tried before.
    pub(crate) tries: u32,
}

/// Outcome of a try.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tried {
    /// Status of the answer, where there was one.
    pub(crate) status: Option<u16>,
    /// Reason for which it is not delivered; empty: it is.
    pub(crate) message: String,
    /// Seconds to the next try; none: there is none.
    pub(crate) wait: Option<f64>,
}

impl Db {
    /// The URL of a user's hook.
    pub(crate) fn hook(&self, user: i64) -> Result<Option<String>> {
        let url = "SELECT url FROM hooks WHERE user = ?1";
        (self.lock())
            .query_row(url, [user], |row| row.get(0))
            .optional()
    }

    /// Sets a user's hook, with a new secret. What waits goes to the new URL.
    pub(crate) fn set_hook(&self, user: i64, url: &str, secret: &str) -> Result<()> {
        self.lock().execute(
            "INSERT INTO hooks(user, url, secret) SELECT id, ?2, ?3 FROM users WHERE id = ?1
             ON CONFLICT(user) DO UPDATE SET url = excluded.url, secret = excluded.secret",
            params![user, url, secret],
        )?;
        Ok(())
    }

    /// Removes a user's hook, with what waits and with the log.
    pub(crate) fn remove_hook(&self, user: i64) -> Result<bool> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let hooks = transaction.execute("DELETE FROM hooks WHERE user = ?1", [user])?;
        transaction.execute("DELETE FROM deliveries WHERE user = ?1", [user])?;
        transaction.commit()?;
        Ok(hooks > 0)
    }

    /// Has a test sent to a user's hook. `false`: the user has no hook, or a test waits already.
    pub(crate) fn test_hook(&self, user: i64) -> Result<bool> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let waits = "SELECT EXISTS (SELECT 1 FROM deliveries WHERE user = ?1 AND run IS NULL AND next IS NOT NULL)";
        if transaction.query_row(waits, [user], |row| row.get(0))? {
            return Ok(false);
        }
        let body = json!({"state": "test", "time": now()}).to_string();
        let added = add(&transaction, user, None, "test", &body)?;
        transaction.commit()?;
        Ok(added)
    }

    /// The last deliveries of a user, newest first.
    pub(crate) fn deliveries(&self, user: i64) -> Result<Vec<DeliveryRow>> {
        let connection = self.lock();
        let mut query = connection.prepare_cached(
            "SELECT id, run, state, created, tries, next, status, message FROM deliveries WHERE user = ?1 ORDER BY id DESC LIMIT ?2",
        )?;
        let rows = query.query_map(params![user, KEPT], |row| {
            Ok(DeliveryRow {
                id: row.get(0)?,
                run: row.get(1)?,
                state: row.get(2)?,
                created: row.get(3)?,
                tries: row.get(4)?,
                next: row.get(5)?,
                status: row.get(6)?,
                message: row.get(7)?,
            })
        })?;
        rows.collect()
    }

    /// The next delivery that may be tried, of a user that has none on its way. The user whose last one began first comes first.
    pub(crate) fn begin_delivery(&self, busy: &[i64]) -> Result<Option<Due>> {
        let connection = self.lock();
        let busy = serde_json::to_string(busy).unwrap_or_default();
        let mut query = connection.prepare_cached(
            "SELECT d.id, d.user, h.url, h.secret, d.body, d.tries FROM deliveries d JOIN hooks h ON h.user = d.user
             WHERE d.next <= ?1 AND d.user NOT IN (SELECT value FROM json_each(?2)) ORDER BY h.began, d.next, d.id LIMIT 1",
        )?;
        let due = query
            .query_row(params![now(), busy], |row: &Row| {
                Ok(Due {
                    id: row.get(0)?,
                    user: row.get(1)?,
                    url: row.get(2)?,
                    secret: row.get(3)?,
                    body: row.get(4)?,
                    tries: row.get(5)?,
                })
            })
            .optional()?;
        if let Some(due) = &due {
            let began = "UPDATE hooks SET began = ?2 WHERE user = ?1";
            connection.execute(began, params![due.user, now()])?;
        }
        Ok(due)
    }

    /// Seconds to the next delivery of a user that has none on its way.
    pub(crate) fn next_delivery(&self, busy: &[i64]) -> Result<Option<f64>> {
        let busy = serde_json::to_string(busy).unwrap_or_default();
        let next =
            "SELECT min(next) FROM deliveries WHERE user NOT IN (SELECT value FROM json_each(?1))";
        let next: Option<f64> = self.lock().query_row(next, [busy], |row| row.get(0))?;
        Ok(next.map(|next| (next - now()).max(0.0)))
    }

    /// Records a try, and forgets the oldest deliveries that are over.
    pub(crate) fn end_delivery(&self, due: &Due, tried: &Tried) -> Result<()> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let next = tried.wait.map(|wait| now() + wait);
        transaction.execute(
            "UPDATE deliveries SET tries = tries + 1, next = ?2, status = ?3, message = ?4 WHERE id = ?1",
            params![due.id, next, tried.status, tried.message],
        )?;
        forget_old(&transaction, due.user)?;
        transaction.commit()
    }
}

fn forget_old(transaction: &Transaction, user: i64) -> Result<()> {
    transaction.execute(
        "DELETE FROM deliveries WHERE user = ?1 AND next IS NULL AND id <=
           (SELECT id FROM deliveries WHERE user = ?1 AND next IS NULL ORDER BY id DESC LIMIT 1 OFFSET ?2)",
        params![user, KEPT],
    )?;
    Ok(())
}

/// Adds a delivery for a user with a hook.
fn add(
    transaction: &Transaction,
    user: i64,
    run: Option<&str>,
    state: &str,
    body: &str,
) -> Result<bool> {
    let waiting = "SELECT count(*) FROM deliveries WHERE user = ?1 AND next IS NOT NULL";
    let waiting: i64 = transaction.query_row(waiting, [user], |row| row.get(0))?;
    let full = waiting >= MOST_WAITING;
    let message = if full {
        format!("Not sent: {MOST_WAITING} deliveries wait already.")
    } else {
        String::new()
    };
    let added = transaction.execute(
        "INSERT INTO deliveries(user, run, state, body, created, tries, next, message)
         SELECT user, ?2, ?3, ?4, ?5, 0, iif(?6, NULL, ?5), ?7 FROM hooks WHERE user = ?1",
        params![user, run, state, body, now(), full, message],
    )?;
    if full {
        forget_old(transaction, user)?;
    }
    Ok(added > 0)
}

/// Adds the delivery for a run that has just ended, as it is in its row now.
pub(super) fn add_end(transaction: &Transaction, run: &str, state: &str) -> Result<()> {
    let row = "SELECT r.owner, r.title, r.label, r.message, u.name FROM runs r JOIN users u ON u.id = r.owner JOIN hooks h ON h.user = u.id WHERE r.id = ?1";
    let found = transaction
        .query_row(row, [run], |row| {
            let text = |at: usize| row.get::<_, String>(at);
            let body = json!({
                "run": run, "state": state, "title": text(1)?, "label": text(2)?, "message": text(3)?, "owner": text(4)?, "time": now(),
            });
            Ok((row.get::<_, i64>(0)?, body.to_string()))
        })
        .optional()?;
    if let Some((user, body)) = found {
        add(transaction, user, Some(run), state, &body)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use cloud_api::lifecycle::Policy;

    use super::*;
    use crate::secrets::LOCAL_ID;
    use crate::users::{
        first_user,
        tests::{changed, new_user},
    };

    fn add_one(db: &Db, user: i64) -> bool {
        let mut connection = db.lock();
        let transaction = connection.transaction().unwrap();
        let added = add(&transaction, user, Some("r"), "finished", "{}").unwrap();
        transaction.commit().unwrap();
        added
    }

    fn tried(wait: Option<f64>) -> Tried {
        Tried {
            status: Some(500),
            message: "The answer is 500.".to_owned(),
            wait,
        }
    }

    /// Users take turns, whatever waits for one of them; one that has a delivery on its way gets no second one; a failed one waits.
    #[test]
    fn users_take_turns() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        changed(&db, &new_user("ada", Some("correct horse"))).unwrap();
        let ada = LOCAL_ID + 1;
        assert!(!add_one(&db, ada), "a delivery without a hook");
        for user in [LOCAL_ID, ada] {
            db.set_hook(user, "https://example.org/", "x").unwrap();
        }
        for _ in 0..3 {
            assert!(add_one(&db, LOCAL_ID));
        }
        assert!(add_one(&db, ada));
        let begin = |busy: &[i64]| db.begin_delivery(busy).unwrap();
        let first = begin(&[]).unwrap();
        assert_eq!(first.user, LOCAL_ID);
        db.end_delivery(&first, &tried(None)).unwrap();
        let second = begin(&[]).unwrap();
        assert_eq!(second.user, ada);
        let third = begin(&[ada]).unwrap();
        assert_eq!((third.user, third.id), (LOCAL_ID, first.id + 1));
        assert_eq!(begin(&[ada, LOCAL_ID]), None);
        db.end_delivery(&second, &tried(Some(1000.0))).unwrap();
        let waits = db.next_delivery(&[LOCAL_ID]).unwrap().unwrap();
        assert!((990.0..=1000.0).contains(&waits), "{waits}");
        assert_eq!(begin(&[LOCAL_ID]), None);
        let log = db.deliveries(ada).unwrap();
        assert_eq!((log.len(), log[0].tries, log[0].status), (1, 1, Some(500)));
        assert!(db.remove_hook(ada).unwrap() && !db.remove_hook(ada).unwrap());
        assert_eq!(db.deliveries(ada).unwrap(), []);
    }

    #[test]
    fn the_log_and_the_queue_are_bounded() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        db.set_hook(LOCAL_ID, "https://example.org/", "x").unwrap();
        for _ in 0..KEPT + 20 {
            add_one(&db, LOCAL_ID);
            let due = db.begin_delivery(&[]).unwrap().unwrap();
            db.end_delivery(&due, &tried(None)).unwrap();
        }
        let count = || {
            let count = "SELECT count(*) FROM deliveries";
            let connection = db.lock();
            connection.query_row(count, [], |row| row.get::<_, i64>(0))
        };
        assert_eq!(count().unwrap(), KEPT);
        let many = format!(
            "INSERT INTO deliveries(user, state, body, created, tries, next, message)
             WITH RECURSIVE n(k) AS (SELECT 1 UNION SELECT k + 1 FROM n WHERE k < {MOST_WAITING}) SELECT 1, 'finished', '', 0, 0, 1e12, '' FROM n"
        );
        db.lock().execute(&many, []).unwrap();
        add_one(&db, LOCAL_ID);
        let newest = &db.deliveries(LOCAL_ID).unwrap()[0];
        assert!(newest.next.is_none() && newest.message.contains("10000"));
        assert_eq!(count().unwrap(), KEPT + MOST_WAITING);
    }
}
