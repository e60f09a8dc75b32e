//! Turns: how many things of a kind happen at once, for each user or address, and in all.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::access::ApiError;

/// Seconds after which a request that was refused may be sent again.
const RETRY: u64 = 5;

/// A user, and whether it is a link to one run of that user.
pub(crate) type OfUser = (i64, bool);

/// Turns of one kind of work. A user that takes all of its turns leaves those of others.
pub(crate) struct Turns<K = OfUser> {
    all: Arc<Semaphore>,
    most_each: usize,
    /// The most turns of one, with those that are waited for.
    most_waiting: usize,
    each: Mutex<HashMap<K, Arc<Semaphore>>>,
}

/// A turn, until it is dropped.
pub(crate) struct Turn(#[expect(dead_code)] [OwnedSemaphorePermit; 2]);

impl<K: Eq + Hash> Turns<K> {
    /// So many turns at once in all, and for each one.
    pub(crate) fn new(all: usize, each: usize) -> Self {
        Self {
            all: Arc::new(Semaphore::new(all)),
            most_each: each,
            most_waiting: usize::MAX,
            each: Mutex::default(),
        }
    }

    /// With at most so many that wait, for each one.
    pub(crate) fn with_waiting(self, waiting: usize) -> Self {
        Self {
            most_waiting: self.most_each + waiting,
            ..self
        }
    }

    /// Waits for a turn, in the order of the requests. Refused where too many wait already.
    pub(crate) async fn take(&self, of: K) -> Result<Turn, ApiError> {
        let own = {
            let mut each = self
                .each
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner());
            // Each turn, and each wait for one, holds the semaphore.
            each.retain(|_, turns| Arc::strong_count(turns) > 1);
            let turns = each
                .entry(of)
                .or_insert_with(|| Arc::new(Semaphore::new(self.most_each)));
            if Arc::strong_count(turns) > self.most_waiting {
                return Err(ApiError::too_many(
                    "too many requests",
                    "Earlier requests of this kind have not ended. Try again.",
                    RETRY,
                ));
            }
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

    const SOON: std::time::Duration = std::time::Duration::from_millis(20);

    #[tokio::test]
    async fn a_user_takes_no_turn_of_another() {
        let turns = Turns::new(3, 2);
        let take = |user, link| tokio::time::timeout(SOON, turns.take((user, link)));
        let (first, _second) = (take(1, false).await.unwrap(), take(1, false).await.unwrap());
        assert!(take(1, false).await.is_err(), "the third turn of a user");
        let _other = take(2, false).await.expect("a turn of another user");
        assert!(take(1, true).await.is_err(), "the fourth turn of all");
        drop(first);
        assert!(take(1, true).await.is_ok(), "a turn that was given back");
    }

    #[tokio::test]
    async fn few_wait_for_a_turn() {
        let turns = Turns::new(2, 1).with_waiting(1);
        let first = turns.take("here").await.unwrap();
        let mut second = std::pin::pin!(turns.take("here"));
        let waits = tokio::time::timeout(SOON, &mut second).await;
        assert!(waits.is_err(), "the second one waits");
        let third = tokio::time::timeout(SOON, turns.take("here")).await;
        assert!(third.expect("the third one does not wait").is_err());
        let other = tokio::time::timeout(SOON, turns.take("elsewhere")).await;
        assert!(other.expect("a turn of another address").is_ok());
        drop(first);
        assert!(second.await.is_ok());
    }
}
