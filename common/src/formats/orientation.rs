//! Orientations: quaternions in memory, Euler angles in `.data`.

use glam::{DQuat, DVec3};

use crate::turns::about_axis;

/// Roll, pitch, yaw (rad) of a unit quaternion, `R = Rz(yaw) Ry(pitch) Rx(roll)`.
///
/// Pitch lies in `[-pi/2, pi/2]`, roll and yaw in `[-pi, pi]`. The yaw is that of the usual formula
/// (Diebel 2006, *Representing attitude*, sequence 1-2-3); the roll is taken from `Rz(-yaw) R`, which equals the
/// usual formula but also gives the right rotation at pitch = +-pi/2, where the usual one is noise.
#[must_use]
pub fn euler_from_quaternion(q: DQuat) -> DVec3 {
    let (q0, q1, q2, q3) = (q.w, q.x, q.y, q.z);
    // Elements of the rotation matrix, row then column.
    let r11 = 1.0 - 2.0 * (q2 * q2 + q3 * q3);
    let r21 = 2.0 * (q1 * q2 + q0 * q3);
    let r31 = 2.0 * (q1 * q3 - q0 * q2);
    let r12 = 2.0 * (q1 * q2 - q0 * q3);
    let r22 = 1.0 - 2.0 * (q1 * q1 + q3 * q3);
    let r13 = 2.0 * (q1 * q3 + q0 * q2);
    let r23 = 2.0 * (q2 * q3 - q0 * q1);

    let yaw = libm::atan2(r21, r11);
    let pitch = libm::atan2(-r31, libm::hypot(r11, r21));
    let (sin_yaw, cos_yaw) = libm::sincos(yaw);
    let roll = libm::atan2(sin_yaw * r13 - cos_yaw * r23, cos_yaw * r22 - sin_yaw * r12);
    DVec3::new(roll, pitch, yaw)
}

/// The unit quaternion of roll, pitch, yaw (rad): the inverse of [`euler_from_quaternion`].
#[must_use]
pub fn quaternion_from_euler(angles: DVec3) -> DQuat {
    let [x, y, z] = DVec3::AXES;
    about_axis(z, angles.z) * about_axis(y, angles.y) * about_axis(x, angles.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn single_axes() {
        let angle = 0.3;
        for (q, expected) in [
            (DQuat::from_rotation_x(angle), DVec3::new(angle, 0.0, 0.0)),
            (DQuat::from_rotation_y(angle), DVec3::new(0.0, angle, 0.0)),
            (DQuat::from_rotation_z(angle), DVec3::new(0.0, 0.0, angle)),
        ] {
            assert!((euler_from_quaternion(q) - expected).length() < 1e-15);
        }
    }

    /// `|a . b| = cos(angle/2)`, so the vector difference is the accurate measure.
    fn rotation_distance(a: DQuat, b: DQuat) -> f64 {
        (a - b).length().min((a + b).length())
    }

    proptest! {
        #[test]
        fn there_and_back(roll in -PI..PI, pitch in -FRAC_PI_2..FRAC_PI_2, yaw in -PI..PI) {
            let q = quaternion_from_euler(DVec3::new(roll, pitch, yaw));
            let back = quaternion_from_euler(euler_from_quaternion(q));
            prop_assert!(rotation_distance(q, back) < 2e-15);
        }

        #[test]
        fn right_at_the_poles(roll in -PI..PI, yaw in -PI..PI, up: bool, off in -1e-9..1e-9) {
            let pitch = if up { FRAC_PI_2 + off } else { -FRAC_PI_2 + off };
            let q = quaternion_from_euler(DVec3::new(roll, pitch, yaw));
            let back = quaternion_from_euler(euler_from_quaternion(q));
            prop_assert!(rotation_distance(q, back) < 2e-15);
        }

        #[test]
        fn equals_the_textbook_formula(roll in -3.1..3.1, pitch in -1.5..1.5, yaw in -3.1..3.1) {
            let angles = DVec3::new(roll, pitch, yaw);
            let q = quaternion_from_euler(angles);
            let textbook = DVec3::new(
                (2.0 * (q.w * q.x + q.y * q.z)).atan2(1.0 - 2.0 * (q.x * q.x + q.y * q.y)),
                (2.0 * (q.w * q.y - q.z * q.x)).asin(),
                (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z)),
            );
            let found = euler_from_quaternion(q);
            // Round-off of a unit in the last place is amplified by 1/cos(pitch) <= 14.2.
            prop_assert!((found - textbook).length() < 1e-13, "{found} {textbook}");
            prop_assert!((found - angles).length() < 1e-13);
        }
    }
}
