//! Wrong passwords: they delay the next try of the same address and name.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Tries to log in without a delay.
const FREE_TRIES: u32 = 3;

/// The longest delay of a try, in s.
const LONGEST_DELAY: u64 = 900;

/// How long a wrong try is remembered.
const REMEMBERED: Duration = Duration::from_secs(3600);

/// The most names and addresses of which wrong tries are remembered.
const MOST_REMEMBERED: usize = 10_000;

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

    /// Takes a try back that was not made.
    pub(crate) fn take_back(&self, address: IpAddr, name: &str) {
        if let Some(wrong) = self.lock().get_mut(&(address, name.to_owned())) {
            wrong.count = wrong.count.saturating_sub(1);
        }
    }

    /// Forgets the wrong tries of a user after a login.
    pub(crate) fn forget(&self, address: IpAddr, name: &str) {
        self.lock().remove(&(address, name.to_owned()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_tries_delay_the_next_ones_of_the_same_address() {
        let tries = Tries::default();
        let (here, elsewhere) = (IpAddr::from([127, 0, 0, 1]), IpAddr::from([127, 0, 0, 2]));
        for _ in 0..3 {
            assert_eq!(tries.begin(here, "ada"), Ok(()));
        }
        tries.take_back(here, "ada");
        assert_eq!(tries.begin(here, "ada"), Ok(()));
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
