//! Exchange of particles: those that come, leave and pass.

use super::{Arrival, Core, Domain, Engine, Exchanged, Leaving, RunError};
use crate::boundaries::{Crossed, Event, OwnGrains, Passage};
use crate::contact::Bridge;
use crate::forces::SharedContacts;
use crate::liquid::BridgeSite;
use crate::state::Particles;

impl Engine {
    /// Counts, removes and inserts particles.
    ///
    /// # Errors
    /// If that was given up; the state is none then.
    pub(super) fn exchange_particles(&mut self) -> Result<(), RunError> {
        let events = self.core.find_passing();
        let Self { core, parts, .. } = self;
        let time = core.time();
        let Core {
            physics,
            domain,
            particles,
            contacts,
            ranks,
            ..
        } = core;
        let Domain {
            cell,
            boundaries,
            walls,
            wall_films,
            ..
        } = domain;
        let mut leaving = |particles: &mut Particles, leavers: &[(u32, bool)]| {
            let mut at = Leaving {
                leavers,
                particles,
                contacts: SharedContacts::new(contacts.as_mut(), ranks.as_mut()),
                wall_films,
                walls,
                physics,
            };
            parts
                .iter_mut()
                .for_each(|part| part.before_leaving(&mut at));
        };
        let mut arrivals = Vec::new();
        let mut brought = |insertion, first, before, particles: &mut Particles| {
            arrivals.push(Arrival {
                insertion,
                rows: first..particles.len(),
                before,
            });
        };
        let changed = boundaries.exchange(
            &events,
            particles,
            &physics.insertions,
            &physics.setting(cell),
            walls,
            time,
            &mut leaving,
            &mut brought,
        );
        core.lists.rows_changed |= changed;
        let exchanged = Exchanged { changed, arrivals };
        self.call(|part, core| part.after_exchange(core, &exchanged));
        if self.threads.task_progress.is_given_up() {
            return Err(RunError::GivenUp);
        }
        Ok(())
    }
}

impl Core {
    /// The grains that cross a plane or leave in this step, of all ranks. If any leaves or may come, all rows are brought up to date.
    fn find_passing(&mut self) -> Vec<Event> {
        let own = OwnGrains {
            rows: self.own_rows(),
            bodies: self.is_first() || !self.is_divided(),
        };
        let (time, physics) = (self.time(), &self.physics);
        let Domain {
            cell, boundaries, ..
        } = &mut self.domain;
        let mut events = boundaries.find(&self.particles, &physics.setting(cell), time, &own);
        let Some(share) = self.ranks.as_mut().filter(|share| share.is_divided()) else {
            return events;
        };
        if boundaries.are_watching(&self.particles) {
            events = Event::of_ranks(&share.ranks().all(Event::encode(&events)));
        }
        if events.iter().any(Event::is_exit) || boundaries.are_inserting(&physics.insertions, time)
        {
            self.complete_rows();
        }
        events
    }

    /// Whether each insertion that waits for space has a place for its next particle now, in the order of the plan.
    #[must_use]
    pub fn have_places(&self) -> Vec<bool> {
        let physics = &self.physics;
        self.domain.boundaries.have_places(
            &self.particles,
            &physics.insertions,
            &physics.setting(&self.domain.cell),
            &self.domain.walls,
            self.time(),
        )
    }

    /// The liquid bridges that are there, in the order of their slots.
    #[must_use]
    pub fn bridges(&self) -> Vec<BridgeSite> {
        self.contacts.memories_of::<Bridge>(&|_| true)
    }

    /// The next step makes new lists: particles were placed anew, or other pairs have contacts.
    pub fn lists_are_stale(&mut self) {
        self.lists.rows_changed = true;
    }

    /// The grains that crossed a flux plane or left since the last call, in the order of time, boundary and id; none where the plan does not
    /// list them.
    pub fn take_passages(&mut self) -> Vec<Passage> {
        self.domain.boundaries.take_passages()
    }

    /// Amounts that crossed the flux planes since the last call: plane by plane, in the order of the plan, each material by
    /// material.
    pub fn take_crossed(&mut self) -> Vec<Crossed> {
        self.domain.boundaries.take_crossed()
    }
}
