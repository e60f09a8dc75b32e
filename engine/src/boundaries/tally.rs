//! Counters for the particles that cross a boundary.

use glam::DVec3;

use super::passage::Look;

/// Sums over the particles that came in or went out somewhere. Velocities are those at the time of the event, which in the
/// leapfrog order of a time step (kick, drift, boundaries, kick) is half a step before that of the positions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    /// Particles.
    pub number: u64,
    /// kg (per metre in 2D).
    pub mass: f64,
    /// m^3 (m^2 in 2D).
    pub volume: f64,
    /// Momentum, kg m/s.
    pub momentum: DVec3,
    /// Mass times position, kg m: minus its product with gravity is the potential energy.
    pub mass_moment: DVec3,
    /// Translational kinetic energy, J.
    pub kinetic: f64,
    /// Rotational kinetic energy, J.
    pub rotational: f64,
}

impl Tally {
    /// Counts a particle, or a body once for all its pebbles.
    pub(super) fn count(&mut self, grain: &Look) {
        self.number += 1;
        self.mass += grain.mass;
        self.volume += grain.volume;
        self.momentum += grain.mass * grain.velocity;
        self.mass_moment += grain.mass * grain.position;
        self.kinetic += 0.5 * grain.mass * grain.velocity.length_squared();
        self.rotational += grain.rotational;
    }

    /// Adds the counts of another one.
    pub fn add(&mut self, other: &Self) {
        self.number += other.number;
        self.mass += other.mass;
        self.volume += other.volume;
        self.momentum += other.momentum;
        self.mass_moment += other.mass_moment;
        self.kinetic += other.kinetic;
        self.rotational += other.rotational;
    }
}

crate::state::plain!(Tally {
    number,
    mass,
    volume,
    momentum,
    mass_moment,
    kinetic,
    rotational
});
