//! Contact laws: pure functions from geometry, kinematics, parameters and history to forces.
//!
//! One law per file. A pair's interaction is a [`PairLaw`] put together from a [`NormalLaw`], a
//! [`TangentialLaw`], a [`RollingLaw`] and an [`AdhesionLaw`]; a part that a scene does not need is a type of size zero
//! ([`NoFriction`], [`NoRolling`], [`NoAdhesion`]), so that it costs neither time nor memory. `forces` picks the
//! instance.
//!
//! Laws are written over [`Real`] numbers: as `f64` for one contact, in lanes for several, of which each gets the bits that it
//! would get alone ([`crate::lanes`]). Parameters are plain numbers, the same for all lanes.
//!
//! Conventions (A = the particle of the lower row, B = its partner or the wall): the normal points from
//! B to A, velocities are those of A relative to B at the contact point x_A - (R_A - overlap/2) n.

pub mod adhesion;
mod any;
mod evaluation;
mod history;
mod liquid;
pub mod mixing;
pub mod normal;
pub mod parameter;
mod planned;
pub mod registry;
pub mod rolling;
pub mod tangential;
#[cfg(test)]
mod tests;

pub use adhesion::{AdhesionLaw, AnyAdhesion, NoAdhesion};
pub use any::OneOf;
pub use evaluation::{Action, Histories, PairLaw};
pub use history::{History, HistoryNumber, TangentialSpring};
pub use normal::{AnyNormal, Hertz, Linear, NormalForce, NormalLaw, Plastic};
pub use planned::{
    PlannedNormal, PlannedRolling, PlannedTangential, SpringAndDashpot, StiffestTangential,
};
pub use rolling::{AnyRolling, Luding, NoRolling, RollingLaw};
pub use tangential::{
    AnyTangential, LinearFriction, Mindlin, MindlinRescaled, NoFriction, TangentialLaw,
};

pub use mercury_common::scene::CoulombLimits;
use mercury_common::scene::LawKeys;

use crate::lanes::{Mask, Real, Vector};

/// What scenes can say of every law, known to this version or refused by it: for reading scenes, and for the users' page.
#[must_use]
pub fn law_keys() -> Vec<&'static LawKeys> {
    let laws = [AnyNormal::KEYS, AnyTangential::KEYS, AnyRolling::KEYS];
    [&laws.concat()[..], &liquid::KEYS].concat()
}

/// Geometry and kinematics of one contact, or of several in lanes, shared by all laws.
#[derive(Debug, Clone, Copy)]
pub struct Contact<L = f64> {
    /// Unit normal from B to A.
    pub normal: Vector<L>,
    /// Distance of the centres, or of the centre from the wall, m.
    pub distance: L,
    /// Overlap R_A + R_B - distance, m; positive where the two touch. Adhesion is asked at a gap too, which is -overlap.
    pub overlap: L,
    /// Effective radius R* = 1/(1/R_A + 1/R_B), m; R_A at a flat wall.
    pub effective_radius: L,
    /// Effective mass m* = 1/(1/m_A + 1/m_B), kg; infinitely heavy partners count 0.
    pub effective_mass: L,
    /// Normal component of the relative velocity at the contact point, m/s; positive when separating.
    pub normal_velocity: L,
    /// Tangential part of the relative velocity at the contact point, m/s.
    pub tangential_velocity: Vector<L>,
    /// Relative velocity of the centres, m/s; zero at walls, whose springs do not turn with the pair.
    pub centre_velocity: Vector<L>,
    /// Relative angular velocity, rad/s.
    pub spin: Vector<L>,
}

impl<L: Real> Contact<L> {
    /// Radius of the contact area by Hertz, a = sqrt(R* overlap), m.
    #[inline(always)]
    #[must_use]
    pub fn contact_radius(&self) -> L {
        (self.effective_radius * self.overlap).sqrt()
    }
}

impl<L: Real> Contact<L> {
    /// The contact in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, k: usize) -> Contact {
        Contact {
            normal: self.normal.lane(k),
            distance: self.distance.lane(k),
            overlap: self.overlap.lane(k),
            effective_radius: self.effective_radius.lane(k),
            effective_mass: self.effective_mass.lane(k),
            normal_velocity: self.normal_velocity.lane(k),
            tangential_velocity: self.tangential_velocity.lane(k),
            centre_velocity: self.centre_velocity.lane(k),
            spin: self.spin.lane(k),
        }
    }
}

impl Contact {
    /// The geometry `dt` (s) before, as the velocities, which are those of half a step before, say: of two particles to round-off.
    #[must_use]
    pub fn one_step_before(&self, dt: f64) -> Self {
        let way = self.centre_velocity * dt;
        let distance = if way.length_squared() > 0.0 {
            (self.normal * self.distance - way).length()
        } else {
            self.distance - self.normal_velocity * dt
        };
        Self {
            distance,
            overlap: self.overlap + (self.distance - distance),
            ..*self
        }
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
fn follow<L: Real>(
    rotation: SpringRotation,
    spring: Vector<L>,
    contact: &Contact<L>,
    dt: f64,
) -> Vector<L> {
    match rotation {
        SpringRotation::Project => project(spring, contact),
        SpringRotation::Incremental => {
            let along = spring.dot(contact.centre_velocity) / contact.distance;
            spring - contact.normal * (along * dt)
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
fn project<L: Real>(spring: Vector<L>, contact: &Contact<L>) -> Vector<L> {
    let length_squared = spring.length_squared();
    let least = contact.effective_radius * 1e-12;
    let short = length_squared.at_most(least * least);
    if short.all() {
        return spring;
    }
    // The division waits for the spring alone, not for the normal.
    let inverse = L::ONE / length_squared;
    let along = spring.dot(contact.normal);
    let flat = spring - contact.normal * along;
    let q = along * along * inverse;
    let far = !(q.below(L::splat(1e-5)) | short);
    // the next term is 35/128 q^4 < 3e-21
    let mut projected = flat * ((q * 0.5 + q * q * (q * 0.3125 + 0.375)) + 1.0);
    if far.any() {
        projected = Vector::select(far, stretch_back(flat, length_squared), projected);
    }
    if short.any() {
        projected = Vector::select(short, spring, projected);
    }
    projected
}

/// `flat` at the length of the spring that it is the projection of.
#[cold]
fn stretch_back<L: Real>(flat: Vector<L>, length_squared: L) -> Vector<L> {
    let flat_squared = flat.length_squared();
    // A spring along the normal has no direction left in the tangent plane; its remainder is round-off.
    let lost = flat_squared.at_most(length_squared * 1e-24);
    Vector::select(lost, flat, flat * (length_squared / flat_squared).sqrt())
}
