//! Liquid with mass: what particles weigh, and the momentum that liquid takes along.
//!
//! A particle weighs its solid, its film, half of its bridges with particles and its bridges at walls. Liquid that goes from one particle to
//! another leaves with the velocity of the first, which does not change, and the second takes on its momentum; so the sum of all momenta
//! stays. Moments of inertia of spheres follow their masses, those of bodies stay those of the solid.

use glam::DVec3;

use super::{BridgeSite, Liquids, Sum};
use crate::contact::Bridge;
use crate::forces::Partner;
use crate::state::Particles;
use mercury_common::particle_properties::FILM_VOLUME;

/// The liquid of a scene in which it has mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    /// kg/m^3
    pub density: f64,
    /// m/s^2
    pub gravity: DVec3,
    /// By how much velocities are older than places, s.
    pub lag: f64,
}

/// Amounts that came from outside of the particles and went there since the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Weighed {
    /// kg
    pub mass: Sum,
    /// Energy that it brought, kinetic and of its height, J.
    pub energy: f64,
}

crate::state::plain!(Weighed { mass, energy });

/// Where liquid comes from, or goes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum End {
    /// The particle of a row.
    Row(u32),
    /// A wall, or the air: it goes there, or comes at the velocity of what takes it.
    Outside,
}

impl Weight {
    /// Mass (kg, negative: that leaves) is added to a particle, or to the body of a pebble; `velocity` (m/s): what comes has it, the particle's
    /// own if `None`. Gives the energy that the particle gains, J: kinetic, and of its height. Nothing that never moves takes any.
    pub fn add(
        &self,
        particles: &mut Particles,
        row: usize,
        mass: f64,
        velocity: Option<DVec3>,
    ) -> Option<f64> {
        if is_held(particles, row) || mass == 0.0 {
            return None;
        }
        let body = particles
            .bodies
            .as_ref()
            .and_then(|bodies| bodies.body_of_row(row));
        let of_height =
            |place: DVec3, velocity: DVec3| -mass * self.gravity.dot(place - velocity * self.lag);
        let gained;
        if let (Some(index), Some(bodies)) = (body, particles.bodies.as_mut()) {
            let body = &mut bodies.all[index.index()];
            let before = 0.5 * body.mass * body.velocity.length_squared();
            let after = body.mass + mass;
            if let Some(velocity) = velocity {
                body.velocity += (mass / after) * (velocity - body.velocity);
            }
            body.mass = after;
            gained = 0.5 * after * body.velocity.length_squared() - before
                + of_height(body.position, body.velocity);
            let range = body.pebbles();
            for pebble in &bodies.pebbles[range] {
                particles.records[pebble.row.index()].inverse_mass = 1.0 / after;
            }
            particles.masses[row] += mass;
        } else {
            let record = &mut particles.records[row];
            if record.inverse_mass == 0.0 {
                return None;
            }
            let before = particles.masses[row];
            let after = before + mass;
            let speeds = record.velocity.length_squared();
            if let Some(velocity) = velocity {
                record.velocity += (mass / after) * (velocity - record.velocity);
                // Liquid that comes does not turn.
                record.angular_velocity *= before / after;
            }
            gained = 0.5 * (after * record.velocity.length_squared() - before * speeds)
                + of_height(record.position, record.velocity);
            record.inverse_mass = 1.0 / after;
            particles.masses[row] = after;
        }
        Some(gained)
    }
}

/// Whether a particle does not move freely, so that its mass is of no account.
fn is_held(particles: &Particles, row: usize) -> bool {
    particles.is_fixed(row) || particles.is_prescribed(row)
}

/// Velocity of the particle of a row, or of its body, m/s.
fn velocity_of(particles: &Particles, row: usize) -> DVec3 {
    let bodies = particles.bodies.as_ref();
    let body = bodies.and_then(|bodies| Some((bodies, bodies.body_of_row(row)?)));
    match body {
        Some((bodies, index)) => bodies.all[index.index()].velocity,
        None => particles.records[row].velocity,
    }
}

impl Liquids {
    /// Liquid (m^3) goes from one end to the other: mass and momentum with it.
    pub(super) fn carry(&mut self, particles: &mut Particles, from: End, to: End, volume: f64) {
        let Some(weight) = self.weight else {
            return;
        };
        let mass = weight.density * volume;
        if from == to || mass == 0.0 {
            return;
        }
        let outside = [from, to].into_iter().any(|end| match end {
            End::Row(row) => is_held(particles, row as usize),
            End::Outside => true,
        });
        let mut gained = 0.0;
        let mut velocity = None;
        if let End::Row(row) = from {
            velocity = Some(velocity_of(particles, row as usize));
            if let Some(energy) = weight.add(particles, row as usize, -mass, None) {
                gained += energy;
                self.note_outside(outside, -mass);
            }
        }
        if let End::Row(row) = to
            && let Some(energy) = weight.add(particles, row as usize, mass, velocity)
        {
            gained += energy;
            self.note_outside(outside, mass);
        }
        if outside {
            self.balance.weighed.energy += gained;
        } else {
            self.balance.set_free -= gained;
        }
    }

    fn note_outside(&mut self, outside: bool, mass: f64) {
        if outside {
            self.balance.weighed.mass.add(mass);
        }
    }

    /// Particles from the row `first` on, which were added without liquid, weigh their films from now on, too.
    pub(super) fn weigh_films(&mut self, first: usize, particles: &mut Particles) {
        if self.weight.is_none() {
            return;
        }
        let films = particles.columns.get(FILM_VOLUME.name).unwrap_or_default();
        let films = films.get(first..).unwrap_or_default().to_vec();
        for (row, film) in (first..).zip(films) {
            self.carry(particles, End::Outside, End::Row(row as u32), film);
        }
    }

    /// Weighs bridges that were there before the run.
    pub fn weigh_bridges(&mut self, bridges: &[BridgeSite], particles: &mut Particles) {
        for site in bridges {
            for (end, volume) in shares(site, &site.memory) {
                self.carry(particles, End::Outside, end, volume);
            }
        }
    }

    /// Mass that came to particles from outside, films and bridges of the start included, kg.
    #[must_use]
    pub fn gained_mass(&self) -> f64 {
        self.balance.weighed.mass.value()
    }

    /// Whether liquid has mass.
    #[must_use]
    pub fn has_mass(&self) -> bool {
        self.weight.is_some()
    }
}

/// Volumes of a bridge that its two ends weigh, m^3: half each, a particle at a wall all of it.
pub(super) fn shares(site: &BridgeSite, bridge: &Bridge) -> [(End, f64); 2] {
    match site.partner {
        Partner::Particle { row, .. } => {
            let half = 0.5 * bridge.volume;
            [
                (End::Row(site.row), half),
                (End::Row(row), bridge.volume - half),
            ]
        }
        Partner::Wall { .. } => [(End::Row(site.row), bridge.volume), (End::Outside, 0.0)],
    }
}
