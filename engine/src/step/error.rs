//! Why a run cannot go on.

use glam::DVec3;
use mercury_common::readable::rounded;

use super::Core;
use crate::contact::parameter::short;
use crate::spray::TooMany;
use crate::state::Particle;
use crate::walls::WallError;

/// Why a run cannot go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// A position or velocity is no longer a number.
    #[error(
        "step {step} (t = {} s): particle {id} is no longer finite (position {}, velocity {}, angular velocity {})\n\
         help: the time step is too large for the contacts that occur, or particles were placed deep inside one another; \
         see the plan for the critical step",
        rounded(*.time, 12), point(.position), point(.velocity), point(.angular_velocity)
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
        /// Angular velocity, rad/s.
        angular_velocity: DVec3,
    },
    /// Something is beyond a limit of the guard.
    #[error(
        "step {step} (t = {} s): {what}\n\
         help: {help}",
        rounded(*.time, 12)
    )]
    Guarded {
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
        /// Which particle, where, with which partner, how much.
        what: String,
        /// The likely cause, and what to do.
        help: String,
    },
    /// More droplets are in flight than a spray allows.
    #[error(
        "t = {} s: {error}\n\
         help: raise `max_droplets` of the spray if the memory allows it (88 bytes each), and go on with --resume; or spray less, or let walls or the domain take the droplets",
        rounded(*.time, 12)
    )]
    Droplets {
        /// Time, s.
        time: f64,
        /// Which spray, and its limit.
        error: TooMany,
    },
    /// A part of the step does not work where several ranks compute a scene.
    #[error(
        "`{what}` does not work on several ranks yet\n\
         help: run this scene in one process, with --threads"
    )]
    OnRanks {
        /// Its name.
        what: String,
    },
    /// A section of the state does not fit the plan, or no run can have written it.
    #[error(
        "the state does not fit this plan: section `{section}`: {reason}\n\
         help: go on with the scene that the state was saved from"
    )]
    OtherState {
        /// Its name.
        section: String,
        /// Description of the problem.
        reason: String,
    },
    /// A sheet cannot be where it should be.
    #[error(
        "membranes.{surface}, step {step} (t = {} s): {error}\n\
         help: the time step is too large for the sheet and its contacts, or the loads are too large for its stiffness",
        rounded(*.time, 12)
    )]
    Surface {
        /// Its name.
        surface: String,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
        /// Why.
        error: WallError,
    },
    /// A wall cannot take another surface.
    #[error("walls.{wall}: {error}")]
    Wall {
        /// Its name.
        wall: String,
        /// Why.
        error: WallError,
    },
    /// The start, or a step, was given up on a request to stop ([`TaskProgress::is_given_up`](crate::task::TaskProgress::is_given_up)): the
    /// present data is no valid state.
    #[error("it was stopped")]
    GivenUp,
    /// Threads could not be started.
    #[error("the threads cannot be started: {0}")]
    Threads(String),
    /// A part from outside declares a column that particles have already.
    #[error(
        "the part `{part}` declares the column `{column}`, which particles have already: choose another name"
    )]
    Column {
        /// Name of the part.
        part: String,
        /// Name of the column.
        column: &'static str,
    },
}

/// In a few digits: a number of the size of what is lost has hundreds.
fn point(vector: &DVec3) -> String {
    let [x, y, z] = vector.to_array().map(short);
    format!("[{x}, {y}, {z}]")
}

impl RunError {
    /// The state has another section than a run of the plan.
    pub(super) fn other_section(expected: &str, found: Option<&str>) -> Self {
        Self::OtherState {
            section: expected.to_owned(),
            reason: match found {
                Some(found) => {
                    format!(
                        "expected `{expected}`, found `{found}`: the two scenes have different features"
                    )
                }
                None => "it is missing".to_owned(),
            },
        }
    }
}

impl Core {
    /// The first particle whose motion is not a number, or so large that its square is none.
    pub(super) fn not_finite(&self) -> RunError {
        let lost = |record: &Particle| {
            let squares =
                record.velocity.length_squared() + record.angular_velocity.length_squared();
            !(record.position.is_finite() && squares.is_finite())
        };
        let row = self.particles.records.iter().position(lost).unwrap_or(0);
        RunError::NotFinite {
            step: self.clock.step,
            time: self.time(),
            id: self.particles.ids[row].number(),
            position: self.particles.records[row].position,
            velocity: self.particles.records[row].velocity,
            angular_velocity: self.particles.records[row].angular_velocity,
        }
    }
}
