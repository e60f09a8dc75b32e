//! A rolling law chosen at run time, for scenes in which pairs of materials differ in law.

use glam::DVec3;

use super::{Contact, Luding, RollingLaw, RollingSprings};

/// One of the rolling laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyRolling {
    /// None.
    None,
    /// Virtual springs.
    Luding(Luding),
}

impl RollingLaw for AnyRolling {
    type History = RollingSprings;
    const ACTIVE: bool = true;

    #[inline]
    fn couple(
        &self,
        contact: &Contact,
        normal_force: f64,
        tangential_stiffness: f64,
        dt: f64,
        history: &mut RollingSprings,
    ) -> DVec3 {
        match self {
            Self::None => DVec3::ZERO,
            Self::Luding(law) => {
                law.couple(contact, normal_force, tangential_stiffness, dt, history)
            }
        }
    }

    fn energy(&self, tangential_stiffness: f64, history: &RollingSprings) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Luding(law) => law.energy(tangential_stiffness, history),
        }
    }
}
