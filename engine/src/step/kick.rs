//! Kicks and drifts of all particles and bodies between two force evaluations.

use rayon::prelude::*;

use super::calls::Call;
use super::motion::{KickDrift, turn_orientations};
use super::{Core, Engine, RunError};
use crate::bodies::BodyStep;
use crate::forces::{MotionBound, block_size};
use crate::state::{Particle, Particles};

impl Engine {
    /// Makes the second half kick if it is still due, so that positions, velocities and forces belong to the same time.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn complete_step(&mut self) -> Result<(), RunError> {
        self.lead(Call::CompleteStep);
        self.complete_step_here()
    }

    /// The part of this rank; the first one gets the state of all rows.
    pub(super) fn complete_step_here(&mut self) -> Result<(), RunError> {
        if std::mem::take(&mut self.core.clock.kick_due) {
            let is_finite = self.advance(1, 0.0).sum_of_squares.is_finite();
            self.check_motion(is_finite)?;
            self.try_call(|part, core| part.advance(core, 1, 0.0))?;
        }
        self.collect_here(false);
        Ok(())
    }
}

impl Core {
    /// Kicks and drift of the particles of this rank, unless they were made with the forces of the last step. Returns the half kicks that
    /// sheets get, whose part of the kicks is never made ahead.
    pub(super) fn begin_step(&mut self) -> u32 {
        let kicks = 1 + u32::from(self.clock.kick_due || self.clock.drifted.is_some());
        self.clock.motion = match self.clock.drifted.take() {
            Some(motion) => motion,
            None => self.kick_and_drift(),
        };
        if let Some(share) = &mut self.ranks {
            share.note_motion();
        }
        kicks
    }

    /// First half kick and drift, with the second half kick of the step before if it is still due.
    fn kick_and_drift(&mut self) -> MotionBound {
        let kicks = if std::mem::take(&mut self.clock.kick_due) {
            2
        } else {
            1
        };
        let drift = self.physics.time_step;
        let fastest = self.advance(kicks, drift);
        self.turn_orientations(drift);
        fastest
    }

    /// `kicks` half kicks, then a drift of `drift` seconds.
    fn advance(&mut self, kicks: u32, drift: f64) -> MotionBound {
        let pass = self.kick_drift(kicks, drift);
        let special = self.hold_prescribed();
        let size = block_size(self.particles.len());
        let own = self.own_rows();
        let records = &mut self.particles.records[own.clone()];
        let loads = &self.particles.loads[own];
        let fastest = match &self.threads.pool {
            Some(pool) if records.len() > size => pool.install(|| {
                let chunks = records.par_chunks_mut(size).zip(loads.par_chunks(size));
                chunks
                    .map(|(records, loads)| pass.run(records, loads))
                    .reduce(MotionBound::default, MotionBound::merge)
            }),
            _ => pass.run(records, loads),
        };
        let prescribed = self.release_prescribed(special, drift);
        fastest
            .merge(prescribed)
            .merge(self.advance_bodies(kicks, drift))
    }

    /// Advances the bodies, whose pebbles the pass over the particles leaves alone.
    pub(super) fn advance_bodies(&mut self, kicks: u32, drift: f64) -> MotionBound {
        let Particles {
            records, bodies, ..
        } = &mut self.particles;
        let Some(bodies) = bodies else {
            return MotionBound::default();
        };
        let step = BodyStep {
            half: 0.5 * self.physics.time_step,
            drift,
            kicks,
            gravity: self.physics.gravity,
        };
        bodies.advance(records, &step, self.threads.pool.as_deref())
    }

    pub(super) fn kick_drift(&self, kicks: u32, drift: f64) -> KickDrift {
        KickDrift {
            half: 0.5 * self.physics.time_step,
            drift,
            kicks,
            gravity: self.physics.gravity,
            inverse_inertia: self.constants.inverse_inertia,
            turns: self.constants.turns,
            width: self.constants.width,
        }
    }

    /// Remembers where prescribed particles stand before a pass that ignores what is prescribed.
    fn hold_prescribed(&self) -> Vec<Particle> {
        let own = self.own_rows();
        let rows = (self.particles.prescribed.iter()).map(|prescribed| prescribed.row.index());
        let own = rows.filter(|row| own.contains(row));
        own.map(|row| self.particles.records[row]).collect()
    }

    /// Puts the prescribed components back and drifts them with their prescribed velocity. Returns the motion
    /// of these particles, which the pass did not see: a kick may have cancelled what is prescribed.
    fn release_prescribed(&mut self, before: Vec<Particle>, drift: f64) -> MotionBound {
        let mut fastest = MotionBound::default();
        let own = self.own_rows();
        let prescribed = self.particles.prescribed.iter();
        let prescribed = prescribed.filter(|prescribed| own.contains(&prescribed.row.index()));
        for (prescribed, before) in prescribed.zip(before) {
            let record = &mut self.particles.records[prescribed.row.index()];
            for axis in 0..3 {
                if let Some(velocity) = prescribed.velocity[axis] {
                    record.velocity[axis] = velocity;
                    record.position[axis] = before.position[axis] + velocity * drift;
                }
                if let Some(spin) = prescribed.angular_velocity[axis] {
                    record.angular_velocity[axis] = spin;
                }
            }
            fastest = fastest.merge(MotionBound::of(record));
        }
        fastest
    }

    /// Turns the orientations by the angular velocities over `drift` seconds.
    fn turn_orientations(&mut self, drift: f64) {
        let own = self.own_rows();
        if let Some(orientations) = &mut self.particles.orientations {
            turn_orientations(
                &mut orientations[own.clone()],
                &self.particles.records[own],
                drift,
                self.constants.width,
            );
        }
    }
}
