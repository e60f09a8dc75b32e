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
pub mod mixing;
pub mod normal;
pub mod parameter;
mod planned;
pub mod registry;
pub mod rolling;
pub mod tangential;
#[cfg(test)]
mod tests;

pub use adhesion::{
    AdhesionForce, AdhesionLaw, AnyAdhesion, AnyMemory, Bridge, BridgeEvent, Dry, EventOf, Held,
    LawEvents, Liquid, LiquidLaw, MemoryOf, NoAdhesion, NoEvents,
};
pub use any::OneOf;
pub use evaluation::{Action, FrictionNow, Histories, PairLaw};
pub use history::{History, HistoryNumber, TangentialSpring};
pub use normal::{AnyNormal, Hertz, Linear, NormalForce, NormalLaw, Plastic};
pub use planned::{
    PlannedNormal, PlannedRolling, PlannedTangential, Scale, SpringAndDashpot, StiffestTangential,
};
pub use rolling::{AnyRolling, Luding, NoRolling, RollingLaw};
pub use tangential::{
    AnyTangential, LinearFriction, Mindlin, MindlinRescaled, NoFriction, TangentialLaw,
};

use mercury_common::scene::LawKeys;
pub use mercury_common::scene::{CoulombLimits, SlidingNormal};

use crate::lanes::{Mask, Real, Vector};

/// Keys of every law, known to this version or refused by it: for reading scenes, and for the users' page.
#[must_use]
pub fn law_keys() -> Vec<&'static LawKeys> {
    let laws = [AnyNormal::KEYS, AnyTangential::KEYS, AnyRolling::KEYS];
    let laws = laws.concat();
    [&laws[..], &adhesion::liquid::KEYS, &adhesion::dry::KEYS].concat()
}

/// Geometry and kinematics of one contact, or of several in lanes, shared by all laws.
#[derive(Debug, Clone, Copy)]
pub struct Contact<L = f64> {
    /// Unit normal from B to A.
    pub normal: Vector<L>,
    /// Distance of the centres, or of the centre from the wall, m.
    pub distance: L,
    /// Overlap R_A + R_B - distance, m; positive where the two touch. Adhesion is evaluated at a gap too, which is -overlap.
    pub overlap: L,
    /// Effective radius R* = 1/(1/R_A + 1/R_B), m; R_A at a flat wall.
    pub effective_radius: L,
    /// Effective mass m* = 1/(1/m_A + 1/m_B), kg; infinitely heavy partners count 0.
    pub effective_mass: L,
    /// Normal component of the relative velocity at the contact point, m/s; positive when separating.
    pub normal_velocity: L,
    /// Tangential part of the relative velocity at the contact point, m/s: taken against `sliding_normal`, then turned into the
    /// plane of `normal`.
    pub tangential_velocity: Vector<L>,
    /// Unit normal at the time of the velocities, half a step before `normal`; the same as `normal` by the rule
    /// [`SlidingNormal::Step`].
    pub sliding_normal: Vector<L>,
    /// Distance at that time, m; the same as `distance` by that rule.
    pub sliding_distance: L,
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
            sliding_normal: self.sliding_normal.lane(k),
            sliding_distance: self.sliding_distance.lane(k),
            centre_velocity: self.centre_velocity.lane(k),
            spin: self.spin.lane(k),
        }
    }
}

impl Contact {
    /// The geometry `dt` (s) before, by the velocities, which are those of half a step before: of two particles to round-off.
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
        SpringRotation::Project => turn(spring, contact),
        SpringRotation::Incremental => {
            let along = spring.dot(contact.centre_velocity) / contact.sliding_distance;
            spring - contact.sliding_normal * (along * dt)
        }
    }
}

/// A spring in the tangent plane of the last step's normal, turned into that of the present one at its length.
///
/// The normal of the half step h halves the angle between the two normals. So the reflection s - 2 (s.h) h takes the old
/// tangent plane to the new one, and does there what the rotation from one normal to the other does: it is of second order
/// along any path, and needs neither root nor division. The remaining part along the normal is taken out, and the length is
/// restored where that is more than round-off: where a contact passes on to another face of a wall, and by the rule
/// [`SlidingNormal::Step`], whose h is the normal itself, so that this is a projection at constant length.
#[inline(always)]
fn turn<L: Real>(spring: Vector<L>, contact: &Contact<L>) -> Vector<L> {
    let half = contact.sliding_normal;
    let turned = spring - half * (spring.dot(half) * 2.0);
    let along = turned.dot(contact.normal);
    let mut flat = turned - contact.normal * along;
    let length_squared = turned.length_squared();
    // Below that the length changes by less than round-off.
    let far = (length_squared * 1e-16).below(along * along);
    if far.any() {
        flat = Vector::select(far, stretch_back(flat, length_squared), flat);
    }
    flat
}

impl<L: Real> Contact<L> {
    /// The part of a vector in the tangent plane.
    #[inline(always)]
    #[must_use]
    pub fn in_plane(&self, vector: Vector<L>) -> Vector<L> {
        vector - self.normal * vector.dot(self.normal)
    }
}

/// `flat` at the length of the spring that it is the projection of.
#[inline(always)]
fn stretch_back<L: Real>(flat: Vector<L>, length_squared: L) -> Vector<L> {
    let flat_squared = flat.length_squared();
    // A spring along the normal has no direction left in the tangent plane; its remainder is round-off.
    let lost = flat_squared.at_most(length_squared * 1e-24);
    Vector::select(lost, flat, flat * (length_squared / flat_squared).sqrt())
}
