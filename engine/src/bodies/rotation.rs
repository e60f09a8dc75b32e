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
/// # use mercury_engine::bodies::{angular_velocity, free_rotation};
/// // About a principal axis the angular velocity stays: a quarter turn about z.
/// let moments = DVec3::new(1.0, 2.0, 3.0);
/// let quarter = std::f64::consts::FRAC_PI_2;
/// let turned = free_rotation(DQuat::IDENTITY, DVec3::Z * 3.0 * quarter, moments, 1.0);
/// assert!((turned * DVec3::X - DVec3::Y).length() < 1e-15);
/// assert!((angular_velocity(turned, DVec3::Z * 3.0, moments) - DVec3::Z).length() < 1e-15);
/// ```
#[must_use]
pub fn free_rotation(orientation: DQuat, momentum: DVec3, moments: DVec3, time: f64) -> DQuat {
    let m = orientation.inverse() * momentum;
    free_motion(orientation, m, moments.recip(), time).0
}

/// Free rotation for the angular momentum `m` in the body's frame and the inverse moments (1/(kg m^2)): orientation and `m`
/// afterwards.
#[inline]
pub(super) fn free_motion(
    orientation: DQuat,
    m: DVec3,
    inverse_moments: DVec3,
    time: f64,
) -> (DQuat, DVec3) {
    let (mut q, mut m) = (orientation, m);
    // m/I per axis is the angular velocity; m itself turns the other way round.
    let [half, whole] = [0.25 * time, 0.5 * time].map(|time| inverse_moments * time);
    about::<0>(&mut q, &mut m, half);
    about::<1>(&mut q, &mut m, half);
    about::<2>(&mut q, &mut m, whole);
    about::<1>(&mut q, &mut m, half);
    about::<0>(&mut q, &mut m, half);
    // One Newton step towards length 1: the length is off by round-off only.
    (q * (1.5 - 0.5 * q.length_squared()), m)
}

/// The exact motion under m_k^2/2I_k alone: the body turns about its axis `K` by twice the angle `m_k by_momentum_k`.
#[inline(always)]
fn about<const K: usize>(q: &mut DQuat, m: &mut DVec3, by_momentum: DVec3) {
    let half_angle = m[K] * by_momentum[K];
    let (c, s) = cosine_and_sine(half_angle);
    let mut axis = [0.0; 3];
    axis[K] = s;
    *q *= DQuat::from_xyzw(axis[0], axis[1], axis[2], c);
    // The inverse rotation of m by the whole angle.
    let (cos, sin) = ((c - s) * (c + s), 2.0 * s * c);
    let (i, j) = ((K + 1) % 3, (K + 2) % 3);
    (m[i], m[j]) = (cos * m[i] + sin * m[j], cos * m[j] - sin * m[i]);
}

/// cos h and sin h; for the small angles of a time step by their series, exact to round-off.
///
/// The coefficients are constants to multiply by: a chain of divisions would take longer than all else that a body costs in a step.
#[inline(always)]
fn cosine_and_sine(h: f64) -> (f64, f64) {
    const C: [f64; 5] = [
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
    ];
    const S: [f64; 5] = [
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5_040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
    ];
    let s = h * h;
    if s < 1e-4 {
        // Remainders below s^4/8! and s^4/9!: 3e-21.
        let cosine = 1.0 + s * (C[0] + s * (C[1] + s * C[2]));
        let sine = h + h * s * (S[0] + s * (S[1] + s * S[2]));
        (cosine, sine)
    } else if s < 0.01 {
        // Remainders below s^6/12! and s^6/13!: 2e-21.
        let cosine = 1.0 + s * (C[0] + s * (C[1] + s * (C[2] + s * (C[3] + s * C[4]))));
        let sine = h + h * s * (S[0] + s * (S[1] + s * (S[2] + s * (S[3] + s * S[4]))));
        (cosine, sine)
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
