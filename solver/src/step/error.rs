//! Why a run cannot go on.

use glam::DVec3;

use super::Engine;
use crate::state::Particle;
use crate::walls::WallError;

/// Why a run cannot go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// A position or velocity is no longer a number.
    #[error(
        "step {step} (t = {time} s): particle {id} has left the numbers (position {position}, velocity {velocity})\n\
         help: the time step is too large for the contacts that occur, or particles were placed deep inside one another; \
         see the plan for the critical step"
    )]
    NotFinite {
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
        /// Id of the particle.
        id: u32,
        /// Position, m.
        position: DVec3,
        /// Velocity, m/s.
        velocity: DVec3,
    },
    /// Something is beyond a limit of the guard.
    #[error(
        "step {step} (t = {time} s): {what}\n\
         help: {help}"
    )]
    Guarded {
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
        /// Who, where, with whom, how much.
        what: String,
        /// The likely cause, and what to do.
        help: String,
    },
    /// The forces beside the contacts are not those that the state came from.
    #[error("the state does not fit the forces of this run: {0}")]
    Forces(String),
    /// The state comes from a run of another plan.
    #[error(
        "the state does not fit this plan: {0}\n\
         help: go on with the scene that the state was saved from"
    )]
    OtherPlan(String),
    /// A wall cannot take another surface.
    #[error("walls.{wall}: {error}")]
    Wall {
        /// Its name.
        wall: String,
        /// Why.
        error: WallError,
    },
    /// Threads could not be started.
    #[error("the threads cannot be started: {0}")]
    Threads(String),
}

impl Engine {
    /// The first particle whose motion is not a number.
    pub(super) fn not_finite(&self) -> RunError {
        let lost = |record: &Particle| {
            !(record.position.is_finite()
                && record.velocity.is_finite()
                && record.angular_velocity.is_finite())
        };
        let row = self.particles.records.iter().position(lost).unwrap_or(0);
        RunError::NotFinite {
            step: self.step,
            time: self.time(),
            id: self.particles.ids[row].number(),
            position: self.particles.records[row].position,
            velocity: self.particles.records[row].velocity,
        }
    }
}
