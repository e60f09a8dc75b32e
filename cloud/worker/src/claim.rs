//! The head as this attempt holds it.

use anyhow::{Context, Result, bail};
use cloud_api::{Head, Phase};
use cloud_store::{Version, sha256};

use crate::{Attempt, machine};

/// The head and the version that the next swap has to find.
pub(crate) struct Held {
    pub(crate) head: Head,
    version: Version,
    /// Digests of heads whose swaps had no answer: one of them may be the head now.
    unanswered: Vec<String>,
}

/// Result of a swap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Swapped {
    Done,
    /// The run belongs to another attempt.
    Superseded,
}

impl Held {
    /// Takes the epoch: launched becomes running. `None`: it is not to be had (any more).
    pub(crate) fn take(attempt: &Attempt) -> Result<Option<Self>> {
        let Some((head, version)) = read(attempt)? else {
            return Ok(None);
        };
        if head.epoch != attempt.epoch || head.phase != Phase::Launched {
            return Ok(None);
        }
        let mut held = Self {
            head,
            version,
            unanswered: Vec::new(),
        };
        held.head.phase = Phase::Running;
        held.head.machine = machine();
        held.head.core_seconds = 0.0;
        Ok((held.swap(attempt)? == Swapped::Done).then_some(held))
    }

    /// Writes the head, if it is still this attempt's.
    ///
    /// A request that had no answer may have been done all the same, or may be done later. The next call then finds a head
    /// that this attempt has written, and goes on from it.
    pub(crate) fn swap(&mut self, attempt: &Attempt) -> Result<Swapped> {
        let key = attempt.key("head.json");
        self.head.commit += 1;
        let text = serde_json::to_vec_pretty(&self.head)?;
        let digest = sha256(&text);
        // Once more for each head that may turn up; then nothing of ours is on its way any more.
        for _ in 0..=self.unanswered.len() + 1 {
            match attempt.store.swap(&key, Some(&self.version), &text) {
                Ok(Some(version)) => {
                    self.version = version;
                    self.unanswered.clear();
                    return Ok(Swapped::Done);
                }
                Ok(None) => {}
                Err(error) => {
                    if !self.unanswered.contains(&digest) {
                        self.unanswered.push(digest);
                    }
                    return Err(error.into());
                }
            }
            // A run that was deleted is gone.
            let Some((now, version)) = attempt.store.get_versioned(&key)? else {
                return Ok(Swapped::Superseded);
            };
            let found = sha256(&now);
            if found == digest {
                // It was written; only the answer was lost.
                self.version = version;
                self.unanswered.clear();
                return Ok(Swapped::Done);
            }
            if !self.unanswered.contains(&found) {
                let now: Head = serde_json::from_slice(&now)
                    .with_context(|| format!("{key} cannot be read"))?;
                if now.epoch == attempt.epoch && now.phase == Phase::Running {
                    bail!(
                        "{key} of epoch {} was changed by another program",
                        now.epoch
                    );
                }
                return Ok(Swapped::Superseded);
            }
            self.version = version;
        }
        bail!("{key} changes again and again")
    }

    /// Whether the head in the store is still this attempt's.
    pub(crate) fn is_ours(attempt: &Attempt) -> Result<bool> {
        Ok(read(attempt)?.is_some_and(|(head, _)| head.epoch == attempt.epoch))
    }

    /// Adds something that the attempt has to say.
    pub(crate) fn note(&mut self, kind: &str, text: String) {
        let notes = &mut self.head.notes;
        notes.push(cloud_api::Note {
            epoch: self.head.epoch,
            kind: kind.to_owned(),
            text,
        });
        let surplus = notes.len().saturating_sub(cloud_api::head::MOST_NOTES);
        notes.drain(..surplus);
    }
}

fn read(attempt: &Attempt) -> Result<Option<(Head, Version)>> {
    let key = attempt.key("head.json");
    let Some((text, version)) = attempt.store.get_versioned(&key)? else {
        return Ok(None);
    };
    Ok(Some((
        serde_json::from_slice(&text).with_context(|| format!("{key} cannot be read"))?,
        version,
    )))
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::ops::Range;
    use std::sync::Mutex;
    use std::time::Duration;

    use cloud_api::RunId;
    use cloud_store::{Entry, FolderStore, Store, StoreError};

    use super::*;

    /// Result of the next swap.
    #[derive(Clone, Copy, PartialEq)]
    enum Fate {
        Answered,
        /// Done, but the answer is lost.
        Silent,
        /// Not done, and no answer.
        Lost,
    }

    /// A folder that loses answers.
    struct Losing {
        store: FolderStore,
        fates: Mutex<Vec<Fate>>,
    }

    fn lost(key: &str) -> StoreError {
        StoreError::OutOfReach {
            key: key.to_owned(),
            source: std::io::ErrorKind::TimedOut.into(),
        }
    }

    impl Store for Losing {
        fn put(&self, key: &str, bytes: &[u8]) -> cloud_store::Result<()> {
            self.store.put(key, bytes)
        }
        fn put_file(
            &self,
            key: &str,
            file: &mut File,
            range: Range<u64>,
        ) -> cloud_store::Result<String> {
            self.store.put_file(key, file, range)
        }
        fn get(&self, key: &str) -> cloud_store::Result<Option<Vec<u8>>> {
            self.store.get(key)
        }
        fn get_range(&self, key: &str, range: Range<u64>) -> cloud_store::Result<Vec<u8>> {
            self.store.get_range(key, range)
        }
        fn get_into(&self, key: &str, to: &mut File) -> cloud_store::Result<String> {
            self.store.get_into(key, to)
        }
        fn bytes(&self, key: &str) -> cloud_store::Result<Option<u64>> {
            self.store.bytes(key)
        }
        fn list(&self, prefix: &str) -> cloud_store::Result<Vec<Entry>> {
            self.store.list(prefix)
        }
        fn delete(&self, key: &str) -> cloud_store::Result<()> {
            self.store.delete(key)
        }
        fn get_versioned(&self, key: &str) -> cloud_store::Result<Option<(Vec<u8>, Version)>> {
            self.store.get_versioned(key)
        }
        fn swap(
            &self,
            key: &str,
            expected: Option<&Version>,
            new: &[u8],
        ) -> cloud_store::Result<Option<Version>> {
            match self.fates.lock().unwrap().pop().unwrap_or(Fate::Answered) {
                Fate::Answered => self.store.swap(key, expected, new),
                Fate::Silent => {
                    self.store.swap(key, expected, new)?;
                    Err(lost(key))
                }
                Fate::Lost => Err(lost(key)),
            }
        }
    }

    /// Every order of answered, silent and lost swaps leaves the last head that was answered, and never takes the own
    /// head for that of another.
    #[test]
    fn a_swap_without_an_answer_is_found_again() {
        let folder = tempfile::tempdir().unwrap();
        for case in 0..3_usize.pow(4) {
            let fates: Vec<Fate> = (0..4)
                .map(|digit| {
                    [Fate::Answered, Fate::Silent, Fate::Lost][case / 3_usize.pow(digit) % 3]
                })
                .collect();
            let store = Losing {
                store: FolderStore::create(folder.path().join(case.to_string())).unwrap(),
                fates: Mutex::new(Vec::new()),
            };
            let attempt = Attempt {
                disk: None,
                store: &store,
                run: RunId::of([7; 16]),
                epoch: 1,
                scratch: folder.path().to_owned(),
                solver: "solver".into(),
                sandbox: false,
                beat: Duration::from_secs(1),
                commit: Duration::from_secs(1),
                checkpoint: "5m".into(),
                limit: None,
                ranks: None,
                patience: Duration::from_secs(1),
            };
            let launched = Head {
                epoch: 1,
                phase: Phase::Launched,
                ..Head::default()
            };
            let key = attempt.key("head.json");
            store
                .swap(&key, None, &serde_json::to_vec_pretty(&launched).unwrap())
                .unwrap();
            let mut held = Held::take(&attempt).unwrap().unwrap();
            *store.fates.lock().unwrap() = fates;
            let mut step = 0;
            while !store.fates.lock().unwrap().is_empty() {
                step += 1;
                held.head.step = step;
                // Lost answers are errors, and nothing else is.
                let _ = held.swap(&attempt).is_err_and(|error| {
                    assert!(error.is::<StoreError>(), "case {case}: {error:#}");
                    true
                });
            }
            held.head.step = 100;
            assert_eq!(held.swap(&attempt).unwrap(), Swapped::Done, "case {case}");
            let (head, _) = read(&attempt).unwrap().unwrap();
            assert_eq!(head, held.head, "case {case}");
            // Another attempt is another attempt.
            let (now, version) = store.get_versioned(&key).unwrap().unwrap();
            let mut other: Head = serde_json::from_slice(&now).unwrap();
            other.epoch = 2;
            store
                .swap(
                    &key,
                    Some(&version),
                    &serde_json::to_vec_pretty(&other).unwrap(),
                )
                .unwrap();
            assert_eq!(
                held.swap(&attempt).unwrap(),
                Swapped::Superseded,
                "case {case}"
            );
        }
    }
}
