//! The linear tangential spring and dashpot with Coulomb's limit.

use glam::DVec3;

use super::super::history::TangentialSpring;
use super::super::{Contact, SpringRotation, follow};
use super::{TangentialLaw, coulomb};

/// f = -k_t xi - gamma_t u_t, the whole of it cut at mu N (Cundall & Strack 1979; Luding 2008, eqs. 22-24).
///
/// The spring xi follows the contact as it turns and is stretched by u_t dt; when it slides it is set back to what
/// the force it may carry needs. A static friction above the dynamic one gives stick-slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearFriction {
    /// k_t, N/m; 0 leaves only the dashpot.
    pub stiffness: f64,
    /// gamma_t, kg/s.
    pub dissipation: f64,
    /// mu while sliding.
    pub friction: f64,
    /// mu while sticking.
    pub static_friction: f64,
    /// How the spring turns with the contact.
    pub rotation: SpringRotation,
}

impl TangentialLaw for LinearFriction {
    type History = TangentialSpring;
    const ACTIVE: bool = true;

    #[inline(always)]
    fn force(
        &self,
        contact: &Contact,
        normal_force: f64,
        dt: f64,
        history: &mut TangentialSpring,
    ) -> DVec3 {
        if normal_force == 0.0 || self.friction == 0.0 {
            return DVec3::ZERO;
        }
        let damping = contact.tangential_velocity * self.dissipation;
        let (static_limit, dynamic_limit) = (
            self.static_friction * normal_force,
            self.friction * normal_force,
        );
        if self.stiffness == 0.0 {
            return coulomb(-damping, static_limit, dynamic_limit).0;
        }
        let spring =
            follow(self.rotation, history.0, contact, dt) + contact.tangential_velocity * dt;
        let (force, slides) = coulomb(
            -(spring * self.stiffness) - damping,
            static_limit,
            dynamic_limit,
        );
        history.0 = if slides {
            -(force + damping) / self.stiffness
        } else {
            spring
        };
        force
    }

    #[inline(always)]
    fn stiffness(&self, _: &Contact) -> f64 {
        self.stiffness
    }

    /// -|xi|.
    fn tangential_overlap(&self, _: &Contact, history: &TangentialSpring) -> f64 {
        -history.0.length()
    }

    fn energy(&self, _: &Contact, history: &TangentialSpring) -> f64 {
        0.5 * self.stiffness * history.0.length_squared()
    }
}
