//! The free rotation of a rigid body.

use glam::{DQuat, DVec3};

/// The orientation after `time` seconds of rotation without torque, for the angular momentum `momentum` (kg m^2/s, global
/// frame, which stays as it is) and the principal `moments` of inertia (kg m^2).
///
/// The kinetic energy is a sum over the three principal axes, m_1^2/2I_1 + m_2^2/2I_2 + m_3^2/2I_3 with m = R^T L, and the motion
/// under each part alone is a rotation about that axis by the angle t m_k/I_k. The symmetric composition 1, 2, 3, 2, 1 of these
/// exact motions is of second order, time-reversible and symplectic (Dullweber, Leimkuhler & McLachlan 1997, J. Chem. Phys.
/// 107, 5840, section III; McLachlan 1993). |L| is kept to the bit, the energy oscillates and does not drift. A sphere needs none of this: its
/// angular velocity is constant.
///
/// ```
/// # use glam::{DQuat, DVec3};
/// # use mercury_solver::bodies::{angular_velocity, free_rotation};
/// // About a principal axis the angular velocity stays: a quarter turn about z.
/// let moments = DVec3::new(1.0, 2.0, 3.0);
/// let quarter = std::f64::consts::FRAC_PI_2;
/// let turned = free_rotation(DQuat::IDENTITY, DVec3::Z * 3.0 * quarter, moments, 1.0);
/// assert!((turned * DVec3::X - DVec3::Y).length() < 1e-15);
/// assert!((angular_velocity(turned, DVec3::Z * 3.0, moments) - DVec3::Z).length() < 1e-15);
/// ```
#[must_use]
pub fn free_rotation(orientation: DQuat, momentum: DVec3, moments: DVec3, time: f64) -> DQuat {
    // m/I per axis is the angular velocity; m itself turns the other way round.
    let mut m = orientation.inverse() * momentum;
    let mut q = orientation;
    let half = 0.5 * time;
    about::<0>(&mut q, &mut m, moments, half);
    about::<1>(&mut q, &mut m, moments, half);
    about::<2>(&mut q, &mut m, moments, time);
    about::<1>(&mut q, &mut m, moments, half);
    about::<0>(&mut q, &mut m, moments, half);
    // One Newton step towards length 1: the length is off by round-off only.
    q * (1.5 - 0.5 * q.length_squared())
}

/// The exact motion under m_k^2/2I_k alone: the body turns about its axis `K`.
#[inline(always)]
fn about<const K: usize>(q: &mut DQuat, m: &mut DVec3, moments: DVec3, time: f64) {
    let half_angle = 0.5 * time * m[K] / moments[K];
    let (c, s) = cosine_and_sine(half_angle);
    let mut axis = [0.0; 3];
    axis[K] = s;
    *q *= DQuat::from_xyzw(axis[0], axis[1], axis[2], c);
    // The inverse rotation of m by the whole angle.
    let (cos, sin) = ((c - s) * (c + s), 2.0 * s * c);
    let (i, j) = ((K + 1) % 3, (K + 2) % 3);
    (m[i], m[j]) = (cos * m[i] + sin * m[j], cos * m[j] - sin * m[i]);
}

/// cos h and sin h; for the small angles of a time step by their series, exact to round-off below |h| = 0.1.
#[inline(always)]
fn cosine_and_sine(h: f64) -> (f64, f64) {
    let s = h * h;
    if s < 0.01 {
        // remainders below s^6/12! and s^6/13!: 2e-21
        (
            1.0 - s / 2.0
                * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0)))),
            h * (1.0
                - s / 6.0
                    * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0))))),
        )
    } else {
        (libm::cos(h), libm::sin(h))
    }
}

/// The angular velocity (rad/s, global frame) of a body of angular momentum `momentum` (kg m^2/s, global frame):
/// w = R I^-1 R^T L.
#[must_use]
pub fn angular_velocity(orientation: DQuat, momentum: DVec3, moments: DVec3) -> DVec3 {
    orientation * ((orientation.inverse() * momentum) / moments)
}
