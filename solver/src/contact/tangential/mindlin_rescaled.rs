//! Mindlin's stiffness with a stored force that shrinks with the contact area.

use glam::DVec3;

use super::super::{Contact, History, HistoryNumber, project};
use super::{TangentialLaw, coulomb};

/// The stored force grows by -s k_t u_t dt, k_t = 8 G* a, and shrinks in proportion to the contact radius a while that
/// shrinks, so that unloading cannot create energy (Thornton, Cummins & Cleary 2013, section 2.3; Elata & Berryman 1996).
///
/// Order in a step: the stored force follows the contact's rotation, is rescaled if a < a_old, incremented, and cut at
/// Coulomb's limit; damping as in [`super::Mindlin`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MindlinRescaled {
    /// The parameters are those of the plain law.
    pub plain: super::Mindlin,
}

/// Stored tangential force on A (N) and the contact radius at which it was stored (m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StoredForce {
    /// Elastic force, N.
    pub force: DVec3,
    /// Contact radius a in the last step, m.
    pub contact_radius: f64,
}

impl History for StoredForce {
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

    fn write(&self, numbers: &mut Vec<f64>) {
        numbers.extend(self.force.to_array());
        numbers.push(self.contact_radius);
    }

    fn read(numbers: &[f64]) -> Self {
        Self {
            force: DVec3::from_slice(numbers),
            contact_radius: numbers[3],
        }
    }
}

impl TangentialLaw for MindlinRescaled {
    type History = StoredForce;
    const ACTIVE: bool = true;

    #[inline(always)]
    fn force(
        &self,
        contact: &Contact,
        normal_force: f64,
        dt: f64,
        history: &mut StoredForce,
    ) -> DVec3 {
        let law = &self.plain;
        if normal_force == 0.0 || law.friction == 0.0 {
            return DVec3::ZERO;
        }
        let radius = contact.contact_radius();
        let stiffness = law.stiffness_factor * law.stiffness(contact);
        let dashpot = law.damping * (contact.effective_mass * law.stiffness(contact)).sqrt();
        // The stored force has the dimension of a spring times its stiffness; `project` only needs a length
        // to tell a direction from round-off.
        let mut elastic = project(history.force / stiffness, contact) * stiffness;
        if radius < history.contact_radius {
            elastic *= radius / history.contact_radius;
        }
        elastic -= contact.tangential_velocity * (stiffness * dt);
        let damping = contact.tangential_velocity * dashpot;
        let (static_limit, dynamic_limit) = (
            law.static_friction * normal_force,
            law.friction * normal_force,
        );
        history.contact_radius = radius;
        if law.cap_total {
            let (force, slides) = coulomb(elastic - damping, static_limit, dynamic_limit);
            history.force = if slides { force + damping } else { elastic };
            force
        } else {
            let (force, slides) = coulomb(elastic, static_limit, dynamic_limit);
            history.force = force;
            if slides { force } else { force - damping }
        }
    }

    #[inline(always)]
    fn stiffness(&self, contact: &Contact) -> f64 {
        self.plain.stiffness(contact)
    }

    /// The sum of the components of the spring that would store the same force at the present stiffness.
    fn tangential_overlap(&self, contact: &Contact, history: &StoredForce) -> f64 {
        let stiffness = self.plain.stiffness_factor * self.plain.stiffness(contact);
        let force = history.force;
        -(force.x + force.y + force.z) / stiffness
    }

    fn energy(&self, contact: &Contact, history: &StoredForce) -> f64 {
        let stiffness = self.plain.stiffness_factor * self.plain.stiffness(contact);
        if stiffness > 0.0 {
            0.5 * history.force.length_squared() / stiffness
        } else {
            0.0
        }
    }
}
