//! What comes, what goes and what passes.

use super::tracks::mark_inserted;
use super::{Engine, RunError};
use crate::boundaries::Crossed;
use crate::forces::Bond;
use crate::liquid::{EVAPORATES_EVERY, LiquidRow, Surroundings};
use crate::spray::Sprays;
use crate::state::Particles;

impl Engine {
    /// Counts, removes and inserts particles.
    ///
    /// # Errors
    /// If that was given up; the state is none then.
    pub(super) fn exchange_particles(&mut self) -> Result<(), RunError> {
        let time = self.time();
        let around = Surroundings {
            laws: self.plan.physics().laws(),
            walls: &self.walls,
        };
        let (liquid, contacts) = (&mut self.liquid, &mut self.forces.contacts);
        let mut leaving = |particles: &mut Particles, leavers: &[(u32, bool)]| {
            if let Some(liquid) = liquid {
                liquid.release(leavers, contacts.as_mut(), particles, &around);
            }
        };
        let output = self.plan.outputs().files();
        let mut first_new = None;
        let mut brought = |insertion, first, before, particles: &mut Particles| {
            first_new.get_or_insert(first);
            if let Some(track) = output.track_of(insertion) {
                mark_inserted(particles, first, before, track, output.track_every);
            }
        };
        let changed = self.boundaries.exchange(
            &mut self.particles,
            self.plan.physics().insertions(),
            &self.plan.physics().setting(),
            &self.images,
            &self.walls,
            time,
            &mut leaving,
            &mut brought,
        );
        if let (Some(first), Some(liquid)) = (first_new, &mut self.liquid) {
            liquid.note_inserted(first, &mut self.particles);
        }
        self.lists.rows_changed |= changed;
        if changed && self.plan.physics().energy_budget() {
            self.note_leavers();
        }
        if self.stage.is_given_up() {
            return Err(RunError::GivenUp);
        }
        Ok(())
    }

    /// Whether each insertion that waits for space has a place for its next particle now, in the order of the plan.
    #[must_use]
    pub fn have_places(&self) -> Vec<bool> {
        let physics = self.plan.physics();
        self.boundaries.have_places(
            &self.particles,
            physics.insertions(),
            &physics.setting(),
            &self.walls,
            self.time(),
        )
    }

    /// Answers the events of the last contacts, if there is liquid that they move.
    pub(super) fn move_liquid(&mut self) {
        let Some(liquid) = &mut self.liquid else {
            return;
        };
        let contacts = self.forces.contacts.as_mut();
        let events = contacts.take_events();
        let around = Surroundings {
            laws: self.plan.physics().laws(),
            walls: &self.walls,
        };
        liquid.answer(events, contacts, &mut self.particles, &around);
        if self.step > 0 && self.step.is_multiple_of(EVAPORATES_EVERY) {
            let time = EVAPORATES_EVERY as f64 * self.plan.physics().time_step();
            liquid.evaporate(time, contacts, &mut self.particles, &around);
        }
    }

    /// The balance of liquid begins with what is there now.
    pub(super) fn note_first_liquid(&mut self) {
        if let Some(liquid) = &mut self.liquid {
            liquid.note_first(self.forces.contacts.as_ref(), &mut self.particles);
        }
    }

    /// Where the liquid is, in scenes that have any.
    #[must_use]
    pub fn liquid(&self) -> Option<LiquidRow> {
        let liquid = self.liquid.as_ref()?;
        let sprayed = (self.sprays.as_ref()).map_or([0.0; 5], Sprays::volumes);
        let contacts = self.forces.contacts.as_ref();
        Some(liquid.row(&self.particles, contacts, sprayed))
    }

    /// The liquid bridges that are there, in the order of their slots.
    #[must_use]
    pub fn bonds(&self) -> Vec<Bond> {
        self.forces.contacts.bonds(&|_| true)
    }

    /// Particles were placed anew from outside: the next step makes new lists.
    #[cfg(test)]
    pub(super) fn lists_are_stale(&mut self) {
        self.lists.rows_changed = true;
    }

    /// What crossed the flux planes since the last call: plane by plane, in the order of the plan, each material by material.
    pub fn take_crossed(&mut self) -> Vec<Crossed> {
        self.boundaries.take_crossed()
    }
}
