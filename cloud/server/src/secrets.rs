//! Sessions, tokens and links: 256 random bits each, kept as hashes.

use std::fs;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use anyhow::{Context, Result, anyhow};
use cloud_store::{hex, sha256};
use rusqlite::{Connection, OptionalExtension, Transaction, params};

use crate::db::{self, Db, now};
use crate::turns::OfUser;

/// Name of the user of a laptop.
pub(crate) const LOCAL: &str = "local";

/// Number of that user.
pub(crate) const LOCAL_ID: i64 = 1;

/// Seconds of a day.
pub(crate) const DAY: f64 = 86_400.0;

/// Use of a secret.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SecretKind {
    /// A cookie.
    Session,
    /// A bearer token of the API.
    Token,
    /// A link that logs in the user of the machine, once.
    Link,
    /// A link to one run, to look at.
    Share,
}

impl SecretKind {
    fn word(self) -> &'static str {
        match self {
            Self::Session => "session",
            Self::Token => "token",
            Self::Link => "link",
            Self::Share => "share",
        }
    }
}

/// What allows a new secret. It still has to hold when the secret is written.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Right<'a> {
    /// The server itself needs the secret.
    Server,
    /// The secret with this number: that of the request.
    Secret(i64),
    /// The link with this number, which is used up.
    Link(i64),
    /// The password of the user, with this hash.
    Password(&'a str),
}

/// A secret that is to be made.
pub(crate) struct NewSecret<'a> {
    pub(crate) kind: SecretKind,
    pub(crate) user: i64,
    pub(crate) right: Right<'a>,
    /// As in [`User`]: the new one ends with that one, and not later.
    pub(crate) root: Option<(i64, f64)>,
    pub(crate) name: &'a str,
    pub(crate) run: Option<&'a str>,
    pub(crate) days: f64,
    pub(crate) read_only: bool,
}

/// A secret that was made.
#[derive(Debug)]
pub(crate) struct Issued {
    pub(crate) id: i64,
    /// Kept nowhere else.
    pub(crate) secret: String,
    /// Unix time, in s.
    pub(crate) expires: f64,
}

/// Sender of a request that has a good secret.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Caller {
    User(User),
    Guest(Guest),
}

/// A guest: one that has a link to a run, to look at.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Guest {
    /// The run.
    pub(crate) run: String,
    /// The owner of the run.
    pub(crate) owner: i64,
    /// Number of the secret that the request has.
    pub(crate) secret: i64,
    /// As in [`User`].
    pub(crate) root: Option<(i64, f64)>,
}

/// A user: one that has an account. Functions that take one do nothing for guests.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct User {
    pub(crate) id: i64,
    pub(crate) name: String,
    pub(crate) admin: bool,
    pub(crate) read_only: bool,
    /// Number of the secret that the request has.
    pub(crate) secret: Option<i64>,
    /// The token or share that the secret is, or was made with: number, and Unix time of its end, in s.
    pub(crate) root: Option<(i64, f64)>,
}

impl User {
    pub(crate) fn new(id: i64, name: &str, admin: bool) -> Self {
        Self {
            id,
            name: name.to_owned(),
            admin,
            read_only: false,
            secret: None,
            root: None,
        }
    }

    /// What allows this user's request to make a secret.
    pub(crate) fn right(&self) -> Right<'static> {
        // Without a secret: the user of `--no-auth`.
        self.secret.map_or(Right::Server, Right::Secret)
    }
}

impl Caller {
    /// Number of the secret that the request has.
    pub(crate) fn secret(&self) -> Option<i64> {
        match self {
            Self::User(user) => user.secret,
            Self::Guest(guest) => Some(guest.secret),
        }
    }

    /// Name of the user; that of a guest is not known.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::User(user) => &user.name,
            Self::Guest(_) => "guest",
        }
    }

    /// Whether it only looks.
    pub(crate) fn is_read_only(&self) -> bool {
        match self {
            Self::User(user) => user.read_only,
            Self::Guest(_) => true,
        }
    }

    /// The user whose turns it takes, and whether they are those of guests.
    pub(crate) fn turns(&self) -> OfUser {
        match self {
            Self::User(user) => (user.id, false),
            Self::Guest(guest) => (guest.owner, true),
        }
    }
}

/// 256 random bits as digits.
pub(crate) fn random() -> Result<String> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes).map_err(|error| anyhow!("no random numbers: {error}"))?;
    Ok(hex(&bytes))
}

/// A name for a run.
pub(crate) fn run_id() -> Result<cloud_api::RunId> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|error| anyhow!("no random numbers: {error}"))?;
    Ok(cloud_api::RunId::of(bytes))
}

/// Whether the user is still there, and what allows a secret of this user still holds.
pub(crate) fn holds(connection: &Connection, user: i64, right: Right) -> db::Result<bool> {
    let hash = match right {
        Right::Password(hash) => Some(hash),
        _ => None,
    };
    let secret = match right {
        Right::Secret(id) | Right::Link(id) => Some(id),
        _ => None,
    };
    connection.query_row(
        "SELECT EXISTS (SELECT 1 FROM users WHERE id = ?1 AND (?2 IS NULL OR hash = ?2))
           AND (?3 IS NULL OR EXISTS (SELECT 1 FROM secrets WHERE id = ?3 AND expires > ?4))",
        params![user, hash, secret, now()],
        |row| row.get(0),
    )
}

/// A new secret: only its hash is kept. `None`: what allowed it does not hold any more.
pub(crate) fn issue(db: &Db, new: &NewSecret) -> Result<Option<Issued>> {
    let mut connection = db.lock();
    let transaction = connection.transaction()?;
    let issued = issue_in(&transaction, new)?;
    if issued.is_some() {
        transaction.commit()?;
    }
    Ok(issued)
}

fn issue_in(transaction: &Transaction, new: &NewSecret) -> Result<Option<Issued>> {
    let secret = match new.kind {
        SecretKind::Token => format!("mc_{}", random()?),
        _ => random()?,
    };
    let wanted = now() + new.days * DAY;
    let (parent, expires) = match new.root {
        Some((parent, end)) => (Some(parent), wanted.min(end)),
        None => (None, wanted),
    };
    transaction.execute("DELETE FROM secrets WHERE expires < ?1", [now()])?;
    if !holds(transaction, new.user, new.right)? {
        return Ok(None);
    }
    if let Right::Link(link) = new.right {
        transaction.execute("DELETE FROM secrets WHERE id = ?1", [link])?;
    }
    let id = db::next_id(transaction, "secrets")?;
    transaction.execute(
        "INSERT INTO secrets(id, hash, kind, user, name, run, expires, read_only, parent, created) VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10)",
        params![
            id,
            sha256(secret.as_bytes()),
            new.kind.word(),
            new.user,
            new.name,
            new.run,
            expires,
            new.read_only,
            parent,
            now()
        ],
    )?;
    Ok(Some(Issued {
        id,
        secret,
        expires,
    }))
}

/// The user or guest whose secret of this kind it is. The comparison is by hash, so its time tells nothing of the secret.
pub(crate) fn recognise(db: &Db, kind: SecretKind, secret: &str) -> db::Result<Option<Caller>> {
    db.lock()
        .query_row(
            "SELECT u.id, u.name, u.admin, s.read_only, s.run, s.id, s.expires, s.parent FROM secrets s JOIN users u ON u.id = s.user
             WHERE s.hash = ?1 AND s.kind = ?2 AND s.expires > ?3",
            params![sha256(secret.as_bytes()), kind.word(), now()],
            |row| {
                let (secret, expires): (i64, f64) = (row.get(5)?, row.get(6)?);
                let parent: Option<i64> = row.get(7)?;
                let root = match kind {
                    SecretKind::Token | SecretKind::Share => Some((secret, expires)),
                    SecretKind::Session | SecretKind::Link => {
                        parent.map(|parent| (parent, expires))
                    }
                };
                let owner = row.get(0)?;
                Ok(match row.get(4)? {
                    Some(run) => Caller::Guest(Guest {
                        run,
                        owner,
                        secret,
                        root,
                    }),
                    None => Caller::User(User {
                        id: owner,
                        name: row.get(1)?,
                        admin: row.get(2)?,
                        read_only: row.get(3)?,
                        secret: Some(secret),
                        root,
                    }),
                })
            },
        )
        .optional()
}

/// The user of a laptop, for `--no-auth`.
pub(crate) fn local() -> User {
    User::new(LOCAL_ID, LOCAL, true)
}

/// Whether a secret with this number is still there, and good.
pub(crate) fn is_good(db: &Db, secret: i64) -> db::Result<bool> {
    let count = "SELECT count(*) FROM secrets WHERE id = ?1 AND expires > ?2";
    let count: i64 = (db.lock()).query_row(count, params![secret, now()], |row| row.get(0))?;
    Ok(count > 0)
}

/// Takes a secret of a user back, with all that were made with it. `false`: the user has no such secret.
pub(crate) fn take_back(db: &Db, kind: SecretKind, user: i64, id: i64) -> db::Result<bool> {
    let which = "id = ?1 AND user = ?2 AND kind = ?3";
    let removed = remove_tree(&db.lock(), which, params![id, user, kind.word()])?;
    Ok(removed > 0)
}

/// Removes the secrets that a condition names, with all that were made with them.
fn remove_tree(
    connection: &Connection,
    condition: &str,
    values: &[&dyn rusqlite::ToSql],
) -> db::Result<usize> {
    let remove = format!(
        "WITH RECURSIVE gone(id) AS (SELECT id FROM secrets WHERE {condition}
           UNION SELECT s.id FROM secrets s JOIN gone ON s.parent = gone.id)
         DELETE FROM secrets WHERE id IN (SELECT id FROM gone)"
    );
    connection.execute(&remove, values)
}

/// A secret as lists show it, with its kind.
pub(crate) struct Listed {
    pub(crate) id: i64,
    pub(crate) name: String,
    pub(crate) run: Option<String>,
    pub(crate) created: f64,
    pub(crate) expires: f64,
    pub(crate) read_only: bool,
    /// Name of the token, or `share`, that it was made with.
    pub(crate) made_with: Option<String>,
}

/// The secrets of a kind that a user has, or that a run has. Sessions of links to runs end with those, and are in no list.
pub(crate) fn list(
    db: &Db,
    kind: SecretKind,
    user: Option<i64>,
    run: Option<&str>,
) -> db::Result<Vec<Listed>> {
    let connection = db.lock();
    let mut query = connection.prepare(
        "SELECT s.id, s.name, s.run, s.created, s.expires, s.read_only, p.name FROM secrets s LEFT JOIN secrets p ON p.id = s.parent
         WHERE s.kind = ?1 AND s.expires > ?2 AND (?3 IS NULL OR s.user = ?3) AND (?4 IS NULL OR s.run = ?4)
           AND (s.kind <> 'session' OR s.run IS NULL) ORDER BY s.id DESC LIMIT 200",
    )?;
    let rows = query.query_map(params![kind.word(), now(), user, run], |row| {
        Ok(Listed {
            id: row.get(0)?,
            name: row.get(1)?,
            run: row.get(2)?,
            created: row.get(3)?,
            expires: row.get(4)?,
            read_only: row.get(5)?,
            made_with: row.get(6)?,
        })
    })?;
    rows.collect()
}

pub(crate) fn revoke(db: &Db, kind: SecretKind, secret: &str) -> db::Result<()> {
    let hash = sha256(secret.as_bytes());
    db.lock().execute(
        "DELETE FROM secrets WHERE hash = ?1 AND kind = ?2",
        params![hash, kind.word()],
    )?;
    Ok(())
}

/// Name of the token with which the command line of this machine talks to the server.
const COMMAND_LINE: &str = "command line of this machine";

/// A link that logs in the user of this machine: good once, within a day. The one before is good no more.
pub(crate) fn link(db: &Db, right: Right, root: Option<(i64, f64)>) -> Result<Option<Issued>> {
    let mut connection = db.lock();
    let transaction = connection.transaction()?;
    transaction.execute("DELETE FROM secrets WHERE kind = 'link'", [])?;
    let link = NewSecret {
        kind: SecretKind::Link,
        user: LOCAL_ID,
        right,
        root,
        name: "link",
        run: None,
        days: 1.0,
        read_only: false,
    };
    let issued = issue_in(&transaction, &link)?;
    if issued.is_some() {
        transaction.commit()?;
    }
    Ok(issued)
}

/// The token of the command line of this machine: kept in the data folder, readable by its owner alone. `rotate`: a new one, and all
/// sessions of the user of this machine end; with what allows that. `None`: it does not hold any more.
pub(crate) fn machine_token(db: &Db, data: &Path, rotate: Option<Right>) -> Result<Option<Issued>> {
    let path = data.join("token");
    if rotate.is_none()
        && let Ok(token) = fs::read_to_string(&path)
        && let Some(Caller::User(user)) = recognise(db, SecretKind::Token, token.trim())?
        && let Some((id, expires)) = user.root
    {
        return Ok(Some(Issued {
            id,
            secret: token.trim().to_owned(),
            expires,
        }));
    }
    let mut connection = db.lock();
    let transaction = connection.transaction()?;
    if let Some(right) = rotate {
        if !holds(&transaction, LOCAL_ID, right)? {
            return Ok(None);
        }
        end_sessions_in(&transaction, LOCAL_ID)?;
    }
    let old = params![COMMAND_LINE, LOCAL_ID, SecretKind::Token.word()];
    remove_tree(&transaction, "name = ?1 AND user = ?2 AND kind = ?3", old)?;
    let token = NewSecret {
        kind: SecretKind::Token,
        user: LOCAL_ID,
        right: Right::Server,
        root: None,
        name: COMMAND_LINE,
        run: None,
        days: 3650.0,
        read_only: false,
    };
    let issued = issue_in(&transaction, &token)?
        .context("the user of this machine is not in the database")?;
    transaction.commit()?;
    write_secret(&path, &issued.secret)?;
    Ok(Some(issued))
}

/// Logs a user out everywhere.
pub(crate) fn end_sessions(db: &Db, user: i64) -> db::Result<()> {
    end_sessions_in(&db.lock(), user)
}

fn end_sessions_in(connection: &Connection, user: i64) -> db::Result<()> {
    let sessions = "DELETE FROM secrets WHERE user = ?1 AND kind = 'session' AND run IS NULL";
    connection.execute(sessions, [user])?;
    Ok(())
}

/// Writes a file that its owner alone may read.
pub(crate) fn write_secret(path: &Path, text: &str) -> Result<()> {
    let written = fs::OpenOptions::new()
        .create(true)
        .truncate(true)
        .write(true)
        .mode(0o600)
        .open(path)
        .and_then(|mut file| writeln!(file, "{text}"));
    written.with_context(|| format!("{}", path.display()))
}

#[cfg(test)]
mod tests {
    use cloud_api::lifecycle::Policy;
    use cloud_api::requests::NewUser;

    use super::*;
    use crate::users::tests::{changed, new_user};
    use crate::users::{BadUser, first_user, log_in, remove_user, set_user};

    /// A secret of the server's own making.
    fn made(
        db: &Db,
        kind: SecretKind,
        user: i64,
        root: Option<(i64, f64)>,
        days: f64,
    ) -> (i64, String, f64) {
        let new = NewSecret {
            kind,
            user,
            right: Right::Server,
            root,
            name: "x",
            run: None,
            days,
            read_only: true,
        };
        let issued = issue(db, &new).unwrap().unwrap();
        (issued.id, issued.secret, issued.expires)
    }

    /// The user that a secret recognises.
    fn user_of(db: &Db, kind: SecretKind, secret: &str) -> Option<User> {
        match recognise(db, kind, secret).unwrap()? {
            Caller::User(user) => Some(user),
            Caller::Guest(guest) => panic!("{guest:?}"),
        }
    }

    #[test]
    fn secrets_are_good_for_one_thing_and_one_time() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let (_, token, _) = made(&db, SecretKind::Token, 1, None, 1.0);
        assert!(user_of(&db, SecretKind::Token, &token).unwrap().read_only);
        assert_eq!(user_of(&db, SecretKind::Session, &token), None);
        assert_eq!(user_of(&db, SecretKind::Token, "mc_0"), None);
        let (_, old, _) = made(&db, SecretKind::Token, 1, None, -1.0);
        assert_eq!(user_of(&db, SecretKind::Token, &old), None);
        revoke(&db, SecretKind::Token, &token).unwrap();
        assert_eq!(user_of(&db, SecretKind::Token, &token), None);
        let kept: i64 = db
            .lock()
            .query_row(
                "SELECT count(*) FROM secrets WHERE hash = ?1",
                [&token],
                |row| row.get(0),
            )
            .unwrap();
        assert_eq!(kept, 0, "a secret is never kept in the clear");
    }

    /// Secrets that a token makes end with it, and not later; so do secrets that those make.
    #[test]
    fn what_a_token_makes_ends_with_it() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let make = |kind, root, days| made(&db, kind, 1, root, days);
        let (id, token, end) = make(SecretKind::Token, None, 1.0);
        let user = user_of(&db, SecretKind::Token, &token).unwrap();
        assert_eq!(user.root, Some((id, end)));
        let (_, session, session_end) = make(SecretKind::Session, user.root, 30.0);
        assert_eq!(session_end, end);
        let user = user_of(&db, SecretKind::Session, &session).unwrap();
        assert_eq!(user.root, Some((id, end)));
        let (_, second, second_end) = make(SecretKind::Token, user.root, 366.0);
        assert_eq!(second_end, end);
        let second = user_of(&db, SecretKind::Token, &second).unwrap();
        let (last, _, _) = make(SecretKind::Session, second.root, 30.0);
        assert!(!take_back(&db, SecretKind::Share, 1, id).unwrap());
        assert!(!take_back(&db, SecretKind::Token, 2, id).unwrap());
        assert!(take_back(&db, SecretKind::Token, 1, id).unwrap());
        assert_eq!(user_of(&db, SecretKind::Session, &session), None);
        assert!(!is_good(&db, last).unwrap());
    }

    /// What allows a request is looked at again when it writes.
    #[test]
    fn what_is_taken_back_makes_nothing_any_more() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let ada = NewUser {
            admin: Some(true),
            ..new_user("ada", Some("correct horse"))
        };
        changed(&db, &ada).unwrap();
        let (user, hash) = log_in(&db, "ada", "correct horse").unwrap().unwrap();
        let ada = user.id;
        let makes = |right| {
            let new = NewSecret {
                kind: SecretKind::Token,
                user: ada,
                right,
                root: None,
                name: "x",
                run: None,
                days: 1.0,
                read_only: false,
            };
            issue(&db, &new).unwrap().is_some()
        };
        let sets =
            |right| set_user(&db, (ada, right), &new_user("bob", Some("correct horse"))).unwrap();
        // By a secret, until it is taken back.
        let (id, secret, _) = made(&db, SecretKind::Session, ada, None, 1.0);
        assert!(makes(Right::Secret(id)));
        assert_eq!(sets(Right::Secret(id)), Ok(()));
        revoke(&db, SecretKind::Session, &secret).unwrap();
        assert!(!makes(Right::Secret(id)));
        assert_eq!(sets(Right::Secret(id)), Err(BadUser::NotAdmin));
        // By an administrator, while it is one.
        let (id, _, _) = made(&db, SecretKind::Session, ada, None, 1.0);
        let demoted = NewUser {
            admin: Some(false),
            ..new_user("ada", None)
        };
        changed(&db, &demoted).unwrap();
        assert_eq!(sets(Right::Secret(id)), Err(BadUser::NotAdmin));
        let removed = remove_user(&db, (ada, Right::Secret(id)), ada).unwrap();
        assert_eq!(removed, Err(BadUser::NotAdmin));
        // By a link, once; by a password, until it is another one.
        let (link, _, _) = made(&db, SecretKind::Link, ada, None, 1.0);
        assert!(makes(Right::Link(link)));
        assert!(!makes(Right::Link(link)));
        assert!(makes(Right::Password(&hash)));
        changed(&db, &new_user("ada", Some("another horse"))).unwrap();
        assert!(!makes(Right::Password(&hash)));
        // For a user, while the user exists; the next user has another number.
        let by = (LOCAL_ID, Right::Server);
        remove_user(
            &db,
            by,
            log_in(&db, "bob", "correct horse").unwrap().unwrap().0.id,
        )
        .unwrap()
        .unwrap();
        remove_user(&db, by, ada).unwrap().unwrap();
        assert!(!makes(Right::Server));
        changed(&db, &new_user("eve", Some("correct horse"))).unwrap();
        let (eve, _) = log_in(&db, "eve", "correct horse").unwrap().unwrap();
        assert_eq!(eve.id, 4);
        // A secret has no number of one that was taken back.
        let (last, _, _) = made(&db, SecretKind::Token, LOCAL_ID, None, 1.0);
        take_back(&db, SecretKind::Token, LOCAL_ID, last).unwrap();
        assert!(made(&db, SecretKind::Token, LOCAL_ID, None, 1.0).0 > last);
    }

    /// A link of a token ends with it, and so does the session that it begins; a new token of the machine ends the old one.
    #[test]
    fn a_link_of_a_token_ends_with_it() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let (id, token, end) = made(&db, SecretKind::Token, LOCAL_ID, None, 0.5);
        let user = user_of(&db, SecretKind::Token, &token).unwrap();
        let made_link = link(&db, user.right(), user.root).unwrap().unwrap();
        assert_eq!(made_link.expires, end);
        let user = user_of(&db, SecretKind::Link, &made_link.secret).unwrap();
        assert_eq!(user.root, Some((id, end)));
        assert!(take_back(&db, SecretKind::Token, LOCAL_ID, id).unwrap());
        assert!(!is_good(&db, made_link.id).unwrap());
        // A token that was taken back rotates nothing, and leaves the link of another one.
        let kept = link(&db, Right::Server, None).unwrap().unwrap();
        assert!(link(&db, Right::Secret(id), None).unwrap().is_none());
        assert!(is_good(&db, kept.id).unwrap());
        let rotate = |right| machine_token(&db, folder.path(), right).unwrap();
        let first = rotate(None).unwrap();
        assert!(rotate(Some(Right::Secret(id))).is_none());
        assert_eq!(rotate(None).unwrap().id, first.id);
        let second = rotate(Some(Right::Secret(first.id))).unwrap();
        assert!(!is_good(&db, first.id).unwrap());
        assert_eq!(rotate(None).unwrap().id, second.id);
    }

    /// Many sessions of links to runs hide none of the user's own.
    #[test]
    fn a_list_of_sessions_has_those_of_users() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let (own, _, _) = made(&db, SecretKind::Session, LOCAL_ID, None, 1.0);
        let add = "INSERT INTO secrets(hash, kind, user, name, run, expires, read_only)
                   WITH RECURSIVE n(k) AS (SELECT 1 UNION SELECT k + 1 FROM n WHERE k < 300)
                   SELECT k, 'session', 1, '', 'r', 1e12, 1 FROM n";
        assert_eq!(db.lock().execute(add, []).unwrap(), 300);
        let listed = list(&db, SecretKind::Session, Some(LOCAL_ID), None).unwrap();
        assert_eq!(listed.iter().map(|row| row.id).collect::<Vec<_>>(), [own]);
    }

    #[test]
    fn a_change_of_a_user_changes_what_is_given() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let set = |user: &NewUser| changed(&db, user);
        assert_eq!(set(&new_user("ada", None)), Err(BadUser::NoPassword));
        let ada = NewUser {
            admin: Some(true),
            cores: Some(Some(3)),
            disk: Some(Some(5)),
            ..new_user("ada", Some("correct horse"))
        };
        assert_eq!(set(&ada), Ok(()));
        let (user, _) = log_in(&db, "ada", "correct horse").unwrap().unwrap();
        let (_, session, _) = made(&db, SecretKind::Session, user.id, None, 1.0);
        let (_, token, _) = made(&db, SecretKind::Token, user.id, None, 1.0);
        assert_eq!(set(&new_user("ada", Some("another horse"))), Ok(()));
        assert!(
            log_in(&db, "ada", "another horse")
                .unwrap()
                .unwrap()
                .0
                .admin
        );
        let usage = db.usage(user.id).unwrap();
        assert_eq!((usage.most_cores, usage.most_disk), (Some(3), Some(5)));
        assert_eq!(user_of(&db, SecretKind::Session, &session), None);
        assert!(user_of(&db, SecretKind::Token, &token).is_some());
        let free = NewUser {
            disk: Some(None),
            ..new_user("ada", None)
        };
        assert_eq!(set(&free), Ok(()));
        assert_eq!(db.usage(user.id).unwrap().most_disk, None);
        let demoted = |name: &str| NewUser {
            admin: Some(false),
            ..new_user(name, None)
        };
        assert_eq!(set(&demoted(LOCAL)), Ok(()));
        assert_eq!(set(&demoted("ada")), Err(BadUser::LastAdmin));
        assert!(
            log_in(&db, "ada", "another horse")
                .unwrap()
                .unwrap()
                .0
                .admin
        );
        let by = (LOCAL_ID, Right::Server);
        assert_eq!(remove_user(&db, by, LOCAL_ID).unwrap(), Err(BadUser::Local));
        assert_eq!(
            remove_user(&db, by, user.id).unwrap(),
            Err(BadUser::LastAdmin)
        );
        let bob = NewUser {
            admin: Some(true),
            ..new_user("bob", Some("correct horse"))
        };
        assert_eq!(set(&bob), Ok(()));
        for (content, owner) in [("a", user.id), ("b", user.id), ("b", LOCAL_ID)] {
            db.add_input(content, owner, 1).unwrap();
        }
        let gone = remove_user(&db, by, user.id).unwrap();
        assert_eq!(gone, Ok(vec!["a".to_owned(), "b".to_owned()]));
        assert!(log_in(&db, "ada", "another horse").unwrap().is_none());
        assert_eq!(user_of(&db, SecretKind::Token, &token), None);
    }

    #[test]
    fn passwords_are_compared_by_their_hashes() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let ada = new_user("ada", Some("correct horse"));
        changed(&db, &ada).unwrap();
        assert!(log_in(&db, "ada", "correct horse").unwrap().is_some());
        assert!(log_in(&db, "ada", "wrong horse").unwrap().is_none());
        assert!(log_in(&db, "local", "").unwrap().is_none());
        assert!(log_in(&db, "nemo", "x").unwrap().is_none());
    }
}
