//! A normal law chosen at run time, for scenes in which pairs of materials differ in law.

use super::{Contact, Hertz, Linear, MaxOverlap, NormalForce, NormalLaw, Plastic};
use crate::lanes::Real;

/// One of the normal laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyNormal {
    /// Spring and dashpot.
    Linear(Linear),
    /// Hertz.
    Hertz(Hertz),
    /// Elasto-plastic.
    Plastic(Plastic),
}

impl NormalLaw for AnyNormal {
    type History<L: Real> = MaxOverlap<L>;

    #[inline]
    fn force<L: Real>(&self, contact: &Contact<L>, history: &mut MaxOverlap<L>) -> NormalForce<L> {
        match self {
            Self::Linear(law) => law.force(contact, &mut ()),
            Self::Hertz(law) => law.force(contact, &mut ()),
            Self::Plastic(law) => law.force(contact, history),
        }
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, history: &MaxOverlap<L>) -> L {
        match self {
            Self::Linear(law) => law.energy(contact, &()),
            Self::Hertz(law) => law.energy(contact, &()),
            Self::Plastic(law) => law.energy(contact, history),
        }
    }
}
