//! A step whose rows are divided among ranks: what of it all ranks do together.

use std::ops::Range;
use std::sync::Arc;

use super::calls::{Beginning, Call};
use super::{Core, Domain, Engine, RunError, Snapshot, StartOptions};
use crate::forces::{FeatureKey, FeatureLoad, OfBlocks, SharedContacts, Watch, block_size};
use crate::physics::ToSetup;
use crate::ranks::{Share, Traffic};
use crate::state::{Particles, Plain};
use crate::sums::{Exact, WORDS};

impl Core {
    /// The rows that this rank computes: all, where there are no other ranks.
    #[must_use]
    pub fn own_rows(&self) -> Range<usize> {
        let rows = self.particles.len();
        let share = self.ranks.as_ref();
        share.map_or(0..rows, |share| share.own_rows(rows))
    }

    /// Whether other ranks compute some of the rows.
    #[must_use]
    pub fn is_divided(&self) -> bool {
        self.ranks.as_ref().is_some_and(Share::is_divided)
    }

    /// Whether this is the rank that finds what concerns no single row.
    #[must_use]
    pub fn is_first(&self) -> bool {
        self.ranks.as_ref().is_none_or(Share::is_first)
    }

    /// The number of ranks, and the messages and bytes that all of them had sent at the last look; `None` where there is one alone.
    #[must_use]
    pub fn traffic(&self) -> Option<(usize, Traffic)> {
        let share = self.ranks.as_ref()?;
        Some((share.place().1, share.total))
    }

    /// The rows of other ranks that contacts and parts of this one read.
    #[must_use]
    pub fn rows_of_others(&self) -> Vec<u32> {
        let share = self.ranks.iter();
        share.flat_map(Share::rows_of_others).collect()
    }

    /// The contacts of all ranks, particles and the domain, all to be changed.
    pub fn lend(&mut self) -> (SharedContacts<'_>, &mut Particles, &mut Domain) {
        let contacts = SharedContacts::new(self.contacts.as_mut(), self.ranks.as_mut());
        (contacts, &mut self.particles, &mut self.domain)
    }

    /// Particles and the domain, to be changed, and the way to other ranks where rows are divided.
    pub fn lend_rows(&mut self) -> (&mut Particles, &mut Domain, Option<&mut Share>) {
        let share = self.ranks.as_mut().filter(|share| share.is_divided());
        (&mut self.particles, &mut self.domain, share)
    }

    /// Brings the events of the contacts of all ranks to each, where a part reads them.
    pub(super) fn join_events(&mut self) {
        if !self.constants.needs.events {
            return;
        }
        if let Some(share) = self.ranks.as_mut().filter(|share| share.is_divided()) {
            self.contacts.join_events(&mut |own| share.to_all(own));
        }
    }

    /// Brings all rows up to date, on every rank.
    pub(super) fn complete_rows(&mut self) {
        if let Some(share) = &mut self.ranks {
            share.complete(&mut self.particles);
        }
    }

    /// Brings up to date the records that contacts and parts of this rank read; all ranks do it.
    pub fn fetch_records(&mut self) {
        if let Some(share) = &mut self.ranks {
            share.fetch_records(&mut self.particles);
        }
    }

    /// Brings up to date the loads on the particles that contacts and parts of this rank read; all ranks do it.
    pub fn fetch_loads(&mut self) {
        if let Some(share) = self.ranks.as_mut().filter(|share| share.is_divided()) {
            share.fetch_loads(&mut self.particles.loads);
        }
    }

    /// The number of this rank among those that divide rows.
    #[must_use]
    pub fn rank(&self) -> usize {
        let share = self.ranks.as_ref().filter(|share| share.is_divided());
        share.map_or(0, |share| share.place().0)
    }

    /// The number of ranks among which rows are divided.
    #[must_use]
    pub fn rank_count(&self) -> usize {
        let share = self.ranks.as_ref().filter(|share| share.is_divided());
        share.map_or(1, |share| share.place().1)
    }

    /// The rank that computes a row.
    #[must_use]
    pub fn rank_of_row(&self, row: u32) -> usize {
        let share = self.ranks.as_ref().filter(|share| share.is_divided());
        share.map_or(0, |share| share.rank_of_row(row))
    }

    /// Adds rows that a part reads in each step, with their orientations, until the next list; all ranks do it. After a list is in place,
    /// [`Core::note_readers`] must follow.
    pub fn read_rows(&mut self, rows: &[u32]) {
        if let Some(share) = &mut self.ranks {
            share.read_beside_contacts(rows);
        }
    }

    /// Sends bytes to each other rank and returns what each has sent here; all ranks do it.
    pub fn exchange_with_ranks(&mut self, out: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        let share = self.ranks.as_mut().filter(|share| share.is_divided());
        share.map_or_else(Vec::new, |share| share.exchange_all(out))
    }

    /// The bytes of all ranks on the first one, nothing on the others; all ranks do it.
    pub fn gather_from_ranks(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        let share = self.ranks.as_mut().filter(|share| share.is_divided());
        share.map_or_else(Vec::new, |share| share.gather(own))
    }

    /// Listed pairs, and those that touch or adhere, of all ranks.
    pub(super) fn count_pairs(&mut self) -> [usize; 2] {
        let count = self.contacts.count();
        let Some(share) = &mut self.ranks else {
            return count;
        };
        let mut sums = count.map(|count| count as i64);
        share.ranks().add(&mut sums);
        sums.map(|sum| sum as usize)
    }

    /// The sums of all ranks.
    pub fn add_exactly<const N: usize>(&mut self, sums: [Exact; N]) -> [Exact; N] {
        let Some(share) = self.ranks.as_mut().filter(|share| share.is_divided()) else {
            return sums;
        };
        let mut words: Vec<i64> = sums.iter().flat_map(Exact::words).collect();
        share.ranks().add(&mut words);
        let mut words = words.as_chunks::<WORDS>().0.iter();
        sums.map(|own| words.next().map_or(own, Exact::of_words))
    }

    /// Puts a list that each rank has of its own rows in place by those of all ranks, in the order of rows.
    pub fn join_ranks<T: Plain>(&mut self, list: &mut Vec<T>) {
        let Some(share) = self.ranks.as_mut().filter(|share| share.is_divided()) else {
            return;
        };
        let mut bytes = Vec::new();
        list.iter().for_each(|one| one.put(&mut bytes));
        share.traffic.messages += 1;
        share.traffic.bytes += bytes.len() as u64;
        let all = share.ranks().all(bytes);
        list.clear();
        for bytes in &all {
            let mut bytes = &bytes[..];
            while !bytes.is_empty()
                && let Ok(one) = T::take(&mut bytes)
            {
                list.push(one);
            }
        }
    }

    /// Brings to the first rank what the blocks of all have.
    pub(super) fn collect_from(&mut self, what: OfBlocks) {
        let Some(share) = self.ranks.as_mut().filter(|share| share.is_divided()) else {
            return;
        };
        let mut bytes = Vec::new();
        self.contacts.put_own(what, &mut bytes);
        let came = share.gather(bytes);
        let cut = share.cut();
        for (rank, bytes) in came.iter().enumerate().skip(1) {
            let blocks = cut[rank]..cut[rank + 1];
            let taken = self.contacts.take_others(what, blocks, &mut &bytes[..]);
            assert_eq!(taken, Ok(()), "all ranks run the same program");
        }
    }

    /// Brings the contacts of all ranks to the first one, which has them until the next step.
    pub fn collect_contacts(&mut self) {
        self.contacts.forget_others();
        self.collect_from(OfBlocks::Contacts);
    }

    /// Brings to the first rank the loads on features of mesh walls that lie in the blocks of all; the others keep theirs.
    pub fn collect_feature_loads(&mut self) {
        self.collect_from(OfBlocks::FeatureLoads);
    }

    /// Moves the loads on features of mesh walls of all ranks to the first one; the others have none then.
    pub fn move_feature_loads(&mut self) {
        self.collect_from(OfBlocks::FeatureLoads);
        if !self.is_first() {
            self.contacts.take_feature_loads();
        }
    }

    /// Loads on features of mesh walls since they were taken last, of all ranks: on the first one, in order; they are removed. All ranks call it.
    pub(super) fn take_feature_loads(&mut self) -> Vec<(FeatureKey, FeatureLoad)> {
        self.collect_from(OfBlocks::FeatureLoads);
        self.contacts.take_feature_loads()
    }

    /// Notes which rows go over to other ranks in each step, after contacts were divided; all ranks do it.
    pub fn note_readers(&mut self) {
        if self.ranks.is_none() {
            return;
        }
        let [listed, _] = self.count_pairs();
        if let Some(share) = &mut self.ranks {
            share.listed = listed;
            share.note_readers(&self.contacts.read_rows());
        }
    }
}

impl Engine {
    /// Divides a state that every rank has as a whole.
    pub(super) fn divide(&mut self) {
        let Core {
            ranks,
            particles,
            contacts,
            ..
        } = &mut self.core;
        let Some(share) = ranks else {
            return;
        };
        let rows = particles.len();
        share.divide(rows, block_size(rows));
        share.with_all(|across| contacts.keep_own(across));
        self.share_parts();
    }

    /// After rows and contacts were divided: parts take their shares, and what ranks read of each other is noted.
    pub(super) fn share_parts(&mut self) {
        if self.is_divided() {
            self.call(|part, core| part.take_share(core));
            self.core.note_readers();
        }
    }

    /// Finds the largest speed of all ranks, and passes on the messages of parts about the last step.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number, or a part cannot go on: the same on all ranks.
    pub(super) fn meet(&mut self) -> Result<(), RunError> {
        let motion = self.clock.motion;
        let is_finite = motion.sum_of_squares.is_finite();
        if !self.is_divided() {
            return match is_finite {
                true => Ok(()),
                false => Err(self.not_finite()),
            };
        }
        let speed = if is_finite { motion.squared_speed } else { 0.0 };
        let [squared_speed, is_lost] = self.meet_with([speed, f64::from(!is_finite)])?;
        self.core.clock.motion.squared_speed = squared_speed;
        if is_lost > 0.0 {
            self.core.complete_rows();
            return Err(self.not_finite());
        }
        Ok(())
    }

    /// Finds the largest of each number of all ranks, and passes on the messages of parts.
    fn meet_with<const N: usize>(&mut self, numbers: [f64; N]) -> Result<[f64; N], RunError> {
        let Self { core, parts, .. } = self;
        let Some(share) = core.ranks.as_mut().filter(|share| share.is_divided()) else {
            return Ok(numbers);
        };
        let messages: Vec<Vec<u8>> = parts.iter_mut().map(|part| part.send_to_ranks()).collect();
        let has_messages = messages.iter().any(|message| !message.is_empty());
        let mut largest = [&[f64::from(has_messages)], &numbers[..]].concat();
        share.ranks().largest(&mut largest);
        if largest[0] > 0.0 {
            let mut bytes = Vec::new();
            messages.put(&mut bytes);
            let all = share.ranks().all(bytes);
            let of_rank = |bytes: &Vec<u8>| <Vec<Vec<u8>>>::take(&mut &bytes[..]);
            let all: Vec<Vec<Vec<u8>>> =
                all.iter().filter_map(|bytes| of_rank(bytes).ok()).collect();
            for (number, part) in parts.iter_mut().enumerate() {
                let of_part = all
                    .iter()
                    .filter_map(|of_rank| of_rank.get(number).cloned());
                let of_part: Vec<Vec<u8>> = of_part.collect();
                if of_part.iter().any(|message| !message.is_empty()) {
                    part.receive_from_ranks(core, &of_part)?;
                }
            }
        }
        let mut result = numbers;
        result.copy_from_slice(&largest[1..]);
        Ok(result)
    }

    /// The end of some steps that were made at once.
    pub(super) fn end_steps(&mut self, watch: Option<Watch>) -> Result<(), RunError> {
        if !self.is_divided() {
            return Ok(());
        }
        self.meet_with([])?;
        if watch.is_some() {
            // Else the first rank has them already.
            if !self.constants.needs.sums {
                self.collect_from(OfBlocks::Observations);
            }
            self.call(|part, core| part.collect_from_ranks(core));
        }
        Ok(())
    }

    /// Whether the motion of any rank is lost, and then its rows for the message.
    ///
    /// # Errors
    /// If so.
    pub(super) fn check_motion(&mut self, is_finite: bool) -> Result<(), RunError> {
        let [is_lost] = self.meet_with([f64::from(!is_finite)])?;
        if is_lost > 0.0 {
            self.core.complete_rows();
            return Err(self.not_finite());
        }
        Ok(())
    }

    /// Brings all rows up to date on the first rank, and on request all contacts, for a checkpoint.
    pub fn collect(&mut self, contacts: bool) {
        self.lead(Call::Collect { contacts });
        self.collect_here(contacts);
    }

    /// The part of this rank.
    pub(super) fn collect_here(&mut self, contacts: bool) {
        if !self.is_divided() {
            return;
        }
        let Core {
            ranks, particles, ..
        } = &mut self.core;
        if let Some(share) = ranks {
            share.collect(particles);
        }
        if contacts {
            self.core.collect_contacts();
        }
        self.call(|part, core| part.collect_from_ranks(core));
    }

    /// On the first rank: lets the others make a call.
    pub(super) fn lead(&mut self, call: Call) {
        if let Some(share) = self.core.ranks.as_mut().filter(|share| share.is_first()) {
            let mut bytes = Vec::new();
            call.put(&mut bytes);
            share.ranks().broadcast(bytes);
        }
    }

    /// On the first rank: lets the others begin.
    pub(super) fn lead_beginning(
        options: &mut StartOptions,
        beginning: impl FnOnce() -> Beginning,
    ) {
        if let Some(share) = options.ranks.as_mut().filter(|share| share.is_first()) {
            let mut bytes = Vec::new();
            beginning().put(&mut bytes);
            share.ranks().broadcast(bytes);
        }
    }

    /// On a rank that is not the first: makes what the first one makes, until that has ended. `setup` and `options` are those of the first one. The
    /// grains of the start are dropped as soon as the particles are made of them, if nothing else holds the physics.
    ///
    /// # Errors
    /// Why the run could not begin, which the first rank finds likewise. Later errors are those of the first rank alone.
    pub fn follow(setup: impl ToSetup, mut options: StartOptions) -> Result<(), RunError> {
        let Some(share) = &mut options.ranks else {
            return Ok(());
        };
        let bytes = share.ranks().broadcast(Vec::new());
        let mut engine = match Beginning::take(&mut &bytes[..]) {
            Ok(Beginning::Start { records }) => {
                let mut engine = Self::unstarted(setup.to_setup(), options)?;
                drop(setup);
                if let Some(physics) = Arc::get_mut(&mut engine.core.physics) {
                    physics.forget_grains();
                }
                engine.started(records)?
            }
            Ok(Beginning::Resume(state)) => {
                let snapshot = Snapshot::decode(&state).map_err(|error| RunError::OtherState {
                    section: "start".to_owned(),
                    reason: error.to_string(),
                })?;
                let mut own = setup.to_setup();
                drop(setup);
                if let Some(physics) = Arc::get_mut(&mut own.physics) {
                    physics.forget_grains();
                }
                Self::resume(own, snapshot, options)?
            }
            _ => {
                share.note_end();
                return Ok(());
            }
        };
        loop {
            let Some(share) = &mut engine.core.ranks else {
                return Ok(());
            };
            let bytes = share.ranks().broadcast(Vec::new());
            // Errors are the same on all ranks, and the first one reports them.
            match Call::take(&mut &bytes[..]) {
                Ok(Call::Steps { count, watch }) => drop(engine.steps_here(count, watch)),
                Ok(Call::CompleteStep) => drop(engine.complete_step_here()),
                Ok(Call::Collect { contacts }) => engine.collect_here(contacts),
                Ok(Call::TakeFeatureLoads) => drop(engine.core.take_feature_loads()),
                _ => {
                    share.note_end();
                    return Ok(());
                }
            }
        }
    }

    /// Loads on features of mesh walls since they were taken last, in order; they are removed.
    pub(crate) fn take_feature_loads(&mut self) -> Vec<(FeatureKey, FeatureLoad)> {
        self.lead(Call::TakeFeatureLoads);
        self.core.take_feature_loads()
    }

    /// The loads on all pebbles, on every rank.
    pub(super) fn complete_pebbles(&mut self) {
        let Core {
            ranks, particles, ..
        } = &mut self.core;
        if let Some(share) = ranks {
            share.complete_pebbles(particles);
        }
    }
}
