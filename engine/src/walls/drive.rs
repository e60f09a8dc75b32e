//! A wall that another program drives.

use glam::{DQuat, DVec3};
use mercury_common::turns::by_vector;

use super::pose::{Pose, RigidVelocity};

/// Motion of a driven wall within a window: from a pose with constant velocities, and to a pose at its end. Behind the window it rests.
///
/// The velocities are those that contacts see, half a step before each position. A partner with the scheme of the particles (velocity Verlet) and
/// windows of one step has both: the position x + v dt at the end, and v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Beginning and end of the window, s.
    window: [f64; 2],
    /// Poses at its beginning and at its end.
    poses: [Pose; 2],
    /// The reference point of the wall at the beginning, m.
    reference: DVec3,
    /// Of the reference point, m/s.
    velocity: DVec3,
    /// rad/s
    angular_velocity: DVec3,
}

crate::state::plain!(Drive {
    window,
    poses,
    reference,
    velocity,
    angular_velocity
});

impl Drive {
    /// At rest where the scene puts it.
    pub(super) const REST: Self = Self {
        window: [0.0; 2],
        poses: [Pose::IDENTITY; 2],
        reference: DVec3::ZERO,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
    };

    /// The next window, s, of a wall whose reference point is at `reference` (m) in the frame of the start: with these velocities of this point (m/s, rad/s) and
    /// to a pose at the end.
    #[must_use]
    pub(super) fn next(
        &self,
        window: [f64; 2],
        target: Pose,
        reference: DVec3,
        [velocity, angular_velocity]: [DVec3; 2],
    ) -> Self {
        let begin = self.pose(window[0]);
        Self {
            window,
            poses: [begin, target],
            reference: begin.to_global(reference),
            velocity,
            angular_velocity,
        }
    }

    /// Pose at `time` (s).
    pub(super) fn pose(&self, time: f64) -> Pose {
        let [begin, end] = self.window;
        if time >= end {
            return self.poses[1];
        }
        let seconds = time - begin;
        let turn = by_vector(self.angular_velocity * seconds);
        self.poses[0].then(&Pose::about(self.reference, turn, self.velocity * seconds))
    }

    /// Velocity at `time` (s), the end of the window included.
    pub(super) fn velocity(&self, time: f64) -> RigidVelocity {
        let [begin, end] = self.window;
        if time > end {
            return RigidVelocity::REST;
        }
        RigidVelocity {
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
            origin: self.reference + self.velocity * (time - begin),
        }
    }
}

/// The pose of a wall whose reference point, at `reference` (m) in the frame of the start, is at `place` (m), turned by `rotation` since the start.
#[must_use]
pub(super) fn pose_at(reference: DVec3, place: DVec3, rotation: DQuat) -> Pose {
    Pose {
        rotation,
        translation: place - rotation * reference,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter turn about the reference point while this goes on by 1 m, in 0.5 s: at half of it both are halfway, at the end the wall is where the pose says.
    #[test]
    fn a_driven_wall_goes_on_with_its_velocities_and_ends_at_its_pose() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let reference = DVec3::new(1.0, 0.0, 0.0);
        let target = pose_at(
            reference,
            DVec3::new(1.0, 1.0, 0.0),
            DQuat::from_rotation_z(quarter),
        );
        let velocities = [DVec3::Y * 2.0, DVec3::Z * (2.0 * quarter)];
        let drive = Drive::REST.next([3.0, 3.5], target, reference, velocities);
        assert_eq!(drive.pose(3.0), Pose::IDENTITY);
        let tip = DVec3::new(2.0, 0.0, 0.0);
        let half = 0.5f64.sqrt();
        let expected = DVec3::new(1.0 + half, 0.5 + half, 0.0);
        assert!((drive.pose(3.25).to_global(tip) - expected).length() < 1e-15);
        let at = DVec3::new(1.0, 0.5, 0.0);
        assert_eq!(drive.velocity(3.25).at(at), velocities[0]);
        // A point 1 m away along x has w x r in addition.
        let rim = drive.velocity(3.25).at(at + DVec3::X);
        assert!((rim - DVec3::Y * (2.0 + 2.0 * quarter)).length() < 1e-14);
        assert_eq!(drive.pose(3.5), target);
        assert_eq!(drive.pose(4.0), target);
        assert_eq!(drive.velocity(3.75), RigidVelocity::REST);
        // The next window begins there.
        let next = drive.next([4.0, 4.5], Pose::IDENTITY, reference, [DVec3::ZERO; 2]);
        assert_eq!(next.pose(4.0), target);
    }
}
