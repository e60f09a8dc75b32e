//! Turns and angles, to the same bits on every processor.
//!
//! Turns are those of glam, but that sine, cosine and arc cosine come from `libm`, in Rust: those of a system's mathematics
//! library differ in the last bit from system to system, and with it from processor to processor (`docs/theory/determinism.md`).

use glam::{DQuat, DVec3};

/// The turn by `angle` (rad) about a unit vector.
///
/// ```
/// use glam::DVec3;
/// use mercury_common::turns::about_axis;
///
/// let quarter = about_axis(DVec3::Z, std::f64::consts::FRAC_PI_2);
/// assert!((quarter * DVec3::X).abs_diff_eq(DVec3::Y, 1e-15));
/// ```
#[must_use]
pub fn about_axis(axis: DVec3, angle: f64) -> DQuat {
    let (sin, cos) = libm::sincos(0.5 * angle);
    let vector = axis * sin;
    DQuat::from_xyzw(vector.x, vector.y, vector.z, cos)
}

/// The turn about a vector by its length, rad.
#[must_use]
pub fn by_vector(rotation: DVec3) -> DQuat {
    let angle = rotation.length();
    if angle == 0.0 {
        DQuat::IDENTITY
    } else {
        about_axis(rotation / angle, angle)
    }
}

/// The angle (rad) between two vectors that are not 0.
#[must_use]
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    let cosine = a.dot(b) / (a.length_squared() * b.length_squared()).sqrt();
    libm::acos(cosine.clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vectors() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-4.0..4.0f64)
            .prop_map(DVec3::from)
            .prop_filter("has a direction", |v| v.length() > 1e-3)
    }

    proptest! {
        /// Turns equal those of glam, but for the last bits: sine and cosine are exact to 1 unit in the last place, the arc
        /// cosine to that of pi.
        #[test]
        fn turns_are_glams(a in vectors(), b in vectors()) {
            let axis = a.normalize();
            prop_assert!(about_axis(axis, b.x).abs_diff_eq(DQuat::from_axis_angle(axis, b.x), 4.0 * f64::EPSILON));
            prop_assert!(by_vector(a).abs_diff_eq(DQuat::from_scaled_axis(a), 4.0 * f64::EPSILON));
            prop_assert!((angle_between(a, b) - a.angle_between(b)).abs() < 4.0 * f64::EPSILON);
        }
    }

    #[test]
    fn no_turn_is_the_identity() {
        assert_eq!(by_vector(DVec3::ZERO), DQuat::IDENTITY);
        assert_eq!(about_axis(DVec3::X, 0.0), DQuat::IDENTITY);
    }

    /// Bits that every processor gives.
    #[test]
    fn bits_are_frozen() {
        let mix = |sum: u64, number: f64| sum.rotate_left(5).wrapping_add(number.to_bits());
        let [mut turns, mut angles] = [0; 2];
        for k in (1..=20_000).map(f64::from) {
            let turn = about_axis(DVec3::Z, 0.0137 * k);
            turns = mix(mix(turns, turn.z), turn.w);
            angles = mix(
                angles,
                angle_between(DVec3::X, DVec3::new(1.0, 0.0, 1e-3 * k)),
            );
        }
        assert_eq!(
            [turns, angles],
            [0xfae4_5428_6716_e3af, 0xb16e_45f6_2c75_6ccf]
        );
    }
}
