//! Mindlin's tangential stiffness with a spring that forgets the load at which it was stretched.

use super::super::history::TangentialSpring;
use super::super::{Contact, project};
use super::{TangentialLaw, coulomb};
use crate::lanes::{Mask, Real, Vector};

/// f = -s k_t xi with k_t = 8 G* a, a = sqrt(R* overlap), taken at the present overlap, cut at mu N; while it sticks a
/// dashpot beta_t sqrt(m* k_t) u_t is added (Mindlin 1949; Di Renzo & Di Maio 2005, eq. 17 for s = 2/3;
/// Thornton et al. 2023, eqs. 4.5-4.8).
///
/// s = 1 is Mindlin's no-slip stiffness at constant load; s = 2/3, the default, is exact where xi grows in proportion to
/// the overlap. Because k_t follows the overlap while xi stays, unloading gives back more or less than loading took:
/// [`super::MindlinRescaled`] cures that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mindlin {
    /// G*, Pa.
    pub effective_shear_modulus: f64,
    /// s.
    pub stiffness_factor: f64,
    /// beta_t.
    pub damping: f64,
    /// mu while sliding.
    pub friction: f64,
    /// mu while sticking.
    pub static_friction: f64,
    /// Cut elastic and viscous part together at mu N, instead of the elastic part alone.
    pub cap_total: bool,
    /// 8 G*, Pa.
    stiffness_per_radius: f64,
    /// beta_t sqrt(8 G*), so that the dashpot is `dashpot` sqrt(m* a).
    dashpot: f64,
}

impl Mindlin {
    /// From G* (Pa), the factor s, beta_t and the two friction coefficients.
    #[must_use]
    pub fn new(
        effective_shear_modulus: f64,
        stiffness_factor: f64,
        damping: f64,
        friction: f64,
        static_friction: f64,
    ) -> Self {
        let stiffness_per_radius = 8.0 * effective_shear_modulus;
        Self {
            effective_shear_modulus,
            stiffness_factor,
            damping,
            friction,
            static_friction,
            cap_total: false,
            stiffness_per_radius,
            dashpot: damping * stiffness_per_radius.sqrt(),
        }
    }
}

impl TangentialLaw for Mindlin {
    type History<L: Real> = TangentialSpring<L>;
    const ACTIVE: bool = true;

    fn name(&self) -> &'static str {
        "mindlin"
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
        let radius = contact.contact_radius();
        let stiffness = radius * (self.stiffness_factor * self.stiffness_per_radius);
        let dashpot = (contact.effective_mass * radius).sqrt() * self.dashpot;
        let mut spring = project(history.0, contact) + contact.tangential_velocity * L::splat(dt);
        let elastic = -(spring * stiffness);
        let damping = contact.tangential_velocity * dashpot;
        let (static_limit, dynamic_limit) = (
            normal_force * self.static_friction,
            normal_force * self.friction,
        );
        let (mut force, slides);
        if self.cap_total {
            (force, slides) = coulomb(elastic - damping, static_limit, dynamic_limit);
            if slides.any() {
                spring = Vector::select(slides, -(force + damping) / stiffness, spring);
            }
        } else {
            (force, slides) = coulomb(elastic, static_limit, dynamic_limit);
            if slides.any() {
                spring = Vector::select(slides, -force / stiffness, spring);
            }
            if !slides.all() {
                force = Vector::select(slides, force, force - damping);
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
    fn stiffness<L: Real>(&self, contact: &Contact<L>) -> L {
        contact.contact_radius() * self.stiffness_per_radius
    }

    /// The sum of the components, a convention of MercuryDPM that shows the sign in plane problems.
    fn tangential_overlap(&self, _: &Contact, history: &TangentialSpring) -> f64 {
        history.0.x + history.0.y + history.0.z
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, history: &TangentialSpring<L>) -> L {
        self.stiffness(contact) * (0.5 * self.stiffness_factor) * history.0.length_squared()
    }
}
