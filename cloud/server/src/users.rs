//! Users: passwords, kept as hashes by argon2id, rights and limits.

use anyhow::{Result, anyhow};
use argon2::Argon2;
use argon2::password_hash::{PasswordHasher, PasswordVerifier, phc::PasswordHash};
use cloud_api::requests::NewUser;
use rusqlite::{Connection, OptionalExtension, params};

use crate::db::{self, Db};
use crate::secrets::{LOCAL, LOCAL_ID, Right, User, holds};

/// The longest password, in bytes.
pub(crate) const LONGEST_PASSWORD: usize = 1000;

/// Hash of a password, with its parameters.
fn password_hash(password: &str) -> Result<String> {
    let hash = on_own_thread(|| Argon2::default().hash_password(password.as_bytes()));
    Ok(hash?
        .map_err(|error| anyhow!("the password cannot be hashed: {error}"))?
        .to_string())
}

fn is_password(password: &str, hash: &str) -> bool {
    PasswordHash::new(hash).is_ok_and(|hash| {
        on_own_thread(|| {
            Argon2::default()
                .verify_password(password.as_bytes(), &hash)
                .is_ok()
        })
        .unwrap_or(false)
    })
}

/// Does work on a thread of its own. The allocator keeps the memory of a hash, 19 MB, for each thread that has made one.
fn on_own_thread<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T> {
    std::thread::scope(|scope| scope.spawn(work).join())
        .map_err(|_| anyhow!("the thread that hashes a password ended unexpectedly"))
}

/// The user of a laptop: exists from the beginning, without a password.
pub(crate) fn first_user(db: &Db) -> db::Result<()> {
    db.lock().execute(
        "INSERT OR IGNORE INTO users(id, name, hash, admin) VALUES (1, ?1, NULL, 1)",
        [LOCAL],
    )?;
    Ok(())
}

/// Reason for which a user was not changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum BadUser {
    #[error("A new user needs a password.")]
    NoPassword,
    #[error("This is the last administrator. Make another user one first.")]
    LastAdmin,
    #[error("The user `{LOCAL}` belongs to this machine, and cannot be removed.")]
    Local,
    #[error("The user has submitted a run meanwhile. Send the request again.")]
    Runs,
    #[error("You are no administrator any more.")]
    NotAdmin,
}

/// Whether a user is an administrator, and what allows the request still holds.
fn is_admin(connection: &Connection, user: i64, right: Right) -> db::Result<bool> {
    let admin = "SELECT EXISTS (SELECT 1 FROM users WHERE id = ?1 AND admin)";
    Ok(holds(connection, user, right)?
        && (matches!(right, Right::Server)
            || connection.query_row(admin, [user], |row| row.get(0))?))
}

/// Adds a user, or changes what is given of a user: password, rights, limits. A new password ends the sessions that the old one has begun.
/// `by`: the administrator, and what allows the request.
pub(crate) fn set_user(
    db: &Db,
    by: (i64, Right),
    user: &NewUser,
) -> Result<std::result::Result<(), BadUser>> {
    let hash = user.password.as_deref().map(password_hash).transpose()?;
    let mut connection = db.lock();
    let transaction = connection.transaction()?;
    if !is_admin(&transaction, by.0, by.1)? {
        return Ok(Err(BadUser::NotAdmin));
    }
    let known = transaction
        .query_row(
            "SELECT id FROM users WHERE name = ?1",
            [&user.name],
            |row| row.get::<_, i64>(0),
        )
        .optional()?;
    let id = match (known, &hash) {
        (Some(id), _) => id,
        (None, Some(_)) => {
            let id = db::next_id(&transaction, "users")?;
            let add = "INSERT INTO users(id, name, admin) VALUES (?1, ?2, 0)";
            transaction.execute(add, params![id, user.name])?;
            id
        }
        (None, None) => return Ok(Err(BadUser::NoPassword)),
    };
    if let Some(hash) = &hash {
        transaction.execute(
            "UPDATE users SET hash = ?2 WHERE id = ?1",
            params![id, hash],
        )?;
        let sessions =
            "DELETE FROM secrets WHERE user = ?1 AND kind = 'session' AND parent IS NULL";
        transaction.execute(sessions, [id])?;
    }
    if let Some(admin) = user.admin {
        transaction.execute(
            "UPDATE users SET admin = ?2 WHERE id = ?1",
            params![id, admin],
        )?;
    }
    if let Some(cores) = user.cores {
        transaction.execute(
            "UPDATE users SET cores = ?2 WHERE id = ?1",
            params![id, cores],
        )?;
    }
    if let Some(disk) = user.disk {
        let disk = disk.map(|bytes| bytes as i64);
        transaction.execute(
            "UPDATE users SET disk = ?2 WHERE id = ?1",
            params![id, disk],
        )?;
    }
    if let Some(core_seconds) = user.core_seconds {
        transaction.execute(
            "UPDATE users SET core_seconds = ?2 WHERE id = ?1",
            params![id, core_seconds],
        )?;
    }
    if !has_other_admin(&transaction, 0)? {
        return Ok(Err(BadUser::LastAdmin));
    }
    transaction.commit()?;
    Ok(Ok(()))
}

/// Whether there is an administrator besides this user.
fn has_other_admin(connection: &Connection, user: i64) -> db::Result<bool> {
    let other = "SELECT EXISTS (SELECT 1 FROM users WHERE admin AND id <> ?1)";
    connection.query_row(other, [user], |row| row.get(0))
}

/// Refuses to remove the user of the machine, and the last administrator.
pub(crate) fn may_be_removed(
    connection: &Connection,
    id: i64,
) -> db::Result<std::result::Result<(), BadUser>> {
    Ok(if id == LOCAL_ID {
        Err(BadUser::Local)
    } else if !has_other_admin(connection, id)? {
        Err(BadUser::LastAdmin)
    } else {
        Ok(())
    })
}

/// Removes a user without runs, with all secrets and inputs. Returns the inputs.
/// `by`: the administrator, and what allows the request.
pub(crate) fn remove_user(
    db: &Db,
    by: (i64, Right),
    id: i64,
) -> Result<std::result::Result<Vec<String>, BadUser>> {
    let mut connection = db.lock();
    let transaction = connection.transaction()?;
    if !is_admin(&transaction, by.0, by.1)? {
        return Ok(Err(BadUser::NotAdmin));
    }
    if let Err(why) = may_be_removed(&transaction, id)? {
        return Ok(Err(why));
    }
    let runs = "SELECT EXISTS (SELECT 1 FROM runs WHERE owner = ?1)";
    if transaction.query_row(runs, [id], |row| row.get(0))? {
        return Ok(Err(BadUser::Runs));
    }
    let gone = db::forget_inputs(&transaction, id)?;
    for (table, column) in [
        ("secrets", "user"),
        ("members", "user"),
        ("hooks", "user"),
        ("deliveries", "user"),
        ("studies", "owner"),
        ("users", "id"),
    ] {
        let remove = format!("DELETE FROM {table} WHERE {column} = ?1");
        transaction.execute(&remove, [id])?;
    }
    transaction.commit()?;
    Ok(Ok(gone))
}

/// The user with this password, and its hash. Takes as long where there is no such user.
pub(crate) fn log_in(db: &Db, name: &str, password: &str) -> Result<Option<(User, String)>> {
    let found = db
        .lock()
        .query_row(
            "SELECT id, admin, hash FROM users WHERE name = ?1",
            [name],
            |row| {
                Ok((
                    row.get::<_, i64>(0)?,
                    row.get::<_, bool>(1)?,
                    row.get::<_, Option<String>>(2)?,
                ))
            },
        )
        .optional()?;
    match found {
        Some((id, admin, Some(hash))) if is_password(password, &hash) => {
            Ok(Some((User::new(id, name, admin), hash)))
        }
        Some((_, _, Some(_))) => Ok(None),
        _ => {
            password_hash(password)?;
            Ok(None)
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The user of the machine changes a user.
    pub(crate) fn changed(db: &Db, user: &NewUser) -> std::result::Result<(), BadUser> {
        set_user(db, (LOCAL_ID, Right::Server), user).unwrap()
    }

    pub(crate) fn new_user(name: &str, password: Option<&str>) -> NewUser {
        NewUser {
            name: name.into(),
            password: password.map(str::to_owned),
            admin: None,
            cores: None,
            disk: None,
            core_seconds: None,
        }
    }
}
