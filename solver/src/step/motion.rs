//! How particles move between two force evaluations: kick, drift and turn.

use std::slice::{from_mut, from_ref};

use glam::{DQuat, DVec3};

use crate::forces::MotionBound;
use crate::lanes::{Real, Task, Vector, Width};
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
    /// Particles that are moved side by side.
    pub(super) width: Width,
}

impl KickDrift {
    /// Moves those that are neither fixed nor pebbles; what their fastest is then.
    pub(super) fn run(&self, records: &mut [Particle], loads: &[Load]) -> MotionBound {
        self.width.run(Advance {
            by: self,
            records,
            loads,
        })
    }

    /// Moves some particles, one in each lane; `fastest`: largest v^2, and the sum of v^2 and w^2, of those that were moved before.
    #[inline(always)]
    fn advance<L: Real>(&self, records: &mut [Particle], loads: &[Load], fastest: &mut [L; 2]) {
        let [x, y, z, inverse_mass] = L::columns(|k| &records[k].quads()[1]);
        let force: Vector<L> = L::vectors(|k| &loads[k].quads()[0]);
        let gravity = Vector::splat(self.gravity.into());
        let kick = (force * inverse_mass + gravity) * L::splat(self.half);
        let mut velocity = Vector::new(x, y, z) + kick;
        if self.kicks == 2 {
            velocity += kick;
        }
        let [x, y, z, radius] = L::columns(|k| &records[k].quads()[0]);
        let position = Vector::new(x, y, z) + velocity * L::splat(self.drift);
        let squared = velocity.length_squared();
        *fastest = [fastest[0].max(squared), fastest[1] + squared];
        let places = L::rows(position, radius);
        let velocities = L::rows(velocity, inverse_mass);
        for (k, record) in records[..L::LANES].iter_mut().enumerate() {
            let quads = record.quads_mut();
            quads[0] = places[k];
            quads[1] = velocities[k];
        }
        if self.turns {
            let [x, y, z, others] = L::columns(|k| &records[k].quads()[2]);
            let torque: Vector<L> = L::vectors(|k| &loads[k].quads()[1]);
            let per_torque = inverse_mass * self.inverse_inertia / (radius * radius);
            let kick = torque * (per_torque * self.half);
            let mut spin = Vector::new(x, y, z) + kick;
            if self.kicks == 2 {
                spin += kick;
            }
            fastest[1] = fastest[1] + spin.length_squared();
            let spins = L::rows(spin, others);
            for (k, record) in records[..L::LANES].iter_mut().enumerate() {
                record.quads_mut()[2] = spins[k];
            }
        }
    }
}

/// A pass of [`KickDrift`] over some particles.
struct Advance<'a> {
    by: &'a KickDrift,
    records: &'a mut [Particle],
    loads: &'a [Load],
}

impl Task for Advance<'_> {
    type Output = MotionBound;

    #[inline(always)]
    fn run<L: Real>(self) -> MotionBound {
        let moves = |record: &Particle| record.flags & (FIXED | PEBBLE) == 0;
        let (mut fastest, mut alone) = ([L::ZERO; 2], [0.0; 2]);
        let groups = self.records.chunks_mut(L::LANES);
        for (records, loads) in groups.zip(self.loads.chunks(L::LANES)) {
            if records.len() == L::LANES && records.iter().all(moves) {
                self.by.advance(records, loads, &mut fastest);
                continue;
            }
            for (record, load) in records.iter_mut().zip(loads) {
                if moves(record) {
                    let (record, load) = (from_mut(record), from_ref(load));
                    self.by.advance(record, load, &mut alone);
                }
            }
        }
        // The sum is only asked whether it is a number: its order is free.
        let lanes = (0..L::LANES).map(|k| fastest.map(|of_lanes| of_lanes.lane(k)));
        let [squared_speed, sum_of_squares] =
            lanes.fold(alone, |all, lane| [all[0].max(lane[0]), all[1] + lane[1]]);
        MotionBound {
            squared_speed,
            sum_of_squares,
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
