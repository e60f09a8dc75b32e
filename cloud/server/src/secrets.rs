//! Passwords, sessions, tokens and links. Secrets are 256 random bits and kept as hashes; passwords by argon2id.

use std::collections::HashMap;
use std::fs;
use std::io::Write;
use std::net::IpAddr;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};
use argon2::Argon2;
use argon2::password_hash::{PasswordHasher, PasswordVerifier, phc::PasswordHash};
use cloud_api::requests::NewUser;
use cloud_store::{hex, sha256};
use rusqlite::{OptionalExtension, params};

use crate::db::{self, Db, now};

/// Name of the user of a laptop.
const LOCAL: &str = "local";

/// Tries to log in without a delay.
const FREE_TRIES: u32 = 3;

/// The longest delay of a try, in s.
const LONGEST_DELAY: u64 = 900;

/// How long a wrong try is remembered.
const REMEMBERED: Duration = Duration::from_secs(3600);

/// The most names and addresses of which wrong tries are remembered.
const MOST_REMEMBERED: usize = 10_000;

/// The longest password, in bytes.
pub(crate) const LONGEST_PASSWORD: usize = 1000;

/// Seconds of a day.
pub(crate) const DAY: f64 = 86_400.0;

/// Use of a secret.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SecretKind {
    /// A cookie.
    Session,
    /// A bearer token of the API.
    Token,
    /// The link that `serve` prints.
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

/// A recognised user.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct User {
    pub(crate) id: i64,
    pub(crate) name: String,
    pub(crate) admin: bool,
    pub(crate) read_only: bool,
    /// The one run that the secret is for.
    pub(crate) share: Option<String>,
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

/// Hash of a password, with its parameters.
pub fn password_hash(password: &str) -> Result<String> {
    let hash = on_own_thread(|| Argon2::default().hash_password(password.as_bytes()));
    Ok(hash?
        .map_err(|error| anyhow!("the password cannot be hashed: {error}"))?
        .to_string())
}

fn is_password(password: &str, hash: &str) -> bool {
    PasswordHash::new(hash).is_ok_and(|hash| {
        on_own_thread(|| Argon2::default().verify_password(password.as_bytes(), &hash).is_ok())
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

/// Adds a user, or gives a user another password and other limits.
pub(crate) fn set_user(db: &Db, user: &NewUser) -> Result<()> {
    let hash = password_hash(&user.password)?;
    db.lock().execute(
        "INSERT INTO users(name, hash, admin, cores, disk) VALUES (?1, ?2, ?3, ?4, ?5)
         ON CONFLICT(name) DO UPDATE SET hash=?2, admin=?3, cores=?4, disk=?5",
        params![
            user.name,
            hash,
            user.admin,
            user.cores,
            user.disk.map(|bytes| bytes as i64)
        ],
    )?;
    Ok(())
}

/// A new secret. It is returned, and only its hash is kept.
pub(crate) fn issue(
    db: &Db,
    kind: SecretKind,
    user: i64,
    name: &str,
    run: Option<&str>,
    days: f64,
    read_only: bool,
) -> Result<(i64, String, f64)> {
    let secret = match kind {
        SecretKind::Token => format!("mc_{}", random()?),
        _ => random()?,
    };
    let expires = now() + days * DAY;
    let connection = db.lock();
    connection.execute("DELETE FROM secrets WHERE expires < ?1", [now()])?;
    connection.execute(
        "INSERT INTO secrets(hash, kind, user, name, run, expires, read_only) VALUES (?1,?2,?3,?4,?5,?6,?7)",
        params![sha256(secret.as_bytes()), kind.word(), user, name, run, expires, read_only],
    )?;
    Ok((connection.last_insert_rowid(), secret, expires))
}

/// The user whose secret of this kind it is. The comparison is by hash, so its time tells nothing of the secret.
pub(crate) fn recognise(db: &Db, kind: SecretKind, secret: &str) -> db::Result<Option<User>> {
    db.lock()
        .query_row(
            "SELECT u.id, u.name, u.admin, s.read_only, s.run FROM secrets s JOIN users u ON u.id = s.user
             WHERE s.hash = ?1 AND s.kind = ?2 AND s.expires > ?3",
            params![sha256(secret.as_bytes()), kind.word(), now()],
            |row| {
                Ok(User {
                    id: row.get(0)?,
                    name: row.get(1)?,
                    admin: row.get(2)?,
                    read_only: row.get(3)?,
                    share: row.get(4)?,
                })
            },
        )
        .optional()
}

/// The user of a laptop, for `--no-auth`.
pub(crate) fn local() -> User {
    User {
        id: 1,
        name: LOCAL.to_owned(),
        admin: true,
        read_only: false,
        share: None,
    }
}

/// The user with this password. Takes as long where there is no such user.
pub(crate) fn log_in(db: &Db, name: &str, password: &str) -> Result<Option<User>> {
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
        Some((id, admin, Some(hash))) if is_password(password, &hash) => Ok(Some(User {
            id,
            name: name.to_owned(),
            admin,
            read_only: false,
            share: None,
        })),
        Some((_, _, Some(_))) => Ok(None),
        _ => {
            password_hash(password)?;
            Ok(None)
        }
    }
}

pub(crate) fn revoke(db: &Db, kind: SecretKind, secret: &str) -> db::Result<()> {
    let hash = sha256(secret.as_bytes());
    db.lock().execute(
        "DELETE FROM secrets WHERE hash = ?1 AND kind = ?2",
        params![hash, kind.word()],
    )?;
    Ok(())
}

/// The secret of the link: kept in the data folder, readable by its owner alone, so that the link stays the same.
pub(crate) fn link_token(db: &Db, data: &Path) -> Result<String> {
    let path = data.join("link-token");
    if let Ok(token) = fs::read_to_string(&path)
        && recognise(db, SecretKind::Link, token.trim())?.is_some()
    {
        return Ok(token.trim().to_owned());
    }
    let (_, token, _) = issue(db, SecretKind::Link, 1, "link", None, 3650.0, false)?;
    write_secret(&path, &token)?;
    Ok(token)
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

/// Tries to log in that were wrong, by address and name together: tries of one address delay no other address.
#[derive(Default)]
pub(crate) struct Tries(Mutex<HashMap<(IpAddr, String), WrongTries>>);

struct WrongTries {
    count: u32,
    last: Instant,
}

impl WrongTries {
    /// Time from the last try to the next one: 1 s after the third, then doubled.
    fn delay(&self) -> Duration {
        let doublings = match self.count.checked_sub(FREE_TRIES) {
            None => return Duration::ZERO,
            Some(doublings) => doublings,
        };
        let seconds = 1_u64.checked_shl(doublings).unwrap_or(LONGEST_DELAY);
        Duration::from_secs(seconds.min(LONGEST_DELAY))
    }
}

impl Tries {
    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<(IpAddr, String), WrongTries>> {
        self.0
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Counts a try as wrong, until [`Self::forget`]. An error is the number of seconds until the next try.
    pub(crate) fn begin(&self, address: IpAddr, name: &str) -> std::result::Result<(), u64> {
        let mut all = self.lock();
        let key = (address, name.to_owned());
        if !all.contains_key(&key) && all.len() >= MOST_REMEMBERED {
            all.retain(|_, wrong| wrong.last.elapsed() < REMEMBERED);
            let oldest = all.iter().min_by_key(|(_, wrong)| wrong.last);
            if let Some(oldest) = oldest.map(|(key, _)| key.clone())
                && all.len() >= MOST_REMEMBERED
            {
                all.remove(&oldest);
            }
        }
        let now = Instant::now();
        let wrong = all.entry(key).or_insert(WrongTries {
            count: 0,
            last: now,
        });
        if wrong.last.elapsed() >= REMEMBERED {
            wrong.count = 0;
        }
        let left = wrong.delay().saturating_sub(wrong.last.elapsed());
        if !left.is_zero() {
            return Err(left.as_secs() + 1);
        }
        wrong.count += 1;
        wrong.last = now;
        Ok(())
    }

    /// Forgets the wrong tries of a user who has logged in.
    pub(crate) fn forget(&self, address: IpAddr, name: &str) {
        self.lock().remove(&(address, name.to_owned()));
    }
}

#[cfg(test)]
mod tests {
    use cloud_api::lifecycle::Policy;

    use super::*;

    #[test]
    fn secrets_are_good_for_one_thing_and_one_time() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let (_, token, _) = issue(&db, SecretKind::Token, 1, "x", None, 1.0, true).unwrap();
        assert!(
            recognise(&db, SecretKind::Token, &token)
                .unwrap()
                .unwrap()
                .read_only
        );
        assert_eq!(recognise(&db, SecretKind::Session, &token).unwrap(), None);
        assert_eq!(recognise(&db, SecretKind::Token, "mc_0").unwrap(), None);
        let (_, old, _) = issue(&db, SecretKind::Token, 1, "x", None, -1.0, false).unwrap();
        assert_eq!(recognise(&db, SecretKind::Token, &old).unwrap(), None);
        revoke(&db, SecretKind::Token, &token).unwrap();
        assert_eq!(recognise(&db, SecretKind::Token, &token).unwrap(), None);
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

    #[test]
    fn passwords_are_compared_by_their_hashes() {
        let folder = tempfile::tempdir().unwrap();
        let db = Db::open(&folder.path().join("db"), Policy::default(), None).unwrap();
        first_user(&db).unwrap();
        let ada = NewUser {
            name: "ada".into(),
            password: "correct horse".into(),
            admin: false,
            cores: None,
            disk: None,
        };
        set_user(&db, &ada).unwrap();
        assert!(log_in(&db, "ada", "correct horse").unwrap().is_some());
        assert!(log_in(&db, "ada", "wrong horse").unwrap().is_none());
        assert!(log_in(&db, "local", "").unwrap().is_none());
        assert!(log_in(&db, "nemo", "x").unwrap().is_none());
    }

    #[test]
    fn wrong_tries_delay_the_next_ones_of_the_same_address() {
        let tries = Tries::default();
        let (here, elsewhere) = (IpAddr::from([127, 0, 0, 1]), IpAddr::from([127, 0, 0, 2]));
        for _ in 0..3 {
            assert_eq!(tries.begin(here, "ada"), Ok(()));
        }
        assert_eq!(tries.begin(here, "ada"), Err(1));
        assert_eq!(tries.begin(elsewhere, "ada"), Ok(()));
        assert_eq!(tries.begin(here, "bob"), Ok(()));
        tries.forget(here, "ada");
        assert_eq!(tries.begin(here, "ada"), Ok(()));
        let delays = [2, 3, 4, 5, 12, 13, 100].map(|count| {
            let last = Instant::now();
            WrongTries { count, last }.delay().as_secs()
        });
        assert_eq!(delays, [0, 1, 2, 4, 512, 900, 900]);
    }

    #[test]
    fn a_table_of_wrong_tries_is_bounded() {
        let tries = Tries::default();
        let here = IpAddr::from([127, 0, 0, 1]);
        for k in 0..MOST_REMEMBERED + 10 {
            assert_eq!(tries.begin(here, &k.to_string()), Ok(()));
        }
        assert_eq!(tries.lock().len(), MOST_REMEMBERED);
    }
}
