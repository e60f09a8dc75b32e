//! A time step of all bodies: loads from the pebbles, kicks and drift, pebbles from the body.

use glam::{DMat3, DQuat, DVec3};
use mercury_common::turns::by_vector;
use rayon::ThreadPool;
use rayon::prelude::*;

use super::rotation::free_motion;
use crate::forces::MotionBound;
use crate::state::{
    Bodies, Body, BodyPebble, FIXED, Load, PRESCRIBED, Particle, PebbleIndex, PrescribedBody,
};

/// Half kicks and a drift of bodies.
#[derive(Debug, Clone, Copy)]
pub struct BodyStep {
    /// Half the time step, s.
    pub half: f64,
    /// Drift, s.
    pub drift: f64,
    /// Half kicks.
    pub kicks: u32,
    /// m/s^2
    pub gravity: DVec3,
}

/// Bodies, or rows, that one thread takes at a time; what they give does not depend on it.
const CHUNK: usize = 512;

impl Bodies {
    /// Force and torque about the centre of mass of every body: F = sum F_p, T = sum (T_p + r_p x F_p), pebble by pebble in the
    /// order of the clump, whatever the rows. The levers r_p are those of the body, which no periodic face cuts.
    /// `pool`: with its threads; the result is the same.
    pub fn gather(&mut self, loads: &[Load], pool: Option<&ThreadPool>) {
        let pebbles = &self.pebbles[..];
        let gather = |body: &mut Body| {
            let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
            let rotation = DMat3::from_quat(body.orientation);
            for pebble in &pebbles[body.pebbles()] {
                let load = &loads[pebble.row.index()];
                force += load.force;
                torque += load.torque + (rotation * pebble.offset).cross(load.force);
            }
            body.load = Load::new(force, torque);
        };
        match pool {
            Some(pool) if self.all.len() > CHUNK => pool.install(|| {
                let chunks = self.all.par_chunks_mut(CHUNK);
                chunks.for_each(|bodies| bodies.iter_mut().for_each(gather));
            }),
            _ => self.all.iter_mut().for_each(gather),
        }
    }

    /// Kicks and drifts all bodies and puts the pebbles' `records` where they now are. Returns the largest speed of a pebble: its
    /// displacement over the drift, or without drift its velocity.
    pub fn advance(
        &mut self,
        records: &mut [Particle],
        step: &BodyStep,
        pool: Option<&ThreadPool>,
    ) -> MotionBound {
        match pool {
            Some(pool) if self.all.len() > CHUNK => pool.install(|| {
                let chunks = self.all.par_chunks_mut(CHUNK);
                chunks.for_each(|bodies| bodies.iter_mut().for_each(|body| step.advance(body)));
            }),
            _ => self.all.iter_mut().for_each(|body| step.advance(body)),
        }
        for prescribed in &self.prescribed {
            step.advance_prescribed(&mut self.all[prescribed.body.index()], prescribed);
        }
        let (all, pebbles) = (&self.all[..], &self.pebbles[..]);
        match pool {
            Some(pool) if records.len() > CHUNK => pool.install(|| {
                let chunks = records.par_chunks_mut(CHUNK);
                let chunks = chunks.zip(self.of_row.par_chunks(CHUNK));
                let put_chunk = |(records, of_row): (&mut [Particle], &[Option<PebbleIndex>])| {
                    let places = records.iter_mut().zip(of_row);
                    let pebbles_only =
                        places.filter_map(|(record, pebble)| Some((record, (*pebble)?)));
                    pebbles_only.fold(MotionBound::default(), |fastest, (record, pebble)| {
                        let pebble = &pebbles[pebble.index()];
                        let body = &all[pebble.body.index()];
                        fastest.merge(put(record, pebble, body, step))
                    })
                };
                chunks
                    .map(put_chunk)
                    .reduce(MotionBound::default, MotionBound::merge)
            }),
            _ => pebbles
                .iter()
                .fold(MotionBound::default(), |fastest, pebble| {
                    let record = &mut records[pebble.row.index()];
                    let body = &all[pebble.body.index()];
                    fastest.merge(put(record, pebble, body, step))
                }),
        }
    }
}

/// Puts a pebble where its body has it.
#[inline]
fn put(record: &mut Particle, pebble: &BodyPebble, body: &Body, step: &BodyStep) -> MotionBound {
    if body.flags & FIXED != 0 {
        return MotionBound::default();
    }
    let lever = body.orientation * pebble.offset;
    // Velocities are those of the middle of the drift, and so is the lever they go with.
    let earlier = body.angular_velocity.cross(lever) * (0.5 * step.drift);
    let velocity = body.velocity + body.angular_velocity.cross(lever - earlier);
    record.velocity = velocity;
    record.angular_velocity = body.angular_velocity;
    let mut squared_speed = velocity.length_squared();
    let sum_of_squares = squared_speed + body.angular_velocity.length_squared();
    if step.drift > 0.0 {
        let position = body.position + lever + pebble.shift;
        squared_speed = (position - record.position).length_squared() / (step.drift * step.drift);
        record.position = position;
    }
    MotionBound {
        squared_speed,
        sum_of_squares,
    }
}

impl BodyStep {
    /// A body that moves freely. The angular velocity afterwards is that of the middle of the drift, as the velocity is: the mean of
    /// those of the old and the new orientation.
    fn advance(&self, body: &mut Body) {
        if body.flags & (FIXED | PRESCRIBED) != 0 {
            return;
        }
        self.kick(body);
        body.position += body.velocity * self.drift;
        self.rotate(body);
    }

    /// The free rotation of a body over the drift.
    fn rotate(&self, body: &mut Body) {
        let before = body.orientation;
        let inverse = body.moments.recip();
        let momentum = before.inverse() * body.angular_momentum;
        body.angular_velocity = before * (momentum * inverse);
        if self.drift > 0.0 {
            let (after, momentum) = free_motion(before, momentum, inverse, self.drift);
            body.orientation = after;
            body.angular_velocity = (body.angular_velocity + after * (momentum * inverse)) * 0.5;
        }
    }

    fn kick(&self, body: &mut Body) {
        let kick = (body.load.force / body.mass + self.gravity) * self.half;
        let turn = body.load.torque * self.half;
        for _ in 0..self.kicks {
            body.velocity += kick;
            body.angular_momentum += turn;
        }
    }

    /// A body of which some components are prescribed: forces act on the free ones. Where a component of the angular velocity is
    /// prescribed the rotation is made by the midpoint rule, exact for a fixed axis, else of second order.
    fn advance_prescribed(&self, body: &mut Body, prescribed: &PrescribedBody) {
        self.kick(body);
        for axis in 0..3 {
            if let Some(velocity) = prescribed.velocity[axis] {
                body.velocity[axis] = velocity;
            }
        }
        body.position += body.velocity * self.drift;
        let spins = prescribed.angular_velocity;
        if spins == [None; 3] {
            self.rotate(body);
            return;
        }
        let mut middle = None;
        if self.drift > 0.0 {
            let start = body.orientation;
            let spin = constrained_spin(body, spins);
            body.orientation = turned(start, spin, 0.5 * self.drift);
            let spin = constrained_spin(body, spins);
            body.orientation = turned(start, spin, self.drift);
            middle = Some(spin);
        }
        let spin = constrained_spin(body, spins);
        body.angular_momentum = body.inertia_times(spin);
        body.angular_velocity = middle.unwrap_or(spin);
    }
}

/// The angular velocity whose prescribed components are `spins`, and whose angular momentum has the body's free components:
/// the constraint's torque acts along the prescribed axes only.
pub(crate) fn constrained_spin(body: &Body, spins: [Option<f64>; 3]) -> DVec3 {
    let rotation = DMat3::from_quat(body.orientation);
    let inertia = rotation * DMat3::from_diagonal(body.moments) * rotation.transpose();
    let (mut rows, mut right) = (inertia.transpose(), body.angular_momentum);
    for axis in 0..3 {
        if let Some(spin) = spins[axis] {
            *rows.col_mut(axis) = DVec3::AXES[axis];
            right[axis] = spin;
        }
    }
    rows.transpose().inverse() * right
}

/// `orientation` turned by a constant angular velocity over `time` seconds.
fn turned(orientation: DQuat, spin: DVec3, time: f64) -> DQuat {
    (by_vector(spin * time) * orientation).normalize()
}
