//! A rolling law chosen at run time, for scenes in which pairs of materials differ in law.

use super::{Contact, Luding, RollingLaw, RollingSprings};
use crate::lanes::{Real, Vector};

/// One of the rolling laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyRolling {
    /// None.
    None,
    /// Virtual springs.
    Luding(Luding),
}

impl RollingLaw for AnyRolling {
    type History<L: Real> = RollingSprings<L>;
    const ACTIVE: bool = true;

    #[inline]
    fn couple<L: Real>(
        &self,
        contact: &Contact<L>,
        normal_force: L,
        tangential_stiffness: L,
        dt: f64,
        history: &mut RollingSprings<L>,
    ) -> Vector<L> {
        match self {
            Self::None => Vector::ZERO,
            Self::Luding(law) => {
                law.couple(contact, normal_force, tangential_stiffness, dt, history)
            }
        }
    }

    fn energy<L: Real>(&self, tangential_stiffness: L, history: &RollingSprings<L>) -> L {
        match self {
            Self::None => L::ZERO,
            Self::Luding(law) => law.energy(tangential_stiffness, history),
        }
    }
}
