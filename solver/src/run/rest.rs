//! When the particles have come to rest.

use crate::state::{FIXED, PEBBLE, PRESCRIBED, Particles};

/// Steps in a row that must be calm.
const STEPS: u32 = 1000;
/// Kinetic energy per particle that counts as calm, over m g d.
const SHARE: f64 = 1e-6;

/// Counts calm steps: those with a kinetic energy per free particle or body below 1e-6 m g d (mean mass and diameter, of bodies the
/// circumscribed one).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rest {
    /// Magnitude of gravity, m/s^2.
    gravity: f64,
    /// Moment of inertia over m R^2.
    inertia: f64,
    calm: u32,
}

impl Rest {
    pub(super) fn new(gravity: f64, inverse_inertia: f64) -> Self {
        Self {
            gravity,
            inertia: 1.0 / inverse_inertia,
            calm: 0,
        }
    }

    /// Whether enough calm steps have been counted.
    pub(super) fn is_over(&self) -> bool {
        self.calm >= STEPS
    }

    /// Whether one more calm step would be enough.
    pub(super) fn is_near(&self) -> bool {
        self.calm + 1 >= STEPS
    }

    /// Counts this step; whether the particles are at rest now. `expects_more`: particles are still to come.
    pub(super) fn is_reached(&mut self, particles: &Particles, expects_more: bool) -> bool {
        let (mut number, mut mass, mut diameter, mut doubled) = (0.0, 0.0, 0.0, 0.0);
        for (record, &m) in particles.records.iter().zip(&particles.masses) {
            if record.is_constrained() || record.flags & PEBBLE != 0 {
                continue;
            }
            let spin = record.radius * record.radius * record.angular_velocity.length_squared();
            number += 1.0;
            mass += m;
            diameter += 2.0 * record.radius;
            doubled += m * (record.velocity.length_squared() + self.inertia * spin);
        }
        for body in particles.bodies() {
            if body.flags & (FIXED | PRESCRIBED) != 0 {
                continue;
            }
            number += 1.0;
            mass += body.mass;
            diameter += 2.0 * body.radius;
            doubled += body.mass * body.velocity.length_squared() + 2.0 * body.rotational_energy();
        }
        let limit = SHARE * (mass / number) * self.gravity * (diameter / number);
        // Without free particles the limit is not a number, and nothing is calm.
        let calm = 0.5 * doubled / number < limit;
        self.calm = if calm && !expects_more {
            self.calm + 1
        } else {
            0
        };
        self.is_over()
    }
}

crate::state::plain!(Rest {
    gravity,
    inertia,
    calm
});
