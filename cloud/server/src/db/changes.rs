//! Changes of runs: each is one transaction that writes the row and an event.

use cloud_api::Head;
use cloud_api::RunState;
use cloud_api::answers::EventRow;
use cloud_api::lifecycle::{self, Illegal, Run, RunEvent};
use cloud_engine::Engine;
use rusqlite::{OptionalExtension, Transaction, params};
use serde_json::{Value, json};

use crate::prices::Cost;

use super::contents::{Forgotten, forget_input};
use super::events::add_event;
use super::hooks::add_end;
use super::rows::{run_of, state_of, wish_word};
use super::{Db, Reserved, Result, now};

/// A further revision of a run, on the same data.
pub(crate) struct Extension<'a> {
    /// The revision that it follows.
    pub(crate) after: u32,
    pub(crate) spec: &'a str,
    pub(crate) of_steps: Option<u64>,
    /// As that of a new run.
    pub(crate) reserved: u64,
}

/// Result of [`Db::apply`] and [`Db::extend`].
pub(crate) enum Applied {
    Done(Run, Vec<EventRow>),
    Missing,
    Illegal(Illegal),
}

impl Db {
    /// Records what happened to a run: the row and an event, in one transaction.
    pub(crate) fn apply(
        &self,
        id: &str,
        event: &RunEvent,
        head: Option<&Head>,
        engine: &dyn Engine,
    ) -> Result<Applied> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let applied = self.apply_in(&transaction, id, event, head, engine)?;
        if matches!(applied, Applied::Done(..)) {
            transaction.commit()?;
        }
        Ok(applied)
    }

    /// Records [`RunEvent::Extend`] with a further spec, if the run has the revision that this one follows. `None`: it has another.
    pub(crate) fn extend(
        &self,
        id: &str,
        extension: &Extension,
        engine: &dyn Engine,
    ) -> Result<Reserved<Option<Applied>>> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let applied = self.apply_in(&transaction, id, &RunEvent::Extend, None, engine)?;
        let Applied::Done(after, _) = &applied else {
            return Ok(Reserved::Done(Some(applied)));
        };
        if after.revision != extension.after + 1 {
            return Ok(Reserved::Done(None));
        }
        transaction.execute(
            "UPDATE runs SET spec=?2, of_steps=?3, reserved=?4 WHERE id=?1",
            params![
                id,
                extension.spec,
                extension.of_steps.map(|steps| steps as i64),
                extension.reserved as i64
            ],
        )?;
        let owner =
            transaction.query_row("SELECT owner FROM runs WHERE id=?1", [id], |row| row.get(0))?;
        if let Some(usage) = self.beyond(&transaction, owner)? {
            return Ok(Reserved::Full(usage));
        }
        transaction.commit()?;
        Ok(Reserved::Done(Some(applied)))
    }

    /// Records [`RunEvent::Resume`], and another number of ranks if that is given.
    pub(crate) fn resume(
        &self,
        id: &str,
        ranks: Option<u32>,
        engine: &dyn Engine,
    ) -> Result<Applied> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let applied = self.apply_in(&transaction, id, &RunEvent::Resume, None, engine)?;
        if matches!(applied, Applied::Done(..)) {
            let record = "UPDATE runs SET ranks = coalesce(?2, ranks) WHERE id = ?1";
            transaction.execute(record, params![id, ranks])?;
            transaction.commit()?;
        }
        Ok(applied)
    }

    /// Stops a run because of a limit, with a sentence that says which.
    pub(crate) fn stop_for(&self, id: &str, why: &str, engine: &dyn Engine) -> Result<Applied> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let applied = self.apply_in(&transaction, id, &RunEvent::Stop, None, engine)?;
        if matches!(applied, Applied::Done(..)) {
            let record = "UPDATE runs SET stopped_by = ?2, message = ?2 WHERE id = ?1";
            transaction.execute(record, params![id, why])?;
            transaction.commit()?;
        }
        Ok(applied)
    }

    fn apply_in(
        &self,
        transaction: &Transaction,
        id: &str,
        event: &RunEvent,
        head: Option<&Head>,
        engine: &dyn Engine,
    ) -> Result<Applied> {
        let Some(before) = transaction
            .query_row("SELECT * FROM runs WHERE id = ?1", [id], run_of)
            .optional()?
        else {
            return Ok(Applied::Missing);
        };
        let after = match lifecycle::apply(&before, event, &self.policy, now()) {
            Ok(after) => after,
            Err(illegal) => return Ok(Applied::Illegal(illegal)),
        };
        transaction.execute(
            "UPDATE runs SET state=?2, wish=?3, epoch=?4, revision=?5, submitted=?6, step=?7, barren=?8, not_before=?9, changed=?10
             WHERE id=?1",
            params![
                id,
                after.state.word(),
                wish_word(after.wish),
                after.epoch as i64,
                after.revision,
                after.submitted,
                after.step as i64,
                after.barren,
                after.not_before,
                now(),
            ],
        )?;
        let mut events = Vec::new();
        match event {
            RunEvent::Launched => {
                transaction.execute(
                    "INSERT INTO attempts VALUES (?1, ?2, ?3, ?4, NULL, NULL, NULL, '', '', NULL, 0, ?5, NULL, NULL)",
                    params![id, after.epoch as i64, engine.name(), now(), engine.queue(before.barren)],
                )?;
                events.push(add_event(
                    transaction,
                    id,
                    "attempt",
                    json!({"epoch": after.epoch, "began": true}),
                )?);
            }
            RunEvent::Ended(ending, step) => {
                let cause = serde_json::to_value(ending.cause).ok();
                let cause = cause.as_ref().and_then(Value::as_str);
                let machine = head.map_or("", |head| head.machine.as_str());
                let seconds = head
                    .filter(|head| head.epoch == before.epoch)
                    .map_or(0.0, |head| head.core_seconds);
                // By the price of today: a later one changes no cost of the past.
                let cost = (self.prices.as_ref()).map_or(Cost::default(), |prices| {
                    prices.cost(engine.queue(before.barren), seconds)
                });
                transaction.execute(
                    "UPDATE attempts SET ended=?3, cause=?4, code=?5, message=?6, machine=?7, step=?8, core_seconds=max(core_seconds, ?9), cost=?10, saved=?11
                     WHERE run=?1 AND epoch=?2",
                    params![id, before.epoch as i64, now(), cause, ending.code, ending.message, machine, *step as i64, seconds, cost.spent, cost.saved],
                )?;
                transaction.execute(
                    "UPDATE runs SET cause=?2, message=CASE WHEN ?2 = 'user' THEN coalesce(stopped_by, ?3) ELSE ?3 END,
                       core_seconds=(SELECT coalesce(sum(core_seconds), 0) FROM attempts WHERE run=?1),
                       cost=(SELECT sum(cost) FROM attempts WHERE run=?1), saved=(SELECT sum(saved) FROM attempts WHERE run=?1)
                     WHERE id=?1",
                    params![id, cause, ending.message],
                )?;
                let data = json!({"epoch": before.epoch, "cause": cause, "code": ending.code, "message": ending.message});
                events.push(add_event(transaction, id, "attempt", data)?);
            }
            RunEvent::Resume | RunEvent::Extend => {
                transaction.execute(
                    "UPDATE runs SET cause=NULL, message='', results=NULL, stopped_by=NULL, core_seconds_before=core_seconds WHERE id=?1",
                    [id],
                )?;
            }
            _ => {}
        }
        if let Some(head) = head {
            transaction.execute(
                "UPDATE runs SET of_steps=coalesce(?2, of_steps), time=?3, bytes=?4 WHERE id=?1",
                params![
                    id,
                    head.of_steps.map(|steps| steps as i64),
                    head.time,
                    head.bytes() as i64
                ],
            )?;
        }
        if after.state != before.state {
            events.push(add_event(
                transaction,
                id,
                "state",
                json!({"state": after.state}),
            )?);
            if !after.state.is_live() {
                add_end(transaction, id, after.state.word())?;
            }
        }
        Ok(Applied::Done(after, events))
    }

    /// Forgets a run that is not live with all that belongs to it, also the inputs of its owner that no other run of the owner names.
    pub(crate) fn delete(&self, id: &str) -> Result<Deleted> {
        let mut connection = self.lock();
        let transaction = connection.transaction()?;
        let run = "SELECT owner, state FROM runs WHERE id = ?1";
        let run: Option<(i64, RunState)> = transaction
            .query_row(run, [id], |row| Ok((row.get(0)?, state_of(row)?)))
            .optional()?;
        let owner = match run {
            None => return Ok(Deleted::Missing),
            // Also one that was resumed since the user looked at it.
            Some((_, state)) if state.is_live() => return Ok(Deleted::Live),
            Some((owner, _)) => owner,
        };
        let named = {
            let mut query = transaction.prepare("SELECT sha256 FROM run_inputs WHERE run = ?1")?;
            let rows = query.query_map([id], |row| row.get(0))?;
            rows.collect::<Result<Vec<String>>>()?
        };
        // What a user has spent stays spent.
        transaction.execute(
            "UPDATE users SET removed_core_seconds = removed_core_seconds + (SELECT coalesce(sum(core_seconds), 0) FROM attempts WHERE run = ?1)
             WHERE id = ?2",
            params![id, owner],
        )?;
        for (table, column) in [
            ("runs", "id"),
            ("attempts", "run"),
            ("events", "run"),
            ("secrets", "run"),
            ("run_inputs", "run"),
        ] {
            let remove = format!("DELETE FROM {table} WHERE {column} = ?1");
            transaction.execute(&remove, [id])?;
        }
        let mut forgotten = Vec::new();
        for sha256 in named {
            if forget_input(&transaction, &sha256, owner)? == Forgotten::Done {
                forgotten.push(sha256);
            }
        }
        transaction.commit()?;
        Ok(Deleted::Done(forgotten))
    }
}

/// Result of [`Db::delete`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Deleted {
    /// With the inputs that the owner does not have any more.
    Done(Vec<String>),
    Missing,
    /// Nothing was changed: the run is queued, or has an attempt.
    Live,
}
