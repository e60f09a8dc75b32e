//! Inputs in the store: each content is there once, for all of its users, for as long as one of them has it or a run names it.

use std::collections::HashSet;
use std::sync::{Condvar, Mutex, MutexGuard};

use crate::access::ApiError;
use crate::db::{Forgotten, Reserved};
use crate::runs::{granted, within_quota};
use crate::state::App;

/// Key of a content in the store.
pub(crate) fn key(sha256: &str) -> String {
    format!("inputs/{sha256}")
}

/// Contents that are being added or removed. A content that another request removes is not taken for one that is there.
#[derive(Default)]
pub(crate) struct Busy {
    contents: Mutex<HashSet<String>>,
    freed: Condvar,
}

/// The right to add or remove a content, until it is dropped.
pub(crate) struct Held<'a> {
    busy: &'a Busy,
    sha256: String,
}

impl Busy {
    fn lock(&self) -> MutexGuard<'_, HashSet<String>> {
        self.contents
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Waits until no other request adds or removes this content.
    fn hold(&self, sha256: &str) -> Held<'_> {
        let mut contents = self.lock();
        while !contents.insert(sha256.to_owned()) {
            contents = self
                .freed
                .wait(contents)
                .unwrap_or_else(|poisoned| poisoned.into_inner());
        }
        Held {
            busy: self,
            sha256: sha256.to_owned(),
        }
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.busy.lock().remove(&self.sha256);
        self.busy.freed.notify_all();
    }
}

/// Gives a user a content, within the limit of the user. `put` brings it into the store, where it is not there yet. Returns whether the
/// user did not have it.
pub(crate) fn add(
    app: &App,
    user: i64,
    sha256: &str,
    bytes: u64,
    put: impl FnOnce() -> Result<(), ApiError>,
) -> Result<bool, ApiError> {
    if app.db.input(sha256, user)?.is_some() {
        return Ok(false);
    }
    // Before the work.
    within_quota(app, user, 0, bytes)?;
    keep(app, sha256, bytes, put, || {
        app.db.add_input(sha256, user, bytes)
    })?;
    Ok(true)
}

/// Takes a content from a user, unless a run of the user names it.
pub(crate) fn take(app: &App, user: i64, sha256: &str) -> Result<Forgotten, ApiError> {
    let forgotten = app.db.remove_input(sha256, user)?;
    if forgotten == Forgotten::Done {
        remove(app, &[sha256.to_owned()])?;
    }
    Ok(forgotten)
}

/// Brings a content into the store, where it is not there yet, and records its user by `record`.
pub(crate) fn keep(
    app: &App,
    sha256: &str,
    bytes: u64,
    put: impl FnOnce() -> Result<(), ApiError>,
    record: impl FnOnce() -> rusqlite::Result<Reserved<()>>,
) -> Result<(), ApiError> {
    let held = app.inputs.hold(sha256);
    if app.store.bytes(&key(sha256))?.is_none() {
        put()?;
    }
    let granted = granted(record()?, bytes);
    if granted.is_err() {
        remove_held(app, &held)?;
    }
    granted
}

/// Removes those of these contents that no user has and no run names.
pub(crate) fn remove(app: &App, contents: &[String]) -> Result<(), ApiError> {
    for sha256 in contents {
        remove_held(app, &app.inputs.hold(sha256))?;
    }
    Ok(())
}

fn remove_held(app: &App, held: &Held) -> Result<(), ApiError> {
    if !app.db.is_needed(&held.sha256)? {
        app.store.delete(&key(&held.sha256))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Eight threads hold one content in turns, and another one is free meanwhile.
    #[test]
    fn one_request_at_a_time_holds_a_content() {
        let (busy, holders) = (Busy::default(), AtomicUsize::new(0));
        let other = busy.hold("other");
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..100 {
                        let held = busy.hold("one");
                        assert_eq!(holders.fetch_add(1, Ordering::SeqCst), 0);
                        std::thread::yield_now();
                        holders.fetch_sub(1, Ordering::SeqCst);
                        drop(held);
                    }
                });
            }
        });
        drop(other);
        assert!(busy.lock().is_empty());
    }
}
