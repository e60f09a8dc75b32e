//! Normal force laws.

#[macro_use]
mod any;
mod elastic;
mod hertz;
mod linear;
mod plastic;

pub(crate) use elastic::elastic_pair;
pub use elastic::{effective_modulus, effective_shear_modulus, rayleigh_time};
pub use hertz::{Hertz, hertz_damping};
pub use linear::{Linear, damping_ratio, damping_ratio_clamped, restitution_clamped};
pub use plastic::{MaxOverlap, Plastic};

use super::{Contact, History, HistoryNumber};
use crate::lanes::Real;

// The laws that a scene can name.
normal_laws!(Hertz(Hertz), Linear(Linear), Plastic(Plastic));

/// Normal force on A along the normal, N; positive pushes A away from B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalForce<L = f64> {
    /// Depends on the overlap and its history alone.
    pub elastic: L,
    /// Depends on the normal velocity.
    pub viscous: L,
}

impl<L: Real> NormalForce<L> {
    /// No force.
    pub const NONE: Self = Self {
        elastic: L::ZERO,
        viscous: L::ZERO,
    };

    /// `force(k)` in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn gather(force: impl Fn(usize) -> NormalForce) -> Self {
        Self {
            elastic: L::from_lanes(|k| force(k).elastic),
            viscous: L::from_lanes(|k| force(k).viscous),
        }
    }

    /// That in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn lane(self, k: usize) -> NormalForce {
        NormalForce {
            elastic: self.elastic.lane(k),
            viscous: self.viscous.lane(k),
        }
    }

    /// Elastic and viscous force, N.
    #[inline(always)]
    #[must_use]
    pub fn total(self) -> L {
        self.elastic + self.viscous
    }

    /// This force without tension: the viscous part is cut so that the sum is never below zero.
    #[inline(always)]
    #[must_use]
    fn clamped(self) -> Self {
        Self {
            elastic: self.elastic,
            viscous: self.viscous.max(-self.elastic),
        }
    }
}

/// A normal law; its fields are its parameters for one pair of materials.
pub trait NormalLaw: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Memory of the law.
    type History<L: Real>: History<L, One = Self::History<f64>>;

    /// How the plan and the log call it.
    fn name(&self) -> &'static str;

    /// Unit and meaning of the numbers of its history.
    fn columns(&self) -> Vec<HistoryNumber> {
        <Self::History<f64> as History>::columns()
    }

    /// The force at this contact; called for overlap > 0 only.
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        history: &mut Self::History<L>,
    ) -> NormalForce<L>;

    /// Whether its elastic part follows one curve there and back, so that it takes no energy.
    fn is_elastic(&self) -> bool {
        true
    }

    /// Whether viscous forces are cut where they would pull.
    fn clamps_tension(&self) -> bool {
        false
    }

    /// Energy that unloading would give back, J.
    fn energy<L: Real>(&self, contact: &Contact<L>, history: &Self::History<L>) -> L;
}
