//! The head as this attempt holds it.

use anyhow::{Context, Result, bail};
use cloud_api::{Head, Phase};
use cloud_store::Version;

use crate::{Attempt, machine};

/// The head and the version that the next swap has to find.
pub(crate) struct Held {
    pub(crate) head: Head,
    version: Version,
}

/// What a swap came to.
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
        let mut held = Self { head, version };
        held.head.phase = Phase::Running;
        held.head.machine = machine();
        held.head.core_seconds = 0.0;
        Ok((held.swap(attempt)? == Swapped::Done).then_some(held))
    }

    /// Writes the head, if it is still this attempt's.
    pub(crate) fn swap(&mut self, attempt: &Attempt) -> Result<Swapped> {
        self.head.commit += 1;
        let text = serde_json::to_vec_pretty(&self.head)?;
        if let Some(version) =
            attempt
                .store
                .swap(&attempt.key("head.json"), Some(&self.version), &text)?
        {
            self.version = version;
            return Ok(Swapped::Done);
        }
        // A run that was deleted is gone.
        let Some((now, version)) = read(attempt)? else {
            return Ok(Swapped::Superseded);
        };
        if now == self.head {
            // It was written; only the answer was lost.
            self.version = version;
            return Ok(Swapped::Done);
        }
        if now.epoch == attempt.epoch && now.phase == Phase::Running {
            bail!(
                "head.json of epoch {} was changed by another program",
                now.epoch
            );
        }
        Ok(Swapped::Superseded)
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
