//! The energies of a state.

use glam::DVec3;
use mercury_common::formats::ene::EnergyRow;

use super::FrameCopy;
use mercury_engine::state::inverse_inertia_factor;

/// The energies (J) and the centre of mass (m) of the particles and bodies that are not fixed, each summed in the order of ids. A body
/// counts once, with its own mass and tensor of inertia.
///
/// Gravitational energy is -sum m g.x, with positions inside the periodic domain.
#[must_use]
pub fn energies(state: &FrameCopy, gravity: DVec3, dimensions: u8) -> EnergyRow {
    let mut row = EnergyRow {
        time: state.time,
        elastic: state.observation.elastic_energy,
        ..EnergyRow::default()
    };
    let (mut mass, mut moment) = (0.0, DVec3::ZERO);
    for (rank, particle) in state.particles.iter().enumerate() {
        if state.is_fixed(rank) || state.is_pebble(rank) {
            continue;
        }
        let m = state.masses[rank];
        let inertia = m * particle.radius * particle.radius / inverse_inertia_factor(dimensions);
        mass += m;
        moment += m * particle.position;
        row.gravitational -= m * gravity.dot(particle.position);
        row.translational_kinetic += 0.5 * m * particle.velocity.length_squared();
        row.rotational_kinetic += 0.5 * inertia * particle.angular_velocity.length_squared();
    }
    for body in state.bodies.iter().filter(|body| !body.is_fixed()) {
        mass += body.mass;
        moment += body.mass * body.position;
        row.gravitational -= body.mass * gravity.dot(body.position);
        row.translational_kinetic += 0.5 * body.mass * body.velocity.length_squared();
        row.rotational_kinetic += body.rotational_energy();
    }
    row.center_of_mass = if mass > 0.0 {
        moment / mass
    } else {
        DVec3::NAN
    };
    row
}
