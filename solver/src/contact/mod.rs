//! Contact laws: pure functions from geometry, kinematics, parameters and history to forces.
//!
//! One law per file. A pair's interaction is a [`PairLaw`] put together from a [`NormalLaw`], a
//! [`TangentialLaw`] and a [`RollingLaw`]; a part that a scene does not need is a type of size zero
//! ([`NoFriction`], [`NoRolling`]), so that it costs neither time nor memory. `registry` picks the
//! instance.
//!
//! Conventions (A = the particle of the lower row, B = its partner or the wall): the normal points from
//! B to A, velocities are those of A relative to B at the contact point x_A - (R_A - overlap/2) n.

mod evaluation;
mod history;
pub mod normal;
pub mod registry;
pub mod rolling;
pub mod tangential;

pub use evaluation::{Action, PairLaw};
pub use history::{History, HistoryNumber};
pub use normal::{AnyNormal, Hertz, Linear, NormalForce, NormalLaw, Plastic};
pub use rolling::{AnyRolling, Luding, NoRolling, RollingLaw};
pub use tangential::{
    AnyTangential, LinearFriction, Mindlin, MindlinRescaled, NoFriction, TangentialLaw,
};

use glam::DVec3;

/// Geometry and kinematics of one contact, shared by all laws.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// Unit normal from B to A.
    pub normal: DVec3,
    /// Distance of the centres, or of the centre from the wall, m.
    pub distance: f64,
    /// Overlap R_A + R_B - distance, m; positive.
    pub overlap: f64,
    /// Effective radius R* = 1/(1/R_A + 1/R_B), m; R_A at a flat wall.
    pub effective_radius: f64,
    /// Effective mass m* = 1/(1/m_A + 1/m_B), kg; infinitely heavy partners count 0.
    pub effective_mass: f64,
    /// Normal component of the relative velocity at the contact point, m/s; positive when separating.
    pub normal_velocity: f64,
    /// Tangential part of the relative velocity at the contact point, m/s.
    pub tangential_velocity: DVec3,
    /// Relative velocity of the centres, m/s; zero at walls, whose springs do not turn with the pair.
    pub centre_velocity: DVec3,
    /// Relative angular velocity, rad/s.
    pub spin: DVec3,
}

impl Contact {
    /// Radius of the contact area by Hertz, a = sqrt(R* overlap), m.
    #[inline(always)]
    #[must_use]
    pub fn contact_radius(&self) -> f64 {
        (self.effective_radius * self.overlap).sqrt()
    }
}

/// How a spring that was stretched in the tangent plane follows the contact as it turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SpringRotation {
    /// Projected on the new tangent plane and brought back to its old length.
    #[default]
    Project,
    /// Turned by the infinitesimal rotation of the pair in this step; not at all at walls (MercuryDPM's linear law).
    Incremental,
}

/// The spring after it followed the contact's rotation, before it is stretched by this step's motion.
#[inline(always)]
fn follow(rotation: SpringRotation, spring: DVec3, contact: &Contact, dt: f64) -> DVec3 {
    match rotation {
        SpringRotation::Project => project(spring, contact),
        SpringRotation::Incremental => {
            spring - contact.normal * (spring.dot(contact.centre_velocity) / contact.distance * dt)
        }
    }
}

/// Projects a spring on the tangent plane and brings it back to its old length.
///
/// Springs shorter than 1e-12 R* are left alone: their direction carries no information.
///
/// With q = (xi.n)^2/|xi|^2 the length grows back by 1/sqrt(1 - q). In one step a contact turns little, so that the first
/// terms of the series are exact to round-off; unlike a root they keep the chain of dependent operations short.
#[inline(always)]
fn project(spring: DVec3, contact: &Contact) -> DVec3 {
    let length_squared = spring.length_squared();
    let least = 1e-12 * contact.effective_radius;
    if length_squared <= least * least {
        return spring;
    }
    // The division waits for the spring alone, not for the normal.
    let inverse = 1.0 / length_squared;
    let along = spring.dot(contact.normal);
    let flat = spring - contact.normal * along;
    let q = along * along * inverse;
    if q < 1e-5 {
        // the next term is 35/128 q^4 < 3e-21
        flat * (1.0 + (0.5 * q + q * q * (0.375 + 0.3125 * q)))
    } else {
        stretch_back(flat, length_squared)
    }
}

/// `flat` at the length of the spring that it is the projection of.
#[cold]
fn stretch_back(flat: DVec3, length_squared: f64) -> DVec3 {
    let flat_squared = flat.length_squared();
    // A spring along the normal has no direction left in the tangent plane; its remainder is round-off.
    if flat_squared <= 1e-24 * length_squared {
        return flat;
    }
    flat * (length_squared / flat_squared).sqrt()
}
