//! How particles move between two force evaluations: kick, drift and turn.

use std::slice::{from_mut, from_ref};

use glam::{DQuat, DVec3};

use crate::forces::MotionBound;
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Task, Vector, Width};
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

    /// Moves some particles, one in each lane; `fastest`: largest v^2, and the sum of v^2 and w^2, of those that were moved
    /// before.
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
        fastest[0] = fastest[0].max(squared);
        fastest[1] = fastest[1] + squared;
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
        // Only whether the sum is a number is used: its order is free.
        let lanes = (0..L::LANES).map(|k| fastest.map(|of_lanes| of_lanes.lane(k)));
        let [squared_speed, sum_of_squares] =
            lanes.fold(alone, |all, lane| [all[0].max(lane[0]), all[1] + lane[1]]);
        MotionBound {
            squared_speed,
            sum_of_squares,
        }
    }
}

/// Turns orientations by the angular velocities over `drift` seconds, exactly for constant ones. Several at once, in lanes of
/// `width`.
pub(super) fn turn_orientations(
    orientations: &mut [DQuat],
    records: &[Particle],
    drift: f64,
    width: Width,
) {
    width.run(Turn {
        orientations,
        records,
        drift,
    });
}

/// Orientations and the particles they are of.
struct Turn<'a> {
    orientations: &'a mut [DQuat],
    records: &'a [Particle],
    drift: f64,
}

impl Task for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Real>(self) {
        // A pebble's orientation is its body's.
        let turns = |record: &Particle| record.flags & PEBBLE == 0;
        let groups = self.orientations.chunks_mut(L::LANES);
        for (orientations, records) in groups.zip(self.records.chunks(L::LANES)) {
            if records.len() == L::LANES && records.iter().all(turns) {
                turn_some::<L>(orientations, records, self.drift);
                continue;
            }
            for (orientation, record) in orientations.iter_mut().zip(records) {
                if turns(record) {
                    turn_some::<f64>(from_mut(orientation), from_ref(record), self.drift);
                }
            }
        }
    }
}

/// Turns as many as there are lanes.
#[inline(always)]
fn turn_some<L: Real>(orientations: &mut [DQuat], records: &[Particle], drift: f64) {
    let mut quads = [Quad::default(); MOST_LANES];
    for (quad, orientation) in quads.iter_mut().zip(orientations.iter()) {
        *quad = Quad(orientation.to_array());
    }
    let [x, y, z, w] = L::columns(|k| &quads[k]);
    let spin: Vector<L> = L::vectors(|k| &records[k].quads()[2]);
    let (v, c) = rotation(spin * L::splat(0.5 * drift));
    // The rotation times the orientation.
    let vector = Vector::new(
        c * x + v.x * w + v.y * z - v.z * y,
        c * y - v.x * z + v.y * w + v.z * x,
        c * z + v.x * y - v.y * x + v.z * w,
    );
    let scalar = c * w - v.x * x - v.y * y - v.z * z;
    // Newton's step for the root: the length is 1 but for round-off.
    let inverse_length = -((vector.length_squared() + scalar * scalar) * 0.5) + 1.5;
    let rows = L::rows(vector * inverse_length, scalar * inverse_length);
    for (orientation, row) in orientations.iter_mut().zip(rows) {
        *orientation = DQuat::from_array(row.0);
    }
}

/// The rotation exp(h) for half the rotation vector h: sin |h| h/|h| and cos |h|.
///
/// For the small angles of a time step by its series, which is exact to round-off below |h| = 0.1.
#[inline(always)]
fn rotation<L: Real>(half: Vector<L>) -> (Vector<L>, L) {
    let s = half.length_squared();
    // Remainders below s^3/6! and s^3/7!: 4e-17. Most turns of a time step.
    let mut cosine = L::ONE - s * (1.0 / 2.0) * (L::ONE - s * (1.0 / 12.0));
    let mut sinc = L::ONE - s * (1.0 / 6.0) * (L::ONE - s * (1.0 / 20.0));
    let small = s.below(L::splat(3e-5));
    if !small.all() {
        let larger = |of: fn(f64) -> f64| L::from_lanes(|k| of(s.lane(k)));
        cosine = L::select(small, cosine, larger(|s| cosine_and_sinc(s)[0]));
        sinc = L::select(small, sinc, larger(|s| cosine_and_sinc(s)[1]));
    }
    (half * sinc, cosine)
}

/// cos |h| and sin |h| / |h| for any s = |h|^2.
#[inline(never)]
fn cosine_and_sinc(s: f64) -> [f64; 2] {
    if s < 0.01 {
        // Remainders below s^6/12! and s^6/13!: 2e-21.
        [
            1.0 - s / 2.0
                * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0)))),
            1.0 - s / 6.0
                * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0)))),
        ]
    } else {
        let angle = s.sqrt();
        [libm::cos(angle), libm::sin(angle) / angle]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::MaterialIndex;

    /// Turns of every size, from none to several radians a step, for a number of particles that no number of lanes divides, one of them a pebble.
    #[test]
    fn orientations_turn_by_the_rotation_vector_in_every_width() {
        let drift = 1e-3;
        let axis = DVec3::new(0.6, -0.48, 0.64);
        let angles = [
            0.0, 1e-9, 1e-4, 0.0109, 0.011, 0.05, 0.19, 0.2, 0.7, 3.0, 6.0, 1.0, 1e-3,
        ];
        let records: Vec<Particle> = (0..)
            .zip(angles)
            .map(|(k, angle)| Particle {
                position: DVec3::ZERO,
                radius: 1.0,
                velocity: DVec3::ZERO,
                inverse_mass: 1.0,
                angular_velocity: axis * (angle / drift),
                material: MaterialIndex::new(0),
                flags: if k == 4 { PEBBLE } else { 0 },
            })
            .collect();
        let start = DQuat::from_axis_angle(DVec3::Y, 0.3);
        let mut first: Option<Vec<DQuat>> = None;
        for width in Width::all() {
            let mut orientations = vec![start; records.len()];
            turn_orientations(&mut orientations, &records, drift, width);
            for ((turned, record), angle) in orientations.iter().zip(&records).zip(angles) {
                let expected = match record.flags {
                    PEBBLE => start,
                    _ => DQuat::from_axis_angle(axis, angle) * start,
                };
                // Some ten roundings of numbers up to 1, and of the angle.
                let tolerance = 2e-15 * (1.0 + angle);
                assert!(
                    turned.abs_diff_eq(expected, tolerance),
                    "{angle} rad: {turned} instead of {expected}"
                );
            }
            match &first {
                Some(first) => assert_eq!(first, &orientations, "{} lanes", width.lanes()),
                None => first = Some(orientations),
            }
        }
    }
}
