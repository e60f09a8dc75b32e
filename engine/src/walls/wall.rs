//! A wall of a scene, and where it stands in a step.

use glam::{DQuat, DVec3};

use super::{Motion, Pose, RigidVelocity, ServoState, Shape};
use crate::state::MaterialIndex;

/// A wall: a surface with a material, perhaps in motion, perhaps there only for a while.
#[derive(Debug, Clone)]
pub struct Wall {
    /// Name as in the scene; faces of a box are `box.-z` ...
    pub name: String,
    /// Index of the material.
    pub material: MaterialIndex,
    /// The surface where it stands at the start.
    pub shape: Shape,
    /// How it moves.
    pub motion: Motion,
    /// Present from this time on, s.
    pub from: f64,
    /// Removed at this time, s.
    pub until: f64,
    /// The point about which its torque is given, in the frame of the start, m.
    pub reference: DVec3,
}

/// Where a wall stands in a step, and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallState {
    /// Whether it is there.
    pub present: bool,
    /// From the frame of the start to where it stands; along periodic axes less whole periods.
    pub pose: Pose,
    /// Velocity half a step earlier: at the time of the particles' velocities that contacts see.
    pub velocity: RigidVelocity,
    /// The point about which its torque is given, now, m.
    pub reference: DVec3,
    /// Whether it moves at all in the run.
    pub moves: bool,
    /// Inverse of the pose's rotation.
    inverse: DQuat,
}

impl Wall {
    /// Whether it is there at `time` (s); times are multiples of the step `dt` (s), so a millionth of a step is round-off.
    #[must_use]
    pub fn is_present(&self, time: f64, dt: f64) -> bool {
        let slack = 1e-6 * dt;
        time >= self.from - slack && time < self.until - slack
    }

    /// The state at `time` (s) for steps of `dt` (s), its servos where they stand at the start.
    #[must_use]
    pub fn state(&self, time: f64, dt: f64) -> WallState {
        self.driven_state(time, dt, &[])
    }

    /// State with servos as in `driven`.
    #[must_use]
    pub fn driven_state(&self, time: f64, dt: f64, driven: &[ServoState]) -> WallState {
        let pose = |time| self.motion.driven_pose(time, driven);
        let velocity = |time| self.motion.driven_velocity(time, driven);
        self.state_by(time, dt, pose, velocity)
    }

    /// State with these poses and velocities as functions of time.
    pub(super) fn state_by(
        &self,
        time: f64,
        dt: f64,
        pose: impl Fn(f64) -> Pose,
        velocity: impl Fn(f64) -> RigidVelocity,
    ) -> WallState {
        let moves = !self.motion.is_static();
        let pose = if moves {
            self.shape.reduced(pose(time))
        } else {
            Pose::IDENTITY
        };
        let velocity = if moves {
            velocity((time - 0.5 * dt).max(0.0))
        } else {
            RigidVelocity::REST
        };
        WallState {
            present: self.is_present(time, dt),
            pose,
            velocity,
            reference: pose.to_global(self.reference),
            inverse: pose.rotation.conjugate(),
            moves,
        }
    }
}

impl WallState {
    /// Puts it elsewhere, with its velocities and its reference point, m.
    pub(super) fn shift(&mut self, by: DVec3) {
        if by != DVec3::ZERO {
            self.pose.translation += by;
            self.velocity.origin += by;
            self.reference += by;
        }
    }

    /// A global position in the frame of the start, m.
    #[inline]
    #[must_use]
    pub fn into_wall(&self, position: DVec3) -> DVec3 {
        if self.moves {
            self.inverse * (position - self.pose.translation)
        } else {
            position
        }
    }

    /// A direction of the global frame in the frame of the start.
    #[inline]
    #[must_use]
    pub fn turn_into_wall(&self, direction: DVec3) -> DVec3 {
        if self.moves {
            self.inverse * direction
        } else {
            direction
        }
    }

    /// A direction of the frame of the start in the global frame.
    #[inline]
    #[must_use]
    pub fn out_of_wall(&self, direction: DVec3) -> DVec3 {
        if self.moves {
            self.pose.rotation * direction
        } else {
            direction
        }
    }
}
