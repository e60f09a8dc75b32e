//! Turns: how many things of a kind happen at once, for each user and in all.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::access::ApiError;

/// Turns of one kind of work. A user who takes all of theirs leaves those of others.
pub(crate) struct Turns {
    all: Arc<Semaphore>,
    most_each: usize,
    /// By user, and whether it is a link to one run.
    each: Mutex<HashMap<(i64, bool), Arc<Semaphore>>>,
}

/// A turn, until it is dropped.
pub(crate) struct Turn(#[expect(dead_code)] [OwnedSemaphorePermit; 2]);

impl Turns {
    /// So many turns at once in all, and for each user.
    pub(crate) fn new(all: usize, each: usize) -> Self {
        Self {
            all: Arc::new(Semaphore::new(all)),
            most_each: each,
            each: Mutex::default(),
        }
    }

    /// Waits for a turn, in the order of the requests. `link`: of a link to a run of this user.
    pub(crate) async fn take(&self, user: i64, link: bool) -> Result<Turn, ApiError> {
        let own = {
            let mut each = self
                .each
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner());
            // Each turn, and each wait for one, holds the semaphore.
            each.retain(|_, turns| Arc::strong_count(turns) > 1);
            let turns = each
                .entry((user, link))
                .or_insert_with(|| Arc::new(Semaphore::new(self.most_each)));
            Arc::clone(turns)
        };
        let own = own.acquire_owned().await.map_err(ApiError::internal)?;
        let all = Arc::clone(&self.all).acquire_owned().await;
        Ok(Turn([own, all.map_err(ApiError::internal)?]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_user_takes_no_turn_of_another() {
        let turns = Turns::new(3, 2);
        let (first, _second) = (turns.take(1, false).await, turns.take(1, false).await);
        let soon = std::time::Duration::from_millis(20);
        let third = tokio::time::timeout(soon, turns.take(1, false)).await;
        assert!(third.is_err(), "the third turn of a user");
        let other = tokio::time::timeout(soon, turns.take(2, false)).await;
        let _other = other.expect("a turn of another user");
        let link = tokio::time::timeout(soon, turns.take(1, true)).await;
        assert!(link.is_err(), "the fourth turn of all");
        drop(first);
        let link = tokio::time::timeout(soon, turns.take(1, true)).await;
        assert!(link.is_ok(), "a turn that was given back");
    }
}
