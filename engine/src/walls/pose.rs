//! Where a rigid wall is, and how fast it moves.

use glam::{DQuat, DVec3};

/// Where a rigid wall is: `x_global = rotation * x_initial + translation`, where `x_initial` are the
/// coordinates in which the scene describes the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Unit quaternion.
    pub rotation: DQuat,
    /// In m.
    pub translation: DVec3,
}

impl Pose {
    /// The pose in which the scene describes the wall.
    pub const IDENTITY: Self = Self {
        rotation: DQuat::IDENTITY,
        translation: DVec3::ZERO,
    };

    /// The rotation by `rotation` about the point `origin`, and then the shift by `displacement`.
    #[must_use]
    pub fn about(origin: DVec3, rotation: DQuat, displacement: DVec3) -> Self {
        Self {
            rotation,
            translation: origin - rotation * origin + displacement,
        }
    }

    /// Global position of a point of the wall, from its initial position.
    #[must_use]
    pub fn to_global(&self, initial: DVec3) -> DVec3 {
        self.rotation * initial + self.translation
    }

    /// A global position in the wall's own (initial) frame.
    #[must_use]
    pub fn to_initial(&self, global: DVec3) -> DVec3 {
        self.rotation.conjugate() * (global - self.translation)
    }

    /// The pose that applies `self` first and `next` to the result.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self {
            rotation: next.rotation * self.rotation,
            translation: next.to_global(self.translation),
        }
    }

    /// The motion from `self` to `to`, seen from the wall's frame at `self`:
    /// `to = from after relative`.
    pub(super) fn relative_to(&self, to: &Self) -> Self {
        let back = self.rotation.conjugate();
        Self {
            rotation: back * to.rotation,
            translation: back * (to.translation - self.translation),
        }
    }
}

/// The velocity field of a rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidVelocity {
    /// Velocity of the material point that is at `origin`, in m/s.
    pub velocity: DVec3,
    /// In rad/s, right-handed.
    pub angular_velocity: DVec3,
    /// Global position of the point that has `velocity`, in m.
    pub origin: DVec3,
}

impl RigidVelocity {
    /// The field of a body at rest.
    pub const REST: Self = Self {
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
        origin: DVec3::ZERO,
    };

    /// Velocity in m/s of the material point that is at the global position `point`:
    /// `v + omega x (point - origin)`.
    #[must_use]
    pub fn at(&self, point: DVec3) -> DVec3 {
        self.velocity + self.angular_velocity.cross(point - self.origin)
    }
}

crate::state::plain!(Pose {
    rotation,
    translation
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn composition_applies_the_first_pose_first() {
        let quarter = Pose::about(
            DVec3::X,
            DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            DVec3::ZERO,
        );
        let shift = Pose {
            rotation: DQuat::IDENTITY,
            translation: DVec3::new(0.0, 0.0, 3.0),
        };
        // (2,0,0) is 1 to the right of (1,0,0): a quarter turn brings it to (1,1,0).
        let expected = DVec3::new(1.0, 1.0, 3.0);
        let both = quarter.then(&shift);
        assert!((both.to_global(DVec3::new(2.0, 0.0, 0.0)) - expected).length() < 1e-15);
        assert!((both.to_initial(expected) - DVec3::new(2.0, 0.0, 0.0)).length() < 1e-15);
        let x = DVec3::new(0.3, -0.4, 0.5);
        let back = quarter.then(&shift).to_global(x);
        let relative = quarter.relative_to(&both);
        assert!((quarter.to_global(relative.to_global(x)) - back).length() < 1e-14);
    }
}
