//! Mindlin's stiffness with a stored force that shrinks with the contact area.

use super::super::{Contact, History, HistoryNumber, turn};
use super::TangentialLaw;
use super::coulomb::Slider;
use crate::contact::StiffestTangential;
use crate::lanes::{Mask, Real, Vector};

/// The stored force grows by -s k_t u_t dt, k_t = 8 G* a, and shrinks in proportion to the contact radius a while that
/// shrinks, so that unloading cannot create energy (Thornton, Cummins & Cleary 2013, section 2.3; Elata & Berryman 1996).
///
/// Order in a step: the stored force follows the contact's rotation, is rescaled if a < a_old, incremented with k_t at the smaller
/// of a and the mean of a and a_old, which is of second order in the step, and cut at Coulomb's limit; damping as in [`super::Mindlin`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MindlinRescaled {
    /// The parameters are those of the plain law.
    pub plain: super::Mindlin,
}

/// Stored tangential force on A (N) and the contact radius at which it was stored (m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StoredForce<L = f64> {
    /// Elastic force, N.
    pub force: Vector<L>,
    /// Contact radius a in the last step, m.
    pub contact_radius: L,
}

impl<L: Real> History<L> for StoredForce<L> {
    type One = StoredForce;
    const LENGTH: usize = 4;

    fn columns() -> Vec<HistoryNumber> {
        vec![
            ("N", "stored tangential force x"),
            ("N", "stored tangential force y"),
            ("N", "stored tangential force z"),
            ("m", "contact radius it belongs to"),
        ]
    }

    fn swapped(self) -> Self {
        Self {
            force: -self.force,
            ..self
        }
    }

    fn write(&self, numbers: &mut Vec<L>) {
        numbers.extend(self.force.to_array());
        numbers.push(self.contact_radius);
    }

    fn read(numbers: &[L]) -> Self {
        Self {
            force: Vector::from_slice(numbers),
            contact_radius: numbers[3],
        }
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> StoredForce) -> Self {
        Self {
            force: Vector::gather(|k| one(k).force),
            contact_radius: L::from_lanes(|k| one(k).contact_radius),
        }
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> StoredForce {
        StoredForce {
            force: self.force.lane(k),
            contact_radius: self.contact_radius.lane(k),
        }
    }
}

impl TangentialLaw for MindlinRescaled {
    type History<L: Real> = StoredForce<L>;
    const ACTIVE: bool = true;

    fn name(&self) -> &'static str {
        "rescaled mindlin"
    }

    #[inline(always)]
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        normal_force: L,
        dt: f64,
        history: &mut StoredForce<L>,
    ) -> Vector<L> {
        let law = &self.plain;
        let idle = Slider::idle(law.limits, normal_force);
        if idle.all() || law.friction == 0.0 {
            return Vector::ZERO;
        }
        let before = *history;
        let radius = contact.contact_radius();
        let stiffness = law.stiffness(contact) * law.stiffness_factor;
        let dashpot = (contact.effective_mass * law.stiffness(contact)).sqrt() * law.damping;
        // The stored force has the dimension of a spring times its stiffness; `turn` only needs a length
        // to tell a direction from round-off.
        let mut elastic = turn(before.force / stiffness, contact) * stiffness;
        let shrinks = radius.below(before.contact_radius);
        if shrinks.any() {
            let smaller = elastic * (radius / before.contact_radius);
            elastic = Vector::select(shrinks, smaller, elastic);
        }
        // An increment in the middle of the step meets the stiffness of that time, and shrinks for the other half of the step. A
        // new contact has no radius before.
        let grows = L::ZERO.below(before.contact_radius) & !shrinks;
        let mean = stiffness * ((before.contact_radius / radius + 1.0) * 0.5);
        let middle = L::select(grows, mean, stiffness);
        elastic -= contact.tangential_velocity * (middle * dt);
        let damping = contact.tangential_velocity * dashpot;
        let slider = Slider::new(law.limits, normal_force, law.friction, law.static_friction);
        let limited = slider.limit(elastic, damping);
        let (mut force, mut stored) = (limited.force, elastic);
        if limited.slides.any() {
            stored = Vector::select(limited.slides, limited.carried, elastic);
        }
        *history = StoredForce {
            force: stored,
            contact_radius: radius,
        };
        if idle.any() {
            force = Vector::select(idle, Vector::ZERO, force);
            history.force = Vector::select(idle, before.force, stored);
            history.contact_radius = L::select(idle, before.contact_radius, radius);
        }
        force
    }

    #[inline(always)]
    fn stiffness<L: Real>(&self, contact: &Contact<L>) -> L {
        self.plain.stiffness(contact)
    }

    /// The sum of the components of the spring that would store the same force at the present stiffness.
    fn tangential_overlap(&self, contact: &Contact, history: &StoredForce) -> f64 {
        let stiffness = self.plain.stiffness_factor * self.plain.stiffness(contact);
        let force = history.force;
        -(force.x + force.y + force.z) / stiffness
    }

    fn slip(
        &self,
        contact: &Contact,
        normal_force: f64,
        dt: f64,
        [before, after]: [&StoredForce; 2],
    ) -> f64 {
        let mut unlimited = *before;
        let law = Self {
            plain: self.plain.without_limit(),
        };
        law.force(contact, normal_force, dt, &mut unlimited);
        let stiffness = self.plain.stiffness(contact) * self.plain.stiffness_factor;
        (unlimited.force - after.force).length() / stiffness
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, history: &StoredForce<L>) -> L {
        let stiffness = self.plain.stiffness(contact) * self.plain.stiffness_factor;
        let stored = history.force.length_squared() * 0.5 / stiffness;
        L::select(L::ZERO.below(stiffness), stored, L::ZERO)
    }
}

impl MindlinRescaled {
    /// As of the plain law.
    pub(super) fn stiffest(&self, effective_mass: f64, radius: f64) -> StiffestTangential {
        self.plain.stiffest(effective_mass, radius)
    }
}
