//! How particles move between two force evaluations: kick, drift and turn.

use glam::{DQuat, DVec3};

use crate::forces::MotionBound;
use crate::state::{FIXED, Load, PEBBLE, Particle};

/// Half kicks and a drift of a block of particles.
pub(super) struct KickDrift {
    /// Half the time step, s.
    pub(super) half: f64,
    /// Drift, s.
    pub(super) drift: f64,
    pub(super) kicks: u32,
    pub(super) gravity: DVec3,
    pub(super) inverse_inertia: f64,
    pub(super) turns: bool,
}

impl KickDrift {
    pub(super) fn run(&self, records: &mut [Particle], loads: &[Load]) -> MotionBound {
        let (mut largest, mut sum) = (0.0f64, 0.0);
        for (record, load) in records.iter_mut().zip(loads) {
            if record.flags & (FIXED | PEBBLE) != 0 {
                continue;
            }
            let kick = (load.force * record.inverse_mass + self.gravity) * self.half;
            let mut velocity = record.velocity + kick;
            if self.kicks == 2 {
                velocity += kick;
            }
            record.velocity = velocity;
            record.position += velocity * self.drift;
            if self.turns {
                let per_torque =
                    self.inverse_inertia * record.inverse_mass / (record.radius * record.radius);
                let kick = load.torque * (per_torque * self.half);
                record.angular_velocity += kick;
                if self.kicks == 2 {
                    record.angular_velocity += kick;
                }
                sum += record.angular_velocity.length_squared();
            }
            let squared = velocity.length_squared();
            largest = largest.max(squared);
            sum += squared;
        }
        MotionBound {
            squared_speed: largest,
            sum_of_squares: sum,
        }
    }
}

/// Turns orientations by the angular velocities over `drift` seconds, exactly for constant ones.
pub(super) fn turn_orientations(orientations: &mut [DQuat], records: &[Particle], drift: f64) {
    for (orientation, record) in orientations.iter_mut().zip(records) {
        // A pebble's orientation is its body's.
        if record.flags & PEBBLE == 0 {
            let turned = turn(record.angular_velocity * (0.5 * drift)) * *orientation;
            // Newton's step for the root: the length is 1 but for round-off.
            *orientation = turned * (1.5 - 0.5 * turned.length_squared());
        }
    }
}

/// The rotation exp(h) for half the rotation vector h: (cos |h|, sin |h| h/|h|).
///
/// For the small angles of a time step by its series, which is exact to round-off below |h| = 0.1.
fn turn(half: DVec3) -> DQuat {
    let s = half.length_squared();
    let (cosine, sinc) = if s < 3e-5 {
        // Remainders below s^3/6! and s^3/7!: 4e-17. Most turns of a time step.
        (
            1.0 - s * (1.0 / 2.0) * (1.0 - s * (1.0 / 12.0)),
            1.0 - s * (1.0 / 6.0) * (1.0 - s * (1.0 / 20.0)),
        )
    } else if s < 0.01 {
        // Remainders below s^6/12! and s^6/13!: 2e-21.
        (
            1.0 - s / 2.0
                * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0)))),
            1.0 - s / 6.0
                * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0)))),
        )
    } else {
        let angle = s.sqrt();
        (angle.cos(), angle.sin() / angle)
    };
    let vector = half * sinc;
    DQuat::from_xyzw(vector.x, vector.y, vector.z, cosine)
}
