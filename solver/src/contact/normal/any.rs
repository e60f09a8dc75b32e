//! A normal law chosen at run time, for scenes in which pairs of materials differ in law.

use super::{Contact, Hertz, Linear, MaxOverlap, NormalForce, NormalLaw, Plastic};

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
    type History = MaxOverlap;

    #[inline]
    fn force(&self, contact: &Contact, history: &mut MaxOverlap) -> NormalForce {
        match self {
            Self::Linear(law) => law.force(contact, &mut ()),
            Self::Hertz(law) => law.force(contact, &mut ()),
            Self::Plastic(law) => law.force(contact, history),
        }
    }

    fn energy(&self, contact: &Contact, history: &MaxOverlap) -> f64 {
        match self {
            Self::Linear(law) => law.energy(contact, &()),
            Self::Hertz(law) => law.energy(contact, &()),
            Self::Plastic(law) => law.energy(contact, history),
        }
    }
}
