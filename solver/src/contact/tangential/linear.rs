//! The linear tangential spring and dashpot with Coulomb's limit.

use super::super::history::TangentialSpring;
use super::super::{Contact, SpringRotation, follow};
use super::{TangentialLaw, coulomb};
use crate::lanes::{Mask, Real, Vector};

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
    type History<L: Real> = TangentialSpring<L>;
    const ACTIVE: bool = true;

    fn name(&self) -> &'static str {
        "linear friction"
    }

    #[inline(always)]
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        normal_force: L,
        dt: f64,
        history: &mut TangentialSpring<L>,
    ) -> Vector<L> {
        let idle = normal_force.equals(L::ZERO);
        if idle.all() || self.friction == 0.0 {
            return Vector::ZERO;
        }
        let damping = contact.tangential_velocity * L::splat(self.dissipation);
        let (static_limit, dynamic_limit) = (
            normal_force * self.static_friction,
            normal_force * self.friction,
        );
        let (mut force, mut spring);
        if self.stiffness == 0.0 {
            (force, _) = coulomb(-damping, static_limit, dynamic_limit);
            spring = history.0;
        } else {
            let slides;
            let stiffness = L::splat(self.stiffness);
            spring = follow(self.rotation, history.0, contact, dt)
                + contact.tangential_velocity * L::splat(dt);
            let trial = -(spring * stiffness) - damping;
            (force, slides) = coulomb(trial, static_limit, dynamic_limit);
            if slides.any() {
                spring = Vector::select(slides, -(force + damping) / stiffness, spring);
            }
        }
        if idle.any() {
            force = Vector::select(idle, Vector::ZERO, force);
            spring = Vector::select(idle, history.0, spring);
        }
        history.0 = spring;
        force
    }

    #[inline(always)]
    fn stiffness<L: Real>(&self, _: &Contact<L>) -> L {
        L::splat(self.stiffness)
    }

    /// -|xi|.
    fn tangential_overlap(&self, _: &Contact, history: &TangentialSpring) -> f64 {
        -history.0.length()
    }

    fn energy<L: Real>(&self, _: &Contact<L>, history: &TangentialSpring<L>) -> L {
        history.0.length_squared() * (0.5 * self.stiffness)
    }
}
